//! Two campaigns of one scene: the bits of what both have run, and whether all of their packings are of one kind.
//!
//! The margins are those of `crossgrain pareto`, set before any of these runs. The packing is the unit: a difference of
//! means has Welch's interval over packings, equivalence is two one-sided tests, and distributions are compared by
//! exchanging packings.

use serde::{Deserialize, Serialize};

use super::CampaignError;
use super::member::Member;
use super::merged::Merged;
use crate::study::realization::Ending;
use crate::study::tradeoff::margins::CHARTED;
use evidence::equivalence::Finding;
use evidence::moments::{deviation, mean};
use evidence::proportion;
use evidence::two_samples::{self, TwoSamples};
use evidence::unpaired::{self, Unpaired};
use evidence::{Interval, holm};

/// Exchanges of packings for the p of two samples.
const PERMUTATIONS: usize = 2000;

/// The bits of realizations that both campaigns have run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bits {
    /// In both, with an end that has a state.
    pub common: usize,
    /// Settled beds with the same bits, contacts included.
    pub settled: usize,
    /// Last moments with the same bits, contacts and punch included.
    pub last: usize,
}

/// One quantity of both campaigns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Compared {
    /// The member's key.
    pub key: String,
    /// For people.
    pub title: String,
    /// SI unit, `1` for a ratio.
    pub unit: String,
    /// Mean and standard deviation of the first and of the second, over so many packings.
    pub first: [f64; 2],
    /// See `first`.
    pub second: [f64; 2],
    /// Packings that have it.
    pub packings: [usize; 2],
    /// Second minus first.
    pub unpaired: Unpaired,
    /// The largest difference that is no matter; none where the quantity judges nothing.
    pub margin: Option<f64>,
    /// Of the margin.
    pub finding: Option<Finding>,
    /// p of the equivalence, corrected for the number of quantities (Holm).
    pub equivalence_p: Option<f64>,
    /// The whole distribution.
    pub distribution: TwoSamples,
    /// p of D, corrected for the number of quantities (Holm).
    pub distribution_p: f64,
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
    /// No quantity is shown to be beyond its margin, but some have too few packings to be shown to be within it.
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
    /// In the order of the chart; empty where the bits say all.
    pub quantities: Vec<Compared>,
    /// What it says.
    pub verdict: Verdict,
}

/// Compares two merged campaigns, whose scenes must be the same but for the realizations.
pub fn compare(first: &Merged, second: &Merged) -> Result<Comparison, CampaignError> {
    let scene = |of: &Merged| {
        let mut scene = of.plan.scene.clone();
        scene.realization = 0;
        scene.digest()
    };
    if scene(first) != scene(second) {
        return Err(CampaignError::Usage(
            "the campaigns are of different scenes, so their packings cannot be compared"
                .to_owned(),
        ));
    }
    let bits = bits(&first.members, &second.members);
    let same = bits.common > 0 && bits.settled == bits.common && bits.last == bits.common;
    let quantities = if same {
        Vec::new()
    } else {
        quantities(&first.members, &second.members)
    };
    let missed = |members: &[Member]| {
        let missed = members.iter().filter(|of| of.ending != Ending::Reached);
        (missed.count(), members.len())
    };
    Ok(Comparison {
        engines: [first.summary.engine.clone(), second.summary.engine.clone()],
        packings: [first.members.len(), second.members.len()],
        bits,
        missed: proportion::difference(missed(&first.members), missed(&second.members), 0.95),
        verdict: verdict(same, &quantities),
        quantities,
    })
}

fn bits(first: &[Member], second: &[Member]) -> Bits {
    let mut bits = Bits {
        common: 0,
        settled: 0,
        last: 0,
    };
    for of in first {
        let other = second
            .iter()
            .find(|other| other.realization == of.realization);
        let Some(other) = other.filter(|other| other.last_state.is_some()) else {
            continue;
        };
        if of.last_state.is_none() {
            continue;
        }
        bits.common += 1;
        bits.settled += usize::from(of.settled_state == other.settled_state);
        bits.last += usize::from(of.last_state == other.last_state && of.ending == other.ending);
    }
    bits
}

fn quantities(first: &[Member], second: &[Member]) -> Vec<Compared> {
    let mut compared: Vec<Compared> = CHARTED
        .iter()
        .filter_map(|charted| {
            let values = |members: &[Member]| -> Vec<f64> {
                let values = members.iter().map(|of| of.measured.get(charted.key));
                values.flatten().copied().collect()
            };
            let (a, b) = (values(first), values(second));
            let unpaired = unpaired::welch(&a, &b)?;
            let margin = charted.margin.map(|margin| margin.absolute(mean(&a)));
            let tested = margin.and_then(|margin| unpaired::equivalence(&unpaired, margin));
            let packings = |values: &[f64]| -> Vec<Vec<f64>> {
                values.iter().map(|value| vec![*value]).collect()
            };
            let distribution = two_samples::compare(&packings(&a), &packings(&b), PERMUTATIONS)?;
            Some(Compared {
                key: charted.key.to_owned(),
                title: charted.title.to_owned(),
                unit: charted.unit.to_owned(),
                first: [mean(&a), deviation(&a)],
                second: [mean(&b), deviation(&b)],
                packings: [a.len(), b.len()],
                unpaired,
                margin,
                finding: tested.map(|(finding, _)| finding),
                equivalence_p: tested.map(|(_, p)| p),
                distribution_p: distribution.kolmogorov_p,
                distribution,
            })
        })
        .collect();
    let p: Vec<f64> = compared.iter().map(|of| of.distribution_p).collect();
    for (of, adjusted) in compared.iter_mut().zip(holm::adjusted(&p)) {
        of.distribution_p = adjusted;
    }
    let p: Vec<f64> = compared.iter().filter_map(|of| of.equivalence_p).collect();
    let mut adjusted = holm::adjusted(&p).into_iter();
    for of in compared.iter_mut().filter(|of| of.equivalence_p.is_some()) {
        of.equivalence_p = adjusted.next();
    }
    compared
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
