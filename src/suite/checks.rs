//! Rungs and facts as a list of checks.

use super::facts::{FactPair, TOLERANCE};
use super::ladder::Climbed;
use crate::checks::{Check, Outcome, slug};
use crate::compare::Verdict;

/// A check for each figure of each rung; one for a rung that has none.
pub fn of_rungs(rungs: &[Climbed]) -> Vec<Check> {
    rungs.iter().flat_map(of_rung).collect()
}

fn of_rung(rung: &Climbed) -> Vec<Check> {
    let id = format!("ladder/{}/{}", slug(&rung.engine), slug(&rung.name));
    if rung.lines.is_empty() || rung.verdict == Verdict::NotMade {
        let found = Check::of_words(id, &rung.title, rung.verdict.into(), &rung.reason);
        return vec![found];
    }
    let of_line = |line: &super::Line| {
        let outcome = if line.holds() {
            Outcome::Pass
        } else {
            Outcome::Fail
        };
        Check {
            unit: line.unit.clone(),
            ..Check::of_words(
                format!("{id}/{}", slug(&line.quantity)),
                &line.quantity,
                outcome,
                &rung.reason,
            )
        }
        .with_limits(line.value, line.expected, Some(line.tolerance))
        .judged_by(&rung.title, &line.basis)
    };
    rung.lines.iter().map(of_line).collect()
}

/// A check for each fact.
pub fn of_facts(facts: &[FactPair]) -> Vec<Check> {
    let of_fact = |pair: &FactPair| {
        let outcome = if pair.agrees() {
            Outcome::Pass
        } else {
            Outcome::Fail
        };
        let (fact, yade) = (&pair.native, pair.yade.unwrap_or(f64::NAN));
        Check {
            unit: fact.unit.to_owned(),
            ..Check::of_words(
                format!("facts/{}/{}", slug(&fact.of), slug(fact.symbol)),
                &format!("{} of {}", fact.symbol, fact.of),
                outcome,
                if pair.yade.is_none() {
                    "YADE does not tell it"
                } else {
                    ""
                },
            )
        }
        .with_limits(fact.value, yade, Some(TOLERANCE * yade.abs()))
        .judged_by(
            "the native engine's parameter against the one that YADE says it uses",
            "the same formulas of the same numbers, which may round once",
        )
    };
    facts.iter().map(of_fact).collect()
}
