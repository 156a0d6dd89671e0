//! A plot as a value.

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
    /// Names at 0, 1, 2, … instead of numbers; empty for numbers.
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
    /// Lower and upper end of its interval.
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
}
