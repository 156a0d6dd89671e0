//! Numbered points with intervals on two logarithmic axes.

use std::f64::consts::TAU;
use std::fmt::Write;

use crate::error::Error;
use crate::report::axis::{Area, Axis};
use crate::report::figure::cells;
use crate::report::figure_files::table;
use crate::report::frame::{border, grid, text, whole};

/// A point of the chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Dot<'a> {
    /// What is written beside it.
    pub number: usize,
    /// In the table.
    pub name: &'a str,
    /// On the horizontal axis, above zero.
    pub x: f64,
    /// On the vertical axis, with the ends of its interval.
    pub y: [f64; 3],
    /// Class of its style: `exact`, `free`, `other`.
    pub class: &'static str,
    /// Drawn hollow.
    pub dominated: bool,
}

/// The chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Scatter<'a> {
    /// Label of the horizontal axis.
    pub x: String,
    /// Label of the vertical axis.
    pub y: String,
    /// Horizontal lines, each with its words.
    pub lines: Vec<(f64, String)>,
    /// In any order.
    pub dots: Vec<Dot<'a>>,
}

const SIZE: [f64; 2] = [720.0, 490.0];
const AREA: Area = [66.0, 14.0, 640.0, 426.0];
const DOT: f64 = 4.0;
/// The drawing's own, so that its file needs no page.
const STYLE: &str = ".scatter .level { stroke: #8a5a00; stroke-dasharray: 5 4; fill: none; } .scatter .words { fill: #8a5a00; } \
    .scatter .bar { stroke: #b9bec4; stroke-width: 1; } .scatter .lead { stroke: #9aa0a6; stroke-width: .8; } \
    .scatter .number { font-size: 11px; } .scatter circle { stroke-width: 1.6; } \
    .scatter .exact { fill: #0072b2; stroke: #0072b2; } .scatter .free { fill: #d55e00; stroke: #d55e00; } \
    .scatter .other { fill: #009e73; stroke: #009e73; } .scatter .hollow { fill: #fff; }";
/// Half the width and height of a number of two digits.
const LABEL: [f64; 2] = [8.0, 6.0];

impl Scatter<'_> {
    /// The chart as an SVG element; empty where there are no points.
    pub fn svg(&self) -> String {
        let dots: Vec<&Dot<'_>> = self.dots.iter().filter(|dot| dot.x > 0.0).collect();
        let (Some(xs), Some(ys)) = (
            range(dots.iter().map(|dot| dot.x)),
            range(dots.iter().map(|dot| dot.y[0].max(LOWEST))),
        ) else {
            return String::new();
        };
        let low = (0.7 * ys[0]).clamp(LOWEST, 0.5);
        let x = Axis::across(AREA, 0.8 * xs[0], 1.25 * xs[1]).logarithmic();
        let y = Axis::upwards(AREA, low, (1.6 * ys[1]).max(2.0)).logarithmic();
        let mut svg = grid(AREA, &x, &y);
        let words = self.levels(&mut svg, &y);
        // Writing to a string does not fail.
        let _ = points(&mut svg, &dots, &x, &y, &words);
        svg += &border(AREA, &x, &y, [&self.x, &self.y]);
        let contents = format!("<style>{STYLE}</style><g class=\"scatter\">{svg}</g>");
        whole(SIZE, &self.y, &contents)
    }

    /// The points as rows.
    pub fn csv(&self) -> Result<String, Error> {
        let head = [
            "number",
            "method",
            &self.x,
            &self.y,
            "lower end, 95 %",
            "upper end, 95 %",
            "dominated",
        ];
        let rows = self.dots.iter().map(|dot| {
            let mut row = vec![dot.number.to_string(), dot.name.to_owned()];
            row.extend(cells([dot.x, dot.y[0], dot.y[1], dot.y[2]]));
            row.push(dot.dominated.to_string());
            row
        });
        table(&head, rows)
    }

    /// Adds the lines with their words; the value is the words' boxes, from left to right and from top to bottom.
    fn levels(&self, svg: &mut String, y: &Axis) -> Vec<[f64; 4]> {
        let [left, right] = [AREA[0], AREA[0] + AREA[2]];
        // One at the left, the next at the right: lines may lie close together.
        let sides = ["start", "end"].into_iter().cycle();
        let shown = |(value, _): &&(f64, String)| *value >= y.low && *value <= y.high;
        let lines = self.lines.iter().filter(shown).zip(sides);
        lines
            .map(|((value, words), side)| {
                let at = y.place(*value);
                let length = 7.5 * words.chars().count() as f64;
                let (x, from) = if side == "start" {
                    (left + 4.0, left)
                } else {
                    (right - 4.0, right - length)
                };
                *svg += &format!(
                    "<path class=\"level\" d=\"M{left} {at:.1}H{right}\"/><g class=\"words\">{}</g>",
                    text([x, at - 5.0], side, words)
                );
                [from, from + length, at - 17.0, at]
            })
            .collect()
    }
}

