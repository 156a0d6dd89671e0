//! Engines that people bring: any program that follows `docs/engine-protocol.md`. It says what it has, is asked for
//! that only, and is believed only what its tables prove.

mod child;
mod describe;
mod job;
mod parts;
pub mod read;

use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::engine::watch::{Done, Limits};
use crate::files::{FileError, file_digest};
use grains::case::Case;
use grains::native::Trouble;
use grains::scene::Scene;
use grains::tables::{Snapshot, Stage};
use grains::task::{Observer, Outcome, Task};

pub use child::log;
pub use describe::{Description, describe};
pub use parts::{Part, missing_for_case, missing_for_scene};

/// The version of the protocol that this program speaks.
pub const PROTOCOL: u32 = 1;

/// A program that is an engine, and how far it may go.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// The program, as it was named.
    pub program: PathBuf,
    /// How far it may go.
    pub limits: Limits,
}

impl Options {
    /// With the usual limits.
    pub fn new(program: PathBuf) -> Self {
        Options {
            program,
            limits: Limits {
                time: Duration::from_secs(4 * 3600),
                stall: Duration::from_secs(120),
                memory: 4 << 30,
                output: 16 << 30,
            },
        }
    }
}

/// A program that was asked what it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Brought {
    /// The program.
    pub options: Options,
    /// What it says of itself.
    pub description: Description,
}

impl Brought {
    /// Asks it.
    pub fn ask(options: Options) -> Result<Self, ExecError> {
        Ok(Brought {
            description: describe(&options)?,
            options,
        })
    }

    /// SHA-256 of the program's file.
    pub fn digest(&self) -> Result<String, ExecError> {
        Ok(file_digest(&self.options.program)?)
    }
}

/// The engine did not give a run that can be used.
#[derive(Debug, thiserror::Error)]
pub enum ExecError {
    #[error(
        "the engine {path} cannot be started: {reason}; after exec: comes the path of an executable file (chmod +x, \
         and an interpreter in its first line if it is a script)"
    )]
    Missing { path: PathBuf, reason: String },
    #[error(
        "`{path} describe` did not say what the engine is: {reason}; it must print one JSON object, see \
         docs/engine-protocol.md"
    )]
    Undescribed { path: PathBuf, reason: String },
    #[error(
        "the engine speaks version {found} of the protocol, and this program speaks {}; take the engine that fits, or \
         change it (docs/engine-protocol.md)",
        PROTOCOL
    )]
    OtherProtocol { found: u64 },
    #[error("{engine} has no {}; {hint}", missing.join(", "))]
    Unsupported {
        engine: String,
        missing: Vec<String>,
        hint: &'static str,
    },
    #[error("the engine refused: {0}")]
    Refused(String),
    #[error("the engine ended with {status}; the end of what it printed:\n{log}")]
    Crashed { status: String, log: String },
    #[error("the engine hung: {reason}; it was ended. The end of what it printed:\n{log}")]
    Hung { reason: String, log: String },
    #[error("the engine took {reason}; it was ended")]
    TooMuch { reason: String },
    #[error("the engine was ended, as asked; start the command again")]
    Interrupted,
    #[error("the engine wrote nonsense: {0}")]
    Nonsense(String),
    #[error("the engine's run went wrong, seen in step {step} of stage {}: {trouble}", .stage.name())]
    WentWrong {
        stage: Stage,
        step: u64,
        trouble: Trouble,
    },
    #[error(transparent)]
    File(#[from] FileError),
}

/// What was written is not what a run writes.
fn nonsense(reason: impl Into<String>) -> ExecError {
    ExecError::Nonsense(reason.into())
}

/// A finished run of an engine.
#[derive(Debug)]
pub struct ExecRun {
    /// Stages and last moment.
    pub outcome: Outcome,
    /// What the engine is.
    pub description: Description,
    /// What it wrote on its standard output and error.
    pub log: String,
    /// What the job took, its start and its tables included, as this program has seen it.
    pub took: Done,
}

/// Runs the task. `work` is an empty folder on a disk with room for about 2 MB a moment of history.
pub fn run(
    scene: &Scene,
    task: &Task,
    options: &Options,
    work: &Path,
    observer: &mut dyn Observer,
) -> Result<ExecRun, ExecError> {
    run_brought(scene, task, &Brought::ask(options.clone())?, work, observer)
}

/// Runs the task in an engine that was asked what it is before.
pub fn run_brought(
    scene: &Scene,
    task: &Task,
    Brought {
        options,
        description,
    }: &Brought,
    work: &Path,
    observer: &mut dyn Observer,
) -> Result<ExecRun, ExecError> {
    let missing = missing_for_scene(description, scene, task);
    if !missing.is_empty() {
        return Err(unsupported(description, missing, HINT_SCENE));
    }
    job::write_scene(work, scene, task)?;
    let took = child::run(options, work, observer)?;
    let outcome = read::scene(work, scene, task, observer)?;
    Ok(ExecRun {
        outcome,
        description: description.clone(),
        log: log(work),
        took,
    })
}

const HINT_SCENE: &str = "take an engine that has it, a scene that does not ask for it, or a shorter part of the run \
                          (--steps N, --until settled)";
const HINT_CASES: &str = "these experiments ask for it";

fn unsupported(description: &Description, missing: Vec<Part>, hint: &'static str) -> ExecError {
    ExecError::Unsupported {
        engine: description.name.clone(),
        missing: missing
            .iter()
            .map(|part| part.in_words().to_owned())
            .collect(),
        hint,
    }
}

/// What an engine made of a case: the states at its moments, or why it refused.
pub type CaseResult = Result<Vec<Snapshot>, String>;

/// Runs the cases in one start of the engine, in order; `work` is an empty folder. Every case must ask only for what the
/// engine has ([`missing_for_case`]).
pub fn run_cases(
    cases: &[&Case],
    description: &Description,
    options: &Options,
    work: &Path,
    observer: &mut dyn Observer,
) -> Result<Vec<CaseResult>, ExecError> {
    let mut missing: Vec<Part> = cases
        .iter()
        .flat_map(|case| missing_for_case(description, case))
        .collect();
    missing.sort();
    missing.dedup();
    if !missing.is_empty() {
        return Err(unsupported(description, missing, HINT_CASES));
    }
    job::write_cases(work, cases)?;
    child::run(options, work, observer)?;
    read::cases(work, cases)
}
