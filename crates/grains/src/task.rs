//! What an engine is asked and what it promises to return, native and others behind the same words: a task of a scene, or a
//! case. A run that is asked to end notices it within a thousand steps.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use serde::{Deserialize, Serialize};

use crate::model::{Model, Wall};
use crate::scene::Scene;
use crate::tables::{Bodies, BodyIds, Memories, Punch, Snapshot, Stage, StopReason};

/// From where to where an engine runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// The state to start from.
    pub start: Start,
    /// Where to end.
    pub until: Until,
}

/// The state that a run starts from.
#[derive(Debug, Clone, PartialEq)]
pub struct Start {
    pub stage: Stage,
    /// Steps of the stage that are behind this state.
    pub step: u64,
    /// All grains, with velocities half a step before the positions.
    pub bodies: Bodies,
    /// The punch, if it is there already; its speed is the scene's, or zero if it stands still. A loading stage at
    /// step 0 makes it.
    pub punch: Option<Punch>,
    /// What contacts with friction remember; where it is empty, they begin to in this state.
    pub memory: Memories,
    /// What the rules have seen before.
    pub seen: Seen,
}

/// What the rules that end a stage remember of it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Seen {
    /// The largest kinetic energy at a look of the rule of settling, J.
    pub energy: f64,
    /// The step in which the force was reached and the punch stopped.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standing_since: Option<u64>,
    /// The rule held, and the stage went on because so many steps were asked for.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub held: bool,
}

impl Start {
    /// The stage whose constants its contacts have.
    pub fn constants(&self) -> Stage {
        self.stage.of_constants(self.step)
    }

    /// The punch as the scene moves it: one that stands still goes on doing so, any other has the scene's speed.
    pub fn punch_in(&self, scene: &Scene) -> Option<Punch> {
        let mut punch = self.punch?;
        let is_still = punch.velocity == 0.0;
        punch.velocity = if is_still { 0.0 } else { -scene.loading.speed };
        Some(punch)
    }
}

impl From<Bodies> for Start {
    /// Of pouring.
    fn from(bodies: Bodies) -> Self {
        Start {
            stage: Stage::Settle,
            step: 0,
            bodies,
            punch: None,
            memory: Memories::default(),
            seen: Seen::default(),
        }
    }
}

impl From<Snapshot> for Start {
    /// Of going on from a moment, without what the rules have seen.
    fn from(moment: Snapshot) -> Self {
        Start {
            stage: moment.stage,
            step: moment.step,
            punch: moment.punch,
            memory: moment.memory,
            ..moment.bodies.into()
        }
    }
}

/// Where a run ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Until {
    /// At the end of settling; the rule of the scene ends it.
    EndOfSettling,
    /// At the end of loading; the rules of the scene end each stage.
    EndOfLoading,
    /// After exactly so many steps of the stage that it starts in, counted from the stage's start.
    Step(u64),
}

impl Task {
    /// The whole experiment from the poured cloud on.
    pub fn whole(initial: impl Into<Start>) -> Self {
        Task {
            start: initial.into(),
            until: Until::EndOfLoading,
        }
    }

    /// Loading of a settled bed.
    pub fn load(bed: Snapshot) -> Self {
        Task::whole(Start {
            stage: Stage::Load,
            step: 0,
            ..bed.into()
        })
    }

    /// Pouring until the bed has settled.
    pub fn settle(initial: impl Into<Start>) -> Self {
        Task {
            until: Until::EndOfSettling,
            ..Task::whole(initial)
        }
    }

    /// Exactly `steps` steps of pouring.
    pub fn pour(initial: impl Into<Start>, steps: u64) -> Self {
        Task {
            until: Until::Step(steps),
            ..Task::whole(initial)
        }
    }
}

/// What an engine tells while it runs.
pub trait Observer {
    /// A moment of the run: the start, every `history_every` steps of a stage, and a stage's end.
    fn snapshot(&mut self, snapshot: &Snapshot);

    /// How far the stage is: its step, and roughly which share of it is done (0 to 1).
    fn progress(&mut self, stage: Stage, step: u64, share: f64) {
        let _ = (stage, step, share);
    }

    /// What there is of a run that is asked to end before its end.
    fn interrupted(&mut self, outcome: Outcome) {
        let _ = outcome;
    }
}

/// Keeps every moment.
impl Observer for Vec<Snapshot> {
    fn snapshot(&mut self, snapshot: &Snapshot) {
        self.push(snapshot.clone());
    }
}

/// Nobody is looking.
impl Observer for () {
    fn snapshot(&mut self, _: &Snapshot) {}
}

