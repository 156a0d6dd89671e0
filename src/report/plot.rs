//! Plots as SVG: one style for all.

use std::fmt::Write;

use super::svg::{
    APART, Area, Axes, LETTER, Scale, Tick, framed, grid, key, label, line, text, whole, widest,
};
use super::views::{escaped, in_lines};
use crate::document::{Axis, Colour, Mark, Plot, Point, Shape, Style};

/// Least width of a drawing beside another, and over a page.
const WIDTH: [f64; 2] = [640.0, 1240.0];
/// Height between the borders of both, and of a row of names.
const HEIGHT: [f64; 2] = [290.0, 500.0];
const ROW: f64 = 19.0;
/// Height of a name on top of a wide drawing.
const FLAG: f64 = 16.0;
/// Letters in a line of words about a place at most.
const IN_LINE: usize = 11;
/// Letters of a name beside an axis at most.
const LONGEST: usize = 60;
/// Points that are nearer than this are one point of a line.
const NEAR: f64 = 0.3;

/// The whole drawing, which needs nothing else. What is not finite, or not above zero on a logarithmic axis, is left out;
/// labels that find no room are left out too and stand in the file of numbers.
pub fn svg(plot: &Plot) -> String {
    let rows = plot.y.categories.len();
    let wide = usize::from(plot.wide);
    let room = FLAG * flags(plot) as f64;
    let mut height = match rows {
        0 => HEIGHT[wide] + room,
        rows => (9.0 * at_one_name(plot) as f64).max(ROW) * rows.max(3) as f64,
    };
    let [xs, ys] = ranges(plot);
    let scale = |axis: &Axis, range: [f64; 2], along: [f64; 2]| Scale {
        logarithmic: axis.logarithmic,
        ..Scale::linear(range, along)
    };
    // The first name stands on top.
    let upwards = |top: f64, height: f64| match rows {
        0 => scale(&plot.y, ys, [top + height, top + room]),
        _ => scale(&plot.y, ys, [top, top + height]),
    };
    let beside = ticks(&plot.y, &upwards(0.0, height), APART[1]);
    let titled = if plot.y.label.is_empty() { 0.0 } else { 20.0 };
    let left = 16.0 + titled + widest(&beside);
    let total = WIDTH[wide].max(left + 380.0);
    let width = total - left - 18.0;
    let is_square = |mark: &Mark| matches!(mark.shape, Shape::Cells(..));
    if plot.marks.iter().any(is_square) {
        height = width;
    }
    let (names, lines) = key([left, total], 20.0, &entries(plot));
    let top = 14.0 + 20.0 * lines as f64;
    let area = [left, top, width, height];
    let (x, y) = (
        scale(&plot.x, xs, [left, left + width]),
        upwards(top, height),
    );
    let below = ticks(&plot.x, &x, APART[0]);
    let mut drawing = Drawing {
        plot,
        area,
        x,
        y,
        marks: String::new(),
        labels: Vec::new(),
        taken: Vec::new(),
    };
    drawing.marks();
    let axes: Axes<'_> = [(&x, &below), (&y, &beside)];
    let titles = [plot.x.label.as_str(), &plot.y.label];
    let (frame, floor) = framed(&plot.name, area, &drawing.marks, axes, titles, 16.0);
    // Names need no lines.
    let mut lines = axes;
    for ((_, ticks), axis) in lines.iter_mut().zip([&plot.x, &plot.y]) {
        if !axis.categories.is_empty() || !axis.ticks.is_empty() {
            *ticks = &[];
        }
    }
    let grid = grid(area, lines);
    let svg = names + &grid + &frame + &drawing.labels();
    whole([total, floor], &plot.caption, &svg)
}

/// Series that stand beside each other: all, if two have points at one name of an axis, else one.
fn at_one_name(plot: &Plot) -> usize {
    let along = usize::from(plot.x.categories.is_empty());
    let mut taken: Vec<f64> = Vec::new();
    let series = || plot.marks.iter().filter_map(Mark::points);
    let share = series().any(|points| {
        let own: Vec<f64> = points
            .iter()
            .map(|point| [point.x, point.y][along])
            .collect();
        let shares = own.iter().any(|place| taken.contains(place));
        taken.extend(own);
        shares
    });
    if share { series().count() } else { 1 }
}

