//! Reading back what an engine wrote, trusting none of it: every count, id, step and number is checked before it
//! becomes a table. Both forms of tables, text and numbers (`docs/engine-protocol.md`), are read here and nowhere else.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::exec::case_folder;
use super::{ProgramError, Result, ensure, nonsense, parsed, read_json};
use crate::files::{FileError, Place, read_text, regular};
use crate::tables as text;
use grains::model::Model;
use grains::native::check_moment;
use grains::native::timing::{Share, Window};
use grains::scene::Scene;
use grains::tables::{
    Across, Bodies, BodyIds, Contact, Memories, Punch, Snapshot, Stage, StopReason, tangential,
};
use grains::task::{
    Case, Effective, Load, Observer, Outcome, Seen, StageReport, Task, Until, moments,
};

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

#[derive(Debug, Clone, PartialEq)]
pub struct CaseRun {
    pub track: Vec<Snapshot>,
    /// Force and torque summed on each grain at each moment, where it tells them.
    pub loads: Vec<Vec<Load>>,
    /// The parameters that it says it uses, where it tells them.
    pub effective: Option<Effective>,
}

/// The most that an engine may say of its parameters, bytes, and for each grain with its contacts.
const LONGEST_PARAMETERS: u64 = 1 << 20;
const LONGEST_OF_GRAIN: u64 = 1 << 12;
/// The longest line that can end a stage or refuse a job, bytes.
const LONGEST_WORD: usize = 1 << 16;

/// A height that is given back is the same within this share, also in single precision and in other units.
const SAME_START: f64 = 1.0e-5;

/// Grains and contacts of a moment, and what contacts have besides in space.
type Tables = (Bodies, (Vec<Contact>, Vec<Across>));

/// The moments of a job, which are checked against the start that the engine was given.
struct Moments<'a> {
    folder: &'a Path,
    /// What messages begin with: a case, or nothing.
    name: &'a str,
    bodies: &'a Bodies,
    ids: BodyIds,
    half_extents: [f64; 2],
    /// Where the punch's bottom was when loading began, if that was told, m.
    started: Option<f64>,
    dt: f64,
    /// Whether adhesion holds contacts beyond their surfaces.
    holds: bool,
    /// `tables.bin`: the tables of all moments as numbers, read from the front.
    numbers: Option<BufReader<File>>,
}

/// Reads all moments of a scene in order, shows them to the observer and returns the outcome.
pub fn scene(
    work: &Path,
    scene: &Scene,
    task: &Task,
    observer: &mut dyn Observer,
) -> Result<Outcome> {
    let start = &task.start.bodies;
    let half_extents = [scene.loading.half_width, 0.5 * scene.loading.punch_height];
    let mut moments = Moments::of(work, "", &Model::of(scene), start, half_extents);
    moments.started = task.start.punch.map(|punch| punch.start);
    moments.holds |= Model::in_stage(scene, Stage::Load).law.holds();
    let list = moments.list()?.map_err(ProgramError::Refused)?;
    let mut stages: Vec<StageReport> = Vec::new();
    let mut settled = None;
    let mut last: Option<Snapshot> = None;
    let mut seen: Vec<(Stage, u64)> = Vec::new();
    for line in list.lines() {
        if has_key(line, "end") {
            let report = end_of_stage(line)?;
            if report.stop == StopReason::Settled {
                settled.clone_from(&last);
            }
            stages.push(report);
            continue;
        }
        let (snapshot, _) = moments.read(line)?;
        let is_start = || snapshot.bodies.digest() == start.digest();
        ensure(!seen.is_empty() || is_start(), || {
            "its first moment is not the start that it was given; write the grains of initial.csv as they are, digit by digit"
                .to_owned()
        })?;
        check_moment(&snapshot, &scene.container).map_err(|trouble| ProgramError::WentWrong {
            stage: snapshot.stage,
            step: snapshot.step,
            trouble,
        })?;
        seen.push((snapshot.stage, snapshot.step));
        observer.snapshot(&snapshot);
        last = Some(snapshot);
    }
    moments.at_end()?;
    let last = last.ok_or_else(|| nonsense("moments.jsonl has not one moment of the run"))?;
    let DoneFile { steps: counted } = done(work)?;
    check_stages(task, &stages)?;
    check_moments(scene, task, &stages, &seen)?;
    let own = |stage: &StageReport| stage.steps.saturating_sub(first_step(task, stage.stage));
    let steps: u64 = stages.iter().map(own).sum();
    ensure(counted == steps, || {
        format!("it counts {counted} steps, its stages have {steps}")
    })?;
    // A bed that was settled at the very end of a run without loading is its last moment anyway.
    let loaded = stages.iter().any(|stage| stage.stage == Stage::Load);
    Ok(Outcome {
        settled: settled.filter(|_| loaded),
        stages,
        last,
        seen: Seen::default(),
    })
}

