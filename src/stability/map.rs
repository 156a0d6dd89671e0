//! The map as a whole: every scene predicted, found in both engines and judged.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::beds::{bed_scene, beds, crystal};
use super::failures::{Failure, failures};
use super::growth::{Disturbed, Found};
use super::in_yade::{Search, find_all};
use super::network::Network;
use super::proposals::by_formula;
use super::scenes::{ClosedForm, MapScene, small};
use super::spectrum::{fastest_mode, limit};
use crate::compare::{Check, Verdict};
use crate::engine::case::Case;
use crate::engine::native::NativeError;
use crate::engine::yade::{self, Proposal, YadeError, propose};
use crate::error::Error;
use crate::files::work_folder;
use crate::interrupt::asked_to_end;
use crate::progress::{Display, StageObserver};
use crate::run::EngineError;
use crate::verify::ladder::Climbers;

/// The version of `stability.json`.
pub const STABILITY_VERSION: u32 = 1;
/// Found and predicted limits may be so far apart, relative.
pub const ALLOWED: f64 = 0.03;
/// Cundall's α of the damped limits: YADE's default, and the paper scene's.
pub const ALPHA: f64 = 0.2;
/// Grains of the beds, quick and in full.
const QUICK_GRAINS: u32 = 500;
const FULL_GRAINS: u32 = 5000;
/// Rows of the crystal.
const ROWS: usize = 12;

/// What is to be mapped, and how.
#[derive(Debug, Clone)]
pub struct Options {
    /// Which engines.
    pub engine: Climbers,
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
        drafts.push(Draft::new(scene, options.engine != Climbers::Yade).map_err(native)?);
        if asked_to_end() {
            return Err(Error::Interrupted);
        }
    }
    task.done("done");
    let in_yade = match options.engine {
        Climbers::Native => Err("YADE was not asked for".to_owned()),
        Climbers::Yade | Climbers::Both => look_in_yade(&mut drafts, options, display)?,
    };
    let task = display.task("where methods fail");
    let yade = in_yade.is_ok().then_some(&options.yade);
    let failures = failures(yade, &mut |share, name| task.share(share, name))?;
    task.done("done");
    let rows: Vec<Row> = drafts
        .into_iter()
        .map(|draft| draft.judged(options.engine))
        .collect();
    let verdicts: Vec<Verdict> = rows
        .iter()
        .flat_map(|row| &row.checks)
        .map(|check| check.verdict)
        .chain(failures.iter().map(|failure| failure.verdict))
        .collect();
    let count = |of: Verdict| verdicts.iter().filter(|verdict| **verdict == of).count();
    let tally = Tally {
        passed: count(Verdict::Pass),
        failed: count(Verdict::Fail),
        not_made: count(Verdict::NotMade),
    };
    Ok(Map {
        version: STABILITY_VERSION,
        crossgrain: env!("CARGO_PKG_VERSION").to_owned(),
        command: options.command.clone(),
        scene_digest: bed_scene(grains).digest(),
        yade: in_yade.as_ref().ok().cloned(),
        missing: in_yade.err().unwrap_or_default(),
        allowed: ALLOWED,
        rows,
        failures,
        tally,
        verdict: match tally {
            Tally { failed: 1.., .. } => Verdict::Fail,
            Tally { not_made: 1.., .. } => Verdict::NotMade,
            _ => Verdict::Pass,
        },
        seconds: began.elapsed().as_secs_f64(),
    })
}

/// A scene on its way to a row.
struct Draft {
    row: Row,
    case: Case,
    at_random: Disturbed,
    in_mode: Disturbed,
}

