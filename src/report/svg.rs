//! Parts of drawings as SVG, the same in all of them: scales with ticks, colours, texts, lines, borders, keys.

use std::fmt::Write;

use super::views::escaped;
use crate::checks::slug;
use crate::document::{Colour, rounded};

/// Ink of frames and texts.
pub const INK: &str = "#1b1b1b";
const GRID: &str = "#e6e8ea";
/// Width of a letter, on average and rather more.
pub const LETTER: f64 = 7.6;
const FONT_SIZE: f64 = 13.0;
/// Ticks are about so far apart, across and upwards.
pub const APART: [f64; 2] = [58.0, 32.0];

/// A rectangle of a drawing: left, top, width, height.
pub type Area = [f64; 4];

/// Where a tick stands, and its words.
pub type Tick = (f64, String);

/// Scales across and upwards, with their ticks.
pub type Axes<'a> = [(&'a Scale, &'a [Tick]); 2];

/// From values to places along one side of an area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// At its ends.
    pub values: [f64; 2],
    /// Of those values.
    pub places: [f64; 2],
    /// Powers of ten are evenly apart.
    pub logarithmic: bool,
}

impl Scale {
    pub fn linear(values: [f64; 2], places: [f64; 2]) -> Self {
        Scale {
            values,
            places,
            logarithmic: false,
        }
    }

    /// Where a value is. What lies a little beyond an end is placed there, to be cut off by whoever draws; farther
    /// values stop half a length beyond: numbers without bound do not draw.
    pub fn place(&self, value: f64) -> f64 {
        let ([low, high], [from, to]) = (self.values, self.places);
        let share = match self.logarithmic {
            true => (value.max(f64::MIN_POSITIVE) / low).ln() / (high / low).ln(),
            false => (value - low) / (high - low),
        };
        from + share.clamp(-0.5, 1.5) * (to - from)
    }

    /// Round values about so far apart: multiples of 1, 2 or 5 times a power of ten; on a logarithmic scale 1, 2 and 5 times
    /// powers of ten if they have room, else the powers. None on a scale that runs backwards or has no ends.
    pub fn ticks(&self, apart: f64) -> Vec<Tick> {
        let ([low, high], [from, to]) = (self.values, self.places);
        let most = ((to - from).abs() / apart).max(2.0);
        let values: Vec<f64> =
            if !(high - low).is_finite() || self.logarithmic && low.min(high) <= 0.0 {
                Vec::new()
            } else if self.logarithmic {
                let steps: &[f64] = match 3.0 * (high / low).log10() <= most + 1.0 {
                    true => &[1.0, 2.0, 5.0],
                    false => &[1.0],
                };
                let powers = (low.log10().floor() as i32)..=(high.log10().ceil() as i32);
                powers
                    .flat_map(|power| steps.iter().map(move |step| step * 10f64.powi(power)))
                    .filter(|tick| *tick >= 0.999_999 * low && *tick <= 1.000_001 * high)
                    .collect()
            } else {
                let step = round_step((high - low) / most);
                let [first, last] = [(low / step - 1e-9).ceil(), (high / step + 1e-9).floor()];
                let all = (first as i64)..=(last as i64);
                all.map(|index| step * index as f64).collect()
            };
        let named = values.into_iter().map(|value| (value, printed(value, 6)));
        named.collect()
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

/// A number of so many significant digits with a minus sign for print.
pub fn printed(value: f64, digits: usize) -> String {
    rounded(value, digits).replace('-', "−")
}

impl Colour {
    /// As SVG writes it.
    pub fn hex(self) -> &'static str {
        match self {
            Colour::Blue => "#0072b2",
            Colour::Vermilion => "#d55e00",
            Colour::Green => "#009e73",
            Colour::Purple => "#cc79a7",
            Colour::Sky => "#56b4e9",
            Colour::Ochre => "#b8860b",
            Colour::Grey => "#5f6368",
        }
    }

    /// The same hue with a contrast to white of 4.5 and more, which letters need and lines do not.
    fn of_letters(self) -> &'static str {
        match self {
            Colour::Vermilion => "#a33b00",
            Colour::Green => "#00674f",
            Colour::Purple => "#8f3a6b",
            Colour::Sky => "#1b6f9c",
            Colour::Ochre => "#7a5900",
            Colour::Blue | Colour::Grey => self.hex(),
        }
    }
}

