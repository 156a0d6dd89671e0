//! A ball that falls on a floor: MFiX-DEM's first verification case.

use super::ball::{Ball, GRAVITY, HEIGHT, RADIUS, touch};
use super::continuum::Release;
use super::experiment::{Experiment, largest, rung, view};
use crate::suite::line;
use crate::suite::{Line, Rung, Track};
use grains::case::Case;
use grains::scene::Tension;

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
    ]
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
