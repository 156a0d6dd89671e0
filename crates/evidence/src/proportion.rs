//! Shares with Wilson's score interval, also above a limit that comes from the same values, their difference with Newcombe's, and
//! histograms made of them.

use statrs::distribution::{ContinuousCDF, Normal};

use super::Interval;
use super::moments::{mean, standard_deviation};

/// Wilson's interval for `hits` of `count` at this level (Wilson 1927); none of nothing.
pub fn wilson(hits: usize, count: usize, level: f64) -> Option<Interval> {
    let (n, p) = (count as f64, hits as f64 / count as f64);
    (count > 0).then(|| score(p, n, level))
}

/// The share of values above so many times their own mean, e^{−multiple} for an exponential. Large values raise share and limit at
/// once, so that the share varies less than one above a limit known beforehand, for exponentials and twice the mean by a factor of
/// 1.6. Wilson's interval of as many values as would have the variance of its influence function, 1(x > c x̄) − p − c f(c x̄)(x − x̄)
/// with the density f from a window of ±1.8 s n^{−1/5} about the limit. Where none or all are above it is Wilson's own.
/// None without values.
pub fn above_multiple_of_mean(values: &[f64], multiple: f64, level: f64) -> Option<Interval> {
    let (n, centre) = (values.len() as f64, mean(values));
    let limit = multiple * centre;
    let is_above = |value: &f64| *value > limit;
    let hits = values.iter().filter(|value| is_above(value)).count();
    let p = hits as f64 / n;
    let width = 1.8 * standard_deviation(values) * n.powf(-0.2);
    let near = values.iter().filter(|value| (*value - limit).abs() < width);
    let slope = multiple * near.count() as f64 / (2.0 * width * n);
    let influence = values.iter().map(|value| {
        let above = f64::from(u8::from(is_above(value)));
        (above - p - slope * (value - centre)).powi(2)
    });
    let variance = influence.sum::<f64>() / (n - 1.0);
    if hits == 0 || hits == values.len() || variance.is_nan() || variance <= 0.0 {
        return wilson(hits, values.len(), level);
    }
    Some(score(p, n * p * (1.0 - p) / variance, level))
}

/// Wilson's interval of a share p of n.
fn score(p: f64, n: f64, level: f64) -> Interval {
    let z = Normal::standard().inverse_cdf(0.5 + 0.5 * level);
    let scale = 1.0 + z * z / n;
    let centre = (p + 0.5 * z * z / n) / scale;
    let reach = z / scale * (p * (1.0 - p) / n + 0.25 * z * z / (n * n)).sqrt();
    let (low, high) = ((centre - reach).max(0.0), (centre + reach).min(1.0));
    Interval {
        estimate: p,
        // Both ends are exact where none or all were hit; rounding would leave 10⁻¹⁸.
        low: if p == 0.0 { 0.0 } else { low },
        high: if p == 1.0 { 1.0 } else { high },
    }
}

/// Second share minus first with Newcombe's interval (1998, method 10), each share as (hits, of).
pub fn difference(first: (usize, usize), second: (usize, usize), level: f64) -> Option<Interval> {
    let a = wilson(first.0, first.1, level)?;
    let b = wilson(second.0, second.1, level)?;
    let estimate = b.estimate - a.estimate;
    let down = (b.estimate - b.low).hypot(a.high - a.estimate);
    let up = (b.high - b.estimate).hypot(a.estimate - a.low);
    Some(Interval {
        estimate,
        low: estimate - down,
        high: estimate + up,
    })
}

/// Equal bins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bins {
    /// Lower end of the first one.
    pub start: f64,
    pub step: f64,
    pub count: usize,
}

impl Bins {
    /// Lower end of a bin, counted from 0; that of the one after the last is the end.
    pub fn edge(&self, index: usize) -> f64 {
        self.start + self.step * index as f64
    }

    /// Upper end of the last bin.
    pub fn end(&self) -> f64 {
        self.edge(self.count)
    }

