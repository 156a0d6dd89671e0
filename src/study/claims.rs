//! The paper's claims about its simulations, held against a campaign's members.
//!
//! One number a packing throughout; what is decided is whether an effect is smaller than a tolerance that was set
//! beforehand, never whether a p-value is small: with a thousand packings every difference has a small one.

mod cells;
mod document;
mod laws;
mod means;
mod sample;
mod shapes;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;

use crate::checks::Outcome;
use crate::paper::published::POINTS;
use crate::study::campaign::Member;
pub use crate::study::claims::cells::{Volume, Volumes, continuum};
pub use crate::study::claims::document::{Cloud, Figures};
pub use crate::study::claims::sample::Moment;
use crate::study::claims::sample::Number;
pub use crate::study::claims::shapes::SAMPLES;
use evidence::goodness::Fit;
use evidence::{Interval, holm};
use grains::scene::{Scene, paper_scene};
use serde::{Deserialize, Serialize};
use serde_json::Value;

pub const CLAIMS_VERSION: u32 = 8;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    pub command: String,
    /// Engine and version that ran them.
    pub engine: String,
    pub plan: String,
    pub members_digest: String,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Claims {
    pub version: u32,
    pub crossgrain: String,
    pub origin: Origin,
    pub scene_digest: String,
    /// Where the scene differs from the project's default for the paper: key, default, here.
    pub other_choices: Vec<[String; 3]>,
    pub members: usize,
    pub endings: BTreeMap<String, usize>,
    pub claims: Vec<Claim>,
    /// Of the same author's earlier paper.
    pub earlier: Vec<Claim>,
    /// How many of the paper's claims came to which verdict; `undecided` for those that need more members, `not computable` for those
    /// that hang on a number which no members make.
    pub verdicts: BTreeMap<String, usize>,
    pub complete: bool,
    pub figures: Figures,
    /// The same claims for another scene.
    pub beside: Option<Beside>,
}

/// The paper's claims for another scene, without their figures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Beside {
    pub origin: Origin,
    pub other_choices: Vec<[String; 3]>,
    pub members: usize,
    pub claims: Vec<Claim>,
    pub verdicts: BTreeMap<String, usize>,
}

impl From<Claims> for Beside {
    fn from(claims: Claims) -> Self {
        Beside {
            origin: claims.origin,
            other_choices: claims.other_choices,
            members: claims.members,
            claims: claims.claims,
            verdicts: claims.verdicts,
        }
    }
}

/// Holds the claims against the members of a scene.
pub fn of(scene: &Scene, members: &[Member], origin: Origin) -> Claims {
    let series = cells::all(scene, members);
    let mut claims: Vec<Claim> = [
        means::height(members),
        means::porosity(members),
        means::both(scene, members),
        Some(means::reached(members)),
        means::gravity(members),
        means::at_point(members, "O"),
        means::at_point(members, "A"),
        means::at_point(members, "B"),
        means::extensive(members),
    ]
    .into_iter()
    .flatten()
    .collect();
    claims.extend(POINTS.map(|point| shapes::at_point(members, point)));
    claims.extend(means::with_theorys_rate(members));
    claims.extend([
        shapes::horizontal(members),
        shapes::settled(members),
        shapes::positive_only(members),
        shapes::laplace(members),
        cells::independence(members),
        cells::square_root(members, &series, Moment::Loaded),
        cells::square_root(members, &series, Moment::Settled),
        cells::erlang(members, &series),
        cells::good_enough(members, &series),
    ]);
    claims.push(shapes::conclusion(members, &claims));
    let mut earlier = shapes::of_earlier_paper(members, &claims);
    for claim in claims.iter_mut().chain(&mut earlier) {
        if let Some(row) = claim.not_computable() {
            let why = format!(
                " Not computable: {}, of {} packings out of {}.",
                row.what, row.packings, row.looked_at
            );
            claim.reading += &why;
        }
        // Of too few members there are no numbers.
        claim.reading = claim
            .reading
            .replace("NaN %", "unknown")
            .replace("NaN", "unknown");
    }
    adjust_claims(&mut claims);
    adjust_claims(&mut earlier);
    let endings = members.iter();
    Claims {
        version: CLAIMS_VERSION,
        crossgrain: env!("CARGO_PKG_VERSION").to_owned(),
        origin,
        scene_digest: scene.digest(),
        other_choices: other_choices(scene),
        members: members.len(),
        endings: counted(endings.map(|member| member.ending.name().replace('_', " "))),
        complete: claims
            .iter()
            .chain(&earlier)
            .all(|claim| claim.verdict.is_some()),
        verdicts: counted(claims.iter().map(Claim::word)),
        claims,
        earlier,
        figures: document::data(members, series, means::solid(scene)),
        beside: None,
    }
}

