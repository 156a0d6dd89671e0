//! What `run.json` of the main job says.

use serde::Serialize;

use super::claims::Claim;
use super::faults::FaultCheck;
use crate::compare::{Comparison, Verdict};
use crate::folder::RunFolder;
use crate::paper;

/// The version of the reproduction's `run.json`.
pub const REPRODUCTION_VERSION: u32 = 1;

/// The result of the main job.
#[derive(Debug, Clone, Serialize)]
pub struct Reproduction {
    pub version: u32,
    pub crossgrain: String,
    pub command: String,
    pub scene_digest: String,
    /// The version of the YADE that ran live.
    pub yade: Option<String>,
    /// Failed if a comparison or a fault check failed; not made if no comparison with another engine
    /// could be made or the experiment did not come to its end; else passed. What could not be checked
    /// is in `not_made`.
    pub verdict: Verdict,
    pub comparisons: Vec<NamedComparison>,
    /// Deliberate faults, each of which the comparison must find.
    pub faults: Vec<FaultCheck>,
    pub not_made: Vec<NotMade>,
    pub claims: Vec<Claim>,
    pub numbers: Vec<paper::Number>,
    pub text_faults: Vec<paper::TextFault>,
    pub runs: Vec<RunSummary>,
    pub seconds: f64,
}

/// How many checks fared how.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tally {
    pub passed: usize,
    pub failed: usize,
    pub not_made: usize,
}

impl Reproduction {
    /// Counts the checks of all comparisons, each measured quantity and each fault among them.
    pub fn tally(&self) -> Tally {
        let mut verdicts = Vec::new();
        for named in &self.comparisons {
            verdicts.extend(named.comparison.checks.iter().map(|check| check.verdict));
            verdicts.extend(named.comparison.quantities.iter().map(|pair| pair.verdict));
        }
        verdicts.extend(self.faults.iter().map(|fault| fault.verdict));
        let count = |of: Verdict| verdicts.iter().filter(|verdict| **verdict == of).count();
        Tally {
            passed: count(Verdict::Pass),
            failed: count(Verdict::Fail),
            not_made: count(Verdict::NotMade) + self.not_made.len(),
        }
    }
}

/// A comparison with the folders it was made from.
#[derive(Debug, Clone, Serialize)]
pub struct NamedComparison {
    pub title: String,
    pub folders: Vec<String>,
    pub comparison: Comparison,
}

/// A check that was not made, and why.
#[derive(Debug, Clone, Serialize)]
pub struct NotMade {
    pub what: String,
    pub why: String,
}

/// A run in one line.
#[derive(Debug, Clone, Serialize)]
pub struct RunSummary {
    pub folder: String,
    pub engine: String,
    pub stages: String,
    pub microseconds_per_step: f64,
    /// Time per step over that of the native run of this job; none for a run made elsewhere.
    pub times_native: Option<f64>,
    pub wall_seconds: f64,
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
