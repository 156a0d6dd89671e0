//! Figure 4 and Table 3 of the paper: a disc between two pairs of opposite forces.

use crate::suite::build::{self, Grain};
use crate::suite::line;
use crate::suite::{Group, Line, Rung, Track};
use grains::measure::{Bed, extensive_stress};
use grains::model::{Axis, Model};

/// m.
const RADIUS: f64 = 1.0;
/// Forces across and up, N per metre of depth.
const FORCES: [f64; 2] = [0.5, 1.0];
/// Σ_xx and Σ_zz of Table 3, J.
const PUBLISHED: [f64; 2] = [1.0, 2.0];
/// Of all four contacts, N/m: a power of two, so that overlaps and forces have no rounding.
const STIFFNESS: f64 = 1024.0;
/// Steps to the moments that are looked at; nothing may move meanwhile.
const MOMENTS: [u64; 2] = [0, 100];

/// The rung.
pub fn rung() -> Rung {
    let overlaps = FORCES.map(|force| force / STIFFNESS);
    let [across, up] = overlaps.map(|overlap| RADIUS - overlap);
    let model = Model {
        walls: vec![
            build::wall(Axis::X, -across),
            build::wall(Axis::X, across),
            build::wall(Axis::Z, -up),
            build::wall(Axis::Z, up),
        ],
        ..build::model(build::springs(STIFFNESS / RADIUS), 1.0e-3)
    };
    let grain = Grain::disc([0.0; 2], RADIUS, 1.0);
    let case = build::case("disc of Figure 4", model, &[grain], MOMENTS.to_vec());
    Rung {
        name: "extensive-stress-of-a-disc",
        title: "The disc of the paper's Figure 4 has the extensive stress of Table 3",
        group: Group::Exact,
        cases: vec![case],
        judge: Box::new(move |tracks| judge(&tracks[0], overlaps)),
    }
}

fn judge(track: &Track, overlaps: [f64; 2]) -> Vec<Line> {
    let mut lines = Vec::new();
    for (moment, steps) in MOMENTS.into_iter().enumerate() {
        let stress = track.get(moment).and_then(|at| {
            let bed = Bed {
                bodies: &at.bodies,
                contacts: &at.contacts,
            };
            extensive_stress::of_grains(bed).first().copied()
        });
        let of =
            |row: usize, column: usize| stress.map_or(f64::NAN, |stress| stress[(row, column)]);
        for (axis, name) in ["Σ_xx", "Σ_zz"].into_iter().enumerate() {
            // The contact points are at the distance R − u, the paper's rigid disc has them at R.
            let rigid = RADIUS / (RADIUS - overlaps[axis]);
            lines.push(line(
                format!("{name}·R/(R−u) after {steps} steps"),
                "J",
                of(axis, axis) * rigid,
                PUBLISHED[axis],
                8.0 * f64::EPSILON * PUBLISHED[axis],
                "Table 3; eight roundings",
            ));
        }
        lines.push(line(
            format!("Σ_xz after {steps} steps"),
            "J",
            0.5 * (of(0, 1) + of(1, 0)),
            0.0,
            0.0,
            "Table 3; each term is zero",
        ));
    }
    lines
}
