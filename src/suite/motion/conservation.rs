//! What contacts conserve: momentum and angular momentum, and energy where nothing takes it.

use std::collections::BTreeMap;

use super::crowd;
use super::{furthest, rounding};
use crate::suite::build::{self, Grain};
use crate::suite::line;
use crate::suite::{Group, Rung, Track};
use grains::case::Case;
use grains::model::{Axis, Law, Model};
use grains::tables::{Bodies, Contact, Snapshot};

/// The rungs.
pub fn rungs() -> Vec<Rung> {
    vec![momentum(), elastic_energy(), lost_energy()]
}

/// Σmv and Σm(z v_x − x v_z) + ΣIω, with the masses and moments of inertia of the case.
///
/// A step changes x × mv by x × F dt only, because dt v × v is zero; and the arms of both grains add up to
/// the distance of the centres, R_1 − u/2 + R_2 − u/2 = |x_2 − x_1|, so a contact's torques and its
/// forces' moments cancel.
fn momenta(of: &Bodies, given: &[Grain]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (id, grain) in given.iter().enumerate() {
        let Some(spin) = of.spin.get(id) else {
            return [f64::NAN; 3];
        };
        let (x, z) = (of.x[id], of.z[id]);
        let (px, pz) = (grain.mass * of.vx[id], grain.mass * of.vz[id]);
        sum[0] += px;
        sum[1] += pz;
        sum[2] += z * px - x * pz + grain.inertia * spin;
    }
    sum
}

/// The sums of the absolute values of the terms of [`momenta`]: what rounding is relative to.
fn sizes(grains: &[Grain]) -> [f64; 3] {
    let reach = grains.iter().flat_map(|grain| grain.position);
    let reach = reach.fold(0.0, |most: f64, x| most.max(x.abs()));
    let momentum: f64 = grains
        .iter()
        .map(|grain| grain.mass * (grain.velocity[0].abs() + grain.velocity[1].abs()))
        .sum();
    let turning: f64 = grains
        .iter()
        .map(|grain| grain.inertia * grain.spin.abs())
        .sum();
    [momentum, momentum, 2.0 * reach * momentum + turning]
}

fn momentum() -> Rung {
    const STEPS: u64 = 1500;
    let grains = crowd::grains(6, 5, [0.0; 2]);
    let [_, time] = crowd::modulus_and_time();
    let cases = crowd::laws().map(|(name, law)| {
        let model = build::model(law, 0.1 * time);
        build::case(name, model, &grains, vec![STEPS])
    });
    let cases = cases.to_vec();
    let start = momenta(&cases[0].bodies, &grains);
    let judge = move |tracks: &[Track]| {
        let mut lines = Vec::new();
        for (track, (name, _)) in tracks.iter().zip(crowd::laws()) {
            let at = track.first().map(|at| momenta(&at.bodies, &grains));
            let found = at.unwrap_or([f64::NAN; 3]);
            let names = [
                ("momentum across", "kg·m/s"),
                ("momentum up", "kg·m/s"),
                ("angular momentum with spins", "kg·m²/s"),
            ];
            for (i, (what, unit)) in names.into_iter().enumerate() {
                lines.push(line(
                    format!("{what} after {STEPS} steps, {name}"),
                    unit,
                    found[i],
                    start[i],
                    rounding(STEPS, sizes(&grains)[i]),
                    "conserved but for rounding: eight roundings a step of the sum of all terms",
                ));
            }
        }
        lines
    };
    Rung {
        name: "momentum",
        title: "Thirty grains with friction keep their momentum and their angular momentum with spins",
        group: Group::Exact,
        cases,
        judge: Box::new(judge),
    }
}

/// Energies of a snapshot on the step, J, with the case's parameters.
struct Energies<'a> {
    case: &'a Case,
}

