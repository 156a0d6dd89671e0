//! Figure 2's content: the forces between grains under the punch, of the whole bed and near the load.

use std::fmt::Write;

use crate::error::Error;
use crate::report::axis::Area;
use crate::report::figure::Figure;
use crate::report::figure_files::table;
use crate::report::frame::{INK, text, whole};
use crate::report::packing;
use crate::study::figures::LoadedBed;
use crate::study::realization::bed_of;
use grains::measure::height;
use grains::tables::Punch;

const WIDTH: f64 = 900.0;
const MARGIN: f64 = 12.0;
/// Half the width and the height of the closer look in a large bed, m.
const NEAR: [f64; 2] = [0.2, 0.22];

/// The bed at the end of loading, with its control points. An error where there are no forces.
pub fn figure(bed: &LoadedBed) -> Result<Figure, Error> {
    let of = bed_of(&bed.last);
    if of.contacts.is_empty() {
        return Err(Error::Report(
            "the bed has no contacts, so there are no forces to draw".to_owned(),
        ));
    }
    let bottom = bed.last.punch.as_ref().map(Punch::bottom);
    let highest = height::highest_grain(of.bodies);
    let top = highest.max(bottom.unwrap_or(0.0)) + 0.03;
    let strong = packing::strong_force([of].into_iter());
    let contents = packing::contents(&bed.scene, of, bottom, strong, top);
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
    Ok(Figure {
        name: "figure-2".to_owned(),
        caption: "Force chains under the load".to_owned(),
        svg: whole(size, "Forces between the grains under the punch", &svg),
        csv: table(
            &[
                "kind",
                "x1 (m)",
                "z1 (m)",
                "x2 (m)",
                "z2 (m)",
                "radius (m)",
                "normal force (N)",
            ],
            rows(bed),
        )?,
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

fn rows(bed: &LoadedBed) -> Vec<[String; 7]> {
    let of = bed_of(&bed.last);
    let cell = |value: f64| format!("{value:.6}");
    let empty = String::new;
    let mut rows = Vec::new();
    for id in 0..of.bodies.len() {
        let (x, z) = (cell(of.bodies.x[id]), cell(of.bodies.z[id]));
        let radius = cell(of.bodies.radius[id]);
        rows.push(["grain".to_owned(), x, z, empty(), empty(), radius, empty()]);
    }
    for contact in of.contacts {
        let [from, to] = packing::ends(of.bodies, contact);
        let force = format!("{:.4}", contact.normal_force);
        let places = [from[0], from[1], to[0], to[1]].map(cell);
        let [x1, z1, x2, z2] = places;
        rows.push(["force".to_owned(), x1, z1, x2, z2, empty(), force]);
    }
    for (name, [x, z]) in bed.places() {
        let kind = format!("point {name}");
        rows.push([kind, cell(x), cell(z), empty(), empty(), empty(), empty()]);
    }
    if let Some(punch) = &bed.last.punch {
        let [x, _] = punch.centre;
        let [half, _] = punch.half_extents;
        let bottom = cell(punch.bottom());
        let force = format!("{:.4}", punch.force);
        let kind = "base of the punch".to_owned();
        let (left, right) = (cell(x - half), cell(x + half));
        rows.push([kind, left, bottom.clone(), right, bottom, empty(), force]);
    }
    rows
}
