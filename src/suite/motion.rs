//! Rungs about motion, all of them with a solution in closed form: flight, oscillators, sliding and
//! rolling, conservation, statics.
//!
//! Most are held against the exact solution of the discrete equations, so that only rounding is left
//! and a fault of 1e-9 shows; some also against the differential equation, where what is left is
//! the order of the method.

mod conservation;
pub(super) mod crowd;
mod disc;
mod flight;
mod oscillator;
mod pile;
mod rolling;
mod springs;
mod stack;
mod swing;

use super::{Line, Rung, Track, line};

/// The rungs.
pub fn rungs() -> Vec<Rung> {
    let mut rungs = flight::rungs();
    rungs.extend(oscillator::rungs());
    rungs.push(stack::rung());
    rungs.extend(springs::rungs());
    rungs.extend(rolling::rungs());
    rungs.extend(conservation::rungs());
    rungs.extend(pile::rungs());
    rungs.push(disc::rung());
    rungs.into_iter().map(strict).collect()
}

/// The same rung with a judge that holds nothing if a case has no track.
pub(super) fn strict(rung: Rung) -> Rung {
    let (count, judge) = (rung.cases.len(), rung.judge);
    let strict = move |tracks: &[Track]| match tracks.len() == count {
        true => judge(tracks),
        false => Vec::new(),
    };
    Rung {
        judge: Box::new(strict),
        ..rung
    }
}

/// Why [`rounding`] is a bound.
const ROUNDING: &str =
    "exact but for rounding: eight roundings a step of half a unit in the last place, added up";

/// What so many steps of rounding may add up to in a number of this size. A step rounds the overlap,
/// the force, the acceleration, the velocity and the position, some of them twice.
fn rounding(steps: u64, size: f64) -> f64 {
    8.0 * 0.5 * f64::EPSILON * steps as f64 * size
}

/// A line that only rounding over so many steps may move, in a number of this size.
fn exact(
    quantity: impl Into<String>,
    unit: &str,
    value: f64,
    expected: f64,
    steps: u64,
    size: f64,
) -> Line {
    line(
        quantity,
        unit,
        value,
        expected,
        rounding(steps, size),
        ROUNDING,
    )
}

/// The value that is furthest from this one; not a number if one of them is none.
pub(super) fn furthest(from: f64, values: impl IntoIterator<Item = f64>) -> f64 {
    let off = |value: f64| (value - from).abs();
    let further = |worst: f64, value: f64| {
        if worst.is_nan() || off(value) <= off(worst) {
            worst
        } else {
            value
        }
    };
    values.into_iter().fold(from, further)
}

/// How a grain moves at a moment; not a number where the track has no such moment or grain.
#[derive(Debug, Clone, Copy)]
struct Seen {
    position: [f64; 2],
    /// Half a step before.
    velocity: [f64; 2],
    spin: f64,
}

