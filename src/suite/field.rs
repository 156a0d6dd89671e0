//! The elastic field inside the disc of Figure 4 under the contact forces that an engine gives it: its
//! average over the disc is the engine's Σ/V.

use super::build::{self, Grain, wall};
use super::{Group, Line, Rung, Track};
use crate::paper::disc_field::{DiscField, RimForce};
use grains::measure::{Bed, extensive_stress};
use grains::model::{Axis, Model};

/// m.
const RADIUS: f64 = 1.0;
/// Overlaps at the walls across and up, m: powers of two, so that forces are in exact balance, and so
/// small that contact points are on the rim to far below the tolerance.
const OVERLAPS: [f64; 2] = [1.0 / 67_108_864.0, 1.0 / 33_554_432.0];
/// N; Figure 4's vertical force.
const FORCE: f64 = 1.0;

/// The rung.
pub fn rungs() -> Vec<Rung> {
    let stiffness = FORCE / OVERLAPS[1];
    let at = |axis, overlap: f64| [wall(axis, overlap - RADIUS), wall(axis, RADIUS - overlap)];
    let model = Model {
        walls: [at(Axis::X, OVERLAPS[0]), at(Axis::Z, OVERLAPS[1])].concat(),
        ..build::model(build::springs(stiffness / RADIUS), 1.0e-6)
    };
    let grain = Grain::disc([0.0; 2], RADIUS, 1.0);
    vec![Rung {
        name: "field-inside-a-disc",
        title: "the elastic field inside Figure 4's disc, under the engine's contact forces, averages to its Σ/V",
        group: Group::Exact,
        cases: vec![build::case("field", model, &[grain], vec![0])],
        judge: Box::new(|tracks| judge(&tracks[0]).unwrap_or_default()),
    }]
}

/// No lines, so a failed rung, where the forces are not in balance.
fn judge(track: &Track) -> Option<Vec<Line>> {
    let moment = track.first()?;
    let bed = Bed {
        bodies: &moment.bodies,
        contacts: &moment.contacts,
    };
    let sum = *extensive_stress::of_grains(bed).first()?;
    let rim = moment.contacts.iter().map(|contact| {
        let [x, z] = contact.point;
        RimForce {
            angle: z.atan2(x),
            radial: -contact.normal_force,
            // The normal points inward and (−n_z, n_x) with it, so along is turned too.
            tangential: -contact.tangential_force,
        }
    });
    let field = DiscField::new(RADIUS, &rim.collect::<Vec<_>>(), [0.0; 2]).ok()?;
    let average = field.average_over_disc();
    let volume = std::f64::consts::PI * RADIUS * RADIUS;
    let largest = sum.iter().fold(0.0f64, |a, b| a.max(b.abs())) / volume;
    let line = |name: &str, row: usize, column: usize| Line {
        quantity: format!("{name} averaged over the disc, compression positive"),
        unit: "Pa".to_owned(),
        value: -average[row][column],
        expected: sum[(row, column)] / volume,
        tolerance: 1.0e-6 * largest,
        basis: "the engine's Σ/V; contact points are within 3e-8 R of the rim".to_owned(),
    };
    Some(vec![
        line("σ_xx", 0, 0),
        line("σ_zz", 1, 1),
        line("σ_xz", 0, 1),
    ])
}