impl Draft {
    /// Predicts the limits of a scene and finds them in the native engine, if that is wanted.
    fn new(scene: MapScene, search: bool) -> Result<Self, NativeError> {
        let network = Network::of(&scene.case)?;
        let [springs, braked] = [0.0, ALPHA].map(|alpha| limit(&network, alpha));
        let mode = fastest_mode(&network, ALPHA);
        let at_random = Disturbed::at_random(&scene.case, scene.axes)?;
        let in_mode = Disturbed::in_mode(&scene.case, &mode)?;
        let mut undamped = None;
        let mut damped = None;
        let mut damped_at_random = None;
        if search {
            undamped = at_random.undamped()?;
            if let Some(undamped) = &undamped {
                damped = in_mode.damped(ALPHA, undamped)?;
                damped_at_random = at_random.damped(ALPHA, undamped)?;
            }
        }
        let limits = |alpha, predicted, native| Limits {
            alpha,
            predicted,
            native,
            yade: None,
        };
        Ok(Draft {
            row: Row {
                name: scene.name,
                title: scene.title,
                remark: scene.remark,
                grains: scene.case.bodies.len(),
                contacts: network.contacts(),
                omega: springs.omega,
                vectors: springs.vectors,
                residual: springs.residual,
                closed: scene.closed,
                undamped: limits(0.0, springs.dt, undamped),
                damped: limits(ALPHA, braked.dt, damped),
                damped_at_random,
                proposal: by_formula(&scene.case)?,
                proposal_of_yade: None,
                checks: Vec::new(),
            },
            case: scene.case,
            at_random,
            in_mode,
        })
    }

    fn judged(self, engines: Climbers) -> Row {
        let mut row = self.row;
        if let Some(closed) = &row.closed {
            let off = row.undamped.predicted / closed.dt - 1.0;
            row.checks.push(Check {
                name: "predicted against the closed form".to_owned(),
                verdict: verdict(off.abs() <= closed.tolerance),
                found: format!(
                    "{} apart, {} allowed",
                    percent(off),
                    percent(closed.tolerance)
                ),
            });
        }
        for limits in [row.undamped, row.damped] {
            let in_native = ("native", limits.native, engines != Climbers::Yade);
            let in_yade = ("YADE", limits.yade, engines != Climbers::Native);
            for (engine, found, wanted) in [in_native, in_yade] {
                if wanted {
                    row.checks.push(of_limit(engine, &limits, found));
                }
            }
        }
        row
    }
}

fn of_limit(engine: &str, limits: &Limits, found: Option<Found>) -> Check {
    let name = format!("{engine} against predicted, α = {}", limits.alpha);
    match found {
        Some(found) => {
            let off = found.limit / limits.predicted - 1.0;
            Check {
                name,
                verdict: verdict(off.abs() <= ALLOWED),
                found: format!("{} apart, {} allowed", percent(off), percent(ALLOWED)),
            }
        }
        None => Check {
            name,
            verdict: Verdict::NotMade,
            found: "no limit was found".to_owned(),
        },
    }
}

fn verdict(holds: bool) -> Verdict {
    if holds { Verdict::Pass } else { Verdict::Fail }
}

/// `+0.12 %`
pub fn percent(share: f64) -> String {
    format!("{:+.2} %", 100.0 * share)
}

/// What YADE makes of all scenes, and its version; the inner error says why there is no YADE.
fn look_in_yade(
    drafts: &mut [Draft],
    options: &Options,
    display: &Display,
) -> Result<Result<String, String>, Error> {
    let failed = |error: YadeError| Error::Engine(EngineError::Yade(error));
    let task = display.task("limits in YADE");
    let cases: Vec<&Case> = drafts.iter().map(|draft| &draft.case).collect();
    let work = work_folder()?;
    let (proposals, version) = match propose(&cases, &options.yade, work.path()) {
        Ok(answer) => answer,
        Err(error @ (YadeError::Missing(_) | YadeError::TooOld { .. })) => {
            task.done("YADE is missing or too old");
            return Ok(Err(error.to_string()));
        }
        Err(error) => return Err(failed(error)),
    };
    let searches = drafts.iter().flat_map(|draft| {
        let about = |limits: &Limits| limits.native.map_or(limits.predicted, |found| found.limit);
        [
            Search::new(
                draft.at_random.clone(),
                draft.row.undamped.alpha,
                about(&draft.row.undamped),
            ),
            Search::new(
                draft.in_mode.clone(),
                draft.row.damped.alpha,
                about(&draft.row.damped),
            ),
        ]
    });
    let mut observer = StageObserver::new(&task);
    let found = find_all(searches.collect(), &options.yade, &mut observer).map_err(failed)?;
    for ((draft, proposal), found) in drafts.iter_mut().zip(proposals).zip(found.chunks(2)) {
        draft.row.proposal_of_yade = Some(proposal);
        if let [undamped, damped] = found {
            draft.row.undamped.yade = *undamped;
            draft.row.damped.yade = *damped;
        }
    }
    task.done("done");
    Ok(Ok(version))
}
