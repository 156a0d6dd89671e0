//! `crossgrain compare`: two run folders side by side.

use std::path::PathBuf;

use clap::Args;

use super::chosen::Beside;
use super::json;
use super::report::Output;
use super::run::YadeLimits;
use crate::compare::first_difference::Locator;
use crate::compare::{ReferenceScatter, compare, compare_as};
use crate::error::Error;
use crate::interrupt::asked_to_end;
use crate::progress::Display;
use crate::reproduce::rounding_scatter;
use crate::run::folder::RunFolder;
use crate::run::folder::record::EngineRecord;

#[derive(Debug, Args)]
#[command(
    after_help = "Where both runs add forces in the same order (native, YADE sorted), every bit must \
    agree; if not, both engines are run again to find the first step and grain.\nWhere they do not, give \
    --control: a YADE run that differs from the second folder only in verletDist. Its separation, and the \
    scatter of twelve perturbed replicas, are the reference.\n\nExamples:\n  crossgrain compare native yade\n  \
    crossgrain compare native yade-a --control yade-b"
)]
pub struct Arguments {
    /// A run folder
    a: PathBuf,
    /// A run folder
    b: PathBuf,
    /// A run that differs from the second one only in YADE's verletDist
    #[arg(long)]
    control: Option<PathBuf>,
    /// Judge by the scatter of twelve perturbed replicas of the first folder, a native run, alone: for an engine that has no
    /// control run of its own
    #[arg(long, conflicts_with = "control")]
    replicas: bool,
    /// Every bit must agree, whichever engines they are: for two engines of the same law, as the adapters of LAMMPS and
    /// LIGGGHTS with one radius
    #[arg(long, conflicts_with_all = ["control", "replicas"])]
    expect_bits: bool,
    /// Do not run engines again to find the first difference
    #[arg(long)]
    no_locate: bool,
    /// exec:PATH, where the engine of a run folder is, so that it can be run again to find the first difference; twice for
    /// two of them
    #[arg(long)]
    engine: Vec<Beside>,
    #[command(flatten)]
    output: Output,
    #[command(flatten)]
    limits: YadeLimits,
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        let a = RunFolder::read(&self.a)?;
        let b = RunFolder::read(&self.b)?;
        let control = self.control.as_deref().map(RunFolder::read).transpose()?;
        let asked = (control.is_some() || self.replicas).then_some(());
        let scatter = match asked {
            None => None,
            Some(()) if a.record.engine.keeps_order() && b.record.engine.keeps_order() => {
                return Err(Error::Usage(
                    "--control is for a second run in YADE's ordinary loop, --replicas for one in another engine; these \
                     two runs must agree in every bit"
                        .to_owned(),
                ));
            }
            Some(()) if !matches!(a.record.engine, EngineRecord::Native { .. }) => {
                return Err(Error::Usage(
                    "--control and --replicas need a native run as the first folder: its replicas are the reference"
                        .to_owned(),
                ));
            }
            Some(()) => Some(rounding_scatter(&a, &Display::new(self.output.quiet))?),
        };
        let reference = scatter.as_ref().map(|scatter| ReferenceScatter {
            control: control.as_ref(),
            scatter,
        });
        let programs = self.engine.iter();
        let programs = programs.map(|Beside(program)| self.limits.exec(program.clone()));
        let locator = (!self.no_locate).then(|| Locator {
            yade: self.limits.options(),
            programs: programs.collect(),
        });
        let comparison = if self.expect_bits {
            compare_as(&a, &b, true, None, locator.as_ref())
        } else {
            compare(&a, &b, reference, locator.as_ref())
        };
        let document = comparison.document();
        self.output
            .tell("compare", &json(&comparison)?, &document)?;
        if asked_to_end() {
            return Err(Error::Interrupted);
        }
        Ok(comparison.verdict().exit_code())
    }
}
