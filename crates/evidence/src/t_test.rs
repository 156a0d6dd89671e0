//! Means compared: paired differences, Welch's test of two samples, and equivalence by two one-sided t tests (Schuirmann
//! 1987). That no difference was found is no evidence that there is none, so for equivalence the difference must be shown to
//! be smaller than a margin that was set beforehand.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

use super::moments::{mean, mean_interval, standard_deviation};
use super::regression::correlation;
use super::{Interval, student, two_sided};

/// The differences of pairs, second minus first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Paired {
    pub pairs: usize,
    /// Mean of the first members.
    pub first_mean: f64,
    /// Standard deviation of the first members: what one member differs by from the next.
    pub first_deviation: f64,
    /// Mean difference with its 95 % t interval.
    pub difference: Interval,
    /// The same with 90 %, for equivalence at 5 %.
    pub difference_90: Interval,
    /// Pearson's correlation of the members of a pair; none where one does not vary.
    pub correlation: Option<f64>,
}

/// Compares pairs (first, second); none for fewer than two.
pub fn paired(pairs: &[(f64, f64)]) -> Option<Paired> {
    let (first, second): (Vec<f64>, Vec<f64>) = pairs.iter().copied().unzip();
    let differences: Vec<f64> = pairs.iter().map(|(a, b)| b - a).collect();
    Some(Paired {
        pairs: pairs.len(),
        first_mean: mean(&first),
        first_deviation: standard_deviation(&first),
        difference: mean_interval(&differences, 0.95)?,
        difference_90: mean_interval(&differences, 0.90)?,
        correlation: correlation(&first, &second),
    })
}

/// Second minus first.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Welch {
    /// Difference of the means with its 95 % interval.
    pub difference: Interval,
    /// The same with 90 %, for equivalence at 5 %.
    pub difference_90: Interval,
    /// Standard error of the difference.
    pub error: f64,
    /// Degrees of freedom (Welch and Satterthwaite), not a whole number.
    pub freedom: f64,
    /// Two-sided p of no difference.
    pub p: f64,
}

/// Welch's t interval (1947), which does not take the two deviations to be equal. None for fewer than two
/// packings on a side or where nothing varies.
pub fn welch(first: &[f64], second: &[f64]) -> Option<Welch> {
    let (error, freedom) = error_of_difference(
        [first.len(), second.len()],
        [first, second].map(standard_deviation),
    );
    let estimate = mean(second) - mean(first);
    let law = student(freedom)?;
    let interval = |level: f64| {
        let reach = two_sided(level, freedom)? * error;
        Some(Interval::about(estimate, reach))
    };
    Some(Welch {
        difference: interval(0.95)?,
        difference_90: interval(0.90)?,
        error,
        freedom,
        p: 2.0 * law.sf((estimate / error).abs()),
    })
}

impl Welch {
    /// Whether the means differ by less than a margin on both sides, with the larger p of the two one-sided tests.
    /// None for degrees of freedom that [`welch`] never returns.
    pub fn equivalence(&self, margin: f64) -> Option<(Finding, f64)> {
        let p = larger_p(self.difference.estimate, self.error, self.freedom, margin)?;
        Some((finding(&self.difference_90, margin), p))
    }

    /// One-sided p of means that differ by no more than the margin, against a difference beyond it on either side.
    pub fn p_beyond(&self, margin: f64) -> Option<f64> {
        let reach = self.difference.estimate.abs() - margin;
        Some(student(self.freedom)?.sf(reach / self.error))
    }
}

/// The probability that [`Welch::equivalence`] finds samples of these sizes and standard deviations equivalent if their means are
/// equal: E[2Φ((margin − t s)/σ) − 1] where it is above 0, σ the true standard error of the difference, and s, what is found for it, of
/// σ√(χ²_ν/ν) with the degrees of freedom ν of the true deviations. None for fewer than two values on a side or where nothing varies.
pub fn power(sizes: [usize; 2], deviations: [f64; 2], margin: f64) -> Option<f64> {
    let (error, freedom) = error_of_difference(sizes, deviations);
    let reach = two_sided(1.0 - 2.0 * LEVEL, freedom).filter(|_| error > 0.0)?;
    let squares = ChiSquared::new(freedom).ok()?;
    let shares = (0..STEPS).map(|step| (f64::from(step) + 0.5) / f64::from(STEPS));
    let within = shares.map(|share| {
        let found = (squares.inverse_cdf(share) / freedom).sqrt();
        let half = margin / error - reach * found;
        (2.0 * Normal::standard().cdf(half) - 1.0).max(0.0)
    });
    Some(within.sum::<f64>() / f64::from(STEPS))
}

/// Of the mean over the distribution of the standard error: good to 0.002 for two degrees of freedom and better for more.
const STEPS: u32 = 200;

