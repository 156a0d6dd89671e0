//! `crossgrain stability`: the largest stable steps, and where methods fail.

use std::path::PathBuf;

use clap::Args;

use super::chosen::Several;
use super::run::YadeLimits;
use super::tell;
use crate::checks::record::{self, Found};
use crate::error::Error;
use crate::files::{refuse_existing, write_folder, write_whole};
use crate::interrupt::asked_to_end;
use crate::limits::bench::machine::Machine;
use crate::limits::stability::{External, Options, map};
use crate::progress::Display;
use crate::report;
use crate::suite::run::Engines;

#[derive(Debug, Args)]
#[command(
    after_help = "Without YADE its limits are skipped, and the exit code is 3.\n\nExamples:\n  \
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
        let yade = || Some(External::Yade(self.limits.options()));
        let (native, external) = match &self.engine {
            Several::BuiltIn(Engines::Native) => (true, None),
            Several::BuiltIn(Engines::Yade) => (false, yade()),
            Several::BuiltIn(Engines::Both) => (true, yade()),
            Several::Exec(program) => (false, Some(External::Exec(self.limits.brought(program)?))),
        };
        let quick = if self.quick { " --quick" } else { "" };
        let options = Options {
            native,
            external,
            quick: self.quick,
            command: format!(
                "crossgrain stability --engine {}{quick}",
                self.engine.name()
            ),
        };
        let found = map(&options, &Display::new(self.quiet))?;
        if asked_to_end() {
            return Err(Error::Interrupted);
        }
        let document = found.document();
        let (text, _) = record::write(
            "stability",
            &found,
            Machine::this().kind(),
            Found {
                checks: document.checks.clone(),
                measured: found.measured(),
                ..Found::default()
            },
        )?;
        if let Some(out) = &self.out {
            write_folder::<Error>(out, |aside| {
                report::page(&document).write(aside)?;
                Ok(write_whole(&aside.join("stability.json"), text.as_bytes())?)
            })?;
        }
        tell(self.json, &text, || report::terminal(&document))?;
        Ok(document.verdict.exit_code())
    }
}
