//! A plot as a value.

use super::table::{Cell, Table};

/// Marks between two axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    /// Of its files; unique in its document.
    pub name: String,
    /// What it shows.
    pub caption: String,
    /// From left to right.
    pub x: Axis,
    /// From bottom to top.
    pub y: Axis,
    /// In the order in which they are drawn.
    pub marks: Vec<Mark>,
}

/// An axis.
#[derive(Debug, Clone, PartialEq)]
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
}

/// What is drawn. A name that is not empty goes into the key.
#[derive(Debug, Clone, PartialEq)]
pub enum Mark {
    /// A line through points.
    Line {
        name: String,
        colour: Colour,
        dashed: bool,
        points: Vec<[f64; 2]>,
    },
    /// Points, each with a label (may be empty) and the ends of its vertical bar (none for no bar).
    Points {
        name: String,
        colour: Colour,
        hollow: bool,
        points: Vec<Point>,
    },
    /// The area between two lines: x, lower, upper.
    Band {
        name: String,
        colour: Colour,
        points: Vec<[f64; 3]>,
    },
    /// Boxes from the floor: left, right, height.
    Bars {
        name: String,
        colour: Colour,
        bars: Vec<[f64; 3]>,
    },
    /// A value across the whole plot, with its words.
    Level {
        name: String,
        colour: Colour,
        y: f64,
    },
}

/// A point of a plot.
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
            logarithmic: false,
            range: None,
            categories: Vec::new(),
        }
    }

    /// In powers of ten.
    pub fn logarithmic(label: &str) -> Self {
        Axis {
            logarithmic: true,
            ..Axis::linear(label)
        }
    }

    /// Names instead of numbers.
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

    /// With words beside it.
    #[must_use]
    pub fn labelled(self, label: String) -> Self {
        Point { label, ..self }
    }

    /// Without interval and label.
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
    /// Without marks.
    pub fn new(name: &str, caption: impl Into<String>, x: Axis, y: Axis) -> Self {
        Plot {
            name: name.to_owned(),
            caption: caption.into(),
            x,
            y,
            marks: Vec::new(),
        }
    }

    /// With a line through points on top.
    #[must_use]
    pub fn line(
        mut self,
        name: &str,
        colour: Colour,
        points: impl IntoIterator<Item = [f64; 2]>,
    ) -> Self {
        self.marks.push(Mark::Line {
            name: name.to_owned(),
            colour,
            dashed: false,
            points: points.into_iter().collect(),
        });
        self
    }

    /// With points on top, if there are any.
    #[must_use]
    pub fn points(
        self,
        name: &str,
        colour: Colour,
        points: impl IntoIterator<Item = Point>,
    ) -> Self {
        self.group(name, colour, false, points)
    }

    /// With filled or hollow points on top, if there are any.
    #[must_use]
    pub fn group(
        mut self,
        name: &str,
        colour: Colour,
        hollow: bool,
        points: impl IntoIterator<Item = Point>,
    ) -> Self {
        let points: Vec<Point> = points.into_iter().collect();
        if !points.is_empty() {
            let name = name.to_owned();
            self.marks.push(Mark::Points {
                name,
                colour,
                hollow,
                points,
            });
        }
        self
    }

    /// With the area between two lines, x, lower, upper, on top.
    #[must_use]
    pub fn band(
        self,
        name: &str,
        colour: Colour,
        points: impl IntoIterator<Item = [f64; 3]>,
    ) -> Self {
        self.with(Mark::Band {
            name: name.to_owned(),
            colour,
            points: points.into_iter().collect(),
        })
    }

    /// With boxes from the floor, left, right, height, on top.
    #[must_use]
    pub fn bars(
        self,
        name: &str,
        colour: Colour,
        bars: impl IntoIterator<Item = [f64; 3]>,
    ) -> Self {
        self.with(Mark::Bars {
            name: name.to_owned(),
            colour,
            bars: bars.into_iter().collect(),
        })
    }

    /// With a value across the whole plot.
    #[must_use]
    pub fn level(self, name: impl Into<String>, colour: Colour, y: f64) -> Self {
        let name = name.into();
        self.with(Mark::Level { name, colour, y })
    }

    /// With another mark on top.
    #[must_use]
    pub fn with(mut self, mark: Mark) -> Self {
        self.marks.push(mark);
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
        let none = || Cell::Missing;
        for mark in &self.marks {
            let mut row = |[x, y]: [Cell; 2], rest: [Cell; 4]| {
                table.row(
                    [Cell::Text(mark.name().to_owned()), x, y]
                        .into_iter()
                        .chain(rest),
                );
            };
            match mark {
                Mark::Line { points, .. } => {
                    for [x, y] in points {
                        row(place(*x, *y), [none(), none(), none(), none()]);
                    }
                }
                Mark::Points { points, .. } => {
                    for point in points {
                        let [low, high] = point.interval.map_or([None; 2], |ends| ends.map(Some));
                        let label = Some(point.label.clone()).filter(|label| !label.is_empty());
                        let rest = [low.into(), high.into(), none(), label.into()];
                        row(place(point.x, point.y), rest);
                    }
                }
                Mark::Band { points, .. } => {
                    for [x, low, high] in points {
                        let rest = [Cell::Number(*low), Cell::Number(*high), none(), none()];
                        row([named(&self.x, *x), none()], rest);
                    }
                }
                Mark::Bars { bars, .. } => {
                    for [from, to, height] in bars {
                        let rest = [none(), none(), Cell::Number(*to), none()];
                        row([Cell::Number(*from), Cell::Number(*height)], rest);
                    }
                }
                Mark::Level { y, .. } => {
                    let ends = if self.y.categories.is_empty() {
                        [none(), Cell::Number(*y)]
                    } else {
                        [Cell::Number(*y), none()]
                    };
                    row(ends, [none(), none(), none(), none()]);
                }
            }
        }
        table.without_empty_columns()
    }
}

impl Mark {
    /// As in the key; empty where it is not in it.
    pub fn name(&self) -> &str {
        match self {
            Mark::Line { name, .. }
            | Mark::Points { name, .. }
            | Mark::Band { name, .. }
            | Mark::Bars { name, .. }
            | Mark::Level { name, .. } => name,
        }
    }

    /// None for anything but points.
    pub fn points(&self) -> Option<&[Point]> {
        match self {
            Mark::Points { points, .. } => Some(points),
            _ => None,
        }
    }

    /// Of everything that is drawn.
    pub fn colour(&self) -> Colour {
        match self {
            Mark::Line { colour, .. }
            | Mark::Points { colour, .. }
            | Mark::Band { colour, .. }
            | Mark::Bars { colour, .. }
            | Mark::Level { colour, .. } => *colour,
        }
    }
}
