//! The half-space: stresses from one function of w = x + iz.

use std::f64::consts::PI;

use super::pressure::Pressure;
use crate::paper::quadrature::integrate;

/// [σ_zz, σ_xx, σ_xz] in Pa. With F(w) = (1/π)∫p(s)/(w−s)ds they are −Im F + z Re F′, −Im F − z Re F′ and
/// z Im F′; for a line load this is Flamant's solution.
pub(super) fn stress(pressure: &Pressure, x: f64, z: f64) -> [f64; 3] {
    let [value, slope] = pressure.potential(x, z);
    [
        -value.im + z * slope.re,
        -value.im - z * slope.re,
        z * slope.im,
    ]
}

/// σ_zz in Pa under a uniform strip load by another route: Flamant's line load 2p/π·z³/((x−s)²+z²)² integrated
/// numerically over the strip.
pub fn strip_load(pressure: f64, half_width: f64, offset: f64, depth: f64) -> f64 {
    integrate(-half_width, half_width, 500, |s| {
        let square = (offset - s).powi(2) + depth * depth;
        2.0 * pressure / PI * depth.powi(3) / (square * square)
    })
}
