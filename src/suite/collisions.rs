//! Head-on collisions without gravity, of a grain with a wall or of two grains whose centre of mass is at rest.

use std::f64::consts::PI;

use super::analytic::{
    SpringDashpot, State, dashpot, deviations, halved, nominal_ratio, random_rounding,
    rounding_of_phase,
};
use crate::suite::{self, CaseGroup, Grain, Track, at};
use grains::model::Law;
use grains::scene::{Tension, Viscosity};
use grains::task::Case;

pub fn groups() -> Vec<CaseGroup> {
    use Tension::{Clipped, Unclipped};
    vec![
        local_damping(),
        rebounds(
            "bounce-dashpot",
            "A spring and a dashpot that does not pull: rebound and contact time, pair and wall",
            Clipped,
            glass_at(&[0.05, 0.2, 0.5, 0.9, 1.5]),
        ),
        // Above critical damping a dashpot that pulls never lets go.
        rebounds(
            "bounce-dashpot-unclipped",
            "A spring and a dashpot that may pull give back exp(−πζ/√(1−ζ²)) of the speed",
            Unclipped,
            glass_at(&[0.05, 0.2, 0.5]),
        ),
        restitutions(),
        squeezed(recurrence(
            "leapfrog-spring",
            "Springs swing as the leapfrog recurrence, to rounding",
            |_| (0.0, Viscosity::None),
        )),
        recurrence(
            "leapfrog-dashpot",
            "A spring and a dashpot that does not pull follow the damped recurrence, to rounding",
            |plain| (0.0, plain.damped(0.3, Clipped)),
        ),
        recurrence(
            "leapfrog-dashpot-unclipped",
            "A spring and a dashpot that may pull follow the damped recurrence, to rounding",
            |plain| (0.0, plain.damped(0.3, Unclipped)),
        ),
        recurrence(
            "leapfrog-local-damping",
            "Springs with local damping follow a recurrence on the way in and one on the way out, to rounding",
            |_| (0.3, Viscosity::None),
        ),
    ]
}

/// A collision: along one line, unless its grains move across it or spin.
#[derive(Debug, Clone)]
pub struct HeadOn {
    pub id: String,
    /// The first grain; where it is and how fast it approaches is put in here.
    pub grain: Grain,
    /// The grain to its right that it meets; none for a wall below it.
    pub other: Option<Grain>,
    /// k_n, N/m.
    pub stiffness: f64,
    /// Its dashpot, if any.
    pub viscosity: Viscosity,
    pub alpha: f64,
    /// Speed of the approach, m/s.
    pub approach: f64,
    /// Steps in the contact time of the spring alone, π√(m_eff/k).
    pub steps: f64,
    /// Steps before touch; half a step in it makes the first step with a force begin at touch.
    pub lead: f64,
}

impl HeadOn {
    /// Without dashpot and local damping.
    pub fn new(id: String, grain: Grain, other: Option<Grain>, stiffness: f64, speed: f64) -> Self {
        HeadOn {
            id,
            grain,
            other,
            stiffness,
            viscosity: Viscosity::None,
            alpha: 0.0,
            approach: speed,
            steps: 1000.0,
            lead: 5.3,
        }
    }

    /// m_eff, kg.
    pub fn mass(&self) -> f64 {
        let one = self.grain.mass;
        self.other
            .map_or(one, |other| one * other.mass / (one + other.mass))
    }

    /// √(k/m_eff), rad/s.
    pub fn frequency(&self) -> f64 {
        (self.stiffness / self.mass()).sqrt()
    }

    /// s.
    pub fn dt(&self) -> f64 {
        PI / (self.frequency() * self.steps)
    }

    /// ω dt.
    pub fn angle(&self) -> f64 {
        PI / self.steps
    }

    /// A dashpot of this ζ.
    pub fn damped(&self, ratio: f64, tension: Tension) -> Viscosity {
        let c_n = dashpot(ratio, self.mass(), self.stiffness);
        Viscosity::Dashpot { c_n, tension }
    }

