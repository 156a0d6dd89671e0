//! A run that goes on from the folder of another one: interrupted or stopped at a step, it goes on to its end; a settled bed is
//! loaded in another way. What comes out is the whole run, bit for bit.

use super::Made;
use crate::run::folder::record::{EngineRecord, Protocol, Restart};
use crate::run::folder::{Moment, RunFolder};
use grains::model::Model;
use grains::native;
use grains::scene::Scene;
use grains::tables::{Punch, Snapshot, Stage, StopReason};
use grains::task::{Outcome, Start, Task, Until};

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
        return Err(
            "its scene is poured in another way; only /loading, /measurement but for history_every, \
             and /control_points may differ"
                .to_owned(),
        );
    }
    let (Some(Restart { punch, seen }), Some(last)) = (record.restart, record.stages.last()) else {
        return Err("its run.json does not have the state; run it again".to_owned());
    };
    if seen.held {
        return Err("with --steps it went beyond the rule of its stage; run it without".to_owned());
    }
    let settled = before.settled.iter().map(|of| (Stage::Settle, of));
    let forgot = |(stage, of): (Stage, &Moment)| {
        let law = Model::in_stage(&before.scene, stage).law;
        law.has_history() && of.memory.len() != of.contacts.len()
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
        let Some(bed) = before
            .settled
            .as_ref()
            .or(is_settled.then_some(&before.last))
        else {
            return Err(
                "its bed never settled; raise /settle/max_steps and run it again".to_owned(),
            );
        };
        if is_same && !is_settled {
            return Err("it is at its end; give a scene with another load".to_owned());
        }
        made.outcome.stages.truncate(1);
        made.history.retain(|row| row.stage == Stage::Settle);
        made.trace.retain(|row| row.stage == Stage::Settle);
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

fn snapshot(of: &Moment, at: (Stage, u64), scene: &Scene, punch: Option<Punch>) -> Snapshot {
    let (stage, step) = at;
    Snapshot {
        stage,
        step,
        time: step as f64 * scene.time_step_seconds(),
        bodies: of.bodies.clone(),
        contacts: of.contacts.clone(),
        memory: of.memory.clone(),
        punch,
    }
}
