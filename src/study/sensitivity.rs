//! What the published figures depend on: the experiment over the choices that the paper does not print.

pub mod bearing;
pub mod document;
pub mod judge;
pub mod penetration;
pub mod plan;

use std::collections::BTreeMap;
use std::path::Path;

use crate::engine::EngineError;
use crate::paper::published::{Of, PUBLISHED, Published};
use crate::study::machine::Folder;
use crate::study::member::{Endings, Member, Members, of_one_bed, values};
use crate::study::realization::{Engines, Runner, Setting, sound};
use crate::study::sensitivity::bearing::{Bearing, bearing};
use crate::study::sensitivity::judge::{Verdict, judge, share_reached};
use crate::study::sensitivity::penetration::Watched;
use crate::study::sensitivity::plan::{COMBINED, Plan, Task};
use crate::study::{Judged, Outline, Study, StudyError};
use evidence::moments::{mean, mean_interval};
use evidence::{Interval, selection};
use serde::{Deserialize, Serialize};

const KEPT: [&str; 7] = [
    "settled.porosity.of_cells",
    "settled.coordination.mean",
    "settled.stress.O.local_zz",
    "settled.stress.A.local_zz",
    "settled.stress.B.local_zz",
    "loaded.punch.depth",
    "loaded.punch.force",
];

/// What a task gives.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Row {
    /// One bed in all its loads.
    Loads(Vec<Member>),
    /// A penetration or relaxation test.
    Penetration(Watched),
}

/// Whether a quantity stays in the rows.
pub fn keep(key: &str) -> bool {
    KEPT.contains(&key) || PUBLISHED.iter().any(|figure| figure.key == key)
}

impl Plan {
    fn digests(&self, settings: &[usize]) -> impl Iterator<Item = String> {
        let own = settings.iter();
        own.map(|of| self.settings[*of].specification.digest())
    }
}

impl Study for Plan {
    const KIND: &'static str = "sensitivity";
    type Row = Row;

    fn count(&self) -> u64 {
        self.tasks().len() as u64
    }

    fn check(&self) -> Result<(), String> {
        sound(&self.settings)
    }

    fn runner(&self, _: u64) -> Runner {
        Runner::Native
    }

    fn identity(&self, task: u64) -> String {
        match self.task(task) {
            Task::Loads(settings, cloud) => {
                let own: Vec<String> = self.digests(settings).collect();
                format!("loads {} {cloud}", own.join(" "))
            }
            Task::Penetration(of, cloud) => {
                format!("penetration {} {cloud}", self.penetrations[*of].digest())
            }
        }
    }

    fn run(&self, task: u64, _: &Engines, _: &Path) -> Result<Row, EngineError> {
        match self.task(task) {
            Task::Loads(settings, cloud) => {
                let settings: Vec<&Setting> =
                    settings.iter().map(|of| &self.settings[*of]).collect();
                of_one_bed(&settings, *cloud, keep).map(Row::Loads)
            }
            Task::Penetration(of, cloud) => {
                penetration::watch(&self.penetrations[*of], *cloud).map(Row::Penetration)
            }
        }
    }

    fn belongs(&self, task: u64, row: &Row) -> bool {
        match (self.task(task), row) {
            (Task::Loads(settings, cloud), Row::Loads(members)) => {
                let own = members.iter().map(|of| of.specification.clone());
                self.digests(settings).eq(own) && members.iter().all(|of| of.realization == *cloud)
            }
            (Task::Penetration(of, cloud), Row::Penetration(row)) => {
                row.realization == *cloud && row.penetration == self.penetrations[*of].digest()
            }
            _ => false,
        }
    }

    fn outline(&self, row: &Row) -> Outline {
        let (ending, cloud, of) = match row {
            Row::Loads(members) => {
                let cloud = members.first().map_or(0, |of| of.realization);
                ("loaded", cloud, members.len())
            }
            Row::Penetration(of) => ("watched", of.realization, of.windows.len()),
        };
        let cells = [
            ("realization", cloud.to_string()),
            ("loads_or_windows", of.to_string()),
        ];
        Outline::new(ending, cells, &BTreeMap::new())
    }

