//! The main job as one list of checks.

use super::record::Reproduction;
use crate::checks::{Check, Measured, Outcome, number_repeated, slug};
use crate::compare;
use crate::compare::spread::quantities;
use crate::paper::{Finding, Number};
use crate::run::folder::RunFolder;
use crate::suite::checks::{of_facts, of_rungs};

/// Every check of the job.
pub fn all(of: &Reproduction) -> Vec<Check> {
    let mut checks = Vec::new();
    for named in &of.comparisons {
        let id = format!("compare/{}", slug(&named.title));
        checks.extend(compare::checks::checks(&id, &named.comparison));
    }
    for fault in &of.faults {
        let id = format!("faults/{}", slug(&fault.fault));
        let check = Check::of_words(id, &fault.fault, fault.verdict.into(), &fault.found);
        checks.push(check.judged_by(
            "the fault is put into the native engine alone; the comparison with the sound one must find it",
            "any bit that differs",
        ));
    }
    checks.extend(of_facts(&of.facts));
    if let Some(ladder) = &of.ladder {
        checks.extend(of_rungs(&ladder.rungs));
    }
    checks.extend(of.numbers.iter().map(of_number));
    for not_made in &of.not_made {
        let id = format!("not-made/{}", slug(&not_made.what));
        checks.push(Check::of_words(
            id,
            &not_made.what,
            Outcome::NotMade,
            &not_made.why,
        ));
    }
    number_repeated(&mut checks);
    checks
}

/// Everything that was measured in a run, for baselines to hold later runs against.
pub fn measured(run: &RunFolder) -> Vec<Measured> {
    let of = |quantity: grains::measure::Quantity| Measured {
        id: format!("native/{}", quantity.key),
        unit: quantity.unit,
        value: quantity.value,
    };
    quantities(run).into_iter().map(of).collect()
}

/// A printed number and its recomputation; that the paper misprints is known and no fault of ours.
fn of_number(number: &Number) -> Check {
    let outcome = match number.finding {
        Finding::Agrees => Outcome::Pass,
        Finding::Derived => Outcome::NotMade,
        Finding::Differs | Finding::Misprint => Outcome::ExpectedFailure,
    };
    let found = match (number.finding, number.remark.as_str()) {
        (Finding::Derived, "") => "the paper does not print it",
        (_, remark) => remark,
    };
    let allowed = (number.finding != Finding::Derived).then_some(number.rounding);
    Check {
        unit: number.unit.clone(),
        ..Check::of_words(
            format!("paper/{}/{}", slug(&number.place), slug(&number.what)),
            &format!("{}: {}", number.place, number.what),
            outcome,
            found,
        )
    }
    .with_limits(number.recomputed, number.published, allowed)
    .judged_by(&number.how, "half a unit of the last printed digit")
}
