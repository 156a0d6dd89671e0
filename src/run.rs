//! One run: a scene through an engine, its history recorded and its beds measured on the way; watched, with progress shown, its
//! folder written, and what a failed engine left saved.

pub mod continued;
pub mod export;
pub mod folder;
pub mod parts;

use std::path::{Path, PathBuf};

use crate::files::TempDir;

pub use crate::engine::EngineError;
use crate::engine::exec::log;
use crate::engine::native::record;
use crate::engine::{Engine, EngineRecord, ProgramError, Run};
use crate::files::{FileError, folder_aside, keep_folder, of_system, write_beside};
use crate::progress::{self, Display, say};
use crate::run::continued::{Continued, Continuing};
use crate::run::folder::record::{
    Protocol, RECORD_VERSION, Restart, RunRecord, Softened, StepChoice, TraceRow,
};
use crate::run::folder::{Moment, RunFolder, has_room_for_history, not_finite};
use grains::generate::initial_bodies;
use grains::measure::{self, HistoryRow};
use grains::model::ModelRecord;
use grains::native::{NativeError, Trouble};
use grains::scene::Scene;
use grains::tables::{Bodies, Snapshot, Stage, StopReason};
use grains::task::{Observer, Outcome, Seen, Start, Task, Until};

/// About so many grains are marked, evenly by id, and their paths kept in the trace.
const MARKED: usize = 100;

/// Runs the scene from the poured cloud on and returns everything that a run folder holds.
/// `progress` hears how far it is.
pub fn recorded(
    scene: &Scene,
    engine: &dyn Engine,
    protocol: Protocol,
    start: impl Into<Start>,
    work: &Path,
    progress: &mut dyn FnMut(Stage, u64, f64),
) -> Result<RunFolder, EngineError> {
    let task = protocol.task(start);
    let made = followed(scene, engine, &task, work, progress)?.whole()?;
    Ok(made.folder(scene, engine, protocol, task.start.bodies))
}

/// What a run has made, from its first moment to its last.
struct Made {
    outcome: Outcome,
    engine: EngineRecord,
    log: String,
    history: Vec<HistoryRow>,
    trace: Vec<TraceRow>,
    continued: Vec<Continued>,
}

/// Runs the task and records it; a run of the native engine that is asked to end, so far.
fn followed(
    scene: &Scene,
    engine: &dyn Engine,
    task: &Task,
    work: &Path,
    progress: &mut dyn FnMut(Stage, u64, f64),
) -> Result<Made, EngineError> {
    // The native engine would go on from itself, or from a fault that was asked for.
    let asked = match engine.native() {
        Some(_) => scene.clone(),
        None => continued::asked_densely(scene),
    };
    let mut recorder = Recorder {
        scene,
        between: None,
        history: Vec::new(),
        trace: Vec::new(),
        progress,
        steps: match task.until {
            Until::Step(steps) => Some(steps),
            Until::EndOfSettling | Until::EndOfLoading => None,
        },
        interrupted: None,
        continuing: (engine.native().is_none()).then(|| Continuing::new(&asked, engine.rules())),
    };
    let run = engine.run(&asked, task, work, &mut recorder);
    recorder.end_of_stage();
    let run = match (run, recorder.interrupted, engine.native()) {
        (Err(_), Some(outcome), Some(options)) => Run {
            outcome,
            engine: record(options),
            log: String::new(),
            took: None,
        },
        (run, _, _) => run?,
    };
    // Such a run folder could not be read.
    if let Some(why) = recorder.history.iter().find_map(not_finite) {
        let why = format!("{why}: forces or speeds are too large for an energy");
        return Err(ProgramError::Nonsense(why).into());
    }
    let of_stage = |stage: Stage| {
        recorder
            .history
            .iter()
            .filter(move |row| row.stage == stage)
    };
    if let (Some(settled), Some(begun)) = (
        of_stage(Stage::Settle).next_back(),
        of_stage(Stage::Load).next(),
    ) && settled.state != begun.state
    {
        let why = "loading begins with other grains than those of the settled bed, and nothing may move between the stages";
        return Err(ProgramError::Nonsense(why.to_owned()).into());
    }
    let mut continuing = recorder.continuing;
    let last = run.outcome.stages.last();
    let by_rule = last.is_some_and(|stage| stage.stop == StopReason::Settled);
    continuing
        .iter_mut()
        .for_each(|continuing| continuing.end_of_stage(by_rule));
    Ok(Made {
        outcome: run.outcome,
        engine: run.engine,
        log: run.log,
        history: recorder.history,
        trace: recorder.trace,
        continued: continuing.map_or_else(Vec::new, |continuing| continuing.found),
    })
}

