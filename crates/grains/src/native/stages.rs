//! The stages of the experiment and the rules that end them.

mod stop_rules;

use std::time::Instant;

use super::dynamics::Dynamics;
use super::fault::Fault;
use super::health::{self, Trouble};
use super::neighbours::Skin;
use super::rounding::{Noise, Shaker};
use super::state::Constants;
use super::threads::Threads;
use super::timing::{Slowness, ThreadTime};
use crate::constant::Given;
use crate::generate::can_turn;
use crate::model::Model;
use crate::scene::Scene;
use crate::tables::{Bodies, Punch, Snapshot, Stage, StopReason};
use crate::task::{Observer, Outcome, Seen, StageReport, Task, Until, asked_to_end};

/// How the native engine goes about it; none of it is physics.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// Skin of the neighbour list, m; the bits do not depend on it. `None`: by how fast the grains move.
    pub skin: Option<f64>,
    pub perturbation: Option<Fault>,
    /// Threads for this one bed; the bits do not depend on them.
    pub threads: Threads,
    /// Rounding errors of another engine, put in at the start and after each step.
    pub noise: Option<Noise>,
}

/// Signs of trouble are looked for every so many steps.
const LOOK_UP_EVERY: u64 = 1000;
/// Signals are looked for at least every so many steps of one grain, a fraction of a second.
const HEEDED: u64 = 1 << 22;

/// The native engine could not finish.
#[derive(Debug, thiserror::Error)]
#[error("native engine stopped in step {step} of stage {}: {trouble}", .stage.name())]
pub struct NativeError {
    pub stage: Stage,
    /// The step in which it was noticed.
    pub step: u64,
    pub trouble: Trouble,
}

impl NativeError {
    pub(super) fn at(stage: Stage, step: u64) -> impl FnOnce(Trouble) -> Self {
        move |trouble| NativeError {
            stage,
            step,
            trouble,
        }
    }
}

/// Runs the task; the observer sees the moments that the scene asks for.
pub fn run(
    scene: &Scene,
    task: &Task,
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<Outcome, NativeError> {
    let start = &task.start;
    let mut given = start.bodies.clone();
    can_turn(scene, &mut given);
    let (mut constants, bodies) = faulty(scene, start.constants(), options, &given);
    // A fault of the very first step.
    constants.half_step_start &= (start.stage, start.step) == (Stage::Settle, 0);
    let punch = start.punch_in(scene);
    let skin = match options.skin {
        Some(skin) => Skin::Fixed(skin),
        None => Skin::Adaptive {
            radius: 0.5 * scene.particles.mean_diameter,
        },
    };
    let dynamics = Dynamics::new(
        &bodies,
        punch,
        &start.memory,
        constants,
        skin,
        options.threads,
    );
    let mut runner = Runner {
        scene,
        options,
        dynamics: dynamics.map_err(NativeError::at(start.stage, start.step))?,
        stage: start.stage,
        step: start.step,
        observer,
        given: &given,
        energy_limit: 0.0,
        seen: start.seen,
        settled: None,
        slowness: options
            .perturbation
            .and_then(Fault::slowed)
            .map(Slowness::new),
        noise: options.noise.map(Noise::begin),
        reports: Vec::new(),
    };
    runner.energy_limit = runner.energy_limit();
    if start.stage == Stage::Load && punch.is_some_and(|punch| punch.velocity == 0.0) {
        runner.seen.standing_since.get_or_insert(start.step);
    }
    runner.run(task)
}

/// The constants of a stage and the grains, with the fault if one is asked for.
fn faulty(scene: &Scene, stage: Stage, options: &Options, bodies: &Bodies) -> (Constants, Bodies) {
    let mut given = Given::new(&Model::in_stage(scene, stage), bodies, None);
    given.constants.box_width = Some(scene.container.width);
    if let Some(perturbation) = options.perturbation {
        perturbation.apply(&mut given);
    }
    (given.constants, given.bodies)
}

struct Runner<'a> {
    scene: &'a Scene,
    options: &'a Options,
    dynamics: Dynamics,
    stage: Stage,
    step: u64,
    observer: &'a mut dyn Observer,
    given: &'a Bodies,
    energy_limit: f64,
    seen: Seen,
    settled: Option<Snapshot>,
    /// Asked for as a fault.
    slowness: Option<Slowness>,
    noise: Option<Shaker>,
    reports: Vec<StageReport>,
}

