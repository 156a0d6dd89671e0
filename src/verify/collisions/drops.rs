//! A ball that falls on a floor: MFiX-DEM's first two verification cases (Garg, Galvin, Li and Pannala,
//! Powder Technology 220 (2012) 122), and bounces with local damping.

use super::continuum::{Impact, Release, dashpot, nominal_ratio};
use super::experiment::{Experiment, View, largest, line, rung, view};
use crate::engine::case::Case;
use crate::model::{Axis, Model};
use crate::scene::{Tension, Viscosity};
use crate::verify::build::{self, Grain};
use crate::verify::{Line, Rung, Track};

/// m/s².
const GRAVITY: f64 = 9.81;
/// Of the ball, m.
const RADIUS: f64 = 0.1;
/// Of the ball, kg/m³.
const DENSITY: f64 = 2600.0;
/// Of the centre at the start, m.
const HEIGHT: f64 = 0.5;

/// The rungs.
pub fn rungs() -> Vec<Rung> {
    vec![
        rung(
            "drop-on-wall",
            "MFiX DEM01: a ball falls on a soft floor whose dashpot does not pull",
            drops(Tension::Clipped),
        ),
        rung(
            "drop-on-wall-unclipped",
            "MFiX DEM01 as published: the floor's dashpot may pull",
            drops(Tension::Unclipped),
        ),
        rung(
            "repeated-bounces",
            "MFiX DEM02: how high a ball bounces, again and again",
            bouncing(),
        ),
        rung(
            "repeated-bounces-local-damping",
            "Local damping: each bounce has ((1−α)/(1+α))² of the height",
            damped_bouncing(),
        ),
    ]
}

/// The ball over the floor z = 0.
#[derive(Debug, Clone)]
struct Ball {
    name: String,
    stiffness: f64,
    restitution: f64,
    tension: Tension,
    alpha: f64,
    dt: f64,
}

impl Ball {
    fn grain(&self) -> Grain {
        // At rest at the start: so fast half a step before.
        let before = 0.5 * GRAVITY * (1.0 - self.alpha) * self.dt;
        Grain::sphere([0.0, HEIGHT], RADIUS, DENSITY).moving([0.0, before])
    }

    fn frequency(&self) -> f64 {
        (self.stiffness / self.grain().mass).sqrt()
    }

    /// (ω dt)².
    fn second_order(&self) -> f64 {
        (self.frequency() * self.dt).powi(2)
    }

    /// c_n dt/m: the share of the momentum that the dashpot takes in a step.
    fn first_order(&self) -> f64 {
        self.dashpot() * self.dt / self.grain().mass
    }

    /// c_n of this restitution where nothing is clipped and nothing weighs, N·s/m.
    fn dashpot(&self) -> f64 {
        let ratio = nominal_ratio(self.restitution);
        dashpot(ratio, self.grain().mass, self.stiffness)
    }

    fn impact(&self, approach: f64) -> Impact {
        Impact {
            mass: self.grain().mass,
            stiffness: self.stiffness,
            dashpot: self.dashpot(),
            pull: GRAVITY,
            approach,
            clipped: self.tension == Tension::Clipped,
        }
    }

    fn case(&self, moments: Vec<u64>) -> Case {
        let springs = build::springs(self.stiffness / RADIUS);
        let law = if self.restitution == 1.0 {
            springs
        } else {
            let viscosity = Viscosity::Dashpot {
                c_n: self.dashpot(),
                tension: self.tension,
            };
            build::with_viscosity(springs, viscosity)
        };
        let model = Model {
            gravity: [0.0, -GRAVITY],
            alpha: self.alpha,
            walls: vec![build::wall(Axis::Z, 0.0)],
            ..build::model(law, self.dt)
        };
        build::case(&self.name, model, &[self.grain()], moments)
    }

    /// The step nearest to a time.
    fn step(&self, time: f64) -> u64 {
        (time / self.dt).round() as u64
    }

    /// Height and upward velocity at a step, not half a step before it, in free flight at −`fall`.
    fn flight(&self, view: View, fall: f64) -> [f64; 2] {
        let velocity = view.velocity(0)[1] - 0.5 * fall * self.dt;
        [view.position(0)[1], velocity]
    }
}

/// Touch: √(2(h−R)/g) after the start, with √(2g(h−R)).
fn touch() -> [f64; 2] {
    let fall = HEIGHT - RADIUS;
    [(2.0 * fall / GRAVITY).sqrt(), (2.0 * GRAVITY * fall).sqrt()]
}

/// The first bounce, seen all along.
struct Drop(Ball);

