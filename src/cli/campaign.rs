//! `crossgrain campaign`: many realizations of a scene.

mod compare;
mod slurm;

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::chosen::BuiltIn;
use super::run::{LoopOrder, YadeLimits};
use super::{exit_code_if, json, print};
use crate::error::{Error, exit};
use crate::progress::Display;
use crate::run::scene_file::read_scene;
use crate::study::campaign::merge::{Summary, merge};
use crate::study::campaign::plan::Plan;
use crate::study::campaign::run::{Job, run};
use crate::study::campaign::shard::Shard;
use crate::study::campaign::status::status;
use crate::study::realization::Runner;
use grains::model::Model;
use grains::model::terms::Kernel;
use grains::native::Mode;
use grains::native::pouring::Softly;

#[derive(Debug, Subcommand)]
#[command(after_help = "Examples:\n  crossgrain scene paper > scene.json\n  \
    crossgrain campaign plan scene.json --members 1000 --out thousand\n  \
    crossgrain campaign run thousand\n  \
    crossgrain campaign run thousand --shard 2/8\n  \
    crossgrain campaign status thousand\n  \
    crossgrain campaign merge thousand\n  \
    crossgrain campaign compare thousand in-yade\n  \
    crossgrain campaign slurm thousand --tasks 20\n  \
    crossgrain claims thousand")]
pub enum Verb {
    /// Fix what is run: scene, engine, seed and number of members
    Plan(PlanArguments),
    /// Run the members of a shard that are missing; without --shard all, and then merge them
    Run(RunArguments),
    /// How far it is
    Status(StatusArguments),
    /// Put the members of a finished campaign into one file
    Merge(MergeArguments),
    /// Two merged campaigns of one scene, such as of two engines: bits of common realizations, else equivalence
    Compare(compare::Arguments),
    /// Write the scripts of a Slurm job array and of the merge after it, and print how they are submitted
    Slurm(slurm::Arguments),
}

#[derive(Debug, Args)]
pub struct PlanArguments {
    /// The scene file
    scene: PathBuf,
    /// How many realizations
    #[arg(long)]
    members: u64,
    /// Realization of member 1; the next members have the next ones
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// native or yade
    #[arg(long, default_value = "native")]
    engine: BuiltIn,
    /// Native: which promise it keeps
    #[arg(long, default_value = "exact")]
    mode: Mode,
    /// Native: pour at a tenth of the modulus and stiffen, as in `crossgrain run --soft-pour`
    #[arg(long)]
    soft_pour: bool,
    /// YADE: order in which interactions are visited
    #[arg(long = "loop", value_enum, default_value = "ordinary")]
    order: LoopOrder,
    /// The campaign's folder; must not exist
    #[arg(long)]
    out: PathBuf,
}

#[derive(Debug, Args)]
pub struct RunArguments {
    /// The campaign's folder
    folder: PathBuf,
    /// I/N: every N-th member from the I-th on; auto: by the variables of a Slurm job array
    #[arg(long)]
    shard: Option<String>,
    /// Members at a time [default: the machine's cores; with --shard 1]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    #[command(flatten)]
    limits: YadeLimits,
    /// No progress
    #[arg(long)]
    quiet: bool,
}

