//! `crossgrain export`: run folders for ParaView and for archives.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::print;
use crate::error::{Error, exit};
use crate::files::{FileError, failed, into_place, refuse_existing, write_folder, write_whole};
use crate::run::export::{pack_archive, vtk_files};
use crate::run::folder::RunFolder;

#[derive(Debug, Subcommand)]
#[command(
    after_help = "Examples:\n  crossgrain export vtk native --out vtk      # open vtk/grains.vtp and vtk/contacts.vtp in ParaView, look along y\n  \
    crossgrain export archive native --out native.tar.gz"
)]
pub enum Verb {
    /// Grains, contacts and cells as VTK files that ParaView opens
    Vtk(Folders),
    /// The run folder packed, with checksums and an RO-Crate description
    Archive(Folders),
}

#[derive(Debug, Args)]
pub struct Folders {
    /// A run folder
    run: PathBuf,
    /// What to write; must not exist
    #[arg(long)]
    out: PathBuf,
}

impl Verb {
    pub fn execute(self) -> Result<u8, Error> {
        match self {
            Verb::Vtk(of) => of.vtk(),
            Verb::Archive(of) => of.archive(),
        }
    }
}

impl Folders {
    fn vtk(self) -> Result<u8, Error> {
        refuse_existing(&self.out)?;
        let run = RunFolder::read(&self.run)?;
        let mut files = vtk_files(&run.scene, &run.last, "").to_vec();
        if let Some(settled) = &run.settled {
            files.extend(vtk_files(&run.scene, settled, "settled-"));
        }
        write_folder::<FileError>(&self.out, |aside| {
            files
                .iter()
                .try_for_each(|(name, text)| write_whole(&aside.join(name), text.as_bytes()))
        })?;
        let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
        print(&format!("{}: {}\n", self.out.display(), names.join(", ")))?;
        Ok(exit::AGREED)
    }

    fn archive(self) -> Result<u8, Error> {
        refuse_existing(&self.out)?;
        // Only what belongs together is worth an archive's room.
        let run = RunFolder::read(&self.run)?;
        let name = self.out.file_name().and_then(|name| name.to_str());
        let name = name
            .and_then(|name| name.split('.').next())
            .filter(|name| !name.is_empty());
        let Some(name) = name else {
            return Err(Error::Usage(format!(
                "{} is no name for an archive; give one such as run.tar.gz",
                self.out.display()
            )));
        };
        let beside = match self.out.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => std::path::Path::new("."),
        };
        let mut aside =
            tempfile::NamedTempFile::new_in(beside).map_err(failed("write into", beside))?;
        pack_archive(&self.run, &run, name, &mut aside)?;
        into_place(aside, &self.out)?;
        print(&format!("{}\n", self.out.display()))?;
        Ok(exit::AGREED)
    }
}
