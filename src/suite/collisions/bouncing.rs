//! A ball that bounces again and again: MFiX-DEM's second verification case, and the same with local damping.

use super::ball::{Ball, GRAVITY, HEIGHT, RADIUS, touch};
use super::continuum::{Impact, nominal_ratio};
use super::experiment::{Experiment, rung, view};
use crate::suite::line;
use crate::suite::{Line, Rung, Track};
use grains::case::Case;
use grains::scene::Tension;

/// The rungs.
pub fn rungs() -> Vec<Rung> {
    vec![
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