impl Made {
    /// An error where the native engine was asked to end.
    fn whole(self) -> Result<Self, EngineError> {
        match self.outcome.stages.last() {
            Some(last) if last.stop == StopReason::Interrupted => {
                let (stage, step, trouble) = (last.stage, last.steps, Trouble::Interrupted);
                Err(NativeError {
                    stage,
                    step,
                    trouble,
                }
                .into())
            }
            _ => Ok(self),
        }
    }

    fn folder(
        self,
        scene: &Scene,
        engine: &dyn Engine,
        protocol: Protocol,
        initial: Bodies,
    ) -> RunFolder {
        let outcome = self.outcome;
        let is_native = engine.native().is_some();
        let restart = is_native.then_some(Restart {
            punch: outcome.last.punch,
            seen: outcome.seen,
        });
        // A bed that was settled at the very end of a run without loading is its last moment anyway.
        let settled = outcome.settled.map(Moment::from);
        let last = Moment::from(outcome.last);
        // One that was asked to end is to end soon, and goes on elsewhere.
        let is_whole = outcome
            .stages
            .last()
            .is_none_or(|stage| stage.stop != StopReason::Interrupted);
        let measures =
            is_whole.then(|| measure::all(scene, settled.as_ref().map(Moment::bed), last.bed()));
        let record = RunRecord {
            version: RECORD_VERSION,
            crossgrain: env!("CARGO_PKG_VERSION").to_owned(),
            engine: self.engine,
            model: ModelRecord::of(scene, is_native),
            scene_digest: scene.digest(),
            initial_digest: initial.digest(),
            protocol,
            command: command(engine, protocol),
            time_step: scene.time_step_seconds(),
            step_choice: None,
            softened: None,
            parts: None,
            stages: outcome.stages,
            restart,
            continued: self.continued,
            peak_memory: peak_memory(),
            measures: measures.unwrap_or_default(),
        };
        RunFolder {
            scene: scene.clone(),
            record,
            initial,
            settled,
            last,
            history: self.history,
            trace: self.trace,
            log: self.log,
        }
    }
}

struct Recorder<'a> {
    scene: &'a Scene,
    /// A moment that the scene does not ask for, unless its stage ends with it.
    between: Option<Snapshot>,
    history: Vec<HistoryRow>,
    trace: Vec<TraceRow>,
    progress: &'a mut dyn FnMut(Stage, u64, f64),
    steps: Option<u64>,
    interrupted: Option<Outcome>,
    continuing: Option<Continuing>,
}

impl Recorder<'_> {
    fn end_of_stage(&mut self) {
        if let Some(last) = self.between.take() {
            self.record(&last);
        }
    }

    fn record(&mut self, snapshot: &Snapshot) {
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
}

impl Observer for Recorder<'_> {
    fn snapshot(&mut self, snapshot: &Snapshot) {
        let before = self.between.as_ref().map(|moment| moment.stage);
        if before.is_some_and(|stage| stage != snapshot.stage) {
            self.end_of_stage();
        }
        self.continuing
            .iter_mut()
            .for_each(|continuing| continuing.moment(snapshot));
        let last = self.history.last();
        let is_first = last.is_none_or(|row| row.stage != snapshot.stage);
        let every = self.scene.measurement.history_every;
        if is_first || snapshot.step.is_multiple_of(every) {
            self.between = None;
            self.record(snapshot);
        } else {
            self.between = Some(snapshot.clone());
        }
    }

    fn progress(&mut self, stage: Stage, step: u64, share: f64) {
        let share = match self.steps {
            Some(steps) => step as f64 / steps.max(1) as f64,
            None => share,
        };
        (self.progress)(stage, step, share.clamp(0.0, 1.0).abs());
    }

    fn interrupted(&mut self, outcome: Outcome) {
        self.interrupted = Some(outcome);
    }
}

/// The command that repeats the run, paths left out: they belong to a machine.
pub fn command(engine: &dyn Engine, protocol: Protocol) -> String {
    let mut words = format!("crossgrain run scene.json {}", engine.words());
    match protocol {
        Protocol::Whole => {}
        Protocol::Steps { steps } => words += &format!(" --steps {steps}"),
        Protocol::Settled => words += " --until settled",
    }
    words + " --out DIR"
}

/// The high-water mark of this process, bytes, on Linux.
pub fn peak_memory() -> Option<u64> {
    let status = String::from_utf8(of_system("/proc/self/status")?).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kibibytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes * 1024)
}

/// The run was not made, or not kept.
#[derive(Debug, thiserror::Error)]
pub enum KeptError {
    #[error(transparent)]
    Engine(#[from] EngineError),
    #[error(transparent)]
    File(#[from] FileError),
    #[error(
        "it was asked to end in step {step} of stage {}, and {} has what there is; go on with crossgrain run SCENE --engine native \
         --from-state {} --out DIR", .stage.name(), out.display(), out.display()
    )]
    Interrupted {
        stage: Stage,
        step: u64,
        out: PathBuf,
    },
}

