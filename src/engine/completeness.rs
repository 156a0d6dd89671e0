//! The run went where it was asked to go: the stages with their ends, every moment, every step.

use grains::scene::Scene;
use grains::tables::{Stage, StopReason};
use grains::task::{StageReport, Task, Until, moments};

/// Checks stages, moments and the engine's own count of steps against the task; else what is wrong.
pub fn check(
    scene: &Scene,
    task: &Task,
    stages: &[StageReport],
    seen: &[(Stage, u64)],
    own_count: u64,
) -> Result<(), String> {
    check_stages(task, stages)?;
    check_moments(scene, task, stages, seen)?;
    check_own_count(task, stages, own_count)
}

/// A line that says how a stage ended.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct EndLine {
    end: Stage,
    steps: u64,
    stop: String,
    wall_seconds: f64,
    cpu_seconds: f64,
}

/// How a stage ended, from such a line; else what is wrong with it.
pub fn end_of_stage(line: &str) -> Result<StageReport, String> {
    let of: EndLine = serde_json::from_str(line).map_err(|error| error.to_string())?;
    let stop = match of.stop.as_str() {
        "settled" => StopReason::Settled,
        "reached" => StopReason::Reached,
        "sank_to_give_up_depth" => StopReason::SankToGiveUpDepth,
        "steps_done" => StopReason::StepsDone,
        "max_steps" => StopReason::MaxSteps,
        "not_finite" => {
            return Err(format!(
                "numbers that are not finite in step {} of stage {}",
                of.steps,
                of.end.name()
            ));
        }
        other => return Err(format!("the stop reason {other:?}")),
    };
    if !(of.wall_seconds >= 0.0 && of.cpu_seconds >= 0.0) {
        return Err("times that are below 0 or none".to_owned());
    }
    Ok(StageReport {
        stage: of.end,
        steps: of.steps,
        stop,
        wall_seconds: of.wall_seconds,
        cpu_seconds: of.cpu_seconds,
    })
}

/// Every moment that the scene asks for, in order, and no other.
fn check_moments(
    scene: &Scene,
    task: &Task,
    stages: &[StageReport],
    seen: &[(Stage, u64)],
) -> Result<(), String> {
    let every = scene.measurement.history_every;
    // A count that somebody made up is not counted through.
    let most = seen.len() as u64;
    if let Some(stage) = stages
        .iter()
        .find(|stage| stage.steps / every > most + task.start.step / every)
    {
        return Err(format!(
            "stage {} of {} steps has more moments than the {most} that there are",
            stage.stage.name(),
            stage.steps
        ));
    }
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
    Err(format!(
        "moment {at} of the run should be {} and is {}",
        moment(wanted.get(at)),
        moment(seen.get(at))
    ))
}

/// The engine's own count of steps is that of the stages.
fn check_own_count(task: &Task, stages: &[StageReport], own_count: u64) -> Result<(), String> {
    let steps: u64 = stages
        .iter()
        .map(|stage| stage.steps.saturating_sub(first_step(task, stage.stage)))
        .sum();
    if own_count == steps {
        return Ok(());
    }
    Err(format!(
        "it counts {own_count} steps, its stages have {steps}"
    ))
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
fn check_stages(task: &Task, stages: &[StageReport]) -> Result<(), String> {
    use StopReason::{MaxSteps, Reached, SankToGiveUpDepth, Settled, StepsDone};
    let ends: Vec<(Stage, StopReason)> = stages.iter().map(|of| (of.stage, of.stop)).collect();
    let fits = match (task.until, task.start.stage, ends.as_slice()) {
        (Until::Step(step), stage, [(end, StepsDone)]) => {
            if stages[0].steps != step {
                return Err(format!(
                    "{step} steps were asked for and {} were done",
                    stages[0].steps
                ));
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
    Err(format!(
        "its stages are not those of the task: {}",
        if stages.is_empty() {
            "none was finished".to_owned()
        } else {
            stages.join(", ")
        }
    ))
}
