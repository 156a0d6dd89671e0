//! The order of convergence on cases with exact solutions: what the time step does where nothing is chaotic.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::suite::build::{self, Grain};
use evidence::{Interval, regression};
use grains::model::{Axis, Model};
use grains::native::{self, NativeError};
use grains::task::Case;

/// dt over √(m/k) of the grain: from a twentieth to beyond what beds are run with.
const STEPS: [f64; 7] = [0.0125, 0.025, 0.05, 0.1, 0.2, 0.45, 0.9];

/// m.
const RADIUS: f64 = 1.0;
/// kg/m³.
const DENSITY: f64 = 1000.0;
/// m: overlap of the swing in equilibrium, and its amplitude.
const OVERLAP: f64 = 0.125;
const AMPLITUDE: f64 = 0.0625;
/// √(k/m) of one contact, rad/s.
const FREQUENCY: f64 = 100.0;

const PLACES: f64 = 8.0;

/// A case at several steps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Convergence {
    pub title: String,
    /// What the error is over.
    pub error_of: String,
    /// dt over √(m/k), and the error.
    pub points: Vec<(f64, f64)>,
    /// Slope of log error over log dt up to the paper's step, with its 95 % interval.
    pub order: Option<Interval>,
    pub expected: f64,
}

pub fn all() -> Result<Vec<Convergence>, NativeError> {
    Ok(vec![swing()?, bounce()?, damped_swing()?])
}

/// The slope over the steps that the scene's is one of.
fn converged(
    title: &str,
    error_of: &str,
    expected: f64,
    error: impl Fn(f64) -> Result<f64, NativeError>,
) -> Result<Convergence, NativeError> {
    let mut points = Vec::new();
    for step in STEPS {
        points.push((step, error(step / FREQUENCY)?));
    }
    let fitted: Vec<(f64, f64)> = points
        .iter()
        .filter(|(step, error)| *step <= 0.45 && *error > 0.0)
        .map(|(step, error)| (step.ln(), error.ln()))
        .collect();
    Ok(Convergence {
        title: title.to_owned(),
        error_of: error_of.to_owned(),
        order: regression::slope(&fitted),
        points,
        expected,
    })
}

/// x after so many steps of a grain between two walls that both touch it all the time, m off the middle.
fn between_walls(dt: f64, alpha: f64, start: [f64; 2], steps: u64) -> Result<f64, NativeError> {
    let width = 2.0 * (RADIUS - OVERLAP);
    let grain = Grain::disc([0.5 * width + start[0], 0.0], RADIUS, DENSITY).moving([start[1], 0.0]);
    let model = Model {
        alpha,
        walls: vec![build::wall(Axis::X, 0.0), build::wall(Axis::X, width)],
        ..build::model(build::springs(modulus(grain.mass)), dt)
    };
    let case = build::case("between walls", model, &[grain], vec![steps]);
    Ok(last(&case)?[0] - 0.5 * width)
}

fn modulus(mass: f64) -> f64 {
    mass * FREQUENCY * FREQUENCY / RADIUS
}

fn last(case: &Case) -> Result<[f64; 2], NativeError> {
    let seen = native::run_case(case, None)?;
    let bodies = seen.last().map(|snapshot| &snapshot.bodies);
    Ok(bodies.map_or([f64::NAN; 2], |bodies| [bodies.x[0], bodies.z[0]]))
}

/// The root of the mean square of errors that depend on where something falls between two steps, over so many places from 0 on.
fn averaged(error: impl Fn(f64) -> Result<f64, NativeError>) -> Result<f64, NativeError> {
    let mut squares = 0.0;
    for place in 0..PLACES as u32 {
        squares += error(place.into())?.powi(2);
    }
    Ok((squares / PLACES).sqrt())
}

/// The number of steps that is nearest to this time, and the time that they take.
fn whole_steps(time: f64, dt: f64) -> (u64, f64) {
    let steps = (time / dt).round().max(1.0);
    (steps as u64, steps * dt)
}