fn seen(track: &Track, moment: usize, grain: usize) -> Seen {
    let bodies = track.get(moment).map(|snapshot| &snapshot.bodies);
    let of = |column: fn(&grains::tables::Bodies) -> &[f64]| {
        let value = bodies.and_then(|bodies| column(bodies).get(grain));
        value.copied().unwrap_or(f64::NAN)
    };
    Seen {
        position: [of(|bodies| &bodies.x), of(|bodies| &bodies.z)],
        velocity: [of(|bodies| &bodies.vx), of(|bodies| &bodies.vz)],
        spin: of(|bodies| &bodies.spin),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::suite::climbing;

    /// A rung and a fault that it must not pass with.
    const FAULTS: &[(&str, &str)] = &[
        ("free-fall", "gravity=1e-9"),
        ("free-fall", "time-step=1e-9"),
        ("free-fall", "start=half-step"),
        ("flight-with-local-damping", "damping=1e-9"),
        ("flight-with-local-damping", "gravity=1e-9"),
        ("flight-with-local-damping", "damping=wrong-sign"),
        ("oscillator", "stiffness=1e-9"),
        ("oscillator", "modulus=1e-9"),
        ("oscillator", "density=1e-9"),
        ("oscillator", "gravity=1e-9"),
        ("oscillator", "radius=1e-9"),
        ("oscillator", "time-step=1e-9"),
        ("oscillator", "wall=1e-9"),
        ("oscillator", "start=half-step"),
        ("oscillator-order", "stiffness=1e-5"),
        ("oscillator-order", "time-step=1e-5"),
        ("oscillator-order", "start=half-step"),
        ("oscillator-with-local-damping", "damping=1e-9"),
        ("oscillator-with-local-damping", "stiffness=1e-9"),
        ("oscillator-with-local-damping", "damping=wrong-sign"),
        ("two-stacked-grains", "stiffness=1e-9"),
        ("two-stacked-grains", "density=1e-9"),
        ("two-stacked-grains", "radius=1e-9"),
        ("two-stacked-grains", "wall=1e-9"),
        ("two-stacked-grains", "gravity=1e-6"),
        ("tangential-spring", "shear-stiffness=1e-9"),
        ("tangential-spring", "density=1e-9"),
        ("tangential-spring", "time-step=1e-9"),
        ("tangential-spring", "ratcheting=other"),
        ("turning-spring", "shear-stiffness=1e-9"),
        ("turning-spring", "inertia=1e-9"),
        ("turning-spring", "radius=1e-9"),
        ("turning-spring", "torque-arms=other"),
        ("turning-spring", "ratcheting=other"),
        ("sliding-ball", "friction=1e-9"),
        ("sliding-ball", "inertia=1e-9"),
        ("sliding-ball", "gravity=1e-9"),
        ("sliding-ball", "time-step=1e-9"),
        ("sliding-ball", "torque-arms=other"),
        ("slip-then-roll", "inertia=1e-9"),
        ("slip-then-roll", "torque-arms=other"),
        ("slip-then-roll", "ratcheting=other"),
        ("slip-then-roll", "friction=1e-3"),
        ("rolling-incline", "inertia=1e-9"),
        ("rolling-incline", "gravity=1e-9"),
        ("rolling-incline", "shear-stiffness=1e-9"),
        ("rolling-incline", "torque-arms=other"),
        ("sliding-incline", "friction=1e-9"),
        ("sliding-incline", "inertia=1e-9"),
        ("sliding-incline", "gravity=1e-9"),
        ("momentum", "inertia=1e-6"),
        ("elastic-energy", "stiffness=1e-2"),
        ("elastic-energy", "density=1e-2"),
        ("lost-energy", "damping=wrong-sign"),
        ("column-of-discs", "gravity=1e-9"),
        ("column-of-discs", "density=1e-9"),
        ("column-of-discs", "stiffness=1e-9"),
        ("column-of-discs", "wall=missing"),
        ("pyramid-of-discs", "gravity=1e-9"),
        ("pyramid-of-discs", "density=1e-9"),
        ("pyramid-of-discs", "stiffness=1e-9"),
        ("extensive-stress-of-a-disc", "stiffness=1e-9"),
        ("extensive-stress-of-a-disc", "radius=1e-9"),
        ("extensive-stress-of-a-disc", "wall=1e-9"),
    ];

    #[test]
    fn every_rung_holds() {
        climbing::all_hold(&rungs());
    }

    #[test]
    fn every_rung_notices_its_faults() {
        climbing::all_notice(&rungs(), FAULTS);
    }

    #[test]
    fn a_judge_of_nothing_holds_nothing() {
        climbing::none_holds_of_nothing(&rungs());
    }

    #[test]
    fn the_furthest_value_may_be_none() {
        assert_eq!(furthest(1.0, [1.5, 0.0, 2.0]), 0.0);
        assert!(furthest(1.0, [1.5, f64::NAN, 2.0]).is_nan());
    }
}
