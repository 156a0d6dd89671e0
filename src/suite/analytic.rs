//! One spring and dashpot in closed form: in continuous time, and as the leapfrog scheme has it. No step is made.
//!
//! Continuous: m ü + c u̇ + k u = m g from touch on, u(0) = 0, u̇(0) = v. What a run may be off it follows from the length of
//! the step.
//!
//! The scheme: with the overlap u_n at the steps and the approach speed w_{n−1/2} = (u_n − u_{n−1})/dt half a step before,
//! w_{n+1/2} = w_{n−1/2} + dt·f·(g − (k u_n + c w_{n−1/2})/m) is the recurrence
//! u_{n+1} = (2 − κ − γ) u_n − (1 − γ) u_{n−1} + f g dt², κ = f k dt²/m, γ = f c dt/m, whose roots are
//! r e^{±iθ} with r² = 1 − γ and sin²(θ/2) = (κ − γ²/(1 + r)²)/(4r). The factor f of local damping, clipping
//! and parting change from step to step, so a collision is a chain of such solutions. A run is off it by rounding only.

use super::{Figures, furthest};
use grains::scene::Tension;

/// Everything that a contact along one line depends on. SI units.
#[derive(Debug, Clone, Copy)]
pub struct SpringDashpot {
    /// Mass, of a pair the effective one, kg.
    pub mass: f64,
    /// k, N/m.
    pub stiffness: f64,
    /// c, N·s/m.
    pub dashpot: f64,
    /// Whether the dashpot may pull; none of a body that is held from both sides and never let go.
    pub ends: Option<Tension>,
    /// g, towards the other body, m/s².
    pub pull: f64,
    /// v, the speed at touch, m/s.
    pub approach: f64,
    pub alpha: f64,
    /// s.
    pub dt: f64,
}

/// How a contact ends in continuous time: when it ceases to bear a force.
#[derive(Debug, Clone, Copy)]
pub struct Release {
    /// Since touch, s.
    pub time: f64,
    /// Overlap left, m.
    pub overlap: f64,
    /// Speed of the rebound, m/s.
    pub speed: f64,
}

/// The state at a step of the scheme.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    pub step: u64,
    /// u_n, m, negative before touch.
    pub overlap: f64,
    /// w_{n−1/2}, m/s.
    pub approach: f64,
}

/// What decides which recurrence holds.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Regime {
    /// Whether the contact bears a force.
    pressing: bool,
    /// f = 1 − α·sign of the power.
    factor: f64,
}

impl SpringDashpot {
    /// A spring that pushes as long as the bodies touch, and nothing else.
    pub fn spring(mass: f64, stiffness: f64, dt: f64) -> Self {
        SpringDashpot {
            mass,
            stiffness,
            dashpot: 0.0,
            ends: Some(Tension::Clipped),
            pull: 0.0,
            approach: 0.0,
            alpha: 0.0,
            dt,
        }
    }

    /// A spring that never lets go, with this ω (rad/s).
    pub fn oscillator(omega: f64, dt: f64) -> Self {
        SpringDashpot {
            ends: None,
            ..SpringDashpot::spring(1.0, omega * omega, dt)
        }
    }

    /// √(k/m), rad/s.
    pub fn frequency(&self) -> f64 {
        (self.stiffness / self.mass).sqrt()
    }

    /// c dt/m: the share of the momentum that the dashpot takes in a step.
    pub fn share(&self) -> f64 {
        self.dashpot * self.dt / self.mass
    }

    /// u and u̇ after the time t, as long as the contact bears a force: with β = c/2m and
    /// ω² = k/m − β², u = mg/k + e^{−βt}(A cos ωt + B sin ωt), or cosh and sinh where ω² < 0.
    pub fn at(&self, t: f64) -> [f64; 2] {
        let beta = 0.5 * self.dashpot / self.mass;
        let omega_squared = self.stiffness / self.mass - beta * beta;
        let root = omega_squared.abs().sqrt();
        let (even, odd) = match omega_squared > 0.0 {
            true => ((root * t).cos(), (root * t).sin() / root),
            false => ((root * t).cosh(), (root * t).sinh() / root),
        };
        let rest = self.mass * self.pull / self.stiffness;
        let (a, b) = (-rest, self.approach - beta * rest);
        let decay = (-beta * t).exp();
        let swing = a * even + b * odd;
        let change = -omega_squared * a * odd + b * even;
        [rest + decay * swing, decay * (change - beta * swing)]
    }