    /// The density in each bin, over the unit of the values: share of all values over the bin's width, with Wilson's
    /// interval. A bin holds its lower end, the last one its upper end too. Empty without values.
    pub fn densities(&self, values: &[f64], level: f64) -> Vec<Interval> {
        (0..self.count)
            .filter_map(|index| {
                let (from, to) = (self.edge(index), self.edge(index + 1));
                let last = index + 1 == self.count;
                let inside =
                    |value: &&f64| **value >= from && (**value < to || last && **value == to);
                let hits = values.iter().filter(inside).count();
                Some(wilson(hits, values.len(), level)?.over(self.step))
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Key, replicates};

    /// Newcombe 1998: 56 of 70 against 48 of 80 differ by 0.20, 95 % interval 0.0524 to 0.3339; Wilson's
    /// interval of 81 of 263 is 0.2553 to 0.3662.
    #[test]
    fn newcombes_examples() {
        let one = wilson(81, 263, 0.95).expect("not of nothing");
        assert!((one.low - 0.2553).abs() < 1.0e-4 && (one.high - 0.3662).abs() < 1.0e-4);
        let two = difference((48, 80), (56, 70), 0.95).expect("not of nothing");
        assert!((two.estimate - 0.2).abs() < 1.0e-12);
        assert!((two.low - 0.0524).abs() < 1.0e-4, "{two:?}");
        assert!((two.high - 0.3339).abs() < 1.0e-4, "{two:?}");
    }

    #[test]
    fn none_of_a_hundred_may_still_be_four() {
        let none = wilson(0, 100, 0.95).expect("not of nothing");
        assert_eq!(none.low, 0.0);
        assert!((none.high - 0.0370).abs() < 1.0e-4);
        assert!(wilson(0, 0, 0.95).is_none());
    }

    /// How often the 95 % interval of a share above multiples of the mean holds the true share, which Wilson's does 99.8 % of the
    /// times for exponentials and twice the mean: it is 1.6 times too wide.
    #[test]
    fn shares_above_an_estimated_limit_are_covered() {
        const KEY: Key = *b"crossgrain: tests of some shares";
        let trials = 2000;
        for (multiple, shape, truth) in [
            (2.0, 1.0, (-2.0f64).exp()),
            (3.0, 1.0, (-3.0f64).exp()),
            // Of x e^{−x}: (1 + 2c) e^{−2c}.
            (2.0, 2.0, 5.0 * (-4.0f64).exp()),
            (3.0, 2.0, 7.0 * (-6.0f64).exp()),
        ] {
            for count in [50, 200, 1000] {
                let found = replicates(&KEY, trials, |source| {
                    let values: Vec<f64> = (0..count).map(|_| source.gamma(shape)).collect();
                    let own = above_multiple_of_mean(&values, multiple, 0.95).expect("values");
                    let hits = (own.estimate * count as f64).round() as usize;
                    let wilson = wilson(hits, count, 0.95).expect("values");
                    let holds =
                        |interval: Interval| interval.low <= truth && truth <= interval.high;
                    let width = (own.high - own.low) / (wilson.high - wilson.low);
                    (holds(own), holds(wilson), width)
                });
                let share = |condition: fn(&(bool, bool, f64)) -> bool| {
                    found.iter().filter(|one| condition(one)).count() as f64 / trials as f64
                };
                let own = share(|one| one.0);
                let within = own > 0.93 && own < 0.985;
                assert!(within, "{multiple} {shape} {count} {own}");
                if multiple == 2.0 && shape == 1.0 && count >= 200 {
                    assert!(share(|one| one.1) > 0.99);
                    let widths: Vec<f64> = found.iter().map(|one| one.2).collect();
                    assert!((1.0 / mean(&widths) - 1.6).abs() < 0.1, "{}", mean(&widths));
                }
            }
        }
        // Where nothing is above, the interval is not empty.
        let none = above_multiple_of_mean(&[1.0, 1.1, 1.2, 0.9], 2.0, 0.95).expect("values");
        assert!(none.low == 0.0 && none.high > 0.4);
        assert!(above_multiple_of_mean(&[], 2.0, 0.95).is_none());
        assert!(above_multiple_of_mean(&[1.0], 0.5, 0.95).is_some());
    }

    #[test]
    fn every_value_between_the_ends_counts_once() {
        let bins = Bins {
            start: -1.0,
            step: 0.5,
            count: 4,
        };
        let values = [-1.0, -0.6, -0.5, 0.0, 0.25, 1.0, 1.5, -2.0];
        let found = bins.densities(&values, 0.95);
        let shares: Vec<f64> = found
            .iter()
            .map(|interval| interval.estimate * 0.5 * 8.0)
            .collect();
        assert_eq!(shares, [2.0, 1.0, 2.0, 1.0]);
        let is_inside = |interval: &Interval| {
            interval.low < interval.estimate && interval.estimate < interval.high
        };
        assert!(found.iter().all(is_inside));
        assert!(bins.densities(&[], 0.95).is_empty());
    }
}