/// Names that stand on top of a wide drawing.
fn flags(plot: &Plot) -> usize {
    let named = |mark: &Mark| match &mark.shape {
        Shape::Points { style, points } if *style != Style::Pale => points
            .iter()
            .filter(|point| !point.label.is_empty())
            .count(),
        _ => 0,
    };
    let marks = plot.marks.iter().filter(|_| plot.wide);
    marks.map(named).sum()
}

/// Places and words of an axis' ticks.
fn ticks(axis: &Axis, scale: &Scale, apart: f64) -> Vec<Tick> {
    if !axis.ticks.is_empty() {
        return axis.ticks.clone();
    }
    if axis.categories.is_empty() {
        return scale.ticks(apart);
    }
    let name = |(index, name): (usize, &String)| {
        let short: String = name.chars().take(LONGEST).collect();
        let more = if short.len() < name.len() { "…" } else { "" };
        (index as f64, short + more)
    };
    axis.categories.iter().enumerate().map(name).collect()
}

/// From where to where the axes go: as they say, or what the marks need and a little room.
fn ranges(plot: &Plot) -> [[f64; 2]; 2] {
    let (mut xs, mut ys) = (Vec::new(), Vec::new());
    let downwards = !plot.y.categories.is_empty();
    for mark in &plot.marks {
        let along = if downwards { &mut xs } else { &mut ys };
        match &mark.shape {
            Shape::Level(at) => along.push(*at),
            Shape::Line { points, .. } => {
                xs.extend(points.iter().map(|point| point[0]));
                ys.extend(points.iter().map(|point| point[1]));
            }
            Shape::Points { points, .. } => {
                along.extend(points.iter().filter_map(|point| point.interval).flatten());
                xs.extend(points.iter().map(|point| point.x));
                ys.extend(points.iter().map(|point| point.y));
            }
            Shape::Band(points) => {
                xs.extend(points.iter().map(|point| point[0]));
                ys.extend(points.iter().flat_map(|point| [point[1], point[2]]));
            }
            Shape::Bars(bars) => {
                xs.extend(bars.iter().flat_map(|bar| [bar[0], bar[1]]));
                ys.extend(bars.iter().flat_map(|bar| [0.0, bar[2]]));
            }
            // Their axes have a range.
            Shape::Cells(..) | Shape::Words(_) => {}
        }
    }
    let points = || plot.marks.iter().filter_map(Mark::points).flatten();
    [
        range(&plot.x, &xs, points().any(|point| point.x == 0.0)),
        range(&plot.y, &ys, points().any(|point| point.y == 0.0)),
    ]
}

/// With `points_at_zero` there is room beyond it, so that no border cuts them.
fn range(axis: &Axis, values: &[f64], points_at_zero: bool) -> [f64; 2] {
    if let Some(range) = axis.range {
        return range;
    }
    if !axis.categories.is_empty() {
        return [-0.5, axis.categories.len() as f64 - 0.5];
    }
    let shown = values.iter().filter(|value| is_shown(**value, axis));
    let (low, high) = shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(*value), high.max(*value))
    });
    match (low <= high, axis.logarithmic) {
        (false, false) => [0.0, 1.0],
        (false, true) => [1.0, 10.0],
        (true, true) => {
            let room = (high / low).powf(0.05).max(1.15);
            [low / room, high * room]
        }
        (true, false) => {
            let room = match high > low {
                true => 0.04 * (high - low),
                false => 0.1 * high.abs().max(1e-300),
            };
            // Zero is an end, not a value beyond which there is more.
            let beyond = |end: f64, room: f64| match end == 0.0 && high > low && !points_at_zero {
                true => 0.0,
                false => end + room,
            };
            [beyond(low, -room), beyond(high, room)]
        }
    }
}

fn is_shown(value: f64, axis: &Axis) -> bool {
    value.is_finite() && (!axis.logarithmic || value > 0.0)
}

