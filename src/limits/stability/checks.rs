//! The map as a list of checks.

use super::draft::name_of;
use super::failures::Failure;
use super::growth::Found;
use super::map::{Limits, Map, Row};
use crate::checks::{Check, Measured, Outcome, slug};

/// A check for each limit that was looked for, each closed form, each scene that an engine has no parts for, and each way to fail.
pub fn all(map: &Map) -> Vec<Check> {
    let rows = map.rows.iter().flat_map(|row| of_row(row, map));
    rows.chain(map.failures.iter().map(of_failure)).collect()
}

/// What was predicted, which only a change of the model moves.
pub fn measured(map: &Map) -> Vec<Measured> {
    let limits = map.rows.iter().flat_map(|row| {
        [row.undamped, row.damped].map(|of| Measured {
            id: format!("stability/{}/predicted-alpha-{}", slug(&row.name), of.alpha),
            unit: "s".to_owned(),
            value: of.predicted,
        })
    });
    limits.collect()
}

fn of_row(row: &Row, map: &Map) -> Vec<Check> {
    let id = format!("stability/{}", slug(&row.name));
    let mut checks: Vec<Check> = row
        .checks
        .iter()
        .map(|of| {
            let id = format!("{id}/{}", slug(&of.name));
            let quantity = format!("{}: {}", row.title, of.name);
            let check = Check::of_words(id, &quantity, of.verdict.into(), &of.found);
            with_numbers(check, row, map, &of.name)
        })
        .collect();
    if let Some(reason) = &row.not_made {
        let id = format!("{id}/not-made");
        checks.push(Check::of_words(id, &row.title, Outcome::NotMade, reason));
    }
    checks
}

/// The check of a limit has the found one over the predicted one.
fn with_numbers(check: Check, row: &Row, map: &Map, name: &str) -> Check {
    let exec = map.exec.as_ref().map_or("", |engine| &engine.name);
    for limits in [row.undamped, row.damped] {
        for (engine, found) in [
            ("native", limits.native),
            ("YADE", limits.yade),
            (exec, limits.exec),
        ] {
            if name == name_of(engine, limits.alpha) {
                return numbered(check, &limits, found, map.allowed);
            }
        }
    }
    check
}

fn numbered(check: Check, limits: &Limits, found: Option<Found>, allowed: f64) -> Check {
    let Some(found) = found else { return check };
    let over = |step: f64| step / limits.predicted;
    Check {
        interval: Some([over(found.stable), over(found.unstable)]),
        ..check
            .with_limits(over(found.limit), 1.0, Some(allowed))
            .judged_by(
                "the step at which a disturbance of a bed at rest begins to grow, over the predicted one; the interval is from the largest step \
                 at which it did not grow to the smallest at which it did",
                "docs/stability.md: found and predicted may be so far apart",
            )
    }
}

fn of_failure(of: &Failure) -> Check {
    let id = format!("stability/failures/{}", slug(&of.name));
    Check::of_words(id, &of.title, of.verdict.into(), &of.happened)
}
