//! `crossgrain bench`: all engines side by side on one bed.

use std::path::{Path, PathBuf};

use clap::Args;

use super::chosen::Beside;
use super::job_folder::{JobFolder, page_line};
use super::run::YadeLimits;
use super::{print, tell};
use crate::checks::record::{self, Found};
use crate::error::{Error, exit};
use crate::limits::bench::checks;
use crate::limits::bench::goals::Goal;
use crate::limits::bench::limits::Bound;
use crate::limits::bench::rounds::Contest;
use crate::limits::bench::{self, Bench, Options, one};
use crate::progress::Display;
use grains::native::Mode;

const FOLDER: JobFolder = JobFolder {
    what: "benchmark",
    usual: "out/bench",
    record: "bench.json",
    keeps_members: false,
};

#[derive(Debug, Args)]
#[command(
    after_help = "Engines that are not installed are shown as not made. Goals that are met or not are findings; the \
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
    #[arg(long)]
    engine: Option<Beside>,
    /// The folder to write; a finished benchmark in it is never overwritten
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
    /// Time the bed in this folder in this process and say so: for the parts that need a process of their own
    #[arg(long, hide = true)]
    one: Option<PathBuf>,
    #[arg(long, hide = true, default_value = "exact")]
    one_mode: Mode,
    #[arg(long, hide = true, default_value_t = 1000)]
    one_steps: u64,
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        if let Some(folder) = &self.one {
            let one = one::run(folder, self.one_mode, self.one_steps)?;
            let line = serde_json::to_string(&one);
            print(&(line.map_err(|error| Error::Report(error.to_string()))? + "\n"))?;
            return Ok(exit::AGREED);
        }
        let brought = match &self.engine {
            Some(Beside(program)) => Some(self.limits.brought(program)?),
            None => None,
        };
        let (out, _lock) = FOLDER.open(self.out.as_deref())?;
        let crossgrain = std::env::current_exe()
            .map_err(|error| Error::Program(format!("this program cannot be found: {error}")))?;
        let options = Options {
            out: out.clone(),
            quick: self.quick,
            rounds: self.rounds.unwrap_or(Options::usual_rounds(self.quick)),
            yade: self.limits.options(),
            brought,
            crossgrain,
            command: self.command(),
        };
        let bench = bench::bench(&options, &Display::new(self.quiet))?;
        let (text, _) = record::write(
            "bench",
            &bench,
            bench.machine.kind(),
            Found {
                checks: checks::all(&bench),
                speeds: checks::speeds(&bench),
                ..Found::default()
            },
        )?;
        let page = crate::report::bench::page(&bench)?;
        FOLDER.finish(&out, &page, &text)?;
        tell(self.json, &text, || in_words(&bench, &out))?;
        Ok(if bench.engine_failed() {
            exit::ENGINE_FAILED
        } else {
            bench.verdict.exit_code()
        })
    }

    fn command(&self) -> String {
        let mut command = "crossgrain bench".to_owned();
        if self.quick {
            command += " --quick";
        }
        if self.engine.is_some() {
            command += " --engine exec:PATH";
        }
        if let Some(rounds) = self.rounds {
            command += &format!(" --rounds {rounds}");
        }
        command
    }
}

