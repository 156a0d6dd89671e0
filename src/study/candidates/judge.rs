//! What the members of each setting say, and whether a published figure comes out of it.

use serde::{Deserialize, Serialize};

use super::Plan;
use crate::paper::continuum::{Field, Model};
use crate::paper::published::{Of, POINTS, PUBLISHED, Published};
use crate::study::figures::setup_of;
use crate::study::member::{Endings, MIRRORED, Member, Members, values};
use crate::study::realization::{Setting, law_key};
use evidence::distribution::Family;
use evidence::moments::mean_interval;
use evidence::proportion::{self, wilson};
use evidence::t_test::{self, Finding, equivalence, paired};
use evidence::zeros::Parted;
use evidence::{Interval, bootstrap};
use grains::measure::stress::LAYERS;

/// A change of the load's part by less than this share of the theory's is none, nor is one of the share of punches with the force.
const NOTHING: f64 = 0.1;
/// A bed bears the force if it does so in this share of the packings; stresses of fewer are those of its firmer beds.
const BEARS: f64 = 0.9;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Candidates {
    pub scene_digest: String,
    pub grains: u32,
    pub clouds: u64,
    /// The first is our default.
    pub settings: Vec<Found>,
    pub halvings: Vec<Halving>,
}

/// A setting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Found {
    pub setting: Setting,
    pub endings: Endings,
    /// The published figures.
    pub figures: Vec<Judged>,
    /// Of the control points first, then of those along the lines.
    pub parts: Vec<Parts>,
    /// How deep the punch went, m.
    pub punch_depth: Option<Interval>,
    /// Share of the weight that the floor bears before the load.
    pub by_floor: Option<Interval>,
    /// Of single-grain stresses before the load, layer by layer.
    pub layers: Vec<Layer>,
}

/// Laws of the stresses in a layer of the settled bed, over the layer's mean, of grains that bear load.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Layer {
    /// Depth of its middle, m.
    pub depth: f64,
    pub packings: usize,
    /// The best first, with the mean logarithm of the density by which the best is ahead, of a grain; intervals over packings, of a level that counts
    /// all comparisons of the study.
    pub laws: Vec<(Family, Interval)>,
}

impl Layer {
    pub fn exponential(&self) -> Option<Interval> {
        let own = self.laws.iter().find(|law| law.0 == Family::Exponential);
        own.map(|law| law.1)
    }

    /// The best law and those that are not told from it.
    pub fn level(&self) -> impl Iterator<Item = Family> {
        let own = self.laws.iter().filter(|law| law.1.low <= 0.0);
        own.map(|law| law.0)
    }
}

/// σ_zz at a point, of local means on both sides of the punch, Pa.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Parts {
    pub point: String,
    /// From the punch's axis, m.
    pub offset: f64,
    pub depth: f64,
    /// What the bed bears before the load; of packings that got the force.
    pub before: Option<Interval>,
    pub added: Option<Interval>,
    /// The theory's two parts.
    pub theory: [f64; 2],
}

/// One setting against another with half of the punch's speed, on the same clouds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Halving {
    /// Of the ladder.
    pub name: String,
    /// Ids.
    pub from: String,
    pub to: String,
    /// At each control point: what the slower load adds more, over the theory's, 90 %.
    pub more: Vec<Option<Interval>>,
    /// Punches that get the force with each, and how many there are.
    pub reached: [usize; 2],
    pub all: usize,
    /// Whether all of that changes by less than a tenth.
    pub finding: Finding,
}

impl Candidates {
    pub fn of(plan: &Plan, members: &Members) -> Self {
        let all = || plan.beds.settings();
        let verdicts = all().count() * PUBLISHED.len();
        let level = 1.0 - (1.0 - LEVEL) / verdicts.max(1) as f64;
        let base = all()
            .next()
            .map_or(Vec::new(), |setting| members.of(setting));
        let comparisons = all().count() * LAYERS.len() * (Family::OF_STRESSES.len() - 1);
        let of_laws = 1.0 - (1.0 - LEVEL) / comparisons.max(1) as f64;
        let levels = [level, of_laws];
        let found = |setting: &Setting| Found::of(setting, &members.of(setting), &base, levels);
        let first = all().next().map(|setting| &setting.specification.scene);
        Candidates {
            scene_digest: first.map_or(String::new(), |scene| scene.digest()),
            grains: first.map_or(0, |scene| scene.particles.count),
            clouds: plan.beds.clouds(),
            settings: all().map(found).collect(),
            halvings: halvings(plan, members),
        }
    }
}

