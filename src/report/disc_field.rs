//! The stress inside a disc, drawn: a map of σ_zz with the contact forces and the control square, and σ_zz along the axes beside
//! its averages. Compression is positive here, as in the paper's tables.

use std::fmt::Write;

use super::fields::{Grid, VIRIDIS, colour};
use super::svg::{Area, INK, key, line, printed, round_step, text, whole};
use crate::document::{self, Colour, Drawing, Plot, Section, Table};
use crate::paper::disc_field::{DiscField, PointForce, figure_4};

/// Width and height of the picture; all lengths that follow are in these units.
const SIZE: [f64; 2] = [800.0, 530.0];
/// Centre and radius of the disc.
const CENTRE: [f64; 2] = [262.0, 262.0];
const DISC: f64 = 160.0;
/// Nodes of the map's grid in each direction; even, so that forces on the axes act between nodes.
const NODES: usize = 150;
/// Half the grid's width, in radii.
const REACH: f64 = 1.03;
/// Left edge of the keys.
const KEY: f64 = 492.0;
/// From one line of text to the next.
const LINE: f64 = 22.0;
/// The line between tension and compression.
const ZERO: &str = "fill=\"none\" stroke=\"#fff\" stroke-width=\"1.3\"";

/// The field inside the disc of the paper's Figure 4: σ_zz, Pa with compression positive, as a map with the forces on the rim and
/// the control square of side R; and along the axes through the centre beside its averages over disc, control square and cell of
/// side 2R.
pub fn of_figure_4() -> Section {
    let field = &figure_4();
    let scale = Scale::of(field);
    let [left, top] = on_map([-0.5, 0.5]);
    let parts = [
        definitions(),
        map(field, &scale),
        // Dark dashes on white, to be seen on every colour.
        outlined(&format!(
            "<rect x=\"{left}\" y=\"{top}\" width=\"{DISC}\" height=\"{DISC}\""
        )),
        arrows(field),
        colour_bar(&scale),
        map_key(field, &scale),
    ];
    let radius = field.radius();
    let table = Table::of("figure-4", "", within_the_disc())
        .column("kind", |_| "map")
        .column("x, m", |[x, _]| radius * x)
        .column("z, m", |[_, z]| radius * z)
        .column("stress zz, Pa", |at| compression(field, at));
    let drawing = Drawing {
        caption: "The stress inside a grain".to_owned(),
        svg: whole(
            SIZE,
            "Vertical stress inside a disc under forces on its rim",
            &parts.concat(),
        ),
        table: table.into(),
    };
    let section = Section::new("The field of Figure 4's disc", "");
    section.with(drawing).with(profiles(field, &scale))
}

/// Along both axes, within the scale of the map, and averages.
fn profiles(field: &DiscField, scale: &Scale) -> Plot {
    let radius = field.radius();
    let caption = "σ_zz along the axes through the centre, and its averages";
    let x = document::Axis::linear("distance from the centre, m");
    let y = document::Axis::linear("σ_zz, Pa").within(scale.low(), scale.high());
    let mut plot = Plot::new("figure-4-profiles", caption, x, y);
    let lines = [
        ("along the vertical axis", Colour::Blue),
        ("along the horizontal axis", Colour::Vermilion),
    ];
    for (axis, (name, colour)) in AXES.into_iter().zip(lines) {
        let points = profile(field, axis).map(|[place, value]| [radius * place, value]);
        plot = plot.line(name, colour, points);
    }
    let square = -field.average_over_square(radius)[(1, 1)];
    let cell = -field.average_over_cell(2.0 * radius)[(1, 1)];
    let averages = [
        ("disc", Colour::Grey, -field.contact_average()[(1, 1)]),
        ("control square", Colour::Green, square),
        ("cell of side 2R", Colour::Purple, cell),
    ];
    for (name, colour, y) in averages {
        let name = format!("average, {name}: {}", printed(y, 4));
        plot = plot.level(name, colour, y);
    }
    plot
}

/// Vertical and horizontal axis.
const AXES: [[f64; 2]; 2] = [[0.0, 1.0], [1.0, 0.0]];
/// Points of each profile.
const POINTS: u32 = 240;

/// σ_zz along an axis from rim to rim: places in radii and values.
fn profile(field: &DiscField, axis: [f64; 2]) -> impl Iterator<Item = [f64; 2]> + '_ {
    (0..=POINTS).map(move |index| {
        // The ends themselves may be the points of forces.
        let place = 0.999 * (2.0 * f64::from(index) / f64::from(POINTS) - 1.0);
        [place, compression(field, axis.map(|part| place * part))]
    })
}

