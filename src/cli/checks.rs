//! `crossgrain checks`: the checks of a finished job, in the forms that other programs read.

use std::path::{Path, PathBuf};

use clap::Args;

use super::{json, print};
use crate::checks::Outcome;
use crate::checks::record::{Record, read};
use crate::compare::baseline::diff::Diff;
use crate::document::{Document, Table};
use crate::error::{Error, exit};
use crate::files::{failed, write_whole};
use crate::report;
use crate::report::junit::{of_checks, of_error};

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
#[derive(Debug, Clone, Default, Args)]
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
            diff.map(crate::compare::baseline::checks)
                .unwrap_or_default(),
        );
        if let Some(path) = &self.junit {
            let name = format!("crossgrain {}", record.job);
            write(path, &of_checks(&name, &checks))?;
        }
        if let Some(path) = &self.csv {
            write(path, &Table::of_checks("checks", &checks).csv())?;
        }
        if let Some(path) = &self.summary {
            append(path, &report::markdown(&record.document(diff)))?;
        }
        Ok(())
    }
}

impl Files {
    /// A job that ended with an error has no checks; whoever reads the files is told so there too.
    pub fn write_error(&self, name: &str, error: &Error) -> Result<(), Error> {
        if let Some(path) = &self.junit {
            write(path, &of_error(name, error))?;
        }
        if let Some(path) = &self.summary {
            let answer = format!("It ended with exit code {}: {error}", error.exit_code());
            let document = Document {
                title: name.to_owned(),
                verdict: Outcome::Skipped,
                answer,
                sections: Vec::new(),
                checks: Vec::new(),
            };
            append(path, &report::markdown(&document))?;
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
        .map_err(failed("write", path))
        .map_err(Error::File)
}

/// Writes a file whole; into a pipe or a device that has this name instead of in its place.
fn write(path: &Path, text: &str) -> Result<(), Error> {
    if std::fs::metadata(path).is_ok_and(|of| !of.is_file() && !of.is_dir()) {
        let file = std::fs::OpenOptions::new().write(true).open(path);
        return file
            .and_then(|mut file| std::io::Write::write_all(&mut file, text.as_bytes()))
            .map_err(failed("write", path))
            .map_err(Error::File);
    }
    Ok(write_whole(path, text.as_bytes())?)
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
            let lines = report::check_lines(&record.checks, self.all);
            let [job, verdict] = [&record.job, record.verdict.word()];
            lines + &format!("{job}: {verdict}; {}\n", record.tally())
        })?;
        Ok(record.verdict.exit_code())
    }
}
