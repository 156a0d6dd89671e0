//! Two samples of different packings: difference and ratio of their means, and whether they are equivalent.

use serde::{Deserialize, Serialize};
use statrs::distribution::ContinuousCDF;

use super::equivalence::{Finding, LEVEL, finding};
use super::moments::{deviation, mean};
use super::{Interval, student, two_sided};

/// Second minus first.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unpaired {
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
pub fn welch(first: &[f64], second: &[f64]) -> Option<Unpaired> {
    let part = |values: &[f64]| deviation(values).powi(2) / values.len() as f64;
    let (a, b) = (part(first), part(second));
    let freedom = (a + b).powi(2)
        / (a * a / (first.len() as f64 - 1.0) + b * b / (second.len() as f64 - 1.0));
    let error = (a + b).sqrt();
    let estimate = mean(second) - mean(first);
    let law = student(freedom)?;
    let interval = |level: f64| {
        let reach = two_sided(level, freedom)? * error;
        Some(Interval {
            estimate,
            low: estimate - reach,
            high: estimate + reach,
        })
    };
    Some(Unpaired {
        difference: interval(0.95)?,
        difference_90: interval(0.90)?,
        error,
        freedom,
        p: 2.0 * law.sf((estimate / error).abs()),
    })
}

/// Whether the means differ by less than a margin on both sides, with the larger p of the two one-sided tests;
/// the margin must have been set before the samples were seen.
pub fn equivalence(compared: &Unpaired, margin: f64) -> Option<(Finding, f64)> {
    let law = student(compared.freedom)?;
    let centre = compared.difference.estimate;
    let below = law.sf((centre + margin) / compared.error);
    let above = law.cdf((centre - margin) / compared.error);
    let p = below.max(above);
    debug_assert_eq!(
        finding(&compared.difference_90, margin) == Finding::Equivalent,
        p < LEVEL
    );
    Some((finding(&compared.difference_90, margin), p))
}

/// p of means that differ by no more than the margin, against a difference beyond it on either side.
pub fn beyond(compared: &Unpaired, margin: f64) -> Option<f64> {
    let law = student(compared.freedom)?;
    Some(law.sf((compared.difference.estimate.abs() - margin) / compared.error))
}

/// Ratio of the typical (geometric mean) second to the typical first, of positive values, through their
/// logarithms: the equivalence of a ratio within 1/(1 + m) to 1 + m is that of the difference of logarithms with
/// margin ln(1 + m). None where a value is not positive.
pub fn ratio(first: &[f64], second: &[f64]) -> Option<Unpaired> {
    let logarithms = |values: &[f64]| -> Option<Vec<f64>> {
        let one = |value: &f64| (*value > 0.0).then(|| value.ln());
        values.iter().map(one).collect()
    };
    welch(&logarithms(first)?, &logarithms(second)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::tests::{AIR_CONDITIONING, BEARINGS};
    use crate::proportion::wilson;
    use crate::random::{Key, replicates};

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
            assert!(
                (found - wanted).abs() < 1.0e-6 * wanted.abs(),
                "{found} {wanted}"
            );
        }
        let (said, p) = equivalence(&found, 40.0).expect("two samples");
        assert_eq!(said, Finding::Equivalent);
        assert!((p - 0.039_874_0).abs() < 1.0e-6);
        assert_eq!(
            equivalence(&found, 30.0).expect("two").0,
            Finding::Undecided
        );
        let found = ratio(&AIR_CONDITIONING, &BEARINGS).expect("positive values");
        let close = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1.0e-6);
        close(found.difference_90.estimate.exp(), 2.208_609_8);
        close(found.difference_90.low.exp(), 1.404_032_3);
        close(found.difference_90.high.exp(), 3.474_248_7);
        assert_eq!(
            equivalence(&found, 1.1f64.ln()).expect("two").0,
            Finding::Different
        );
        assert!(ratio(&[1.0, 0.0], &BEARINGS).is_none());
        assert!(welch(&[1.0], &BEARINGS).is_none());
    }

    /// Equal means are called different, and means exactly a margin apart equivalent, one time in twenty;
    /// the deviations differ by a factor of three and the sizes too.
    #[test]
    fn levels() {
        const KEY: Key = *b"crossgrain: tests of two samples";
        let trials = 8000;
        let found = replicates(&KEY, trials, |source| {
            let first: Vec<f64> = (0..12).map(|_| source.normal()).collect();
            let second: Vec<f64> = (0..25).map(|_| 3.0 * source.normal()).collect();
            let equal = welch(&first, &second).expect("two samples").p <= 0.05;
            let moved: Vec<f64> = second.iter().map(|value| value + 4.0).collect();
            let apart = welch(&first, &moved).expect("two samples");
            let said = equivalence(&apart, 4.0).expect("two samples").0;
            (equal, said == Finding::Equivalent)
        });
        for hits in [
            found.iter().filter(|one| one.0).count(),
            found.iter().filter(|one| one.1).count(),
        ] {
            let share = wilson(hits, trials, 0.99).expect("trials");
            assert!(share.low < 0.05 && share.high > 0.05, "{share:?}");
        }
    }
}
