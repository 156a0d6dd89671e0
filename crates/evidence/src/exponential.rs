//! The mean of an exponential law.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::Interval;
use super::moments::mean;

/// The interval of the mean if the values are exponential: 2nx̄/μ is χ² with 2n degrees of freedom. None
/// without values or with a negative one.
pub fn mean_interval(values: &[f64], level: f64) -> Option<Interval> {
    if values.is_empty() || !values.iter().all(|value| *value >= 0.0) {
        return None;
    }
    let law = ChiSquared::new(2.0 * values.len() as f64).ok()?;
    let twice = 2.0 * values.iter().sum::<f64>();
    Some(Interval {
        estimate: mean(values),
        low: twice / law.inverse_cdf(0.5 + 0.5 * level),
        high: twice / law.inverse_cdf(0.5 - 0.5 * level),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::tests::AIR_CONDITIONING;

    /// scipy 1.17.1, 2Σx/chi2.ppf: 42.930370 to 88.336106.
    #[test]
    fn the_interval_of_a_known_sample() {
        let found = mean_interval(&AIR_CONDITIONING, 0.95).expect("not negative");
        assert!((found.estimate - 59.6).abs() < 1.0e-12);
        assert!((found.low - 42.930_370).abs() < 1.0e-5, "{found:?}");
        assert!((found.high - 88.336_106).abs() < 1.0e-5, "{found:?}");
        assert!(mean_interval(&[], 0.95).is_none());
        assert!(mean_interval(&[1.0, -1.0], 0.95).is_none());
    }
}
