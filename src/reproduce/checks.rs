//! The main job as one list of checks.

use super::record::Reproduction;
use crate::checks::{Check, Measured, Outcome};
use crate::compare::divergence::quantities;
use crate::paper::Number;
use crate::run::folder::RunFolder;
use crate::suite::parameters::pair_checks;

/// Every check of the job.
pub fn all(of: &Reproduction) -> Vec<Check> {
    let compared = of.comparisons.iter().any(|of| of.comparison.agrees());
    let (outcome, found) = if compared {
        (Outcome::Pass, "")
    } else {
        (Outcome::Skipped, "no comparison could be made and agreed")
    };
    let what = "at least one comparison with another engine";
    let compared = Check::of_words("compare/made", what, outcome, found);
    let mut checks = vec![compared.required()];
    for named in &of.comparisons {
        checks.extend(named.comparison.all_checks(&named.id));
    }
    for fault in &of.faults {
        let id = format!("faults/{}", fault.fault.replace('=', "-"));
        let check = Check::of_words(id, &fault.fault, fault.verdict, &fault.found);
        checks.push(check.judged_by(
            "the fault is put into the native engine alone; the comparison with the sound one must find it",
            "any bit that differs",
        ));
    }
    checks.extend(pair_checks(&of.facts));
    if let Some(ladder) = &of.ladder {
        // An engine that is not there leaves the job complete.
        checks.extend(ladder.checks().into_iter().map(|check| Check {
            required: false,
            ..check
        }));
    }
    checks.extend(of.numbers.iter().map(Number::check));
    checks.extend(of.skipped.iter().map(|of| Check {
        required: of.required,
        ..Check::of_words(of.id.as_str(), &of.what, Outcome::Skipped, &of.why)
    }));
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
