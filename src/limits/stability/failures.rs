//! Where the method fails: what happens, how the program notices, what it says. Every run is bounded by the
//! scene's own rules, so none hangs.

mod ways;

use serde::{Deserialize, Serialize};

use crate::compare::Verdict;
use crate::engine::yade::{self, YadeError};
use crate::error::Error;
use crate::files::work_folder;
use crate::interrupt::asked_to_end;
use crate::run::EngineError;
use grains::generate::initial_bodies;
use grains::native::{self, NativeError, Options, Trouble};
use grains::scene::{Cloud, Scene, paper_scene, parse_scene};
use grains::tables::StopReason;
use grains::task::{Outcome, Task};

/// Grains of the scenes.
const GRAINS: u32 = 60;

/// One way to fail.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// A short name, in kebab-case.
    pub name: String,
    /// What is done.
    pub title: String,
    /// What happens in the native engine.
    pub happened: String,
    /// Which part of the program notices.
    pub noticed: String,
    /// What it says.
    pub says: String,
    /// What YADE's run comes to, where that was asked.
    pub yade: Option<String>,
    /// Whether the program noticed it in the way that it should.
    pub verdict: Verdict,
}

/// What a run came to.
enum Came {
    /// To an end by a rule.
    Ended(Box<Outcome>),
    /// To trouble.
    Troubled(NativeError),
}

impl Came {
    fn stop(&self) -> Option<StopReason> {
        match self {
            Came::Ended(outcome) => outcome.stages.last().map(|stage| stage.stop),
            Came::Troubled(_) => None,
        }
    }

    fn trouble(&self) -> Option<&Trouble> {
        match self {
            Came::Ended(_) => None,
            Came::Troubled(error) => Some(&error.trouble),
        }
    }

    /// What the command line prints.
    fn says(&self) -> String {
        match self {
            Came::Ended(outcome) => {
                let stages = outcome.stages.iter().map(|stage| {
                    let stop = serde_json::to_value(stage.stop).unwrap_or_default();
                    let stop = stop.as_str().unwrap_or_default().replace('_', " ");
                    format!("{} {} steps ({stop})", stage.stage.name(), stage.steps)
                });
                stages.collect::<Vec<_>>().join(", ")
            }
            Came::Troubled(error) => error.to_string(),
        }
    }

    /// Whether every number of a result is finite; trouble has none.
    fn is_finite(&self) -> bool {
        match self {
            Came::Ended(outcome) => {
                let columns = outcome.last.bodies.motion();
                columns
                    .iter()
                    .all(|(_, column)| column.iter().all(|value| value.is_finite()))
            }
            Came::Troubled(_) => true,
        }
    }
}

/// An experiment that fails: a scene, and what should come of it.
struct Mode {
    name: &'static str,
    title: &'static str,
    scene: Scene,
    in_yade: bool,
    /// Whether it was noticed; what happens; who notices.
    judge: fn(&Came, &Scene) -> (bool, String, &'static str),
}

/// A shallow bed of the paper's grains in a narrow box.
pub fn small_bed() -> Scene {
    let mut scene = paper_scene(1, GRAINS);
    scene.container.width = 0.1;
    let Cloud::JitteredLattice { columns, .. } = &mut scene.cloud;
    *columns = 8;
    scene.control_points.truncate(1);
    scene.loading.give_up_depth = 0.03;
    scene.loading.speed = 0.5;
    scene.settle.max_steps = 30_000;
    scene.measurement.history_every = 50;
    scene
}

/// All ways to fail, each tried; in YADE too where that is cheap, if it may be used.
pub fn failures(
    in_yade: Option<&yade::Options>,
    progress: &mut dyn FnMut(f64, &str),
) -> Result<Vec<Failure>, Error> {
    let modes = ways::all();
    let mut all = Vec::with_capacity(modes.len() + 1);
    for (at, mode) in modes.iter().enumerate() {
        progress(at as f64 / modes.len() as f64, mode.name);
        all.push(tried(mode, in_yade)?);
        if asked_to_end() {
            return Err(Error::Interrupted);
        }
    }
    all.insert(4, refused_punch());
    Ok(all)
}

fn tried(mode: &Mode, in_yade: Option<&yade::Options>) -> Result<Failure, Error> {
    let came = run(&mode.scene)?;
    let (noticed, happened, who) = (mode.judge)(&came, &mode.scene);
    let yade = match in_yade.filter(|_| mode.in_yade) {
        Some(options) => Some(of_yade(&mode.scene, options)?),
        None => None,
    };
    Ok(Failure {
        name: mode.name.to_owned(),
        title: mode.title.to_owned(),
        happened,
        noticed: who.to_owned(),
        says: came.says(),
        yade,
        verdict: if noticed && came.is_finite() {
            Verdict::Pass
        } else {
            Verdict::Fail
        },
    })
}

fn run(scene: &Scene) -> Result<Came, Error> {
    let task = Task::whole(initial_bodies(scene));
    match native::run(scene, &task, &Options::default(), &mut ()) {
        Ok(outcome) => Ok(Came::Ended(Box::new(outcome))),
        Err(error) if error.trouble == Trouble::Interrupted => Err(Error::Interrupted),
        Err(error) => Ok(Came::Troubled(error)),
    }
}

/// What comes of the scene in YADE, in words.
fn of_yade(scene: &Scene, options: &yade::Options) -> Result<String, Error> {
    let work = work_folder()?;
    let task = Task::whole(initial_bodies(scene));
    match yade::run(scene, &task, options, work.path(), &mut ()) {
        Ok(run) => Ok(Came::Ended(Box::new(run.outcome)).says()),
        Err(error @ (YadeError::Nonsense(_) | YadeError::WentWrong { .. })) => {
            Ok(error.to_string())
        }
        Err(error @ (YadeError::Crashed { .. } | YadeError::Hung { .. })) => Ok(error.to_string()),
        Err(error) => Err(Error::Engine(EngineError::Yade(error))),
    }
}

/// A punch that would jump over what it should touch never starts.
fn refused_punch() -> Failure {
    let mut scene = small_bed();
    scene.loading.speed = 0.2 * 0.005 / ways::base_step();
    let text = serde_json::to_string(&scene).unwrap_or_default();
    let says = match parse_scene(&text) {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    };
    Failure {
        name: "punch-too-fast".to_owned(),
        title: "a punch that moves a fifth of a radius a step".to_owned(),
        happened: "nothing: the scene is refused".to_owned(),
        noticed: "the check of the scene; exit code 2".to_owned(),
        verdict: if says.contains("/loading/speed") {
            Verdict::Pass
        } else {
            Verdict::Fail
        },
        says,
        yade: None,
    }
}
