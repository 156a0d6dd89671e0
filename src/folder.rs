//! The run folder: what a run leaves behind, and how it is read back without trust.
//!
//! `scene.json`, `run.json`, `initial.csv`, `bodies.csv`, `contacts.csv`, `history.csv`, `trace.csv`,
//! for a run with loading also `settled-bodies.csv` and `settled-contacts.csv`, for YADE `yade.log`.
//! Any of the tables may be packed, with `.gz` after its name.

pub mod record;

use std::path::{Path, PathBuf};

use crate::files::{FileError, read_text, write_folder, write_whole};
use crate::measure::Bed;
use crate::measure::history::HistoryRow;
use crate::scene::{Scene, SceneError, read_scene};
use crate::tables::text::{self, TableError};
use crate::tables::{Bodies, BodyIds, Contact, Snapshot};
use record::{RECORD_VERSION, RunRecord, TraceRow};

/// Grains and contacts at one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    pub bodies: Bodies,
    pub contacts: Vec<Contact>,
}

impl Moment {
    /// For measuring.
    pub fn bed(&self) -> Bed<'_> {
        Bed {
            bodies: &self.bodies,
            contacts: &self.contacts,
        }
    }
}

impl From<Snapshot> for Moment {
    fn from(snapshot: Snapshot) -> Self {
        Moment {
            bodies: snapshot.bodies,
            contacts: snapshot.contacts,
        }
    }
}

/// Everything that a run folder holds.
#[derive(Debug, Clone, PartialEq)]
pub struct RunFolder {
    pub scene: Scene,
    pub record: RunRecord,
    pub initial: Bodies,
    pub settled: Option<Moment>,
    pub last: Moment,
    pub history: Vec<HistoryRow>,
    pub trace: Vec<TraceRow>,
    /// What the engine printed.
    pub log: String,
}

/// A run folder that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error("{path}: {source}")]
    Scene { path: PathBuf, source: SceneError },
    #[error(transparent)]
    Table(#[from] TableError),
    #[error("{path} is not a run folder: {reason}")]
    Inconsistent { path: PathBuf, reason: String },
}

/// The most text that `run.json` may have, bytes.
const LARGEST_RECORD: u64 = 1 << 24;

impl RunFolder {
    /// Writes the folder aside and renames it into place; `path` must not exist.
    pub fn write(&self, path: &Path) -> Result<(), FolderError> {
        write_folder(path, |aside| self.fill(aside))
    }

    /// `settle 42000 steps (settled), load 6435 steps (reached)`
    pub fn stages_in_words(&self) -> String {
        let of = |stage: &crate::engine::StageReport| {
            let stop = serde_json::to_value(stage.stop).unwrap_or_default();
            let stop = stop.as_str().unwrap_or_default().replace('_', " ");
            format!("{} {} steps ({stop})", stage.stage.name(), stage.steps)
        };
        let stages: Vec<String> = self.record.stages.iter().map(of).collect();
        stages.join(", ")
    }

    fn fill(&self, folder: &Path) -> Result<(), FolderError> {
        let json = |name: &str, text: serde_json::Result<String>| {
            let path = folder.join(name);
            match text {
                Ok(text) => Ok(write_whole(&path, (text + "\n").as_bytes())?),
                Err(error) => Err(FolderError::Inconsistent {
                    path,
                    reason: error.to_string(),
                }),
            }
        };
        json("scene.json", serde_json::to_string_pretty(&self.scene))?;
        text::write_bodies(&folder.join("initial.csv"), &self.initial)?;
        text::write_bodies(&folder.join("bodies.csv"), &self.last.bodies)?;
        text::write_contacts(&folder.join("contacts.csv"), &self.last.contacts)?;
        if let Some(settled) = &self.settled {
            text::write_bodies(&folder.join("settled-bodies.csv"), &settled.bodies)?;
            text::write_contacts(&folder.join("settled-contacts.csv"), &settled.contacts)?;
        }
        text::write_rows(&folder.join("history.csv"), self.history.iter())?;
        text::write_rows(&folder.join("trace.csv"), self.trace.iter())?;
        if !self.log.is_empty() {
            write_whole(&folder.join("yade.log"), self.log.as_bytes())?;
        }
        json("run.json", serde_json::to_string_pretty(&self.record))
    }

    /// Reads a folder and checks that its parts belong together.
    pub fn read(path: &Path) -> Result<Self, FolderError> {
        let wrong = |reason: String| FolderError::Inconsistent {
            path: path.to_owned(),
            reason,
        };
        let record_path = path.join("run.json");
        let record_text = read_text(&record_path, LARGEST_RECORD)?;
        let record: RunRecord = serde_json::from_str(&record_text)
            .map_err(|error| wrong(format!("run.json: {error}")))?;
        if record.version != RECORD_VERSION {
            return Err(wrong(format!(
                "run.json has version {}, this program reads version {RECORD_VERSION}",
                record.version
            )));
        }
        let scene_path = path.join("scene.json");
        let scene = read_scene(&scene_path).map_err(|source| FolderError::Scene {
            path: scene_path,
            source,
        })?;
        if scene.digest() != record.scene_digest {
            return Err(wrong("scene.json is not the scene of run.json".to_owned()));
        }
        let count = scene.particles.count;
        let bodies_in = |name: &str| -> Result<Bodies, FolderError> {
            let bodies = text::read_bodies(&packed(path, name))?;
            if bodies.len() != count as usize {
                return Err(wrong(format!(
                    "{name} has {} grains, the scene {count}",
                    bodies.len()
                )));
            }
            Ok(bodies)
        };
        let contacts_in = |name: &str| {
            let bodies = BodyIds { grains: count }.punch() + 1;
            text::read_contacts(&packed(path, name), bodies)
        };
        let initial = bodies_in("initial.csv")?;
        if initial.digest() != record.initial_digest {
            return Err(wrong("initial.csv is not the start of run.json".to_owned()));
        }
        let last = Moment {
            bodies: bodies_in("bodies.csv")?,
            contacts: contacts_in("contacts.csv")?,
        };
        let settled = if packed(path, "settled-bodies.csv").is_file() {
            Some(Moment {
                bodies: bodies_in("settled-bodies.csv")?,
                contacts: contacts_in("settled-contacts.csv")?,
            })
        } else {
            None
        };
        let history: Vec<HistoryRow> = text::read_rows(&packed(path, "history.csv"))?;
        let at_end = history.last().map(|row| row.state.as_str());
        if at_end != Some(last.bodies.digest().as_str()) {
            return Err(wrong(
                "the last row of history.csv is not the state in bodies.csv".to_owned(),
            ));
        }
        let log_path = packed(path, "yade.log");
        let log = if log_path.is_file() {
            read_text(&log_path, LARGEST_RECORD)?
        } else {
            String::new()
        };
        Ok(RunFolder {
            trace: text::read_rows(&packed(path, "trace.csv"))?,
            scene,
            record,
            initial,
            settled,
            last,
            history,
            log,
        })
    }
}

/// The table under its name or packed.
fn packed(folder: &Path, name: &str) -> PathBuf {
    let plain = folder.join(name);
    let packed = folder.join(format!("{name}.gz"));
    if !plain.exists() && packed.exists() {
        packed
    } else {
        plain
    }
}
