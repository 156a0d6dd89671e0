//! Energies of a bed, J.

use crate::scene::Scene;
use crate::tables::{Bodies, Contact};

/// Σ ½mv² + Σ ½Iω², with the velocities as stored: half a step before the positions.
pub fn kinetic(bodies: &Bodies) -> f64 {
    let mut energy = 0.0;
    for ((mass, vx), vz) in bodies.mass.iter().zip(&bodies.vx).zip(&bodies.vz) {
        energy += 0.5 * mass * (vx * vx + vz * vz);
    }
    for (inertia, spin) in bodies.inertia.iter().zip(&bodies.spin) {
        energy += 0.5 * inertia * (spin * spin);
    }
    energy
}

/// Σ mgz above the floor.
pub fn potential(scene: &Scene, bodies: &Bodies) -> f64 {
    let moment: f64 = bodies.mass.iter().zip(&bodies.z).map(|(m, z)| m * z).sum();
    scene.gravity * moment
}

/// Σ ½F_n u_n of the normal springs.
pub fn elastic(contacts: &[Contact]) -> f64 {
    contacts
        .iter()
        .map(|contact| 0.5 * contact.normal_force * contact.overlap)
        .fold(0.0, |sum, energy| sum + energy)
}
