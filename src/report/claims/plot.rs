//! Two axes and what is drawn between them, as an SVG element that needs no style sheet.

use std::fmt::Write;

/// Okabe and Ito's colours, as SVG writes them.
pub const BLUE: &str = "#0072b2";
/// See [`BLUE`].
pub const VERMILION: &str = "#d55e00";
/// See [`BLUE`].
pub const GREEN: &str = "#009e73";
/// See [`BLUE`].
pub const PURPLE: &str = "#cc79a7";
/// Of what was found where it is compared with laws.
pub const INK: &str = "#1b1b1b";
const SOFT: &str = "#5f6368";
const GRID: &str = "#e6e8ea";

/// One axis.
#[derive(Debug, Clone, Copy)]
pub struct Axis {
    /// Left or lower end.
    pub low: f64,
    /// Right or upper end.
    pub high: f64,
    /// Powers of ten.
    pub logarithmic: bool,
    from: f64,
    to: f64,
}

impl Axis {
    /// From `low` to `high`.
    pub fn new(low: f64, high: f64, logarithmic: bool) -> Self {
        Axis {
            low,
            high,
            logarithmic,
            from: 0.0,
            to: 1.0,
        }
    }

    fn place(&self, value: f64) -> f64 {
        let share = if self.logarithmic {
            (value.max(1.0e-300) / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        // A little beyond the ends is drawn, and cut off there.
        self.from + share.clamp(-0.5, 1.5) * (self.to - self.from)
    }

    /// About so many.
    fn ticks(&self, wanted: f64) -> Vec<f64> {
        if self.logarithmic {
            let (first, last) = (
                self.low.log10().floor() as i32,
                self.high.log10().ceil() as i32,
            );
            let steps: &[f64] = if f64::from(last - first) < 0.6 * wanted {
                &[1.0, 2.0, 5.0]
            } else {
                &[1.0]
            };
            let inside = |tick: &f64| *tick >= 0.999 * self.low && *tick <= 1.001 * self.high;
            return (first..=last)
                .flat_map(|power| steps.iter().map(move |of| of * 10f64.powi(power)))
                .filter(inside)
                .collect();
        }
        let rough = (self.high - self.low) / wanted;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|of| of * power);
        let step = step
            .into_iter()
            .find(|step| *step >= rough)
            .unwrap_or(10.0 * power);
        let (first, last) = (
            (self.low / step).ceil() as i64,
            (self.high / step).floor() as i64,
        );
        (first..=last).map(|tick| tick as f64 * step).collect()
    }
}

/// A picture in the making.
#[derive(Debug)]
pub struct Plot {
    svg: String,
    x: Axis,
    y: Axis,
    inner: bool,
}

/// Where a plot stands in its picture: left, top, right, bottom of its frame.
pub type Frame = [f64; 4];

/// Begins a picture of this size.
pub fn picture(width: f64, height: f64) -> String {
    format!(
        "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" xmlns=\"http://www.w3.org/2000/svg\" \
         font-family=\"system-ui, 'DejaVu Sans', sans-serif\" font-size=\"12\" fill=\"{INK}\">"
    )
}

impl Plot {
    /// Axes in a frame of the picture `svg`, with their labels; an inner plot has a white ground and small letters.
    pub fn new(
        svg: String,
        frame: Frame,
        x: Axis,
        y: Axis,
        labels: [&str; 2],
        inner: bool,
    ) -> Self {
        let [left, top, right, bottom] = frame;
        let x = Axis {
            from: left,
            to: right,
            ..x
        };
        let y = Axis {
            from: bottom,
            to: top,
            ..y
        };
        let mut plot = Plot { svg, x, y, inner };
        // Writing to a string does not fail.
        let _ = plot.frame(frame, labels);
        plot
    }

    fn frame(&mut self, [left, top, right, bottom]: Frame, labels: [&str; 2]) -> std::fmt::Result {
        let size = if self.inner { 9.5 } else { 12.0 };
        let (width, height) = (right - left, bottom - top);
        let wanted = [(width / 70.0).max(3.0), (height / 45.0).max(2.5)];
        let name = format!("c{:.0}-{:.0}-{:.0}", left, top, width);
        write!(
            self.svg,
            "<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\
             <clipPath id=\"{name}\"><rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"/></clipPath>"
        )?;
        for tick in self.x.ticks(wanted[0]) {
            let at = self.x.place(tick);
            write!(
                self.svg,
                "<path d=\"M{at:.1} {top}V{bottom}\" stroke=\"{GRID}\"/><text x=\"{at:.1}\" y=\"{:.1}\" font-size=\"{size}\" \
                 text-anchor=\"middle\">{}</text>",
                bottom + 1.25 * size,
                written(tick)
            )?;
        }
        for tick in self.y.ticks(wanted[1]) {
            let at = self.y.place(tick);
            write!(
                self.svg,
                "<path d=\"M{left} {at:.1}H{right}\" stroke=\"{GRID}\"/><text x=\"{:.1}\" y=\"{:.1}\" font-size=\"{size}\" \
                 text-anchor=\"end\">{}</text>",
                left - 4.0,
                at + 0.35 * size,
                written(tick)
            )?;
        }
        let middle = 0.5 * (top + bottom);
        let away = if self.inner { 30.0 } else { 48.0 };
        write!(
            self.svg,
            "<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" fill=\"none\" stroke=\"{SOFT}\" stroke-width=\".8\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" font-size=\"{size}\" text-anchor=\"middle\">{}</text>\
             <text transform=\"translate({:.1} {middle:.1}) rotate(-90)\" font-size=\"{size}\" text-anchor=\"middle\">{}</text>\
             <g clip-path=\"url(#{name})\">",
            0.5 * (left + right),
            bottom + 2.75 * size,
            labels[0],
            left - away,
            labels[1]
        )
    }

