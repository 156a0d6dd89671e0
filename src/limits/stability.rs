//! The stability map: the largest stable time step of scene after scene, predicted and found by trials, and the failure
//! modes of the method. A study: a task is one scene in one engine, or one failure mode in one engine.

mod document;
pub mod failures;
pub mod scenes;
pub mod spectrum;
pub mod spheres;
pub mod time_step;
pub mod trials;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;

use serde::{Deserialize, Serialize};

use crate::checks::{Check, Measured, Outcome, verdict};
use crate::engine::exec::Description;
use crate::engine::yade::{Proposal, propose};
use crate::engine::{EngineError, ProgramError};
use crate::files::new_folder;
use crate::study::folder::StudyFolder;
use crate::study::plan::Program;
use crate::study::realization::{Engines, Runner};
use crate::study::{Judged, Outline, Study, StudyError};
use crate::workers::lock;
use failures::{Failure, MODES, Mode};
use grains::native::NativeError;
use scenes::{ClosedForm, MapScene, bed_scene};
use spectrum::Network;
use spheres::Spheres;
use time_step::by_formula;
use trials::{Disturbed, Found, Search, find_all};

/// Found and predicted limits may be so far apart, relative.
pub const ALLOWED: f64 = 0.03;
/// Cundall's α of the damped limits: YADE's default, and the paper scene's.
pub const ALPHA: f64 = 0.2;
/// Grains of the beds, quick and in full.
const QUICK_GRAINS: u32 = 500;
const FULL_GRAINS: u32 = 5000;
const QUICK_SPHERES: u32 = 150;
const FULL_SPHERES: u32 = 200;
const NATIVE: Runner = Runner::Native;

type Result<T, E = NativeError> = std::result::Result<T, E>;

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stability {
    /// Whether limits are looked for in the native engine.
    pub native: bool,
    /// Another engine whose limits are looked for.
    pub external: Option<Runner>,
    pub scenes: Vec<String>,
    /// Names of the failure modes that are tried in the native engine, and in YADE where that takes part and it is cheap.
    pub failures: Vec<String>,
    pub grains: u32,
    /// Whether the scenes are of spheres in space.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub in_space: bool,
    /// Digest of the scene that the beds come from, in space the first.
    pub scene_digest: String,
    /// Beds that were made, which several tasks start from.
    #[serde(skip)]
    beds: Mutex<BTreeMap<String, MapScene>>,
}

#[derive(Clone, Copy)]
enum Task<'a> {
    /// The limits of the scene of this name.
    Limits(&'a str, Runner),
    Failure(&'static Mode, Runner),
}

/// What a task gives.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Made {
    /// A scene with the limits of one engine, and the engine's version.
    Limits {
        runner: Runner,
        version: String,
        row: Box<Row>,
    },
    Failure(Failure),
    /// What a failure mode comes to in YADE.
    FailureInYade {
        name: String,
        end: String,
    },
}

impl Stability {
    /// Every scene in these engines, and in the plane every failure mode where the native one takes part.
    pub fn new(native: bool, external: Option<Runner>, quick: bool, in_space: bool) -> Self {
        let grains = match (in_space, quick) {
            (false, true) => QUICK_GRAINS,
            (false, false) => FULL_GRAINS,
            (true, true) => QUICK_SPHERES,
            (true, false) => FULL_SPHERES,
        };
        let modes = MODES.iter().filter(|_| native && !in_space);
        Stability {
            native,
            external,
            scenes: match in_space {
                true => spheres::names(quick),
                false => scenes::names(),
            },
            failures: modes.map(|mode| mode.name.to_owned()).collect(),
            grains,
            in_space,
            scene_digest: scene_digest(grains, in_space),
            beds: Mutex::default(),
        }
    }

    /// All limits, then all failure modes; those of the native engine first.
    fn tasks(&self) -> Vec<Task<'_>> {
        let engines = self.native.then_some(NATIVE).into_iter();
        let engines = engines.chain(self.external);
        let limits = engines.flat_map(|engine| {
            let scenes = self.scenes.iter();
            scenes.map(move |name| Task::Limits(name, engine))
        });
        let modes = || self.failures.iter().filter_map(|name| Mode::of(name));
        let native = modes().map(|mode| Task::Failure(mode, NATIVE));
        let in_yade = self.external.filter(|engine| engine.is_yade());
        let in_yade = in_yade.into_iter().flat_map(|engine| {
            let cheap = modes().filter(|mode| mode.in_yade);
            cheap.map(move |mode| Task::Failure(mode, engine))
        });
        limits.chain(native).chain(in_yade).collect()
    }

    fn task(&self, number: u64) -> Task<'_> {
        self.tasks()[number as usize - 1]
    }

    /// The scene of this name; beds are made once.
    fn scene(&self, name: &str) -> Result<MapScene> {
        scenes::of(name, self.grains, &mut lock(&self.beds))
    }
}

