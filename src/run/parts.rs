//! Runs that go on. One run of an engine in parts, side by side: where contacts remember nothing, positions and velocities are the
//! whole state, so parts can begin in states that the native engine has made. A part counts only if the one before has ended in the
//! very bits that it began with: the parts that count are then the engine's own run, bit for bit.
//!
//! And a run that goes on from the folder of another one: interrupted or stopped at a step, it goes on to its end; a settled bed is
//! loaded in another way. What comes out is the whole run, bit for bit.

use std::path::Path;
use std::sync::Mutex;

use super::{EngineError, KeptError, Made, followed, keep_evidence};
use crate::engine::{Engine, EngineRecord, ProgramError};
use crate::files::folder_aside;
use crate::progress::{self, Display};
use crate::run::folder::record::{Protocol, Restart};
use crate::run::folder::{Moment, RunFolder};
use crate::workers::{cores, each, lock};
use grains::generate::initial_bodies;
use grains::measure::HistoryRow;
use grains::model::Model;
use grains::native;
use grains::scene::Scene;
use grains::tables::{Punch, Snapshot, Stage, StopReason};
use grains::task::{Outcome, Seen, StageReport, Start, Task, Until};

/// Work of a part in the mean, steps times contacts: about half a minute of YADE's.
const WORK: f64 = 4.5e7;

/// Steps of settling at which to cut a run that goes about like this one, each part longer than the one before; none where it
/// is short, or cannot be cut.
pub fn cuts(scene: &Scene, history: &[HistoryRow]) -> Vec<u64> {
    // The peak that the rule of settling goes by is known where each of its looks is a moment.
    let every = scene.measurement.history_every;
    let is_seen = scene.settle.check_every.is_multiple_of(every);
    if scene.in_space() || Model::of(scene).law.has_history() || !is_seen {
        return Vec::new();
    }
    // Grains take time too where nothing touches.
    let grains = 0.5 * f64::from(scene.particles.count);
    let settling = history.iter().filter(|row| row.stage == Stage::Settle);
    let mut done = 0.0;
    let until: Vec<(u64, f64)> = settling
        .map(|row| {
            done += every as f64 * (row.contacts as f64 + grains);
            (row.step, done)
        })
        .collect();
    let parts = (done / WORK).round();
    // The longest are begun first, so that short ones are left when the cores come to their end.
    let at = |part: u64| {
        let share = (part as f64 / parts).powi(2);
        until.iter().find(|(_, work)| *work >= done * share)
    };
    let cuts = (1..parts as u64).filter_map(at).map(|(step, _)| *step);
    cuts.filter(|step| step.is_multiple_of(every)).collect()
}

/// Runs the scene whole, cut at these steps of settling, and writes its folder.
pub fn to_folder(
    scene: &Scene,
    engine: &dyn Engine,
    cuts: &[u64],
    out: &Path,
    display: &Display,
) -> Result<RunFolder, KeptError> {
    let task = display.task(&engine.name());
    let made = in_parts(scene, engine, cuts, out, &task);
    let (made, parts) = made.inspect_err(|_| task.done("failed"))?;
    let mut run = made.folder(scene, engine, Protocol::Whole, initial_bodies(scene));
    run.record.parts = Some(parts);
    run.write(out)?;
    task.done(&format!("{}, in {parts} parts", run.stages_in_words()));
    Ok(run)
}

/// The run, and how many parts it is of.
fn in_parts(
    scene: &Scene,
    engine: &dyn Engine,
    cuts: &[u64],
    out: &Path,
    task: &progress::Task,
) -> Result<(Made, usize), KeptError> {
    let parts = begun(scene, cuts)?;
    let shares = Mutex::new(vec![0.0; parts.len()]);
    let made: Vec<Mutex<Option<Made>>> = parts.iter().map(|_| Mutex::default()).collect();
    // The last ones, loading among them, are the longest.
    let order = (0..parts.len()).rev();
    each(order, cores(), |at| {
        let part = &parts[at];
        let mut progress = |_, step, share| {
            let mut shares = lock(&shares);
            shares[at] = part.share(step, share);
            let all = shares.iter().sum::<f64>() / shares.len() as f64;
            let done = shares.iter().filter(|share| **share >= 1.0).count();
            task.share(all, &format!("{done} of {} parts", shares.len()));
        };
        let done = part.run(engine, out, &mut progress)?;
        progress(part.task.start.stage, part.end, 1.0);
        *lock(&made[at]) = Some(done);
        Ok::<_, KeptError>(())
    })?;
    // Without an error, only a signal to end leaves a part out.
    let interrupted = || EngineError::from(ProgramError::Interrupted);
    let made = made
        .iter()
        .map(|slot| lock(slot).take().ok_or_else(interrupted));
    let made: Vec<Made> = made.collect::<Result<_, _>>()?;
    let mut pairs = parts.iter().zip(made);
    let (_, mut whole) = pairs.next().ok_or_else(interrupted)?;
    let mut count = 1;
    for (part, made) in pairs {
        let goes_on = whole.next(scene);
        if !goes_on.is_some_and(|next| is_same(&next, &part.task.start)) {
            break;
        }
        whole = whole.and(made);
        count += 1;
    }
    // The engine has other bits than the native one: it goes on alone from its own.
    if let Some(start) = whole.next(scene) {
        let rest = Part {
            scene: scene.clone(),
            task: Task {
                start,
                until: Until::EndOfLoading,
            },
            end: 0,
        };
        let mut progress = |stage, step, share| task.run(stage, step, share);
        whole = whole.and(rest.run(engine, out, &mut progress)?);
        count += 1;
    }
    Ok((whole, count))
}

