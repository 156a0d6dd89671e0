//! The recorded run of YADE, carried in the program. `reference_data/README.md` says how it was made.

use std::path::Path;

use super::FolderError;
use crate::files::{FileError, unpacked, write_folder, write_whole};
use crate::tables::parse_rows;
use grains::measure::HistoryRow;

/// The folder that it is unpacked into.
pub const FOLDER: &str = "yade-recorded";

macro_rules! recorded_files {
    ($($name:literal),* $(,)?) => {
        &[$((
            $name,
            include_bytes!(concat!("../../../reference_data/yade-paper-1/", $name)) as &[u8],
        )),*]
    };
}

const FILES: &[(&str, &[u8])] = recorded_files![
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
];

/// Writes the recorded run folder.
pub fn unpack(folder: &Path) -> Result<(), FileError> {
    write_folder(folder, |aside| {
        for (name, bytes) in FILES {
            write_whole(&aside.join(name), bytes)?;
        }
        Ok::<(), FileError>(())
    })
}

/// The history of the recorded run.
pub fn history() -> Result<Vec<HistoryRow>, FolderError> {
    let path = Path::new("history.csv.gz");
    let packed = FILES.iter().find(|(name, _)| Path::new(name) == path);
    let text = unpacked(path, packed.map_or(&[], |(_, bytes)| *bytes))?;
    Ok(parse_rows(path, &text)?)
}

/// Whether a folder holds exactly the recorded run.
pub fn is_intact(folder: &Path) -> bool {
    FILES.iter().all(|(name, bytes)| {
        let path = folder.join(name);
        path.is_file() && std::fs::read(path).is_ok_and(|found| found == *bytes)
    })
}
