//! How far a bed is from rest.

use super::Bed;
use crate::vector::{Vector, hypot, plus, times};

/// Unbalanced force: mean over grains of |ΣF + mg| over mean over contacts of |F|; none without contacts.
pub fn unbalanced_force(gravity: f64, bed: Bed<'_>) -> Option<f64> {
    if bed.contacts.is_empty() || bed.bodies.is_empty() {
        return None;
    }
    let ids = bed.ids();
    let weight = |mass: &f64| [0.0, 0.0, -mass * gravity];
    let mut total: Vec<Vector> = bed.bodies.mass.iter().map(weight).collect();
    let mut magnitudes = 0.0;
    for (contact, force) in bed.forces() {
        for (id, sign) in [(contact.id1, -1.0), (contact.id2, 1.0)] {
            if ids.is_grain(id) {
                total[id as usize] = plus(total[id as usize], times(sign, force));
            }
        }
        magnitudes += hypot(force);
    }
    let residual: f64 = total.into_iter().map(hypot).sum();
    let per_contact = magnitudes / bed.contacts.len() as f64;
    (per_contact > 0.0).then(|| residual / bed.bodies.len() as f64 / per_contact)
}
