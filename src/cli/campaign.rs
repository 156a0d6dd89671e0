//! `crossgrain campaign`: many realizations of a scene.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use super::run::{EngineName, LoopOrder, YadeLimits};
use super::{json, print};
use crate::campaign::compare::{Comparison, Verdict, compare};
use crate::campaign::merge::{Summary, merge};
use crate::campaign::merged;
use crate::campaign::plan::Plan;
use crate::campaign::run::{Job, run};
use crate::campaign::shard::Shard;
use crate::campaign::slurm;
use crate::campaign::status::status;
use crate::engine::native::Mode;
use crate::engine::native::pouring::Softly;
use crate::error::{Error, exit};
use crate::files::failed;
use crate::model::Model;
use crate::model::terms::Kernel;
use crate::progress::Display;
use crate::realization::Runner;
use crate::scene::read_scene;
use crate::statistics::Interval;
use crate::statistics::equivalence::Finding;

#[derive(Debug, Subcommand)]
#[command(after_help = "Examples:\n  crossgrain scene paper > scene.json\n  \
    crossgrain campaign plan scene.json --members 1000 --out thousand\n  \
    crossgrain campaign run thousand\n  \
    crossgrain campaign run thousand --shard 2/8\n  \
    crossgrain campaign merge thousand\n  \
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
    Compare(CompareArguments),
    /// Write the scripts of a Slurm job array and of the merge after it, and print how they are submitted
    Slurm(SlurmArguments),
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
    #[arg(long, value_enum, default_value = "native")]
    engine: EngineName,
    /// Native: which promise it keeps
    #[arg(long, value_enum, default_value = "exact")]
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

#[derive(Debug, Args)]
pub struct CompareArguments {
    /// A merged campaign
    first: PathBuf,
    /// Another one
    second: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
pub struct SlurmArguments {
    /// The campaign's folder, on a file system that all nodes share
    folder: PathBuf,
    /// Tasks of the array; each runs its share of the members one after another
    #[arg(long)]
    tasks: u64,
    /// Members at a time in a task, and processors that it asks for
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// The partition, where the cluster has no default
    #[arg(long)]
    partition: Option<String>,
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
            (EngineName::Native, _) => Runner::Native(self.mode),
            (EngineName::Yade, _) if !self.mode.is_exact() || self.soft_pour => {
                return Err(Error::Usage(
                    "--mode and --soft-pour are of the native engine".to_owned(),
                ));
            }
            (EngineName::Yade, LoopOrder::Sorted) => Runner::YadeSorted,
            (EngineName::Yade, LoopOrder::Ordinary) => Runner::YadeOrdinary,
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
        let code = if status.finished == status.members {
            exit::AGREED
        } else {
            exit::INCOMPLETE
        };
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

impl CompareArguments {
    fn execute(self) -> Result<u8, Error> {
        let first = merged::read(&self.first)?;
        let second = merged::read(&self.second)?;
        let comparison = compare(&first, &second)?;
        print(&if self.json {
            json(&comparison)?
        } else {
            compared_in_words(&comparison)
        })?;
        Ok(match comparison.verdict {
            Verdict::SameBits | Verdict::Equivalent => exit::AGREED,
            Verdict::Different => exit::CHECK_FAILED,
            Verdict::Undecided => exit::INCOMPLETE,
        })
    }
}

fn compared_in_words(comparison: &Comparison) -> String {
    let Comparison { bits, .. } = comparison;
    let mut text = format!(
        "A: {} packings of {}\nB: {} packings of {}\n\nrealizations in both: {}; settled beds with the same bits: {}; \
         last moments with the same bits: {}\n",
        comparison.packings[0],
        comparison.engines[0],
        comparison.packings[1],
        comparison.engines[1],
        bits.common,
        bits.settled,
        bits.last
    );
    if let Some(missed) = comparison.missed {
        let _ = writeln!(
            text,
            "punches that missed the force, B − A: {:.3} ({:.3} to {:.3})",
            missed.estimate, missed.low, missed.high
        );
    }
    if !comparison.quantities.is_empty() {
        let _ = writeln!(
            text,
            "\n{:<46} {:>12} {:>12} {:>34} {:>10}  {:<12} p equal",
            "quantity", "A", "B", "B − A (95 %)", "margin", "finding"
        );
    }
    for of in &comparison.quantities {
        let Interval {
            estimate,
            low,
            high,
        } = of.unpaired.difference;
        let finding = match of.finding {
            Some(Finding::Equivalent) => "equivalent",
            Some(Finding::Different) => "different",
            Some(Finding::Undecided) => "undecided",
            None => "",
        };
        let _ = writeln!(
            text,
            "{:<46} {:>12} {:>12} {:>34} {:>10}  {:<12} {:.3}",
            format!("{} [{}]", of.title, of.unit),
            short(of.first[0]),
            short(of.second[0]),
            format!("{} ({} to {})", short(estimate), short(low), short(high)),
            of.margin.map(short).unwrap_or_default(),
            finding,
            of.distribution_p
        );
    }
    let verdict = match comparison.verdict {
        Verdict::SameBits => "SAME BITS",
        Verdict::Equivalent => "EQUIVALENT",
        Verdict::Different => "DIFFERENT",
        Verdict::Undecided => "UNDECIDED: more packings are needed for these margins",
    };
    let _ = writeln!(text, "{verdict}");
    text
}

/// Four digits.
fn short(value: f64) -> String {
    format!("{value:.4e}")
}

impl SlurmArguments {
    fn execute(self) -> Result<u8, Error> {
        let program = std::env::current_exe().map_err(failed("find", Path::new("this program")))?;
        let scripts = slurm::write(
            &self.folder,
            &slurm::Array {
                tasks: self.tasks,
                threads: self.threads,
                partition: self.partition.as_deref(),
                program: &program,
            },
        )?;
        print(&format!("{}\n", scripts.submit.join("\n")))?;
        Ok(exit::AGREED)
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