pub fn cases(work: &Path, cases: &[&Case]) -> Result<Vec<Result<CaseRun, String>>> {
    let mut results = Vec::with_capacity(cases.len());
    let mut steps = 0;
    for (index, case) in cases.iter().enumerate() {
        let result = read_case(&case_folder(work, index), case)?;
        if result.is_ok() {
            steps += case.moments.last().copied().unwrap_or(0);
        }
        results.push(result);
    }
    let DoneFile { steps: counted } = done(work)?;
    ensure(counted == steps, || {
        format!("done.json counts {counted} steps, its cases have {steps}")
    })?;
    Ok(results)
}

fn read_case(folder: &Path, case: &Case) -> Result<Result<CaseRun, String>> {
    let name = format!("case {}: ", case.name);
    let half_extents = case.punch.map_or([0.0; 2], |punch| punch.half_extents);
    let mut moments = Moments::of(folder, &name, &case.model, &case.bodies, half_extents);
    moments.started = case.punch.map(|punch| punch.start);
    let list = match moments.list()? {
        Ok(list) => list,
        Err(reason) => return Ok(Err(reason)),
    };
    let place = Place::from((folder, "effective.json"));
    let named = format!("{name}effective.json");
    let longest = LONGEST_PARAMETERS + LONGEST_OF_GRAIN * case.bodies.len() as u64;
    let read = || read_json(place, longest, &named);
    let effective = place.is_taken().then(read).transpose()?;
    let mut track = Vec::with_capacity(case.moments.len());
    let mut loads = Vec::new();
    let mut lines = list.lines();
    for &step in &case.moments {
        let ends = || nonsense(format!("{name}moments.jsonl ends before step {step}"));
        let line = lines.next().ok_or_else(ends)?;
        let (moment, of_moment) = moments.read(line)?;
        let found = (moment.stage, moment.step);
        ensure(found == (Stage::Settle, step), || {
            let (stage, at) = (found.0.name(), found.1);
            format!("{name}step {at} of stage {stage} where step {step} of stage settle should be")
        })?;
        let rows = of_moment.as_ref().map_or(case.bodies.len(), Vec::len);
        ensure(rows == case.bodies.len(), || {
            format!("{name}loads of other grains")
        })?;
        track.push(moment);
        loads.extend(of_moment);
    }
    moments.at_end()?;
    ensure(lines.next().is_none(), || {
        format!("{name}moments.jsonl goes on after its last moment")
    })?;
    Ok(Ok(CaseRun {
        track,
        loads,
        effective,
    }))
}

/// Steps before, in and after a timed window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimedSteps {
    pub warm_up: u64,
    pub timed: u64,
    /// Afterwards, with the engine's own account of its parts.
    pub shares: u64,
    /// On so many processes or threads, where the engine has them.
    pub processes: u32,
}

/// A bed whose steps an engine has timed by its own clock.
#[derive(Debug)]
pub struct Timed {
    pub window: Window,
    /// The bed after warm-up and window.
    pub last: Snapshot,
    /// Largest resident memory of its process up to the end of the window, bytes, where it tells.
    pub peak_memory: Option<u64>,
    /// Its own account of its parts; empty where it gives none.
    pub shares: Vec<Share>,
}

