//! A scene as a file.

use std::path::Path;

use grains::scene::{Scene, SceneError, parse_scene};

use crate::exit;
use crate::files::{FileError, read_text};

/// A scene file larger than this is not one of ours.
const LARGEST_SCENE: u64 = 1 << 20;

/// A scene file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SceneFileError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error(transparent)]
    Scene(#[from] SceneError),
}

impl SceneFileError {
    /// What to tell a script.
    pub fn exit_code(&self) -> u8 {
        match self {
            SceneFileError::File(error) => error.exit_code(),
            SceneFileError::Scene(_) => exit::USAGE,
        }
    }
}

/// Reads and validates a scene file.
pub fn read_scene(path: &Path) -> Result<Scene, SceneFileError> {
    Ok(parse_scene(&read_text(path, LARGEST_SCENE)?)?)
}
