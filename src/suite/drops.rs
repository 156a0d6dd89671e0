//! A ball that falls on a floor: MFiX-DEM's first two verification cases (Garg, Galvin, Li and Pannala, Powder
//! Technology 220 (2012) 122; DEM01 and DEM02 of MFiX's verification manual), and the same with local damping.

use super::analytic::{
    Release, SpringDashpot, State, dashpot, deviations, nominal_ratio, random_rounding,
};
use crate::suite::{self, CaseGroup, Grain, Track, at, furthest};
use grains::scene::{Tension, Viscosity};
use grains::task::Case;

pub fn groups() -> Vec<CaseGroup> {
    vec![
        first_bounces(
            "drop-on-wall",
            "MFiX DEM01: a ball falls on a soft floor whose dashpot does not pull",
            Tension::Clipped,
        ),
        first_bounces(
            "drop-on-wall-unclipped",
            "MFiX DEM01 as published: the floor's dashpot may pull",
            Tension::Unclipped,
        ),
        repeated_bounces(),
        damped_bounces(),
        recurrence(),
    ]
}

/// m/s².
const GRAVITY: f64 = 9.81;
/// Of the ball, m.
const RADIUS: f64 = 0.1;
/// Of the centre at the start, m.
const HEIGHT: f64 = 0.5;

/// The ball over the floor z = 0.
#[derive(Debug, Clone)]
struct Ball {
    id: String,
    /// k_n, N/m.
    stiffness: f64,
    /// Of the dashpot where nothing is clipped and nothing weighs; 1 is without one.
    restitution: f64,
    /// Whether the dashpot may pull.
    tension: Tension,
    alpha: f64,
    /// s.
    dt: f64,
}

impl Ball {
    fn new(stiffness: f64, restitution: f64, tension: Tension, dt: f64) -> Self {
        Ball {
            id: format!("k-{stiffness:e}/e-{restitution}"),
            stiffness,
            restitution,
            tension,
            alpha: 0.0,
            dt,
        }
    }

    /// Before it falls.
    fn grain(&self) -> Grain {
        // At rest at the start: so fast half a step before.
        let before = 0.5 * GRAVITY * (1.0 - self.alpha) * self.dt;
        Grain::sphere([0.0, HEIGHT], RADIUS, 2600.0).moving([0.0, before])
    }

    /// A contact that begins at this speed, m/s.
    fn contact(&self, approach: f64) -> SpringDashpot {
        let mass = self.grain().mass;
        SpringDashpot {
            dashpot: dashpot(nominal_ratio(self.restitution), mass, self.stiffness),
            ends: Some(self.tension),
            pull: GRAVITY,
            approach,
            alpha: self.alpha,
            ..SpringDashpot::spring(mass, self.stiffness, self.dt)
        }
    }

    /// (ω dt)².
    fn second_order(&self) -> f64 {
        (self.contact(0.0).frequency() * self.dt).powi(2)
    }

    /// What the step does: the dashpot's share of the momentum, and (ω dt)².
    fn order(&self) -> f64 {
        self.contact(0.0).share() + self.second_order()
    }

    fn case(&self, moments: Vec<u64>) -> Case {
        on_a_floor(&self.id, &self.contact(0.0), self.grain(), 0.0, moments)
    }

    /// The step nearest to a time.
    fn step(&self, time: f64) -> u64 {
        (time / self.dt).round() as u64
    }

    /// Height and upward velocity at a step, not half a step before it, in free flight at −`fall`.
    fn flight(&self, track: &Track, step: u64, fall: f64) -> [f64; 2] {
        let view = at(track, step);
        let velocity = view.velocity(0)[1] - 0.5 * fall * self.dt;
        [view.position(0)[1], velocity]
    }
}

/// A grain over a floor at this height.
fn on_a_floor(
    id: &str,
    contact: &SpringDashpot,
    grain: Grain,
    floor: f64,
    moments: Vec<u64>,
) -> Case {
    let (dt, alpha, c_n) = (contact.dt, contact.alpha, contact.dashpot);
    let springs = suite::springs(contact.stiffness / grain.radius);
    let law = match contact.ends {
        Some(tension) if c_n != 0.0 => {
            suite::with_viscosity(springs, Viscosity::Dashpot { c_n, tension })
        }
        _ => springs,
    };
    let model = suite::world(law, dt, [0.0, -GRAVITY], alpha, [&[], &[floor]]);
    suite::case(id, model, &[grain], moments)
}

