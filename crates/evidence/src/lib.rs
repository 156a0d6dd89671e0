//! Samples to estimates with intervals, comparisons, tests of equivalence, fitted distributions and corrections for
//! multiplicity. Knows nothing of grains, files or terminals, and can be used alone.
//!
//! A sample is a slice with one number for each independent observation. Where an observation has several numbers that hang
//! together, as the grains of a packing do, [`bootstrap`] and [`two_samples`] draw and exchange whole observations.
//!
//! | question | module |
//! |---|---|
//! | what is the mean, and how well is it known? | [`moments`], [`bootstrap`] for any other statistic |
//! | how large is a share? | [`proportion`] |
//! | do means differ, or are they equivalent? | [`t_test`] |
//! | does one number follow another? | [`regression`] |
//! | which distribution do values have? | [`distribution`] fits, [`goodness`] of fit, [`likelihood`] of one against another |
//! | do two samples have one distribution? | [`two_samples`] |
//! | what does a simulation give where it was not run? | [`emulator`] |
//! | which settings cannot have given published figures? | [`history`] |
//! | what of values that are exactly zero? | [`zeros`] |
//! | what of many tests at once? | [`holm`] |
//!
//! Random numbers come from [`random`], under a key for each purpose: the same input gives the same result on any machine.
//!
//! ```
//! use evidence::moments::mean_interval;
//! use evidence::t_test::{Finding, equivalence};
//! use evidence::holm;
//!
//! // Student's sleep data: hours of sleep that ten patients gained.
//! let gained = [1.2, 2.4, 1.3, 1.3, 0.0, 1.0, 1.8, 0.8, 4.6, 1.4];
//! let mean = mean_interval(&gained, 0.95).ok_or("fewer than two values")?;
//! assert!(mean.low > 0.70 && mean.high < 2.46);
//!
//! // Is it less than 2.5 hours, one way or the other? The margin was set before.
//! let (finding, p) = equivalence(&gained, 2.5).ok_or("fewer than two values")?;
//! assert_eq!(finding, Finding::Equivalent);
//!
//! // As one of three tests.
//! let adjusted = holm::adjusted(&[p, 0.3, 0.004]);
//! assert!(adjusted[0] > p && adjusted[0] < 0.05);
//! # Ok::<(), &str>(())
//! ```

pub mod bootstrap;
pub mod distribution;
pub mod emulator;
pub mod goodness;
pub mod history;
pub mod holm;
pub mod likelihood;
pub mod moments;
pub mod proportion;
pub mod random;
pub mod regression;
pub mod t_test;
pub mod two_samples;
pub mod zeros;

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// An estimate with its interval, all in the unit of what is estimated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Interval {
    pub estimate: f64,
    pub low: f64,
    pub high: f64,
}

impl Interval {
    /// `reach` to both sides of an estimate.
    fn about(estimate: f64, reach: f64) -> Self {
        Interval {
            estimate,
            low: estimate - reach,
            high: estimate + reach,
        }
    }

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

/// Where what holds near the lower end of an interval of positive numbers ceases to hold, by halving on a logarithmic scale.
fn halved([mut low, mut high]: [f64; 2], times: u32, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..times {
        let middle = (low * high).sqrt();
        // No number lies between.
        if middle == low || middle == high {
            break;
        }
        let end = if holds(middle) { &mut low } else { &mut high };
        *end = middle;
    }
    (low * high).sqrt()
}

/// The results of `work` for 0 … count−1 in order, worked out by as many threads as there are processors.
pub fn in_parallel<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let processors = thread::available_parallelism().map_or(1, usize::from);
    on_threads(processors, count, work)
}

fn on_threads<T: Send>(threads: usize, count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let share = || {
        let indices = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
        let mine = indices.take_while(|index| *index < count);
        mine.map(|index| (index, work(index))).collect::<Vec<_>>()
    };
    let mut results: Vec<(usize, T)> = thread::scope(|scope| {
        let others = (1..threads.min(count)).map(|_| scope.spawn(share));
        let others: Vec<_> = others.collect();
        let mut all = share();
        for other in others {
            all.extend(other.join().unwrap_or_else(|panic| resume_unwind(panic)));
        }
        all
    });
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}

/// As many of these trials hold as have this probability, as far as Wilson's interval of this level tells.
#[cfg(test)]
fn assert_share(trials: impl IntoIterator<Item = bool>, level: f64, probability: f64) {
    let trials: Vec<bool> = trials.into_iter().collect();
    let hits = trials.iter().filter(|holds| **holds).count();
    let share = proportion::wilson(hits, trials.len(), level).expect("trials");
    let within = share.low < probability && share.high > probability;
    assert!(within, "{probability}: {share:?}");
}
