//! Flight: gravity and local damping alone.

use super::{exact, seen};
use crate::suite::build::{self, Grain};
use crate::suite::{Group, Line, Rung, Track};
use grains::model::Model;

/// s.
const DT: f64 = 1.0e-3;
/// Steps to the moments that are looked at.
const MOMENTS: [u64; 2] = [100, 1000];
/// Standard gravity's two first decimals, m/s².
const GRAVITY: f64 = 9.81;
/// Local damping.
const ALPHA: f64 = 0.3;
/// m/s.
const THROWN: f64 = 2.0;

/// The rungs.
pub fn rungs() -> Vec<Rung> {
    vec![free_fall(), damped_flight()]
}

fn model(gravity: [f64; 2], alpha: f64) -> Model {
    Model {
        gravity,
        alpha,
        ..build::model(build::springs(1.0e6), DT)
    }
}

/// A grain that starts at rest and one that is thrown, without damping, gravity having both components.
fn free_fall() -> Rung {
    let gravity = [0.6, -GRAVITY];
    let grains = [
        Grain::disc([0.0, 0.0], 0.1, 1000.0),
        Grain::disc([2.0, 1.0], 0.1, 1000.0).moving([3.0, 5.0]),
    ];
    let case = build::case("free fall", model(gravity, 0.0), &grains, MOMENTS.to_vec());
    let judge = move |tracks: &[Track]| {
        let mut lines = Vec::new();
        for (id, (grain, kind)) in grains.iter().zip(["dropped", "thrown"]).enumerate() {
            for (moment, steps) in MOMENTS.into_iter().enumerate() {
                let found = seen(&tracks[0], moment, id);
                for (axis, name) in ["x", "z"].into_iter().enumerate() {
                    let start = [grain.position[axis], grain.velocity[axis]];
                    let expected = flown(start, gravity[axis], steps);
                    let what = format!("{name} of the {kind} grain after {steps} steps");
                    let size = start[0].abs() + reach(start[1], gravity[axis], steps);
                    let value = found.position[axis];
                    lines.push(exact(what, "m", value, expected[0], steps, size));
                }
            }
        }
        lines
    };
    Rung {
        name: "free-fall",
        title: "Free fall with velocities at half steps: x_n = x_0 + v_0 n dt + ½g dt² n(n+1)",
        group: Group::Exact,
        cases: vec![case],
        judge: Box::new(judge),
    }
}

/// Grains dropped, thrown up and drifting sideways under local damping.
fn damped_flight() -> Rung {
    let grains = [
        Grain::disc([0.0, 0.0], 0.1, 1000.0),
        Grain::disc([2.0, 0.0], 0.1, 1000.0).moving([0.0, THROWN]),
        Grain::disc([4.0, 0.0], 0.1, 1000.0).moving([1.5, 0.0]),
    ];
    let model = model([0.0, -GRAVITY], ALPHA);
    let case = build::case(
        "flight with local damping",
        model,
        &grains,
        MOMENTS.to_vec(),
    );
    let judge = move |tracks: &[Track]| {
        let mut lines: Vec<Line> = Vec::new();
        for (moment, steps) in MOMENTS.into_iter().enumerate() {
            let of = |id: usize| seen(&tracks[0], moment, id);
            let add = |lines: &mut Vec<Line>, what: &str, value: f64, expected: f64, size: f64| {
                let what = format!("{what} after {steps} steps");
                lines.push(exact(what, "m", value, expected, steps, size));
            };
            let fallen = flown([0.0; 2], -GRAVITY * (1.0 - ALPHA), steps)[0];
            let dropped = of(0).position[1];
            add(
                &mut lines,
                "z of the dropped grain, which falls at g(1−α)",
                dropped,
                fallen,
                fallen.abs(),
            );
            let risen = thrown_up(steps);
            let size = reach(THROWN, GRAVITY * (1.0 + ALPHA), steps);
            let thrown = of(1).position[1];
            let what = "z of the thrown grain, which rises at g(1+α) and falls at g(1−α)";
            add(&mut lines, what, thrown, risen, size);
            let drifted = flown([4.0, 1.5], 0.0, steps)[0];
            let what = "x of the drifting grain, which nothing slows down";
            add(&mut lines, what, of(2).position[0], drifted, drifted);
        }
        lines
    };
    Rung {
        name: "flight-with-local-damping",
        title: "Under local damping a grain falls at g(1−α) and rises at g(1+α)",
        group: Group::Exact,
        cases: vec![case],
        judge: Box::new(judge),
    }
}

/// Place and velocity after so many steps at this acceleration.
fn flown([place, velocity]: [f64; 2], acceleration: f64, steps: u64) -> [f64; 2] {
    let n = steps as f64;
    let way = velocity * n * DT + 0.5 * acceleration * DT * DT * n * (n + 1.0);
    [place + way, velocity + n * DT * acceleration]
}

/// A bound of the way at this speed and acceleration.
fn reach(speed: f64, acceleration: f64, steps: u64) -> f64 {
    let time = steps as f64 * DT;
    (speed.abs() + acceleration.abs() * time) * time
}

/// Height of the thrown grain. It rises as long as the velocity on the step, v − ½g dt, is positive.
fn thrown_up(steps: u64) -> f64 {
    let up = GRAVITY * (1.0 + ALPHA);
    let rising = (THROWN - 0.5 * GRAVITY * DT) / (up * DT);
    let rising = (rising.ceil() as u64).min(steps);
    let top = flown([0.0, THROWN], -up, rising);
    flown(top, -GRAVITY * (1.0 - ALPHA), steps - rising)[0]
}