impl Energies<'_> {
    fn stiffness(&self, contact: &Contact) -> f64 {
        let radius = |id: u32| self.case.bodies.radius.get(id as usize).copied();
        let two = radius(contact.id2).unwrap_or(f64::NAN);
        let one = radius(contact.id1).unwrap_or(two);
        2.0 * self.case.model.law.modulus * one * two / (one + two)
    }

    /// ½F²/k of all springs, the tangential ones too.
    fn stored(&self, at: &Snapshot) -> f64 {
        let mut energy = 0.0;
        for contact in &at.contacts {
            let k_n = self.stiffness(contact);
            energy += 0.5 * k_n * contact.overlap * contact.overlap;
            if self.case.model.law.has_friction() {
                let k_s = self.case.model.law.stiffness_ratio * k_n;
                energy += 0.5 * contact.tangential_force.powi(2) / k_s;
            }
        }
        energy
    }

    /// ½mv_{n−½}v_{n+½} and the same of the spins.
    fn moving(&self, at: &Snapshot) -> f64 {
        let dt = self.case.model.dt;
        let (given, of) = (&self.case.bodies, &at.bodies);
        let mut force = vec![[0.0; 3]; given.len()];
        for contact in &at.contacts {
            let [fx, fz] = contact.force();
            for (id, sign) in [(contact.id1, -1.0), (contact.id2, 1.0)] {
                let id = id as usize;
                if let Some(sum) = force.get_mut(id) {
                    sum[0] += sign * fx;
                    sum[1] += sign * fz;
                    let arm = given.radius[id] - 0.5 * contact.overlap;
                    sum[2] += arm * contact.tangential_force;
                }
            }
        }
        let mut energy = 0.0;
        for (id, [fx, fz, torque]) in force.into_iter().enumerate() {
            let product = |now: f64, rate: f64| now * (now + dt * rate);
            let mass = given.mass[id];
            let squares = product(of.vx[id], fx / mass) + product(of.vz[id], fz / mass);
            energy += 0.5 * mass * squares;
            if let (Some(spin), Some(inertia)) = (of.spin.get(id), given.inertia.get(id)) {
                energy += 0.5 * inertia * product(*spin, torque / inertia);
            }
        }
        energy
    }

    /// The energy at each moment over that at the first.
    fn over_the_first(&self, track: &Track) -> Vec<f64> {
        let total = |at: &Snapshot| self.stored(at) + self.moving(at);
        let first = track.first().map_or(f64::NAN, total);
        track.iter().map(|at| total(at) / first).collect()
    }
}

/// What leapfrog may lose and gain where contacts close and open between two steps, over the energy at
/// the start.
///
/// While a linear contact is closed, ½m v_{n−½}v_{n+½} + ½ku² is conserved. Where it closes with the first
/// overlap y of at most v dt, it loses ½ky(v dt − y), a most of ⅛k(v dt)²; where it opens it gains as
/// much. That is ¼(ω dt)² of the energy that the contact stores at its peak, ω² = k/m_eff.
fn kinks(track: &Track, case: &Case) -> f64 {
    let energies = Energies { case };
    let mass = |id: u32| case.bodies.mass.get(id as usize).copied();
    let mut open: BTreeMap<(u32, u32), f64> = BTreeMap::new();
    let mut sum = 0.0;
    for at in track {
        let mut closed = BTreeMap::new();
        for contact in &at.contacts {
            let two = mass(contact.id2).unwrap_or(f64::NAN);
            let lightness = 1.0 / two + mass(contact.id1).map_or(0.0, |one| 1.0 / one);
            let stiffness = energies.stiffness(contact);
            let stored = 0.5 * stiffness * contact.overlap * contact.overlap;
            let turn = case.model.dt * (stiffness * lightness).sqrt();
            let ids = (contact.id1, contact.id2);
            let peak = open.remove(&ids).unwrap_or(0.0);
            closed.insert(ids, f64::max(peak, 0.25 * turn * turn * stored));
        }
        sum += open.values().sum::<f64>();
        open = closed;
    }
    let first = track.first().map_or(f64::NAN, |at| energies.moving(at));
    (sum + open.values().sum::<f64>()) / first
}

