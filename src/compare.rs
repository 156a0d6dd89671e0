//! Two run folders side by side: bits, the first difference, then every measured quantity.

pub mod baseline;
pub mod bits;
pub mod divergence;
pub mod first_difference;

use serde::Serialize;

use crate::checks::{self, Check, Outcome};
use crate::document::{Cell, Document, Section, Table};
use crate::run::folder::RunFolder;
use crate::run::folder::record::EngineRecord;
use bits::TableBits;
use divergence::{Divergence, Divergences, REPLICAS, Scatter};
use first_difference::{CommonStart, FirstDifference, Locator};
use grains::measure::Quantity;

/// A measured quantity in both runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct QuantityPair {
    /// The quantity, as in [`Quantity`].
    pub key: String,
    /// SI unit.
    pub unit: String,
    /// In run A, if it has it.
    pub a: Option<f64>,
    /// In run B, if it has it.
    pub b: Option<f64>,
    /// |a − b|.
    pub difference: Option<f64>,
    /// The difference within the control pair, if there is one.
    pub control_difference: Option<f64>,
    /// The most that |a − b| may be; none where nothing is judged.
    pub allowed: Option<f64>,
    /// What that amounts to.
    pub verdict: Outcome,
}

/// The comparison of run A with run B.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// In run A, if it has it.
    pub a: String,
    /// In run B, if it has it.
    pub b: String,
    /// Both runs add forces in the same order, so every bit is expected to agree.
    pub bits_expected: bool,
    /// All checks, in order.
    pub checks: Vec<Check>,
    /// The tables, number by number.
    pub tables: Vec<TableBits>,
    /// Where the runs diverge, if they should not and it was looked for.
    pub first_difference: Option<FirstDifference>,
    /// How the runs diverge, if they may.
    pub divergences: Option<Divergences>,
    /// All measured quantities.
    pub quantities: Vec<QuantityPair>,
}

/// What a run in another order of sums is judged against.
#[derive(Debug, Clone, Copy)]
pub struct ReferenceScatter<'a> {
    /// A run that differs from B only in the order of sums (YADE with another `verletDist`); without one the
    /// replicas are the control.
    pub control: Option<&'a RunFolder>,
    /// How far runs diverge that differ in one last bit at the start.
    pub scatter: &'a Scatter,
}

impl Comparison {
    /// All checks, their ids beginning with this one.
    pub fn all_checks(&self, id: &str) -> Vec<Check> {
        let of = |check: &Check| Check {
            id: format!("{id}/{}", check.id),
            ..check.clone()
        };
        let quantities = self
            .quantities
            .iter()
            .map(|pair| pair.check(id, self.bits_expected));
        self.checks.iter().map(of).chain(quantities).collect()
    }

    /// Skipped if no measured quantity could be judged, which is so when bits are not expected and there is no reference;
    /// else that of all checks.
    pub fn verdict(&self) -> Outcome {
        let verdict = checks::verdict(&self.all_checks(""));
        let judged = |pair: &QuantityPair| pair.verdict != Outcome::Skipped;
        match verdict {
            Outcome::Pass if !self.quantities.iter().any(judged) => Outcome::Skipped,
            verdict => verdict,
        }
    }

    /// Whether the comparison was made and no check failed.
    pub fn agrees(&self) -> bool {
        self.verdict() == Outcome::Pass
    }

    fn check(&mut self, id: &str, quantity: &str, outcome: Outcome, found: impl Into<String>) {
        let check = Check::of_words(id, quantity, outcome, &found.into());
        self.checks.push(check);
    }

    /// What was checked, as a table.
    pub fn check_table(&self) -> Table {
        let mut table = Table::new("checks", "", &["outcome", "check", "found"]);
        for check in &self.checks {
            let [quantity, found] = [&check.quantity, &check.found].map(|of| of.as_str().into());
            table.row([check.outcome.into(), quantity, found]);
        }
        if let Some(first) = &self.first_difference {
            let first = first.to_string();
            table.row([Cell::Missing, "first difference".into(), first.into()]);
        }
        table
    }

