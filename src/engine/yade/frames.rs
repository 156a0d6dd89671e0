//! Reading back what the script wrote, trusting none of it: every count, id, step and number is
//! checked before it becomes a table.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use serde::Deserialize;

use super::YadeError;
use crate::engine::{Observer, Outcome, StageReport, Task, Until, moments};
use crate::files::read_text;
use crate::scene::Scene;
use crate::tables::text::most_contacts;
use crate::tables::{Bodies, BodyIds, Contact, Punch, Snapshot, Stage, StopReason};

const CONTACT_COLUMNS: usize = 9;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FrameLine {
    frame: Stage,
    step: u64,
    bodies: usize,
    contacts: usize,
    out_of_plane: f64,
    punch: Option<PunchLine>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DoneFile {
    steps_by_yade: u64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PunchLine {
    centre: [f64; 2],
    start: f64,
    velocity: f64,
    force: f64,
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
    let binary = work.join("frames.bin");
    let binary = BufReader::new(written(&binary)?);
    let mut reader = Frames {
        scene,
        start: &task.start.bodies,
        binary,
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
            seen.push((snapshot.stage, snapshot.step));
            observer.snapshot(&snapshot);
            last = Some(snapshot);
        }
    }
    reader.at_end()?;
    let last = last.ok_or_else(|| nonsense("not one moment of the run".to_owned()))?;
    check_stages(task, &stages)?;
    check_moments(scene, task, &stages, &seen)?;
    check_own_count(work, task, &stages)?;
    Ok(Outcome {
        stages,
        settled,
        last,
    })
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
        (Until::EndOfLoading, Stage::Settle, [(Stage::Settle, MaxSteps)]) => true,
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
    start: &'a Bodies,
    binary: BufReader<File>,
}

impl Frames<'_> {
    fn frame(&mut self, line: &str) -> Result<Snapshot, YadeError> {
        let of: FrameLine = serde_json::from_str(line)
            .map_err(|error| nonsense(format!("frames.jsonl: {error}")))?;
        let at = format!("stage {} step {}", of.frame.name(), of.step);
        let count = self.start.len();
        if of.bodies != count {
            return Err(nonsense(format!(
                "{at}: {} grains instead of {count}",
                of.bodies
            )));
        }
        if of.out_of_plane != 0.0 {
            return Err(nonsense(format!("{at}: grains have left the plane")));
        }
        if of.contacts as u64 > most_contacts(count as u32) {
            return Err(nonsense(format!("{at}: {} contacts", of.contacts)));
        }
        let columns = [
            self.numbers(count, &at)?,
            self.numbers(count, &at)?,
            self.numbers(count, &at)?,
            self.numbers(count, &at)?,
        ];
        let rows = self.numbers(of.contacts * CONTACT_COLUMNS, &at)?;
        let [x, z, vx, vz] = columns;
        let bodies = Bodies {
            x,
            z,
            vx,
            vz,
            radius: self.start.radius.clone(),
            mass: self.start.mass.clone(),
        };
        let ids = BodyIds {
            grains: count as u32,
        };
        let mut contacts = rows
            .chunks_exact(CONTACT_COLUMNS)
            .map(|row| contact(row, ids))
            .collect::<Option<Vec<Contact>>>()
            .ok_or_else(|| nonsense(format!("{at}: a contact between bodies that do not exist")))?;
        contacts.sort_by_key(|contact| (contact.id1, contact.id2));
        let punch = of.punch.map(|punch| self.punch(&punch, &at)).transpose()?;
        Ok(Snapshot {
            stage: of.frame,
            step: of.step,
            time: of.step as f64 * self.scene.time_step_seconds(),
            bodies,
            contacts,
            punch,
        })
    }

    fn punch(&self, of: &PunchLine, at: &str) -> Result<Punch, YadeError> {
        let [x, z] = of.centre;
        if ![x, z, of.start, of.velocity, of.force]
            .iter()
            .all(|value| value.is_finite())
        {
            return Err(nonsense(format!("{at}: the punch is not finite")));
        }
        let loading = &self.scene.loading;
        Ok(Punch {
            centre: of.centre,
            half_extents: [loading.half_width, 0.5 * loading.punch_height],
            start: of.start,
            velocity: of.velocity,
            force: of.force,
        })
    }

    fn numbers(&mut self, count: usize, at: &str) -> Result<Vec<f64>, YadeError> {
        let mut bytes = vec![0; count * 8];
        self.binary
            .read_exact(&mut bytes)
            .map_err(|_| nonsense(format!("{at}: frames.bin is cut off")))?;
        let numbers: Vec<f64> = bytes
            .chunks_exact(8)
            .map(|chunk| {
                let mut eight = [0; 8];
                eight.copy_from_slice(chunk);
                f64::from_ne_bytes(eight)
            })
            .collect();
        match numbers.iter().find(|number| !number.is_finite()) {
            Some(number) => Err(nonsense(format!("{at}: a {number} among its numbers"))),
            None => Ok(numbers),
        }
    }

    fn at_end(&mut self) -> Result<(), YadeError> {
        let mut more = [0; 1];
        match self.binary.read(&mut more) {
            Ok(0) => Ok(()),
            _ => Err(nonsense(
                "frames.bin goes on after the last moment".to_owned(),
            )),
        }
    }
}

/// A contact of the script's row; its force is split along the normal and across it as the native
/// engine splits its own.
fn contact(row: &[f64], ids: BodyIds) -> Option<Contact> {
    let id = |value: f64| {
        let id = value as u32;
        (f64::from(id) == value && id <= ids.punch()).then_some(id)
    };
    let (nx, nz, fx, fz) = (row[3], row[4], row[5], row[6]);
    Some(Contact {
        id1: id(row[0])?,
        id2: id(row[1])?,
        overlap: row[2],
        normal_force: fx * nx + fz * nz,
        tangential_force: fz * nx - fx * nz,
        normal: [nx, nz],
        point: [row[7], row[8]],
    })
}

fn nonsense(reason: String) -> YadeError {
    YadeError::Nonsense(reason)
}
