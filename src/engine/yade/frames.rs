//! Reading back what the script wrote, trusting none of it: every count, id, step and number is
//! checked before it becomes a table.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use serde::Deserialize;

use super::binary::{MomentLine, Tables};
use super::{YadeError, completeness, nonsense};
use crate::engine::native::check_moment;
use crate::engine::{Observer, Outcome, StageReport, Task};
use crate::scene::Scene;
use crate::tables::{Bodies, BodyIds, Snapshot, Stage, StopReason};

#[derive(Deserialize)]
struct FrameLine {
    frame: Stage,
    step: u64,
    #[serde(flatten)]
    moment: MomentLine,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EndLine {
    end: Stage,
    steps: u64,
    stop: String,
    wall_seconds: f64,
    cpu_seconds: f64,
}

/// Reads all moments in order, shows them to the observer and returns the outcome.
pub fn read(
    work: &Path,
    scene: &Scene,
    task: &Task,
    observer: &mut dyn Observer,
) -> Result<Outcome, YadeError> {
    let index = work.join("frames.jsonl");
    let written = |path: &Path| {
        File::open(path).map_err(|error| nonsense(format!("{}: {error}", path.display())))
    };
    let index = BufReader::new(written(&index)?);
    let mut reader = Frames {
        scene,
        tables: Tables::open(work)?,
        start: &task.start.bodies,
    };
    let mut stages: Vec<StageReport> = Vec::new();
    let mut settled = None;
    let mut last: Option<Snapshot> = None;
    let mut seen: Vec<(Stage, u64)> = Vec::new();
    for line in index.lines() {
        let line = line.map_err(|error| nonsense(format!("frames.jsonl: {error}")))?;
        if line.starts_with(r#"{"end""#) {
            let report = end(&line)?;
            if report.stop == StopReason::Settled {
                settled.clone_from(&last);
            }
            stages.push(report);
        } else {
            let snapshot = reader.frame(&line)?;
            if seen.is_empty() && snapshot.bodies.digest() != task.start.bodies.digest() {
                return Err(nonsense(
                    "its first moment is not the start that it was given".to_owned(),
                ));
            }
            check_moment(&snapshot, scene.container.width).map_err(|trouble| {
                YadeError::WentWrong {
                    stage: snapshot.stage,
                    step: snapshot.step,
                    trouble,
                }
            })?;
            seen.push((snapshot.stage, snapshot.step));
            observer.snapshot(&snapshot);
            last = Some(snapshot);
        }
    }
    reader.tables.at_end()?;
    let last = last.ok_or_else(|| nonsense("not one moment of the run".to_owned()))?;
    completeness::check(work, scene, task, &stages, &seen)?;
    Ok(Outcome {
        stages,
        settled,
        last,
    })
}

fn end(line: &str) -> Result<StageReport, YadeError> {
    let of: EndLine =
        serde_json::from_str(line).map_err(|error| nonsense(format!("frames.jsonl: {error}")))?;
    let stop = match of.stop.as_str() {
        "settled" => StopReason::Settled,
        "reached" => StopReason::Reached,
        "sank_to_give_up_depth" => StopReason::SankToGiveUpDepth,
        "steps_done" => StopReason::StepsDone,
        "max_steps" => StopReason::MaxSteps,
        "not_finite" => {
            return Err(nonsense(format!(
                "numbers that are not finite in step {} of stage {}",
                of.steps,
                of.end.name()
            )));
        }
        other => return Err(nonsense(format!("the stop reason {other:?}"))),
    };
    Ok(StageReport {
        stage: of.end,
        steps: of.steps,
        stop,
        wall_seconds: of.wall_seconds,
        cpu_seconds: of.cpu_seconds,
    })
}

struct Frames<'a> {
    scene: &'a Scene,
    tables: Tables,
    start: &'a Bodies,
}

impl Frames<'_> {
    fn frame(&mut self, line: &str) -> Result<Snapshot, YadeError> {
        let of: FrameLine = serde_json::from_str(line)
            .map_err(|error| nonsense(format!("frames.jsonl: {error}")))?;
        let at = format!("stage {} step {}", of.frame.name(), of.step);
        let ids = BodyIds::of_box(self.start.len() as u32);
        let loading = &self.scene.loading;
        let half_extents = [loading.half_width, 0.5 * loading.punch_height];
        let (bodies, contacts, punch) =
            self.tables
                .moment(&of.moment, self.start, ids, half_extents, &at)?;
        Ok(Snapshot {
            stage: of.frame,
            step: of.step,
            time: of.step as f64 * self.scene.time_step_seconds(),
            bodies,
            contacts,
            punch,
        })
    }
}
