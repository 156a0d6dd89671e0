//! A grain against a wall, or two grains whose centre of mass is at rest, head-on.

use std::f64::consts::PI;

use super::continuum::Impact;
use super::experiment::View;
use super::leapfrog::{Scheme, State};
use crate::suite::build::{self, Grain};
use grains::case::Case;
use grains::model::{Axis, Model};
use grains::scene::{Tension, Viscosity};

/// What the first grain meets.
#[derive(Debug, Clone, Copy)]
pub enum Partner {
    /// A wall below it.
    Wall,
    /// Another grain, to its right.
    Grain(Grain),
}

/// A collision without gravity.
#[derive(Debug, Clone)]
pub struct HeadOn {
    /// A name for messages.
    pub name: String,
    /// The first grain; where it is and how it moves is put in here.
    pub grain: Grain,
    /// What it meets.
    pub partner: Partner,
    /// k_n, N/m.
    pub stiffness: f64,
    /// Dashpot.
    pub viscosity: Viscosity,
    /// Cundall's α.
    pub alpha: f64,
    /// Speed of the approach, m/s.
    pub approach: f64,
    /// Steps in the contact time of the spring alone, π√(m_eff/k).
    pub steps: f64,
    /// Steps before touch; half a step in it makes the first step with a force begin at touch.
    pub lead: f64,
}

impl HeadOn {
    /// m_eff, kg.
    pub fn mass(&self) -> f64 {
        let one = self.grain.mass;
        match self.partner {
            Partner::Wall => one,
            Partner::Grain(other) => one * other.mass / (one + other.mass),
        }
    }

    /// √(k/m_eff), rad/s.
    pub fn frequency(&self) -> f64 {
        (self.stiffness / self.mass()).sqrt()
    }

    /// s.
    pub fn dt(&self) -> f64 {
        PI / (self.frequency() * self.steps)
    }

    /// ω dt.
    pub fn angle(&self) -> f64 {
        PI / self.steps
    }

    /// c_n, N·s/m; not for a dashpot that is given by its restitution.
    fn dashpot(&self) -> f64 {
        match self.viscosity {
            Viscosity::Dashpot { c_n, .. } => c_n,
            Viscosity::None | Viscosity::Restitution { .. } => 0.0,
        }
    }

    /// Whether the force is never less than zero.
    pub fn clipped(&self) -> bool {
        match self.viscosity {
            Viscosity::None => true,
            Viscosity::Dashpot { tension, .. } | Viscosity::Restitution { tension, .. } => {
                tension == Tension::Clipped
            }
        }
    }

    /// The contact in continuous time, without local damping.
    pub fn impact(&self) -> Impact {
        Impact {
            mass: self.mass(),
            stiffness: self.stiffness,
            dashpot: self.dashpot(),
            pull: 0.0,
            approach: self.approach,
            clipped: self.clipped(),
        }
    }

    /// The contact as the scheme has it.
    pub fn scheme(&self) -> Scheme {
        Scheme {
            mass: self.mass(),
            stiffness: self.stiffness,
            dashpot: self.dashpot(),
            clipped: self.clipped(),
            pull: 0.0,
            alpha: self.alpha,
            dt: self.dt(),
        }
    }

    /// The state at the start.
    pub fn start(&self) -> State {
        State {
            step: 0,
            overlap: -self.lead * self.dt() * self.approach,
            approach: self.approach,
        }
    }

    /// A step by which a contact of this duration (s) is over.
    pub fn end(&self, duration: f64) -> u64 {
        (self.lead + 1.02 * duration / self.dt() + 3.0).ceil() as u64
    }

    /// The experiment with the state after these steps.
    pub fn case(&self, moments: Vec<u64>) -> Case {
        let (model, grains) = match self.partner {
            Partner::Wall => self.at_a_wall(),
            Partner::Grain(other) => self.with_a_grain(other),
        };
        let model = Model {
            alpha: self.alpha,
            ..model
        };
        build::case(&self.name, model, &grains, moments)
    }

    fn at_a_wall(&self) -> (Model, Vec<Grain>) {
        let radius = self.grain.radius;
        let mut model = self.model(self.stiffness / radius);
        model.walls.push(build::wall(Axis::Z, self.floor()));
        let height = self.floor() + radius - self.start().overlap;
        let grain = Grain {
            position: [0.0, height],
            ..self.grain
        };
        (model, vec![grain.moving([0.0, -self.approach])])
    }

    fn with_a_grain(&self, other: Grain) -> (Model, Vec<Grain>) {
        let one = self.grain;
        let sum = one.radius + other.radius;
        let modulus = self.stiffness * sum / (2.0 * one.radius * other.radius);
        let share = other.mass / (one.mass + other.mass);
        let place = Grain {
            position: [0.0, 0.0],
            ..one
        };
        let opposite = Grain {
            position: [sum - self.start().overlap, 0.0],
            ..other
        };
        let grains = vec![
            place.moving([share * self.approach, 0.0]),
            opposite.moving([(share - 1.0) * self.approach, 0.0]),
        ];
        (self.model(modulus), grains)
    }

    fn model(&self, modulus: f64) -> Model {
        let springs = build::springs(modulus);
        let law = match self.viscosity {
            Viscosity::None => springs,
            _ => build::with_viscosity(springs, self.viscosity.clone()),
        };
        build::model(law, self.dt())
    }

    /// Height of the wall, m; not zero, so that a fault in it shows.
    fn floor(&self) -> f64 {
        0.5 * self.grain.radius
    }

    /// Overlap and approach speed as a snapshot has them.
    pub fn state(&self, view: View, step: u64) -> State {
        let ([x, z], [vx, vz]) = (view.position(0), view.velocity(0));
        let (overlap, approach) = match self.partner {
            Partner::Wall => (self.floor() + self.grain.radius - z, -vz),
            Partner::Grain(other) => {
                let sum = self.grain.radius + other.radius;
                (sum - (view.position(1)[0] - x), vx - view.velocity(1)[0])
            }
        };
        State {
            step,
            overlap,
            approach,
        }
    }

    /// Restitution and contact time (s) from states before touch and after the surfaces have parted: in
    /// between nothing but the contact acts, so the straight ways tell when the surfaces met and parted.
    pub fn outcome(&self, before: &State, after: &State) -> [f64; 2] {
        let at = |state: &State| state.step as f64 * self.dt() - state.overlap / state.approach;
        [-after.approach / before.approach, at(after) - at(before)]
    }
}
