//! One realization of a scene, from the poured cloud to the loaded bed, in any engine, without a history.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::engine::exec::{Brought, Part, missing_for_scene, run_brought};
use crate::engine::{ProgramError, yade};
use crate::run::EngineError;
use evidence::{distribution, moments};
use grains::generate::initial_bodies;
use grains::measure::{self, Bed, equilibrium, stress};
use grains::native::pouring::Phase;
use grains::native::{self, Mode, NativeError, Trouble};
use grains::scene::Scene;
use grains::tables::{Snapshot, Stage, StopReason};
use grains::task::{Outcome, Start, Task, Until};

/// How a realization ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// Settled, and the punch got its force.
    Reached,
    /// Settled; the punch went to the give-up depth without the force.
    TargetLoadNotReached,
    /// Not settled within the scene's steps.
    NotSettled,
    /// Settled, in an engine that has no punch: nobody asked for more.
    Poured,
    /// The engine gave up, with its words.
    Failed(String),
}

impl Ending {
    /// The word for it in tables.
    pub fn name(&self) -> &'static str {
        match self {
            Ending::Reached => "reached",
            Ending::TargetLoadNotReached => "target_load_not_reached",
            Ending::NotSettled => "not_settled",
            Ending::Poured => "poured",
            Ending::Failed(_) => "failed",
        }
    }
}

/// Who runs it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Runner {
    /// The native engine.
    Native(Mode),
    /// YADE's ordinary loop, as it is usually run.
    YadeOrdinary,
    /// YADE's loop over sorted interactions, which has the native engine's bits.
    YadeSorted,
    /// A program that was brought.
    Brought,
}

impl Runner {
    /// For people and in job files: `native`, `native-free`, `yade-ordinary`.
    pub fn name(self) -> String {
        match self {
            Runner::Native(mode) if mode.is_exact() => "native".to_owned(),
            Runner::Native(mode) => format!("native-{}", mode.name()),
            Runner::YadeOrdinary => "yade-ordinary".to_owned(),
            Runner::YadeSorted => "yade-sorted".to_owned(),
            Runner::Brought => "exec".to_owned(),
        }
    }

    /// Whether it runs in this process.
    pub fn is_native(self) -> bool {
        matches!(self, Runner::Native(_))
    }

    /// Whether YADE is needed.
    pub fn is_yade(self) -> bool {
        matches!(self, Runner::YadeOrdinary | Runner::YadeSorted)
    }
}

/// How engines that are other programs are started.
#[derive(Debug, Clone, Default)]
pub struct Engines {
    /// YADE; its loop is the runner's.
    pub yade: yade::Options,
    /// The external engine, for its runner.
    pub external: Option<Brought>,
}

impl Engines {
    /// The external engine, which must have been named.
    pub fn external(&self) -> Result<&Brought, ProgramError> {
        let missing = || ProgramError::NotStarted {
            path: "exec:PATH".into(),
            reason: "it was not named".to_owned(),
        };
        self.external.as_ref().ok_or_else(missing)
    }
}

/// How a realization is run.
#[derive(Debug, Clone, Copy)]
pub struct Specification<'a> {
    /// In which engine.
    pub runner: Runner,
    /// Pouring, part by part, in the native engine; without any the scene's own stages and rules are used.
    pub phases: &'a [Phase],
    /// The engines that are other programs.
    pub engines: &'a Engines,
    /// An empty folder for the use of such an engine.
    pub work: &'a Path,
}

/// A realization that was run to an end.
#[derive(Debug)]
pub struct Realization {
    /// Settled and last moment.
    pub outcome: Outcome,
    /// [`Ending::Reached`], [`Ending::TargetLoadNotReached`] or [`Ending::NotSettled`].
    pub ending: Ending,
    /// Steps of pouring, of all phases.
    pub pour_steps: u64,
    /// Steps of loading.
    pub load_steps: u64,
    /// Processor time of an engine in another process, s.
    pub elsewhere: f64,
    /// Engine and version.
    pub engine: String,
}

