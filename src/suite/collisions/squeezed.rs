//! A grain squeezed between two walls: always in touch with both, so a fault in stiffness, mass, radius
//! or step grows from swing to swing.

use super::experiment::{Experiment, view};
use super::leapfrog::{Scheme, State, deviations, rounding, rounding_of_phase};
use crate::suite::build::{self, Grain};
use crate::suite::{Line, Track};
use grains::case::Case;
use grains::model::Axis;

/// Both springs push to the middle: m ü = −2k u with u the distance to the left of it.
pub struct Squeezed;

/// k of one spring, N/m.
const STIFFNESS: f64 = 1.0e5;
/// Place of the left wall, m.
const LEFT: f64 = 0.004;
/// Overlap with both walls in the middle, m.
const SQUEEZE: f64 = 0.002;
/// At the start, m; less than the squeeze.
const AMPLITUDE: f64 = 0.0015;
/// θ of the recurrence, rad: about twenty steps in a swing.
const ANGLE: f64 = 0.3;
const STEPS: u64 = 5000;

impl Squeezed {
    fn grain(&self) -> Grain {
        Grain::disc([self.middle() - AMPLITUDE, 0.0], 0.01, 2000.0)
    }

    fn middle(&self) -> f64 {
        LEFT + 0.01 - SQUEEZE
    }

    fn dt(&self) -> f64 {
        // sin(θ/2) = ½ω dt.
        2.0 * (0.5 * ANGLE).sin() * (self.grain().mass / (2.0 * STIFFNESS)).sqrt()
    }

    fn moments(&self) -> Vec<u64> {
        vec![0, 1, 10, 100, 1000, STEPS - 7, STEPS]
    }

    /// Seen as one spring of 2k that the grain presses on when it is left of the middle; it never lets go.
    fn swing(&self) -> (State, Scheme) {
        let start = State {
            step: 0,
            overlap: AMPLITUDE,
            approach: 0.0,
        };
        let scheme = Scheme {
            mass: self.grain().mass,
            stiffness: 2.0 * STIFFNESS,
            dashpot: 0.0,
            clipped: false,
            pull: 0.0,
            alpha: 0.0,
            dt: self.dt(),
        };
        (start, scheme)
    }
}

impl Experiment for Squeezed {
    fn cases(&self) -> Vec<Case> {
        let grain = self.grain();
        let mut model = build::model(build::springs(STIFFNESS / grain.radius), self.dt());
        let right = LEFT + 2.0 * (grain.radius - SQUEEZE);
        model.walls = vec![build::wall(Axis::X, LEFT), build::wall(Axis::X, right)];
        vec![build::case(
            "squeezed between two walls",
            model,
            &[grain],
            self.moments(),
        )]
    }

    fn lines(&self, tracks: &[Track]) -> Vec<Line> {
        let (start, scheme) = self.swing();
        let expected: Vec<State> = self
            .moments()
            .iter()
            .map(|step| scheme.in_touch(&start, *step))
            .collect();
        let seen = self.moments().into_iter().map(|step| {
            let view = view(tracks, 0, step);
            State {
                step,
                overlap: self.middle() - view.position(0)[0],
                approach: -view.velocity(0)[0],
            }
        });
        let speed = AMPLITUDE * (scheme.stiffness / scheme.mass).sqrt();
        let tolerance =
            rounding(STEPS, self.middle(), AMPLITUDE) + rounding_of_phase(STEPS as f64 * ANGLE);
        deviations(
            "squeezed",
            seen.collect(),
            &expected,
            [AMPLITUDE, speed],
            tolerance,
        )
    }
}
