//! Where the record and the page of a job go.

use std::path::{Path, PathBuf};

use clap::Args;

use super::report::Views;
use crate::document::Document;
use crate::error::Error;
use crate::files::{
    FileError, Lock, Place, folder_lock, has_room, make_folder, make_room, write_folder,
    write_whole,
};
use crate::progress::say;
use crate::report::html::FIRST;
use crate::report::{Page, page};

/// The folder of a long job, made if it is not there, for this process alone as long as the lock lives; the job is taken up again
/// there. A finished one, which `record` tells, gets a number.
pub fn open(folder: &Path, record: &str) -> Result<Lock, Error> {
    clear(folder, record)?;
    let finished = || Place::from((folder, record)).is_taken();
    let place = Place::from(folder);
    if finished() || (place.is_taken() && !place.is_folder()) {
        let path = folder.to_owned();
        return Err(Error::File(FileError::Exists { path }));
    }
    make_folder(folder)?;
    let lock = folder_lock(folder)?;
    // Another process may have finished the job between the two.
    if finished() {
        let path = folder.to_owned();
        return Err(Error::File(FileError::Busy { path }));
    }
    Ok(lock)
}

/// Writes the pages with their figures, and last of all the record, which says that the job is finished.
pub fn finish(folder: &Path, pages: &[Page], record: &str, text: &str) -> Result<(), Error> {
    for page in pages {
        page.write(folder)?;
    }
    write_whole((folder, record), text.as_bytes())?;
    Ok(())
}

/// Where the record and the page of a verb go that needs no folder while it works.
#[derive(Debug, Args)]
pub struct Results {
    /// A folder for the record and the page; an earlier result in it is kept, with a number after its name
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Results {
    /// An error if there is something else; to be asked before the work.
    pub fn check(&self, record: &str) -> Result<(), Error> {
        let out = self.out.as_deref();
        Ok(out.map_or(Ok(()), |out| has_room(out, record))?)
    }

    /// Tells what a job found, and writes its page and its record; the value is the exit code.
    pub fn finish(
        &self,
        views: &Views,
        job: &str,
        record: (&str, &str),
        document: &Document,
    ) -> Result<u8, Error> {
        views.tell(job, record.1, document)?;
        self.write(document, &[record])?;
        Ok(document.exit_code())
    }

    /// Writes the page and the files, of which the first is the record, and says where the page is.
    pub fn write(&self, document: &Document, files: &[(&str, &str)]) -> Result<(), Error> {
        let (Some(out), Some((record, _))) = (&self.out, files.first()) else {
            if document.has_pictures() {
                say("--out DIR writes a page with the pictures");
            }
            return Ok(());
        };
        clear(out, record)?;
        write_folder(out, |aside| {
            page(document).write(aside)?;
            let write = |(name, text): &(&str, &str)| write_whole((aside, *name), text.as_bytes());
            Ok::<(), Error>(files.iter().try_for_each(write)?)
        })?;
        say(page_line(out).trim_end());
        Ok(())
    }
}

/// Makes room for a result and says what became of the earlier one.
pub fn clear(folder: &Path, record: &str) -> Result<(), FileError> {
    if let Some(kept) = make_room(folder, record)? {
        let [was, is] = [folder, &kept].map(Path::display);
        say(&format!("what was in {was} is in {is} now"));
    }
    Ok(())
}

/// Where the page is, as a line.
pub fn page_line(folder: &Path) -> String {
    let page = folder.join(format!("{FIRST}.html"));
    format!("report: {}\n", page.display())
}
