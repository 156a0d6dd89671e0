//! Head-on collisions: rebound and contact time with local damping and with dashpots.

use super::continuum::{dashpot, nominal_ratio};
use super::experiment::{Experiment, rung, view};
use super::head_on::{HeadOn, Partner};
use crate::suite::build::Grain;
use crate::suite::line;
use crate::suite::{Line, Rung, Track};
use grains::case::Case;
use grains::scene::{Tension, Viscosity};

/// The rungs.
pub fn rungs() -> Vec<Rung> {
    vec![
        rung(
            "bounce-local-damping",
            "A spring with local damping gives back √((1−α)/(1+α)) of the speed",
            local_damping(),
        ),
        rung(
            "bounce-dashpot",
            "A spring and a dashpot that does not pull: rebound and contact time, pair and wall",
            dashpots(Tension::Clipped),
        ),
        rung(
            "bounce-dashpot-unclipped",
            "A spring and a dashpot that may pull give back exp(−πζ/√(1−ζ²)) of the speed",
            dashpots(Tension::Unclipped),
        ),
        rung(
            "bounce-restitution",
            "A restitution asked for is the one that comes out, pair and wall",
            restitutions(),
        ),
    ]
}

/// A glass ball of 2 mm and what it meets.
fn bodies() -> [(&'static str, Grain, Partner); 2] {
    let ball = |radius| Grain::sphere([0.0; 2], radius, 2500.0);
    [
        ("wall", ball(1.0e-3), Partner::Wall),
        ("pair", ball(1.0e-3), Partner::Grain(ball(1.7e-3))),
    ]
}

fn head_on(name: String, grain: Grain, partner: Partner) -> HeadOn {
    HeadOn {
        name,
        grain,
        partner,
        stiffness: 2.0e4,
        viscosity: Viscosity::None,
        alpha: 0.0,
        approach: 0.4,
        steps: 1000.0,
        lead: 5.3,
    }
}

/// e = √((1−α)/(1+α)): the grain is slowed down by 1+α times the spring's force and sped up by 1−α
/// times it. Contact time ½T(1/√(1−α) + 1/√(1+α)) with T = π√(m/k).
struct LocalDamping(HeadOn);

fn local_damping() -> Vec<Box<dyn Experiment>> {
    let mut experiments: Vec<Box<dyn Experiment>> = Vec::new();
    for (what, grain, partner) in bodies() {
        for alpha in [0.0, 0.1, 0.3, 0.5, 0.7] {
            let name = format!("{what}, alpha {alpha}");
            let head_on = HeadOn {
                alpha,
                ..head_on(name, grain, partner)
            };
            experiments.push(Box::new(LocalDamping(head_on)));
        }
    }
    experiments
}

impl LocalDamping {
    fn contact_time(&self) -> f64 {
        let alpha = self.0.alpha;
        let period = self.0.steps * self.0.dt();
        0.5 * period * (1.0 / (1.0 - alpha).sqrt() + 1.0 / (1.0 + alpha).sqrt())
    }

    fn end(&self) -> u64 {
        self.0.end(self.contact_time())
    }
}

impl Experiment for LocalDamping {
    fn cases(&self) -> Vec<Case> {
        vec![self.0.case(vec![0, self.end()])]
    }

    fn lines(&self, tracks: &[Track]) -> Vec<Line> {
        let of = &self.0;
        let state = |step| of.state(view(tracks, 0, step), step);
        let [rebound, time] = of.outcome(&state(0), &state(self.end()));
        let alpha = of.alpha;
        let expected = ((1.0 - alpha) / (1.0 + alpha)).sqrt();
        let small = of.angle() * of.angle();
        // At the turning point half a step at most is damped with the wrong sign: work 2αF over the way
        // ½a(dt/2)², of the energy ½F²(1−α)/k; touching and parting between steps, (ω dt)²/8 each.
        let of_rebound = expected * 0.5 * small * (1.0 + alpha) / (1.0 - alpha);
        // The same half step moves the way back by 2α/(1−α) of itself.
        let turning = of.dt() * alpha / (1.0 - alpha);
        vec![
            line(
                format!("restitution, {}", of.name),
                "1",
                rebound,
                expected,
                of_rebound,
                "second order in the step: (1+α)/(1−α)·½(ω dt)² from touching, turning and parting between steps",
            ),
            line(
                format!("contact time, {}", of.name),
                "s",
                time,
                self.contact_time(),
                turning + small * time.abs(),
                "damping turns round at a step, half a step off at most: dt·α/(1−α); (ω dt)² beside it",
            ),
        ]
    }
}

/// How much finer the second run of a dashpot's collision is. Thrice, so that touch falls into the middle
/// between two steps in both and what is left is smooth in the step.
const FINER: f64 = 3.0;

/// A collision with a dashpot at two lengths of the step.
pub struct Rebound {
    /// The coarse run.
    pub coarse: HeadOn,
    /// The restitution that is expected.
    pub restitution: f64,
    /// The contact time that is expected, s.
    pub contact_time: f64,
    /// c_n dt/m_eff of the coarse run: the share of the momentum that the dashpot takes in a step.
    pub share: f64,
}

impl Rebound {
    /// With the dashpot constant and the law of the closed form.
    pub fn of_dashpot(coarse: HeadOn) -> Self {
        let impact = coarse.impact();
        let release = impact.release();
        Rebound {
            restitution: release.speed / coarse.approach,
            contact_time: release.parted(),
            share: impact.dashpot * coarse.dt() / impact.mass,
            coarse,
        }
    }

    fn fine(&self) -> HeadOn {
        HeadOn {
            name: format!("{}, fine", self.coarse.name),
            steps: FINER * self.coarse.steps,
            lead: FINER * self.coarse.lead,
            ..self.coarse.clone()
        }
    }

    /// Of the coarse run, relative.
    fn first_order(&self) -> f64 {
        let lag = 0.5 * self.restitution.ln().abs();
        let letting_go = if self.coarse.clipped() { 0.0 } else { 0.5 };
        (lag + letting_go) * self.share
    }

    /// (ω dt)² + (c dt/m)² of the coarse run.
    fn second_order(&self) -> f64 {
        self.coarse.angle() * self.coarse.angle() + self.share * self.share
    }

    fn runs(&self) -> [HeadOn; 2] {
        [self.coarse.clone(), self.fine()]
    }
}

impl Experiment for Rebound {
    fn cases(&self) -> Vec<Case> {
        let case = |run: &HeadOn| run.case(vec![0, run.end(self.contact_time)]);
        self.runs().iter().map(case).collect()
    }

    fn lines(&self, tracks: &[Track]) -> Vec<Line> {
        let runs = self.runs();
        let outcome = |index: usize| {
            let run = &runs[index];
            let state = |step| run.state(view(tracks, index, step), step);
            run.outcome(&state(0), &state(run.end(self.contact_time)))
        };
        let (coarse, fine) = (outcome(0), outcome(1));
        let limit = |index: usize| (FINER * fine[index] - coarse[index]) / (FINER - 1.0);
        let first = self.first_order() / FINER;
        let second = self.second_order() / 3.0;
        let name = &self.coarse.name;
        vec![
            line(
                format!("restitution, {name}"),
                "1",
                fine[0],
                self.restitution,
                self.restitution * (first + self.second_order()),
                "first order in the step: the dashpot takes the speed of half a step before, as if the mass were \
                 less by ½c dt; twice ¼|ln e| c dt/m, and ½c dt/m where it lets go of a force within a step",
            ),
            line(
                format!("restitution for dt → 0, {name}"),
                "1",
                limit(0),
                self.restitution,
                self.restitution * second,
                "two runs, steps of 3 and 1, first order taken out; left is a third of the coarse run's second \
                 order, (ω dt)² + (c dt/m)²",
            ),
            line(
                format!("contact time for dt → 0, {name}"),
                "s",
                limit(1),
                self.contact_time,
                self.contact_time * second,
                "as the restitution for dt → 0",
            ),
        ]
    }
}

/// Steps of a coarse run in a contact time.
pub const COARSE: f64 = 500.0;

/// A rebound in so many steps, touch in the middle between two of them. A dashpot that pulls lets go
/// of a force, so when it does so within a step matters: it has a whole number of steps in its contact
/// time π/(ω₀√(1−ζ²)), which parts coarse and fine runs at the same place in a step.
pub fn in_steps(steps: f64, ratio: f64, tension: Tension, of: HeadOn) -> HeadOn {
    let steps = match tension {
        Tension::Clipped => steps,
        Tension::Unclipped => steps * (1.0 - ratio * ratio).sqrt(),
    };
    HeadOn {
        steps,
        lead: 5.5,
        ..of
    }
}

fn dashpots(tension: Tension) -> Vec<Box<dyn Experiment>> {
    // Above critical damping a dashpot that pulls never lets go.
    let ratios: &[f64] = match tension {
        Tension::Clipped => &[0.05, 0.2, 0.5, 0.9, 1.5],
        Tension::Unclipped => &[0.05, 0.2, 0.5],
    };
    let mut experiments: Vec<Box<dyn Experiment>> = Vec::new();
    for (what, grain, partner) in bodies() {
        for &ratio in ratios {
            let name = format!("{what}, zeta {ratio}");
            let plain = in_steps(COARSE, ratio, tension, head_on(name, grain, partner));
            let c_n = dashpot(ratio, plain.mass(), plain.stiffness);
            let viscosity = Viscosity::Dashpot { c_n, tension };
            let damped = HeadOn { viscosity, ..plain };
            experiments.push(Box::new(Rebound::of_dashpot(damped)));
        }
    }
    experiments
}

fn restitutions() -> Vec<Box<dyn Experiment>> {
    let mut experiments: Vec<Box<dyn Experiment>> = Vec::new();
    for (what, grain, partner) in bodies() {
        for tension in [Tension::Clipped, Tension::Unclipped] {
            for e_n in [0.2, 0.5, 0.9] {
                let name = format!("{what}, e {e_n}, {tension:?}").to_lowercase();
                let plain = head_on(name, grain, partner);
                let plain = in_steps(300.0, nominal_ratio(e_n), tension, plain);
                experiments.push(Box::new(asked_for(plain, e_n, tension)));
            }
        }
    }
    experiments
}

/// A collision that is asked to have a restitution. Only the contact time needs the dashpot's constant:
/// it is looked for by halving, on the closed form.
fn asked_for(plain: HeadOn, e_n: f64, tension: Tension) -> Rebound {
    let with = |ratio: f64| HeadOn {
        viscosity: Viscosity::Dashpot {
            c_n: dashpot(ratio, plain.mass(), plain.stiffness),
            tension,
        },
        ..plain.clone()
    };
    let rebound = |ratio: f64| Rebound::of_dashpot(with(ratio));
    let (mut low, mut high) = (0.5 * nominal_ratio(e_n), 3.0 * nominal_ratio(e_n).max(0.1));
    if tension == Tension::Unclipped {
        (low, high) = (nominal_ratio(e_n), nominal_ratio(e_n));
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if rebound(middle).restitution > e_n {
            low = middle;
        } else {
            high = middle;
        }
    }
    let found = rebound(0.5 * (low + high));
    Rebound {
        restitution: e_n,
        coarse: HeadOn {
            viscosity: Viscosity::Restitution { e_n, tension },
            ..plain
        },
        ..found
    }
}
