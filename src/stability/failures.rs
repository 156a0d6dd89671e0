//! Where the method fails: what happens, how the program notices, what it says. Every run is bounded by the
//! scene's own rules, so none hangs.

use serde::Serialize;

use super::automatic;
use crate::compare::Verdict;
use crate::engine::native::{self, NativeError, Options, Trouble};
use crate::engine::yade::{self, YadeError};
use crate::engine::{Outcome, Task};
use crate::error::Error;
use crate::files::work_folder;
use crate::generate::initial_bodies;
use crate::interrupt::asked_to_end;
use crate::measure::unbalanced_force;
use crate::run::EngineError;
use crate::scene::{Cloud, Damping, Scene, TimeStep, paper_scene, parse_scene};
use crate::tables::StopReason;

/// Grains of the scenes.
const GRAINS: u32 = 60;

/// One way to fail.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
    let modes = modes();
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

fn modes() -> Vec<Mode> {
    let base = small_bed();
    let changed = |change: &dyn Fn(&mut Scene)| {
        let mut scene = base.clone();
        change(&mut scene);
        scene
    };
    vec![
        Mode {
            name: "step-beyond-limit",
            title: "twice the largest stable step",
            scene: changed(&|scene| {
                scene.time_step = TimeStep::Fraction {
                    of_sqrt_m_over_k: 1.7,
                };
            }),
            in_yade: true,
            judge: |came, _| {
                (
                    matches!(
                        came.trouble(),
                        Some(
                            Trouble::EnergyBlownUp { .. }
                                | Trouble::Lost { .. }
                                | Trouble::BeyondRadius { .. }
                        )
                    ),
                    "energy grows out of nothing until grains fly apart".to_owned(),
                    "the limit on the kinetic energy, looked at every 1000 steps, or the box",
                )
            },
        },
        Mode {
            name: "step-just-beyond-limit",
            title: "a tenth more than the largest stable step",
            scene: changed(&|scene| {
                let bed = automatic::choose(scene, 1.0);
                let limit = bed.map_or(f64::NAN, |choice| choice.limit);
                scene.time_step = TimeStep::Absolute {
                    seconds: 1.1 * limit,
                };
            }),
            in_yade: false,
            judge: |came, scene| {
                let share = match came {
                    Came::Ended(outcome) => {
                        let bed = outcome.settled.as_ref().unwrap_or(&outcome.last);
                        automatic::share_of_limit(scene, &bed.bodies)
                    }
                    Came::Troubled(_) => Ok(None),
                };
                let share = share.ok().flatten().unwrap_or(f64::NAN);
                (
                    share > 1.0,
                    format!(
                        "the bed settles all the same: what grows opens its own contacts and stops there; unbalanced force \
                         {:.2} of the mean contact force at the end",
                        unbalanced_at_end(came, scene)
                    ),
                    "the limit of the settled bed, which `crossgrain run` works out at the end of every run",
                )
            },
        },
        Mode {
            name: "overlap-beyond-radius",
            title: "grains far too soft for their sizes (E = 10 MPa, radii from 0.2 to 1.8 of the mean)",
            scene: changed(&|scene| {
                scene.material.youngs_modulus = 1.0e7;
                scene.particles.dispersion = 0.8;
                let Cloud::JitteredLattice { columns, .. } = &mut scene.cloud;
                *columns = 5;
                scene.time_step = TimeStep::Absolute { seconds: 2.0e-5 };
            }),
            in_yade: true,
            judge: |came, _| {
                let deep = match came.trouble() {
                    Some(Trouble::BeyondRadius {
                        overlap, radius, ..
                    }) => overlap / radius,
                    _ => f64::NAN,
                };
                (
                    deep > 1.0,
                    format!("large grains swallow small ones: {deep:.2} radii when it is seen"),
                    "every moment of the history",
                )
            },
        },
        Mode {
            name: "tunnelling",
            title: "grains that move five radii a step",
            scene: changed(&|scene| {
                let Cloud::JitteredLattice { speed, .. } = &mut scene.cloud;
                *speed = 5.0 * 0.005 / base_step();
            }),
            in_yade: true,
            judge: |came, _| {
                (
                    matches!(came.trouble(), Some(Trouble::Lost { .. })),
                    "a grain is on one side of a wall before a step and on the other after it"
                        .to_owned(),
                    "the box, at every rebuild of the neighbour list and every moment of the history",
                )
            },
        },
        Mode {
            name: "fast-punch",
            title: "a punch at 1 m/s, ten times the paper's scene's",
            scene: changed(&|scene| scene.loading.speed = 1.0),
            in_yade: false,
            judge: |came, scene| {
                let unbalanced = unbalanced_at_end(came, scene);
                (
                    came.stop() == Some(StopReason::Reached) && unbalanced > 0.1,
                    format!(
                        "the load is reached by the inertia of the grains: unbalanced force {unbalanced:.2} of the mean \
                         contact force"
                    ),
                    "the measure of the unbalanced force in run.json",
                )
            },
        },
        Mode {
            name: "stiffness-contrast",
            title: "radii from 0.05 to 1.95 of the mean, a step for the mean grain",
            scene: contrast(),
            in_yade: false,
            judge: |came, scene| {
                let chosen = automatic::choose(scene, automatic::DEFAULT_SHARE);
                let cured = chosen.map(|choice| {
                    let better = automatic::with_step(scene, &choice);
                    let again = run(&better);
                    let ended = matches!(&again, Ok(came @ Came::Ended(_)) if came.is_finite());
                    (ended, choice.time_step / scene.time_step_seconds())
                });
                let (ended, share) = cured.unwrap_or((false, f64::NAN));
                (
                    came.trouble().is_some() && ended,
                    format!(
                        "the smallest grains are too fast for the step; the automatic step, {share:.3} of it, runs to the end"
                    ),
                    "the limit on the kinetic energy, or the box",
                )
            },
        },
        Mode {
            name: "zero-damping",
            title: "no damping of any kind",
            scene: changed(&|scene| scene.damping = Damping::Cundall { alpha: 0.0 }),
            in_yade: false,
            judge: |came, _| {
                (
                    came.stop() == Some(StopReason::MaxSteps),
                    "nothing takes energy out: the grains stay a gas".to_owned(),
                    "the scene's largest number of steps; exit code 3",
                )
            },
        },
        Mode {
            name: "never-at-rest",
            title: "a frictionless bed, nearly isostatic, asked for 10⁻³⁰ of its energy",
            scene: changed(&|scene| {
                scene.settle.kinetic_energy_fraction = 1.0e-30;
                scene.settle.max_steps = 60_000;
            }),
            in_yade: false,
            judge: |came, scene| {
                (
                    came.stop() == Some(StopReason::MaxSteps),
                    format!(
                        "it creeps on: unbalanced force {:.1e} of the mean contact force",
                        unbalanced_at_end(came, scene)
                    ),
                    "the scene's largest number of steps; exit code 3",
                )
            },
        },
        Mode {
            name: "load-too-large",
            title: "a pressure of 1 GPa on a shallow bed",
            scene: changed(&|scene| scene.loading.pressure = 1.0e9),
            in_yade: true,
            judge: |came, _| {
                (
                    came.stop() == Some(StopReason::SankToGiveUpDepth),
                    "the grains give way and the punch goes on down".to_owned(),
                    "the scene's give-up depth",
                )
            },
        },
    ]
}

/// The step of the paper's grains, s.
fn base_step() -> f64 {
    paper_scene(1, GRAINS).time_step_seconds()
}

/// A wide range of sizes. One modulus rules all bodies, so stiffness differs with the radius only.
fn contrast() -> Scene {
    let mut scene = small_bed();
    scene.particles.dispersion = 0.95;
    let Cloud::JitteredLattice { columns, .. } = &mut scene.cloud;
    *columns = 5;
    scene
}

fn unbalanced_at_end(came: &Came, scene: &Scene) -> f64 {
    let Came::Ended(outcome) = came else {
        return f64::NAN;
    };
    let bed = crate::measure::Bed {
        bodies: &outcome.last.bodies,
        contacts: &outcome.last.contacts,
    };
    unbalanced_force::of(scene, bed).unwrap_or(f64::NAN)
}

/// A punch that would jump over what it should touch never starts.
fn refused_punch() -> Failure {
    let mut scene = small_bed();
    scene.loading.speed = 0.2 * 0.005 / base_step();
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
