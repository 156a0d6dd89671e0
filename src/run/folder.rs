//! The run folder: what a run leaves behind, and how it is read back without trust; and a scene as a file.
//!
//! `scene.json`, `run.json`, `initial.csv`, `bodies.csv`, `contacts.csv`, `history.csv`, `trace.csv`,
//! for a run with loading also `settled-bodies.csv` and `settled-contacts.csv`, of contacts with friction `memory.csv` and
//! `settled-memory.csv`, for YADE `yade.log`, for an external engine
//! `engine.log`. Any of the tables may be packed, with `.gz` after its name. `SHA256SUMS` has the digest of each file as it was
//! written; a file with another one is not read.

pub mod record;

use std::collections::BTreeSet;
use std::fmt::Display;
use std::path::Path;
use std::sync::LazyLock;

use crate::engine::EngineRecord;
use flate2::read::GzDecoder;
use record::{Protocol, RECORD_VERSION, Restart, RunRecord, TraceRow};
use serde::Deserialize;

use crate::files::{
    FileError, Place, file_digest, listed, read_text, sha256_hex, unpacked_digest, write_folder,
    write_whole, written_digest,
};
use crate::stl;
use crate::tables::{self as text, Rows};
use grains::measure::{self, Bed, HistoryRow, Quantity};
use grains::model::{Model, rotates};
use grains::scene::{Mesh, Scene, SceneError, parse_scene, parse_scene_with};
use grains::tables::{Across, Bodies, BodyIds, Contact, Memories, Snapshot, Stage, StopReason};
use grains::task::{StageReport, moments};

/// Grains and contacts at one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    pub bodies: Bodies,
    /// All contacts, sorted by ids.
    pub contacts: Vec<Contact>,
    /// What they have besides in space, in the same order.
    pub across: Vec<Across>,
    /// What they remember, in the same order; empty without friction, and of engines that do not tell.
    pub memory: Memories,
}

impl Moment {
    pub fn bed(&self) -> Bed<'_> {
        Bed {
            bodies: &self.bodies,
            contacts: &self.contacts,
            across: &self.across,
        }
    }
}

