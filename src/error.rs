//! Every way in which the program can fail, and its exit code.

use crate::checks::record::RecordError;
use crate::engine::exec::ExecError;
use crate::engine::yade::YadeError;
use crate::files::FileError;
use crate::run::EngineError;
use crate::run::folder::FolderError;
use crate::run::kept::KeptError;
use crate::run::scene_file::SceneFileError;
use crate::run::tables::TableError;
use crate::study::campaign::CampaignError;
use grains::native::{NativeError, Trouble};

/// Exit codes; scripts rely on them.
pub mod exit {
    /// Everything agreed, or was done.
    pub const AGREED: u8 = 0;
    /// A check failed.
    pub const CHECK_FAILED: u8 = 1;
    /// The command line, a scene or a run folder cannot be used.
    pub const USAGE: u8 = 2;
    /// The run or the comparison is incomplete.
    pub const INCOMPLETE: u8 = 3;
    /// An engine failed.
    pub const ENGINE_FAILED: u8 = 4;
    /// The surroundings failed (a full disk, no permission to write, a signal to end): try again.
    pub const TRY_AGAIN: u8 = 75;
}

/// Any failure of the program.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error(transparent)]
    Scene(#[from] SceneFileError),
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
    /// Another program than an engine of a run.
    #[error("{0}")]
    Program(String),
    #[error("the report cannot be made: {0}")]
    Report(String),
    #[error(transparent)]
    Campaign(#[from] CampaignError),
    #[error(transparent)]
    Record(#[from] RecordError),
}

impl From<KeptError> for Error {
    fn from(error: KeptError) -> Self {
        match error {
            KeptError::Engine(error) => Error::Engine(error),
            KeptError::Folder(error) => Error::Folder(error),
            KeptError::File(error) => Error::File(error),
        }
    }
}

impl Error {
    /// The exit code that tells a script what kind of failure this is.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Usage(_) => exit::USAGE,
            Error::Campaign(error) => of_campaign(error),
            Error::Record(RecordError::File(error)) => of_file(error),
            Error::Record(_) => exit::USAGE,
            Error::Scene(SceneFileError::File(error)) | Error::File(error) => of_file(error),
            Error::Scene(_) => exit::USAGE,
            Error::Folder(error) => of_folder(error),
            Error::Engine(error) => of_engine(error),
            Error::Program(_) => exit::ENGINE_FAILED,
            Error::Output(_) | Error::Report(_) | Error::Interrupted => exit::TRY_AGAIN,
        }
    }
}

fn of_engine(error: &EngineError) -> u8 {
    match error {
        EngineError::Yade(YadeError::Unsupported(_)) => exit::USAGE,
        EngineError::Yade(YadeError::File(_) | YadeError::Interrupted) => exit::TRY_AGAIN,
        EngineError::Exec(ExecError::Unsupported { .. } | ExecError::Missing { .. }) => exit::USAGE,
        EngineError::Exec(ExecError::File(_) | ExecError::Interrupted) => exit::TRY_AGAIN,
        EngineError::Native(NativeError {
            trouble: Trouble::Interrupted,
            ..
        }) => exit::TRY_AGAIN,
        _ => exit::ENGINE_FAILED,
    }
}

fn of_campaign(error: &CampaignError) -> u8 {
    match error {
        CampaignError::Engine(error) => of_engine(error),
        CampaignError::File(error) => of_file(error),
        CampaignError::Scene(_) => exit::USAGE,
        error => error.exit_code().unwrap_or(exit::USAGE),
    }
}

fn of_folder(error: &FolderError) -> u8 {
    match error {
        FolderError::File(error)
        | FolderError::Table(TableError::File(error))
        | FolderError::Scene {
            source: SceneFileError::File(error),
            ..
        } => of_file(error),
        _ => exit::USAGE,
    }
}

/// What cannot be read was named wrongly; what cannot be written may work another time.
fn of_file(error: &FileError) -> u8 {
    match error {
        FileError::Io { source, .. }
            if matches!(
                source.kind(),
                std::io::ErrorKind::NotADirectory
                    | std::io::ErrorKind::AlreadyExists
                    | std::io::ErrorKind::InvalidFilename
            ) =>
        {
            exit::USAGE
        }
        FileError::Io { action, .. } if !matches!(*action, "open" | "read" | "find") => {
            exit::TRY_AGAIN
        }
        _ => exit::USAGE,
    }
}