fn drops(tension: Tension) -> Vec<Box<dyn Experiment>> {
    // The stiffnesses and restitutions of the published case that a dashpot tells apart.
    let mut all = vec![
        (1.0e4, 0.9),
        (1.0e4, 0.6),
        (5.0e4, 0.8),
        (1.0e5, 0.9),
        (1.0e5, 0.6),
    ];
    if tension == Tension::Clipped {
        all.push((1.0e5, 1.0));
    }
    let drop = |(stiffness, restitution)| -> Box<dyn Experiment> {
        Box::new(Drop(Ball {
            name: format!("k {stiffness:e}, e {restitution}"),
            stiffness,
            restitution,
            tension,
            alpha: 0.0,
            dt: 4.0e-5,
        }))
    };
    all.into_iter().map(drop).collect()
}

impl Drop {
    /// When the floor lets go, s after the start, and how.
    fn release(&self) -> (f64, Release) {
        let [time, speed] = touch();
        let release = self.0.impact(speed).release();
        (time + release.time, release)
    }

    /// y(t) of the closed form, m.
    fn height(&self, t: f64) -> f64 {
        let [touch, speed] = touch();
        let (released, release) = self.release();
        if t < touch {
            HEIGHT - 0.5 * GRAVITY * t * t
        } else if t < released {
            RADIUS - self.0.impact(speed).at(t - touch)[0]
        } else {
            let since = t - released;
            RADIUS - release.overlap + release.speed * since - 0.5 * GRAVITY * since * since
        }
    }

    /// The last step before touch.
    fn before_touch(&self) -> u64 {
        (touch()[0] / self.0.dt).floor() as u64
    }

    /// After touch the curve is looked at every so many steps, until it is well off the floor.
    fn moments(&self) -> Vec<u64> {
        let first = self.before_touch();
        let (released, release) = self.release();
        let off = (released + release.overlap / release.speed + 0.02) / self.0.dt;
        let last = off.ceil() as u64;
        let every = (last - first) / 40;
        (0..=40).map(|count| last - (40 - count) * every).collect()
    }
}

impl Experiment for Drop {
    fn cases(&self) -> Vec<Case> {
        let first = self.before_touch();
        let later = self.moments().into_iter().filter(|step| *step > first);
        vec![self.0.case(std::iter::once(first).chain(later).collect())]
    }

    fn lines(&self, tracks: &[Track]) -> Vec<Line> {
        let ball = &self.0;
        let (first, curve) = (self.before_touch(), self.moments());
        let time = |step: u64| step as f64 * ball.dt;
        let height = |step: u64| view(tracks, 0, step).position(0)[1];
        let seen = curve.iter().filter(|step| **step > first);
        let apart = seen.map(|step| (height(*step) - self.height(time(*step))).abs());

        let last = curve.last().copied().unwrap_or_default();
        let (released, release) = self.release();
        let [end, velocity] = ball.flight(view(tracks, 0, last), GRAVITY);
        let since = time(last) - released;
        let back = end - velocity * since - 0.5 * GRAVITY * since * since;

        let off = touch()[1] * (ball.first_order() + ball.second_order());
        let name = &ball.name;
        let basis = "order of the step: the dashpot's share c dt/m of the momentum in a step, and (ω dt)²; of the \
                     speed at touch";
        let way = "the same velocity over the time since touch";
        vec![
            line(
                format!("height in free fall, {name}"),
                "m",
                height(first),
                self.height(time(first)),
                first as f64 * f64::EPSILON * HEIGHT,
                "the scheme has the parabola exactly; rounding of the height in every step",
            ),
            line(
                format!("velocity when the floor lets go, {name}"),
                "m/s",
                velocity + GRAVITY * since,
                release.speed,
                off,
                basis,
            ),
            line(
                format!("height when the floor lets go, {name}"),
                "m",
                back,
                RADIUS - release.overlap,
                off * (released - touch()[0]),
                way,
            ),
            line(
                format!("largest distance from y(t), {name}"),
                "m",
                largest(apart),
                0.0,
                off * (time(last) - touch()[0]),
                way,
            ),
        ]
    }
}

/// Some bounces on a soft floor and on one ten times as stiff.
struct Bouncing {
    floors: [Ball; 2],
    bounces: usize,
}

/// √10: hard spheres are approached as 1/√k.
const ROOT_OF_STIFFER: f64 = 3.162_277_660_168_379_4;

/// One bounce in the closed form.
struct Bounce {
    /// When the height is read: half way up, s.
    reading: f64,
    /// Of the bounce's top, m.
    apex: f64,
    /// Speed at touch, m/s.
    approach: f64,
    /// Speed when the floor lets go, m/s.
    rebound: f64,
}

fn bouncing() -> Vec<Box<dyn Experiment>> {
    let of = |(restitution, bounces)| -> Box<dyn Experiment> {
        let ball = |stiffness: f64| Ball {
            name: format!("k {stiffness:e}, e {restitution}"),
            stiffness,
            restitution,
            tension: Tension::Clipped,
            alpha: 0.0,
            dt: 1.0e-4,
        };
        let floors = [ball(5.0e4), ball(5.0e5)];
        Box::new(Bouncing { floors, bounces })
    };
    [(1.0, 2), (0.8, 3), (0.6, 2)].into_iter().map(of).collect()
}