fn counted<S: Into<String>>(words: impl Iterator<Item = S>) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for word in words {
        *counts.entry(word.into()).or_insert(0) += 1;
    }
    counts
}

/// Holm's correction for all of these p-values.
fn adjust<'a>(all: impl Iterator<Item = &'a mut f64>) {
    let all: Vec<&mut f64> = all.collect();
    let given: Vec<f64> = all.iter().map(|p| **p).collect();
    for (p, adjusted) in all.into_iter().zip(holm::adjusted(&given)) {
        *p = adjusted;
    }
}

/// Over the tests of all these claims.
fn adjust_claims(claims: &mut [Claim]) {
    let rows = claims.iter_mut().flat_map(|claim| &mut claim.rows);
    let tests = rows.flat_map(|row| &mut row.probabilities);
    adjust(tests.map(|test| &mut test.adjusted));
}

/// What of the scene is not the default, without its name, realization and words.
fn other_choices(scene: &Scene) -> Vec<[String; 3]> {
    let (default, here) = (leaves(&paper_scene(1, 5000)), leaves(scene));
    let keys: BTreeSet<&String> = default.keys().chain(here.keys()).collect();
    let other = keys.into_iter().filter(|key| {
        let mut left_out = NOT_COMPARED.iter();
        default.get(*key) != here.get(*key) && !left_out.any(|prefix| key.starts_with(prefix))
    });
    let absent = "–".to_owned();
    let both = other.map(|key| {
        let value = |leaves: &BTreeMap<String, String>| leaves.get(key).unwrap_or(&absent).clone();
        [key.clone(), value(&default), value(&here)]
    });
    both.collect()
}

const NOT_COMPARED: [&str; 4] = [
    "/choices",
    "/name",
    "/realization",
    "/measurement/history_every",
];

/// Of the scene's JSON, by their paths.
fn leaves(scene: &Scene) -> BTreeMap<String, String> {
    let (mut leaves, mut open) = (BTreeMap::new(), vec![(String::new(), scene.json())]);
    while let Some((path, value)) = open.pop() {
        let below = |key: &dyn Display| format!("{path}/{key}");
        match value {
            Value::Object(map) => {
                open.extend(map.into_iter().map(|(key, value)| (below(&key), value)))
            }
            Value::Array(list) => {
                let all = list.into_iter().enumerate();
                open.extend(all.map(|(index, value)| (below(&index), value)));
            }
            leaf => {
                leaves.insert(path, leaf.to_string());
            }
        }
    }
    leaves
}

/// With fewer packings than this nothing holds.
pub const FEWEST: usize = 30;
/// A claim does not hold with this many realizations at least: fewer have intervals that are too narrow.
const FEWEST_AGAINST: usize = 10;
/// Of the intervals that are shown.
pub const LEVEL: f64 = 0.95;
/// Of the intervals that decide: two one-sided tests at 5 % each.
const DECIDING: f64 = 0.90;

/// What a claim comes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// As the paper says it.
    Holds,
    /// For some readings of what the paper leaves open, not for others.
    HoldsUnderStatedChoices,
    /// The effect is beyond the tolerance.
    DoesNotHold,
    /// It hangs on what the paper does not print.
    CannotBeDecided,
}

impl Verdict {
    /// For people.
    pub fn words(self) -> &'static str {
        match self {
            Verdict::Holds => "holds",
            Verdict::HoldsUnderStatedChoices => "holds under stated choices",
            Verdict::DoesNotHold => "does not hold",
            Verdict::CannotBeDecided => "cannot be decided from what is printed",
        }
    }
}

/// A number held against limits.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// It should be at least this; none for no lower limit.
    pub low: Option<f64>,
    pub high: Option<f64>,
    /// Whether it is; skipped: the 90 % interval holds a limit, or there are too few realizations for one.
    pub outcome: Outcome,
}

impl Judged {
    /// Holds the 90 % interval of `packings` packings against the limits.
    fn new(interval: Option<Interval>, packings: usize, limits: [f64; 2]) -> Self {
        let [low, high] = limits;
        let outcome = match interval.filter(|_| packings >= FEWEST_AGAINST) {
            Some(interval)
                if interval.low >= low && interval.high <= high && packings >= FEWEST =>
            {
                Outcome::Pass
            }
            Some(interval) if interval.high < low || interval.low > high => Outcome::Fail,
            _ => Outcome::Skipped,
        };
        Judged {
            low: low.is_finite().then_some(low),
            high: high.is_finite().then_some(high),
            outcome,
        }
    }
}

