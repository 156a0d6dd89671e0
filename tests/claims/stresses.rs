//! What is said of means and forms of stresses.

use evidence::distribution::Distribution;

use crate::support::near;

use super::{NO, claims_where, none_of, only, verdict};

/// Gamma laws of shape 2 are no exponentials, and their sums no Erlang laws of shape N; means stay.
#[test]
fn another_form_is_noticed() {
    let (shape, scale) = (2.0, 0.5);
    let claims = claims_where(|of| of.normal = Distribution::Gamma { shape, scale });
    let rows = claims.claims.iter().flat_map(|claim| &claim.rows);
    let mut tests = rows.flat_map(|row| &row.probabilities);
    let exponential = tests
        .clone()
        .filter(|of| of.test.contains("exponential with") || of.test.starts_with("shape 1 "));
    assert!(exponential.clone().count() >= 21);
    for test in exponential {
        assert!(test.adjusted < 0.02, "{test:?}");
    }
    // What is true of these members is not rejected.
    assert!(tests.all(|of| !of.test.starts_with("gamma with") || of.adjusted > 0.05));
    let others = "exponential.O exponential.A exponential.B exponential.theory exponential.xx
        exponential.gravity variation.load variation.gravity erlang conclusion earlier.normal";
    only(&claims, others);
}

/// A third more at A: what is said of A and of all points fails, what is said of O, B and of forms does not.
#[test]
fn a_biased_mean_is_noticed() {
    let claims = claims_where(|of| of.factor = [1.0, 1.3, 1.0]);
    let others = "mean.A extensive exponential.theory large_scale conclusion earlier.scale";
    only(&claims, others);
}

/// Half of every cell's stress in common: neighbours correlate, and the variation stops to fall.
#[test]
fn cells_that_hang_together_are_noticed() {
    let claims = claims_where(|of| (of.common, of.members) = (0.4, 320));
    let ids = "independence variation.load variation.gravity erlang large_scale";
    none_of(&claims, ids);
    let exponent = claims.figures.volumes[0].exponent.expect("many packings");
    assert!(exponent.low > -0.3, "{exponent:?}");
    assert_eq!(claims.figures.volumes[0].enough, None);
    let correlation = claims.figures.volumes[0].volumes[4].correlation;
    // 0.4²/(0.4² + 0.6²) = 0.308.
    near(correlation.expect("sixteen cells"), 0.308, 0.08);
}

#[test]
fn normal_shear_and_tension_are_noticed() {
    let (mean, deviation) = (0.0, 4200.0);
    let claims = claims_where(|of| {
        of.shear = Distribution::Normal { mean, deviation };
        (of.gravity_shift, of.members) = (-0.1, 320);
    });
    none_of(&claims, "laplace earlier.shear positive");
    assert_ne!(verdict(&claims, "earlier.normal"), Some(NO));
    assert_ne!(verdict(&claims, "exponential.O"), Some(NO));
}
