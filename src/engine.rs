//! Engines that are programs of their own: YADE, LAMMPS, LIGGGHTS, and those of users.

mod describe;
pub mod exec;
mod job;
pub mod read;
pub mod watch;
pub mod yade;

use std::path::PathBuf;

use crate::exit;
use crate::files::FileError;
use grains::native::{NativeError, Trouble};
use grains::tables::Stage;

/// An engine did not finish.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    /// Our own.
    #[error(transparent)]
    Native(#[from] NativeError),
    /// Any other.
    #[error(transparent)]
    Program(#[from] ProgramError),
}

impl EngineError {
    /// The exit code of the command that needed the engine.
    pub fn exit_code(&self) -> u8 {
        match self {
            EngineError::Native(_) if self.is_interruption() => exit::TRY_AGAIN,
            EngineError::Native(_) => exit::ENGINE_FAILED,
            EngineError::Program(error) => error.exit_code(),
        }
    }

    /// Whether a signal ended it.
    pub fn is_interruption(&self) -> bool {
        match self {
            EngineError::Native(error) => error.trouble == Trouble::Interrupted,
            EngineError::Program(error) => matches!(error, ProgramError::Interrupted),
        }
    }
}

/// An engine that is a program did not give a run that can be used.
#[derive(Debug, thiserror::Error)]
pub enum ProgramError {
    /// It is not installed.
    #[error(
        "{engine} is missing: {reason}; on Debian 12 install it with `apt-get install --no-install-recommends {package}`"
    )]
    Missing {
        engine: &'static str,
        reason: String,
        package: &'static str,
    },
    #[error(
        "the engine {path} cannot be started: {reason}; after exec: comes the path of an executable file (chmod +x, \
         and an interpreter in its first line if it is a script)"
    )]
    NotStarted { path: PathBuf, reason: String },
    #[error("YADE {found} is too old: this driver needs {}.{:02} or later, as in Debian 12", oldest.0, oldest.1)]
    TooOld { found: String, oldest: (u32, u32) },
    #[error(
        "`{path} describe` did not say what the engine is: {reason}; it must print one JSON object, see \
         docs/engine-protocol.md"
    )]
    Undescribed { path: PathBuf, reason: String },
    #[error(
        "the engine speaks version {found} of the protocol, and this program speaks {}; take the engine that fits, or \
         change it (docs/engine-protocol.md)",
        exec::PROTOCOL
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
    #[error(
        "the engine hung: {reason}; it was ended (--stall-limit and --time-limit give it longer). The end of what it \
         printed:\n{log}"
    )]
    Hung { reason: String, log: String },
    #[error(
        "the engine took {reason}; it was ended (--memory-limit and --output-limit give it more)"
    )]
    TooMuch { reason: String },
    #[error(
        "{path} was replaced while it ran, so nobody can say which program made the run; start the command again"
    )]
    Changed { path: PathBuf },
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

impl ProgramError {
    /// The exit code of the command that needed the engine.
    pub fn exit_code(&self) -> u8 {
        match self {
            ProgramError::Unsupported { .. } | ProgramError::NotStarted { .. } => exit::USAGE,
            ProgramError::File(_) | ProgramError::Interrupted => exit::TRY_AGAIN,
            _ => exit::ENGINE_FAILED,
        }
    }

    /// Whether the engine is not installed here, or too old.
    pub fn is_missing(&self) -> bool {
        matches!(
            self,
            ProgramError::Missing { .. } | ProgramError::TooOld { .. }
        )
    }

    /// Whether the engine ran and failed, which it may not do another time.
    pub fn is_failure(&self) -> bool {
        matches!(
            self,
            ProgramError::Crashed { .. }
                | ProgramError::Hung { .. }
                | ProgramError::TooMuch { .. }
                | ProgramError::Nonsense(_)
        )
    }
}

/// What was written is not what a run writes.
fn nonsense(reason: impl Into<String>) -> ProgramError {
    ProgramError::Nonsense(reason.into())
}
