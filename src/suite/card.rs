//! What an engine's parameters really mean: each constant is asked for in an experiment of one or two grains, and read from how
//! the grains move, in the plane and in space. Forces that the engine writes play no part.

mod asked;
mod causes;
mod pictures;
mod readings;
mod unread;

use serde::Serialize;

use crate::checks::{Check, Outcome, verdict};
use crate::document::table::{Cell, Table, rounded};
use crate::document::{Document, Plot, Section};
use crate::engine::{Description, Engine, EngineError, ProgramError};
use crate::files::work_folder;
use crate::suite::Track;
use asked::{About, Kind, Quantity, quantities};
use causes::tell_causes;
use grains::rules::{Choice, Rules};
use grains::task::Case;
use grains::variant::{Form, Variant, run};
use pictures::{Line, lines, pictures};
use unread::unread;

/// How far what is read may be from what it should be, as a share of it: single precision, in differences of velocities.
const TOLERANCE: f64 = 1.0e-4;
/// Stands in the names of what two grains have of each other whatever the law is.
const OF_BOTH: &str = "on the first grain over that on the last";
/// What is said of a row that is right.
const AS_ASKED: &str = "as asked";
/// How the words of a row end that has no cause.
const IS_RIGHT: &str = " times what is right";
/// So many causes are told in the answer; all of them are in the table.
const TOLD: usize = 6;
/// And so many keys that were not read.
const UNREAD_TOLD: usize = 8;

/// A row of the card.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    #[serde(flatten)]
    about: About,
    /// What the native engine's trajectory shows under the model's rules; it is not exactly what was asked where time has steps.
    pub right: f64,
    /// What this engine's shows; none where it was not asked.
    pub shown: Option<f64>,
    /// The rules that it declares, what would explain the difference, or why it was not asked.
    pub why: String,
    pub outcome: Outcome,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Card {
    pub engine: Description,
    pub rows: Vec<Row>,
    /// Keys and rules with their values that no reading that was made would show.
    pub not_read: Vec<String>,
    #[serde(skip)]
    pictures: Vec<Plot>,
}

/// Asks the engine for everything.
pub fn card(engine: &dyn Engine) -> Result<Card, EngineError> {
    let described = engine.describe()?;
    let all = quantities(&described);
    let lines = lines(&described).into_iter();
    let lines = lines.filter(|line| engine.lacks_for(&line.case).is_none());
    let lines: Vec<Line> = lines.collect();
    let lacking: Vec<Option<String>> = all
        .iter()
        .map(|reading| engine.lacks_for(&reading.case))
        .collect();
    let asked = all
        .iter()
        .zip(&lacking)
        .filter(|(_, lacks)| lacks.is_none());
    let cases = asked.map(|(reading, _)| &reading.case);
    let cases: Vec<&Case> = cases.chain(lines.iter().map(|line| &line.case)).collect();
    let work = work_folder().map_err(ProgramError::File)?;
    let mut answers = engine.run_cases(&cases, work.path())?.into_iter();
    let own: Vec<Result<Track, String>> = lacking
        .into_iter()
        .map(|lacks| match lacks {
            Some(lacks) => Err(format!("it has no {lacks}")),
            None => answers
                .next()
                .unwrap_or_else(|| Err("it did not answer".to_owned())),
        })
        .collect();
    let rows = card_of(&all, own, described.rules);
    let lines = lines.into_iter().zip(answers).filter_map(|(line, answer)| {
        let right = run(&line.case, &variant(described.rules));
        let points = [(line.trace)(&answer.ok()?), (line.trace)(&right)];
        Some((line, points))
    });
    let pictures = pictures(&lines.collect::<Vec<_>>());
    let read = all.iter().zip(&rows);
    let read = read.filter(|(_, row)| row.shown.is_some());
    let read: Vec<&Quantity> = read.map(|(quantity, _)| quantity).collect();
    let not_read = unread(&read, &described, variant(described.rules));
    Ok(Card {
        engine: described,
        rows,
        not_read,
        pictures,
    })
}

/// What these answers show, and why.
fn card_of(
    all: &[Quantity],
    answers: impl IntoIterator<Item = Result<Track, String>>,
    declared: Rules,
) -> Vec<Row> {
    let answered = all.iter().zip(answers);
    let rows = answered.map(|(quantity, answer)| quantity.row(answer, declared));
    let mut rows: Vec<Row> = rows.collect();
    tell_causes(all, &mut rows, declared, variant(declared));
    rows
}

