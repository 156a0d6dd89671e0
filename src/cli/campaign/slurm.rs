//! `crossgrain campaign slurm`: job scripts.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::print;
use crate::error::{Error, exit};
use crate::files::failed;
use crate::study::campaign::slurm;

#[derive(Debug, Args)]
pub struct Arguments {
    /// The campaign's folder, on a file system that all nodes share
    folder: PathBuf,
    /// Tasks of the array; each runs its share of the members one after another
    #[arg(long)]
    tasks: u64,
    /// Members at a time in a task, and processors that it asks for
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// The partition, where the cluster has no default
    #[arg(long)]
    partition: Option<String>,
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        let program = std::env::current_exe().map_err(failed("find", Path::new("this program")))?;
        let scripts = slurm::write(
            &self.folder,
            &slurm::Array {
                tasks: self.tasks,
                threads: self.threads,
                partition: self.partition.as_deref(),
                program: &program,
            },
        )?;
        print(&format!("{}\n", scripts.submit.join("\n")))?;
        Ok(exit::AGREED)
    }
}
