//! A picture of the stress inside a disc: a map of σ_zz with the contact forces and the control
//! square, and σ_zz along the axes beside its averages. Compression is positive here, as in the
//! paper's tables.

mod arrows;
mod panel;
mod scale;

use std::fmt::Write;

use self::arrows::{arrow, arrows};
use self::scale::{Scale, colour_bar};
use super::axis::{Area, rounded};
use super::contours::Grid;
use super::frame::{line, text};
use crate::paper::disc_field::DiscField;

/// Width and height of the picture; all lengths that follow are in these units.
const SIZE: [f64; 2] = [800.0, 800.0];
/// Centre and radius of the disc.
const CENTRE: [f64; 2] = [262.0, 262.0];
const DISC: f64 = 160.0;
/// Nodes of the map's grid in each direction; even, so that forces on the axes act between nodes.
const NODES: usize = 150;
/// Half the grid's width, in radii.
const REACH: f64 = 1.03;
/// Left edge, top, width and height of the panel with the curves.
const PANEL: Area = [72.0, 528.0, 390.0, 210.0];
/// Left edge of the keys.
const KEY: f64 = 492.0;
/// From one line of text to the next.
const LINE: f64 = 22.0;
/// The line between tension and compression.
const ZERO: &str = "fill=\"none\" stroke=\"#fff\" stroke-width=\"1.3\"";

/// Within the control square, in the panel.
const SHADE: &str = "#e8eaed";

/// Draws σ_zz of the field, Pa with compression positive, as one SVG element of about 800 by 800
/// that needs nothing else and scales with the page. The control square has the side R and the
/// Voronoi cell 2R, as in Figure 4.
pub fn picture(field: &DiscField) -> String {
    let scale = Scale::of(field);
    let [width, height] = SIZE;
    let parts = [
        definitions(),
        map(field, &scale),
        control_square(),
        arrows(field),
        colour_bar(&scale),
        map_key(field, &scale),
        panel::panel(field, &scale),
        panel::panel_key(field),
    ];
    format!(
        "<svg class=\"disc-field\" xmlns=\"http://www.w3.org/2000/svg\" \
         viewBox=\"0 0 {width} {height}\" role=\"img\" \
         aria-label=\"Vertical stress inside a disc under forces on its rim\" \
         font-family=\"system-ui, 'DejaVu Sans', sans-serif\" font-size=\"13\" fill=\"#1b1b1b\">\n\
         {}</svg>",
        parts.concat()
    )
}

/// What is drawn, as rows of kind, x and z in m and σ_zz in Pa: the map's nodes within the disc, both axes, and the
/// averages, which have no place.
pub fn numbers(field: &DiscField) -> Vec<[String; 4]> {
    let row = |kind: &str, [x, z]: [f64; 2]| {
        let place = [x, z].map(|part| format!("{:.6}", field.radius() * part));
        let value = format!("{:.6e}", compression(field, [x, z]));
        let [x, z] = place;
        [kind.to_owned(), x, z, value]
    };
    let mut rows: Vec<[String; 4]> = nodes()
        .flat_map(|x| nodes().map(move |z| [x, z]))
        .filter(|[x, z]| x.hypot(*z) < 1.0)
        .map(|point| row("map", point))
        .collect();
    for (kind, axis) in ["vertical axis", "horizontal axis"]
        .into_iter()
        .zip(panel::AXES)
    {
        for [place, _] in panel::profile(field, axis) {
            rows.push(row(kind, axis.map(|part| place * part)));
        }
    }
    let kinds = [
        "average over the disc",
        "over the control square",
        "over the cell",
    ];
    for (kind, value) in kinds.into_iter().zip(panel::averages(field)) {
        let value = format!("{value:.6e}");
        rows.push([kind.to_owned(), String::new(), String::new(), value]);
    }
    rows
}

/// σ_zz with compression positive, Pa; the point in radii.
fn compression(field: &DiscField, [x, z]: [f64; 2]) -> f64 {
    let radius = field.radius();
    -field.stress([radius * x, radius * z])[1][1]
}

/// Places of the grid's nodes, in radii.
fn nodes() -> impl Iterator<Item = f64> + Clone {
    (0..NODES).map(|index| place(index as f64))
}

/// Of a column or row of the grid, in radii.
fn place(index: f64) -> f64 {
    REACH * (2.0 * index / (NODES - 1) as f64 - 1.0)
}

/// On the picture, of a point in radii.
fn on_map([x, z]: [f64; 2]) -> [f64; 2] {
    [CENTRE[0] + DISC * x, CENTRE[1] - DISC * z]
}

/// Hatchings for what is below and above the scale, and the edges that cut map and curves.
fn definitions() -> String {
    let hatch = |name: &str, colour: &str| {
        format!(
            "<pattern id=\"disc-field-{name}\" width=\"6\" height=\"6\" \
             patternUnits=\"userSpaceOnUse\" patternTransform=\"rotate(45)\">\
             <path d=\"M3 0V6\" stroke=\"{colour}\" stroke-width=\"2\"/></pattern>"
        )
    };
    let [x, y] = CENTRE;
    let [left, top, width, height] = PANEL;
    format!(
        "<defs>{}{}<clipPath id=\"disc-field-disc\"><circle cx=\"{x}\" cy=\"{y}\" r=\"{DISC}\"/>\
         </clipPath><clipPath id=\"disc-field-panel\">\
         <rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"/></clipPath></defs>\n",
        hatch("below", "#fff"),
        hatch("above", "#1b1b1b")
    )
}

