//! A benchmark as a list of checks, and what of it travels between machines.

use super::Bench;
use super::contender::{Contender, NATIVE};
use super::rounds::Contest;
use crate::checks::{Check, Outcome, Speed, slug};

/// Every check: beds, bits, and what was missed. No time counts.
pub fn all(bench: &Bench) -> Vec<Check> {
    let mut checks: Vec<Check> = bench.contests.iter().flat_map(of_bed).collect();
    if let Some(bits) = &bench.sorted_bits {
        let outcome = if bits.agrees() {
            Outcome::Pass
        } else {
            Outcome::Fail
        };
        let check = Check::of_words(
            "bench/bits".to_owned(),
            "native exact against YADE's sorted loop",
            outcome,
            &bits.to_string(),
        );
        let check = Check {
            n: bits.numbers as u64,
            ..check
        };
        checks.push(
            check
                .with_limits(bits.differing as f64, 0.0, Some(0.0))
                .judged_by(
                    "how many numbers differ in any bit after the same steps",
                    "both engines do the same operations in the same order (docs/determinism.md)",
                ),
        );
    }
    for missed in &bench.missed {
        let outcome = if missed.failed {
            Outcome::Fail
        } else {
            Outcome::Skipped
        };
        let id = format!("bench/missed/{}", slug(&missed.what));
        checks.push(Check {
            required: missed.needed,
            ..Check::of_words(id, &missed.what, outcome, &missed.why)
        });
    }
    checks
}

/// The three ways in which an engine's bed must still be the bed.
fn of_bed(contest: &Contest) -> [Check; 3] {
    let sanity = &contest.sanity;
    let (tolerance, exact) = (sanity.tolerance, sanity.energy_in_exact);
    let contacts = sanity.contacts_in_exact as f64;
    let check = |quantity: &str, value: f64, [expected, lower, upper]: [f64; 3], unit: &str| {
        let outcome = if lower <= value && value <= upper {
            Outcome::Pass
        } else {
            Outcome::Fail
        };
        Check {
            unit: unit.to_owned(),
            lower: Some(lower),
            upper: Some(upper),
            ..Check::of_words(
                format!("bench/bed/{}/{}", slug(&contest.name), slug(quantity)),
                &format!("{quantity} of the bed of {}", contest.name),
                outcome,
                "",
            )
            .with_limits(value, expected, None)
            .judged_by(
                "against native exact's bed after the same steps",
                "how far rounding or the other law may take it (src/bench/sanity.rs)",
            )
        }
    };
    let beside = |of: f64, share: f64| [of, of * (1.0 - share), of * (1.0 + share)];
    [
        check(
            "largest displacement over the mean radius",
            sanity.displacement,
            [0.0, 0.0, tolerance.displacement],
            "1",
        ),
        check(
            "contacts between grains",
            sanity.contacts as f64,
            beside(contacts, tolerance.contacts),
            "1",
        ),
        check(
            "kinetic energy",
            sanity.energy,
            [exact, exact / tolerance.energy, exact * tolerance.energy],
            "J",
        ),
    ]
}

/// Times over native exact's, and instructions.
pub fn speeds(bench: &Bench) -> Vec<Speed> {
    let others = bench.contests.iter();
    let others = others.filter(|contest| contest.contender != Contender::Exact);
    let ratios = others.filter_map(|contest| {
        let over = contest.over_exact.as_ref()?;
        // Of the native engine's own modes less is better; what others take longer is to its credit.
        Some(Speed {
            id: format!("time/{}", slug(&contest.name)),
            what: format!("time a step of {} over native exact", contest.name),
            unit: "times native exact".to_owned(),
            value: over.median,
            range: Some([over.least, over.most]),
            less_is_better: NATIVE.contains(&contest.contender),
        })
    });
    let instructions = bench.instructions.iter().map(|of| Speed {
        id: format!("instructions/{}", slug(&of.name)),
        what: format!("instructions a step of {}", of.name),
        unit: "instructions a step".to_owned(),
        value: of.per_step,
        range: None,
        less_is_better: true,
    });
    ratios.chain(instructions).collect()
}
