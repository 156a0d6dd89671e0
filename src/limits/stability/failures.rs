//! Where the method fails: what happens, how the program notices, what it says. Every run is bounded by the
//! scene's own rules, so none hangs.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{Result, time_step};
use crate::checks::Outcome;
use crate::engine::{Engine, EngineError, ProgramError};
use crate::run::folder::stages_in_words;
use crate::study::realization::bed_of;
use crate::workers::asked_to_end;
use grains::generate::initial_bodies;
use grains::measure;
use grains::native::{self, NativeError, Options, Trouble};
use grains::scene::{Cloud, Damping, Scene, TimeStep, paper_scene};
use grains::tables::{Stage, StopReason};
use grains::task::{self, Task};

const GRAINS: u32 = 60;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Failure {
    pub name: String,
    pub title: String,
    pub happened: String,
    pub noticed: String,
    pub says: String,
    /// What YADE's run comes to, where that was asked.
    pub yade: Option<String>,
    /// Whether the program noticed it in the way that it should.
    pub outcome: Outcome,
}

/// A failure mode: a change of a small bed, and what should come of it.
pub struct Mode {
    pub name: &'static str,
    title: &'static str,
    change: fn(&mut Scene),
    /// Tried in YADE too, where that is cheap.
    pub in_yade: bool,
    /// Whether it was noticed, and what happens.
    judge: fn(&Run, &Scene) -> (bool, String),
    notices: &'static str,
}

