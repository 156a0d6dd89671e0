//! `crossgrain engine`: what an engine that somebody brings is, and what is wrong with it.

use clap::{Args, Subcommand};

use super::chosen::Chosen;
use super::compare::mark;
use super::run::YadeLimits;
use super::{json, print};
use crate::compare::Verdict;
use crate::error::{Error, exit};
use crate::interrupt::asked_to_end;
use crate::progress::Display;
use crate::suite::brought::{Examination, examine};

#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Run a few tiny jobs in exec:PATH and say in plain words what is wrong with it
    Check(Arguments),
}

#[derive(Debug, Args)]
#[command(
    after_help = "Exit codes: 0 sound; 1 a check failed; 2 usage; 4 the engine failed (it crashed, hung or was not \
    understood).\n\nExamples:\n  crossgrain engine check exec:adapters/toy.py\n  crossgrain engine check exec:./mine"
)]
pub struct Arguments {
    /// exec:PATH, a program that speaks the engine protocol (docs/engine-protocol.md)
    engine: Chosen,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// No progress
    #[arg(long)]
    quiet: bool,
    #[command(flatten)]
    limits: YadeLimits,
}

impl Verb {
    pub fn execute(self) -> Result<u8, Error> {
        match self {
            Verb::Check(arguments) => arguments.execute(),
        }
    }
}

impl Arguments {
    fn execute(self) -> Result<u8, Error> {
        let Chosen::Exec(program) = self.engine else {
            return Err(Error::Usage(
                "only an engine that is brought is checked: exec:PATH; for the others there is `crossgrain verify`"
                    .to_owned(),
            ));
        };
        let display = Display::new(self.quiet);
        let task = display.task("engine check");
        let found = examine(&self.limits.exec(program), &mut |name| {
            task.share(0.0, name)
        })?;
        task.done("done");
        if asked_to_end() {
            return Err(Error::Interrupted);
        }
        print(&if self.json {
            json(&found)?
        } else {
            in_words(&found)
        })?;
        Ok(match found.verdict() {
            Verdict::Fail if found.engine_failed() => exit::ENGINE_FAILED,
            Verdict::Fail => exit::CHECK_FAILED,
            Verdict::Pass => exit::AGREED,
            Verdict::NotMade => exit::INCOMPLETE,
        })
    }
}

fn in_words(found: &Examination) -> String {
    let engine = &found.engine;
    let parts: Vec<&str> = engine.parts.iter().map(|part| part.name()).collect();
    let mut text = format!("{}: {}\n", engine.label(), parts.join(", "));
    for approximation in &engine.approximations {
        text += &format!("it says of itself: {approximation}\n");
    }
    text += "\n";
    for check in &found.checks {
        text += &format!(
            "{} {}: {}\n{:>9}{}\n",
            mark(check.verdict),
            check.name,
            check.job,
            "",
            check.found.trim_end()
        );
    }
    let verdict = match found.verdict() {
        Verdict::Pass => "SOUND: what was checked is right; what was not made is not known",
        Verdict::Fail => "NOT SOUND: mend the first failure first, the others may come from it",
        Verdict::NotMade => "NOTHING CHECKED",
    };
    text + &format!("\n{verdict}\n")
}
