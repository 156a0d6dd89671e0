//! `crossgrain engine`: whether an external engine does what the protocol and the model say.

use clap::{Args, Subcommand};

use super::chosen::Chosen;
use super::json;
use super::report::Output;
use super::run::YadeArguments;
use crate::checks::Outcome;
use crate::compare::first_steps::OfBed;
use crate::error::{Error, exit};
use crate::interrupt::asked_to_end;
use crate::progress::Display;
use crate::suite::conformance::{conformance, of_yade};
use verdict::starts::DISPERSION;

#[derive(Debug, Subcommand)]
#[command(after_help = "Example:\n  crossgrain engine check exec:adapters/toy.py")]
pub enum Verb {
    /// Say whether an engine is the model's engine to the bit or to rounding, and what is wrong if it is not
    Check(Arguments),
}

#[derive(Debug, Args)]
#[command(
    after_help = "Exit codes: 0 identical or equal to rounding; 1 different; 2 usage; 3 undecided; 4 the engine failed (it crashed, hung or was not \
    understood).\n\nExamples:\n  crossgrain engine check exec:adapters/toy.py\n  crossgrain engine check exec:./mine\n  crossgrain engine check yade --loop ordinary"
)]
pub struct Arguments {
    /// yade, or exec:PATH, a program that speaks the engine protocol (docs/engine-protocol.md)
    engine: Chosen,
    /// Grains of the bed whose first steps are judged
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(50..=100_000))]
    grains: u32,
    /// How much the radii of the bed differ, as a share of their mean; 0 for an engine that has one radius
    #[arg(long, default_value_t = DISPERSION, value_parser = dispersion)]
    dispersion: f64,
    #[command(flatten)]
    output: Output,
    #[command(flatten)]
    yade: YadeArguments,
}

/// Grains of a bed that stays a bed.
fn dispersion(text: &str) -> Result<f64, String> {
    let of: f64 = text.parse().map_err(|_| "it is a number".to_owned())?;
    let fits = (0.0..=0.3).contains(&of);
    fits.then_some(of)
        .ok_or_else(|| "it is 0 to 0.3".to_owned())
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
        if matches!(self.engine, Chosen::Native) {
            return Err(Error::Usage(
                "the native engine is what others are held against: yade, or exec:PATH; `crossgrain verify` verifies it"
                    .to_owned(),
            ));
        }
        let display = Display::new(self.output.quiet);
        let task = display.task("engine check");
        let bed = OfBed {
            grains: self.grains,
            dispersion: self.dispersion,
        };
        let mut progress = |name: &str| task.share(0.0, name);
        let found = match self.engine {
            Chosen::Exec(program) => {
                conformance(&self.yade.limits.exec(program), bed, &mut progress)
            }
            _ => of_yade(&self.yade.options()?, bed, &mut progress),
        }?;
        task.done("done");
        if asked_to_end() {
            return Err(Error::Interrupted);
        }
        self.output
            .tell("engine check", &json(&found)?, &found.document())?;
        Ok(match found.outcome() {
            Outcome::Fail if found.engine_failed => exit::ENGINE_FAILED,
            outcome => outcome.exit_code(),
        })
    }
}
