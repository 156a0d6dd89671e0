//! Two run folders side by side: bits, the first difference, then every measured quantity.

pub mod baseline;
pub mod bits;
pub mod checks;
pub mod common_start;
pub mod first_difference;
pub mod parting;
pub mod partings;
pub mod spread;

use serde::{Deserialize, Serialize};

use crate::run::folder::RunFolder;
use crate::run::folder::record::EngineRecord;
use bits::TableBits;
use common_start::CommonStart;
use first_difference::{FirstDifference, Locator};
use grains::measure::Quantity;
use parting::Parting;
use partings::Partings;
use spread::Spread;

/// What a check found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It holds.
    Pass,
    /// It does not.
    Fail,
    /// The check could not be made, or nothing was expected of it; never counted as passed.
    NotMade,
}

/// One check with what it rests on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// What is checked.
    pub name: String,
    /// What that amounts to.
    pub verdict: Verdict,
    /// What was found, in words and figures.
    pub found: String,
}

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
    pub verdict: Verdict,
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
    /// Where the runs part, if they should not and it was looked for.
    pub first_difference: Option<FirstDifference>,
    /// How the runs part, if they may.
    pub partings: Option<Partings>,
    /// All measured quantities.
    pub quantities: Vec<QuantityPair>,
}

/// What a run in another order of sums is judged against.
#[derive(Debug, Clone, Copy)]
pub struct Yardstick<'a> {
    /// A run that differs from B only in the order of sums (YADE with another `verletDist`); without one the twins
    /// are the control.
    pub control: Option<&'a RunFolder>,
    /// How far runs part that differ in one last bit at the start.
    pub spread: &'a Spread,
}

impl Comparison {
    /// Failed if anything failed; not made if no measured quantity could be judged, which is so when
    /// bits are not expected and there is no yardstick; else passed.
    pub fn verdict(&self) -> Verdict {
        let judged = |verdict: Verdict| {
            let checks = self.checks.iter().map(|check| check.verdict);
            let quantities = self.quantities.iter().map(|pair| pair.verdict);
            checks.chain(quantities).any(|found| found == verdict)
        };
        let made = |pair: &QuantityPair| pair.verdict != Verdict::NotMade;
        if judged(Verdict::Fail) {
            Verdict::Fail
        } else if self.quantities.iter().any(made) {
            Verdict::Pass
        } else {
            Verdict::NotMade
        }
    }

    /// Whether the comparison was made and no check failed.
    pub fn agrees(&self) -> bool {
        self.verdict() == Verdict::Pass
    }

    fn check(&mut self, name: &str, verdict: Verdict, found: impl Into<String>) {
        self.checks.push(Check {
            name: name.to_owned(),
            verdict,
            found: found.into(),
        });
    }
}

fn pass_if(holds: bool) -> Verdict {
    if holds { Verdict::Pass } else { Verdict::Fail }
}

/// Compares two runs. Where bits are expected and differ, `locator` finds the first step and grain.
/// Where they are not expected, the runs are judged by the yardstick, if there is one.
pub fn compare(
    a: &RunFolder,
    b: &RunFolder,
    yardstick: Option<Yardstick<'_>>,
    locator: Option<&Locator>,
) -> Comparison {
    let bits_expected = a.record.engine.keeps_order() && b.record.engine.keeps_order();
    compare_as(a, b, bits_expected, yardstick, locator)
}

