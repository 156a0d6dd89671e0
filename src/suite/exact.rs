//! The exact answer of a case, as the limit of ever shorter steps of the step written out under the case's rules; and how far an engine
//! is from it, and from the model's own step.

use super::Track;
use grains::rules::Rules;
use grains::tables::{Bodies, Snapshot};
use grains::task::Case;
use grains::variant::{Variant, run};
use grains::vector::{hypot, plus, times};

/// How far an engine may be from the model's step, over the largest speed, way or force of a case.
pub const ROUNDING: f64 = 1.0e-11;
/// Steps are divided by three until two limits are as near as this, and so often at most. What happens in the middle of a step is in
/// the middle of one of all the shorter steps.
pub const CONVERGED: f64 = 1.0e-9;
const SHORTER: u64 = 3;
const DIVISIONS: u32 = 5;

/// Whether tracks of these cases are the model's under an engine's own rules, to rounding.
pub fn follow_rules(cases: &[Case], tracks: &[Track], rules: Rules) -> bool {
    cases.len() == tracks.len()
        && cases.iter().zip(tracks).all(|(case, track)| {
            let mut case = case.clone();
            case.model.rules = rules.over(case.model.rules);
            let own = numbers(&case, &run(&case, &Variant::default()));
            largest_difference(&own, &numbers(&case, track)) <= ROUNDING
        })
}

/// What is known of a case: its numbers by the model's own step and in the limit of short ones, and how near to it two limits came.
pub struct Known {
    pub step: Vec<f64>,
    pub exact: Vec<f64>,
    pub spread: f64,
}

impl Known {
    pub fn new(case: &Case) -> Self {
        let divided = |divisions: u32| {
            let factor = SHORTER.pow(divisions);
            let mut case = case.clone();
            case.model.dt /= factor as f64;
            case.moments.iter_mut().for_each(|moment| *moment *= factor);
            run(&case, &Variant::default())
        };
        let step = numbers(case, &divided(0));
        // Romberg's table: errors go by whole powers of the step, but for those of a contact that slips or ends within one.
        let mut row = vec![step.clone()];
        let (mut exact, mut spread) = (step.clone(), f64::INFINITY);
        for divisions in 1..=DIVISIONS {
            let mut next = vec![numbers(case, &divided(divisions))];
            for (order, before) in row.iter().enumerate().take(3) {
                let share = 1.0 / (SHORTER.pow(order as u32 + 1) as f64 - 1.0);
                let last = &next[order];
                let better = last.iter().zip(before);
                next.push(better.map(|(a, b)| a + share * (a - b)).collect());
            }
            let best = next.last().expect("there is one").clone();
            let apart = largest_difference(&best, &exact);
            // The last ones may be rounding.
            if apart < spread {
                (exact, spread) = (best, apart);
            } else if spread < 100.0 * CONVERGED {
                break;
            } else {
                exact = best;
            }
            if spread < CONVERGED {
                break;
            }
            row = next;
        }
        Known {
            step,
            exact,
            spread,
        }
    }
}

/// Not a number if there are more of one than of the other, or if one is none.
pub fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    if a.len() != b.len() {
        return f64::NAN;
    }
    let worse = |worst: f64, (a, b): (&f64, &f64)| {
        let off = (a - b).abs();
        if off <= worst || worst.is_nan() {
            worst
        } else {
            off
        }
    };
    a.iter().zip(b).fold(0.0, worse)
}

/// The numbers of a track after its start, over the largest way, speed or force of the case: places of all spheres and forces of all
/// contacts, at the end velocities and spins too. Before, these would show the half step by which they are behind places.
pub fn numbers(case: &Case, track: &Track) -> Vec<f64> {
    let start = &case.bodies;
    let state = |bodies: &Bodies, id: usize| {
        let at = |column: &Vec<f64>| column.get(id).copied().unwrap_or(0.0);
        let place = [&bodies.x, &bodies.y, &bodies.z].map(at);
        let velocity = [&bodies.vx, &bodies.vy, &bodies.vz].map(at);
        let spin = [&bodies.spin_x, &bodies.spin, &bodies.spin_z].map(at);
        (place, velocity, times(start.radius[id], spin))
    };
    let ids = 0..start.len();
    let time = case.model.dt * case.moments.last().copied().unwrap_or(1) as f64;
    let pull = hypot([case.model.gravity[0], 0.0, case.model.gravity[1]]) * time;
    let fastest = ids.clone().map(|id| {
        let (_, velocity, spin) = state(start, id);
        hypot(velocity) + hypot(spin)
    });
    let speed = fastest.fold(pull, f64::max);
    let lightest = start.mass.iter().copied().fold(f64::INFINITY, f64::min);
    let is_held = lightest > 1.0e12;
    let forces = |snapshot: &Snapshot| -> Vec<f64> {
        let contacts = snapshot.contacts.iter();
        contacts
            .flat_map(|contact| [contact.normal_force, contact.tangential_force])
            .collect()
    };
    // Of what is held the first force is as large as any; of what is free, what stops it within an eighth of the time.
    let first = track.first().map_or(Vec::new(), forces);
    let force = match is_held {
        true => first.first().copied().unwrap_or(f64::NAN),
        false => 8.0 * lightest * speed / time,
    };
    let last = case.moments.len() - 1;
    let later = track.iter().enumerate().skip(1).flat_map(|(at, snapshot)| {
        let of_bodies = ids.clone().flat_map(|id| {
            let (place, velocity, spin) = state(&snapshot.bodies, id);
            let (from, ..) = state(start, id);
            let way = times(1.0 / (speed * time), plus(place, times(-1.0, from)));
            let motion = [velocity, spin].map(|vector| times(1.0 / speed, vector));
            let all = [way, motion[0], motion[1]].into_iter();
            all.take(if at == last { 3 } else { 1 })
                .flatten()
                .collect::<Vec<f64>>()
        });
        let forces = forces(snapshot)
            .into_iter()
            .map(move |component| component / force);
        of_bodies.chain(forces).collect::<Vec<f64>>()
    });
    let complete = track.len() == case.moments.len();
    later.chain((!complete).then_some(f64::NAN)).collect()
}
