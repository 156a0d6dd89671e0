//! What `run.json` of the main job says, and its checks.

use serde::Serialize;

use super::beside::Stated;
use crate::checks::{Check, Measured, Outcome, Speed};
use crate::compare::Comparison;
use crate::compare::first_steps;
use crate::paper::published::{HEIGHTS, POROSITIES, Printed, printed};
use crate::paper::{self, Number};
use crate::run::folder::RunFolder;
use crate::suite::parameters::{ParameterPair, pair_checks};
use crate::suite::run::Verification;
use grains::scene::paper_scene;
use verdict::judge::Judgement;

#[derive(Debug, Clone, Serialize)]
pub struct Reproduction {
    pub crossgrain: String,
    pub command: String,
    pub scene_digest: String,
    /// The version of the YADE that ran live.
    pub yade: Option<String>,
    /// Of all checks; skipped if no comparison with another engine could be made or the experiment did not come to its end.
    pub verdict: Outcome,
    pub comparisons: Vec<NamedComparison>,
    /// What the first steps of YADE's loops say, if YADE ran live.
    pub first_steps: Vec<LoopSteps>,
    /// Deliberate faults, each of which the comparison must find.
    pub faults: Vec<FaultCheck>,
    /// The parameters that both engines use, if YADE ran live.
    pub facts: Vec<ParameterPair>,
    pub suite: Option<Verification>,
    pub skipped: Vec<Skipped>,
    pub claims: Vec<Claim>,
    pub numbers: Vec<Number>,
    pub text_faults: Vec<paper::TextFault>,
    /// Records of other jobs that stand on the page; they are no part of the verdict.
    pub beside: Vec<Stated>,
    pub runs: Vec<RunSummary>,
    pub seconds: f64,
}

impl Reproduction {
    pub fn checks(&self) -> Vec<Check> {
        let compared = self.comparisons.iter().any(|of| of.comparison.agrees());
        let (outcome, found) = if compared {
            (Outcome::Pass, "")
        } else {
            (Outcome::Skipped, "none that was made agrees")
        };
        let what = "at least one comparison with another engine";
        let compared = Check::of_words("compare/made", what, outcome, found);
        let mut checks = vec![compared.required()];
        for named in &self.comparisons {
            checks.extend(named.comparison.all_checks(&named.id));
        }
        for of in &self.first_steps {
            checks.extend(first_steps::checks(&of.judgement, &of.id));
        }
        for fault in &self.faults {
            let id = format!("faults/{}", fault.fault.replace('=', "-"));
            let check = Check::of_words(id, &fault.fault, fault.verdict, &fault.found);
            checks.push(check.judged_by(
                "the fault is put into the native engine alone; the comparison with the sound one must find it",
                "any bit that differs",
            ));
        }
        checks.extend(pair_checks(&self.facts));
        if let Some(suite) = &self.suite {
            // An engine that is not there leaves the job complete.
            checks.extend(suite.checks().into_iter().map(|check| Check {
                required: false,
                ..check
            }));
        }
        checks.extend(self.numbers.iter().map(Number::check));
        checks.extend(self.skipped.iter().map(|of| Check {
            required: of.required,
            ..Check::of_words(of.id.as_str(), &of.what, Outcome::Skipped, &of.why)
        }));
        checks
    }

