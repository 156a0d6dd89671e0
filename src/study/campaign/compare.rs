//! Two campaigns of one scene, in whichever engines: the bits of what both have run, and whether all of their packings are of one
//! kind.
//!
//! The margins are those of the trade-off, set before any of these runs. The packing is the unit: a difference of means
//! has Welch's interval over packings. Equality is two one-sided tests of every quantity with a margin and of the share of punches
//! that missed the force; all of them must hold, so none is corrected for their number (intersection–union). A difference beyond a
//! margin is corrected (Holm), since one is enough. A quantity that some packings lack counts as equal only where as
//! many packings of both campaigns are shown to have it.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;
use verdict::judge::Verdict;

use super::{Member, Merged};
use crate::checks::{Check, Outcome};
use crate::compare::first_steps::sentence;
use crate::document::{Document, Section, Table};
use crate::study::StudyError;
use crate::study::realization::Ending;
use crate::study::tradeoff::judge::{
    IN_SPACE, MISSED, MISSED_KEY, MISSED_TITLE, QUANTITIES, Quantity, outcome, word,
};
use evidence::moments::{mean, standard_deviation};
use evidence::random::{Key, replicates};
use evidence::t_test::{self, Finding, LEVEL, Welch};
use evidence::two_samples::{self, TwoSamples};
use evidence::{Interval, holm, proportion};

/// Exchanges of packings for the p of two samples.
const PERMUTATIONS: usize = 2000;
/// Pairs of campaigns that are drawn for the power of the whole: it is known to 0.05.
const DRAWN: usize = 400;
/// The probability with which so many packings decide that are said to.
const ENOUGH: f64 = 0.9;
/// More are not proposed.
const MOST_PACKINGS: usize = 1_000_000;
const MARGINS: &str = "the margins of the trade-off";
const KEY: Key = *b"crossgrain: campaigns drawn anew";

/// The bits of realizations that both campaigns have run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Bits {
    /// In both.
    pub common: usize,
    /// Settled beds with the same bits, contacts included.
    pub settled: usize,
    /// The same ends, with last moments of the same bits, contacts and punch included.
    pub last: usize,
}

/// One quantity of both campaigns, of the first and of the second.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Compared {
    pub key: &'static str,
    pub title: &'static str,
    /// SI unit, `1` for a ratio.
    pub unit: &'static str,
    pub packings: [usize; 2],
    /// Mean and standard deviation; not a number without packings, and then null in JSON.
    pub moments: [[Option<f64>; 2]; 2],
    /// Share of packings that have it, second minus first, with Newcombe's 90 % interval; none where all have it.
    pub share: Option<Interval>,
    /// Second minus first; none for fewer than two packings on a side, or where nothing varies.
    pub welch: Option<Welch>,
    /// The largest difference that is no matter; none where the quantity judges nothing.
    pub margin: Option<f64>,
    /// What is judged: Different where `difference_p` < 0.05 or the shares are beyond their margin; Equivalent where
    /// `equivalence_p` < 0.05 and the shares are within it. None without a margin.
    pub finding: Option<Finding>,
    /// p of means that differ by the margin or more.
    pub equivalence_p: Option<f64>,
    /// p of means that differ by no more than the margin, corrected for the number of quantities (Holm).
    pub difference_p: Option<f64>,
    /// The probability that `equivalence_p` is below 0.05 if the means are equal, for these packings and deviations.
    pub power: Option<f64>,
    pub distribution: Option<TwoSamples>,
    /// p of its D, corrected for the number of quantities (Holm).
    pub distribution_p: Option<f64>,
}

/// What quantities and missed forces say.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judgement {
    /// Share of punches that missed the force, second minus first, with Newcombe's 90 % interval.
    pub missed: Option<Interval>,
    /// That share against its margin.
    pub missed_finding: Finding,
    /// In the order of the trade-off's list.
    pub quantities: Vec<Compared>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    pub engines: [String; 2],
    pub packings: [usize; 2],
    /// What both have run.
    pub bits: Bits,
    pub judged: Option<Judgement>,
    /// The probability that the packings would be found equal in distribution if all means were equal, with its 95 % interval: the
    /// share of pairs of campaigns that were, drawn with replacement from both after their means were made equal.
    pub power: Option<Interval>,
    pub verdict: Verdict,
}

