//! A run held against a baseline: what is worse, what is better, what moved, and what cannot be told. Speeds are ratios,
//! judged beyond their scatter.

use std::collections::BTreeMap;

use serde::Serialize;

use super::Baseline;
use crate::checks::record::Record;
use crate::checks::{Check, Measured, Outcome, Speed};

/// What became of a check. The order is that of reading: the worst first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// It fails now, and did not or was not there.
    NewFailure,
    /// It failed, and is now farther off than its noise explains, off to the other side, or no longer a number.
    WorseFailure,
    /// It was made, or was not there and must be made; it is not made now.
    NoLongerMade,
    Removed,
    /// It failed without a number, and now fails in other words or with one.
    FailsOtherwise,
    /// Its unit, method, basis or limits are others, so its values do not compare.
    DefinitionChanged,
    /// It failed and holds now.
    Fixed,
    /// It was not made and is now.
    NowMade,
    Added,
    /// It fails as it failed, whether its value moved or not.
    AcceptedFailure,
    /// Its value is another, its outcome the same.
    Moved,
}

/// What leaves something that can no longer be told.
pub const UNTOLD: [Change; 4] = [
    Change::NoLongerMade,
    Change::Removed,
    Change::FailsOtherwise,
    Change::DefinitionChanged,
];

/// What is worse.
pub const WORSE: [Change; 2] = [Change::NewFailure, Change::WorseFailure];

/// A failure without intervals is worse if it is off by more than so many times what it was.
const FARTHER: f64 = 1.5;

impl Change {
    pub fn words(self) -> &'static str {
        match self {
            Change::NewFailure => "new failure",
            Change::WorseFailure => "worse failure",
            Change::NoLongerMade => "no longer made",
            Change::Removed => "removed",
            Change::FailsOtherwise => "fails otherwise",
            Change::DefinitionChanged => "definition changed",
            Change::Fixed => "fixed",
            Change::NowMade => "now made",
            Change::Added => "added",
            Change::AcceptedFailure => "accepted failure",
            Change::Moved => "moved",
        }
    }
}

/// A check that is not as it was, or fails as it did.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Changed {
    pub id: String,
    pub change: Change,
    pub before: Option<Check>,
    pub after: Option<Check>,
    /// Value after minus value before, in the check's unit.
    pub by: Option<f64>,
    /// The same over what the limits leave to either side of what is expected.
    pub share_of_tolerance: Option<f64>,
}

impl Changed {
    /// It came to what it had come to.
    pub fn is_as_good(&self) -> bool {
        matches!(self.change, Change::Moved | Change::AcceptedFailure)
    }

    /// Its value has other bits.
    pub fn has_other_bits(&self) -> bool {
        let bits = |entry: &Option<Check>| {
            entry
                .as_ref()
                .and_then(|check| check.value)
                .map(f64::to_bits)
        };
        bits(&self.before) != bits(&self.after)
    }
}

/// A measured number that is not as it was.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MovedNumber {
    pub id: String,
    pub unit: String,
    pub before: Option<f64>,
    pub after: Option<f64>,
    /// |after − before| over the larger of the two; none where one is missing.
    pub relative: Option<f64>,
}

/// A run against a baseline.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Diff {
    pub baseline: String,
    pub crossgrain: [String; 2],
    pub commands: [String; 2],
    pub same_machine: bool,
    /// Every check that is not as it was, the worst first.
    pub changes: Vec<Changed>,
    /// Checks that do not fail and are as they were, to the last bit.
    pub same: usize,
    /// Measured numbers that are others, the most by their own size first.
    pub moved: Vec<MovedNumber>,
    /// Measured numbers that are the same to the last bit.
    pub unmoved: usize,
    /// Whether a measured number that moved fails.
    pub bits_demanded: bool,
    pub speeds: Vec<SpeedPair>,
    /// Failed if anything is worse; not made if something can no longer be told; else passed.
    pub verdict: Outcome,
}

/// Limits that differ by less, relative to their width, are the same.
const SAME_WIDTH: f64 = 0.01;

