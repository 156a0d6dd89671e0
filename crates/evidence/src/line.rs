//! A straight line by least squares; its slope is the order of convergence where both axes are logarithms.

use super::moments::mean;
use super::{Interval, two_sided};

/// Slope of the line through the points with its 95 % t interval; none for fewer than three points or a single
/// abscissa.
pub fn slope(points: &[(f64, f64)]) -> Option<Interval> {
    let xs: Vec<f64> = points.iter().map(|point| point.0).collect();
    let ys: Vec<f64> = points.iter().map(|point| point.1).collect();
    let (x, y) = (mean(&xs), mean(&ys));
    let spread: f64 = xs.iter().map(|value| (value - x).powi(2)).sum();
    if spread.is_nan() || spread <= 0.0 {
        return None;
    }
    let products = points.iter().map(|(a, b)| (a - x) * (b - y));
    let estimate = products.sum::<f64>() / spread;
    let residuals = points.iter().map(|(a, b)| b - y - estimate * (a - x));
    let freedom = points.len() as f64 - 2.0;
    let variance = residuals.map(|off| off * off).sum::<f64>() / freedom;
    let reach = two_sided(0.95, freedom)? * (variance / spread).sqrt();
    Some(Interval {
        estimate,
        low: estimate - reach,
        high: estimate + reach,
    })
}

/// Height of the line at abscissa 0 with its 95 % t interval; none for fewer than three points or a single abscissa.
pub fn intercept(points: &[(f64, f64)]) -> Option<Interval> {
    let slope = slope(points)?;
    let count = points.len() as f64;
    let xs: Vec<f64> = points.iter().map(|point| point.0).collect();
    let ys: Vec<f64> = points.iter().map(|point| point.1).collect();
    let (x, y) = (mean(&xs), mean(&ys));
    let spread: f64 = xs.iter().map(|value| (value - x).powi(2)).sum();
    let estimate = y - slope.estimate * x;
    // Both have the same t and the same variance of residuals: that of the slope is s²/Σ(x − x̄)².
    let reach = (slope.high - slope.estimate) * (spread / count + x * x).sqrt();
    Some(Interval {
        estimate,
        low: estimate - reach,
        high: estimate + reach,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Anscombe's first set: intercept 3.0001, standard error 1.1247.
    #[test]
    fn anscombes_intercept() {
        let xs = [10.0, 8.0, 13.0, 9.0, 11.0, 14.0, 6.0, 4.0, 12.0, 7.0, 5.0];
        let ys = [
            8.04, 6.95, 7.58, 8.81, 8.33, 9.96, 7.24, 4.26, 10.84, 4.82, 5.68,
        ];
        let points: Vec<(f64, f64)> = xs.into_iter().zip(ys).collect();
        let found = intercept(&points).expect("eleven points");
        assert!((found.estimate - 3.00009).abs() < 1.0e-5);
        assert!((found.high - found.estimate - 2.262 * 1.1247).abs() < 1.0e-3);
    }

    /// Anscombe's first set (1973): slope 0.5001, standard error 0.1179, t = 2.262 on 9 degrees of freedom.
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
}
