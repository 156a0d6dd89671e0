//! Two campaigns of one scene: the bits of what both have run, and whether all of their packings are of one kind.
//!
//! The margins are those of the trade-off, set before any of these runs. The packing is the unit: a difference of means
//! has Welch's interval over packings. Equivalence is two one-sided tests of every quantity with a margin; all of them
//! must hold, so none is corrected for their number (intersection–union). A difference beyond a margin is corrected
//! (Holm), since one is enough. A quantity counts as equivalent only where as many packings of both campaigns have it: those
//! whose punch missed the force have no loaded quantities.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Member, Merged};
use crate::checks::{Check, Outcome};
use crate::document::{Document, Section, Table};
use crate::study::StudyError;
use crate::study::realization::Ending;
use crate::study::tradeoff::judge::{QUANTITIES, Quantity, outcome, word};
use evidence::moments::{mean, standard_deviation};
use evidence::t_test::{self, Finding, LEVEL, Welch};
use evidence::two_samples::{self, TwoSamples};
use evidence::{Interval, holm, proportion};

/// Exchanges of packings for the p of two samples.
const PERMUTATIONS: usize = 2000;
/// The largest difference of the shares of packings that have a quantity: a twentieth, as the level of the tests.
const SHARE_MARGIN: f64 = 0.05;

/// The bits of realizations that both campaigns have run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bits {
    /// In both, with an end that has a state.
    pub common: usize,
    /// Settled beds with the same bits, contacts included.
    pub settled: usize,
    /// Last moments with the same bits, contacts and punch included.
    pub last: usize,
}

/// One quantity of both campaigns, of the first and of the second.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Compared {
    /// The member's key.
    pub key: String,
    /// For people.
    pub title: String,
    /// SI unit, `1` for a ratio.
    pub unit: String,
    /// Packings that have it.
    pub packings: [usize; 2],
    /// Mean and standard deviation; not a number without packings, and then null in JSON.
    pub moments: [[Option<f64>; 2]; 2],
    /// Share of packings that have it, second minus first, with Newcombe's 90 % interval.
    pub share: Option<Interval>,
    /// Second minus first; none for fewer than two packings on a side, or where nothing varies.
    pub unpaired: Option<Welch>,
    /// The largest difference that is no matter; none where the quantity judges nothing.
    pub margin: Option<f64>,
    /// What is judged: Different where `difference_p` < 0.05 or the shares are beyond their margin; Equivalent where
    /// `equivalence_p` < 0.05 and the shares are within it. None without a margin.
    pub finding: Option<Finding>,
    /// p of means that differ by the margin or more.
    pub equivalence_p: Option<f64>,
    /// p of means that differ by no more than the margin, corrected for the number of quantities (Holm).
    pub difference_p: Option<f64>,
    /// The whole distribution, which judges nothing.
    pub distribution: Option<TwoSamples>,
    /// p of its D, corrected for the number of quantities (Holm).
    pub distribution_p: Option<f64>,
}

/// What the comparison says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Every common realization has the same bits.
    SameBits,
    /// Every quantity with a margin is equivalent.
    Equivalent,
    /// Some quantity is beyond its margin.
    Different,
    /// No quantity is shown to be beyond its margin, but some are not shown to be within it.
    Undecided,
}

/// Two campaigns compared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Comparison {
    /// Engines of the two.
    pub engines: [String; 2],
    /// Packings of the two.
    pub packings: [usize; 2],
    /// What both have run.
    pub bits: Bits,
    /// Share of punches that missed the force, second minus first, with Newcombe's 95 % interval.
    pub missed: Option<Interval>,
    /// In the order of the trade-off's list; empty where the bits say all.
    pub quantities: Vec<Compared>,
    /// What it says.
    pub verdict: Verdict,
}

