//! A simulation's mean over a space of settings, from noisy means at some of them: a Gaussian process with a linear trend
//! (Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, chapters 2 and 5).
//!
//! The noise of each mean is given and may differ from setting to setting; means of one group, as loads on the same beds, are
//! correlated. Coordinates are in the unit cube.

use std::f64::consts::TAU;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::moments::{mean, standard_deviation};

/// A mean that was found at a setting.
#[derive(Debug, Clone, PartialEq)]
pub struct Observation {
    /// Coordinates of the setting, each in 0 to 1.
    pub at: Vec<f64>,
    /// Noise is correlated within a group.
    pub group: usize,
    pub mean: f64,
    /// Of the mean, by sampling.
    pub variance: f64,
}

/// What is expected at a setting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected {
    pub mean: f64,
    /// Of the mean; the noise of another observation is not in it.
    pub variance: f64,
}

/// A fitted Gaussian process. In units of the observed means' deviation, about their mean.
#[derive(Debug, Clone)]
pub struct Emulator {
    /// What it was fitted to.
    pub observed: Vec<Observation>,
    centre: f64,
    unit: f64,
    law: Law,
    factor: Cholesky<f64, Dyn>,
    /// K⁻¹y.
    weights: DVector<f64>,
    /// By how much all deviations are larger than the process has them, so that 95 % of the observed means are within 1.96
    /// deviations of what is expected of them from the other groups.
    pub inflation: f64,
}

/// The process before anything is observed.
#[derive(Debug, Clone)]
struct Law {
    /// ln of the lengths over which the process changes, one an axis, then of its deviation, then of that of what no smooth
    /// function can follow.
    logarithms: Vec<f64>,
    /// The lengths themselves: they are asked for at every pair of settings.
    lengths: Vec<f64>,
}

/// The variance of the trend's coefficients: next to nothing is known of them.
const TREND: f64 = 100.0;
/// What is expected of the logarithms, each with deviation 1: changes over the whole cube, of the size of the observed
/// differences, and a thirtieth of it that is not smooth.
const EXPECTED: [f64; 3] = [0.0, 0.0, -3.5];
/// Steps of the search for the most likely law.
const STEPS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];

impl Law {
    /// Of as many logarithms as there are axes and two more.
    fn of(logarithms: Vec<f64>) -> Self {
        let axes = &logarithms[..logarithms.len() - 2];
        let lengths = axes.iter().map(|length| length.exp()).collect();
        Law {
            logarithms,
            lengths,
        }
    }

    /// Deviations of what is smooth and of what is not.
    fn deviations(&self) -> [f64; 2] {
        let axes = self.lengths.len();
        [axes, axes + 1].map(|index| self.logarithms[index].exp())
    }

    /// Covariance of the means at two settings, without what is not smooth; `smooth` is the deviation of what is.
    fn between(&self, smooth: f64, one: &[f64], other: &[f64]) -> f64 {
        let (mut distance, mut trend) = (0.0, 1.0);
        for ((a, b), length) in one.iter().zip(other).zip(&self.lengths) {
            distance += ((a - b) / length).powi(2);
            trend += (a - 0.5) * (b - 0.5);
        }
        smooth * smooth * (-0.5 * distance).exp() + TREND * trend
    }

    fn of_observed(&self, all: &[Observation], noise: &DMatrix<f64>) -> DMatrix<f64> {
        let [smooth, rough] = self.deviations();
        let mut covariance = noise.clone();
        for (row, one) in all.iter().enumerate() {
            for (column, other) in all.iter().enumerate().take(row + 1) {
                let term = self.between(smooth, &one.at, &other.at);
                covariance[(row, column)] += term;
                if row != column {
                    covariance[(column, row)] += term;
                }
            }
            covariance[(row, row)] += rough * rough;
        }
        covariance
    }

    /// ln of how well the law does before anything is observed, but for a constant.
    fn expected(&self) -> f64 {
        let last = self.logarithms.len() - 2;
        let logarithms = self.logarithms.iter().enumerate();
        let off = logarithms
            .map(|(index, logarithm)| logarithm - EXPECTED[(index + 1).saturating_sub(last)]);
        -0.5 * off.map(|off| off * off).sum::<f64>()
    }
}