    /// The contact in closed form; not for a dashpot that is given by its restitution.
    pub fn contact(&self) -> SpringDashpot {
        let (dashpot, tension) = match self.viscosity {
            Viscosity::Dashpot { c_n, tension } => (c_n, tension),
            Viscosity::Restitution { tension, .. } | Viscosity::Ratio { tension, .. } => {
                (0.0, tension)
            }
            Viscosity::None => (0.0, Tension::Clipped),
        };
        SpringDashpot {
            dashpot,
            ends: Some(tension),
            approach: self.approach,
            alpha: self.alpha,
            ..SpringDashpot::spring(self.mass(), self.stiffness, self.dt())
        }
    }

    /// Before touch.
    pub fn start(&self) -> State {
        State::new(0, -self.lead * self.dt() * self.approach, self.approach)
    }

    /// A step by which a contact of this duration (s) is over.
    pub fn end(&self, duration: f64) -> u64 {
        (self.lead + 1.02 * duration / self.dt() + 3.0).ceil() as u64
    }

    /// Height of the wall, m; not zero, so that a fault in it shows.
    pub fn floor(&self) -> f64 {
        0.5 * self.grain.radius
    }

    fn case(&self, moments: Vec<u64>) -> Case {
        self.case_of(suite::springs, moments)
    }

    /// The case under the law with this modulus, to which the dashpot is added.
    pub fn case_of(&self, law: impl Fn(f64) -> Law, moments: Vec<u64>) -> Case {
        let one = self.grain;
        let [across, up] = one.velocity;
        let (modulus, grains) = match self.other {
            None => {
                let height = self.floor() + one.radius - self.start().overlap;
                let grain = one.at([0.0, height]).moving([across, -self.approach]);
                (self.stiffness / one.radius, vec![grain])
            }
            Some(other) => {
                let sum = one.radius + other.radius;
                let share = other.mass / (one.mass + other.mass);
                let place = [sum - self.start().overlap, 0.0];
                let speeds = [share, share - 1.0].map(|share| share * self.approach);
                let grains = vec![
                    one.at([0.0; 2]).moving([speeds[0], up]),
                    other.at(place).moving([speeds[1], other.velocity[1]]),
                ];
                let modulus = self.stiffness * sum / (2.0 * one.radius * other.radius);
                (modulus, grains)
            }
        };
        let law = match self.viscosity {
            Viscosity::None => law(modulus),
            _ => suite::with_viscosity(law(modulus), self.viscosity.clone()),
        };
        let floor = [self.floor()];
        let walls: [&[f64]; 2] = [&[], if self.other.is_none() { &floor } else { &[] }];
        let model = suite::world(law, self.dt(), [0.0; 2], self.alpha, walls);
        suite::case(&self.id, model, &grains, moments)
    }

    /// Overlap and approach speed at a step.
    fn state(&self, track: &Track, step: u64) -> State {
        let view = at(track, step);
        let ([x, z], [vx, vz]) = (view.position(0), view.velocity(0));
        let Some(other) = self.other else {
            return State::new(step, self.floor() + self.grain.radius - z, -vz);
        };
        let sum = self.grain.radius + other.radius;
        let overlap = sum - (view.position(1)[0] - x);
        State::new(step, overlap, vx - view.velocity(1)[0])
    }

    /// Restitution and contact time (s) from states before touch and after the surfaces have parted: in
    /// between nothing but the contact acts, so the straight ways tell when the surfaces met and parted.
    fn outcome(&self, track: &Track, end: u64) -> [f64; 2] {
        let (before, after) = (self.state(track, 0), self.state(track, end));
        let at = |state: &State| state.step as f64 * self.dt() - state.overlap / state.approach;
        [-after.approach / before.approach, at(&after) - at(&before)]
    }
}

/// A glass ball of 2 mm that meets a wall, and one that meets another ball.
fn glass(id: impl Fn(&str) -> String) -> [HeadOn; 2] {
    let ball = |radius| Grain::sphere([0.0; 2], radius, 2500.0);
    let impact = |what, other| HeadOn::new(id(what), ball(1.0e-3), other, 2.0e4, 0.4);
    [impact("wall", None), impact("pair", Some(ball(1.7e-3)))]
}