    /// Every measured quantity, as a table with this title.
    pub fn quantity_table(&self, title: &str) -> Table {
        let heads = [
            "outcome",
            "quantity",
            "unit",
            "A",
            "B",
            "|A − B|",
            "allowed",
            "in the control pair",
        ];
        let mut table = Table::new("quantities", title, &heads);
        for pair in &self.quantities {
            table.row([
                pair.verdict.into(),
                Cell::Code(pair.key.clone()),
                pair.unit.as_str().into(),
                pair.a.into(),
                pair.b.into(),
                pair.difference.into(),
                pair.allowed.into(),
                pair.control_difference.into(),
            ]);
        }
        table.without_empty_columns()
    }

    /// The comparison for people.
    pub fn document(&self) -> Document {
        let first = self.first_difference.as_ref();
        let first = first.map_or(String::new(), |of| format!("; first difference: {of}"));
        let quantities = self.quantity_table("");
        Document {
            title: "Two runs compared".to_owned(),
            verdict: self.verdict(),
            answer: format!("{} against {}{first}", self.a, self.b),
            sections: vec![
                Section::new("Checks", format!("A: {}\nB: {}", self.a, self.b))
                    .with(self.check_table()),
                Section::new("Measured quantities", "").with(quantities),
            ],
            checks: self.all_checks("compare"),
        }
    }
}

const SAME_OPERATIONS: &str =
    "both engines do the same operations in the same order (docs/determinism.md)";

impl QuantityPair {
    /// A is the value, B what is expected.
    fn check(&self, id: &str, bits_expected: bool) -> Check {
        let found = match (self.verdict, self.a, self.b) {
            (Outcome::Skipped, Some(_), Some(_)) => "nothing to judge it by",
            (_, None, _) => "run A does not have it",
            (_, _, None) => "run B does not have it",
            _ => "",
        };
        let (a, b) = (self.a.unwrap_or(f64::NAN), self.b.unwrap_or(f64::NAN));
        let id = format!("{id}/quantity/{}", self.key);
        let check = Check {
            unit: self.unit.clone(),
            ..Check::of_words(id, &self.key, self.verdict, found).with_limits(a, b, self.allowed)
        };
        if bits_expected {
            check.judged_by("the same number in both runs", SAME_OPERATIONS)
        } else {
            let basis = format!(
                "the scatter of {REPLICAS} replicas that differ in a last bit at the start"
            );
            check.judged_by("A against B, one realization", &basis)
        }
    }
}

/// Compares two runs. Where bits are expected and differ, `locator` finds the first step and grain.
/// Where they are not expected, the runs are judged by the reference, if there is one.
pub fn compare(
    a: &RunFolder,
    b: &RunFolder,
    reference: Option<ReferenceScatter<'_>>,
    locator: Option<&Locator>,
) -> Comparison {
    let bits_expected = a.record.engine.keeps_order() && b.record.engine.keeps_order();
    compare_as(a, b, bits_expected, reference, locator)
}

/// The same where somebody says whether bits are expected: of external engines nobody else knows.
pub fn compare_as(
    a: &RunFolder,
    b: &RunFolder,
    bits_expected: bool,
    reference: Option<ReferenceScatter<'_>>,
    locator: Option<&Locator>,
) -> Comparison {
    let mut comparison = Comparison {
        a: a.record.engine.label(),
        b: b.record.engine.label(),
        bits_expected,
        checks: Vec::new(),
        tables: Vec::new(),
        first_difference: None,
        divergences: None,
        quantities: Vec::new(),
    };
    same_question(a, b, &mut comparison);
    for (name, run) in [("A", a), ("B", b)] {
        let stated = run.record.engine.approximations();
        if !stated.is_empty() {
            let id = format!("approximations-{}", name.to_lowercase());
            let name = format!("approximations that {name} states");
            comparison.check(&id, &name, Outcome::Skipped, stated.join("; "));
        }
    }
    if a.scene.particles.count != b.scene.particles.count {
        return comparison;
    }
    comparison.tables = bits::tables(a, b);
    if bits_expected {
        expect_bits(a, b, locator, &mut comparison);
        quantities(a, b, None, &mut comparison);
    } else {
        expect_scatter(a, b, reference, locator, &mut comparison);
        quantities(a, b, reference, &mut comparison);
    }
    comparison
}

