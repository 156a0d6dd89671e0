//! What contacts conserve: momentum and angular momentum, and energy where nothing takes it, in a crowd.

use std::collections::BTreeMap;

use crate::suite::{self, CaseGroup, Grain, Track, furthest, rounding};
use grains::model::Law;
use grains::tables::{Bodies, Contact, Snapshot};
use grains::task::Case;

pub fn groups() -> Vec<CaseGroup> {
    vec![momentum(), elastic_energy(), lost_energy()]
}

/// A little crowd of grains that run into each other, the same on every machine.
pub mod crowd {
    use crate::suite::{self, Grain};
    use grains::model::Law;
    use grains::scene::{Tension, Viscosity};

    /// Mean radius, m.
    pub const RADIUS: f64 = 0.01;
    /// kg/m³.
    const DENSITY: f64 = 2000.0;
    /// Distance of the grains at the start over the mean radius.
    const PITCH: f64 = 2.3;
    /// Speed at which the outermost grains run inwards; half of it is added at random, m/s.
    const SPEED: f64 = 2.0;
    /// Spins are up to so much, rad/s.
    const SPIN: f64 = 100.0;

    /// Spheres on a lattice about this centre, moved off their places, all running to the centre and all
    /// spinning. Numbers between −1 and 1 are the fractions of multiples of irrational numbers.
    pub fn grains(columns: usize, rows: usize, centre: [f64; 2]) -> Vec<Grain> {
        let mut grains = Vec::new();
        for row in 0..rows {
            for column in 0..columns {
                let number = (grains.len() + 1) as f64;
                let random = |root: f64| 2.0 * (number * root.sqrt()).fract() - 1.0;
                let off = |index: usize, count: usize| index as f64 - 0.5 * (count - 1) as f64;
                let place = [off(column, columns), off(row, rows)];
                let furthest = 0.5 * columns.max(rows) as f64;
                let moved = [random(2.0), random(3.0)];
                let added = [random(5.0), random(7.0)];
                let at = [0, 1].map(|i| centre[i] + RADIUS * (PITCH * place[i] + 0.04 * moved[i]));
                let velocity = [0, 1].map(|i| SPEED * (0.5 * added[i] - place[i] / furthest));
                let radius = RADIUS * (1.0 + 0.1 * random(11.0));
                let grain = Grain::sphere(at, radius, DENSITY);
                grains.push(grain.moving(velocity).spinning(SPIN * random(13.0)));
            }
        }
        grains
    }

    /// Young's modulus whose springs give way by about three hundredths of a radius at the speed of the crowd, Pa,
    /// and √(m/k), s.
    pub fn modulus_and_time() -> [f64; 2] {
        let mass = Grain::sphere([0.0; 2], RADIUS, DENSITY).mass;
        let time = 0.03 * RADIUS / SPEED;
        [mass / (time * time * RADIUS), time]
    }