/// In the order of the page.
pub const MODES: [Mode; 10] = [
    Mode {
        name: "step-beyond-limit",
        title: "twice the largest stable step",
        change: |scene| {
            scene.time_step = TimeStep::Fraction {
                of_sqrt_m_over_k: 1.7,
            };
        },
        in_yade: true,
        judge: |run, _| {
            use Trouble::{BeyondRadius, EnergyBlownUp, Lost};
            let seen = matches!(
                run.trouble(),
                Some(EnergyBlownUp { .. } | Lost { .. } | BeyondRadius { .. })
            );
            let happens = "energy grows out of nothing until grains fly apart";
            (seen, happens.to_owned())
        },
        notices: "the limit on the kinetic energy, looked at every 1000 steps, or the box",
    },
    Mode {
        name: "step-just-beyond-limit",
        title: "a tenth more than the largest stable step",
        change: |scene| {
            // Without a limit the scene is refused, and the mode does not happen.
            let limit = time_step::choose(scene, 1.0).map_or(f64::NAN, |choice| choice.limit);
            scene.time_step = TimeStep::Absolute {
                seconds: 1.1 * limit,
            };
        },
        in_yade: false,
        judge: |run, scene| {
            let share = run.ended().and_then(|outcome| {
                let bed = outcome.settled.as_ref().unwrap_or(&outcome.last);
                time_step::share_of_limit(scene, &bed.bodies).ok()?
            });
            let happens = format!(
                "the bed settles all the same: what grows opens its own contacts and stops there; unbalanced force \
                 {:.2} of the mean contact force at the end",
                run.unbalanced(scene)
            );
            (share.is_some_and(|share| share > 1.0), happens)
        },
        notices: "the limit of the settled bed, which `crossgrain run` works out at the end of every run",
    },
    Mode {
        name: "overlap-beyond-radius",
        title: "grains far too soft for their sizes (E = 10 MPa, radii from 0.2 to 1.8 of the mean)",
        change: |scene| {
            scene.material.youngs_modulus = 1.0e7;
            scene.particles.dispersion = 0.8;
            *lattice(scene).0 = 5;
            scene.time_step = TimeStep::Absolute { seconds: 2.0e-5 };
        },
        in_yade: true,
        judge: |run, _| {
            let deep = match run.trouble() {
                Some(Trouble::BeyondRadius {
                    overlap, radius, ..
                }) => overlap / radius,
                _ => f64::NAN,
            };
            let happens =
                format!("large grains swallow small ones: {deep:.2} radii when it is seen");
            (deep > 1.0, happens)
        },
        notices: "every moment of the history",
    },
    Mode {
        name: "tunnelling",
        title: "grains that move five radii a step",
        change: |scene| *lattice(scene).1 = 5.0 * 0.005 / scene.time_step_seconds(),
        in_yade: true,
        judge: |run, _| {
            let happens =
                "a grain is on one side of a wall before a step and on the other after it";
            let lost = matches!(run.trouble(), Some(Trouble::Lost { .. }));
            (lost, happens.to_owned())
        },
        notices: "the box, at every rebuild of the neighbour list and every moment of the history",
    },
    Mode {
        name: "punch-too-fast",
        title: "a punch that moves a fifth of a radius a step",
        change: |scene| scene.loading.speed = 0.2 * 0.005 / scene.time_step_seconds(),
        in_yade: false,
        judge: |run, _| match run {
            Run::Refused(why) => (
                why.contains("/loading/speed"),
                "nothing: the scene is refused".to_owned(),
            ),
            _ => (false, "the scene is accepted and run".to_owned()),
        },
        notices: "the check of the scene; exit code 2",
    },
    Mode {
        name: "fast-punch",
        title: "a punch at 1 m/s, ten times the paper's scene's",
        change: |scene| scene.loading.speed = 1.0,
        in_yade: false,
        judge: |run, scene| {
            let unbalanced = run.unbalanced(scene);
            let happens = format!(
                "the load is reached by the inertia of the grains: unbalanced force {unbalanced:.2} of the mean \
                 contact force"
            );
            let seen = run.stop() == Some(StopReason::Reached) && unbalanced > 0.1;
            (seen, happens)
        },
        notices: "the measure of the unbalanced force in run.json",
    },
    Mode {
        name: "stiffness-contrast",
        title: "radii from 0.05 to 1.95 of the mean, a step for the mean grain",
        // One modulus rules all bodies, so stiffness differs with the radius only.
        change: |scene| {
            scene.particles.dispersion = 0.95;
            *lattice(scene).0 = 5;
        },
        in_yade: false,
        judge: |run, scene| {
            let choice = time_step::choose(scene, time_step::DEFAULT_SHARE).ok();
            let cured = choice.as_ref().is_some_and(|choice| {
                let again = run_scene(&time_step::with_step(scene, choice));
                again.is_ok_and(|run| run.ended().is_some() && run.is_finite())
            });
            let step = choice.map_or(f64::NAN, |choice| choice.time_step);
            let share = step / scene.time_step_seconds();
            let happens = format!(
                "the smallest grains are too fast for the step; the automatic step, {share:.3} of it, runs to the end"
            );
            (run.trouble().is_some() && cured, happens)
        },
        notices: "the limit on the kinetic energy, or the box",
    },
    Mode {
        name: "zero-damping",
        title: "no damping of any kind",
        change: |scene| scene.damping = Damping::Cundall { alpha: 0.0 },
        in_yade: false,
        judge: |run, _| {
            let happens = "nothing takes energy out: the grains stay a gas";
            (run.stop() == Some(StopReason::MaxSteps), happens.to_owned())
        },
        notices: "the scene's largest number of steps; exit code 3",
    },
    Mode {
        name: "never-at-rest",
        title: "a frictionless bed, nearly isostatic, asked for 10⁻³⁰ of its energy",
        change: |scene| {
            scene.settle.kinetic_energy_fraction = 1.0e-30;
            scene.settle.max_steps = 60_000;
        },
        in_yade: false,
        judge: |run, scene| {
            let left = run.unbalanced(scene);
            let happens =
                format!("it creeps on: unbalanced force {left:.1e} of the mean contact force");
            (run.stop() == Some(StopReason::MaxSteps), happens)
        },
        notices: "the scene's largest number of steps; exit code 3",
    },
    Mode {
        name: "load-too-large",
        title: "a pressure of 1 GPa on a shallow bed",
        change: |scene| scene.loading.pressure = 1.0e9,
        in_yade: true,
        judge: |run, _| {
            let happens = "the grains give way and the punch goes on down";
            let seen = run.stop() == Some(StopReason::TargetLoadNotReached);
            (seen, happens.to_owned())
        },
        notices: "the scene's give-up depth",
    },
];

/// A shallow bed of the paper's grains in a narrow box.
pub fn small_bed() -> Scene {
    let mut scene = paper_scene(1, GRAINS);
    scene.container.width = 0.1;
    *lattice(&mut scene).0 = 8;
    scene.control_points.truncate(1);
    scene.loading.give_up_depth = 0.03;
    scene.loading.speed = 0.5;
    scene.settle.max_steps = 30_000;
    scene.measurement.history_every = 50;
    scene
}

