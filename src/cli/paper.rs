//! `crossgrain paper`: what the paper prints that needs no simulation.

use clap::{Args, Subcommand};
use serde_json::json;

use super::job_folder::Results;
use super::report::Views;
use super::{json, tell};
use crate::error::{Error, exit};
use crate::paper::continuum::table::{Continuum, Setup};
use crate::paper::{document, numbers, text_faults};
use crate::report::terminal;

#[derive(Debug, Subcommand)]
#[command(after_help = "Examples:\n  crossgrain paper numbers\n  crossgrain paper continuum")]
pub enum Verb {
    /// Every published number that needs no simulation: published, recomputed, outcome, how
    Numbers(Numbers),
    /// The continuum's stress at the control points: half-space, layer and box, uniform load and rigid punch
    Continuum(Arguments),
}

#[derive(Debug, Args)]
#[command(
    after_help = "What the paper is known to misprint is no failure. Exit code 1: a number differs from both the print and what is known.\n\nExamples:\n  crossgrain paper numbers\n  crossgrain paper numbers --json"
)]
pub struct Numbers {
    #[command(flatten)]
    results: Results,
    #[command(flatten)]
    views: Views,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  crossgrain paper continuum\n  crossgrain paper continuum --height 0.467 --porosity 0.16 --json"
)]
pub struct Arguments {
    /// Height of the bed, m [default: 0.46, as printed]
    #[arg(long)]
    height: Option<f64>,
    /// Porosity for the weight [default: 0.17, as printed]
    #[arg(long)]
    porosity: Option<f64>,
    #[command(flatten)]
    results: Results,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

const NUMBERS: &str = "numbers.json";
const CONTINUUM: &str = "continuum.json";

impl Verb {
    pub fn execute(self) -> Result<u8, Error> {
        match self {
            Verb::Numbers(arguments) => arguments.execute(),
            Verb::Continuum(arguments) => arguments.execute(),
        }
    }
}

impl Numbers {
    fn execute(self) -> Result<u8, Error> {
        self.results.check(NUMBERS)?;
        let (numbers, faults) = (numbers(), text_faults());
        let document = document(&numbers, &faults);
        let text = json(&json!({"numbers": numbers, "text_faults": faults}))?;
        let record = (NUMBERS, text.as_str());
        self.results
            .finish(&self.views, "paper numbers", record, &document)
    }
}

impl Arguments {
    fn execute(self) -> Result<u8, Error> {
        self.results.check(CONTINUUM)?;
        let mut setup = Setup::published();
        setup.height = self.height.unwrap_or(setup.height);
        setup.porosity = self.porosity.unwrap_or(setup.porosity);
        let deepest = setup.points.iter().map(|point| point.depth);
        let deepest = deepest.fold(0.0, f64::max);
        if !(setup.height >= deepest && setup.height.is_finite()) {
            return Err(Error::Usage(format!(
                "--height is {}, and must be at least the control points' depth, {deepest} m",
                setup.height
            )));
        }
        if !(0.0..1.0).contains(&setup.porosity) {
            return Err(Error::Usage(format!(
                "--porosity is {}, and must be at least 0 and below 1",
                setup.porosity
            )));
        }
        let found = Continuum::of(setup);
        let (text, document) = (json(&found)?, found.document());
        tell(self.json, &text, || terminal(&document))?;
        self.results.write(&document, &[(CONTINUUM, &text)])?;
        Ok(exit::AGREED)
    }
}
