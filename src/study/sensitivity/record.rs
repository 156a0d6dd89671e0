//! The map as a record: the source of its lines, its page and its pictures.

use std::path::Path;

use serde::Serialize;

use super::bearing::{Bearing, bearing};
use super::choices::Axis;
use super::job::{self, Members};
use super::judge::{Judged, Verdict, judge, share_reached};
use super::plan::{Plan, Setting};
use super::row::Row;
use crate::error::Error;
use crate::progress::Display;
use crate::study::claims::published::{Of, PUBLISHED};
use crate::study::tradeoff::judge::Endings;
use evidence::Interval;
use evidence::moments::{mean, mean_interval};

/// The version of `sensitivity.json`.
pub const SENSITIVITY_VERSION: u32 = 1;

/// A published figure.
#[derive(Debug, Clone, Serialize)]
pub struct Figure {
    /// As in [`PUBLISHED`].
    pub id: &'static str,
    /// For people.
    pub title: &'static str,
    /// Published.
    pub value: f64,
    /// Counts as the same.
    pub tolerance: f64,
    /// SI unit.
    pub unit: &'static str,
    /// Where the tolerance comes from.
    pub reason: &'static str,
    /// Numbers of the settings in which it comes out.
    pub comes_out: Vec<usize>,
    /// In which that is undecided.
    pub undecided: Vec<usize>,
    /// In which it does not.
    pub does_not: Vec<usize>,
    /// In which too few members gave it.
    pub not_made: Vec<usize>,
}

/// A setting and what came out of it.
#[derive(Debug, Clone, Serialize)]
pub struct Point {
    /// Its number in lists of this record.
    pub number: usize,
    /// What was run.
    pub setting: Setting,
    /// As in `members.jsonl`.
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

impl Point {
    /// How many figures have this verdict.
    pub fn count(&self, wanted: Verdict) -> usize {
        let of = self.figures.iter().filter(|of| of.verdict == wanted);
        of.count()
    }
}

/// Which figures come out together.
#[derive(Debug, Clone, Serialize)]
pub struct Joint {
    /// For people.
    pub title: &'static str,
    /// Ids of the figures.
    pub figures: Vec<&'static str>,
    /// Numbers of the settings in which all come out.
    pub comes_out: Vec<usize>,
    /// In which none is excluded, though not all are shown.
    pub possible: Vec<usize>,
    /// In which the estimates of all are within the tolerances, whatever their intervals.
    pub near: Vec<usize>,
}

/// The map.
#[derive(Debug, Clone, Serialize)]
pub struct Sensitivity {
    /// [`SENSITIVITY_VERSION`].
    pub version: u32,
    /// Version of crossgrain.
    pub crossgrain: String,
    /// The command as it was given.
    pub command: String,
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
    /// Whether every planned member was made.
    pub complete: bool,
    /// Time on the clock of this start of the job, s.
    pub seconds: f64,
}

/// Runs the plan and judges it.
pub fn sensitivity(
    plan: &Plan,
    out: &Path,
    command: String,
    display: &Display,
) -> Result<Sensitivity, Error> {
    let began = std::time::Instant::now();
    let members = job::run(plan, out, display)?;
    let mut record = of_members(plan, &members, command);
    record.seconds = began.elapsed().as_secs_f64();
    Ok(record)
}

/// The record of these members.
pub fn of_members(plan: &Plan, members: &Members, command: String) -> Sensitivity {
    let base = base_rows(plan, members);
    let points: Vec<Point> = plan
        .settings
        .iter()
        .enumerate()
        .map(|(index, setting)| point(index + 1, setting, &members.of(setting), &base))
        .collect();
    let of_bed = |key: &str| {
        let values = base.iter().filter_map(|row| row.measured.get(key).copied());
        mean(&values.collect::<Vec<f64>>())
    };
    let watched: u64 = plan.pushes.iter().map(|push| push.clouds).sum();
    let all_made = points
        .iter()
        .all(|point| point.made as u64 == point.setting.clouds);
    Sensitivity {
        version: SENSITIVITY_VERSION,
        crossgrain: env!("CARGO_PKG_VERSION").to_owned(),
        command,
        scene_digest: plan.base.digest(),
        grains: plan.base.particles.count,
        clouds: plan.clouds,
        figures: figures(&points),
        joint: joint(&points),
        bearing: bearing(
            &plan.base,
            &plan.pushes,
            &members.watched,
            of_bed("settled.height.mean_surface"),
            of_bed("settled.porosity.of_cells"),
        ),
        complete: all_made && members.watched.len() as u64 == watched,
        points,
        seconds: 0.0,
    }
}

/// Members of the base scene, wherever most of them are planned.
fn base_rows<'a>(plan: &Plan, members: &'a Members) -> Vec<&'a Row> {
    let is_base = |setting: &&Setting| {
        setting.scene.digest() == plan.base.digest() && setting.axis != Axis::Combined
    };
    let settings = plan.settings.iter().filter(is_base);
    let widest = settings.max_by_key(|setting| setting.clouds);
    widest.map_or(Vec::new(), |setting| members.of(setting))
}

