//! The bed in an engine that was brought: a process a run, so steps are timed as the difference of two runs.

use std::path::Path;

use super::BenchError;
use super::bed::{Bed, start};
use super::contender::{Plan, Turn};
use super::program;
use super::sanity::between_grains;
use crate::engine::exec::{Brought, ExecRun, run_brought};
use grains::native::timing::Window;
use grains::task::{Task, Until};

/// The two runs differ by at least so much, s: processor time is told in hundredths of a second.
const LONG_ENOUGH: f64 = 1.0;
/// N grows by this factor at most, and so many times at most: an engine that needs more computes nothing.
const MOST_LONGER: f64 = 16.0;
const MOST_ROUNDS: u32 = 8;

/// Times steps of this bed: runs of N and of 2N steps from it, N made longer until they differ by a second.
/// Start, reading and tables are the same in both, and so not in their difference. The bed is that of the first run.
pub fn time(bed: &Bed, plan: &Plan, engine: &Brought, work: &Path) -> Result<Turn, BenchError> {
    let mut steps = plan.compared_after();
    let first = run(bed, steps, engine, work)?;
    let mut before = first.took;
    for _ in 0..MOST_ROUNDS {
        let after = run(bed, 2 * steps, engine, work)?.took;
        let cpu_seconds = after
            .processor_seconds
            .zip(before.processor_seconds)
            .map(|(after, before)| after - before);
        let window = Window {
            steps,
            wall_seconds: after.wall_seconds - before.wall_seconds,
            cpu_seconds,
        };
        let seconds = cpu_seconds.unwrap_or(window.wall_seconds);
        if seconds >= LONG_ENOUGH {
            let last = first.outcome.last;
            return Ok(Turn {
                window,
                bed: Some((last.bodies.clone(), between_grains(&last))),
                version: first.description.version,
                peak_memory: None,
                shares: Vec::new(),
            });
        }
        // A little more than it should take.
        let longer = 1.2 * LONG_ENOUGH / seconds.max(f64::MIN_POSITIVE);
        steps *= longer.ceil().clamp(2.0, MOST_LONGER) as u64;
        before = run(bed, steps, engine, work)?.took;
    }
    Err(BenchError::Nonsense(format!(
        "{steps} steps take no longer than half of them"
    )))
}

fn run(bed: &Bed, steps: u64, engine: &Brought, work: &Path) -> Result<ExecRun, BenchError> {
    let mut scene = bed.scene.clone();
    // Its first moment and its last.
    scene.measurement.history_every = u64::from(u32::MAX);
    let task = Task {
        start: start(bed.bodies.clone()),
        until: Until::Step(steps),
    };
    let folder = program::folder(work, "job")?;
    Ok(run_brought(&scene, &task, engine, &folder, &mut ())?)
}
