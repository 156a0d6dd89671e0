//! The job folder: everything that the script is told, as data.

use std::fs;
use std::path::Path;

use serde::Serialize;

use super::timing::Steps;
use super::{Options, YadeError};
use crate::files::{failed, write_whole};
use crate::run::tables as text;
use grains::case::Case;
use grains::model::Model;
use grains::scene::Scene;
use grains::tables::{Bodies, Stage};
use grains::task::{Task, Until};

/// The fixed scripts: runs a scene, runs cases, asks for time steps, and what they share.
pub const RUN_SCENE: (&str, &str) = (
    "run_scene.py",
    include_str!("../../../yade_scripts/run_scene.py"),
);
pub const RUN_CASES: (&str, &str) = (
    "run_cases.py",
    include_str!("../../../yade_scripts/run_cases.py"),
);
/// The script that times steps.
pub const TIME_STEPS: (&str, &str) = (
    "time_steps.py",
    include_str!("../../../yade_scripts/time_steps.py"),
);
/// The script that asks for time steps.
pub const PROPOSE_STEPS: (&str, &str) = (
    "propose_steps.py",
    include_str!("../../../yade_scripts/propose_steps.py"),
);
const SHARED: (&str, &str) = (
    "model_in_yade.py",
    include_str!("../../../yade_scripts/model_in_yade.py"),
);

/// SHA-256 of the scripts that run a scene, in hexadecimal: what ran inside YADE.
pub fn script_digest() -> String {
    crate::files::sha256_hex(format!("{}{}", RUN_SCENE.1, SHARED.1).as_bytes())
}

/// Half-extent of the punch across the plane, m: so large that this face never is the nearest.
const PUNCH_HALF_DEPTH: f64 = 10.0;

#[derive(Serialize)]
struct Job {
    model: Model,
    sorted: bool,
    verlet_distance: f64,
    punch_half_depth: f64,
    until_step: Option<u64>,
    ends_settled: bool,
    steps_standing_still: Option<u64>,
    start: Start,
}

#[derive(Serialize)]
struct Start {
    stage: Stage,
    step: u64,
    punch: Option<StartPunch>,
}

#[derive(Serialize)]
struct StartPunch {
    centre: [f64; 2],
    start: f64,
    velocity: f64,
}

/// Writes script, scene, grains and job into `work`.
pub fn write(work: &Path, scene: &Scene, task: &Task, options: &Options) -> Result<(), YadeError> {
    let job = Job {
        model: Model::of(scene),
        sorted: options.sorted,
        verlet_distance: options.verlet_distance,
        punch_half_depth: PUNCH_HALF_DEPTH,
        until_step: match task.until {
            Until::Step(step) => Some(step),
            Until::EndOfSettling | Until::EndOfLoading => None,
        },
        ends_settled: task.until == Until::EndOfSettling,
        steps_standing_still: scene.steps_standing_still(),
        start: Start {
            stage: task.start.stage,
            step: task.start.step,
            punch: task.start.punch.map(|punch| StartPunch {
                centre: punch.centre,
                start: punch.start,
                velocity: punch.velocity,
            }),
        },
    };
    write_scripts(work, RUN_SCENE)?;
    write_json(&work.join("scene.json"), scene)?;
    write_json(&work.join("job.json"), &job)?;
    write_grains(work, &task.start.bodies)
}

fn write_grains(work: &Path, bodies: &Bodies) -> Result<(), YadeError> {
    text::write_bodies(&work.join("initial.csv"), bodies).map_err(|error| match error {
        text::TableError::File(error) => YadeError::File(error),
        other => YadeError::Nonsense(other.to_string()),
    })
}

#[derive(Serialize)]
struct TimingJob<'a> {
    model: &'a Model,
    sorted: bool,
    verlet_distance: f64,
    warm_up: u64,
    steps: u64,
    shares: u64,
    block: u64,
}