#[derive(Debug, Args)]
pub struct StatusArguments {
    /// The campaign's folder
    folder: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
pub struct MergeArguments {
    /// The campaign's folder
    folder: PathBuf,
}

impl Verb {
    pub fn execute(self) -> Result<u8, Error> {
        match self {
            Verb::Plan(arguments) => arguments.execute(),
            Verb::Run(arguments) => arguments.execute(),
            Verb::Status(arguments) => arguments.execute(),
            Verb::Compare(arguments) => arguments.execute(),
            Verb::Merge(arguments) => {
                let summary = merge(&arguments.folder)?;
                print(&in_words(&summary))?;
                Ok(exit::AGREED)
            }
            Verb::Slurm(arguments) => arguments.execute(),
        }
    }
}

impl PlanArguments {
    fn execute(self) -> Result<u8, Error> {
        let scene = read_scene(&self.scene)?;
        let general = Kernel::of(&Model::of(&scene).law) == Kernel::General;
        if general && !self.mode.is_exact() {
            return Err(Error::Usage(format!(
                "--mode {} is for frictionless scenes without dashpots; leave it away",
                self.mode.name()
            )));
        }
        let runner = match (self.engine, self.order) {
            (BuiltIn::Native, _) => Runner::Native(self.mode),
            (BuiltIn::Yade, _) if !self.mode.is_exact() || self.soft_pour => {
                return Err(Error::Usage(
                    "--mode and --soft-pour are of the native engine".to_owned(),
                ));
            }
            (BuiltIn::Yade, LoopOrder::Sorted) => Runner::YadeSorted,
            (BuiltIn::Yade, LoopOrder::Ordinary) => Runner::YadeOrdinary,
        };
        let phases = if self.soft_pour {
            let softly = Softly::tested(&scene).ok_or_else(|| {
                Error::Usage("--soft-pour needs /time_step as a fraction".to_owned())
            })?;
            softly.phases(&scene)
        } else {
            Vec::new()
        };
        let plan = Plan::new(&scene, runner, phases, self.members, self.seed)?;
        plan.write(&self.out)?;
        print(&format!(
            "{} members of {:?} in {}, realizations {} to {}; plan {}\nrun it: crossgrain campaign run {}\n",
            plan.members,
            plan.scene.name,
            plan.runner.name(),
            plan.realization(1),
            plan.realization(plan.members),
            &plan.digest()[..16],
            self.out.display()
        ))?;
        Ok(exit::AGREED)
    }
}

impl RunArguments {
    fn execute(self) -> Result<u8, Error> {
        let shard = match self.shard.as_deref() {
            None => Shard::WHOLE,
            Some("auto") => {
                Shard::from_slurm(|name| std::env::var(name).ok()).map_err(Error::Usage)?
            }
            Some(text) => text.parse().map_err(Error::Usage)?,
        };
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let threads = match self.threads {
            Some(threads) => usize::from(threads),
            None if self.shard.is_some() => 1,
            None => cores,
        };
        let job = Job {
            folder: &self.folder,
            shard,
            threads,
            yade: &self.limits.options(),
        };
        let done = run(&job, &Display::new(self.quiet))?;
        print(&format!(
            "shard {shard}: {} members, {} of them finished before\n",
            done.wanted, done.before
        ))?;
        if shard == Shard::WHOLE {
            print(&in_words(&merge(&self.folder)?))?;
        } else if done.complete {
            print(&format!(
                "all members are finished; merge them: crossgrain campaign merge {}\n",
                self.folder.display()
            ))?;
        }
        Ok(exit::AGREED)
    }
}

impl StatusArguments {
    /// Exit code 0 if no member is missing, else 3.
    fn execute(self) -> Result<u8, Error> {
        let status = status(&self.folder)?;
        let code = exit_code_if(status.finished == status.members);
        if self.json {
            print(&json(&status)?)?;
            return Ok(code);
        }
        let mut text = format!(
            "{}: {} of {} members finished{}\n",
            status.runner,
            status.finished,
            status.members,
            if status.merged { ", merged" } else { "" }
        );
        for (file, records) in &status.files {
            let _ = writeln!(text, "  {file}: {records}");
        }
        if status.repeated > 0 {
            let _ = writeln!(
                text,
                "  {} records repeat a member; it counts once",
                status.repeated
            );
        }
        for (file, line) in &status.damaged {
            let _ = writeln!(
                text,
                "  {file} line {line} is no whole record and is not believed"
            );
        }
        if !status.missing.is_empty() {
            let _ = writeln!(text, "missing: members {}", status.missing);
        }
        print(&text)?;
        Ok(code)
    }
}

fn in_words(summary: &Summary) -> String {
    let endings = summary.endings.iter();
    let endings: Vec<String> = endings
        .map(|(how, count)| format!("{count} {how}"))
        .collect();
    // None where it gave up on every member.
    let engine = match summary.engine.as_str() {
        "" => String::new(),
        engine => format!(" of {engine}"),
    };
    format!(
        "merged {} members{engine}: {}; sha256 {}\n",
        summary.members,
        endings.join(", "),
        &summary.sha256[..16]
    )
}