/// Symbols and words of the key; marks of one name share theirs.
fn entries(plot: &Plot) -> Vec<(String, String)> {
    let mut entries: Vec<(String, String)> = Vec::new();
    for mark in plot.marks.iter().filter(|mark| !mark.name.is_empty()) {
        let colour = mark.colour.hex();
        let line = |width: f64, dashes: &str| {
            format!(
                "<path stroke=\"{colour}\" stroke-width=\"{width}\" stroke-dasharray=\"{dashes}\" d=\"M0 -4.5h22\"/>"
            )
        };
        let box_of = |opacity: f64| {
            format!(
                "<rect y=\"-10\" width=\"22\" height=\"11\" fill=\"{colour}\" fill-opacity=\"{opacity}\"/>"
            )
        };
        let symbol = match mark.shape {
            Shape::Level(_) => line(1.6, "2 3"),
            Shape::Line { dashed, .. } => line(2.0, dashes(dashed)),
            Shape::Points { style, .. } => circle([11.0, -4.5], colour, style, 4.0, 1.0, ""),
            Shape::Band(_) => box_of(OF_BAND),
            Shape::Bars(_) => box_of(OF_BARS),
            Shape::Cells(dense, _) => box_of(dense),
            Shape::Words(_) => String::new(),
        };
        match entries.iter_mut().find(|(_, words)| *words == mark.name) {
            Some((symbols, _)) => *symbols += &symbol,
            None => entries.push((symbol, mark.name.clone())),
        }
    }
    entries
}

fn dashes(dashed: bool) -> &'static str {
    if dashed { "6 4" } else { "" }
}

/// Opacity of areas.
const OF_BAND: f64 = 0.25;
const OF_BARS: f64 = 0.45;

fn circle(
    [x, y]: [f64; 2],
    colour: &str,
    style: Style,
    radius: f64,
    opacity: f64,
    title: &str,
) -> String {
    let style = match style {
        Style::Hollow => format!("fill=\"#fff\" stroke=\"{colour}\" stroke-width=\"1.8\""),
        Style::Filled => format!("fill=\"{colour}\" fill-opacity=\"{opacity}\""),
        Style::Pale => format!("fill=\"{colour}\" fill-opacity=\"{OF_BAND}\""),
    };
    let title = match title {
        "" => String::new(),
        title => format!("<title>{}</title>", escaped(title)),
    };
    format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" {style}>{title}</circle>")
}

/// The name of a point.
struct Label {
    words: String,
    colour: Colour,
    /// Of the point, and how far up its bar goes.
    point: [f64; 2],
    highest: f64,
}

/// A plot in the making.
struct Drawing<'a> {
    plot: &'a Plot,
    /// Between its borders.
    area: Area,
    x: Scale,
    y: Scale,
    marks: String,
    labels: Vec<Label>,
    /// Where nothing more can be written: left, top, right, bottom.
    taken: Vec<[f64; 4]>,
}