struct Part {
    /// With the step of the cut as the last one, so that each rule holds in each part.
    scene: Scene,
    task: Task,
    /// The step at which the native engine ended it.
    end: u64,
}

/// The parts as the native engine begins them.
fn begun(scene: &Scene, cuts: &[u64]) -> Result<Vec<Part>, EngineError> {
    let native = native::Options::default();
    let mut parts = Vec::new();
    let mut whole: Option<Made> = None;
    let mut next = Some(Start::from(initial_bodies(scene)));
    while let Some(start) = next.take() {
        let mut part = Part::new(scene, start, cuts);
        if part.task.start.stage == Stage::Settle {
            let nowhere = Path::new("");
            let made =
                followed(&part.scene, &native, &part.task, nowhere, &mut |_, _, _| {})?.whole()?;
            part.end = made.outcome.last.step;
            let made = match whole.take() {
                Some(before) => before.and(made),
                None => made,
            };
            next = made.next(scene);
            whole = Some(made);
        }
        parts.push(part);
    }
    Ok(parts)
}

impl Part {
    fn new(scene: &Scene, start: Start, cuts: &[u64]) -> Self {
        let mut scene = scene.clone();
        let cut = cuts.iter().find(|step| **step > start.step);
        let until = match start.stage {
            Stage::Settle => Until::EndOfSettling,
            Stage::Load => Until::EndOfLoading,
        };
        if let Some(cut) = cut {
            scene.settle.max_steps = scene.settle.max_steps.min(*cut);
        }
        Part {
            scene,
            task: Task { start, until },
            end: 0,
        }
    }

    fn run(
        &self,
        engine: &dyn Engine,
        out: &Path,
        progress: &mut dyn FnMut(Stage, u64, f64),
    ) -> Result<Made, KeptError> {
        let work = folder_aside(out)?;
        let made = followed(&self.scene, engine, &self.task, work.path(), progress);
        made.and_then(Made::whole).map_err(|error| {
            keep_evidence(engine, &error, work, out);
            error.into()
        })
    }

    /// The share of it that is done at a step, where its stage's is `share`.
    fn share(&self, step: u64, share: f64) -> f64 {
        let first = self.task.start.step;
        match self.task.start.stage {
            Stage::Settle => (step - first) as f64 / (self.end - first).max(1) as f64,
            Stage::Load => share,
        }
    }
}

impl Made {
    /// The state that the whole run goes on from, if it does.
    fn next(&self, scene: &Scene) -> Option<Start> {
        let last = &self.outcome.last;
        let stage = self.outcome.stages.last()?;
        match (stage.stage, stage.stop) {
            (Stage::Settle, StopReason::Settled) => Some(Start {
                stage: Stage::Load,
                ..last.bodies.clone().into()
            }),
            (Stage::Settle, StopReason::MaxSteps) if stage.steps < scene.settle.max_steps => {
                let is_look = |row: &&HistoryRow| {
                    row.step > 0 && row.step.is_multiple_of(scene.settle.check_every)
                };
                let looks = self.history.iter().filter(is_look);
                Some(Start {
                    seen: Seen {
                        energy: looks.map(|row| row.kinetic_energy).fold(0.0, f64::max),
                        ..Seen::default()
                    },
                    ..last.clone().into()
                })
            }
            _ => None,
        }
    }

    /// Both as one run; `after` has gone on where this one has ended.
    pub(super) fn and(mut self, after: Made) -> Made {
        let last = &self.outcome.last;
        let seam = (last.stage, last.step);
        let rows = after.history.into_iter();
        self.history
            .extend(rows.filter(|row| (row.stage, row.step) != seam));
        let rows = after.trace.into_iter();
        self.trace
            .extend(rows.filter(|row| (row.stage, row.step) != seam));
        self.continued.extend(after.continued);
        self.log += &after.log;
        let stages = &mut self.outcome.stages;
        for stage in after.outcome.stages {
            match stages.last_mut() {
                Some(before) if before.stage == stage.stage => {
                    *before = StageReport {
                        wall_seconds: before.wall_seconds + stage.wall_seconds,
                        cpu_seconds: before.cpu_seconds + stage.cpu_seconds,
                        ..stage
                    };
                }
                _ => stages.push(stage),
            }
        }
        let last = std::mem::replace(&mut self.outcome.last, after.outcome.last);
        let is_settled = seam.0 == Stage::Settle && self.outcome.last.stage == Stage::Load;
        let settled = after.outcome.settled.or(is_settled.then_some(last));
        self.outcome.settled = settled.or(self.outcome.settled);
        self.outcome.seen = after.outcome.seen;
        self
    }
}

