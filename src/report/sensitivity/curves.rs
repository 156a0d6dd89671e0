//! Lines with intervals, each named at its right end.

use std::fmt::Write;

use crate::report::axis::{Area, Axis};
use crate::report::frame::{BLUE, GREEN, INK, OCHRE, PURPLE, SKY, VERMILION, coloured, whole};
use crate::report::plot::{Plot, Stroke};

/// A line of the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// At its right end.
    pub name: String,
    /// Of line and name.
    pub colour: &'static str,
    /// Dashes for what was not measured.
    pub dashed: bool,
    /// x, and y with its lower and upper end.
    pub points: Vec<(f64, [f64; 3])>,
}

/// The picture; the vertical axis is logarithmic.
#[derive(Debug, Clone, PartialEq)]
pub struct Curves {
    /// Label of the horizontal axis.
    pub x: String,
    /// Label of the vertical axis.
    pub y: String,
    /// Whether the horizontal axis is logarithmic.
    pub logarithmic: bool,
    /// Of the vertical axis; what is lower is drawn at its foot.
    pub lowest: f64,
    /// In order of drawing.
    pub lines: Vec<Line>,
}

const SIZE: [f64; 2] = [744.0, 410.0];
/// Room on the right is for names.
const AREA: Area = [66.0, 14.0, 454.0, 346.0];
const LINE: f64 = 15.0;

/// Okabe and Ito's colours, dark enough for thin lines.
pub const COLOURS: [&str; 7] = [BLUE, VERMILION, GREEN, PURPLE, SKY, OCHRE, INK];

/// The least and the largest.
fn ends(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let start = [f64::MAX, f64::MIN];
    values.fold(start, |[least, most], value| {
        [least.min(value), most.max(value)]
    })
}

impl Curves {
    /// The picture as an SVG element; empty without points that lie apart.
    pub fn svg(&self) -> String {
        let points = || self.lines.iter().flat_map(|line| &line.points);
        if points().next().is_none() {
            return String::new();
        }
        let low = (0.8 * ends(points().map(|point| point.1[0]))[0]).max(self.lowest);
        let high = 1.3 * ends(points().map(|point| point.1[2]))[1];
        let across = ends(points().map(|point| point.0));
        let from = if self.logarithmic { across[0] } else { 0.0 };
        if across[1].is_nan() || across[1] <= from {
            return String::new();
        }
        // What stands at the ends is not cut.
        let x = if self.logarithmic {
            Axis::across(AREA, from / 1.1, 1.1 * across[1]).logarithmic()
        } else {
            Axis::across(AREA, from, 1.01 * across[1])
        };
        let y = Axis::upwards(AREA, low, high).logarithmic();
        let mut plot = Plot::with_grid(AREA, x, y);
        let shown = |value: f64| value.clamp(low, high);
        for line in &self.lines {
            let stroke = if line.dashed {
                Stroke::dashed(line.colour)
            } else {
                Stroke::whole(line.colour)
            };
            let points = line.points.iter();
            plot.line(points.map(|(at, value)| [*at, shown(value[0])]), stroke);
            for (at, [value, least, most]) in &line.points {
                if least < most {
                    plot.upright(*at, [shown(*least), shown(*most)], line.colour);
                    plot.dot([*at, shown(*value)], line.colour, 2.4, 1.0);
                }
            }
        }
        let drawn = plot.svg([&self.x, &self.y])
            + &self.names(|[at, value]| [x.place(at), y.place(shown(value))]);
        whole(SIZE, &self.y, &drawn)
    }

    /// In the order of the lines' ends, none on top of another.
    fn names(&self, place: impl Fn([f64; 2]) -> [f64; 2]) -> String {
        let mut names: Vec<([f64; 2], &Line)> = self
            .lines
            .iter()
            .filter_map(|line| {
                let (at, value) = line.points.last()?;
                Some((place([*at, value[0]]), line))
            })
            .collect();
        names.sort_by(|(a, _), (b, _)| a[1].total_cmp(&b[1]));
        let [left, top, width, height] = AREA;
        let right = left + width + 14.0;
        let most = top + height - LINE * (names.len() as f64 - 1.0);
        let (mut svg, mut free) = (String::new(), top + 6.0);
        for (index, ([from, end], line)) in names.iter().enumerate() {
            let at = end.max(free).min(most + LINE * index as f64);
            free = at + LINE;
            // Writing to a string does not fail.
            let _ = write!(
                svg,
                "<path stroke=\"{}\" opacity=\".5\" d=\"M{:.1} {end:.1}L{:.1} {at:.1}\"/>",
                line.colour,
                from + 2.0,
                right - 3.0
            );
            svg += &coloured(line.colour, [right, at + 4.0], "start", &line.name);
        }
        svg
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(points: &[(f64, [f64; 3])]) -> Curves {
        Curves {
            x: "x".to_owned(),
            y: "y".to_owned(),
            logarithmic: false,
            lowest: 0.1,
            lines: vec![Line {
                name: "one".to_owned(),
                colour: INK,
                dashed: false,
                points: points.to_vec(),
            }],
        }
    }

    #[test]
    fn nothing_apart_draws_nothing() {
        assert_eq!(line(&[]).svg(), "");
        for nowhere in [0.0, -1.0, f64::NAN] {
            assert_eq!(line(&[(nowhere, [1.0; 3])]).svg(), "", "{nowhere}");
        }
        let drawn = line(&[(0.0, [1.0; 3]), (10.0, [2.0, 1.0, 3.0])]).svg();
        assert!(drawn.contains(">one<") && !drawn.contains("NaN"), "{drawn}");
    }
}