/// Holds a run against a baseline.
pub fn diff(baseline: &Baseline, run: &Record) -> Diff {
    let before = &baseline.record;
    let checks = paired(&before.checks, &run.checks, |check| &check.id);
    let found = checks.iter().map(|(id, [a, b])| changed(id, *a, *b));
    let mut changes: Vec<Changed> = found.flatten().collect();
    let moved = |change: &Changed| change.share_of_tolerance.unwrap_or(0.0);
    changes.sort_by(|a, b| {
        let by_size = moved(b).total_cmp(&moved(a));
        a.change.cmp(&b.change).then(by_size).then(a.id.cmp(&b.id))
    });
    let same_machine = before.machine_kind == run.machine_kind && run.machine_kind.is_some();
    let speeds = speeds(&before.speeds, &run.speeds, same_machine);
    let (moved, unmoved) = numbers(&before.measured, &run.measured);
    Diff {
        baseline: baseline.name.clone(),
        moved,
        unmoved,
        bits_demanded: false,
        crossgrain: [before.crossgrain.clone(), run.crossgrain.clone()],
        commands: [before.command.clone(), run.command.clone()],
        same_machine,
        same: checks.len() - changes.len(),
        verdict: verdict(&changes, &speeds),
        changes,
        speeds,
    }
}

/// Before and after, of every id that is in either.
fn paired<'a, T>(
    before: &'a [T],
    after: &'a [T],
    id: fn(&T) -> &str,
) -> BTreeMap<&'a str, [Option<&'a T>; 2]> {
    let mut all: BTreeMap<&str, [Option<&T>; 2]> = BTreeMap::new();
    for (side, list) in [before, after].into_iter().enumerate() {
        for item in list {
            all.entry(id(item)).or_default()[side] = Some(item);
        }
    }
    all
}

impl Diff {
    /// Values of checks and measured numbers that are others.
    pub fn all_moved(&self) -> usize {
        let of_checks = self.changes.iter();
        let of_checks = of_checks.filter(|change| change.is_as_good() && change.has_other_bits());
        self.moved.len() + of_checks.count()
    }

    /// Every number must be the same to the last bit, as in a change that is to change nothing.
    pub fn demanding_bits(mut self) -> Self {
        self.bits_demanded = true;
        if self.all_moved() > 0 {
            self.verdict = Outcome::Fail;
        }
        self
    }

    pub fn in_a_line(&self) -> String {
        let mut parts = Vec::new();
        let mut count = |number: usize, words: &str| {
            if number > 0 {
                parts.push(format!("{number} {words}"));
            }
        };
        // They stand in their order.
        for group in self.changes.chunk_by(|a, b| a.change == b.change) {
            let words = group[0].change.words();
            match group.len() > 1 && words.ends_with("failure") {
                true => count(group.len(), &format!("{words}s")),
                false => count(group.len(), words),
            }
        }
        for (pace, words) in [(Pace::Slower, "slower"), (Pace::Faster, "faster")] {
            let speeds = self.speeds.iter().filter(|pair| pair.pace == pace);
            count(speeds.count(), words);
        }
        count(self.same, "as they were");
        let numbers = self.moved.len() + self.unmoved;
        if numbers > 0 {
            let moved = self.moved.len();
            parts.push(format!("{moved} of {numbers} measured numbers moved"));
        }
        parts.join(", ")
    }
}

fn verdict(changes: &[Changed], speeds: &[SpeedPair]) -> Outcome {
    let any = |wanted: &[Change]| changes.iter().any(|change| wanted.contains(&change.change));
    if any(&WORSE) || speeds.iter().any(|pair| pair.pace == Pace::Slower) {
        Outcome::Fail
    } else if any(&UNTOLD) {
        Outcome::Skipped
    } else {
        Outcome::Pass
    }
}

/// None for a check that is as it was and does not fail.
fn changed(id: &str, before: Option<&Check>, after: Option<&Check>) -> Option<Changed> {
    use Outcome::{Fail, Skipped};
    let change = match (before, after) {
        (None, None) => return None,
        (Some(_), None) => Change::Removed,
        (None, Some(after)) if after.outcome == Fail => Change::NewFailure,
        (None, Some(after)) if after.outcome == Skipped && after.required => Change::NoLongerMade,
        (None, Some(_)) => Change::Added,
        (Some(before), Some(after)) => match (before.outcome, after.outcome) {
            (Fail, Fail) if same_definition(before, after) => failure(before, after),
            (Fail, Fail) => Change::DefinitionChanged,
            (_, Fail) => Change::NewFailure,
            (Skipped, Skipped) => return None,
            (_, Skipped) => Change::NoLongerMade,
            (Skipped, _) => Change::NowMade,
            (Fail, _) => Change::Fixed,
            (a, b) if a != b => Change::DefinitionChanged,
            _ => return moved(id, before, after),
        },
    };
    Some(entry(id, change, before, after))
}

