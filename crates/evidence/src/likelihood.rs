//! Distributions compared by their likelihoods: nested ones by the ratio, others by Akaike's criterion and Vuong's test.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};
use statrs::function::gamma::ln_gamma;

use super::distribution::{Distribution, Family};
use super::moments::{mean, standard_deviation};
use super::random::{Key, Source};
use super::{Interval, halved, in_parallel};

/// A distribution with a shape against the exponential, which it is at shape 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AgainstExponential {
    /// Shape with its 95 % deviance interval: every shape with 2(l̂ − l(shape)) below the 95 % of χ²₁, the
    /// scale being the likeliest for that shape.
    pub shape: Interval,
    /// 2(l̂ − l_exponential), never below zero.
    pub ratio: f64,
    /// The probability of such a ratio or a larger one, χ² with one degree of freedom (Wilks 1938).
    pub p: f64,
}

/// Gamma or Weibull against the exponential; none for other families and where there is no fit.
pub fn against_exponential(family: Family, values: &[f64]) -> Option<AgainstExponential> {
    let (Distribution::Gamma { shape: best, .. } | Distribution::Weibull { shape: best, .. }) =
        family.fit(values)?
    else {
        return None;
    };
    let profile = profile(family, values);
    let top = profile(best);
    let law = ChiSquared::new(1.0).ok()?;
    let limit = law.inverse_cdf(0.95);
    let inside = |shape: f64| 2.0 * (top - profile(shape)) < limit;
    let ratio = (2.0 * (top - profile(1.0))).max(0.0);
    Some(AgainstExponential {
        shape: Interval {
            estimate: best,
            low: end(best, 0.5, inside),
            high: end(best, 2.0, inside),
        },
        ratio,
        p: law.sf(ratio),
    })
}

/// Where going from `best` by factors leaves the inside, to a relative 10⁻⁹.
fn end(best: f64, factor: f64, inside: impl Fn(f64) -> bool) -> f64 {
    let (mut near, mut far) = (best, best * factor);
    while inside(far) && far > 1.0e-9 && far < 1.0e9 {
        (near, far) = (far, far * factor);
    }
    halved([near, far], 60, inside)
}

/// The log-likelihood as a function of the shape alone, the scale being the likeliest for it.
fn profile(family: Family, values: &[f64]) -> impl Fn(f64) -> f64 {
    let logarithms: Vec<f64> = values.iter().map(|value| value.ln()).collect();
    let (count, mean, mean_logarithm) = (values.len() as f64, mean(values), mean(&logarithms));
    move |shape| {
        if family == Family::Weibull {
            let powers = values.iter().map(|value| (value / mean).powf(shape));
            let scale = mean * (powers.sum::<f64>() / count).powf(1.0 / shape);
            let ratio = mean_logarithm - scale.ln();
            return count * (shape.ln() - scale.ln() + (shape - 1.0) * ratio - 1.0);
        }
        let scale = mean / shape;
        let constant = ln_gamma(shape) + shape * scale.ln();
        count * ((shape - 1.0) * mean_logarithm - shape - constant)
    }
}

/// Two laws of the same number of values, neither part of the other.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NotNested {
    /// Akaike's criterion, first minus second, 2(k₁ − k₂) − 2(l₁ − l₂): negative where the first describes the values better.
    pub akaike_difference: f64,
    /// Vuong's z (1989), √n times mean over standard deviation of ln f₁ − ln f₂: positive where the first is
    /// closer to the truth. Not corrected for the number of parameters.
    pub z: f64,
    /// Two-sided normal p of z: both laws being equally far from the truth.
    pub p: f64,
}

/// Compares the likeliest laws of two families; none where one cannot be fitted or they do not differ.
pub fn not_nested(first: Family, second: Family, values: &[f64]) -> Option<NotNested> {
    let (one, two) = (first.fit(values)?, second.fit(values)?);
    between(one, two, values.chunks(1))
}

