//! `crossgrain verify`: the ladder of exact solutions, symmetries and bits.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::chosen::Several;
use super::compare::mark;
use super::job_folder::write_new;
use super::run::YadeLimits;
use super::{in_a_word, json, tell};
use crate::checks::number_repeated;
use crate::checks::record::{Found, Whole};
use crate::compare::Verdict;
use crate::error::Error;
use crate::files::refuse_existing;
use crate::interrupt::asked_to_end;
use crate::limits::bench::machine::Machine;
use crate::progress::Display;
use crate::report::verification;
use crate::suite::checks::of_rungs;
use crate::suite::ladder::Climbed;
use crate::suite::limits::{Limit, Limits};
use crate::suite::record::{Options, Tally, Verification, verify, verify_exec};

#[derive(Debug, Args)]
#[command(
    after_help = "Every rung is run by both engines and judged by the same code; YADE runs all cases in \
    one process. Without YADE its rungs are shown as not made, and the exit code is 3.\n\nExamples:\n  \
    crossgrain verify\n  crossgrain verify --engine native\n  crossgrain verify --engine exec:adapters/lammps.py\n  crossgrain verify --detection-limits --out verified"
)]
pub struct Arguments {
    /// native, yade or both; or exec:PATH, a program that speaks the engine protocol (docs/engine-protocol.md)
    #[arg(long, default_value = "both")]
    engine: Several,
    /// Find the smallest size of each fault that each rung notices
    #[arg(long)]
    detection_limits: bool,
    /// Trajectories and rounding errors of so many grains at most
    #[arg(long, default_value_t = 5000, value_parser = sizes())]
    grains: u32,
    /// A new folder for verify.json and report.html
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

/// The sizes of trajectories.
fn sizes() -> impl TypedValueParser<Value = u32> {
    PossibleValuesParser::new(["5", "500", "5000"]).map(|text| text.parse().unwrap_or(5000))
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        if let Some(out) = &self.out {
            refuse_existing(out)?;
        }
        let display = Display::new(self.quiet);
        let verification = match &self.engine {
            Several::BuiltIn(engine) => {
                let options = Options {
                    engine: *engine,
                    grains: self.grains,
                    detection_limits: self.detection_limits,
                    yade: self.limits.options(),
                    command: self.command(),
                };
                verify(&options, &display)?
            }
            Several::Exec(_) if self.detection_limits => {
                return Err(Error::Usage(
                    "--detection-limits puts faults into the native engine; an engine that is brought has none of them"
                        .to_owned(),
                ));
            }
            Several::Exec(program) => {
                let options = self.limits.exec(program.clone());
                verify_exec(&options, self.command(), &display)?
            }
        };
        if asked_to_end() {
            return Err(Error::Interrupted);
        }
        let mut checks = of_rungs(&verification.rungs);
        number_repeated(&mut checks);
        let text = json(&Whole::of(
            "verify",
            &verification,
            Machine::this().kind(),
            Found {
                checks,
                ..Found::default()
            },
        ))?;
        tell(self.json, &text, || in_words(&verification))?;
        if let Some(out) = &self.out {
            let page = verification::page(&verification)?;
            write_new(out, "verify.json", &text, &page)?;
        }
        Ok(super::exit_code(verification.verdict))
    }

    fn command(&self) -> String {
        let engine = self.engine.name();
        if let Several::Exec(_) = self.engine {
            return format!("crossgrain verify --engine {engine}");
        }
        let limits = if self.detection_limits {
            " --detection-limits"
        } else {
            ""
        };
        format!(
            "crossgrain verify --engine {engine} --grains {}{limits}",
            self.grains
        )
    }
}

/// The verification as lines for a terminal.
fn in_words(verification: &Verification) -> String {
    let mut text = String::new();
    if let Some(engine) = &verification.exec {
        text += &format!("{}\n", engine.label());
        for approximation in &engine.approximations {
            text += &format!("it says of itself: {approximation}\n");
        }
    }
    for rung in &verification.rungs {
        text += &rung_lines(rung);
    }
    if let Some(limits) = &verification.limits {
        text += &limit_lines(limits);
    }
    let verdict = in_a_word(verification.verdict);
    text + &format!("\n{verdict}: {}\n", counts(verification.tally))
}

fn counts(tally: Tally) -> String {
    let Tally {
        passed,
        failed,
        not_made,
        inapplicable,
    } = tally;
    format!(
        "{passed} rungs passed, {failed} failed, {not_made} not made, {inapplicable} of options that \
         the engine does not have"
    )
}

/// The ladder in short: its counts, and what failed.
pub fn summary(verification: &Verification) -> String {
    let mut text = format!("\nladder: {}\n", counts(verification.tally));
    for rung in &verification.rungs {
        if rung.verdict == Verdict::Fail {
            text += &rung_lines(rung);
        }
    }
    text
}

fn rung_lines(rung: &Climbed) -> String {
    let mut text = format!(
        "{} {} [{}]: {}\n",
        mark(rung.verdict),
        rung.name,
        rung.engine,
        rung.title
    );
    if !rung.reason.is_empty() {
        text += &format!("{:>12}{}\n", "", rung.reason);
    }
    for line in &rung.lines {
        text += &format!(
            "{:>12}{} {} = {:e}, expected {:e} ± {:.1e} {} ({})\n",
            "",
            if line.holds() { "ok" } else { "NOT" },
            line.quantity,
            line.value,
            line.expected,
            line.tolerance,
            if line.unit == "1" { "" } else { &line.unit },
            line.basis
        );
    }
    text
}

/// The table of detection limits, a rung a row, powers of ten.
fn limit_lines(limits: &Limits) -> String {
    let mut text = "\nsmallest relative size noticed, as a power of ten (· not in the rung, – not \
                    noticed, x noticed)\n"
        .to_owned();
    for (index, fault) in limits.faults.iter().enumerate() {
        text += &format!("{:>6} {fault}\n", index + 1);
    }
    text += &format!("{:<40}", "rung");
    for index in 1..=limits.faults.len() {
        text += &format!("{index:>6}");
    }
    text += "   false alarms\n";
    for row in &limits.rungs {
        text += &format!("{:<40}", row.rung);
        for limit in &row.limits {
            let cell = match limit {
                Limit::Without => "·".to_owned(),
                Limit::Blind => "–".to_owned(),
                Limit::Notices => "x".to_owned(),
                Limit::From { size } => format!("{:.1}", size.log10()),
            };
            text += &format!("{cell:>6}");
        }
        text += &format!("   {} of {}\n", row.false_alarms, row.sound_runs);
    }
    text
}
