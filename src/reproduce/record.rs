//! What `run.json` of the main job says.

use serde::Serialize;

use super::beside::Stated;
use super::claims::Claim;
use super::faults::FaultCheck;
use crate::checks::Outcome;
use crate::checks::Speed;
use crate::compare::Comparison;
use crate::engine::yade;
use crate::paper;
use crate::run::folder::RunFolder;
use crate::suite::parameters::ParameterPair;
use crate::suite::run::{Engines, Options, Verification};

/// The version of the reproduction's `run.json`.
pub const REPRODUCTION_VERSION: u32 = 1;

/// Grains of the longest trajectories of the ladder in the main job; `crossgrain verify` has all.
const LADDER_GRAINS: u32 = 500;

/// The ladder as the main job climbs it.
pub fn verification(yade: &yade::Options) -> Options {
    Options {
        engine: Engines::Both,
        grains: LADDER_GRAINS,
        detection_limits: true,
        yade: yade.clone(),
        command: format!("crossgrain verify --detection-limits --grains {LADDER_GRAINS}"),
    }
}

/// The result of the main job.
#[derive(Debug, Clone, Serialize)]
pub struct Reproduction {
    /// Format version of this file.
    pub version: u32,
    /// Version of crossgrain.
    pub crossgrain: String,
    /// How to do it again.
    pub command: String,
    /// SHA-256 of the scene's canonical JSON.
    pub scene_digest: String,
    /// The version of the YADE that ran live.
    pub yade: Option<String>,
    /// Of all checks; skipped if no comparison with another engine could be made or the experiment did not come to its end.
    pub verdict: Outcome,
    /// All comparisons of two runs.
    pub comparisons: Vec<NamedComparison>,
    /// Deliberate faults, each of which the comparison must find.
    pub faults: Vec<FaultCheck>,
    /// The parameters that both engines use, if YADE ran live.
    pub facts: Vec<ParameterPair>,
    /// The ladder, if it was climbed.
    pub ladder: Option<Verification>,
    /// What was skipped, with the reason.
    pub skipped: Vec<Skipped>,
    pub claims: Vec<Claim>,
    /// The paper's numbers that need no simulation.
    pub numbers: Vec<paper::Number>,
    /// Faults of the paper's text.
    pub text_faults: Vec<paper::TextFault>,
    /// Records of other jobs that stand on the page; they are no part of the verdict.
    pub beside: Vec<Stated>,
    /// All runs.
    pub runs: Vec<RunSummary>,
    /// How long the job took, s.
    pub seconds: f64,
}

impl Reproduction {
    /// YADE's time a step over the native engine's, of the runs that were made live, one each.
    pub fn speeds(&self) -> Vec<Speed> {
        let of = |run: &RunSummary| {
            let value = run
                .times_native
                .filter(|_| run.folder.starts_with("yade"))?;
            Some(Speed {
                id: format!("time/{}", run.folder),
                what: format!("time a step of {} over native exact", run.engine),
                unit: "times native".to_owned(),
                value,
                range: None,
                less_is_better: false,
            })
        };
        self.runs.iter().filter_map(of).collect()
    }
}

/// A comparison with the folders it was made from.
#[derive(Debug, Clone, Serialize)]
pub struct NamedComparison {
    /// The beginning of its checks' ids.
    pub id: String,
    /// What is compared.
    pub title: String,
    /// The run folders, in the output folder.
    pub folders: Vec<String>,
    /// What came out.
    pub comparison: Comparison,
}

/// A check that was skipped, and why.
#[derive(Debug, Clone, Serialize)]
pub struct Skipped {
    /// The check's id.
    pub id: String,
    /// The check.
    pub what: String,
    /// Why it was skipped.
    pub why: String,
    /// Whether the job is incomplete without it.
    pub required: bool,
}

/// A run in one line.
#[derive(Debug, Clone, Serialize)]
pub struct RunSummary {
    /// In the output folder.
    pub folder: String,
    /// Who ran, in words.
    pub engine: String,
    /// The stages, in words.
    pub stages: String,
    /// Wall time over all stages, µs.
    pub microseconds_per_step: f64,
    /// Time per step over that of the native run of this job; none for a run made elsewhere.
    pub times_native: Option<f64>,
    /// Wall time of all stages, s.
    pub wall_seconds: f64,
    /// How to do it again.
    pub command: String,
}

impl RunSummary {
    /// Of a run in this folder.
    pub fn of(folder: &str, run: &RunFolder) -> Self {
        RunSummary {
            folder: folder.to_owned(),
            engine: run.record.engine.label(),
            stages: run.stages_in_words(),
            microseconds_per_step: 1e6 * run.record.seconds_per_step(),
            times_native: None,
            wall_seconds: run
                .record
                .stages
                .iter()
                .map(|stage| stage.wall_seconds)
                .sum(),
            command: run.record.command.clone(),
        }
    }
}
