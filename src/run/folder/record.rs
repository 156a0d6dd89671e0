//! What `run.json` and `trace.csv` say.

use serde::{Deserialize, Serialize};

use crate::engine::EngineRecord;
use crate::run::continued::Continued;
use grains::measure;
use grains::model::ModelRecord;
use grains::native::pouring::Phase;
use grains::tables::{Punch, Stage, StopReason};
use grains::task::{Seen, StageReport, Start, Task};

/// The version of `run.json` that this program writes and reads.
pub const RECORD_VERSION: u32 = 4;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Protocol {
    /// Pouring, settling and loading, each ended by its rule.
    Whole,
    /// Exactly so many steps of pouring.
    Steps { steps: u64 },
    /// Pouring and settling, ended by its rule; no loading.
    Settled,
}

impl Protocol {
    /// What an engine is asked.
    pub fn task(self, start: impl Into<Start>) -> Task {
        match self {
            Protocol::Whole => Task::whole(start),
            Protocol::Steps { steps } => Task::pour(start, steps),
            Protocol::Settled => Task::settle(start),
        }
    }
}

impl std::fmt::Display for Protocol {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Protocol::Whole => out.write_str("the whole experiment"),
            Protocol::Steps { steps } => write!(out, "{steps} steps of pouring"),
            Protocol::Settled => out.write_str("pouring until settled"),
        }
    }
}

/// What came before `initial.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Softened {
    pub phases: Vec<Phase>,
    /// Digest of the poured cloud that they began with.
    pub cloud_digest: String,
    pub steps: u64,
    /// Largest kinetic energy that their rules saw, J; the settle rule goes on with it.
    pub energy_seen: f64,
    /// Processor time, s.
    pub cpu_seconds: f64,
}

/// `run.json`: everything about a run that is not a table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunRecord {
    pub version: u32,
    pub crossgrain: String,
    pub engine: EngineRecord,
    pub model: ModelRecord,
    /// SHA-256 of the scene's canonical JSON.
    pub scene_digest: String,
    /// Digest of the initial positions and velocities.
    pub initial_digest: String,
    pub protocol: Protocol,
    /// The command that does this run again, in a folder that holds `scene.json`.
    pub command: String,
    /// s.
    pub time_step: f64,
    /// The evidence for the time step, where the program chose it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_choice: Option<StepChoice>,
    /// How the grains were poured before `initial.csv`, where they were softened; `settle` is then the last phase alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub softened: Option<Softened>,
    /// How many processes of the engine made the run, each going on from the bits that the one before had left; none where it
    /// was one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parts: Option<usize>,
    /// Times are summed over the parts.
    pub stages: Vec<StageReport>,
    /// What a run of the native engine goes on with, besides the tables.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restart: Option<Restart>,
    /// Stretches of another engine's run that the native engine made too.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub continued: Vec<Continued>,
    /// Largest resident memory of the crossgrain process up to the end of the run, bytes, where the
    /// system tells; YADE's own is not in it.
    pub peak_memory: Option<u64>,
    /// Every measure of the settled and the last bed.
    pub measures: Vec<measure::Quantity>,
}

/// The state of a run at its end, besides the tables.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Restart {
    pub punch: Option<Punch>,
    pub seen: Seen,
}

/// How an automatic time step was chosen: a share of the largest stable step that a probe of the scene showed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepChoice {
    /// The share of the limit that was taken.
    pub share: f64,
    /// share × limit, s.
    pub time_step: f64,
    /// The smallest of the largest stable steps at all looks, with the scene's α, s.
    pub limit: f64,
    /// The same look without Cundall damping: 2/ω_max where there are no dashpots, s.
    pub limit_without_damping: f64,
    pub alpha: f64,
    /// The step of the probing run, s.
    pub probed_at: f64,
    /// How often contacts were looked at.
    pub looks: u64,
    /// The look with the smallest limit; none if nothing ever touched.
    pub least: Option<StepLook>,
    /// The last look of pouring.
    pub settled: Option<StepLook>,
    /// The last look under the punch, if the probe came so far.
    pub loaded: Option<StepLook>,
    /// A limit that was found by trials; none where the bed did not come to rest.
    pub trial: Option<StepTrial>,
}

/// The largest stable step at one moment of the probe.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepLook {
    pub stage: Stage,
    /// Steps of the stage so far, of the probe's length.
    pub step: u64,
    pub contacts: u64,
    /// With the scene's α, s.
    pub limit: f64,
    /// Without damping, s.
    pub undamped: f64,
}

/// The settled bed brought to rest, without dashpots and damping: its limit predicted and found by trials.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepTrial {
    /// From the springs, s.
    pub predicted: f64,
    /// The largest step at which a small disturbance did not grow, s.
    pub stable: f64,
    /// The smallest step at which it grew, s.
    pub unstable: f64,
}

impl RunRecord {
    /// Why the last stage ended.
    pub fn stop(&self) -> Option<StopReason> {
        self.stages.last().map(|stage| stage.stop)
    }

    /// Processor time of all stages, s.
    pub fn cpu_seconds(&self) -> f64 {
        self.stages.iter().map(|stage| stage.cpu_seconds).sum()
    }

    /// Processor time per step over all stages, s.
    pub fn seconds_per_step(&self) -> f64 {
        let steps: u64 = self.stages.iter().map(|stage| stage.steps).sum();
        self.cpu_seconds() / steps.max(1) as f64
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TraceRow {
    pub stage: Stage,
    pub step: u64,
    pub id: u32,
    pub x: f64,
    pub z: f64,
}

impl TraceRow {
    /// The columns of `trace.csv`.
    pub const HEADER: &[&str] = &["stage", "step", "id", "x", "z"];
}