/// Touch: √(2(h−R)/g) after the start, with √(2g(h−R)).
fn touch() -> [f64; 2] {
    let fall = HEIGHT - RADIUS;
    [(2.0 * fall / GRAVITY).sqrt(), (2.0 * GRAVITY * fall).sqrt()]
}

/// When the floor lets go after the first fall, s after the start, and how.
fn first_release(ball: &Ball) -> (f64, Release) {
    let [time, speed] = touch();
    let release = ball.contact(speed).release();
    (time + release.time, release)
}

/// y(t) of the closed form, m.
fn height(ball: &Ball, t: f64) -> f64 {
    let [touch, speed] = touch();
    let (released, release) = first_release(ball);
    if t < touch {
        HEIGHT - 0.5 * GRAVITY * t * t
    } else if t < released {
        RADIUS - ball.contact(speed).at(t - touch)[0]
    } else {
        let since = t - released;
        RADIUS - release.overlap + release.speed * since - 0.5 * GRAVITY * since * since
    }
}

/// The stiffnesses and restitutions of the published case that a dashpot tells apart; without one no dashpot pulls.
fn first_bounces(id: &'static str, title: &'static str, tension: Tension) -> CaseGroup {
    let (soft, stiff) = (1.0e4, 1.0e5);
    let damped = [
        (soft, 0.9),
        (soft, 0.6),
        (5.0e4, 0.8),
        (stiff, 0.9),
        (stiff, 0.6),
    ];
    let elastic = (tension == Tension::Clipped).then_some((stiff, 1.0));
    let balls = damped.into_iter().chain(elastic);
    balls.fold(CaseGroup::new(id, title), |group, (k, restitution)| {
        first_bounce(group, Ball::new(k, restitution, tension, 4.0e-5))
    })
}