/// The nodes of the map within the disc, in radii.
fn within_the_disc() -> impl Iterator<Item = [f64; 2]> {
    let all = nodes().flat_map(|x| nodes().map(move |z| [x, z]));
    all.filter(|[x, z]| x.hypot(*z) < 1.0)
}

/// σ_zz with compression positive, Pa; the point in radii.
fn compression(field: &DiscField, [x, z]: [f64; 2]) -> f64 {
    let radius = field.radius();
    -field.stress([radius * x, radius * z])[(1, 1)]
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

/// The hatching for what is above the scale, and the edge that cuts the map.
fn definitions() -> String {
    let [x, y] = CENTRE;
    format!(
        "<defs><pattern id=\"disc-field-above\" width=\"6\" height=\"6\" \
         patternUnits=\"userSpaceOnUse\" patternTransform=\"rotate(45)\">\
         <path d=\"M3 0V6\" stroke=\"#1b1b1b\" stroke-width=\"2\"/></pattern>\
         <clipPath id=\"disc-field-disc\"><circle cx=\"{x}\" cy=\"{y}\" r=\"{DISC}\"/>\
         </clipPath></defs>\n"
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
    svg += &filled(&path(&grid, scale.high()), "url(#disc-field-above)");
    let _ = writeln!(svg, "<path {ZERO} d=\"{}\"/>", path(&grid, 0.0));
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

fn outlined(shape: &str) -> String {
    format!(
        "{shape} fill=\"none\" stroke=\"#fff\" stroke-width=\"3.2\"/>\
         {shape} fill=\"none\" stroke=\"#1b1b1b\" stroke-width=\"1.6\" stroke-dasharray=\"7 4\"/>\n"
    )
}

/// What is drawn on the map.
fn map_key(field: &DiscField, scale: &Scale) -> String {
    let square = outlined("<rect y=\"-11\" width=\"22\" height=\"12\"");
    let arrow = arrow([[0.0, -4.5], [22.0, -4.5]]);
    let zero = format!(
        "<rect y=\"-11\" width=\"22\" height=\"12\" fill=\"{}\"/><path {ZERO} d=\"M0 -5h22\"/>",
        scale.colour(0)
    );
    let entries = [
        (square, "control square, side R".to_owned()),
        (arrow, "forces on the disc, N/m".to_owned()),
        (zero, "σ_zz = 0; tension is negative".to_owned()),
        (
            String::new(),
            format!("R = {} m", printed(field.radius(), 4)),
        ),
    ];
    // One below the other.
    key([KEY, KEY + 1.0], 376.0, &entries).0
}

/// Length of the arrow of the strongest force.
const ARROW: f64 = 46.0;

/// The pushes on the rim, from outside, as long as they are strong, with their sizes.
fn arrows(field: &DiscField) -> String {
    let size = |force: &PointForce| force.force[0].hypot(force.force[1]);
    let forces = field.forces().iter();
    let largest = forces.clone().map(size).fold(0.0, f64::max);
    let arrows = forces.map(|force| {
        let (point, size): ([f64; 2], f64) = ((force.point / field.radius()).into(), size(force));
        // Upwards on the picture is down its coordinate.
        let away = [-force.force[0] / size, force.force[1] / size];
        let length = (ARROW * size / largest).max(16.0);
        let [near, far, label] = [2.0, 2.0 + length, 10.0 + length].map(|distance| {
            let [x, y] = on_map(point);
            [x + distance * away[0], y + distance * away[1]]
        });
        let anchor = match away[0] {
            x if x > 0.4 => "start",
            x if x < -0.4 => "end",
            _ => "middle",
        };
        let middle = [label[0], label[1] + 4.5 + 5.0 * away[1]];
        arrow([far, near]) + &text(middle, anchor, &printed(size, 3))
    });
    arrows.collect()
}

/// A line with a head at its end.
fn arrow([from, to]: [[f64; 2]; 2]) -> String {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = dx.hypot(dy);
    let (dx, dy) = (dx / length, dy / length);
    let [x, y] = [to[0] - 9.0 * dx, to[1] - 9.0 * dy];
    let [left, right] = [[x - 4.5 * dy, y + 4.5 * dx], [x + 4.5 * dy, y - 4.5 * dx]];
    let path = |places: &[[f64; 2]]| {
        let places = places.iter().map(|[x, y]| format!("{x:.1} {y:.1}"));
        format!("M{}", places.collect::<Vec<_>>().join("L"))
    };
    let (shaft, head) = (path(&[from, [x, y]]), path(&[to, left, right]));
    format!("<path stroke=\"#1b1b1b\" stroke-width=\"2.4\" d=\"{shaft}\"/><path d=\"{head}Z\"/>\n")
}

/// Left edge, top, width and height of the colour bar.
const BAR: Area = [545.0, 84.0, 22.0, 230.0];
/// About as many bands of colour.
const BANDS: f64 = 20.0;

/// Beyond this many distances between the quartiles lie outliers, after Tukey.
const FENCE: f64 = 1.5;

/// The bands of colour.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Scale {
    /// The lowest level, in steps.
    first: f64,
    /// From one level to the next, Pa.
    step: f64,
    /// How many.
    bands: u32,
}

impl Scale {
    /// From the least value, but not to the largest: near a force there is none.
    fn of(field: &DiscField) -> Self {
        let map = within_the_disc().map(|point| compression(field, point));
        let axes = AXES.into_iter().flat_map(|axis| profile(field, axis));
        let all = map.chain(axes.map(|[_, value]| value));
        let mut values: Vec<f64> = all.filter(|value| value.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values[((values.len() - 1) as f64 * share) as usize];
        let (quarter, three_quarters) = (at(0.25), at(0.75));
        let fence = FENCE * (three_quarters - quarter);
        let inner = [
            at(0.0).max(quarter - fence),
            at(1.0).min(three_quarters + fence),
        ];
        let step = round_step((inner[1] - inner[0]) / BANDS);
        // Without noise where the least value is the rounding of a zero.
        let first = (inner[0] / step + 1e-6).floor();
        let last = (inner[1] / step - 1e-6).ceil().max(first + 1.0);
        let bands = (last - first) as u32;
        Scale { first, step, bands }
    }

    /// Lower end of a band, Pa.
    fn level(&self, band: u32) -> f64 {
        self.step * (self.first + f64::from(band))
    }

    /// Lower end of the scale, Pa.
    fn low(&self) -> f64 {
        self.level(0)
    }

    /// Upper end of the scale, Pa.
    fn high(&self) -> f64 {
        self.level(self.bands)
    }

    /// Of a band.
    fn colour(&self, band: u32) -> String {
        colour(&VIRIDIS, (f64::from(band) + 0.5) / f64::from(self.bands))
    }

    /// Bands with a label: all, or so many that the labels have room on `length`.
    fn labelled(&self, length: f64) -> impl Iterator<Item = (u32, String)> + '_ {
        let every = (LINE * f64::from(self.bands) / length).ceil().max(1.0) as u32;
        // Zero is labelled.
        let offset = self.first.rem_euclid(f64::from(every)) as u32;
        (0..=self.bands)
            .filter(move |band| (band + offset).is_multiple_of(every))
            .map(|band| (band, printed(self.level(band), 6)))
    }
}

/// The bands from the lowest to the highest with labels, and what stands for values beyond the scale.
fn colour_bar(scale: &Scale) -> String {
    let [left, top, width, height] = BAR;
    let step = height / f64::from(scale.bands);
    let y = |band: u32| top + height - step * f64::from(band);
    let mut svg = text([left, top - 46.0], "start", "σ_zz, Pa");
    for band in 0..scale.bands {
        svg += &bar_part(y(band + 1), step, &scale.colour(band));
    }
    for (band, label) in scale.labelled(height) {
        let (right, y) = (left + width, y(band));
        let _ = write!(svg, "<path stroke=\"{INK}\" d=\"M{right:.1} {y:.1}h5\"/>");
        svg += &text([right + 9.0, y + 4.5], "start", &label);
    }
    let (y, last) = (top - 26.0, scale.colour(scale.bands - 1));
    svg += &bar_part(y, 16.0, &last);
    svg += &bar_part(y, 16.0, "url(#disc-field-above)");
    svg += &text([left + width + 9.0, y + 12.5], "start", "more: clipped");
    svg
}

fn bar_part(y: f64, height: f64, fill: &str) -> String {
    let [left, _, width, _] = BAR;
    format!(
        "<rect x=\"{left}\" y=\"{y:.1}\" width=\"{width}\" height=\"{height:.1}\" fill=\"{fill}\"/>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::of_figure_4;
    use crate::document::Block;

    #[test]
    fn every_number_draws_the_averages_stand_beside_the_curves_and_the_picture_is_small() {
        let section = of_figure_4();
        let [Block::Drawing(map), Block::Plot(profiles)] = &section.blocks[..] else {
            panic!("a map and its profiles");
        };
        let profiles = crate::report::svg(profiles);
        for label in [
            "disc: 0.6366",
            "control square: 0.7189",
            "cell of side 2R: 0.5<",
        ] {
            assert!(profiles.contains(label), "{label}");
        }
        let svg = map.svg.clone() + &profiles;
        for wrong in ["NaN", "inf", "-0.0 ", "−0<"] {
            assert!(!svg.contains(wrong), "{wrong}");
        }
        assert!(svg.len() < 400_000, "{}", svg.len());
        assert_eq!(svg.matches("<svg").count(), svg.matches("</svg>").count());
    }
}