/// Scene, start and protocol are the same in both.
fn same_question(a: &RunFolder, b: &RunFolder, comparison: &mut Comparison) {
    let differing = bits::differing_keys(&a.scene, &b.scene);
    comparison.check(
        "same-scene",
        "same scene",
        Outcome::pass_if(differing.is_empty()),
        if differing.is_empty() {
            format!("digest {}", &a.record.scene_digest[..16])
        } else {
            format!("the scenes differ in {}", differing.join(", "))
        },
    );
    comparison.check(
        "same-start",
        "same start",
        Outcome::pass_if(a.record.initial_digest == b.record.initial_digest),
        format!(
            "initial states {} and {}",
            a.record.initial_digest, b.record.initial_digest
        ),
    );
    comparison.check(
        "same-protocol",
        "same protocol",
        Outcome::pass_if(a.record.protocol == b.record.protocol),
        format!("{} and {}", a.record.protocol, b.record.protocol),
    );
}

fn expect_bits(
    a: &RunFolder,
    b: &RunFolder,
    locator: Option<&Locator>,
    comparison: &mut Comparison,
) {
    let (of_a, of_b) = (a.stages_in_words(), b.stages_in_words());
    comparison.check(
        "same-stages",
        "same stages",
        Outcome::pass_if(of_a == of_b),
        if of_a == of_b {
            of_a
        } else {
            format!("{of_a} against {of_b}")
        },
    );
    for table in comparison.tables.clone() {
        let id = format!("bits-of-{}", table.table.replace(' ', "-"));
        let quantity = format!("bits of {}", table.table);
        let check = Check::of_words(id, &quantity, table.verdict(), &table.to_string());
        let check = Check {
            n: table.numbers as u64,
            ..check.with_limits(table.differing as f64, 0.0, Some(0.0))
        };
        comparison.checks.push(check.judged_by(
            "how many numbers of the two tables differ in any bit",
            SAME_OPERATIONS,
        ));
    }
    let history = bits::history(a, b);
    comparison.check(
        "bits-along-the-way",
        "bits along the way",
        Outcome::pass_if(history.agrees()),
        history.to_string(),
    );
    if comparison
        .checks
        .iter()
        .all(|check| check.outcome != Outcome::Fail)
    {
        return;
    }
    match locator {
        Some(locator) => match locator.locate(a, b) {
            Ok(found) => comparison.first_difference = found,
            Err(reason) => comparison.check(
                "first-difference",
                "first difference",
                Outcome::Skipped,
                reason,
            ),
        },
        None => comparison.check(
            "first-difference",
            "first difference",
            Outcome::Skipped,
            "not asked for",
        ),
    }
}

const GROWTH: &str = "growth of rounding differences";

