//! The time steps that YADE would choose, by its formulas: shown where YADE is not there to be asked.

use crate::engine::yade::Proposal;
use grains::case::{Case, Effective};
use grains::native::{NativeError, effective, run_case};
use grains::tables::BodyIds;

/// √2 as the stepper has it.
const ROOT_TWO: f64 = 1.41044;
/// `timestepSafetyCoefficient`.
const SAFETY: f64 = 0.8;

/// YADE's formulas on a case at its start.
///
/// PWave: min R√(ρ/E) with ρ the mass over the volume 4/3πR³ of a ball. GlobalStiffness: per grain and axis
/// K = Σ[(k_n − k_s)n_a² + k_s], about each axis K = Σ k_s R²(1 − n_a²), both over contacts under load;
/// dt = 1.41044·0.8·√(min(m/K, I/K)), with dashpots no more than 2·0.8·m/C. A material without friction
/// still has a k_s here.
pub fn by_formula(case: &Case) -> Result<Proposal, NativeError> {
    let still = Case {
        moments: vec![0],
        ..case.clone()
    };
    let parameters = effective(&still, None)?;
    let track = run_case(&still, None)?;
    let bodies = &case.bodies;
    let law = &case.model.law;
    let volume = |radius: f64| 4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius;
    let p_wave = bodies
        .mass
        .iter()
        .zip(&bodies.radius)
        .map(|(mass, radius)| radius * (mass / volume(*radius) / law.modulus).sqrt())
        .fold(f64::INFINITY, f64::min);
    let mut sums = vec![[0.0; 7]; bodies.len()];
    for moment in &track {
        add(&mut sums, case, &parameters, &moment.contacts);
    }
    let (mut square, mut viscous) = (f64::INFINITY, f64::INFINITY);
    for (id, sums) in sums.iter().enumerate() {
        let mass = bodies.mass[id];
        // Where grains do not turn the stepper looks at rotations all the same: a ball of this mass.
        let ball = 0.4 * mass * bodies.radius[id] * bodies.radius[id];
        let inertia = bodies.inertia.get(id).copied().unwrap_or(ball);
        let stiff = sums[..3].iter().copied().fold(0.0, f64::max);
        let turning = sums[3..6].iter().copied().fold(0.0, f64::max);
        if stiff > 0.0 {
            square = square.min(mass / stiff);
        }
        if turning > 0.0 {
            square = square.min(inertia / turning);
        }
        if sums[6] > 0.0 {
            viscous = viscous.min(2.0 * SAFETY * mass / sums[6]);
        }
    }
    let global_stiffness = ROOT_TWO * SAFETY * square.sqrt();
    Ok(Proposal {
        p_wave,
        global_stiffness,
        with_dashpots: global_stiffness.min(viscous),
    })
}

fn add(
    sums: &mut [[f64; 7]],
    case: &Case,
    parameters: &Effective,
    contacts: &[grains::tables::Contact],
) {
    let ids = BodyIds {
        grains: case.bodies.len() as u32,
        walls: 0,
    };
    for (contact, of) in contacts.iter().zip(&parameters.contacts) {
        if contact.normal_force == 0.0 {
            continue;
        }
        let k_s = of.k_s.unwrap_or(of.k_n * case.model.law.stiffness_ratio);
        let squares = [contact.normal[0], 0.0, contact.normal[1]].map(|n| n * n);
        for id in [contact.id1, contact.id2] {
            if !ids.is_grain(id) {
                continue;
            }
            let radius = case.bodies.radius[id as usize];
            let sums = &mut sums[id as usize];
            for axis in 0..3 {
                sums[axis] += (of.k_n - k_s) * squares[axis] + k_s;
                sums[3 + axis] += k_s * radius * radius * (1.0 - squares[axis]);
            }
            sums[6] += of.c_n;
        }
    }
}