impl Bouncing {
    fn closed_form(&self, ball: &Ball) -> Vec<Bounce> {
        let [mut time, mut approach] = touch();
        let mut bounces = Vec::new();
        for _ in 0..self.bounces {
            let release = ball.impact(approach).release();
            let let_go = time + release.time;
            bounces.push(Bounce {
                reading: let_go + 0.5 * release.speed / GRAVITY,
                apex: RADIUS - release.overlap + 0.5 * release.speed.powi(2) / GRAVITY,
                approach,
                rebound: release.speed,
            });
            approach = (release.speed.powi(2) - 2.0 * GRAVITY * release.overlap).sqrt();
            time = let_go + (release.speed + approach) / GRAVITY;
        }
        bounces
    }

    /// The top of the last bounce over a rigid floor, m above the lowest place of the centre:
    /// (h₀ − R)e^{2n} with the e of the clipped dashpot where nothing weighs.
    fn rigid(&self) -> f64 {
        let impact = Impact {
            pull: 0.0,
            ..self.floors[0].impact(1.0)
        };
        (HEIGHT - RADIUS) * impact.release().speed.powi(2 * self.bounces as i32)
    }

    /// What the step may do to the height of a bounce's top, as a share of it.
    fn off(&self, ball: &Ball) -> f64 {
        2.0 * (ball.first_order() + ball.second_order())
    }

    /// What weight during the contacts takes of the last top, to first order: 4ζg/ω (1/v + 1/v′) a
    /// bounce with the speeds v of the approach and v′ of the rebound.
    fn weight(&self, ball: &Ball) -> f64 {
        let of_one = |bounce: &Bounce| 1.0 / bounce.approach + 1.0 / bounce.rebound;
        let speeds: f64 = self.closed_form(ball).iter().map(of_one).sum();
        4.0 * nominal_ratio(ball.restitution) * GRAVITY / ball.frequency() * speeds
    }

    fn tops(&self, tracks: &[Track], index: usize) -> Vec<f64> {
        let ball = &self.floors[index];
        let bounces = self.closed_form(ball);
        let top = |bounce: &Bounce| {
            let view = view(tracks, index, ball.step(bounce.reading));
            let [height, velocity] = ball.flight(view, GRAVITY);
            height + 0.5 * velocity * velocity / GRAVITY
        };
        bounces.iter().map(top).collect()
    }

    fn line_of_the_rigid_floor(&self, tops: [f64; 2]) -> Line {
        let [soft, stiff] = tops.map(|top| (top - RADIUS) / self.rigid());
        let [weight_soft, weight_stiff] = [0, 1].map(|index| self.weight(&self.floors[index]));
        let root = ROOT_OF_STIFFER;
        let steps = (root + 1.0) / (root - 1.0) * self.off(&self.floors[1]) * self.bounces as f64;
        line(
            format!(
                "last top for k → ∞ over that of hard spheres, e {}",
                self.floors[0].restitution
            ),
            "1",
            (root * stiff - soft) / (root - 1.0),
            1.0,
            weight_soft * weight_stiff + steps,
            "hard spheres, (h₀ − R)e^{2n}, are approached as 1/√k; extrapolated from two floors, what is left is the \
             product of what weight does to both, 4ζg/ω (1/v + 1/v′) a bounce; and the order of the step",
        )
    }
}

impl Experiment for Bouncing {
    fn cases(&self) -> Vec<Case> {
        let case = |ball: &Ball| {
            let bounces = self.closed_form(ball);
            ball.case(
                bounces
                    .iter()
                    .map(|bounce| ball.step(bounce.reading))
                    .collect(),
            )
        };
        self.floors.iter().map(case).collect()
    }

    fn lines(&self, tracks: &[Track]) -> Vec<Line> {
        let tops = [0, 1].map(|index| self.tops(tracks, index));
        let mut lines = Vec::new();
        for (ball, tops) in self.floors.iter().zip(&tops) {
            for (index, (top, bounce)) in tops.iter().zip(self.closed_form(ball)).enumerate() {
                lines.push(line(
                    format!("top of bounce {}, {}", index + 1, ball.name),
                    "m",
                    *top,
                    bounce.apex,
                    (bounce.apex - RADIUS) * self.off(ball) * (index + 1) as f64,
                    "order of the step, twice over in a height: c dt/m + (ω dt)² a bounce",
                ));
            }
        }
        let last = |tops: &[f64]| tops.last().copied().unwrap_or(f64::NAN);
        lines.push(self.line_of_the_rigid_floor([last(&tops[0]), last(&tops[1])]));
        lines
    }
}