/// e = √((1−α)/(1+α)): the grain is slowed down by 1+α times the spring's force and sped up by 1−α
/// times it. Contact time ½T(1/√(1−α) + 1/√(1+α)) with T = π√(m/k).
fn local_damping() -> CaseGroup {
    let title = "A spring with local damping gives back √((1−α)/(1+α)) of the speed";
    let mut group = CaseGroup::new("bounce-local-damping", title);
    for alpha in [0.0, 0.1, 0.3, 0.5, 0.7] {
        for plain in glass(|what| format!("{what}/alpha-{alpha}")) {
            let impact = HeadOn { alpha, ..plain };
            let period = impact.steps * impact.dt();
            let duration = 0.5 * period * (1.0 / (1.0 - alpha).sqrt() + 1.0 / (1.0 + alpha).sqrt());
            let end = impact.end(duration);
            group = group.with(impact.id.clone(), impact.case(vec![0, end]), move |track, figures| {
                let [rebound, time] = impact.outcome(track, end);
                let expected = ((1.0 - alpha) / (1.0 + alpha)).sqrt();
                let small = impact.angle() * impact.angle();
                // At the turning point half a step at most is damped with the wrong sign: work 2αF over the way
                // ½a(dt/2)², of the energy ½F²(1−α)/k; touching and parting between steps, (ω dt)²/8 each.
                let of_rebound = expected * 0.5 * small * (1.0 + alpha) / (1.0 - alpha);
                // The same half step moves the way back by 2α/(1−α) of itself.
                let turning = impact.dt() * alpha / (1.0 - alpha);
                figures.because(
                    "second order in the step: (1+α)/(1−α)·½(ω dt)² from touching, turning and parting between steps",
                );
                figures.is("restitution, 1", rebound, expected, of_rebound);
                figures.because(
                    "damping turns round at a step, half a step off at most: dt·α/(1−α); (ω dt)² beside it",
                );
                let off = turning + small * time.abs();
                figures.is("contact-time, s", time, duration, off);
            });
        }
    }
    group
}

/// How much finer the second run of a dashpot's collision is. Thrice, so that touch falls into the middle
/// between two steps in both and what is left is smooth in the step.
const FINER: f64 = 3.0;

/// A collision with a dashpot at two lengths of the step.
struct Rebound {
    coarse: HeadOn,
    /// The restitution and the contact time (s) that are expected.
    restitution: f64,
    contact_time: f64,
    /// c_n dt/m_eff of the coarse run: the share of the momentum that the dashpot takes in a step.
    share: f64,
}

impl Rebound {
    /// With a dashpot of this ζ.
    fn of_dashpot(ratio: f64, tension: Tension, plain: &HeadOn) -> Self {
        let mut coarse = plain.clone();
        if ratio != 0.0 {
            coarse.viscosity = plain.damped(ratio, tension);
        }
        let contact = coarse.contact();
        let release = contact.release();
        Rebound {
            restitution: release.speed / coarse.approach,
            contact_time: release.parted(),
            share: contact.share(),
            coarse,
        }
    }

