//! One choice at a time: each setting a row, each published figure a column, ours over published.

use std::fmt::Write;

use super::words::class;
use crate::study::sensitivity::choices::Axis;
use crate::study::sensitivity::record::{Point, Sensitivity};

const LEFT: f64 = 396.0;
const COLUMN: f64 = 128.0;
const GAP: f64 = 10.0;
const ROW: f64 = 15.0;
const TOP: f64 = 44.0;
/// Ours over published.
const RANGE: [f64; 2] = [0.0, 2.0];
/// Heights and porosities differ by little.
const NARROW: [f64; 2] = [0.8, 1.2];
/// The columns, by id.
const SHOWN: [&str; 7] = [
    "height",
    "porosity",
    "stress.O",
    "stress.A",
    "stress.B",
    "variation.O",
    "variation.B",
];

/// The picture as an SVG element.
pub fn svg(record: &Sensitivity) -> String {
    let groups: Vec<(Axis, Vec<&Point>)> = Axis::ALL
        .into_iter()
        .filter(|axis| *axis != Axis::SpeedAndDamping)
        .map(|axis| {
            let own = record.points.iter();
            (
                axis,
                own.filter(|point| point.setting.axis == axis).collect(),
            )
        })
        .filter(|(_, own): &(Axis, Vec<&Point>)| !own.is_empty())
        .collect();
    let columns: Vec<usize> = SHOWN
        .iter()
        .filter_map(|id| record.figures.iter().position(|figure| figure.id == *id))
        .collect();
    let rows: usize = groups.iter().map(|(_, own)| own.len() + 1).sum();
    let width = LEFT + COLUMN * columns.len() as f64;
    let height = TOP + ROW * rows as f64 + 30.0;
    let mut svg = format!(
        "<svg class=\"map\" viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\" xmlns=\"http://www.w3.org/2000/svg\"><style>{}</style>",
        super::words::STYLE
    );
    // Writing to a string does not fail.
    let _ = frame(&mut svg, record, &columns, height);
    let mut y = TOP;
    for (axis, own) in &groups {
        let _ = write!(
            svg,
            "<text class=\"title\" x=\"4\" y=\"{:.1}\">{}</text>",
            y + 11.5,
            axis.title()
        );
        y += ROW;
        for point in own {
            let _ = row(&mut svg, point, &columns, record, y);
            y += ROW;
        }
    }
    svg + "</svg>"
}

fn range(id: &str) -> [f64; 2] {
    if matches!(id, "height" | "porosity") {
        NARROW
    } else {
        RANGE
    }
}

/// Place of a ratio in a column, and whether it lies beyond the column.
fn place(column: usize, [low, high]: [f64; 2], ratio: f64) -> (f64, bool) {
    let share = (ratio - low) / (high - low);
    let x = LEFT + COLUMN * column as f64 + share.clamp(0.0, 1.0) * (COLUMN - GAP);
    (x, !(0.0..=1.0).contains(&share))
}

fn frame(
    svg: &mut String,
    record: &Sensitivity,
    columns: &[usize],
    height: f64,
) -> std::fmt::Result {
    let floor = height - 26.0;
    for (column, index) in columns.iter().enumerate() {
        let figure = &record.figures[*index];
        let range = range(figure.id);
        let tolerance = figure.tolerance / figure.value;
        let [from, to] = [1.0 - tolerance, 1.0 + tolerance].map(|of| place(column, range, of).0);
        let (one, _) = place(column, range, 1.0);
        write!(
            svg,
            "<rect class=\"band\" x=\"{from:.1}\" y=\"{TOP}\" width=\"{:.1}\" height=\"{:.1}\"/>",
            to - from,
            floor - TOP
        )?;
        write!(svg, "<path class=\"one\" d=\"M{one:.1} {TOP}V{floor}\"/>")?;
        let name = figure
            .title
            .replace("coefficient of variation of", "CV,")
            .replace(", mean surface", "")
            .replace(", from the mean surface", "");
        write!(
            svg,
            "<text class=\"title\" x=\"{one:.1}\" y=\"16\" text-anchor=\"middle\">{name}</text>"
        )?;
        write!(
            svg,
            "<text class=\"axis\" x=\"{one:.1}\" y=\"32\" text-anchor=\"middle\">{}</text>",
            super::words::with_unit(figure.value, figure.unit)
        )?;
        // The ends' words stay in their own column.
        for (tick, anchor) in [(range[0], "start"), (1.0, "middle"), (range[1], "end")] {
            let (x, _) = place(column, range, tick);
            write!(
                svg,
                "<text class=\"axis\" x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{tick}</text>",
                floor + 14.0
            )?;
        }
    }
    write!(
        svg,
        "<text class=\"axis\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">ours over published</text>",
        LEFT - 16.0,
        floor + 14.0
    )
}

fn row(
    svg: &mut String,
    point: &Point,
    columns: &[usize],
    record: &Sensitivity,
    y: f64,
) -> std::fmt::Result {
    let middle = y + 0.5 * ROW;
    write!(
        svg,
        "<text x=\"14\" y=\"{:.1}\">{}</text>",
        y + 11.5,
        point.setting.name
    )?;
    if point.reached < 1.0 {
        write!(
            svg,
            "<text class=\"axis\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{} of {}</text>",
            LEFT - 8.0,
            y + 11.5,
            point.endings.reached,
            point.endings.all()
        )?;
    }
    write!(
        svg,
        "<path class=\"grid\" d=\"M14 {:.1}H{:.1}\"/>",
        y + ROW,
        LEFT + COLUMN * columns.len() as f64 - GAP
    )?;
    for (column, index) in columns.iter().enumerate() {
        let (figure, judged) = (&record.figures[*index], &point.figures[*index]);
        let Some(value) = judged.value else { continue };
        let range = range(figure.id);
        let ours = value.over(figure.value);
        let [(at, beyond), (low, _), (high, _)] =
            [ours.estimate, ours.low, ours.high].map(|of| place(column, range, of));
        let class = class(judged);
        write!(
            svg,
            "<line class=\"{class}\" x1=\"{low:.1}\" x2=\"{high:.1}\" y1=\"{middle:.1}\" y2=\"{middle:.1}\" stroke-width=\"1.4\"/>"
        )?;
        if beyond {
            // Too far off to be shown at its place.
            let back = if ours.estimate > range[1] { -6.0 } else { 6.0 };
            write!(
                svg,
                "<path class=\"tip\" fill=\"#d55e00\" d=\"M{at:.1} {middle:.1}l{back} -4v8z\"/>"
            )?;
        } else {
            let hollow = if judged.conditional {
                " style=\"fill:#fff\""
            } else {
                ""
            };
            write!(
                svg,
                "<circle class=\"{class}\" cx=\"{at:.1}\" cy=\"{middle:.1}\" r=\"3.2\" stroke-width=\"1.4\"{hollow}/>"
            )?;
        }
    }
    Ok(())
}
