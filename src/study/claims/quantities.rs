//! Intervals of what claims are about, each as a function of the level.

use evidence::law::Family;
use evidence::likelihood::against_exponential;
use evidence::{Interval, bootstrap, moments, proportion, shape};

/// Mean with its t interval.
pub fn mean(values: &[f64]) -> impl Fn(f64) -> Option<Interval> {
    |level| moments::mean_interval(values, level)
}

/// Standard deviation over mean with its BCa interval over packings.
pub fn variation(values: &[f64]) -> impl Fn(f64) -> Option<Interval> {
    |level| bootstrap::variation(values, level)
}

/// Share above so many means, with Wilson's interval.
pub fn share_above(values: &[f64], multiple: f64) -> impl Fn(f64) -> Option<Interval> {
    let share = shape::share_above(values, multiple);
    let hits = (share * values.len() as f64).round() as usize;
    move |level| proportion::wilson(hits, values.len(), level)
}

/// Share for which something holds, with Wilson's interval.
pub fn share(values: &[f64], holds: fn(f64) -> bool) -> impl Fn(f64) -> Option<Interval> {
    let hits = values.iter().filter(|value| holds(**value)).count();
    move |level| proportion::wilson(hits, values.len(), level)
}

/// Shape of the gamma law with its deviance interval.
pub fn gamma_shape(values: &[f64]) -> impl Fn(f64) -> Option<Interval> {
    law_shape(Family::Gamma, values)
}

/// Shape of the gamma or Weibull law with its deviance interval. That one is of 95 %; other levels have the ends
/// where a normal logarithm of the shape would have them.
pub fn law_shape(family: Family, values: &[f64]) -> impl Fn(f64) -> Option<Interval> + use<> {
    use statrs::distribution::{ContinuousCDF, Normal};
    let found = against_exponential(family, values).map(|found| found.shape);
    move |level| {
        let of = found?;
        let normal = Normal::standard();
        let reach = normal.inverse_cdf(0.5 + 0.5 * level) / normal.inverse_cdf(0.975);
        Some(Interval {
            estimate: of.estimate,
            low: of.estimate * (of.low / of.estimate).powf(reach),
            high: of.estimate * (of.high / of.estimate).powf(reach),
        })
    }
}

/// Any statistic of one number a packing, with its BCa interval.
pub fn statistic(values: &[f64], of: fn(&[f64]) -> f64) -> impl Fn(f64) -> Option<Interval> {
    move |level| bootstrap::of_values(values, level, of)
}
