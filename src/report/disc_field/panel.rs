//! The panel under the map: σ_zz along the axes through the centre, and its averages.

use std::fmt::Write;

use super::scale::Scale;
use super::{PANEL, SHADE, compression, key, swatch, tick};
use crate::paper::disc_field::DiscField;
use crate::report::axis::rounded;
use crate::report::frame::{line, text};

/// Points of each curve.
const POINTS: u32 = 240;

/// Vertical and horizontal axis.
pub(super) const AXES: [[f64; 2]; 2] = [[0.0, 1.0], [1.0, 0.0]];

/// Colour and width of the curves along these axes.
const CURVES: [&str; 2] = [
    "stroke=\"#0072b2\" stroke-width=\"2.2\"",
    "stroke=\"#d55e00\" stroke-width=\"2.2\"",
];

/// Colour, width and dashes of the lines of the averages over disc, control square and cell.
const AVERAGES: [&str; 3] = [
    "stroke=\"#1b1b1b\" stroke-width=\"1.4\"",
    "stroke=\"#1b1b1b\" stroke-width=\"1.6\" stroke-dasharray=\"7 4\"",
    "stroke=\"#1b1b1b\" stroke-width=\"1.8\" stroke-dasharray=\"1.8 3.6\"",
];

/// σ_zz along both axes; curves are cut where they leave the scale.
pub(super) fn panel(field: &DiscField, scale: &Scale) -> String {
    let [left, top, width, height] = PANEL;
    let x = |place: f64| left + 0.5 * width * (place + 1.0);
    // Kept near the panel: numbers without bound do not draw.
    let y = |value: f64| top + height * (1.0 - scale.share(value).clamp(-0.5, 1.5));
    let middle = left + 0.5 * width;
    let mut svg = text(
        [middle, top - 14.0],
        "middle",
        "σ_zz along the axes through the centre, Pa",
    );
    let _ = writeln!(
        svg,
        "<rect x=\"{:.1}\" y=\"{top}\" width=\"{:.1}\" height=\"{height}\" fill=\"{SHADE}\"/>",
        x(-0.5),
        0.5 * width
    );
    svg += &panel_ticks(field, scale);
    svg += "<g fill=\"none\" clip-path=\"url(#disc-field-panel)\">\n";
    for (value, style) in averages(field).into_iter().zip(AVERAGES) {
        let _ = writeln!(svg, "<path {style} d=\"M{left} {:.1}h{width}\"/>", y(value));
    }
    for (axis, style) in AXES.into_iter().zip(CURVES) {
        let points = profile(field, axis).map(|[place, value]| [x(place), y(value)]);
        let _ = writeln!(svg, "<path {style} d=\"{}\"/>", line(points));
    }
    let _ = writeln!(
        svg,
        "</g><rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" fill=\"none\" \
         stroke=\"#1b1b1b\"/>"
    );
    svg
}

fn panel_ticks(field: &DiscField, scale: &Scale) -> String {
    let [left, top, width, height] = PANEL;
    let bottom = top + height;
    let mut svg = String::new();
    for (band, label) in scale.labelled(height) {
        let y = bottom - height * f64::from(band) / f64::from(scale.bands);
        let _ = write!(
            svg,
            "<path stroke=\"#1b1b1b\" opacity=\".14\" d=\"M{left} {y:.1}h{width}\"/>"
        );
        svg += &tick([left, y], [-5.0, 0.0]);
        svg += &text([left - 9.0, y + 4.5], "end", &label);
    }
    for quarter in 0..5 {
        let place = 0.5 * f64::from(quarter) - 1.0;
        let x = left + 0.25 * width * f64::from(quarter);
        svg += &tick([x, bottom], [0.0, 5.0]);
        svg += &text(
            [x, bottom + 20.0],
            "middle",
            &rounded(field.radius() * place, 4),
        );
    }
    svg + &text(
        [left + 0.5 * width, bottom + 42.0],
        "middle",
        "distance from the centre, m",
    )
}

/// σ_zz along an axis from rim to rim: places in radii and values.
pub(super) fn profile(field: &DiscField, axis: [f64; 2]) -> impl Iterator<Item = [f64; 2]> + '_ {
    (0..=POINTS).map(move |index| {
        // The ends themselves may be the points of forces.
        let place = 0.999 * (2.0 * f64::from(index) / f64::from(POINTS) - 1.0);
        [place, compression(field, axis.map(|part| place * part))]
    })
}

/// Of σ_zz over the disc, the control square of side R and the cell of side 2R, compression positive.
pub(super) fn averages(field: &DiscField) -> [f64; 3] {
    let radius = field.radius();
    let square = field.average_over_square(radius);
    [
        -field.contact_average()[1][1],
        square.map_or(f64::NAN, |stress| -stress[1][1]),
        -field.average_over_cell(2.0 * radius)[1][1],
    ]
}

/// What is drawn in the panel.
pub(super) fn panel_key(field: &DiscField) -> String {
    let [disc, square, cell] = averages(field).map(|value| rounded(value, 4));
    let sample = |style: &str| format!("<path {style} d=\"M0 -4.5h24\"/>");
    let entries = [
        (sample(CURVES[0]), "along the vertical axis".to_owned()),
        (sample(CURVES[1]), "along the horizontal axis".to_owned()),
        (sample(AVERAGES[0]), format!("average, disc: {disc}")),
        (
            sample(AVERAGES[1]),
            format!("average, control square: {square}"),
        ),
        (
            sample(AVERAGES[2]),
            format!("average, cell of side 2R: {cell}"),
        ),
        (swatch(SHADE), "within the control square".to_owned()),
        (String::new(), "curves are cut beyond the scale".to_owned()),
    ];
    key(PANEL[1] + 16.0, &entries)
}