/// What was done before a run, for its record.
#[derive(Debug, Default)]
pub struct Preparation {
    /// The evidence for the scene's time step, where the program chose it.
    pub step_choice: Option<StepChoice>,
    /// Grains that were poured softly, with what that took; else the scene's cloud is the start.
    pub softened: Option<(Softened, Bodies)>,
    /// Whether a run that is asked to end is written so far.
    pub keeps: bool,
    /// The run that goes on, and where it is.
    pub before: Option<(RunFolder, PathBuf)>,
}

/// Runs the scene after a preparation and writes its folder. When YADE fails, its log is kept beside.
pub fn prepared(
    scene: &Scene,
    preparation: Preparation,
    engine: &dyn Engine,
    protocol: Protocol,
    out: &Path,
    display: &Display,
) -> Result<RunFolder, KeptError> {
    has_room_for_history(scene, protocol)?;
    let task = display.task(&engine.name());
    let mut progress = |stage, step, share| task.run(stage, step, share);
    let work = folder_aside(out)?;
    if let Some((before, path)) = preparation.before {
        let path = path.display();
        let not_resumed = |reason| FileError::Unfit(format!("{path} cannot go on: {reason}"));
        let Some(options) = engine.native() else {
            let reason = "only the native engine goes on from a state".to_owned();
            return Err(not_resumed(reason).into());
        };
        let rest = parts::rest(&before, scene, options, protocol);
        let (rest, made) = rest.map_err(not_resumed)?;
        let rest = followed(scene, engine, &rest, work.path(), &mut progress);
        let made = made.and(rest.inspect_err(|_| task.done("failed"))?);
        let mut run = made.folder(scene, engine, protocol, before.initial);
        run.record.parts = Some(before.record.parts.unwrap_or(1) + 1);
        run.record.step_choice = before.record.step_choice;
        run.record.softened = before.record.softened;
        return kept(run, out, &task);
    }
    let (softened, poured) = preparation.softened.unzip();
    let bodies = poured.unwrap_or_else(|| initial_bodies(scene));
    let start = Start {
        seen: Seen {
            energy: softened
                .as_ref()
                .map_or(0.0, |softened| softened.energy_seen),
            ..Seen::default()
        },
        ..bodies.into()
    };
    let bodies = start.bodies.clone();
    let task_of = protocol.task(start);
    let made = followed(scene, engine, &task_of, work.path(), &mut progress);
    let made = match preparation.keeps {
        true => made,
        false => made.and_then(Made::whole),
    };
    let made = made.inspect_err(|error| {
        task.done("failed");
        keep_evidence(engine, error, work, out);
    })?;
    let mut run = made.folder(scene, engine, protocol, bodies);
    run.record.step_choice = preparation.step_choice;
    if softened.is_some() {
        let command = &mut run.record.command;
        *command = command.replace(" --out ", " --reduced-stiffness --out ");
    }
    run.record.softened = softened;
    kept(run, out, &task)
}

/// Writes the folder, also of a run that was asked to end.
fn kept(run: RunFolder, out: &Path, task: &progress::Task) -> Result<RunFolder, KeptError> {
    run.write(out)?;
    task.done(&run.stages_in_words());
    match run.record.stages.last() {
        Some(last) if last.stop == StopReason::Interrupted => Err(KeptError::Interrupted {
            stage: last.stage,
            step: last.steps,
            out: out.to_owned(),
        }),
        _ => Ok(run),
    }
}

/// An engine that failed leaves its whole log beside where its run folder would have been; one whose files cannot be used
/// leaves them all, since the message names one of them. Said even where no progress is shown.
fn keep_evidence(engine: &dyn Engine, error: &EngineError, work: TempDir, out: &Path) {
    if engine.native().is_some() {
        return;
    }
    let [end, whose] = engine.log();
    // An engine that was never started has said nothing.
    let error = match error {
        EngineError::Native(_) => return,
        EngineError::Program(ProgramError::Missing { .. } | ProgramError::Interrupted) => return,
        EngineError::Program(error) => error,
    };
    let beside = |end: &str| {
        let mut name = out.as_os_str().to_owned();
        name.push(end);
        PathBuf::from(name)
    };
    let log = log(work.path());
    if !log.is_empty()
        && let Ok(kept) = write_beside(&beside(end), log.as_bytes())
    {
        say(&format!("{whose} log is kept in {}", kept.display()));
    }
    if matches!(error, ProgramError::Nonsense(_))
        && let Ok(kept) = keep_folder(work, &beside(".job"))
    {
        say(&format!("what it wrote is kept in {}", kept.display()));
    }
}
