//! How much of what presses down arrives at the floor: 1 for a bed at rest, whatever its stresses.
//!
//! Less means that the bed is still moving: falling grains bear nothing, and local damping bears up to the share α of the
//! weight of grains that sink.

use super::Bed;
use crate::scene::Scene;

/// Vertical force on the floor over the weight of all grains and what presses on the bed from above, `pressed` in N.
/// Friction at the walls, where there is any, is not counted.
pub fn by_floor(scene: &Scene, bed: Bed<'_>, pressed: f64) -> f64 {
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