/// x = A cos ωt, ω² = 2k/m, after ten and a quarter periods, where the error of the phase shows.
fn swing() -> Result<Convergence, NativeError> {
    let omega = FREQUENCY * 2f64.sqrt();
    converged(
        "a grain swings between two walls, ten periods and a quarter",
        "place, over the amplitude",
        2.0,
        |dt| {
            let (steps, time) = whole_steps(10.25 * 2.0 * PI / omega, dt);
            // At rest at the start, so half a step before it moves outwards.
            let before = 0.5 * dt * omega * omega * AMPLITUDE;
            let found = between_walls(dt, 0.0, [AMPLITUDE, before], steps)?;
            Ok((found / AMPLITUDE - (omega * time).cos()).abs())
        },
    )
}

/// A grain hits a wall at 1 m/s and flies back: the end of the contact falls between two steps. The error is
/// averaged over eight places of the touch within a step, as its size depends on the place.
fn bounce() -> Result<Convergence, NativeError> {
    converged(
        "a grain hits a wall without gravity and flies back",
        "speed after the rebound, over the speed before",
        2.0,
        |dt| {
            averaged(|place| {
                let gap = 1.0e-6 + dt * place / PLACES;
                let grain = Grain::disc([RADIUS + gap, 0.0], RADIUS, DENSITY).moving([-1.0, 0.0]);
                let model = Model {
                    walls: vec![build::wall(Axis::X, 0.0)],
                    ..build::model(build::springs(modulus(grain.mass)), dt)
                };
                let (steps, _) = whole_steps(2.0 * PI / FREQUENCY, dt);
                let case = build::case("bounce", model, &[grain], vec![steps]);
                let seen = native::run_case(&case, None)?;
                Ok(seen.last().map_or(f64::NAN, |last| last.bodies.vx[0]) - 1.0)
            })
        },
    )
}

/// With local damping a swing speeds up with (1−α)k and slows down with (1+α)k, so a quarter period takes
/// π/2/(ω√(1∓α)) and each half swing ends at √((1−α)/(1+α)) of where it began. Read near the sixth turn, where
/// the phase does not show; the error depends on where the steps fall, so it is averaged over eight steps about dt. The sign
/// of the damping comes half a step late, but always where either force or velocity is next to nothing: order 2.
fn damped_swing() -> Result<Convergence, NativeError> {
    const ALPHA: f64 = 0.2;
    const HALVES: i32 = 6;
    let omega = FREQUENCY * 2f64.sqrt();
    let quarters = [1.0 - ALPHA, 1.0 + ALPHA].map(|factor: f64| 0.5 * PI / (omega * factor.sqrt()));
    let half = quarters[0] + quarters[1];
    let turn = AMPLITUDE * ((1.0 - ALPHA) / (1.0 + ALPHA)).sqrt().powi(HALVES);
    converged(
        "the same swing with local damping 0.2, six half periods",
        "place, over the place where it turns",
        2.0,
        |middle| {
            averaged(|place| {
                let dt = middle * (0.93 + 0.02 * place);
                let (steps, time) = whole_steps(f64::from(HALVES) * half, dt);
                let before = 0.5 * dt * omega * omega * (1.0 - ALPHA) * AMPLITUDE;
                let found = between_walls(dt, ALPHA, [AMPLITUDE, before], steps)?;
                let off = time - f64::from(HALVES) * half;
                let sign = if off > 0.0 { -1.0 } else { 1.0 };
                let expected = turn * (omega * (1.0 + sign * ALPHA).sqrt() * off).cos();
                Ok((found - expected) / turn)
            })
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_what_theory_says() {
        for case in all().expect("cases run") {
            let order = case.order.expect("seven steps");
            assert!(
                (order.estimate - case.expected).abs() < 0.35,
                "{}: {order:?} {:?}",
                case.title,
                case.points
            );
        }
    }
}
