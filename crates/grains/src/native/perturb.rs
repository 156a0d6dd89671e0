//! Deliberate small faults, so that a comparison can prove that it would notice them. And rounding errors as another engine makes
//! them, for replicas of a run: how far runs part that are the same but for rounding.

use std::fmt;
use std::str::FromStr;

use chacha20::ChaCha8Rng;
use rand_core::SeedableRng;
use serde::{Deserialize, Serialize};

use super::state::{Constants, State};
use crate::constant::{Constant, Given, right_wall};
use crate::generate::{initial_bodies, symmetric};
use crate::model::Model;
use crate::scene::Scene;
use crate::tables::Bodies;

/// One fault in the native engine, as written on the command line: `stiffness=1e-12`, `sums=reversed`, `slow=2`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Perturbation {
    /// This constant is multiplied by 1 + the size.
    Sized(Constant, f64),
    /// Something of the table below is done in another way.
    Switched(Name),
    /// The same steps take so many times as long, 1 to 100: a fault that no result shows, only a clock.
    Slowed(f64),
}

/// Of a fault in the table below.
pub type Name = &'static str;

/// What puts it in.
type Switch = fn(&mut Constants);

/// What can be done in another way. Where nothing slips or turns, another slip velocity or arm is no fault.
const SWITCHES: [(Name, Switch); 7] = [
    // The forces on a grain are summed from the highest partner down.
    ("sums=reversed", |of| of.reversed_sums = true),
    // The right wall is where nothing comes near it.
    ("wall=missing", |of| {
        right_wall(of, |wall| wall.place = f64::INFINITY)
    }),
    // Damping adds energy instead of taking it.
    ("damping=wrong-sign", |of| of.alpha = -of.alpha),
    // The initial velocities are taken for those at the start.
    ("start=half-step", |of| of.half_step_start = true),
    // Half overlap and contact point change places.
    ("torque-arms=other", |of| {
        if of.law.rotates() {
            of.law.contact.torque_arms = of.law.contact.torque_arms.other();
        }
    }),
    // Corrected and contact point velocity change places.
    ("ratcheting=other", |of| {
        if of.law.has_friction() {
            of.law.contact.slip_velocity = of.law.contact.slip_velocity.other();
        }
    }),
    // Clipped and unclipped tension change places.
    ("clipping=other", |of| {
        of.change_law(|law| law.contact.viscosity.clip_otherwise());
    }),
];

fn switch(name: &str) -> Option<(Name, Switch)> {
    SWITCHES.into_iter().find(|of| of.0 == name)
}

const SLOW: &str = "slow";

/// Times as long; a signal is noticed every thousand steps, which must not take minutes.
const SLOWEST: f64 = 100.0;

/// A perturbation that this engine does not know.
#[derive(Debug, thiserror::Error)]
#[error(
    "unknown perturbation {found:?}; write one of {} with a number S, or one of {}, or slow=F with a factor F of 1 to {SLOWEST}",
    Constant::faults().map(|of| format!("{of}=S")).collect::<Vec<_>>().join(", "),
    Perturbation::switches().collect::<Vec<_>>().join(", ")
)]
pub struct PerturbationError {
    found: String,
}

impl Perturbation {
    /// The names of all things that can be done in another way.
    pub fn switches() -> impl Iterator<Item = Name> {
        SWITCHES.into_iter().map(|of| of.0)
    }

    /// Whether a run of this scene is any different with the fault: without gravity, a fault in it is none.
    pub fn changes(self, scene: &Scene) -> bool {
        let bodies = initial_bodies(scene);
        let mut stages = scene.stages();
        stages.any(|stage| self.changes_case(&Model::in_stage(scene, stage), &bodies))
    }

    /// Whether these grains with this model are any different with the fault.
    pub fn changes_case(self, model: &Model, bodies: &Bodies) -> bool {
        let sound = Given::new(model, bodies, None);
        let mut faulty = sound.clone();
        self.apply(&mut faulty);
        faulty != sound
    }

    /// Puts the fault in.
    pub(super) fn apply(self, given: &mut Given) {
        match self {
            Perturbation::Sized(constant, size) => constant.enlarge(given, size),
            Perturbation::Switched(name) => {
                let (_, change) = switch(name).expect("a switch of the list");
                change(&mut given.constants);
            }
            Perturbation::Slowed(_) => {}
        }
    }