    /// Normal force after the time t, N.
    fn force_at(&self, t: f64) -> f64 {
        let [overlap, speed] = self.at(t);
        self.stiffness * overlap + self.dashpot * speed
    }

    /// When the force, or unclipped the overlap, first is zero: by halving.
    pub fn release(&self) -> Release {
        let left = |t: f64| match self.ends {
            Some(Tension::Clipped) => self.force_at(t),
            _ => self.at(t)[0],
        };
        let step = 0.02 * (self.mass / self.stiffness).sqrt();
        let mut low = step;
        while left(low + step) > 0.0 {
            low += step;
        }
        let [low, _] = halved([low, low + step], 100, |t| left(t) > 0.0);
        let [overlap, speed] = self.at(low);
        Release {
            time: low,
            overlap,
            speed: -speed,
        }
    }

    /// ∫ u F dt over the contact, m·N·s: what the overlap takes from the arm of a sliding contact.
    /// Simpson's rule on the closed form.
    pub fn overlap_impulse(&self) -> f64 {
        const PIECES: u32 = 2000;
        let width = self.release().time / f64::from(PIECES);
        let at = |place: f64| {
            let t = place * width;
            self.at(t)[0] * self.force_at(t)
        };
        let sum = (0..PIECES).map(|piece| {
            let from = f64::from(piece);
            at(from) + 4.0 * at(from + 0.5) + at(from + 1.0)
        });
        sum.sum::<f64>() * width / 6.0
    }

    /// The state at each of these rising steps, from this one on.
    pub fn track(&self, start: State, steps: &[u64]) -> Vec<State> {
        let mut states = Vec::with_capacity(steps.len());
        let mut wanted = steps.iter().peekable();
        let last = steps.last().copied().unwrap_or(0);
        self.chain(start, last, &mut |now, _| {
            while wanted.next_if(|step| **step <= now.step).is_some() {
                states.push(*now);
            }
        });
        states
    }

    /// The steps, up to `last`, from which local damping takes again from what speeds the body up: its turning points.
    pub fn turns(&self, start: State, last: u64) -> Vec<u64> {
        let mut before = self.regime(&start).factor;
        let mut turns = Vec::new();
        self.chain(start, last, &mut |now, regime| {
            if regime.factor < before {
                turns.push(now.step);
            }
            before = regime.factor;
        });
        turns
    }

    /// Shows every state from `start` to the step `last`, and the regime that follows it.
    fn chain(&self, start: State, last: u64, seen: &mut dyn FnMut(&State, Regime)) {
        let (mut base, mut now) = (start, start);
        let mut regime = self.regime(&base);
        seen(&now, regime);
        while now.step < last {
            now = self.solution(regime, &base, now.step + 1 - base.step);
            let next = self.regime(&now);
            if next != regime {
                (base, regime) = (now, next);
            }
            seen(&now, regime);
        }
    }

    /// The state at this step of a contact that never lets go, without local damping.
    pub fn in_touch(&self, start: &State, step: u64) -> State {
        self.swing(1.0, start, step - start.step)
    }

    /// k u + c w, and nothing where the contact bears no force, N.
    pub fn force(&self, state: &State) -> f64 {
        let force = self.stiffness * state.overlap + self.dashpot * state.approach;
        let bears = force >= 0.0 || self.ends != Some(Tension::Clipped);
        if bears && self.touches(state) {
            force
        } else {
            0.0
        }
    }

    fn touches(&self, state: &State) -> bool {
        state.overlap >= 0.0 || self.ends.is_none()
    }

    fn regime(&self, state: &State) -> Regime {
        let force = self.force(state);
        let acceleration = self.pull - force / self.mass;
        let power = acceleration * (state.approach + 0.5 * self.dt * acceleration);
        let sign = if power == 0.0 { 0.0 } else { power.signum() };
        Regime {
            pressing: force != 0.0 || (self.touches(state) && self.dashpot == 0.0),
            factor: 1.0 - self.alpha * sign,
        }
    }

