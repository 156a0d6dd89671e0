//! A grain that slides on a wall all through a collision, as the scheme has it: in every step the tangential
//! force is tan φ of the normal one, so the changes of velocity are, whatever the step.

use super::experiment::{Experiment, view};
use super::leapfrog::rounding;
use super::slide::{Arms, Slide};
use crate::suite::build::Grain;
use crate::suite::line;
use crate::suite::{Line, Track};
use grains::case::Case;

struct Sliding(Slide);

/// A ball and a disc, a dashpot, and both kinds of arms.
pub fn experiments() -> Vec<Box<dyn Experiment>> {
    let ball = Grain::sphere([0.0; 2], 0.01, 5.0e4);
    let disc = Grain::disc([0.0; 2], 0.01, 2000.0);
    let all = [
        ("ball, half overlap", ball, Arms::HalfOverlap, 0.0),
        ("disc, contact point", disc, Arms::ContactPoint, 0.0),
        ("disc, dashpot", disc, Arms::ContactPoint, 0.2),
    ];
    let of = |(name, grain, arms, damping_ratio): (&str, Grain, Arms, f64)| -> Box<dyn Experiment> {
        let mut slide = Slide {
            name: name.to_owned(),
            grain,
            stiffness: 3.0e5,
            ratio: 0.7,
            tan_phi: 0.4,
            damping_ratio,
            arms,
            steps: 100.0,
        };
        let speed = 0.2 * grain.radius * slide.frequency();
        slide.grain = grain
            .moving([0.0, -speed])
            .spinning(-8.0 * speed / grain.radius);
        Box::new(Sliding(slide))
    };
    all.into_iter().map(of).collect()
}

impl Sliding {
    /// ∫N dt and ∫u N dt as the scheme has them: sums over its steps.
    fn sums(&self) -> [f64; 2] {
        let of = &self.0;
        let scheme = of.scheme();
        let steps: Vec<u64> = (0..of.end()).collect();
        let states = scheme.track(of.start(), &steps);
        let normal = |state| of.dt() * scheme.force(state);
        [
            states.iter().map(normal).sum(),
            states
                .iter()
                .map(|state| state.overlap * normal(state))
                .sum(),
        ]
    }
}

impl Experiment for Sliding {
    fn cases(&self) -> Vec<Case> {
        vec![self.0.case(vec![0, self.0.end()])]
    }

    fn lines(&self, tracks: &[Track]) -> Vec<Line> {
        let of = &self.0;
        let start = view(tracks, 0, 0).velocity(0);
        let end = view(tracks, 0, of.end()).velocity(0);
        let [_, spin] = of.seen(tracks);
        let [impulse, overlap_impulse] = self.sums();
        let [_, of_spin] = of.sliding(impulse, overlap_impulse);
        let reach = 1.5 * of.grain.radius;
        let of_all = rounding(of.end(), reach, of.approach() / of.frequency());
        vec![
            line(
                format!(
                    "change of velocity along the wall over that across, {}",
                    of.name
                ),
                "1",
                (end[0] - start[0]).abs() / (end[1] - start[1]),
                of.tan_phi,
                of.tan_phi * 2.0 * f64::EPSILON * of.end() as f64,
                "true of every step that slides; rounding of two velocities in every step",
            ),
            line(
                format!("velocity across after the impact, {}", of.name),
                "m/s",
                end[1],
                impulse / of.grain.mass - of.approach(),
                of.approach() * of_all,
                super::leapfrog::ROUNDING,
            ),
            line(
                format!("spin, {}", of.name),
                "rad/s",
                spin,
                of_spin,
                of.grain.spin.abs() * of_all,
                super::leapfrog::ROUNDING,
            ),
        ]
    }
}
