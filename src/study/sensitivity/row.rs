//! One member of the map: a setting on a cloud.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::run::EngineError;
use crate::study::claims::published::PUBLISHED;
use crate::study::realization::{self, Ending, Realization, went_wrong};
use crate::study::tradeoff::ledger::Entry;
use grains::generate::initial_bodies;
use grains::native::{self, Mode, NativeError};
use grains::scene::Scene;
use grains::tables::{Snapshot, StopReason};
use grains::task::Task;

/// Kept besides the published figures' quantities.
const KEPT: &[&str] = &[
    "settled.porosity.of_cells",
    "settled.coordination.mean",
    "settled.stress.O.local_zz",
    "settled.stress.A.local_zz",
    "settled.stress.B.local_zz",
    "last.punch.depth",
    "last.punch.force",
];

/// What one setting gave on one cloud.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Digest of the setting.
    pub setting: String,
    /// Which cloud.
    pub realization: u64,
    /// How it ended.
    pub ending: Ending,
    /// Steps of pouring.
    pub pour_steps: u64,
    /// Steps of loading.
    pub load_steps: u64,
    /// Digest of all bits of the last moment.
    pub last_state: Option<String>,
    /// The quantities of the published figures and a few more, SI units; those of the loaded bed only where the
    /// force was reached.
    pub measured: BTreeMap<String, f64>,
}

impl Entry for Row {
    fn digest(&self) -> &str {
        &self.setting
    }

    fn realization(&self) -> u64 {
        self.realization
    }
}

/// A bed that was poured, or why there is none.
#[derive(Debug)]
pub enum Poured {
    /// It was poured to an end.
    Bed {
        /// The last moment of pouring.
        snapshot: Box<Snapshot>,
        /// Whether the settle rule ended it.
        settled: bool,
    },
    /// The engine gave up, with its words.
    Failed(String),
}

/// Pours this scene's bed.
pub fn pour(scene: &Scene) -> Result<Poured, EngineError> {
    let scene = unobserved(scene);
    let task = Task::settle(initial_bodies(&scene));
    let poured = match native::run(&scene, &task, &options(), &mut ()) {
        Ok(outcome) => outcome,
        Err(error) => return Ok(Poured::Failed(words(error)?)),
    };
    let stop = poured.stages.last().map(|stage| stage.stop);
    Ok(Poured::Bed {
        snapshot: Box::new(poured.last),
        settled: stop == Some(StopReason::Settled),
    })
}

/// Loads a bed of this scene.
pub fn load(setting: &str, scene: &Scene, poured: &Poured) -> Result<Row, EngineError> {
    match poured {
        Poured::Failed(reason) => Ok(Row::without(setting, scene, Ending::Failed(reason.clone()))),
        Poured::Bed { settled: false, .. } => Ok(Row::without(setting, scene, Ending::NotSettled)),
        Poured::Bed { snapshot, .. } => {
            let observed = unobserved(scene);
            let run = realization::loaded(&observed, snapshot, true, &options());
            of_run(setting, scene, run)
        }
    }
}

/// The whole realization in one go.
pub fn whole(setting: &str, scene: &Scene) -> Result<Row, EngineError> {
    let run = realization::native_whole(&unobserved(scene), &options());
    of_run(setting, scene, run)
}

fn of_run(
    setting: &str,
    scene: &Scene,
    run: Result<Realization, NativeError>,
) -> Result<Row, EngineError> {
    Ok(match run {
        Ok(run) => Row::of(setting, scene, &run),
        Err(error) => Row::without(setting, scene, Ending::Failed(words(error)?)),
    })
}

impl Row {
    fn of(setting: &str, scene: &Scene, run: &Realization) -> Self {
        let mut measured = realization::measured(scene, run);
        measured.retain(|key, _| {
            KEPT.contains(&key.as_str()) || PUBLISHED.iter().any(|figure| figure.key == key)
        });
        Row {
            setting: setting.to_owned(),
            realization: scene.realization,
            ending: run.ending.clone(),
            pour_steps: run.pour_steps,
            load_steps: run.load_steps,
            last_state: Some(run.outcome.last.digest()),
            measured,
        }
    }

    /// One that gave nothing.
    fn without(setting: &str, scene: &Scene, ending: Ending) -> Self {
        Row {
            setting: setting.to_owned(),
            realization: scene.realization,
            ending,
            pour_steps: 0,
            load_steps: 0,
            last_state: None,
            measured: BTreeMap::new(),
        }
    }
}

/// Exact mode: the bits are the same on any machine, and YADE's.
pub fn options() -> native::Options {
    native::Options {
        mode: Mode::Exact,
        ..native::Options::default()
    }
}

/// Nobody looks at the history.
fn unobserved(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.measurement.history_every = 1_000_000_000;
    scene
}

fn words(error: NativeError) -> Result<String, EngineError> {
    went_wrong(EngineError::Native(error))
}
