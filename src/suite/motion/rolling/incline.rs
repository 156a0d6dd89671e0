//! A ball on an incline: the plane stays level and gravity is tilted.

use std::f64::consts::PI;

use super::super::swing::Swing;
use super::super::{exact, seen};
use super::{Ball, SHAPES};
use crate::suite::build;
use crate::suite::line;
use crate::suite::{Group, Line, Rung, Track};
use grains::case::Case;
use grains::model::{Axis, Model};

/// m.
const RADIUS: f64 = 0.1;
/// kg.
const MASS: f64 = 1.0;
/// m/s².
const GRAVITY: f64 = 9.8;

/// A ball on a plane of this slope (rad), at the overlap R/`stiff`.
struct Incline {
    shape: &'static str,
    ball: Ball,
    /// Gravity along the plane and against it, m/s².
    along: f64,
    against: f64,
    friction: f64,
    ratio: f64,
    dt: f64,
}

impl Incline {
    fn new((shape, share): (&'static str, f64), slope: f64, friction: f64, stiff: f64) -> Self {
        let (along, against) = (GRAVITY * slope.sin(), GRAVITY * slope.cos());
        let weight = MASS * against;
        let stiffness = weight * stiff / RADIUS;
        let ball = Ball::new(0.0, [RADIUS, MASS, share], weight, stiffness);
        let ratio = 2.0 / 7.0;
        Incline {
            shape,
            ball,
            along,
            against,
            friction,
            ratio,
            dt: 2.0 * (PI / PERIOD as f64).sin() / ball.stick_omega(ratio),
        }
    }

    fn case(&self, moments: &[u64]) -> Case {
        let model = Model {
            gravity: [self.along, -self.against],
            walls: vec![build::wall(Axis::Z, 0.0)],
            ..build::model(self.ball.law(self.ratio, self.friction), self.dt)
        };
        let grains = [self.ball.grain];
        build::case(self.shape, model, &grains, moments.to_vec())
    }

    /// v and ω of rolling after so many steps from rest. A step adds mr g sinβ dt to mrv + Iω, whatever
    /// friction does, and the tangential spring swings about the force that rolling needs:
    /// its way σ, slack at the start and one step before, is that of a [`Swing`] about σ* = a g sinβ/ω².
    fn rolled(&self, steps: u64) -> [f64; 2] {
        let Ball { arm, grain, .. } = self.ball;
        let omega = self.ball.stick_omega(self.ratio);
        let factor = grain.radius / arm;
        let offset = factor * self.along / (omega * omega);
        let slip = Swing::new(omega, self.dt, -offset, 0.0).velocity(steps) / factor;
        // v − rω and v + Iω/(mr).
        let momentum = steps as f64 * self.dt * self.along;
        let lightness = self.ball.lightness();
        let speed = (momentum * lightness + slip) / (1.0 + lightness);
        [speed, (speed - slip) / arm]
    }
}

/// Steps in a period of the tangential spring.
const PERIOD: u64 = 80;

/// MercuryDPM's InclinedPlaneUnitTest: a = g sinβ/(1 + I/(mR²)), 5/7 g sinβ for a sphere at 15°.
pub fn rolling() -> Rung {
    const MOMENTS: [u64; 2] = [4000, 4000 + PERIOD / 2];
    let all = SHAPES.map(|shape| Incline::new(shape, PI / 12.0, 0.5, 1000.0));
    let cases = all.iter().map(|incline| incline.case(&MOMENTS)).collect();
    let judge = move |tracks: &[Track]| {
        let mut lines = Vec::new();
        for (incline, track) in all.iter().zip(tracks) {
            lines.extend(judge_rolling(incline, track, MOMENTS));
        }
        lines
    };
    Rung {
        name: "rolling-incline",
        title: "A ball rolls down an incline with g sinβ/(1 + I/(mR²))",
        group: Group::Exact,
        cases,
        judge: Box::new(judge),
    }
}

fn judge_rolling(incline: &Incline, track: &Track, moments: [u64; 2]) -> Vec<Line> {
    let shape = incline.shape;
    let mut lines = Vec::new();
    let n = moments[0];
    let found = seen(track, 0, 0);
    let [speed, spin] = incline.rolled(n);
    let what = format!("velocity of the {shape} after {n} steps");
    lines.push(exact(what, "m/s", found.velocity[0], speed, n, speed));
    let what = format!("spin of the {shape} after {n} steps");
    lines.push(exact(what, "rad/s", found.spin, spin, n, spin));
    // Half a period apart, the swinging of the tangential spring cancels.
    let mean = 0.5 * (found.velocity[0] + seen(track, 1, 0).velocity[0]);
    let time = 0.5 * (moments[0] + moments[1]) as f64 * incline.dt;
    let acceleration = mean / time / incline.along;
    let Ball { arm, grain, .. } = incline.ball;
    let what = format!("acceleration of the {shape} over g sinβ");
    let expected = |arm: f64| 1.0 / (1.0 + grain.inertia / (MASS * arm * arm));
    let exactly = expected(arm);
    lines.push(exact(what.clone(), "1", acceleration, exactly, n, 1.0));
    lines.push(line(
        format!("{what}, as of a rigid ball"),
        "1",
        acceleration,
        expected(RADIUS),
        incline.ball.overlap / RADIUS,
        "InclinedPlaneUnitTest; the arm is R − u/2 and not R",
    ));
    lines
}

/// Steeper than tan β = μ(1 + mR²/I) a ball slides: a = g(sinβ − μ cosβ), Iω′ = rμmg cosβ.
pub fn sliding() -> Rung {
    const MOMENTS: [u64; 2] = [200, 1000];
    // Soft, so that the rounding of the overlap is small against the overlap.
    let all = SHAPES.map(|shape| Incline::new(shape, PI / 4.5, 0.1, 64.0));
    let cases = all.iter().map(|incline| incline.case(&MOMENTS)).collect();
    let judge = move |tracks: &[Track]| {
        let mut lines = Vec::new();
        let steps = MOMENTS[1] - MOMENTS[0];
        for (incline, track) in all.iter().zip(tracks) {
            let (early, late) = (seen(track, 0, 0), seen(track, 1, 0));
            let time = steps as f64 * incline.dt;
            let pull = incline.friction * incline.against;
            let shape = incline.shape;
            let gain = late.velocity[0] - early.velocity[0];
            let expected = time * (incline.along - pull);
            let what = format!("velocity that the {shape} gains in {steps} steps");
            lines.push(exact(what, "m/s", gain, expected, MOMENTS[1], expected));
            let gain = late.spin - early.spin;
            let Ball { arm, grain, .. } = incline.ball;
            let expected = time * arm * MASS * pull / grain.inertia;
            let what = format!("spin that the {shape} gains in {steps} steps");
            lines.push(exact(what, "rad/s", gain, expected, MOMENTS[1], expected));
        }
        lines
    };
    Rung {
        name: "sliding-incline",
        title: "On a steeper incline it slides with g(sinβ − μ cosβ)",
        group: Group::Exact,
        cases,
        judge: Box::new(judge),
    }
}
