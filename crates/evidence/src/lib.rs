//! Samples → estimates with intervals, paired comparisons and tests of equivalence.
//!
//! The unit of replication is always the packing: a sample has one number a packing.

pub mod bootstrap;
pub mod correlation;
pub mod equivalence;
pub mod exponential;
pub mod goodness;
pub mod histogram;
pub mod holm;
pub mod kolmogorov;
pub mod law;
pub mod likelihood;
pub mod line;
pub mod moments;
pub mod paired;
pub mod proportion;
pub mod random;
pub mod shape;
pub mod two_samples;
pub mod unpaired;

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// An estimate with its interval, all in the unit of what is estimated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Interval {
    /// The value in the middle.
    pub estimate: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// Everything divided by a positive number.
    pub fn over(&self, scale: f64) -> Interval {
        Interval {
            estimate: self.estimate / scale,
            low: self.low / scale,
            high: self.high / scale,
        }
    }

    /// The interval of the absolute value: its lower end is 0 where the interval holds 0.
    pub fn absolute(&self) -> Interval {
        let (low, high) = (self.low.abs(), self.high.abs());
        let holds_zero = self.low <= 0.0 && self.high >= 0.0;
        Interval {
            estimate: self.estimate.abs(),
            low: if holds_zero { 0.0 } else { low.min(high) },
            high: low.max(high),
        }
    }
}

/// The t distribution with `freedom` degrees of freedom; none for less than one.
fn student(freedom: f64) -> Option<StudentsT> {
    (freedom >= 1.0)
        .then(|| StudentsT::new(0.0, 1.0, freedom).ok())
        .flatten()
}

/// The t value that a share `level` of the distribution lies within, on both sides of zero.
fn two_sided(level: f64, freedom: f64) -> Option<f64> {
    Some(student(freedom)?.inverse_cdf(0.5 + 0.5 * level))
}
