//! What the members of each setting say.

use evidence::Interval;
use evidence::distribution::Family;
use evidence::moments::mean_interval;
use evidence::proportion::{self, wilson};
use evidence::t_test::{self, Finding, equivalence};
use grains::measure::stress::LAYERS;
use serde::{Deserialize, Serialize};

use super::Plan;
use super::published::{Judged, LEVEL, Verdict, judge};
use crate::paper::continuum::{Field, Model, weight};
use crate::paper::published::{POINTS, PUBLISHED};
use crate::study::figures::setup_of;
use crate::study::member::{Endings, MIRRORED, Member, Members};
use crate::study::realization::{Setting, law_key};

/// A change of the load's part by less than this share of the theory's is none, nor is one of the share of punches with the force.
const NOTHING: f64 = 0.1;
/// A bed bears the force if it does so in this share of the packings.
const BEARS: f64 = 0.9;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Candidates {
    pub scene_digest: String,
    pub grains: u32,
    pub clouds: u64,
    /// The first is the printed one.
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
    /// The best law and those that are not told from it.
    pub fn level(&self) -> impl Iterator<Item = Family> {
        let own = self.laws.iter().filter(|of| of.1.low <= 0.0);
        own.map(|of| of.0)
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
        let base = all().next().map_or(Vec::new(), |of| members.of(of));
        let comparisons = all().count() * LAYERS.len() * (Family::OF_STRESSES.len() - 1);
        let of_laws = 1.0 - (1.0 - LEVEL) / comparisons.max(1) as f64;
        let levels = [level, of_laws];
        let found = |setting: &Setting| Found::of(setting, &members.of(setting), &base, levels);
        let first = all().next().map(|of| &of.specification.scene);
        Candidates {
            scene_digest: first.map_or(String::new(), |of| of.digest()),
            grains: first.map_or(0, |of| of.particles.count),
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
        let of = |key: &str| {
            let values = rows.iter().filter_map(|row| row.measured.get(key));
            mean_interval(&values.copied().collect::<Vec<f64>>(), LEVEL)
        };
        Found {
            setting: setting.clone(),
            endings: Endings::of(rows.iter().copied()),
            figures: judged.collect(),
            parts: parts(setting, rows),
            punch_depth: of("loaded.punch.depth"),
            by_floor: of("settled.support.by_floor"),
            layers: LAYERS
                .into_iter()
                .filter_map(|depth| layer(rows, depth, levels[1]))
                .collect(),
        }
    }

    /// Whether the punch may get its force in nine of ten packings.
    pub fn bears(&self) -> bool {
        let found = wilson(self.endings.reached, self.endings.all(), LEVEL);
        found.is_none_or(|of| of.high >= BEARS)
    }

    /// Whether all published figures come out, of beds that bear the force; none while some are undecided.
    pub fn gives_all(&self) -> Option<bool> {
        let any = |wanted| self.figures.iter().any(|of| of.verdict == wanted);
        match any(Verdict::DoesNot) || !self.bears() {
            true => Some(false),
            false if any(Verdict::Undecided) || any(Verdict::Skipped) => None,
            false => Some(true),
        }
    }
}

/// Local mean of σ_zz at a point, on both sides of the punch where both are measured: before the load, and what it adds.
fn two_parts(row: &Member, point: &str) -> Option<[f64; 2]> {
    let of = |moment: &str| {
        let at = |name: &str| {
            let key = format!("{moment}.stress.{name}.local_zz");
            row.measured.get(&key).copied()
        };
        let own = at(point)?;
        let other = at(&format!("{MIRRORED}{point}"));
        Some(other.map_or(own, |other| 0.5 * (own + other)))
    };
    let before = of("settled")?;
    Some([before, of("loaded")? - before])
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
    let of = |law: usize| densities.iter().map(|of| of[law]).collect::<Vec<f64>>();
    let total = |law: &usize| of(*law).iter().sum::<f64>();
    let best = (0..Family::OF_STRESSES.len()).max_by(|a, b| total(a).total_cmp(&total(b)))?;
    let behind = |law: usize| {
        let ahead = of(best)
            .into_iter()
            .zip(of(law))
            .map(|(best, own)| best - own);
        let ahead = mean_interval(&ahead.collect::<Vec<f64>>(), level)?;
        Some((Family::OF_STRESSES[law], ahead))
    };
    let mut laws: Vec<(Family, Interval)> = (0..Family::OF_STRESSES.len())
        .map(behind)
        .collect::<Option<_>>()?;
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
    let of = own.map(|point| {
        let both = rows.iter().filter_map(|row| two_parts(row, &point.name));
        let both: Vec<[f64; 2]> = both.collect();
        let of = |part: usize| {
            let values: Vec<f64> = both.iter().map(|of| of[part]).collect();
            mean_interval(&values, LEVEL)
        };
        Parts {
            point: point.name.clone(),
            offset: point.offset,
            depth: point.depth,
            before: of(0),
            added: of(1),
            theory: [
                weight(setup.density, setup.gravity, setup.porosity, point.depth),
                field.stress(point.offset, point.depth).zz,
            ],
        }
    });
    of.collect()
}

fn halvings(plan: &Plan, members: &Members) -> Vec<Halving> {
    let setting = |id: &String| plan.beds.settings().find(|of| of.id == *id);
    let halving = |name: &String, pair: &[String]| {
        let [from, to] = [setting(&pair[0])?, setting(&pair[1])?];
        let control = parts(from, &[]).into_iter().take(POINTS.len());
        let found = control.map(|point| {
            let more = members.of(to).into_iter().filter_map(|slow| {
                let fast = members.get(&from.specification, slow.realization)?;
                let of = |row| two_parts(row, &point.point).map(|of| of[1]);
                Some((of(slow)? - of(fast)?) / point.theory[1])
            });
            let more: Vec<f64> = more.collect();
            let level = 1.0 - 2.0 * t_test::LEVEL;
            let finding = equivalence(&more, NOTHING).map(|of| of.0);
            (mean_interval(&more, level), finding)
        });
        let (more, mut findings): (Vec<_>, Vec<Option<Finding>>) = found.unzip();
        let endings = [from, to].map(|of| Endings::of(members.of(of)));
        let [fast, slow] = endings.each_ref().map(|of| (of.reached, of.all()));
        let reached = proportion::difference(fast, slow, 1.0 - 2.0 * t_test::LEVEL);
        findings.push(reached.map(|of| t_test::finding(&of, NOTHING)));
        let findings = findings.into_iter();
        let findings: Vec<Finding> = findings
            .map(|of| of.unwrap_or(Finding::Undecided))
            .collect();
        Some(Halving {
            name: name.clone(),
            from: from.id.clone(),
            to: to.id.clone(),
            more,
            reached: [fast.0, slow.0],
            all: slow.1,
            finding: t_test::together(&findings),
        })
    };
    let ladders = plan.ladders.iter();
    let all = ladders.flat_map(|of| of.settings.windows(2).map(move |pair| (&of.name, pair)));
    all.filter_map(|(name, pair)| halving(name, pair)).collect()
}