/// A text's place and anchor.
type Place = ([f64; 2], &'static str);

impl Drawing<'_> {
    fn shown(&self, [x, y]: [f64; 2]) -> bool {
        is_shown(x, &self.plot.x) && is_shown(y, &self.plot.y)
    }

    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.x.place(x), self.y.place(y)]
    }

    /// The data of a path; what cannot be shown interrupts it.
    fn path(&self, points: impl Iterator<Item = [f64; 2]>) -> String {
        let mut path = String::new();
        let mut piece: Vec<[f64; 2]> = Vec::new();
        for point in points {
            if !self.shown(point) {
                path += &line(piece.drain(..));
                continue;
            }
            let at = self.place(point);
            let near = piece
                .last()
                .is_some_and(|last| (at[0] - last[0]).abs() + (at[1] - last[1]).abs() < NEAR);
            if !near {
                piece.push(at);
            }
        }
        path + &line(piece.into_iter())
    }

    fn marks(&mut self) {
        let plot = self.plot;
        let of_points = at_one_name(plot);
        let mut series = 0;
        for mark in &plot.marks {
            let colour = mark.colour.hex();
            match &mark.shape {
                Shape::Line { dashed, points } => {
                    let path = self.path(points.iter().copied());
                    let dashes = dashes(*dashed);
                    self.marks += &format!(
                        "<path fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.8\" stroke-linejoin=\"round\" stroke-dasharray=\"{dashes}\" d=\"{path}\"/>"
                    );
                }
                Shape::Band(points) => {
                    let lower = points.iter().rev().map(|[x, low, _]| [*x, *low]);
                    let around = points.iter().map(|[x, _, high]| [*x, *high]).chain(lower);
                    let shown = around.filter(|point| self.shown(*point));
                    let path = line(shown.map(|point| self.place(point)));
                    self.marks += &format!(
                        "<path fill=\"{colour}\" fill-opacity=\"{OF_BAND}\" d=\"{path}Z\"/>"
                    );
                }
                Shape::Bars(bars) => {
                    let floor = self.y.place(0.0);
                    let is_finite = |bar: &&[f64; 3]| bar.iter().all(|value| value.is_finite());
                    for [from, to, height] in bars.iter().filter(is_finite) {
                        let [left, right] = [from, to].map(|value| self.x.place(*value));
                        let top = self.y.place(*height);
                        let _ = write!(
                            self.marks,
                            "<rect x=\"{left:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{colour}\" fill-opacity=\"{OF_BARS}\" stroke=\"{colour}\" stroke-width=\"0.6\"/>",
                            top.min(floor),
                            (right - left).max(0.0),
                            (floor - top).abs()
                        );
                    }
                }
                Shape::Level(at) => self.level(mark.colour, *at),
                Shape::Cells(dense, cells) => {
                    let mut path = String::new();
                    for ([left, right, low, high], _) in cells {
                        let [[left, top], [right, low]] =
                            [[*left, *high], [*right, *low]].map(|corner| self.place(corner));
                        let _ = write!(path, "M{left:.1} {top:.1}H{right:.1}V{low:.1}H{left:.1}Z");
                    }
                    self.marks += &format!(
                        "<path fill=\"{colour}\" fill-opacity=\"{dense}\" stroke=\"#fff\" stroke-width=\"0.6\" d=\"{path}\"/>"
                    );
                }
                Shape::Words(all) => {
                    for (at, words) in all {
                        let lines = in_lines(words, IN_LINE);
                        let [x, y] = self.place(*at);
                        let first = y + 4.0 - 6.5 * (lines.len() as f64 - 1.0);
                        for (line, row) in lines.iter().zip(0..) {
                            let line = text([x, first + 13.0 * f64::from(row)], "middle", line);
                            self.marks += &format!("<g font-size=\"11.5\">{line}</g>");
                        }
                    }
                }
                Shape::Points { style, points } => {
                    self.points(points, mark.colour, *style, [series, of_points]);
                    series = (series + 1) % of_points;
                }
            }
        }
    }

    /// A line across.
    fn level(&mut self, colour: Colour, value: f64) {
        let [left, top, width, height] = self.area;
        let (right, floor) = (left + width, top + height);
        let path = if self.plot.y.categories.is_empty() {
            if !self.shown([self.x.values[1], value]) {
                return;
            }
            let y = self.y.place(value);
            self.taken.push([left, y - 1.0, right, y + 1.0]);
            format!("M{left:.1} {y:.1}H{right:.1}")
        } else {
            format!("M{:.1} {top}V{floor}", self.x.place(value))
        };
        let colour = colour.hex();
        self.marks += &format!(
            "<path stroke=\"{colour}\" stroke-width=\"1.6\" stroke-dasharray=\"2 3\" d=\"{path}\"/>"
        );
    }

    /// Points with intervals; on an axis of names several series that share a name stand beside each other.
    fn points(
        &mut self,
        points: &[Point],
        colour: Colour,
        style: Style,
        [series, count]: [usize; 2],
    ) {
        let (downwards, hex) = (!self.plot.y.categories.is_empty(), colour.hex());
        let names = [self.plot.x.categories.len(), self.plot.y.categories.len()];
        let apart = |named: usize, length: f64| match named {
            0 => 0.0,
            _ => {
                (0.7 * length / (named * count) as f64).min(8.0)
                    * (series as f64 - 0.5 * (count as f64 - 1.0))
            }
        };
        let shift = [apart(names[0], self.area[2]), apart(names[1], self.area[3])];
        let (radius, opacity) = match points.len() {
            301.. => (2.2, 0.6),
            _ => (3.4, 0.9),
        };
        for point in points {
            if !self.shown([point.x, point.y]) {
                continue;
            }
            let [x, y] = self.place([point.x, point.y]);
            let [x, y] = [x + shift[0], y + shift[1]];
            let mut highest = y - radius;
            let known = |ends: &[f64; 2]| ends.iter().all(|end| !end.is_nan());
            if let Some([low, high]) = point.interval.filter(known) {
                let path = if downwards {
                    let [low, high] = [low, high].map(|end| self.x.place(end));
                    let cap = y - 3.0;
                    self.taken.push([low, cap, high, y + 3.0]);
                    format!("M{low:.1} {y:.1}H{high:.1}M{low:.1} {cap:.1}v6M{high:.1} {cap:.1}v6")
                } else {
                    let [low, high] = [low, high].map(|end| self.y.place(end));
                    highest = highest.min(high);
                    let cap = x - 3.0;
                    self.taken.push([cap, high, x + 3.0, low]);
                    format!("M{x:.1} {low:.1}V{high:.1}M{cap:.1} {low:.1}h6M{cap:.1} {high:.1}h6")
                };
                self.marks +=
                    &format!("<path stroke=\"{hex}\" stroke-width=\"1.4\" d=\"{path}\"/>");
            }
            self.marks += &circle([x, y], hex, style, radius, opacity, &point.label);
            self.taken.push([x - 4.0, y - 4.0, x + 4.0, y + 4.0]);
            if !point.label.is_empty() && style != Style::Pale {
                self.labels.push(Label {
                    words: point.label.clone(),
                    colour,
                    point: [x, y],
                    highest,
                });
            }
        }
    }

    /// The names beside their points, where no other words, points and bars are.
    fn labels(&mut self) -> String {
        if self.plot.wide {
            return self.flags();
        }
        let mut svg = String::new();
        for Label {
            words,
            colour,
            point: [x, y],
            ..
        } in std::mem::take(&mut self.labels)
        {
            let places: [Place; 8] = [
                ([x + 7.0, y + 4.5], "start"),
                ([x - 7.0, y + 4.5], "end"),
                ([x, y - 7.0], "middle"),
                ([x, y + 17.0], "middle"),
                ([x + 6.0, y - 6.0], "start"),
                ([x - 6.0, y - 6.0], "end"),
                ([x + 6.0, y + 15.0], "start"),
                ([x - 6.0, y + 15.0], "end"),
            ];
            let free = |place: &Place| self.is_free(&room(&words, place));
            if let Some(place) = places.into_iter().find(free) {
                self.taken.push(room(&words, &place));
                svg += &label(colour, place.0, place.1, &words);
            }
        }
        svg
    }

    /// The names on top, each at the end of a line from its point: first those that end there, from the right, then those that
    /// begin there, from the left, so that no line goes through a name that begins.
    fn flags(&mut self) -> String {
        let [left, top, width, _] = self.area;
        let labels = std::mem::take(&mut self.labels).into_iter();
        let labels = labels.map(|name| {
            let x = name.point[0];
            let begins = x + LETTER * name.words.chars().count() as f64 <= left + width - 6.0;
            (begins, if begins { x } else { -x }, [x, name.highest], name)
        });
        let mut labels: Vec<_> = labels.collect();
        labels.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let (mut lines, mut names) = (String::new(), String::new());
        for ((begins, _, [x, y], name), row) in labels.into_iter().zip(1..) {
            let floor = top + FLAG * f64::from(row) - 3.0;
            let (from, anchor) = if begins {
                (x + 3.0, "start")
            } else {
                (x - 3.0, "end")
            };
            let hex = name.colour.hex();
            lines += &format!(
                "<path stroke=\"{hex}\" stroke-width=\"0.7\" d=\"M{x:.1} {y:.1}V{:.1}\"/>",
                floor - 10.0
            );
            names += &label(name.colour, [from, floor], anchor, &name.words);
        }
        lines + &names
    }

    /// Whether nothing stands in this box, and it is not at the frame.
    fn is_free(&self, own: &[f64; 4]) -> bool {
        let [left, top, width, height] = self.area;
        let within = own[0] >= left + 3.0
            && own[1] >= top
            && own[2] <= left + width - 3.0
            && own[3] <= top + height;
        let meets = |other: &[f64; 4]| {
            own[0] < other[2] && other[0] < own[2] && own[1] < other[3] && other[1] < own[3]
        };
        within && !self.taken.iter().any(meets)
    }
}