    fn judge(folder: &Folder<Self>) -> Result<Judged, StudyError> {
        let (mut members, mut watched) = (Vec::new(), Vec::new());
        folder.each(|_, row| match row {
            Row::Loads(of) => members.extend(of),
            Row::Penetration(of) => watched.push(of),
        })?;
        let record = Sensitivity::of(&folder.plan.study, members.into_iter().collect(), &watched);
        Judged::of(Self::KIND, &record, record.document())
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    pub id: String,
    pub title: String,
    pub value: f64,
    /// Counts as the same.
    pub tolerance: f64,
    pub unit: String,
    /// Where the tolerance comes from.
    pub reason: String,
    pub comes_out: Vec<String>,
    pub undecided: Vec<String>,
    pub does_not: Vec<String>,
    /// In which too few members gave it.
    pub skipped: Vec<String>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Point {
    pub setting: Setting,
    /// As in the rows.
    pub digest: String,
    pub made: usize,
    pub endings: Endings,
    /// Share of them in which the punch got its force.
    pub reached: f64,
    /// Mean depth of the punch when it got its force, m.
    pub depth: Option<Interval>,
    /// Every published figure, in their order.
    pub figures: Vec<judge::Judged>,
}

/// Which figures come out together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    pub title: String,
    pub figures: Vec<String>,
    /// Ids of the settings in which all come out.
    pub comes_out: Vec<String>,
    /// In which none is excluded, though not all are shown.
    pub possible: Vec<String>,
    /// In which the estimates of all are within the tolerances, whatever their intervals.
    pub near: Vec<String>,
}

/// The share of the map's decisions that may be wrong on average.
pub const WRONG: f64 = 0.05;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sensitivity {
    pub scene_digest: String,
    pub grains: u32,
    /// Clouds of a cheap setting.
    pub clouds: u64,
    /// Of the intervals that decide, corrected for how many do.
    pub level: f64,
    pub figures: Vec<Figure>,
    pub points: Vec<Point>,
    pub joint: Vec<Joint>,
    /// Why the load is reached at all.
    pub bearing: Bearing,
}

impl Sensitivity {
    pub fn of(plan: &Plan, members: Members, watched: &[Watched]) -> Self {
        let base = base_members(plan, &members);
        let rows: Vec<Vec<&Member>> = plan.settings.iter().map(|of| members.of(of)).collect();
        let decided = |level: f64| {
            let cells = rows.iter().flat_map(|rows| judged(rows, &base, level));
            let decided =
                |of: &judge::Judged| matches!(of.verdict, Verdict::ComesOut | Verdict::DoesNot);
            cells.filter(decided).count()
        };
        let level = selection::level(rows.len() * PUBLISHED.len(), WRONG, decided);
        let points = plan.settings.iter().zip(&rows);
        let points = points.map(|(setting, rows)| point(setting, rows, &base, level));
        let points: Vec<Point> = points.collect();
        let of_bed = |key: &str| mean(&values(&base, key));
        Sensitivity {
            scene_digest: plan.base.digest(),
            grains: plan.base.particles.count,
            clouds: plan.clouds,
            level,
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
    let own = |of: &&Setting| of.specification.scene.digest() == base && of.axis != COMBINED;
    let own = plan.settings.iter().filter(own);
    let widest = own.max_by_key(|setting| setting.realizations().count());
    widest.map_or(Vec::new(), |setting| members.of(setting))
}

fn point(setting: &Setting, members: &[&Member], base: &[&Member], level: f64) -> Point {
    let depths = values(members, "loaded.punch.depth");
    Point {
        digest: setting.specification.digest(),
        made: members.len(),
        endings: Endings::of(members.iter().copied()),
        reached: share_reached(members),
        depth: mean_interval(&depths, 0.95),
        figures: judged(members, base, level).collect(),
        setting: setting.clone(),
    }
}

/// Every published figure, in their order.
fn judged(
    members: &[&Member],
    base: &[&Member],
    level: f64,
) -> impl Iterator<Item = judge::Judged> {
    let all = PUBLISHED.iter();
    all.map(move |figure| judge(figure, members, base, level))
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
        let all = |check: &dyn Fn(&judge::Judged) -> bool| {
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