impl From<Snapshot> for Moment {
    fn from(snapshot: Snapshot) -> Self {
        Moment {
            bodies: snapshot.bodies,
            contacts: snapshot.contacts,
            across: snapshot.across,
            memory: snapshot.memory,
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct RunFolder {
    pub scene: Scene,
    pub record: RunRecord,
    pub initial: Bodies,
    pub settled: Option<Moment>,
    pub last: Moment,
    pub history: Vec<HistoryRow>,
    pub trace: Vec<TraceRow>,
    pub log: String,
}

fn not_a_run(path: &Path, reason: impl Display) -> FileError {
    let path = path.display();
    FileError::Unfit(format!("{path} is not a run folder: {reason}"))
}

/// What is wrong with the scene of this file.
pub fn bad_scene(path: &Path, error: &SceneError) -> FileError {
    FileError::Unfit(format!("{}: {error}", path.display()))
}

/// Files of a run folder, and what they are: `files.json`, read.
pub static FILES: LazyLock<Vec<(&str, &str)>> = LazyLock::new(|| {
    serde_json::from_str(include_str!("folder/files.json"))
        .expect("it is a list of names and words")
});

/// The digests of the other files, as `sha256sum` writes and checks them.
pub const SUMS: &str = "SHA256SUMS";
/// The most text of [`SUMS`], bytes.
const LARGEST_SUMS: u64 = 1 << 16;
/// The file of the record.
pub const RECORD: &str = "run.json";
/// The most text that `run.json` may have, bytes.
const LARGEST_RECORD: u64 = 1 << 24;
/// The most rows of history that a run may have.
const MOST_MOMENTS: u64 = 1 << 20;
const MOST_MARKED: u64 = 200;

/// Looked at before the rest, which another version may not have.
#[derive(Deserialize)]
struct Versioned {
    version: u32,
}

impl RunFolder {
    /// Its measures, made anew from its tables, and how long its stages took.
    pub fn quantities(&self) -> Vec<Quantity> {
        let settled = self.settled.as_ref().map(Moment::bed);
        let mut quantities = measure::all(&self.scene, settled, self.last.bed());
        let mut add = |key: String, value: f64, unit: &str| {
            quantities.push(Quantity {
                key,
                value,
                unit: unit.to_owned(),
            });
        };
        for stage in &self.record.stages {
            let key = format!("{}.steps", stage.stage.name());
            add(key, stage.steps as f64, "1");
        }
        if let Some(last) = self.history.last() {
            if let Some(depth) = last.punch_depth {
                add("load.punch_depth".to_owned(), depth, "m");
            }
            if let Some(force) = last.punch_force {
                add("load.punch_force".to_owned(), force, "N");
            }
        }
        quantities
    }

    /// Writes the folder aside and renames it into place; `path` must not exist.
    pub fn write(&self, path: &Path) -> Result<(), FileError> {
        write_folder(path, |aside| self.fill(aside))
    }

    /// `settle 42000 steps (settled), load 6435 steps (reached)`
    pub fn stages_in_words(&self) -> String {
        stages_in_words(&self.record.stages)
    }

    fn fill(&self, folder: &Path) -> Result<(), FileError> {
        let json = |name: &str, text: serde_json::Result<String>| {
            let text = text.map_err(|error| not_a_run(&folder.join(name), error))?;
            write_whole((folder, name), (text + "\n").as_bytes())
        };
        json("scene.json", serde_json::to_string_pretty(&self.scene))?;
        text::write_bodies((folder, "initial.csv"), &self.initial)?;
        let moments = [("", Some(&self.last)), ("settled-", self.settled.as_ref())];
        for (prefix, moment) in moments {
            let Some(moment) = moment else { continue };
            let name = |name: &str| format!("{prefix}{name}.csv");
            text::write_bodies((folder, &name("bodies")), &moment.bodies)?;
            text::write_contacts(
                (folder, &name("contacts")),
                &moment.contacts,
                &moment.across,
            )?;
            if !moment.memory.is_empty() {
                text::write_memory((folder, &name("memory")), &moment.memory)?;
            }
        }
        let (history, trace) = (self.history.iter(), self.trace.iter());
        text::write_rows((folder, "history.csv"), HistoryRow::HEADER, history)?;
        text::write_rows((folder, "trace.csv"), TraceRow::HEADER, trace)?;
        if !self.log.is_empty() {
            let name = match self.record.engine {
                EngineRecord::Exec { .. } => "engine.log",
                EngineRecord::Native { .. } | EngineRecord::Yade { .. } => "yade.log",
            };
            write_whole((folder, name), self.log.as_bytes())?;
        }
        json(RECORD, serde_json::to_string_pretty(&self.record))?;
        write_sums(folder)
    }

    /// Reads a folder and checks that its parts belong together and that the run came to its end.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let run = RunFolder::read_so_far(path)?;
        match run.record.stop() {
            Some(StopReason::Interrupted) => Err(FileError::Unfit(format!(
                "{0} is a run that was asked to end; first go on with crossgrain run SCENE --engine native --from-state {0} --out DIR",
                path.display()
            ))),
            _ => Ok(run),
        }
    }

    /// The same, also of a run that was asked to end.
    pub fn read_so_far(path: &Path) -> Result<Self, FileError> {
        let wrong = |reason: String| not_a_run(path, reason);
        if !Place::from((path, RECORD)).is_taken() {
            return Err(wrong(without(path, RECORD)));
        }
        check_sums(path)?;
        let record_text = read_text((path, RECORD), LARGEST_RECORD)?;
        let broken = |error: serde_json::Error| wrong(format!("run.json: {error}"));
        let Versioned { version } = serde_json::from_str(&record_text).map_err(broken)?;
        if version != RECORD_VERSION {
            return Err(wrong(format!(
                "run.json has version {version}, this program reads version {RECORD_VERSION}"
            )));
        }
        let record: RunRecord = serde_json::from_str(&record_text).map_err(broken)?;
        let scene = read_own_scene((path, "scene.json"))?;
        let ensure = |holds: bool, otherwise: &str| match holds {
            true => Ok(()),
            false => Err(wrong(otherwise.to_owned())),
        };
        let same = scene.digest() == record.scene_digest;
        ensure(same, "scene.json is not the scene of run.json")?;
        let same = record.time_step.to_bits() == scene.time_step_seconds().to_bits();
        ensure(same, "the time step of run.json is not the scene's")?;
        let count = scene.particles.count;
        let bodies_in = |name: &str| -> Result<Bodies, FileError> {
            let bodies = text::read_bodies((path, &packed(path, name)), count)?;
            let (found, wanted) = (bodies.len(), count as usize);
            let otherwise = format!("{name} has {found} grains, the scene {count}");
            ensure(found == wanted, &otherwise).map(|()| bodies)
        };
        let initial = bodies_in("initial.csv")?;
        let same = initial.digest() == record.initial_digest;
        ensure(same, "initial.csv is not the start of run.json")?;
        let same = initial.in_space() == scene.in_space();
        ensure(
            same,
            "initial.csv and scene.json do not agree on whether grains are in space",
        )?;
        let same = initial.rotate() == rotates(&scene);
        let why = "initial.csv and scene.json do not agree on whether grains rotate";
        ensure(same, why)?;
        let moment_in = |prefix: &str| -> Result<Moment, FileError> {
            let bodies = bodies_in(&format!("{prefix}bodies.csv"))?;
            let same = bodies.radius == initial.radius
                && bodies.mass == initial.mass
                && bodies.inertia == initial.inertia;
            let why = "has other radii, masses or moments of inertia than initial.csv";
            ensure(same, &format!("{prefix}bodies.csv {why}"))?;
            let contacts = packed(path, &format!("{prefix}contacts.csv"));
            let ids = BodyIds {
                grains: bodies.len() as u32,
                walls: Model::of(&scene).walls_and_obstacles(),
            };
            let (contacts, across) = text::read_contacts((path, &contacts), ids)?;
            let of_grains = contacts.iter().all(|contact| contact.id2 < count);
            let why = "has a contact whose second body is no grain";
            ensure(of_grains, &format!("{prefix}contacts.csv {why}"))?;
            let memory = packed(path, &format!("{prefix}memory.csv"));
            let memory = match Place::from((path, &memory)).is_taken() {
                true => text::read_memory((path, &memory), &contacts, &across)?,
                false => Memories::default(),
            };
            Ok(Moment {
                bodies,
                contacts,
                across,
                memory,
            })
        };
        let last = moment_in("")?;
        let loaded = record.stages.iter().any(|stage| stage.stage == Stage::Load);
        let settled = loaded.then(|| moment_in("settled-")).transpose()?;
        let every = scene.measurement.history_every;
        let rows = record.stages.iter();
        let rows = rows.map(|stage| (stage.steps / every).saturating_add(2));
        let rows = rows.fold(0, u64::saturating_add);
        let otherwise = format!("its stages have {rows} moments of history");
        ensure(rows <= MOST_MOMENTS, &otherwise)?;
        let mut wanted = all_moments(&record.stages, every).into_iter();
        let mut history: Vec<HistoryRow> = Vec::new();
        for row in Rows::open((path, &packed(path, "history.csv")), rows)? {
            let row: HistoryRow = row?;
            if let Some(why) = not_finite(&row) {
                return Err(wrong(why));
            }
            ensure(wanted.next() == Some((row.stage, row.step)), OTHER_MOMENTS)?;
            history.push(row);
        }
        ensure(wanted.next().is_none(), OTHER_MOMENTS)?;
        let mut trace: Vec<TraceRow> = Vec::new();
        for row in Rows::open((path, &packed(path, "trace.csv")), rows * MOST_MARKED)? {
            let row: TraceRow = row?;
            let (id, key) = (row.id, |row: &TraceRow| (row.stage, row.step, row.id));
            let finite = (row.x + row.z).is_finite();
            let otherwise = format!("trace.csv has a place of grain {id} that is not finite");
            ensure(finite, &otherwise)?;
            let is_later = trace.last().is_none_or(|last| key(last) < key(&row));
            ensure(
                is_later && id < count,
                "trace.csv is not in the order of its moments and grains",
            )?;
            trace.push(row);
        }
        let logs = ["yade.log", "engine.log"].map(|name| packed(path, name));
        let log = logs
            .into_iter()
            .find(|log| Place::from((path, log)).is_taken());
        let log = log.map(|log| read_text((path, &log), LARGEST_RECORD));
        let log = log.transpose()?;
        let run = RunFolder {
            scene,
            record,
            initial,
            settled,
            last,
            history,
            trace,
            log: log.unwrap_or_default(),
        };
        run.history_fits().map_err(wrong)?;
        Ok(run)
    }

    /// The states of the history at the start, at the settled bed and at the end are those of the tables.
    fn history_fits(&self) -> Result<(), String> {
        let state_at = |stage: Stage, first: bool| {
            let mut rows = self.history.iter().filter(|row| row.stage == stage);
            let row = if first { rows.next() } else { rows.next_back() };
            row.map(|row| row.state.as_str())
        };
        let first = state_at(Stage::Settle, true);
        let mut ties = vec![("initial.csv", first, &self.initial)];
        if let Some(Moment { bodies, .. }) = &self.settled {
            let table = "settled-bodies.csv";
            ties.push((table, state_at(Stage::Settle, false), bodies));
            ties.push((table, state_at(Stage::Load, true), bodies));
        }
        let at_end = self.history.last().map(|row| row.state.as_str());
        ties.push(("bodies.csv", at_end, &self.last.bodies));
        for (table, state, bodies) in ties {
            if state != Some(bodies.digest().as_str()) {
                return Err(format!(
                    "history.csv has another state than {table} at its moment"
                ));
            }
        }
        let last = self.history.last();
        if let Some(Restart { punch, .. }) = self.record.restart
            && last.map(|row| (row.punch_depth, row.punch_force))
                != Some((
                    punch.map(|punch| punch.depth()),
                    punch.map(|punch| punch.force),
                ))
        {
            return Err("history.csv has another punch than run.json at the end".to_owned());
        }
        Ok(())
    }
}

/// That the longest run that the scene's rules allow can be read back: asked before it is run.
pub fn has_room_for_history(scene: &Scene, protocol: Protocol) -> Result<(), FileError> {
    let every = scene.measurement.history_every;
    let loading = &scene.loading;
    let stride = loading.speed * scene.time_step_seconds();
    let sinking = (loading.give_up_depth / stride).ceil() as u64;
    let load = sinking.saturating_add(scene.steps_standing_still().unwrap_or(0));
    let [settle, load] = match protocol {
        Protocol::Steps { steps } => [steps, 0],
        Protocol::Settled => [scene.settle.max_steps, 0],
        Protocol::Whole => [scene.settle.max_steps, load],
    };
    let rows = (settle / every)
        .saturating_add(load / every)
        .saturating_add(4);
    match rows > MOST_MOMENTS {
        true => Err(FileError::Unfit(format!(
            "the run could have {rows} moments of history, and a run folder has at most {MOST_MOMENTS}: raise \
             /measurement/history_every, which is {every}, or lower /settle/max_steps"
        ))),
        false => Ok(()),
    }
}

const OTHER_MOMENTS: &str = "history.csv has not the moments of the stages in run.json";

/// Every moment of the history of these stages.
fn all_moments(stages: &[StageReport], every: u64) -> Vec<(Stage, u64)> {
    let moments = stages.iter().flat_map(|stage| {
        let steps = moments(0, stage.steps, every).into_iter();
        steps.map(|step| (stage.stage, step))
    });
    moments.collect()
}

/// Where a row of history has no number in its place.
pub fn not_finite(row: &HistoryRow) -> Option<String> {
    let at = || format!("{} {}", row.stage.name(), row.step);
    (!row.is_finite()).then(|| format!("history.csv has a number that is not finite at {}", at()))
}

/// Each file of a run that is there, plain or packed.
fn present(folder: &Path) -> impl Iterator<Item = String> {
    let names = FILES
        .iter()
        .flat_map(|(name, ..)| [(*name).to_owned(), format!("{name}.gz")]);
    names.filter(move |name| Place::from((folder, name)).is_taken())
}

/// A line of [`SUMS`].
pub fn sum_line(digest: &str, name: &str) -> String {
    format!("{digest}  {name}\n")
}

/// Writes the digests of the files that are there.
pub fn write_sums(folder: &Path) -> Result<(), FileError> {
    let mut sums = String::new();
    for name in present(folder) {
        sums += &sum_line(&written_digest((folder, &name))?, &name);
    }
    write_whole((folder, SUMS), sums.as_bytes())
}

/// As many entries of a folder are looked at.
const MOST_LISTED: usize = 10_000;

/// Why a folder without this file is no run folder, and what may have been meant.
fn without(folder: &Path, name: &str) -> String {
    if !Place::from(folder).is_taken() {
        return "there is no such folder".to_owned();
    }
    let inside = listed(folder, MOST_LISTED).unwrap_or_default();
    let is_run = |path: &Path| [SUMS, RECORD].map(|name| Place::from((path, name)).is_file());
    let runs = inside
        .iter()
        .filter(|entry| is_run(&entry.path) == [true; 2]);
    let runs: Vec<String> = runs.map(|entry| entry.path.display().to_string()).collect();
    match runs.is_empty() {
        true => format!("it has no {name}; `crossgrain run` writes one"),
        false => format!(
            "it holds run folders; name one of them: {}",
            runs.join(", ")
        ),
    }
}

/// Every file that is listed is there and as it was written, and every file that a run may have is listed.
fn check_sums(folder: &Path) -> Result<(), FileError> {
    let wrong = |reason: String| not_a_run(folder, reason);
    if !Place::from((folder, SUMS)).is_taken() {
        return Err(wrong(without(folder, SUMS)));
    }
    let text = read_text((folder, SUMS), LARGEST_SUMS)?;
    let mut listed = BTreeSet::new();
    for line in text.split_inclusive('\n') {
        let parts = line
            .strip_suffix('\n')
            .and_then(|line| line.split_once("  "));
        // A name is obeyed only where it stays in the folder.
        let parts = parts.filter(|(_, name)| !name.starts_with('.') && !name.contains('/'));
        let Some((digest, name)) = parts else {
            return Err(wrong(format!(
                "{SUMS} has a line that is no digest and name: {line:?}"
            )));
        };
        let there = packed(folder, name);
        let (path, place) = (folder.join(&there), Place::from((folder, &there)));
        if !place.is_taken() {
            return Err(wrong(format!("{name} is in {SUMS} and not in the folder")));
        }
        // Who packs a table afterwards leaves its text as it is.
        let found = match there == name {
            true => file_digest(place)?,
            false => unpacked_digest(place)?,
        };
        if found != digest {
            return Err(FileError::Unfit(format!(
                "{} was changed after it was written: {SUMS} has another digest; put back what was there, or run it again",
                path.display()
            )));
        }
        listed.insert(name);
    }
    // A packed table counts for the plain one only where that is not there.
    let is_packed = |name: &str| {
        let plain = name.strip_suffix(".gz");
        plain.is_some_and(|plain| listed.contains(plain) && packed(folder, plain) == name)
    };
    let is_listed = |name: &str| listed.contains(name) || is_packed(name);
    match present(folder).find(|name| !is_listed(name)) {
        Some(name) => Err(wrong(format!("{name} is in the folder and not in {SUMS}"))),
        None => Ok(()),
    }
}

/// The name of a table, packed where only that is there.
pub fn packed(folder: &Path, name: &str) -> String {
    let packed = format!("{name}.gz");
    let is_taken = |name: &str| Place::from((folder, name)).is_taken();
    match !is_taken(name) && is_taken(&packed) {
        true => packed,
        false => name.to_owned(),
    }
}

/// A scene file larger than this is not one of ours.
const LARGEST_SCENE: u64 = 1 << 22;

/// The scene of a run, which has its triangles in itself.
fn read_own_scene<'a>(place: impl Into<Place<'a>>) -> Result<Scene, FileError> {
    let place = place.into();
    let text = read_text(place, LARGEST_SCENE)?;
    parse_scene(&text).map_err(|error| bad_scene(&place.path(), &error))
}

/// A scene with the triangles of the files that it names.
pub fn read_scene(path: &Path) -> Result<Scene, FileError> {
    let text = read_text(path, LARGEST_SCENE)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let triangles = |mesh: &Mesh| stl::triangles(folder, mesh);
    parse_scene_with(&text, &triangles).map_err(|error| bad_scene(path, &error))
}

/// The folder that the recorded run of YADE is unpacked into, which is carried in the program. `reference_data/README.md` says
/// how it was made.
pub const RECORDED: &str = "yade-recorded";

macro_rules! recorded_files {
    ($($name:literal),* $(,)?) => {
        &[$((
            $name,
            include_bytes!(concat!("../../reference_data/yade-paper-1/", $name)) as &[u8],
        )),*]
    };
}

const RECORDED_FILES: &[(&str, &[u8])] = recorded_files![
    "run.json",
    "scene.json",
    "initial.csv.gz",
    "bodies.csv.gz",
    "contacts.csv.gz",
    "settled-bodies.csv.gz",
    "settled-contacts.csv.gz",
    "history.csv.gz",
    "trace.csv.gz",
    "yade.log",
    "SHA256SUMS",
];

pub fn unpack_recorded(folder: &Path) -> Result<(), FileError> {
    write_folder(folder, |aside| {
        for (name, bytes) in RECORDED_FILES {
            write_whole((aside, name), bytes)?;
        }
        Ok::<(), FileError>(())
    })
}

pub fn recorded_history() -> Result<Vec<HistoryRow>, FileError> {
    let wanted = "history.csv.gz";
    let packed = RECORDED_FILES.iter().find(|(name, _)| *name == wanted);
    let bytes = packed.map_or(&[] as &[u8], |(_, bytes)| *bytes);
    Rows::of(wanted.as_ref(), Box::new(GzDecoder::new(bytes)))?.collect()
}

/// Whether a folder holds exactly the recorded run.
pub fn is_recorded(folder: &Path) -> bool {
    RECORDED_FILES.iter().all(|(name, bytes)| {
        file_digest((folder, *name)).is_ok_and(|found| found == sha256_hex(bytes))
    })
}

/// `settle 42000 steps (settled), load 6435 steps (reached)`.
pub fn stages_in_words(stages: &[StageReport]) -> String {
    let in_words = |stage: &StageReport| {
        let stop = serde_json::to_value(stage.stop).expect("a word is JSON");
        let stop = stop.as_str().expect("a word").replace('_', " ");
        format!("{} {} steps ({stop})", stage.stage.name(), stage.steps)
    };
    let stages: Vec<String> = stages.iter().map(in_words).collect();
    stages.join(", ")
}
