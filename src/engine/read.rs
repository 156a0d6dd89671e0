//! Reading back what an engine wrote, trusting none of it: every count, id, step and number is checked before it
//! becomes a table. Both forms of tables, text and numbers (`docs/engine-protocol.md`), are read here and nowhere else.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::exec::case_folder;
use super::{ProgramError, nonsense};
use crate::files::read_text;
use crate::tables as text;
use grains::model::Model;
use grains::native::check_moment;
use grains::native::timing::{Share, Window};
use grains::scene::Scene;
use grains::tables::{Bodies, BodyIds, Contact, Punch, Snapshot, Stage, StopReason, tangential};
use grains::task::{Case, Effective, Load};
use grains::task::{Observer, Outcome, StageReport, Task, Until, moments};

/// The most that the list of moments may have, bytes.
const LONGEST_LIST: u64 = 1 << 26;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MomentLine {
    stage: Stage,
    step: u64,
    #[serde(default)]
    punch: Option<PunchLine>,
    /// How many contacts there are in the tables of numbers; without it the tables are text.
    #[serde(default)]
    contacts: Option<u64>,
    /// The largest place or speed across the plane.
    #[serde(default)]
    out_of_plane: f64,
    /// Force and torque summed on each grain.
    #[serde(default)]
    loads: Option<Vec<Load>>,
}

/// Place and velocity of the punch and the force on it, SI units.
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
struct RefusedLine {
    refused: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DoneFile {
    steps: u64,
}

/// What an engine made of a case.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseRun {
    /// The state at each moment.
    pub track: Vec<Snapshot>,
    /// Force and torque summed on each grain at each moment, where it tells them.
    pub loads: Vec<Vec<Load>>,
    /// The parameters that it says it uses, where it tells them.
    pub effective: Option<Effective>,
}

/// The most that an engine may say of its parameters, bytes.
const LONGEST_PARAMETERS: u64 = 1 << 28;

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
) -> Result<Outcome, ProgramError> {
    let start = &task.start.bodies;
    let given = Given {
        bodies: start,
        ids: BodyIds::of_box(start.len() as u32),
        half_extents: [scene.loading.half_width, 0.5 * scene.loading.punch_height],
        dt: scene.time_step_seconds(),
    };
    let mut numbers = Numbers::new(work);
    let list = list(work, "")?;
    if let Some(reason) = refusal(&list)? {
        return Err(ProgramError::Refused(reason));
    }
    let mut stages: Vec<StageReport> = Vec::new();
    let mut settled = None;
    let mut last: Option<Snapshot> = None;
    let mut seen: Vec<(Stage, u64)> = Vec::new();
    for line in list.lines() {
        if line.starts_with(r#"{"end""#) {
            let report = end_of_stage(line)
                .map_err(|reason| nonsense(format!("moments.jsonl: {reason}")))?;
            if report.stop == StopReason::Settled {
                settled.clone_from(&last);
            }
            stages.push(report);
            continue;
        }
        let (snapshot, _) = given.moment(work, &mut numbers, line, "")?;
        if seen.is_empty() && snapshot.bodies.digest() != start.digest() {
            return Err(nonsense(
                "its first moment is not the start that it was given; write the grains of initial.csv as they are, digit by \
                 digit",
            ));
        }
        check_moment(&snapshot, scene.container.width).map_err(|trouble| {
            ProgramError::WentWrong {
                stage: snapshot.stage,
                step: snapshot.step,
                trouble,
            }
        })?;
        seen.push((snapshot.stage, snapshot.step));
        observer.snapshot(&snapshot);
        last = Some(snapshot);
    }
    numbers.at_end("")?;
    let last = last.ok_or_else(|| nonsense("moments.jsonl has not one moment of the run"))?;
    check_completeness(scene, task, &stages, &seen, own_count(work)?).map_err(nonsense)?;
    // A bed that was settled at the very end of a run without loading is its last moment anyway.
    let loaded = stages.iter().any(|stage| stage.stage == Stage::Load);
    Ok(Outcome {
        settled: settled.filter(|_| loaded),
        stages,
        last,
    })
}