/// Errors below this are drawn there: no margin is known that well.
const LOWEST: f64 = 0.02;

fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let mut range: Option<[f64; 2]> = None;
    for value in values {
        let [low, high] = range.unwrap_or([value, value]);
        range = Some([low.min(value), high.max(value)]);
    }
    range
}

/// Dots, bars and numbers; the numbers keep out of `words`, boxes from left to right and from top to bottom.
fn points(
    svg: &mut String,
    dots: &[&Dot<'_>],
    x: &Axis,
    y: &Axis,
    words: &[[f64; 4]],
) -> std::fmt::Result {
    let places: Vec<[f64; 2]> = dots
        .iter()
        .map(|dot| [x.place(dot.x), y.place_within(dot.y[0])])
        .collect();
    for (dot, [at, _]) in dots.iter().zip(&places) {
        let [low, high] = [dot.y[1], dot.y[2]].map(|value| y.place_within(value));
        write!(
            svg,
            "<path class=\"bar\" d=\"M{at:.1} {low:.1}V{high:.1}\"/>"
        )?;
    }
    for (dot, [at, height]) in dots.iter().zip(&places) {
        let hollow = if dot.dominated { " hollow" } else { "" };
        write!(
            svg,
            "<circle class=\"{}{hollow}\" cx=\"{at:.1}\" cy=\"{height:.1}\" r=\"{DOT}\"/>",
            dot.class
        )?;
    }
    for (dot, (place, label)) in dots.iter().zip(places.iter().zip(labels(&places, words))) {
        let [dx, dy] = [label[0] - place[0], label[1] - place[1]];
        if dx.hypot(dy) > 16.0 {
            // Ends at the rims of dot and number.
            let from = DOT / dx.hypot(dy);
            write!(
                svg,
                "<path class=\"lead\" d=\"M{:.1} {:.1}L{:.1} {:.1}\"/>",
                place[0] + from * dx,
                place[1] + from * dy,
                place[0] + 0.75 * dx,
                place[1] + 0.75 * dy
            )?;
        }
        write!(
            svg,
            "<text class=\"number\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            label[0],
            label[1] + 4.0,
            dot.number
        )?;
    }
    Ok(())
}

/// A place for each number, as near to its dot as nothing is in the way.
fn labels(places: &[[f64; 2]], words: &[[f64; 4]]) -> Vec<[f64; 2]> {
    let mut set: Vec<[f64; 2]> = Vec::new();
    for place in places {
        let ring = |turn: usize| {
            let (radius, angle) = (
                13.0 + 7.0 * (turn / 16) as f64,
                TAU * (turn % 16) as f64 / 16.0,
            );
            [
                place[0] + radius * angle.cos(),
                place[1] - radius * angle.sin(),
            ]
        };
        let free = |label: &[f64; 2]| {
            let [left, top, width, height] = AREA;
            let inside = label[0] > left + LABEL[0]
                && label[0] < left + width - LABEL[0]
                && label[1] > top + LABEL[1]
                && label[1] < top + height - LABEL[1];
            let off_dots = places.iter().all(|dot| {
                (dot[0] - label[0]).abs() > LABEL[0] + DOT
                    || (dot[1] - label[1]).abs() > LABEL[1] + DOT
            });
            let off_labels = set.iter().all(|other| {
                (other[0] - label[0]).abs() > 2.0 * LABEL[0]
                    || (other[1] - label[1]).abs() > 2.0 * LABEL[1]
            });
            let off_words = words.iter().all(|[left, right, top, floor]| {
                label[0] < left - LABEL[0]
                    || label[0] > right + LABEL[0]
                    || label[1] < top - LABEL[1]
                    || label[1] > floor + LABEL[1]
            });
            inside && off_dots && off_labels && off_words
        };
        let found = (0..16 * 12).map(ring).find(free).unwrap_or_else(|| ring(0));
        set.push(found);
    }
    set
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_clear_of_dots_and_of_each_other() {
        // Forty dots in a small corner.
        let places: Vec<[f64; 2]> = (0..40)
            .map(|k| {
                [
                    300.0 + 9.0 * f64::from(k % 8),
                    200.0 + 9.0 * f64::from(k / 8),
                ]
            })
            .collect();
        let labels = labels(&places, &[]);
        for (index, label) in labels.iter().enumerate() {
            for other in &labels[..index] {
                let apart = (label[0] - other[0]).abs() > 2.0 * LABEL[0]
                    || (label[1] - other[1]).abs() > 2.0 * LABEL[1];
                assert!(apart, "{label:?} {other:?}");
            }
            for dot in &places {
                let apart =
                    (label[0] - dot[0]).abs() > LABEL[0] || (label[1] - dot[1]).abs() > LABEL[1];
                assert!(apart, "{label:?} {dot:?}");
            }
        }
    }
}