impl Emulator {
    /// The most likely process of these means; `correlation` is that of the noise within a group, in 0 to 1. None for fewer
    /// than three, or equal means without noise.
    pub fn of(observed: Vec<Observation>, correlation: f64) -> Option<Self> {
        let means: Vec<f64> = observed
            .iter()
            .map(|observation| observation.mean)
            .collect();
        let noise: Vec<f64> = observed
            .iter()
            .map(|observation| observation.variance)
            .collect();
        let centre = mean(&means);
        let unit = standard_deviation(&means).max(mean(&noise).sqrt());
        if observed.len() < 3 || unit.is_nan() || unit <= 0.0 {
            return None;
        }
        let y =
            DVector::from_iterator(means.len(), means.iter().map(|mean| (mean - centre) / unit));
        let noise = DMatrix::from_fn(y.len(), y.len(), |row, column| {
            let (one, other) = (&observed[row], &observed[column]);
            let both = (one.variance * other.variance).sqrt() / (unit * unit);
            match (row == column, one.group == other.group) {
                (true, _) => both,
                (false, true) => correlation * both,
                (false, false) => 0.0,
            }
        });
        let fitted = |law: &Law| {
            let factor = law.of_observed(&observed, &noise).cholesky()?;
            let weights = factor.solve(&y);
            let diagonal = factor.l_dirty().diagonal();
            let determinant: f64 = diagonal.iter().map(|value| value.ln()).sum();
            let likelihood = -0.5 * (y.dot(&weights) + y.len() as f64 * TAU.ln()) - determinant;
            Some((likelihood + law.expected(), factor, weights))
        };
        let axes = observed[0].at.len();
        let mut law = Law::of([&vec![EXPECTED[0]; axes][..], &EXPECTED[1..]].concat());
        let mut best = fitted(&law)?;
        for step in STEPS {
            let mut moved = true;
            while moved {
                moved = false;
                for index in 0..law.logarithms.len() {
                    for by in [step, -step] {
                        let mut other = law.logarithms.clone();
                        other[index] += by;
                        let other = Law::of(other);
                        if let Some(found) = fitted(&other)
                            && found.0 > best.0 + 1.0e-3
                        {
                            (law, best, moved) = (other, found, true);
                            break;
                        }
                    }
                }
            }
        }
        let (_, factor, weights) = best;
        let mut emulator = Emulator {
            observed,
            centre,
            unit,
            law,
            factor,
            weights,
            inflation: 1.0,
        };
        let left_out = emulator.left_out();
        let off = left_out.iter().zip(&emulator.observed);
        let off =
            off.map(|(expected, own)| (expected.mean - own.mean).abs() / expected.variance.sqrt());
        let mut off: Vec<f64> = off.collect();
        off.sort_by(f64::total_cmp);
        let nineteen_in_twenty = (0.95 * off.len() as f64).ceil() as usize;
        let within = off.get(nineteen_in_twenty.saturating_sub(1));
        emulator.inflation = within.map_or(1.0, |deviation| (deviation / 1.96).max(1.0));
        Some(emulator)
    }

    /// What is expected at a setting that need not be observed.
    pub fn at(&self, at: &[f64]) -> Expected {
        let all = self.observed.iter();
        let [smooth, rough] = self.law.deviations();
        let shared = all.map(|observation| self.law.between(smooth, at, &observation.at));
        let shared = DVector::from_iterator(self.observed.len(), shared);
        let own = self.law.between(smooth, at, at) + rough * rough;
        let mut known = shared.clone();
        self.factor.l_dirty().solve_lower_triangular_mut(&mut known);
        self.expected(shared.dot(&self.weights), own - known.norm_squared())
    }

    fn expected(&self, mean: f64, variance: f64) -> Expected {
        Expected {
            mean: self.centre + self.unit * mean,
            variance: (self.inflation * self.unit).powi(2) * variance.max(0.0),
        }
    }