fn scene_digest(grains: u32, in_space: bool) -> String {
    let scene = match in_space {
        true => spheres::bed_scene(grains, spheres::MODULI[0]),
        false => bed_scene(grains),
    };
    scene.digest()
}

impl Study for Stability {
    const KIND: &'static str = "stability";
    type Row = Made;

    fn count(&self) -> u64 {
        self.tasks().len() as u64
    }

    fn check(&self) -> Result<(), String> {
        let known = match self.in_space {
            true => spheres::names(false),
            false => scenes::names(),
        };
        let strange = self.scenes.iter().find(|name| !known.contains(name));
        let strange =
            strange.or_else(|| self.failures.iter().find(|name| Mode::of(name).is_none()));
        if let Some(name) = strange {
            return Err(format!("{name:?} is no scene and no failure mode"));
        }
        if self.external.is_some_and(Runner::is_native) {
            return Err("the other engine is the native one".to_owned());
        }
        if scene_digest(self.grains, self.in_space) != self.scene_digest {
            return Err("the scene of the beds is not the one that was planned".to_owned());
        }
        Ok(())
    }

    fn runner(&self, task: u64) -> Runner {
        let (Task::Limits(_, runner) | Task::Failure(_, runner)) = self.task(task);
        runner
    }

    fn identity(&self, task: u64) -> String {
        match self.task(task) {
            Task::Limits(name, runner) => {
                format!("limits {name} {} {}", runner.name(), self.scene_digest)
            }
            Task::Failure(mode, runner) => format!("failure {} {}", mode.name, runner.name()),
        }
    }

    fn run(&self, task: u64, engines: &Engines, work: &Path) -> Result<Made, EngineError> {
        match self.task(task) {
            Task::Limits(name, runner) => {
                let mut trials = SceneTrials::new(self.scene(name)?)?;
                let version = match runner {
                    Runner::Native => trials.in_native()?,
                    _ => trials.in_external(runner, engines, work)?,
                };
                Ok(Made::Limits {
                    runner,
                    version,
                    row: Box::new(trials.row),
                })
            }
            Task::Failure(mode, Runner::Native) => Ok(Made::Failure(mode.in_native()?)),
            Task::Failure(mode, runner) => Ok(Made::FailureInYade {
                name: mode.name.to_owned(),
                end: mode.in_engine(engines.engine(runner)?.as_ref(), work)?,
            }),
        }
    }

    fn belongs(&self, task: u64, made: &Made) -> bool {
        match (self.task(task), made) {
            (Task::Limits(name, wanted), Made::Limits { runner, row, .. }) => {
                row.name == name && *runner == wanted
            }
            (Task::Failure(mode, NATIVE), Made::Failure(failure)) => failure.name == mode.name,
            (Task::Failure(mode, _), Made::FailureInYade { name, .. }) => name == mode.name,
            _ => false,
        }
    }

    fn outline(&self, made: &Made) -> Outline {
        let over = |limits: &Limits| {
            let found = limits.native.or(limits.external)?;
            Some(format!("{:?}", found.limit() / limits.predicted))
        };
        let (ending, name, found) = match made {
            Made::Limits { row, .. } => (
                "limits",
                &row.name,
                row.limits().map(|(_, limits)| over(limits)),
            ),
            Made::Failure(failure) => ("failure", &failure.name, [None, None]),
            Made::FailureInYade { name, .. } => ("failure_in_yade", name, [None, None]),
        };
        let [undamped, damped] = found.map(Option::unwrap_or_default);
        let cells = [
            ("name", name.clone()),
            ("undamped_over_predicted", undamped),
            ("damped_over_predicted", damped),
        ];
        Outline::new(ending, cells, &BTreeMap::new())
    }