impl Found {
    fn of(setting: &Setting, rows: &[&Member], base: &[&Member], levels: [f64; 2]) -> Self {
        let judged = PUBLISHED.iter();
        let judged = judged.map(|figure| judge(figure, rows, base, levels[0]));
        let mean = |key: &str| mean_interval(&values(rows, key), LEVEL);
        let layers = LAYERS.into_iter();
        let layers = layers.filter_map(|depth| layer(rows, depth, levels[1]));
        Found {
            setting: setting.clone(),
            endings: Endings::of(rows.iter().copied()),
            figures: judged.collect(),
            parts: parts(setting, rows),
            punch_depth: mean("loaded.punch.depth"),
            by_floor: mean("settled.support.by_floor"),
            layers: layers.collect(),
        }
    }

    /// Whether the punch may get its force in so many packings.
    pub fn bears(&self) -> bool {
        let found = wilson(self.endings.reached, self.endings.all(), LEVEL);
        found.is_none_or(|share| share.high >= BEARS)
    }

    /// Whether all published figures come out, of beds that bear the force; none while some are undecided.
    pub fn gives_all(&self) -> Option<bool> {
        let any = |wanted| self.figures.iter().any(|judged| judged.verdict == wanted);
        match any(Verdict::DoesNot) || !self.bears() {
            true => Some(false),
            false if any(Verdict::Undecided) || any(Verdict::Skipped) => None,
            false => Some(true),
        }
    }
}

/// Local mean of σ_zz at a point: before the load, and what it adds.
fn two_parts(row: &Member, point: &str) -> Option<[f64; 2]> {
    let stress = |moment: &str| row.of_both_sides(&format!("{moment}.stress.{point}.local_zz"));
    let before = stress("settled")?;
    Some([before, stress("loaded")? - before])
}

/// None where a law could not be fitted to most packings.
fn layer(rows: &[&Member], depth: f64, level: f64) -> Option<Layer> {
    let own = |row: &&Member| -> Option<Vec<f64>> {
        let density = |family: &Family| row.measured.get(&law_key(depth, *family)).copied();
        Family::OF_STRESSES.iter().map(density).collect()
    };
    let densities: Vec<Vec<f64>> = rows.iter().filter_map(own).collect();
    if densities.is_empty() || 2 * densities.len() < rows.len() {
        return None;
    }
    let all = 0..Family::OF_STRESSES.len();
    let total = |law: &usize| densities.iter().map(|packing| packing[*law]).sum::<f64>();
    let best = all.clone().max_by(|a, b| total(a).total_cmp(&total(b)))?;
    let behind = |law: usize| {
        let ahead = densities.iter().map(|packing| packing[best] - packing[law]);
        let ahead = mean_interval(&ahead.collect::<Vec<f64>>(), level)?;
        Some((Family::OF_STRESSES[law], ahead))
    };
    let mut laws: Vec<(Family, Interval)> = all.map(behind).collect::<Option<_>>()?;
    laws.sort_by(|a, b| a.1.estimate.total_cmp(&b.1.estimate));
    Some(Layer {
        depth,
        packings: densities.len(),
        laws,
    })
}

fn parts(setting: &Setting, rows: &[&Member]) -> Vec<Parts> {
    let setup = setup_of(&setting.specification.scene);
    let field = Field::new(Model::HalfSpace, setup.load);
    let own = setup.points.iter();
    let own = own.filter(|point| !point.name.starts_with(MIRRORED));
    let all = own.map(|point| {
        let both = rows.iter().filter_map(|row| two_parts(row, &point.name));
        let both: Vec<[f64; 2]> = both.collect();
        let mean = |part: usize| {
            let values: Vec<f64> = both.iter().map(|pair| pair[part]).collect();
            mean_interval(&values, LEVEL)
        };
        Parts {
            point: point.name.clone(),
            offset: point.offset,
            depth: point.depth,
            before: mean(0),
            added: mean(1),
            theory: [
                setup.weight(point.depth),
                field.stress(point.offset, point.depth).zz,
            ],
        }
    });
    all.collect()
}

