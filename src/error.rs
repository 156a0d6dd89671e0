//! Every way in which the program can fail, and its exit code.

use crate::checks::record::RecordError;
use crate::compare::baseline::BaselineError;
use crate::compare::baseline::history::BisectError;
use crate::engine::{EngineError, ProgramError};
use crate::files::FileError;
use crate::run::KeptError;
use crate::run::folder::FolderError;
use crate::study::StudyError;
use crate::tables::TableError;
use grains::native::NativeError;

pub use crate::exit;

/// Any failure of the program.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error(transparent)]
    Folder(#[from] FolderError),
    #[error(transparent)]
    Engine(#[from] EngineError),
    #[error(transparent)]
    File(#[from] FileError),
    #[error("cannot write to the output: {0}")]
    Output(#[from] std::io::Error),
    #[error("{0}")]
    Usage(String),
    #[error("asked to end; start the command again")]
    Interrupted,
    /// What there is was kept.
    #[error("{0}")]
    Stopped(String),
    #[error("the report cannot be made: {0}")]
    Report(String),
    #[error(transparent)]
    Study(#[from] StudyError),
    #[error(transparent)]
    Record(#[from] RecordError),
}

impl From<NativeError> for Error {
    fn from(error: NativeError) -> Self {
        Error::Engine(error.into())
    }
}

impl From<ProgramError> for Error {
    fn from(error: ProgramError) -> Self {
        Error::Engine(error.into())
    }
}

impl From<TableError> for Error {
    fn from(error: TableError) -> Self {
        match error {
            TableError::File(error) => Error::File(error),
            other => ProgramError::Nonsense(other.to_string()).into(),
        }
    }
}

impl From<KeptError> for Error {
    fn from(error: KeptError) -> Self {
        match error {
            KeptError::Engine(error) => Error::Engine(error),
            KeptError::Folder(error) => Error::Folder(error),
            KeptError::File(error) => Error::File(error),
            other @ KeptError::NotResumed { .. } => Error::Usage(other.to_string()),
            other @ KeptError::Interrupted { .. } => Error::Stopped(other.to_string()),
        }
    }
}

impl From<BaselineError> for Error {
    fn from(error: BaselineError) -> Self {
        match error {
            BaselineError::File(error) => Error::File(error),
            BaselineError::Record(error) => Error::Record(error),
            other => Error::Usage(other.to_string()),
        }
    }
}

impl From<BisectError> for Error {
    fn from(error: BisectError) -> Self {
        match error {
            BisectError::File(error) => Error::File(error),
            BisectError::Interrupted => Error::Interrupted,
            other => Error::Usage(other.to_string()),
        }
    }
}

impl Error {
    /// The exit code that tells a script what kind of failure this is.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Usage(_) => exit::USAGE,
            Error::Study(error) => error.exit_code(),
            Error::Record(error) => error.exit_code(),
            Error::Folder(error) => error.exit_code(),
            Error::Engine(error) => error.exit_code(),
            Error::File(error) => error.exit_code(),
            Error::Output(_) | Error::Report(_) | Error::Interrupted | Error::Stopped(_) => {
                exit::TRY_AGAIN
            }
        }
    }
}
