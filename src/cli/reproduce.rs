//! `crossgrain reproduce`: the main job.

use std::path::{Path, PathBuf};

use clap::Args;

use super::run::YadeLimits;
use super::{json, print};
use crate::compare::Verdict;
use crate::error::Error;
use crate::files::{failed, free_folder, write_whole};
use crate::interrupt::asked_to_end;
use crate::progress::Display;
use crate::reproduce::record::Reproduction;
use crate::reproduce::{Options, reproduce};
use crate::scene::{paper_scene, read_scene};

/// The folder that is used when none is named; a number is added when it holds a finished job.
const DEFAULT_OUT: &str = "out/reproduce";

#[derive(Debug, Args)]
#[command(
    after_help = "Without YADE the native run is compared with a recorded YADE run. With YADE it also \
    runs live: the sorted loop on one core, two runs of the ordinary loop on the other.\nAn interrupted job \
    is taken up again when it is started with the same --out."
)]
pub struct Arguments {
    /// The folder to write; a finished job in it is never overwritten
    #[arg(long)]
    out: Option<PathBuf>,
    /// Two more realizations, whole, against YADE's sorted loop
    #[arg(long)]
    full: bool,
    /// Another scene than the paper's
    #[arg(long)]
    scene: Option<PathBuf>,
    #[command(flatten)]
    limits: YadeLimits,
    /// No progress
    #[arg(long)]
    quiet: bool,
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        let scene = match &self.scene {
            Some(path) => read_scene(path)?,
            None => paper_scene(1, 5000),
        };
        let out = match &self.out {
            Some(out) if out.join("run.json").exists() => {
                return Err(Error::Usage(format!(
                    "{} holds a finished job; name a folder that does not",
                    out.display()
                )));
            }
            Some(out) if out.join("report.html").exists() && !out.join("native").exists() => {
                return Err(Error::Usage(format!(
                    "{} holds a report.html that is not of this job; name another folder",
                    out.display()
                )));
            }
            Some(out) => out.clone(),
            None => free_folder(Path::new(DEFAULT_OUT), "run.json"),
        };
        std::fs::create_dir_all(&out).map_err(failed("create", &out))?;
        let display = Display::new(self.quiet);
        let options = Options {
            out: out.clone(),
            scene,
            full: self.full,
            ladder: self.scene.is_none(),
            yade: self.limits.options(),
            command: self.command(),
        };
        let (reproduction, runs) = reproduce(&options, &display)?;
        if asked_to_end() {
            return Err(Error::Interrupted);
        }
        write_whole(
            &out.join("scene.json"),
            json(&runs.native.scene)?.as_bytes(),
        )?;
        let page = crate::report::page::render(&reproduction, &runs)?;
        write_whole(&out.join("report.html"), page.as_bytes())?;
        // Last of all: this file says that the job is finished.
        write_whole(&out.join("run.json"), json(&reproduction)?.as_bytes())?;
        print(&in_words(&reproduction, &out))?;
        Ok(super::exit_code(reproduction.verdict))
    }

    fn command(&self) -> String {
        let mut command = "crossgrain reproduce".to_owned();
        if self.full {
            command += " --full";
        }
        if self.scene.is_some() {
            command += " --scene scene.json";
        }
        command
    }
}

fn in_words(reproduction: &Reproduction, out: &Path) -> String {
    let mut text = String::new();
    for named in &reproduction.comparisons {
        let verdict = super::in_a_word(named.comparison.verdict());
        text += &format!("\n{}: {verdict}\n", named.title);
        for check in &named.comparison.checks {
            text += &super::compare::check_line(check);
        }
        if let Some(first) = &named.comparison.first_difference {
            text += &format!("         first difference: {first}\n");
        }
    }
    text += "\nfaults put in:\n";
    for fault in &reproduction.faults {
        let mark = match fault.verdict {
            Verdict::Pass => "found",
            Verdict::Fail => "MISSED",
            Verdict::NotMade => "not made",
        };
        text += &format!("{mark:>8} {}: {}\n", fault.fault, fault.found);
    }
    if let Some(ladder) = &reproduction.ladder {
        text += &super::verify::summary(ladder);
    }
    for not_made in &reproduction.not_made {
        text += &format!("not made {}: {}\n", not_made.what, not_made.why);
    }
    text += "\nruns:\n";
    for run in &reproduction.runs {
        let times = match run.times_native {
            Some(times) => format!("{times:.1} times native"),
            None => "made on another machine".to_owned(),
        };
        text += &format!(
            "{:>10.1} µs a step, {times}: {}, {}\n",
            run.microseconds_per_step, run.engine, run.stages
        );
    }
    let tally = reproduction.tally();
    text += &format!(
        "\n{}: {} checks passed, {} failed, {} not made; {} s\nreport: {}\n",
        super::in_a_word(reproduction.verdict),
        tally.passed,
        tally.failed,
        tally.not_made,
        reproduction.seconds.round(),
        out.join("report.html").display()
    );
    text
}
