//! Numbers for the shape of a distribution of positive values; the scale drops out of all of them.

use statrs::function::gamma::digamma;

use super::moments::{deviation, mean};

/// Standard deviation over mean; 1 for an exponential.
pub fn variation(values: &[f64]) -> f64 {
    deviation(values) / mean(values)
}

/// The share of values above so many means; e^{−multiple} for an exponential.
pub fn share_above(values: &[f64], multiple: f64) -> f64 {
    let limit = multiple * mean(values);
    values.iter().filter(|value| **value > limit).count() as f64 / values.len() as f64
}

/// Maximum-likelihood shape k of a Gamma law: ln k − ψ(k) = ln x̄ − mean(ln x); 1 for an exponential. Values
/// at or below zero are left out. None for fewer than two different values.
pub fn gamma(values: &[f64]) -> Option<f64> {
    let positive = positive(values);
    let logarithms: Vec<f64> = positive.iter().map(|value| value.ln()).collect();
    let wanted = mean(&positive).ln() - mean(&logarithms);
    if wanted.is_nan() || wanted <= 0.0 {
        return None;
    }
    // ln k − ψ(k) falls from ∞ to 0.
    falling_root(|k| k.ln() - digamma(k) - wanted)
}

/// Maximum-likelihood shape c of a Weibull law: Σxᶜ ln x/Σxᶜ − 1/c = mean(ln x); 1 for an exponential. Values
/// at or below zero are left out. None for fewer than two different values.
pub fn weibull(values: &[f64]) -> Option<f64> {
    let positive = positive(values);
    let largest = positive.iter().copied().fold(0.0, f64::max);
    let logarithms: Vec<f64> = positive
        .iter()
        .map(|value| (value / largest).ln())
        .collect();
    let centre = mean(&logarithms);
    if centre.is_nan() || centre >= 0.0 {
        return None;
    }
    falling_root(|c| {
        let (mut weighted, mut weights) = (0.0, 0.0);
        for logarithm in &logarithms {
            let weight = (c * logarithm).exp();
            weighted += weight * logarithm;
            weights += weight;
        }
        1.0 / c + centre - weighted / weights
    })
}

fn positive(values: &[f64]) -> Vec<f64> {
    values
        .iter()
        .copied()
        .filter(|value| *value > 0.0)
        .collect()
}

/// Where a falling function of a positive number is zero, by halving on a logarithmic scale.
fn falling_root(function: impl Fn(f64) -> f64) -> Option<f64> {
    let (mut low, mut high) = (1.0e-3f64, 1.0e4f64);
    if !(function(low) > 0.0 && function(high) < 0.0) {
        return None;
    }
    for _ in 0..80 {
        let middle = (low * high).sqrt();
        if function(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some((low * high).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ContinuousCDF, Gamma, Weibull};

    /// The quantiles at the middles of a thousand equal shares.
    fn quantiles(of: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..1000)
            .map(|k| of((f64::from(k) + 0.5) / 1000.0))
            .collect()
    }

    #[test]
    fn shapes_of_known_laws_are_found() {
        for shape in [0.7, 1.0, 1.9, 4.0] {
            let law = Gamma::new(shape, 3.0).expect("a gamma law");
            let found = gamma(&quantiles(|p| law.inverse_cdf(p))).expect("positive values");
            assert!((found / shape - 1.0).abs() < 0.01, "{shape} {found}");
            let law = Weibull::new(shape, 3.0).expect("a weibull law");
            let found = weibull(&quantiles(|p| law.inverse_cdf(p))).expect("positive values");
            assert!((found / shape - 1.0).abs() < 0.01, "{shape} {found}");
        }
    }

    #[test]
    fn an_exponential_has_ones() {
        let values = quantiles(|p| -(1.0 - p).ln());
        assert!((variation(&values) - 1.0).abs() < 0.01);
        assert!((share_above(&values, 2.0) - (-2.0f64).exp()).abs() < 0.002);
        assert!((share_above(&values, 0.0) - 1.0).abs() < 1.0e-12);
    }

    #[test]
    fn equal_values_have_no_shape() {
        assert!(gamma(&[2.0, 2.0, 2.0]).is_none());
        assert!(gamma(&[]).is_none());
        assert!(weibull(&[]).is_none());
    }
}
