//! One member of a campaign: what one realization of the scene gave.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::engine::EngineError;
use crate::study::realization::{self, Ending, Realization, Specification, bed_of};
use grains::measure::neighbourhood::{self, Neighbourhood};
use grains::measure::{self, cells, stress};
use grains::scene::Scene;
use grains::tables::Snapshot;

/// What one realization gave; nothing in it depends on when, where or beside whom it was run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Member {
    /// From 1.
    pub member: u64,
    /// Which cloud was poured.
    pub realization: u64,
    /// Engine and version; empty where the engine gave up.
    pub engine: String,
    /// How it ended.
    pub ending: Ending,
    /// Steps of pouring.
    pub pour_steps: u64,
    /// Steps of loading.
    pub load_steps: u64,
    /// Digest of all bits of the settled bed, its contacts included.
    pub settled_state: Option<String>,
    /// The same of the last moment, punch included.
    pub last_state: Option<String>,
    /// See [`realization::measured`].
    pub measured: BTreeMap<String, f64>,
    /// Around the control points under gravity alone; none where the bed did not settle.
    pub settled: Option<Fields>,
    /// Around the control points when the force is reached; none where it was not.
    pub loaded: Option<Fields>,
}

/// Stresses of one moment around the control points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fields {
    /// [`stress::across`] at the depth of the first control point.
    pub across: Vec<f64>,
    /// [`stress::down`].
    pub down: Vec<f64>,
    /// In the order of the scene's control points; a point that is not inside the bed has none.
    pub points: Vec<Neighbourhood>,
}

impl Member {
    /// A realization that went wrong.
    fn failed(member: u64, realization: u64, reason: String) -> Self {
        Member {
            member,
            realization,
            engine: String::new(),
            ending: Ending::Failed(reason),
            pour_steps: 0,
            load_steps: 0,
            settled_state: None,
            last_state: None,
            measured: BTreeMap::new(),
            settled: None,
            loaded: None,
        }
    }

    /// The member of this realization of the scene.
    pub fn of(member: u64, scene: &Scene, run: &Realization) -> Self {
        let settled = run.outcome.settled.as_ref();
        let surface = settled.map(|settled| measure::surface(scene, &settled.bodies));
        let fields = |of: &Snapshot| surface.map(|surface| fields(scene, of, surface));
        let last = &run.outcome.last;
        let reached = run.ending == Ending::Reached;
        Member {
            member,
            realization: scene.realization,
            engine: run.engine.clone(),
            ending: run.ending.clone(),
            pour_steps: run.pour_steps,
            load_steps: run.load_steps,
            settled_state: settled.map(Snapshot::digest),
            last_state: Some(last.digest()),
            measured: realization::measured(scene, run),
            settled: settled.and_then(fields),
            loaded: reached.then(|| fields(last)).flatten(),
        }
    }
}

/// Runs this realization of the scene. What goes wrong in it is a member too; an interrupt, a missing or broken
/// YADE and a full disk are errors.
pub fn run(
    member: u64,
    realization: u64,
    scene: &Scene,
    how: &Specification<'_>,
) -> Result<Member, EngineError> {
    let mut scene = scene.clone();
    scene.realization = realization;
    match realization::run(&scene, how) {
        Ok(run) => Ok(Member::of(member, &scene, &run)),
        Err(error) => Ok(Member::failed(
            member,
            realization,
            realization::went_wrong(error)?,
        )),
    }
}

fn fields(scene: &Scene, of: &Snapshot, surface: f64) -> Fields {
    let bed = bed_of(of);
    let cells = cells::radical(scene, bed.bodies);
    let extensive = stress::of_grains(bed);
    let places = scene.control_points.iter().map(|point| {
        let place = [scene.punch_axis() + point.offset, surface - point.depth];
        (point, place)
    });
    let inside = places.clone().filter(|(_, place)| place[1] > 0.0);
    let depth = scene
        .control_points
        .first()
        .map_or(0.0, |point| point.depth);
    Fields {
        across: stress::across(scene, bed, &cells, &extensive, surface - depth),
        down: stress::down(scene, bed, &cells, &extensive, surface),
        points: inside
            .map(|(point, place)| neighbourhood::of(&point.name, place, bed, &cells, &extensive))
            .collect(),
    }
}
