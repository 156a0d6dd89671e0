//! Lines with intervals, each named at its right end.

use std::fmt::Write;

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

const SIZE: [f64; 2] = [720.0, 400.0];
const LEFT: f64 = 62.0;
const RIGHT: f64 = 190.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 46.0;
const LINE: f64 = 15.0;

/// Okabe and Ito's colours, dark enough for thin lines.
pub const COLOURS: [&str; 7] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#b8860b", "#1b1b1b",
];

/// The least and the largest.
fn ends(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let start = [f64::MAX, f64::MIN];
    values.fold(start, |[least, most], value| {
        [least.min(value), most.max(value)]
    })
}

impl Curves {
    /// The picture as an SVG element; empty without two places.
    pub fn svg(&self) -> String {
        let points = || self.lines.iter().flat_map(|line| &line.points);
        if points().next().is_none() {
            return String::new();
        }
        let low = (0.8 * ends(points().map(|point| point.1[0]))[0]).max(self.lowest);
        let high = 1.3 * ends(points().map(|point| point.1[2]))[1];
        let across = ends(points().map(|point| point.0));
        let from = if self.logarithmic { across[0] } else { 0.0 };
        if across[1] <= from {
            return String::new();
        }
        let x = |value: f64| {
            let share = if self.logarithmic {
                (value / from).ln() / (across[1] / from).ln()
            } else {
                (value - from) / (across[1] - from)
            };
            LEFT + share * (SIZE[0] - LEFT - RIGHT)
        };
        let y = |value: f64| {
            let share = (value.clamp(low, high) / low).ln() / (high / low).ln();
            SIZE[1] - BOTTOM - share * (SIZE[1] - BOTTOM - TOP)
        };
        let mut svg = format!(
            "<svg class=\"map\" viewBox=\"0 0 {} {}\" role=\"img\" xmlns=\"http://www.w3.org/2000/svg\"><style>{}</style>",
            SIZE[0],
            SIZE[1],
            super::words::STYLE
        );
        // Writing to a string does not fail.
        let _ = self.frame(&mut svg, [low, high], [from, across[1]], &x, &y);
        let _ = self.draw(&mut svg, &x, &y);
        svg + "</svg>"
    }

    fn frame(
        &self,
        svg: &mut String,
        [low, high]: [f64; 2],
        [from, to]: [f64; 2],
        x: &dyn Fn(f64) -> f64,
        y: &dyn Fn(f64) -> f64,
    ) -> std::fmt::Result {
        let (right, floor) = (SIZE[0] - RIGHT, SIZE[1] - BOTTOM);
        for tick in decades(low, high) {
            let at = y(tick);
            write!(svg, "<path class=\"grid\" d=\"M{LEFT} {at:.1}H{right}\"/>")?;
            write!(
                svg,
                "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                LEFT - 6.0,
                at + 4.0,
                plain(tick)
            )?;
        }
        let ticks = if self.logarithmic {
            let tens = decades(from, to).into_iter();
            tens.filter(|tick| (tick.log10() - tick.log10().round()).abs() < 1.0e-9)
                .collect()
        } else {
            steps(to)
        };
        for tick in ticks {
            let at = x(tick);
            write!(svg, "<path class=\"grid\" d=\"M{at:.1} {TOP}V{floor}\"/>")?;
            write!(
                svg,
                "<text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                floor + 16.0,
                plain(tick)
            )?;
        }
        write!(
            svg,
            "<text class=\"axis\" x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            0.5 * (LEFT + right),
            SIZE[1] - 8.0,
            self.x
        )?;
        write!(
            svg,
            "<text class=\"axis\" transform=\"translate(15 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            0.5 * (TOP + floor),
            self.y
        )
    }

    fn draw(
        &self,
        svg: &mut String,
        x: &dyn Fn(f64) -> f64,
        y: &dyn Fn(f64) -> f64,
    ) -> std::fmt::Result {
        for line in &self.lines {
            let path: Vec<String> = line
                .points
                .iter()
                .map(|(at, value)| format!("{:.1} {:.1}", x(*at), y(value[0])))
                .collect();
            let dashes = if line.dashed {
                " stroke-dasharray=\"6 4\""
            } else {
                ""
            };
            let colour = line.colour;
            write!(
                svg,
                "<path class=\"curve\" stroke=\"{colour}\"{dashes} d=\"M{}\"/>",
                path.join("L")
            )?;
            for (at, [value, low, high]) in &line.points {
                if low < high {
                    write!(
                        svg,
                        "<path class=\"whisker\" stroke=\"{colour}\" d=\"M{at:.1} {:.1}V{:.1}\"/><circle fill=\"{colour}\" cx=\"{at:.1}\" cy=\"{:.1}\" r=\"2.4\"/>",
                        y(*low),
                        y(*high),
                        y(*value),
                        at = x(*at),
                    )?;
                }
            }
        }
        // Names in the order of the lines' ends, none on top of another.
        let mut names: Vec<(f64, f64, &Line)> = self
            .lines
            .iter()
            .filter_map(|line| {
                let (at, value) = line.points.last()?;
                Some((y(value[0]), x(*at), line))
            })
            .collect();
        names.sort_by(|a, b| a.0.total_cmp(&b.0));
        let right = SIZE[0] - RIGHT + 14.0;
        let most = SIZE[1] - BOTTOM - LINE * (names.len() as f64 - 1.0);
        let mut free = TOP + 6.0;
        for (index, (end, from, line)) in names.iter().enumerate() {
            let at = end.max(free).min(most + LINE * index as f64);
            free = at + LINE;
            write!(
                svg,
                "<path class=\"whisker\" stroke=\"{}\" opacity=\".5\" d=\"M{:.1} {end:.1}L{:.1} {at:.1}\"/><text x=\"{right:.1}\" y=\"{:.1}\" style=\"fill:{}\">{}</text>",
                line.colour,
                from + 2.0,
                right - 3.0,
                at + 4.0,
                line.colour,
                line.name
            )?;
        }
        Ok(())
    }
}

/// 1, 2 and 5 times powers of ten.
fn decades(low: f64, high: f64) -> Vec<f64> {
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    (first..=last)
        .flat_map(|power| [1.0, 2.0, 5.0].map(|of| of * 10f64.powi(power)))
        .filter(|tick| (low..=high).contains(tick))
        .collect()
}

/// About five even steps from zero.
fn steps(to: f64) -> Vec<f64> {
    let rough = to / 5.0;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .map(|of| of * power)
        .into_iter()
        .find(|step| *step >= rough)
        .unwrap_or(rough);
    (0..)
        .map(|index| f64::from(index) * step)
        .take_while(|tick| *tick <= to * 1.001)
        .collect()
}

/// Without the noise of its last digits.
fn plain(tick: f64) -> String {
    format!("{}", (tick * 1.0e9).round() / 1.0e9)
}