impl Runner<'_> {
    fn run(mut self, task: &Task) -> Result<Outcome, NativeError> {
        let exactly = match task.until {
            Until::Step(step) => Some(step),
            Until::EndOfSettling | Until::EndOfLoading => None,
        };
        if self.stage == Stage::Settle {
            let stop = self.stage_loop(exactly, Self::settle_rule)?;
            if stop != StopReason::Settled || task.until == Until::EndOfSettling {
                return Ok(self.outcome());
            }
            self.settled = Some(self.snapshot());
            self.stage = Stage::Load;
            self.step = 0;
            self.seen = Seen::default();
        }
        if self.dynamics.state.punch.is_none() {
            self.lower_punch()?;
        }
        self.stage_loop(exactly, Self::load_rule)?;
        Ok(self.outcome())
    }

    fn stage_loop(
        &mut self,
        exactly: Option<u64>,
        mut rule: impl FnMut(&mut Self) -> Option<StopReason>,
    ) -> Result<StopReason, NativeError> {
        let grains = self.dynamics.state.position.len();
        let cpu = ThreadTime::of(self.options.threads.of(grains));
        let wall = Instant::now();
        let every = self.scene.measurement.history_every;
        self.observe()?;
        let mut observed = self.step;
        let stop = loop {
            if exactly.is_some_and(|steps| self.step >= steps) {
                break match asked_to_end() {
                    true => StopReason::Interrupted,
                    false => StopReason::StepsDone,
                };
            }
            if (self.stage, self.step) == (Stage::Load, 0) && self.scene.has_stages() {
                self.change_constants()?;
            }
            if self.step == 0 {
                self.shake();
            }
            let steps = self.unseen(exactly);
            self.dynamics
                .steps(steps)
                .map_err(|(done, trouble)| self.error(self.step + done + 1, trouble))?;
            self.step += steps;
            self.shake();
            if let Some(stop) = rule(self) {
                if exactly.is_none() {
                    break stop;
                }
                self.seen.held = true;
            }
            if self.step.is_multiple_of(every) {
                self.observe()?;
                observed = self.step;
            }
            if self.step.is_multiple_of(LOOK_UP_EVERY) {
                self.look_up()?;
            }
            if asked_to_end() {
                break StopReason::Interrupted;
            }
        };
        self.look_up()?;
        if observed != self.step {
            self.observe()?;
        }
        self.reports.push(StageReport {
            stage: self.stage,
            steps: self.step,
            stop,
            wall_seconds: wall.elapsed().as_secs_f64(),
            cpu_seconds: cpu.elapsed().as_secs_f64(),
        });
        if stop == StopReason::Interrupted {
            let outcome = self.outcome();
            self.observer.interrupted(outcome);
            return Err(self.error(self.step, Trouble::Interrupted));
        }
        Ok(stop)
    }

    /// Puts in the rounding errors of a replica.
    fn shake(&mut self) {
        match &mut self.noise {
            Some(noise) if self.step.is_multiple_of(noise.every()) => self.dynamics.shake(noise),
            _ => {}
        }
    }

    /// Steps up to the next one that somebody looks at.
    fn unseen(&self, exactly: Option<u64>) -> u64 {
        let settle = &self.scene.settle;
        let every = match self.stage {
            Stage::Settle => settle.check_every,
            Stage::Load => 1,
        };
        let shaken = self.noise.as_ref().map_or(u64::MAX, Shaker::every);
        let looked = self.scene.measurement.history_every;
        let all = [every, looked, LOOK_UP_EVERY, shaken];
        let next = all.map(|every| every - self.step % every);
        let next = next.into_iter().fold(u64::MAX, u64::min);
        let end = exactly.unwrap_or(u64::MAX).min(settle.max_steps);
        let heeded = HEEDED / self.dynamics.state.position.len() as u64;
        next.min(heeded).min(end.saturating_sub(self.step)).max(1)
    }

    /// Sets the punch on the highest grain below it, moving down at its constant speed.
    fn lower_punch(&mut self) -> Result<(), NativeError> {
        let state = &self.dynamics.state;
        self.dynamics.state.punch = Some(first_contact_punch(self.scene, &state.bodies()));
        self.dynamics.punch_is_new = true;
        self.dynamics
            .list_neighbours()
            .map_err(|trouble| self.error(self.step, trouble))
    }

    /// Goes on with the constants of loading.
    fn change_constants(&mut self) -> Result<(), NativeError> {
        let (constants, _) = faulty(self.scene, Stage::Load, self.options, self.given);
        let changed = self.dynamics.change(constants);
        changed.map_err(|trouble| self.error(self.step, trouble))?;
        self.energy_limit = self.energy_limit.max(self.energy_limit());
        Ok(())
    }

    /// Ends the run if it has gone wrong.
    fn look_up(&mut self) -> Result<(), NativeError> {
        if let Some(slowness) = &mut self.slowness {
            slowness.stretch();
        }
        let (state, constants) = (&self.dynamics.state, &self.dynamics.constants);
        let found = health::check(state, constants).and_then(|()| {
            let energy = self.dynamics.kinetic_energy();
            health::check_energy(state, energy, self.energy_limit)
        });
        found.map_err(|trouble| self.error(self.step, trouble))
    }

    fn energy_limit(&self) -> f64 {
        let snapshot = self.snapshot();
        let constants = &self.dynamics.constants;
        let radius = |id: u32| snapshot.bodies.radius.get(id as usize).copied();
        // Of the normal springs; the limit is ten times all, which leaves room for the tangential ones.
        let stored = snapshot.contacts.iter().map(|contact| {
            let grain = snapshot.bodies.radius[contact.id2 as usize];
            let stiffness = constants.stiffness(radius(contact.id1).unwrap_or(grain), grain);
            0.5 * stiffness * contact.overlap * contact.overlap
        });
        let stored: f64 = stored.sum();
        let by_punch = self.scene.target_force() * self.scene.loading.give_up_depth;
        let work = self.dynamics.kinetic_energy() + stored + by_punch;
        health::energy_limit(&self.dynamics.state, constants, work)
    }

    fn observe(&mut self) -> Result<(), NativeError> {
        let snapshot = self.snapshot();
        if self.dynamics.constants.box_width.is_some() {
            health::check_moment(&snapshot, &self.scene.container)
                .map_err(|trouble| self.error(self.step, trouble))?;
        }
        self.observer.snapshot(&snapshot);
        Ok(())
    }

    /// With the sizes that were given, whatever fault the step computes with.
    fn snapshot(&self) -> Snapshot {
        let mut snapshot = self.dynamics.snapshot(self.stage, self.step);
        let bodies = &mut snapshot.bodies;
        bodies.radius.clone_from(&self.given.radius);
        bodies.mass.clone_from(&self.given.mass);
        bodies.inertia.clone_from(&self.given.inertia);
        snapshot
    }

    fn outcome(&self) -> Outcome {
        Outcome {
            stages: self.reports.clone(),
            settled: self.settled.clone(),
            last: self.snapshot(),
            seen: self.seen,
        }
    }

    fn error(&self, step: u64, trouble: Trouble) -> NativeError {
        NativeError::at(self.stage, step)(trouble)
    }
}

/// The punch at the start of loading: in the middle of the box, its bottom at the top of the highest grain below it.
pub fn first_contact_punch(scene: &Scene, bodies: &Bodies) -> Punch {
    let axis = scene.punch_axis();
    let half_extents = [scene.loading.half_width, 0.5 * scene.loading.punch_height];
    let mut top = 0.0f64;
    for ((x, z), radius) in bodies.x.iter().zip(&bodies.z).zip(&bodies.radius) {
        if (x - axis).abs() < half_extents[0] + radius {
            top = top.max(z + radius);
        }
    }
    Punch {
        centre: [axis, top + half_extents[1]],
        half_extents,
        start: top,
        velocity: -scene.loading.speed,
        force: 0.0,
    }
}
