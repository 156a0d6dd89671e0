//! Records kept over time, as a page: what changed in which record, and a small chart of each quantity that did.

use crate::checks::Check;
use crate::checks::record::Record;
use crate::compare::baseline::diff::{Change, Changed, Pace};
use crate::compare::baseline::history::{History, Series, Value};
use crate::document::{
    Axis, Cell, Colour, Document, Plot, Point, Section, Shape, Style, Table, rounded,
};

/// Charts that are drawn at most; the speeds come first, then what came to another outcome.
const MOST: usize = 24;

impl History {
    /// With the checks of the newest record; `subject` says what a record is of by its name.
    pub fn document(&self, newest: &Record, subject: impl Fn(&str) -> String) -> Document {
        let checks_now = [&newest.checks[..], &[self.slower()]].concat();
        let name = |at: usize| Cell::Code(short(&self.names[at]));
        let told = |at: usize| subject(&self.names[at]);
        let is_moved = Changed::is_as_good;
        let outcomes = self
            .changes
            .iter()
            .filter(|(_, changed)| !is_moved(changed));
        let value = |checked: &Option<Check>| checked.as_ref().and_then(|check| check.value);
        let limit = |changed: &Changed, side: fn(&Check) -> Option<f64>| {
            let check = changed.after.as_ref().or(changed.before.as_ref());
            check.and_then(side)
        };
        let checks = Table::of("changes", "Checks that came to another outcome", outcomes)
            .column("record", |(at, _)| name(*at))
            .column("subject", |(at, _)| told(*at))
            .column("change", |(_, changed)| changed.change.words())
            .column("check", |(_, changed)| Cell::Code(changed.id.clone()))
            .column("before", |(_, changed)| value(&changed.before))
            .column("then", |(_, changed)| value(&changed.after))
            .column("at least", |(_, changed)| {
                limit(changed, |check| check.lower)
            })
            .column("at most", |(_, changed)| {
                limit(changed, |check| check.upper)
            });
        let steps = Table::of("steps", "Speeds that changed", &self.steps)
            .column("record", |step| name(step.at))
            .column("subject", |step| told(step.at))
            .column("speed", |step| step.pace.words())
            .column("what", |step| &step.what)
            .column("times the cost", |step| rounded(step.cost, 4))
            .column("seen in the next record", |step| match step.confirmed {
                true => "yes",
                false => "there is none yet",
            });
        let moved = |at: usize| {
            let changes = self.changes.iter().filter(|(record, _)| *record == at);
            changes.filter(|(_, changed)| is_moved(changed)).count()
        };
        let moves = (0..self.names.len()).filter(|at| moved(*at) > 0);
        let title = "Checks whose value moved and outcome did not";
        let moves = Table::of("moves", title, moves)
            .column("record", name)
            .column("subject", told)
            .column("checks", |at| moved(at) as f64);
        let tables = [Table::from(checks), steps.into(), moves.into()];
        let tables = tables.into_iter().filter(|table| !table.rows.is_empty());
        let tables: Vec<Table> = tables.map(Table::without_empty_columns).collect();
        let words = if tables.is_empty() { "Nothing." } else { "" };
        let mut sections = vec![Section::new("What changed", words).with_all(tables)];
        if !self.series.is_empty() {
            let mut words = "A ring where it changed; limits of checks are dashed, bars go from the least to the largest of a speed's rounds."
                .to_owned();
            if let more @ 1.. = self.series.len().saturating_sub(MOST) {
                words += &format!(" {more} more are in the table of all.");
            }
            let charts = self
                .series
                .iter()
                .take(MOST)
                .map(|series| self.chart(series));
            sections.extend([
                Section::new("Over time", words).with_all(charts),
                Section::new("Every value", "")
                    .with(self.values())
                    .as_details(),
            ]);
        }
        let title = format!("History of {}", newest.job);
        Document::new(title, self.answer(), checks_now).with(sections)
    }

    fn answer(&self) -> String {
        let all = self.changes.iter();
        let changes = |change: Change| {
            all.clone()
                .filter(|(_, changed)| changed.change == change)
                .count()
        };
        let pace = |pace: Pace| self.steps.iter().filter(|step| step.pace == pace).count();
        let [new, worse, repaired] =
            [Change::NewFailure, Change::WorseFailure, Change::Fixed].map(changes);
        let failures = new + worse;
        let [slower, faster] = [Pace::Slower, Pace::Faster].map(pace);
        format!(
            "In {} records: new or worse failures {failures}, repaired {repaired}, slower {slower}, faster {faster}.",
            self.names.len()
        )
    }

    /// Every value of every quantity.
    fn values(&self) -> Table {
        let values = self.series.iter().flat_map(|series| {
            let values = series.values.iter().enumerate();
            values.filter_map(move |(at, value)| Some((series, at, value.as_ref()?)))
        });
        let changed = |series: &Series, at: usize| series.changed.contains(&at).then_some("yes");
        Table::of("every-value", "Every quantity in every record", values)
            .column("quantity", |(series, ..)| &series.name)
            .column("record", |(_, at, _)| Cell::Code(self.names[at].clone()))
            .column("value", |(.., value)| value.value)
            .column("from", |(.., value)| value.between[0])
            .column("to", |(.., value)| value.between[1])
            .column("changed", |(series, at, _)| changed(series, at))
            .into()
    }

    /// A quantity through the records. The names of the first record and of the last change stand below: more find no room.
    fn chart(&self, series: &Series) -> Plot {
        let changed = series.changed.last().copied().filter(|at| *at > 0);
        let named = [Some(0), changed].into_iter().flatten();
        let last = (self.names.len() - 1) as f64;
        let x = Axis {
            ticks: named
                .map(|at| (at as f64, short(&self.names[at])))
                .collect(),
            ..Axis::linear("").within(-0.02 * last, 1.02 * last)
        };
        let made = || {
            let values = series.values.iter().enumerate();
            values.filter_map(|(at, value)| Some((at, (*value)?)))
        };
        let point = |(at, value): (usize, Value)| {
            let point = Point::at(at as f64, value.value);
            match value.between {
                [Some(from), Some(to)] if series.is_speed => point.between(from, to),
                _ => point,
            }
        };
        let plot = Plot::new("history", &series.name, x, Axis::linear(&series.unit));
        let limits = [0, 1].map(|side| {
            let limit = |(at, value): (usize, Value)| Some([at as f64, value.between[side]?]);
            made().filter_map(limit).collect::<Vec<_>>()
        });
        let limits = limits.into_iter();
        let limits = limits.filter(|points| !series.is_speed && !points.is_empty());
        let plot = limits.fold(plot, |plot, points| {
            let dashed = true;
            plot.with("limits", Colour::Grey, Shape::Line { dashed, points })
        });
        let (rings, dots): (Vec<_>, Vec<_>) =
            made().partition(|(at, _)| series.changed.contains(at));
        let line = made().map(|(at, value)| [at as f64, value.value]);
        let rings = rings.into_iter().map(point);
        plot.line("", Colour::Blue, line)
            .points("", Colour::Blue, dots.into_iter().map(point))
            .group("changed", Colour::Vermilion, Style::Hollow, rings)
    }
}

/// As much of a name as tells commits apart.
fn short(name: &str) -> String {
    name.chars().take(12).collect()
}