impl Quantity {
    fn row(&self, answer: Result<Track, String>, declared: Rules) -> Row {
        let mut row = Row {
            about: self.about.clone(),
            right: self.of(&Variant::default()),
            shown: None,
            why: String::new(),
            outcome: Outcome::Skipped,
        };
        match answer {
            Err(why) => row.why = why,
            Ok(track) => {
                row.shown = Some((self.read)(&track));
                (row.outcome, row.why) = self.explained(&row, declared);
            }
        }
        row
    }

    /// What a variant's trajectory shows.
    fn of(&self, variant: &Variant) -> f64 {
        (self.read)(&run(&self.case, variant))
    }

    /// Whether this is right, or right by the rules that are declared.
    fn explained(&self, row: &Row, declared: Rules) -> (Outcome, String) {
        if row.is(row.right) {
            return (Outcome::Pass, AS_ASKED.to_owned());
        }
        let under = variant(declared);
        if !row.is(self.of(&under)) {
            return (Outcome::Fail, format!("{}{IS_RIGHT}", row.times_in_words()));
        }
        // Those without which it would not be.
        let needed = |choice: &Choice| {
            let mut without = under.clone();
            without.forms.retain(|form| *form != Form::Rule(*choice));
            !row.is(self.of(&without))
        };
        // Of rules that each suffice none is needed.
        let suffices = |choice: &Choice| row.is(self.of(&Variant::of(Form::Rule(*choice))));
        let mut names: Vec<Choice> = declared.unusual().filter(needed).collect();
        if names.is_empty() {
            names = declared.unusual().filter(suffices).collect();
        }
        let names: Vec<String> = names.into_iter().map(Choice::name).collect();
        (
            Outcome::Pass,
            format!("as it declares: {}", names.join(", ")),
        )
    }
}

impl Row {
    /// Whether the engine's trajectory shows this.
    fn is(&self, value: f64) -> bool {
        let near = |shown: f64| (shown - value).abs() <= TOLERANCE * self.right.abs();
        self.shown.is_some_and(near)
    }

    /// What it is of, at whatever speed.
    fn constant(&self) -> &str {
        self.about.name.split(", ").next().unwrap_or_default()
    }

    /// What is shown over what is right, in words.
    fn times_in_words(&self) -> String {
        let times = self.times();
        let is_nothing = times.abs() < TOLERANCE;
        rounded(if is_nothing { 0.0 } else { times }, 5)
    }

    /// What is shown over what is right.
    fn times(&self) -> f64 {
        self.shown.unwrap_or(f64::NAN) / self.right
    }
}

/// With these rules.
fn variant(rules: Rules) -> Variant {
    Variant {
        forms: rules.unusual().map(Form::Rule).collect(),
        ..Variant::default()
    }
}

impl Card {
    pub fn checks(&self) -> Vec<Check> {
        let check = |row: &Row| {
            let words = format!("{}, {}", row.about.name, row.about.place);
            let check = Check::of_words(
                format!("card/{}", row.about.key),
                &words,
                row.outcome,
                &row.why,
            );
            let mut check = check.with_limits(
                row.shown.unwrap_or(f64::NAN),
                row.right,
                Some(TOLERANCE * row.right.abs()),
            );
            row.about.unit.clone_into(&mut check.unit);
            check
        };
        self.rows.iter().map(check).collect()
    }

    /// What the page says nothing about.
    fn unread_in_words(&self) -> String {
        if self.not_read.is_empty() {
            return String::new();
        }
        let told: Vec<&str> = self
            .not_read
            .iter()
            .take(UNREAD_TOLD)
            .map(String::as_str)
            .collect();
        let more = match self.not_read.len() - told.len() {
            0 => String::new(),
            more => format!(" and {more} others"),
        };
        format!(" Not read: {}{more}.", told.join("; "))
    }

