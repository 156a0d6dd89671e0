//! The stability map: the largest stable time step of scene after scene, predicted and found by trials, and the failure
//! modes of the method.

mod document;
pub mod failures;
pub mod scenes;
pub mod spectrum;
pub mod time_step;
pub mod trials;

use std::time::Instant;

use serde::{Deserialize, Serialize};

use crate::checks::{self, Check, Measured, Outcome};
use crate::engine::EngineError;
use crate::engine::exec::{self, Brought, missing_for_case};
use crate::engine::yade::{self, Proposal, propose};
use crate::error::Error;
use crate::files::work_folder;
use crate::interrupt::asked_to_end;
use crate::progress::{Display, StageObserver};
use failures::{Failure, failures};
use grains::native::NativeError;
use grains::task::Case;
use scenes::{ClosedForm, MapScene, bed_scene, beds, crystal, small};
use spectrum::Network;
use time_step::by_formula;
use trials::{Disturbed, Found, Search, SearchResult, find_all};

/// Found and predicted limits may be so far apart, relative.
pub const ALLOWED: f64 = 0.03;
/// Cundall's α of the damped limits: YADE's default, and the paper scene's.
pub const ALPHA: f64 = 0.2;
/// Grains of the beds, quick and in full.
const QUICK_GRAINS: u32 = 500;
const FULL_GRAINS: u32 = 5000;
/// Rows of the crystal.
const CRYSTAL_ROWS: usize = 12;

/// An engine that is a program.
#[derive(Debug, Clone)]
pub enum External {
    Yade(yade::Options),
    Exec(Brought),
}

/// What is to be mapped, and how.
#[derive(Debug, Clone)]
pub struct Options {
    /// Whether limits are looked for in the native engine.
    pub native: bool,
    /// Another engine whose limits are looked for.
    pub external: Option<External>,
    /// Beds of 500 grains instead of 5,000.
    pub quick: bool,
    /// The command as it was given.
    pub command: String,
}

/// Limits with one damping number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Cundall's α.
    pub alpha: f64,
    /// From the springs of the contact network, s.
    pub predicted: f64,
    /// As found in the native engine.
    pub native: Option<Found>,
    /// As found in the external engine.
    pub external: Option<Found>,
}

/// A scene of the map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
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
    /// Why the external engine was not given this scene: a part that it lacks, or its own words.
    pub skipped: Option<String>,
}

/// The external engine of a map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExternalEngine {
    pub name: String,
    /// None where it did not run.
    pub version: Option<String>,
    /// Where it does something else than the model says, in its words.
    pub approximations: Vec<String>,
    /// Why it did not run; empty if it did.
    pub missing: String,
}

/// The stability map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Map {
    /// Version of crossgrain.
    pub crossgrain: String,
    /// The command as it was given.
    pub command: String,
    /// SHA-256 of the canonical JSON of the scene that the beds come from.
    pub scene_digest: String,
    /// Whether limits were looked for in the native engine.
    pub native: bool,
    /// The other engine whose limits were looked for.
    pub external: Option<ExternalEngine>,
    /// The scenes.
    pub rows: Vec<Row>,
    /// Failure modes of the method in the native engine; none where that took no part.
    pub failures: Vec<Failure>,
    /// How long it took, s.
    pub seconds: f64,
}

/// A scene with its row, and how it is disturbed: at random without damping, in the fastest mode with it.
pub struct SceneTrials {
    pub row: Row,
    case: Case,
    disturbed: [Disturbed; 2],
}

impl SceneTrials {
    /// Predicts the limits of a scene, and finds them in the native engine if that is wanted.
    pub fn new(scene: MapScene, search: bool) -> Result<Self, NativeError> {
        let network = Network::of(&scene.case)?;
        let [springs, braked] = [0.0, ALPHA].map(|alpha| network.limit(alpha));
        let at_random = Disturbed::at_random(&scene.case, scene.axes)?;
        let in_mode = Disturbed::in_mode(&scene.case, &network.fastest_mode(ALPHA))?;
        let (mut damped, mut damped_at_random) = (None, None);
        let undamped = if search { at_random.undamped()? } else { None };
        if let Some(undamped) = &undamped {
            damped = in_mode.damped(ALPHA, undamped)?;
            damped_at_random = at_random.damped(ALPHA, undamped)?;
        }
        let limits = |alpha, predicted, native| Limits {
            alpha,
            predicted,
            native,
            external: None,
        };
        Ok(SceneTrials {
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
                skipped: None,
            },
            case: scene.case,
            disturbed: [at_random, in_mode],
        })
    }

    /// What an external engine is to look for: without damping, and with it.
    fn searches(&self) -> [Search; 2] {
        let [at_random, in_mode] = self.disturbed.clone();
        let of = |disturbed, limits: &Limits| {
            let about = limits
                .native
                .map_or(limits.predicted, |found| found.limit());
            Search::new(disturbed, limits.alpha, about)
        };
        [
            of(at_random, &self.row.undamped),
            of(in_mode, &self.row.damped),
        ]
    }
}