/// What became of a failure by the same definition.
fn failure(before: &Check, after: &Check) -> Change {
    let (Some(old), Some(new)) = (before.value, after.value) else {
        return match (before.value, after.value) {
            (Some(_), None) => Change::WorseFailure,
            (None, None) if before.found == after.found => Change::AcceptedFailure,
            _ => Change::FailsOtherwise,
        };
    };
    // What is off is off from what is expected, or from the limit that is broken where nothing is.
    let limit = if after.lower.is_some_and(|lower| new < lower) {
        after.lower
    } else {
        after.upper
    };
    let expected = |check: &Check| check.expected.or(limit).unwrap_or(0.0);
    let off = [old - expected(before), new - expected(after)];
    let farther = match (before.interval, after.interval) {
        (Some([_, high]), Some([low, _])) if off[0] > 0.0 => off[1] < 0.0 || low > high,
        (Some([low, _]), Some([_, high])) => off[1] > 0.0 || high < low,
        _ => old.to_bits() != new.to_bits() && !(0.0..=FARTHER).contains(&(off[1] / off[0])),
    };
    if farther {
        Change::WorseFailure
    } else {
        Change::AcceptedFailure
    }
}

/// Both were made and came to the same.
fn moved(id: &str, before: &Check, after: &Check) -> Option<Changed> {
    if !same_definition(before, after) {
        return Some(entry(
            id,
            Change::DefinitionChanged,
            Some(before),
            Some(after),
        ));
    }
    let bits = |check: &Check| check.value.map(f64::to_bits);
    (bits(before) != bits(after)).then(|| entry(id, Change::Moved, Some(before), Some(after)))
}

fn entry(id: &str, change: Change, before: Option<&Check>, after: Option<&Check>) -> Changed {
    let value = |check: Option<&Check>| check.and_then(|check| check.value);
    let both = value(before).zip(value(after));
    let by = both.map(|(before, after)| after - before);
    let side = usize::from(!by.is_some_and(|by| by < 0.0));
    let room = after.and_then(|check| room(check)[side]);
    Changed {
        id: id.to_owned(),
        change,
        before: before.cloned(),
        after: after.cloned(),
        by,
        share_of_tolerance: (by.zip(room.filter(|room| *room > 0.0)))
            .map(|(by, room)| by.abs() / room),
    }
}

/// What the limits leave below and above what is expected.
fn room(check: &Check) -> [Option<f64>; 2] {
    let [lower, upper] = [check.lower, check.upper].map(|limit| check.expected.zip(limit));
    let below = lower.map(|(expected, lower)| expected - lower);
    [below, upper.map(|(expected, upper)| upper - expected)]
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
    let pairs = paired(before, after, |number| &number.id).into_iter();
    let pairs = pairs.map(|(id, [before, after])| {
        let both = before.zip(after);
        let one = after.or(before).expect("one of a pair is there");
        MovedNumber {
            id: id.to_owned(),
            unit: one.unit.clone(),
            before: before.map(|number| number.value),
            after: after.map(|number| number.value),
            relative: both.map(|(a, b)| relative(a.value, b.value)),
        }
    });
    let (mut moved, same): (Vec<_>, Vec<_>) =
        pairs.partition(|number| number.relative != Some(0.0));
    let size = |number: &MovedNumber| number.relative.unwrap_or(f64::INFINITY);
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

/// What became of a speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Pace {
    /// Beyond what rounds scatter.
    Slower,
    /// Beyond what rounds scatter.
    Faster,
    /// Within it.
    Same,
    /// The machines are not the same, or one run does not have it.
    NotJudged,
}

impl Pace {
    pub fn words(self) -> &'static str {
        match self {
            Pace::Slower => "SLOWER",
            Pace::Faster => "faster",
            Pace::Same => "same",
            Pace::NotJudged => "not judged",
        }
    }
}

/// A speed in both.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpeedPair {
    pub id: String,
    pub what: String,
    pub unit: String,
    pub before: Option<f64>,
    pub after: Option<f64>,
    /// Cost after over cost before: above 1 is slower.
    pub cost: Option<f64>,
    /// A change of cost up to this factor, either way, says nothing.
    pub scatter: f64,
    pub pace: Pace,
}

