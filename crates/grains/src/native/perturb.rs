//! Deliberate small faults, so that a comparison can prove that it would notice them. And rounding errors as another engine makes
//! them, for replicas of a run: how far runs part that are the same but for rounding.

use std::fmt;
use std::str::FromStr;

use chacha20::ChaCha8Rng;
use rand_core::SeedableRng;
use serde::{Deserialize, Serialize};

use super::contact::Axis;
use super::state::{Constants, State};
use crate::generate::{initial_bodies, symmetric};
use crate::model::{Law, Model};
use crate::scene::{Scene, SlipVelocity, Tension, TorqueArms, Viscosity};
use crate::tables::Bodies;

/// One fault in the native engine, as written on the command line: `stiffness=1e-12`, `sums=reversed`, `slow=2`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Perturbation {
    /// A quantity is multiplied by 1 + the size.
    Sized(Quantity, f64),
    /// Something is done in another way.
    Switched(Switch),
    /// The same steps take so many times as long, 1 to 100: a fault that no result shows, only a clock.
    Slowed(f64),
}

/// What can be a little wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Every k_n.
    Stiffness,
    /// Every k_s.
    ShearStiffness,
    /// Young's modulus, so k_n and k_s.
    Modulus,
    /// Gravity.
    Gravity,
    /// Density: every mass and moment of inertia.
    Density,
    /// The damping number.
    Damping,
    /// The friction angle.
    Friction,
    /// The damping constant of the dashpots, or the restitution.
    Dashpot,
    /// The radius of grain 0, at its contacts only.
    Radius,
    /// The time step.
    TimeStep,
    /// The moment of inertia of grain 0.
    Inertia,
    /// The right wall is moved by this share of its place; without one, the last wall.
    Wall,
}

/// What can be done in another way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Switch {
    /// The forces on a grain are summed from the highest partner down.
    Sums,
    /// The right wall is not there; without one, the last wall.
    Wall,
    /// Damping adds energy instead of taking it.
    DampingSign,
    /// The initial velocities are taken for those at the start.
    Start,
    /// Half overlap and contact point change places.
    TorqueArms,
    /// Corrected and contact point velocity change places.
    Ratcheting,
    /// Clipped and unclipped tension change places.
    Clipping,
}

const QUANTITIES: &[(&str, Quantity)] = &[
    ("stiffness", Quantity::Stiffness),
    ("shear-stiffness", Quantity::ShearStiffness),
    ("modulus", Quantity::Modulus),
    ("gravity", Quantity::Gravity),
    ("density", Quantity::Density),
    ("damping", Quantity::Damping),
    ("friction", Quantity::Friction),
    ("dashpot", Quantity::Dashpot),
    ("radius", Quantity::Radius),
    ("time-step", Quantity::TimeStep),
    ("inertia", Quantity::Inertia),
    ("wall", Quantity::Wall),
];

const SWITCHES: &[(&str, Switch)] = &[
    ("sums=reversed", Switch::Sums),
    ("wall=missing", Switch::Wall),
    ("damping=wrong-sign", Switch::DampingSign),
    ("start=half-step", Switch::Start),
    ("torque-arms=other", Switch::TorqueArms),
    ("ratcheting=other", Switch::Ratcheting),
    ("clipping=other", Switch::Clipping),
];

const SLOW: &str = "slow";

/// Times as long; a signal is noticed every thousand steps, which must not take minutes.
const SLOWEST: f64 = 100.0;

/// A perturbation that this engine does not know.
#[derive(Debug, thiserror::Error)]
#[error(
    "unknown perturbation {found:?}; write one of {} with a number S, or one of {}, or slow=F with a factor F of 1 to {SLOWEST}",
    quantities(),
    switches()
)]
pub struct PerturbationError {
    found: String,
}

fn quantities() -> String {
    let names: Vec<String> = QUANTITIES
        .iter()
        .map(|(name, _)| format!("{name}=S"))
        .collect();
    names.join(", ")
}

fn switches() -> String {
    let names: Vec<&str> = SWITCHES.iter().map(|(name, _)| *name).collect();
    names.join(", ")
}

impl Perturbation {
    /// All quantities that can be a little wrong.
    pub fn quantities() -> impl Iterator<Item = Quantity> {
        QUANTITIES.iter().map(|(_, quantity)| *quantity)
    }

