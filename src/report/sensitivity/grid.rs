//! The main picture: for each published figure a map of punch speed and damping.

use std::fmt::Write;

use super::words::{class, in_unit};
use crate::study::sensitivity::choices::Axis;
use crate::study::sensitivity::record::{Point, Sensitivity};

const CELL: [f64; 2] = [48.0, 24.0];
const LEFT: f64 = 50.0;
const HEAD: f64 = 26.0;
const FOOT: f64 = 40.0;
const GAP: f64 = 14.0;
/// What the longest title takes, its beginning included.
const TITLE: f64 = 370.0;
const LEGEND: f64 = 30.0;
const ACROSS: usize = 3;

/// What a panel shows in a cell: class of the style, words.
type Cell = (String, String);

/// The picture as an SVG element; empty where no speeds were crossed with damping.
pub fn svg(record: &Sensitivity) -> String {
    let points: Vec<&Point> = record
        .points
        .iter()
        .filter(|point| point.setting.axis == Axis::SpeedAndDamping)
        .collect();
    let speeds = places(points.iter().map(|point| Some(point.setting.at)));
    let alphas = places(points.iter().map(|point| point.setting.beside));
    if points.is_empty() {
        return String::new();
    }
    let mut panels: Vec<(String, Vec<Option<Cell>>)> = Vec::new();
    let cells = |cell: &dyn Fn(&Point) -> Cell| -> Vec<Option<Cell>> {
        let at = |alpha: f64, speed: f64| {
            points
                .iter()
                .find(|point| point.setting.at == speed && point.setting.beside == Some(alpha))
                .map(|point| cell(point))
        };
        alphas
            .iter()
            .rev()
            .flat_map(|alpha| speeds.iter().map(move |speed| (*alpha, *speed)))
            .map(|(alpha, speed)| at(alpha, speed))
            .collect()
    };
    for (index, figure) in record.figures.iter().enumerate() {
        let title = format!(
            "{}: {} ± {}",
            figure.title,
            in_unit(figure.value, figure.unit),
            super::words::with_unit(figure.tolerance, figure.unit)
        );
        panels.push((
            title,
            cells(&|point| {
                let judged = &point.figures[index];
                let value = judged
                    .value
                    .map_or("–".to_owned(), |of| in_unit(of.estimate, figure.unit));
                let flag = if judged.conditional { "*" } else { "" };
                (class(judged).to_owned(), format!("{value}{flag}"))
            }),
        ));
    }
    panels.push((
        "share of punches that got the force".to_owned(),
        cells(&|point| {
            let shade = match point.reached {
                share if share >= 0.9 => "r3",
                share if share >= 0.5 => "r2",
                share if share > 0.0 => "r1",
                _ => "r0",
            };
            (shade.to_owned(), format!("{:.0} %", 100.0 * point.reached))
        }),
    ));
    draw(&panels, &speeds, &alphas)
}

fn draw(panels: &[(String, Vec<Option<Cell>>)], speeds: &[f64], alphas: &[f64]) -> String {
    let width = (LEFT + CELL[0] * speeds.len() as f64).max(TITLE) + GAP;
    let height = HEAD + CELL[1] * alphas.len() as f64 + FOOT;
    let rows = panels.len().div_ceil(ACROSS);
    let size = [width * ACROSS as f64, LEGEND + height * rows as f64];
    let mut svg = format!(
        "<svg class=\"map\" viewBox=\"0 0 {:.0} {:.0}\" role=\"img\" xmlns=\"http://www.w3.org/2000/svg\"><style>{}</style>",
        size[0],
        size[1],
        super::words::STYLE
    );
    // Writing to a string does not fail.
    let _ = legend(&mut svg);
    for (index, (title, cells)) in panels.iter().enumerate() {
        let x = width * (index % ACROSS) as f64;
        let y = LEGEND + height * (index / ACROSS) as f64;
        let _ = panel(&mut svg, [x, y], title, cells, speeds, alphas);
    }
    svg + "</svg>"
}

fn panel(
    svg: &mut String,
    [x, y]: [f64; 2],
    title: &str,
    cells: &[Option<Cell>],
    speeds: &[f64],
    alphas: &[f64],
) -> std::fmt::Result {
    let (left, top) = (x + LEFT, y + HEAD);
    write!(
        svg,
        "<text class=\"title\" x=\"{left}\" y=\"{:.1}\">{title}</text>",
        top - 9.0
    )?;
    for (row, alpha) in alphas.iter().rev().enumerate() {
        let middle = top + CELL[1] * (row as f64 + 0.5) + 4.0;
        write!(
            svg,
            "<text x=\"{:.1}\" y=\"{middle:.1}\" text-anchor=\"end\">{alpha}</text>",
            left - 6.0
        )?;
    }
    let bottom = top + CELL[1] * alphas.len() as f64;
    for (column, speed) in speeds.iter().enumerate() {
        let middle = left + CELL[0] * (column as f64 + 0.5);
        write!(
            svg,
            "<text x=\"{middle:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{speed}</text>",
            bottom + 14.0
        )?;
    }
    write!(
        svg,
        "<text class=\"axis\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">punch speed, m/s</text>",
        left + 0.5 * CELL[0] * speeds.len() as f64,
        bottom + 29.0
    )?;
    write!(
        svg,
        "<text class=\"axis\" transform=\"translate({:.1} {:.1}) rotate(-90)\" text-anchor=\"middle\">damping α</text>",
        x + 15.0,
        0.5 * (top + bottom)
    )?;
    for (index, cell) in cells.iter().enumerate() {
        let Some((class, words)) = cell else { continue };
        let cell_x = left + CELL[0] * (index % speeds.len()) as f64;
        let cell_y = top + CELL[1] * (index / speeds.len()) as f64;
        write!(
            svg,
            "<rect class=\"{class}\" x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>",
            cell_x + 0.5,
            cell_y + 0.5,
            CELL[0] - 1.0,
            CELL[1] - 1.0
        )?;
        write!(
            svg,
            "<text class=\"{class}\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{words}</text>",
            cell_x + 0.5 * CELL[0],
            cell_y + 0.5 * CELL[1] + 4.0
        )?;
    }
    Ok(())
}

fn legend(svg: &mut String) -> std::fmt::Result {
    let mut x = LEFT;
    for (class, words) in super::words::LEGEND {
        write!(
            svg,
            "<rect class=\"{class}\" x=\"{x}\" y=\"6\" width=\"16\" height=\"14\"/><text x=\"{}\" y=\"17.5\">{words}</text>",
            x + 21.0
        )?;
        x += 36.0 + 6.6 * words.chars().count() as f64;
    }
    write!(
        svg,
        "<text x=\"{x}\" y=\"17.5\">* fewer than 90 % of the punches got the force</text>"
    )
}

/// Every place once, in order.
fn places(all: impl Iterator<Item = Option<f64>>) -> Vec<f64> {
    let mut places: Vec<f64> = all.flatten().collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    places
}
