//! The engine of this program as one among others.

use std::path::Path;

use clap::ValueEnum;

use super::{Description, Engine, EngineError, EngineRecord, Part, Run};

use grains::native::{self, Options};
use grains::scene::Scene;
use grains::task::{Case, Observer, Task};
use verdict::Answer;

/// What the record of a run says of it.
pub fn record(options: &Options) -> EngineRecord {
    EngineRecord::Native {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        perturbation: options.perturbation,
    }
}

impl Engine for Options {
    fn name(&self) -> String {
        "native".to_owned()
    }

    fn words(&self) -> String {
        let fault = self.perturbation;
        let fault = fault.map_or(String::new(), |fault| format!(" --perturb {fault}"));
        format!("--engine native{fault}")
    }

    fn describe(&self) -> Result<Description, EngineError> {
        let (version, parts) = (env!("CARGO_PKG_VERSION"), Part::value_variants());
        Ok(Description::of_this_program(
            "native",
            version.to_owned(),
            parts.to_vec(),
        ))
    }

    fn run(
        &self,
        scene: &Scene,
        task: &Task,
        _work: &Path,
        observer: &mut dyn Observer,
    ) -> Result<Run, EngineError> {
        Ok(Run {
            outcome: native::run(scene, task, self, observer)?,
            engine: record(self),
            log: String::new(),
            took: None,
        })
    }

    fn run_cases(&self, cases: &[&Case], _work: &Path) -> Result<Vec<Answer>, EngineError> {
        let run = |case: &&Case| Ok(Ok(native::run_case(case, self.perturbation)?));
        cases.iter().map(run).collect()
    }

    fn native(&self) -> Option<&Options> {
        Some(self)
    }

    fn is_of_this_program(&self) -> bool {
        true
    }
}