/// Grains times steps between two signs of life: about half a second's.
const GRAIN_STEPS_A_BLOCK: u64 = 2_000_000;

/// Writes script, model and grains into `work`, for timing.
pub fn write_timing(
    work: &Path,
    model: &Model,
    bodies: &Bodies,
    steps: Steps,
    options: &Options,
) -> Result<(), YadeError> {
    let job = TimingJob {
        model,
        sorted: options.sorted,
        verlet_distance: options.verlet_distance,
        warm_up: steps.warm_up,
        steps: steps.timed,
        shares: steps.shares,
        block: GRAIN_STEPS_A_BLOCK.div_ceil(bodies.len().max(1) as u64),
    };
    write_scripts(work, TIME_STEPS)?;
    write_json(&work.join("job.json"), &job)?;
    write_grains(work, bodies)
}

/// A home of its own, the script and what it imports.
fn write_scripts(work: &Path, script: (&str, &str)) -> Result<(), YadeError> {
    let home = work.join("home");
    fs::create_dir(&home).map_err(failed("create", &home))?;
    for (name, text) in [script, SHARED] {
        write_whole(&work.join(name), text.as_bytes())?;
    }
    Ok(())
}

#[derive(Serialize)]
struct CasesJob {
    punch_half_depth: f64,
}

#[derive(Serialize)]
struct JobCase<'a> {
    model: &'a Model,
    bodies: Vec<[f64; 8]>,
    punch: Option<CasePunch>,
    moments: &'a [u64],
    loads: bool,
    verlet_distance: f64,
}

#[derive(Serialize)]
struct CasePunch {
    centre: [f64; 2],
    half_extents: [f64; 2],
    velocity: f64,
    start: f64,
}

/// `verletDist` of a case over its smallest radius; in sorted mode the bits do not depend on it.
const VERLET_OVER_RADIUS: f64 = 0.1;

/// Grains of the largest case whose summed forces and torques are written too.
pub const MOST_LOADED: usize = 200;

/// Writes script and cases into `work`.
pub fn write_cases(work: &Path, cases: &[&Case]) -> Result<(), YadeError> {
    write_cases_for(work, RUN_CASES, cases)
}

/// Writes this script and cases into `work`.
pub fn write_cases_for(
    work: &Path,
    script: (&str, &str),
    cases: &[&Case],
) -> Result<(), YadeError> {
    write_scripts(work, script)?;
    let job = CasesJob {
        punch_half_depth: PUNCH_HALF_DEPTH,
    };
    write_json(&work.join("job.json"), &job)?;
    let cases: Vec<JobCase> = cases.iter().map(|case| job_case(case)).collect();
    write_json(&work.join("cases.json"), &cases)
}

fn job_case(case: &Case) -> JobCase<'_> {
    let of = &case.bodies;
    let row = |at: usize| {
        let turning = |column: &[f64], none: f64| column.get(at).copied().unwrap_or(none);
        [
            of.x[at],
            of.z[at],
            of.vx[at],
            of.vz[at],
            of.radius[at],
            of.mass[at],
            turning(&of.spin, 0.0),
            turning(&of.inertia, 1.0),
        ]
    };
    let smallest = of.radius.iter().copied().fold(f64::INFINITY, f64::min);
    JobCase {
        model: &case.model,
        bodies: (0..of.len()).map(row).collect(),
        punch: case.punch.map(|punch| CasePunch {
            centre: punch.centre,
            half_extents: punch.half_extents,
            velocity: punch.velocity,
            start: punch.start,
        }),
        moments: &case.moments,
        loads: of.len() <= MOST_LOADED,
        verlet_distance: VERLET_OVER_RADIUS * smallest,
    }
}

fn write_json(path: &Path, value: &impl Serialize) -> Result<(), YadeError> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|error| YadeError::Nonsense(error.to_string()))?;
    Ok(write_whole(path, text.as_bytes())?)
}
