//! One contact in continuous time: linear spring, dashpot and a constant pull, in closed form.

/// From touch on: m ü + c u̇ + k u = m g, u(0) = 0, u̇(0) = v, with the overlap u.
#[derive(Debug, Clone, Copy)]
pub struct Impact {
    /// Mass, of a pair the effective one, kg.
    pub mass: f64,
    /// k, N/m.
    pub stiffness: f64,
    /// c, N·s/m.
    pub dashpot: f64,
    /// g, towards the other body, m/s².
    pub pull: f64,
    /// v, m/s.
    pub approach: f64,
    /// Whether the force is never less than zero; otherwise it pulls until the overlap is zero.
    pub clipped: bool,
}

/// How a contact ends: when it ceases to bear a force.
#[derive(Debug, Clone, Copy)]
pub struct Release {
    /// Since touch, s.
    pub time: f64,
    /// Overlap left, m.
    pub overlap: f64,
    /// Speed of the rebound, m/s.
    pub speed: f64,
}

impl Impact {
    /// u and u̇ after the time t, as long as the contact bears a force: with β = c/2m and
    /// ω² = k/m − β², u = mg/k + e^{−βt}(A cos ωt + B sin ωt), or cosh and sinh where ω² < 0.
    pub fn at(&self, t: f64) -> [f64; 2] {
        let beta = 0.5 * self.dashpot / self.mass;
        let omega_squared = self.stiffness / self.mass - beta * beta;
        let root = omega_squared.abs().sqrt();
        let (even, odd) = if omega_squared > 0.0 {
            ((root * t).cos(), (root * t).sin() / root)
        } else {
            ((root * t).cosh(), (root * t).sinh() / root)
        };
        let rest = self.mass * self.pull / self.stiffness;
        let (a, b) = (-rest, self.approach - beta * rest);
        let decay = (-beta * t).exp();
        let swing = a * even + b * odd;
        let change = -omega_squared * a * odd + b * even;
        [rest + decay * swing, decay * (change - beta * swing)]
    }

    /// Normal force after the time t, N.
    pub fn force(&self, t: f64) -> f64 {
        let [overlap, speed] = self.at(t);
        self.stiffness * overlap + self.dashpot * speed
    }

    /// When the force, or unclipped the overlap, first is zero: by halving.
    pub fn release(&self) -> Release {
        let left = |t: f64| {
            if self.clipped {
                self.force(t)
            } else {
                self.at(t)[0]
            }
        };
        let step = 0.02 * (self.mass / self.stiffness).sqrt();
        let mut low = step;
        while left(low + step) > 0.0 {
            low += step;
        }
        let mut high = low + step;
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if left(middle) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
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
            self.at(t)[0] * self.force(t)
        };
        let sum: f64 = (0..PIECES)
            .map(|piece| {
                let from = f64::from(piece);
                at(from) + 4.0 * at(from + 0.5) + at(from + 1.0)
            })
            .sum();
        sum * width / 6.0
    }
}

impl Release {
    /// From touch until the surfaces part, without a pull, s: the overlap that is left goes at the
    /// speed of the rebound.
    pub fn parted(&self) -> f64 {
        self.time + self.overlap / self.speed
    }
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

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use grains::model::damping_ratio;
    use grains::scene::Tension;

    fn impact(ratio: f64, clipped: bool) -> Impact {
        Impact {
            mass: 2.0,
            stiffness: 50.0,
            dashpot: dashpot(ratio, 2.0, 50.0),
            pull: 0.0,
            approach: 3.0,
            clipped,
        }
    }

    /// Schwager and Pöschel's formula, which the program uses where a restitution is asked for, says
    /// the same of clipped dashpots as the equation of motion.
    #[test]
    fn both_ways_to_the_restitution_agree() {
        for restitution in [0.05, 0.2, 0.5, 0.9] {
            for (tension, clipped) in [(Tension::Clipped, true), (Tension::Unclipped, false)] {
                let release = impact(damping_ratio(restitution, tension), clipped).release();
                let off = release.speed / 3.0 / restitution - 1.0;
                assert!(off.abs() < 1.0e-9, "{restitution} {tension:?}: {off}");
            }
        }
    }

    /// Rebound of clipped dashpots by their nominal restitution, and the share of the contact time
    /// during which they bear a force; worked out apart from this program.
    #[test]
    fn clipped_dashpots_rebound_as_known() {
        for (nominal, rebound, duration) in [
            (0.2, 0.324863, 0.6986),
            (0.5, 0.550283, 0.8618),
            (0.9, 0.902026, 0.9787),
        ] {
            let ratio = nominal_ratio(nominal);
            let release = impact(ratio, true).release();
            assert!((release.speed / 3.0 - rebound).abs() < 1.0e-6);
            let half_swing = PI / (5.0 * (1.0 - ratio * ratio).sqrt());
            assert!((release.time / half_swing - duration).abs() < 1.0e-4);
        }
    }

    /// ∫ u k u dt over half a swing of amplitude A is ½π k A²/ω.
    #[test]
    fn the_overlap_impulse_of_a_spring_is_known() {
        let spring = impact(0.0, true);
        let known = 0.5 * PI * 50.0 * 0.6 * 0.6 / 5.0;
        assert!((spring.overlap_impulse() / known - 1.0).abs() < 1.0e-9);
    }
}
