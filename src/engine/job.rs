//! The job folder: everything that an engine is told, as data.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde_json::Value;

use super::exec::PROTOCOL;
use super::read::TimedSteps;
use super::{ProgramError, nonsense};
use crate::files::{failed, write_whole};
use crate::tables as text;
use grains::model::Model;
use grains::scene::Scene;
use grains::tables::{Bodies, Punch, Stage};
use grains::task::Case;
use grains::task::{Task, Until};

#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum Job<'a> {
    Scene {
        protocol: u32,
        model: Model,
        stage: Stage,
        step: u64,
        until_step: Option<u64>,
        ends_settled: bool,
        moments_every: u64,
        settle: SettleRule,
        loading: Loading,
        punch: Option<GivenPunch>,
        #[serde(skip_serializing_if = "Value::is_null")]
        settings: &'a Value,
    },
    Case {
        protocol: u32,
        name: &'a str,
        model: &'a Model,
        moments: &'a [u64],
        punch: Option<GivenPunch>,
    },
    Timing {
        protocol: u32,
        model: &'a Model,
        warm_up: u64,
        steps: u64,
        shares: u64,
        under: &'a [String],
        #[serde(skip_serializing_if = "Value::is_null")]
        settings: &'a Value,
    },
    Cases {
        protocol: u32,
        folders: Vec<String>,
        #[serde(skip_serializing_if = "Value::is_null")]
        settings: &'a Value,
    },
}

#[derive(Serialize)]
struct SettleRule {
    kinetic_energy_fraction: f64,
    check_every: u64,
    max_steps: u64,
}

#[derive(Serialize)]
struct Loading {
    axis: f64,
    half_extents: [f64; 2],
    speed: f64,
    target_force: f64,
    give_up_depth: f64,
    steps_standing_still: Option<u64>,
}

#[derive(Serialize)]
struct GivenPunch {
    centre: [f64; 2],
    half_extents: [f64; 2],
    start: f64,
    velocity: f64,
}

impl From<Punch> for GivenPunch {
    fn from(of: Punch) -> Self {
        GivenPunch {
            centre: of.centre,
            half_extents: of.half_extents,
            start: of.start,
            velocity: of.velocity,
        }
    }
}

/// Writes scene, grains and job into `work`; `settings` are those of an adapter, null where there are none.
pub fn write_scene(
    work: &Path,
    scene: &Scene,
    task: &Task,
    settings: &Value,
) -> Result<(), ProgramError> {
    let loading = &scene.loading;
    // A punch that stands still goes on doing so; any other has the scene's speed.
    let punch = task.start.punch.map(|punch| Punch {
        velocity: if punch.velocity == 0.0 {
            0.0
        } else {
            -loading.speed
        },
        ..punch
    });
    let job = Job::Scene {
        protocol: PROTOCOL,
        model: Model::of(scene),
        stage: task.start.stage,
        step: task.start.step,
        until_step: match task.until {
            Until::Step(step) => Some(step),
            Until::EndOfSettling | Until::EndOfLoading => None,
        },
        ends_settled: task.until == Until::EndOfSettling,
        moments_every: scene.measurement.history_every,
        settle: SettleRule {
            kinetic_energy_fraction: scene.settle.kinetic_energy_fraction,
            check_every: scene.settle.check_every,
            max_steps: scene.settle.max_steps,
        },
        loading: Loading {
            axis: scene.punch_axis(),
            half_extents: [loading.half_width, 0.5 * loading.punch_height],
            speed: loading.speed,
            target_force: scene.target_force(),
            give_up_depth: loading.give_up_depth,
            steps_standing_still: scene.steps_standing_still(),
        },
        punch: punch.map(GivenPunch::from),
        settings,
    };
    write_json(&work.join("scene.json"), scene)?;
    write_json(&work.join("job.json"), &job)?;
    write_grains(work, &task.start.bodies)
}

/// The folder of the case with this number.
pub fn case_folder(work: &Path, index: usize) -> PathBuf {
    work.join(case_name(index))
}

fn case_name(index: usize) -> String {
    format!("case-{index:04}")
}

/// Writes a folder for each case into `work`, and the list of them.
pub fn write_cases(work: &Path, cases: &[&Case], settings: &Value) -> Result<(), ProgramError> {
    for (index, case) in cases.iter().enumerate() {
        let folder = case_folder(work, index);
        fs::create_dir(&folder).map_err(failed("create", &folder))?;
        let job = Job::Case {
            protocol: PROTOCOL,
            name: &case.name,
            model: &case.model,
            moments: &case.moments,
            punch: case.punch.map(GivenPunch::from),
        };
        write_json(&folder.join("job.json"), &job)?;
        write_grains(&folder, &case.bodies)?;
    }
    let job = Job::Cases {
        protocol: PROTOCOL,
        folders: (0..cases.len()).map(case_name).collect(),
        settings,
    };
    write_json(&work.join("job.json"), &job)
}

/// Writes a bed whose steps are to be timed into `work`; the program runs `under` another one, such as valgrind, if any is
/// named.
pub fn write_timing(
    work: &Path,
    model: &Model,
    bodies: &Bodies,
    steps: TimedSteps,
    under: &[String],
    settings: &Value,
) -> Result<(), ProgramError> {
    let job = Job::Timing {
        protocol: PROTOCOL,
        model,
        warm_up: steps.warm_up,
        steps: steps.timed,
        shares: steps.shares,
        under,
        settings,
    };
    write_json(&work.join("job.json"), &job)?;
    write_grains(work, bodies)
}

fn write_grains(work: &Path, bodies: &Bodies) -> Result<(), ProgramError> {
    text::write_bodies(&work.join("initial.csv"), bodies).map_err(|error| match error {
        text::TableError::File(error) => ProgramError::File(error),
        other => nonsense(other.to_string()),
    })
}

fn write_json(path: &Path, value: &impl Serialize) -> Result<(), ProgramError> {
    let text = serde_json::to_string_pretty(value).map_err(|error| nonsense(error.to_string()))?;
    Ok(write_whole(path, text.as_bytes())?)
}