    /// `count` steps after `base` in one and the same regime.
    fn solution(&self, regime: Regime, base: &State, count: u64) -> State {
        if regime.pressing {
            return self.swing(regime.factor, base, count);
        }
        let n = count as f64;
        let gain = regime.factor * self.pull * self.dt;
        let fallen = 0.5 * n * (n + 1.0) * gain * self.dt;
        let overlap = base.overlap + n * self.dt * base.approach + fallen;
        State::new(base.step + count, overlap, base.approach + n * gain)
    }

    /// u_n = u* + rⁿ(a cos nθ + b sin nθ) about the rest u* = mg/k.
    fn swing(&self, factor: f64, base: &State, count: u64) -> State {
        let n = count as f64;
        let kappa = factor * self.stiffness * self.dt * self.dt / self.mass;
        let gamma = factor * self.dashpot * self.dt / self.mass;
        let r = (1.0 - gamma).sqrt();
        let half = gamma / (1.0 + r);
        let sine_squared = (kappa - half * half) / (4.0 * r);
        let theta = 2.0 * sine_squared.sqrt().asin();
        // cos θ − r, without the difference of two numbers near 1.
        let beyond = half - 2.0 * sine_squared;
        let rest = self.mass * self.pull / self.stiffness;
        let a = base.overlap - rest;
        let b = (a * beyond + r * base.approach * self.dt) / theta.sin();
        let decay = (0.5 * n * (-gamma).ln_1p()).exp();
        let (sine, cosine) = (n * theta).sin_cos();
        let swing = a * cosine + b * sine;
        let change = -beyond * swing - theta.sin() * (a * sine - b * cosine);
        let approach = decay / r * change / self.dt;
        State::new(base.step + count, rest + decay * swing, approach)
    }
}

impl Release {
    /// From touch until the surfaces part, without a pull, s: the overlap that is left goes at the
    /// speed of the rebound.
    pub fn parted(&self) -> f64 {
        self.time + self.overlap / self.speed
    }
}

impl State {
    pub fn new(step: u64, overlap: f64, approach: f64) -> Self {
        State {
            step,
            overlap,
            approach,
        }
    }
}

/// The ends of an interval halved so many times; what `is_low` says of a place holds at the lower end alone.
pub fn halved([mut low, mut high]: [f64; 2], times: u32, is_low: impl Fn(f64) -> bool) -> [f64; 2] {
    for _ in 0..times {
        let middle = 0.5 * (low + high);
        let end = if is_low(middle) { &mut low } else { &mut high };
        *end = middle;
    }
    [low, high]
}

/// ζ of a dashpot whose collisions, pulling included, have the restitution e: from
/// e = exp(−πζ/√(1 − ζ²)), ζ = |ln e|/√(π² + ln²e).
pub fn nominal_ratio(restitution: f64) -> f64 {
    let logarithm = restitution.ln().abs();
    logarithm / std::f64::consts::PI.hypot(logarithm)
}

/// c = 2ζ√(m k), N·s/m.
pub fn dashpot(ratio: f64, mass: f64, stiffness: f64) -> f64 {
    2.0 * ratio * (mass * stiffness).sqrt()
}

/// What rounding may do to an overlap or a speed in so many steps, as a share of its amplitude. Each step
/// rounds a position of the size `reach`, a velocity and a force by up to 2⁻⁵³ of it; the sum of n such is
/// rarely beyond √n of one. Four times that, in units of 2⁻⁵².
pub fn random_rounding(steps: u64, reach: f64, amplitude: f64) -> f64 {
    4.0 * (steps as f64).sqrt() * f64::EPSILON * (2.0 + reach / amplitude)
}

/// What rounding of the parameters may do to a swing that has turned by this angle (rad), as a share of its
/// amplitude: stiffness, mass and step are each good to some 2⁻⁵², half of which is in the frequency.
pub fn rounding_of_phase(angle: f64) -> f64 {
    2.0 * f64::EPSILON * angle
}