    /// Laws for crowds: friction alone, and with dashpots of about a twentieth of the critical damping, which
    /// YADE has too.
    pub fn laws() -> [(&'static str, Law); 2] {
        let [modulus, time] = modulus_and_time();
        let friction = suite::friction(modulus, 0.5, 0.4);
        let c_n = 0.1 * modulus * RADIUS * time;
        let viscosity = Viscosity::dashpot(c_n, Tension::Clipped);
        let dashpots = suite::with_viscosity(friction.clone(), viscosity);
        [("friction", friction), ("friction-and-dashpots", dashpots)]
    }
}

/// Σmv and Σm(z v_x − x v_z) + ΣIω, with the masses and moments of inertia of the case.
///
/// A step changes x × mv by x × F dt only, because dt v × v is zero; and the arms of both grains add up to
/// the distance of the centres, R_1 − u/2 + R_2 − u/2 = |x_2 − x_1|, so a contact's torques and its
/// forces' moments cancel.
fn momenta(bodies: &Bodies, given: &[Grain]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (id, grain) in given.iter().enumerate() {
        let Some(spin) = bodies.spin.get(id) else {
            return [f64::NAN; 3];
        };
        let (x, z) = (bodies.x[id], bodies.z[id]);
        let (px, pz) = (grain.mass * bodies.vx[id], grain.mass * bodies.vz[id]);
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
    let momentum = |grain: &Grain| grain.mass * (grain.velocity[0].abs() + grain.velocity[1].abs());
    let momentum: f64 = grains.iter().map(momentum).sum();
    let turning = grains.iter().map(|grain| grain.inertia * grain.spin.abs());
    let turning: f64 = turning.sum();
    [momentum, momentum, 2.0 * reach * momentum + turning]
}

fn momentum() -> CaseGroup {
    const STEPS: u64 = 1500;
    let title =
        "Thirty grains with friction keep their momentum and their angular momentum with spins";
    let mut group = CaseGroup::new("momentum", title);
    let [_, time] = crowd::modulus_and_time();
    for (id, law) in crowd::laws() {
        let grains = crowd::grains(6, 5, [0.0; 2]);
        let case = suite::case(id, suite::model(law, 0.1 * time), &grains, vec![STEPS]);
        let start = momenta(&case.bodies, &grains);
        group = group.with(id, case, move |track, figures| {
            let at = track.first().map(|at| momenta(&at.bodies, &grains));
            let found = at.unwrap_or([f64::NAN; 3]);
            figures.because(
                "conserved but for rounding: eight roundings a step of the sum of all terms",
            );
            let mut kept = |i: usize, what: &str| {
                let off = rounding(STEPS, sizes(&grains)[i]);
                figures.is(what, found[i], start[i], off);
            };
            kept(0, "momentum-across, kg·m/s");
            kept(1, "momentum-up, kg·m/s");
            kept(2, "angular-momentum: angular momentum with spins, kg·m²/s");
        });
    }
    group
}

/// k_n, N/m.
fn stiffness(case: &Case, contact: &Contact) -> f64 {
    let radius = |id: u32| case.bodies.radius.get(id as usize).copied();
    let two = radius(contact.id2).unwrap_or(f64::NAN);
    let one = radius(contact.id1).unwrap_or(two);
    2.0 * case.model.law.modulus * one * two / (one + two)
}

/// ½F²/k of all springs on the step, the tangential ones too, J.
fn stored(case: &Case, at: &Snapshot) -> f64 {
    let mut energy = 0.0;
    for contact in &at.contacts {
        let k_n = stiffness(case, contact);
        energy += 0.5 * k_n * contact.overlap * contact.overlap;
        if case.model.law.has_friction() {
            let k_s = case.model.law.stiffness_ratio * k_n;
            energy += 0.5 * contact.tangential_force.powi(2) / k_s;
        }
    }
    energy
}

/// ½mv_{n−½}v_{n+½} and the same of the spins, J.
fn moving(case: &Case, at: &Snapshot) -> f64 {
    let dt = case.model.dt;
    let (given, bodies) = (&case.bodies, &at.bodies);
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
        let squares = product(bodies.vx[id], fx / mass) + product(bodies.vz[id], fz / mass);
        energy += 0.5 * mass * squares;
        if let (Some(spin), Some(inertia)) = (bodies.spin.get(id), given.inertia.get(id)) {
            energy += 0.5 * inertia * product(*spin, torque / inertia);
        }
    }
    energy
}

/// What leapfrog may lose and gain where contacts close and open between two steps, over the energy at
/// the start.
///
/// While a linear contact is closed, ½m v_{n−½}v_{n+½} + ½ku² is conserved. Where it closes with the first
/// overlap y of at most v dt, it loses ½ky(v dt − y), a most of ⅛k(v dt)²; where it opens it gains as
/// much. That is ¼(ω dt)² of the energy that the contact stores at its peak, ω² = k/m_eff.
fn kinks(case: &Case, track: &Track) -> f64 {
    let mass = |id: u32| case.bodies.mass.get(id as usize).copied();
    let mut open: BTreeMap<(u32, u32), f64> = BTreeMap::new();
    let mut sum = 0.0;
    for at in track {
        let mut closed = BTreeMap::new();
        for contact in &at.contacts {
            let two = mass(contact.id2).unwrap_or(f64::NAN);
            let lightness = 1.0 / two + mass(contact.id1).map_or(0.0, |one| 1.0 / one);
            let stiffness = stiffness(case, contact);
            let stored = 0.5 * stiffness * contact.overlap * contact.overlap;
            let turn = case.model.dt * (stiffness * lightness).sqrt();
            let ids = contact.ids();
            let peak = open.remove(&ids).unwrap_or(0.0);
            closed.insert(ids, f64::max(peak, 0.25 * turn * turn * stored));
        }
        sum += open.values().sum::<f64>();
        open = closed;
    }
    let first = track.first().map_or(f64::NAN, |at| moving(case, at));
    (sum + open.values().sum::<f64>()) / first
}

/// Adds a crowd of so many rows between four walls, looked at every ½√(m/k), with dt/√(m/k) = `turn`, whose energy over
/// that at the start `figure` reduces to one number and what it should be.
fn watched(
    group: CaseGroup,
    id: &str,
    (law, alpha, rows, turn): (Law, f64, usize, f64),
    what: &'static str,
    figure: fn(Vec<f64>) -> [f64; 2],
) -> CaseGroup {
    const MOMENTS: u64 = 200;
    let [_, time] = crowd::modulus_and_time();
    let half = 8.0 * crowd::RADIUS;
    let walls: [&[f64]; 2] = [&[-half, half], &[-half, half]];
    let model = suite::world(law, turn * time, [0.0; 2], alpha, walls);
    let every = (0.5 / turn).round() as u64;
    let moments = (0..=MOMENTS).map(|i| i * every).collect();
    let case = suite::case(id, model, &crowd::grains(rows, rows, [0.0; 2]), moments);
    let copy = case.clone();
    group.with(id, case, move |track, figures| {
        let total = |at: &Snapshot| stored(&copy, at) + moving(&copy, at);
        let first = track.first().map_or(f64::NAN, total);
        let ratios = track.iter().map(|at| total(at) / first);
        let [found, expected] = figure(ratios.collect());
        figures.because(
            "the energy that each contact stores at its peak, times ¼(ω dt)² for closing and \
             opening between two steps, added up",
        );
        figures.is(what, found, expected, kinks(&copy, track));
    })
}

/// Frictionless and undamped: what the grains have lost or won at most.
fn elastic_energy() -> CaseGroup {
    let title = "Frictionless grains without damping keep their energy";
    let group = CaseGroup::new("elastic-energy", title);
    let [modulus, _] = crowd::modulus_and_time();
    let what = "energy: energy over that at the start where it is furthest from 1, 1";
    [0.1, 0.05, 0.025].into_iter().fold(group, |group, turn| {
        let given = (suite::springs(modulus), 0.0, 4, turn);
        let figure = |ratios| [furthest(1.0, ratios), 1.0];
        watched(group, &format!("omega-dt-{turn}"), given, what, figure)
    })
}

/// With friction, dashpots and local damping: how much the energy has ever risen over its lowest before.
fn lost_energy() -> CaseGroup {
    let title = "Friction, dashpots and local damping only take energy";
    let mut group = CaseGroup::new("lost-energy", title);
    let what = "rise: most that the energy rises over that at the start, 1";
    for alpha in [0.0, 0.3] {
        for (id, law) in crowd::laws() {
            let figure = |ratios: Vec<f64>| {
                let mut lowest = f64::INFINITY;
                let risen = ratios.into_iter().map(|ratio| {
                    lowest = f64::min(lowest, ratio);
                    ratio - lowest
                });
                [furthest(0.0, risen), 0.0]
            };
            let id = format!("{id}/alpha-{alpha}");
            group = watched(group, &id, (law, alpha, 5, 0.05), what, figure);
        }
    }
    group
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use grains::native::run_case;

    /// A crowd that does not run into itself conserves everything.
    #[test]
    fn the_crowds_collide() {
        for group in groups() {
            for mut case in group.cases {
                let last = case.moments.last().copied().unwrap_or(0);
                case.moments = (0..=100).map(|i| i * last / 100).collect();
                let track = run_case(&case, None).expect("a sound case");
                let contacts = track.iter().flat_map(|at| &at.contacts);
                let pairs: BTreeSet<_> = contacts.map(Contact::ids).collect();
                let grains = case.bodies.len();
                assert!(pairs.len() > grains, "{}: {}", case.name, pairs.len());
            }
        }
    }
}
