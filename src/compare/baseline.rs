//! Baselines: the checks of a run, kept under a name to hold later runs against, and what that says, as checks and to people.
//! Only an explicit command changes one.

pub mod diff;
pub mod history;

use std::path::{Path, PathBuf};

use diff::{Change, Changed, Diff, Pace, SpeedPair, UNTOLD, WORSE};
use serde::{Deserialize, Serialize};

use crate::checks::record::{Record, UNSEALED, is_sealed, sealed};
use crate::checks::{Check, Outcome};
use crate::document::{Cell, Document, Section, Table, rounded};
use crate::files::{
    FileError, Listed, Place, listed, make_folder, read_text, sha256_hex, write_new, write_whole,
};

/// The version of a baseline's file.
const VERSION: u32 = 2;

/// Longest file that is read, bytes.
const LONGEST: u64 = 200_000_000;

const LONGEST_NAME: usize = 100;

/// A run's checks under a name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Baseline {
    pub baseline: u32,
    pub name: String,
    /// SHA-256 of the record that it was made from.
    pub source: String,
    /// The record without what is the job's own.
    pub record: Record,
    /// From version 2 on, as in records.
    #[serde(default, skip_serializing)]
    record_digest: Option<String>,
}

#[derive(Debug, thiserror::Error)]
pub enum BaselineError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error(
        "{0:?} is no name for a baseline: letters, digits, '.', '_' and '-', at most {LONGEST_NAME}, not beginning with '.'"
    )]
    Name(String),
    #[error("there is a baseline {name} in {store} already; --replace puts this run in its place")]
    Exists { name: String, store: String },
    #[error("there is no baseline {name} in {store}; {there}")]
    Missing {
        name: String,
        store: String,
        there: String,
    },
    #[error("{path} is no baseline: {reason}; save it again from a run")]
    Malformed { path: String, reason: String },
}

/// Where there is no baseline.
pub const NONE: &str = "there are none yet; crossgrain report baseline save makes one";

/// As many files of a folder of baselines are looked at.
const MOST_FILES: usize = 100_000;

/// The folder of baselines.
#[derive(Debug, Clone)]
pub struct Store(PathBuf);

impl Store {
    /// In this folder, which need not exist.
    pub fn new(folder: &Path) -> Self {
        Store(folder.to_owned())
    }

    /// The name of its file in the folder.
    fn file(name: &str) -> Result<String, BaselineError> {
        let plain = |letter: char| letter.is_ascii_alphanumeric() || "._-".contains(letter);
        let sound = !name.is_empty()
            && name.len() <= LONGEST_NAME
            && !name.starts_with('.')
            && name.chars().all(plain);
        if !sound {
            return Err(BaselineError::Name(name.to_owned()));
        }
        Ok(format!("{name}.json"))
    }

    /// Keeps the record of a finished job; a baseline of that name stays as it is unless it is to be replaced.
    pub fn save(&self, record: &Path, name: &str, replace: bool) -> Result<PathBuf, BaselineError> {
        let file = Store::file(name)?;
        let place = Place::from((&self.0, &file));
        let exists = || BaselineError::Exists {
            name: name.to_owned(),
            store: self.0.display().to_string(),
        };
        if place.is_taken() && !replace {
            return Err(exists());
        }
        let text = read_text(record, LONGEST)?;
        let baseline = Baseline {
            baseline: VERSION,
            name: name.to_owned(),
            source: sha256_hex(text.as_bytes()),
            record: crate::checks::record::read(record)?,
            record_digest: None,
        };
        let malformed = |error: serde_json::Error| BaselineError::Malformed {
            path: record.display().to_string(),
            reason: error.to_string(),
        };
        let text = serde_json::to_string_pretty(&baseline).map_err(malformed)?;
        make_folder(&self.0)?;
        let write = if replace { write_whole } else { write_new };
        match write(place, sealed(&text).as_bytes()) {
            Ok(()) => Ok(place.path()),
            // Another program was faster.
            Err(FileError::Exists { .. }) => Err(exists()),
            Err(error) => Err(error.into()),
        }
    }