/// Whether two states are the same to the bit.
fn is_same(a: &Start, b: &Start) -> bool {
    a == b && a.bodies.digest() == b.bodies.digest()
}

/// What is left to do of the scene after this run of the native engine, and what of the run stays.
///
/// # Errors
///
/// Why it cannot go on, and what helps.
pub(super) fn rest(
    before: &RunFolder,
    scene: &Scene,
    options: &native::Options,
    protocol: Protocol,
) -> Result<(Task, Made), String> {
    let record = &before.record;
    let EngineRecord::Native { perturbation, .. } = &record.engine else {
        let by = record.engine.label();
        return Err(format!(
            "it was made by {by}, and only a run of the native engine goes on"
        ));
    };
    if *perturbation != options.perturbation {
        return Err("it was made with another --perturb".to_owned());
    }
    if !scene.pours_like(&before.scene) {
        let why = "its scene is poured in another way; only /loading, /measurement but for history_every, \
                   and /control_points may differ";
        return Err(why.to_owned());
    }
    let (Some(Restart { punch, seen }), Some(last)) = (record.restart, record.stages.last()) else {
        return Err("its run.json does not have the state; run it again".to_owned());
    };
    if seen.held {
        return Err("with --steps it went beyond the rule of its stage; run it without".to_owned());
    }
    let settled = before.settled.iter().map(|moment| (Stage::Settle, moment));
    let forgot = |(stage, moment): (Stage, &Moment)| {
        let law = Model::in_stage(&before.scene, stage).law;
        law.has_history() && moment.memory.len() != moment.contacts.len()
    };
    if settled.chain([(last.stage, &before.last)]).any(forgot) {
        return Err("a memory.csv of it is missing, without which friction begins anew".to_owned());
    }
    let is_same = scene.digest() == before.scene.digest();
    let is_under_way = matches!(last.stop, StopReason::StepsDone | StopReason::Interrupted);
    let mut made = Made {
        outcome: Outcome {
            stages: record.stages.clone(),
            settled: None,
            last: snapshot(&before.last, (last.stage, last.steps), scene, punch),
            seen,
        },
        engine: record.engine.clone(),
        log: String::new(),
        history: before.history.clone(),
        trace: before.trace.clone(),
        continued: record.continued.clone(),
    };
    let start = if is_under_way && (is_same || last.stage == Stage::Settle) {
        let settled = before.settled.as_ref();
        let of_settling = (Stage::Settle, record.stages[0].steps);
        made.outcome.settled = settled.map(|bed| snapshot(bed, of_settling, scene, None));
        // A whole run would not have looked at this moment.
        if !last.steps.is_multiple_of(scene.measurement.history_every) {
            let at = (last.stage, last.steps);
            made.history.retain(|row| (row.stage, row.step) != at);
            made.trace.retain(|row| (row.stage, row.step) != at);
        }
        Start {
            seen,
            ..made.outcome.last.clone().into()
        }
    } else {
        let is_settled = last.stop == StopReason::Settled;
        let at_end = is_settled.then_some(&before.last);
        let bed = before
            .settled
            .as_ref()
            .or(at_end)
            .ok_or("its bed never settled; raise /settle/max_steps and run it again")?;
        if is_same && !is_settled {
            return Err("it is at its end; give a scene with another load".to_owned());
        }
        made.outcome.stages.truncate(1);
        made.history.retain(|row| row.stage == Stage::Settle);
        made.trace.retain(|row| row.stage == Stage::Settle);
        made.continued
            .retain(|stretch| stretch.stage == Stage::Settle);
        let steps = made.outcome.stages[0].steps;
        made.outcome.last = snapshot(bed, (Stage::Settle, steps), scene, None);
        Task::load(made.outcome.last.clone()).start
    };
    let until = match protocol {
        Protocol::Whole => Until::EndOfLoading,
        Protocol::Settled if start.stage == Stage::Settle => Until::EndOfSettling,
        Protocol::Steps { steps } if start.stage == Stage::Settle && start.step < steps => {
            Until::Step(steps)
        }
        Protocol::Settled | Protocol::Steps { .. } => {
            return Err("it is further already; leave --steps and --until away".to_owned());
        }
    };
    Ok((Task { start, until }, made))
}

fn snapshot(moment: &Moment, at: (Stage, u64), scene: &Scene, punch: Option<Punch>) -> Snapshot {
    let (stage, step) = at;
    Snapshot {
        stage,
        step,
        time: step as f64 * scene.time_step_seconds(),
        bodies: moment.bodies.clone(),
        contacts: moment.contacts.clone(),
        across: moment.across.clone(),
        memory: moment.memory.clone(),
        punch,
    }
}
