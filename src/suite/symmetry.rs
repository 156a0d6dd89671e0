//! The same experiment seen in another way: mirrored, turned, shifted, from a moving frame, with the
//! grains numbered differently. What is seen must be the same, whatever the law is.
//!
//! A mirror and a quarter turn only exchange and negate coordinates; each operation of a step does with
//! them what it did before, so not a bit may change (but the sign of a zero). The others round differently.

use std::collections::BTreeMap;

use super::conservation::crowd;
use crate::suite::{self, CaseGroup, Evidence, Track, furthest};
use grains::model::Law;
use grains::tables::{Bodies, Contact, Snapshot};
use grains::task::Case;
use verdict::frame::Frame;

/// Steps, and the moments that are looked at.
const STEPS: u64 = 800;
const MOMENTS: [u64; 3] = [200, 400, STEPS];
/// How much further than at the start two beds may be apart at the end that differ by nearly nothing: about
/// ten times the most that is seen with 150 stiffnesses.
const GROWTH: f64 = 6.0e4;
/// Grains along a side, and all of them.
const SIDE: usize = 4;
const COUNT: u32 = (SIDE * SIDE) as u32;
/// How far the grains get from the origin, m.
const SIZE: f64 = 0.11;

/// The groups. What is rounded differently is of so many m; none where every bit is the same.
pub fn groups() -> Vec<CaseGroup> {
    groups_where(|rounded| rounded)
}

/// The same for engines that nobody has promised those bits for: a fused multiplication rounds one product of two, and a turn
/// exchanges them.
pub fn rounded() -> Vec<CaseGroup> {
    groups_where(|rounded| rounded.or(Some(SIZE)))
}

fn groups_where(rounded: impl Fn(Option<f64>) -> Option<f64>) -> Vec<CaseGroup> {
    let group = |id, title, seen, make: fn(&str, &Law) -> Case, size| {
        group(id, title, seen, make, rounded(size))
    };
    let punched: fn(&str, &Law) -> Case = |name, law| bed(name, law, true);
    let open: fn(&str, &Law) -> Case = |name, law| bed(name, law, false);
    const UP: f64 = 0.25;
    vec![
        group(
            "mirror",
            "A bed under a punch in the mirror: the same bits, x and spins negated",
            Frame::MIRRORED.into(),
            punched,
            None,
        ),
        group(
            "quarter-turn",
            "A bed with walls and gravity turned by 90°: the same bits, turned",
            Frame::TURNED.back().into(),
            open,
            None,
        ),
        group(
            "shift",
            "A bed under a punch put elsewhere",
            Frame::shifted([0.125, 0.0, UP]).into(),
            punched,
            Some(UP + SIZE),
        ),
        // Only sums of forces are rounded differently, and a force is k times a tenth of a radius at most.
        group(
            "other-numbers",
            "A bed under a punch whose grains have other numbers: forces are added in another order",
            // 5 and 16 have no common divisor.
            Frame::with_ids((0..COUNT).map(|id| (5 * id + 3) % COUNT).collect()).into(),
            punched,
            Some(0.1 * crowd::RADIUS),
        ),
        group(
            "moving-frame",
            "Grains that run into each other, seen from a moving frame",
            Seen {
                frame: Frame::HERE,
                drift: [0.5, -0.25],
            },
            gas,
            Some(SIZE),
        ),
    ]
}

/// Grains that spin and run into each other, into three walls and, if there is one, a punch.
fn bed(name: &str, law: &Law, with_punch: bool) -> Case {
    let radius = crowd::RADIUS;
    let half = 4.6 * radius;
    // Strong enough to count within the few steps.
    let gravity = [150.0, -300.0];
    let walls: [&[f64]; 2] = [&[-half, half], &[0.0]];
    let model = suite::world(law.clone(), dt(), gravity, 0.2, walls);
    let grains = crowd::grains(SIDE, SIDE, [0.0, 4.7 * radius]);
    let mut case = suite::case(name, model, &grains, MOMENTS.to_vec());
    let half_extents = [2.5 * radius, 3.0 * radius];
    let punch = suite::punch(0.7 * radius, 9.3 * radius, half_extents, -3.0);
    case.punch = with_punch.then_some(punch);
    case
}

/// Grains that spin and run into each other.
fn gas(name: &str, law: &Law) -> Case {
    let grains = crowd::grains(SIDE, SIDE, [0.0; 2]);
    let model = suite::model(law.clone(), dt());
    suite::case(name, model, &grains, MOMENTS.to_vec())
}

/// s.
fn dt() -> f64 {
    let [_, time] = crowd::modulus_and_time();
    0.1 * time
}

/// For positions, velocities, spins and forces, where numbers up to so many m are rounded differently.
fn tolerances(size: f64) -> [f64; 4] {
    let [modulus, time] = crowd::modulus_and_time();
    let position = GROWTH * (8.0 * STEPS as f64).sqrt() * f64::EPSILON * size;
    let velocity = 2.0 * position / time;
    let spin = 2.5 * velocity / crowd::RADIUS;
    [position, velocity, spin, modulus * crowd::RADIUS * position]
}