/// Adds the first bounce, seen all along: at the last step before touch, then every so many steps until it is well off the floor.
fn first_bounce(group: CaseGroup, ball: Ball) -> CaseGroup {
    let first = (touch()[0] / ball.dt).floor() as u64;
    let (released, release) = first_release(&ball);
    let off = (released + release.overlap / release.speed + 0.02) / ball.dt;
    let last = off.ceil() as u64;
    let every = (last - first) / 40;
    let curve = (0..=40).map(|count| last - (40 - count) * every);
    let curve: Vec<u64> = curve.filter(|step| *step > first).collect();
    let moments = [&[first], &curve[..]].concat();
    group.with(ball.id.clone(), ball.case(moments), move |track, figures| {
        let time = |step: u64| step as f64 * ball.dt;
        let seen = |step: u64| at(track, step).position(0)[1];
        let apart = curve
            .iter()
            .map(|step| (seen(*step) - height(&ball, time(*step))).abs());
        let (released, release) = first_release(&ball);
        let [end, velocity] = ball.flight(track, last, GRAVITY);
        let since = time(last) - released;
        let back = end - velocity * since - 0.5 * GRAVITY * since * since;
        let off = touch()[1] * ball.order();
        figures.because(
            "the scheme has the parabola exactly; rounding of the height in every step",
        );
        let expected = height(&ball, time(first));
        let rounding = first as f64 * f64::EPSILON * HEIGHT;
        let what = "free-fall: height in free fall, m";
        figures.is(what, seen(first), expected, rounding);
        figures.because(
            "order of the step: the dashpot's share c dt/m of the momentum in a step, and (ω dt)²; of the \
             speed at touch",
        );
        let what = "release-velocity: velocity when the floor lets go, m/s";
        figures.is(what, velocity + GRAVITY * since, release.speed, off);
        figures.because("the same velocity over the time since touch");
        let what = "release-height: height when the floor lets go, m";
        let way = off * (released - touch()[0]);
        figures.is(what, back, RADIUS - release.overlap, way);
        let what = "curve: largest distance from y(t), m";
        let way = off * (time(last) - touch()[0]);
        figures.is(what, furthest(0.0, apart), 0.0, way);
    })
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

fn bounces(ball: &Ball, count: usize) -> Vec<Bounce> {
    let [mut time, mut approach] = touch();
    let mut bounces = Vec::new();
    for _ in 0..count {
        let release = ball.contact(approach).release();
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

/// What weight during the contacts takes of the last top, to first order: 4ζg/ω (1/v + 1/v′) a
/// bounce with the speeds v of the approach and v′ of the rebound.
fn weight(ball: &Ball, count: usize) -> f64 {
    let of_one = |bounce: &Bounce| 1.0 / bounce.approach + 1.0 / bounce.rebound;
    let speeds: f64 = bounces(ball, count).iter().map(of_one).sum();
    4.0 * nominal_ratio(ball.restitution) * GRAVITY / ball.contact(0.0).frequency() * speeds
}

/// Some bounces on a soft floor and on one ten times as stiff.
fn repeated_bounces() -> CaseGroup {
    let title = "MFiX DEM02: how high a ball bounces, again and again";
    let mut group = CaseGroup::new("repeated-bounces", title);
    for (restitution, count) in [(1.0, 2), (0.8, 3), (0.6, 2)] {
        let floors = [5.0e4, 5.0e5].map(|k| Ball::new(k, restitution, Tension::Clipped, 1.0e-4));
        let case = |ball: &Ball| {
            let bounces = bounces(ball, count);
            let steps = bounces.iter().map(|bounce| ball.step(bounce.reading));
            ball.case(steps.collect())
        };
        group = group.with_all("", floors.each_ref().map(case), move |tracks, figures| {
            let mut last = [f64::NAN; 2];
            for ((ball, track), last) in floors.iter().zip(tracks).zip(&mut last) {
                figures.case(&ball.id);
                figures.because("order of the step, twice over in a height: c dt/m + (ω dt)² a bounce");
                for (index, bounce) in bounces(ball, count).iter().enumerate() {
                    let step = ball.step(bounce.reading);
                    let [height, velocity] = ball.flight(track, step, GRAVITY);
                    let top = height + 0.5 * velocity * velocity / GRAVITY;
                    let bounces = (index + 1) as f64;
                    let off = (bounce.apex - RADIUS) * (2.0 * ball.order()) * bounces;
                    figures.is(&format!("top-{bounces}, m"), top, bounce.apex, off);
                    *last = top;
                }
            }
            // The top of the last bounce over a rigid floor, m above the lowest place of the centre:
            // (h₀ − R)e^{2n} with the e of the clipped dashpot where nothing weighs.
            let mut weightless = floors[0].contact(1.0);
            weightless.pull = 0.0;
            let speed = weightless.release().speed;
            let rigid = (HEIGHT - RADIUS) * speed.powi(2 * count as i32);
            let [soft, stiff] = last.map(|top| (top - RADIUS) / rigid);
            let [weight_soft, weight_stiff] = floors.each_ref().map(|ball| weight(ball, count));
            let root = ROOT_OF_STIFFER;
            let steps = (root + 1.0) / (root - 1.0) * (2.0 * floors[1].order()) * count as f64;
            figures.case(format!("e-{restitution}"));
            figures.because(
                "hard spheres, (h₀ − R)e^{2n}, are approached as 1/√k; extrapolated from two floors, what is left is the \
                 product of what weight does to both, 4ζg/ω (1/v + 1/v′) a bounce; and the order of the step",
            );
            let limit = (root * stiff - soft) / (root - 1.0);
            let what = "rigid-floor: last top for k → ∞ over that of hard spheres, 1";
            figures.is(what, limit, 1.0, weight_soft * weight_stiff + steps);
        });
    }
    group
}

/// Bounces on a spring with local damping, gravity damped too. The work that is done on the way down is
/// taken 1−α fold, that against the spring 1+α fold, and back; with P = h − R + mg/2k, which measures from
/// the middle of the static sinking, each bounce has exactly ((1−α)/(1+α))² of the P before, whatever k.
fn damped_bounces() -> CaseGroup {
    let title = "Local damping: each bounce has ((1−α)/(1+α))² of the height";
    let mut group = CaseGroup::new("repeated-bounces-local-damping", title);
    for (stiffness, alpha, count) in [
        (5.0e4, 0.1, 2),
        (5.0e5, 0.1, 2),
        (5.0e4, 0.3, 3),
        (5.0e5, 0.3, 3),
    ] {
        let mut ball = Ball::new(stiffness, 1.0, Tension::Clipped, 5.0e-5);
        (ball.id, ball.alpha) = (format!("k-{stiffness:e}/alpha-{alpha}"), alpha);
        let ratio: f64 = (1.0 - alpha) / (1.0 + alpha);
        // Half way up in each bounce; to find it, the floor may count as weightless.
        let fall = |height: f64| (2.0 * height / (GRAVITY * (1.0 - alpha))).sqrt();
        let rise = |height: f64| (2.0 * height / (GRAVITY * (1.0 + alpha))).sqrt();
        let half = 0.5 * std::f64::consts::PI / ball.contact(0.0).frequency();
        let contact = half * (1.0 / (1.0 - alpha).sqrt() + 1.0 / (1.0 + alpha).sqrt());
        let (mut height, mut time) = (HEIGHT - RADIUS, 0.0);
        let mut steps = Vec::new();
        for _ in 0..count {
            time += fall(height) + contact;
            height *= ratio.powi(2);
            steps.push(ball.step(time + 0.5 * rise(height)));
            time += rise(height);
        }
        group = group.with(ball.id.clone(), ball.case(steps.clone()), move |track, figures| {
            let raised = 0.5 * ball.grain().mass * GRAVITY / stiffness - RADIUS;
            let fall = GRAVITY * (1.0 + alpha);
            let start = HEIGHT + raised;
            figures.because(
                "second order in the step, as in bounce-local-damping and twice over in a height: \
                 (1+α)/(1−α)·(ω dt)² a bounce",
            );
            for (count, step) in (1..).zip(&steps) {
                let [height, velocity] = ball.flight(track, *step, fall);
                let apex = height + 0.5 * velocity * velocity / fall;
                let expected = ratio.powi(2 * count);
                let off = expected * f64::from(count) * ball.second_order() / ratio;
                let what = format!(
                    "bounce-{count}: (h − R + mg/2k) over that at the start after bounce {count}, 1"
                );
                figures.is(&what, (apex + raised) / start, expected, off);
            }
        });
    }
    group
}

/// Gravity with the one, the other and both, over several bounces, against the chain of recurrences.
fn recurrence() -> CaseGroup {
    /// Height of the floor, m.
    const FLOOR: f64 = 0.05;
    const STEPS: u64 = 3000;
    let title =
        "Gravity, spring, dashpot and local damping together, over several bounces, to rounding";
    let mut group = CaseGroup::new("leapfrog-drop", title);
    for (id, alpha, ratio) in [
        ("elastic", 0.0, 0.0),
        ("local-damping", 0.2, 0.0),
        ("dashpot", 0.0, 0.1),
        ("local-damping-and-dashpot", 0.1, 0.05),
    ] {
        // A height at which touch falls between two steps.
        let grain = Grain::disc([0.0, FLOOR + 0.0713], 0.05, 1000.0);
        let spring = SpringDashpot {
            dashpot: dashpot(ratio, grain.mass, 2.0e4),
            pull: GRAVITY,
            alpha,
            ..SpringDashpot::spring(grain.mass, 2.0e4, 2.0e-4)
        };
        let moments: Vec<u64> = (0..=10).map(|count| count * (STEPS / 10)).collect();
        let case = on_a_floor(id, &spring, grain, FLOOR, moments.clone());
        group = group.with(id, case, move |track, figures| {
            let overlap = |height: f64| FLOOR + grain.radius - height;
            let start = State::new(0, overlap(grain.position[1]), -grain.velocity[1]);
            let expected = spring.track(start, &moments);
            let seen = |step: u64| {
                let view = at(track, step);
                [overlap(view.position(0)[1]), -view.velocity(0)[1]]
            };
            let height = grain.position[1] - grain.radius - FLOOR;
            let scales = [height, (2.0 * GRAVITY * height).sqrt()];
            let tolerance = random_rounding(STEPS, grain.position[1], height);
            deviations(figures, seen, &expected, scales, tolerance);
        });
    }
    group
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Release times and velocities of MFiX's DEM01, worked out apart from this program.
    #[test]
    fn the_closed_form_has_the_known_releases() {
        use Tension::{Clipped, Unclipped};
        for (stiffness, restitution, tension, time, speed) in [
            (1.0e4, 0.9, Unclipped, 0.397388, 2.475857),
            (1.0e4, 0.9, Clipped, 0.395164, 2.503278),
            (1.0e4, 0.6, Unclipped, 0.401299, 1.491954),
            (1.0e4, 0.6, Clipped, 0.390156, 1.685430),
            (1.0e5, 1.0, Clipped, 0.319116, 2.801428),
            (1.0e5, 0.6, Unclipped, 0.319818, 1.626207),
            (1.0e5, 0.6, Clipped, 0.316376, 1.748693),
        ] {
            let ball = Ball::new(stiffness, restitution, tension, 1.0e-5);
            let (released, release) = first_release(&ball);
            assert!((released - time).abs() < 1.0e-6, "{ball:?}: {released}");
            let off = (release.speed - speed).abs();
            assert!(off < 1.0e-6, "{ball:?}: {}", release.speed);
        }
    }
}
