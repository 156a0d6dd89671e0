//! Histograms: equal bins and the density in each with its interval.

use super::Interval;
use super::proportion::wilson;

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