fn point(number: usize, setting: &Setting, rows: &[&Row], base: &[&Row]) -> Point {
    let depths: Vec<f64> = rows
        .iter()
        .filter_map(|row| row.measured.get("last.punch.depth").copied())
        .collect();
    Point {
        number,
        digest: setting.digest(),
        made: rows.len(),
        endings: Endings::of(rows.iter().map(|row| &row.ending)),
        reached: share_reached(rows),
        depth: mean_interval(&depths, 0.95),
        figures: PUBLISHED
            .iter()
            .map(|figure| judge(figure, rows, base))
            .collect(),
        setting: setting.clone(),
    }
}

fn figures(points: &[Point]) -> Vec<Figure> {
    PUBLISHED
        .iter()
        .enumerate()
        .map(|(index, figure)| {
            let of = |wanted: Verdict| -> Vec<usize> {
                let own = points
                    .iter()
                    .filter(|point| point.figures[index].verdict == wanted);
                own.map(|point| point.number).collect()
            };
            Figure {
                id: figure.id,
                title: figure.title,
                value: figure.value,
                tolerance: figure.tolerance,
                unit: figure.unit,
                reason: figure.reason,
                comes_out: of(Verdict::ComesOut),
                undecided: of(Verdict::Undecided),
                does_not: of(Verdict::DoesNot),
                not_made: of(Verdict::NotMade),
            }
        })
        .collect()
}

fn joint(points: &[Point]) -> Vec<Joint> {
    let together = |title, wanted: &dyn Fn(usize) -> bool| {
        let indices: Vec<usize> = (0..PUBLISHED.len())
            .filter(|index| wanted(*index))
            .collect();
        let all = |check: &dyn Fn(&Judged) -> bool| -> Vec<usize> {
            let own = points
                .iter()
                .filter(|point| indices.iter().all(|index| check(&point.figures[*index])));
            own.map(|point| point.number).collect()
        };
        Joint {
            title,
            figures: indices.iter().map(|index| PUBLISHED[*index].id).collect(),
            comes_out: all(&|of| of.verdict == Verdict::ComesOut),
            possible: all(&|of| matches!(of.verdict, Verdict::ComesOut | Verdict::Undecided)),
            near: all(&|of| of.near),
        }
    };
    let is_stress =
        |index: usize| PUBLISHED[index].of == Of::Mean && PUBLISHED[index].key.starts_with("last.");
    let is_bed = |index: usize| PUBLISHED[index].key.starts_with("settled.");
    vec![
        together("height and porosity", &is_bed),
        together("mean stresses at O, A and B", &is_stress),
        together("height, porosity and mean stresses", &|index| {
            is_bed(index) || is_stress(index)
        }),
        together("exponential shapes at O, A and B", &|index| {
            PUBLISHED[index].of != Of::Mean
        }),
        together("everything", &|_| true),
    ]
}
