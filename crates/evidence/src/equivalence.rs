//! Equivalence by two one-sided t tests (Schuirmann 1987): that no difference was found is no evidence that
//! there is none, so the difference must be shown to be smaller than a margin that was set beforehand.

use serde::{Deserialize, Serialize};

use super::moments::{deviation, mean, mean_interval};
use super::{Interval, student};

/// Level of each of the two tests.
pub const LEVEL: f64 = 0.05;

/// What the tests say.
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

/// The larger p of the two one-sided tests of mean ≤ −margin and mean ≥ margin; none for fewer than two
/// differences. Below [`LEVEL`] exactly where the 90 % interval lies within the margins.
pub fn p_value(differences: &[f64], margin: f64) -> Option<f64> {
    use statrs::distribution::ContinuousCDF;
    let count = differences.len() as f64;
    let law = student(count - 1.0)?;
    let error = deviation(differences) / count.sqrt();
    let centre = mean(differences);
    if error == 0.0 {
        return Some(if centre.abs() < margin { 0.0 } else { 1.0 });
    }
    let below = law.sf((centre + margin) / error);
    let above = law.cdf((centre - margin) / error);
    Some(below.max(above))
}

/// Finding and p of differences; none for fewer than two.
pub fn test(differences: &[f64], margin: f64) -> Option<(Finding, f64)> {
    let interval = mean_interval(differences, 1.0 - 2.0 * LEVEL)?;
    Some((finding(&interval, margin), p_value(differences, margin)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// n = 10, mean 1.58, s = 1.229995: with margin 2.5, t = (2.5 − 1.58)/0.388958 = 2.3653 on 9 degrees
    /// of freedom, p = 0.0211.
    #[test]
    fn p_of_students_sleep_data() {
        let gained = [1.2, 2.4, 1.3, 1.3, 0.0, 1.0, 1.8, 0.8, 4.6, 1.4];
        let (finding, p) = test(&gained, 2.5).expect("ten values");
        assert_eq!(finding, Finding::Equivalent);
        assert!((p - 0.0211).abs() < 2.0e-4, "{p}");
        let (finding, p) = test(&gained, 2.0).expect("ten values");
        assert_eq!(finding, Finding::Undecided);
        assert!(p > LEVEL);
        let (finding, p) = test(&gained, 0.5).expect("ten values");
        assert_eq!(finding, Finding::Different);
        assert!(p > 0.9);
    }

    /// Interval and p must never contradict each other.
    #[test]
    fn interval_and_p_agree() {
        for shift in 0..200 {
            let differences: Vec<f64> = [0.3, -0.2, 0.5, -0.4, 0.1, -0.3]
                .iter()
                .map(|noise| noise + 0.01 * f64::from(shift))
                .collect();
            let (finding, p) = test(&differences, 1.0).expect("six values");
            assert_eq!(finding == Finding::Equivalent, p < LEVEL, "{shift}");
        }
    }

    /// A difference as large as the margin is called equivalent once in twenty times, not more: 10⁴
    /// samples of 12 from a fixed generator.
    #[test]
    fn the_level_is_kept_at_the_margin() {
        let mut state = 1u64;
        let mut uniform = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut wrong = 0;
        for _ in 0..10_000 {
            // Sums of twelve uniforms: close to normal with deviation 1.
            let sample: Vec<f64> = (0..12)
                .map(|_| 5.0 + (0..12).map(|_| uniform()).sum::<f64>() - 6.0)
                .collect();
            let (finding, _) = test(&sample, 5.0).expect("twelve values");
            wrong += usize::from(finding == Finding::Equivalent);
        }
        assert!((400..=600).contains(&wrong), "{wrong}");
    }
}
