//! A grain that falls on a floor and bounces, with everything that acts along one line.

use super::continuum::dashpot;
use super::experiment::{Experiment, view};
use super::leapfrog::{Scheme, State, deviations, rounding};
use crate::suite::build::{self, Grain};
use crate::suite::{Line, Track};
use grains::case::Case;
use grains::model::{Axis, Model};
use grains::scene::{Tension, Viscosity};

struct Bounces {
    name: &'static str,
    /// Cundall's α.
    alpha: f64,
    /// ζ of the clipped dashpot.
    ratio: f64,
}

/// With the one, the other and both.
pub fn experiments() -> Vec<Box<dyn Experiment>> {
    let all = [
        ("elastic", 0.0, 0.0),
        ("local damping", 0.2, 0.0),
        ("dashpot", 0.0, 0.1),
        ("local damping and dashpot", 0.1, 0.05),
    ];
    let of =
        |(name, alpha, ratio)| -> Box<dyn Experiment> { Box::new(Bounces { name, alpha, ratio }) };
    all.into_iter().map(of).collect()
}

/// k, N/m.
const STIFFNESS: f64 = 2.0e4;
/// m/s².
const GRAVITY: f64 = 9.81;
/// Height of the floor, m.
const FLOOR: f64 = 0.05;
/// s.
const DT: f64 = 2.0e-4;
/// Several bounces.
const STEPS: u64 = 3000;

impl Bounces {
    fn grain(&self) -> Grain {
        // A height at which touch falls between two steps.
        Grain::disc([0.0, FLOOR + 0.0713], 0.05, 1000.0)
    }

    fn scheme(&self) -> Scheme {
        let mass = self.grain().mass;
        Scheme {
            mass,
            stiffness: STIFFNESS,
            dashpot: dashpot(self.ratio, mass, STIFFNESS),
            clipped: true,
            pull: GRAVITY,
            alpha: self.alpha,
            dt: DT,
        }
    }

    fn state(&self, step: u64, height: f64, velocity: f64) -> State {
        State {
            step,
            overlap: FLOOR + self.grain().radius - height,
            approach: -velocity,
        }
    }

    fn moments(&self) -> Vec<u64> {
        (0..=10).map(|count| count * (STEPS / 10)).collect()
    }
}

impl Experiment for Bounces {
    fn cases(&self) -> Vec<Case> {
        let springs = build::springs(STIFFNESS / self.grain().radius);
        let law = if self.ratio == 0.0 {
            springs
        } else {
            let viscosity = Viscosity::Dashpot {
                c_n: self.scheme().dashpot,
                tension: Tension::Clipped,
            };
            build::with_viscosity(springs, viscosity)
        };
        let model = Model {
            gravity: [0.0, -GRAVITY],
            alpha: self.alpha,
            walls: vec![build::wall(Axis::Z, FLOOR)],
            ..build::model(law, DT)
        };
        vec![build::case(
            self.name,
            model,
            &[self.grain()],
            self.moments(),
        )]
    }

    fn lines(&self, tracks: &[Track]) -> Vec<Line> {
        let grain = self.grain();
        let start = self.state(0, grain.position[1], grain.velocity[1]);
        let expected = self.scheme().track(start, &self.moments());
        let seen = self.moments().into_iter().map(|step| {
            let view = view(tracks, 0, step);
            self.state(step, view.position(0)[1], view.velocity(0)[1])
        });
        let height = grain.position[1] - grain.radius - FLOOR;
        let speed = (2.0 * GRAVITY * height).sqrt();
        let tolerance = rounding(STEPS, grain.position[1], height);
        deviations(
            self.name,
            seen.collect(),
            &expected,
            [height, speed],
            tolerance,
        )
    }
}
