//! Drawings of a bed: grains, and the forces between them as lines as thick as they are strong.

use std::fmt::Write;

use super::axis::Area;
use super::figure::cells;
use super::figure_files::table;
use super::frame::{INK, text, whole};
use crate::document::{Cell, Drawing, Table};
use crate::error::Error;
use crate::study::figures::LoadedBed;
use crate::study::realization::bed_of;
use grains::measure::{self, Bed};
use grains::scene::Scene;
use grains::tables::{Bodies, Contact, Punch};

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

const WIDTH: f64 = 900.0;
const MARGIN: f64 = 12.0;
/// Half the width and the height of the closer look in a large bed, m.
const NEAR: [f64; 2] = [0.2, 0.22];

/// The bed at the end of loading, with its control points. An error where there are no forces.
pub fn force_chains(bed: &LoadedBed) -> Result<Drawing, Error> {
    let of = bed_of(&bed.last);
    if of.contacts.is_empty() {
        return Err(Error::Report(
            "the bed has no contacts, so there are no forces to draw".to_owned(),
        ));
    }
    let bottom = bed.last.punch.as_ref().map(Punch::bottom);
    let highest = measure::highest_grain(of.bodies);
    let top = highest.max(bottom.unwrap_or(0.0)) + 0.03;
    let strong = strong_force([of].into_iter());
    let contents = contents(&bed.scene, of, bottom, strong, top);
    let inner = WIDTH - 2.0 * MARGIN;
    let full_width = bed.scene.container.width;
    let axis = bed.scene.punch_axis();
    // No more than the bed.
    let half = NEAR[0].min(0.5 * full_width + 0.004);
    let lower = (bed.surface + 0.03 - NEAR[1] * half / NEAR[0]).max(-0.004);
    // Left, right, upper and lower edge of what each window shows, m.
    let all = [-0.004, full_width + 0.004, top, -0.004];
    let near = [axis - half, axis + half, bed.surface + 0.03, lower];
    let area = |above: f64, [left, right, upper, lower]: [f64; 4]| -> Area {
        [
            MARGIN,
            above,
            inner,
            inner * (upper - lower) / (right - left),
        ]
    };
    let first = area(40.0, all);
    let second = area(first[1] + first[3] + 40.0, near);
    let mut svg = format!("<defs><g id=\"bed\">{contents}</g></defs>\n");
    let force = bed.last.punch.map_or(0.0, |punch| punch.force);
    svg += &text(
        [MARGIN, 26.0],
        "start",
        &format!(
            "Realization {} under the punch, which bears {force:.0} N: forces as lines, the thickest {strong:.0} N or more",
            bed.scene.realization
        ),
    );
    svg += &text([MARGIN, second[1] - 12.0], "start", "Closer");
    for (area, shown) in [(first, all), (second, near)] {
        svg += &window(bed, area, shown, top);
    }
    let size = [WIDTH, second[1] + second[3] + MARGIN];
    Ok(Drawing {
        name: "figure-2".to_owned(),
        caption: "Force chains under the load".to_owned(),
        svg: whole(size, "Forces between the grains under the punch", &svg),
        table: table_of(bed),
    })
}

/// One look at the bed; the drawing of the bed is in mm from its upper left corner.
fn window(bed: &LoadedBed, area: Area, [left, right, upper, lower]: [f64; 4], top: f64) -> String {
    let [x, y, width, height] = area;
    let mut svg = format!(
        "<svg x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" \
         viewBox=\"{:.2} {:.2} {:.2} {:.2}\"><use href=\"#bed\"/></svg>\n",
        1e3 * left,
        1e3 * (top - upper),
        1e3 * (right - left),
        1e3 * (upper - lower)
    );
    let _ = write!(
        svg,
        "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"none\" stroke=\"#aaa\"/>\n\
         <g font-weight=\"bold\" font-size=\"16\" stroke=\"#fff\" stroke-width=\"4\" stroke-linejoin=\"round\" paint-order=\"stroke\">"
    );
    for (name, place) in bed.places() {
        let at = [
            x + width * (place[0] - left) / (right - left),
            y + height * (upper - place[1]) / (upper - lower),
        ];
        let _ = write!(
            svg,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"5\" fill=\"{INK}\" stroke-width=\"3\"/>",
            at[0], at[1]
        );
        svg += &text([at[0] + 9.0, at[1] + 6.0], "start", name);
    }
    svg + "</g>\n"
}

/// Grains, forces, control points and the punch's base as they are drawn.
fn table_of(bed: &LoadedBed) -> Table {
    let of = bed_of(&bed.last);
    let heads = [
        "kind",
        "x1, m",
        "z1, m",
        "x2, m",
        "z2, m",
        "radius, m",
        "normal force, N",
    ];
    let mut table = Table::new("figure-2", "", &heads);
    let mut row = |kind: String, from: [f64; 2], to: Option<[f64; 2]>, rest: [Option<f64>; 2]| {
        let to = to.map_or([None; 2], |to| to.map(Some));
        let numbers = [Some(from[0]), Some(from[1]), to[0], to[1], rest[0], rest[1]];
        table.row(std::iter::once(kind.into()).chain(numbers.map(Cell::from)));
    };
    let Bodies { x, z, radius, .. } = of.bodies;
    for ((x, z), radius) in x.iter().zip(z).zip(radius) {
        row("grain".to_owned(), [*x, *z], None, [Some(*radius), None]);
    }
    for contact in of.contacts {
        let [from, to] = ends(of.bodies, contact);
        row(
            "force".to_owned(),
            from,
            Some(to),
            [None, Some(contact.normal_force)],
        );
    }
    for (name, place) in bed.places() {
        row(format!("point {name}"), place, None, [None, None]);
    }
    if let Some(punch) = &bed.last.punch {
        let [x, half, bottom] = [punch.centre[0], punch.half_extents[0], punch.bottom()];
        let kind = "base of the punch".to_owned();
        row(
            kind,
            [x - half, bottom],
            Some([x + half, bottom]),
            [None, Some(punch.force)],
        );
    }
    table
}
