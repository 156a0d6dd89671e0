//! The model: what a scene asks an engine to compute, resolved to numbers, and which terms of the
//! method are in it.
//!
//! Engines read this and never the scene's way of saying it, so a verification case, which is no
//! poured bed, is the same kind of thing to them.

mod restitution;
pub mod terms;

use serde::{Deserialize, Serialize};

use crate::scene::{ContactLaw, Rotation, Scene, Viscosity};

pub use restitution::damping_ratio;

/// Everything that a step depends on besides the grains and the punch. SI units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Gravitational acceleration, m/s², x and z.
    pub gravity: [f64; 2],
    /// Cundall's α.
    pub alpha: f64,
    /// s.
    pub dt: f64,
    /// Infinite walls; their ids follow the grains' in this order.
    pub walls: Vec<Wall>,
    /// What happens at a contact.
    pub law: Law,
}

/// The contact law with its parameters, the same for grains, walls and punch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Law {
    /// Young's modulus E, Pa.
    pub modulus: f64,
    /// k_s/k_n.
    pub stiffness_ratio: f64,
    /// Friction angle φ, rad.
    pub friction_angle: f64,
    /// Dashpots, rotations and the choices that the paper does not print.
    pub contact: ContactLaw,
}

/// Which coordinate a wall holds fixed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// Across.
    X = 0,
    /// Up.
    Z = 1,
}

/// An infinite wall; grains feel it from both sides.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// The coordinate that it holds fixed.
    pub axis: Axis,
    /// Its place on that axis, m.
    pub place: f64,
}

impl Model {
    /// What this scene asks for.
    pub fn of(scene: &Scene) -> Self {
        let wall = |axis, place| Wall { axis, place };
        Model {
            gravity: [0.0, -scene.gravity],
            alpha: scene.damping.alpha(),
            dt: scene.time_step_seconds(),
            walls: vec![
                wall(Axis::X, 0.0),
                wall(Axis::X, scene.container.width),
                wall(Axis::Z, 0.0),
            ],
            law: Law {
                modulus: scene.material.youngs_modulus,
                stiffness_ratio: scene.material.stiffness_ratio,
                friction_angle: scene.material.friction_angle,
                contact: scene.contact.clone(),
            },
        }
    }
}

impl Law {
    /// Whether contacts bear tangential forces.
    pub fn has_friction(&self) -> bool {
        self.friction_angle > 0.0
    }

    /// Normal stiffness of two grains, N/m: Eq. 4 of the paper, 2E R_i R_j/(R_i + R_j). Engines have their own.
    pub fn normal_stiffness(&self, radius1: f64, radius2: f64) -> f64 {
        2.0 * self.modulus * radius1 * radius2 / (radius1 + radius2)
    }

    /// Whether contacts have dashpots.
    pub fn has_dashpots(&self) -> bool {
        self.contact.viscosity != Viscosity::None
    }

    /// Whether grains can change their spin: only a tangential force turns a grain.
    pub fn rotates(&self) -> bool {
        self.has_friction() && self.contact.rotation == Rotation::Free
    }

    /// Whether forces depend on what was before, so that positions and velocities alone do not
    /// tell how a run goes on.
    pub fn has_history(&self) -> bool {
        self.has_friction()
    }
}
