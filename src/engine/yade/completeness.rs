//! The run went where it was asked to go: the stages with their ends, every moment, every step.

use std::path::Path;

use serde::Deserialize;

use super::{YadeError, nonsense};
use crate::engine::{StageReport, Task, Until, moments};
use crate::files::read_text;
use crate::scene::Scene;
use crate::tables::{Stage, StopReason};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DoneFile {
    steps_by_yade: u64,
}

/// Checks stages, moments and YADE's own count of steps against the task.
pub fn check(
    work: &Path,
    scene: &Scene,
    task: &Task,
    stages: &[StageReport],
    seen: &[(Stage, u64)],
) -> Result<(), YadeError> {
    check_stages(task, stages)?;
    check_moments(scene, task, stages, seen)?;
    check_own_count(work, task, stages)
}

/// Every moment that the scene asks for, in order, and no other.
fn check_moments(
    scene: &Scene,
    task: &Task,
    stages: &[StageReport],
    seen: &[(Stage, u64)],
) -> Result<(), YadeError> {
    let every = scene.measurement.history_every;
    let wanted: Vec<(Stage, u64)> = stages
        .iter()
        .flat_map(|stage| {
            let from = first_step(task, stage.stage);
            let steps = moments(from, stage.steps.max(from), every);
            steps.into_iter().map(move |step| (stage.stage, step))
        })
        .collect();
    if wanted == seen {
        return Ok(());
    }
    let odd = wanted.iter().zip(seen).position(|(want, see)| want != see);
    let at = odd.unwrap_or(wanted.len().min(seen.len()));
    let moment = |of: Option<&(Stage, u64)>| {
        of.map_or("none".to_owned(), |(stage, step)| {
            format!("{} {step}", stage.name())
        })
    };
    Err(nonsense(format!(
        "moment {at} of the run should be {} and is {}",
        moment(wanted.get(at)),
        moment(seen.get(at))
    )))
}

/// YADE's own count of steps is that of the stages.
fn check_own_count(work: &Path, task: &Task, stages: &[StageReport]) -> Result<(), YadeError> {
    let text =
        read_text(&work.join("done.json"), 1 << 16).map_err(|error| nonsense(error.to_string()))?;
    let done: DoneFile =
        serde_json::from_str(&text).map_err(|error| nonsense(format!("done.json: {error}")))?;
    let steps: u64 = stages
        .iter()
        .map(|stage| stage.steps.saturating_sub(first_step(task, stage.stage)))
        .sum();
    if done.steps_by_yade != steps {
        return Err(nonsense(format!(
            "YADE counts {} steps, its stages {steps}",
            done.steps_by_yade
        )));
    }
    Ok(())
}

/// The step that a stage starts at in this task.
fn first_step(task: &Task, stage: Stage) -> u64 {
    if stage == task.start.stage {
        task.start.step
    } else {
        0
    }
}

/// The stages are those asked for, each ended by a rule of its own.
fn check_stages(task: &Task, stages: &[StageReport]) -> Result<(), YadeError> {
    use StopReason::{MaxSteps, Reached, SankToGiveUpDepth, Settled, StepsDone};
    let ends: Vec<(Stage, StopReason)> = stages.iter().map(|of| (of.stage, of.stop)).collect();
    let fits = match (task.until, task.start.stage, ends.as_slice()) {
        (Until::Step(step), stage, [(end, StepsDone)]) => {
            if stages[0].steps != step {
                return Err(nonsense(format!(
                    "{step} steps were asked for and {} were done",
                    stages[0].steps
                )));
            }
            *end == stage
        }
        (Until::EndOfSettling, Stage::Settle, [(Stage::Settle, Settled | MaxSteps)])
        | (Until::EndOfLoading, Stage::Settle, [(Stage::Settle, MaxSteps)]) => true,
        (
            Until::EndOfLoading,
            Stage::Settle,
            [
                (Stage::Settle, Settled),
                (Stage::Load, Reached | SankToGiveUpDepth),
            ],
        )
        | (Until::EndOfLoading, Stage::Load, [(Stage::Load, Reached | SankToGiveUpDepth)]) => true,
        _ => false,
    };
    if fits {
        return Ok(());
    }
    let of = |stage: &StageReport| format!("{} {:?}", stage.stage.name(), stage.stop);
    let stages: Vec<String> = stages.iter().map(of).collect();
    Err(nonsense(format!(
        "its stages are not those of the task: {}",
        if stages.is_empty() {
            "none was finished".to_owned()
        } else {
            stages.join(", ")
        }
    )))
}
