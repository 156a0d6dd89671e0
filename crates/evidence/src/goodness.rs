//! How far values lie from a distribution: Kolmogorov's distance D and the weighted square distance A² of Anderson and
//! Darling, with the probability of such distances if it were true.
//!
//! Where parameters were fitted to the same values the distances are smaller than the classical tables say, so
//! the probability is found by drawing samples from the fitted distribution and fitting each of them anew (Lilliefors 1969
//! for the exponential; a parametric bootstrap where the distribution of the distance depends on the shape).

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::distribution::{Distribution, Family};
use super::random::{self, Key, Source};

const KNOWN: Key = *b"crossgrain: fits with known laws";
const FITTED: Key = *b"crossgrain: fits of fitted laws ";

/// Distances of values from a law.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Distances {
    /// D, the largest difference of the shares below a value.
    pub kolmogorov: f64,
    /// A² = −n − Σ(2i − 1)(ln uᵢ + ln(1 − uₙ₊₁₋ᵢ))/n, which weighs the tails more.
    pub anderson_darling: f64,
}

/// Distances with their probabilities.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fit {
    pub law: Distribution,
    pub distances: Distances,
    /// The probability of so large a D.
    pub kolmogorov_p: f64,
    /// The probability of so large an A², from drawn samples.
    pub anderson_darling_p: f64,
    /// The most samples that are drawn: no p is below 1/(samples + 1).
    pub samples: usize,
}

/// The distances of values, which need not be sorted; none without values. A value that the law does not
/// allow (a zero of an exponential) counts with the smallest positive probability, so that A² stays finite.
pub fn distances(law: &Distribution, values: &[f64]) -> Option<Distances> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    of_sorted(sorted.iter().map(|value| {
        let below = law.cumulative(*value);
        match below < 0.9 {
            true => (below, 1.0 - below),
            false => (below, law.survival(*value)),
        }
    }))
}

/// From the shares below and above each value, in order.
fn of_sorted(shares: impl Iterator<Item = (f64, f64)>) -> Option<Distances> {
    let shares: Vec<(f64, f64)> = shares.collect();
    let n = shares.len() as f64;
    let (mut largest, mut sum) = (0.0f64, 0.0);
    for (index, (below, _)) in shares.iter().enumerate() {
        let rank = index as f64;
        largest = largest.max(below - rank / n).max((rank + 1.0) / n - below);
        let above = shares[shares.len() - 1 - index].1;
        sum += (2.0 * rank + 1.0) * (logarithm(*below) + logarithm(above));
    }
    (!shares.is_empty()).then(|| Distances {
        kolmogorov: largest,
        anderson_darling: -n - sum / n,
    })
}

fn logarithm(share: f64) -> f64 {
    share.max(f64::MIN_POSITIVE).ln()
}

/// Values against a law that was known before: p of D exactly, p of A² from at most so many samples. None without values.
pub fn known(law: &Distribution, values: &[f64], samples: usize) -> Option<Fit> {
    known_under(&KNOWN, law, values, samples)
}

fn known_under(key: &Key, law: &Distribution, values: &[f64], samples: usize) -> Option<Fit> {
    let fit = Fit::new(key, *law, values, samples, |source| {
        let mut uniform: Vec<f64> = values.iter().map(|_| source.uniform()).collect();
        uniform.sort_by(f64::total_cmp);
        of_sorted(uniform.into_iter().map(|below| (below, 1.0 - below)))
    })?;
    Some(Fit {
        kolmogorov_p: kolmogorov_p_value(fit.distances.kolmogorov, values.len()),
        ..fit
    })
}

/// Values against the likeliest law of a family, if there is one: both p from at most so many samples of it, each fitted anew.
pub fn fitted(family: Family, values: &[f64], samples: usize) -> Option<Fit> {
    fitted_under(&FITTED, family, values, samples)
}

fn fitted_under(key: &Key, family: Family, values: &[f64], samples: usize) -> Option<Fit> {
    let law = family.fit(values)?;
    Fit::new(key, law, values, samples, |source| {
        let drawn: Vec<f64> = values.iter().map(|_| law.draw(source)).collect();
        distances(&family.fit(&drawn)?, &drawn)
    })
}

impl Fit {
    /// With both p among the distances of drawn samples, of which one that could not be fitted counts as extreme.
    fn new(
        key: &Key,
        law: Distribution,
        values: &[f64],
        samples: usize,
        draw: impl Fn(&mut Source) -> Option<Distances> + Sync,
    ) -> Option<Self> {
        let distances = distances(&law, values)?;
        let both = |distances: Distances| [distances.kolmogorov, distances.anderson_darling];
        let [found, other] = both(distances);
        let [kolmogorov_p, anderson_darling_p] = random::p_values(key, samples, |source| {
            let drawn = draw(source).map(both);
            drawn.map_or([true; 2], |drawn| [drawn[0] >= found, drawn[1] >= other])
        });
        Some(Fit {
            law,
            distances,
            kolmogorov_p,
            anderson_darling_p,
            samples,
        })
    }
}