/// Compares two merged campaigns, whose scenes must be the same but for the realizations.
pub fn compare(first: &Merged, second: &Merged) -> Result<Comparison, StudyError> {
    let scene = |of: &Merged| {
        let mut scene = of.plan.study.scene.clone();
        scene.realization = 0;
        scene.digest()
    };
    if scene(first) != scene(second) {
        return Err(StudyError::Usage(
            "the campaigns are of different scenes, so their packings cannot be compared"
                .to_owned(),
        ));
    }
    let bits = bits(&first.rows, &second.rows);
    let same = bits.common > 0 && bits.settled == bits.common && bits.last == bits.common;
    let quantities = if same {
        Vec::new()
    } else {
        quantities(&first.rows, &second.rows)
    };
    let missed = |members: &[Member]| {
        let missed = members.iter().filter(|of| of.ending != Ending::Reached);
        (missed.count(), members.len())
    };
    Ok(Comparison {
        engines: [first.summary.engine.clone(), second.summary.engine.clone()],
        packings: [first.rows.len(), second.rows.len()],
        bits,
        missed: proportion::difference(missed(&first.rows), missed(&second.rows), 0.95),
        verdict: verdict(same, &quantities),
        quantities,
    })
}

fn bits(first: &[Member], second: &[Member]) -> Bits {
    let second: BTreeMap<u64, &Member> = second.iter().map(|of| (of.realization, of)).collect();
    let mut bits = Bits::default();
    for of in first.iter().filter(|of| of.loaded_state.is_some()) {
        let other = second.get(&of.realization);
        if let Some(other) = other.filter(|other| other.loaded_state.is_some()) {
            bits.common += 1;
            bits.settled += usize::from(of.settled_state == other.settled_state);
            bits.last +=
                usize::from(of.loaded_state == other.loaded_state && of.ending == other.ending);
        }
    }
    bits
}

fn quantities(first: &[Member], second: &[Member]) -> Vec<Compared> {
    let mut compared: Vec<Compared> = QUANTITIES
        .iter()
        .map(|charted| quantity(charted, first, second))
        .collect();
    correct(&mut compared, |of| &mut of.distribution_p);
    correct(&mut compared, |of| &mut of.difference_p);
    for of in &mut compared {
        of.finding = of.margin.map(|_| finding(of));
    }
    compared
}

fn quantity(charted: &Quantity, first: &[Member], second: &[Member]) -> Compared {
    let values = |members: &[Member]| -> Vec<f64> {
        let values = members.iter().map(|of| of.measured.get(charted.key));
        values.flatten().copied().collect()
    };
    let (a, b) = (values(first), values(second));
    let moments = |values: &[f64]| {
        [mean(values), standard_deviation(values)].map(|of| Some(of).filter(|of| of.is_finite()))
    };
    let packings =
        |values: &[f64]| -> Vec<Vec<f64>> { values.iter().map(|of| vec![*of]).collect() };
    let unpaired = t_test::welch(&a, &b);
    let distribution = match unpaired {
        Some(_) => two_samples::compare(&packings(&a), &packings(&b), PERMUTATIONS),
        None => None,
    };
    // Where the first has none, any margin will do: nothing is shown.
    let margin = charted
        .margin
        .map(|margin| margin.absolute(moments(&a)[0].unwrap_or(0.0)));
    let judged = unpaired.zip(margin);
    Compared {
        key: charted.key.to_owned(),
        title: charted.title.to_owned(),
        unit: charted.unit.to_owned(),
        packings: [a.len(), b.len()],
        moments: [moments(&a), moments(&b)],
        share: proportion::difference((a.len(), first.len()), (b.len(), second.len()), 0.90),
        margin,
        finding: None,
        equivalence_p: judged.and_then(|(of, margin)| Some(of.equivalence(margin)?.1)),
        difference_p: judged.and_then(|(of, margin)| of.p_beyond(margin)),
        distribution_p: distribution.as_ref().map(|of| of.kolmogorov_p),
        unpaired,
        distribution,
    }
}

/// Corrects the p values that are there for their number (Holm).
fn correct(compared: &mut [Compared], p: impl Fn(&mut Compared) -> &mut Option<f64>) {
    let all: Vec<f64> = compared.iter_mut().filter_map(|of| *p(of)).collect();
    let mut corrected = holm::adjusted(&all).into_iter();
    for value in compared.iter_mut().map(p).filter(|of| of.is_some()) {
        *value = corrected.next();
    }
}

fn finding(of: &Compared) -> Finding {
    let share = of.share.map(|share| t_test::finding(&share, SHARE_MARGIN));
    let below = |p: Option<f64>| p.is_some_and(|p| p < LEVEL);
    if below(of.difference_p) || share == Some(Finding::Different) {
        Finding::Different
    } else if below(of.equivalence_p) && share == Some(Finding::Equivalent) {
        Finding::Equivalent
    } else {
        Finding::Undecided
    }
}