/// The same where somebody says whether bits are expected: of engines that were brought nobody else knows.
pub fn compare_as(
    a: &RunFolder,
    b: &RunFolder,
    bits_expected: bool,
    yardstick: Option<Yardstick<'_>>,
    locator: Option<&Locator>,
) -> Comparison {
    let mut comparison = Comparison {
        a: a.record.engine.label(),
        b: b.record.engine.label(),
        bits_expected,
        checks: Vec::new(),
        tables: Vec::new(),
        first_difference: None,
        partings: None,
        quantities: Vec::new(),
    };
    same_question(a, b, &mut comparison);
    for (name, run) in [("A", a), ("B", b)] {
        let stated = run.record.engine.approximations();
        if !stated.is_empty() {
            let name = format!("approximations that {name} states");
            comparison.check(&name, Verdict::NotMade, stated.join("; "));
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
        expect_spread(a, b, yardstick, locator, &mut comparison);
        quantities(a, b, yardstick, &mut comparison);
    }
    comparison
}

/// Scene, start and protocol are the same in both.
fn same_question(a: &RunFolder, b: &RunFolder, comparison: &mut Comparison) {
    let differing = bits::differing_keys(&a.scene, &b.scene);
    comparison.check(
        "same scene",
        pass_if(differing.is_empty()),
        if differing.is_empty() {
            format!("digest {}", &a.record.scene_digest[..16])
        } else {
            format!("the scenes differ in {}", differing.join(", "))
        },
    );
    comparison.check(
        "same start",
        pass_if(a.record.initial_digest == b.record.initial_digest),
        format!(
            "initial states {} and {}",
            a.record.initial_digest, b.record.initial_digest
        ),
    );
    comparison.check(
        "same protocol",
        pass_if(a.record.protocol == b.record.protocol),
        format!("{:?} and {:?}", a.record.protocol, b.record.protocol),
    );
}

fn expect_bits(
    a: &RunFolder,
    b: &RunFolder,
    locator: Option<&Locator>,
    comparison: &mut Comparison,
) {
    let stages = |run: &RunFolder| -> Vec<String> {
        let of = |stage: &grains::task::StageReport| {
            format!("{} {} ({:?})", stage.stage.name(), stage.steps, stage.stop)
        };
        run.record.stages.iter().map(of).collect()
    };
    let (of_a, of_b) = (stages(a), stages(b));
    comparison.check(
        "same stages",
        pass_if(of_a == of_b),
        if of_a == of_b {
            of_a.join(", ")
        } else {
            format!("{} against {}", of_a.join(", "), of_b.join(", "))
        },
    );
    for table in comparison.tables.clone() {
        comparison.check(
            &format!("bits of {}", table.table),
            table.verdict(),
            table.to_string(),
        );
    }
    let history = bits::history(a, b);
    comparison.check(
        "bits along the way",
        pass_if(history.agrees()),
        history.to_string(),
    );
    if comparison
        .checks
        .iter()
        .all(|check| check.verdict != Verdict::Fail)
    {
        return;
    }
    match locator {
        Some(locator) => match locator.locate(a, b) {
            Ok(found) => comparison.first_difference = found,
            Err(reason) => comparison.check("first difference", Verdict::NotMade, reason),
        },
        None => comparison.check("first difference", Verdict::NotMade, "not asked for"),
    }
}

fn expect_spread(
    a: &RunFolder,
    b: &RunFolder,
    yardstick: Option<Yardstick<'_>>,
    locator: Option<&Locator>,
    comparison: &mut Comparison,
) {
    let equal = comparison.tables.iter().all(TableBits::agrees);
    let same_operations = [a, b]
        .iter()
        .all(|run| run.record.engine.keeps_operations());
    comparison.check(
        "bits",
        Verdict::NotMade,
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
        Err(reason) => (Verdict::NotMade, reason),
    };
    comparison.check(
        "same bits before the order of sums can matter",
        verdict,
        found,
    );
    let Some(yardstick) = yardstick else {
        comparison.check(
            "parting as the control pair does",
            Verdict::NotMade,
            "give a control run (--control) that differs from the second one only in verletDist, or --twins",
        );
        return;
    };
    let Some(control) = yardstick.control else {
        let parting = Parting::of(a, b);
        for (name, key, value) in [
            (
                "growth of rounding differences",
                parting::GROWTH_KEY,
                parting.steps_per_e,
            ),
            (
                "as far apart in the end as twins",
                parting::SETTLED_KEY,
                parting.steps_per_e.map(|_| parting.settled_median),
            ),
        ] {
            let (verdict, found) = yardstick.spread.judge(key, value);
            comparison.check(name, verdict, found);
        }
        return;
    };
    let wrong = unfit_control(b, control);
    comparison.check(
        "control differs from B in verletDist only",
        pass_if(wrong.is_none()),
        wrong.unwrap_or_else(|| control.record.engine.label()),
    );
    let partings = Partings::of(a, b, control);
    let (verdict, found) = partings.growth(yardstick.spread);
    comparison.check("growth of rounding differences", verdict, found);
    let (verdict, found) = partings.settled(yardstick.spread);
    comparison.check(
        "as far apart in the end as the control pair",
        verdict,
        found,
    );
    comparison.partings = Some(partings);
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

/// Pairs the quantities of both runs; exact where bits are expected, else judged by the yardstick.
fn quantities(
    a: &RunFolder,
    b: &RunFolder,
    yardstick: Option<Yardstick<'_>>,
    comparison: &mut Comparison,
) {
    let exact = comparison.bits_expected;
    let (of_a, of_b) = (spread::quantities(a), spread::quantities(b));
    let of_control = yardstick
        .and_then(|yardstick| yardstick.control)
        .map(spread::quantities);
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
            yardstick.and_then(|yardstick| yardstick.spread.allowed(key))
        };
        let verdict = match (difference, allowed) {
            (Some(difference), Some(allowed)) => pass_if(difference <= allowed),
            // Bits are expected, and one run has a measure that the other has not.
            (None, Some(_)) => Verdict::Fail,
            _ => Verdict::NotMade,
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
