//! What an engine that is timed tells, whichever it is; and the native step with a clock between its parts, for finding out
//! where its time goes.

use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};
use serde::{Deserialize, Serialize};

use super::dynamics::{Clock, Dynamics};
use super::health::Trouble;
use super::neighbours::Skin;
use super::state::Constants;
use super::threads::Threads;
use crate::model::Model;
use crate::tables::{Bodies, Memories, Stage};

/// A moment on the clock of this thread's processor time, or of all of the process.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThreadTime(ClockId, Duration);

impl ThreadTime {
    /// Now.
    pub fn now() -> Self {
        ThreadTime::on(ClockId::ThreadCPUTime)
    }

    /// Now, for a bed on so many threads: where there are several, of the process, which then computes this bed alone.
    pub fn of(threads: usize) -> Self {
        match threads {
            1 => ThreadTime::now(),
            _ => ThreadTime::on(ClockId::ProcessCPUTime),
        }
    }

    fn on(clock: ClockId) -> Self {
        let now = clock_gettime(clock);
        ThreadTime(clock, Duration::new(now.tv_sec as u64, now.tv_nsec as u32))
    }

    /// Processor time that was used between an earlier moment and this one.
    pub fn duration_since(&self, earlier: ThreadTime) -> Duration {
        self.1.saturating_sub(earlier.1)
    }

    /// Processor time that has been used since.
    pub fn elapsed(&self) -> Duration {
        ThreadTime::on(self.0).duration_since(*self)
    }
}

/// Steps that were timed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Window {
    pub steps: u64,
    /// Time on the clock, s.
    pub wall_seconds: f64,
    /// Processor time, s; none where the engine tells the clock's only.
    pub cpu_seconds: Option<f64>,
}

impl Window {
    /// Seconds a step: of processor time, which other programs on the machine change least, else on the clock.
    pub fn seconds_per_step(&self) -> f64 {
        self.cpu_seconds.unwrap_or(self.wall_seconds) / self.steps as f64
    }

    /// Processor time over time on the clock; well below 1 where the machine had something else to do.
    pub fn processor_share(&self) -> Option<f64> {
        self.cpu_seconds.map(|cpu| cpu / self.wall_seconds)
    }
}

/// The part of a step's time that a stage of it takes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Share {
    pub stage: String,
    /// Between 0 and 1.
    pub share: f64,
}

/// Where the time of a step goes, and what it was spent on.
#[derive(Debug, Clone, PartialEq)]
pub struct Clocked {
    /// Of the time of all steps, in the order of the step; they add to 1.
    pub shares: Vec<Share>,
    /// Listed pairs of grains at the end.
    pub listed_pairs: usize,
    /// Those of them that touch.
    pub touching_pairs: usize,
    /// How often the neighbour list was built in these steps.
    pub builds: u64,
    /// The grains afterwards; the same bits as by an ordinary run.
    pub bodies: Bodies,
}

/// Times the parts of so many steps of a frictionless bed of grains of about this radius, m.
pub fn parts_of_a_step(
    model: &Model,
    bodies: &Bodies,
    radius: f64,
    steps: u64,
) -> Result<Clocked, Trouble> {
    let constants = Constants::new(model, bodies.len() as u32);
    let skin = Skin::Adaptive { radius };
    let mut dynamics = Dynamics::new(
        bodies,
        None,
        &Memories::default(),
        constants,
        skin,
        Threads::default(),
    )?;
    let builds = dynamics.neighbours.builds;
    let mut clock = Clock(Some(Default::default()));
    for _ in 0..steps {
        dynamics.step_timed(&mut clock)?;
    }
    let spent = clock.0.expect("a clock that runs");
    let total: Duration = spent.iter().sum();
    let share = |(stage, time): (&str, Duration)| Share {
        stage: stage.to_owned(),
        share: time.as_secs_f64() / total.as_secs_f64(),
    };
    let contacts = dynamics.snapshot(Stage::Settle, steps).contacts;
    let grains = bodies.len() as u32;
    Ok(Clocked {
        shares: PARTS.into_iter().zip(spent).map(share).collect(),
        listed_pairs: dynamics.neighbours.len(),
        touching_pairs: contacts
            .iter()
            .filter(|contact| contact.id1 < grains)
            .count(),
        builds: dynamics.neighbours.builds - builds,
        bodies: dynamics.state.bodies(),
    })
}

/// In the order of the step.
const PARTS: [&str; 4] = [
    "integration",
    "neighbour lists",
    "contacts between grains and at walls",
    "punch",
];

/// A deliberate slowness: the same steps, to the bit, in a multiple of their time. A job proves with it that it would notice a
/// slower kernel. Where it is not asked for it costs nothing.
#[derive(Debug)]
pub struct Slowness {
    factor: f64,
    since: Instant,
}

impl Slowness {
    /// From now on everything takes `factor` times as long; below 1 is 1.
    pub fn new(factor: f64) -> Self {
        Slowness {
            factor,
            since: Instant::now(),
        }
    }

    /// Works on nothing for as long as is missing, so that wall time and processor time both grow.
    pub fn stretch(&mut self) {
        let wanted = self.since.elapsed().mul_f64(self.factor.max(1.0));
        while self.since.elapsed() < wanted {
            std::hint::spin_loop();
        }
        self.since = Instant::now();
    }
}