    pub fn load(&self, name: &str) -> Result<Baseline, BaselineError> {
        let file = Store::file(name)?;
        let place = Place::from((&self.0, &file));
        if !place.is_taken() {
            let names = self.names()?;
            return Err(BaselineError::Missing {
                name: name.to_owned(),
                store: self.0.display().to_string(),
                there: match &names[..] {
                    [] => NONE.to_owned(),
                    names => format!("there are {}", names.join(", ")),
                },
            });
        }
        let malformed = |reason: String| BaselineError::Malformed {
            path: place.path().display().to_string(),
            reason,
        };
        let text = read_text(place, LONGEST)?;
        let baseline: Baseline =
            serde_json::from_str(&text).map_err(|error| malformed(error.to_string()))?;
        if baseline.baseline == VERSION && !is_sealed(&text) {
            return Err(malformed("it was changed after it was written".to_owned()));
        }
        if ![UNSEALED, VERSION].contains(&baseline.baseline) {
            return Err(malformed(format!(
                "version {} of the format, where this program knows {VERSION}",
                baseline.baseline
            )));
        }
        Ok(baseline)
    }

    /// The names of all baselines, in order; none where there is no such folder.
    pub fn names(&self) -> Result<Vec<String>, BaselineError> {
        let found = listed(&self.0, MOST_FILES)?.into_iter();
        let name = |entry: Listed| Some(entry.name.to_str()?.strip_suffix(".json")?.to_owned());
        let mut names: Vec<String> = found.filter_map(name).collect();
        names.sort();
        Ok(names)
    }
}

/// Names in a check's words at most; the rest is counted.
const MOST_NAMES: usize = 5;

/// New failures, what can no longer be told, bits where they are demanded, and every speed.
pub fn checks(diff: &Diff) -> Vec<Check> {
    let what = "checks that fail and did not, or fail worse";
    let failures = counted(diff, "new-failures", what, &WORSE, Outcome::Fail);
    let what = "checks that are gone, no longer made, defined otherwise or fail in other words";
    let untold = counted(diff, "told-no-more", what, &UNTOLD, Outcome::Skipped);
    let speeds = diff.speeds.iter().map(speed);
    let bits = diff.bits_demanded.then(|| bits(diff));
    let all = [failures.required(), untold.required()];
    all.into_iter().chain(bits).chain(speeds).collect()
}

fn bits(diff: &Diff) -> Check {
    let moved = diff.all_moved() as f64;
    let outcome = Outcome::pass_if(diff.all_moved() == 0);
    let quantity = format!("numbers with other bits than in baseline {}", diff.baseline);
    Check::of_words("baseline/bits", &quantity, outcome, "")
        .with_limits(moved, 0.0, Some(0.0))
        .judged_by(
            "the value of every check and every measured number is held against the one of the same id",
            "--bits",
        )
}

/// How many changes are of these kinds; with any it comes to `otherwise`.
fn counted(diff: &Diff, id: &str, what: &str, kinds: &[Change], otherwise: Outcome) -> Check {
    let changes = diff.changes.iter();
    let changes = changes.filter(|change| kinds.contains(&change.change));
    let ids: Vec<&str> = changes.map(|change| change.id.as_str()).collect();
    let mut found = ids[..ids.len().min(MOST_NAMES)].join(", ");
    if ids.len() > MOST_NAMES {
        found += &format!(" and {} more", ids.len() - MOST_NAMES);
    }
    let outcome = if ids.is_empty() {
        Outcome::Pass
    } else {
        otherwise
    };
    let quantity = format!("{what} in baseline {}", diff.baseline);
    let method = "every check is held against the one of the same id";
    Check::of_words(format!("baseline/{id}"), &quantity, outcome, &found)
        .with_limits(ids.len() as f64, 0.0, Some(0.0))
        .judged_by(method, "docs/checks.md")
}

/// A cost over that of the baseline, beyond what scatters.
fn speed(pair: &SpeedPair) -> Check {
    let outcome = match pair.pace {
        Pace::Slower => Outcome::Fail,
        Pace::Faster | Pace::Same => Outcome::Pass,
        Pace::NotJudged => Outcome::Skipped,
    };
    let id = format!("baseline/speed/{}", pair.id);
    let what = "cost over the baseline's";
    let mut check = Check::of_words(id, what, outcome, &pair.in_a_line());
    check.value = pair.cost.filter(|cost| cost.is_finite());
    check.expected = Some(1.0);
    check.upper = pair.scatter.is_finite().then_some(pair.scatter);
    check.judged_by(
        "a ratio of times in one run over the same of the baseline",
        "the scatter of rounds, docs/checks.md",
    )
}

