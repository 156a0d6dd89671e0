//! Deliberate faults, so that a comparison can prove that it would notice them.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::state::Constants;
use crate::constant::{Constant, Given, right_wall};
use crate::generate::initial_bodies;
use crate::model::Model;
use crate::scene::Scene;
use crate::tables::Bodies;

/// One fault in the native engine, as written on the command line: `stiffness=1e-12`, `sums=reversed`, `slow=2`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Fault {
    /// This constant is multiplied by 1 + the size.
    Sized(Constant, f64),
    /// Something of the table below is done in another way.
    Switched(Switch),
    /// The same steps take so many times as long, 1 to 100: a fault that no result shows, only a clock.
    Slowed(f64),
}

/// A row of the table below, by its number, so that no other fault can be named.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Switch(usize);

/// A fault's name, and what puts it in.
type Row = (&'static str, fn(&mut Constants));

/// What can be done in another way. Where nothing slips or turns, another slip velocity or arm is no fault.
const SWITCHES: [Row; 7] = [
    // The forces on a grain are summed from the highest partner down.
    ("sums=reversed", |constants| constants.reversed_sums = true),
    // The right wall is where nothing comes near it.
    ("wall=missing", |constants| {
        right_wall(constants, |wall| wall.place = f64::INFINITY)
    }),
    // Damping adds energy instead of taking it.
    ("damping=wrong-sign", |constants| {
        constants.alpha = -constants.alpha
    }),
    // The initial velocities are taken for those at the start.
    ("start=half-step", |constants| {
        constants.half_step_start = true
    }),
    // Half overlap and contact point change places.
    ("torque-arms=other", |constants| {
        if constants.law.rotates() {
            constants.law.contact.torque_arms = constants.law.contact.torque_arms.other();
        }
    }),
    // Corrected and contact point velocity change places.
    ("ratcheting=other", |constants| {
        if constants.law.has_friction() {
            constants.law.contact.slip_velocity = constants.law.contact.slip_velocity.other();
        }
    }),
    // Clipped and unclipped tension change places.
    ("clipping=other", |constants| {
        constants.change_law(|law| law.contact.viscosity.clip_otherwise());
    }),
];

impl fmt::Display for Switch {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(SWITCHES[self.0].0)
    }
}

const SLOW: &str = "slow";

/// Times as long; a signal is noticed every thousand steps, which must not take minutes.
const SLOWEST: f64 = 100.0;

/// A fault that this engine does not know.
#[derive(Debug, thiserror::Error)]
#[error(
    "unknown perturbation {found:?}; write one of {} with a number S, or one of {}, or slow=F with a factor F of 1 to {SLOWEST}",
    Constant::faults().map(|constant| format!("{constant}=S")).collect::<Vec<_>>().join(", "),
    Fault::switches().map(|switch| switch.to_string()).collect::<Vec<_>>().join(", ")
)]
pub struct FaultError {
    found: String,
}

impl Fault {
    /// All things that can be done in another way.
    pub fn switches() -> impl Iterator<Item = Switch> {
        (0..SWITCHES.len()).map(Switch)
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
            Fault::Sized(constant, size) => constant.enlarge(given, size),
            Fault::Switched(Switch(row)) => SWITCHES[row].1(&mut given.constants),
            Fault::Slowed(_) => {}
        }
    }

    /// How many times as long the steps take, if that is the fault.
    pub(super) fn slowed(self) -> Option<f64> {
        match self {
            Fault::Slowed(factor) => Some(factor),
            Fault::Sized(..) | Fault::Switched(_) => None,
        }
    }

    fn known(text: &str) -> Option<Self> {
        if let Some(row) = SWITCHES.iter().position(|(name, _)| *name == text) {
            return Some(Fault::Switched(Switch(row)));
        }
        let (what, size) = text.split_once('=')?;
        let size: f64 = size.parse().ok()?;
        if what == SLOW && (1.0..=SLOWEST).contains(&size) {
            return Some(Fault::Slowed(size));
        }
        let mut faults = Constant::faults().filter(|_| size.is_finite());
        let constant = faults.find(|constant| constant.to_string() == what)?;
        Some(Fault::Sized(constant, size))
    }
}

impl FromStr for Fault {
    type Err = FaultError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Fault::known(text).ok_or_else(|| FaultError {
            found: text.to_owned(),
        })
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fault::Sized(constant, size) => write!(out, "{constant}={size:e}"),
            Fault::Switched(switch) => switch.fmt(out),
            Fault::Slowed(factor) => write!(out, "{SLOW}={factor}"),
        }
    }
}

impl TryFrom<String> for Fault {
    type Error = FaultError;
    fn try_from(text: String) -> Result<Self, Self::Error> {
        text.parse()
    }
}

impl From<Fault> for String {
    fn from(fault: Fault) -> String {
        fault.to_string()
    }
}