    fn judge(folder: &StudyFolder<Self>) -> Result<Judged, StudyError> {
        let mut map = Map::new(&folder.plan.study, folder.plan.program.as_ref());
        folder.each(|_, made| map.take(made))?;
        let places = &folder.plan.study.scenes;
        map.rows
            .sort_by_key(|row| places.iter().position(|name| *name == row.name));
        Ok(Judged {
            measured: map.measured(),
            ..Judged::of(Self::KIND, &map, map.document())?
        })
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    pub alpha: f64,
    /// From the springs of the contact network, s.
    pub predicted: f64,
    pub native: Option<Found>,
    pub external: Option<Found>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    pub name: String,
    pub title: String,
    /// What a reader should know of it; may be empty.
    pub remark: String,
    pub grains: usize,
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
    pub proposal: Proposal,
    /// What YADE says that it would choose.
    pub proposal_of_yade: Option<Proposal>,
    /// Why the external engine was not given this scene: a part that it lacks, or its own words.
    pub skipped: Option<String>,
    /// What rules of thumb for spheres in space go by.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spheres: Option<Spheres>,
}

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

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Map {
    /// SHA-256 of the canonical JSON of the scene that the beds come from.
    pub scene_digest: String,
    /// Whether limits were looked for in the native engine.
    pub native: bool,
    /// The other engine whose limits were looked for.
    pub external: Option<ExternalEngine>,
    pub rows: Vec<Row>,
    /// Failure modes of the method in the native engine; none where that took no part.
    pub failures: Vec<Failure>,
}

/// A scene with its row, and how it is disturbed: at random without damping, in the fastest mode with it.
struct SceneTrials {
    row: Row,
    scene: MapScene,
    disturbed: [Disturbed; 2],
}

impl SceneTrials {
    /// Predicts the limits of a scene.
    fn new(scene: MapScene) -> Result<Self> {
        let network = Network::of(&scene.case)?;
        let springs = network.limit(0.0);
        let limits = |alpha| Limits {
            alpha,
            predicted: network.limit(alpha).dt,
            native: None,
            external: None,
        };
        Ok(SceneTrials {
            row: Row {
                name: scene.name.clone(),
                title: scene.title.clone(),
                remark: scene.remark.clone(),
                grains: scene.case.bodies.len(),
                contacts: network.contacts(),
                omega: springs.omega,
                vectors: springs.vectors,
                residual: springs.residual,
                closed: scene.closed.clone(),
                undamped: limits(0.0),
                damped: limits(ALPHA),
                damped_at_random: None,
                proposal: by_formula(&scene.case)?,
                proposal_of_yade: None,
                skipped: None,
                spheres: Spheres::of(&scene)?,
            },
            disturbed: [
                Disturbed::at_random(&scene.case, scene.axes)?,
                Disturbed::in_mode(&scene.case, &network.fastest_mode(ALPHA))?,
            ],
            scene,
        })
    }

    /// Finds the limits in the native engine; its version.
    fn in_native(&mut self) -> Result<String> {
        let [at_random, in_mode] = &self.disturbed;
        let row = &mut self.row;
        row.undamped.native = at_random.undamped()?;
        if let Some(undamped) = &row.undamped.native {
            row.damped.native = in_mode.damped(ALPHA, undamped)?;
            row.damped_at_random = at_random.damped(ALPHA, undamped)?;
        }
        Ok(env!("CARGO_PKG_VERSION").to_owned())
    }

