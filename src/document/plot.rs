//! A plot as a value.

use super::table::{Cell, Table};

/// Marks between two axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    /// Of its files; unique in its document.
    pub name: String,
    pub caption: String,
    pub x: Axis,
    pub y: Axis,
    /// Over the whole width of its page.
    pub wide: bool,
    /// In the order in which they are drawn.
    pub marks: Vec<Mark>,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub struct Axis {
    /// With the unit.
    pub label: String,
    /// Powers of ten; values at or below zero are left out.
    pub logarithmic: bool,
    /// From where to where; none for what the marks need.
    pub range: Option<[f64; 2]>,
    /// Names at 0, 1, 2, … instead of numbers; empty for numbers. On the vertical axis the first stands on top, and intervals and
    /// levels are of the horizontal axis.
    pub categories: Vec<String>,
    /// Places and words that stand there instead of round numbers; empty for these.
    pub ticks: Vec<(f64, String)>,
}

/// What is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    /// As in the key; empty where it is not in it.
    pub name: String,
    pub colour: Colour,
    pub shape: Shape,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// Through points.
    Line {
        dashed: bool,
        points: Vec<[f64; 2]>,
    },
    Points {
        style: Style,
        points: Vec<Point>,
    },
    /// The area between two lines: x, lower, upper.
    Band(Vec<[f64; 3]>),
    /// Boxes from the floor: left, right, height.
    Bars(Vec<[f64; 3]>),
    /// A value across the whole plot.
    Level(f64),
    /// Filled areas so dense: left, right, lower, upper, and what each is. With them a plot is as high as it is wide.
    Cells(f64, Vec<([f64; 4], String)>),
    /// Words about places.
    Words(Vec<([f64; 2], String)>),
}

/// How points are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    Filled,
    Hollow,
    /// They stand back, and their labels are seen only when one points at them.
    Pale,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    pub x: f64,
    pub y: f64,
    /// Lower and upper end of its interval: of y, or of x where y has names.
    pub interval: Option<[f64; 2]>,
    /// Written beside it.
    pub label: String,
}

/// Colours that colour-blind readers can tell apart (Okabe and Ito), and one for what stands back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Colour {
    Blue,
    Vermilion,
    Green,
    Purple,
    Sky,
    Ochre,
    Grey,
}

impl Colour {
    /// Of lines beside each other.
    pub const OF_LINES: [Colour; 5] = [
        Colour::Vermilion,
        Colour::Blue,
        Colour::Green,
        Colour::Purple,
        Colour::Ochre,
    ];
}

impl Axis {
    /// Even, over what the marks need.
    pub fn linear(label: &str) -> Self {
        Axis {
            label: label.to_owned(),
            ..Axis::default()
        }
    }

    pub fn logarithmic(label: &str) -> Self {
        Axis {
            logarithmic: true,
            ..Axis::linear(label)
        }
    }

    pub fn of_names(label: &str, names: impl IntoIterator<Item = impl Into<String>>) -> Self {
        Axis {
            categories: names.into_iter().map(Into::into).collect(),
            ..Axis::linear(label)
        }
    }

    /// From here to there, whatever the marks need.
    #[must_use]
    pub fn within(mut self, low: f64, high: f64) -> Self {
        self.range = Some([low, high]);
        self
    }
}

impl Point {
    /// With the ends of an interval, of y or where y has names of x.
    #[must_use]
    pub fn between(self, low: f64, high: f64) -> Self {
        Point {
            interval: Some([low, high]),
            ..self
        }
    }

    #[must_use]
    pub fn labelled(self, label: String) -> Self {
        Point { label, ..self }
    }

    pub fn at(x: f64, y: f64) -> Self {
        Point {
            x,
            y,
            interval: None,
            label: String::new(),
        }
    }
}

impl Plot {
    pub fn new(name: &str, caption: impl Into<String>, x: Axis, y: Axis) -> Self {
        Plot {
            name: name.to_owned(),
            caption: caption.into(),
            x,
            y,
            wide: false,
            marks: Vec::new(),
        }
    }

    #[must_use]
    pub fn over_the_page(self) -> Self {
        Plot { wide: true, ..self }
    }