/// The probability of what was seen, or more, if a statement were true.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Probability {
    /// Which statement, by which test.
    pub test: String,
    /// The test's statistic: a distance or a likelihood ratio.
    pub statistic: f64,
    pub p: f64,
    /// Adjusted by Holm's method for all tests of all claims.
    pub adjusted: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    pub what: String,
    /// What the paper says it is; none where it says nothing.
    pub published: Option<f64>,
    /// What it is here, with its 95 % interval; none where there are too few packings.
    pub ours: Option<Interval>,
    /// SI unit, `1` for a ratio.
    pub unit: Cow<'static, str>,
    pub packings: usize,
    /// Those included whose value was set aside.
    pub looked_at: usize,
    pub ratio: Option<Interval>,
    /// None for a number that decides nothing.
    pub judged: Option<Judged>,
    /// Tests, after the effect.
    pub probabilities: Vec<Probability>,
}

impl Row {
    /// A number that decides nothing.
    fn shown(what: impl Into<String>, number: Number) -> Self {
        Row {
            what: what.into(),
            published: None,
            ours: number.at(LEVEL),
            unit: "1".into(),
            packings: number.packings,
            looked_at: number.looked_at,
            ratio: None,
            judged: None,
            probabilities: Vec::new(),
        }
    }

    /// The same with limits.
    fn judged(what: impl Into<String>, limits: [f64; 2], number: Number) -> Self {
        let judged = Judged::new(number.at(DECIDING), number.packings, limits);
        Row {
            judged: Some(judged),
            ..Row::shown(what, number)
        }
    }

    fn in_unit(mut self, unit: &'static str) -> Self {
        self.unit = unit.into();
        self
    }

    /// With what the paper prints.
    pub fn against(mut self, published: f64) -> Self {
        self.published = Some(published);
        if published > 0.0 {
            self.ratio = self.ours.map(|ours| ours.over(published));
        }
        self
    }

    /// With the probability of a statement.
    pub fn with(mut self, test: impl Into<String>, statistic: f64, p: f64) -> Self {
        self.probabilities.push(Probability {
            test: test.into(),
            statistic,
            p,
            adjusted: p,
        });
        self
    }

    /// With both distances from a law.
    pub fn with_fit(self, test: &str, fit: &Fit) -> Self {
        let (distances, same) = (&fit.distances, "the same (A², drawn samples)");
        self.with(test, distances.kolmogorov, fit.kolmogorov_p)
            .with(same, distances.anderson_darling, fit.anderson_darling_p)
    }

    pub fn estimate(&self) -> f64 {
        self.ours.map_or(f64::NAN, |ours| ours.estimate)
    }
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// Short and lasting: `mean.O`.
    pub id: Cow<'static, str>,
    pub place: Cow<'static, str>,
    pub statement: String,
    pub rows: Vec<Row>,
    /// Limits, where they come from, and how the rows make the verdict.
    pub decided_by: String,
    /// None, undecided, where the campaign is too small to say.
    pub verdict: Option<Verdict>,
    pub reading: String,
    /// Id of the figure that shows it.
    pub figure: Cow<'static, str>,
}

impl Claim {
    fn of(id: impl Into<Cow<'static, str>>, place: &'static str, figure: &'static str) -> Self {
        Claim {
            id: id.into(),
            place: place.into(),
            figure: figure.into(),
            ..Claim::default()
        }
    }

    fn says(mut self, statement: impl Into<String>) -> Self {
        self.statement = statement.into();
        self
    }

    fn found(mut self, reading: impl Into<String>) -> Self {
        self.reading = reading.into();
        self
    }

    fn decided_by(mut self, limits: impl Into<String>) -> Self {
        self.decided_by = limits.into();
        self
    }

    fn with(self, verdict: Option<Verdict>, rows: Vec<Row>) -> Self {
        Claim {
            verdict,
            rows,
            ..self
        }
    }

    fn by(self, rule: Rule, rows: Vec<Row>) -> Self {
        self.with(verdict(&rows, rule), rows)
    }

    /// The number for which there is no interval though the packings are enough for one: it is no evidence, and more packings will
    /// not make it. None where something else decides.
    fn not_computable(&self) -> Option<&Row> {
        let missing = |row: &&Row| {
            row.judged.is_some() && row.ours.is_none() && row.looked_at >= FEWEST_AGAINST
        };
        self.rows
            .iter()
            .find(missing)
            .filter(|_| self.verdict.is_none())
    }

    /// The first number beyond its limits where the claim does not hold or cannot be decided, the first undecided one where it is undecided, else
    /// the first within its limits. None where other claims decide.
    fn hangs_on(&self) -> Option<&Row> {
        let wanted = match self.verdict {
            None => Outcome::Skipped,
            Some(Verdict::DoesNotHold | Verdict::CannotBeDecided) => Outcome::Fail,
            Some(Verdict::Holds | Verdict::HoldsUnderStatedChoices) => Outcome::Pass,
        };
        let is_it = |row: &&Row| row.judged.is_some_and(|judged| judged.outcome == wanted);
        self.rows.iter().find(is_it)
    }
}