fn expect_scatter(
    a: &RunFolder,
    b: &RunFolder,
    reference: Option<ReferenceScatter<'_>>,
    locator: Option<&Locator>,
    comparison: &mut Comparison,
) {
    let equal = comparison.tables.iter().all(TableBits::agrees);
    let same_operations = [a, b]
        .iter()
        .all(|run| run.record.engine.keeps_operations());
    comparison.check(
        "bits",
        "bits",
        Outcome::Skipped,
        match (equal, same_operations) {
            (true, _) => "all bits agree, though the order of sums is not the same",
            (false, true) => "not expected to agree: the order of sums is not the same",
            (false, false) => "not expected to agree: the operations are not the same",
        },
    );
    let common = if same_operations {
        CommonStart::of(a, b, locator)
    } else {
        Err(
            "one of them computes a force by other operations, so runs part at the first contact"
                .to_owned(),
        )
    };
    let (verdict, found) = match common {
        Ok(common) => (common.verdict(), common.to_string()),
        Err(reason) => (Outcome::Skipped, reason),
    };
    comparison.check(
        "common-start",
        "same bits before the order of sums can matter",
        verdict,
        found,
    );
    let Some(reference) = reference else {
        comparison.check(
            "control",
            "trajectory divergence as the control pair's",
            Outcome::Skipped,
            "give a control run (--control) that differs from the second one only in verletDist, or --replicas",
        );
        return;
    };
    let Some(control) = reference.control else {
        let divergence = Divergence::of(a, b);
        let steps = divergence.e_folding_steps;
        let settled = steps.map(|_| divergence.settled_median);
        let scatter = reference.scatter;
        let (outcome, found) = scatter.judge(divergence::GROWTH_KEY, steps);
        comparison.check("growth", GROWTH, outcome, found);
        let (outcome, found) = scatter.judge(divergence::SETTLED_KEY, settled);
        comparison.check(
            "final-separation",
            "as far apart in the end as replicas",
            outcome,
            found,
        );
        return;
    };
    let wrong = unfit_control(b, control);
    comparison.check(
        "control",
        "control differs from B in verletDist only",
        Outcome::pass_if(wrong.is_none()),
        wrong.unwrap_or_else(|| control.record.engine.label()),
    );
    let divergences = Divergences::of(a, b, control);
    let (verdict, found) = divergences.growth(reference.scatter);
    comparison.check("growth", GROWTH, verdict, found);
    let (verdict, found) = divergences.settled(reference.scatter);
    comparison.check(
        "final-separation",
        "as far apart in the end as the control pair",
        verdict,
        found,
    );
    comparison.divergences = Some(divergences);
}

/// Why a run is no control of B, if it is none.
fn unfit_control(b: &RunFolder, control: &RunFolder) -> Option<String> {
    let (of_b, of_control) = (&b.record, &control.record);
    let same_question = of_b.scene_digest == of_control.scene_digest
        && of_b.initial_digest == of_control.initial_digest
        && of_b.protocol == of_control.protocol;
    if !same_question {
        return Some("it has another scene, start or protocol".to_owned());
    }
    match (&of_b.engine, &of_control.engine) {
        (
            EngineRecord::Yade {
                sorted: false,
                verlet_distance: of_b,
                ..
            },
            EngineRecord::Yade {
                sorted: false,
                verlet_distance: of_control,
                ..
            },
        ) if of_b != of_control => None,
        (of_b, of_control) => Some(format!(
            "B is {}, the control {}",
            of_b.label(),
            of_control.label()
        )),
    }
}

/// Pairs the quantities of both runs; exact where bits are expected, else judged by the reference.
fn quantities(
    a: &RunFolder,
    b: &RunFolder,
    reference: Option<ReferenceScatter<'_>>,
    comparison: &mut Comparison,
) {
    let exact = comparison.bits_expected;
    let (of_a, of_b) = (divergence::quantities(a), divergence::quantities(b));
    let of_control = reference
        .and_then(|reference| reference.control)
        .map(divergence::quantities);
    let find = |list: &[Quantity], key: &str| {
        list.iter()
            .find(|quantity| quantity.key == key)
            .map(|quantity| quantity.value)
    };
    let mut all: Vec<&Quantity> = of_a.iter().collect();
    all.extend(of_b.iter().filter(|of| find(&of_a, &of.key).is_none()));
    for quantity in all {
        let key = &quantity.key;
        let (in_a, in_b) = (find(&of_a, key), find(&of_b, key));
        let difference = in_a.zip(in_b).map(|(a, b)| (a - b).abs());
        let in_control = of_control.as_deref().and_then(|of| find(of, key));
        let allowed = if exact {
            Some(0.0)
        } else {
            reference.and_then(|reference| reference.scatter.allowed(key))
        };
        let verdict = match (difference, allowed) {
            (Some(difference), Some(allowed)) => Outcome::pass_if(difference <= allowed),
            // Bits are expected, and one run has a measure that the other has not.
            (None, Some(_)) => Outcome::Fail,
            _ => Outcome::Skipped,
        };
        comparison.quantities.push(QuantityPair {
            key: key.clone(),
            unit: quantity.unit.clone(),
            a: in_a,
            b: in_b,
            difference,
            control_difference: in_b.zip(in_control).map(|(b, c)| (b - c).abs()),
            allowed,
            verdict,
        });
    }
}