/// A campaign's numbers in columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Packings {
    /// [`QUANTITIES`], or those [`IN_SPACE`].
    quantities: &'static [Quantity],
    /// Of each of them, one a packing.
    columns: Vec<Vec<Option<f64>>>,
    reached: Vec<bool>,
}

impl Packings {
    pub fn of(members: &[Member], in_space: bool) -> Self {
        let quantities: &'static [Quantity] = if in_space { &IN_SPACE } else { &QUANTITIES };
        let column = |key| {
            members
                .iter()
                .map(move |member| member.measured.get(key).copied())
        };
        let columns = quantities
            .iter()
            .map(|quantity| column(quantity.key).collect());
        let reached = members
            .iter()
            .map(|member| member.ending == Ending::Reached);
        Packings {
            quantities,
            columns: columns.collect(),
            reached: reached.collect(),
        }
    }

    pub fn count(&self) -> usize {
        self.reached.len()
    }

    /// Those at these places, each of which may come more than once.
    pub fn at(&self, places: &[usize]) -> Self {
        let sampled =
            |column: &Vec<Option<f64>>| places.iter().map(|place| column[*place]).collect();
        Packings {
            quantities: self.quantities,
            columns: self.columns.iter().map(sampled).collect(),
            reached: places.iter().map(|place| self.reached[*place]).collect(),
        }
    }

    /// With this added to a quantity.
    pub fn moved(mut self, key: &str, by: f64) -> Self {
        for (quantity, column) in self.quantities.iter().zip(&mut self.columns) {
            if quantity.key == key {
                column.iter_mut().flatten().for_each(|value| *value += by);
            }
        }
        self
    }

    fn values(&self, quantity: usize) -> Vec<f64> {
        self.columns[quantity].iter().flatten().copied().collect()
    }

    fn missed(&self) -> (usize, usize) {
        let reached = self.reached.iter().filter(|reached| **reached).count();
        (self.count() - reached, self.count())
    }
}

/// Compares two merged campaigns, whose scenes must be the same but for the realizations.
pub fn compare(first: &Merged, second: &Merged) -> Result<Comparison, StudyError> {
    let scene = |campaign: &Merged| {
        let mut scene = campaign.plan.study.scene.clone();
        scene.realization = 0;
        scene.digest()
    };
    if scene(first) != scene(second) {
        let why = "the campaigns are of different scenes, so their packings cannot be compared";
        return Err(StudyError::Usage(why.to_owned()));
    }
    let bits = bits(&first.rows, &second.rows);
    let same = bits.common > 0 && bits.settled == bits.common && bits.last == bits.common;
    let in_space = first.plan.study.scene.in_space();
    let sides = [first, second].map(|campaign| Packings::of(&campaign.rows, in_space));
    let judged = (!same).then(|| judge(&sides[0], &sides[1]).complete(&sides[0], &sides[1]));
    Ok(Comparison {
        engines: [first.summary.engine.clone(), second.summary.engine.clone()],
        packings: [first.rows.len(), second.rows.len()],
        bits,
        power: if same { None } else { power(&sides) },
        verdict: (judged.as_ref()).map_or(Verdict::Identical, Judgement::verdict),
        judged,
    })
}

fn bits(first: &[Member], second: &[Member]) -> Bits {
    let second: BTreeMap<u64, &Member> = second
        .iter()
        .map(|member| (member.realization, member))
        .collect();
    let mut bits = Bits::default();
    for member in first {
        let Some(other) = second.get(&member.realization) else {
            continue;
        };
        // An end without a state has no bits that could be the same.
        let same = |a: &Option<String>, b: &Option<String>| usize::from(a.is_some() && a == b);
        bits.common += 1;
        bits.settled += same(&member.settled_state, &other.settled_state);
        if member.ending == other.ending && measured_alike(member, other) {
            bits.last += same(&member.loaded_state, &other.loaded_state);
        }
    }
    bits
}

/// Whether what was measured of both is the same, as it is of the same moments: what an engine tells besides plays a part too.
fn measured_alike(member: &Member, other: &Member) -> bool {
    let values = member.measured.iter();
    let mut both = values.filter_map(|(key, value)| Some((value, other.measured.get(key)?)));
    both.all(|(one, two)| (one - two).abs() <= MEASURED_AGAIN * one.abs().max(two.abs()))
}

/// Of a number that is measured again by another version a share of this much may be other digits.
const MEASURED_AGAIN: f64 = 1.0e-9;