fn in_words(bench: &Bench, out: &Path) -> String {
    let machine = &bench.machine;
    let load = machine
        .load
        .map_or(String::new(), |load| format!(", load {load} before"));
    let mut text = format!(
        "{}, {} processors, {}{load}\n\n{:<26} {:>10}  {:>17} {:>8}  {:>22} {:>9} {:>10}  bed\n",
        machine.processor,
        machine.processors,
        machine.vector_unit,
        "the settled bed of 5,000",
        "µs a step",
        "least to most",
        "of clock",
        "times native exact",
        "contacts",
        "moved, R",
    );
    for contest in &bench.contests {
        text += &contest_line(contest);
        for approximation in &contest.approximations {
            text += &format!("{:>4}it says of itself: {approximation}\n", "");
        }
    }
    if let Some(bits) = &bench.sorted_bits {
        text += &format!("native exact against YADE's sorted loop: {bits}\n");
    }
    text += "\nwhere a native exact step's time goes:";
    for share in &bench.stages {
        text += &format!(" {} {:.0} %,", share.stage, 100.0 * share.share);
    }
    text += &format!(" a list for {:.0} steps\n", bench.bed.steps_per_build);
    for distance in &bench.distances {
        let bounds = distance.bounds.iter().map(|bound| {
            let Bound {
                resource,
                distance,
                seconds,
            } = bound;
            format!(
                "{resource} {distance:.1} (at least {:.1} µs)",
                1e6 * seconds
            )
        });
        let bounds: Vec<String> = bounds.collect();
        text += &format!(
            "\nlimits at {} grains, times above: {}",
            distance.grains,
            bounds.join(", ")
        );
    }
    text += "\n\n";
    for of in &bench.instructions {
        text += &format!(
            "{:<26} {:>12.0} instructions a step, {:>7.1} a listed pair, {:.2} times native exact\n",
            of.name, of.per_step, of.per_listed_pair, of.over_exact
        );
    }
    text += &size_table(bench);
    text += "\ngoals (findings, no checks):\n";
    if bench.disturbed {
        text += "   the machine was busy with other things: measure again before believing any of these\n";
    }
    for goal in &bench.goals {
        text += &goal_line(goal);
    }
    for missed in &bench.missed {
        let word = if missed.failed { "FAILED" } else { "skipped" };
        text += &format!("{word}: {}: {}\n", missed.what, missed.why);
    }
    text + &format!(
        "\n{}: {:.0} s\n{}",
        bench.verdict.verdict_word(),
        bench.seconds,
        page_line(out)
    )
}

fn contest_line(contest: &Contest) -> String {
    let time = &contest.seconds_per_step;
    let over = contest.over_exact.as_ref();
    let ratio = over.map_or(String::new(), |over| {
        format!("{:.2} ({:.2} to {:.2})", over.median, over.least, over.most)
    });
    let share = contest.processor_share;
    format!(
        "{:<26} {:>10.2}  {:>8.2} {:>8.2} {:>8}  {ratio:>22} {:>9} {:>10.1e}  {}\n",
        contest.name,
        1e6 * time.median,
        1e6 * time.least,
        1e6 * time.most,
        share.map_or("?".to_owned(), |share| format!("{:.0} %", 100.0 * share)),
        contest.sanity.contacts,
        contest.sanity.displacement,
        if contest.sanity.holds {
            "sane"
        } else {
            "NOT THE BED"
        }
    )
}

fn size_table(bench: &Bench) -> String {
    let mut sizes: Vec<u32> = bench.scaling.iter().map(|point| point.grains).collect();
    sizes.sort_unstable();
    sizes.dedup();
    let mut text = format!("\n{:<28}", "ns a step and grain");
    for size in &sizes {
        text += &format!("{size:>15}");
    }
    text += "\n";
    let mut names: Vec<&str> = Vec::new();
    for point in &bench.scaling {
        if !names.contains(&point.name.as_str()) {
            names.push(&point.name);
        }
    }
    for name in names {
        text += &format!("{name:<28}");
        for size in &sizes {
            let of = bench.scaling.iter();
            let mut of = of.filter(|point| point.name == name && point.grains == *size);
            let cell = of.next().map_or(String::new(), |point| {
                let memory = point.peak_memory.map_or(String::new(), |bytes| {
                    format!("{:.0} MB", bytes as f64 / 1e6)
                });
                format!("{:.2}, {memory}", 1e9 * point.seconds_per_grain)
            });
            text += &format!("{cell:>15}");
        }
        text += "\n";
    }
    text
}

fn goal_line(goal: &Goal) -> String {
    let word = match goal.met {
        Some(true) => "met",
        Some(false) => "not met",
        None => "skipped",
    };
    let measured = goal
        .measured
        .map_or(String::new(), |value| format!("{value:.2}, "));
    let bound = if goal.at_least { "at least" } else { "at most" };
    format!(
        "{word:>9}  {}: {measured}goal {bound} {}\n",
        goal.goal, goal.bound
    )
}