/// Standard error of a difference of means, and its degrees of freedom (Welch and Satterthwaite).
fn error_of_difference(sizes: [usize; 2], deviations: [f64; 2]) -> (f64, f64) {
    let [n, m] = sizes.map(|size| size as f64);
    let (a, b) = (deviations[0].powi(2) / n, deviations[1].powi(2) / m);
    let freedom = (a + b).powi(2) / (a * a / (n - 1.0) + b * b / (m - 1.0));
    ((a + b).sqrt(), freedom)
}

/// Level of each of the two tests.
pub const LEVEL: f64 = 0.05;

/// What tests of equivalence say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Finding {
    /// The 90 % interval lies within the margins.
    Equivalent,
    /// The 90 % interval lies wholly beyond a margin.
    Different,
    /// Neither: too few packings for this margin.
    Undecided,
}

/// The finding for a 90 % interval of a difference and a margin on both sides of zero.
pub fn finding(difference: &Interval, margin: f64) -> Finding {
    if difference.low > -margin && difference.high < margin {
        Finding::Equivalent
    } else if difference.low >= margin || difference.high <= -margin {
        Finding::Different
    } else {
        Finding::Undecided
    }
}

/// What findings come to together: different if one is, equivalent if all are.
pub fn together(all: &[Finding]) -> Finding {
    let worst = [Finding::Different, Finding::Undecided];
    let found = worst.into_iter().find(|finding| all.contains(finding));
    found.unwrap_or(Finding::Equivalent)
}

/// The larger p of the one-sided tests of a difference with this standard error.
fn larger_p(difference: f64, error: f64, freedom: f64, margin: f64) -> Option<f64> {
    let student = student(freedom)?;
    let below = student.sf((difference + margin) / error);
    let above = student.cdf((difference - margin) / error);
    Some(below.max(above))
}

