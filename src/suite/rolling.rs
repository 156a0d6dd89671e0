//! A ball on a plane: sliding, sliding until it rolls, rolling down an incline. In all of them the normal
//! force is constant, because the ball starts at the overlap u that bears it.
//!
//! With YADE's choices the force acts at the arm r = R − u/2, and rolling without slip is v = rω: the
//! slip is a(v − rω) with a = R/r. So the results for a rigid ball hold with r in place of R, in
//! I/(mR²) as well.

use std::f64::consts::PI;

use super::analytic::{SpringDashpot, State};
use super::sliding::{CONTACT_POINT, HALF_OVERLAP};
use crate::suite::{self, CaseGroup, Grain, at};
use grains::model::Law;
use grains::task::Case;

pub fn groups() -> Vec<CaseGroup> {
    vec![
        sliding(),
        slip_then_roll(),
        rolling_incline(),
        sliding_incline(),
    ]
}

/// What a ball is: its name and I/(mR²).
const SHAPES: [(&str, f64); 2] = [("sphere", 0.4), ("disc", 0.5)];

/// A ball on the plane z = 0 whose weight makes the overlap.
#[derive(Debug, Clone, Copy)]
struct Ball {
    grain: Grain,
    /// m.
    overlap: f64,
    /// Distance from the centre at which the plane's force acts, m.
    arm: f64,
    /// k_n, N/m.
    stiffness: f64,
}

impl Ball {
    /// A ball of this radius (m), mass (kg) and share I/(mR²) that bears this weight (N) at this k_n (N/m).
    fn new(x: f64, [radius, mass, share]: [f64; 3], weight: f64, stiffness: f64) -> Self {
        let overlap = weight / stiffness;
        let mut grain = Grain::disc([x, radius - overlap], radius, 0.0);
        (grain.mass, grain.inertia) = (mass, share * mass * radius * radius);
        Ball {
            grain,
            overlap,
            arm: radius - 0.5 * overlap,
            stiffness,
        }
    }

    /// mr²/I.
    fn lightness(&self) -> f64 {
        self.grain.mass * self.arm * self.arm / self.grain.inertia
    }

    /// ω of the slip while the ball sticks: k_s a (1/m + r²/I), with k_s = k_n·ratio.
    fn stick_omega(&self, ratio: f64) -> f64 {
        let factor = self.grain.radius / self.arm;
        let stiffness = ratio * self.stiffness * factor;
        (stiffness * (1.0 + self.lightness()) / self.grain.mass).sqrt()
    }

    /// The step that makes a swing of the stuck ball so many steps long, s.
    fn dt(&self, ratio: f64, period: u64) -> f64 {
        2.0 * (PI / period as f64).sin() / self.stick_omega(ratio)
    }

    /// The law that gives these stiffnesses, with friction of this tan φ.
    fn law(&self, ratio: f64, friction: f64) -> Law {
        let modulus = self.stiffness / self.grain.radius;
        suite::friction(modulus, ratio, friction.atan())
    }
}

/// Grains on the plane, moved to the right at this speed, under this gravity.
fn on_a_plane(law: Law, dt: f64, gravity: [f64; 2], grains: &[Grain], moments: &[u64]) -> Case {
    let model = suite::world(law, dt, gravity, 0.0, [&[], &[0.0]]);
    suite::case("on a plane", model, grains, moments.to_vec())
}

/// m/s², on the level.
const GRAVITY: f64 = 9.81;

/// While the ball slides, a step takes μg dt from v and adds rμmg dt/I to ω.
fn sliding() -> CaseGroup {
    const FRICTION: f64 = 0.3;
    const SPEED: f64 = 10.0;
    const DT: f64 = 1.0e-3;
    const MOMENTS: [u64; 2] = [1, 500];
    // Soft, so that the rounding of the overlap is small against the overlap: u = R/64.
    let weight = 1000.0 * GRAVITY;
    let ball = |x: f64, share: f64| Ball::new(x, [1.0, 1000.0, share], weight, 64.0 * weight);
    let balls = [ball(0.0, SHAPES[0].1), ball(-10.0, SHAPES[1].1)];
    let grains = balls.map(|ball| ball.grain.moving([SPEED, 0.0]));
    let law = balls[0].law(1.0, FRICTION);
    let title = "Sliding friction slows a ball by μg dt a step and turns it by rμmg dt/I";
    let mut group = CaseGroup::new("sliding-ball", title);
    for arms in [HALF_OVERLAP, CONTACT_POINT] {
        let arm = 1.0 - arms.shortening * balls[0].overlap;
        let law = (arms.law)(law.clone());
        let case = on_a_plane(law, DT, [0.0, -GRAVITY], &grains, &MOMENTS);
        group = group.with(arms.id, case, move |track, figures| {
            for (id, (shape, share)) in SHAPES.into_iter().enumerate() {
                for n in MOMENTS {
                    let found = at(track, n);
                    let lost = FRICTION * GRAVITY * DT * n as f64;
                    let what = format!("{shape}/velocity/{n}-steps, m/s");
                    let speed = found.velocity(id)[0];
                    figures.exact(&what, speed, SPEED - lost, n, SPEED);
                    let what = format!("{shape}/spin/{n}-steps, rad/s");
                    figures.exact(&what, found.spin(id), arm * lost / share, n, SPEED);
                }
            }
        });
    }
    group
}