/// How the judged rows make a verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// Every row must be within its limits.
    All,
    /// The rows are readings of what the paper leaves open: one is enough, if it is named.
    AnyReading,
}

/// The verdict of judged rows; none where it hangs on an undecided one.
pub fn verdict(rows: &[Row], rule: Rule) -> Option<Verdict> {
    let outcomes = rows.iter().filter_map(|row| Some(row.judged?.outcome));
    let outcomes: Vec<Outcome> = outcomes.collect();
    let [yes, no, open] =
        [Outcome::Pass, Outcome::Fail, Outcome::Skipped].map(|outcome| outcomes.contains(&outcome));
    match rule {
        _ if outcomes.is_empty() => None,
        Rule::All if no => Some(Verdict::DoesNotHold),
        Rule::AnyReading if yes && no => Some(Verdict::HoldsUnderStatedChoices),
        _ if open => None,
        _ if yes => Some(Verdict::Holds),
        _ => Some(Verdict::DoesNotHold),
    }
}

/// Of a statement that holds where all of these do.
fn together(claims: &[&Claim]) -> Option<Verdict> {
    let verdicts: Vec<Option<Verdict>> = claims.iter().map(|claim| claim.verdict).collect();
    let any = |wanted: Verdict| verdicts.contains(&Some(wanted));
    if any(Verdict::DoesNotHold) {
        Some(Verdict::DoesNotHold)
    } else if verdicts.is_empty() || verdicts.contains(&None) {
        None
    } else if any(Verdict::HoldsUnderStatedChoices) {
        Some(Verdict::HoldsUnderStatedChoices)
    } else {
        Some(Verdict::Holds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(estimate: f64, reach: f64, packings: usize) -> Row {
        let number = Number::new(packings, |level| {
            Some(Interval {
                estimate,
                low: estimate - reach * level,
                high: estimate + reach * level,
            })
        });
        Row::judged("x", [0.9, 1.1], number)
    }

    #[test]
    fn intervals_decide_however_many_packings_there_are() {
        let answer = |estimate, reach, packings| {
            let judged = row(estimate, reach, packings).judged;
            judged.expect("judged").outcome
        };
        for packings in [50, 500, 50_000] {
            assert_eq!(answer(1.0, 0.05, packings), Outcome::Pass);
            assert_eq!(answer(1.3, 0.05, packings), Outcome::Fail);
            assert_eq!(answer(1.08, 0.05, packings), Outcome::Skipped);
            assert_eq!(answer(1.12, 0.05, packings), Outcome::Skipped);
        }
        assert_eq!(answer(1.0, 0.05, FEWEST - 1), Outcome::Skipped);
        assert_eq!(answer(1.3, 0.05, FEWEST - 1), Outcome::Fail);
        assert_eq!(answer(1.3, 0.05, FEWEST_AGAINST - 1), Outcome::Skipped);
    }

    #[test]
    fn rows_make_verdicts() {
        let (yes, no, open) = (row(1.0, 0.01, 50), row(2.0, 0.01, 50), row(1.1, 0.1, 50));
        let decided = |rows: &[&Row], rule| {
            let rows: Vec<Row> = rows.iter().map(|row| (*row).clone()).collect();
            verdict(&rows, rule)
        };
        use Verdict::{DoesNotHold, Holds, HoldsUnderStatedChoices};
        for (rows, rule, wanted) in [
            ([&yes, &yes], Rule::All, Some(Holds)),
            ([&yes, &no], Rule::All, Some(DoesNotHold)),
            ([&open, &no], Rule::All, Some(DoesNotHold)),
            ([&open, &yes], Rule::All, None),
            ([&yes, &no], Rule::AnyReading, Some(HoldsUnderStatedChoices)),
            ([&no, &no], Rule::AnyReading, Some(DoesNotHold)),
            ([&open, &no], Rule::AnyReading, None),
        ] {
            assert_eq!(decided(&rows, rule), wanted, "{rows:?} {rule:?}");
        }
        let hangs_on = |rows: [&Row; 3]| {
            let claim = Claim::of("x", "", "").by(Rule::All, rows.map(Row::clone).to_vec());
            claim.hangs_on().map(Row::estimate)
        };
        assert_eq!(hangs_on([&yes, &open, &no]), Some(no.estimate()));
        assert_eq!(hangs_on([&yes, &open, &yes]), Some(open.estimate()));
        assert_eq!(hangs_on([&yes, &yes, &yes]), Some(yes.estimate()));
        let reading = Claim::of("x", "", "").with(Some(Verdict::CannotBeDecided), vec![no.clone()]);
        assert_eq!(reading.hangs_on().map(Row::estimate), Some(no.estimate()));
        assert_eq!(decided(&[], Rule::All), None);
    }
}
