//! A grain that swings in contact all the time: the normal spring and the integrator.

use std::f64::consts::PI;

use super::swing::Swing;
use super::{exact, seen};
use crate::suite::build::{self, Grain};
use crate::suite::line;
use crate::suite::{Group, Rung, Track};
use grains::case::Case;
use grains::model::{Axis, Model};

/// m.
const RADIUS: f64 = 1.0;
/// kg/m³.
const DENSITY: f64 = 1000.0;
/// Overlap in equilibrium, and the largest way from there, m: the grain keeps touching.
const OVERLAP: f64 = 0.125;
const AMPLITUDE: f64 = 0.0625;
/// rad/s.
const OMEGA: f64 = 100.0;
/// m/s².
const GRAVITY: f64 = 9.81;
/// Local damping.
const ALPHA: f64 = 0.3;

/// The rungs.
pub fn rungs() -> Vec<Rung> {
    vec![undamped(), order(), damped()]
}

/// Between two walls: ω² = 2k/m, k = ER.
fn between_walls(name: &str, dt: f64, alpha: f64, velocity: f64, moments: Vec<u64>) -> Case {
    let width = 2.0 * (RADIUS - OVERLAP);
    let start = [0.5 * width + AMPLITUDE, 0.0];
    let grain = Grain::disc(start, RADIUS, DENSITY).moving([velocity, 0.0]);
    let stiffness = 0.5 * grain.mass * OMEGA * OMEGA;
    let model = Model {
        alpha,
        walls: vec![build::wall(Axis::X, 0.0), build::wall(Axis::X, width)],
        ..build::model(build::springs(stiffness / RADIUS), dt)
    };
    build::case(name, model, &[grain], moments)
}

/// Way from the middle between the walls.
fn off_middle(track: &Track, moment: usize) -> f64 {
    seen(track, moment, 0).position[0] - (RADIUS - OVERLAP)
}

/// On the floor under gravity: k = mg/u in equilibrium, so ω² = g/u.
fn on_the_floor(dt: f64, moments: Vec<u64>) -> Case {
    let start = [0.0, RADIUS - OVERLAP + AMPLITUDE];
    let grain = Grain::disc(start, RADIUS, DENSITY);
    let stiffness = grain.mass * GRAVITY / OVERLAP;
    let model = Model {
        gravity: [0.0, -GRAVITY],
        walls: vec![build::wall(Axis::Z, 0.0)],
        ..build::model(build::springs(stiffness / RADIUS), dt)
    };
    build::case("on the floor", model, &[grain], moments)
}

fn undamped() -> Rung {
    const MOMENTS: [u64; 3] = [1, 137, 600];
    let omegas = [OMEGA, (GRAVITY / OVERLAP).sqrt()];
    let steps = omegas.map(|omega| 0.1 / omega);
    let cases = vec![
        between_walls("between walls", steps[0], 0.0, 0.0, MOMENTS.to_vec()),
        on_the_floor(steps[1], MOMENTS.to_vec()),
    ];
    let judge = move |tracks: &[Track]| {
        let mut lines = Vec::new();
        for (axis, (case, track)) in ["between walls", "on the floor"]
            .iter()
            .zip(tracks)
            .enumerate()
        {
            let swing = Swing::new(omegas[axis], steps[axis], AMPLITUDE, 0.0);
            for (moment, n) in MOMENTS.into_iter().enumerate() {
                let found = seen(track, moment, 0);
                let what = format!("way from equilibrium {case} after {n} steps");
                let place = found.position[axis] - (RADIUS - OVERLAP);
                lines.push(exact(what, "m", place, swing.place(n), n, RADIUS));
                let what = format!("velocity {case} after {n} steps");
                let speed = found.velocity[axis];
                let size = omegas[axis] * RADIUS;
                lines.push(exact(what, "m/s", speed, swing.velocity(n), n, size));
            }
        }
        lines
    };
    Rung {
        name: "oscillator",
        title: "A grain that swings in contact follows the leapfrog solution, sin(θ/2) = ½ω dt",
        group: Group::Exact,
        cases,
        judge: Box::new(judge),
    }
}

