//! What changed since a baseline.

use serde::Serialize;

use crate::checks::Check;
use crate::compare::baseline::diff::{Change, Changed, Diff, Pace};

/// A check that is not as it was.
#[derive(Debug, Serialize)]
pub struct ChangedRow<'a> {
    id: &'a str,
    change: &'static str,
    bad: bool,
    before: String,
    after: String,
    share: Option<f64>,
}

/// Rows of moved checks at most; the worst come first.
const MOST_MOVED: usize = 12;

/// Every change but the least of those that moved.
pub fn changed(diff: &Diff) -> Vec<ChangedRow<'_>> {
    let side = |check: &Option<Check>| check.as_ref().map_or("–".to_owned(), Check::in_a_line);
    let row = |of: &'_ Changed| ChangedRow {
        id: "",
        change: of.change.words(),
        bad: of.change == Change::NewFailure,
        before: side(&of.before),
        after: side(&of.after),
        share: of.share_of_tolerance,
    };
    let (moved, other): (Vec<_>, Vec<_>) = diff
        .changes
        .iter()
        .partition(|of| of.change == Change::Moved);
    let shown = other.into_iter().chain(moved.into_iter().take(MOST_MOVED));
    shown
        .map(|of| ChangedRow {
            id: &of.id,
            ..row(of)
        })
        .collect()
}

/// New failures as a number, as `What failed` names them, and every speed that is slower.
pub fn worse(diff: &Diff) -> Vec<String> {
    let new = |of: &&Changed| of.change == Change::NewFailure;
    let failures = diff.changes.iter().filter(new).count();
    let mut lines = Vec::new();
    if failures > 0 {
        lines.push(format!("new failures: {failures}"));
    }
    let slower = diff.speeds.iter().filter(|of| of.pace == Pace::Slower);
    lines.extend(slower.map(|of| format!("slower: {}", of.in_a_line())));
    lines
}