/// The same of two laws with their parameters; groups are independent, not the values of one: grains of a packing.
pub fn between<'a>(
    one: Distribution,
    two: Distribution,
    groups: impl Iterator<Item = &'a [f64]>,
) -> Option<NotNested> {
    let differences: Vec<f64> = groups
        .map(|group| one.log_likelihood(group) - two.log_likelihood(group))
        .collect();
    let count = differences.len() as f64;
    let parameters = [one, two].map(|law| law.family().parameters() as f64);
    // Vuong divides by n, not n − 1.
    let spread = standard_deviation(&differences) * ((count - 1.0) / count).sqrt();
    let z = (spread > 0.0).then(|| count.sqrt() * mean(&differences) / spread)?;
    Some(NotNested {
        akaike_difference: 2.0 * (parameters[0] - parameters[1])
            - 2.0 * differences.iter().sum::<f64>(),
        z,
        p: 2.0 * Normal::standard().sf(z.abs()),
    })
}

const SEEN: Key = *b"crossgrain: power of Vuong, 5 %.";
/// Samples drawn for a power, which is then known to ± 0.05.
const DRAWN: usize = 200;
/// So many are drawn before it is looked whether that is decided.
const BLOCK: usize = 10;
/// More values than this are not tried.
const MOST: usize = 2048;

/// Whether Vuong's test of 5 % says of a sample of so many values of a law that it is nearer than the other family, both fitted anew.
fn shows(law: &Distribution, other: Family, count: usize, source: &mut Source) -> bool {
    let values: Vec<f64> = (0..count).map(|_| law.draw(source)).collect();
    let found = not_nested(law.family(), other, &values);
    found.is_some_and(|found| found.z > 0.0 && found.p < 0.05)
}

/// Whether nine in ten of the samples that are drawn show it; drawing ends as soon as that is decided.
fn is_seen(law: &Distribution, other: Family, count: usize) -> bool {
    let mut unseen = 0;
    for start in (0..DRAWN).step_by(BLOCK) {
        let shown = in_parallel(BLOCK, |at| {
            let source = &mut Source::new(&SEEN, (start + at) as u64);
            shows(law, other, count, source)
        });
        unseen += shown.into_iter().filter(|shown| !shown).count();
        if 10 * unseen > DRAWN {
            return false;
        }
    }
    true
}