/// Compares packings of two campaigns; what judges nothing is left out, see [`Judgement::complete`].
pub fn judge(first: &Packings, second: &Packings) -> Judgement {
    let all = (0..first.quantities.len()).map(|index| quantity(index, first, second));
    let mut quantities: Vec<Compared> = all.collect();
    correct(&mut quantities, |compared| &mut compared.difference_p);
    for compared in &mut quantities {
        compared.finding = compared.margin.map(|_| finding(compared));
    }
    let missed = proportion::difference(first.missed(), second.missed(), 1.0 - 2.0 * LEVEL);
    Judgement {
        missed,
        missed_finding: missed.map_or(Finding::Undecided, |interval| {
            t_test::finding(&interval, MISSED)
        }),
        quantities,
    }
}

fn quantity(index: usize, first: &Packings, second: &Packings) -> Compared {
    let charted = &first.quantities[index];
    let (a, b) = (first.values(index), second.values(index));
    let moments = [&a, &b].map(|values| [mean(values), standard_deviation(values)]);
    let welch = t_test::welch(&a, &b);
    // Where the first has none, any margin will do: nothing is shown.
    let scale = if a.is_empty() { 0.0 } else { moments[0][0] };
    let margin = charted.margin.map(|margin| margin.absolute(scale));
    let judged = welch.zip(margin);
    let packings = [a.len(), b.len()];
    let all = [first.count(), second.count()];
    let level = 1.0 - 2.0 * LEVEL;
    let share = proportion::difference((a.len(), all[0]), (b.len(), all[1]), level);
    Compared {
        key: charted.key,
        title: charted.title,
        unit: charted.unit,
        packings,
        moments: moments
            .map(|side| side.map(|moment| Some(moment).filter(|value| value.is_finite()))),
        share: share.filter(|_| packings != all),
        margin,
        equivalence_p: judged.and_then(|(test, margin)| Some(test.equivalence(margin)?.1)),
        difference_p: judged.and_then(|(test, margin)| test.p_beyond(margin)),
        welch,
        ..Compared::default()
    }
}

/// Corrects the p values that are there for their number (Holm).
fn correct(compared: &mut [Compared], p: impl Fn(&mut Compared) -> &mut Option<f64>) {
    let all: Vec<f64> = compared
        .iter_mut()
        .filter_map(|quantity| *p(quantity))
        .collect();
    let mut corrected = holm::adjusted(&all).into_iter();
    for value in compared.iter_mut().map(p).filter(|value| value.is_some()) {
        *value = corrected.next();
    }
}

fn finding(compared: &Compared) -> Finding {
    let share = compared.share.map(|share| t_test::finding(&share, MISSED));
    let below = |p: Option<f64>| p.is_some_and(|p| p < LEVEL);
    if below(compared.difference_p) || share == Some(Finding::Different) {
        Finding::Different
    } else if below(compared.equivalence_p)
        && share.is_none_or(|found| found == Finding::Equivalent)
    {
        Finding::Equivalent
    } else {
        Finding::Undecided
    }
}

/// The share of drawn pairs of campaigns with equal means that are equal in distribution.
fn power([first, second]: &[Packings; 2]) -> Option<Interval> {
    let mut centred = second.clone();
    for (index, quantity) in first.quantities.iter().enumerate() {
        let off = mean(&first.values(index)) - mean(&second.values(index));
        centred = centred.moved(quantity.key, off);
    }
    let equal = replicates(&KEY, DRAWN, |source| {
        let mut draw = |packings: &Packings| {
            let places: Vec<usize> = (0..packings.count())
                .map(|_| source.below(packings.count()))
                .collect();
            packings.at(&places)
        };
        judge(&draw(first), &draw(&centred)).verdict() == Verdict::EqualInDistribution
    });
    let equal = equal.into_iter().filter(|equal| *equal).count();
    proportion::wilson(equal, DRAWN, 0.95)
}

