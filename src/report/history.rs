//! Records kept over time, as a page: what changed in which record, and a small chart of each quantity that did.

use super::svg::{INK, LETTER, Scale, line, printed, text, whole};
use crate::checks::record::Record;
use crate::checks::{Check, verdict};
use crate::compare::baseline::diff::{Change, Changed, Pace};
use crate::compare::baseline::history::{History, Series, Value};
use crate::document::{Cell, Colour, Document, Drawing, Section, Table, rounded};

/// A chart and the room around it.
const PANEL: [f64; 2] = [300.0, 84.0];
const ROOM: [f64; 2] = [24.0, 56.0];
const LEFT: f64 = 76.0;
const ACROSS: usize = 2;
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
            let more = self.series.len().saturating_sub(MOST);
            let words = match more {
                0 => String::new(),
                more => format!("{more} more are in the file of numbers."),
            };
            sections.push(Section::new("Over time", words).with(self.charts()));
        }
        Document {
            title: format!("History of {}", newest.job),
            verdict: verdict(&checks_now),
            answer: self.answer(),
            sections,
            checks: checks_now,
        }
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

    fn charts(&self) -> Drawing {
        let values = self.series.iter().flat_map(|series| {
            let values = series.values.iter().enumerate();
            values.filter_map(move |(at, value)| Some((series, at, value.as_ref()?)))
        });
        let changed = |series: &Series, at: usize| {
            if series.changed.contains(&at) {
                "yes"
            } else {
                ""
            }
        };
        let table = Table::of("history", "", values)
            .column("quantity", |(series, ..)| &series.name)
            .column("record", |(_, at, _)| Cell::Code(self.names[at].clone()))
            .column("value", |(.., value)| value.value)
            .column("from", |(.., value)| value.between[0])
            .column("to", |(.., value)| value.between[1])
            .column("changed", |(series, at, _)| changed(series, at));
        let mut svg = String::new();
        let mut below = 0.0;
        for (index, series) in self.series.iter().take(MOST).enumerate() {
            let [column, row] = [index % ACROSS, index / ACROSS].map(|number| number as f64);
            let left = LEFT + column * (PANEL[0] + LEFT + ROOM[0]);
            let top = 30.0 + row * (PANEL[1] + ROOM[1]);
            svg += &self.chart(series, [left, top]);
            below = top + PANEL[1] + 26.0;
        }
        let width = (PANEL[0] + LEFT + ROOM[0]) * ACROSS as f64;
        Drawing {
            caption: "Each quantity through the records: a ring where it changed; limits of checks are dashed, bars go from the \
                      least to the largest of a speed's rounds"
                .to_owned(),
            svg: whole([width, below], "Quantities through the records", &svg),
            table: table.into(),
        }
    }

    fn chart(&self, series: &Series, [left, top]: [f64; 2]) -> String {
        let numbers = series.values.iter().flatten();
        let numbers =
            numbers.flat_map(|value| [Some(value.value), value.between[0], value.between[1]]);
        let finite = numbers.flatten().filter(|number| number.is_finite());
        let ends = finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], number| {
            [low.min(number), high.max(number)]
        });
        let ends = match ends {
            [low, high] if low < high => ends,
            [low, _] if low.is_finite() => [low - 1.0, low + 1.0],
            _ => [0.0, 1.0],
        };
        let last = (self.names.len() - 1).max(1) as f64;
        let x = Scale::linear([0.0, last], [left + 8.0, left + PANEL[0] - 8.0]);
        let y = Scale::linear(ends, [top + PANEL[1] - 8.0, top + 8.0]);
        let [grey, blue, red] = [Colour::Grey, Colour::Blue, Colour::Vermilion].map(Colour::hex);
        let mut svg = format!(
            "<rect x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"{INK}\"/>",
            PANEL[0], PANEL[1]
        );
        let fits = (PANEL[0] / LETTER) as usize;
        let unit = if series.unit.is_empty() { "" } else { ", " };
        let words = format!("{}{unit}{}", series.name, series.unit);
        let letters = words.chars().count();
        // Ids differ in their last words.
        let title = match letters.checked_sub(fits) {
            None | Some(0) => words,
            Some(more) => format!("…{}", words.chars().skip(more + 1).collect::<String>()),
        };
        svg += &text([left, top - 8.0], "start", &title);
        let made = || {
            let values = series.values.iter().enumerate();
            values.filter_map(|(at, entry)| entry.map(|value| (at as f64, value)))
        };
        let shown = || made().filter(|(_, value)| value.value.is_finite());
        for side in [0, 1] {
            let limit = |(at, value): (f64, Value)| {
                let end = value.between[side].filter(|end| end.is_finite())?;
                Some([x.place(at), y.place(end)])
            };
            if !series.is_speed {
                let path = line(made().filter_map(limit));
                svg += &format!(
                    "<path fill=\"none\" stroke=\"{grey}\" stroke-dasharray=\"6 4\" d=\"{path}\"/>"
                );
            }
        }
        let path = line(shown().map(|(at, value)| [x.place(at), y.place(value.value)]));
        svg +=
            &format!("<path fill=\"none\" stroke=\"{blue}\" stroke-width=\"1.8\" d=\"{path}\"/>");
        for (at, value) in shown() {
            let [from, to] = value.between.map(|end| end.map(|number| y.place(number)));
            let at_x = x.place(at);
            if let (true, Some(from), Some(to)) = (series.is_speed, from, to) {
                svg += &format!("<path stroke=\"{blue}\" d=\"M{at_x:.1} {from:.1}V{to:.1}\"/>");
            }
            let at_y = y.place(value.value);
            let ring = match series.changed.contains(&(at as usize)) {
                true => format!("r=\"5\" fill=\"#fff\" stroke=\"{red}\" stroke-width=\"2\""),
                false => format!("r=\"2.2\" fill=\"{blue}\""),
            };
            svg += &format!("<circle cx=\"{at_x:.1}\" cy=\"{at_y:.1}\" {ring}/>");
        }
        for end in ends {
            svg += &text([left - 6.0, y.place(end) + 4.5], "end", &printed(end, 4));
        }
        let floor = top + PANEL[1] + 16.0;
        // The names of the first record and of the last change: more find no room.
        svg += &text([left, floor], "start", &short(&self.names[0]));
        if let Some(at) = series.changed.last().filter(|at| **at > 0) {
            let place = x.place(*at as f64);
            let (place, anchor) = match place > left + 0.7 * PANEL[0] {
                true => (left + PANEL[0], "end"),
                false => (place.max(left + 0.5 * PANEL[0]), "middle"),
            };
            svg += &text([place, floor], anchor, &short(&self.names[*at]));
        }
        svg
    }
}

/// As much of a name as tells commits apart.
fn short(name: &str) -> String {
    name.chars().take(12).collect()
}
