//! The map as a record: which figure comes out in which setting, and what bears the load.

use serde::{Deserialize, Serialize};

use super::bearing::{Bearing, bearing};
use super::judge::{Judged, Verdict, judge, share_reached};
use super::penetration::Watched;
use super::plan::{COMBINED, Plan};
use crate::paper::published::{Of, PUBLISHED, Published};
use crate::study::member::{Endings, Member, Members};
use crate::study::specification::Setting;
use evidence::Interval;
use evidence::moments::{mean, mean_interval};

/// A published figure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// As in [`PUBLISHED`].
    pub id: String,
    /// For people.
    pub title: String,
    /// Published.
    pub value: f64,
    /// Counts as the same.
    pub tolerance: f64,
    /// SI unit.
    pub unit: String,
    /// Where the tolerance comes from.
    pub reason: String,
    /// Ids of the settings in which it comes out.
    pub comes_out: Vec<String>,
    /// In which that is undecided.
    pub undecided: Vec<String>,
    /// In which it does not.
    pub does_not: Vec<String>,
    /// In which too few members gave it.
    pub skipped: Vec<String>,
}

/// A setting and what came out of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// What was run.
    pub setting: Setting,
    /// As in the rows.
    pub digest: String,
    /// Members that were made.
    pub made: usize,
    /// How they ended.
    pub endings: Endings,
    /// Share of them in which the punch got its force.
    pub reached: f64,
    /// Mean depth of the punch when it got its force, m.
    pub depth: Option<Interval>,
    /// Every published figure, in their order.
    pub figures: Vec<Judged>,
}

/// Which figures come out together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// For people.
    pub title: String,
    /// Ids of the figures.
    pub figures: Vec<String>,
    /// Ids of the settings in which all come out.
    pub comes_out: Vec<String>,
    /// In which none is excluded, though not all are shown.
    pub possible: Vec<String>,
    /// In which the estimates of all are within the tolerances, whatever their intervals.
    pub near: Vec<String>,
}

/// The map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sensitivity {
    /// Digest of the base scene.
    pub scene_digest: String,
    /// Grains of the base scene.
    pub grains: u32,
    /// Clouds of a cheap setting.
    pub clouds: u64,
    /// The published figures.
    pub figures: Vec<Figure>,
    /// Every setting.
    pub points: Vec<Point>,
    /// Figures together.
    pub joint: Vec<Joint>,
    /// Why the load is reached at all.
    pub bearing: Bearing,
}

impl Sensitivity {
    /// Of these members and watched punches.
    pub fn of(plan: &Plan, members: Members, watched: &[Watched]) -> Self {
        let base = base_members(plan, &members);
        let settings = plan.settings.iter();
        let points: Vec<Point> = settings
            .map(|setting| point(setting, &members.of(setting), &base))
            .collect();
        let of_bed = |key: &str| {
            let values = base.iter().filter_map(|of| of.measured.get(key).copied());
            mean(&values.collect::<Vec<f64>>())
        };
        Sensitivity {
            scene_digest: plan.base.digest(),
            grains: plan.base.particles.count,
            clouds: plan.clouds,
            figures: figures(&points),
            joint: joint(&points),
            bearing: bearing(
                &plan.base,
                &plan.penetrations,
                watched,
                of_bed("settled.height.mean_surface"),
                of_bed("settled.porosity.of_cells"),
            ),
            points,
        }
    }
}

/// Members of the base scene, wherever most of them are planned.
fn base_members<'a>(plan: &Plan, members: &'a Members) -> Vec<&'a Member> {
    let base = plan.base.digest();
    let own = plan
        .settings
        .iter()
        .filter(|setting| setting.specification.scene.digest() == base && setting.axis != COMBINED);
    let widest = own.max_by_key(|setting| setting.realizations().count());
    widest.map_or(Vec::new(), |setting| members.of(setting))
}

fn point(setting: &Setting, members: &[&Member], base: &[&Member]) -> Point {
    let depths: Vec<f64> = members
        .iter()
        .filter_map(|of| of.measured.get("loaded.punch.depth").copied())
        .collect();
    Point {
        digest: setting.specification.digest(),
        made: members.len(),
        endings: Endings::of(members.iter().copied()),
        reached: share_reached(members),
        depth: mean_interval(&depths, 0.95),
        figures: PUBLISHED
            .iter()
            .map(|figure| judge(figure, members, base))
            .collect(),
        setting: setting.clone(),
    }
}

fn figures(points: &[Point]) -> Vec<Figure> {
    let one = |(index, figure): (usize, &Published)| {
        let of = |wanted: Verdict| ids(points, |point| point.figures[index].verdict == wanted);
        Figure {
            id: figure.id.to_owned(),
            title: figure.title.to_owned(),
            value: figure.value,
            tolerance: figure.tolerance,
            unit: figure.unit.to_owned(),
            reason: figure.reason.to_owned(),
            comes_out: of(Verdict::ComesOut),
            undecided: of(Verdict::Undecided),
            does_not: of(Verdict::DoesNot),
            skipped: of(Verdict::Skipped),
        }
    };
    PUBLISHED.iter().enumerate().map(one).collect()
}

fn ids(points: &[Point], wanted: impl Fn(&Point) -> bool) -> Vec<String> {
    let own = points.iter().filter(|point| wanted(point));
    own.map(|point| point.setting.id.clone()).collect()
}

fn joint(points: &[Point]) -> Vec<Joint> {
    let is_bed = |of: &Published| of.key.starts_with("settled.");
    let is_stress = |of: &Published| of.of == Of::Mean && of.key.starts_with("loaded.");
    let together = |title: &str, wanted: &dyn Fn(&Published) -> bool| {
        let all = |check: &dyn Fn(&Judged) -> bool| {
            ids(points, |point| {
                let mut both = PUBLISHED.iter().zip(&point.figures);
                both.all(|(figure, judged)| !wanted(figure) || check(judged))
            })
        };
        let own = PUBLISHED.iter().filter(|figure| wanted(figure));
        Joint {
            title: title.to_owned(),
            figures: own.map(|figure| figure.id.to_owned()).collect(),
            comes_out: all(&|of| of.verdict == Verdict::ComesOut),
            possible: all(&|of| matches!(of.verdict, Verdict::ComesOut | Verdict::Undecided)),
            near: all(&|of| of.near),
        }
    };
    vec![
        together("height and porosity", &is_bed),
        together("mean stresses at O, A and B", &is_stress),
        together("height, porosity and mean stresses", &|of| {
            is_bed(of) || is_stress(of)
        }),
        together("exponential shapes at O, A and B", &|of| of.of != Of::Mean),
        together("everything", &|_| true),
    ]
}
