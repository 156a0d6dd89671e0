//! One realization by one method: what it cost and what was measured.

use std::collections::BTreeMap;
use std::path::Path;

use cpu_time::ThreadTime;
use serde::{Deserialize, Serialize};

use super::ledger::Entry;
use super::method::{Method, Runner};
use crate::engine::exec::{Brought, ExecError};
use crate::engine::yade::{self, YadeError};
use crate::run::EngineError;
pub use crate::study::realization::Ending;
use crate::study::realization::{self, Way};

/// What a realization cost.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cost {
    /// Processor time from the scene to the measured numbers, s; of YADE, its own.
    pub cpu_seconds: f64,
    /// The part of it that went into measuring, s.
    pub measuring_seconds: f64,
    /// Steps of pouring.
    pub pour_steps: u64,
    /// Steps of loading.
    pub load_steps: u64,
}

/// One realization by one method.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Member {
    /// Digest of the method.
    pub method: String,
    /// Which cloud.
    pub realization: u64,
    /// How it ended.
    pub ending: Ending,
    /// What it took.
    pub cost: Cost,
    /// By the keys of the charted quantities, SI units; those of the loaded bed only where the force was reached.
    pub measured: BTreeMap<String, f64>,
}

impl Entry for Member {
    fn digest(&self) -> &str {
        &self.method
    }

    fn realization(&self) -> u64 {
        self.realization
    }
}

/// Runs a realization. An engine that fails is a result; an interrupt, a missing YADE, and a program that was brought and
/// does not have what it takes are errors. `work` is an empty folder for the use of either.
pub fn run(
    method: &Method,
    realization: u64,
    yade: &yade::Options,
    brought: Option<&Brought>,
    work: &Path,
) -> Result<Member, EngineError> {
    let clock = ThreadTime::now();
    let mut scene = method.scene.clone();
    scene.realization = realization;
    let mut member = Member {
        method: method.digest(),
        realization,
        ending: Ending::Reached,
        cost: Cost::default(),
        measured: BTreeMap::new(),
    };
    let way = Way {
        runner: method.runner,
        phases: &method.phases,
        yade,
        brought,
        work,
    };
    let run = match realization::run(&scene, &way) {
        Ok(run) => run,
        Err(error) => {
            member.ending = Ending::Failed(failure(error)?);
            if matches!(method.runner, Runner::Native(_)) {
                member.cost.cpu_seconds = clock.elapsed().as_secs_f64();
            }
            return Ok(member);
        }
    };
    let measuring = ThreadTime::now();
    member.measured = realization::measured(&scene, &run);
    let charted = |key: &str| super::margins::CHARTED.iter().any(|of| of.key == key);
    member.measured.retain(|key, _| charted(key));
    member.cost = Cost {
        cpu_seconds: clock.elapsed().as_secs_f64() + run.elsewhere,
        measuring_seconds: measuring.elapsed().as_secs_f64(),
        pour_steps: run.pour_steps,
        load_steps: run.load_steps,
    };
    member.ending = run.ending;
    Ok(member)
}

/// What a method that cannot do it costs its user is part of the chart, a YADE or a program that breaks included.
fn failure(error: EngineError) -> Result<String, EngineError> {
    match error {
        EngineError::Yade(
            error @ (YadeError::Crashed { .. } | YadeError::Hung { .. } | YadeError::Nonsense(_)),
        ) => Ok(error.to_string()),
        EngineError::Exec(
            error @ (ExecError::Crashed { .. }
            | ExecError::Hung { .. }
            | ExecError::TooMuch { .. }
            | ExecError::Nonsense(_)),
        ) => Ok(error.to_string()),
        error => realization::went_wrong(error),
    }
}
