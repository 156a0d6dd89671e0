//! Whether two samples come from one distribution, by exchanging packings.
//!
//! The numbers of a packing hang together (a grain's neighbours carry what it does not), so packings are exchanged
//! between the two sides, never single numbers: grains pooled and exchanged singly reject far too often.

use serde::{Deserialize, Serialize};

use super::random::{self, Key};

const KEY: Key = *b"crossgrain: packings exchanged. ";

/// Two samples compared.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TwoSamples {
    /// D, the largest difference of the shares below a value.
    pub kolmogorov: f64,
    /// A² of two samples (Scholz and Stephens 1987, Eq. 3), which weighs the tails more.
    pub anderson_darling: f64,
    /// The probability of so large a D if packings may be exchanged.
    pub kolmogorov_p: f64,
    /// The same for A².
    pub anderson_darling_p: f64,
}

/// Compares two sets of packings, each with its numbers. The p are of at most `permutations`
/// exchanges; they cannot be below 2/C(n + m, n), so four packings a side are the fewest for 5 %. None where a
/// side has no number.
pub fn compare(first: &[Vec<f64>], second: &[Vec<f64>], permutations: usize) -> Option<TwoSamples> {
    let mut pooled: Vec<(f64, usize)> = Vec::new();
    for (packing, values) in first.iter().chain(second).enumerate() {
        pooled.extend(values.iter().map(|value| (*value, packing)));
    }
    pooled.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut sides = vec![true; first.len()];
    sides.resize(first.len() + second.len(), false);
    let (kolmogorov, anderson_darling) = distances(&pooled, &sides)?;
    // An exchange that leaves a side without a number says nothing and counts as extreme. Sums of other
    // order may differ in the last bits.
    let extreme = |found: f64, exchanged: f64| exchanged >= found * (1.0 - 1.0e-12);
    let [kolmogorov_p, anderson_darling_p] = random::p_values(&KEY, permutations, |source| {
        let mut mixed = sides.clone();
        source.shuffle(&mut mixed);
        distances(&pooled, &mixed).map_or([true; 2], |one| {
            [extreme(kolmogorov, one.0), extreme(anderson_darling, one.1)]
        })
    });
    Some(TwoSamples {
        kolmogorov,
        anderson_darling,
        kolmogorov_p,
        anderson_darling_p,
    })
}

/// D and A² of sorted values; the first sample is the packings with `true`. None where a side is empty.
fn distances(pooled: &[(f64, usize)], sides: &[bool]) -> Option<(f64, f64)> {
    let total = pooled.len() as f64;
    let n = pooled.iter().filter(|(_, packing)| sides[*packing]).count() as f64;
    let m = total - n;
    if n == 0.0 || m == 0.0 {
        return None;
    }
    let (mut of_first, mut seen) = (0.0, 0.0);
    let (mut largest, mut sum) = (0.0f64, 0.0);
    let mut start = 0;
    while start < pooled.len() {
        // Equal values (grains that carry nothing) are passed in one step.
        let mut end = start;
        while end < pooled.len() && pooled[end].0 == pooled[start].0 {
            of_first += f64::from(u8::from(sides[pooled[end].1]));
            end += 1;
        }
        let ties = (end - start) as f64;
        seen += ties;
        largest = largest.max((of_first / n - (seen - of_first) / m).abs());
        if seen < total {
            sum += ties * (total * of_first - n * seen).powi(2) / (seen * (total - seen));
        }
        start = end;
    }
    Some((largest, sum / (n * m)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assert_share;
    use crate::distribution::tests::{AIR_CONDITIONING, BEARINGS};
    use crate::random::replicates;
    use assert_approx_eq::assert_approx_eq;

    fn singly(values: &[f64]) -> Vec<Vec<f64>> {
        values.iter().map(|value| vec![*value]).collect()
    }

    /// scipy 1.17.1: `ks_2samp` D 0.4898551, p 0.00219; A² 4.2261233 (`_anderson_ksamp_right`).
    #[test]
    fn known_samples() {
        let found = compare(&singly(&AIR_CONDITIONING), &singly(&BEARINGS), 9999);
        let found = found.expect("two samples");
        assert_approx_eq!(found.kolmogorov, 0.489_855_07, 1.0e-7);
        assert_approx_eq!(found.anderson_darling, 4.226_123_3, 1.0e-5);
        assert_approx_eq!(found.kolmogorov_p, 0.002_2, 0.0015);
        assert_approx_eq!(found.anderson_darling_p, 0.006, 0.004);
    }

    /// Three packings a side: no exchange is rarer than 2/C(6, 3) = 0.1.
    #[test]
    fn few_packings_cannot_differ() {
        let first: Vec<Vec<f64>> = (0..3).map(|k| vec![f64::from(k); 50]).collect();
        let second: Vec<Vec<f64>> = (0..3).map(|k| vec![f64::from(k) + 10.0; 50]).collect();
        let found = compare(&first, &second, 4999).expect("two samples");
        assert_eq!(found.kolmogorov, 1.0);
        assert!((found.kolmogorov_p - 0.1).abs() < 0.02, "{found:?}");
        assert!(compare(&first, &[], 9).is_none());
    }

    /// Packings with a common part (5 % of the variance lies between them): exchanging packings keeps the level,
    /// exchanging grains rejects in most of the cases (facts: 66 % with ten packings of 500 grains a side).
    #[test]
    fn level_of_exchanged_packings() {
        const KEY: Key = *b"crossgrain: tests of exchanges  ";
        let found = replicates(&KEY, 1000, |source| {
            let mut side = || -> Vec<Vec<f64>> {
                let packing = |_| {
                    let common = 0.23 * source.normal();
                    (0..60).map(|_| common + source.normal()).collect()
                };
                (0..8).map(packing).collect()
            };
            let (first, second) = (side(), side());
            let packings = compare(&first, &second, 99).expect("two samples");
            let grains = compare(&singly(&first.concat()), &singly(&second.concat()), 99);
            let grains = grains.expect("two samples");
            [
                packings.kolmogorov_p <= 0.05,
                packings.anderson_darling_p <= 0.05,
                grains.anderson_darling_p <= 0.05,
            ]
        });
        for which in [0, 1] {
            assert_share(found.iter().map(|one| one[which]), 0.99, 0.05);
        }
        let singly = found.iter().filter(|one| one[2]).count();
        assert!(singly > 250, "{singly}");
    }
}