/// Checks and numbers that moved, in a table of those that moved most.
const MOST_MOVED: usize = 12;

impl Record {
    /// What all records have.
    pub fn document(&self) -> Document {
        Document {
            title: self.job.clone(),
            verdict: self.verdict,
            answer: format!("`{}`, crossgrain {}.", self.command, self.crossgrain),
            sections: Vec::new(),
            checks: self.checks.clone(),
        }
    }
}

impl Diff {
    pub fn document(&self, all: bool) -> Document {
        Document {
            title: format!("Against the baseline {}", self.baseline),
            verdict: self.verdict,
            answer: self.answer(),
            sections: vec![self.section(all)],
            checks: checks(self),
        }
    }

    /// Failures that are new or worse as numbers, as pages name them under `What failed`, and every speed that is slower; a line each.
    pub fn worse(&self) -> Vec<String> {
        let failures = WORSE.into_iter().filter_map(|change| {
            let count = self
                .changes
                .iter()
                .filter(|found| found.change == change)
                .count();
            (count > 0).then(|| format!("{}s: {count}", change.words()))
        });
        failures.chain(self.slower()).collect()
    }

    fn slower(&self) -> impl Iterator<Item = String> {
        let slower = self.speeds.iter().filter(|pair| pair.pace == Pace::Slower);
        slower.map(|pair| format!("slower: {}", pair.in_a_line()))
    }

    /// What is worse and the counts, in a sentence.
    pub fn answer(&self) -> String {
        let word = match self.verdict {
            Outcome::Pass => "Nothing is worse than in",
            Outcome::Fail => "WORSE than",
            Outcome::Skipped | Outcome::ExpectedFailure => "Some of it cannot be told against",
        };
        let slower: String = self.slower().map(|line| format!("; {line}")).collect();
        format!("{word} {}: {}{slower}", self.baseline, self.in_a_line())
    }

    /// What is not as it was, the worst first; `all` that moved, or what moved most.
    pub fn section(&self, all: bool) -> Section {
        let most = if all { usize::MAX } else { MOST_MOVED };
        let mut shown: Vec<&Changed> = self.changes.iter().collect();
        // They stand last, what moved most first.
        let others = shown
            .iter()
            .filter(|row| row.change != Change::Moved)
            .count();
        shown.truncate(others.saturating_add(most));
        let side = |check: &Option<Check>| check.as_ref().map(Check::in_a_line);
        let changes = Table::of("changes", "", shown)
            .column("change", |row| match row.change {
                change if WORSE.contains(&change) => change.words().to_uppercase(),
                change => change.words().to_owned(),
            })
            .column("check", |row| Cell::Code(row.id.clone()))
            .column("before", |row| side(&row.before))
            .column("now", |row| side(&row.after))
            .column("moved by so many tolerances", |row| row.share_of_tolerance);
        let moved = self.moved.len();
        let mut title = format!("{moved} of {} measured numbers moved", moved + self.unmoved);
        if moved > most {
            title += &format!(
                "; these {most} moved most (`crossgrain report baseline diff RECORD NAME --all` shows all)"
            );
        }
        let numbers = Table::of("moved", &title, self.moved.iter().take(most))
            .column("measured", |number| Cell::Code(number.id.clone()))
            .column("before", |number| number.before)
            .column("now", |number| number.after)
            .column("relative difference", |number| number.relative)
            .column("unit", |number| &number.unit);
        let speeds = Table::of("speeds", "", &self.speeds)
            .column("speed", |pair| pair.pace.words())
            .column("what", |pair| &pair.what)
            .column("before", |pair| pair.before)
            .column("now", |pair| pair.after)
            .column("times the cost", |pair| {
                pair.cost.map(|cost| rounded(cost, 4))
            })
            .column("unit", |pair| &pair.unit);
        let title = format!("What changed since {}", self.baseline);
        let tables = [Table::from(changes), numbers.into(), speeds.into()];
        let tables = tables.into_iter().filter(|table| !table.rows.is_empty());
        let mut section = Section::new(&title, self.answer()).with_all(tables);
        if !self.same_machine && !self.speeds.is_empty() {
            section = section.with("Speeds are not judged: the machines are not of one kind.");
        }
        section
    }
}
