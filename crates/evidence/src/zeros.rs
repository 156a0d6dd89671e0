//! Values of which some are exactly zero, as the load of a grain that carries nothing, or below zero, as that of one that is pulled:
//! a share of all that the continuous laws of loads have no place for. What is said of the others' distribution – fit, distance, shape, coefficient of variation, share
//! above multiples of the mean – is said under the condition that a value is none of them, with their share beside it.

use super::Interval;
use super::proportion::wilson;

/// Values parted into zeros and others.
#[derive(Debug, Clone, PartialEq)]
pub struct Parted {
    /// How many are exactly zero, or set aside with those.
    pub zeros: usize,
    pub others: Vec<f64>,
}

impl Parted {
    pub fn of(values: &[f64]) -> Self {
        Parted::by(values, |value| value != 0.0)
    }

    /// Of loads: those at or below zero are set aside. A law of positive values has no place for either.
    pub fn loads(values: &[f64]) -> Self {
        // What is not a number is no load either, and must not be hidden as one.
        Parted::by(values, |value| value > 0.0 || value.is_nan())
    }

    fn by(values: &[f64], stays: impl Fn(f64) -> bool) -> Self {
        let others: Vec<f64> = values
            .iter()
            .copied()
            .filter(|value| stays(*value))
            .collect();
        Parted {
            zeros: values.len() - others.len(),
            others,
        }
    }

    /// The share of zeros with Wilson's interval; none without values.
    pub fn share_of_zeros(&self, level: f64) -> Option<Interval> {
        wilson(self.zeros, self.zeros + self.others.len(), level)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::Family;
    use crate::goodness;
    use crate::moments::coefficient_of_variation;
    use crate::random::{Key, Source};

    /// Exponential values with one in ten set to zero: the others are exponential by every measure, all together are by none.
    #[test]
    fn zeros_are_no_part_of_the_distribution() {
        const KEY: Key = *b"crossgrain: tests of many zeros ";
        let mut source = Source::new(&KEY, 0);
        let mut draw = || match source.uniform() < 0.1 {
            true => 0.0,
            false => source.exponential(),
        };
        let values: Vec<f64> = (0..2000).map(|_| draw()).collect();
        let parted = Parted::of(&values);
        let share = parted.share_of_zeros(0.99).expect("values");
        assert!(share.low < 0.1 && share.high > 0.1, "{share:?}");
        let fit = |values: &[f64]| goodness::fitted(Family::Exponential, values, 999);
        let p = |values: &[f64]| fit(values).expect("a fit").anderson_darling_p;
        assert!(p(&parted.others) > 0.01);
        assert!((coefficient_of_variation(&parted.others) - 1.0).abs() < 0.08);
        assert_eq!(p(&values), 1.0e-3);
        // √(2/0.9 − 1) = 1.106.
        assert!((coefficient_of_variation(&values) - 1.106).abs() < 0.08);
        assert!(Parted::of(&[]).share_of_zeros(0.95).is_none());
        // Three that are slightly negative change nothing but the share.
        let pulled = [&values[..], &[-1.0e-3, -2.0e-3, -1.0e-9]].concat();
        let loads = Parted::loads(&pulled);
        assert_eq!(
            (loads.zeros, loads.others),
            (parted.zeros + 3, parted.others)
        );
    }
}