    fn add_to(self, group: CaseGroup) -> CaseGroup {
        let mut fine = self.coarse.clone();
        fine.id += "/fine";
        (fine.steps, fine.lead) = (FINER * fine.steps, FINER * fine.lead);
        let runs = [self.coarse.clone(), fine];
        let case = |run: &HeadOn| run.case(vec![0, run.end(self.contact_time)]);
        group.with_all(self.coarse.id.clone(), runs.each_ref().map(case), move |tracks, figures| {
            let outcome = |i: usize| runs[i].outcome(&tracks[i], runs[i].end(self.contact_time));
            let (coarse, fine) = (outcome(0), outcome(1));
            let limit = |index: usize| (FINER * fine[index] - coarse[index]) / (FINER - 1.0);
            let lag = 0.5 * self.restitution.ln().abs();
            let lets_go = match self.coarse.contact().ends {
                Some(Tension::Clipped) => 0.0,
                _ => 0.5,
            };
            let first = (lag + lets_go) * self.share / FINER;
            let angle = self.coarse.angle();
            let second = angle * angle + self.share * self.share;
            figures.because(
                "first order in the step: the dashpot takes the speed of half a step before, as if the mass were \
                 less by ½c dt; twice ¼|ln e| c dt/m, and ½c dt/m where it lets go of a force within a step",
            );
            let expected = self.restitution;
            let off = expected * (first + second);
            figures.is("restitution, 1", fine[0], expected, off);
            figures.because(
                "two runs, steps of 3 and 1, first order taken out; left is a third of the coarse run's second \
                 order, (ω dt)² + (c dt/m)²",
            );
            let off = second / 3.0;
            let what = "restitution-limit: restitution for dt → 0, 1";
            figures.is(what, limit(0), expected, expected * off);
            let what = "contact-time-limit: contact time for dt → 0, s";
            let time = self.contact_time;
            figures.is(what, limit(1), time, time * off);
        })
    }
}

/// A rebound in so many steps, touch in the middle between two of them. A dashpot that pulls lets go
/// of a force, so when it does so within a step matters: it has a whole number of steps in its contact
/// time π/(ω₀√(1−ζ²)), which parts coarse and fine runs at the same place in a step.
fn in_steps(steps: f64, ratio: f64, tension: Tension, mut impact: HeadOn) -> HeadOn {
    impact.lead = 5.5;
    impact.steps = match tension {
        Tension::Clipped => steps,
        Tension::Unclipped => steps * (1.0 - ratio * ratio).sqrt(),
    };
    impact
}

/// Rebounds with dashpots of these ζ.
fn rebounds(
    id: &'static str,
    title: &'static str,
    tension: Tension,
    runs: Vec<(f64, HeadOn)>,
) -> CaseGroup {
    let group = CaseGroup::new(id, title);
    runs.into_iter().fold(group, |group, (ratio, plain)| {
        let plain = in_steps(500.0, ratio, tension, plain);
        Rebound::of_dashpot(ratio, tension, &plain).add_to(group)
    })
}

fn glass_at(ratios: &[f64]) -> Vec<(f64, HeadOn)> {
    let runs =
        |ratio: &f64| glass(|what| format!("{what}/zeta-{ratio}")).map(|impact| (*ratio, impact));
    ratios.iter().flat_map(runs).collect()
}

/// Collisions that are asked to have a restitution. Only the contact time needs the dashpot's constant:
/// it is looked for by halving, on the closed form.
fn restitutions() -> CaseGroup {
    let title = "A restitution asked for is the one that comes out, pair and wall";
    let mut group = CaseGroup::new("bounce-restitution", title);
    for (name, tension) in [
        ("clipped", Tension::Clipped),
        ("unclipped", Tension::Unclipped),
    ] {
        for e_n in [0.2, 0.5, 0.9] {
            let nominal = nominal_ratio(e_n);
            for plain in glass(|what| format!("{what}/e-{e_n}/{name}")) {
                let plain = in_steps(300.0, nominal, tension, plain);
                let rebound = |ratio: f64| Rebound::of_dashpot(ratio, tension, &plain);
                let (low, high) = match tension {
                    Tension::Clipped => (0.5 * nominal, 3.0 * nominal.max(0.1)),
                    Tension::Unclipped => (nominal, nominal),
                };
                let [low, high] = halved([low, high], 60, |ratio| rebound(ratio).restitution > e_n);
                let mut found = rebound(0.5 * (low + high));
                found.restitution = e_n;
                found.coarse.viscosity = Viscosity::Restitution { e_n, tension };
                group = found.add_to(group);
            }
        }
    }
    group
}

