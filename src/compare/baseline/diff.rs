//! A run held against a baseline: what is worse, what is better, what moved, and what cannot be told.

use std::collections::BTreeMap;

use serde::Serialize;

use super::Baseline;
use super::pace::speeds;
pub use super::pace::{Pace, SpeedPair};
use crate::checks::record::Record;
use crate::checks::{Check, Measured, Outcome};
use crate::compare::Verdict;

/// What became of a check. The order is that of reading: the worst first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// It fails now, and did not or was not there.
    NewFailure,
    /// It was made and is not now.
    NoLongerMade,
    /// It is gone.
    Removed,
    /// Its unit, method, basis or limits are others, so its values do not compare.
    DefinitionChanged,
    /// It failed and holds now.
    Fixed,
    /// It was not made and is now.
    NowMade,
    /// It was not there.
    Added,
    /// Its value is another, its outcome the same.
    Moved,
}

impl Change {
    /// For people.
    pub fn words(self) -> &'static str {
        match self {
            Change::NewFailure => "new failure",
            Change::NoLongerMade => "no longer made",
            Change::Removed => "removed",
            Change::DefinitionChanged => "definition changed",
            Change::Fixed => "fixed",
            Change::NowMade => "now made",
            Change::Added => "added",
            Change::Moved => "moved within tolerance",
        }
    }
}

/// A check that is not as it was.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Changed {
    /// Of the check.
    pub id: String,
    /// What became of it.
    pub change: Change,
    /// In the baseline.
    pub before: Option<Check>,
    /// In this run.
    pub after: Option<Check>,
    /// Value after minus value before, in the check's unit.
    pub by: Option<f64>,
    /// The same over what the limits leave to either side of what is expected.
    pub share_of_tolerance: Option<f64>,
}

/// A measured number that is not as it was.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MovedNumber {
    /// Of the number.
    pub id: String,
    /// SI unit.
    pub unit: String,
    /// In the baseline, if it was there.
    pub before: Option<f64>,
    /// In this run, if it is there.
    pub after: Option<f64>,
    /// |after − before| over the larger of the two; none where one is missing.
    pub relative: Option<f64>,
}

/// A run against a baseline.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Diff {
    /// The baseline's name.
    pub baseline: String,
    /// Versions of crossgrain, before and after.
    pub crossgrain: [String; 2],
    /// Commands, before and after.
    pub commands: [String; 2],
    /// Both were made on machines of the same kind.
    pub same_machine: bool,
    /// Every check that is not as it was, the worst first.
    pub changes: Vec<Changed>,
    /// Checks that are as they were, to the last bit.
    pub same: usize,
    /// Checks that fail now and failed before.
    pub still_failing: usize,
    /// Measured numbers that are others, the most by their own size first.
    pub moved: Vec<MovedNumber>,
    /// Measured numbers that are the same to the last bit.
    pub unmoved: usize,
    /// All speeds.
    pub speeds: Vec<SpeedPair>,
    /// Failed if anything is worse; not made if something can no longer be told; else passed.
    pub verdict: Verdict,
}

/// Limits that differ by less, relative to their width, are the same.
const SAME_WIDTH: f64 = 0.01;

/// Holds a run against a baseline.
pub fn diff(baseline: &Baseline, run: &Record) -> Diff {
    let before = &baseline.record;
    let by_id = |checks: &[Check]| -> BTreeMap<String, Check> {
        let pair = |check: &Check| (check.id.clone(), check.clone());
        checks.iter().map(pair).collect()
    };
    let (old, new) = (by_id(&before.checks), by_id(&run.checks));
    let mut changes = Vec::new();
    let mut same = 0;
    for (id, after) in &new {
        match changed(id, old.get(id), Some(after)) {
            Some(change) => changes.push(change),
            None => same += 1,
        }
    }
    let gone = old.iter().filter(|(id, _)| !new.contains_key(*id));
    changes.extend(gone.filter_map(|(id, check)| changed(id, Some(check), None)));
    let moved = |of: &Changed| of.share_of_tolerance.unwrap_or(0.0);
    changes.sort_by(|a, b| {
        let by_size = moved(b).total_cmp(&moved(a));
        a.change.cmp(&b.change).then(by_size).then(a.id.cmp(&b.id))
    });
    let same_machine = before.machine_kind == run.machine_kind && run.machine_kind.is_some();
    let speeds = speeds(&before.speeds, &run.speeds, same_machine);
    let failing = |id: &String| {
        let fails = |of: &BTreeMap<String, Check>| {
            of.get(id)
                .is_some_and(|check| check.outcome == Outcome::Fail)
        };
        fails(&old) && fails(&new)
    };
    let (moved, unmoved) = numbers(&before.measured, &run.measured);
    Diff {
        baseline: baseline.name.clone(),
        moved,
        unmoved,
        crossgrain: [before.crossgrain.clone(), run.crossgrain.clone()],
        commands: [before.command.clone(), run.command.clone()],
        same_machine,
        same,
        still_failing: new.keys().filter(|id| failing(id)).count(),
        verdict: verdict(&changes, &speeds),
        changes,
        speeds,
    }
}

impl Diff {
    /// Every measured number must be the same to the last bit, as in a change that is to change nothing.
    pub fn demanding_bits(mut self) -> Self {
        if !self.moved.is_empty() {
            self.verdict = Verdict::Fail;
        }
        self
    }

