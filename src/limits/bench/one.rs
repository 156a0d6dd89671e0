//! One timed run of the native engine in a process of its own: so that its memory is its own, and so that
//! its instructions can be counted.

use std::path::Path;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::bed::Bed;
use super::{BenchError, native, program};
use crate::files::{read_text, write_whole};
use crate::tables::{read_bodies, write_bodies};
use grains::native::Mode;
use grains::native::timing::Window;
use grains::scene::Scene;

/// What the process says when it is done.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct One {
    /// The timed steps.
    pub window: Window,
    /// All steps, those before the window too.
    pub steps: u64,
    /// Largest resident memory, bytes, where the system tells.
    pub peak_memory: Option<u64>,
    /// The widest vector unit that the processor shows it.
    pub vector_unit: String,
}

/// Puts a bed where [`run`] finds it.
pub fn write(bed: &Bed, folder: &Path) -> Result<(), BenchError> {
    let text = serde_json::to_string(&bed.scene)
        .map_err(|error| BenchError::Nonsense(error.to_string()))?;
    write_whole(&folder.join("scene.json"), text.as_bytes())?;
    Ok(write_bodies(&folder.join("bed.csv"), &bed.bodies)?)
}

/// Inside the process: times the bed in this folder.
pub fn run(folder: &Path, mode: Mode, steps: u64) -> Result<One, BenchError> {
    let text = read_text(&folder.join("scene.json"), 1 << 20)?;
    // Not through the check of scenes: a narrow box has no room for the paper's control points.
    let scene: Scene =
        serde_json::from_str(&text).map_err(|error| BenchError::Nonsense(error.to_string()))?;
    let bodies = read_bodies(&folder.join("bed.csv"), scene.particles.count)?;
    let window = native::time(&Bed { scene, bodies }, mode, steps)?;
    Ok(One {
        window,
        steps: native::all_steps(steps),
        peak_memory: crate::run::peak_memory(),
        vector_unit: super::machine::vector_unit().to_owned(),
    })
}

/// The arguments that make the program `crossgrain` do [`run`].
pub fn arguments(folder: &Path, mode: Mode, steps: u64) -> Vec<String> {
    vec![
        "bench".to_owned(),
        "--one".to_owned(),
        folder.display().to_string(),
        "--one-mode".to_owned(),
        mode.name().to_owned(),
        "--one-steps".to_owned(),
        steps.to_string(),
    ]
}

/// Outside: starts the process on the bed in `folder` and waits for it.
pub fn in_a_process(
    crossgrain: &Path,
    folder: &Path,
    mode: Mode,
    steps: u64,
    limit: Duration,
) -> Result<One, BenchError> {
    let arguments = arguments(folder, mode, steps);
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    said(&program::run(crossgrain, &arguments, folder, limit)?)
}

/// The line that the process printed, among others.
pub fn said(log: &str) -> Result<One, BenchError> {
    log.lines()
        .find(|line| line.starts_with('{'))
        .and_then(|line| serde_json::from_str(line).ok())
        .ok_or_else(|| BenchError::Nonsense("the timing process said nothing".to_owned()))
}