/// Soft unequal grains, and one of them at a wall, at some steps of the contact and after it, against the chain of
/// recurrences. Steps are long on purpose; the scheme is solved, not approximated. α and the dashpot are given; ζ = 0.3 parts a
/// clipped and a pulling dashpot well.
fn recurrence(
    id: &'static str,
    title: &'static str,
    law: fn(&HeadOn) -> (f64, Viscosity),
) -> CaseGroup {
    let mut group = CaseGroup::new(id, title);
    let grain = Grain::disc([0.0; 2], 0.01, 2000.0);
    let other = Some(Grain::sphere([0.0; 2], 0.015, 60_000.0));
    for (id, other) in [("wall", None), ("pair", other)] {
        let mut impact = HeadOn::new(id.to_owned(), grain, other, 3.0e5, 1.0);
        (impact.steps, impact.lead) = (100.0, 3.3);
        // As deep as a third of the radius, so that rounding is small beside it.
        impact.approach = 0.33 * impact.grain.radius * impact.frequency();
        (impact.alpha, impact.viscosity) = law(&impact);
        let later = [0.02, 0.25, 0.5, 0.75, 1.6];
        let later = later.map(|share| (impact.lead + share * impact.steps).round() as u64);
        let moments = [&[0, 1], &later[..]].concat();
        let case = impact.case(moments.clone());
        group = group.with(impact.id.clone(), case, move |track, figures| {
            let seen = |step: u64| {
                let state = impact.state(track, step);
                [state.overlap, state.approach]
            };
            let expected = impact.contact().track(impact.start(), &moments);
            let amplitude = impact.approach / impact.frequency();
            let steps = expected.last().map_or(0, |state| state.step);
            let tolerance = random_rounding(steps, 3.0 * impact.grain.radius, amplitude);
            let scales = [amplitude, impact.approach];
            deviations(figures, seen, &expected, scales, tolerance);
        });
    }
    group
}

/// Adds a grain squeezed between two walls: always in touch with both, so a fault in stiffness, mass, radius
/// or step grows from swing to swing. m ü = −2k u with the distance u to the left of the middle.
fn squeezed(group: CaseGroup) -> CaseGroup {
    /// k of one spring, N/m.
    const STIFFNESS: f64 = 1.0e5;
    /// Place of the left wall, overlap with both walls in the middle, and the way at the start, less than that, m.
    const LEFT: f64 = 0.004;
    const SQUEEZE: f64 = 0.002;
    const AMPLITUDE: f64 = 0.0015;
    /// θ of the recurrence, rad: about twenty steps in a swing.
    const ANGLE: f64 = 0.3;
    const STEPS: u64 = 5000;
    const MOMENTS: [u64; 7] = [0, 1, 10, 100, 1000, STEPS - 7, STEPS];
    let middle = LEFT + 0.01 - SQUEEZE;
    let grain = Grain::disc([middle - AMPLITUDE, 0.0], 0.01, 2000.0);
    // sin(θ/2) = ½ω dt.
    let dt = 2.0 * (0.5 * ANGLE).sin() * (grain.mass / (2.0 * STIFFNESS)).sqrt();
    let right = LEFT + 2.0 * (grain.radius - SQUEEZE);
    let law = suite::springs(STIFFNESS / grain.radius);
    let model = suite::world(law, dt, [0.0; 2], 0.0, [&[LEFT, right], &[]]);
    let case = suite::case("squeezed", model, &[grain], MOMENTS.to_vec());
    group.with("squeezed", case, move |track, figures| {
        let spring = SpringDashpot::spring(grain.mass, 2.0 * STIFFNESS, dt);
        let start = State::new(0, AMPLITUDE, 0.0);
        let expected = MOMENTS.map(|step| spring.in_touch(&start, step));
        let seen = |step: u64| {
            let view = at(track, step);
            [middle - view.position(0)[0], -view.velocity(0)[0]]
        };
        let scales = [AMPLITUDE, AMPLITUDE * spring.frequency()];
        let tolerance =
            random_rounding(STEPS, middle, AMPLITUDE) + rounding_of_phase(STEPS as f64 * ANGLE);
        deviations(figures, seen, &expected, scales, tolerance);
    })
}