    /// The counts.
    pub fn in_a_line(&self) -> String {
        let mut parts = Vec::new();
        let mut count = |number: usize, words: &str| {
            if number > 0 {
                parts.push(format!("{number} {words}"));
            }
        };
        for change in [
            Change::NewFailure,
            Change::NoLongerMade,
            Change::Removed,
            Change::DefinitionChanged,
            Change::Fixed,
            Change::NowMade,
            Change::Added,
            Change::Moved,
        ] {
            let of = self.changes.iter().filter(|of| of.change == change);
            count(of.count(), change.words());
        }
        for (pace, words) in [(Pace::Slower, "slower"), (Pace::Faster, "faster")] {
            let of = self.speeds.iter().filter(|of| of.pace == pace);
            count(of.count(), words);
        }
        count(self.still_failing, "still failing");
        count(self.same, "as they were");
        let numbers = self.moved.len() + self.unmoved;
        if numbers > 0 {
            let of = self.moved.len();
            parts.push(format!("{of} of {numbers} measured numbers moved"));
        }
        parts.join(", ")
    }
}

fn verdict(changes: &[Changed], speeds: &[SpeedPair]) -> Verdict {
    let any = |wanted: &[Change]| changes.iter().any(|of| wanted.contains(&of.change));
    if any(&[Change::NewFailure]) || speeds.iter().any(|of| of.pace == Pace::Slower) {
        Verdict::Fail
    } else if any(&[
        Change::NoLongerMade,
        Change::Removed,
        Change::DefinitionChanged,
    ]) {
        Verdict::Skipped
    } else {
        Verdict::Pass
    }
}

/// None for a check that is as it was.
fn changed(id: &str, before: Option<&Check>, after: Option<&Check>) -> Option<Changed> {
    use Outcome::{Fail, Skipped};
    let change = match (before, after) {
        (None, None) => return None,
        (Some(_), None) => Change::Removed,
        (None, Some(after)) if after.outcome == Fail => Change::NewFailure,
        (None, Some(_)) => Change::Added,
        (Some(before), Some(after)) => match (before.outcome, after.outcome) {
            (Fail, Fail) => return moved(id, before, after),
            (_, Fail) => Change::NewFailure,
            (Skipped, Skipped) => return None,
            (_, Skipped) => Change::NoLongerMade,
            (Skipped, _) => Change::NowMade,
            (Fail, _) => Change::Fixed,
            (a, b) if a != b => Change::DefinitionChanged,
            _ => return moved(id, before, after),
        },
    };
    Some(of(id, change, before, after))
}

/// Both were made and came to the same.
fn moved(id: &str, before: &Check, after: &Check) -> Option<Changed> {
    if !same_definition(before, after) {
        return Some(of(id, Change::DefinitionChanged, Some(before), Some(after)));
    }
    let bits = |check: &Check| check.value.map(f64::to_bits);
    (bits(before) != bits(after)).then(|| of(id, Change::Moved, Some(before), Some(after)))
}

fn of(id: &str, change: Change, before: Option<&Check>, after: Option<&Check>) -> Changed {
    let value = |check: Option<&Check>| check.and_then(|check| check.value);
    let by = value(before)
        .zip(value(after))
        .map(|(before, after)| after - before);
    let room = after.and_then(|check| {
        let [below, above] = room(check);
        if by.is_some_and(|by| by < 0.0) {
            below
        } else {
            above
        }
    });
    Changed {
        id: id.to_owned(),
        change,
        before: before.cloned(),
        after: after.cloned(),
        by,
        share_of_tolerance: by
            .zip(room)
            .and_then(|(by, room)| (room > 0.0).then(|| by.abs() / room)),
    }
}

/// What the limits leave below and above what is expected.
fn room(check: &Check) -> [Option<f64>; 2] {
    let expected = check.expected;
    [
        expected
            .zip(check.lower)
            .map(|(expected, lower)| expected - lower),
        expected
            .zip(check.upper)
            .map(|(expected, upper)| upper - expected),
    ]
}

fn same_definition(a: &Check, b: &Check) -> bool {
    let alike = |(a, b): (Option<f64>, Option<f64>)| match (a, b) {
        (Some(a), Some(b)) => a == b || (a - b).abs() <= SAME_WIDTH * a.abs().max(b.abs()),
        (a, b) => a.is_none() == b.is_none(),
    };
    let rooms = room(a).into_iter().zip(room(b));
    (&a.unit, &a.method, &a.basis) == (&b.unit, &b.method, &b.basis) && rooms.into_iter().all(alike)
}

/// Those that moved, and how many did not.
fn numbers(before: &[Measured], after: &[Measured]) -> (Vec<MovedNumber>, usize) {
    let by_id = |of: &[Measured]| -> BTreeMap<String, Measured> {
        of.iter().map(|of| (of.id.clone(), of.clone())).collect()
    };
    let (old, new) = (by_id(before), by_id(after));
    let ids: std::collections::BTreeSet<&String> = old.keys().chain(new.keys()).collect();
    let pairs = ids.into_iter().map(|id| {
        let (before, after) = (old.get(id), new.get(id));
        let both = before.zip(after);
        let unit = after.or(before).map(|of| of.unit.clone());
        MovedNumber {
            id: id.clone(),
            unit: unit.unwrap_or_default(),
            before: before.map(|of| of.value),
            after: after.map(|of| of.value),
            relative: both.map(|(a, b)| relative(a.value, b.value)),
        }
    });
    let (mut moved, same): (Vec<_>, Vec<_>) = pairs.partition(|of| of.relative != Some(0.0));
    let size = |of: &MovedNumber| of.relative.unwrap_or(f64::INFINITY);
    moved.sort_by(|a, b| size(b).total_cmp(&size(a)));
    (moved, same.len())
}

/// 0 only for the same bits.
fn relative(a: f64, b: f64) -> f64 {
    if a.to_bits() == b.to_bits() {
        0.0
    } else {
        ((a - b).abs() / a.abs().max(b.abs())).max(f64::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests;
