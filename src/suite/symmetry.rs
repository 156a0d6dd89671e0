//! The same experiment seen in another way: mirrored, turned, shifted, from a moving frame, with the
//! grains numbered differently. What is seen must be the same, whatever the law is.
//!
//! A mirror and a quarter turn only exchange and negate coordinates; each operation of a step does with
//! them what it did before, so not a bit may change (but the sign of a zero). The others round differently.

mod frame;

use frame::Frame;

use super::build;
use super::motion::{crowd, strict};
use super::{Group, Rung, Track, line};
use grains::case::Case;
use grains::model::{Axis, Law, Model};

/// Steps, and the moments that are looked at.
const STEPS: u64 = 800;
const MOMENTS: [u64; 3] = [200, 400, STEPS];
/// How much further than at the start two beds may be apart at the end that differ by nearly nothing: about
/// ten times the most that is seen with 150 stiffnesses.
const GROWTH: f64 = 6.0e4;

/// The rungs.
pub fn rungs() -> Vec<Rung> {
    vec![
        mirror(),
        quarter_turn(),
        shift(),
        other_numbers(),
        moving_frame(),
    ]
}

fn mirror() -> Rung {
    let frame = Frame {
        turn: [[-1.0, 0.0], [0.0, 1.0]],
        ..Frame::SAME
    };
    let title = "A bed under a punch in the mirror: the same bits, x and spins negated";
    let make = |name: &str, law: &Law| bed(name, law, true);
    rung("mirror", title, frame, make, Seen::ToTheBit)
}

fn quarter_turn() -> Rung {
    let frame = Frame {
        turn: [[0.0, 1.0], [-1.0, 0.0]],
        ..Frame::SAME
    };
    let title = "A bed with walls and gravity turned by 90°: the same bits, turned";
    let make = |name: &str, law: &Law| bed(name, law, false);
    rung("quarter-turn", title, frame, make, Seen::ToTheBit)
}

fn shift() -> Rung {
    let shift = [0.125, 0.25];
    let frame = Frame {
        shift,
        ..Frame::SAME
    };
    let title = "A bed under a punch put elsewhere";
    let make = |name: &str, law: &Law| bed(name, law, true);
    rung("shift", title, frame, make, Seen::Rounded(shift[1] + SIZE))
}

fn other_numbers() -> Rung {
    let frame = Frame {
        // 5 and 16 have no common divisor.
        numbers: (0..COUNT).map(|id| (5 * id + 3) % COUNT).collect(),
        ..Frame::SAME
    };
    let title =
        "A bed under a punch whose grains have other numbers: forces are added in another order";
    let make = |name: &str, law: &Law| bed(name, law, true);
    // Only sums of forces are rounded differently, and a force is k times a tenth of a radius at most.
    let size = 0.1 * crowd::RADIUS;
    rung("other-numbers", title, frame, make, Seen::Rounded(size))
}

fn moving_frame() -> Rung {
    let frame = Frame {
        drift: [0.5, -0.25],
        ..Frame::SAME
    };
    let title = "Grains that run into each other, seen from a moving frame";
    rung("moving-frame", title, frame, gas, Seen::Rounded(SIZE))
}

/// Grains along a side, and all of them.
const SIDE: usize = 4;
const COUNT: usize = SIDE * SIDE;
/// How far the grains get from the origin, m.
const SIZE: f64 = 0.11;

/// Grains that spin and run into each other, into three walls and, if there is one, a punch.
fn bed(name: &str, law: &Law, with_punch: bool) -> Case {
    let radius = crowd::RADIUS;
    let half = 4.6 * radius;
    let crowd = gas(name, law);
    let model = Model {
        // Strong enough to count within the few steps.
        gravity: [150.0, -300.0],
        alpha: 0.2,
        walls: vec![
            build::wall(Axis::X, -half),
            build::wall(Axis::X, half),
            build::wall(Axis::Z, 0.0),
        ],
        ..crowd.model
    };
    let grains = crowd::grains(SIDE, SIDE, [0.0, 4.7 * radius]);
    let mut case = build::case(name, model, &grains, MOMENTS.to_vec());
    let half_extents = [2.5 * radius, 3.0 * radius];
    let punch = build::punch(0.7 * radius, 9.3 * radius, half_extents, -3.0);
    case.punch = with_punch.then_some(punch);
    case
}

/// Grains that spin and run into each other.
fn gas(name: &str, law: &Law) -> Case {
    let model = build::model(law.clone(), dt());
    let grains = crowd::grains(SIDE, SIDE, [0.0; 2]);
    build::case(name, model, &grains, MOMENTS.to_vec())
}

/// s.
fn dt() -> f64 {
    let [_, time] = crowd::modulus_and_time();
    0.1 * time
}

