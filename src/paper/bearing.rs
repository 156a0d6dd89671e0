//! What a strip bears on ground without cohesion before it sinks, by the classical sum p = γ (d N_q + a N_γ): d is the depth of its
//! base, a its half width, γ the ground's weight, with N_q of Prandtl and Reissner and N_γ = 2 (N_q + 1) tan φ of Vesić (1973).

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::continuum::table::Setup;

/// N_q and N_γ for ground of this friction angle, rad.
fn factors(friction: f64) -> [f64; 2] {
    let tangent = friction.tan();
    let depth = (PI * tangent).exp() * (FRAC_PI_4 + 0.5 * friction).tan().powi(2);
    [depth, 2.0 * (depth + 1.0) * tangent]
}

/// Pa, at a depth of the base in m.
pub fn borne(setup: &Setup, depth: f64, friction: f64) -> f64 {
    let [of_depth, of_width] = factors(friction);
    setup.weight(depth) * of_depth + setup.weight(setup.load.half_width) * of_width
}

/// The friction angle of ground that just bears the load there, rad.
pub fn needed(setup: &Setup, depth: f64) -> f64 {
    let (mut low, mut high) = (0.0, FRAC_PI_2);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match borne(setup, depth, middle) < setup.load.pressure {
            true => low = middle,
            false => high = middle,
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vesić's table: N_q 1, 2.47, 18.40, 64.20 and N_γ 0, 1.22, 22.40, 109.41 at 0, 10, 30 and 40 degrees.
    #[test]
    fn factors_are_those_of_the_table() {
        for (degrees, wanted) in [
            (0.0f64, [1.0, 0.0]),
            (10.0, [2.47, 1.22]),
            (30.0, [18.40, 22.40]),
            (40.0, [64.20, 109.41]),
        ] {
            let found = factors(degrees.to_radians());
            let near = |index: usize| (found[index] - wanted[index]).abs() < 0.006;
            assert!(near(0) && near(1), "{degrees}: {found:?}");
        }
    }

    #[test]
    fn what_is_needed_bears_the_load_and_depth_helps() {
        let setup = Setup::published();
        let angles = [0.0, 0.04, 0.11].map(|depth| needed(&setup, depth));
        for (angle, depth) in angles.into_iter().zip([0.0, 0.04, 0.11]) {
            let ratio = borne(&setup, depth, angle) / setup.load.pressure;
            assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
        }
        assert!(angles[0] > angles[1] && angles[1] > angles[2]);
    }
}
