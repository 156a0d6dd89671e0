//! One run: a scene through an engine, its history recorded and its beds measured on the way.

pub mod archive;
pub mod folder;
pub mod kept;
pub mod scene_file;
pub mod vtk;

use std::path::Path;

pub use crate::engine::EngineError;
use crate::engine::{exec, yade};
use crate::run::folder::record::{EngineRecord, Protocol, RECORD_VERSION, RunRecord, TraceRow};
use crate::run::folder::{Moment, RunFolder};
use grains::measure;
use grains::measure::HistoryRow;
use grains::model::ModelRecord;
use grains::native;
use grains::scene::Scene;
use grains::tables::{Bodies, Snapshot, Stage};
use grains::task::{Observer, Outcome, Task, Until};

/// About so many grains are marked, evenly by id, and their paths kept in the trace.
const MARKED: usize = 100;

/// Which engine, and how.
#[derive(Debug, Clone, PartialEq)]
pub enum Engine {
    /// Our own.
    Native(native::Options),
    Yade(yade::Options),
    /// A program that speaks the engine protocol.
    Exec(exec::Options),
}

/// Runs the task without recording anything; `work` is an empty folder for YADE's use.
pub fn bare(
    scene: &Scene,
    engine: &Engine,
    task: &Task,
    work: &Path,
    observer: &mut dyn Observer,
) -> Result<(Outcome, EngineRecord, String), EngineError> {
    match engine {
        Engine::Native(options) => {
            let outcome = native::run(scene, task, options, observer)?;
            let record = EngineRecord::Native {
                version: env!("CARGO_PKG_VERSION").to_owned(),
                perturbation: options.perturbation,
                mode: options.mode,
            };
            Ok((outcome, record, String::new()))
        }
        Engine::Yade(options) => {
            let run = yade::run(scene, task, options, work, observer)?;
            let record = EngineRecord::Yade {
                version: run.version,
                sorted: options.sorted,
                verlet_distance: options.verlet_distance,
                script: yade::script_digest(),
            };
            Ok((run.outcome, record, run.log))
        }
        Engine::Exec(options) => {
            let run = exec::run(scene, task, options, work, observer)?;
            let record = EngineRecord::Exec {
                described: run.description,
                digest: run.digest,
            };
            Ok((run.outcome, record, run.log))
        }
    }
}

/// Runs the scene from the poured cloud on and returns everything that a run folder holds.
/// `progress` hears how far it is.
pub fn recorded(
    scene: &Scene,
    engine: &Engine,
    protocol: Protocol,
    initial: Bodies,
    work: &Path,
    progress: &mut dyn FnMut(Stage, u64, f64),
) -> Result<RunFolder, EngineError> {
    let task = match protocol {
        Protocol::Whole => Task::whole(initial),
        Protocol::Steps { steps } => Task::pour(initial, steps),
        Protocol::Settled => Task::settle(initial),
    };
    let mut recorder = Recorder {
        scene,
        history: Vec::new(),
        trace: Vec::new(),
        progress,
        steps: match task.until {
            Until::Step(steps) => Some(steps),
            Until::EndOfSettling | Until::EndOfLoading => None,
        },
    };
    let (outcome, record, log) = bare(scene, engine, &task, work, &mut recorder)?;
    let (history, trace) = (recorder.history, recorder.trace);
    // A bed that was settled at the very end of a run without loading is its last moment anyway.
    let settled = outcome.settled.map(Moment::from);
    let last = Moment::from(outcome.last);
    let record = RunRecord {
        version: RECORD_VERSION,
        crossgrain: env!("CARGO_PKG_VERSION").to_owned(),
        engine: record,
        model: Some(ModelRecord::of(scene, matches!(engine, Engine::Native(_)))),
        scene_digest: scene.digest(),
        initial_digest: task.start.bodies.digest(),
        protocol,
        command: command(engine, protocol),
        time_step: scene.time_step_seconds(),
        step_choice: None,
        softened: None,
        stages: outcome.stages,
        peak_memory: peak_memory(),
        measures: measure::all(scene, settled.as_ref().map(Moment::bed), last.bed()),
    };
    Ok(RunFolder {
        scene: scene.clone(),
        record,
        initial: task.start.bodies,
        settled,
        last,
        history,
        trace,
        log,
    })
}

struct Recorder<'a> {
    scene: &'a Scene,
    history: Vec<HistoryRow>,
    trace: Vec<TraceRow>,
    progress: &'a mut dyn FnMut(Stage, u64, f64),
    steps: Option<u64>,
}

impl Observer for Recorder<'_> {
    fn snapshot(&mut self, snapshot: &Snapshot) {
        self.history
            .push(measure::history_row(self.scene, snapshot));
        let bodies = &snapshot.bodies;
        for id in (0..bodies.len()).step_by((bodies.len() / MARKED).max(1)) {
            self.trace.push(TraceRow {
                stage: snapshot.stage,
                step: snapshot.step,
                id: id as u32,
                x: bodies.x[id],
                z: bodies.z[id],
            });
        }
    }

    fn progress(&mut self, stage: Stage, step: u64, share: f64) {
        let share = match self.steps {
            Some(steps) => step as f64 / steps.max(1) as f64,
            None => share,
        };
        (self.progress)(stage, step, share.clamp(0.0, 1.0).abs());
    }
}

/// The command that repeats the run, paths left out: they belong to a machine.
pub fn command(engine: &Engine, protocol: Protocol) -> String {
    let mut words = "crossgrain run scene.json".to_owned();
    match engine {
        Engine::Native(options) => {
            words += " --engine native";
            if let Some(fault) = options.perturbation {
                words += &format!(" --perturb {fault}");
            }
            if !options.mode.is_exact() {
                words += &format!(" --mode {}", options.mode.name());
            }
        }
        Engine::Yade(options) => {
            let order = if options.sorted { "sorted" } else { "ordinary" };
            words += &format!(
                " --engine yade --loop {order} --verlet-distance {:?}",
                options.verlet_distance
            );
        }
        // The path belongs to a machine.
        Engine::Exec(_) => words += " --engine exec:PATH",
    }
    match protocol {
        Protocol::Whole => {}
        Protocol::Steps { steps } => words += &format!(" --steps {steps}"),
        Protocol::Settled => words += " --until settled",
    }
    words + " --out DIR"
}

/// The high-water mark of this process, bytes, on Linux.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kibibytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes * 1024)
}
