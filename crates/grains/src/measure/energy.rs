//! Energies of a bed, J.

use super::Bed;
use crate::model::Model;
use crate::scene::Scene;
use crate::tables::{Bodies, Contact};

/// Σ ½mv² + Σ ½Iω², with the velocities as stored: half a step before the positions.
pub fn kinetic(bodies: &Bodies) -> f64 {
    bodies.kinetic_energy()
}

/// Σ mgz above the floor.
pub fn potential(scene: &Scene, bodies: &Bodies) -> f64 {
    let moment: f64 = bodies.mass.iter().zip(&bodies.z).map(|(m, z)| m * z).sum();
    scene.gravity * moment
}

/// Energy stored in the springs of the contacts: Σ ½F_n u_n of the normal ones, with dashpots Σ ½k_n u_n²,
/// since F_n is then not the spring's alone; and with friction Σ ½F_s²/k_s of the tangential ones.
pub fn elastic(scene: &Scene, bed: Bed<'_>) -> f64 {
    let law = Model::of(scene).law;
    let (dashpots, friction) = (law.has_dashpots(), law.has_friction());
    let radius = |id: u32| bed.bodies.radius.get(id as usize).copied();
    let stored = |contact: &Contact| {
        let grain = radius(contact.id2).unwrap_or_default();
        // A flat body counts as a grain of the same radius.
        let other = radius(contact.id1).unwrap_or(grain);
        let stiffness = law.normal_stiffness(other, grain);
        let normal = if dashpots {
            0.5 * stiffness * contact.overlap * contact.overlap
        } else {
            0.5 * contact.normal_force * contact.overlap
        };
        let tangential = if friction {
            let shear = contact.tangential_force;
            0.5 * shear * shear / (law.stiffness_ratio * stiffness)
        } else {
            0.0
        };
        normal + tangential
    };
    bed.contacts
        .iter()
        .map(stored)
        .fold(0.0, |sum, energy| sum + energy)
}