/// Runs the scene's realization.
pub fn run(scene: &Scene, how: &Specification<'_>) -> Result<Realization, EngineError> {
    // Nobody looks at the history.
    let mut scene = scene.clone();
    scene.measurement.history_every = 1_000_000_000;
    match how.runner {
        Runner::Native(mode) => {
            let options = native::Options {
                mode,
                ..native::Options::default()
            };
            Ok(in_native(&scene, how.phases, &options)?)
        }
        Runner::YadeOrdinary | Runner::YadeSorted => {
            let options = yade::Options {
                sorted: how.runner == Runner::YadeSorted,
                ..how.engines.yade.clone()
            };
            let task = Task::whole(initial_bodies(&scene));
            let run = yade::run(&scene, &task, &options, how.work, &mut ())?;
            let seconds = run.outcome.stages.iter().map(|stage| stage.cpu_seconds);
            let seconds = seconds.sum();
            let engine = format!("YADE {}", run.version);
            Ok(whole(run.outcome, seconds, engine))
        }
        Runner::Brought => Ok(in_brought(&scene, how.engines.external()?, how.work)?),
    }
}

/// Pours and loads in an engine that was brought. One that has everything but a punch pours and settles.
fn in_brought(scene: &Scene, engine: &Brought, work: &Path) -> Result<Realization, ProgramError> {
    let mut task = Task::whole(initial_bodies(scene));
    let missing = missing_for_scene(&engine.description, scene, &task);
    let only_poured = missing == [Part::Punch];
    if only_poured {
        task.until = Until::EndOfSettling;
    }
    let run = run_brought(scene, &task, engine, work, &mut ())?;
    let told = run.outcome.stages.iter().map(|stage| stage.cpu_seconds);
    let elsewhere = run.took.processor_seconds.unwrap_or_else(|| told.sum());
    let mut made = whole(run.outcome, elsewhere, run.description.label());
    if only_poured && made.ending != Ending::NotSettled {
        made.ending = Ending::Poured;
        made.outcome.settled = Some(made.outcome.last.clone());
    }
    Ok(made)
}

/// The words of an engine for which the realization itself went wrong, as numbers that are not finite or grains that
/// left the box; any other failure – an interrupt, a missing or broken YADE, a full disk – is handed back.
pub fn went_wrong(error: EngineError) -> Result<String, EngineError> {
    match error {
        EngineError::Native(NativeError {
            trouble: Trouble::Interrupted,
            ..
        }) => Err(error),
        EngineError::Native(error) => Ok(error.to_string()),
        EngineError::Program(error @ ProgramError::WentWrong { .. }) => Ok(error.to_string()),
        error @ EngineError::Program(_) => Err(error),
    }
}

fn in_native(
    scene: &Scene,
    phases: &[Phase],
    options: &native::Options,
) -> Result<Realization, NativeError> {
    let initial = initial_bodies(scene);
    let poured = if phases.is_empty() {
        None
    } else {
        native::pouring::pour(scene, phases, options, initial.clone())?
    };
    let Some(poured) = poured else {
        return native_whole(scene, options);
    };
    Ok(Realization {
        pour_steps: poured.steps,
        ..loaded(scene, &poured.bed, poured.settled, options)?
    })
}

/// Pours and loads in the native engine, by the scene's own rules.
pub fn native_whole(scene: &Scene, options: &native::Options) -> Result<Realization, NativeError> {
    let task = Task::whole(initial_bodies(scene));
    let outcome = native::run(scene, &task, options, &mut ())?;
    Ok(whole(outcome, 0.0, native_engine()))
}