/// Finding and the larger p of the two one-sided tests of mean ≤ −margin and mean ≥ margin, below [`LEVEL`] exactly where the
/// 90 % interval lies within the margins; none for fewer than two differences.
pub fn equivalence(differences: &[f64], margin: f64) -> Option<(Finding, f64)> {
    let interval = mean_interval(differences, 1.0 - 2.0 * LEVEL)?;
    let count = differences.len() as f64;
    let error = standard_deviation(differences) / count.sqrt();
    let p = match error == 0.0 {
        true if interval.estimate.abs() < margin => 0.0,
        true => 1.0,
        false => larger_p(interval.estimate, error, count - 1.0, margin)?,
    };
    Some((finding(&interval, margin), p))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assert_share;
    use crate::distribution::tests::{AIR_CONDITIONING, BEARINGS};
    use crate::proportion::wilson;
    use crate::random::{Key, replicates};
    use assert_approx_eq::assert_approx_eq;

    #[test]
    fn pairs_of_a_common_size_differ_by_less_than_their_members() {
        let pairs: Vec<(f64, f64)> = (0..10)
            .map(|k| (f64::from(k), f64::from(k) + 1.0 + 0.1 * f64::from(k % 2)))
            .collect();
        let found = paired(&pairs).expect("ten pairs");
        assert!((found.difference.estimate - 1.05).abs() < 1.0e-12);
        assert!(found.difference.high - found.difference.low < 0.1);
        assert!(found.first_deviation > 3.0);
        assert!(found.correlation.expect("both vary") > 0.999);
    }

    /// scipy 1.17.1, `ttest_ind(equal_var=False)`: p 0.4128617 on 45.6518364 degrees, −18.1306872 to
    /// 43.3793829, 90 % −13.0226485 to 38.2713442; p of the larger one-sided test at margin 40 0.0398740; geometric
    /// means 2.2086098, 90 % 1.4040323 to 3.4742487.
    #[test]
    fn known_samples() {
        let found = welch(&AIR_CONDITIONING, &BEARINGS).expect("two samples");
        for (found, wanted) in [
            (found.p, 0.412_861_7),
            (found.freedom, 45.651_836_0),
            (found.difference.low, -18.130_687_2),
            (found.difference.high, 43.379_382_9),
            (found.difference_90.low, -13.022_648_5),
            (found.difference_90.high, 38.271_344_2),
        ] {
            assert_approx_eq!(found, wanted, 1.0e-6 * f64::abs(wanted));
        }
        let (said, p) = found.equivalence(40.0).expect("two samples");
        assert_eq!(said, Finding::Equivalent);
        assert!((p - 0.039_874_0).abs() < 1.0e-6);
        assert_eq!(found.equivalence(30.0).expect("two").0, Finding::Undecided);
        let logarithms = |values: &[f64]| values.iter().map(|value| value.ln()).collect::<Vec<_>>();
        let found = welch(&logarithms(&AIR_CONDITIONING), &logarithms(&BEARINGS));
        let found = found.expect("positive values");
        assert_approx_eq!(found.difference_90.estimate.exp(), 2.208_609_8);
        assert_approx_eq!(found.difference_90.low.exp(), 1.404_032_3);
        assert_approx_eq!(found.difference_90.high.exp(), 3.474_248_7);
        let (said, _) = found.equivalence(1.1f64.ln()).expect("two samples");
        assert_eq!(said, Finding::Different);
        assert!(welch(&[1.0], &BEARINGS).is_none());
    }

    /// Equal means are called different, and means exactly a margin apart equivalent, one time in twenty;
    /// the deviations differ by a factor of three and the sizes too.
    #[test]
    fn levels() {
        const KEY: Key = *b"crossgrain: tests of two samples";
        let found = replicates(&KEY, 8000, |source| {
            let first: Vec<f64> = (0..12).map(|_| source.normal()).collect();
            let second: Vec<f64> = (0..25).map(|_| 3.0 * source.normal()).collect();
            let equal = welch(&first, &second).expect("two samples").p <= 0.05;
            let moved: Vec<f64> = second.iter().map(|value| value + 4.0).collect();
            let apart = welch(&first, &moved).expect("two samples");
            let said = apart.equivalence(4.0).expect("two samples").0;
            (equal, said == Finding::Equivalent)
        });
        assert_share(found.iter().map(|one| one.0), 0.99, 0.05);
        assert_share(found.iter().map(|one| one.1), 0.99, 0.05);
    }

    /// The power that is told beforehand is the share of trials with equal means that are found equivalent.
    #[test]
    fn power_is_how_often_equal_means_are_found_so() {
        const KEY: Key = *b"crossgrain: tests of the power. ";
        let trials = 8000;
        for (sizes, deviations, margin) in [
            ([9, 200], [1.0, 1.0], 1.0),
            ([12, 25], [1.0, 3.0], 1.5),
            ([4, 6], [1.0, 1.0], 2.5),
            ([60, 60], [2.0, 1.0], 0.6),
            ([300, 20], [1.0, 1.0], 0.2),
        ] {
            let found = replicates(&KEY, trials, |source| {
                let mut side = |which: usize| -> Vec<f64> {
                    let draw = |_| deviations[which] * source.normal();
                    (0..sizes[which]).map(draw).collect()
                };
                let (first, second) = (side(0), side(1));
                let welch = welch(&first, &second).expect("two samples");
                welch.equivalence(margin).expect("two samples").0 == Finding::Equivalent
            });
            let hits = found.iter().filter(|one| **one).count();
            let share = wilson(hits, trials, 0.999).expect("trials");
            let told = power(sizes, deviations, margin).expect("both vary");
            // Degrees of freedom that are themselves estimated cost up to 0.01.
            let reach = 0.01;
            assert!(
                share.low - reach < told && told < share.high + reach,
                "{sizes:?} {share:?} {told}"
            );
        }
        assert!(power([1, 9], [1.0, 1.0], 1.0).is_none());
        assert!(power([9, 9], [0.0, 0.0], 1.0).is_none());
    }

    /// n = 10, mean 1.58, s = 1.229995: with margin 2.5, t = (2.5 − 1.58)/0.388958 = 2.3653 on 9 degrees
    /// of freedom, p = 0.0211.
    #[test]
    fn p_of_students_sleep_data() {
        let gained = [1.2, 2.4, 1.3, 1.3, 0.0, 1.0, 1.8, 0.8, 4.6, 1.4];
        for (margin, wanted, low, high) in [
            (2.5, Finding::Equivalent, 0.0209, 0.0213),
            (2.0, Finding::Undecided, LEVEL, 1.0),
            (0.5, Finding::Different, 0.9, 1.0),
        ] {
            let (finding, p) = equivalence(&gained, margin).expect("ten values");
            assert_eq!(finding, wanted);
            assert!(p > low && p < high, "{margin}: {p}");
        }
    }

    /// Interval and p must never contradict each other.
    #[test]
    fn interval_and_p_agree() {
        for shift in 0..200 {
            let differences: Vec<f64> = [0.3, -0.2, 0.5, -0.4, 0.1, -0.3]
                .iter()
                .map(|noise| noise + 0.01 * f64::from(shift))
                .collect();
            let (finding, p) = equivalence(&differences, 1.0).expect("six values");
            assert_eq!(finding == Finding::Equivalent, p < LEVEL, "{shift}");
        }
    }

    /// A difference as large as the margin is called equivalent once in twenty times, not more.
    #[test]
    fn the_level_is_kept_at_the_margin() {
        const KEY: Key = *b"crossgrain: tests at the margin.";
        let found = replicates(&KEY, 10_000, |source| {
            let sample: Vec<f64> = (0..12).map(|_| 5.0 + source.normal()).collect();
            equivalence(&sample, 5.0).expect("twelve values").0 == Finding::Equivalent
        });
        assert_share(found, 0.99, 0.05);
    }
}
