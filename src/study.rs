//! Many runs, written down one by one. A study is a plan with tasks from 1 to N; each task gives a row; a judge makes
//! checks and a document of the rows.
//!
//! A type that is the study's plan implements [`Study`]: how many tasks there are, what one of them depends on
//! ([`Study::identity`]), how its row is made ([`Study::run`]) and what the rows together say ([`Study::judge`]). It is
//! registered in `cli/study.rs` (an arm of `open`) and in `cli/study/plan.rs` (the options of `study plan KIND`, which end in
//! [`create`]). Everything else comes with it:
//!
//! - [`plan`]: `plan.json` with kind, version, the source digest of the physics, the study's own plan, and a digest;
//! - [`store`]: rows on the disk, each line with a check, which files only grow; [`shard`]: who makes which rows;
//! - [`folder`]: running (threads, progress, resume, engines that fail), status, merging, reading, reuse of another
//!   plan's rows; [`slurm`]: job arrays; and the record with its checks and document.
//!
//! A task is a number; the plan says what it means. Where tasks share work (one bed, loaded in ten ways), the task is the
//! shared work, and its row is a list. What is random or timed may stand in a row; [`Study::same`] says then which rows
//! are of one result. An engine that fails is an error of [`Study::run`], and the row is tried again at the next start; a
//! study for which that is a result makes a row of it. Grown plans go on by reuse: `study plan … --reuse DIR`.
//!
//! The physics' source is part of every row's check: a plan is run only by the program that made it, and rows of an
//! older kernel are never mixed with new ones.

pub mod answer;
pub mod campaign;
pub mod candidates;
pub mod change;
pub mod claims;
pub mod conventions;
pub mod figures;
pub mod folder;
pub mod member;
pub mod plan;
pub mod realization;
pub mod search;
pub mod shard;
pub mod slurm;
pub mod store;
pub mod tradeoff;

use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::{Path, PathBuf};

use crate::checks::Measured;
use crate::checks::record::{Record, malformed};
use crate::document::Document;
use crate::engine::EngineError;
use crate::exit;
use crate::files::{FileError, remove_folder};
use crate::study::folder::StudyFolder;
use plan::{Plan, Program};
use realization::{Engines, Runner};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// What is run many times, and what it says; the value is the study's own plan.
pub trait Study: Serialize + DeserializeOwned + Sync + Sized {
    /// In `plan.json` and commands: `campaign`.
    const KIND: &'static str;
    type Row: Serialize + DeserializeOwned + PartialEq + Send;

    /// How many tasks; they are numbered from 1.
    fn count(&self) -> u64;

    /// What is wrong with the plan, which may have been read from a file.
    fn check(&self) -> Result<(), String>;

    fn runner(&self, task: u64) -> Runner;

    /// Whether its beds are of spheres.
    fn in_space(&self) -> bool {
        false
    }

    /// Everything in the plan that the task's row depends on, in words or a digest: tasks of two plans with the same
    /// identity have the same row.
    fn identity(&self, task: u64) -> String;

    /// Makes the row. `work` is an empty folder for an engine that is another program. The row may depend on nothing but
    /// the plan and the task.
    fn run(&self, task: u64, engines: &Engines, work: &Path) -> Result<Self::Row, EngineError>;

    /// Whether the row says that it is of this task.
    fn belongs(&self, _task: u64, _row: &Self::Row) -> bool {
        true
    }

    /// Whether two rows of a task are the same result.
    fn same(first: &Self::Row, second: &Self::Row) -> bool {
        first == second
    }

    /// What merging counts and writes into the table.
    fn outline(&self, row: &Self::Row) -> Outline;

    /// What the rows that are there say; [`StudyFolder::each`] has them.
    fn judge(folder: &StudyFolder<Self>) -> Result<Judged, StudyError>;
}

/// A row in short.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// Engine and version, where all rows must be of one engine and this one has told it.
    pub engine: Option<String>,
    pub ending: &'static str,
    /// Columns of `rows.csv` with their values.
    pub cells: Vec<(String, String)>,
}

impl Outline {
    /// Of no engine of its own; what was measured stands after the other cells.
    pub fn new<const N: usize>(
        ending: &'static str,
        cells: [(&str, String); N],
        measured: &BTreeMap<String, f64>,
    ) -> Self {
        let cells = cells.map(|(name, value)| (name.to_owned(), value));
        let measured = measured.iter();
        let measured = measured.map(|(key, value)| (key.clone(), format!("{value:?}")));
        Outline {
            engine: None,
            ending,
            cells: cells.into_iter().chain(measured).collect(),
        }
    }
}

