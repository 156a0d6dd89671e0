//! How far a bed is from rest: its energies, the force that is not balanced, and how much of what presses down arrives at the
//! floor.

use super::Bed;
use crate::model::Model;
use crate::scene::Scene;
use crate::tables::{Bodies, Contact};

/// Σ ½mv² + Σ ½Iω², with the velocities as stored: half a step before the positions.
pub fn kinetic_energy(bodies: &Bodies) -> f64 {
    bodies.kinetic_energy()
}

/// Σ mgz above the floor.
pub fn potential_energy(scene: &Scene, bodies: &Bodies) -> f64 {
    let moment: f64 = bodies.mass.iter().zip(&bodies.z).map(|(m, z)| m * z).sum();
    scene.gravity * moment
}

/// Energy stored in the springs of the contacts: Σ ½F_n u_n of the normal ones, with dashpots Σ ½k_n u_n²,
/// since F_n is then not the spring's alone; and with friction Σ ½F_s²/k_s of the tangential ones.
pub fn elastic_energy(scene: &Scene, bed: Bed<'_>) -> f64 {
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

/// Unbalanced force: mean over grains of |ΣF + mg| over mean over contacts of |F|; none without contacts.
pub fn unbalanced_force(scene: &Scene, bed: Bed<'_>) -> Option<f64> {
    if bed.contacts.is_empty() || bed.bodies.is_empty() {
        return None;
    }
    let ids = bed.ids();
    let mut total: Vec<[f64; 2]> = bed
        .bodies
        .mass
        .iter()
        .map(|mass| [0.0, -mass * scene.gravity])
        .collect();
    let mut magnitudes = 0.0;
    for contact in bed.contacts {
        let force = contact.force();
        for (id, sign) in [(contact.id1, -1.0), (contact.id2, 1.0)] {
            if ids.is_grain(id) {
                total[id as usize][0] += sign * force[0];
                total[id as usize][1] += sign * force[1];
            }
        }
        magnitudes += force[0].hypot(force[1]);
    }
    let residual: f64 = total.iter().map(|[x, z]| x.hypot(*z)).sum();
    let per_contact = magnitudes / bed.contacts.len() as f64;
    (per_contact > 0.0).then(|| residual / total.len() as f64 / per_contact)
}

/// How much of what presses down arrives at the floor: 1 for a bed at rest, whatever its stresses. Less means that the bed is
/// still moving: falling grains bear nothing, and local damping bears up to the share α of the weight of grains that sink.
///
/// Vertical force on the floor over the weight of all grains and what presses on the bed from above, `pressed` in N.
/// Friction at the walls, where there is any, is not counted.
pub fn borne_by_floor(scene: &Scene, bed: Bed<'_>, pressed: f64) -> f64 {
    let floor = bed.ids().floor();
    let borne: f64 = bed
        .contacts
        .iter()
        .filter(|contact| contact.id1 == floor)
        .map(|contact| contact.force()[1])
        .sum();
    let mass: f64 = bed.bodies.mass.iter().sum();
    borne / (mass * scene.gravity + pressed)
}