/// Columns of the cloud, and its grains' speed, m/s.
fn lattice(scene: &mut Scene) -> (&mut u32, &mut f64) {
    let Cloud::JitteredLattice { columns, speed, .. } = &mut scene.cloud;
    (columns, speed)
}

enum Run {
    /// An end by a rule.
    Ended(Box<task::Outcome>),
    Troubled(NativeError),
    /// The check of the scene did not let it start.
    Refused(String),
}

impl Run {
    fn ended(&self) -> Option<&task::Outcome> {
        match self {
            Run::Ended(outcome) => Some(outcome),
            _ => None,
        }
    }

    fn trouble(&self) -> Option<&Trouble> {
        match self {
            Run::Troubled(error) => Some(&error.trouble),
            _ => None,
        }
    }

    fn stop(&self) -> Option<StopReason> {
        self.ended()?.stages.last().map(|stage| stage.stop)
    }

    /// Mean unbalanced force at the end over the mean contact force.
    fn unbalanced(&self, scene: &Scene) -> f64 {
        let bed = self.ended().map(|outcome| bed_of(&outcome.last));
        bed.and_then(|bed| measure::unbalanced_force(scene.gravity, bed))
            .unwrap_or(f64::NAN)
    }

    /// What the command line prints.
    fn says(&self) -> String {
        match self {
            Run::Ended(outcome) => stages_in_words(&outcome.stages),
            Run::Troubled(error) => error.to_string(),
            Run::Refused(why) => why.clone(),
        }
    }

    /// Whether every number of a result is finite; trouble has none.
    fn is_finite(&self) -> bool {
        self.ended().is_none_or(|outcome| {
            let columns = outcome.last.bodies.motion();
            let mut columns = columns.iter();
            columns.all(|(_, column)| column.iter().all(|value| value.is_finite()))
        })
    }
}

impl Mode {
    pub fn of(name: &str) -> Option<&'static Self> {
        MODES.iter().find(|mode| mode.name == name)
    }

    fn scene(&self) -> Scene {
        let mut scene = small_bed();
        (self.change)(&mut scene);
        scene
    }

    pub fn in_native(&self) -> Result<Failure> {
        let scene = self.scene();
        let run = run_scene(&scene)?;
        let (noticed, happened) = (self.judge)(&run, &scene);
        if asked_to_end() {
            return Err(NativeError {
                stage: Stage::Settle,
                step: 0,
                trouble: Trouble::Interrupted,
            });
        }
        Ok(Failure {
            name: self.name.to_owned(),
            title: self.title.to_owned(),
            happened,
            noticed: self.notices.to_owned(),
            says: run.says(),
            yade: None,
            outcome: Outcome::pass_if(noticed && run.is_finite()),
        })
    }

    /// What comes of it in another engine, in words; `work` is an empty folder.
    pub fn in_engine(&self, engine: &dyn Engine, work: &Path) -> Result<String, EngineError> {
        use ProgramError::{Crashed, Hung, Nonsense, WentWrong};
        let scene = self.scene();
        let task = Task::whole(initial_bodies(&scene));
        match engine.run(&scene, &task, work, &mut ()) {
            Ok(run) => Ok(stages_in_words(&run.outcome.stages)),
            Err(EngineError::Program(
                error @ (Nonsense(_) | WentWrong { .. } | Crashed { .. } | Hung { .. }),
            )) => Ok(error.to_string()),
            Err(error) => Err(error),
        }
    }
}

/// Checked as a scene's file is, and run in the native engine.
fn run_scene(scene: &Scene) -> Result<Run> {
    if let Err(error) = scene.check() {
        return Ok(Run::Refused(error.to_string()));
    }
    let task = Task::whole(initial_bodies(scene));
    match native::run(scene, &task, &Options::default(), &mut ()) {
        Ok(outcome) => Ok(Run::Ended(Box::new(outcome))),
        Err(error) if error.trouble == Trouble::Interrupted => Err(error),
        Err(error) => Ok(Run::Troubled(error)),
    }
}
