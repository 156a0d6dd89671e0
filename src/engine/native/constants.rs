//! What a step reads and never changes.

use super::contact::{self, Axis};
use crate::scene::Scene;
use crate::tables::BodyIds;

/// Constants of a run, taken from the scene once.
#[derive(Debug, Clone, PartialEq)]
pub struct Constants {
    /// Young's modulus, Pa.
    pub modulus: f64,
    /// Relative change of every k_n; 1 unless a stiffness is perturbed.
    pub stiffness_factor: f64,
    /// m/s².
    pub gravity: f64,
    /// Cundall's α.
    pub alpha: f64,
    /// s.
    pub dt: f64,
    pub walls: Vec<Wall>,
    pub ids: BodyIds,
    /// Inner width of the box, m.
    pub width: f64,
    /// Pairs of a grain are summed from the highest partner down instead of from the lowest up.
    pub reversed_sums: bool,
}

/// An infinite wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall {
    pub id: u32,
    pub axis: Axis,
    /// Its coordinate on that axis, m.
    pub place: f64,
}

impl Constants {
    /// The scene's constants.
    pub fn new(scene: &Scene) -> Self {
        let ids = BodyIds {
            grains: scene.particles.count,
        };
        let width = scene.container.width;
        let wall = |id, axis, place| Wall { id, axis, place };
        Constants {
            modulus: scene.material.youngs_modulus,
            stiffness_factor: 1.0,
            gravity: scene.gravity,
            alpha: scene.damping.alpha(),
            dt: scene.time_step_seconds(),
            walls: vec![
                wall(ids.left(), Axis::X, 0.0),
                wall(ids.right(), Axis::X, width),
                wall(ids.floor(), Axis::Z, 0.0),
            ],
            ids,
            width,
            reversed_sums: false,
        }
    }

    /// k_n of two grains, or of a grain and a flat body (give its radius twice), N/m.
    pub fn stiffness(&self, radius1: f64, radius2: f64) -> f64 {
        contact::normal_stiffness(self.modulus, radius1, radius2) * self.stiffness_factor
    }
}
