//! One contact as the leapfrog scheme has it, in closed form: no step is made.
//!
//! With the overlap u_n at the steps and the approach speed w_{n−1/2} = (u_n − u_{n−1})/dt half a step
//! before, the scheme w_{n+1/2} = w_{n−1/2} + dt·f·(g − (k u_n + c w_{n−1/2})/m) is the recurrence
//! u_{n+1} = (2 − κ − γ) u_n − (1 − γ) u_{n−1} + f g dt², κ = f k dt²/m, γ = f c dt/m, whose roots are
//! r e^{±iθ} with r² = 1 − γ and sin²(θ/2) = (κ − γ²/(1 + r)²)/(4r). The factor f of local damping, clipping
//! and parting change from step to step, so a collision is a chain of such solutions.

use super::experiment::largest;
use crate::suite::Line;
use crate::suite::line;

/// Everything that the recurrence depends on. SI units.
#[derive(Debug, Clone, Copy)]
pub struct Scheme {
    /// Mass, of a pair the effective one, kg.
    pub mass: f64,
    /// k, N/m.
    pub stiffness: f64,
    /// c, N·s/m.
    pub dashpot: f64,
    /// Whether the force is never less than zero.
    pub clipped: bool,
    /// g, towards the other body, m/s².
    pub pull: f64,
    /// Cundall's α.
    pub alpha: f64,
    /// s.
    pub dt: f64,
}

/// The state at a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// The number of the step.
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

impl Scheme {
    /// The state at each of these rising steps, from this one on.
    pub fn track(&self, start: State, steps: &[u64]) -> Vec<State> {
        let mut base = start;
        let mut regime = self.regime(&base);
        let mut now = base;
        let mut states = Vec::with_capacity(steps.len());
        for &step in steps {
            while now.step < step {
                now = self.solution(regime, &base, now.step + 1 - base.step);
                let next = self.regime(&now);
                if next != regime {
                    (base, regime) = (now, next);
                }
            }
            states.push(now);
        }
        states
    }

    /// The state at this step of a contact that never lets go.
    pub fn in_touch(&self, start: &State, step: u64) -> State {
        let regime = Regime {
            pressing: true,
            factor: 1.0,
        };
        self.solution(regime, start, step - start.step)
    }

    /// k u + c w, and nothing where the bodies are apart or the dashpot would pull, N.
    pub fn force(&self, state: &State) -> f64 {
        let force = self.stiffness * state.overlap + self.dashpot * state.approach;
        if state.overlap < 0.0 || (self.clipped && force < 0.0) {
            return 0.0;
        }
        force
    }

    fn regime(&self, state: &State) -> Regime {
        let force = self.force(state);
        let acceleration = self.pull - force / self.mass;
        let power = acceleration * (state.approach + 0.5 * self.dt * acceleration);
        let sign = if power == 0.0 { 0.0 } else { power.signum() };
        Regime {
            pressing: force != 0.0 || (state.overlap >= 0.0 && self.dashpot == 0.0),
            factor: 1.0 - self.alpha * sign,
        }
    }

    /// `count` steps after `base` in one and the same regime.
    fn solution(&self, regime: Regime, base: &State, count: u64) -> State {
        let n = count as f64;
        let (overlap, approach) = if regime.pressing {
            self.swing(regime.factor, base, n)
        } else {
            let gain = regime.factor * self.pull * self.dt;
            let fallen = 0.5 * n * (n + 1.0) * gain * self.dt;
            (
                base.overlap + n * self.dt * base.approach + fallen,
                base.approach + n * gain,
            )
        };
        State {
            step: base.step + count,
            overlap,
            approach,
        }
    }

    /// u_n = u* + rⁿ(a cos nθ + b sin nθ) about the rest u* = mg/k.
    fn swing(&self, factor: f64, base: &State, n: f64) -> (f64, f64) {
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
        (rest + decay * swing, decay / r * change / self.dt)
    }
}

/// What rounding may do to an overlap or a speed in so many steps, as a share of its amplitude. Each step
/// rounds a position of the size `reach`, a velocity and a force by up to 2⁻⁵³ of it; the sum of n such is
/// rarely beyond √n of one. Four times that, in units of 2⁻⁵².
pub fn rounding(steps: u64, reach: f64, amplitude: f64) -> f64 {
    4.0 * (steps as f64).sqrt() * f64::EPSILON * (2.0 + reach / amplitude)
}

/// What rounding of the parameters may do to a swing that has turned by this angle (rad), as a share of its
/// amplitude: stiffness, mass and step are each good to some 2⁻⁵², half of which is in the frequency.
pub fn rounding_of_phase(angle: f64) -> f64 {
    2.0 * f64::EPSILON * angle
}

/// Where [`rounding`] comes from, for people.
pub const ROUNDING: &str = "closed form of the scheme itself; left is rounding of position, velocity and force in \
                            every step, which grows as the root of their number";

/// The largest distances of overlap and approach speed from what they should be, as a share of their
/// amplitudes.
pub fn deviations(
    name: &str,
    seen: Vec<State>,
    expected: &[State],
    [amplitude, speed]: [f64; 2],
    tolerance: f64,
) -> Vec<Line> {
    let off = |figure: fn(&State) -> f64, scale: f64| {
        let pairs = seen.iter().zip(expected);
        largest(pairs.map(|(seen, expected)| ((figure(seen) - figure(expected)) / scale).abs()))
    };
    let figures: [(&str, f64); 2] = [
        ("overlap", off(|state| state.overlap, amplitude)),
        ("approach speed", off(|state| state.approach, speed)),
    ];
    let line = |(what, value): (&str, f64)| {
        let quantity = format!("largest deviation of the {what} over its amplitude, {name}");
        line(quantity, "1", value, 0.0, tolerance, ROUNDING)
    };
    figures.into_iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One step after the other, with everything at once.
    fn stepped(scheme: &Scheme, mut state: State, steps: u64) -> State {
        for _ in 0..steps {
            let acceleration = scheme.pull - scheme.force(&state) / scheme.mass;
            let on_step = state.approach + 0.5 * scheme.dt * acceleration;
            let sign = (acceleration * on_step).signum();
            state.approach += scheme.dt * acceleration * (1.0 - scheme.alpha * sign);
            state.overlap += scheme.dt * state.approach;
            state.step += 1;
        }
        state
    }

    #[test]
    fn the_closed_form_is_what_steps_give() {
        for (dashpot, alpha, clipped) in [
            (0.0, 0.0, true),
            (5.0, 0.0, false),
            (5.0, 0.0, true),
            (2.0, 0.3, true),
        ] {
            let scheme = Scheme {
                mass: 1.3,
                stiffness: 200.0,
                dashpot,
                clipped,
                pull: 9.81,
                alpha,
                dt: 0.01,
            };
            let start = State {
                step: 0,
                overlap: -0.5,
                approach: 0.2,
            };
            let steps: Vec<u64> = (1..40).map(|count| 7 * count).collect();
            for state in scheme.track(start, &steps) {
                let known = stepped(&scheme, start, state.step);
                assert!(
                    (state.overlap - known.overlap).abs() < 1.0e-12,
                    "{state:?} {known:?}"
                );
                assert!(
                    (state.approach - known.approach).abs() < 1.0e-11,
                    "{state:?} {known:?}"
                );
            }
        }
    }
}