/// Numbers are kept below this by taking out powers of ten.
const LARGE: f64 = 1.0e140;
const EXPONENT: i32 = 140;

/// The probability of a distance of at least `distance` for `count` values: exact, by the matrix power of
/// Marsaglia, Tsang and Wang (2003), to about 13 digits of 1 − p; in the far tail, nD² > 7.24 or > 3.76 for
/// n > 99, by their formula 2 exp(−(2.000071 + 0.331/√n + 1.409/n) nD²), good to seven decimals.
///
/// Not for parameters that were fitted to the values: see [`fitted`].
pub fn kolmogorov_p_value(distance: f64, count: usize) -> f64 {
    let n = count as f64;
    let square = n * distance * distance;
    if distance.is_nan() || count == 0 {
        return f64::NAN;
    }
    if distance <= 0.5 / n {
        return 1.0;
    }
    if distance >= 1.0 {
        return 0.0;
    }
    if square > 7.24 || (square > 3.76 && count > 99) {
        let slope = 2.000_071 + 0.331 / n.sqrt() + 1.409 / n;
        return (2.0 * (-slope * square).exp()).min(1.0);
    }
    (1.0 - below(distance, count)).clamp(0.0, 1.0)
}

/// P(D < distance): the middle element of Hⁿ times n!/nⁿ.
fn below(distance: f64, count: usize) -> f64 {
    let n = count as f64;
    let half = (n * distance) as usize + 1;
    let size = 2 * half - 1;
    let rest = half as f64 - n * distance;
    let mut matrix = DMatrix::from_fn(size, size, |row, column| {
        f64::from(u8::from(row + 1 >= column))
    });
    for row in 0..size {
        matrix[(row, 0)] -= rest.powi(row as i32 + 1);
        matrix[(size - 1, row)] -= rest.powi((size - row) as i32);
    }
    matrix[(size - 1, 0)] += (2.0 * rest - 1.0).max(0.0).powi(size as i32);
    for row in 0..size {
        for column in 0..=row {
            for divisor in 1..=(row - column + 1) {
                matrix[(row, column)] /= divisor as f64;
            }
        }
    }

    let mut vector = DVector::zeros(size);
    vector[half - 1] = 1.0;
    let (mut of_vector, mut of_matrix) = (0, 0);
    let mut power = count;
    while power > 0 {
        if power % 2 == 1 {
            vector = &matrix * vector;
            of_vector += of_matrix;
            if vector[half - 1].abs() > LARGE {
                vector /= LARGE;
                of_vector += EXPONENT;
            }
        }
        power /= 2;
        matrix = &matrix * &matrix;
        of_matrix *= 2;
        if matrix[(half - 1, half - 1)].abs() > LARGE {
            matrix /= LARGE;
            of_matrix += EXPONENT;
        }
    }
    let mut result = vector[half - 1];
    for factor in 1..=count {
        result *= factor as f64 / n;
        if result < 1.0 / LARGE {
            result *= LARGE;
            of_vector -= EXPONENT;
        }
    }
    result * 10f64.powi(of_vector)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assert_share;
    use crate::distribution::tests::{self as laws, AIR_CONDITIONING};
    use assert_approx_eq::assert_approx_eq;

    const KEY: Key = *b"crossgrain: tests of distances  ";

    /// Distances from numpy; p from `scipy.stats.goodness_of_fit` 1.17.1 with 20,000 (exponential) and 4,000
    /// (gamma) samples: 0.0217 and 0.0750, 0.0427 and 0.1082. Ours have 4,000.
    #[test]
    fn a_known_sample() {
        use Family::{Exponential, Gamma};
        for (family, wanted) in [
            (Exponential, [0.213_167_7, 1.163_122_3, 0.0217, 0.075]),
            (Gamma, [0.169_375_2, 0.653_380_4, 0.0427, 0.1082]),
        ] {
            let fit = fitted(family, &AIR_CONDITIONING, 3999).expect("a fit");
            assert!((fit.distances.kolmogorov - wanted[0]).abs() < 1.0e-6);
            assert!((fit.distances.anderson_darling - wanted[1]).abs() < 1.0e-5);
            // Four standard errors of two such simulations.
            assert_approx_eq!(fit.kolmogorov_p, wanted[2], 0.015);
            assert_approx_eq!(fit.anderson_darling_p, wanted[3], 0.025);
        }
    }

    /// The value that a share 0.95 of the distances of fitted exponential samples lies below.
    fn critical(count: usize, samples: usize, statistic: fn(&Distances) -> f64) -> f64 {
        let mut drawn = random::replicates(&KEY, samples, |source| {
            let values: Vec<f64> = (0..count).map(|_| source.exponential()).collect();
            let law = Family::Exponential.fit(&values).expect("positive values");
            statistic(&distances(&law, &values).expect("values"))
        });
        drawn.sort_by(f64::total_cmp);
        drawn[samples * 95 / 100]
    }

    /// Lilliefors' 5 % points as tabulated from ten million samples in statsmodels 0.15
    /// (`_lilliefors_critical_values`), Stephens' form of them, and the 5 % point 1.321 of A²(1 + 0.6/n) in
    /// D'Agostino and Stephens (1986), table 4.14.
    #[test]
    fn critical_values_of_the_fitted_exponential() {
        for (count, samples, table) in [
            (10, 40_000, 0.324_38),
            (20, 40_000, 0.234_47),
            (100, 20_000, 0.107_52),
            (800, 8_000, 0.038_45),
        ] {
            let found = critical(count, samples, |one| one.kolmogorov);
            assert!((found / table - 1.0).abs() < 0.02, "{count} {found}");
            let n = count as f64;
            let stephens = 1.094 / (n.sqrt() + 0.26 + 0.5 / n.sqrt()) + 0.2 / n;
            assert!((found / stephens - 1.0).abs() < 0.02, "{count} {found}");
            // The table for a known mean would be a quarter too lax.
            assert!(1.3581 / n.sqrt() > 1.2 * found);
            let squares = critical(count, samples, |one| one.anderson_darling);
            let squares = squares * (1.0 + 0.6 / n);
            assert!((squares / 1.321 - 1.0).abs() < 0.06, "{count} {squares}");
        }
    }

    /// Each of the tests rejects a true law one time in twenty: p ≤ 0.05 in a share of trials whose 99 % Wilson
    /// interval holds 0.05. Each trial draws its samples under a key of its own.
    #[test]
    fn levels() {
        for truth in [
            Distribution::Exponential { mean: 2.0 },
            laws::gamma(2.2, 0.5),
            laws::laplace(0.3, 2.0),
        ] {
            let found = random::replicates(&KEY, 2000, |source| {
                let values: Vec<f64> = (0..40).map(|_| truth.draw(source)).collect();
                let key = std::array::from_fn(|_| source.below(256) as u8);
                let found = fitted_under(&key, truth.family(), &values, 99).expect("a fit");
                let before = known_under(&key, &truth, &values, 99).expect("values");
                [
                    found.kolmogorov_p,
                    found.anderson_darling_p,
                    before.kolmogorov_p,
                    before.anderson_darling_p,
                ]
            });
            for which in 0..4 {
                assert_share(found.iter().map(|values| values[which] <= 0.05), 0.99, 0.05);
            }
        }
    }

    /// 150 values of a gamma law of shape 1.5 are told from an exponential nearly always, from their own family hardly ever.
    #[test]
    fn another_law_is_noticed() {
        let mut source = Source::new(&KEY, 10);
        let (mut exponential, mut gamma) = (0, 0);
        for _ in 0..60 {
            let values: Vec<f64> = (0..150).map(|_| source.gamma(1.5)).collect();
            let fit = |family| fitted(family, &values, 199).expect("a fit");
            let p = |family| fit(family).anderson_darling_p;
            exponential += usize::from(p(Family::Exponential) <= 0.05);
            gamma += usize::from(p(Family::Gamma) <= 0.05);
        }
        assert!(exponential >= 45, "{exponential}");
        assert!(gamma <= 9, "{gamma}");
    }

    #[test]
    fn a_value_that_cannot_be() {
        let law = Distribution::Exponential { mean: 1.0 };
        let found = distances(&law, &[0.0, 1.0, 2.0]).expect("values");
        assert!(found.anderson_darling.is_finite() && found.anderson_darling > 100.0);
        assert!(distances(&law, &[]).is_none());
    }

    /// D = 0.274 of ten values is the example of Marsaglia, Tsang and Wang, P(D < d) = 0.628480; the others
    /// are `scipy.stats.kstwo.sf` 1.17.1, which approximates for more than 140 values.
    #[test]
    fn known_values_of_kolmogorov() {
        for (distance, count, wanted, tolerance) in [
            (0.274, 10, 0.371_520_384_543_495_7, 1.0e-12),
            (0.1, 100, 0.252_692_757_006_387_4, 1.0e-12),
            (0.04, 1000, 0.079_339_560_590_002_2, 1.0e-7),
            (0.03, 1000, 0.322_690_214_391_463_6, 1.0e-7),
            (0.05, 50, 0.999_023_809_846_183_8, 1.0e-12),
            (0.2, 170, 1.951e-6, 1.0e-7),
            (0.1, 1000, 3.704e-9, 1.0e-9),
        ] {
            assert_approx_eq!(kolmogorov_p_value(distance, count), wanted, tolerance);
        }
        // The 5 % point of many values is 1.358/√n.
        assert!((kolmogorov_p_value(1.3581 / 5000.0f64.sqrt(), 5000) - 0.05).abs() < 0.001);
    }

    #[test]
    fn ends_of_kolmogorov() {
        assert_eq!(kolmogorov_p_value(0.0, 10), 1.0);
        assert_eq!(kolmogorov_p_value(0.05, 10), 1.0);
        assert_eq!(kolmogorov_p_value(1.0, 10), 0.0);
        assert!(kolmogorov_p_value(f64::NAN, 10).is_nan());
        assert!(kolmogorov_p_value(0.1, 0).is_nan());
    }
}
