//! A picture of a packing: grains, and the forces between them as lines as thick as they are strong.

use std::fmt::Write;

use super::figure::cells;
use super::figure_files::table;
use crate::error::Error;
use grains::measure::Bed;
use grains::scene::Scene;
use grains::tables::{Bodies, Contact};

/// Line classes; a force is drawn in the class of its share of the strong force.
const CLASSES: usize = 8;

/// Draws the bed in millimetres. `strong_force` is the force of the thickest line, the same for all
/// pictures that are to be compared. `punch_bottom` is the height of the punch, m.
pub fn picture(
    scene: &Scene,
    bed: Bed<'_>,
    punch_bottom: Option<f64>,
    strong_force: f64,
    top: f64,
    label: &str,
) -> String {
    let label = label.replace(['<', '>', '&', '"'], " ");
    let width = 1e3 * scene.container.width;
    let height = 1e3 * top;
    format!(
        "<svg class=\"packing\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-4 -4 {:.0} {:.0}\" role=\"img\" aria-label=\"{label}\">\n{}</svg>",
        width + 8.0,
        height + 8.0,
        contents(scene, bed, punch_bottom, strong_force, top)
    )
}

/// The elements of [`picture`] without a root, in millimetres from the box's upper left corner.
pub fn contents(
    scene: &Scene,
    bed: Bed<'_>,
    punch_bottom: Option<f64>,
    strong_force: f64,
    top: f64,
) -> String {
    let width = 1e3 * scene.container.width;
    let height = 1e3 * top;
    let flip = |z: f64| 1e3 * (top - z);
    let mut svg = format!(
        "<path fill=\"none\" stroke=\"#333\" stroke-width=\"2\" d=\"M0 0V{height:.1}H{width:.1}V0\"/>\n<g fill=\"#dfe3e8\">"
    );
    for i in 0..bed.bodies.len() {
        // Writing to a string cannot fail.
        let _ = write!(
            svg,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{:.1}\"/>",
            1e3 * bed.bodies.x[i],
            flip(bed.bodies.z[i]),
            1e3 * bed.bodies.radius[i]
        );
    }
    svg += "</g>\n<g fill=\"none\" stroke=\"#0072b2\" stroke-linecap=\"round\">";
    let mut lines = vec![String::new(); CLASSES];
    for contact in bed.contacts {
        let share = (contact.normal_force / strong_force).clamp(0.0, 1.0);
        let class = ((share * CLASSES as f64) as usize).min(CLASSES - 1);
        let [from, to] = ends(bed.bodies, contact);
        let _ = write!(
            lines[class],
            "M{:.1} {:.1}L{:.1} {:.1}",
            1e3 * from[0],
            flip(from[1]),
            1e3 * to[0],
            flip(to[1])
        );
    }
    for (class, path) in lines.iter().enumerate() {
        let thickness = 6.0 * (class as f64 + 0.5) / CLASSES as f64;
        let _ = write!(svg, "<path stroke-width=\"{thickness:.2}\" d=\"{path}\"/>");
    }
    svg += "</g>\n";
    if let Some(bottom) = punch_bottom {
        let left = 1e3 * (scene.punch_axis() - scene.loading.half_width);
        let _ = writeln!(
            svg,
            "<rect fill=\"#d55e00\" fill-opacity=\".75\" x=\"{left:.1}\" y=\"0\" width=\"{:.1}\" height=\"{:.1}\"/>",
            2e3 * scene.loading.half_width,
            flip(bottom).max(0.0)
        );
    }
    svg
}

/// The lines as they are drawn.
pub fn numbers(bed: Bed<'_>) -> Result<String, Error> {
    let head = ["x1 (m)", "z1 (m)", "x2 (m)", "z2 (m)", "normal force (N)"];
    let rows = bed.contacts.iter().map(|contact| {
        let [from, to] = ends(bed.bodies, contact);
        cells([from[0], from[1], to[0], to[1], contact.normal_force])
    });
    table(&head, rows)
}

/// A line from centre to centre, or from the contact point where one body is flat.
pub fn ends(bodies: &Bodies, contact: &Contact) -> [[f64; 2]; 2] {
    let end = |id: u32| {
        let id = id as usize;
        if id < bodies.len() {
            [bodies.x[id], bodies.z[id]]
        } else {
            contact.point
        }
    };
    [end(contact.id1), end(contact.id2)]
}

/// The force that one contact in a hundred exceeds, N: the thickest line.
pub fn strong_force<'a>(beds: impl Iterator<Item = Bed<'a>>) -> f64 {
    let mut forces: Vec<f64> = beds
        .flat_map(|bed| bed.contacts.iter().map(|contact| contact.normal_force))
        .collect();
    forces.sort_by(f64::total_cmp);
    let index = (forces.len() as f64 * 0.99) as usize;
    forces
        .get(index)
        .or(forces.last())
        .copied()
        .unwrap_or(1.0)
        .max(f64::MIN_POSITIVE)
}