fn halvings(plan: &Plan, members: &Members) -> Vec<Halving> {
    let setting = |id: &String| plan.beds.settings().find(|setting| setting.id == *id);
    let halving = |name: &String, pair: &[String]| {
        let [from, to] = [setting(&pair[0])?, setting(&pair[1])?];
        let control = parts(from, &[]).into_iter().take(POINTS.len());
        let found = control.map(|point| {
            let more = members.of(to).into_iter().filter_map(|slow| {
                let fast = members.get(&from.specification, slow.realization)?;
                let added = |row| two_parts(row, &point.point).map(|stress| stress[1]);
                Some((added(slow)? - added(fast)?) / point.theory[1])
            });
            let more: Vec<f64> = more.collect();
            let level = 1.0 - 2.0 * t_test::LEVEL;
            let finding = equivalence(&more, NOTHING).map(|test| test.0);
            (mean_interval(&more, level), finding)
        });
        let (more, mut findings): (Vec<_>, Vec<Option<Finding>>) = found.unzip();
        let endings = [from, to].map(|setting| Endings::of(members.of(setting)));
        let [fast, slow] = endings
            .each_ref()
            .map(|counts| (counts.reached, counts.all()));
        let reached = proportion::difference(fast, slow, 1.0 - 2.0 * t_test::LEVEL);
        findings.push(reached.map(|difference| t_test::finding(&difference, NOTHING)));
        let findings = findings.into_iter();
        let findings = findings.map(|finding| finding.unwrap_or(Finding::Undecided));
        Some(Halving {
            name: name.clone(),
            from: from.id.clone(),
            to: to.id.clone(),
            more,
            reached: [fast.0, slow.0],
            all: slow.1,
            finding: t_test::together(&findings.collect::<Vec<_>>()),
        })
    };
    let ladders = plan.ladders.iter();
    let all = ladders.flat_map(|ladder| {
        ladder
            .settings
            .windows(2)
            .map(move |pair| (&ladder.name, pair))
    });
    all.filter_map(|(name, pair)| halving(name, pair)).collect()
}

/// Confidence of the intervals that are shown.
pub const LEVEL: f64 = 0.95;
/// Fewer packings give no interval of a mean, or of a variation or share, that is worth a verdict.
const FEWEST: [usize; 2] = [3, 8];

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The interval of the level that is corrected for all verdicts lies within value ± tolerance.
    /// Of few clouds such intervals hold a mean of skewed stresses less often than they say.
    ComesOut,
    /// It lies outside.
    DoesNot,
    /// It holds one of their ends: more packings would tell.
    Undecided,
    /// Too few packings gave the quantity.
    Skipped,
}

/// A published figure in one setting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Judged {
    pub id: String,
    /// Packings that gave the quantity, of a shape those whose grain bears load.
    pub packings: usize,
    /// Of a shape, the share of packings whose grain bears nothing.
    pub zeros: Option<Interval>,
    /// Ours with its 95 % interval over packings.
    pub value: Option<Interval>,
    /// Against value ± tolerance.
    pub verdict: Verdict,
    /// Whether the estimate lies within value ± tolerance, whatever the interval.
    pub near: bool,
    /// Whether it holds only for the beds that bore the force, as fewer than 90 % did.
    pub conditional: bool,
    /// Of a mean: what it is more than in the base, on the same clouds.
    pub change: Option<Interval>,
}

/// Judges a setting's members by intervals of this level; `base` are those of the base scene.
fn judge(figure: &Published, rows: &[&Member], base: &[&Member], level: f64) -> Judged {
    let values = rows.iter().filter_map(|row| row.published(figure));
    let values: Vec<f64> = values.collect();
    // Shapes are those of grains that bear load.
    let parted = (figure.statistic != Of::Mean).then(|| Parted::loads(&values));
    let zeros = parted
        .as_ref()
        .and_then(|parted| parted.share_of_zeros(LEVEL));
    let values = parted.map_or(values, |parted| parted.others);
    let fewest = FEWEST[usize::from(figure.statistic != Of::Mean)];
    let enough = Some(&values).filter(|values| values.len() >= fewest);
    let at = |level: f64| interval(figure.statistic, enough?, level);
    let found = at(LEVEL);
    let [low, high] = figure.limits();
    let near = found.is_some_and(|interval| low <= interval.estimate && interval.estimate <= high);
    let reached = Endings::of(rows.iter().copied()).reached as f64;
    Judged {
        id: figure.id.to_owned(),
        packings: values.len(),
        zeros,
        verdict: verdict(at(level), low, high),
        near,
        conditional: figure.key.starts_with("loaded.")
            && reached / (rows.len().max(1) as f64) < BEARS,
        change: (figure.statistic == Of::Mean)
            .then(|| change(figure, rows, base))
            .flatten(),
        value: found,
    }
}

fn verdict(found: Option<Interval>, low: f64, high: f64) -> Verdict {
    match found {
        None => Verdict::Skipped,
        Some(found) if low <= found.low && found.high <= high => Verdict::ComesOut,
        Some(found) if found.high < low || high < found.low => Verdict::DoesNot,
        Some(_) => Verdict::Undecided,
    }
}

/// t for a mean, the bootstrap (BCa) for a variation, the influence function for a share.
fn interval(statistic: Of, values: &[f64], level: f64) -> Option<Interval> {
    match statistic {
        Of::Mean => mean_interval(values, level),
        Of::Variation => bootstrap::coefficient_of_variation(values, level),
        Of::ShareAbove(multiple) => {
            proportion::above_multiple_of_mean(values, f64::from(multiple), level)
        }
    }
}