/// Finds the limits of all scenes in an external engine. Scenes of parts that it does not have are skipped; a YADE that is
/// missing or too old is no error.
pub fn find_external(
    scenes: &mut [SceneTrials],
    engine: &External,
    display: &Display,
) -> Result<ExternalEngine, Error> {
    let mut known = match engine {
        External::Yade(_) => ExternalEngine {
            name: "YADE".to_owned(),
            version: None,
            approximations: Vec::new(),
            missing: String::new(),
        },
        External::Exec(Brought { description, .. }) => ExternalEngine {
            name: description.name.clone(),
            version: Some(description.version.clone()),
            approximations: description.approximations.clone(),
            missing: String::new(),
        },
    };
    let task = display.task(&format!("limits in {}", known.name));
    match engine {
        External::Yade(options) => {
            let cases: Vec<&Case> = scenes.iter().map(|scene| &scene.case).collect();
            match propose(&cases, options, work_folder()?.path()) {
                Ok((proposals, version)) => {
                    for (scene, proposal) in scenes.iter_mut().zip(proposals) {
                        scene.row.proposal_of_yade = Some(proposal);
                    }
                    known.version = Some(version);
                }
                Err(error) if error.is_missing() => {
                    task.done("YADE is missing or too old");
                    known.missing = error.to_string();
                    return Ok(known);
                }
                Err(error) => return Err(Error::Engine(error.into())),
            }
        }
        External::Exec(Brought { description, .. }) => {
            for scene in &mut *scenes {
                // The damped search asks for all that the other does.
                let [_, damped] = scene.searches();
                let missing = missing_for_case(description, &damped.at_start());
                let words: Vec<&str> = missing.iter().map(|part| part.in_words()).collect();
                let reason = format!("{} has no {}", known.name, words.join(", "));
                scene.row.skipped = (!missing.is_empty()).then_some(reason);
            }
        }
    }
    let mut asked: Vec<&mut SceneTrials> = scenes
        .iter_mut()
        .filter(|scene| scene.row.skipped.is_none())
        .collect();
    let searches = asked.iter().flat_map(|scene| scene.searches()).collect();
    let mut observer = StageObserver::new(&task);
    let found = find_all(searches, |cases| -> Result<_, Error> {
        let work = work_folder()?;
        match engine {
            External::Yade(options) => {
                let run = yade::run_cases(cases, options, work.path(), &mut observer)
                    .map_err(EngineError::from)?;
                Ok(run.cases.into_iter().map(|case| Ok(case.track)).collect())
            }
            External::Exec(Brought {
                options,
                description,
                ..
            }) => {
                let tracks =
                    exec::run_cases(cases, description, options, work.path(), &mut observer);
                Ok(tracks.map_err(EngineError::from)?)
            }
        }
    })?;
    for (scene, found) in asked.iter_mut().zip(found.chunks(2)) {
        scene.row.take(&known.name, found);
    }
    task.done("done");
    Ok(known)
}

/// Makes the map as asked.
pub fn map(options: &Options, display: &Display) -> Result<Map, Error> {
    let native = |error: NativeError| Error::Engine(EngineError::Native(error));
    let began = Instant::now();
    let grains = if options.quick {
        QUICK_GRAINS
    } else {
        FULL_GRAINS
    };
    let task = display.task("scenes at rest");
    let mut scenes = small();
    scenes.push(crystal(CRYSTAL_ROWS).map_err(native)?);
    scenes.extend(beds(grains).map_err(native)?);
    task.done("done");
    let task = display.task("native limits");
    let count = scenes.len() as f64;
    let mut trials = Vec::with_capacity(scenes.len());
    for (at, scene) in scenes.into_iter().enumerate() {
        task.share(at as f64 / count, &scene.name);
        trials.push(SceneTrials::new(scene, options.native).map_err(native)?);
        if asked_to_end() {
            return Err(Error::Interrupted);
        }
    }
    task.done("done");
    let external = match &options.external {
        Some(engine) => Some(find_external(&mut trials, engine, display)?),
        None => None,
    };
    let mut failures_found = Vec::new();
    if options.native {
        let task = display.task("failure modes");
        let yade = match (&options.external, &external) {
            (Some(External::Yade(yade)), Some(known)) if known.missing.is_empty() => Some(yade),
            _ => None,
        };
        failures_found = failures(yade, &mut |share, name| task.share(share, name))?;
        task.done("done");
    }
    Ok(Map {
        crossgrain: env!("CARGO_PKG_VERSION").to_owned(),
        command: options.command.clone(),
        scene_digest: bed_scene(grains).digest(),
        native: options.native,
        external,
        rows: trials.into_iter().map(|scene| scene.row).collect(),
        failures: failures_found,
        seconds: began.elapsed().as_secs_f64(),
    })
}