impl Compared {
    /// How many packings of each side show equality, if the means are equal and deviations as they are; none where no number does.
    fn needs(&self) -> Option<usize> {
        let deviations = [self.moments[0][1]?, self.moments[1][1]?];
        let shows = |count: usize| {
            let power = t_test::power([count; 2], deviations, self.margin?);
            Some(power? >= ENOUGH)
        };
        let mut most = self.packings[0].min(self.packings[1]).max(2);
        while !shows(most)? {
            most = most.checked_mul(2).filter(|count| *count < MOST_PACKINGS)?;
        }
        let mut least = most / 2;
        while most - least > 1 + least / 20 {
            let middle = least.midpoint(most);
            match shows(middle)? {
                true => most = middle,
                false => least = middle,
            }
        }
        Some(most)
    }
}

impl Judgement {
    /// Different if one finding is, equal if all are.
    pub fn verdict(&self) -> Verdict {
        let of_quantities = self
            .quantities
            .iter()
            .filter_map(|compared| compared.finding);
        let all: Vec<Finding> = of_quantities.chain([self.missed_finding]).collect();
        match t_test::together(&all) {
            Finding::Different => Verdict::Different,
            Finding::Undecided => Verdict::Undecided,
            Finding::Equivalent => Verdict::EqualInDistribution,
        }
    }

    /// With what is shown and judges nothing: powers and distributions.
    pub fn complete(mut self, first: &Packings, second: &Packings) -> Self {
        for (index, compared) in self.quantities.iter_mut().enumerate() {
            if compared.welch.is_none() {
                continue;
            }
            let sides = [first, second].map(|side| side.values(index));
            let deviations = sides.each_ref().map(|values| standard_deviation(values));
            compared.power = compared
                .margin
                .and_then(|margin| t_test::power(compared.packings, deviations, margin));
            let [a, b] = sides.map(|values| {
                values
                    .into_iter()
                    .map(|value| vec![value])
                    .collect::<Vec<_>>()
            });
            compared.distribution = two_samples::compare(&a, &b, PERMUTATIONS);
            compared.distribution_p = compared
                .distribution
                .as_ref()
                .map(|distribution| distribution.kolmogorov_p);
        }
        correct(&mut self.quantities, |compared| {
            &mut compared.distribution_p
        });
        self
    }

    /// How many packings would decide what so many leave open, were the means and shares equal.
    fn needs(&self, packings: [usize; 2]) -> String {
        let open = self.quantities.iter();
        let open = open.filter(|compared| compared.finding == Some(Finding::Undecided));
        let mut needed: Vec<Option<usize>> = open.map(Compared::needs).collect();
        if self.missed_finding == Finding::Undecided {
            // The interval's width falls as the square root of their number.
            let shorter = self
                .missed
                .map(|interval| 0.5 * (interval.high - interval.low) / MISSED);
            let least = packings[0].min(packings[1]) as f64;
            needed.push(shorter.map(|ratio| (least * (1.1 * ratio).powi(2)).ceil() as usize));
        }
        let needed: Option<Vec<usize>> = needed.into_iter().collect();
        match needed.and_then(|counts| counts.into_iter().max()) {
            Some(most) if most > packings[0].min(packings[1]) => format!(
                "where the engines are equal, about {most} packings of each would show it for each of these in {:.0} % of the cases",
                100.0 * ENOUGH
            ),
            // What some packings lack, or fewer than two of a side.
            _ => "run more members".to_owned(),
        }
    }

    fn checks(&self) -> Vec<Check> {
        let check = |compared: &Compared| {
            let outcome = outcome(compared.finding?);
            let found = match outcome {
                Outcome::Skipped => "too few packings, or packings without it",
                _ => "",
            };
            let id = format!("campaigns/{}", compared.key);
            let mut check = Check {
                unit: compared.unit.to_owned(),
                n: compared.packings[0].min(compared.packings[1]) as u64,
                ..Check::of_words(id, compared.title, outcome, found)
            };
            if let Some(welch) = &compared.welch {
                check = check.with_limits(welch.difference.estimate, 0.0, compared.margin);
                check.interval = Some([welch.difference.low, welch.difference.high]);
            }
            Some(check.judged_by(
                "difference of means, second minus first: two one-sided tests at 5 %, Welch",
                MARGINS,
            ))
        };
        let id = format!("campaigns/{MISSED_KEY}");
        let estimate = self.missed.map_or(f64::NAN, |interval| interval.estimate);
        let missed = Check::of_words(id, MISSED_TITLE, outcome(self.missed_finding), "")
            .with_limits(estimate, 0.0, Some(MISSED))
            .judged_by(
                "difference of shares, second minus first: Newcombe's 90 % interval",
                MARGINS,
            );
        let all = self.quantities.iter().filter_map(check);
        all.chain([missed]).map(Check::required).collect()
    }