/// Each band is painted over the lower ones.
fn map(field: &DiscField, scale: &Scale) -> String {
    // Beyond the rim the field means nothing; lines go on there from the value on the rim.
    let value = |column: usize, row: usize| {
        let (x, z) = (place(column as f64), place(row as f64));
        let shrink = (0.995 / x.hypot(z)).min(1.0);
        compression(field, [shrink * x, shrink * z])
    };
    let grid = Grid::new(NODES, value);
    let lower = Grid::new(NODES, |column, row| -value(column, row));
    let [x, y] = CENTRE;
    let mut svg = text(
        [x, 24.0],
        "middle",
        "Vertical stress σ_zz inside the disc, Pa, compression positive",
    );
    svg += "<g clip-path=\"url(#disc-field-disc)\">\n";
    svg += &filled(
        &format!("M0 0H{}V{}H0Z", SIZE[0], SIZE[1]),
        &scale.colour(0),
    );
    for band in 1..scale.bands {
        svg += &filled(&path(&grid, scale.level(band)), &scale.colour(band));
    }
    let [below, above] = scale.beyond;
    if above {
        svg += &filled(&path(&grid, scale.high()), "url(#disc-field-above)");
    }
    if below {
        svg += &filled(&path(&lower, -scale.low()), "url(#disc-field-below)");
    }
    if scale.has_tension() {
        let _ = writeln!(svg, "<path {ZERO} d=\"{}\"/>", path(&grid, 0.0));
    }
    let _ = writeln!(
        svg,
        "</g><circle cx=\"{x}\" cy=\"{y}\" r=\"{DISC}\" fill=\"none\" stroke=\"#1b1b1b\"/>"
    );
    svg
}

fn filled(path: &str, fill: &str) -> String {
    if path.is_empty() {
        return String::new();
    }
    format!("<path fill=\"{fill}\" d=\"{path}\"/>\n")
}

/// The parts of the grid above a level.
fn path(grid: &Grid, level: f64) -> String {
    let lines = grid.contours(level);
    let closed =
        |points: &Vec<[f64; 2]>| line(points.iter().map(|point| on_map(point.map(place)))) + "Z";
    lines.iter().map(closed).collect()
}

/// Dark dashes on white, to be seen on every colour.
fn control_square() -> String {
    let [left, top] = on_map([-0.5, 0.5]);
    let square = format!("<rect x=\"{left}\" y=\"{top}\" width=\"{DISC}\" height=\"{DISC}\"");
    outlined(&square)
}

fn outlined(shape: &str) -> String {
    format!(
        "{shape} fill=\"none\" stroke=\"#fff\" stroke-width=\"3.2\"/>\
         {shape} fill=\"none\" stroke=\"#1b1b1b\" stroke-width=\"1.6\" stroke-dasharray=\"7 4\"/>\n"
    )
}

fn tick([x, y]: [f64; 2], [dx, dy]: [f64; 2]) -> String {
    format!("<path stroke=\"#1b1b1b\" d=\"M{x:.1} {y:.1}l{dx} {dy}\"/>")
}

/// What is drawn on the map.
fn map_key(field: &DiscField, scale: &Scale) -> String {
    let square = outlined("<rect y=\"-11\" width=\"24\" height=\"12\"");
    let mut entries = vec![
        (square, "control square, side R".to_owned()),
        (
            arrow([[0.0, -4.5], [24.0, -4.5]]),
            "forces on the disc, N/m".to_owned(),
        ),
    ];
    if scale.has_tension() {
        let line = swatch(&scale.colour(0)) + &format!("<path {ZERO} d=\"M0 -5h24\"/>");
        entries.push((line, "σ_zz = 0; tension is negative".to_owned()));
    }
    let radius = format!("R = {} m", rounded(field.radius(), 4));
    entries.push((String::new(), radius));
    let [x, z] = field.body_force();
    if [x, z] != [0.0; 2] {
        let weight = format!("body force ({}, {}) N/m³", rounded(x, 4), rounded(z, 4));
        entries.push((String::new(), weight));
    }
    key(376.0, &entries)
}

/// Symbols, each drawn upwards from its own origin, with what they mean; `top` is the first line's.
fn key(top: f64, entries: &[(String, String)]) -> String {
    let mut svg = String::new();
    for (index, (symbol, meaning)) in entries.iter().enumerate() {
        let y = top + LINE * index as f64;
        let _ = write!(svg, "<g transform=\"translate({KEY} {y})\">{symbol}</g>");
        svg += &text([KEY + 34.0, y], "start", meaning);
    }
    svg
}

fn swatch(fill: &str) -> String {
    format!("<rect y=\"-11\" width=\"24\" height=\"12\" fill=\"{fill}\"/>")
}

#[cfg(test)]
mod tests;
