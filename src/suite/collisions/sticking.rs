//! A grain that rests on a floor and rocks on its tangential spring, below Coulomb's limit.
//!
//! The force S along the floor obeys S_n = S_{n−1} − k_s σ_{n−1/2} dt with the slip rate σ, and changes the slip
//! rate by Γ S dt, Γ = a/m + bR′/I. So S is the recurrence of a spring of stiffness k_s on the mass 1/Γ.
//! Corrected slip has a = 2R/(2R − u), R′ = R and the arm b = R − u/2; the contact point a = 1,
//! R′ = b = R − u.

use super::experiment::{Experiment, largest, view};
use super::leapfrog::{ROUNDING, Scheme, State, rounding, rounding_of_phase};
use super::slide::Arms;
use crate::suite::build::{self, Grain};
use crate::suite::line;
use crate::suite::{Line, Track};
use grains::case::Case;
use grains::model::{Axis, Model};

struct Sticking {
    name: &'static str,
    grain: Grain,
    arms: Arms,
}

/// A ball and a disc with both kinds of arms.
pub fn experiments() -> Vec<Box<dyn Experiment>> {
    let ball = Grain::sphere([0.0; 2], 0.01, 5.0e4);
    let disc = Grain::disc([0.0; 2], 0.01, 2000.0);
    let all = [
        ("ball, half overlap", ball, Arms::HalfOverlap),
        ("disc, half overlap", disc, Arms::HalfOverlap),
        ("ball, contact point", ball, Arms::ContactPoint),
        ("disc, contact point", disc, Arms::ContactPoint),
    ];
    let of =
        |(name, grain, arms)| -> Box<dyn Experiment> { Box::new(Sticking { name, grain, arms }) };
    all.into_iter().map(of).collect()
}

/// m/s².
const GRAVITY: f64 = 9.81;
/// k_s/k_n.
const RATIO: f64 = 0.6;
/// Height of the floor, m.
const FLOOR: f64 = 0.005;
/// Velocity along the floor at the start, m/s; small enough that nothing slides.
const SPEED: f64 = 0.02;
/// k_s Γ dt² = 4 sin²(θ/2) with about 30 steps in a swing.
const ANGLE: f64 = 0.2;
const STEPS: u64 = 2000;

/// What Γ is made of.
struct Rocking {
    /// Slip rate per velocity along the floor, a.
    of_velocity: f64,
    /// Slip rate per spin, R′, m.
    of_spin: f64,
    /// Arm of the force, b, m.
    arm: f64,
}

impl Sticking {
    /// u = 0.1 R.
    fn overlap(&self) -> f64 {
        0.1 * self.grain.radius
    }

    /// The weight rests on it: k_n u = mg.
    fn stiffness(&self) -> f64 {
        self.grain.mass * GRAVITY / self.overlap()
    }

    fn rocking(&self) -> Rocking {
        let (radius, overlap) = (self.grain.radius, self.overlap());
        match self.arms {
            Arms::HalfOverlap => Rocking {
                of_velocity: 2.0 * radius / (2.0 * radius - overlap),
                of_spin: radius,
                arm: radius - 0.5 * overlap,
            },
            Arms::ContactPoint => Rocking {
                of_velocity: 1.0,
                of_spin: radius - overlap,
                arm: radius - overlap,
            },
        }
    }

    /// Γ, 1/kg.
    fn mobility(&self) -> f64 {
        let of = self.rocking();
        of.of_velocity / self.grain.mass + of.arm * of.of_spin / self.grain.inertia
    }

    fn tangential(&self) -> f64 {
        RATIO * self.stiffness()
    }

    fn dt(&self) -> f64 {
        2.0 * (0.5 * ANGLE).sin() / (self.tangential() * self.mobility()).sqrt()
    }

    /// The slip −S/k_s as a swing. At the start the contact is new and given the slip of one step.
    fn swing(&self, step: u64) -> State {
        let rate = self.rocking().of_velocity * SPEED;
        let scheme = Scheme {
            mass: 1.0 / self.mobility(),
            stiffness: self.tangential(),
            dashpot: 0.0,
            clipped: false,
            pull: 0.0,
            alpha: 0.0,
            dt: self.dt(),
        };
        let start = State {
            step: 0,
            overlap: rate * self.dt(),
            approach: rate,
        };
        scheme.in_touch(&start, step)
    }

    fn moments(&self) -> Vec<u64> {
        vec![0, 1, 5, 40, 333, STEPS - 9, STEPS]
    }

    /// Way, velocity, spin and force along the floor after so many steps: σ tells ∫S dt = (σ − σ₀)/Γ, and S
    /// tells ∫σ dt.
    fn expected(&self, step: u64) -> [f64; 4] {
        let (now, start) = (self.swing(step), self.swing(0));
        let (mobility, mass) = (self.mobility(), self.grain.mass);
        let impulse = (now.approach - start.approach) / mobility;
        // What S does not stop: the velocity at which the grain rolls.
        let rolling = SPEED - start.approach / (mobility * mass);
        let time = step as f64 * self.dt();
        [
            time * rolling + (now.overlap - start.overlap) / (mobility * mass),
            SPEED + impulse / mass,
            -self.rocking().arm * impulse / self.grain.inertia,
            -self.tangential() * now.overlap,
        ]
    }

    fn seen(&self, tracks: &[Track], step: u64) -> [f64; 4] {
        let view = view(tracks, 0, step);
        // Along (−n_z, n_x), so to the left.
        let force = view
            .contact()
            .map_or(f64::NAN, |contact| -contact.tangential_force);
        [
            view.position(0)[0],
            view.velocity(0)[0],
            view.spin(0),
            force,
        ]
    }
}

impl Experiment for Sticking {
    fn cases(&self) -> Vec<Case> {
        let height = FLOOR + self.grain.radius - self.overlap();
        let grain = Grain {
            position: [0.0, height],
            ..self.grain
        };
        let modulus = self.stiffness() / grain.radius;
        let law = self.arms.of(build::friction(modulus, RATIO, 1.2));
        let model = Model {
            gravity: [0.0, -GRAVITY],
            walls: vec![build::wall(Axis::Z, FLOOR)],
            ..build::model(law, self.dt())
        };
        let grains = [grain.moving([SPEED, 0.0])];
        vec![build::case(self.name, model, &grains, self.moments())]
    }

    fn lines(&self, tracks: &[Track]) -> Vec<Line> {
        let amplitude = self.swing(0).approach / (self.tangential() * self.mobility()).sqrt();
        let figures = [
            ("way", self.dt() * SPEED * STEPS as f64),
            ("velocity", SPEED),
            ("spin", SPEED / self.grain.radius),
            ("force", self.tangential() * amplitude),
        ];
        let tolerance =
            rounding(STEPS, amplitude, amplitude) + rounding_of_phase(STEPS as f64 * ANGLE);
        let line = |(index, (what, scale)): (usize, &(&str, f64))| {
            let off = |step: u64| {
                let (seen, expected) = (self.seen(tracks, step), self.expected(step));
                ((seen[index] - expected[index]) / scale).abs()
            };
            line(
                format!(
                    "largest deviation of the {what} over its size, {}",
                    self.name
                ),
                "1",
                largest(self.moments().into_iter().map(off)),
                0.0,
                tolerance,
                ROUNDING,
            )
        };
        figures.iter().enumerate().map(line).collect()
    }
}
