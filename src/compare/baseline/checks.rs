//! What a diff says, as checks: programs that read JUnit or CSV are told of it too.

use super::diff::{Change, Diff};
use super::pace::{Pace, SpeedPair};
use crate::checks::{Check, Outcome};

/// Names in a check's words at most; the rest is counted.
const MOST_NAMES: usize = 5;

/// New failures, what can no longer be told, and every speed.
pub fn all(diff: &Diff) -> Vec<Check> {
    let failures = counted(
        diff,
        "baseline/new-failures",
        "checks that fail and did not",
        &[Change::NewFailure],
        Outcome::Fail,
    );
    let untold = counted(
        diff,
        "baseline/told-no-more",
        "checks that are gone, no longer made or defined otherwise",
        &[
            Change::NoLongerMade,
            Change::Removed,
            Change::DefinitionChanged,
        ],
        Outcome::Skipped,
    );
    let speeds = diff.speeds.iter().map(speed);
    [failures, untold].into_iter().chain(speeds).collect()
}

/// How many changes are of these kinds; with any it comes to `otherwise`.
fn counted(diff: &Diff, id: &str, what: &str, kinds: &[Change], otherwise: Outcome) -> Check {
    let of: Vec<&str> = diff
        .changes
        .iter()
        .filter(|of| kinds.contains(&of.change))
        .map(|of| of.id.as_str())
        .collect();
    let mut found = of[..of.len().min(MOST_NAMES)].join(", ");
    if of.len() > MOST_NAMES {
        found += &format!(" and {} more", of.len() - MOST_NAMES);
    }
    let outcome = if of.is_empty() {
        Outcome::Pass
    } else {
        otherwise
    };
    let quantity = format!("{what} in baseline {}", diff.baseline);
    Check::of_words(id.to_owned(), &quantity, outcome, &found)
        .with_limits(of.len() as f64, 0.0, Some(0.0))
        .judged_by(
            "every check is held against the one of the same id",
            "docs/checks.md",
        )
}

/// A cost over that of the baseline, beyond what scatters.
fn speed(pair: &SpeedPair) -> Check {
    let outcome = match pair.pace {
        Pace::Slower => Outcome::Fail,
        Pace::Faster | Pace::Same => Outcome::Pass,
        Pace::NotJudged => Outcome::Skipped,
    };
    let mut check = Check::of_words(
        format!("baseline/speed/{}", pair.id),
        "cost over the baseline's",
        outcome,
        &pair.in_a_line(),
    );
    check.value = pair.cost.filter(|cost| cost.is_finite());
    check.expected = Some(1.0);
    check.upper = pair.scatter.is_finite().then_some(pair.scatter);
    check.judged_by(
        "a ratio of times in one run, or a number of instructions, over the same of the baseline",
        "the scatter of rounds, docs/checks.md",
    )
}
