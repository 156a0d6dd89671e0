//! A ball on a plane: sliding, sliding until it rolls, rolling down an incline. In all of them the normal
//! force is constant, because the ball starts at the overlap u that bears it.
//!
//! With YADE's choices the force acts at the arm r = R − u/2, and rolling without slip is v = rω: the
//! slip is a(v − rω) with a = R/r. So the results for a rigid ball hold with r in place of R, in
//! I/(mR²) as well.

mod incline;
mod slip;

use crate::suite::Rung;
use crate::suite::build::{self, Grain};
use grains::model::Law;
use grains::scene::{ContactLaw, SlipVelocity, TorqueArms};

/// The rungs.
pub fn rungs() -> Vec<Rung> {
    vec![
        slip::sliding(),
        slip::then_rolling(),
        incline::rolling(),
        incline::sliding(),
    ]
}

/// What a ball is: its name and I/(mR²).
const SHAPES: [(&str, f64); 2] = [("sphere", 0.4), ("disc", 0.5)];

/// A ball on the plane z = 0 whose weight makes the overlap.
#[derive(Debug, Clone, Copy)]
struct Ball {
    grain: Grain,
    /// m.
    overlap: f64,
    /// Distance from the centre at which the plane's force acts, m.
    arm: f64,
    /// k_n, N/m.
    stiffness: f64,
}

impl Ball {
    /// A ball of this radius (m), mass (kg) and share I/(mR²) that bears this weight (N) at this k_n (N/m).
    fn new(x: f64, [radius, mass, share]: [f64; 3], weight: f64, stiffness: f64) -> Self {
        let overlap = weight / stiffness;
        let grain = Grain {
            position: [x, radius - overlap],
            velocity: [0.0; 2],
            spin: 0.0,
            radius,
            mass,
            inertia: share * mass * radius * radius,
        };
        Ball {
            grain,
            overlap,
            arm: radius - 0.5 * overlap,
            stiffness,
        }
    }

    /// mr²/I.
    fn lightness(&self) -> f64 {
        self.grain.mass * self.arm * self.arm / self.grain.inertia
    }

    /// ω of the slip while the ball sticks: k_s a (1/m + r²/I), with k_s = k_n·ratio.
    fn stick_omega(&self, ratio: f64) -> f64 {
        let factor = self.grain.radius / self.arm;
        let stiffness = ratio * self.stiffness * factor;
        (stiffness * (1.0 + self.lightness()) / self.grain.mass).sqrt()
    }

    /// The law that gives these stiffnesses, with friction of this tan φ.
    fn law(&self, ratio: f64, friction: f64) -> Law {
        let modulus = self.stiffness / self.grain.radius;
        build::friction(modulus, ratio, friction.atan())
    }
}

/// The same law with slip and arms at the contact point.
fn at_the_contact_point(law: Law) -> Law {
    Law {
        contact: ContactLaw {
            slip_velocity: SlipVelocity::ContactPoint,
            torque_arms: TorqueArms::ContactPoint,
            ..law.contact
        },
        ..law
    }
}