    /// With a line through points on top.
    #[must_use]
    pub fn line(
        self,
        name: &str,
        colour: Colour,
        values: impl IntoIterator<Item = [f64; 2]>,
    ) -> Self {
        let (dashed, points) = (false, values.into_iter().collect());
        self.with(name, colour, Shape::Line { dashed, points })
    }

    /// With points on top, if there are any.
    #[must_use]
    pub fn points(
        self,
        name: &str,
        colour: Colour,
        points: impl IntoIterator<Item = Point>,
    ) -> Self {
        self.group(name, colour, Style::Filled, points)
    }

    /// With points of a style on top, if there are any.
    #[must_use]
    pub fn group(
        self,
        name: &str,
        colour: Colour,
        style: Style,
        points: impl IntoIterator<Item = Point>,
    ) -> Self {
        let points: Vec<Point> = points.into_iter().collect();
        if points.is_empty() {
            return self;
        }
        self.with(name, colour, Shape::Points { style, points })
    }

    /// With a value across the whole plot.
    #[must_use]
    pub fn level(self, name: impl Into<String>, colour: Colour, at: f64) -> Self {
        self.with(name, colour, Shape::Level(at))
    }

    /// With another mark on top.
    #[must_use]
    pub fn with(mut self, name: impl Into<String>, colour: Colour, shape: Shape) -> Self {
        let name = name.into();
        self.marks.push(Mark {
            name,
            colour,
            shape,
        });
        self
    }

    /// What is drawn, as numbers: a row a point.
    pub fn table(&self) -> Table {
        let columns = [
            "series",
            &self.x.label,
            &self.y.label,
            "lower",
            "upper",
            "to",
            "label",
        ];
        let mut table = Table::new(&self.name, &self.caption, &columns);
        let named = |axis: &Axis, value: f64| {
            let is_named = value >= 0.0 && value.fract() == 0.0;
            let name = axis.categories.get(value as usize).filter(|_| is_named);
            name.map_or(Cell::Number(value), |name| Cell::Text(name.clone()))
        };
        let place = |x: f64, y: f64| [named(&self.x, x), named(&self.y, y)];
        const NONE: Cell = Cell::Missing;
        for Mark { name, shape, .. } in &self.marks {
            let mut row = |place: [Cell; 2], rest: [Cell; 4]| {
                let cells = place.into_iter().chain(rest);
                table.row(std::iter::once(name.into()).chain(cells));
            };
            match shape {
                Shape::Line { points, .. } => {
                    (points.iter()).for_each(|[x, y]| row(place(*x, *y), [NONE; 4]));
                }
                Shape::Points { points, .. } => {
                    for point in points {
                        let [low, high] = point.interval.map_or([None; 2], |ends| ends.map(Some));
                        let label = Some(&point.label).filter(|label| !label.is_empty());
                        let rest = [low.into(), high.into(), NONE, label.into()];
                        row(place(point.x, point.y), rest);
                    }
                }
                Shape::Band(points) => {
                    for [x, low, high] in points {
                        let rest = [(*low).into(), (*high).into(), NONE, NONE];
                        row([named(&self.x, *x), NONE], rest);
                    }
                }
                Shape::Bars(bars) => {
                    for [from, to, height] in bars {
                        let rest = [NONE, NONE, (*to).into(), NONE];
                        row([(*from).into(), (*height).into()], rest);
                    }
                }
                Shape::Level(at) if self.y.categories.is_empty() => {
                    row([NONE, (*at).into()], [NONE; 4]);
                }
                Shape::Level(at) => row([(*at).into(), NONE], [NONE; 4]),
                Shape::Cells(_, cells) => {
                    for ([left, right, low, high], words) in cells {
                        let rest = [(*low).into(), (*high).into(), (*right).into(), words.into()];
                        row([(*left).into(), NONE], rest);
                    }
                }
                Shape::Words(all) => {
                    for ([x, y], words) in all {
                        row(place(*x, *y), [NONE, NONE, NONE, words.into()]);
                    }
                }
            }
        }
        table.without_empty_columns()
    }
}

impl Mark {
    /// None for anything but points.
    pub fn points(&self) -> Option<&[Point]> {
        match &self.shape {
            Shape::Points { points, .. } => Some(points),
            _ => None,
        }
    }
}