impl Timed {
    /// Without an account of memory and parts.
    pub fn plain(window: Window, last: Snapshot) -> Self {
        Timed {
            window,
            last,
            peak_memory: None,
            shares: Vec::new(),
        }
    }
}

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
pub fn timed(work: &Path, model: &Model, start: &Bodies, steps: TimedSteps) -> Result<Timed> {
    let mut moments = Moments::of(work, "", model, start, [0.0; 2]);
    let list = moments.list()?.map_err(ProgramError::Refused)?;
    let (last, _) = moments.read(list.trim_end())?;
    moments.at_end()?;
    let (after, at) = (steps.warm_up + steps.timed, last.step);
    ensure(at == after, || {
        format!("step {at} where step {after} should be")
    })?;
    let done: TimedDone = done(work)?;
    let (asked, counted) = (after + steps.shares, done.steps);
    ensure(counted == asked, || {
        format!("done.json counts {counted} steps, {asked} were asked for")
    })?;
    let times = done.wall_seconds > 0.0 && done.cpu_seconds.is_none_or(|seconds| seconds > 0.0);
    ensure(times, || "times that are not above zero".to_owned())?;
    let total: f64 = done
        .shares
        .iter()
        .map(|share| share.nanoseconds as f64)
        .sum();
    let shares = done.shares.into_iter().map(|share| Share {
        share: share.nanoseconds as f64 / total,
        stage: share.name,
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

/// Whether a line is an object with this key, at any place in it.
fn has_key(line: &str, key: &str) -> bool {
    type Object = serde_json::Map<String, serde_json::Value>;
    line.len() <= LONGEST_WORD
        && line.contains(key)
        && serde_json::from_str::<Object>(line).is_ok_and(|object| object.contains_key(key))
}

/// `done.json`, with the engine's own count of steps.
fn done<T: DeserializeOwned>(work: &Path) -> Result<T> {
    let text = read_text((work, "done.json"), 1 << 16)
        .map_err(|error| nonsense(format!("it ended well before the job was done: {error}")))?;
    parsed(&text, "done.json")
}

impl<'a> Moments<'a> {
    fn of(
        folder: &'a Path,
        name: &'a str,
        model: &Model,
        bodies: &'a Bodies,
        half_extents: [f64; 2],
    ) -> Self {
        Moments {
            folder,
            name,
            bodies,
            ids: BodyIds {
                grains: bodies.len() as u32,
                walls: model.walls_and_obstacles(),
            },
            half_extents,
            started: None,
            dt: model.dt,
            holds: model.law.holds(),
            numbers: None,
        }
    }

    /// The lines of `moments.jsonl`, or why it refused the job.
    fn list(&self) -> Result<Result<String, String>> {
        let list = read_text((self.folder, "moments.jsonl"), LONGEST_LIST);
        let list = list.map_err(|error| {
            let why = "it ended well, but its list of moments is not there";
            nonsense(format!("{}{why}: {error}", self.name))
        })?;
        if !has_key(&list, "refused") {
            return Ok(Ok(list));
        }
        let line: RefusedLine = parsed(list.trim_end(), "moments.jsonl")?;
        Ok(Err(line.refused.chars().take(400).collect()))
    }

    /// The moment of this line, with what it says of forces and torques.
    fn read(&mut self, line: &str) -> Result<(Snapshot, Option<Vec<Load>>)> {
        let name = self.name;
        let moment: MomentLine = parsed(line, &format!("{name}moments.jsonl"))?;
        let at = format!("{name}stage {} step {}", moment.stage.name(), moment.step);
        ensure(moment.out_of_plane == 0.0, || {
            format!("{at}: grains have left the plane")
        })?;
        let (bodies, (contacts, across)) = match moment.contacts {
            Some(count) => (self.next_bodies(&at)?, self.next_contacts(count, &at)?),
            None => self.tables(moment.stage, moment.step, &at)?,
        };
        for contact in &contacts {
            self.check_contact(contact, &at)?;
        }
        let punch = moment
            .punch
            .map(|punch| self.punch(&punch, &at))
            .transpose()?;
        let snapshot = Snapshot {
            stage: moment.stage,
            step: moment.step,
            time: moment.step as f64 * self.dt,
            bodies,
            contacts,
            across,
            memory: Memories::default(),
            punch,
        };
        Ok((snapshot, moment.loads))
    }

    /// The tables of a moment as text.
    fn tables(&self, stage: Stage, step: u64, at: &str) -> Result<Tables> {
        let name = |what: &str| format!("{}-{step}-{what}.csv", stage.name());
        // By its name in the job's folder: that is moved or removed before anybody reads this.
        let place = format!("{}/", self.folder.display());
        let broken = |error: FileError| {
            let error = error.to_string().replace(&place, "");
            nonsense(format!("{at}: {error}"))
        };
        let bodies = text::read_bodies((self.folder, &name("bodies")), self.ids.grains);
        let bodies = bodies.map_err(broken)?;
        self.same_grains(&bodies, at)?;
        let contacts = text::read_contacts((self.folder, &name("contacts")), self.ids);
        let contacts = contacts.map_err(broken)?;
        Ok((bodies, contacts))
    }

    fn check_contact(&self, contact: &Contact, at: &str) -> Result<()> {
        let ordered = contact.id1 < contact.id2 || !self.ids.is_grain(contact.id1);
        let pair = || format!("{at}: a contact of {} and {}", contact.id1, contact.id2);
        ensure(self.ids.is_grain(contact.id2) && ordered, || {
            format!(
                "{}: of two grains the lower id stands first, a wall or the punch always does",
                pair()
            )
        })?;
        ensure(contact.overlap >= 0.0 || self.holds, || {
            let (pair, overlap) = (pair(), contact.overlap);
            format!("{pair} with the overlap {overlap}: only what touches is a contact")
        })
    }

    fn punch(&self, punch: &PunchLine, at: &str) -> Result<Punch> {
        let [x, z] = punch.centre;
        let numbers = [x, z, punch.start, punch.velocity, punch.force];
        let finite = numbers.iter().all(|value| value.is_finite());
        ensure(finite, || format!("{at}: the punch is not finite"))?;
        let given = self.started.unwrap_or(punch.start);
        let near = SAME_START * (given.abs() + self.half_extents[1]);
        ensure((punch.start - given).abs() <= near, || {
            let start = punch.start;
            format!("{at}: punch.start is {start:e} m, and the job says {given:e} m")
        })?;
        Ok(Punch {
            centre: punch.centre,
            half_extents: self.half_extents,
            start: punch.start,
            velocity: punch.velocity,
            force: punch.force,
        })
    }

    fn same_grains(&self, bodies: &Bodies, at: &str) -> Result<()> {
        let (found, wanted) = (bodies.len(), self.bodies.len());
        ensure(found == wanted, || {
            format!("{at}: {found} grains instead of {wanted}")
        })?;
        ensure(bodies.in_space() == self.bodies.in_space(), || {
            format!("{at}: the columns y and vy are for grains in space, and for those always")
        })?;
        ensure(bodies.rotate() == self.bodies.rotate(), || {
            format!(
                "{at}: the columns spin and inertia are for grains that rotate, and for those always"
            )
        })?;
        let same = bodies.radius == self.bodies.radius
            && bodies.mass == self.bodies.mass
            && bodies.inertia == self.bodies.inertia
            && bodies.material == self.bodies.material;
        ensure(same, || {
            format!(
                "{at}: other radii, masses or moments of inertia than in initial.csv; write them as they were given"
            )
        })
    }

    /// The next numbers of `tables.bin`.
    fn take(&mut self, count: usize, at: &str) -> Result<Vec<f64>> {
        if self.numbers.is_none() {
            let file = regular((self.folder, "tables.bin"));
            let file = file.map_err(|error| nonsense(format!("{at}: tables.bin: {error}")))?;
            self.numbers = Some(BufReader::new(file));
        }
        let mut bytes = vec![0; count * 8];
        let file = self.numbers.as_mut();
        let all = file.map(|file| file.read_exact(&mut bytes));
        ensure(matches!(all, Some(Ok(()))), || {
            format!("{at}: tables.bin is cut off")
        })?;
        let (eights, _) = bytes.as_chunks::<8>();
        let numbers = eights.iter().map(|eight| f64::from_le_bytes(*eight));
        let numbers: Vec<f64> = numbers.collect();
        match numbers.iter().find(|number| !number.is_finite()) {
            Some(number) => Err(nonsense(format!("{at}: a {number} among its numbers"))),
            None => Ok(numbers),
        }
    }

    /// The grains of the next moment; radii, masses and moments of inertia are those of the start.
    fn next_bodies(&mut self, at: &str) -> Result<Bodies> {
        let (start, count) = (self.bodies, self.bodies.len());
        Ok(Bodies {
            x: self.take(count, at)?,
            z: self.take(count, at)?,
            vx: self.take(count, at)?,
            vz: self.take(count, at)?,
            radius: start.radius.clone(),
            mass: start.mass.clone(),
            spin: self.take(start.spin.len(), at)?,
            inertia: start.inertia.clone(),
            y: self.take(start.y.len(), at)?,
            vy: self.take(start.vy.len(), at)?,
            spin_x: self.take(start.spin_x.len(), at)?,
            spin_z: self.take(start.spin_z.len(), at)?,
            material: start.material.clone(),
        })
    }

    /// The contacts of the next moment, sorted by ids, normals of length 1, and what they have besides in space.
    fn next_contacts(&mut self, count: u64, at: &str) -> Result<(Vec<Contact>, Vec<Across>)> {
        let ids = self.ids;
        let few = count <= text::most_contacts(ids.grains);
        ensure(few, || format!("{at}: {count} contacts"))?;
        let further = if self.bodies.in_space() {
            ACROSS_COLUMNS
        } else {
            0
        };
        let columns = CONTACT_COLUMNS + further;
        let numbers = self.take(count as usize * columns, at)?;
        let rows = numbers.chunks_exact(columns);
        let planar = rows.clone().filter_map(|row| row.first_chunk());
        let contacts: Option<Vec<Contact>> = planar.map(|row| contact(*row, ids)).collect();
        let contacts = contacts
            .ok_or_else(|| nonsense(format!("{at}: a contact between bodies that do not exist")))?;
        let across = rows.filter_map(|row| row[CONTACT_COLUMNS..].first_chunk());
        let across: Vec<Across> = across.map(|row| in_space(*row)).collect();
        for pair in contacts.windows(2) {
            let (id1, id2) = pair[1].ids();
            ensure(pair[0].ids() < (id1, id2), || {
                format!(
                    "{at}: the contact of {id1} and {id2} must stand after the pair of the row before"
                )
            })?;
        }
        let mut ys = across.iter().map(|across| across.normal);
        for contact in &contacts {
            let planar = contact.normal[0].hypot(contact.normal[1]);
            let off = (planar.hypot(ys.next().unwrap_or(0.0)) - 1.0).abs();
            let (id1, id2) = contact.ids();
            ensure(off <= text::NORMAL_TOLERANCE, || {
                format!("{at}: the normal of {id1} and {id2} must be of length 1")
            })?;
        }
        Ok((contacts, across))
    }

    /// Nothing follows the last moment.
    fn at_end(&mut self) -> Result<()> {
        let mut more = [0; 1];
        let rest = self.numbers.as_mut().map(|file| file.read(&mut more));
        ensure(matches!(rest, None | Some(Ok(0))), || {
            format!("{}tables.bin goes on after the last moment", self.name)
        })
    }
}

const CONTACT_COLUMNS: usize = 9;

/// Further ones in space.
const ACROSS_COLUMNS: usize = 5;

fn in_space([normal, point, tangential @ ..]: [f64; ACROSS_COLUMNS]) -> Across {
    Across {
        normal,
        point,
        tangential,
    }
}

/// A contact of its row, if both its ids are those of bodies.
fn contact(row: [f64; CONTACT_COLUMNS], ids: BodyIds) -> Option<Contact> {
    let [id1, id2, overlap, along, across, nx, nz, x, z] = row;
    let id = |value: f64| {
        let id = value as u32;
        (f64::from(id) == value && id <= ids.punch()).then_some(id)
    };
    Some(Contact {
        id1: id(id1)?,
        id2: id(id2)?,
        overlap,
        normal_force: along,
        tangential_force: tangential(across),
        normal: [nx, nz],
        point: [x, z],
    })
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

/// How a stage ended, from such a line.
fn end_of_stage(line: &str) -> Result<StageReport> {
    let end: EndLine = parsed(line, "moments.jsonl")?;
    ensure(end.stop != "not_finite", || {
        let (step, stage) = (end.steps, end.end.name());
        format!("moments.jsonl: numbers that are not finite in step {step} of stage {stage}")
    })?;
    let stop = serde_json::from_value(end.stop.as_str().into());
    let stop =
        stop.map_err(|_| nonsense(format!("moments.jsonl: the stop reason {:?}", end.stop)))?;
    ensure(end.wall_seconds >= 0.0 && end.cpu_seconds >= 0.0, || {
        "moments.jsonl: times that are below 0 or none".to_owned()
    })?;
    Ok(StageReport {
        stage: end.end,
        steps: end.steps,
        stop,
        wall_seconds: end.wall_seconds,
        cpu_seconds: end.cpu_seconds,
    })
}

/// Every moment that the scene asks for, in order, and no other.
fn check_moments(
    scene: &Scene,
    task: &Task,
    stages: &[StageReport],
    seen: &[(Stage, u64)],
) -> Result<()> {
    let every = scene.measurement.history_every;
    // A count that somebody made up is not counted through.
    let most = seen.len() as u64;
    for StageReport { stage, steps, .. } in stages {
        ensure(steps / every <= most + task.start.step / every, || {
            let stage = stage.name();
            format!(
                "stage {stage} of {steps} steps has more moments than the {most} that there are"
            )
        })?;
    }
    let of_stage = |report: &StageReport| {
        let (stage, from) = (report.stage, first_step(task, report.stage));
        let steps = moments(from, report.steps.max(from), every).into_iter();
        steps.map(move |step| (stage, step))
    };
    let wanted: Vec<(Stage, u64)> = stages.iter().flat_map(of_stage).collect();
    let odd = wanted.iter().zip(seen).position(|(want, see)| want != see);
    let at = odd.unwrap_or(wanted.len().min(seen.len()));
    let moment = |moment: Option<&(Stage, u64)>| {
        moment.map_or("none".to_owned(), |(stage, step)| {
            format!("{} {step}", stage.name())
        })
    };
    ensure(wanted == seen, || {
        let (wanted, seen) = (moment(wanted.get(at)), moment(seen.get(at)));
        format!("moment {at} of the run should be {wanted} and is {seen}")
    })
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
fn check_stages(task: &Task, stages: &[StageReport]) -> Result<()> {
    use Stage::{Load, Settle};
    use StopReason::{MaxSteps, Reached, Settled, StepsDone, TargetLoadNotReached};
    let ends: Vec<(Stage, StopReason)> = stages
        .iter()
        .map(|stage| (stage.stage, stage.stop))
        .collect();
    let ended = match (task.until, ends.as_slice()) {
        (Until::Step(step), [(_, StepsDone)]) => {
            let done = stages[0].steps;
            ensure(done == step, || {
                format!("{step} steps were asked for and {done} were done")
            })?;
            true
        }
        (Until::EndOfSettling, [(Settle, stop)]) => matches!(stop, Settled | MaxSteps),
        (Until::EndOfLoading, [(Settle, stop)]) => *stop == MaxSteps,
        (Until::EndOfLoading, [(Load, stop)] | [(Settle, Settled), (Load, stop)]) => {
            matches!(stop, Reached | TargetLoadNotReached)
        }
        _ => false,
    };
    let begun = ends.first().map(|(stage, _)| *stage);
    let fits = ended && begun == Some(task.start.stage);
    let in_words = |stage: &StageReport| format!("{} {:?}", stage.stage.name(), stage.stop);
    let stages: Vec<String> = stages.iter().map(in_words).collect();
    ensure(fits, || match &stages[..] {
        [] => "its stages are not those of the task: none was finished".to_owned(),
        some => format!("its stages are not those of the task: {}", some.join(", ")),
    })
}
