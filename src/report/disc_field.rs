//! A picture of the stress inside a disc: a map of σ_zz with the contact forces and the control
//! square, and σ_zz along the axes beside its averages. Compression is positive here, as in the
//! paper's tables.

mod panel;

use std::fmt::Write;

use super::axis::{round_step, rounded as number};
use super::contours::Grid;
use super::frame::{line, text};
use super::shades::viridis;
use crate::paper::disc_field::{DiscField, PointForce};

/// Width and height of the picture; all lengths that follow are in these units.
const SIZE: [f64; 2] = [800.0, 800.0];
/// Centre and radius of the disc.
const CENTRE: [f64; 2] = [262.0, 262.0];
const DISC: f64 = 160.0;
/// Nodes of the map's grid in each direction; even, so that forces on the axes act between nodes.
const NODES: usize = 150;
/// Half the grid's width, in radii.
const REACH: f64 = 1.03;
/// Left edge, top, width and height of the colour bar.
const BAR: [f64; 4] = [545.0, 84.0, 22.0, 230.0];
/// The same of the panel with the curves.
const PANEL: [f64; 4] = [72.0, 528.0, 390.0, 210.0];
/// Left edge of the keys.
const KEY: f64 = 492.0;
/// From one line of text to the next.
const LINE: f64 = 22.0;
/// Length of the arrow of the strongest force.
const ARROW: f64 = 46.0;
/// About as many bands of colour.
const BANDS: f64 = 20.0;

/// Beyond this many distances between the quartiles lie outliers, after Tukey.
const FENCE: f64 = 1.5;

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

/// The bands of colour.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Scale {
    /// The lowest level, in steps.
    first: f64,
    /// From one level to the next, Pa.
    step: f64,
    bands: u32,
    /// Whether the field goes below and above the scale.
    beyond: [bool; 2],
}

impl Scale {
    /// From the least to the largest value, but not to outliers: near a force there is no largest.
    fn of(field: &DiscField) -> Self {
        let mut values: Vec<f64> = nodes()
            .flat_map(|x| nodes().map(move |z| [x, z]))
            .filter(|[x, z]| x.hypot(*z) < 1.0)
            .map(|point| compression(field, point))
            .chain(
                panel::AXES
                    .into_iter()
                    .flat_map(|axis| panel::profile(field, axis))
                    .map(|[_, value]| value),
            )
            .filter(|value| value.is_finite())
            .collect();
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values[((values.len() - 1) as f64 * share) as usize];
        let (low, quarter, three_quarters, high) = (at(0.0), at(0.25), at(0.75), at(1.0));
        let fence = FENCE * (three_quarters - quarter);
        let inner = [low.max(quarter - fence), high.min(three_quarters + fence)];
        let step = round_step((inner[1] - inner[0]) / BANDS);
        // Without noise where the least value is the rounding of a zero.
        let first = (inner[0] / step + 1e-6).floor();
        let last = (inner[1] / step - 1e-6).ceil().max(first + 1.0);
        let beyond = [low < step * (first - 1e-6), high > step * (last + 1e-6)];
        Scale {
            first,
            step,
            bands: (last - first) as u32,
            beyond,
        }
    }

    fn level(&self, band: u32) -> f64 {
        self.step * (self.first + f64::from(band))
    }

    fn low(&self) -> f64 {
        self.level(0)
    }

    fn high(&self) -> f64 {
        self.level(self.bands)
    }

    /// Whether zero parts tension from compression.
    fn has_tension(&self) -> bool {
        self.first < 0.0 && self.high() > 0.0
    }

    /// In [0, 1] within the scale.
    fn share(&self, value: f64) -> f64 {
        (value - self.low()) / (self.high() - self.low())
    }

    fn colour(&self, band: u32) -> String {
        viridis((f64::from(band) + 0.5) / f64::from(self.bands))
    }

    /// Bands with a label: all, or so many that the labels have room on `length`.
    fn labelled(&self, length: f64) -> impl Iterator<Item = (u32, String)> + '_ {
        let every = (LINE * f64::from(self.bands) / length).ceil().max(1.0) as u32;
        // Zero is labelled.
        let offset = self.first.rem_euclid(f64::from(every)) as u32;
        (0..=self.bands)
            .filter(move |band| (band + offset).is_multiple_of(every))
            .map(|band| (band, number(self.level(band), 6)))
    }
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

