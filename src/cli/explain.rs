//! `crossgrain explain`: what a check means.

use std::path::PathBuf;

use clap::Args;

use super::print;
use crate::checks::Check;
use crate::checks::record::read;
use crate::error::{Error, exit};
use crate::explain::{EXPLANATIONS, of};

#[derive(Debug, Args)]
#[command(
    after_help = "Without CHECK all kinds of checks are named.\n\nExamples:\n  crossgrain explain faults\n  crossgrain explain \
    facts/everything/dt --record out/reproduce/run.json"
)]
pub struct Arguments {
    /// A check's id, or the beginning of one, as `crossgrain checks --all` prints it
    check: Option<String>,
    /// The record that it stands in: its values and limits are shown too
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
}

/// Checks of a record that are shown for the beginning of an id.
const MOST_SHOWN: usize = 10;

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        let Some(id) = &self.check else {
            let kinds = EXPLANATIONS.map(|of| format!("{}\n    {}\n", of.pattern, of.meaning));
            print(&kinds.concat())?;
            return Ok(exit::AGREED);
        };
        let Some(found) = of(id) else {
            return Err(Error::Usage(format!(
                "there is no check {id}; crossgrain explain names all kinds, crossgrain checks RECORD --all those of a job"
            )));
        };
        let mut text = format!(
            "{}\n\nmeaning: {}\nformula: {}\nsource:  {}\nbreaks:  {}\n",
            found.pattern, found.meaning, found.formula, found.source, found.breaks
        );
        if let Some(path) = &self.record {
            let record = read(path)?;
            let within = |check: &&Check| {
                check.id == *id
                    || check
                        .id
                        .starts_with(&format!("{}/", id.trim_end_matches('/')))
            };
            let shown: Vec<&Check> = record.checks.iter().filter(within).collect();
            if shown.is_empty() {
                return Err(Error::Usage(format!(
                    "{} has no check {id}; crossgrain checks {} --all names them",
                    path.display(),
                    path.display()
                )));
            }
            for check in shown.iter().take(MOST_SHOWN) {
                text += &lines(check);
            }
            if shown.len() > MOST_SHOWN {
                text += &format!("\n… and {} more\n", shown.len() - MOST_SHOWN);
            }
        }
        print(&text)?;
        Ok(exit::AGREED)
    }
}

fn lines(check: &Check) -> String {
    let mut text = format!(
        "\n{}: {}\n    {}\n",
        check.id,
        check.outcome.word(),
        check.in_a_line()
    );
    for (title, words) in [("method", &check.method), ("limits", &check.basis)] {
        if !words.is_empty() {
            text += &format!("    {title}: {words}\n");
        }
    }
    text
}