    /// Finds them in another engine, about the predicted ones; its version. `work` is an empty folder. A scene of parts that
    /// the engine does not have is skipped, and so is one that it refuses.
    fn in_external(
        &mut self,
        runner: Runner,
        engines: &Engines,
        work: &Path,
    ) -> Result<String, EngineError> {
        let mut starts = 0..;
        let mut place = || {
            let path = work.join(starts.next().unwrap_or(0).to_string());
            new_folder(&path).map(|()| path).map_err(ProgramError::from)
        };
        let [at_random, in_mode] = self.disturbed.clone();
        let searches = [(at_random, &self.row.undamped), (in_mode, &self.row.damped)]
            .map(|(disturbed, limits)| Search::new(disturbed, limits.alpha, limits.predicted));
        let engine = engines.engine(runner)?;
        let (name, version) = if runner.is_yade() {
            let options = &engines.yade;
            let (proposals, version) = propose(&[&self.scene.case], options, &place()?)?;
            self.row.proposal_of_yade = proposals.into_iter().next();
            ("YADE".to_owned(), version)
        } else {
            let Description { name, version, .. } = engine.describe()?;
            (name, version)
        };
        // The damped search asks for all that the other does.
        if let Some(lacking) = engine.lacks_for(&searches[1].at_start()) {
            self.row.skipped = Some(format!("{name} has no {lacking}"));
            return Ok(version);
        }
        let found = find_all(searches.into(), |cases| engine.run_cases(cases, &place()?))?;
        let refused = found.iter().find_map(|found| found.as_ref().err());
        self.row.skipped = refused.map(|reason| format!("{name} refused: {reason}"));
        if let [Ok(undamped), Ok(damped)] = &found[..] {
            self.row.undamped.external = *undamped;
            self.row.damped.external = *damped;
        }
        Ok(version)
    }
}

impl Row {
    /// Takes over what another row of the scene has of its own engine.
    fn take(&mut self, other: Row) {
        let undamped = (&mut self.undamped, other.undamped);
        for (own, theirs) in [undamped, (&mut self.damped, other.damped)] {
            own.native = own.native.or(theirs.native);
            own.external = own.external.or(theirs.external);
        }
        self.damped_at_random = self.damped_at_random.or(other.damped_at_random);
        self.proposal_of_yade = self.proposal_of_yade.take().or(other.proposal_of_yade);
        self.skipped = self.skipped.take().or(other.skipped);
    }

    /// Both limits, each with the word for it in ids.
    fn limits(&self) -> [(&'static str, &Limits); 2] {
        [("undamped", &self.undamped), ("damped", &self.damped)]
    }
}

impl Map {
    fn new(plan: &Stability, program: Option<&Program>) -> Self {
        let described = program.map(|program| &program.described);
        let name = described.map_or("YADE", |description| &description.name);
        let external = plan.external.map(|_| ExternalEngine {
            name: name.to_owned(),
            version: None,
            approximations: described
                .map_or(Vec::new(), |description| description.approximations.clone()),
            missing: "it has made no rows yet".to_owned(),
        });
        Map {
            scene_digest: plan.scene_digest.clone(),
            native: plan.native,
            external,
            rows: Vec::new(),
            failures: Vec::new(),
        }
    }

    /// Takes over what a task gave; those of the native engine come first.
    fn take(&mut self, made: Made) {
        match made {
            Made::Limits {
                runner,
                version,
                row,
            } => {
                if let Some(engine) = self.external.as_mut().filter(|_| !runner.is_native()) {
                    engine.version = Some(version);
                    engine.missing.clear();
                }
                match self.rows.iter_mut().find(|known| known.name == row.name) {
                    Some(known) => known.take(*row),
                    None => self.rows.push(*row),
                }
            }
            Made::Failure(failure) => self.failures.push(failure),
            Made::FailureInYade { name, end } => {
                if let Some(failure) = self
                    .failures
                    .iter_mut()
                    .find(|failure| failure.name == name)
                {
                    failure.yade = Some(end);
                }
            }
        }
    }

    /// A check for each closed form, each limit that was looked for, each scene that the external engine skipped, and each
    /// failure mode.
    pub fn checks(&self) -> Vec<Check> {
        let rows = self.rows.iter().flat_map(|row| self.checks_of(row));
        let failures = self.failures.iter().map(|failure| {
            let id = format!("stability/failures/{}", failure.name);
            Check::of_words(id, &failure.title, failure.outcome, &failure.happened).required()
        });
        rows.chain(failures).collect()
    }

    fn checks_of(&self, row: &Row) -> Vec<Check> {
        let id = format!("stability/{}", row.name);
        let mut checks = Vec::new();
        if let Some(closed) = &row.closed {
            let over = row.undamped.predicted / closed.dt;
            let quantity = format!("{}: predicted limit over the closed form's", row.title);
            let id = format!("{id}/closed-form");
            let check = judged(id, &quantity, over, closed.tolerance);
            checks.push(check.judged_by(&closed.formula, "docs/stability.md: of the pre-stress"));
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
            let mut check = Check::of_words(id, &row.title, Outcome::Skipped, reason);
            // An engine that has the parts for no scene has shown nothing.
            check.required = self.rows.iter().all(|row| row.skipped.is_some());
            checks.push(check);
        }
        checks
    }

    pub fn verdict(&self) -> Outcome {
        verdict(&self.checks())
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
