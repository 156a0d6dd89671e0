//! Reading back what the script wrote, trusting none of it: every count, id, step and number is
//! checked before it becomes a table.

use std::path::Path;

use serde::Deserialize;

use super::binary::{MomentLine, Tables, index};
use super::{YadeError, nonsense};
use crate::engine::completeness;
use crate::files::read_text;
use grains::native::check_moment;
use grains::scene::Scene;
use grains::tables::{Bodies, BodyIds, Snapshot, Stage, StopReason};
use grains::task::{Observer, Outcome, StageReport, Task};

#[derive(Deserialize)]
struct FrameLine {
    frame: Stage,
    step: u64,
    #[serde(flatten)]
    moment: MomentLine,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DoneFile {
    steps_by_yade: u64,
}

/// Reads all moments in order, shows them to the observer and returns the outcome.
pub fn read(
    work: &Path,
    scene: &Scene,
    task: &Task,
    observer: &mut dyn Observer,
) -> Result<Outcome, YadeError> {
    let index = index(work)?;
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
        if line.starts_with(r#"{"end""#) {
            let report = completeness::end_of_stage(line)
                .map_err(|reason| nonsense(format!("frames.jsonl: {reason}")))?;
            if report.stop == StopReason::Settled {
                settled.clone_from(&last);
            }
            stages.push(report);
        } else {
            let snapshot = reader.frame(line)?;
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
    completeness::check(scene, task, &stages, &seen, own_count(work)?).map_err(nonsense)?;
    Ok(Outcome {
        stages,
        settled,
        last,
    })
}

/// YADE's own count of steps.
fn own_count(work: &Path) -> Result<u64, YadeError> {
    let text =
        read_text(&work.join("done.json"), 1 << 16).map_err(|error| nonsense(error.to_string()))?;
    let done: DoneFile =
        serde_json::from_str(&text).map_err(|error| nonsense(format!("done.json: {error}")))?;
    Ok(done.steps_by_yade)
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