/// Reads what the engine made of each case.
pub fn cases(work: &Path, cases: &[&Case]) -> Result<Vec<Result<CaseRun, String>>, ProgramError> {
    let mut results = Vec::with_capacity(cases.len());
    let mut steps = 0;
    for (index, case) in cases.iter().enumerate() {
        let result = read_case(&case_folder(work, index), case)?;
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

fn read_case(folder: &Path, case: &Case) -> Result<Result<CaseRun, String>, ProgramError> {
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
    let effective = folder.join("effective.json");
    let effective = if effective.exists() {
        let broken = |error: String| nonsense(format!("{name}effective.json: {error}"));
        let said =
            read_text(&effective, LONGEST_PARAMETERS).map_err(|error| broken(error.to_string()))?;
        Some(serde_json::from_str(&said).map_err(|error| broken(error.to_string()))?)
    } else {
        None
    };
    let mut numbers = Numbers::new(folder);
    let mut track = Vec::with_capacity(case.moments.len());
    let mut loads = Vec::new();
    let mut lines = list.lines();
    for &step in &case.moments {
        let line = lines
            .next()
            .ok_or_else(|| nonsense(format!("{name}moments.jsonl ends before step {step}")))?;
        let (moment, of_moment) = given.moment(folder, &mut numbers, line, &name)?;
        if (moment.stage, moment.step) != (Stage::Settle, step) {
            return Err(nonsense(format!(
                "{name}step {} of stage {} where step {step} of stage settle should be",
                moment.step,
                moment.stage.name()
            )));
        }
        if of_moment
            .as_ref()
            .is_some_and(|rows| rows.len() != case.bodies.len())
        {
            return Err(nonsense(format!("{name}loads of other grains")));
        }
        track.push(moment);
        loads.extend(of_moment);
    }
    numbers.at_end(&name)?;
    match lines.next() {
        None => Ok(Ok(CaseRun {
            track,
            loads,
            effective,
        })),
        Some(_) => Err(nonsense(format!(
            "{name}moments.jsonl goes on after its last moment"
        ))),
    }
}

/// Steps before, in and after a timed window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimedSteps {
    /// Before it.
    pub warm_up: u64,
    /// In it.
    pub timed: u64,
    /// Afterwards, with the engine's own account of its parts.
    pub shares: u64,
}

/// A bed whose steps an engine has timed by its own clock.
#[derive(Debug)]
pub struct Timed {
    /// The timed steps.
    pub window: Window,
    /// The bed after warm-up and window.
    pub last: Snapshot,
    /// Largest resident memory of its process up to the end of the window, bytes, where it tells.
    pub peak_memory: Option<u64>,
    /// Its own account of its parts; empty where it gives none.
    pub shares: Vec<Share>,
}

/// `done.json` of a timed bed.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TimedDone {
    steps: u64,
    wall_seconds: f64,
    cpu_seconds: Option<f64>,
    peak_memory: Option<u64>,
    #[serde(default)]
    shares: Vec<TimedShare>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TimedShare {
    name: String,
    nanoseconds: u64,
}

/// Reads what an engine made of a bed whose steps it was to time.
pub fn timed(
    work: &Path,
    model: &Model,
    start: &Bodies,
    steps: TimedSteps,
) -> Result<Timed, ProgramError> {
    let list = list(work, "")?;
    if let Some(reason) = refusal(&list)? {
        return Err(ProgramError::Refused(reason));
    }
    let given = Given {
        bodies: start,
        ids: BodyIds {
            grains: start.len() as u32,
            walls: model.walls.len() as u32,
        },
        half_extents: [0.0; 2],
        dt: model.dt,
    };
    let mut numbers = Numbers::new(work);
    let (last, _) = given.moment(work, &mut numbers, list.trim_end(), "")?;
    numbers.at_end("")?;
    let after = steps.warm_up + steps.timed;
    if last.step != after {
        return Err(nonsense(format!(
            "step {} where step {after} should be",
            last.step
        )));
    }
    let done: TimedDone = done(work)?;
    if done.steps != after + steps.shares {
        return Err(nonsense(format!(
            "done.json counts {} steps, {} were asked for",
            done.steps,
            after + steps.shares
        )));
    }
    if !(done.wall_seconds > 0.0 && done.cpu_seconds.is_none_or(|seconds| seconds > 0.0)) {
        return Err(nonsense("times that are not above zero"));
    }
    let total: f64 = done.shares.iter().map(|of| of.nanoseconds as f64).sum();
    let shares = done.shares.into_iter().map(|of| Share {
        share: of.nanoseconds as f64 / total,
        stage: of.name,
    });
    Ok(Timed {
        window: Window {
            steps: steps.timed,
            wall_seconds: done.wall_seconds,
            cpu_seconds: done.cpu_seconds,
        },
        last,
        peak_memory: done.peak_memory,
        shares: shares.filter(|_| total > 0.0).collect(),
    })
}

/// The lines of `moments.jsonl`.
fn list(folder: &Path, name: &str) -> Result<String, ProgramError> {
    let text = read_text(&folder.join("moments.jsonl"), LONGEST_LIST);
    text.map_err(|error| {
        nonsense(format!(
            "{name}it ended well, but its list of moments is not there: {error}"
        ))
    })
}

fn refusal(list: &str) -> Result<Option<String>, ProgramError> {
    if !list.starts_with(r#"{"refused""#) {
        return Ok(None);
    }
    let line: RefusedLine = serde_json::from_str(list.trim_end())
        .map_err(|error| nonsense(format!("moments.jsonl: {error}")))?;
    Ok(Some(line.refused.chars().take(400).collect()))
}

/// The engine's own count of steps.
fn own_count(work: &Path) -> Result<u64, ProgramError> {
    done(work).map(|done: DoneFile| done.steps)
}

/// `done.json`.
fn done<T: DeserializeOwned>(work: &Path) -> Result<T, ProgramError> {
    let text = read_text(&work.join("done.json"), 1 << 16)
        .map_err(|error| nonsense(format!("it ended well before the job was done: {error}")))?;
    serde_json::from_str(&text).map_err(|error| nonsense(format!("done.json: {error}")))
}

impl Given<'_> {
    fn moment(
        &self,
        folder: &Path,
        numbers: &mut Numbers,
        line: &str,
        name: &str,
    ) -> Result<(Snapshot, Option<Vec<Load>>), ProgramError> {
        let of: MomentLine = serde_json::from_str(line)
            .map_err(|error| nonsense(format!("{name}moments.jsonl: {error}")))?;
        let at = format!("{name}stage {} step {}", of.stage.name(), of.step);
        if of.out_of_plane != 0.0 {
            return Err(nonsense(format!("{at}: grains have left the plane")));
        }
        let (bodies, contacts) = match of.contacts {
            Some(count) => {
                let bodies = numbers.bodies(self.bodies, &at)?;
                (bodies, numbers.contacts(count, self.ids, &at)?)
            }
            None => self.tables(folder, of.stage, of.step, &at)?,
        };
        for contact in &contacts {
            self.check_contact(contact, &at)?;
        }
        let punch = of.punch.map(|punch| self.punch(&punch, &at)).transpose()?;
        let snapshot = Snapshot {
            stage: of.stage,
            step: of.step,
            time: of.step as f64 * self.dt,
            bodies,
            contacts,
            punch,
        };
        Ok((snapshot, of.loads))
    }

    /// The tables of a moment as text.
    fn tables(
        &self,
        folder: &Path,
        stage: Stage,
        step: u64,
        at: &str,
    ) -> Result<(Bodies, Vec<Contact>), ProgramError> {
        let table = |what: &str| folder.join(format!("{}-{step}-{what}.csv", stage.name()));
        let broken = |error: text::TableError| nonsense(format!("{at}: {error}"));
        let bodies =
            text::read_bodies(&table("bodies"), self.bodies.len() as u32).map_err(broken)?;
        self.same_grains(&bodies, at)?;
        let contacts = text::read_contacts(&table("contacts"), self.ids).map_err(broken)?;
        Ok((bodies, contacts))
    }

    fn check_contact(&self, of: &Contact, at: &str) -> Result<(), ProgramError> {
        let ordered = of.id1 < of.id2 || !self.ids.is_grain(of.id1);
        if !self.ids.is_grain(of.id2) || !ordered {
            return Err(nonsense(format!(
                "{at}: a contact of {} and {}: of two grains the lower id stands first, a wall or the punch always does",
                of.id1, of.id2
            )));
        }
        if of.overlap < 0.0 {
            return Err(nonsense(format!(
                "{at}: a contact of {} and {} with the overlap {}: only what touches is a contact",
                of.id1, of.id2, of.overlap
            )));
        }
        Ok(())
    }

    fn punch(&self, of: &PunchLine, at: &str) -> Result<Punch, ProgramError> {
        let [x, z] = of.centre;
        let numbers = [x, z, of.start, of.velocity, of.force];
        if !numbers.iter().all(|value| value.is_finite()) {
            return Err(nonsense(format!("{at}: the punch is not finite")));
        }
        Ok(Punch {
            centre: of.centre,
            half_extents: self.half_extents,
            start: of.start,
            velocity: of.velocity,
            force: of.force,
        })
    }

    fn same_grains(&self, bodies: &Bodies, at: &str) -> Result<(), ProgramError> {
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

/// Numbers in the row of a contact.
const CONTACT_COLUMNS: usize = 9;

/// `tables.bin`: the tables of all moments as numbers, read from the front.
struct Numbers {
    path: PathBuf,
    file: Option<BufReader<File>>,
}

impl Numbers {
    fn new(folder: &Path) -> Self {
        Numbers {
            path: folder.join("tables.bin"),
            file: None,
        }
    }

    fn take(&mut self, count: usize, at: &str) -> Result<Vec<f64>, ProgramError> {
        if self.file.is_none() {
            // Asked before opening: opening a pipe would wait for a writer.
            if !self.path.is_file() {
                return Err(nonsense(format!("{at}: there is no tables.bin")));
            }
            let file = File::open(&self.path)
                .map_err(|error| nonsense(format!("{at}: tables.bin: {error}")))?;
            self.file = Some(BufReader::new(file));
        }
        let mut bytes = vec![0; count * 8];
        let all = self.file.as_mut().map(|file| file.read_exact(&mut bytes));
        if !matches!(all, Some(Ok(()))) {
            return Err(nonsense(format!("{at}: tables.bin is cut off")));
        }
        let (eights, _) = bytes.as_chunks::<8>();
        let numbers: Vec<f64> = eights
            .iter()
            .map(|eight| f64::from_le_bytes(*eight))
            .collect();
        match numbers.iter().find(|number| !number.is_finite()) {
            Some(number) => Err(nonsense(format!("{at}: a {number} among its numbers"))),
            None => Ok(numbers),
        }
    }

    /// The grains of the next moment; radii, masses and moments of inertia are those of `start`.
    fn bodies(&mut self, start: &Bodies, at: &str) -> Result<Bodies, ProgramError> {
        let count = start.len();
        Ok(Bodies {
            x: self.take(count, at)?,
            z: self.take(count, at)?,
            vx: self.take(count, at)?,
            vz: self.take(count, at)?,
            radius: start.radius.clone(),
            mass: start.mass.clone(),
            spin: self.take(start.spin.len(), at)?,
            inertia: start.inertia.clone(),
        })
    }

    /// The contacts of the next moment, sorted by ids, normals of length 1.
    fn contacts(
        &mut self,
        count: u64,
        ids: BodyIds,
        at: &str,
    ) -> Result<Vec<Contact>, ProgramError> {
        if count > text::most_contacts(ids.grains) {
            return Err(nonsense(format!("{at}: {count} contacts")));
        }
        let numbers = self.take(count as usize * CONTACT_COLUMNS, at)?;
        let (rows, _) = numbers.as_chunks::<CONTACT_COLUMNS>();
        let contacts: Option<Vec<Contact>> = rows.iter().map(|row| contact(*row, ids)).collect();
        let contacts = contacts
            .ok_or_else(|| nonsense(format!("{at}: a contact between bodies that do not exist")))?;
        let key = |of: &Contact| (of.id1, of.id2);
        if let Some(pair) = contacts.windows(2).find(|of| key(&of[0]) >= key(&of[1])) {
            let [id1, id2] = [pair[1].id1, pair[1].id2];
            return Err(nonsense(format!(
                "{at}: the contact of {id1} and {id2} must stand after the pair of the row before"
            )));
        }
        if let Some(of) = contacts
            .iter()
            .find(|of| (of.normal[0].hypot(of.normal[1]) - 1.0).abs() > text::NORMAL_TOLERANCE)
        {
            return Err(nonsense(format!(
                "{at}: the normal of {} and {} must be of length 1",
                of.id1, of.id2
            )));
        }
        Ok(contacts)
    }

    /// Nothing follows the last moment.
    fn at_end(&mut self, name: &str) -> Result<(), ProgramError> {
        let mut more = [0; 1];
        match self.file.as_mut().map(|file| file.read(&mut more)) {
            None | Some(Ok(0)) => Ok(()),
            _ => Err(nonsense(format!(
                "{name}tables.bin goes on after the last moment"
            ))),
        }
    }
}

/// A contact of its row, if both its ids are those of bodies.
fn contact(row: [f64; CONTACT_COLUMNS], ids: BodyIds) -> Option<Contact> {
    let [
        id1,
        id2,
        overlap,
        normal_force,
        tangential_force,
        nx,
        nz,
        x,
        z,
    ] = row;
    let id = |value: f64| {
        let id = value as u32;
        (f64::from(id) == value && id <= ids.punch()).then_some(id)
    };
    Some(Contact {
        id1: id(id1)?,
        id2: id(id2)?,
        overlap,
        normal_force,
        tangential_force: tangential(tangential_force),
        normal: [nx, nz],
        point: [x, z],
    })
}

/// Checks stages, moments and the engine's own count of steps against the task; else what is wrong.
fn check_completeness(
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
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EndLine {
    end: Stage,
    steps: u64,
    stop: String,
    wall_seconds: f64,
    cpu_seconds: f64,
}

/// How a stage ended, from such a line; else what is wrong with it.
fn end_of_stage(line: &str) -> Result<StageReport, String> {
    let of: EndLine = serde_json::from_str(line).map_err(|error| error.to_string())?;
    let stop = match of.stop.as_str() {
        "settled" => StopReason::Settled,
        "reached" => StopReason::Reached,
        "target_load_not_reached" => StopReason::TargetLoadNotReached,
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
    use StopReason::{MaxSteps, Reached, Settled, StepsDone, TargetLoadNotReached};
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
                (Stage::Load, Reached | TargetLoadNotReached),
            ],
        )
        | (Until::EndOfLoading, Stage::Load, [(Stage::Load, Reached | TargetLoadNotReached)]) => {
            true
        }
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