/// Times of one round each.
const SINGLE_ROUND: f64 = 1.5;
/// Times whose rounds do not overlap.
const APART: f64 = 1.05;

impl SpeedPair {
    pub fn in_a_line(&self) -> String {
        let number =
            |value: Option<f64>| value.map_or("–".to_owned(), |known| format!("{known:.4}"));
        let cost = |cost| format!(", {cost:.3} times the cost");
        let cost = self.cost.map_or(String::new(), cost);
        let (before, after) = (number(self.before), number(self.after));
        format!("{}: {before} to {after} {}{cost}", self.what, self.unit)
    }
}

/// All speeds of either; judged on machines of one kind only.
fn speeds(before: &[Speed], after: &[Speed], same_machine: bool) -> Vec<SpeedPair> {
    fn find<'a>(list: &'a [Speed], wanted: &Speed) -> Option<&'a Speed> {
        list.iter().find(|speed| speed.id == wanted.id)
    }
    let now = after.iter().map(|new| (find(before, new), Some(new)));
    let gone = before.iter().filter(|old| find(after, old).is_none());
    let all = now.chain(gone.map(|old| (Some(old), None)));
    all.filter_map(|(old, new)| pair(old, new, same_machine))
        .collect()
}

/// What one speed became; none without any.
pub fn pair(old: Option<&Speed>, new: Option<&Speed>, same_machine: bool) -> Option<SpeedPair> {
    let speed = new.or(old)?;
    let both = old.zip(new);
    let cost = both.map(|(old, new)| match new.less_is_better {
        true => new.value / old.value,
        false => old.value / new.value,
    });
    let scatter = both.map_or(SINGLE_ROUND, |(old, new)| scatter(old, new));
    Some(SpeedPair {
        id: speed.id.clone(),
        what: speed.what.clone(),
        unit: speed.unit.clone(),
        before: old.map(|speed| speed.value),
        after: new.map(|speed| speed.value),
        cost,
        scatter,
        pace: match cost.filter(|cost| same_machine && cost.is_finite()) {
            Some(cost) if cost > scatter => Pace::Slower,
            Some(cost) if cost < 1.0 / scatter => Pace::Faster,
            Some(_) => Pace::Same,
            None => Pace::NotJudged,
        },
    })
}