/// MFiX's DEM04, of a sphere and of a disc of the same mass. Garg et al. 2012 (Powder Technology 220:122–137):
/// μg t_s/u_0 = 2/7 and v/u_0 = 5/7 for a rigid sphere, 1/3 and 2/3 for a disc; here with r in place of R.
fn slip_then_roll() -> CaseGroup {
    /// m/s.
    const SPEED: f64 = 0.1;
    /// Steps in a period of the spring that is left swinging when sliding ends.
    const PERIOD: u64 = 40;
    let title =
        "MFiX DEM04: a ball slips until μg t/u_0 = 2/7 (disc 1/3) and rolls at 5/7 (2/3) of u_0";
    let mut group = CaseGroup::new("slip-then-roll", title);
    for (shape, share) in SHAPES {
        for friction in [0.2, 0.5, 1.0] {
            let radius = 0.5e-3;
            let mass = 1.0e4 * 4.0 / 3.0 * PI * radius * radius * radius;
            let ball = Ball::new(0.0, [radius, mass, share], mass * GRAVITY, 1.0e4);
            let dt = ball.dt(1.0, PERIOD);
            let deceleration = friction * GRAVITY;
            let slides = SPEED / (deceleration * (1.0 + ball.lightness()) * dt);
            // Two moments half a period apart after sliding.
            let late = (1.2 * slides) as u64;
            let moments = [late, late + PERIOD / 2];
            let grains = [ball.grain.moving([SPEED, 0.0])];
            let law = ball.law(1.0, friction);
            let case = on_a_plane(law, dt, [0.0, -GRAVITY], &grains, &moments);
            let id = format!("{shape}/mu-{friction}");
            group = group.with(id, case, move |track, figures| {
                // The tangential spring is left swinging undamped; moments half a period apart cancel it.
                let [early, late] = moments.map(|step| at(track, step));
                let mean = |a: f64, b: f64| 0.5 * (a + b);
                let speed = mean(early.velocity(0)[0], late.velocity(0)[0]);
                let spin = mean(early.spin(0), late.spin(0));
                let way = mean(early.position(0)[0], late.position(0)[0]);
                let [start, end] = moments.map(|step| step as f64 * dt);
                // The way is v t + ½μg t_s²; sliding starts with a velocity half a step old.
                let slid = 2.0 * (way - speed * mean(start, end)) / deceleration;
                let slid = slid.sqrt() + 0.5 * dt;
                let share = 1.0 / (1.0 + ball.lightness());
                let turning = spin * ball.arm / SPEED;
                let (last, rest) = (moments[1], 1.0 - share);
                figures.exact("speed: v/u_0, 1", speed / SPEED, rest, last, 1.0);
                figures.exact("spin: ωr/u_0, 1", turning, rest, last, 1.0);
                figures.because("sliding ends between two steps: half a step");
                let found = deceleration * slid / SPEED;
                let off = 0.5 * deceleration * dt / SPEED;
                figures.is("slip-time: μg t_s/u_0, 1", found, share, off);
            });
        }
    }
    group
}

/// A ball on an incline: the plane stays level and gravity is tilted.
struct Incline {
    ball: Ball,
    /// Gravity along the plane and against it, m/s².
    along: f64,
    against: f64,
    dt: f64,
}

impl Incline {
    /// m.
    const RADIUS: f64 = 0.1;
    /// kg.
    const MASS: f64 = 1.0;
    const GRAVITY: f64 = 9.8;
    /// k_s/k_n.
    const RATIO: f64 = 2.0 / 7.0;
    /// Steps in a period of the tangential spring.
    const PERIOD: u64 = 80;

    /// On a plane of this slope (rad), at the overlap R/`stiff`.
    fn new(share: f64, slope: f64, stiff: f64) -> Self {
        let [along, against] = [slope.sin(), slope.cos()].map(|share| Self::GRAVITY * share);
        let weight = Self::MASS * against;
        let stiffness = weight * stiff / Self::RADIUS;
        let ball = Ball::new(0.0, [Self::RADIUS, Self::MASS, share], weight, stiffness);
        Incline {
            ball,
            along,
            against,
            dt: ball.dt(Self::RATIO, Self::PERIOD),
        }
    }

