//! `crossgrain verify`: the verification suite.

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::engine::{Several, name, several};
use super::job_folder::Results;
use super::report::Output;
use super::run::YadeLimits;
use super::{flag, unless_ended, with_options};
use crate::checks::record;
use crate::compare::first_steps::Beds;
use crate::engine::named::Named;
use crate::error::Error;
use crate::limits::bench::machine::Machine;
use crate::progress::Display;
use crate::report::disc_field::of_figure_4;
use crate::suite::run::{Options, verify, verify_in};

#[derive(Debug, Args)]
#[command(
    after_help = "Every case is run by both engines and judged by the same code; YADE runs all cases in \
    one process. Without YADE its cases are skipped, and the exit code is 3.\n\nExamples:\n  \
    crossgrain verify\n  crossgrain verify --engine native\n  crossgrain verify --engine exec:adapters/lammps.py\n  crossgrain verify --detection-limits --out verified"
)]
pub struct Arguments {
    /// native, yade or both; or exec:PATH, a program that speaks the engine protocol (docs/engine-protocol.md)
    #[arg(long, default_value = "both", value_parser = several)]
    engine: Several,
    /// Find the smallest size of each fault that each case detects
    #[arg(long)]
    detection_limits: bool,
    /// Trajectories and rounding errors of so many grains at most
    #[arg(long, default_value_t = 5000, value_parser = sizes())]
    grains: u32,
    #[command(flatten)]
    results: Results,
    #[command(flatten)]
    output: Output,
    #[command(flatten)]
    limits: YadeLimits,
}

const RECORD: &str = "verify.json";

/// The sizes of trajectories.
fn sizes() -> impl TypedValueParser<Value = u32> {
    PossibleValuesParser::new(["5", "500", "5000"]).map(|text| text.parse().unwrap_or(5000))
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        self.results.check(RECORD)?;
        let display = Display::new(self.output.quiet);
        let verification = match &self.engine[..] {
            [Named::Exec(_)] if self.detection_limits => {
                return Err(Error::Usage(
                    "--detection-limits puts faults into the native engine; an external engine has none of them"
                        .to_owned(),
                ));
            }
            [Named::Exec(program)] => {
                let engine = self.limits.external(program)?;
                // One radius, so that an engine with a stiffness for each can take part.
                let beds = Beds::new(1000, 0.0);
                verify_in(&engine, &beds, &self.command(), &display)?
            }
            engines => {
                let with_yade = engines.contains(&Named::Yade(None));
                let options = Options {
                    native: engines.contains(&Named::Native),
                    yade: with_yade.then(|| self.limits.options()),
                    grains: self.grains,
                    detection_limits: self.detection_limits,
                    command: self.command(),
                };
                verify(&options, &display)?
            }
        };
        unless_ended()?;
        let (found, machine) = (verification.checks()[..].into(), Machine::this().kind());
        let (text, record) = record::write("verify", &verification, machine, found)?;
        let mut document = verification.document();
        document.sections.push(of_figure_4());
        self.output.views.tell(&record.job, &text, &document)?;
        self.results.write(&document, &[(RECORD, &text)])?;
        Ok(verification.verdict().exit_code())
    }

    fn command(&self) -> String {
        let is_built_in = !matches!(self.engine[..], [Named::Exec(_)]);
        let options = [
            Some(format!("--engine {}", name(&self.engine))),
            is_built_in.then(|| format!("--grains {}", self.grains)),
            flag(self.detection_limits, "--detection-limits"),
        ];
        with_options("crossgrain verify", options)
    }
}
