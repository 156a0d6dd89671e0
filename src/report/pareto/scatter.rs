//! Numbered points with intervals on two logarithmic axes.

use std::f64::consts::TAU;
use std::fmt::Write;

/// A point of the chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Dot {
    /// What is written beside it.
    pub number: usize,
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
pub struct Scatter {
    /// Label of the horizontal axis.
    pub x: String,
    /// Label of the vertical axis.
    pub y: String,
    /// Horizontal lines, each with its words.
    pub lines: Vec<(f64, String)>,
    /// In any order.
    pub dots: Vec<Dot>,
}

const SIZE: [f64; 2] = [720.0, 480.0];
const LEFT: f64 = 62.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 46.0;
const DOT: f64 = 4.0;
/// Half the width and height of a number of two digits.
const LABEL: [f64; 2] = [8.0, 6.0];

struct Axis {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Axis {
    fn place(&self, value: f64) -> f64 {
        let share =
            (value.clamp(self.low, self.high) / self.low).ln() / (self.high / self.low).ln();
        self.from + share * (self.to - self.from)
    }

    /// 1, 2 and 5 times powers of ten.
    fn ticks(&self) -> Vec<f64> {
        let (first, last) = (
            self.low.log10().floor() as i32,
            self.high.log10().ceil() as i32,
        );
        (first..=last)
            .flat_map(|power| [1.0, 2.0, 5.0].map(|of| of * 10f64.powi(power)))
            .filter(|tick| (self.low..=self.high).contains(tick))
            .collect()
    }
}

impl Scatter {
    /// The chart as an SVG element; empty where there are no points.
    pub fn svg(&self) -> String {
        let dots: Vec<&Dot> = self.dots.iter().filter(|dot| dot.x > 0.0).collect();
        let (Some(xs), Some(ys)) = (
            range(dots.iter().map(|dot| dot.x)),
            range(dots.iter().map(|dot| dot.y[0].max(LOWEST))),
        ) else {
            return String::new();
        };
        let x = Axis {
            low: 0.8 * xs[0],
            high: 1.25 * xs[1],
            from: LEFT,
            to: SIZE[0] - RIGHT,
        };
        let y = Axis {
            low: (0.7 * ys[0]).clamp(LOWEST, 0.5),
            high: (1.6 * ys[1]).max(2.0),
            from: SIZE[1] - BOTTOM,
            to: TOP,
        };
        let mut svg = format!(
            "<svg class=\"scatter\" viewBox=\"0 0 {} {}\" role=\"img\" xmlns=\"http://www.w3.org/2000/svg\">",
            SIZE[0], SIZE[1]
        );
        // Writing to a string does not fail.
        let _ = self.frame(&mut svg, &x, &y);
        let words: Vec<[f64; 4]> = self
            .lines
            .iter()
            .map(|(value, words)| {
                let at = y.place(*value);
                let length = 7.0 * words.chars().count() as f64;
                [LEFT, LEFT + length, at - 17.0, at]
            })
            .collect();
        let _ = points(&mut svg, &dots, &x, &y, &words);
        svg + "</svg>"
    }

    fn frame(&self, svg: &mut String, x: &Axis, y: &Axis) -> std::fmt::Result {
        let (right, floor) = (SIZE[0] - RIGHT, SIZE[1] - BOTTOM);
        for tick in x.ticks() {
            let at = x.place(tick);
            write!(svg, "<path class=\"grid\" d=\"M{at:.1} {TOP}V{floor}\"/>")?;
            write!(
                svg,
                "<text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{tick}</text>",
                floor + 16.0
            )?;
        }
        for tick in y.ticks() {
            let at = y.place(tick);
            write!(svg, "<path class=\"grid\" d=\"M{LEFT} {at:.1}H{right}\"/>")?;
            write!(
                svg,
                "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{tick}</text>",
                LEFT - 6.0,
                at + 4.0
            )?;
        }
        // One at the left, the next at the right: lines may lie close together.
        let ends = [(LEFT + 4.0, "start"), (right - 4.0, "end")];
        for ((value, words), (x, anchor)) in self.lines.iter().zip(ends.iter().cycle()) {
            if *value < y.low || *value > y.high {
                continue;
            }
            let at = y.place(*value);
            write!(svg, "<path class=\"level\" d=\"M{LEFT} {at:.1}H{right}\"/>")?;
            write!(
                svg,
                "<text class=\"words\" x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{words}</text>",
                at - 5.0
            )?;
        }
        write!(
            svg,
            "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            0.5 * (LEFT + right),
            SIZE[1] - 8.0,
            self.x
        )?;
        let middle = 0.5 * (TOP + floor);
        write!(
            svg,
            "<text transform=\"translate(15 {middle:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            self.y
        )
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
    dots: &[&Dot],
    x: &Axis,
    y: &Axis,
    words: &[[f64; 4]],
) -> std::fmt::Result {
    let places: Vec<[f64; 2]> = dots
        .iter()
        .map(|dot| [x.place(dot.x), y.place(dot.y[0])])
        .collect();
    for (dot, [at, _]) in dots.iter().zip(&places) {
        let (low, high) = (y.place(dot.y[1]), y.place(dot.y[2]));
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
            let inside = label[0] > LEFT + LABEL[0]
                && label[0] < SIZE[0] - RIGHT - LABEL[0]
                && label[1] > TOP + LABEL[1]
                && label[1] < SIZE[1] - BOTTOM - LABEL[1];
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