    /// All things that can be done in another way.
    pub fn switches() -> impl Iterator<Item = Switch> {
        SWITCHES.iter().map(|(_, switch)| *switch)
    }

    /// Whether a run of this scene is any different with the fault: without gravity, a fault in
    /// gravity is none.
    pub fn changes(self, scene: &Scene) -> bool {
        let bodies = initial_bodies(scene);
        let mut stages = scene.stages();
        stages.any(|stage| self.changes_case(&Model::in_stage(scene, stage), &bodies))
    }

    /// Whether these grains with this model are any different with the fault.
    pub fn changes_case(self, model: &Model, bodies: &Bodies) -> bool {
        let sound = Constants::new(model, bodies.len() as u32);
        let (mut faulty, mut grains) = (sound.clone(), bodies.clone());
        self.apply(&mut faulty, &mut grains);
        faulty != sound || grains != *bodies
    }

    /// Puts the fault in.
    pub(super) fn apply(self, constants: &mut Constants, bodies: &mut Bodies) {
        match self {
            Perturbation::Sized(quantity, size) => scale(quantity, 1.0 + size, constants, bodies),
            Perturbation::Switched(switch) => change(switch, constants),
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
}

fn scale(quantity: Quantity, factor: f64, constants: &mut Constants, bodies: &mut Bodies) {
    let all = |column: &mut Vec<f64>| column.iter_mut().for_each(|value| *value *= factor);
    match quantity {
        Quantity::Stiffness => constants.normal_factor *= factor,
        // Without friction it has no effect, so it is no fault.
        Quantity::ShearStiffness if !constants.law.has_friction() => {}
        Quantity::ShearStiffness => constants.tangential_factor *= factor,
        Quantity::Modulus => constants.change_law(|law| law.modulus *= factor),
        Quantity::Gravity => constants.gravity = constants.gravity.map(|g| g * factor),
        Quantity::Density => {
            all(&mut bodies.mass);
            all(&mut bodies.inertia);
        }
        Quantity::Damping => constants.alpha *= factor,
        Quantity::Friction => constants.change_law(|law| {
            law.friction_angle *= factor;
            let others = [&mut law.wall_friction_angle, &mut law.punch_friction_angle];
            others
                .into_iter()
                .flatten()
                .for_each(|angle| *angle *= factor);
        }),
        Quantity::Dashpot => constants.change_law(|law| match &mut law.contact.viscosity {
            Viscosity::None => {}
            Viscosity::Dashpot { c_n, .. } => *c_n *= factor,
            Viscosity::Restitution { e_n, .. } => *e_n *= factor,
        }),
        Quantity::Radius => bodies.radius.iter_mut().take(1).for_each(|r| *r *= factor),
        Quantity::TimeStep => constants.dt *= factor,
        Quantity::Inertia => bodies.inertia.iter_mut().take(1).for_each(|i| *i *= factor),
        Quantity::Wall => {
            let at = right_wall(constants);
            if let Some(wall) = at.and_then(|at| constants.walls.get_mut(at)) {
                wall.place *= factor;
            }
        }
    }
}

fn change(switch: Switch, constants: &mut Constants) {
    match switch {
        Switch::Sums => constants.reversed_sums = true,
        Switch::Wall => {
            if let Some(at) = right_wall(constants) {
                constants.walls.remove(at);
            }
        }
        Switch::DampingSign => constants.alpha = -constants.alpha,
        Switch::Start => constants.half_step_start = true,
        Switch::TorqueArms | Switch::Ratcheting | Switch::Clipping => {
            constants.change_law(|law| change_law(switch, law));
        }
    }
}

/// Where nothing slips or turns, another slip velocity or arm is no fault.
fn change_law(switch: Switch, law: &mut Law) {
    let (rotates, slips) = (law.rotates(), law.has_friction());
    let contact = &mut law.contact;
    match (switch, &mut contact.viscosity) {
        (Switch::TorqueArms, _) if rotates => {
            contact.torque_arms = match contact.torque_arms {
                TorqueArms::HalfOverlap => TorqueArms::ContactPoint,
                TorqueArms::ContactPoint => TorqueArms::HalfOverlap,
            }
        }
        (Switch::Ratcheting, _) if slips => {
            contact.slip_velocity = match contact.slip_velocity {
                SlipVelocity::RatchetingCorrected => SlipVelocity::ContactPoint,
                SlipVelocity::ContactPoint => SlipVelocity::RatchetingCorrected,
            }
        }
        (
            Switch::Clipping,
            Viscosity::Dashpot { tension, .. } | Viscosity::Restitution { tension, .. },
        ) => {
            *tension = match tension {
                Tension::Clipped => Tension::Unclipped,
                Tension::Unclipped => Tension::Clipped,
            }
        }
        _ => {}
    }
}

/// The wall x > 0 with the lowest id; without one, the last wall.
fn right_wall(constants: &Constants) -> Option<usize> {
    let walls = &constants.walls;
    let right = |wall: &super::state::Wall| wall.axis == Axis::X && wall.place > 0.0;
    walls.iter().position(right).or(walls.len().checked_sub(1))
}

impl FromStr for Perturbation {
    type Err = PerturbationError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let unknown = || PerturbationError {
            found: text.to_owned(),
        };
        if let Some((_, switch)) = SWITCHES.iter().find(|(name, _)| *name == text) {
            return Ok(Perturbation::Switched(*switch));
        }
        let (what, size) = text.split_once('=').ok_or_else(unknown)?;
        let size: f64 = size.parse().map_err(|_| unknown())?;
        if what == SLOW && (1.0..=SLOWEST).contains(&size) {
            return Ok(Perturbation::Slowed(size));
        }
        let (_, quantity) = QUANTITIES
            .iter()
            .find(|(name, _)| *name == what)
            .ok_or_else(unknown)?;
        if !size.is_finite() {
            return Err(unknown());
        }
        Ok(Perturbation::Sized(*quantity, size))
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = QUANTITIES.iter().find(|(_, of)| of == self);
        out.write_str(name.map_or("", |(name, _)| name))
    }
}

impl fmt::Display for Switch {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = SWITCHES.iter().find(|(_, of)| of == self);
        out.write_str(name.map_or("", |(name, _)| name))
    }
}

