//! Where the record and the page of a job go.

use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::files::{FileError, FolderLock, failed, free_folder, write_whole};
use crate::report::Page;
use crate::report::html::FIRST;

/// The folder of a long job, which is taken up again there. Its record is written last of all and says that it is
/// finished.
pub struct JobFolder {
    /// What the job makes: `map`.
    pub what: &'static str,
    /// Taken when none is named; a number is added when it holds a finished job.
    pub usual: &'static str,
    /// The record's file.
    pub record: &'static str,
    /// Whether it keeps members that a finished job can go on with.
    pub keeps_members: bool,
}

impl JobFolder {
    /// The folder, made if it is not there, for this process alone as long as the lock lives. A finished job in a named one is
    /// never overwritten.
    pub fn open(&self, named: Option<&Path>) -> Result<(PathBuf, FolderLock), Error> {
        let JobFolder { what, record, .. } = self;
        let folder = match named {
            Some(folder) if folder.join(record).exists() => {
                let go_on = if self.keeps_members {
                    format!(", or take its {record} away to go on with its members")
                } else {
                    String::new()
                };
                return Err(Error::Usage(format!(
                    "{} holds a finished {what}; name a folder that does not{go_on}",
                    folder.display()
                )));
            }
            Some(folder) => folder.to_owned(),
            None => free_folder(Path::new(self.usual), record),
        };
        std::fs::create_dir_all(&folder).map_err(failed("create", &folder))?;
        let lock = FolderLock::of(&folder)?;
        // Another process may have finished the job between the two.
        if folder.join(record).exists() {
            return Err(Error::File(FileError::Busy { path: folder }));
        }
        Ok((folder, lock))
    }

    /// Writes the pages with their figures, and then the record.
    pub fn finish(&self, folder: &Path, pages: &[Page], record: &str) -> Result<(), Error> {
        for page in pages {
            page.write(folder)?;
        }
        write_whole(&folder.join(self.record), record.as_bytes())?;
        Ok(())
    }
}

/// Where the page is, as a line.
pub fn page_line(folder: &Path) -> String {
    format!(
        "report: {}\n",
        folder.join(format!("{FIRST}.html")).display()
    )
}
