//! The map as a whole: every scene predicted, found in both engines and judged.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::beds::{bed_scene, beds, crystal};
use super::draft::Draft;
use super::failures::{Failure, failures};
use super::growth::Found;
use super::others::{look_in_exec, look_in_yade};
use super::scenes::{ClosedForm, small};
use crate::compare::{Check, Verdict};
use crate::engine::exec::{Brought, Description};
use crate::engine::yade::{self, Proposal};
use crate::error::Error;
use crate::interrupt::asked_to_end;
use crate::progress::Display;
use crate::run::EngineError;
use crate::suite::ladder::Climbers;
use grains::native::NativeError;

/// The version of `stability.json`.
pub const STABILITY_VERSION: u32 = 2;
/// Found and predicted limits may be so far apart, relative.
pub const ALLOWED: f64 = 0.03;
/// Cundall's α of the damped limits: YADE's default, and the paper scene's.
pub const ALPHA: f64 = 0.2;
/// Grains of the beds, quick and in full.
const QUICK_GRAINS: u32 = 500;
const FULL_GRAINS: u32 = 5000;
/// Rows of the crystal.
const ROWS: usize = 12;

/// Whose limits are looked for.
#[derive(Debug, Clone)]
pub enum Wanted {
    /// The native engine's, YADE's or both.
    BuiltIn(Climbers),
    /// Those of a program that was brought, alone.
    Exec(Brought),
}

impl Wanted {
    /// Whether the native engine's are.
    pub fn native(&self) -> bool {
        matches!(self, Wanted::BuiltIn(Climbers::Native | Climbers::Both))
    }

    /// Whether YADE's are.
    pub fn yade(&self) -> bool {
        matches!(self, Wanted::BuiltIn(Climbers::Yade | Climbers::Both))
    }
}

/// What is to be mapped, and how.
#[derive(Debug, Clone)]
pub struct Options {
    /// Which engines.
    pub engine: Wanted,
    /// Beds of 500 grains instead of 5,000.
    pub quick: bool,
    /// How YADE is started.
    pub yade: yade::Options,
    /// The command as it was given.
    pub command: String,
}

/// Limits with one damping number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Cundall's α.
    pub alpha: f64,
    /// From the springs of the contact network, s.
    pub predicted: f64,
    /// As found in the native engine.
    pub native: Option<Found>,
    /// As found in YADE.
    pub yade: Option<Found>,
    /// As found in the engine that was brought.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exec: Option<Found>,
}

/// A scene of the map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// A short name.
    pub name: String,
    /// What it is.
    pub title: String,
    /// What a reader should know of it; may be empty.
    pub remark: String,
    /// Number of grains.
    pub grains: usize,
    /// Number of contacts.
    pub contacts: usize,
    /// ω_max of the springs, rad/s.
    pub omega: f64,
    /// Lanczos vectors that the prediction took.
    pub vectors: usize,
    /// Relative bound of the error of the eigenvalue.
    pub residual: f64,
    /// The limit by a formula, where there is one.
    pub closed: Option<ClosedForm>,
    /// Without Cundall damping, from a random disturbance.
    pub undamped: Limits,
    /// With it, the fastest mode alone disturbed.
    pub damped: Limits,
    /// With it, from a random disturbance: not predicted.
    pub damped_at_random: Option<Found>,
    /// What YADE would choose, by its formulas.
    pub proposal: Proposal,
    /// What YADE says that it would choose.
    pub proposal_of_yade: Option<Proposal>,
    /// Why this scene was not made in the engine that was brought: a part that it lacks, or its own words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_made: Option<String>,
    /// What is judged.
    pub checks: Vec<Check>,
}

/// How many checks, by verdict.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Checks that hold.
    pub passed: usize,
    /// Checks that do not.
    pub failed: usize,
    /// Checks that could not be made.
    pub not_made: usize,
    /// Scenes that an engine that was brought does not have the parts for: nothing is missing.
    #[serde(default)]
    pub inapplicable: usize,
}