/// A crowd of so many rows between four walls, looked at every ½√(m/k), with dt/√(m/k) = `turn`.
fn watched(name: &str, law: &Law, alpha: f64, rows: usize, turn: f64) -> Case {
    const MOMENTS: u64 = 200;
    let [_, time] = crowd::modulus_and_time();
    let half = 8.0 * crowd::RADIUS;
    let walls = |axis| [build::wall(axis, -half), build::wall(axis, half)];
    let model = Model {
        alpha,
        walls: [walls(Axis::X), walls(Axis::Z)].concat(),
        ..build::model(law.clone(), turn * time)
    };
    let every = (0.5 / turn).round() as u64;
    let moments = (0..=MOMENTS).map(|i| i * every).collect();
    build::case(name, model, &crowd::grains(rows, rows, [0.0; 2]), moments)
}

/// Why [`kinks`] is a bound.
const KINKS: &str = "the energy that each contact stores at its peak, times ¼(ω dt)² for closing and \
                     opening between two steps, added up";

/// Frictionless and undamped: what the grains have lost or won at most.
fn elastic_energy() -> Rung {
    let [modulus, _] = crowd::modulus_and_time();
    let law = build::springs(modulus);
    let cases = [0.1, 0.05, 0.025].map(|turn| {
        let name = format!("dt = {turn}√(m/k)");
        watched(&name, &law, 0.0, 4, turn)
    });
    let of = cases.to_vec();
    let judge = move |tracks: &[Track]| {
        let judge = |(track, case): (&Track, &Case)| {
            let ratios = Energies { case }.over_the_first(track);
            line(
                format!(
                    "energy over that at the start, where it is furthest from 1, {}",
                    case.name
                ),
                "1",
                furthest(1.0, ratios),
                1.0,
                kinks(track, case),
                KINKS,
            )
        };
        tracks.iter().zip(&of).map(judge).collect()
    };
    Rung {
        name: "elastic-energy",
        title: "Frictionless grains without damping keep their energy",
        group: Group::Exact,
        cases: cases.to_vec(),
        judge: Box::new(judge),
    }
}

/// With friction, dashpots and local damping: how much the energy has ever risen over its lowest before.
fn lost_energy() -> Rung {
    let with = |alpha: f64| {
        crowd::laws().map(|(name, law)| {
            let name = format!("{name}, α = {alpha}");
            watched(&name, &law, alpha, 5, 0.05)
        })
    };
    let cases = [with(0.0), with(0.3)].concat();
    let of = cases.clone();
    let judge = move |tracks: &[Track]| {
        let judge = |(track, case): (&Track, &Case)| {
            let mut lowest = f64::INFINITY;
            let ratios = (Energies { case }).over_the_first(track).into_iter();
            let risen = ratios.map(|ratio| {
                lowest = f64::min(lowest, ratio);
                ratio - lowest
            });
            let risen = furthest(0.0, risen);
            let what = format!(
                "most that the energy rises over that at the start, {}",
                case.name
            );
            line(what, "1", risen, 0.0, kinks(track, case), KINKS)
        };
        tracks.iter().zip(&of).map(judge).collect()
    };
    Rung {
        name: "lost-energy",
        title: "Friction, dashpots and local damping only take energy",
        group: Group::Exact,
        cases,
        judge: Box::new(judge),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use grains::native::run_case;

    /// A crowd that does not run into itself conserves everything.
    #[test]
    fn the_crowds_collide() {
        for rung in rungs() {
            for mut case in rung.cases {
                let last = case.moments.last().copied().unwrap_or(0);
                case.moments = (0..=100).map(|i| i * last / 100).collect();
                let track = run_case(&case, None).expect("a sound case");
                let contacts = track.iter().flat_map(|at| &at.contacts);
                let pairs: BTreeSet<_> = contacts.map(|of| (of.id1, of.id2)).collect();
                assert!(
                    pairs.len() > case.bodies.len(),
                    "{}: {}",
                    case.name,
                    pairs.len()
                );
            }
        }
    }
}