#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    #[error(
        "the rows of {path} are not merged yet; `crossgrain study run` makes those that are missing and merges them"
    )]
    NotMerged { path: PathBuf },
    #[error(
        "{path} was planned with crossgrain {planned}, and this is {present}, which may give other bits; go on with the \
         program that planned it, or plan a new study"
    )]
    OtherProgram {
        path: PathBuf,
        planned: String,
        present: String,
    },
    #[error(
        "rows {rows} are missing, {missing} of {wanted}; run `crossgrain study run` on the folder, then merge"
    )]
    Incomplete {
        /// The first few, for people.
        rows: String,
        missing: u64,
        wanted: u64,
    },
    /// Rows that cannot be of one result.
    #[error("{0}")]
    Contradiction(String),
    /// The folder, the plan or the engine is not what it must be.
    #[error("{0}")]
    Usage(String),
    #[error(
        "{finished} rows are written down; for rows {rows} the engine failed, the first with: {first}"
    )]
    EnginesFailed {
        finished: u64,
        rows: String,
        first: String,
    },
    #[error(
        "asked to end; {finished} of {wanted} rows are written down, start the command again to go on"
    )]
    Interrupted { finished: u64, wanted: u64 },
    #[error(transparent)]
    Engine(#[from] EngineError),
    #[error(transparent)]
    File(#[from] FileError),
}

impl StudyError {
    /// A folder that holds none that can be used.
    pub fn not_a_study(path: &Path, reason: impl Display) -> Self {
        let path = path.display();
        StudyError::Usage(format!(
            "{path} is no study that can be used: {reason}; `crossgrain study plan` makes one"
        ))
    }

    /// Another engine than the plan's.
    fn other_engine(path: &Path) -> Self {
        let path = path.display();
        StudyError::Usage(format!(
            "the engine {path} is not the program that was planned; put that one back, name it with --engine exec:PATH, or \
             plan a new study"
        ))
    }

    pub fn exit_code(&self) -> u8 {
        match self {
            StudyError::OtherProgram { .. } | StudyError::Usage(_) => exit::USAGE,
            StudyError::Interrupted { .. } => exit::TRY_AGAIN,
            StudyError::NotMerged { .. } | StudyError::Incomplete { .. } => exit::INCOMPLETE,
            StudyError::Contradiction(_) => exit::CHECK_FAILED,
            StudyError::EnginesFailed { .. } => exit::ENGINE_FAILED,
            StudyError::Engine(error) => error.exit_code(),
            StudyError::File(error) => error.exit_code(),
        }
    }
}

/// Plans a study in a folder that must not exist, and takes over what another one of its kind has of its rows; how many.
pub fn create<S: Study>(
    path: &Path,
    study: S,
    program: Option<Program>,
    reuse: Option<&Path>,
) -> Result<u64, StudyError> {
    Plan::new(study, program)?.write(path)?;
    let Some(from) = reuse else {
        return Ok(0);
    };
    let reused = StudyFolder::<S>::open(path).and_then(|folder| folder.reuse(from));
    if reused.is_err() {
        // Else the same command, mended, would be refused for the folder that this one left.
        remove_folder(path)?;
    }
    reused
}

pub const RECORD: &str = "report.json";

/// What a judge says.
#[derive(Debug)]
pub struct Judged {
    /// The study's own record, a JSON object.
    pub own: Value,
    /// Numbers that only a baseline judges.
    pub measured: Vec<Measured>,
    /// With the study's checks; the machine adds one that no row is missing, and the verdict.
    pub document: Document,
}

impl Judged {
    pub fn of(kind: &str, record: &impl Serialize, document: Document) -> Result<Self, StudyError> {
        let broken = |error| malformed(&format!("the record of {kind}"), error);
        let own = serde_json::to_value(record).map_err(broken)?;
        Ok(Judged {
            own,
            measured: Vec::new(),
            document,
        })
    }
}

/// What is written and shown.
#[derive(Debug)]
pub struct Report {
    pub text: String,
    /// The same, as all jobs have it.
    pub record: Record,
    pub document: Document,
}
