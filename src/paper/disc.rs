//! Figure 4 and Table 3: a disc between two pairs of opposite line forces. Recomputed by integrating
//! the elastic stress field over the disc.

use std::f64::consts::PI;

use super::Number;
use crate::paper::quadrature::integrate;

/// m.
const RADIUS: f64 = 1.0;
/// Vertical and horizontal force, N/m.
const FORCES: [f64; 2] = [1.0, 0.5];

/// ∫σ dA over the disc of one pair of opposite forces, along the pair and across it, compression
/// positive, J/m.
///
/// The field is Flamant's radial compression 2P cosθ/(πr) about each force plus an isotropic
/// tension P/(πR). About each force the area element r dr dθ takes the singularity away: the disc
/// is 0 < r < 2R cosθ.
fn integrated_stress(force: f64) -> [f64; 2] {
    let about_one_force = |component: fn(f64) -> f64| {
        integrate(-PI / 2.0, PI / 2.0, 400, |angle| {
            let to = 2.0 * RADIUS * angle.cos();
            // σ·r at distance r: Flamant's field times the Jacobian.
            integrate(0.0, to, 2, |_| {
                2.0 * force / PI * angle.cos() * component(angle)
            })
        })
    };
    let tension = force / (PI * RADIUS) * disc_area();
    [
        2.0 * about_one_force(|angle| angle.cos().powi(2)) - tension,
        2.0 * about_one_force(|angle| angle.sin().powi(2)) - tension,
    ]
}

/// ∫σ_xz dA of one pair: odd in the angle.
fn integrated_shear(force: f64) -> f64 {
    2.0 * integrate(-PI / 2.0, PI / 2.0, 400, |angle| {
        4.0 * force * RADIUS / PI * angle.cos().powi(3) * angle.sin()
    })
}

/// Two discs on top of each other between two forces: the force between them is inner to the pair.
fn stacked_over_sum() -> f64 {
    let force = FORCES[0];
    let sum_about = |centre: f64, ends: [f64; 2]| {
        let [low, high] = ends.map(|end| end - centre);
        // The lower force pushes up, the upper one down; compression positive.
        -(low * force + high * -force)
    };
    let lower = sum_about(RADIUS, [0.0, 2.0 * RADIUS]);
    let upper = sum_about(3.0 * RADIUS, [2.0 * RADIUS, 4.0 * RADIUS]);
    sum_about(2.0 * RADIUS, [0.0, 4.0 * RADIUS]) / (lower + upper)
}

/// πR² in polar rings, m².
fn disc_area() -> f64 {
    integrate(0.0, RADIUS, 100, |r| 2.0 * PI * r)
}

/// The numbers of Table 3.
pub fn numbers() -> Vec<Number> {
    let [vertical, horizontal] = FORCES;
    let [along_vertical, across_vertical] = integrated_stress(vertical);
    let [along_horizontal, across_horizontal] = integrated_stress(horizontal);
    let zz = along_vertical + across_horizontal;
    let xx = along_horizontal + across_vertical;
    let xz = integrated_shear(vertical) + integrated_shear(horizontal);
    let volume = integrate(-RADIUS, RADIUS, 10, |_| 2.0 * RADIUS);
    let particle = disc_area();
    let field = "elastic stress field integrated over the disc";
    let area = "integration";
    let table = |what: &str, published: f64, rounding: f64, value: f64, unit: &str, how: &str| {
        Number::new("Table 3", what, published, rounding, value, unit, how)
    };
    vec![
        table("total volume", 4.0, 0.0, volume, "m³", area),
        table("particle volume", PI, 0.0, particle, "m³", area),
        table("porosity", 0.21, 0.005, 1.0 - particle / volume, "1", area),
        table("Σ_zz", 2.0, 0.05, zz, "J", field),
        table("σ_zz", 0.5, 0.05, zz / volume, "Pa", field),
        table("Σ_xx", 1.0, 0.05, xx, "J", field),
        table("σ_xx", 0.25, 0.005, xx / volume, "Pa", field),
        table("Σ_xy", 0.0, 0.05, xz, "J", field),
        table("σ_xy", 0.0, 0.05, xz / volume, "Pa", field),
        Number::new(
            "Eq. 8",
            "Σ_zz of two stacked discs over the sum of theirs",
            1.0,
            0.0,
            stacked_over_sum(),
            "1",
            "Σ x_i F_j of the outer forces of the pair, and of each disc alone",
        )
        .remark("printed as a formula"),
    ]
}
