//! A table as a value.

use evidence::Interval;

use crate::checks::Outcome;

/// Rows of cells under columns.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// Of its files; unique in its document, letters, digits and hyphens.
    pub name: String,
    /// What the rows are.
    pub title: String,
    /// From left to right.
    pub columns: Vec<Column>,
    /// Each with a cell a column.
    pub rows: Vec<Vec<Cell>>,
}

/// A column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Heading.
    pub title: String,
    /// SI unit; empty for words, counts and ratios.
    pub unit: String,
}

/// A value in a table; views choose digits, alignment and colours.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// There is no value.
    Missing,
    /// Words.
    Text(String),
    /// A command, key or file name, letter by letter.
    Code(String),
    /// A count.
    Count(u64),
    /// A number; people see four significant digits, files all.
    Number(f64),
    /// An estimate with its interval.
    Interval(Interval),
    /// How a check came out.
    Outcome(Outcome),
}

impl Table {
    /// With columns, each as `title` or `title, unit` after the last comma and a space.
    pub fn new(name: &str, title: &str, columns: &[&str]) -> Self {
        Table {
            name: name.to_owned(),
            title: title.to_owned(),
            columns: columns.iter().map(|of| Column::parse(of)).collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        self.rows.push(cells.into_iter().collect());
    }
}

impl Column {
    fn parse(text: &str) -> Self {
        let (title, unit) = text.rsplit_once(", ").unwrap_or((text, ""));
        Column {
            title: title.to_owned(),
            unit: unit.to_owned(),
        }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Cell::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Cell::Text(text)
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Cell::Number(value)
    }
}

impl From<u64> for Cell {
    fn from(count: u64) -> Self {
        Cell::Count(count)
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Cell::Count(count as u64)
    }
}

impl From<Interval> for Cell {
    fn from(interval: Interval) -> Self {
        Cell::Interval(interval)
    }
}

impl From<Outcome> for Cell {
    fn from(outcome: Outcome) -> Self {
        Cell::Outcome(outcome)
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Cell::Missing, Into::into)
    }
}