fn group(
    id: &'static str,
    title: &'static str,
    seen: Seen,
    make: fn(&str, &Law) -> Case,
    rounded: Option<f64>,
) -> CaseGroup {
    let mut group = CaseGroup::new(id, title);
    group.evidence = Evidence::Symmetry;
    for (law_name, law) in crowd::laws() {
        let case = make(law_name, &law);
        let other = seen.case(&format!("{law_name}, {id}"), &case);
        let seen = seen.clone();
        group = group.with_all(law_name, [case, other], move |pair, figures| {
            let found = seen.differences(dt(), &pair[0], &pair[1]);
            let allowed = rounded.map_or([0.0; 4], tolerances);
            figures.because(match rounded {
                None => "the same operations on the same numbers: no difference at all",
                Some(_) => {
                    "eight roundings a step at random, √(8n)·ε of what is rounded differently, grown by collisions, \
                     three thousandfold at most; times 2/√(m/k) for velocities, 2.5/R more for spins, and k for forces"
                }
            });
            let quantities = [
                "position: largest difference of a position, m",
                "velocity: largest difference of a velocity, m/s",
                "spin: largest difference of a spin, rad/s",
                "contact-force: largest difference of a contact force, N",
            ];
            for (index, what) in quantities.into_iter().enumerate() {
                figures.is(what, found[index], 0.0, allowed[index]);
            }
        });
    }
    group
}

/// Another frame, which may move, m/s.
#[derive(Debug, Clone)]
struct Seen {
    frame: Frame,
    drift: [f64; 2],
}

impl From<Frame> for Seen {
    fn from(frame: Frame) -> Self {
        Seen {
            frame,
            drift: [0.0; 2],
        }
    }
}

impl Seen {
    /// The case as it is in this frame. A punch stays upright.
    fn case(&self, name: &str, case: &Case) -> Case {
        Case {
            name: name.to_owned(),
            bodies: self.bodies(&case.bodies, 0.0),
            ..self.frame.case(case)
        }
    }

    /// The grains as they are in this frame at this time.
    fn bodies(&self, bodies: &Bodies, time: f64) -> Bodies {
        let mut seen = self.frame.bodies(bodies);
        let [x, z] = self.drift;
        for (column, more) in [
            (&mut seen.x, x * time),
            (&mut seen.z, z * time),
            (&mut seen.vx, x),
            (&mut seen.vz, z),
        ] {
            column.iter_mut().for_each(|value| *value += more);
        }
        seen
    }

    /// The largest differences between how `still` looks in this frame and `other`, over all moments:
    /// of positions, velocities, spins and forces. The time is that of the case.
    fn differences(&self, dt: f64, still: &Track, other: &Track) -> [f64; 4] {
        if still.is_empty() || still.len() != other.len() {
            return [f64::NAN; 4];
        }
        let mut worst = [0.0; 4];
        for (still, other) in still.iter().zip(other) {
            let a = self.bodies(&still.bodies, still.step as f64 * dt);
            let b = &other.bodies;
            let found = [
                furthest(0.0, [apart(&a.x, &b.x), apart(&a.z, &b.z)]),
                furthest(0.0, [apart(&a.vx, &b.vx), apart(&a.vz, &b.vz)]),
                apart(&a.spin, &b.spin),
                self.forces_apart(still, other),
            ];
            for (worst, found) in worst.iter_mut().zip(found) {
                *worst = furthest(0.0, [*worst, found]);
            }
        }
        worst
    }

    /// A contact that only one of the two has bears nothing in the other.
    fn forces_apart(&self, still: &Snapshot, other: &Snapshot) -> f64 {
        let grains = still.bodies.len();
        let vector = |contact: &Contact| {
            let (seen, _) = self.frame.contact(contact, None, grains);
            (seen.ids(), seen.force())
        };
        let mut apart: BTreeMap<(u32, u32), [f64; 2]> = still.contacts.iter().map(vector).collect();
        for contact in &other.contacts {
            let force = contact.force();
            let difference = apart.entry(contact.ids()).or_default();
            *difference = [0, 1].map(|i| difference[i] - force[i]);
        }
        furthest(0.0, apart.into_values().flatten()).abs()
    }
}

/// The largest difference of two columns; not a number if one is longer.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    if a.len() != b.len() {
        return f64::NAN;
    }
    furthest(0.0, a.iter().zip(b).map(|(a, b)| a - b)).abs()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::checks::Outcome;
    use grains::native::run_case;

    /// Stiffer or softer grains on both sides are no fault, so no group may fail with them.
    #[test]
    fn other_stiffnesses_are_no_false_positives() {
        for index in 0..150 {
            for mut group in groups() {
                for case in &mut group.cases {
                    case.model.law.modulus *= 1.0 + 4.0e-4 * f64::from(index - 75);
                }
                for check in crate::suite::detection::tests::judged(&group, None) {
                    let id = group.id;
                    assert_eq!(check.outcome, Outcome::Pass, "{id} {index}: {check:?}");
                }
            }
        }
    }

    /// The beds must be worth looking at, and the growth that the tolerances allow for is measured.
    #[test]
    fn everything_touches_and_small_differences_grow() {
        for (name, law) in crowd::laws() {
            for punch in [true, false] {
                let mut case = bed(name, &law, punch);
                case.moments = (0..=STEPS / 20).map(|i| 20 * i).collect();
                let track = run_case(&case, None).expect("a sound case");
                let contacts = track.iter().flat_map(|at| &at.contacts);
                let pairs: BTreeSet<_> = contacts.map(Contact::ids).collect();
                assert!(pairs.len() > 25, "{name}: {}", pairs.len());
                // Right wall, floor and punch; gravity leans to the right.
                for body in 1..3 + u32::from(punch) {
                    let body = COUNT + body;
                    assert!(pairs.iter().any(|pair| pair.0 == body), "{name}: {body}");
                }
                let mut moved = case.clone();
                moved.bodies.x[5] += 1.0e-12;
                moved.bodies.z[9] += 1.0e-12;
                let moved = run_case(&moved, None).expect("a sound case");
                let found = Seen::from(Frame::HERE).differences(dt(), &track, &moved)[0] / 1.0e-12;
                assert!(found > 10.0 && found < 0.3 * GROWTH, "{name}: {found}");
            }
        }
    }
}
