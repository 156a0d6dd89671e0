//! Parts of drawings in SVG: axes with ticks, texts, lines.

use std::fmt::Write;

use crate::paper::short;

/// Ink of frames and texts.
pub const INK: &str = "#1b1b1b";
/// Of what is drawn first: see [`crate::report::chart::BLUE`].
pub const BLUE: &str = "#0072b2";
/// See [`BLUE`].
pub const VERMILION: &str = "#d55e00";
/// See [`BLUE`].
pub const GREEN: &str = "#009e73";

/// A rectangle of a drawing: left, top, width, height.
pub type Area = [f64; 4];

/// From values to places along one side of an area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// Value at `from`.
    pub low: f64,
    /// Value at `to`.
    pub high: f64,
    /// Place of `low`.
    pub from: f64,
    /// Place of `high`.
    pub to: f64,
    /// Powers of ten are evenly apart.
    pub logarithmic: bool,
}

impl Axis {
    /// Along the floor of an area.
    pub fn across([left, _, width, _]: Area, low: f64, high: f64) -> Self {
        Axis {
            low,
            high,
            from: left,
            to: left + width,
            logarithmic: false,
        }
    }

    /// Upwards along the left side of an area.
    pub fn upwards([_, top, _, height]: Area, low: f64, high: f64) -> Self {
        Axis {
            low,
            high,
            from: top + height,
            to: top,
            logarithmic: false,
        }
    }

    /// The same axis with powers of ten evenly apart.
    pub fn logarithmic(self) -> Self {
        Axis {
            logarithmic: true,
            ..self
        }
    }

    /// Where a value is; values beyond the ends are at the ends.
    pub fn place(&self, value: f64) -> f64 {
        let value = value.clamp(self.low, self.high);
        let share = if self.logarithmic {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        self.from + share * (self.to - self.from)
    }

    /// About `most` round values: multiples of 1, 2 or 5 times a power of ten, or powers of ten.
    pub fn ticks(&self, most: f64) -> Vec<f64> {
        if self.logarithmic {
            let powers = (self.low.log10().ceil() as i32)..=(self.high.log10().floor() as i32);
            return powers.map(|power| 10f64.powi(power)).collect();
        }
        let step = round_step((self.high - self.low) / most);
        let first = (self.low / step - 1e-9).ceil() as i64;
        let last = (self.high / step + 1e-9).floor() as i64;
        (first..=last).map(|index| step * index as f64).collect()
    }
}

/// 1, 2 or 5 times a power of ten, at least `least`; 1 if that is not above zero.
pub fn round_step(least: f64) -> f64 {
    if !(least > 0.0 && least.is_finite()) {
        return 1.0;
    }
    let power = 10f64.powf(least.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|f| f * power >= least);
    factor.unwrap_or(10.0) * power
}

/// A number with a minus sign for print.
pub fn printed(value: f64) -> String {
    short(value).replace('-', "−")
}

/// A text at a place; `anchor` is `start`, `middle` or `end`. Signs of the markup are replaced.
pub fn text([x, y]: [f64; 2], anchor: &str, content: &str) -> String {
    let content = content
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;");
    format!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{content}</text>\n")
}

/// The data of a path through these places.
pub fn line(places: impl Iterator<Item = [f64; 2]>) -> String {
    let mut path = String::new();
    for (index, [x, y]) in places.enumerate() {
        // Places after the first are lines; writing to a string cannot fail.
        let _ = write!(path, "{}{x:.1} {y:.1}", if index == 0 { "M" } else { " " });
    }
    path
}

/// The border of an area, with ticks and labels on its floor and left side.
pub fn border(area: Area, x: &Axis, y: &Axis, [across, upwards]: [&str; 2]) -> String {
    let [left, top, width, height] = area;
    let floor = top + height;
    let mut svg = format!(
        "<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" fill=\"none\" stroke=\"{INK}\"/>\n"
    );
    for tick in x.ticks(width / 55.0) {
        let at = x.place(tick);
        let _ = write!(svg, "<path stroke=\"{INK}\" d=\"M{at:.1} {floor}v5\"/>");
        svg += &text([at, floor + 18.0], "middle", &printed(tick));
    }
    for tick in y.ticks(height / 32.0) {
        let at = y.place(tick);
        let _ = write!(svg, "<path stroke=\"{INK}\" d=\"M{left} {at:.1}h-5\"/>");
        svg += &text([left - 8.0, at + 4.5], "end", &printed(tick));
    }
    svg += &text([left + 0.5 * width, floor + 36.0], "middle", across);
    if !upwards.is_empty() {
        let _ = write!(
            svg,
            "<g transform=\"translate({:.1} {:.1}) rotate(-90)\">{}</g>",
            left - 46.0,
            top + 0.5 * height,
            text([0.0, 0.0], "middle", upwards)
        );
    }
    svg
}

/// A whole drawing of this size that needs nothing else.
pub fn whole([width, height]: [f64; 2], label: &str, contents: &str) -> String {
    let label = label.replace(['<', '>', '&', '"'], " ");
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{label}\" \
         font-family=\"'DejaVu Sans', system-ui, sans-serif\" font-size=\"13\" fill=\"{INK}\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n{contents}</svg>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within() {
        let axis = Axis::across([0.0, 0.0, 100.0, 10.0], -0.3, 1.0);
        assert_eq!(
            axis.ticks(7.0),
            [-0.2, 0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0]
        );
        let powers = Axis::upwards([0.0, 0.0, 10.0, 90.0], 1e-3, 1.0).logarithmic();
        assert_eq!(powers.ticks(3.0), [1e-3, 1e-2, 1e-1, 1.0]);
        assert!((powers.place(1e-1) - 30.0).abs() < 1e-9);
        assert_eq!(axis.place(7.0), 100.0);
    }

    #[test]
    fn steps_are_round() {
        assert_eq!(round_step(0.085), 0.1);
        assert_eq!(round_step(1.3), 2.0);
        assert_eq!(round_step(400.0), 500.0);
        assert_eq!(round_step(0.0), 1.0);
    }
}