/// Where [`random_rounding`] comes from, for people.
pub const ROUNDING: &str = "closed form of the scheme itself; left is rounding of position, velocity and force in \
                            every step, which grows as the root of their number";

/// The largest distances of what is seen of overlap and approach speed from what they should be, as a share of their amplitudes.
pub fn deviations(
    figures: &mut Figures,
    seen: impl Fn(u64) -> [f64; 2],
    expected: &[State],
    amplitudes: [f64; 2],
    tolerance: f64,
) {
    figures.because(ROUNDING);
    for (part, (id, what)) in [("overlap", "overlap"), ("approach", "approach speed")]
        .into_iter()
        .enumerate()
    {
        let off = expected.iter().map(|state| {
            let expected = [state.overlap, state.approach][part];
            ((seen(state.step)[part] - expected) / amplitudes[part]).abs()
        });
        let what = format!("{id}: largest deviation of the {what} over its amplitude, 1");
        figures.is(&what, furthest(0.0, off), 0.0, tolerance);
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use grains::model::damping_ratio;

    fn impact(ratio: f64, tension: Tension) -> SpringDashpot {
        SpringDashpot {
            dashpot: dashpot(ratio, 2.0, 50.0),
            ends: Some(tension),
            approach: 3.0,
            ..SpringDashpot::spring(2.0, 50.0, 0.01)
        }
    }

    /// Schwager and Pöschel's formula, which the program uses where a restitution is asked for, says
    /// the same of clipped dashpots as the equation of motion.
    #[test]
    fn both_ways_to_the_restitution_agree() {
        for restitution in [0.05, 0.2, 0.5, 0.9] {
            for tension in [Tension::Clipped, Tension::Unclipped] {
                let ratio = damping_ratio(restitution, tension);
                let release = impact(ratio, tension).release();
                let off = release.speed / 3.0 / restitution - 1.0;
                assert!(off.abs() < 1.0e-9, "{restitution} {tension:?}: {off}");
            }
        }
    }

    /// ∫ u k u dt over half a swing of amplitude A is ½π k A²/ω.
    #[test]
    fn the_overlap_impulse_of_a_spring_is_known() {
        let known = 0.5 * PI * 50.0 * 0.6 * 0.6 / 5.0;
        let found = impact(0.0, Tension::Clipped).overlap_impulse();
        assert!((found / known - 1.0).abs() < 1.0e-9);
    }

    /// One step after the other, with everything at once.
    fn stepped(contact: &SpringDashpot, mut state: State, steps: u64) -> State {
        for _ in 0..steps {
            let acceleration = contact.pull - contact.force(&state) / contact.mass;
            let on_step = state.approach + 0.5 * contact.dt * acceleration;
            let sign = (acceleration * on_step).signum();
            state.approach += contact.dt * acceleration * (1.0 - contact.alpha * sign);
            state.overlap += contact.dt * state.approach;
            state.step += 1;
        }
        state
    }

    #[test]
    fn the_closed_form_is_what_steps_give() {
        use Tension::{Clipped, Unclipped};
        for (dashpot, alpha, ends) in [
            (0.0, 0.0, Some(Clipped)),
            (5.0, 0.0, Some(Unclipped)),
            (5.0, 0.0, Some(Clipped)),
            (2.0, 0.3, Some(Clipped)),
            (0.0, 0.3, None),
        ] {
            let spring = SpringDashpot {
                dashpot,
                ends,
                pull: ends.map_or(0.0, |_| 9.81),
                alpha,
                ..SpringDashpot::spring(1.3, 200.0, 0.01)
            };
            let start = State::new(0, -0.5, 0.2);
            let steps: Vec<u64> = (0..40).map(|count| 7 * count).collect();
            let track = spring.track(start, &steps);
            assert_eq!(track.len(), steps.len());
            for state in track {
                let known = stepped(&spring, start, state.step);
                let off = (state.overlap - known.overlap).abs();
                assert!(off < 1.0e-12, "{state:?} {known:?}");
                let off = (state.approach - known.approach).abs();
                assert!(off < 1.0e-11, "{state:?} {known:?}");
            }
        }
    }
}