    fn section(&self) -> Section {
        let table = Table::of("quantities", "Means over packings", &self.quantities)
            .column("quantity", |compared| compared.title)
            .column("unit", |compared| compared.unit)
            .column("first", |compared| compared.moments[0][0])
            .column("second", |compared| compared.moments[1][0])
            .column("packings of the first", |compared| compared.packings[0])
            .column("packings of the second", |compared| compared.packings[1])
            .column("second − first (95 %)", |compared| {
                compared.welch.map(|test| test.difference)
            })
            .column("margin", |compared| compared.margin)
            .column(
                "packings that have it, second − first (90 %)",
                |compared| compared.share,
            )
            .column("finding", |compared| {
                compared.finding.map_or("not judged", word)
            })
            .column("p of equivalence", |compared| compared.equivalence_p)
            .column("p of a difference (Holm)", |compared| compared.difference_p)
            .column(
                "probability of equivalence if the means are equal",
                |compared| compared.power,
            )
            .column("p of one distribution (Holm), judges nothing", |compared| {
                compared.distribution_p
            });
        let forces = Table::of("missed", "Punches that missed the force", [self])
            .column("share, second − first (90 %)", |judgement| {
                judgement.missed
            })
            .column("margin", |_| MISSED)
            .column("finding", |judgement| word(judgement.missed_finding));
        Section::new("Quantities", "").with(table).with(forces)
    }
}

impl Comparison {
    /// Two campaigns of one engine are named with their folders.
    #[must_use]
    pub fn told_apart(mut self, folders: [&Path; 2]) -> Self {
        if self.engines[0] == self.engines[1] {
            for (engine, folder) in self.engines.iter_mut().zip(folders) {
                *engine += &format!(" in {}", folder.display());
            }
        }
        self
    }

    /// Every quantity with a margin, or the bits that say all.
    fn checks(&self) -> Vec<Check> {
        let found = format!("{} realizations in both", self.bits.common);
        let same = Check::of_words("campaigns/bits", "same bits", Outcome::Pass, &found);
        self.judged.as_ref().map_or(vec![same], Judgement::checks)
    }

    /// What decides, and what so many packings could have shown.
    fn answer(&self) -> String {
        let verdict = format!("{}.", sentence(self.verdict.in_words()));
        let Some(judged) = &self.judged else {
            let (common, [first, second]) = (self.bits.common, self.packings);
            return match first.max(second) - common {
                0 => verdict,
                _ => format!(
                    "{verdict} That is of the {common} realizations that both have; of the others, {} of the first and {} of the second, nothing is \
                     said.",
                    first - common,
                    second - common
                ),
            };
        };
        let of_quantities = judged.quantities.iter();
        let all = of_quantities.filter_map(|compared| Some((compared.finding?, compared.title)));
        let all: Vec<_> = all.chain([(judged.missed_finding, MISSED_TITLE)]).collect();
        let named = |wanted| {
            let own = all.iter().filter(|pair| pair.0 == wanted);
            own.map(|pair| pair.1).collect::<Vec<&str>>()
        };
        let (count, [first, second]) = (all.len(), self.packings);
        let open = named(Finding::Undecided).len();
        let mut answer = match self.verdict {
            Verdict::Different => format!(
                "These differ by more than their margins: {}.",
                named(Finding::Different).join(", ")
            ),
            Verdict::Undecided => format!(
                "{open} of {count} quantities are undecided: {first} and {second} packings show neither that they differ by more than \
                 their margins nor that they differ by less. None is shown to differ; {}.",
                judged.needs(self.packings)
            ),
            _ => verdict,
        };
        if let Some(power) = self.power.filter(|_| self.verdict != Verdict::Different) {
            answer += &format!(
                " With so many packings two equal engines are found equal in {:.0} % of the cases ({:.0} to {:.0} %).",
                100.0 * power.estimate,
                100.0 * power.low,
                100.0 * power.high
            );
        }
        answer
    }

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
        let mut sections = vec![Section::new("Campaigns", "").with(both).with(bits)];
        sections.extend(self.judged.as_ref().map(Judgement::section));
        Document {
            verdict: self.verdict.into(),
            ..Document::new("Two campaigns", self.answer(), self.checks()).with(sections)
        }
    }
}
