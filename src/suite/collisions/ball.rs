//! The ball of MFiX-DEM's first two verification cases over its floor (Garg, Galvin, Li and Pannala, Powder
//! Technology 220 (2012) 122; DEM01 and DEM02 of MFiX's verification manual).

use super::continuum::{Impact, dashpot, nominal_ratio};
use super::experiment::View;
use crate::suite::build::{self, Grain};
use grains::case::Case;
use grains::model::{Axis, Model};
use grains::scene::{Tension, Viscosity};

/// m/s².
pub const GRAVITY: f64 = 9.81;
/// Of the ball, m.
pub const RADIUS: f64 = 0.1;
/// Of the ball, kg/m³.
pub const DENSITY: f64 = 2600.0;
/// Of the centre at the start, m.
pub const HEIGHT: f64 = 0.5;

/// The ball over the floor z = 0.
#[derive(Debug, Clone)]
pub struct Ball {
    /// A name for messages.
    pub name: String,
    /// k_n, N/m.
    pub stiffness: f64,
    /// Of the dashpot where nothing is clipped and nothing weighs; 1 is without one.
    pub restitution: f64,
    /// Whether the dashpot may pull.
    pub tension: Tension,
    /// Cundall's α.
    pub alpha: f64,
    /// s.
    pub dt: f64,
}

impl Ball {
    /// Before it falls.
    pub fn grain(&self) -> Grain {
        // At rest at the start: so fast half a step before.
        let before = 0.5 * GRAVITY * (1.0 - self.alpha) * self.dt;
        Grain::sphere([0.0, HEIGHT], RADIUS, DENSITY).moving([0.0, before])
    }

    /// √(k/m), rad/s.
    pub fn frequency(&self) -> f64 {
        (self.stiffness / self.grain().mass).sqrt()
    }

    /// (ω dt)².
    pub fn second_order(&self) -> f64 {
        (self.frequency() * self.dt).powi(2)
    }

    /// c_n dt/m: the share of the momentum that the dashpot takes in a step.
    pub fn first_order(&self) -> f64 {
        self.dashpot() * self.dt / self.grain().mass
    }

    /// c_n of this restitution where nothing is clipped and nothing weighs, N·s/m.
    pub fn dashpot(&self) -> f64 {
        let ratio = nominal_ratio(self.restitution);
        dashpot(ratio, self.grain().mass, self.stiffness)
    }

    /// A contact that begins at this speed, m/s.
    pub fn impact(&self, approach: f64) -> Impact {
        Impact {
            mass: self.grain().mass,
            stiffness: self.stiffness,
            dashpot: self.dashpot(),
            pull: GRAVITY,
            approach,
            clipped: self.tension == Tension::Clipped,
        }
    }

    /// The fall with the state after these steps.
    pub fn case(&self, moments: Vec<u64>) -> Case {
        let springs = build::springs(self.stiffness / RADIUS);
        let law = if self.restitution == 1.0 {
            springs
        } else {
            let viscosity = Viscosity::Dashpot {
                c_n: self.dashpot(),
                tension: self.tension,
            };
            build::with_viscosity(springs, viscosity)
        };
        let model = Model {
            gravity: [0.0, -GRAVITY],
            alpha: self.alpha,
            walls: vec![build::wall(Axis::Z, 0.0)],
            ..build::model(law, self.dt)
        };
        build::case(&self.name, model, &[self.grain()], moments)
    }

    /// The step nearest to a time.
    pub fn step(&self, time: f64) -> u64 {
        (time / self.dt).round() as u64
    }

    /// Height and upward velocity at a step, not half a step before it, in free flight at −`fall`.
    pub fn flight(&self, view: View, fall: f64) -> [f64; 2] {
        let velocity = view.velocity(0)[1] - 0.5 * fall * self.dt;
        [view.position(0)[1], velocity]
    }
}

/// Touch: √(2(h−R)/g) after the start, with √(2g(h−R)).
pub fn touch() -> [f64; 2] {
    let fall = HEIGHT - RADIUS;
    [(2.0 * fall / GRAVITY).sqrt(), (2.0 * GRAVITY * fall).sqrt()]
}