    /// YADE's time a step over the native engine's, of the runs that were made live, one each.
    pub fn speeds(&self) -> Vec<Speed> {
        let of = |run: &RunSummary| {
            let way = run.folder.strip_prefix("yade-")?;
            Some(Speed {
                id: format!("time/{way}"),
                what: format!("time a step of {} over native", run.engine),
                unit: "times native".to_owned(),
                value: run.times_native?,
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
    pub title: String,
    pub folders: Vec<String>,
    pub comparison: Comparison,
}

/// What the first steps of one of YADE's loops say.
#[derive(Debug, Clone, Serialize)]
pub struct LoopSteps {
    /// The beginning of its checks' ids.
    pub id: String,
    pub title: String,
    pub judgement: Judgement,
}

#[derive(Debug, Clone, Serialize)]
pub struct Skipped {
    pub id: String,
    pub what: String,
    pub why: String,
    pub required: bool,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaultCheck {
    /// As on the command line.
    pub fault: String,
    /// Passed if the comparison found it; not made where the fault changes nothing in this scene.
    pub verdict: Outcome,
    /// The first step and grain, or why it was not found.
    pub found: String,
}

#[derive(Debug, Clone, Serialize)]
pub struct RunSummary {
    /// In the output folder.
    pub folder: String,
    /// Who ran, in words.
    pub engine: String,
    pub stages: String,
    /// Processor time over all stages, µs.
    pub microseconds_per_step: f64,
    /// Time per step over that of the native run of this job; none for a run made elsewhere.
    pub times_native: Option<f64>,
    /// Processor time of all stages, s.
    pub cpu_seconds: f64,
    pub command: String,
}

impl RunSummary {
    pub fn of(folder: &str, run: &RunFolder) -> Self {
        let record = &run.record;
        let parts = record.parts.map(|of| format!(", in {of} parts"));
        RunSummary {
            folder: folder.to_owned(),
            engine: record.engine.label(),
            stages: run.stages_in_words() + &parts.unwrap_or_default(),
            microseconds_per_step: 1e6 * record.seconds_per_step(),
            times_native: None,
            cpu_seconds: record.cpu_seconds(),
            command: record.command.clone(),
        }
    }
}

/// Everything that was measured in a run, for baselines to hold later runs against.
pub fn measured(run: &RunFolder) -> Vec<Measured> {
    let of = |quantity: grains::measure::Quantity| Measured {
        id: quantity.key,
        unit: quantity.unit,
        value: quantity.value,
    };
    run.quantities().into_iter().map(of).collect()
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Claim {
    pub what: String,
    /// As printed, in `unit`.
    pub published: f64,
    pub scatter: Option<f64>,
    /// From this run, in `unit`.
    pub ours: f64,
    /// SI unit, `1` for a ratio.
    pub unit: String,
    pub reading: String,
}

/// The claims that this run has a figure for; none for a scene that is not the paper's. One realization decides nothing about a
/// distribution, so these are findings, not checks.
pub fn claims(run: &RunFolder) -> Vec<Claim> {
    let scene = &run.scene;
    if scene.digest() != paper_scene(scene.realization, 5000).digest() {
        return Vec::new();
    }
    let measured = run.quantities();
    let claim = |what: String, key: &str, id: &str| {
        let figure: &Printed = printed(id)?;
        let ours = measured.iter().find(|quantity| quantity.key == key)?.value;
        let scatter = Some(figure.rounding).filter(|_| id.starts_with("bed/"));
        let off = (ours - figure.value).abs();
        let reading = match scatter {
            None => format!(
                "{:.2} of the published mean; one draw from a wide distribution",
                ours / figure.value
            ),
            Some(scatter) if off <= scatter => "within the published scatter".to_owned(),
            Some(_) => "outside the published scatter".to_owned(),
        };
        Some(Claim {
            what,
            published: figure.value,
            scatter,
            ours,
            unit: figure.unit.to_owned(),
            reading,
        })
    };
    let heights = HEIGHTS.map(|(key, words)| claim(format!("H, {words}"), key, "bed/height"));
    let porosities =
        POROSITIES.map(|(key, words)| claim(format!("n, {words}"), key, "bed/porosity"));
    let stresses = scene.control_points.iter().flat_map(|point| {
        let at = |what: &str, key: &str, column: &str| {
            let key = format!("loaded.stress.{}.{key}", point.name);
            let id = format!("table-4/{column}/{}", point.name);
            claim(format!("{what} at {}", point.name), &key, &id)
        };
        let extensive = "Σ_zz of V_c, nearest grain";
        [
            at("local mean σ_zz", "local_zz", "stress"),
            at(extensive, "control_volume_zz", "extensive"),
        ]
    });
    let all = heights.into_iter().chain(porosities).chain(stresses);
    all.flatten().collect()
}
