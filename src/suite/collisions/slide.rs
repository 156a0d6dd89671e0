//! A grain that hits a wall obliquely or spinning, and slides on it all through.

use std::f64::consts::PI;

use super::continuum::{self, Impact};
use super::experiment::view;
use super::leapfrog::{Scheme, State, rounding};
use crate::suite::Track;
use crate::suite::build::{self, Grain};
use grains::case::Case;
use grains::model::{Axis, Law, Model};
use grains::scene::{ContactLaw, SlipVelocity, Tension, TorqueArms, Viscosity};

/// The laws that differ in where a contact's force acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arms {
    /// R − u_n/2, and slip without ratcheting.
    HalfOverlap,
    /// R − u_n, and slip at the contact point.
    ContactPoint,
}

impl Arms {
    /// The share of the overlap that the arm at a wall is shorter than the radius.
    pub fn share(self) -> f64 {
        match self {
            Arms::HalfOverlap => 0.5,
            Arms::ContactPoint => 1.0,
        }
    }

    /// The law with these arms.
    pub fn of(self, law: Law) -> Law {
        match self {
            Arms::HalfOverlap => law,
            Arms::ContactPoint => Law {
                contact: ContactLaw {
                    slip_velocity: SlipVelocity::ContactPoint,
                    torque_arms: TorqueArms::ContactPoint,
                    ..law.contact
                },
                ..law
            },
        }
    }
}

/// A grain over a wall.
#[derive(Debug, Clone)]
pub struct Slide {
    /// A name for messages.
    pub name: String,
    /// Its position is put in here; it moves to the right and down.
    pub grain: Grain,
    /// k_n, N/m.
    pub stiffness: f64,
    /// k_s/k_n.
    pub ratio: f64,
    /// tan φ.
    pub tan_phi: f64,
    /// ζ of a clipped dashpot; with one, the arms end at the contact point.
    pub damping_ratio: f64,
    /// Where the force acts.
    pub arms: Arms,
    /// Steps in the contact time of the spring alone.
    pub steps: f64,
}

/// Steps before touch.
const LEAD: f64 = 5.5;

impl Slide {
    /// √(k/m), rad/s.
    pub fn frequency(&self) -> f64 {
        (self.stiffness / self.grain.mass).sqrt()
    }

    /// s.
    pub fn dt(&self) -> f64 {
        PI / (self.frequency() * self.steps)
    }

    fn dashpot(&self) -> f64 {
        continuum::dashpot(self.damping_ratio, self.grain.mass, self.stiffness)
    }

    /// Speed towards the wall, m/s.
    pub fn approach(&self) -> f64 {
        -self.grain.velocity[1]
    }

    /// The contact in continuous time.
    pub fn impact(&self) -> Impact {
        Impact {
            mass: self.grain.mass,
            stiffness: self.stiffness,
            dashpot: self.dashpot(),
            pull: 0.0,
            approach: self.approach(),
            clipped: true,
        }
    }

    /// The contact as the scheme has it.
    pub fn scheme(&self) -> Scheme {
        Scheme {
            mass: self.grain.mass,
            stiffness: self.stiffness,
            dashpot: self.dashpot(),
            clipped: true,
            pull: 0.0,
            alpha: 0.0,
            dt: self.dt(),
        }
    }

    /// The state at the start.
    pub fn start(&self) -> State {
        State {
            step: 0,
            overlap: -LEAD * self.dt() * self.approach(),
            approach: self.approach(),
        }
    }

    /// A step by which the contact is over.
    pub fn end(&self) -> u64 {
        (LEAD + 1.02 * self.impact().release().parted() / self.dt() + 3.0).ceil() as u64
    }

    /// +1 where the surface slips to the right, −1 to the left: friction pushes the other way.
    pub fn direction(&self) -> f64 {
        (self.grain.velocity[0] - self.grain.radius * self.grain.spin).signum()
    }

    /// Velocity along the wall and spin that follow from the impulse J = ∫N dt and from ∫u N dt: the
    /// tangential impulse is μJ and acts at the arm R − s·u.
    pub fn sliding(&self, impulse: f64, overlap_impulse: f64) -> [f64; 2] {
        let Grain {
            velocity,
            spin,
            mass,
            inertia,
            radius,
            ..
        } = self.grain;
        let friction = self.direction() * self.tan_phi;
        let turning = radius * impulse - self.arms.share() * overlap_impulse;
        [
            velocity[0] - friction * impulse / mass,
            spin + friction * turning / inertia,
        ]
    }

    /// The same in the closed form: J = m(1+e)v.
    pub fn expected(&self) -> [f64; 2] {
        let impact = self.impact();
        let impulse = impact.mass * (impact.approach + impact.release().speed);
        self.sliding(impulse, impact.overlap_impulse())
    }

    /// How far velocity and spin may be off that: the impulse, as touch and parting fall into the middle
    /// between two steps, by (ω dt)⁴, and with a dashpot, which lags by half a step and so acts on a mass
    /// smaller by ½c dt, by twice ¼|ln e|·c dt/m; the overlap by (ω dt)² and c dt/m. And rounding.
    pub fn tolerances(&self) -> [f64; 2] {
        let impact = self.impact();
        let (angle, share) = (PI / self.steps, impact.dashpot * self.dt() / impact.mass);
        let rebound = impact.release().speed / impact.approach;
        let reach = self.wall() + self.grain.radius;
        let rounding = rounding(self.end(), reach, impact.approach / self.frequency());
        let of_impulse = angle.powi(4) + 0.5 * rebound.ln().abs() * share + rounding;
        let impulse = impact.mass * (1.0 + rebound) * impact.approach * of_impulse;
        let shortening = self.arms.share() * impact.overlap_impulse() * (angle * angle + share);
        let turning = self.grain.radius * impulse + shortening;
        let Grain { mass, inertia, .. } = self.grain;
        [
            self.tan_phi * impulse / mass,
            self.tan_phi * turning / inertia,
        ]
    }

    /// Height of the wall, m; not zero, so that a fault in it shows.
    fn wall(&self) -> f64 {
        0.5 * self.grain.radius
    }

    /// The experiment with the state after these steps.
    pub fn case(&self, moments: Vec<u64>) -> Case {
        let angle = self.tan_phi.atan();
        let plain = build::friction(self.stiffness / self.grain.radius, self.ratio, angle);
        let law = if self.damping_ratio == 0.0 {
            self.arms.of(plain)
        } else {
            let viscosity = Viscosity::Dashpot {
                c_n: self.dashpot(),
                tension: Tension::Clipped,
            };
            build::with_viscosity(plain, viscosity)
        };
        let model = Model {
            walls: vec![build::wall(Axis::Z, self.wall())],
            ..build::model(law, self.dt())
        };
        let height = self.wall() + self.grain.radius - self.start().overlap;
        let grain = Grain {
            position: [0.0, height],
            ..self.grain
        };
        build::case(&self.name, model, &[grain], moments)
    }

    /// Velocity along the wall and spin at the end.
    pub fn seen(&self, tracks: &[Track]) -> [f64; 2] {
        let end = view(tracks, 0, self.end());
        [end.velocity(0)[0], end.spin(0)]
    }
}
