//! Rungs on the closed form of the scheme itself: only rounding is allowed for, so they feel the smallest
//! faults. Steps are long on purpose; the scheme is solved, not approximated.

use super::continuum::dashpot;
use super::experiment::{Experiment, rung, view};
use super::falling;
use super::first_slip;
use super::head_on::{HeadOn, Partner};
use super::leapfrog::{deviations, rounding};
use super::sliding;
use super::squeezed;
use super::sticking;
use crate::suite::build::Grain;
use crate::suite::{Line, Rung, Track};
use grains::case::Case;
use grains::scene::{Tension, Viscosity};

/// The rungs.
pub fn rungs() -> Vec<Rung> {
    let mut springs = collisions(|_| (0.0, Viscosity::None));
    springs.push(Box::new(squeezed::Squeezed));
    vec![
        rung(
            "leapfrog-spring",
            "Springs swing as the leapfrog recurrence, to rounding",
            springs,
        ),
        rung(
            "leapfrog-dashpot",
            "A spring and a dashpot that does not pull follow the damped recurrence, to rounding",
            collisions(|plain| (0.0, damped(plain, Tension::Clipped))),
        ),
        rung(
            "leapfrog-dashpot-unclipped",
            "A spring and a dashpot that may pull follow the damped recurrence, to rounding",
            collisions(|plain| (0.0, damped(plain, Tension::Unclipped))),
        ),
        rung(
            "leapfrog-local-damping",
            "Springs with local damping follow a recurrence on the way in and one on the way out, to rounding",
            collisions(|_| (0.3, Viscosity::None)),
        ),
        rung(
            "leapfrog-drop",
            "Gravity, spring, dashpot and local damping together, over several bounces, to rounding",
            falling::experiments(),
        ),
        rung(
            "leapfrog-sliding",
            "Sliding contacts push along by tan φ of what they push apart, to rounding",
            sliding::experiments(),
        ),
        rung(
            "leapfrog-sticking",
            "A tangential spring below Coulomb's limit swings as the leapfrog recurrence, to rounding",
            sticking::experiments(),
        ),
        rung(
            "first-slip",
            "A new contact is given the slip of the whole step in which it was made",
            first_slip::of_whole_steps(),
        ),
        rung(
            "first-slip-since-touch",
            "A new contact is given the slip since the surfaces met",
            first_slip::since_touch(),
        ),
    ]
}

/// A collision at some steps of the contact and after it, against the chain of recurrences.
struct Exact(HeadOn);

/// ζ = 0.3, for which a clipped and a pulling dashpot part well apart.
fn damped(plain: &HeadOn, tension: Tension) -> Viscosity {
    Viscosity::Dashpot {
        c_n: dashpot(0.3, plain.mass(), plain.stiffness),
        tension,
    }
}

/// Soft unequal grains, and one of them at a wall; the law is given by α and the dashpot.
fn collisions(law: fn(&HeadOn) -> (f64, Viscosity)) -> Vec<Box<dyn Experiment>> {
    let grain = Grain::disc([0.0; 2], 0.01, 2000.0);
    let other = Grain::sphere([0.0; 2], 0.015, 60_000.0);
    let all = [("wall", Partner::Wall), ("pair", Partner::Grain(other))];
    let of = |(name, partner): (&str, Partner)| -> Box<dyn Experiment> {
        let mut plain = HeadOn {
            name: name.to_owned(),
            grain,
            partner,
            stiffness: 3.0e5,
            viscosity: Viscosity::None,
            alpha: 0.0,
            approach: 1.0,
            steps: 100.0,
            lead: 3.3,
        };
        // As deep as a third of the radius, so that rounding is small beside it.
        plain.approach = 0.33 * grain.radius * plain.frequency();
        let (alpha, viscosity) = law(&plain);
        let head_on = HeadOn {
            alpha,
            viscosity,
            ..plain
        };
        Box::new(Exact(head_on))
    };
    all.into_iter().map(of).collect()
}

impl Exact {
    fn moments(&self) -> Vec<u64> {
        let touch = self.0.lead;
        let at = |share: f64| (touch + share * self.0.steps).round() as u64;
        vec![0, 1, at(0.02), at(0.25), at(0.5), at(0.75), at(1.6)]
    }
}

impl Experiment for Exact {
    fn cases(&self) -> Vec<Case> {
        vec![self.0.case(self.moments())]
    }

    fn lines(&self, tracks: &[Track]) -> Vec<Line> {
        let of = &self.0;
        let reach = 3.0 * of.grain.radius;
        let seen = self
            .moments()
            .into_iter()
            .map(|step| of.state(view(tracks, 0, step), step));
        let expected = of.scheme().track(of.start(), &self.moments());
        let amplitude = of.approach / of.frequency();
        let steps = expected.last().map_or(0, |state| state.step);
        let tolerance = rounding(steps, reach, amplitude);
        deviations(
            &of.name,
            seen.collect(),
            &expected,
            [amplitude, of.approach],
            tolerance,
        )
    }
}