impl Tally {
    fn of(rows: &[Row], failures: &[Failure]) -> Self {
        let of_rows = rows.iter().flat_map(|row| &row.checks);
        let verdicts: Vec<Verdict> = of_rows
            .map(|check| check.verdict)
            .chain(failures.iter().map(|failure| failure.verdict))
            .collect();
        let count = |of: Verdict| verdicts.iter().filter(|verdict| **verdict == of).count();
        Tally {
            passed: count(Verdict::Pass),
            failed: count(Verdict::Fail),
            not_made: count(Verdict::NotMade),
            inapplicable: rows.iter().filter(|row| row.not_made.is_some()).count(),
        }
    }

    /// An engine that has the parts for no scene has shown nothing.
    fn verdict(self, scenes: usize) -> Verdict {
        if self.failed > 0 {
            Verdict::Fail
        } else if self.not_made > 0 || self.inapplicable == scenes {
            Verdict::NotMade
        } else {
            Verdict::Pass
        }
    }
}

/// The stability map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Map {
    /// [`STABILITY_VERSION`].
    pub version: u32,
    /// Version of crossgrain.
    pub crossgrain: String,
    /// The command as it was given.
    pub command: String,
    /// SHA-256 of the canonical JSON of the scene that the beds come from.
    pub scene_digest: String,
    /// YADE's version, if it ran.
    pub yade: Option<String>,
    /// Why it did not; empty if it did.
    pub missing: String,
    /// The engine that was brought, if the limits are those of one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exec: Option<Description>,
    /// Found and predicted may be so far apart, relative.
    pub allowed: f64,
    /// The scenes.
    pub rows: Vec<Row>,
    /// Where methods fail.
    pub failures: Vec<Failure>,
    /// How many checks, by verdict.
    pub tally: Tally,
    /// Failed if a check failed; not made if one is missing; else passed.
    pub verdict: Verdict,
    /// How long it took, s.
    pub seconds: f64,
}

fn native(error: NativeError) -> Error {
    Error::Engine(EngineError::Native(error))
}

/// Makes the map as asked.
pub fn map(options: &Options, display: &Display) -> Result<Map, Error> {
    let began = Instant::now();
    let grains = if options.quick {
        QUICK_GRAINS
    } else {
        FULL_GRAINS
    };
    let task = display.task("scenes at rest");
    let mut scenes = small();
    scenes.push(crystal(ROWS).map_err(native)?);
    scenes.extend(beds(grains).map_err(native)?);
    task.done("done");
    let task = display.task("native limits");
    let mut drafts = Vec::with_capacity(scenes.len());
    for (at, scene) in scenes.into_iter().enumerate() {
        task.share(at as f64 / 14.0, &scene.name);
        drafts.push(Draft::new(scene, options.engine.native()).map_err(native)?);
        if asked_to_end() {
            return Err(Error::Interrupted);
        }
    }
    task.done("done");
    let in_yade = if options.engine.yade() {
        look_in_yade(&mut drafts, &options.yade, display)?
    } else {
        Err("YADE was not asked for".to_owned())
    };
    let description = match &options.engine {
        Wanted::Exec(engine) => {
            look_in_exec(&mut drafts, engine, display)?;
            Some(engine.description.clone())
        }
        Wanted::BuiltIn(_) => None,
    };
    let task = display.task("where methods fail");
    let yade = in_yade.is_ok().then_some(&options.yade);
    let failures = failures(yade, &mut |share, name| task.share(share, name))?;
    task.done("done");
    let judged = |draft: Draft| draft.judged(&options.engine);
    let rows: Vec<Row> = drafts.into_iter().map(judged).collect();
    let tally = Tally::of(&rows, &failures);
    Ok(Map {
        version: STABILITY_VERSION,
        crossgrain: env!("CARGO_PKG_VERSION").to_owned(),
        command: options.command.clone(),
        scene_digest: bed_scene(grains).digest(),
        yade: in_yade.as_ref().ok().cloned(),
        missing: in_yade.err().unwrap_or_default(),
        exec: description,
        allowed: ALLOWED,
        verdict: tally.verdict(rows.len()),
        rows,
        failures,
        tally,
        seconds: began.elapsed().as_secs_f64(),
    })
}
