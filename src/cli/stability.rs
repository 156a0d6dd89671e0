//! `crossgrain stability`: the largest stable steps, and where methods fail.

use std::path::PathBuf;

use clap::Args;

use super::chosen::Several;
use super::compare::mark;
use super::job_folder::write_new;
use super::run::YadeLimits;
use super::{in_a_word, json, tell};
use crate::checks::record::{self, Whole};
use crate::compare::Verdict;
use crate::error::Error;
use crate::files::refuse_existing;
use crate::interrupt::asked_to_end;
use crate::limits::bench::machine::Machine;
use crate::limits::stability::checks;
use crate::limits::stability::growth::Found;
use crate::limits::stability::map::{Limits, Row, Wanted};
use crate::limits::stability::{Map, Options, map};
use crate::progress::Display;
use crate::report::stability;

#[derive(Debug, Args)]
#[command(
    after_help = "Without YADE its limits are shown as not made, and the exit code is 3.\n\nExamples:\n  \
    crossgrain stability --quick\n  crossgrain stability --out stable\n  crossgrain stability --quick --engine \
    exec:adapters/lammps.py\n  crossgrain run scene.json --engine native --auto-step --out run"
)]
pub struct Arguments {
    /// Beds of 500 grains instead of 5,000
    #[arg(long)]
    quick: bool,
    /// native, yade or both; or exec:PATH, a program that speaks the engine protocol (docs/engine-protocol.md)
    #[arg(long, default_value = "both")]
    engine: Several,
    /// A new folder for stability.json and report.html
    #[arg(long)]
    out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// No progress
    #[arg(long)]
    quiet: bool,
    #[command(flatten)]
    limits: YadeLimits,
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        if let Some(out) = &self.out {
            refuse_existing(out)?;
        }
        let options = Options {
            engine: match &self.engine {
                Several::BuiltIn(engine) => Wanted::BuiltIn(*engine),
                Several::Exec(program) => Wanted::Exec(self.limits.brought(program)?),
            },
            quick: self.quick,
            yade: self.limits.options(),
            command: self.command(),
        };
        let found = map(&options, &Display::new(self.quiet))?;
        if asked_to_end() {
            return Err(Error::Interrupted);
        }
        let text = json(&Whole::of(
            "stability",
            &found,
            Machine::this().kind(),
            record::Found {
                checks: checks::all(&found),
                measured: checks::measured(&found),
                ..record::Found::default()
            },
        ))?;
        if let Some(out) = &self.out {
            let page = stability::page(&found)?;
            write_new(out, "stability.json", &text, &page)?;
        }
        tell(self.json, &text, || in_words(&found))?;
        Ok(super::exit_code(found.verdict))
    }

    fn command(&self) -> String {
        let engine = self.engine.name();
        let quick = if self.quick { " --quick" } else { "" };
        format!("crossgrain stability --engine {engine}{quick}")
    }
}

/// The map as lines for a terminal.
fn in_words(map: &Map) -> String {
    let mut text = String::new();
    if let Some(engine) = &map.exec {
        text += &format!("{}\n", engine.label());
        for approximation in &engine.approximations {
            text += &format!("it says of itself: {approximation}\n");
        }
    }
    let other = map.exec.as_ref().map_or("YADE", |engine| &engine.name);
    text += &format!(
        "largest stable steps; found ones over predicted, YADE's own choices over the limit without damping\n\
         {:<20} {:>11} {:>8} {:>8} {:>8.8} {:>8} {:>8.8} {:>8} {:>8} {:>8}\n\
         {:<20} {:>11} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}\n",
        "scene",
        "predicted",
        "closed",
        "native",
        other,
        "native",
        other,
        "random",
        "PWave",
        "Global",
        "",
        "s",
        "form",
        "α=0",
        "α=0",
        "α=0.2",
        "α=0.2",
        "α=0.2",
        "",
        "Stiffness"
    );
    for row in &map.rows {
        text += &row_line(row);
    }
    text += "\nwhere methods fail\n";
    for failure in &map.failures {
        text += &format!(
            "{} {}: {}\n{:>9}{}\n{:>9}noticed by: {}\n{:>9}says: {}\n",
            mark(failure.verdict),
            failure.name,
            failure.title,
            "",
            failure.happened,
            "",
            failure.noticed,
            "",
            failure.says
        );
        if let Some(yade) = &failure.yade {
            text += &format!("{:>9}YADE: {yade}\n", "");
        }
    }
    for row in &map.rows {
        if let Some(reason) = &row.not_made {
            text += &format!("{} {}: {reason}\n", mark(Verdict::NotMade), row.name);
        }
        for check in row
            .checks
            .iter()
            .filter(|check| check.verdict != Verdict::Pass)
        {
            text += &super::compare::check_line(check);
        }
    }
    text + &format!(
        "\n{}: {} checks passed, {} failed, {} not made{}; {:.0} s\n",
        in_a_word(map.verdict),
        map.tally.passed,
        map.tally.failed,
        map.tally.not_made,
        match map.tally.inapplicable {
            0 => String::new(),
            scenes => format!(", {scenes} scenes are of parts that the engine does not have"),
        },
        map.seconds
    )
}

fn row_line(row: &Row) -> String {
    let ratio = |value: Option<f64>| value.map_or("–".to_owned(), |value| format!("{value:.4}"));
    let of = |limits: &Limits, found: Option<Found>| {
        ratio(found.map(|found| found.limit / limits.predicted))
    };
    let limit = row.undamped.predicted;
    let proposal = row.proposal_of_yade.unwrap_or(row.proposal);
    format!(
        "{:<20} {:>11.4e} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8.4} {:>8.4}\n",
        row.name,
        limit,
        ratio(row.closed.as_ref().map(|closed| closed.dt / limit)),
        of(&row.undamped, row.undamped.native),
        of(&row.undamped, row.undamped.yade.or(row.undamped.exec)),
        of(&row.damped, row.damped.native),
        of(&row.damped, row.damped.yade.or(row.damped.exec)),
        of(&row.damped, row.damped_at_random),
        proposal.p_wave / limit,
        proposal.global_stiffness / limit,
    )
}
