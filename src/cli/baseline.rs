//! `crossgrain baseline`: keeps a run's checks under a name and holds later runs against them.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::checks::append;
use super::{json, print};
use crate::checks::record::read;
use crate::compare::baseline::Store;
use crate::compare::baseline::diff::diff;
use crate::error::Error;
use crate::report;

#[derive(Debug, Subcommand)]
#[command(
    after_help = "A baseline changes only by `save --replace`.\n\nExamples:\n  crossgrain baseline save out/reproduce/run.json main\n  \
    crossgrain baseline list\n  crossgrain baseline diff out/reproduce-1/run.json main"
)]
pub enum Verb {
    /// Keep the checks of a finished job under a name
    Save(Save),
    /// All baselines: name, job, version, how many checks
    List(List),
    /// What is worse, better, moved or gone since a baseline
    Diff(DiffArguments),
}

#[derive(Debug, Args)]
pub struct Where {
    /// The folder of baselines
    #[arg(long, default_value = "baselines", value_name = "DIR")]
    store: PathBuf,
}

impl Where {
    pub fn store(&self) -> Store {
        Store::new(&self.store)
    }
}

#[derive(Debug, Args)]
pub struct Save {
    /// run.json, verify.json or bench.json of a finished job
    record: PathBuf,
    /// Its name as a baseline
    name: String,
    /// Put it in the place of one of that name
    #[arg(long)]
    replace: bool,
    #[command(flatten)]
    at: Where,
}

#[derive(Debug, Args)]
pub struct List {
    #[command(flatten)]
    at: Where,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Exit code 0: nothing is worse; 1: a new failure, or slower on the same kind of machine; 3: a check is gone, is no \
    longer made or is defined otherwise, so that nothing can be said of it.\nTimes are compared as ratios to YADE and to native exact and as \
    numbers of instructions, never as seconds."
)]
pub struct DiffArguments {
    /// run.json, verify.json or bench.json of a finished job
    record: PathBuf,
    /// The baseline's name
    name: String,
    /// Print every check that moved within its tolerance, not only the dozen that moved most
    #[arg(long)]
    all: bool,
    /// Every measured number must be the same to the last bit, as after a change that is to change nothing
    #[arg(long)]
    bits: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Append a job summary in Markdown
    #[arg(long, value_name = "FILE")]
    summary: Option<PathBuf>,
    #[command(flatten)]
    at: Where,
}

impl Verb {
    pub fn execute(self) -> Result<u8, Error> {
        match self {
            Verb::Save(save) => {
                let path = save
                    .at
                    .store()
                    .save(&save.record, &save.name, save.replace)?;
                print(&format!("kept as {}\n", path.display()))?;
                Ok(crate::error::exit::AGREED)
            }
            Verb::List(list) => {
                let store = list.at.store();
                let mut text = String::new();
                for name in store.names()? {
                    let record = store.load(&name)?.record;
                    let [job, version] = [&record.job, &record.crossgrain];
                    text += &format!("{name}: {job}, crossgrain {version}, {}\n", record.tally());
                }
                if text.is_empty() {
                    text = "there are none yet; crossgrain baseline save makes one\n".to_owned();
                }
                print(&text)?;
                Ok(crate::error::exit::AGREED)
            }
            Verb::Diff(arguments) => arguments.execute(),
        }
    }
}

impl DiffArguments {
    fn execute(self) -> Result<u8, Error> {
        let baseline = self.at.store().load(&self.name)?;
        let record = read(&self.record)?;
        if baseline.record.job != record.job {
            return Err(Error::Usage(format!(
                "the baseline {} is of {}, this run is of {}; give a run of the same job",
                self.name, baseline.record.job, record.job
            )));
        }
        let mut found = diff(&baseline, &record);
        if self.bits {
            found = found.demanding_bits();
        }
        if let Some(path) = &self.summary {
            append(path, &report::markdown(&record.document(Some(&found))))?;
        }
        print(&if self.json {
            json(&found)?
        } else {
            report::terminal(&found.document(self.all))
        })?;
        Ok(found.verdict.exit_code())
    }
}