    /// What is expected of each observed mean from those of the other groups; the variance has the mean's own noise in it.
    pub fn left_out(&self) -> Vec<Expected> {
        let inverse = self.factor.inverse();
        let own = |index: usize| -> Option<Expected> {
            let group = self.observed[index].group;
            let all = 0..self.observed.len();
            let members = all.filter(|member| self.observed[*member].group == group);
            let members: Vec<usize> = members.collect();
            let block = inverse.select_rows(&members).select_columns(&members);
            let weights = self.weights.select_rows(&members);
            let block = block.cholesky()?;
            let off = block.solve(&weights);
            let place = members.iter().position(|member| *member == index)?;
            let observed = (self.observed[index].mean - self.centre) / self.unit;
            Some(self.expected(observed - off[place], block.inverse()[(place, place)]))
        };
        (0..self.observed.len()).filter_map(own).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Source;

    const KEY: crate::random::Key = *b"crossgrain: tests of an emulator";

    fn truth(at: &[f64]) -> f64 {
        10.0 + 6.0 * at[0] + 3.0 * (4.0 * at[1]).sin() + at[0] * at[1]
    }

    /// Groups of four with common noise; an axis without effect is among the three.
    fn observed(source: &mut Source, groups: usize) -> Vec<Observation> {
        let mut all = Vec::new();
        for group in 0..groups {
            let common = source.normal();
            for _ in 0..4 {
                let at: Vec<f64> = (0..3).map(|_| source.uniform()).collect();
                let deviation = 0.2 + 0.8 * at[0];
                let noise = 0.5f64.sqrt() * (common + source.normal());
                all.push(Observation {
                    mean: truth(&at) + deviation * noise,
                    variance: deviation * deviation,
                    group,
                    at,
                });
            }
        }
        all
    }

    /// The true mean is within 1.96 deviations of what is expected in about 95 % of the places, rather more,, over forty samples.
    #[test]
    fn deviations_are_those_of_the_errors() {
        let (mut within, mut errors, mut left) = (0, 0.0, 0);
        let (samples, places) = (40, 50);
        for sample in 0..samples {
            let source = &mut Source::new(&KEY, sample);
            let all = observed(source, 30);
            let emulator = Emulator::of(all.clone(), 0.5).expect("it fits");
            for _ in 0..places {
                let at: Vec<f64> = (0..3).map(|_| source.uniform()).collect();
                let found = emulator.at(&at);
                let off = found.mean - truth(&at);
                errors += off * off;
                within += usize::from(off.abs() < 1.96 * found.variance.sqrt());
            }
            let out = emulator.left_out();
            assert_eq!(out.len(), all.len());
            let near = |(expected, at): &(&Expected, &Observation)| {
                (expected.mean - at.mean).abs() < 1.96 * expected.variance.sqrt()
            };
            left += out.iter().zip(&all).filter(near).count();
        }
        let all = (samples * places) as f64;
        let share = within as f64 / all;
        // A little more, as there might be what is not smooth.
        assert!((0.93..0.99).contains(&share), "{share}");
        let left = left as f64 / (samples * 120) as f64;
        assert!((0.92..0.98).contains(&left), "{left}");
        // Less than the least noise of a single mean, and far less than the differences.
        let error = (errors / all).sqrt();
        assert!(error < 0.3, "{error}");
    }

    /// What is left out is what a fit without that group says, where the law is the same.
    #[test]
    fn a_group_left_out_is_a_group_never_seen() {
        let all = observed(&mut Source::new(&KEY, 1000), 12);
        let whole = Emulator::of(all.clone(), 0.5).expect("it fits");
        let others: Vec<Observation> = all
            .iter()
            .filter(|observation| observation.group != 3)
            .cloned()
            .collect();
        let noise = DMatrix::from_fn(others.len(), others.len(), |row, column| {
            let (one, other) = (&others[row], &others[column]);
            let both = (one.variance * other.variance).sqrt() / (whole.unit * whole.unit);
            let share = f64::from(u8::from(one.group == other.group));
            both * if row == column { 1.0 } else { 0.5 * share }
        });
        let factor = whole
            .law
            .of_observed(&others, &noise)
            .cholesky()
            .expect("sound");
        let y = others
            .iter()
            .map(|observation| observation.mean - whole.centre);
        let y = DVector::from_iterator(others.len(), y) / whole.unit;
        let weights = factor.solve(&y);
        let part = Emulator {
            observed: others,
            factor,
            weights,
            ..whole.clone()
        };
        for (index, out) in whole.left_out().iter().enumerate() {
            if all[index].group == 3 {
                let alone = part.at(&all[index].at);
                let variance = alone.variance + all[index].variance;
                assert!((alone.mean - out.mean).abs() < 1.0e-6, "{alone:?} {out:?}");
                assert!((variance / out.variance - 1.0).abs() < 1.0e-6);
            }
        }
    }

    #[test]
    fn nothing_is_fitted_to_nothing() {
        let all = observed(&mut Source::new(&KEY, 1), 1);
        assert!(Emulator::of(all[..2].to_vec(), 0.5).is_none());
        let equal = |variance: f64| {
            let mut all = all.clone();
            for observation in &mut all {
                (observation.mean, observation.variance) = (1.0, variance);
            }
            Emulator::of(all, 0.5)
        };
        assert!(equal(0.0).is_none());
        let found = equal(0.01).expect("noise").at(&[0.5; 3]);
        assert!((found.mean - 1.0).abs() < 1.0e-9 && found.variance > 0.0);
    }
}