impl Row {
    /// Takes over what an external engine of this name found without damping and with it.
    fn take(&mut self, name: &str, found: &[SearchResult]) {
        let refused = found.iter().find_map(|found| found.as_ref().err());
        self.skipped = refused.map(|reason| format!("{name} refused: {reason}"));
        if let [Ok(undamped), Ok(damped)] = found {
            self.undamped.external = *undamped;
            self.damped.external = *damped;
        }
    }

    /// Both limits, each with the word for it in ids.
    fn limits(&self) -> [(&'static str, &Limits); 2] {
        [("undamped", &self.undamped), ("damped", &self.damped)]
    }
}

impl Map {
    /// A check for each closed form, each limit that was looked for, each scene that the external engine skipped, and each
    /// failure mode.
    pub fn checks(&self) -> Vec<Check> {
        let rows = self.rows.iter().flat_map(|row| self.checks_of(row));
        let failures = self.failures.iter().map(|of| {
            let id = format!("stability/failures/{}", of.name);
            Check::of_words(id, &of.title, of.outcome, &of.happened).required()
        });
        rows.chain(failures).collect()
    }

    fn checks_of(&self, row: &Row) -> Vec<Check> {
        let id = format!("stability/{}", row.name);
        let mut checks = Vec::new();
        if let Some(closed) = &row.closed {
            let over = row.undamped.predicted / closed.dt;
            let quantity = format!("{}: predicted limit over the closed form's", row.title);
            checks.push(
                judged(
                    format!("{id}/closed-form"),
                    &quantity,
                    over,
                    closed.tolerance,
                )
                .judged_by(&closed.formula, "docs/stability.md: of the pre-stress"),
            );
        }
        for (word, limits) in row.limits() {
            let mut check = |engine: &str, name: &str, found: Option<Found>| {
                let id = format!("{id}/{word}/{engine}");
                let quantity = format!(
                    "{}: limit in {name} over the predicted one, α = {}",
                    row.title, limits.alpha
                );
                checks.push(of_limit(id, &quantity, limits.predicted, found));
            };
            if self.native {
                check("built-in", "the native engine", limits.native);
            }
            if let Some(engine) = self.external.as_ref().filter(|_| row.skipped.is_none()) {
                check("external", &engine.name, limits.external);
            }
        }
        if let Some(reason) = &row.skipped {
            let id = format!("{id}/external");
            // An engine that has the parts for no scene has shown nothing.
            let required = self.rows.iter().all(|row| row.skipped.is_some());
            checks.push(Check {
                required,
                ..Check::of_words(id, &row.title, Outcome::Skipped, reason)
            });
        }
        checks
    }

    /// What all checks come to.
    pub fn verdict(&self) -> Outcome {
        checks::verdict(&self.checks())
    }

    /// What was predicted, which only a change of the model moves.
    pub fn measured(&self) -> Vec<Measured> {
        let of_row = |row: &Row| {
            row.limits().map(|(word, limits)| Measured {
                id: format!("stability/{}/{word}/predicted", row.name),
                unit: "s".to_owned(),
                value: limits.predicted,
            })
        };
        self.rows.iter().flat_map(of_row).collect()
    }
}

/// A ratio that should be 1.
fn judged(id: String, quantity: &str, over: f64, allowed: f64) -> Check {
    let off = over - 1.0;
    let outcome = Outcome::pass_if(off.abs() <= allowed);
    let percent = |share: f64| format!("{:+.2} %", 100.0 * share);
    let found = format!("{} apart, {} allowed", percent(off), percent(allowed));
    Check::of_words(id, quantity, outcome, &found)
        .with_limits(over, 1.0, Some(allowed))
        .required()
}

fn of_limit(id: String, quantity: &str, predicted: f64, found: Option<Found>) -> Check {
    let Some(found) = found else {
        return Check::of_words(id, quantity, Outcome::Skipped, "no limit was found").required();
    };
    Check {
        interval: Some([found.stable / predicted, found.unstable / predicted]),
        ..judged(id, quantity, found.limit() / predicted, ALLOWED).judged_by(
            "the step at which a disturbance of a bed at rest begins to grow, over the predicted one; the interval is from the largest \
             step at which it did not grow to the smallest at which it did",
            "docs/stability.md: found and predicted may be so far apart",
        )
    }
}
