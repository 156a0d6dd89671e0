//! A ball that starts without spin on a level plane: it slides, and friction makes it roll.

use std::f64::consts::PI;

use super::super::{ROUNDING, exact, rounding, seen};
use super::{Ball, SHAPES, at_the_contact_point};
use crate::suite::build;
use crate::suite::line;
use crate::suite::{Group, Line, Rung, Track};
use grains::case::Case;
use grains::model::{Axis, Law, Model};

/// m/s².
const GRAVITY: f64 = 9.81;

fn on_a_plane(
    name: &str,
    law: Law,
    dt: f64,
    balls: &[Ball],
    speed: f64,
    moments: Vec<u64>,
) -> Case {
    let model = Model {
        gravity: [0.0, -GRAVITY],
        walls: vec![build::wall(Axis::Z, 0.0)],
        ..build::model(law, dt)
    };
    let grains: Vec<_> = balls
        .iter()
        .map(|ball| ball.grain.moving([speed, 0.0]))
        .collect();
    build::case(name, model, &grains, moments)
}

/// While the ball slides, a step takes μg dt from v and adds rμmg dt/I to ω.
pub fn sliding() -> Rung {
    const FRICTION: f64 = 0.3;
    const SPEED: f64 = 10.0;
    const DT: f64 = 1.0e-3;
    const MOMENTS: [u64; 2] = [1, 500];
    // Soft, so that the rounding of the overlap is small against the overlap: u = R/64.
    let weight = 1000.0 * GRAVITY;
    let ball = |x: f64, share: f64| Ball::new(x, [1.0, 1000.0, share], weight, 64.0 * weight);
    let balls = [ball(0.0, SHAPES[0].1), ball(-10.0, SHAPES[1].1)];
    let law = balls[0].law(1.0, FRICTION);
    let names = ["arm R − u/2", "arm R − u"];
    let arms = [balls[0].arm, 1.0 - balls[0].overlap];
    let laws = [law.clone(), at_the_contact_point(law)];
    let cases = names.into_iter().zip(laws);
    let cases = cases.map(|(name, law)| on_a_plane(name, law, DT, &balls, SPEED, MOMENTS.to_vec()));
    let cases = cases.collect();
    let judge = move |tracks: &[Track]| {
        let mut lines = Vec::new();
        for ((track, arm), name) in tracks.iter().zip(arms).zip(names) {
            for (id, (shape, share)) in SHAPES.into_iter().enumerate() {
                for (moment, n) in MOMENTS.into_iter().enumerate() {
                    let found = seen(track, moment, id);
                    let lost = FRICTION * GRAVITY * DT * n as f64;
                    let speed = SPEED - lost;
                    let after = format!("of the {shape} after {n} steps, {name}");
                    let what = format!("velocity {after}");
                    lines.push(exact(what, "m/s", found.velocity[0], speed, n, SPEED));
                    let spin = arm * lost / share;
                    let what = format!("spin {after}");
                    lines.push(exact(what, "rad/s", found.spin, spin, n, SPEED));
                }
            }
        }
        lines
    };
    Rung {
        name: "sliding-ball",
        title: "Sliding friction slows a ball by μg dt a step and turns it by rμmg dt/I",
        group: Group::Exact,
        cases,
        judge: Box::new(judge),
    }
}

/// MFiX's DEM04, of a sphere and of a disc of the same mass.
struct Dem04 {
    ball: Ball,
    shape: &'static str,
    friction: f64,
    dt: f64,
    /// Middle of sliding, and two moments half a period apart after it.
    moments: [u64; 2],
}

/// m/s.
const SPEED: f64 = 0.1;
/// Steps in a period of the spring that is left swinging when sliding ends.
const PERIOD: u64 = 40;

impl Dem04 {
    fn new((shape, share): (&'static str, f64), friction: f64) -> Self {
        let radius = 0.5e-3;
        let mass = 1.0e4 * 4.0 / 3.0 * PI * radius * radius * radius;
        let ball = Ball::new(0.0, [radius, mass, share], mass * GRAVITY, 1.0e4);
        let dt = 2.0 * (PI / PERIOD as f64).sin() / ball.stick_omega(1.0);
        let slides = SPEED / (friction * GRAVITY * (1.0 + ball.lightness()) * dt);
        let late = (1.2 * slides) as u64;
        Dem04 {
            ball,
            shape,
            friction,
            dt,
            moments: [late, late + PERIOD / 2],
        }
    }

    fn case(&self) -> Case {
        let name = format!("{} with μ = {}", self.shape, self.friction);
        let law = self.ball.law(1.0, self.friction);
        let moments = self.moments.to_vec();
        on_a_plane(&name, law, self.dt, &[self.ball], SPEED, moments)
    }

    /// The tangential spring is left swinging undamped; moments half a period apart cancel it.
    fn mean(&self, of: impl Fn(usize) -> f64) -> f64 {
        0.5 * (of(0) + of(1))
    }

    fn judge(&self, track: &Track) -> Vec<Line> {
        let last = self.moments[1];
        let speed = self.mean(|moment| seen(track, moment, 0).velocity[0]);
        let spin = self.mean(|moment| seen(track, moment, 0).spin);
        let way = self.mean(|moment| seen(track, moment, 0).position[0]);
        let time = self.mean(|moment| self.moments[moment] as f64 * self.dt);
        // The way is v t + ½μg t_s²; sliding starts with a velocity half a step old.
        let deceleration = self.friction * GRAVITY;
        let slid = (2.0 * (way - speed * time) / deceleration).sqrt() + 0.5 * self.dt;
        let share = 1.0 / (1.0 + self.ball.lightness());
        let of = format!("of the {} with μ = {}", self.shape, self.friction);
        vec![
            line(
                format!("v/u_0 {of}"),
                "1",
                speed / SPEED,
                1.0 - share,
                rounding(last, 1.0),
                ROUNDING,
            ),
            line(
                format!("ωr/u_0 {of}"),
                "1",
                spin * self.ball.arm / SPEED,
                1.0 - share,
                rounding(last, 1.0),
                ROUNDING,
            ),
            line(
                format!("μg t_s/u_0 {of}"),
                "1",
                deceleration * slid / SPEED,
                share,
                0.5 * deceleration * self.dt / SPEED,
                "sliding ends between two steps: half a step",
            ),
        ]
    }
}

/// Garg et al. 2012 (Powder Technology 220:122–137): μg t_s/u_0 = 2/7 and v/u_0 = 5/7 for a
/// rigid sphere, 1/3 and 2/3 for a disc; here with r in place of R.
pub fn then_rolling() -> Rung {
    let all: Vec<Dem04> = SHAPES
        .into_iter()
        .flat_map(|shape| [0.2, 0.5, 1.0].map(|friction| Dem04::new(shape, friction)))
        .collect();
    let cases = all.iter().map(Dem04::case).collect();
    let judge = move |tracks: &[Track]| {
        let mut lines = Vec::new();
        for (dem04, track) in all.iter().zip(tracks) {
            lines.extend(dem04.judge(track));
        }
        lines
    };
    Rung {
        name: "slip-then-roll",
        title: "MFiX DEM04: a ball slips until μg t/u_0 = 2/7 (disc 1/3) and rolls at 5/7 (2/3) of u_0",
        group: Group::Exact,
        cases,
        judge: Box::new(judge),
    }
}