    /// A line through points; `dashes` is empty for a whole one.
    pub fn line(
        &mut self,
        points: impl IntoIterator<Item = (f64, f64)>,
        colour: &str,
        dashes: &str,
    ) {
        let mut path = String::new();
        for (x, y) in points
            .into_iter()
            .filter(|(x, y)| x.is_finite() && y.is_finite())
        {
            let pen = if path.is_empty() { 'M' } else { 'L' };
            let _ = write!(path, "{pen}{:.1} {:.1}", self.x.place(x), self.y.place(y));
        }
        let _ = write!(
            self.svg,
            "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.8\" stroke-dasharray=\"{dashes}\"/>"
        );
    }

    /// A function over the horizontal axis.
    pub fn curve(&mut self, of: impl Fn(f64) -> f64, colour: &str, dashes: &str) {
        const PIECES: usize = 200;
        let x = self.x;
        let at = |piece: usize| {
            let share = piece as f64 / PIECES as f64;
            if x.logarithmic {
                x.low * (x.high / x.low).powf(share)
            } else {
                x.low + share * (x.high - x.low)
            }
        };
        let points: Vec<(f64, f64)> = (0..=PIECES)
            .map(|piece| (at(piece), of(at(piece))))
            .collect();
        self.line(points, colour, dashes);
    }

    /// A filled box between two corners.
    pub fn area(&mut self, from: [f64; 2], to: [f64; 2], colour: &str, opacity: f64) {
        let (left, right) = (self.x.place(from[0]), self.x.place(to[0]));
        let (bottom, top) = (self.y.place(from[1]), self.y.place(to[1]));
        let _ = write!(
            self.svg,
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{colour}\" fill-opacity=\"{opacity}\"/>",
            (right - left).max(0.0),
            (bottom - top).max(0.0)
        );
    }

    /// A vertical bar of an interval, with its middle as a dot of a radius.
    pub fn interval(&mut self, x: f64, [low, middle, high]: [f64; 3], colour: &str, radius: f64) {
        let at = self.x.place(x);
        let _ = write!(
            self.svg,
            "<path d=\"M{at:.1} {:.1}V{:.1}\" stroke=\"{colour}\" stroke-width=\"1.3\"/>\
             <circle cx=\"{at:.1}\" cy=\"{:.1}\" r=\"{radius}\" fill=\"{colour}\"/>",
            self.y.place(low),
            self.y.place(high),
            self.y.place(middle)
        );
    }

    /// A horizontal one.
    pub fn level(&mut self, y: f64, [low, middle, high]: [f64; 3], colour: &str) {
        let at = self.y.place(y);
        let _ = write!(
            self.svg,
            "<path d=\"M{:.1} {at:.1}H{:.1}\" stroke=\"{colour}\" stroke-width=\"1.6\"/>\
             <circle cx=\"{:.1}\" cy=\"{at:.1}\" r=\"3.2\" fill=\"{colour}\"/>",
            self.x.place(low),
            self.x.place(high),
            self.x.place(middle)
        );
    }

    /// A dot that others shine through.
    pub fn dot(&mut self, x: f64, y: f64, colour: &str) {
        let _ = write!(
            self.svg,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"2.2\" fill=\"{colour}\" fill-opacity=\".45\"/>",
            self.x.place(x),
            self.y.place(y)
        );
    }

    /// The picture, for more plots in it or its end.
    pub fn done(self) -> String {
        self.svg + "</g>"
    }
}

/// Words at a place of the picture.
pub fn words(svg: &mut String, x: f64, y: f64, anchor: &str, colour: &str, text: &str) {
    let _ = write!(
        svg,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{colour}\">{}</text>",
        text.replace('&', "&amp;").replace('<', "&lt;")
    );
}

fn written(tick: f64) -> String {
    if tick == 0.0 {
        return "0".to_owned();
    }
    if tick.abs() >= 1.0e-3 && tick.abs() < 1.0e5 {
        // Twelve digits hide what a multiple of a step is off by.
        let rounded: f64 = format!("{tick:.11e}").parse().unwrap_or(tick);
        return rounded.to_string().replace('-', "−");
    }
    let power = format!("{tick:.1e}").replace(".0e", "e");
    power.replace('-', "−")
}
