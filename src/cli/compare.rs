//! `crossgrain compare`: two run folders side by side.

use std::path::PathBuf;

use clap::Args;

use super::engine::beside;
use super::job_folder::Results;
use super::report::Output;
use super::run::YadeLimits;
use super::{json, unless_ended};
use crate::compare::bits::differing_keys;
use crate::compare::first_difference::Locator;
use crate::compare::{compare, compare_as};
use crate::error::Error;
use crate::progress::Display;
use crate::run::folder::RunFolder;

#[derive(Debug, Args)]
#[command(
    after_help = "The verdict: identical, equal to rounding, different, or undecided. Where both runs add forces in the same \
    order (native, YADE sorted), every bit must agree; if not, both engines are run again to find the first step and grain.\nWhere \
    they do not, both engines are run again for their first hundred steps from states of these very runs, under the scene's own model, and \
    both histories and ends are held against native runs with rounding errors.\n\n\
    Exit codes: 0 identical or equal to rounding; 1 different; 2 usage, or the scenes differ; 3 undecided.\n\nExamples:\n  \
    crossgrain compare yade native\n  crossgrain compare mine native --engine exec:./mine"
)]
pub struct Arguments {
    /// The run folder that is judged
    a: PathBuf,
    /// The run folder that it is held against
    b: PathBuf,
    /// Every bit must agree, whichever engines they are: for two engines of the same law, as the adapters of LAMMPS and
    /// LIGGGHTS with one radius
    #[arg(long)]
    expect_bits: bool,
    /// Do not run engines again
    #[arg(long)]
    no_locate: bool,
    /// exec:PATH, where the engine of a run folder is, so that it can be run again; twice for
    /// two of them
    #[arg(long, value_parser = beside)]
    engine: Vec<PathBuf>,
    #[command(flatten)]
    results: Results,
    #[command(flatten)]
    output: Output,
    #[command(flatten)]
    limits: YadeLimits,
}

const RECORD: &str = "compare.json";

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        self.results.check(RECORD)?;
        let a = RunFolder::read(&self.a)?;
        let b = RunFolder::read(&self.b)?;
        let differing = differing_keys(&a.scene, &b.scene);
        if !differing.is_empty() {
            return Err(Error::Usage(format!(
                "these are runs of two scenes, which differ in {}; compare takes two runs of one scene",
                differing.join(", ")
            )));
        }
        let programs = self.engine.iter();
        let programs = programs.map(|program| self.limits.exec(program.clone()));
        let locator = (!self.no_locate).then(|| Locator {
            yade: self.limits.options(),
            programs: programs.collect(),
        });
        let task = Display::new(self.output.quiet).task("compare");
        let mut comparison = if self.expect_bits {
            compare_as(&a, &b, true, locator.as_ref())
        } else {
            compare(&a, &b, locator.as_ref())
        };
        task.done("done");
        comparison.tell_apart([&self.a, &self.b]);
        let (text, document) = (json(&comparison)?, comparison.document());
        self.output.views.tell("compare", &text, &document)?;
        unless_ended()?;
        self.results.write(&document, &[(RECORD, &text)])?;
        Ok(document.verdict.exit_code())
    }
}
