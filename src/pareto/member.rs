//! One realization by one method: what it cost and what was measured.

use std::collections::BTreeMap;
use std::path::Path;

use cpu_time::ThreadTime;
use serde::{Deserialize, Serialize};

use super::method::{Method, Runner};
use crate::engine::native::{self, NativeError, Trouble};
use crate::engine::yade::{self, YadeError};
use crate::engine::{Outcome, Start, Task, Until};
use crate::generate::initial_bodies;
use crate::measure::{self, Bed, height, stress_at_depth};
use crate::run::EngineError;
use crate::scene::Scene;
use crate::statistics::shape;
use crate::tables::{Snapshot, Stage, StopReason};

/// How a realization ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// Settled, and the punch got its force.
    Reached,
    /// Settled; the punch went to the give-up depth without the force.
    Sank,
    /// Not settled within the scene's steps.
    NotSettled,
    /// The engine gave up, with its words.
    Failed(String),
}

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

/// What was run before anything is measured.
struct Run {
    outcome: Outcome,
    pour_steps: u64,
    /// Of an engine in another process, s.
    elsewhere: f64,
    unsettled: bool,
}

/// Runs a realization. An engine that fails is a result; an interrupt and a missing YADE are errors. `work` is an
/// empty folder for YADE's use.
pub fn run(
    method: &Method,
    realization: u64,
    yade: &yade::Options,
    work: &Path,
) -> Result<Member, EngineError> {
    let clock = ThreadTime::now();
    let mut scene = method.scene.clone();
    scene.realization = realization;
    // Nobody looks at the history.
    scene.measurement.history_every = 1_000_000_000;
    let mut member = Member {
        method: method.digest(),
        realization,
        ending: Ending::Reached,
        cost: Cost::default(),
        measured: BTreeMap::new(),
    };
    let run = match method.runner {
        Runner::Native(mode) => {
            let options = native::Options {
                mode,
                ..native::Options::default()
            };
            native_run(method, &scene, &options).map_err(EngineError::from)
        }
        Runner::YadeOrdinary => yade_run(&scene, yade, work),
    };
    let run = match run {
        Ok(run) => run,
        Err(
            error @ EngineError::Native(NativeError {
                trouble: Trouble::Interrupted,
                ..
            }),
        ) => return Err(error),
        Err(EngineError::Native(error)) => {
            member.ending = Ending::Failed(error.to_string());
            member.cost.cpu_seconds = clock.elapsed().as_secs_f64();
            return Ok(member);
        }
        Err(EngineError::Yade(
            error @ (YadeError::Crashed { .. }
            | YadeError::Hung { .. }
            | YadeError::WentWrong { .. }
            | YadeError::Nonsense(_)),
        )) => {
            member.ending = Ending::Failed(error.to_string());
            return Ok(member);
        }
        Err(error) => return Err(error),
    };
    let measuring = ThreadTime::now();
    member.ending = ending(&run);
    member.measured = measured(&scene, &run.outcome, &member.ending);
    member.cost = Cost {
        cpu_seconds: clock.elapsed().as_secs_f64() + run.elsewhere,
        measuring_seconds: measuring.elapsed().as_secs_f64(),
        pour_steps: run.pour_steps,
        load_steps: run
            .outcome
            .stages
            .iter()
            .filter(|stage| stage.stage == Stage::Load)
            .map(|stage| stage.steps)
            .sum(),
    };
    Ok(member)
}

fn native_run(
    method: &Method,
    scene: &Scene,
    options: &native::Options,
) -> Result<Run, NativeError> {
    let initial = initial_bodies(scene);
    if method.phases.is_empty() {
        let outcome = native::run(scene, &Task::whole(initial), options, &mut ())?;
        return Ok(whole(outcome, 0.0));
    }
    let poured = native::pouring::pour(scene, &method.phases, options, initial.clone())?;
    let Some(poured) = poured else {
        let outcome = native::run(scene, &Task::whole(initial), options, &mut ())?;
        return Ok(whole(outcome, 0.0));
    };
    let task = Task {
        start: Start {
            stage: Stage::Load,
            step: 0,
            bodies: poured.bed.bodies.clone(),
            punch: None,
        },
        until: Until::EndOfLoading,
    };
    let mut outcome = native::run(scene, &task, options, &mut ())?;
    outcome.settled = Some(poured.bed);
    Ok(Run {
        outcome,
        pour_steps: poured.steps,
        elsewhere: 0.0,
        unsettled: !poured.settled,
    })
}

fn yade_run(scene: &Scene, options: &yade::Options, work: &Path) -> Result<Run, EngineError> {
    let options = yade::Options {
        sorted: false,
        ..options.clone()
    };
    let task = Task::whole(initial_bodies(scene));
    let run = yade::run(scene, &task, &options, work, &mut ())?;
    let seconds = run.outcome.stages.iter().map(|stage| stage.cpu_seconds);
    let seconds = seconds.sum();
    Ok(whole(run.outcome, seconds))
}

fn whole(outcome: Outcome, elsewhere: f64) -> Run {
    let pouring = outcome.stages.iter();
    let pouring = pouring.filter(|stage| stage.stage == Stage::Settle);
    Run {
        pour_steps: pouring.clone().map(|stage| stage.steps).sum(),
        unsettled: pouring
            .clone()
            .any(|stage| stage.stop != StopReason::Settled),
        elsewhere,
        outcome,
    }
}

fn ending(run: &Run) -> Ending {
    match run.outcome.stages.last().map(|stage| stage.stop) {
        _ if run.unsettled => Ending::NotSettled,
        Some(StopReason::Reached) => Ending::Reached,
        _ => Ending::Sank,
    }
}

/// The charted quantities of this run.
fn measured(scene: &Scene, outcome: &Outcome, ending: &Ending) -> BTreeMap<String, f64> {
    let Some(settled) = &outcome.settled else {
        return BTreeMap::new();
    };
    let (settled_bed, last_bed) = (bed_of(settled), bed_of(&outcome.last));
    let all = measure::all(scene, Some(settled_bed), last_bed);
    let mut measured: BTreeMap<String, f64> = all
        .into_iter()
        .map(|quantity| (quantity.key, quantity.value))
        .collect();
    let surface = height::surface(scene, &settled.bodies);
    let layer = stress_at_depth::scaled(scene, settled_bed, surface);
    let shapes = [
        ("variation", Some(shape::variation(&layer))),
        ("above_two_means", Some(shape::share_above(&layer, 2.0))),
        ("gamma_shape", shape::gamma(&layer)),
        ("weibull_shape", shape::weibull(&layer)),
    ];
    for (name, value) in shapes {
        if let Some(value) = value {
            measured.insert(format!("settled.distribution.{name}"), value);
        }
    }
    if let Some(punch) = &outcome.last.punch {
        measured.insert("last.punch.depth".to_owned(), punch.depth());
    }
    let wanted = |key: &str| {
        let charted = super::margins::CHARTED.iter().any(|of| of.key == key);
        charted && (*ending == Ending::Reached || !key.starts_with("last."))
    };
    measured.retain(|key, value| wanted(key) && value.is_finite());
    measured
}

fn bed_of(snapshot: &Snapshot) -> Bed<'_> {
    Bed {
        bodies: &snapshot.bodies,
        contacts: &snapshot.contacts,
    }
}
