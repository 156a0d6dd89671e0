//! Reading back what the script wrote, trusting none of it: every count, id, step and number is
//! checked before it becomes a table.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use serde::Deserialize;

use super::{YadeError, completeness, nonsense};
use crate::engine::{Observer, Outcome, StageReport, Task};
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
        let spin = self.numbers(self.start.spin.len(), &at)?;
        let rows = self.numbers(of.contacts * CONTACT_COLUMNS, &at)?;
        let [x, z, vx, vz] = columns;
        let bodies = Bodies {
            x,
            z,
            vx,
            vz,
            radius: self.start.radius.clone(),
            mass: self.start.mass.clone(),
            spin,
            inertia: self.start.inertia.clone(),
        };
        let ids = BodyIds::of_box(count as u32);
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