/// One stage as it went.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StageReport {
    pub stage: Stage,
    /// Steps of the stage when it ended.
    pub steps: u64,
    /// Why it ended.
    pub stop: StopReason,
    /// Time on the clock, s.
    pub wall_seconds: f64,
    /// Processor time of the engine, s.
    pub cpu_seconds: f64,
}

/// What an engine returns.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The stages that were run, in order.
    pub stages: Vec<StageReport>,
    /// The settled bed, if settling ended in this run and loading followed.
    pub settled: Option<Snapshot>,
    /// The last moment.
    pub last: Snapshot,
    /// What the rule of the last stage has seen.
    pub seen: Seen,
}

/// The moments at which an observer sees a stage: its start, every `every` steps, its end.
pub fn moments(start: u64, end: u64, every: u64) -> Vec<u64> {
    let mut steps = vec![start];
    let next = (start / every + 1) * every;
    steps.extend((next..=end).step_by(every as usize));
    if steps.last() != Some(&end) {
        steps.push(end);
    }
    steps
}

/// A small experiment that any engine can run.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// A name for messages.
    pub name: String,
    /// What is computed.
    pub model: Model,
    /// The grains at the start, velocities half a step before the positions.
    pub bodies: Bodies,
    /// A punch that moves up or down at a constant velocity.
    pub punch: Option<Punch>,
    /// The steps after which the state is taken, rising; 0 is the start with its contacts.
    pub moments: Vec<u64>,
}

impl Case {
    /// Without a punch.
    pub fn new(name: impl Into<String>, model: Model, bodies: Bodies, moments: Vec<u64>) -> Self {
        Case {
            name: name.into(),
            model,
            bodies,
            punch: None,
            moments,
        }
    }

    /// The wall that has this id.
    pub fn wall(&self, id: u32) -> Option<&Wall> {
        let index = id.checked_sub(self.ids().wall(0))?;
        self.model.walls.get(index as usize)
    }

    /// The same, looked at in other moments.
    pub fn at(&self, moments: Vec<u64>) -> Self {
        Case {
            moments,
            ..self.clone()
        }
    }

    /// Whether a run has its moments and no others.
    pub fn is_answered_by(&self, run: &[Snapshot]) -> bool {
        let steps = run.iter().map(|snapshot| snapshot.step);
        steps.eq(self.moments.iter().copied())
    }

    /// The ids of its bodies.
    pub fn ids(&self) -> BodyIds {
        BodyIds {
            grains: self.bodies.len() as u32,
            walls: self.model.walls_and_obstacles(),
        }
    }

    /// tan φ of these two bodies.
    pub fn tangent(&self, id1: u32, id2: u32) -> f64 {
        let (law, ids) = (&self.model.law, self.ids());
        let first = ids.body(id1);
        if law.materials.is_empty() || law.friction_of_its_own(first).is_some() {
            return law.friction_angles()[first as usize].tan();
        }
        let material = |id: u32| self.bodies.material.get(id as usize).copied().unwrap_or(0);
        let angles = [id1, id2].map(|id| law.solid(material(id)).friction_angle);
        angles[0].min(angles[1]).tan()
    }
}

/// Force and torque summed on a grain: x and z, N; about y, N·m.
pub type Load = [f64; 3];

/// What an engine makes of one grain or contact of a case: its parameters, as used.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectiveContact {
    /// Body 1; a wall or the punch, if there is one in the pair.
    pub id1: u32,
    /// Body 2; always a grain.
    pub id2: u32,
    /// Normal stiffness, N/m.
    pub k_n: f64,
    /// Tangential stiffness, N/m; none where the engine does not compute it.
    pub k_s: Option<f64>,
    /// tan φ.
    pub tan_phi: f64,
    /// Damping constant of the dashpot, N·s/m.
    pub c_n: f64,
}

/// The parameters that an engine uses for a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Effective {
    /// Of every contact at the start, by ids.
    pub contacts: Vec<EffectiveContact>,
    /// Mass of each grain, kg.
    pub mass: Vec<f64>,
    /// Moment of inertia of each grain, kg·m²; empty where grains do not rotate.
    pub inertia: Vec<f64>,
    /// m/s², x and z.
    pub gravity: [f64; 2],
    /// Cundall's α.
    pub alpha: f64,
    /// s.
    pub dt: f64,
}

static ASKED: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// The flag: whoever sets it asks every run of this process to end.
pub fn flag() -> &'static Arc<AtomicBool> {
    ASKED.get_or_init(Arc::default)
}

/// Whether the process was asked to end.
pub fn asked_to_end() -> bool {
    ASKED
        .get()
        .is_some_and(|asked| asked.load(Ordering::Relaxed))
}