    pub fn document(&self) -> Document {
        let checks = self.checks();
        let other = self.rows.iter().filter(|row| row.outcome == Outcome::Fail);
        let other: Vec<&Row> = other.collect();
        let asked = self.rows.iter().filter(|row| row.shown.is_some()).count();
        let answer = match (other.is_empty(), asked) {
            (_, 0) => "It has nothing of what is asked for.".to_owned(),
            (true, _) => {
                format!("All {asked} constants that it was asked for are what its grains show.")
            }
            (false, _) => format!(
                "{} of {asked} constants are not what was asked for: {}.",
                other.len(),
                causes(&other)
            ),
        };
        let answer = format!("{answer}{}", self.unread_in_words());
        let about = "Read from how grains move from one step to the next; forces that the engine writes play no part. Right is what the same \
                     reading gives of the native engine, whose steps are the same. In space normals and tangents are askew to the axes.";
        let sections = Kind::ALL.into_iter().filter_map(|kind| {
            let own = self.rows.iter().filter(|row| row.about.kind == kind);
            let own: Vec<&Row> = own.collect();
            (!own.is_empty()).then(|| section(kind, &own))
        });
        let mut sections: Vec<Section> = sections.collect();
        if let Some(first) = sections.first_mut() {
            about.clone_into(&mut first.answer);
        }
        let unusual = self.rows.iter().filter(|row| row.why != AS_ASKED);
        let unusual: Vec<&Row> = unusual.filter(|row| row.shown.is_some()).collect();
        if !unusual.is_empty() {
            let table = table("card-otherwise", "Otherwise than asked", unusual);
            sections.insert(0, Section::new("Otherwise than asked", "").with(table));
        }
        if !self.not_read.is_empty() {
            let table = Table::of("card-not-read", "Not read", &self.not_read)
                .column("key or rule", |what: &String| what);
            sections.push(
                Section::new("Not read", "No reading shows whether these are right.")
                    .with(Table::from(table)),
            );
        }
        let plots = Section::new("Contacts in space", "").with_all(self.pictures.clone());
        sections.extend((!self.pictures.is_empty()).then_some(plots));
        let all =
            Section::new("All constants", "").with(table("card", "Asked and shown", &self.rows));
        sections.push(Section {
            details: true,
            ..all
        });
        Document {
            title: format!("Card of {}", self.engine.label()),
            verdict: if asked == 0 {
                Outcome::Skipped
            } else {
                verdict(&checks)
            },
            answer,
            sections,
            checks,
        }
    }
}

/// Each cause once, with the first constant that it makes wrong, and each constant that has none; what the law cannot be at all first.
fn causes(wrong: &[&Row]) -> String {
    let has_none = |row: &Row| row.why.ends_with(IS_RIGHT);
    let group = |row: &Row| match has_none(row) {
        true => row.constant().to_owned(),
        false => row.why.clone(),
    };
    let mut told: Vec<(&Row, usize)> = Vec::new();
    for row in wrong {
        match told
            .iter_mut()
            .find(|(first, _)| group(first) == group(row))
        {
            Some((_, count)) => *count += 1,
            None => told.push((row, 1)),
        }
    }
    told.sort_by_key(|(row, _)| has_none(row) && !row.about.name.contains(OF_BOTH));
    let rest: usize = told.iter().skip(TOLD).map(|(_, count)| count).sum();
    let words = told.iter().take(TOLD).map(|(row, count)| {
        let in_space = if row.about.kind.in_space() {
            " in space"
        } else {
            ""
        };
        let likewise = match count {
            1 => String::new(),
            _ => format!(" ({} more)", count - 1),
        };
        let (name, place, why) = (&row.about.name, &row.about.place, &row.why);
        format!("{name} at {place}{in_space}: {why}{likewise}")
    });
    let mut words: Vec<String> = words.collect();
    if rest > 0 {
        words.push(format!("{rest} others"));
    }
    words.join("; ")
}

/// A row for each.
fn table<'a>(name: &str, title: &str, rows: impl IntoIterator<Item = &'a Row>) -> Table {
    let columns = Table::of(name, title, rows)
        .column("constant", |row: &Row| &row.about.name)
        .column("at", |row: &Row| row.about.place)
        .column("where", |row: &Row| row.about.kind.name())
        .column("asked", |row: &Row| row.about.asked)
        .column("right", |row: &Row| row.right)
        .column("shown", |row: &Row| row.shown)
        .column("unit", |row: &Row| row.about.unit)
        .column("which is", |row: &Row| &row.why);
    columns.into()
}

/// A row for each constant and a column for each place.
fn section(kind: Kind, rows: &[&Row]) -> Section {
    let mut names: Vec<&String> = Vec::new();
    let mut places: Vec<&str> = Vec::new();
    for row in rows {
        if !names.contains(&&row.about.name) {
            names.push(&row.about.name);
        }
        if !places.contains(&row.about.place) {
            places.push(row.about.place);
        }
    }
    let name = ["card-plane", "card-linear", "card-hertz"][kind as usize];
    let mut table = Table::of(name, "Pass, or so many times what is right", names)
        .column("constant", |name: &String| name);
    for place in places {
        table = table.column(place, |name: &String| {
            let cells = rows
                .iter()
                .filter(|row| (&row.about.name, row.about.place) == (name, place));
            cells.fold(Cell::Missing, |cell, row| match (row.outcome, cell) {
                (Outcome::Skipped, cell) => cell,
                (Outcome::Pass, cell @ (Cell::Text(_) | Cell::Outcome(_))) => cell,
                (Outcome::Pass, _) => Cell::Outcome(Outcome::Pass),
                _ => Cell::Text(format!("{} ×", row.times_in_words())),
            })
        });
    }
    Section::new(kind.name(), "").with(Table::from(table))
}