impl fmt::Display for Perturbation {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Perturbation::Sized(quantity, size) => write!(out, "{quantity}={size:e}"),
            Perturbation::Switched(switch) => write!(out, "{switch}"),
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
    /// Of positions, over their size.
    pub position: f64,
    /// Of velocities and spins, over their size.
    pub velocity: f64,
    /// Of the overlaps that forces are made of, m.
    pub overlap: f64,
    /// Which replica.
    pub replica: u64,
}

/// The noise under way.
pub(super) struct Shaker {
    noise: Noise,
    random: ChaCha8Rng,
}

const KEY: &[u8; 32] = b"crossgrain: rounding of replicas";

impl Noise {
    pub(super) fn begin(self) -> Shaker {
        Shaker {
            noise: self,
            random: self.random(),
        }
    }

    fn random(self) -> ChaCha8Rng {
        let mut random = ChaCha8Rng::from_seed(*KEY);
        random.set_stream(self.replica);
        random
    }
}

impl Shaker {
    /// Before the first step or after one.
    pub(super) fn shake(&mut self, state: &mut State, constants: &Constants) {
        if self.noise.replica % 2 == 1 {
            self.random = self.noise.random();
        }
        let Noise {
            position,
            velocity,
            overlap,
            ..
        } = self.noise;
        for id in 0..state.mass.len() {
            let id = state.place[id] as usize;
            let (radius, mass) = (state.radius[id], state.mass[id]);
            let kick = if state.force[id] == [0.0; 2] {
                0.0
            } else {
                constants.dt * constants.stiffness(radius, radius) * overlap / mass
            };
            for axis in 0..2 {
                let of = &mut self.random;
                state.position[id][axis] *= 1.0 + position * symmetric(of);
                state.velocity[id][axis] *= 1.0 + velocity * symmetric(of);
                let kick = kick * symmetric(of);
                state.velocity[id][axis] += kick;
                // The step has moved it already.
                state.position[id][axis] += constants.dt * kick;
            }
            if !state.inertia.is_empty() {
                // A force that is off by k times the overlap's error turns the grain at most with the arm R.
                let turn = kick * mass * radius / state.inertia[id];
                state.spin[id] *= 1.0 + velocity * symmetric(&mut self.random);
                state.spin[id] += turn * symmetric(&mut self.random);
            }
        }
    }
}
