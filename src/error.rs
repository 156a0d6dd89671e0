//! Every way in which the program can fail, and its exit code.

use crate::compare::baseline::BaselineError;
use crate::compare::baseline::history::RepositoryError;
use crate::engine::{EngineError, ProgramError};
use crate::files::FileError;
use crate::run::KeptError;
use crate::study::StudyError;
use grains::native::NativeError;

pub use crate::exit;

/// Any failure of the program.
#[derive(Debug, thiserror::Error)]
pub enum Error {
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

impl From<KeptError> for Error {
    fn from(error: KeptError) -> Self {
        match error {
            KeptError::Engine(error) => Error::Engine(error),
            KeptError::File(error) => Error::File(error),
            other @ KeptError::Interrupted { .. } => Error::Stopped(other.to_string()),
        }
    }
}

impl From<BaselineError> for Error {
    fn from(error: BaselineError) -> Self {
        match error {
            BaselineError::File(error) => Error::File(error),
            other => Error::Usage(other.to_string()),
        }
    }
}

impl From<RepositoryError> for Error {
    fn from(error: RepositoryError) -> Self {
        match error {
            RepositoryError::File(error) => Error::File(error),
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
            Error::Engine(error) => error.exit_code(),
            Error::File(error) => error.exit_code(),
            Error::Output(_) | Error::Report(_) | Error::Interrupted | Error::Stopped(_) => {
                exit::TRY_AGAIN
            }
        }
    }
}
