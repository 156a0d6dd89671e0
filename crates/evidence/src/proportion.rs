//! Shares with Wilson's score interval, their difference with Newcombe's, and histograms made of them.

use statrs::distribution::{ContinuousCDF, Normal};

use super::Interval;

/// Wilson's interval for `hits` of `of` at this level (Wilson 1927); none of nothing.
pub fn wilson(hits: usize, of: usize, level: f64) -> Option<Interval> {
    if of == 0 {
        return None;
    }
    let z = Normal::standard().inverse_cdf(0.5 + 0.5 * level);
    let (n, p) = (of as f64, hits as f64 / of as f64);
    let scale = 1.0 + z * z / n;
    let centre = (p + 0.5 * z * z / n) / scale;
    let reach = z / scale * (p * (1.0 - p) / n + 0.25 * z * z / (n * n)).sqrt();
    Some(Interval {
        estimate: p,
        // Both ends are exact where none or all were hit; rounding would leave 10⁻¹⁸.
        low: if hits == 0 {
            0.0
        } else {
            (centre - reach).max(0.0)
        },
        high: if hits == of {
            1.0
        } else {
            (centre + reach).min(1.0)
        },
    })
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
    /// Width of each.
    pub step: f64,
    /// How many.
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

    #[test]
    fn every_value_between_the_ends_counts_once() {
        let bins = Bins {
            start: -1.0,
            step: 0.5,
            count: 4,
        };
        let values = [-1.0, -0.6, -0.5, 0.0, 0.25, 1.0, 1.5, -2.0];
        let found = bins.densities(&values, 0.95);
        let shares: Vec<f64> = found.iter().map(|of| of.estimate * 0.5 * 8.0).collect();
        assert_eq!(shares, [2.0, 1.0, 2.0, 1.0]);
        assert!(
            found
                .iter()
                .all(|of| of.low < of.estimate && of.estimate < of.high)
        );
        assert!(bins.densities(&[], 0.95).is_empty());
    }
}
