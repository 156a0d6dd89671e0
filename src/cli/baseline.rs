//! `crossgrain baseline`: keeps a run's checks under a name and holds later runs against them.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::checks::append;
use super::{json, print};
use crate::checks::record::read;
use crate::compare::baseline::Store;
use crate::compare::baseline::diff::{Change, Changed, Diff, diff};
use crate::error::Error;
use crate::report::check_files::markdown;
use crate::report::junit::in_a_line;

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
    /// Print every check that moved within its tolerance, not only the five that moved most
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
            append(path, &markdown(&record, Some(&found)))?;
        }
        print(&if self.json {
            json(&found)?
        } else {
            in_words(&found, self.all)
        })?;
        Ok(super::exit_code(found.verdict))
    }
}

/// Moved checks that are printed without `--all`.
const MOST_MOVED: usize = 5;

/// What is not as it was, the worst first.
pub fn in_words(diff: &Diff, all: bool) -> String {
    let mut text = String::new();
    let mut moved = 0;
    for of in &diff.changes {
        moved += usize::from(of.change == Change::Moved);
        if all || of.change != Change::Moved || moved <= MOST_MOVED {
            text += &change_lines(of);
        }
    }
    if !all && moved > MOST_MOVED {
        text += &format!(
            "{:>18} {} more moved less (--all)\n",
            "…",
            moved - MOST_MOVED
        );
    }
    let shown = if all { diff.moved.len() } else { MOST_MOVED };
    for number in diff.moved.iter().take(shown) {
        let value = |of: Option<f64>| of.map_or("–".to_owned(), |of| of.to_string());
        let relative = number
            .relative
            .map_or(String::new(), |of| format!(", by {of:.1e} of itself"));
        text += &format!(
            "{:>18} {}: {} to {} {}{relative}\n",
            "measured",
            number.id,
            value(number.before),
            value(number.after),
            number.unit
        );
    }
    for speed in &diff.speeds {
        text += &format!(
            "{:>18} {}\n",
            format!("{:?}", speed.pace).to_lowercase(),
            speed.in_a_line()
        );
    }
    if !diff.same_machine && !diff.speeds.is_empty() {
        text += "speeds are not judged: the machines are not of one kind\n";
    }
    let word = match diff.verdict {
        crate::compare::Verdict::Pass => "NOTHING WORSE",
        crate::compare::Verdict::Fail => "WORSE",
        crate::compare::Verdict::NotMade => "CANNOT TELL",
    };
    text + &format!("{word} than {}: {}\n", diff.baseline, diff.in_a_line())
}

fn change_lines(of: &Changed) -> String {
    let mut text = format!("{:>18} {}\n", of.change.words(), of.id);
    for (side, check) in [("before", &of.before), ("after", &of.after)] {
        if let Some(check) = check {
            text += &format!("{:>18} {side}: {}\n", "", in_a_line(check));
        }
    }
    if let Some(share) = of.share_of_tolerance {
        let share = if share < 1000.0 {
            format!("{share:.3}")
        } else {
            format!("{share:.1e}")
        };
        text += &format!("{:>18} moved by {share} of its tolerance\n", "");
    }
    text
}