fn change(figure: &Published, rows: &[&Member], base: &[&Member]) -> Option<Interval> {
    let pairs: Vec<(f64, f64)> = rows
        .iter()
        .filter_map(|row| {
            let same = base
                .iter()
                .find(|member| member.realization == row.realization)?;
            // The base itself has no change.
            (same.specification != row.specification).then_some(())?;
            Some((same.published(figure)?, row.published(figure)?))
        })
        .collect();
    Some(paired(&pairs)?.difference)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::published::published;
    use crate::study::realization::Ending;

    /// A packing each that has this of the quantity; none got no force.
    fn rows(key: &str, values: impl Iterator<Item = Option<f64>>) -> Vec<Member> {
        let row = |(realization, value): (usize, Option<f64>)| Member {
            specification: "abc".to_owned(),
            realization: realization as u64,
            ending: match value {
                Some(_) => Ending::Reached,
                None => Ending::TargetLoadNotReached,
            },
            pour_steps: 1,
            load_steps: 1,
            cost: None,
            loaded_state: None,
            measured: value
                .map(|value| (key.to_owned(), value))
                .into_iter()
                .collect(),
        };
        values.enumerate().map(row).collect()
    }

    /// Twelve beds around this height.
    fn heights(middle: f64, spread: f64) -> Vec<Member> {
        let heights = (0..12).map(|index| Some(middle + spread * (f64::from(index) - 5.5)));
        rows("settled.height.mean_surface", heights)
    }

    fn judged(id: &str, rows: &[Member], base: &[Member]) -> Judged {
        let [rows, base] = [rows, base].map(|members| members.iter().collect::<Vec<&Member>>());
        let figure = published(id).expect("a published figure");
        judge(figure, &rows, &base, LEVEL)
    }

    #[test]
    fn a_verdict_goes_each_way() {
        let verdict = |middle, spread| judged("height", &heights(middle, spread), &[]).verdict;
        assert_eq!(verdict(0.46, 0.001), Verdict::ComesOut);
        assert_eq!(verdict(0.48, 0.001), Verdict::DoesNot);
        assert_eq!(verdict(0.469, 0.003), Verdict::Undecided);
        // Far off or not, where the spread is wide nothing is decided.
        assert_eq!(verdict(0.48, 0.02), Verdict::Undecided);
        let few = heights(0.46, 0.001);
        assert_eq!(judged("height", &few[..2], &[]).verdict, Verdict::Skipped);
        assert_eq!(judged("stress.O", &few, &[]).verdict, Verdict::Skipped);
    }

    #[test]
    fn stresses_of_the_firmer_beds_alone_are_flagged() {
        let stresses = |sunk: u32| {
            let value = |index| 13.6e3 + 10.0 * f64::from(index);
            let values = (0..20).map(|index| (index >= sunk).then(|| value(index)));
            rows("loaded.stress.O.local_zz", values)
        };
        assert!(!judged("stress.O", &stresses(2), &[]).conditional);
        let found = judged("stress.O", &stresses(3), &[]);
        assert!(found.conditional);
        assert_eq!(found.packings, 17);
        assert_eq!(found.verdict, Verdict::ComesOut);
    }

    #[test]
    fn shapes_of_exponential_and_of_equal_stresses() {
        let verdict = |id: &str, stress: fn(f64) -> f64, count: u32| {
            let shares = (0..count).map(|index| (f64::from(index) + 0.5) / f64::from(count));
            let stresses = shares.map(|share| Some(stress(share)));
            judged(id, &rows("loaded.stress.O.grain_zz", stresses), &[]).verdict
        };
        let exponential = |share: f64| -(1.0 - share).ln();
        let narrow = |share: f64| 1.0 + share;
        assert_eq!(verdict("variation.O", exponential, 2000), Verdict::ComesOut);
        assert_eq!(verdict("variation.O", narrow, 40), Verdict::DoesNot);
        assert_eq!(verdict("beyond.O", narrow, 40), Verdict::DoesNot);
        assert_eq!(verdict("beyond.O", narrow, 7), Verdict::Skipped);
    }

    #[test]
    fn a_change_is_that_of_the_same_clouds() {
        let base = heights(0.46, 0.01);
        let mut moved = heights(0.47, 0.01);
        for row in &mut moved {
            row.specification = "other".to_owned();
        }
        let found = judged("height", &moved, &base).change;
        let found = found.expect("twelve pairs");
        assert!((found.estimate - 0.01).abs() < 1.0e-12);
        assert!(found.high - found.low < 1.0e-9);
        assert!(judged("height", &base, &base).change.is_none());
    }
}
