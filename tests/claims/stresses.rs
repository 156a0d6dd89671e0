//! What is said of means and forms of stresses.

use evidence::distribution::Distribution;

use crate::support::near;

use crossgrain::study::claims::Claims;

use super::{NO, claims_where, none_of, only, verdict};

/// Gamma laws of shape 2 are no exponentials, and their sums no Erlang laws of shape N; means stay.
#[test]
fn another_form_is_noticed() {
    let (shape, scale) = (2.0, 0.5);
    let claims = claims_where(|truth| truth.normal = Distribution::Gamma { shape, scale });
    let rows = claims.claims.iter().flat_map(|claim| &claim.rows);
    let mut tests = rows.flat_map(|row| &row.probabilities);
    let exponential = tests
        .clone()
        .filter(|test| test.test.contains("exponential with") || test.test.starts_with("shape 1 "));
    assert!(exponential.clone().count() >= 21);
    for test in exponential {
        assert!(test.adjusted < 0.02, "{test:?}");
    }
    // What is true of these members is not rejected.
    assert!(tests.all(|test| !test.test.starts_with("gamma with") || test.adjusted > 0.05));
    let others = "exponential.O exponential.A exponential.B exponential.theory exponential.xx
        exponential.gravity variation.load variation.gravity erlang conclusion earlier.normal";
    only(&claims, others);
}

/// One grain that is pulled leaves every shape what it is, and every verdict.
#[test]
fn a_pulled_grain_is_no_excuse() {
    let (shape, scale) = (2.0, 0.5);
    let with = |pulled| {
        claims_where(|truth| {
            truth.normal = Distribution::Gamma { shape, scale };
            (truth.pulled, truth.factor, truth.heights) = (pulled, [1.3; 3], [0.49; 3]);
        })
    };
    let (sound, pulled) = (with(0), with(1));
    assert_eq!(pulled.verdicts, sound.verdicts);
    none_of(
        &pulled,
        "exponential.O exponential.A exponential.B conclusion",
    );
    let shapes = |claims: &Claims| -> Vec<(String, usize)> {
        let rows = claims.claims.iter().flat_map(|claim| &claim.rows);
        let shapes = rows.filter(|row| row.what.ends_with("gamma shape"));
        shapes.map(|row| (row.what.clone(), row.packings)).collect()
    };
    let (sound, pulled) = (shapes(&sound), shapes(&pulled));
    assert!(!sound.is_empty());
    // It is no part of the sample that a shape is of, and that is said.
    let of_loads = |shape: &&(String, usize)| shape.0.starts_with("Σ_zz of grains");
    let counts = |shapes: &[(String, usize)]| {
        shapes
            .iter()
            .filter(of_loads)
            .map(|shape| shape.1)
            .collect::<Vec<_>>()
    };
    assert_eq!(counts(&sound), [600; 3]);
    assert_eq!(counts(&pulled), [599; 3]);
}

/// Where no stress can be computed from, a claim says so; that is neither evidence nor too little of it.
#[test]
fn what_cannot_be_computed_is_said() {
    let claims = claims_where(|truth| truth.normal = Distribution::Exponential { mean: 0.0 });
    let at_o = claims
        .claims
        .iter()
        .find(|claim| claim.id == "exponential.O");
    let at_o = at_o.expect("is there");
    assert_eq!(at_o.verdict, None);
    assert!(
        at_o.reading.contains("Not computable: "),
        "{}",
        at_o.reading
    );
    assert!(
        claims.verdicts["not computable"] > 0,
        "{:?}",
        claims.verdicts
    );
}

/// A third more at A: what is said of A and of all points fails, what is said of O, B and of forms does not.
#[test]
fn a_biased_mean_is_noticed() {
    let claims = claims_where(|truth| truth.factor = [1.0, 1.3, 1.0]);
    let others = "mean.A extensive exponential.theory large_scale conclusion earlier.scale";
    only(&claims, others);
}

/// Half of every cell's stress in common: neighbours correlate, and the variation stops to fall.
#[test]
fn cells_that_hang_together_are_noticed() {
    let claims = claims_where(|truth| (truth.common, truth.members) = (0.4, 320));
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
    let claims = claims_where(|truth| {
        truth.shear = Distribution::Normal { mean, deviation };
        (truth.gravity_shift, truth.members) = (-0.1, 320);
    });
    none_of(&claims, "laplace earlier.shear positive");
    assert_ne!(verdict(&claims, "earlier.normal"), Some(NO));
    assert_ne!(verdict(&claims, "exponential.O"), Some(NO));
}