/// The box that words need: left, top, right, bottom.
fn room(words: &str, ([x, y], anchor): &Place) -> [f64; 4] {
    let length = LETTER * words.chars().count() as f64;
    let from = match *anchor {
        "start" => *x,
        "end" => x - length,
        _ => x - 0.5 * length,
    };
    [from, y - 11.0, from + length, y + 3.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every mark on linear, logarithmic and named axes, with values that cannot be drawn among them.
    fn plots() -> [Plot; 6] {
        let plot = |name: &str, x: Axis, y: Axis| Plot::new(name, "caption", x, y);
        let curve = |function: fn(f64) -> f64| {
            let places = (0..200).map(|i| f64::from(i) / 20.0);
            places.map(move |x| [x, function(x)])
        };
        let labelled = |x: f64, y: f64, label: &str| {
            let point = Point::at(x, y).between(0.5 * y, 1.4 * y);
            point.labelled(label.to_owned())
        };
        let sine = curve(f64::sin).map(|[x, y]| [x, 40.0 + 30.0 * y, 60.0 + 30.0 * y]);
        let steps = (0..9).map(|i| [f64::from(i), f64::from(i) + 1.0, f64::from(5 * i)]);
        let broken = curve(|x| if x < 5.0 { 90.0 - x * x } else { f64::NAN });
        let dashed = Shape::Line {
            dashed: true,
            points: broken.collect(),
        };
        let some = [
            labelled(1.0, 60.0, "one"),
            labelled(1.1, 61.0, "two"),
            labelled(1.2, 60.5, "three"),
            labelled(9.9, 20.0, "at the edge"),
            Point::at(f64::INFINITY, 1.0),
        ];
        let [x, y] = [Axis::linear("depth, mm"), Axis::linear("force, N")];
        let linear = plot("linear", x, y)
            .with(
                "a band & <its> name",
                Colour::Sky,
                Shape::Band(sine.collect()),
            )
            .with("bars", Colour::Grey, Shape::Bars(steps.collect()))
            .line("a long name", Colour::Blue, curve(|x| 10.0 * x))
            .with("dashed", Colour::Vermilion, dashed)
            .points("points", Colour::Green, some)
            .group(
                "hollow",
                Colour::Purple,
                Style::Hollow,
                [Point::at(5.0, 80.0)],
            )
            .level("a limit", Colour::Ochre, 75.0)
            .level("another limit", Colour::Vermilion, 76.0);
        let grows = (0..50).map(|i| [f64::from(1 + i), 1e-16 * 2f64.powi(i)]);
        let between = (1..50).map(|i| [f64::from(i), 0.0, 1e-12 * f64::from(i)]);
        let zero = [Point::at(3.0, 1e-10), Point::at(3.0, 0.0)];
        let [x, y] = ["step", "separation over R"].map(Axis::logarithmic);
        let powers = plot("powers", x, y)
            .line("grows", Colour::Blue, grows)
            .with("between", Colour::Grey, Shape::Band(between.collect()))
            .points("zeros are left out", Colour::Vermilion, zero);
        let engines = || Axis::of_names("", ["native", "YADE, ordinary loop", "LIGGGHTS"]);
        let values = |factor: f64| {
            (0..3).map(move |i| {
                let [low, middle, high] = [1, 2, 3].map(|more| factor * f64::from(i + more));
                Point::at(f64::from(i), middle).between(low, high)
            })
        };
        let below = plot("below", engines(), Axis::linear("µs a step"))
            .points("small", Colour::Blue, values(1.0))
            .points("large", Colour::Vermilion, values(1.5));
        let across = |factor: f64| {
            values(factor).map(|point| Point {
                x: point.y,
                y: point.x,
                ..point
            })
        };
        let beside = plot("beside", Axis::logarithmic("µs a step"), engines())
            .points("small", Colour::Blue, across(1.0))
            .points("large", Colour::Vermilion, across(1.5))
            .level("goal", Colour::Green, 4.0);
        let nothing = plot("nothing", Axis::linear("x"), Axis::logarithmic("y"));
        let one = plot("one", Axis::linear("x"), Axis::linear("y")).points(
            "",
            Colour::Blue,
            [Point::at(3.0, 3.0)],
        );
        [linear, powers, below, beside, nothing, one]
    }

    #[test]
    fn drawings_have_no_numbers_that_are_none() {
        for plot in plots() {
            let (name, svg) = (&plot.name, svg(&plot));
            let is_whole = svg.starts_with("<svg ") && svg.ends_with("</svg>\n");
            assert!(is_whole, "{name}: {svg}");
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
        }
    }

    #[test]
    fn no_border_cuts_a_point() {
        let x = Axis::linear("x");
        assert!(range(&x, &[0.0, 1.0], true)[0] < 0.0);
        assert_eq!(range(&x, &[0.0, 1.0], false)[0], 0.0);
    }

    #[test]
    fn series_stand_beside_each_other_only_where_they_share_a_name() {
        let apart = |second: [f64; 2]| {
            let y = Axis::of_names("", ["a", "b"]);
            let other = [Point::at(1.0, second[0]), Point::at(2.0, second[1])];
            let plot = Plot::new("rows", "", Axis::linear("x"), y)
                .points("one", Colour::Blue, [Point::at(1.0, 0.0)])
                .points("other", Colour::Green, other);
            let svg = svg(&plot);
            let circles = svg.split("<circle cx=").skip(1);
            let heights =
                circles.filter_map(|circle| circle.split("cy=\"").nth(1)?.split('"').next());
            let heights: Vec<f64> = heights.filter_map(|height| height.parse().ok()).collect();
            // The key has one of each series before.
            let [first, same] = [heights[2], heights[3]];
            same - first
        };
        assert!(apart([0.0, 1.0]) > 1.0);
        assert!((apart([1.0, 1.0]) - ROW * 1.5).abs() < 0.2, "a row lower");
    }

    #[test]
    fn each_point_of_a_crowd_has_its_name_on_top_of_a_wide_drawing() {
        let crowd = (0..24).map(|at| {
            let point = Point::at(1.0 + 0.01 * f64::from(at), 2.0).between(0.2, 18.0);
            point.labelled(format!("no. {at:03}"))
        });
        let [x, y] = [Axis::logarithmic("s"), Axis::logarithmic("error")];
        let plot = Plot::new("crowd", "", x, y).points("", Colour::Blue, crowd);
        let svg = svg(&plot.over_the_page());
        let is_there = |at: &u32| svg.contains(&format!(">no. {at:03}</text>"));
        assert_eq!((0..24).filter(is_there).count(), 24);
    }

    #[test]
    fn no_name_lies_over_a_bar() {
        let place = |interval| {
            let bar = Point {
                interval,
                ..Point::at(1.1, 5.0)
            };
            let points = [Point::at(1.0, 1.0).labelled("a long name".to_owned()), bar];
            let [x, y] = ["s", "error"].map(|label| Axis::linear(label).within(0.0, 6.0));
            let svg = svg(&Plot::new("bar", "", x, y).points("", Colour::Blue, points));
            let (before, _) = svg.split_once(">a long name</text>")?;
            before.rsplit_once("<text").map(|(_, text)| text.to_owned())
        };
        let [beside, elsewhere] = [[5.0, 5.0], [0.0, 5.0]].map(|ends| place(Some(ends)));
        assert!(beside.is_some() && elsewhere.is_some() && beside != elsewhere);
    }
}
