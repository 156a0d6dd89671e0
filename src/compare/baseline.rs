//! Baselines: the checks of a run, kept under a name to hold later runs against. Only an explicit command changes one.

pub mod checks;
pub mod diff;
mod document;
mod pace;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::checks::record::{Record, RecordError};
use crate::files::{FileError, failed, read_text, sha256_hex, write_whole};

/// The version of a baseline's file.
const VERSION: u32 = 1;

/// Longest file that is read, bytes.
const LONGEST: u64 = 200_000_000;

/// Longest name.
const LONGEST_NAME: usize = 100;

/// A run's checks under a name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Baseline {
    /// Version of this format.
    pub baseline: u32,
    /// As it was saved.
    pub name: String,
    /// SHA-256 of the record that it was made from.
    pub source: String,
    /// The record without what is the job's own.
    pub record: Record,
}

/// What can go wrong with a baseline.
#[derive(Debug, thiserror::Error)]
pub enum BaselineError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error(transparent)]
    Record(#[from] RecordError),
    #[error(
        "{0:?} is no name for a baseline: letters, digits, '.', '_' and '-', at most {LONGEST_NAME}, not beginning with '.'"
    )]
    Name(String),
    #[error("there is a baseline {name} in {store} already; --replace puts this run in its place")]
    Exists { name: String, store: String },
    #[error("there is no baseline {name} in {store}; {there}")]
    Missing {
        name: String,
        store: String,
        there: String,
    },
    #[error("{path} is no baseline: {reason}; save it again from a run")]
    Malformed { path: String, reason: String },
}

/// The folder of baselines.
#[derive(Debug, Clone)]
pub struct Store(PathBuf);

impl Store {
    /// In this folder, which need not exist.
    pub fn new(folder: &Path) -> Self {
        Store(folder.to_owned())
    }

    fn path(&self, name: &str) -> Result<PathBuf, BaselineError> {
        let plain = |letter: char| letter.is_ascii_alphanumeric() || "._-".contains(letter);
        let sound = !name.is_empty()
            && name.len() <= LONGEST_NAME
            && !name.starts_with('.')
            && name.chars().all(plain);
        if !sound {
            return Err(BaselineError::Name(name.to_owned()));
        }
        Ok(self.0.join(format!("{name}.json")))
    }

    /// Keeps the record of a finished job; a baseline of that name stays as it is unless it is to be replaced.
    pub fn save(&self, record: &Path, name: &str, replace: bool) -> Result<PathBuf, BaselineError> {
        let path = self.path(name)?;
        if path.exists() && !replace {
            return Err(BaselineError::Exists {
                name: name.to_owned(),
                store: self.0.display().to_string(),
            });
        }
        let text = read_text(record, LONGEST)?;
        let baseline = Baseline {
            baseline: VERSION,
            name: name.to_owned(),
            source: sha256_hex(text.as_bytes()),
            record: crate::checks::record::read(record)?,
        };
        let text =
            serde_json::to_string_pretty(&baseline).map_err(|error| BaselineError::Malformed {
                path: record.display().to_string(),
                reason: error.to_string(),
            })?;
        std::fs::create_dir_all(&self.0).map_err(failed("create", &self.0))?;
        write_whole(&path, (text + "\n").as_bytes())?;
        Ok(path)
    }

    /// The baseline of this name.
    pub fn load(&self, name: &str) -> Result<Baseline, BaselineError> {
        let path = self.path(name)?;
        if !path.exists() {
            let names = self.names()?;
            return Err(BaselineError::Missing {
                name: name.to_owned(),
                store: self.0.display().to_string(),
                there: match names.as_slice() {
                    [] => {
                        "there are none yet; crossgrain report baseline save makes one".to_owned()
                    }
                    names => format!("there are {}", names.join(", ")),
                },
            });
        }
        let malformed = |reason: String| BaselineError::Malformed {
            path: path.display().to_string(),
            reason,
        };
        let baseline: Baseline = serde_json::from_str(&read_text(&path, LONGEST)?)
            .map_err(|error| malformed(error.to_string()))?;
        if baseline.baseline != VERSION {
            return Err(malformed(format!(
                "version {} of the format, where this program knows {VERSION}",
                baseline.baseline
            )));
        }
        Ok(baseline)
    }

    /// The names of all baselines, in order; none where there is no such folder.
    pub fn names(&self) -> Result<Vec<String>, BaselineError> {
        let entries = match std::fs::read_dir(&self.0) {
            Ok(entries) => entries,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(error) => return Err(failed("read", &self.0)(error).into()),
        };
        let mut names = Vec::new();
        for entry in entries {
            let path = entry.map_err(failed("read", &self.0))?.path();
            let json = path.extension().is_some_and(|end| end == "json");
            if let (true, Some(name)) = (json, path.file_stem().and_then(|name| name.to_str())) {
                names.push(name.to_owned());
            }
        }
        names.sort();
        Ok(names)
    }
}
