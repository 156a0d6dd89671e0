//! A comparison as a list of checks.

use super::spread::TWINS;
use super::{Comparison, QuantityPair, Verdict};
use crate::checks::{Check, Outcome, slug};

impl From<Verdict> for Outcome {
    fn from(verdict: Verdict) -> Self {
        match verdict {
            Verdict::Pass => Outcome::Pass,
            Verdict::Fail => Outcome::Fail,
            Verdict::NotMade => Outcome::NotMade,
        }
    }
}

/// The checks of a comparison, their ids beginning with this one.
pub fn checks(id: &str, comparison: &Comparison) -> Vec<Check> {
    let words = comparison.checks.iter().map(|check| {
        let of = Check::of_words(
            format!("{id}/{}", slug(&check.name)),
            &check.name,
            check.verdict.into(),
            &check.found,
        );
        let table = comparison
            .tables
            .iter()
            .find(|table| format!("bits of {}", table.table) == check.name);
        match table {
            Some(table) => Check {
                n: table.numbers as u64,
                ..of.with_limits(table.differing as f64, 0.0, Some(0.0)).judged_by(
                    "how many numbers of the two tables differ in any bit",
                    "both engines do the same operations in the same order (docs/determinism.md)",
                )
            },
            None => of,
        }
    });
    let quantities = comparison
        .quantities
        .iter()
        .map(|pair| of_quantity(id, pair, comparison.bits_expected));
    words.chain(quantities).collect()
}

/// A is the value, B what is expected.
fn of_quantity(id: &str, pair: &QuantityPair, bits_expected: bool) -> Check {
    let found = match (pair.verdict, pair.a, pair.b) {
        (Verdict::NotMade, Some(_), Some(_)) => "nothing to judge it by",
        (_, None, _) => "run A does not have it",
        (_, _, None) => "run B does not have it",
        _ => "",
    };
    let check = Check::of_words(
        format!("{id}/quantity/{}", pair.key),
        &pair.key,
        pair.verdict.into(),
        found,
    )
    .with_limits(
        pair.a.unwrap_or(f64::NAN),
        pair.b.unwrap_or(f64::NAN),
        pair.allowed,
    );
    let check = Check {
        unit: pair.unit.clone(),
        ..check
    };
    if bits_expected {
        check.judged_by(
            "the same number in both runs",
            "both engines do the same operations in the same order (docs/determinism.md)",
        )
    } else {
        check.judged_by(
            "A against B, one realization",
            &format!("the scatter of {TWINS} twins that differ in a last bit at the start"),
        )
    }
}
