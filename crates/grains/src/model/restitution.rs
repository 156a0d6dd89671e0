//! The dashpot that gives a restitution: linear spring and dashpot, in closed form.

use std::f64::consts::PI;

use crate::scene::Tension;

/// The damping ratio ζ = c_n/(2√(m_eff k_n)) whose collisions have the restitution e in (0, 1].
///
/// Unclipped, e = exp(−πζ/√(1−ζ²)) and ζ follows in closed form. Clipped, the bodies part as soon
/// as the force is zero (Schwager and Pöschel 2007); ζ is then found by halving.
pub fn damping_ratio(restitution: f64, tension: Tension) -> f64 {
    let logarithm = -restitution.ln();
    let unclipped = logarithm / (PI * PI + logarithm * logarithm).sqrt();
    if tension == Tension::Unclipped || restitution == 1.0 {
        return unclipped;
    }
    // Clipping raises e, so more damping is needed than without.
    let (mut low, mut high) = (unclipped, 1.0);
    while clipped_restitution(high) > restitution {
        low = high;
        high *= 2.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if clipped_restitution(middle) > restitution {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// e of a spring and dashpot without tension, for any damping ratio ζ ≥ 0:
/// exp(−(ζ/s)(π − atan2(2ζs, 1 − 2ζ²))) with s = √(1−ζ²) below critical damping, and
/// exp(−(ζ/s)·2 ln(ζ+s)) with s = √(ζ²−1) above it.
pub fn clipped_restitution(ratio: f64) -> f64 {
    let off = 1.0 - ratio * ratio;
    if off.abs() < 1.0e-12 {
        return (-2.0f64).exp();
    }
    let s = off.abs().sqrt();
    let angle = if off > 0.0 {
        PI - (2.0 * ratio * s).atan2(1.0 - 2.0 * ratio * ratio)
    } else {
        2.0 * (ratio + s).ln()
    };
    (-(ratio / s) * angle).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damping_ratio_gives_back_its_restitution() {
        for restitution in [1.0e-15, 1.0e-3, 0.05, 0.13, 0.14, 0.3, 0.5, 0.8, 0.95, 1.0] {
            let ratio = damping_ratio(restitution, Tension::Clipped);
            let back = clipped_restitution(ratio);
            assert!((back / restitution - 1.0).abs() < 1.0e-9, "{restitution}");
            let ratio: f64 = damping_ratio(restitution, Tension::Unclipped);
            let back = (-PI * ratio / (1.0 - ratio * ratio).sqrt()).exp();
            assert!((back / restitution - 1.0).abs() < 1.0e-12, "{restitution}");
        }
    }

    #[test]
    fn clipping_raises_the_restitution_as_published() {
        // The nominal ones are those of the same dashpot unclipped.
        for (nominal, clipped) in [(0.1, 0.252729), (0.5, 0.550283), (0.9, 0.902026)] {
            let ratio = damping_ratio(nominal, Tension::Unclipped);
            assert!((clipped_restitution(ratio) - clipped).abs() < 1.0e-6);
        }
    }
}