    fn case(&self, friction: f64, moments: &[u64]) -> Case {
        let law = self.ball.law(Self::RATIO, friction);
        let gravity = [self.along, -self.against];
        on_a_plane(law, self.dt, gravity, &[self.ball.grain], moments)
    }

    /// v and ω of rolling after so many steps from rest. A step adds mr g sinβ dt to mrv + Iω, whatever
    /// friction does, and the tangential spring swings about the force that rolling needs:
    /// its way σ, slack at the start and one step before, is that of a swing about σ* = a g sinβ/ω².
    fn rolled(&self, steps: u64) -> [f64; 2] {
        let Ball { arm, grain, .. } = self.ball;
        let omega = self.ball.stick_omega(Self::RATIO);
        let factor = grain.radius / arm;
        let start = State::new(0, -(factor * self.along / (omega * omega)), 0.0);
        let swing = SpringDashpot::oscillator(omega, self.dt).in_touch(&start, steps);
        let slip = swing.approach / factor;
        // v − rω and v + Iω/(mr).
        let momentum = steps as f64 * self.dt * self.along;
        let lightness = self.ball.lightness();
        let speed = (momentum * lightness + slip) / (1.0 + lightness);
        [speed, (speed - slip) / arm]
    }
}

/// MercuryDPM's InclinedPlaneUnitTest: a = g sinβ/(1 + I/(mR²)), 5/7 g sinβ for a sphere at 15°.
fn rolling_incline() -> CaseGroup {
    const MOMENTS: [u64; 2] = [4000, 4000 + Incline::PERIOD / 2];
    let title = "A ball rolls down an incline with g sinβ/(1 + I/(mR²))";
    let mut group = CaseGroup::new("rolling-incline", title);
    for (shape, share) in SHAPES {
        let incline = Incline::new(share, PI / 12.0, 1000.0);
        group = group.with(shape, incline.case(0.5, &MOMENTS), move |track, figures| {
            let n = MOMENTS[0];
            let [early, late] = MOMENTS.map(|step| at(track, step));
            let [speed, spin] = incline.rolled(n);
            let what = format!("velocity/{n}-steps, m/s");
            figures.exact(&what, early.velocity(0)[0], speed, n, speed);
            let what = format!("spin/{n}-steps, rad/s");
            figures.exact(&what, early.spin(0), spin, n, spin);
            // Half a period apart, the swinging of the tangential spring cancels.
            let mean = 0.5 * (early.velocity(0)[0] + late.velocity(0)[0]);
            let time = 0.5 * (MOMENTS[0] + MOMENTS[1]) as f64 * incline.dt;
            let found = mean / time / incline.along;
            let of_arm =
                |r: f64| 1.0 / (1.0 + incline.ball.grain.inertia / (Incline::MASS * r * r));
            let what = "acceleration: acceleration over g sinβ, 1";
            figures.exact(what, found, of_arm(incline.ball.arm), n, 1.0);
            figures.because("InclinedPlaneUnitTest; the arm is R − u/2 and not R");
            let what = "acceleration-rigid: acceleration over g sinβ as of a rigid ball, 1";
            let radius = Incline::RADIUS;
            figures.is(what, found, of_arm(radius), incline.ball.overlap / radius);
        });
    }
    group
}

/// Steeper than tan β = μ(1 + mR²/I) a ball slides: a = g(sinβ − μ cosβ), Iω′ = rμmg cosβ.
fn sliding_incline() -> CaseGroup {
    const MOMENTS: [u64; 2] = [200, 1000];
    const FRICTION: f64 = 0.1;
    let title = "On a steeper incline it slides with g(sinβ − μ cosβ)";
    let mut group = CaseGroup::new("sliding-incline", title);
    for (shape, share) in SHAPES {
        // Soft, so that the rounding of the overlap is small against the overlap.
        let incline = Incline::new(share, PI / 4.5, 64.0);
        group = group.with(
            shape,
            incline.case(FRICTION, &MOMENTS),
            move |track, figures| {
                let [early, late] = MOMENTS.map(|step| at(track, step));
                let steps = MOMENTS[1] - MOMENTS[0];
                let time = steps as f64 * incline.dt;
                let pull = FRICTION * incline.against;
                let gain = late.velocity(0)[0] - early.velocity(0)[0];
                let expected = time * (incline.along - pull);
                let what = format!("velocity-gain: velocity gained in {steps} steps, m/s");
                figures.exact(&what, gain, expected, MOMENTS[1], expected);
                let gain = late.spin(0) - early.spin(0);
                let Ball { arm, grain, .. } = incline.ball;
                let expected = time * arm * Incline::MASS * pull / grain.inertia;
                let what = format!("spin-gain: spin gained in {steps} steps, rad/s");
                figures.exact(&what, gain, expected, MOMENTS[1], expected);
            },
        );
    }
    group
}