/// Rounds that overlap say nothing, however far their medians are apart.
fn scatter(old: &Speed, new: &Speed) -> f64 {
    match (old.range, new.range) {
        (Some([_, high]), Some([low, _])) if high < low => APART,
        (Some([low, _]), Some([_, high])) if high < low => APART,
        (Some(_), Some(_)) => f64::INFINITY,
        _ => SINGLE_ROUND,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(id: &str, value: f64, outcome: Outcome) -> Check {
        Check::of_words(id.to_owned(), id, outcome, "")
            .with_limits(value, 1.0, Some(0.5))
            .judged_by("by looking", "told so")
    }

    fn speed(value: f64, range: Option<[f64; 2]>) -> Speed {
        Speed {
            id: "time/yade".to_owned(),
            what: "YADE over native".to_owned(),
            unit: "times native".to_owned(),
            value,
            range,
            less_is_better: false,
        }
    }

    fn record(checks: Vec<Check>, speeds: Vec<Speed>) -> Record {
        Record {
            job: "verify".to_owned(),
            version: 2,
            crossgrain: "0.1.0".to_owned(),
            command: "crossgrain verify".to_owned(),
            machine_kind: Some("a machine".to_owned()),
            scene_digest: None,
            yade: None,
            verdict: Outcome::Pass,
            checks,
            measured: Vec::new(),
            speeds,
        }
    }

    /// Checks a, b and so on.
    fn of_checks<const N: usize>(values: [f64; N], outcomes: [Outcome; N]) -> Record {
        let checks = ["a", "b", "c", "d"].into_iter().zip(values).zip(outcomes);
        let checks = checks.map(|((id, value), outcome)| check(id, value, outcome));
        record(checks.collect(), Vec::new())
    }

    fn between(before: Record, after: &Record) -> Diff {
        let baseline = Baseline {
            baseline: 1,
            name: "main".to_owned(),
            source: String::new(),
            record: before,
            record_digest: None,
        };
        diff(&baseline, after)
    }

    fn of_one(before: Option<Check>, after: Option<Check>) -> (Option<Change>, Outcome) {
        let run = |check: Option<Check>| record(check.into_iter().collect(), Vec::new());
        let diff = between(run(before), &run(after));
        (
            diff.changes.first().map(|change| change.change),
            diff.verdict,
        )
    }

    #[test]
    fn each_kind_of_change_is_told_and_weighed() {
        use Change::*;
        use Outcome::{ExpectedFailure, Fail, Pass, Skipped};
        use Outcome::{Fail as Worse, Pass as Fine, Skipped as Open};
        let a = |value, outcome| Some(check("a", value, outcome));
        let other = |change: fn(&mut Check)| {
            let mut check = check("a", 1.0, Pass);
            change(&mut check);
            Some(check)
        };
        let known = a(1.0, ExpectedFailure);
        let required = Some(check("a", 0.0, Skipped).required());
        let told = |found: &str| Some(Check::of_words("a", "", Fail, found));
        let noisy = |value: f64, noise: f64| {
            let mut check = check("a", value, Fail);
            check.interval = Some([value - noise, value + noise]);
            Some(check)
        };
        let within = |noise| noisy(1.6, noise);
        let (apart, overlapping) = (noisy(1.9, 0.1), noisy(3.2, 0.9));
        let looser = other(|check| check.upper = Some(1.6));
        let unit = other(|check| check.unit = "m".to_owned());
        let method = other(|check| check.method = "by hearsay".to_owned());
        for (before, after, change, verdict) in [
            (a(1.0, Pass), a(1.0, Pass), None, Fine),
            (a(1.0, Pass), a(1.1, Pass), Some(Moved), Fine),
            (a(1.0, Pass), a(1.6, Fail), Some(NewFailure), Worse),
            (None, a(1.6, Fail), Some(NewFailure), Worse),
            (a(0.0, Skipped), a(1.6, Fail), Some(NewFailure), Worse),
            (a(1.6, Fail), a(1.6, Fail), Some(AcceptedFailure), Fine),
            (a(1.6, Fail), a(1.7, Fail), Some(AcceptedFailure), Fine),
            (a(1.6, Fail), a(2.0, Fail), Some(WorseFailure), Worse),
            (a(1.6, Fail), a(0.4, Fail), Some(WorseFailure), Worse),
            (a(1.6, Fail), a(f64::NAN, Fail), Some(WorseFailure), Worse),
            (told("off"), told("off"), Some(AcceptedFailure), Fine),
            (told("off"), told("upside down"), Some(FailsOtherwise), Open),
            (a(4.55, Fail), a(5.0e4, Fail), Some(WorseFailure), Worse),
            (within(0.1), apart, Some(WorseFailure), Worse),
            (within(0.9), overlapping, Some(AcceptedFailure), Fine),
            (a(1.6, Fail), a(1.0, Pass), Some(Fixed), Fine),
            (a(1.0, Pass), a(0.0, Skipped), Some(NoLongerMade), Open),
            (a(1.6, Fail), a(0.0, Skipped), Some(NoLongerMade), Open),
            (a(0.0, Skipped), a(1.0, Pass), Some(NowMade), Fine),
            (a(0.0, Skipped), a(0.0, Skipped), None, Fine),
            (None, a(1.0, Pass), Some(Added), Fine),
            (None, required, Some(NoLongerMade), Open),
            (a(1.0, Pass), None, Some(Removed), Open),
            (a(1.0, Pass), looser, Some(DefinitionChanged), Open),
            (a(1.0, Pass), unit, Some(DefinitionChanged), Open),
            (a(1.0, Pass), method, Some(DefinitionChanged), Open),
            (known, a(1.0, Pass), Some(DefinitionChanged), Open),
        ] {
            let found = of_one(before.clone(), after.clone());
            assert_eq!(found, (change, verdict), "{before:?} {after:?}");
        }
    }

    #[test]
    fn a_move_is_measured_in_its_tolerance_and_the_worst_comes_first() {
        use Outcome::{Fail, Pass};
        let before = of_checks([1.0; 3], [Pass; 3]);
        let diff = between(before, &of_checks([1.1, 1.0, 0.6], [Pass, Fail, Pass]));
        let ids: Vec<&str> = diff
            .changes
            .iter()
            .map(|change| change.id.as_str())
            .collect();
        assert_eq!(ids, ["b", "c", "a"]);
        let share = diff.changes[1].share_of_tolerance.expect("limits");
        assert!((share - 0.8).abs() < 1e-12, "{share}");
    }

    #[test]
    fn every_check_is_counted_once() {
        use Outcome::{Fail, Pass};
        let outcomes = [Fail, Fail, Pass, Pass];
        let before = of_checks([1.6, 1.6, 1.0, 1.0], outcomes);
        let after = of_checks([1.6, 1.7, 1.1, 1.0], outcomes);
        let diff = between(before.clone(), &after);
        assert_eq!(
            diff.in_a_line(),
            "2 accepted failures, 1 moved, 1 as they were"
        );
        let mut after = before.clone();
        after.checks[0].method = "by hearsay".to_owned();
        let words = "1 definition changed, 1 accepted failure, 2 as they were";
        assert_eq!(between(before, &after).in_a_line(), words);
    }

    #[test]
    fn measured_numbers_that_moved_are_told_by_their_own_size() {
        let run = |ids: &[&str], values: &[f64]| {
            let mut run = record(Vec::new(), Vec::new());
            run.measured = (ids.iter().zip(values))
                .map(|(id, value)| Measured {
                    id: (*id).to_owned(),
                    unit: "m".to_owned(),
                    value: *value,
                })
                .collect();
            run
        };
        let before = run(&["a", "b", "c", "gone"], &[1.0, 1.0, 100.0, 1.0]);
        let moved = [1.0, 1.0 + f64::EPSILON, 101.0, 1.0];
        let after = run(&["a", "b", "c", "new"], &moved);
        let diff = between(before.clone(), &after);
        let moved: Vec<&str> = diff.moved.iter().map(|number| number.id.as_str()).collect();
        assert_eq!(moved, ["gone", "new", "c", "b"]);
        assert_eq!(diff.unmoved, 1);
        assert!(diff.in_a_line().contains("4 of 5 measured numbers moved"));
        let many = "a b c d e f g h i j k l m".split(' ').collect::<Vec<_>>();
        let diff = between(run(&many, &[1.0; 13]), &run(&many, &[2.0; 13]));
        let says = |all| format!("{:?}", diff.section(all)).contains("these 12 moved most");
        assert!(says(false) && !says(true));
        // Numbers alone are findings; whether they may move is for the caller to say.
        assert_eq!(diff.verdict, Outcome::Pass);
        assert_eq!(diff.demanding_bits().verdict, Outcome::Fail);
        let same = between(before.clone(), &before).demanding_bits();
        assert_eq!(same.verdict, Outcome::Pass);
        // A record without measured numbers has its bits in the values of its checks.
        let run = |value| of_checks([value], [Outcome::Pass]);
        let moved = between(run(1.0), &run(1.0 + f64::EPSILON));
        assert_eq!(moved.verdict, Outcome::Pass);
        assert_eq!(moved.demanding_bits().verdict, Outcome::Fail);
    }

    #[test]
    fn speeds_are_ratios_judged_beyond_their_scatter_on_one_machine() {
        let pace = |before: Speed, after: Speed| {
            let run = |speed| record(Vec::new(), vec![speed]);
            let diff = between(run(before), &run(after));
            (diff.speeds[0].pace, diff.verdict)
        };
        let single = |value| speed(value, None);
        let friction = |value| Speed {
            less_is_better: true,
            ..single(value)
        };
        let rounds = |value| speed(value, Some([value - 2.0, value + 2.0]));
        use Outcome::{Fail, Pass};
        assert_eq!(pace(single(80.0), single(60.0)), (Pace::Same, Pass));
        assert_eq!(pace(single(80.0), single(40.0)), (Pace::Slower, Fail));
        assert_eq!(pace(single(40.0), single(80.0)), (Pace::Faster, Pass));
        assert_eq!(pace(friction(2.0), friction(4.0)), (Pace::Slower, Fail));
        assert_eq!(pace(friction(4.0), friction(2.0)), (Pace::Faster, Pass));
        assert_eq!(pace(rounds(80.0), rounds(77.0)), (Pace::Same, Pass));
        assert_eq!(pace(rounds(80.0), rounds(70.0)), (Pace::Slower, Fail));
        let before = record(Vec::new(), vec![single(80.0)]);
        let mut after = record(Vec::new(), vec![single(40.0)]);
        after.machine_kind = Some("another".to_owned());
        assert_eq!(between(before, &after).speeds[0].pace, Pace::NotJudged);
    }
}
