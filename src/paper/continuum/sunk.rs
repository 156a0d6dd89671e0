//! A load that has sunk below the surface.
//!
//! A punch that has gone down by d presses nearer to the control points. Two bounds of what the ground beside and above its
//! base does: nothing, so that the surface may be taken at d ([`beneath`]); or as much as an elastic body that fills the hole
//! and is stuck to the base ([`within`]).

use std::f64::consts::PI;

use super::{Load, Model};
use crate::paper::quadrature::gauss_legendre;

/// The ground under the depth d, which then is its surface: what lies above bears nothing.
pub fn beneath(model: Model, sunk: f64) -> Model {
    match model {
        Model::HalfSpace => Model::HalfSpace,
        Model::Layer { depth } => Model::Layer {
            depth: depth - sunk,
        },
        Model::Box { width, depth } => Model::Box {
            width,
            depth: depth - sunk,
        },
    }
}

/// σ_zz in Pa at (x, z), z from the surface, under a uniform strip load at the depth `sunk` inside the half-space: Melan's line
/// load (Melan 1932; in the form of Poulos and Davis 1974) summed over the strip. Depends on `poisson`, ν.
pub fn within(load: Load, sunk: f64, poisson: f64, x: f64, z: f64) -> f64 {
    let a = load.half_width;
    gauss_legendre(40)
        .iter()
        .map(|node| a * node.weight * load.pressure * melan(sunk, poisson, x - a * node.place, z))
        .sum()
}

/// σ_zz over the force of a line load at depth d, 1/m.
fn melan(d: f64, poisson: f64, x: f64, z: f64) -> f64 {
    let m = (1.0 - poisson) / poisson;
    let (near, far) = (x * x + (z - d).powi(2), x * x + (z + d).powi(2));
    let first = (z - d).powi(3) / (near * near)
        + (z + d) * ((z + d).powi(2) + 2.0 * d * z) / (far * far)
        - 8.0 * d * z * (d + z) * x * x / far.powi(3);
    let second = (z - d) / near + (3.0 * z + d) / far - 4.0 * z * x * x / (far * far);
    ((m + 1.0) / (2.0 * m) * first + (m - 1.0) / (4.0 * m) * second) / PI
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::continuum::{Spread, half_space, tests::close};
    use crate::paper::quadrature::integrate;

    #[test]
    fn a_load_at_the_surface_is_flamants() {
        let load = Load {
            spread: Spread::Uniform,
            pressure: 3.0,
            half_width: 0.2,
        };
        for (x, z) in [(0.0, 0.1), (0.5, 0.3), (1.5, 2.0)] {
            for poisson in [0.1, 0.5] {
                let flamant = half_space::strip_load(3.0, 0.2, x, z);
                close(within(load, 0.0, poisson, x, z), flamant, 1e-7);
            }
        }
    }

    /// Every horizontal cut below the load carries all of it, and one above carries nothing; the surface is free.
    #[test]
    fn equilibrium_above_and_below() {
        for poisson in [0.1, 0.3, 0.5] {
            let carried = |z: f64| {
                // x = tan u: the tails fall as 1/x⁴ and 1/x².
                integrate(-0.5 * PI, 0.5 * PI, 20_000, |u| {
                    let x = u.tan();
                    let value = melan(1.0, poisson, x, z) / u.cos().powi(2);
                    if value.is_finite() { value } else { 0.0 }
                })
            };
            close(carried(1.5), 1.0, 1e-4);
            close(carried(3.0), 1.0, 1e-4);
            close(carried(0.5), 0.0, 1e-4);
            for x in [0.0, 0.3, 2.0] {
                close(melan(1.0, poisson, x, 0.0), 0.0, 1e-14);
            }
        }
    }

    /// Deep inside, half of the force hangs above: Kelvin's line load, whose σ_zz on the axis is (3−2ν)/(4π(1−ν)r).
    #[test]
    fn deep_inside_it_is_kelvins() {
        for poisson in [0.0f64, 0.3, 0.5] {
            let nu = poisson.max(1e-9);
            let kelvin = (3.0 - 2.0 * nu) / (4.0 * PI * (1.0 - nu));
            close(melan(1e5, nu, 0.0, 1e5 + 1.0), kelvin, 1e-4);
            close(melan(1e5, nu, 0.0, 1e5 - 1.0), -kelvin, 1e-4);
        }
    }
}