/// The forces on the rim, from outside, as long as they are strong, with their sizes.
fn arrows(field: &DiscField) -> String {
    let size = |force: &PointForce| force.force[0].hypot(force.force[1]);
    let largest = field.forces().map(|force| size(&force)).fold(0.0, f64::max);
    field
        .forces()
        .filter(|force| size(force) > 1e-6 * largest)
        .map(|force| force_arrow(field, &force, size(&force), largest))
        .collect()
}

/// A push ends at the rim and a pull begins there.
fn force_arrow(field: &DiscField, force: &PointForce, size: f64, largest: f64) -> String {
    let point = force.point.map(|x| x / field.radius());
    let pushes = force.force[0] * point[0] + force.force[1] * point[1] <= 0.0;
    let sign = if pushes { -1.0 } else { 1.0 };
    // Upwards on the picture is down its coordinate.
    let away = [sign * force.force[0] / size, -sign * force.force[1] / size];
    let length = (ARROW * size / largest).max(16.0);
    let [near, far, label] = [2.0, 2.0 + length, 10.0 + length].map(|distance| {
        let [x, y] = on_map(point);
        [x + distance * away[0], y + distance * away[1]]
    });
    let line = if pushes { [far, near] } else { [near, far] };
    let anchor = match away[0] {
        x if x > 0.4 => "start",
        x if x < -0.4 => "end",
        _ => "middle",
    };
    let middle = [label[0], label[1] + 4.5 + 5.0 * away[1]];
    arrow(line) + &text(middle, anchor, &number(size, 3))
}

fn arrow([from, to]: [[f64; 2]; 2]) -> String {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = dx.hypot(dy);
    let (dx, dy) = (dx / length, dy / length);
    let base = [to[0] - 9.0 * dx, to[1] - 9.0 * dy];
    format!(
        "<path stroke=\"#1b1b1b\" stroke-width=\"2.4\" d=\"M{:.1} {:.1}L{:.1} {:.1}\"/>\
         <path d=\"M{:.1} {:.1}L{:.1} {:.1}L{:.1} {:.1}Z\"/>\n",
        from[0],
        from[1],
        base[0],
        base[1],
        to[0],
        to[1],
        base[0] - 4.5 * dy,
        base[1] + 4.5 * dx,
        base[0] + 4.5 * dy,
        base[1] - 4.5 * dx
    )
}

fn colour_bar(scale: &Scale) -> String {
    let [left, top, width, height] = BAR;
    let step = height / f64::from(scale.bands);
    let y = |band: u32| top + height - step * f64::from(band);
    let mut svg = text([left, top - 46.0], "start", "σ_zz, Pa");
    for band in 0..scale.bands {
        svg += &bar_part(y(band + 1), step, &scale.colour(band));
    }
    for (band, label) in scale.labelled(height) {
        svg += &tick([left + width, y(band)], [5.0, 0.0]);
        svg += &text([left + width + 9.0, y(band) + 4.5], "start", &label);
    }
    let last = scale.bands - 1;
    let ends = [
        (top + height + 10.0, 0, "below", "less: clipped"),
        (top - 26.0, last, "above", "more: clipped"),
    ];
    for ((y, band, name, label), beyond) in ends.into_iter().zip(scale.beyond) {
        if beyond {
            svg += &bar_part(y, 16.0, &scale.colour(band));
            svg += &bar_part(y, 16.0, &format!("url(#disc-field-{name})"));
            svg += &text([left + width + 9.0, y + 12.5], "start", label);
        }
    }
    svg
}

fn bar_part(y: f64, height: f64, fill: &str) -> String {
    let [left, _, width, _] = BAR;
    format!(
        "<rect x=\"{left}\" y=\"{y:.1}\" width=\"{width}\" height=\"{height:.1}\" fill=\"{fill}\"/>\n"
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
    let radius = format!("R = {} m", number(field.radius(), 4));
    entries.push((String::new(), radius));
    let [x, z] = field.body_force();
    if [x, z] != [0.0; 2] {
        let weight = format!("body force ({}, {}) N/m³", number(x, 4), number(z, 4));
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
