//! Two samples with the same members: their differences.

use serde::{Deserialize, Serialize};

use super::Interval;
use super::moments::{deviation, mean, mean_interval};

/// The differences of pairs, second minus first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Paired {
    /// How many pairs.
    pub pairs: usize,
    /// Mean of the first members.
    pub first_mean: f64,
    /// Standard deviation of the first members: what one member differs by from the next.
    pub first_deviation: f64,
    /// Mean difference with its 95 % t interval.
    pub difference: Interval,
    /// The same with 90 %, for equivalence at 5 %.
    pub difference_90: Interval,
    /// Pearson's correlation of the members of a pair; none where one does not vary.
    pub correlation: Option<f64>,
}

/// Compares pairs (first, second); none for fewer than two.
pub fn paired(pairs: &[(f64, f64)]) -> Option<Paired> {
    let first: Vec<f64> = pairs.iter().map(|pair| pair.0).collect();
    let second: Vec<f64> = pairs.iter().map(|pair| pair.1).collect();
    let differences: Vec<f64> = pairs.iter().map(|(a, b)| b - a).collect();
    Some(Paired {
        pairs: pairs.len(),
        first_mean: mean(&first),
        first_deviation: deviation(&first),
        difference: mean_interval(&differences, 0.95)?,
        difference_90: mean_interval(&differences, 0.90)?,
        correlation: correlation(&first, &second),
    })
}

/// Σ(x − x̄)(y − ȳ)/√(Σ(x − x̄)² Σ(y − ȳ)²).
pub fn correlation(first: &[f64], second: &[f64]) -> Option<f64> {
    let (x, y) = (mean(first), mean(second));
    let both = first.iter().zip(second);
    let product: f64 = both.map(|(a, b)| (a - x) * (b - y)).sum();
    let squares = |of: &[f64], centre: f64| of.iter().map(|v| (v - centre).powi(2)).sum::<f64>();
    let scale = (squares(first, x) * squares(second, y)).sqrt();
    (scale > 0.0).then(|| product / scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_of_a_common_size_differ_by_less_than_their_members() {
        let pairs: Vec<(f64, f64)> = (0..10)
            .map(|k| (f64::from(k), f64::from(k) + 1.0 + 0.1 * f64::from(k % 2)))
            .collect();
        let found = paired(&pairs).expect("ten pairs");
        assert!((found.difference.estimate - 1.05).abs() < 1.0e-12);
        assert!(found.difference.high - found.difference.low < 0.1);
        assert!(found.first_deviation > 3.0);
        assert!(found.correlation.expect("both vary") > 0.999);
    }

    #[test]
    fn correlation_of_known_series() {
        let found = correlation(&[1.0, 2.0, 3.0, 4.0], &[1.0, 3.0, 2.0, 4.0]);
        assert!((found.expect("both vary") - 0.8).abs() < 1.0e-12);
        assert!(correlation(&[1.0, 1.0], &[1.0, 2.0]).is_none());
    }
}
