//! Drawings of a bed: grains, and the forces between them as lines as thick as they are strong.

use std::fmt::Write;

use super::svg::{Area, INK, line, text, whole};
use crate::checks::slug;
use crate::document::{Colour, Drawing, Table};
use crate::error::Error;
use crate::study::figures::LoadedBed;
use crate::study::realization::bed_of;
use grains::measure::{Bed, highest_grain};
use grains::model::Axis;
use grains::scene::Scene;
use grains::tables::{Bodies, Contact, Punch};
use verdict::causes::Cause;

/// Line classes; a force is drawn in the class of its share of the strong force.
const CLASSES: usize = 8;

/// Beds of one scene on one scale of forces, each with the height of its punch's bottom, m, if there is a punch, and its words.
pub fn pictures(scene: &Scene, beds: &[(Bed<'_>, Option<f64>, String)]) -> Vec<Drawing> {
    let strong = strong_force(beds.iter().map(|(bed, ..)| *bed));
    let highest = beds.iter().map(|(bed, ..)| highest_grain(bed.bodies));
    let top = highest.fold(0.0, f64::max) + 0.02;
    let width = scene.container.width;
    let draw = |(index, (bed, bottom, caption)): (usize, &(Bed<'_>, Option<f64>, String))| {
        let name = format!("packing-{}", index + 1);
        let contents = contents(width, punch(scene, *bottom), *bed, strong, top);
        Drawing {
            svg: with_margin([width, top], caption, &contents),
            caption: format!("{caption}; the thickest lines bear {strong:.0} N or more."),
            table: table_of(&name, *bed, std::iter::empty()),
        }
    };
    beds.iter().enumerate().map(draw).collect()
}

/// A drawing of something of this size, m.
fn with_margin(size: [f64; 2], label: &str, contents: &str) -> String {
    let contents = format!("<g transform=\"translate(4 4)\">{contents}</g>\n");
    whole(size.map(|length| 1e3 * length + 8.0), label, &contents)
}

/// The grains of an engine's bed that are farther off than rounding takes them though what is wrong is taken into account,
/// marked in the state in which they are; nothing where there are none.
pub fn grains_left(cause: &Cause) -> Option<Drawing> {
    let state = cause.state.as_ref().filter(|_| !cause.left.is_empty())?;
    let bed = Bed {
        bodies: &state.bodies,
        contacts: &state.contacts,
        across: &state.across,
    };
    let across = cause.walls.iter().filter(|wall| wall.axis == Axis::X);
    let width = across.map(|wall| wall.place).fold(0.0, f64::max);
    let punch = state.punch.map(|punch| {
        let ([x, _], [half, _]) = (punch.centre, punch.half_extents);
        [x - half, x + half, punch.bottom()]
    });
    let strong = strong_force([bed]);
    let top = highest_grain(bed.bodies) + 0.02;
    let mut svg = contents(width, punch, bed, strong, top);
    let place = |id: usize| [bed.bodies.x[id], bed.bodies.z[id]];
    let mut left = cause.left.clone();
    left.retain(|id| *id < bed.bodies.len());
    let colour = Colour::Vermilion.hex();
    for id in &left {
        let ([x, z], radius) = (place(*id), bed.bodies.radius[*id]);
        let (x, z, radius) = (1e3 * x, 1e3 * (top - z), 1e3 * radius);
        // The ring is seen where the grain is small on the page.
        let _ = write!(
            svg,
            "<circle cx=\"{x:.1}\" cy=\"{z:.1}\" r=\"{radius:.1}\" fill=\"{colour}\"/>\
             <circle cx=\"{x:.1}\" cy=\"{z:.1}\" r=\"{:.1}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>",
            2.5 * radius
        );
    }
    let caption = format!(
        "Grains that are left in {}, marked: {} of {}",
        cause.left_in,
        left.len(),
        bed.bodies.len()
    );
    let name = format!("left-{}", slug(&cause.law));
    let rows = left.iter().map(|id| ("left", place(*id), None, None, None));
    Some(Drawing {
        svg: with_margin([width, top], &caption, &svg),
        table: table_of(&name, bed, rows),
        caption,
    })
}

/// Left, right and lower edge of a scene's punch, m, where its bottom is there.
fn punch(scene: &Scene, bottom: Option<f64>) -> Option<[f64; 3]> {
    let (axis, half) = (scene.punch_axis(), scene.loading.half_width);
    bottom.map(|bottom| [axis - half, axis + half, bottom])
}

/// The bed in millimetres from the upper left corner of a box of this width, m, `top` metres above its floor. `strong` is the
/// force of the thickest line, N.
fn contents(width: f64, punch: Option<[f64; 3]>, bed: Bed<'_>, strong: f64, top: f64) -> String {
    let (width, height) = (1e3 * width, 1e3 * top);
    let flip = |z: f64| 1e3 * (top - z);
    let mut svg = format!(
        "<path fill=\"none\" stroke=\"#333\" stroke-width=\"2\" d=\"M0 0V{height:.1}H{width:.1}V0\"/>\n<g fill=\"#dfe3e8\">"
    );
    for i in 0..bed.bodies.len() {
        let (x, z, radius) = (bed.bodies.x[i], bed.bodies.z[i], bed.bodies.radius[i]);
        let (x, z, radius) = (1e3 * x, flip(z), 1e3 * radius);
        // Writing to a string cannot fail.
        let _ = write!(
            svg,
            "<circle cx=\"{x:.1}\" cy=\"{z:.1}\" r=\"{radius:.1}\"/>"
        );
    }
    let colour = Colour::Blue.hex();
    svg += &format!("</g>\n<g fill=\"none\" stroke=\"{colour}\" stroke-linecap=\"round\">");
    let mut lines = vec![String::new(); CLASSES];
    for contact in bed.contacts {
        let share = (contact.normal_force / strong).clamp(0.0, 1.0);
        let class = ((share * CLASSES as f64) as usize).min(CLASSES - 1);
        let ends = ends(bed.bodies, contact).map(|[x, z]| [1e3 * x, flip(z)]);
        lines[class] += &line(ends.into_iter());
    }
    for (class, path) in lines.iter().enumerate() {
        let thickness = 6.0 * (class as f64 + 0.5) / CLASSES as f64;
        let _ = write!(svg, "<path stroke-width=\"{thickness:.2}\" d=\"{path}\"/>");
    }
    svg += "</g>\n";
    if let Some([left, right, bottom]) = punch {
        let (colour, height) = (Colour::Vermilion.hex(), flip(bottom).max(0.0));
        let [left, width] = [1e3 * left, 1e3 * (right - left)];
        let _ = writeln!(
            svg,
            "<rect fill=\"{colour}\" fill-opacity=\".75\" x=\"{left:.1}\" y=\"0\" width=\"{width:.1}\" height=\"{height:.1}\"/>"
        );
    }
    svg
}

/// A line from centre to centre, or from the contact point where one body is flat.
fn ends(bodies: &Bodies, contact: &Contact) -> [[f64; 2]; 2] {
    [contact.id1, contact.id2].map(|id| match id as usize {
        id if id < bodies.len() => [bodies.x[id], bodies.z[id]],
        _ => contact.point,
    })
}

/// The force that one contact in a hundred exceeds, N: the thickest line.
fn strong_force<'a>(beds: impl IntoIterator<Item = Bed<'a>>) -> f64 {
    let beds = beds.into_iter();
    let forces = beds.flat_map(|bed| bed.contacts.iter().map(|contact| contact.normal_force));
    let mut forces: Vec<f64> = forces.collect();
    forces.sort_by(f64::total_cmp);
    let index = (forces.len() as f64 * 0.99) as usize;
    let strong = forces.get(index).or(forces.last()).copied();
    strong.unwrap_or(1.0).max(f64::MIN_POSITIVE)
}

const WIDTH: f64 = 900.0;
const MARGIN: f64 = 12.0;
/// Half the width and the height of the closer look in a large bed, m.
const NEAR: [f64; 2] = [0.2, 0.22];

/// The bed at the end of loading, with its control points. An error where there are no forces.
pub fn force_chains(bed: &LoadedBed) -> Result<Drawing, Error> {
    let last = bed_of(&bed.last);
    if last.contacts.is_empty() {
        return Err(Error::Report(
            "the bed has no contacts, so there are no forces to draw".to_owned(),
        ));
    }
    let bottom = bed.last.punch.as_ref().map(Punch::bottom);
    let top = highest_grain(last.bodies).max(bottom.unwrap_or(0.0)) + 0.03;
    let strong = strong_force([last]);
    let inner = WIDTH - 2.0 * MARGIN;
    let full_width = bed.scene.container.width;
    let contents = contents(full_width, punch(&bed.scene, bottom), last, strong, top);
    let axis = bed.scene.punch_axis();
    // No more than the bed.
    let half = NEAR[0].min(0.5 * full_width + 0.004);
    let lower = (bed.surface + 0.03 - NEAR[1] * half / NEAR[0]).max(-0.004);
    // Left, right, upper and lower edge of what each window shows, m.
    let all = [-0.004, full_width + 0.004, top, -0.004];
    let near = [axis - half, axis + half, bed.surface + 0.03, lower];
    let area = |above: f64, [left, right, upper, lower]: [f64; 4]| -> Area {
        let height = inner * (upper - lower) / (right - left);
        [MARGIN, above, inner, height]
    };
    let first = area(40.0, all);
    let second = area(first[1] + first[3] + 40.0, near);
    let force = bed.last.punch.map_or(0.0, |punch| punch.force);
    let words = format!(
        "Realization {} under the punch, which bears {force:.0} N: forces as lines, the thickest {strong:.0} N or more",
        bed.scene.realization
    );
    let mut svg = format!("<defs><g id=\"bed\">{contents}</g></defs>\n");
    svg += &text([MARGIN, 26.0], "start", &words);
    svg += &text([MARGIN, second[1] - 12.0], "start", "Closer");
    for (area, shown) in [(first, all), (second, near)] {
        svg += &window(bed, area, shown, top);
    }
    let size = [WIDTH, second[1] + second[3] + MARGIN];
    let points = bed.places().map(|(name, at)| (format!("point {name}"), at));
    let points: Vec<_> = points.collect();
    let points = points.iter();
    let points = points.map(|(name, at)| (name.as_str(), *at, None, None, None));
    let base = bed.last.punch.iter().map(|punch| {
        let [x, half, bottom] = [punch.centre[0], punch.half_extents[0], punch.bottom()];
        let [from, to] = [[x - half, bottom], [x + half, bottom]];
        ("base of the punch", from, Some(to), None, Some(punch.force))
    });
    let table = table_of("figure-2", last, points.chain(base));
    Ok(Drawing {
        caption: "Force chains under the load".to_owned(),
        svg: whole(size, "Forces between the grains under the punch", &svg),
        table,
    })
}

/// One look at the bed; the drawing of the bed is in mm from its upper left corner.
fn window(bed: &LoadedBed, area: Area, [left, right, upper, lower]: [f64; 4], top: f64) -> String {
    let [x, y, width, height] = area;
    let frame = format!("x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"");
    let mut svg = format!(
        "<svg {frame} viewBox=\"{:.2} {:.2} {:.2} {:.2}\"><use href=\"#bed\"/></svg>\n\
         <rect {frame} fill=\"none\" stroke=\"#aaa\"/>\n\
         <g font-weight=\"bold\" font-size=\"16\" stroke=\"#fff\" stroke-width=\"4\" stroke-linejoin=\"round\" paint-order=\"stroke\">",
        1e3 * left,
        1e3 * (top - upper),
        1e3 * (right - left),
        1e3 * (upper - lower)
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

/// What, from where to where, m, its radius, m, and force, N.
type Row<'a> = (
    &'a str,
    [f64; 2],
    Option<[f64; 2]>,
    Option<f64>,
    Option<f64>,
);

/// Grains and forces as they are drawn, and more.
fn table_of<'a>(name: &str, bed: Bed<'_>, more: impl Iterator<Item = Row<'a>>) -> Table {
    let Bodies { x, z, radius, .. } = bed.bodies;
    let grains = x.iter().zip(z).zip(radius);
    let grains = grains.map(|((x, z), radius)| ("grain", [*x, *z], None, Some(*radius), None));
    let forces = bed.contacts.iter().map(|contact| {
        let [from, to] = ends(bed.bodies, contact);
        ("force", from, Some(to), None, Some(contact.normal_force))
    });
    Table::of(name, "", grains.chain(forces).chain(more))
        .column("kind", |(kind, ..)| kind)
        .column("x1, m", |(_, from, ..)| from[0])
        .column("z1, m", |(_, from, ..)| from[1])
        .column("x2, m", |(_, _, to, ..)| to.map(|to| to[0]))
        .column("z2, m", |(_, _, to, ..)| to.map(|to| to[1]))
        .column("radius, m", |(.., radius, _)| radius)
        .column("normal force, N", |(.., force)| force)
        .into()
}
