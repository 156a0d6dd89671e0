//! Mean, standard deviation, median, coefficient of variation, and the t interval of a mean.

use super::{Interval, two_sided};

/// Σx/n; not a number without values.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// √(Σ(x − x̄)²/(n − 1)); not a number for fewer than two values.
pub fn standard_deviation(values: &[f64]) -> f64 {
    let centre = mean(values);
    let squares: f64 = values.iter().map(|value| (value - centre).powi(2)).sum();
    if values.len() < 2 {
        return f64::NAN;
    }
    (squares / (values.len() - 1) as f64).sqrt()
}

/// The middle value, or the mean of the two in the middle; none without values.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let upper = *sorted.get(sorted.len() / 2)?;
    let lower = sorted[(sorted.len() - 1) / 2];
    Some(0.5 * (lower + upper))
}

/// x̄ ± t·s/√n, which holds the true mean with probability `level` for normal values; none for fewer than two.
pub fn mean_interval(values: &[f64], level: f64) -> Option<Interval> {
    let count = values.len() as f64;
    let reach = two_sided(level, count - 1.0)? * standard_deviation(values) / count.sqrt();
    Some(Interval::about(mean(values), reach))
}

/// Standard deviation over mean; 1 for an exponential.
pub fn coefficient_of_variation(values: &[f64]) -> f64 {
    standard_deviation(values) / mean(values)
}

/// The share of values above so many means; e^{−multiple} for an exponential.
pub fn share_above(values: &[f64], multiple: f64) -> f64 {
    let limit = multiple * mean(values);
    values.iter().filter(|value| **value > limit).count() as f64 / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Student's own sleep data (1908): ten differences, mean 1.58, s 1.230, 95 % interval 0.70 to 2.46.
    #[test]
    fn the_interval_of_students_sleep_data() {
        let gained = [1.2, 2.4, 1.3, 1.3, 0.0, 1.0, 1.8, 0.8, 4.6, 1.4];
        assert!((standard_deviation(&gained) - 1.229_995).abs() < 1.0e-6);
        let interval = mean_interval(&gained, 0.95).expect("ten values");
        assert!((interval.estimate - 1.58).abs() < 1.0e-12);
        assert!((interval.low - 0.700_114).abs() < 1.0e-6, "{interval:?}");
        assert!((interval.high - 2.459_886).abs() < 1.0e-6, "{interval:?}");
    }

    #[test]
    fn one_value_has_no_interval() {
        assert!(mean_interval(&[1.0], 0.95).is_none());
        assert!(standard_deviation(&[1.0]).is_nan());
    }

    #[test]
    fn medians() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), Some(2.5));
        assert_eq!(median(&[]), None);
    }

    #[test]
    fn an_exponential_has_ones() {
        // The quantiles at the middles of a thousand equal shares.
        let quantile = |k| -(1.0 - (f64::from(k) + 0.5) / 1000.0f64).ln();
        let values: Vec<f64> = (0..1000).map(quantile).collect();
        assert!((coefficient_of_variation(&values) - 1.0).abs() < 0.01);
        assert!((share_above(&values, 2.0) - (-2.0f64).exp()).abs() < 0.002);
        assert!((share_above(&values, 0.0) - 1.0).abs() < 1.0e-12);
    }
}
