//! Contacts as their laws have them for small displacements about where they stand: springs and dashpots.

use super::{Motion, Reference};
use crate::scene::Springs;
use crate::tables::Body;
use crate::vector::{Vector, cross, dot, norm};

/// A contact for small displacements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linear {
    /// Body 1, which a wall or the punch is if there is one, and body 2.
    pub ids: (u32, u32),
    pub first: Body,
    pub radii: [f64; 2],
    /// m.
    pub overlap: f64,
    /// From body 1 to body 2.
    pub normal: Vector,
    /// Of spring and adhesion along the normal, N.
    pub force: f64,
    /// dF/du, N/m, and along the tangent, whether or not Coulomb's limit is above zero.
    pub k_n: f64,
    pub k_s: f64,
    /// Whether there is friction that lets it stick.
    pub sticks: bool,
    /// N·s/m.
    pub c_n: f64,
    pub c_s: f64,
    /// How much of the centres' velocity counts as slip.
    pub stretch: f64,
    /// Lever arms of both sides, m: the mean of that of the slip, over `stretch`, and that of the force's torque. Where the two differ
    /// the stiffness is not symmetric, and what this leaves out of it is smaller by the square of their difference.
    pub arms: [f64; 2],
    /// N·m/rad.
    pub bending: f64,
    pub twisting: f64,
}

impl Reference {
    /// The contacts of the last evaluation, sorted by ids.
    pub fn linear(&self) -> Vec<Linear> {
        (0..self.touching.len())
            .map(|at| self.linear_at(at))
            .collect()
    }

    fn linear_at(&self, at: usize) -> Linear {
        let (ids, touch) = (self.touching[at].ids, &self.touching[at].touch);
        let (law, pair) = (&self.constants.law, self.pair(ids));
        let strength = self.strength(ids, touch, &pair);
        let still = self.motions(ids, touch).map(|motion| Motion {
            place: motion.place,
            ..Motion::default()
        });
        // Slips and torques are linear in what makes them, so one of each kind tells all. In the plane the tangent lies in it.
        let [x, _, z] = touch.normal;
        let tangent = match norm([z, 0.0, -x]) {
            0.0 => [1.0, 0.0, 0.0],
            size => [z / size, 0.0, -x / size],
        };
        let about = cross(touch.normal, tangent);
        let slip = |motions| self.slip(touch, motions).0;
        let mut moving = still;
        moving[1].velocity = tangent;
        let stretch = dot(slip(moving), tangent);
        let torques = self.torques(touch, still, tangent);
        let arms = [0, 1].map(|side: usize| {
            let mut turning = still;
            turning[side].spin = about;
            let of_slip = dot(slip(turning), tangent).abs() / stretch;
            0.5 * (of_slip + dot(torques[side], about).abs())
        });
        let rolling = law.contact.rolling.as_ref();
        let force = match law.contact.springs {
            Springs::HertzMindlin if !law.holds() => strength.elastic - pair.pull,
            _ => strength.elastic,
        };
        Linear {
            ids,
            first: touch.first,
            radii: touch.radii,
            overlap: touch.overlap,
            normal: touch.normal,
            force,
            k_n: strength.k_n,
            k_s: strength.k_s,
            sticks: pair.tangent > 0.0,
            c_n: if law.has_dashpots() {
                strength.c_n
            } else {
                0.0
            },
            c_s: -dot(self.braking(&strength, tangent), tangent),
            stretch,
            arms,
            bending: rolling
                .and_then(|rolling| rolling.bending_stiffness)
                .unwrap_or(0.0),
            twisting: rolling.map_or(0.0, |rolling| rolling.twisting_stiffness),
        }
    }
}
