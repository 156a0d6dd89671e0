//! Linear regression, whose slope is the order of convergence where both axes are logarithms, and correlation with the
//! probability of so large a one without any.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};

use super::moments::mean;
use super::random::{self, Key};
use super::{Interval, two_sided};

const KEY: Key = *b"crossgrain: pairs that are mixed";

/// Slope of the line through the points with its 95 % t interval; none for fewer than three points or one abscissa.
pub fn slope(points: &[(f64, f64)]) -> Option<Interval> {
    let (xs, ys): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
    let (x, y) = (mean(&xs), mean(&ys));
    let spread: f64 = xs.iter().map(|value| (value - x).powi(2)).sum();
    if spread.is_nan() || spread <= 0.0 {
        return None;
    }
    let products = points.iter().map(|(a, b)| (a - x) * (b - y));
    let slope = products.sum::<f64>() / spread;
    let residuals = points.iter().map(|(a, b)| b - y - slope * (a - x));
    let count = points.len() as f64;
    let variance = residuals.map(|off| off * off).sum::<f64>() / (count - 2.0);
    let reach = two_sided(0.95, count - 2.0)? * (variance / spread).sqrt();
    Some(Interval::about(slope, reach))
}

/// Σ(x − x̄)(y − ȳ)/√(Σ(x − x̄)² Σ(y − ȳ)²).
pub fn correlation(first: &[f64], second: &[f64]) -> Option<f64> {
    let (x, y) = (mean(first), mean(second));
    let both = first.iter().zip(second);
    let product: f64 = both.map(|(a, b)| (a - x) * (b - y)).sum();
    let squares =
        |values: &[f64], centre: f64| values.iter().map(|v| (v - centre).powi(2)).sum::<f64>();
    let scale = (squares(first, x) * squares(second, y)).sqrt();
    (scale > 0.0).then(|| product / scale)
}

/// A correlation of two numbers a packing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Correlation {
    /// With its 95 % interval.
    pub value: Interval,
    /// The probability of one at least as far from zero if the second numbers belonged to any other of the
    /// packings: a permutation test, two-sided.
    pub p: f64,
}

/// Spearman's correlation, Pearson's of the ranks; Fisher's z = artanh r with standard error √((1 + r²/2)/(n − 3)) (Bonett and
/// Wright 2000). None for fewer than four packings and where one of the two does not vary.
pub fn spearman(first: &[f64], second: &[f64], permutations: usize) -> Option<Correlation> {
    let (first, second) = (ranks(first), ranks(second));
    let estimate = correlation(&first, &second)?;
    if first.len() < 4 || first.len() != second.len() {
        return None;
    }
    let error = ((1.0 + 0.5 * estimate * estimate) / (first.len() as f64 - 3.0)).sqrt();
    let reach = Normal::standard().inverse_cdf(0.975) * error;
    // Another order of the same sum may differ in the last bits.
    let limit = estimate.abs() - 1.0e-12;
    let [p] = random::p_values(&KEY, permutations, |source| {
        let mut mixed = second.clone();
        source.shuffle(&mut mixed);
        [correlation(&first, &mixed).is_none_or(|r| r.abs() >= limit)]
    });
    let z = estimate.clamp(-1.0, 1.0).atanh();
    Some(Correlation {
        value: Interval {
            estimate,
            low: (z - reach).tanh(),
            high: (z + reach).tanh(),
        },
        p,
    })
}

/// Ranks from 1; equal values share the mean of theirs.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    let mut start = 0;
    while start < order.len() {
        let mut end = start + 1;
        while end < order.len() && values[order[end]] == values[order[start]] {
            end += 1;
        }
        for place in &order[start..end] {
            ranks[*place] = 0.5 * (start + end + 1) as f64;
        }
        start = end;
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assert_share;
    use crate::distribution::tests::AIR_CONDITIONING;
    use crate::random::replicates;

    /// Anscombe's first set (1973): slope 0.5001, standard error 0.1179; t = 2.262 on 9 degrees of freedom.
    #[test]
    fn anscombes_first_set() {
        let xs = [10.0, 8.0, 13.0, 9.0, 11.0, 14.0, 6.0, 4.0, 12.0, 7.0, 5.0];
        let ys = [
            8.04, 6.95, 7.58, 8.81, 8.33, 9.96, 7.24, 4.26, 10.84, 4.82, 5.68,
        ];
        let points: Vec<(f64, f64)> = xs.into_iter().zip(ys).collect();
        let found = slope(&points).expect("eleven points");
        assert!((found.estimate - 0.50009).abs() < 1.0e-5);
        assert!((found.high - found.estimate - 2.262 * 0.1179).abs() < 1.0e-3);
        assert!(slope(&points[..2]).is_none());
    }

    const TESTS: Key = *b"crossgrain: tests of mixed pairs";

    /// Each value with the next: `scipy.stats` 1.17.1, pearsonr −0.0265462; spearmanr 0.0417387, p 0.8298. Its interval by the
    /// formula of its documentation: −0.3299614 to 0.4022337.
    #[test]
    fn a_known_sample() {
        let (first, second) = (&AIR_CONDITIONING[..29], &AIR_CONDITIONING[1..]);
        let found = correlation(first, second).expect("29 pairs");
        assert!((found + 0.026_546_2).abs() < 1.0e-6);
        let found = spearman(first, second, 4999).expect("29 pairs");
        assert!((found.value.estimate - 0.041_738_7).abs() < 1.0e-6);
        assert!((found.value.low + 0.329_961_4).abs() < 1.0e-6);
        assert!((found.value.high - 0.402_233_7).abs() < 1.0e-6);
        assert!((found.p - 0.8298).abs() < 0.03, "{}", found.p);
    }

    /// Independent pairs are called correlated one time in twenty; pairs with a common part nearly always.
    #[test]
    fn level_and_power() {
        let found: Vec<[bool; 2]> = replicates(&TESTS, 1000, |source| {
            let first: Vec<f64> = (0..60).map(|_| source.exponential()).collect();
            let second: Vec<f64> = (0..60).map(|_| source.exponential()).collect();
            let both: Vec<f64> = first.iter().zip(&second).map(|(a, b)| a + b).collect();
            let p = |correlation: Option<Correlation>| correlation.expect("sixty pairs").p;
            [
                p(spearman(&first, &second, 99)) <= 0.05,
                p(spearman(&first, &both, 99)) <= 0.05,
            ]
        });
        assert_share(found.iter().map(|one| one[0]), 0.99, 0.05);
        let correlated = found.iter().filter(|one| one[1]).count();
        assert!(correlated > 950, "{correlated}");
    }

    #[test]
    fn ties_and_too_few() {
        assert_eq!(ranks(&[3.0, 1.0, 3.0, 2.0]), [3.5, 1.0, 3.5, 2.0]);
        assert!(spearman(&[1.0, 2.0, 3.0], &[1.0, 2.0, 4.0], 9).is_none());
        assert!(spearman(&[1.0; 5], &[1.0, 2.0, 3.0, 4.0, 5.0], 9).is_none());
        let same = spearman(&[1.0, 2.0, 3.0, 4.0], &[1.0, 2.0, 3.0, 4.0], 9).expect("four");
        assert!(same.value.estimate > 0.999 && same.value.high <= 1.0);
    }
}
