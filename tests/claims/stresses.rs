//! What is said of means and forms of stresses.

use evidence::distribution::Distribution;

use super::truth::Truth;
use super::{NO, claims_of, only, verdict};

/// Gamma laws of shape 2 are no exponentials, and their sums no Erlang laws of shape N; means stay.
#[test]
fn another_form_is_noticed() {
    let truth = Truth {
        normal: Distribution::Gamma {
            shape: 2.0,
            scale: 0.5,
        },
        ..Truth::paper()
    };
    let claims = claims_of(&truth);
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
    only(
        &claims,
        &[
            ("exponential.O", NO),
            ("exponential.A", NO),
            ("exponential.B", NO),
            ("exponential.theory", NO),
            ("exponential.xx", NO),
            ("exponential.gravity", NO),
            ("variation.load", NO),
            ("variation.gravity", NO),
            ("erlang", NO),
            ("conclusion", NO),
            ("earlier.normal", NO),
        ],
    );
}

/// A third more at A: what is said of A and of all points fails, what is said of O, B and of forms does not.
#[test]
fn a_biased_mean_is_noticed() {
    let truth = Truth {
        factor: [1.0, 1.3, 1.0],
        ..Truth::paper()
    };
    only(
        &claims_of(&truth),
        &[
            ("mean.A", NO),
            ("extensive", NO),
            ("exponential.theory", NO),
            ("large_scale", NO),
            ("conclusion", NO),
            ("earlier.scale", NO),
        ],
    );
}

/// Half of every cell's stress in common: neighbours correlate, and the variation stops to fall.
#[test]
fn cells_that_hang_together_are_noticed() {
    let truth = Truth {
        common: 0.4,
        members: 320,
        ..Truth::paper()
    };
    let claims = claims_of(&truth);
    for id in [
        "independence",
        "variation.load",
        "variation.gravity",
        "erlang",
        "large_scale",
    ] {
        assert_eq!(verdict(&claims, id), Some(NO), "{id}");
    }
    let exponent = claims.figures.volumes[0].exponent.expect("many packings");
    assert!(exponent.low > -0.3, "{exponent:?}");
    assert_eq!(claims.figures.volumes[0].enough, None);
    let correlation = claims.figures.volumes[0].volumes[4].correlation;
    // 0.4²/(0.4² + 0.6²) = 0.308.
    assert!((correlation.expect("sixteen cells") - 0.308).abs() < 0.08);
}

#[test]
fn normal_shear_and_tension_are_noticed() {
    let truth = Truth {
        shear: Distribution::Normal {
            mean: 0.0,
            deviation: 4200.0,
        },
        gravity_shift: -0.1,
        members: 320,
        ..Truth::paper()
    };
    let claims = claims_of(&truth);
    assert_eq!(verdict(&claims, "laplace"), Some(NO));
    assert_eq!(verdict(&claims, "earlier.shear"), Some(NO));
    assert_ne!(verdict(&claims, "earlier.normal"), Some(NO));
    assert_eq!(verdict(&claims, "positive"), Some(NO));
    assert_ne!(verdict(&claims, "exponential.O"), Some(NO));
}
