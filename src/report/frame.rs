//! Parts of drawings in SVG: colours, texts, lines, borders with ticks, keys.

use std::fmt::Write;

use super::axis::{Area, Axis, printed};

/// Ink of frames and texts.
pub const INK: &str = "#1b1b1b";
/// Of what stands back.
pub const SOFT: &str = "#5f6368";
/// Of what is drawn first: see [`crate::report::chart::BLUE`].
pub const BLUE: &str = "#0072b2";
/// See [`BLUE`].
pub const VERMILION: &str = "#d55e00";
/// See [`BLUE`].
pub const GREEN: &str = "#009e73";
/// See [`BLUE`].
pub const PURPLE: &str = "#cc79a7";
/// See [`BLUE`].
pub const SKY: &str = "#56b4e9";
/// Darker than theirs.
pub const OCHRE: &str = "#b8860b";
const GRID: &str = "#e6e8ea";

/// About so far apart are ticks across and upwards.
const TICKS: [f64; 2] = [55.0, 32.0];
/// Width of a letter over the size of the font, on average, and rather more.
const LETTER: f64 = 0.6;
/// Size of the letters of a [`whole`] drawing.
const FONT_SIZE: f64 = 13.0;

/// A text at a place; `anchor` is `start`, `middle` or `end`. Signs of the markup are replaced.
pub fn text([x, y]: [f64; 2], anchor: &str, content: &str) -> String {
    let content = escaped(content);
    format!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{content}</text>\n")
}

/// Words with the signs of the markup replaced.
pub fn escaped(words: &str) -> String {
    words
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

/// The same in a colour, or in a darker one of its hue where it is too light for letters.
pub fn coloured(colour: &str, place: [f64; 2], anchor: &str, content: &str) -> String {
    let colour = legible(colour);
    format!(
        "<g fill=\"{colour}\">{}</g>",
        text(place, anchor, content).trim_end()
    )
}

/// Contrast to white of 4.5 and more, which letters need and lines do not.
fn legible(colour: &str) -> &str {
    match colour {
        VERMILION => "#a33b00",
        GREEN => "#00674f",
        PURPLE => "#8f3a6b",
        SKY => "#1b6f9c",
        OCHRE => "#7a5900",
        other => other,
    }
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
    for tick in x.ticks(width / TICKS[0]) {
        let at = x.place(tick);
        let _ = write!(svg, "<path stroke=\"{INK}\" d=\"M{at:.1} {floor}v5\"/>");
        svg += &text([at, floor + 18.0], "middle", &printed(tick));
    }
    for tick in y.ticks(height / TICKS[1]) {
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

/// Thin lines through an area at the ticks of its [`border`].
pub fn grid([left, top, width, height]: Area, x: &Axis, y: &Axis) -> String {
    let mut path = String::new();
    for tick in x.ticks(width / TICKS[0]) {
        let _ = write!(path, "M{:.1} {top}v{height}", x.place(tick));
    }
    for tick in y.ticks(height / TICKS[1]) {
        let _ = write!(path, "M{left} {:.1}h{width}", y.place(tick));
    }
    format!("<path stroke=\"{GRID}\" d=\"{path}\"/>\n")
}

/// A sample of a line for a [`key`].
pub fn sample(colour: &str, width: f64, dashes: &str) -> String {
    format!(
        "<path stroke=\"{colour}\" stroke-width=\"{width}\" stroke-dasharray=\"{dashes}\" d=\"M0 -4.5h22\"/>"
    )
}

/// Symbols, each drawn upwards from its own origin and 22 wide, with their words: one after another from `left` on, in
/// a new line where the next would end beyond `right`. The value is the drawing and the number of its lines.
pub fn key([left, right]: [f64; 2], top: f64, entries: &[(String, String)]) -> (String, usize) {
    let (mut svg, mut x, mut row) = (String::new(), left, 0);
    for (symbol, words) in entries {
        let width = 26.0 + LETTER * FONT_SIZE * words.chars().count() as f64;
        if x > left && x + width > right {
            (x, row) = (left, row + 1);
        }
        let y = top + 20.0 * row as f64;
        let _ = write!(
            svg,
            "<g transform=\"translate({x:.1} {y:.1})\">{symbol}</g>"
        );
        svg += &text([x + 26.0, y], "start", words);
        x += width + 6.0;
    }
    (svg, row + 1)
}

/// A whole drawing of this size that needs nothing else.
pub fn whole([width, height]: [f64; 2], label: &str, contents: &str) -> String {
    let label = label.replace(['<', '>', '&', '"'], " ");
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{label}\" \
         font-family=\"'DejaVu Sans', system-ui, sans-serif\" font-size=\"{FONT_SIZE}\" fill=\"{INK}\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n{contents}</svg>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_goes_on_in_a_new_line() {
        let entry = |words: &str| (String::new(), words.to_owned());
        let entries = [entry("the first words"), entry("the second words")];
        assert_eq!(key([0.0, 400.0], 0.0, &entries).1, 1);
        assert_eq!(key([0.0, 200.0], 0.0, &entries).1, 2);
    }
}
