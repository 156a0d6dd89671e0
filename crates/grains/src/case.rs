//! A case: a few bodies, a model and the steps to look at. What is verified is a case, not a scene.

use serde::{Deserialize, Serialize};

use crate::model::Model;
use crate::tables::{Bodies, Punch};

/// A small experiment that any engine can run.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// A name for messages.
    pub name: String,
    /// What is computed.
    pub model: Model,
    /// The grains at the start, velocities half a step before the positions.
    pub bodies: Bodies,
    /// A punch that moves up or down at a constant velocity.
    pub punch: Option<Punch>,
    /// The steps after which the state is taken, rising; 0 is the start with its contacts.
    pub moments: Vec<u64>,
}

/// Force and torque summed on a grain: x and z, N; about y, N·m.
pub type Load = [f64; 3];

/// What an engine makes of one grain or contact of a case: its parameters, as used.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectiveContact {
    /// Body 1; a wall or the punch, if there is one in the pair.
    pub id1: u32,
    /// Body 2; always a grain.
    pub id2: u32,
    /// Normal stiffness, N/m.
    pub k_n: f64,
    /// Tangential stiffness, N/m; none where the engine does not compute it.
    pub k_s: Option<f64>,
    /// tan φ.
    pub tan_phi: f64,
    /// Damping constant of the dashpot, N·s/m.
    pub c_n: f64,
}

/// The parameters that an engine uses for a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Effective {
    /// Of every contact at the start, by ids.
    pub contacts: Vec<EffectiveContact>,
    /// Mass of each grain, kg.
    pub mass: Vec<f64>,
    /// Moment of inertia of each grain, kg·m²; empty where grains do not rotate.
    pub inertia: Vec<f64>,
    /// m/s², x and z.
    pub gravity: [f64; 2],
    /// Cundall's α.
    pub alpha: f64,
    /// s.
    pub dt: f64,
}