fn verdict(same: bool, quantities: &[Compared]) -> Verdict {
    let all: Vec<Finding> = quantities.iter().filter_map(|of| of.finding).collect();
    if same {
        Verdict::SameBits
    } else if all.contains(&Finding::Different) {
        Verdict::Different
    } else if all.is_empty() || all.contains(&Finding::Undecided) {
        Verdict::Undecided
    } else {
        Verdict::Equivalent
    }
}

impl Comparison {
    /// Every quantity with a margin, or the bits that say all.
    fn checks(&self) -> Vec<Check> {
        if self.verdict == Verdict::SameBits {
            let found = format!("{} realizations in both", self.bits.common);
            let id = "campaigns/bits".to_owned();
            return vec![Check::of_words(id, "same bits", Outcome::Pass, &found)];
        }
        let check =
            |of: &Compared| {
                let outcome = outcome(of.finding?);
                let found = match outcome {
                    Outcome::Skipped => "too few packings, or packings without it",
                    _ => "",
                };
                let id = format!("campaigns/{}", of.key);
                let mut check = Check::of_words(id, &of.title, outcome, found).required().judged_by(
                "difference of means, second minus first: two one-sided tests at 5 %, Welch",
                "the margins of the trade-off",
            );
                check.unit.clone_from(&of.unit);
                check.n = of.packings[0].min(of.packings[1]) as u64;
                if let Some(unpaired) = &of.unpaired {
                    check = check.with_limits(unpaired.difference.estimate, 0.0, of.margin);
                    check.interval = Some([unpaired.difference.low, unpaired.difference.high]);
                }
                Some(check)
            };
        self.quantities.iter().filter_map(check).collect()
    }

    /// For people.
    pub fn document(&self) -> Document {
        let both = Table::of("campaigns", "The campaigns", [("first", 0), ("second", 1)])
            .column("", |(name, _)| name)
            .column("engine", |(_, index)| &self.engines[index])
            .column("packings", |(_, index)| self.packings[index]);
        let counts = [
            ("in both", self.bits.common),
            ("settled beds with the same bits", self.bits.settled),
            ("last moments with the same bits", self.bits.last),
        ];
        let bits = Table::of("bits", "Realizations that both have run", counts)
            .column("", |(words, _)| words)
            .column("realizations", |(_, count)| count);
        let table = Table::of("quantities", "Means over packings", &self.quantities)
            .column("quantity", |of| &of.title)
            .column("unit", |of| &of.unit)
            .column("first", |of| of.moments[0][0])
            .column("second", |of| of.moments[1][0])
            .column("packings of the first", |of| of.packings[0])
            .column("packings of the second", |of| of.packings[1])
            .column("second − first (95 %)", |of| {
                of.unpaired.map(|of| of.difference)
            })
            .column("margin", |of| of.margin)
            .column("share, second − first (90 %)", |of| of.share)
            .column("finding", |of| of.finding.map_or("not judged", word))
            .column("p of equivalence", |of| of.equivalence_p)
            .column("p of a difference (Holm)", |of| of.difference_p)
            .column("p of one distribution (Holm), judges nothing", |of| {
                of.distribution_p
            });
        let (answer, verdict) = match self.verdict {
            Verdict::SameBits => ("SAME BITS", Outcome::Pass),
            Verdict::Equivalent => ("EQUIVALENT", Outcome::Pass),
            Verdict::Different => ("DIFFERENT", Outcome::Fail),
            Verdict::Undecided => (
                "UNDECIDED: more packings are needed for these margins",
                Outcome::Skipped,
            ),
        };
        let forces = Table::of("missed", "Punches that missed the force", [self.missed])
            .column("share, second − first (95 %)", |share| share);
        let mut sections = vec![
            Section::new("Campaigns", "")
                .with(both)
                .with(bits)
                .with(forces),
        ];
        if !self.quantities.is_empty() {
            sections.push(Section::new("Quantities", "").with(table));
        }
        Document {
            title: "Two campaigns".to_owned(),
            verdict,
            answer: answer.to_owned(),
            sections,
            checks: self.checks(),
        }
    }
}