/// A text at a place; `anchor` is `start`, `middle` or `end`. Signs of the markup are replaced.
pub fn text([x, y]: [f64; 2], anchor: &str, content: &str) -> String {
    let content = escaped(content);
    format!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{content}</text>\n")
}

/// The same in the colour of what it names, with a rim of white so that it can be read on lines.
pub fn label(colour: Colour, place: [f64; 2], anchor: &str, content: &str) -> String {
    format!(
        "<g fill=\"{}\" stroke=\"#fff\" stroke-width=\"3\" stroke-opacity=\"0.8\" paint-order=\"stroke\">{}</g>",
        colour.of_letters(),
        text(place, anchor, content).trim_end()
    )
}

/// Ink on a rim of white, so that it can be read on a picture.
pub fn on_white(words: &str) -> String {
    format!(
        "<g font-size=\"12\" stroke=\"#fff\" stroke-width=\"3.5\" stroke-linejoin=\"round\" paint-order=\"stroke\">{words}</g>"
    )
}

/// The same turned by so many degrees about the end that is its anchor.
fn turned([x, y]: [f64; 2], degrees: i32, anchor: &str, content: &str) -> String {
    let words = text([0.0, 0.0], anchor, content);
    format!("<g transform=\"translate({x:.1} {y:.1}) rotate({degrees})\">{words}</g>")
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

/// The width of the widest of these words.
pub fn widest(ticks: &[Tick]) -> f64 {
    let letters = ticks.iter().map(|(_, words)| words.chars().count()).max();
    LETTER * letters.unwrap_or(0) as f64
}

/// What is drawn in an area, cut off at its border, with ticks and labels on its floor and left side; the label on the left
/// begins at `edge`. The value is the drawing and how far down it goes.
pub fn framed(
    name: &str,
    area: Area,
    contents: &str,
    [(x, across), (y, upwards)]: Axes<'_>,
    labels: [&str; 2],
    edge: f64,
) -> (String, f64) {
    let [left, top, width, height] = area;
    let (floor, name) = (top + height, slug(name));
    let frame =
        format!("<rect x=\"{left:.1}\" y=\"{top}\" width=\"{width:.1}\" height=\"{height}\"");
    let mut svg = format!(
        "<clipPath id=\"clip-{name}\">{frame}/></clipPath><g clip-path=\"url(#clip-{name})\">{contents}</g>\n\
         {frame} fill=\"none\" stroke=\"{INK}\"/>\n"
    );
    // Words that do not fit below each other's sides are turned.
    let widest = widest(across);
    let leans = widest > width / across.len().max(1) as f64 - 6.0;
    let mut path = String::new();
    for (value, words) in across {
        let at = x.place(*value);
        let _ = write!(path, "M{at:.1} {floor}v5");
        svg += &if leans {
            turned([at + 4.0, floor + 16.0], -45, "end", words)
        } else {
            text([at, floor + 18.0], "middle", words)
        };
    }
    for (value, words) in upwards {
        let at = y.place(*value);
        let _ = write!(path, "M{left:.1} {at:.1}h-5");
        svg += &text([left - 8.0, at + 4.5], "end", words);
    }
    let _ = write!(svg, "<path stroke=\"{INK}\" d=\"{path}\"/>");
    let room = if leans { 12.0 + 0.72 * widest } else { 20.0 };
    let below = floor + room + 18.0;
    svg += &text([left + 0.5 * width, below], "middle", labels[0]);
    if !labels[1].is_empty() {
        svg += &turned([edge, top + 0.5 * height], -90, "middle", labels[1]);
    }
    (svg, below + 10.0)
}

/// Thin lines through an area at ticks.
pub fn grid([left, top, width, height]: Area, [(x, across), (y, upwards)]: Axes<'_>) -> String {
    let mut path = String::new();
    for (tick, _) in across {
        let _ = write!(path, "M{:.1} {top}v{height}", x.place(*tick));
    }
    for (tick, _) in upwards {
        let _ = write!(path, "M{left} {:.1}h{width}", y.place(*tick));
    }
    format!("<path stroke=\"{GRID}\" d=\"{path}\"/>\n")
}

/// Symbols, each drawn upwards from its own origin and 22 wide, with their words: one after another from `left` on, in
/// a new line where the next would end beyond `right`. The value is the drawing and the number of its lines.
pub fn key([left, right]: [f64; 2], top: f64, entries: &[(String, String)]) -> (String, usize) {
    let (mut svg, mut x, mut row) = (String::new(), left, 0);
    for (symbol, words) in entries {
        let width = 40.0 + LETTER * words.chars().count() as f64;
        if x > left && x + width > right {
            (x, row) = (left, row + 1);
        }
        let y = top + 20.0 * row as f64;
        let _ = write!(
            svg,
            "<g transform=\"translate({x:.1} {y:.1})\">{symbol}</g>"
        );
        svg += &text([x + 26.0, y], "start", words);
        x += width;
    }
    (svg, row + usize::from(!entries.is_empty()))
}

/// A whole drawing of this size that needs nothing else.
pub fn whole([width, height]: [f64; 2], label: &str, contents: &str) -> String {
    let class = if width > 1000.0 {
        " class=\"wide\""
    } else {
        ""
    };
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\"{class} viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\" aria-label=\"{}\" \
         font-family=\"'DejaVu Sans', system-ui, sans-serif\" font-size=\"{FONT_SIZE}\" fill=\"{INK}\">\n\
         <rect width=\"{width:.0}\" height=\"{height:.0}\" fill=\"#fff\"/>\n{contents}</svg>\n",
        escaped(label)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale(low: f64, high: f64, length: f64, logarithmic: bool) -> Scale {
        Scale {
            logarithmic,
            ..Scale::linear([low, high], [0.0, length])
        }
    }

    #[test]
    fn ticks_are_round_and_within() {
        let words = |scale: Scale, apart: f64| -> Vec<String> {
            scale
                .ticks(apart)
                .into_iter()
                .map(|(_, words)| words)
                .collect()
        };
        let all = ["−0.2", "0", "0.2", "0.4", "0.6", "0.8", "1"];
        assert_eq!(words(scale(-0.3, 1.0, 70.0, false), 10.0), all);
        let powers = scale(1e-5, 1e-2, 90.0, true);
        assert_eq!(words(powers, 30.0), ["1e−5", "0.0001", "0.001", "0.01"]);
        assert_eq!(words(powers, 10.0).len(), 10);
        for [low, high] in [[7.0, 0.0], [0.0, f64::INFINITY], [f64::NAN, 1.0]] {
            for logarithmic in [false, true] {
                let ticks = scale(low, high, 90.0, logarithmic).ticks(30.0);
                assert!(ticks.is_empty(), "{low} to {high}");
            }
        }
    }

    #[test]
    fn places_are_even_and_go_on_a_little_beyond_the_ends() {
        let even = scale(-0.3, 1.0, 100.0, false);
        assert_eq!(even.place(7.0), 150.0);
        assert!((even.place(1.13) - 110.0).abs() < 1e-9);
        let powers = scale(1e-3, 1.0, 90.0, true);
        assert!((powers.place(1e-1) - 60.0).abs() < 1e-9);
        assert_eq!(powers.place(0.0), -45.0);
    }

    #[test]
    fn steps_are_round() {
        for (least, step) in [(0.085, 0.1), (1.3, 2.0), (400.0, 500.0), (0.0, 1.0)] {
            assert_eq!(round_step(least), step);
        }
    }

    #[test]
    fn a_key_goes_on_in_a_new_line() {
        let entry = |words: &str| (String::new(), words.to_owned());
        let entries = [entry("the first words"), entry("the second words")];
        assert_eq!(key([0.0, 400.0], 0.0, &entries).1, 1);
        assert_eq!(key([0.0, 200.0], 0.0, &entries).1, 2);
    }
}