    /// How many times as long the steps take, if that is the fault.
    pub(super) fn slowed(self) -> Option<f64> {
        match self {
            Perturbation::Slowed(factor) => Some(factor),
            Perturbation::Sized(..) | Perturbation::Switched(_) => None,
        }
    }

    fn known(text: &str) -> Option<Self> {
        if let Some((name, _)) = switch(text) {
            return Some(Perturbation::Switched(name));
        }
        let (what, size) = text.split_once('=')?;
        let size: f64 = size.parse().ok()?;
        if what == SLOW && (1.0..=SLOWEST).contains(&size) {
            return Some(Perturbation::Slowed(size));
        }
        let mut faults = Constant::faults().filter(|_| size.is_finite());
        let constant = faults.find(|of| of.to_string() == what)?;
        Some(Perturbation::Sized(constant, size))
    }
}

impl FromStr for Perturbation {
    type Err = PerturbationError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Perturbation::known(text).ok_or_else(|| PerturbationError {
            found: text.to_owned(),
        })
    }
}

impl fmt::Display for Perturbation {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Perturbation::Sized(constant, size) => write!(out, "{constant}={size:e}"),
            Perturbation::Switched(name) => out.write_str(name),
            Perturbation::Slowed(factor) => write!(out, "{SLOW}={factor}"),
        }
    }
}

impl TryFrom<String> for Perturbation {
    type Error = PerturbationError;
    fn try_from(text: String) -> Result<Self, Self::Error> {
        text.parse()
    }
}

impl From<Perturbation> for String {
    fn from(perturbation: Perturbation) -> String {
        perturbation.to_string()
    }
}

/// How coarsely an engine computes. At the start and after each step every position and velocity is off by up to so much, and
/// every grain that bears a force is kicked by what its contacts are off. A replica with an odd number makes the same errors in
/// each step: a number that grows by the same amount in each step is rounded the same way, for a while.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Of positions, over the largest coordinate: some engines count from a corner of their own.
    pub position: f64,
    /// Of velocities and spins, over their size.
    pub velocity: f64,
    /// Of the overlaps that forces are made of, m.
    pub overlap: f64,
    /// Which replica.
    pub replica: u64,
    /// The errors of so many steps are made at once, as large as their sum is likely to be.
    pub every: u64,
}

/// The noise under way.
pub(super) struct Shaker {
    noise: Noise,
    random: ChaCha8Rng,
}

const KEY: &[u8; 32] = b"crossgrain: rounding of replicas";

impl Noise {
    pub(super) fn begin(self) -> Shaker {
        let mut random = ChaCha8Rng::from_seed(*KEY);
        random.set_stream(self.replica);
        let noise = self;
        Shaker { noise, random }
    }
}

impl Shaker {
    pub(super) fn every(&self) -> u64 {
        self.noise.every
    }

    /// Before the first step or after one.
    pub(super) fn shake(&mut self, state: &mut State, constants: &Constants) {
        if self.noise.replica % 2 == 1 {
            *self = self.noise.begin();
        }
        let off = self.noise;
        let sum = (off.every as f64).sqrt();
        let coordinates = state.position.iter().flatten();
        let extent = coordinates.fold(0.0, |largest: f64, of| largest.max(of.abs()));
        let (length, share) = (sum * off.position * extent, sum * off.velocity);
        for id in 0..state.mass.len() {
            let id = state.place[id] as usize;
            let (radius, mass) = (state.radius[id], state.mass[id]);
            let kick = if state.force[id] == [0.0; 2] {
                0.0
            } else {
                sum * constants.dt * constants.stiffness(radius, radius) * off.overlap / mass
            };
            for axis in 0..2 {
                let of = &mut self.random;
                state.position[id][axis] += length * symmetric(of);
                state.velocity[id][axis] *= 1.0 + share * symmetric(of);
                let kick = kick * symmetric(of);
                state.velocity[id][axis] += kick;
                // The step has moved it already.
                state.position[id][axis] += constants.dt * kick;
            }
            if !state.inertia.is_empty() {
                // A force that is off by k times the overlap's error turns the grain at most with the arm R.
                let turn = kick * mass * radius / state.inertia[id];
                state.spin[id] *= 1.0 + share * symmetric(&mut self.random);
                state.spin[id] += turn * symmetric(&mut self.random);
            }
        }
    }
}
