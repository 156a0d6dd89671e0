//! Intervals by drawing packings again, with replacement: all numbers of a packing stay together.

use statrs::distribution::{ContinuousCDF, Normal};

use super::Interval;
use super::moments::{self, mean};
use super::random::{self, Key};

/// How often packings are drawn again: the ends of a 95 % interval are then known to about 3 % of its width.
pub const RESAMPLES: usize = 2000;

const KEY: Key = *b"crossgrain: packings drawn again";

/// The bias-corrected and accelerated interval (BCa, Efron 1987) of a statistic of so many packings, given
/// as a function of which of them are looked at (each may come more than once). Unlike the percentile
/// interval it allows for a biased and skewed statistic, such as a ratio. For the variation of exponential
/// values it still holds the truth too seldom with few packings (see the test). None for fewer than three packings
/// and where the statistic is not a number.
pub fn interval(
    packings: usize,
    level: f64,
    statistic: impl Fn(&[usize]) -> f64 + Sync,
) -> Option<Interval> {
    if packings < 3 {
        return None;
    }
    let all: Vec<usize> = (0..packings).collect();
    let estimate = statistic(&all);
    let mut drawn = random::replicates(&KEY, RESAMPLES, |source| {
        let again: Vec<usize> = all.iter().map(|_| source.below(packings)).collect();
        statistic(&again)
    });
    drawn.retain(|value| value.is_finite());
    if !estimate.is_finite() || drawn.len() < RESAMPLES / 2 {
        return None;
    }
    drawn.sort_by(f64::total_cmp);

    let normal = Normal::standard();
    let below = drawn.iter().filter(|value| **value < estimate).count() as f64;
    let equal = drawn.iter().filter(|value| **value == estimate).count() as f64;
    let count = drawn.len() as f64;
    let share = ((below + 0.5 * equal) / count).clamp(0.5 / count, 1.0 - 0.5 / count);
    let bias = normal.inverse_cdf(share);
    let acceleration = acceleration(&all, &statistic);
    let end = |share: f64| {
        let z = bias + normal.inverse_cdf(share);
        let moved = normal.cdf(bias + z / (1.0 - acceleration * z));
        quantile(&drawn, moved)
    };
    Some(Interval {
        estimate,
        low: end(0.5 - 0.5 * level),
        high: end(0.5 + 0.5 * level),
    })
}

/// Σd³/(6(Σd²)^1.5), d the mean of what the statistic is without one packing minus what it is; zero where all are equal.
fn acceleration(all: &[usize], statistic: &impl Fn(&[usize]) -> f64) -> f64 {
    let mut others = all[1..].to_vec();
    let mut without = Vec::with_capacity(all.len());
    for left_out in 0..all.len() {
        without.push(statistic(&others));
        if let Some(place) = others.get_mut(left_out) {
            *place = left_out;
        }
    }
    let centre = mean(&without);
    let cubes: f64 = without.iter().map(|value| (centre - value).powi(3)).sum();
    let squares: f64 = without.iter().map(|value| (centre - value).powi(2)).sum();
    let found = cubes / (6.0 * squares.powf(1.5));
    if found.is_finite() { found } else { 0.0 }
}

/// The value that a share lies below, linear between neighbours.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share.clamp(0.0, 1.0) * (sorted.len() - 1) as f64;
    let lower = place.floor() as usize;
    let upper = (lower + 1).min(sorted.len() - 1);
    sorted[lower] + (place - lower as f64) * (sorted[upper] - sorted[lower])
}

/// Coefficient of variation, standard deviation over mean, with its interval; one number a packing.
pub fn coefficient_of_variation(values: &[f64], level: f64) -> Option<Interval> {
    of_values(values, level, moments::coefficient_of_variation)
}

/// Any statistic of one number a packing with its interval.
pub fn of_values(
    values: &[f64],
    level: f64,
    statistic: impl Fn(&[f64]) -> f64 + Sync,
) -> Option<Interval> {
    interval(values.len(), level, |packings| {
        let drawn: Vec<f64> = packings.iter().map(|packing| values[*packing]).collect();
        statistic(&drawn)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::tests::AIR_CONDITIONING;
    use crate::proportion::wilson;
    use crate::random::replicates;

    const KEY: Key = *b"crossgrain: tests of resampling ";

    /// `scipy.stats.bootstrap` 1.17.1, BCa, 100,000 resamples: CV 1.20612, 95 % interval 0.9591 to 1.5510;
    /// (percentile: 0.8931 to 1.4799, which the bounds here keep out).
    #[test]
    fn variation_of_a_known_sample() {
        let found = coefficient_of_variation(&AIR_CONDITIONING, 0.95).expect("thirty values");
        assert!((found.estimate - 1.206_120_4).abs() < 1.0e-6);
        assert!((found.low - 0.9591).abs() < 0.02, "{found:?}");
        assert!((found.high - 1.5510).abs() < 0.04, "{found:?}");
    }

    /// Packings of several numbers are drawn whole: the interval of the mean of forty packings with five equal
    /// numbers each is that of forty numbers, not of two hundred.
    #[test]
    fn packings_stay_together() {
        let values: Vec<f64> = (0..40).map(|k| f64::from(k * k % 17)).collect();
        let single = of_values(&values, 0.95, mean).expect("values");
        let packings: Vec<[f64; 5]> = values.iter().map(|value| [*value; 5]).collect();
        let five = interval(packings.len(), 0.95, |chosen| {
            let all: Vec<f64> = chosen.iter().flat_map(|one| packings[*one]).collect();
            mean(&all)
        });
        let five = five.expect("packings");
        assert!((five.low - single.low).abs() < 1.0e-9 && (five.high - single.high).abs() < 1.0e-9);
        let pooled: Vec<f64> = packings.iter().flatten().copied().collect();
        let pooled = of_values(&pooled, 0.95, mean).expect("values");
        assert!(pooled.high - pooled.low < 0.6 * (five.high - five.low));
    }

    /// How often the 95 % intervals of mean and variation of exponential values hold the truth, 1. That of the
    /// variation does so too seldom, since its error hangs on few large values: 0.89 of the times with a hundred
    /// packings and 0.92 with a thousand, in scipy 1.17.1 (400 and 300 trials) as here (1,500).
    #[test]
    fn intervals_cover() {
        for (count, trials, told) in [(100, 400, [0.94, 0.89]), (1000, 300, [0.95, 0.92])] {
            let covered = replicates(&KEY, trials, |source| {
                let values: Vec<f64> = (0..count).map(|_| source.exponential()).collect();
                let holds = |found: Option<Interval>| {
                    found.is_some_and(|found| found.low < 1.0 && found.high > 1.0)
                };
                let statistics = [mean, moments::coefficient_of_variation];
                statistics
                    .map(|statistic: fn(&[f64]) -> f64| holds(of_values(&values, 0.95, statistic)))
            });
            for (which, told) in told.into_iter().enumerate() {
                let hits = covered.iter().filter(|one| one[which]).count();
                let share = wilson(hits, trials, 0.99).expect("trials");
                assert!(share.low < told && told < share.high, "{count} {share:?}");
            }
        }
    }

    #[test]
    fn too_few() {
        assert!(of_values(&[1.0, 2.0], 0.95, mean).is_none());
        assert!(coefficient_of_variation(&[0.0, 0.0, 0.0], 0.95).is_none());
        let same = of_values(&[1.0, 1.0, 1.0], 0.95, mean).expect("three values");
        assert_eq!((same.low, same.high), (1.0, 1.0));
    }
}
