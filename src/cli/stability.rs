//! `crossgrain stability`: the largest stable steps, and where methods fail, as one study from plan to report.

use std::path::PathBuf;

use clap::Args;

use super::job_folder::clear;
use super::report::Output;
use super::run::YadeLimits;
use super::study::plan::MapArguments;
use super::study::{engines_of, open, report};
use crate::error::Error;
use crate::files::{has_room, work_folder};
use crate::progress::Display;
use crate::study::folder::Job;
use crate::study::shard::Shard;
use crate::study::{StudyError, create};
use crate::workers::cores;

#[derive(Debug, Args)]
#[command(
    after_help = "The same in shards, on a cluster or taken up again: crossgrain study plan stability. Where an engine is missing its \
    limits are skipped, and the exit code is 3.\n\nExamples:\n  \
    crossgrain stability --quick\n  crossgrain stability --out stable\n  crossgrain stability --in-space --quick\n  crossgrain stability --quick --engine \
    exec:adapters/lammps.py\n  crossgrain run scene.json --engine native --auto-step --out run"
)]
pub struct Arguments {
    #[command(flatten)]
    map: MapArguments,
    /// The study's folder, with report.json and report.html in the end, instead of a temporary one; a finished one is kept, with a
    /// number after its name
    #[arg(long)]
    out: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
    #[command(flatten)]
    limits: YadeLimits,
}

/// The file that a finished study has.
const RECORD: &str = "report.json";

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        let place = work_folder()?;
        let folder = self.out.clone();
        let folder = folder.unwrap_or_else(|| place.path().join("stability"));
        has_room(&folder, RECORD)?;
        let (plan, program) = self.map.plan(&self.limits)?;
        clear(&folder, RECORD)?;
        create(&folder, plan, program, None)?;
        let study = open(&folder)?;
        let job = Job {
            shard: Shard::WHOLE,
            threads: cores(),
            engines: &engines_of(study.as_ref(), None, &self.limits)?,
        };
        let display = Display::new(self.output.quiet);
        match study.run(&job, &display) {
            Ok(_) => drop(study.merge()?),
            Err(error @ StudyError::EnginesFailed { .. }) => display.line(&error.to_string()),
            Err(error) => return Err(error.into()),
        }
        report(&folder, &self.output.views, self.out.is_some())
    }
}