/// Bounces on a spring with local damping, gravity damped too. The work that is done on the way down is
/// taken 1−α fold, that against the spring 1+α fold, and back; with P = h − R + mg/2k, which measures from
/// the middle of the static sinking, each bounce has exactly ((1−α)/(1+α))² of the P before, whatever k.
struct DampedBouncing {
    ball: Ball,
    bounces: usize,
}

fn damped_bouncing() -> Vec<Box<dyn Experiment>> {
    let of = |(stiffness, alpha, bounces)| -> Box<dyn Experiment> {
        let ball = Ball {
            name: format!("k {stiffness:e}, alpha {alpha}"),
            stiffness,
            restitution: 1.0,
            tension: Tension::Clipped,
            alpha,
            dt: 5.0e-5,
        };
        Box::new(DampedBouncing { ball, bounces })
    };
    let all = [
        (5.0e4, 0.1, 2),
        (5.0e5, 0.1, 2),
        (5.0e4, 0.3, 3),
        (5.0e5, 0.3, 3),
    ];
    all.into_iter().map(of).collect()
}

impl DampedBouncing {
    /// (1−α)/(1+α).
    fn ratio(&self) -> f64 {
        (1.0 - self.ball.alpha) / (1.0 + self.ball.alpha)
    }

    fn raised(&self) -> f64 {
        0.5 * self.ball.grain().mass * GRAVITY / self.ball.stiffness - RADIUS
    }

    /// Half way up in each bounce; to find it, the floor may count as weightless.
    fn steps(&self) -> Vec<u64> {
        let alpha = self.ball.alpha;
        let fall = |height: f64| (2.0 * height / (GRAVITY * (1.0 - alpha))).sqrt();
        let rise = |height: f64| (2.0 * height / (GRAVITY * (1.0 + alpha))).sqrt();
        let half = 0.5 * std::f64::consts::PI / self.ball.frequency();
        let contact = half * (1.0 / (1.0 - alpha).sqrt() + 1.0 / (1.0 + alpha).sqrt());
        let mut height = HEIGHT - RADIUS;
        let mut time = 0.0;
        let mut steps = Vec::new();
        for _ in 0..self.bounces {
            time += fall(height) + contact;
            height *= self.ratio().powi(2);
            steps.push(self.ball.step(time + 0.5 * rise(height)));
            time += rise(height);
        }
        steps
    }
}

impl Experiment for DampedBouncing {
    fn cases(&self) -> Vec<Case> {
        vec![self.ball.case(self.steps())]
    }

    fn lines(&self, tracks: &[Track]) -> Vec<Line> {
        let ball = &self.ball;
        let fall = GRAVITY * (1.0 + ball.alpha);
        let start = HEIGHT + self.raised();
        let steps = self.steps();
        let lines = steps.iter().enumerate().map(|(index, step)| {
            let [height, velocity] = ball.flight(view(tracks, 0, *step), fall);
            let apex = height + 0.5 * velocity * velocity / fall;
            let count = index as i32 + 1;
            let expected = self.ratio().powi(2 * count);
            line(
                format!(
                    "(h − R + mg/2k) over that at the start, bounce {count}, {}",
                    ball.name
                ),
                "1",
                (apex + self.raised()) / start,
                expected,
                expected * f64::from(count) * ball.second_order() / self.ratio(),
                "second order in the step, as in bounce-local-damping and twice over in a height: \
                 (1+α)/(1−α)·(ω dt)² a bounce",
            )
        });
        lines.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Release times and velocities of MFiX's DEM01, worked out apart from this program.
    #[test]
    fn the_closed_form_has_the_known_releases() {
        let known = [
            (1.0e4, 0.9, Tension::Unclipped, 0.397388, 2.475857),
            (1.0e4, 0.9, Tension::Clipped, 0.395164, 2.503278),
            (1.0e4, 0.6, Tension::Unclipped, 0.401299, 1.491954),
            (1.0e4, 0.6, Tension::Clipped, 0.390156, 1.685430),
            (1.0e5, 1.0, Tension::Clipped, 0.319116, 2.801428),
            (1.0e5, 0.6, Tension::Unclipped, 0.319818, 1.626207),
            (1.0e5, 0.6, Tension::Clipped, 0.316376, 1.748693),
        ];
        for (stiffness, restitution, tension, time, speed) in known {
            let ball = Ball {
                name: String::new(),
                stiffness,
                restitution,
                tension,
                alpha: 0.0,
                dt: 1.0e-5,
            };
            let (released, release) = Drop(ball).release();
            assert!(
                (released - time).abs() < 1.0e-6,
                "{stiffness} {restitution} {tension:?}: {released}"
            );
            assert!(
                (release.speed - speed).abs() < 1.0e-6,
                "{stiffness} {restitution} {tension:?}: {}",
                release.speed
            );
        }
    }
}
