//! Extensive stress of a grain, Eq. 7 of the paper: Σ_ij = Σ_l x_i F_j over its contacts.

use nalgebra::Matrix2;

use super::Bed;

/// The three components of a plane stress or extensive stress, compression positive.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Components {
    /// Horizontal normal component.
    pub xx: f64,
    /// Vertical normal component.
    pub zz: f64,
    /// The symmetric part, ½(xz + zx).
    pub xz: f64,
}

impl From<Matrix2<f64>> for Components {
    fn from(tensor: Matrix2<f64>) -> Self {
        Components {
            xx: tensor[(0, 0)],
            zz: tensor[(1, 1)],
            xz: 0.5 * (tensor[(0, 1)] + tensor[(1, 0)]),
        }
    }
}

/// Σ of every grain, J per metre of depth: −Σ x_i F_j with x from the grain's centre to the contact
/// point and F the force on the grain, so that compression is positive.
pub fn of_grains(bed: Bed<'_>) -> Vec<Matrix2<f64>> {
    let ids = bed.ids();
    let mut extensive = vec![Matrix2::zeros(); bed.bodies.len()];
    for contact in bed.contacts {
        let force = contact.force();
        for (id, sign) in [(contact.id1, -1.0), (contact.id2, 1.0)] {
            if !ids.is_grain(id) {
                continue;
            }
            let id = id as usize;
            let arm = [
                contact.point[0] - bed.bodies.x[id],
                contact.point[1] - bed.bodies.z[id],
            ];
            extensive[id] -= sign
                * Matrix2::new(
                    arm[0] * force[0],
                    arm[0] * force[1],
                    arm[1] * force[0],
                    arm[1] * force[1],
                );
        }
    }
    extensive
}