/// Loads a bed that was poured before, in the native engine; a bed that has not `settled` is none to judge by. The
/// bits are those of the whole run as long as contacts remember nothing, that is without friction.
pub fn loaded(
    scene: &Scene,
    bed: &Snapshot,
    settled: bool,
    options: &native::Options,
) -> Result<Realization, NativeError> {
    let task = Task {
        start: Start {
            stage: Stage::Load,
            step: 0,
            bodies: bed.bodies.clone(),
            punch: None,
        },
        until: Until::EndOfLoading,
    };
    let mut outcome = native::run(scene, &task, options, &mut ())?;
    outcome.settled = Some(bed.clone());
    Ok(Realization {
        ending: ending(&outcome, !settled),
        load_steps: steps_of(&outcome, Stage::Load),
        pour_steps: bed.step,
        elsewhere: 0.0,
        engine: native_engine(),
        outcome,
    })
}

fn native_engine() -> String {
    format!("native {}", env!("CARGO_PKG_VERSION"))
}

fn whole(outcome: Outcome, elsewhere: f64, engine: String) -> Realization {
    let mut pouring = outcome.stages.iter();
    let unsettled =
        pouring.any(|stage| stage.stage == Stage::Settle && stage.stop != StopReason::Settled);
    Realization {
        ending: ending(&outcome, unsettled),
        pour_steps: steps_of(&outcome, Stage::Settle),
        load_steps: steps_of(&outcome, Stage::Load),
        elsewhere,
        engine,
        outcome,
    }
}

fn steps_of(outcome: &Outcome, wanted: Stage) -> u64 {
    let stages = outcome.stages.iter();
    let steps = stages.filter(|stage| stage.stage == wanted);
    steps.map(|stage| stage.steps).sum()
}

fn ending(outcome: &Outcome, unsettled: bool) -> Ending {
    match outcome.stages.last().map(|stage| stage.stop) {
        _ if unsettled => Ending::NotSettled,
        Some(StopReason::Reached) => Ending::Reached,
        _ => Ending::TargetLoadNotReached,
    }
}

/// Every measured number of a realization by its key, SI units: those of [`measure::all`], the shape of the settled
/// bed's stresses (`settled.distribution.*`), what the floor bears, and the punch's depth and force. Those of the last moment only where
/// the force was reached, none of a bed that did not settle.
pub fn measured(scene: &Scene, realization: &Realization) -> BTreeMap<String, f64> {
    let outcome = &realization.outcome;
    let Some(settled) = &outcome.settled else {
        return BTreeMap::new();
    };
    let (settled_bed, last_bed) = (bed_of(settled), bed_of(&outcome.last));
    let all = measure::all(scene, Some(settled_bed), last_bed);
    let mut measured: BTreeMap<String, f64> = all
        .into_iter()
        .map(|quantity| (quantity.key, quantity.value))
        .collect();
    let surface = measure::surface(scene, &settled.bodies);
    let layer = stress::over_depth(scene, settled_bed, surface);
    let shapes = [
        ("variation", Some(moments::coefficient_of_variation(&layer))),
        ("above_two_means", Some(moments::share_above(&layer, 2.0))),
        ("gamma_shape", distribution::gamma_shape(&layer)),
        ("weibull_shape", distribution::weibull_shape(&layer)),
    ];
    for (name, value) in shapes {
        if let Some(value) = value {
            measured.insert(format!("settled.distribution.{name}"), value);
        }
    }
    let mut insert = |key: &str, value: f64| measured.insert(key.to_owned(), value);
    insert(
        "settled.support.by_floor",
        equilibrium::borne_by_floor(scene, settled_bed, 0.0),
    );
    if let Some(punch) = &outcome.last.punch {
        insert("loaded.punch.depth", punch.depth());
        insert("loaded.punch.force", punch.force);
        let share = equilibrium::borne_by_floor(scene, last_bed, punch.force);
        insert("loaded.support.by_floor", share);
    }
    let reached = realization.ending == Ending::Reached;
    measured.retain(|key, value| (reached || !key.starts_with("loaded.")) && value.is_finite());
    measured
}

/// The tables of a moment, for measuring.
pub fn bed_of(snapshot: &Snapshot) -> Bed<'_> {
    Bed {
        bodies: &snapshot.bodies,
        contacts: &snapshot.contacts,
    }
}
