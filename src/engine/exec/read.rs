//! Reading back what the engine wrote, trusting none of it: every count, id, step and number is checked before it
//! becomes a table.

use std::path::Path;

use serde::Deserialize;

use super::{CaseResult, ExecError, job, nonsense};
use crate::engine::completeness;
use crate::engine::punch_line::PunchLine;
use crate::files::read_text;
use crate::run::tables as text;
use grains::case::Case;
use grains::native::check_moment;
use grains::scene::Scene;
use grains::tables::{Bodies, BodyIds, Snapshot, Stage, StopReason};
use grains::task::{Observer, Outcome, StageReport, Task};

/// The most that the list of moments may have, bytes.
const LONGEST_LIST: u64 = 1 << 26;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MomentLine {
    stage: Stage,
    step: u64,
    #[serde(default)]
    punch: Option<PunchLine>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RefusedLine {
    refused: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DoneFile {
    steps: u64,
}

/// The start that an engine was given, and what its moments are checked against.
struct Given<'a> {
    bodies: &'a Bodies,
    ids: BodyIds,
    half_extents: [f64; 2],
    dt: f64,
}

/// Reads all moments of a scene in order, shows them to the observer and returns the outcome.
pub fn scene(
    work: &Path,
    scene: &Scene,
    task: &Task,
    observer: &mut dyn Observer,
) -> Result<Outcome, ExecError> {
    let start = &task.start.bodies;
    let given = Given {
        bodies: start,
        ids: BodyIds::of_box(start.len() as u32),
        half_extents: [scene.loading.half_width, 0.5 * scene.loading.punch_height],
        dt: scene.time_step_seconds(),
    };
    let list = list(work, "")?;
    if let Some(reason) = refusal(&list)? {
        return Err(ExecError::Refused(reason));
    }
    let mut stages: Vec<StageReport> = Vec::new();
    let mut settled = None;
    let mut last: Option<Snapshot> = None;
    let mut seen: Vec<(Stage, u64)> = Vec::new();
    for line in list.lines() {
        if line.starts_with(r#"{"end""#) {
            let report = completeness::end_of_stage(line)
                .map_err(|reason| nonsense(format!("moments.jsonl: {reason}")))?;
            if report.stop == StopReason::Settled {
                settled.clone_from(&last);
            }
            stages.push(report);
            continue;
        }
        let snapshot = given.moment(work, line, "")?;
        if seen.is_empty() && snapshot.bodies.digest() != start.digest() {
            return Err(nonsense(
                "its first moment is not the start that it was given; write the grains of initial.csv as they are, digit by \
                 digit",
            ));
        }
        check_moment(&snapshot, scene.container.width).map_err(|trouble| ExecError::WentWrong {
            stage: snapshot.stage,
            step: snapshot.step,
            trouble,
        })?;
        seen.push((snapshot.stage, snapshot.step));
        observer.snapshot(&snapshot);
        last = Some(snapshot);
    }
    let last = last.ok_or_else(|| nonsense("moments.jsonl has not one moment of the run"))?;
    completeness::check(scene, task, &stages, &seen, own_count(work)?).map_err(nonsense)?;
    // A bed that was settled at the very end of a run without loading is its last moment anyway.
    let loaded = stages.iter().any(|stage| stage.stage == Stage::Load);
    Ok(Outcome {
        settled: settled.filter(|_| loaded),
        stages,
        last,
    })
}

/// Reads what the engine made of each case.
pub fn cases(work: &Path, cases: &[&Case]) -> Result<Vec<CaseResult>, ExecError> {
    let mut results = Vec::with_capacity(cases.len());
    let mut steps = 0;
    for (index, case) in cases.iter().enumerate() {
        let result = read_case(&job::case_folder(work, index), case)?;
        if result.is_ok() {
            steps += case.moments.last().copied().unwrap_or(0);
        }
        results.push(result);
    }
    let counted = own_count(work)?;
    if counted != steps {
        return Err(nonsense(format!(
            "done.json counts {counted} steps, its cases have {steps}"
        )));
    }
    Ok(results)
}

fn read_case(folder: &Path, case: &Case) -> Result<CaseResult, ExecError> {
    let name = format!("case {}: ", case.name);
    let given = Given {
        bodies: &case.bodies,
        ids: BodyIds {
            grains: case.bodies.len() as u32,
            walls: case.model.walls.len() as u32,
        },
        half_extents: case.punch.map_or([0.0; 2], |punch| punch.half_extents),
        dt: case.model.dt,
    };
    let list = list(folder, &name)?;
    if let Some(reason) = refusal(&list)? {
        return Ok(Err(reason));
    }
    let mut track = Vec::with_capacity(case.moments.len());
    let mut lines = list.lines();
    for &step in &case.moments {
        let line = lines
            .next()
            .ok_or_else(|| nonsense(format!("{name}moments.jsonl ends before step {step}")))?;
        let moment = given.moment(folder, line, &name)?;
        if (moment.stage, moment.step) != (Stage::Settle, step) {
            return Err(nonsense(format!(
                "{name}step {} of stage {} where step {step} of stage settle should be",
                moment.step,
                moment.stage.name()
            )));
        }
        track.push(moment);
    }
    match lines.next() {
        None => Ok(Ok(track)),
        Some(_) => Err(nonsense(format!(
            "{name}moments.jsonl goes on after its last moment"
        ))),
    }
}

/// The lines of `moments.jsonl`.
fn list(folder: &Path, name: &str) -> Result<String, ExecError> {
    let text = read_text(&folder.join("moments.jsonl"), LONGEST_LIST);
    text.map_err(|error| {
        nonsense(format!(
            "{name}it ended well, but its list of moments is not there: {error}"
        ))
    })
}

fn refusal(list: &str) -> Result<Option<String>, ExecError> {
    if !list.starts_with(r#"{"refused""#) {
        return Ok(None);
    }
    let line: RefusedLine = serde_json::from_str(list.trim_end())
        .map_err(|error| nonsense(format!("moments.jsonl: {error}")))?;
    Ok(Some(line.refused.chars().take(400).collect()))
}

/// The engine's own count of steps.
fn own_count(work: &Path) -> Result<u64, ExecError> {
    let text = read_text(&work.join("done.json"), 1 << 16)
        .map_err(|error| nonsense(format!("it ended well before the job was done: {error}")))?;
    let done: DoneFile =
        serde_json::from_str(&text).map_err(|error| nonsense(format!("done.json: {error}")))?;
    Ok(done.steps)
}

impl Given<'_> {
    fn moment(&self, folder: &Path, line: &str, name: &str) -> Result<Snapshot, ExecError> {
        let of: MomentLine = serde_json::from_str(line)
            .map_err(|error| nonsense(format!("{name}moments.jsonl: {error}")))?;
        let at = format!("{name}stage {} step {}", of.stage.name(), of.step);
        let table = |what: &str| folder.join(format!("{}-{}-{what}.csv", of.stage.name(), of.step));
        let broken = |error: text::TableError| nonsense(format!("{at}: {error}"));
        let bodies =
            text::read_bodies(&table("bodies"), self.bodies.len() as u32).map_err(broken)?;
        self.same_grains(&bodies, &at)?;
        let contacts = text::read_contacts(&table("contacts"), self.ids).map_err(broken)?;
        for contact in &contacts {
            let ordered = contact.id1 < contact.id2 || !self.ids.is_grain(contact.id1);
            if !self.ids.is_grain(contact.id2) || !ordered {
                return Err(nonsense(format!(
                    "{at}: a contact of {} and {}: of two grains the lower id stands first, a wall or the punch always does",
                    contact.id1, contact.id2
                )));
            }
            if contact.overlap < 0.0 {
                return Err(nonsense(format!(
                    "{at}: a contact of {} and {} with the overlap {}: only what touches is a contact",
                    contact.id1, contact.id2, contact.overlap
                )));
            }
        }
        let punch = of.punch.map(|punch| punch.read(self.half_extents, &at));
        let punch = punch.transpose().map_err(nonsense)?;
        Ok(Snapshot {
            stage: of.stage,
            step: of.step,
            time: of.step as f64 * self.dt,
            bodies,
            contacts,
            punch,
        })
    }

    fn same_grains(&self, bodies: &Bodies, at: &str) -> Result<(), ExecError> {
        if bodies.len() != self.bodies.len() {
            return Err(nonsense(format!(
                "{at}: {} grains instead of {}",
                bodies.len(),
                self.bodies.len()
            )));
        }
        if bodies.rotate() != self.bodies.rotate() {
            return Err(nonsense(format!(
                "{at}: the columns spin and inertia are for grains that rotate, and for those always"
            )));
        }
        let same = bodies.radius == self.bodies.radius
            && bodies.mass == self.bodies.mass
            && bodies.inertia == self.bodies.inertia;
        if same {
            return Ok(());
        }
        Err(nonsense(format!(
            "{at}: other radii, masses or moments of inertia than in initial.csv; write them as they were given"
        )))
    }
}
