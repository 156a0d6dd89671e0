//! How far a bed is from rest.

use super::Bed;

/// Unbalanced force: mean over grains of |ΣF + mg| over mean over contacts of |F|; none without contacts.
pub fn unbalanced_force(gravity: f64, bed: Bed<'_>) -> Option<f64> {
    if bed.contacts.is_empty() || bed.bodies.is_empty() {
        return None;
    }
    let ids = bed.ids();
    let weight = |mass: &f64| [0.0, -mass * gravity];
    let mut total: Vec<[f64; 2]> = bed.bodies.mass.iter().map(weight).collect();
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
