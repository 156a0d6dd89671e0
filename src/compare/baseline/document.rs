//! What a run held against a baseline says to people.

use super::diff::{Change, Changed, Diff, Pace};
use crate::checks::record::Record;
use crate::checks::{Check, Outcome};
use crate::document::{Cell, Document, Section, Table, rounded};

/// Checks and numbers that moved, in a table of those that moved most.
const MOST_MOVED: usize = 12;

impl Record {
    /// What all records have, and what a baseline says of it.
    pub fn document(&self, diff: Option<&Diff>) -> Document {
        Document {
            title: self.job.clone(),
            verdict: self.verdict,
            answer: format!("`{}`, crossgrain {}.", self.command, self.crossgrain),
            sections: diff.map(|diff| diff.section(false)).into_iter().collect(),
            checks: self.checks.clone(),
        }
    }
}

impl Diff {
    /// As a document of its own.
    pub fn document(&self, all: bool) -> Document {
        Document {
            title: format!("Against the baseline {}", self.baseline),
            verdict: self.verdict,
            answer: self.answer(),
            sections: vec![self.section(all)],
            checks: Vec::new(),
        }
    }

    /// New failures as a number, as pages name them under `What failed`, and every speed that is slower; a line each.
    pub fn worse(&self) -> Vec<String> {
        let new = |of: &&Changed| of.change == Change::NewFailure;
        let failures = self.changes.iter().filter(new).count();
        let failures = (failures > 0).then(|| format!("new failures: {failures}"));
        failures.into_iter().chain(self.slower()).collect()
    }

    fn slower(&self) -> impl Iterator<Item = String> {
        let slower = self.speeds.iter().filter(|of| of.pace == Pace::Slower);
        slower.map(|of| format!("slower: {}", of.in_a_line()))
    }

    /// What is worse and the counts, in a sentence.
    pub fn answer(&self) -> String {
        let word = match self.verdict {
            Outcome::Pass => "Nothing is worse than in",
            Outcome::Fail => "WORSE than",
            Outcome::Skipped | Outcome::ExpectedFailure => "Some of it cannot be told against",
        };
        let slower: String = self.slower().map(|of| format!("; {of}")).collect();
        format!("{word} {}: {}{slower}", self.baseline, self.in_a_line())
    }

    /// What is not as it was, the worst first; `all` that moved, or what moved most.
    pub fn section(&self, all: bool) -> Section {
        let most = if all { usize::MAX } else { MOST_MOVED };
        let columns = [
            "change",
            "check",
            "before",
            "now",
            "moved by so many tolerances",
        ];
        let mut changes = Table::new("changes", "", &columns);
        let (moved, others): (Vec<_>, Vec<_>) = self
            .changes
            .iter()
            .partition(|of| of.change == Change::Moved);
        for of in others.into_iter().chain(moved.into_iter().take(most)) {
            let side = |check: &Option<Check>| Cell::from(check.as_ref().map(Check::in_a_line));
            let words = match of.change {
                Change::NewFailure => of.change.words().to_uppercase(),
                change => change.words().to_owned(),
            };
            changes.row([
                words.into(),
                Cell::Code(of.id.clone()),
                side(&of.before),
                side(&of.after),
                of.share_of_tolerance.into(),
            ]);
        }
        let title = format!(
            "{} of {} measured numbers moved",
            self.moved.len(),
            self.moved.len() + self.unmoved
        );
        let mut numbers = Table::new(
            "moved",
            &title,
            &["measured", "before", "now", "relative difference", "unit"],
        );
        for of in self.moved.iter().take(most) {
            let id = Cell::Code(of.id.clone());
            numbers.row([
                id,
                of.before.into(),
                of.after.into(),
                of.relative.into(),
                of.unit.as_str().into(),
            ]);
        }
        let mut speeds = Table::new(
            "speeds",
            "",
            &["speed", "what", "before", "now", "times the cost", "unit"],
        );
        for of in &self.speeds {
            let cost = of.cost.map(|cost| rounded(cost, 4));
            let pace = Cell::from(of.pace.words());
            speeds.row([
                pace,
                of.what.as_str().into(),
                of.before.into(),
                of.after.into(),
                cost.into(),
                of.unit.as_str().into(),
            ]);
        }
        let mut section = Section::new(
            &format!("What changed since {}", self.baseline),
            self.answer(),
        );
        for table in [changes, numbers, speeds] {
            if !table.rows.is_empty() {
                section = section.with(table);
            }
        }
        if !self.same_machine && !self.speeds.is_empty() {
            section = section.with("Speeds are not judged: the machines are not of one kind.");
        }
        section
    }
}
