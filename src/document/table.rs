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
    pub columns: Vec<Column>,
    /// Each with a cell a column.
    pub rows: Vec<Vec<Cell>>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    pub title: String,
    /// SI unit; empty for words, counts and ratios.
    pub unit: String,
}

/// A value in a table; views choose digits, alignment and colours.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    Missing,
    Text(String),
    /// A command, key or file name, letter by letter.
    Code(String),
    Count(u64),
    /// A number; people see four significant digits, files all.
    Number(f64),
    Interval(Interval),
    Outcome(Outcome),
}

/// A table that gets its columns one after the other, each with what it shows of an item; an item is a row.
#[derive(Debug, Clone)]
pub struct Columns<T> {
    items: Vec<T>,
    table: Table,
}

impl<T: Copy> Columns<T> {
    /// With another column; its heading is `title` or `title, unit` after the last comma and a space.
    #[must_use]
    pub fn column<C: Into<Cell>>(mut self, heading: &str, cell: impl Fn(T) -> C) -> Self {
        self.table.columns.push(Column::parse(heading));
        for (row, item) in self.table.rows.iter_mut().zip(&self.items) {
            row.push(cell(*item).into());
        }
        self
    }
}

impl<T> From<Columns<T>> for Table {
    fn from(columns: Columns<T>) -> Self {
        columns.table
    }
}

impl Table {
    /// Of these items, a row each.
    pub fn of<T: Copy>(name: &str, title: &str, items: impl IntoIterator<Item = T>) -> Columns<T> {
        let items: Vec<T> = items.into_iter().collect();
        let table = Table {
            rows: vec![Vec::new(); items.len()],
            ..Table::new(name, title, &[])
        };
        Columns { items, table }
    }

    /// With columns, headed as in [`Columns::column`], and no rows yet.
    pub fn new(name: &str, title: &str, columns: &[&str]) -> Self {
        Table {
            name: name.to_owned(),
            title: title.to_owned(),
            columns: columns.iter().map(|column| Column::parse(column)).collect(),
            rows: Vec::new(),
        }
    }

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

becomes!(Cell {
    text: &str => Cell::Text(text.to_owned());
    text: &String => Cell::Text(text.clone());
    text: String => Cell::Text(text);
    value: f64 => Cell::Number(value);
    count: u32 => Cell::Count(count.into());
    count: u64 => Cell::Count(count);
    count: usize => Cell::Count(count as u64);
    interval: Interval => Cell::Interval(interval);
    outcome: Outcome => Cell::Outcome(outcome);
});

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Cell::Missing, Into::into)
    }
}

/// So many significant digits, without trailing zeros; a power of ten below 10⁻⁴ and from 10⁷ on.
pub fn rounded(value: f64, digits: usize) -> String {
    if value == 0.0 {
        // Of −0 too.
        return "0".to_owned();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    let trimmed = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    };
    // As the digits are after rounding: 9.9996 is 10.
    let scientific = format!("{value:.*e}", digits.max(1) - 1);
    let (mantissa, power) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    match power.parse::<i32>() {
        Ok(power) if (-4..7).contains(&power) => {
            let decimals = (digits as i32 - 1 - power).max(0) as usize;
            trimmed(&format!("{value:.decimals$}"))
        }
        _ => format!("{}e{power}", trimmed(mantissa)),
    }
}

impl Cell {
    /// For people: four significant digits.
    pub fn shown(&self) -> String {
        let short = |value: f64| rounded(value, 4);
        match self {
            Cell::Missing => "–".to_owned(),
            Cell::Text(text) | Cell::Code(text) => text.clone(),
            Cell::Count(count) => count.to_string(),
            Cell::Number(value) => short(*value),
            Cell::Interval(interval) => {
                let [mean, low, high] = [interval.estimate, interval.low, interval.high].map(short);
                format!("{mean} [{low}, {high}]")
            }
            Cell::Outcome(outcome) => outcome.word().to_owned(),
        }
    }

    /// Numbers stand right, with their last digits below each other.
    pub fn is_number(&self) -> bool {
        matches!(self, Cell::Count(_) | Cell::Number(_) | Cell::Interval(_))
    }
}

impl Table {
    /// Without the columns that hold nothing; a table without rows keeps its headings.
    #[must_use]
    pub fn without_empty_columns(mut self) -> Self {
        let there = |column: usize| {
            let mut cells = self.rows.iter().filter_map(|row| row.get(column));
            self.rows.is_empty() || cells.any(|cell| !matches!(cell.shown().as_str(), "–" | ""))
        };
        let kept: Vec<bool> = (0..self.columns.len()).map(there).collect();
        let mut keep_column = kept.iter();
        self.columns.retain(|_| keep_column.next() == Some(&true));
        for row in &mut self.rows {
            let mut keep_cell = kept.iter();
            row.retain(|_| keep_cell.next() == Some(&true));
        }
        self
    }

    /// Whether a column holds numbers, missing ones apart.
    pub fn has_numbers(&self, column: usize) -> bool {
        let mut cells = self.rows.iter().filter_map(|row| row.get(column));
        let mut there = cells.by_ref().filter(|cell| **cell != Cell::Missing);
        let first = there.next();
        first.is_some_and(Cell::is_number) && there.all(Cell::is_number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_are_asked_for() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (0.123_456, "0.1235"),
            (9.999_96, "10"),
            (-1234.56, "-1235"),
            (123_456.0, "123456"),
            (1.0e7, "1e7"),
            (9.9e-5, "9.9e-5"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(rounded(value, 4), text);
        }
        assert_eq!(rounded(2.0 / 3.0, 6), "0.666667");
    }

    #[test]
    fn a_column_with_a_unit() {
        let table = Table::from(
            Table::of("t", "", [1.0])
                .column("force, N", |force| 2.0 * force)
                .column("of, or not, in", |_| Cell::Missing)
                .column("name", |_| "weight"),
        );
        let units: Vec<&str> = table
            .columns
            .iter()
            .map(|column| column.unit.as_str())
            .collect();
        assert_eq!(units, ["N", "in", ""]);
        let row = vec![2.0.into(), Cell::Missing, "weight".into()];
        assert_eq!(table.rows, [row]);
    }
}