/// Against y = A cos ωt after 1¼ periods, where an error of the phase is all that shows. The phase is
/// behind by ωt·(ω dt)²/24 (θ/(ω dt) − 1 to leading order); the next terms are (ω dt)² smaller.
fn order() -> Rung {
    const STEPS: [u64; 4] = [40, 80, 160, 320];
    let phase = 2.5 * PI;
    let turn = STEPS.map(|n| phase / n as f64);
    let case = |(n, turn): (u64, f64)| {
        // At rest at the start: −½dt·a half a step before.
        let velocity = 0.5 * turn * OMEGA * AMPLITUDE;
        let name = format!("{n} steps for 1¼ periods");
        between_walls(&name, turn / OMEGA, 0.0, velocity, vec![n])
    };
    let cases = STEPS.into_iter().zip(turn).map(case).collect();
    let judge = move |tracks: &[Track]| {
        let errors: Vec<f64> = tracks
            .iter()
            .map(|track| off_middle(track, 0) - AMPLITUDE * phase.cos())
            .collect();
        let mut lines = Vec::new();
        for (pair, steps) in errors.windows(2).zip(STEPS.windows(2)) {
            let what = format!("order from {} and {} steps", steps[0], steps[1]);
            let turn = phase / steps[0] as f64;
            lines.push(line(
                what,
                "1",
                (pair[0] / pair[1]).log2(),
                2.0,
                turn * turn,
                "the next term of the error is smaller by (ω dt)², of the coarser step",
            ));
        }
        let finest = turn[3];
        let leading = -AMPLITUDE * phase * finest * finest / 24.0;
        lines.push(line(
            "error of 320 steps over its leading term −A ωt (ω dt)²/24",
            "1",
            errors.last().map_or(f64::NAN, |error| error / leading),
            1.0,
            finest * finest,
            "the next term of the error is smaller by (ω dt)²",
        ));
        lines
    };
    Rung {
        name: "oscillator-order",
        title: "The oscillator converges to A cos ωt with the second order in dt",
        group: Group::Exact,
        cases,
        judge: Box::new(judge),
    }
}

/// Under local damping: ω² is (1−α) of itself on the way in and (1+α) on the way out.
struct DampedSwing {
    /// The step at which each quarter starts, and how it goes on from there.
    quarters: Vec<(u64, Swing)>,
}

impl DampedSwing {
    /// The quarters of so many steps from [`AMPLITUDE`] with velocity zero half a step before.
    fn new(dt: f64, steps: u64) -> Self {
        let mut quarters: Vec<(u64, Swing)> = Vec::new();
        let (mut from, mut place, mut velocity) = (0, AMPLITUDE, 0.0);
        while from <= steps {
            let inward = Self::inward(place, velocity, dt);
            let factor = if inward { 1.0 - ALPHA } else { 1.0 + ALPHA };
            let swing = Swing::new(OMEGA * factor.sqrt(), dt, place, velocity);
            let same = |n: &u64| Self::inward(swing.place(*n), swing.velocity(*n), dt) == inward;
            let length = (1..).take_while(same).count() as u64 + 1;
            quarters.push((from, swing));
            (place, velocity) = (swing.place(length), swing.velocity(length));
            from += length;
        }
        DampedSwing { quarters }
    }

    /// The sign rule: whether a·(v + ½dt a) > 0 with a = −ω²y.
    fn inward(place: f64, velocity: f64, dt: f64) -> bool {
        let acceleration = -OMEGA * OMEGA * place;
        acceleration * (velocity + 0.5 * dt * acceleration) > 0.0
    }

    /// Place and velocity after so many steps.
    fn after(&self, steps: u64) -> [f64; 2] {
        let quarter = self.quarters.iter().rev().find(|(from, _)| *from <= steps);
        quarter.map_or([f64::NAN; 2], |(from, swing)| {
            [swing.place(steps - from), swing.velocity(steps - from)]
        })
    }

    /// The first steps on the way back in, of every second quarter: the turning points.
    fn turns(&self) -> Vec<u64> {
        let inward = self.quarters.iter().skip(2).step_by(2);
        inward.map(|(from, _)| *from).collect()
    }
}

fn damped() -> Rung {
    const STEPS: u64 = 4000;
    let turn = 0.005;
    let dt = turn / OMEGA;
    let swing = DampedSwing::new(dt, STEPS);
    let turns: Vec<u64> = swing.turns().into_iter().filter(|n| *n < STEPS).collect();
    let moments: Vec<u64> = turns.iter().copied().chain([STEPS]).collect();
    let case = between_walls(
        "local damping between walls",
        dt,
        ALPHA,
        0.0,
        moments.clone(),
    );
    let judge = move |tracks: &[Track]| {
        let track = &tracks[0];
        let last = moments.len() - 1;
        let [place, velocity] = swing.after(STEPS);
        let found = off_middle(track, last);
        let speed = seen(track, last, 0).velocity[0];
        let what = |what: &str| format!("{what} after {STEPS} steps");
        let mut lines = vec![
            exact(
                what("way from equilibrium"),
                "m",
                found,
                place,
                STEPS,
                RADIUS,
            ),
            exact(
                what("velocity"),
                "m/s",
                speed,
                velocity,
                STEPS,
                OMEGA * RADIUS,
            ),
        ];
        let each = ((1.0 - ALPHA) / (1.0 + ALPHA)).sqrt();
        for moment in 0..turns.len() {
            let half_periods = (moment + 1) as i32;
            lines.push(line(
                format!("amplitude after {half_periods} half periods over that at the start"),
                "1",
                off_middle(track, moment).abs() / AMPLITUDE,
                each.powi(half_periods),
                f64::from(half_periods) * turn * turn,
                "√((1−α)/(1+α)) a half period; the signs change on a step and not in between, \
                 which costs (ω dt)² of the amplitude each time",
            ));
        }
        lines
    };
    Rung {
        name: "oscillator-with-local-damping",
        title: "Local damping takes √((1−α)/(1+α)) of the amplitude in half a period",
        group: Group::Exact,
        cases: vec![case],
        judge: Box::new(judge),
    }
}