/// What is compared, with its unit.
const COMPARED: [(&str, &str); 4] = [
    ("position", "m"),
    ("velocity", "m/s"),
    ("spin", "rad/s"),
    ("contact force", "N"),
];

/// How exactly the other frame must show the same.
#[derive(Debug, Clone, Copy)]
enum Seen {
    /// With the same bits.
    ToTheBit,
    /// But for rounding, of numbers up to so many m.
    Rounded(f64),
}

impl Seen {
    /// For positions, velocities, spins and forces.
    fn tolerances(self) -> [f64; 4] {
        let Seen::Rounded(size) = self else {
            return [0.0; 4];
        };
        let [modulus, time] = crowd::modulus_and_time();
        let position = GROWTH * (8.0 * STEPS as f64).sqrt() * f64::EPSILON * size;
        let velocity = 2.0 * position / time;
        let spin = 2.5 * velocity / crowd::RADIUS;
        [position, velocity, spin, modulus * crowd::RADIUS * position]
    }

    fn basis(self) -> &'static str {
        match self {
            Seen::ToTheBit => "the same operations on the same numbers: no difference at all",
            Seen::Rounded(_) => {
                "eight roundings a step at random, √(8n)·ε of what is rounded differently, grown by collisions, \
                 three thousandfold at most; times 2/√(m/k) for velocities, 2.5/R more for spins, and k for forces"
            }
        }
    }
}

fn rung(
    name: &'static str,
    title: &'static str,
    frame: Frame,
    make: fn(&str, &Law) -> Case,
    seen: Seen,
) -> Rung {
    let mut cases = Vec::new();
    for (law_name, law) in crowd::laws() {
        let case = make(law_name, &law);
        let other = frame.case(&format!("{law_name}, {name}"), &case);
        cases.extend([case, other]);
    }
    let judge = move |tracks: &[Track]| {
        let mut lines = Vec::new();
        for (pair, (law_name, _)) in tracks.chunks_exact(2).zip(crowd::laws()) {
            let found = frame.differences(dt(), &pair[0], &pair[1]);
            let bounds = found.into_iter().zip(seen.tolerances());
            for ((what, unit), (found, tolerance)) in COMPARED.into_iter().zip(bounds) {
                let what = format!("largest difference of a {what}, {law_name}");
                lines.push(line(what, unit, found, 0.0, tolerance, seen.basis()));
            }
        }
        lines
    };
    strict(Rung {
        name,
        title,
        group: Group::Symmetry,
        cases,
        judge: Box::new(judge),
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::suite::climbing;
    use grains::native::run_case;

    #[test]
    fn every_rung_holds() {
        climbing::all_hold(&rungs());
    }

    #[test]
    fn every_rung_notices_its_faults() {
        let faults = [
            ("mirror", "wall=1e-12"),
            ("mirror", "wall=missing"),
            ("quarter-turn", "wall=1e-12"),
            ("quarter-turn", "wall=missing"),
            ("shift", "wall=1e-9"),
            ("other-numbers", "radius=1e-9"),
            ("other-numbers", "inertia=1e-6"),
            ("moving-frame", "time-step=1e-6"),
        ];
        climbing::all_notice(&rungs(), &faults);
    }

    #[test]
    fn a_judge_of_nothing_holds_nothing() {
        climbing::none_holds_of_nothing(&rungs());
    }

    /// Stiffer or softer grains on both sides are no fault, so no rung may fail with them.
    #[test]
    fn no_rung_cries_wolf_at_other_stiffnesses() {
        for index in 0..150 {
            for mut rung in rungs() {
                for case in &mut rung.cases {
                    case.model.law.modulus *= 1.0 + 4.0e-4 * f64::from(index - 75);
                }
                for line in climbing::climb(&rung, None) {
                    assert!(line.holds(), "{} {index}: {line:?}", rung.name);
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
                let pairs: BTreeSet<_> =
                    contacts.map(|contact| (contact.id1, contact.id2)).collect();
                assert!(pairs.len() > 25, "{name}: {}", pairs.len());
                // Right wall, floor and punch; gravity leans to the right.
                for body in 1..3 + u32::from(punch) {
                    let body = COUNT as u32 + body;
                    assert!(pairs.iter().any(|pair| pair.0 == body), "{name}: {body}");
                }
                let mut moved = case.clone();
                moved.bodies.x[5] += 1.0e-12;
                moved.bodies.z[9] += 1.0e-12;
                let moved = run_case(&moved, None).expect("a sound case");
                let found = Frame::SAME.differences(dt(), &track, &moved)[0] / 1.0e-12;
                assert!(found > 10.0 && found < 0.3 * GROWTH, "{name}: {found}");
            }
        }
    }
}
