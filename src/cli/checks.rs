//! `crossgrain checks`: the checks of a finished job, in the forms that other programs read.

use std::path::{Path, PathBuf};

use clap::Args;

use super::{json, print};
use crate::checks::record::{Record, read};
use crate::checks::{Check, Outcome};
use crate::compare::baseline::diff::Diff;
use crate::error::{Error, exit};
use crate::files::write_whole;
use crate::report::check_files::{csv, error_in_markdown, markdown};
use crate::report::junit::{in_a_line, of_checks, of_error};

#[derive(Debug, Args)]
#[command(
    after_help = "The exit code is that of the job: 0 agreed, 1 a check failed, 3 incomplete.\n\nExamples:\n  \
    crossgrain checks out/reproduce/run.json\n  crossgrain checks out/reproduce/run.json --junit checks.xml --summary \
    \"$GITHUB_STEP_SUMMARY\"\n  crossgrain checks verified/verify.json --all --csv checks.csv"
)]
pub struct Arguments {
    /// run.json, verify.json or bench.json of a finished job
    #[arg(required_unless_present = "schema")]
    record: Option<PathBuf>,
    /// Print the JSON Schema of what all records have in common
    #[arg(long, conflicts_with = "record")]
    schema: bool,
    /// Print the checks that passed too
    #[arg(long)]
    all: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    files: Files,
}

/// The files that a job's checks can be written to.
#[derive(Debug, Clone, Args)]
pub struct Files {
    /// Write JUnit XML
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Write a table
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Append a job summary in Markdown
    #[arg(long, value_name = "FILE")]
    summary: Option<PathBuf>,
}

impl Files {
    /// Writes those that were asked for, with what a baseline says.
    pub fn write(&self, record: &Record, diff: Option<&Diff>) -> Result<(), Error> {
        let mut checks = record.checks.clone();
        checks.extend(
            diff.map(crate::compare::baseline::checks::all)
                .unwrap_or_default(),
        );
        if let Some(path) = &self.junit {
            let name = format!("crossgrain {}", record.job);
            write_whole(path, of_checks(&name, &checks)?.as_bytes())?;
        }
        if let Some(path) = &self.csv {
            write_whole(path, csv(&checks)?.as_bytes())?;
        }
        if let Some(path) = &self.summary {
            append(path, &markdown(record, diff))?;
        }
        Ok(())
    }
}

impl Files {
    /// A job that ended with an error has no checks; whoever reads the files is told so there too.
    pub fn write_error(&self, name: &str, error: &Error) -> Result<(), Error> {
        if let Some(path) = &self.junit {
            write_whole(path, of_error(name, error)?.as_bytes())?;
        }
        if let Some(path) = &self.summary {
            append(path, &error_in_markdown(name, error))?;
        }
        Ok(())
    }
}

/// Adds to a file that other steps of a job may have begun.
pub fn append(path: &Path, text: &str) -> Result<(), Error> {
    use std::io::Write;
    let file = std::fs::OpenOptions::new()
        .create(true)
        .append(true)
        .open(path);
    file.and_then(|mut file| file.write_all(text.as_bytes()))
        .map_err(crate::files::failed("write", path))
        .map_err(Error::File)
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        let Some(path) = &self.record else {
            print(&json(&schemars::schema_for!(Record))?)?;
            return Ok(exit::AGREED);
        };
        let record = read(path)?;
        self.files.write(&record, None)?;
        print(&if self.json {
            json(&record)?
        } else {
            in_words(&record, self.all)
        })?;
        Ok(exit_code(record.verdict))
    }
}

fn exit_code(verdict: Outcome) -> u8 {
    match verdict {
        Outcome::Pass => exit::AGREED,
        Outcome::Fail => exit::CHECK_FAILED,
        Outcome::NotMade | Outcome::ExpectedFailure => exit::INCOMPLETE,
    }
}

/// Failures first; what passed only if it is asked for.
fn in_words(record: &Record, all: bool) -> String {
    let mut checks: Vec<&Check> = record.checks.iter().collect();
    let rank = |outcome: Outcome| match outcome {
        Outcome::Fail => 0,
        Outcome::NotMade => 1,
        Outcome::ExpectedFailure => 2,
        Outcome::Pass => 3,
    };
    checks.sort_by_key(|check| rank(check.outcome));
    let mut text = String::new();
    for check in checks {
        if all || check.outcome != Outcome::Pass {
            let Check { id, outcome, .. } = check;
            text += &format!("{:>16} {id}: {}\n", outcome.word(), in_a_line(check));
        }
    }
    text + &format!(
        "{}: {}; {}\n",
        record.job,
        record.verdict.word(),
        record.tally()
    )
}