/// So many independent values of the law show in nine samples of ten that it is nearer than the other family, to a sixteenth; none
/// where 2,048 do not.
pub fn seen_from(law: &Distribution, other: Family) -> Option<usize> {
    let is_seen = |count: &usize| is_seen(law, other, *count);
    let mut doubled = std::iter::successors(Some(16), |count| Some(2 * count));
    let enough = doubled
        .by_ref()
        .take_while(|count| *count <= MOST)
        .find(is_seen)?;
    let [mut low, mut high] = [enough / 2, enough];
    while high - low > high / 16 + 1 {
        let middle = low.midpoint(high);
        let end = if is_seen(&middle) {
            &mut high
        } else {
            &mut low
        };
        *end = middle;
    }
    Some(high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assert_share;
    use crate::distribution::tests::{AIR_CONDITIONING, BEARINGS, close, laplace};
    use crate::random::replicates;

    /// scipy 1.17.1: deviance interval by `brentq` on `gamma.logpdf`, ratios and `chi2.sf`, Vuong by hand.
    #[test]
    fn known_samples() {
        let gamma = against_exponential(Family::Gamma, &AIR_CONDITIONING).expect("a fit");
        close(gamma.shape.low, 0.510_547_4);
        close(gamma.shape.high, 1.226_009_1);
        close(gamma.ratio, 0.924_672_97);
        close(gamma.p, 0.336_250_99);
        let weibull = against_exponential(Family::Weibull, &AIR_CONDITIONING).expect("a fit");
        close(weibull.ratio, 1.385_557_05);
        close(weibull.p, 0.239_156_84);
        let bearings = against_exponential(Family::Gamma, &BEARINGS).expect("a fit");
        close(bearings.shape.low, 2.195_475_6);
        close(bearings.shape.high, 6.711_272_4);
        let between =
            not_nested(Family::Gamma, Family::Weibull, &AIR_CONDITIONING).expect("two fits");
        close(between.z, -0.918_932_5);
        assert!((between.p - 0.358_13).abs() < 1.0e-5);
        close(between.akaike_difference, 2.0 * (152.167_331 - 151.936_889));
        assert!(against_exponential(Family::Laplace, &BEARINGS).is_none());
        assert!(against_exponential(Family::Gamma, &[1.0, 0.0]).is_none());
    }

    const KEY: Key = *b"crossgrain: tests of likelihoods";

    fn rejections(shape: f64, count: usize, trials: usize) -> Vec<bool> {
        let trial = |source: &mut crate::random::Source| {
            let values: Vec<f64> = (0..count).map(|_| source.gamma(shape)).collect();
            against_exponential(Family::Gamma, &values).is_some_and(|found| found.p < 0.05)
        };
        replicates(&KEY, trials, trial)
    }

    /// An exponential is rejected one time in twenty. The sizes are those for which the non-central χ² promises
    /// nine rejections in ten, n = 10.51/(2 KL); there are more, since the ratio of small samples is skewed:
    /// 0.9226, 0.9465 and 0.9653 in 20,000 samples of numpy 2 each.
    #[test]
    fn level_and_power_of_the_ratio() {
        assert_share(rejections(1.0, 200, 4000), 0.99, 0.05);
        for (shape, count, wanted) in [(1.2, 530, 0.9226), (1.5, 120, 0.9465), (2.0, 46, 0.9653)] {
            assert_share(rejections(shape, count, 2000), 0.99, wanted);
        }
    }

    /// What the formula for nested laws promises, n = 10.51/(2 KL), is too little for Vuong's test.
    #[test]
    fn samples_that_tell_laws_apart_are_found_by_drawing() {
        let half_normal = Distribution::GaussianTail {
            shape: 0.5,
            scale: 1.0,
        };
        let behind = 0.5 - (std::f64::consts::PI / 2.0).ln();
        let promised = (10.51 / (2.0 * behind)).ceil() as usize;
        let found = seen_from(&half_normal, Family::Exponential).expect("they differ");
        assert!(found > promised, "{found} {promised}");
        let at = |count| {
            let shown = replicates(&SEEN, DRAWN, |source| {
                shows(&half_normal, Family::Exponential, count, source)
            });
            shown.into_iter().filter(|shown| *shown).count() as f64 / DRAWN as f64
        };
        assert!(at(found) >= 0.9 && at(promised) < 0.85, "{}", at(promised));
        let exponential = Distribution::Exponential { mean: 1.0 };
        assert_eq!(seen_from(&exponential, Family::Exponential), None);
    }

    /// Of two laws equally far from values in groups of ten one in twenty is rejected by groups, and far more by values.
    #[test]
    fn groups_are_the_unit() {
        let law = |location| laplace(location, 1.0);
        let rejected = |size: usize| {
            replicates(&KEY, 2000, |source| {
                let mut values = Vec::new();
                for _ in 0..60 {
                    let common = law(0.0).draw(source);
                    values.extend((0..10).map(|_| common + law(0.0).draw(source)));
                }
                let found = between(law(1.0), law(-1.0), values.chunks(size));
                found.expect("they differ").p < 0.05
            })
        };
        assert_share(rejected(10), 0.99, 0.05);
        assert!(rejected(1).iter().filter(|rejected| **rejected).count() > 600);
    }

    /// Of few values the ends lie beyond half and twice the estimate; at each the deviance is the 95 % of χ²₁.
    #[test]
    fn wide_intervals_end_at_the_limit() {
        let values = &AIR_CONDITIONING[..3];
        for family in [Family::Gamma, Family::Weibull] {
            let found = against_exponential(family, values).expect("a fit").shape;
            let Interval {
                estimate,
                low,
                high,
            } = found;
            assert!(low < 0.5 * estimate && high > 2.0 * estimate, "{found:?}");
            let likelihood = profile(family, values);
            for end in [low, high] {
                close(2.0 * (likelihood(estimate) - likelihood(end)), 3.841_458_8);
            }
        }
    }

    /// The deviance interval of 95 % holds the truth 95 times in a hundred.
    #[test]
    fn the_interval_covers() {
        let covered = replicates(&KEY, 2000, |source| {
            let values: Vec<f64> = (0..150).map(|_| source.gamma(1.6)).collect();
            let found = against_exponential(Family::Gamma, &values).expect("a fit");
            found.shape.low < 1.6 && found.shape.high > 1.6
        });
        assert_share(covered, 0.99, 0.95);
    }
}
