//! `crossgrain bench`: all engines side by side on one bed.

use std::path::{Path, PathBuf};

use clap::Args;

use super::engine::beside;
use super::job_folder::{finish, open, page_line};
use super::report::Output;
use super::run::YadeLimits;
use super::{flag, print, tell, with_options};
use crate::checks::record::{self, Found};
use crate::error::{Error, exit};
use crate::files::failed;
use crate::limits::bench::{self, Options, timing};
use crate::progress::Display;
use crate::report::{page, terminal};
use crate::study::realization::Engines;

const RECORD: &str = "bench.json";

#[derive(Debug, Args)]
#[command(
    after_help = "Engines that are not installed are shown as skipped. No time is a check: the \
    exit code tells whether the engines ran and whether their beds agree.\nA settled bed in --out is taken over.\n\n\
    Examples:\n  crossgrain bench --quick\n  crossgrain bench --rounds 15 --out bench\n  crossgrain bench --quick --engine exec:adapters/lammps.py"
)]
pub struct Arguments {
    /// Few rounds, small beds: about a minute
    #[arg(long)]
    quick: bool,
    /// How often every engine takes its turn; 11, and 3 with --quick
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: Option<u32>,
    /// One more engine: exec:PATH, a program that speaks the engine protocol (docs/engine-protocol.md)
    #[arg(long, value_parser = beside)]
    engine: Option<PathBuf>,
    /// The folder to write; a finished benchmark in it is kept, with a number after its name
    #[arg(long, value_name = "DIR", default_value = "out/bench")]
    out: PathBuf,
    #[command(flatten)]
    output: Output,
    #[command(flatten)]
    limits: YadeLimits,
    /// Time the bed in this folder in this process and say so: for the parts that need a process of their own
    #[arg(long, hide = true)]
    one: Option<PathBuf>,
    #[arg(long, hide = true, default_value_t = 1000)]
    one_steps: u64,
    #[arg(long, hide = true, default_value_t = 1)]
    one_threads: usize,
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        if let Some(folder) = &self.one {
            let one = timing::one(folder, self.one_steps, self.one_threads)?;
            let line = serde_json::to_string(&one);
            print(&(line.map_err(|error| Error::Report(error.to_string()))? + "\n"))?;
            return Ok(exit::AGREED);
        }
        let external = self.engine.as_deref();
        let external = external.map(|program| self.limits.external(program));
        let engines = Engines {
            yade: self.limits.options(),
            external: external.transpose()?,
        };
        let _lock = open(&self.out, RECORD)?;
        let crossgrain =
            std::env::current_exe().map_err(failed("find", Path::new("this program")))?;
        let options = Options {
            out: self.out.clone(),
            quick: self.quick,
            rounds: self.rounds,
            engines,
            crossgrain,
            command: self.command(),
        };
        let bench = bench::bench(&options, &Display::new(self.output.quiet))?;
        let document = bench.document();
        let found = Found {
            checks: document.checks.clone(),
            speeds: bench.speeds(),
            ..Found::default()
        };
        let (text, record) = record::write("bench", &bench, bench.machine.kind(), found)?;
        finish(&self.out, &[page(&document)], RECORD, &text)?;
        let views = &self.output.views;
        views.files.write(&record.job, &document)?;
        tell(views.json, &text, || {
            terminal(&document) + &page_line(&self.out)
        })?;
        Ok(document.exit_code())
    }

    fn command(&self) -> String {
        let options = [
            flag(self.quick, "--quick"),
            flag(self.engine.is_some(), "--engine exec:PATH"),
            self.rounds.map(|rounds| format!("--rounds {rounds}")),
        ];
        with_options("crossgrain bench", options)
    }
}
