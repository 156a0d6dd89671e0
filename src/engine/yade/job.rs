//! The job folder: everything that the script is told, as data.

use std::fs;
use std::path::Path;

use serde::Serialize;

use super::{Options, YadeError};
use crate::engine::{Task, Until};
use crate::files::{failed, write_whole};
use crate::scene::Scene;
use crate::tables::{Stage, text};

/// The fixed script.
pub const SCRIPT: &str = include_str!("../../../yade_scripts/run_scene.py");

/// SHA-256 of the script, in hexadecimal: what ran inside YADE.
pub fn script_digest() -> String {
    crate::files::sha256_hex(SCRIPT.as_bytes())
}

/// Half-extent of the punch across the plane, m: so large that this face never is the nearest.
const PUNCH_HALF_DEPTH: f64 = 10.0;

#[derive(Serialize)]
struct Job {
    dt: f64,
    sorted: bool,
    verlet_distance: f64,
    punch_half_depth: f64,
    until_step: Option<u64>,
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
}

/// Writes script, scene, grains and job into `work`.
pub fn write(work: &Path, scene: &Scene, task: &Task, options: &Options) -> Result<(), YadeError> {
    let job = Job {
        dt: scene.time_step_seconds(),
        sorted: options.sorted,
        verlet_distance: options.verlet_distance,
        punch_half_depth: PUNCH_HALF_DEPTH,
        until_step: match task.until {
            Until::Step(step) => Some(step),
            Until::EndOfLoading => None,
        },
        start: Start {
            stage: task.start.stage,
            step: task.start.step,
            punch: task.start.punch.map(|punch| StartPunch {
                centre: punch.centre,
                start: punch.start,
            }),
        },
    };
    let home = work.join("home");
    fs::create_dir(&home).map_err(failed("create", &home))?;
    write_whole(&work.join("run_scene.py"), SCRIPT.as_bytes())?;
    write_json(&work.join("scene.json"), scene)?;
    write_json(&work.join("job.json"), &job)?;
    text::write_bodies(&work.join("initial.csv"), &task.start.bodies).map_err(|error| match error {
        text::TableError::File(error) => YadeError::File(error),
        other => YadeError::Nonsense(other.to_string()),
    })
}

fn write_json(path: &Path, value: &impl Serialize) -> Result<(), YadeError> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|error| YadeError::Nonsense(error.to_string()))?;
    Ok(write_whole(path, text.as_bytes())?)
}
