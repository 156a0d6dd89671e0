//! The distributions that stresses are compared with, and their maximum-likelihood fits.

use serde::{Deserialize, Serialize};
use statrs::distribution::{self as known, Continuous, ContinuousCDF};
use statrs::function::gamma::{digamma, ln_gamma};

use super::halved;
use super::moments::{mean, median};
use super::random::Source;

/// A family of distributions; [`Distribution`] has their densities and parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    Exponential,
    Gamma,
    Weibull,
    Laplace,
    Normal,
    StretchedExponential,
    GaussianTail,
}

/// A distribution with its parameters, in the unit of the values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Distribution {
    /// f = e^{−x/mean}/mean.
    Exponential {
        /// Mean, which is also the standard deviation.
        mean: f64,
    },
    /// f ∝ x^{shape − 1} e^{−x/scale}; mean shape·scale. Erlang where the shape is a whole number.
    Gamma {
        /// 1 for an exponential.
        shape: f64,
        /// Mean over shape.
        scale: f64,
    },
    /// F = 1 − e^{−(x/scale)^shape}.
    Weibull {
        /// 1 for an exponential.
        shape: f64,
        /// The value that a share 1 − 1/e lies below.
        scale: f64,
    },
    /// f = e^{−|x − location|/scale}/(2 scale): two exponentials back to back.
    Laplace {
        /// Mean and median.
        location: f64,
        /// Mean absolute deviation; the standard deviation is √2 times it.
        scale: f64,
    },
    /// f ∝ e^{−(x − mean)²/(2 deviation²)}.
    Normal {
        /// Mean and median.
        mean: f64,
        /// Standard deviation.
        deviation: f64,
    },
    /// f ∝ e^{−(x/scale)^power} for x ≥ 0: forces of frictionless grains with power 2 in the plane (van Eerd et al. 2007).
    StretchedExponential {
        /// 1 for an exponential, 2 for half of a normal law.
        power: f64,
        /// Where the density is 1/e of that at zero.
        scale: f64,
    },
    /// f ∝ x^{2·shape − 1} e^{−(x/scale)²}: x² has a gamma law. A Gaussian tail, as pressures of the force network ensemble
    /// have (Tighe, van Eerd and Vlugt 2008).
    GaussianTail {
        /// ½ for half of a normal law.
        shape: f64,
        /// √2 times the standard deviation of that one.
        scale: f64,
    },
}

impl Family {
    /// Of single-grain stresses: the exponential of Tejada's theory, and those of others.
    pub const OF_STRESSES: [Family; 5] = [
        Family::Exponential,
        Family::Gamma,
        Family::StretchedExponential,
        Family::Weibull,
        Family::GaussianTail,
    ];

    /// For people.
    pub fn title(self) -> &'static str {
        match self {
            Family::Exponential => "exponential",
            Family::Gamma => "gamma",
            Family::Weibull => "Weibull",
            Family::Laplace => "Laplace",
            Family::Normal => "normal",
            Family::StretchedExponential => "stretched exponential",
            Family::GaussianTail => "Gaussian tail",
        }
    }

    /// Number of its parameters.
    pub fn parameters(self) -> usize {
        match self {
            Family::Exponential => 1,
            _ => 2,
        }
    }

    /// The distribution of this family under which the values are likeliest. None where there is none: for fewer than
    /// two different values, and for values at or below zero in the families of positive ones (zero is
    /// possible under an exponential alone).
    pub fn fit(self, values: &[f64]) -> Option<Distribution> {
        let (lowest, highest) = range(values)?;
        if lowest == highest {
            return None;
        }
        let mean_of = |function: &dyn Fn(f64) -> f64| {
            values.iter().map(|value| function(*value)).sum::<f64>() / values.len() as f64
        };
        match self {
            Family::Exponential if lowest >= 0.0 => {
                Some(Distribution::Exponential { mean: mean(values) })
            }
            Family::Gamma if lowest > 0.0 => {
                let shape = gamma_shape(values)?;
                let scale = mean(values) / shape;
                Some(Distribution::Gamma { shape, scale })
            }
            Family::Weibull if lowest > 0.0 => {
                let shape = weibull_shape(values)?;
                let power = mean_of(&|value| (value / highest).powf(shape));
                let scale = highest * power.powf(1.0 / shape);
                Some(Distribution::Weibull { shape, scale })
            }
            Family::Laplace => {
                let location = median(values)?;
                let scale = mean_of(&|value| (value - location).abs());
                Some(Distribution::Laplace { location, scale })
            }
            Family::Normal => {
                let mean = mean(values);
                let deviation = mean_of(&|value| (value - mean).powi(2)).sqrt();
                Some(Distribution::Normal { mean, deviation })
            }
            Family::StretchedExponential if lowest >= 0.0 => {
                let power = stretching(values, highest)?;
                let powers = mean_of(&|value| (value / highest).powf(power));
                let scale = highest * (power * powers).powf(1.0 / power);
                Some(Distribution::StretchedExponential { power, scale })
            }
            Family::GaussianTail if lowest > 0.0 => {
                let squares: Vec<f64> = values
                    .iter()
                    .map(|value| (value / highest).powi(2))
                    .collect();
                let shape = gamma_shape(&squares)?;
                let scale = highest * (mean(&squares) / shape).sqrt();
                Some(Distribution::GaussianTail { shape, scale })
            }
            _ => None,
        }
    }
}

/// Smallest and largest; none without values or with one that is not a number.
fn range(values: &[f64]) -> Option<(f64, f64)> {
    let sound = !values.is_empty() && values.iter().all(|value| value.is_finite());
    let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    sound.then_some((lowest, highest))
}

impl Distribution {
    pub fn family(&self) -> Family {
        match self {
            Distribution::Exponential { .. } => Family::Exponential,
            Distribution::Gamma { .. } => Family::Gamma,
            Distribution::Weibull { .. } => Family::Weibull,
            Distribution::Laplace { .. } => Family::Laplace,
            Distribution::Normal { .. } => Family::Normal,
            Distribution::StretchedExponential { .. } => Family::StretchedExponential,
            Distribution::GaussianTail { .. } => Family::GaussianTail,
        }
    }

    /// The probability of a value up to `x`; not a number for impossible parameters.
    pub fn cumulative(&self, x: f64) -> f64 {
        self.share(x, false)
    }

    /// The probability of a value above `x`, to full precision where it is small.
    pub fn survival(&self, x: f64) -> f64 {
        self.share(x, true)
    }

    fn share(&self, x: f64, above: bool) -> f64 {
        let exponential = |x: f64| match above {
            true => (-x).exp(),
            false => -(-x).exp_m1(),
        };
        match *self {
            Distribution::Exponential { mean } => exponential(x.max(0.0) / mean),
            Distribution::Gamma { shape, scale } => match known::Gamma::new(shape, 1.0 / scale) {
                Ok(law) if above => law.sf(x),
                law => law.map_or(f64::NAN, |law| law.cdf(x)),
            },
            Distribution::Weibull { shape, scale } => exponential((x.max(0.0) / scale).powf(shape)),
            Distribution::Laplace { location, scale } => {
                let off = (x - location) / scale;
                let tail = 0.5 * (-off.abs()).exp();
                let in_tail = if above { off > 0.0 } else { off < 0.0 };
                if in_tail { tail } else { 1.0 - tail }
            }
            Distribution::Normal { mean, deviation } => match known::Normal::new(mean, deviation) {
                Ok(law) if above => law.sf(x),
                law => law.map_or(f64::NAN, |law| law.cdf(x)),
            },
            Distribution::StretchedExponential { power, scale } => {
                gamma(1.0 / power).share((x.max(0.0) / scale).powf(power), above)
            }
            Distribution::GaussianTail { shape, scale } => {
                gamma(shape).share((x.max(0.0) / scale).powi(2), above)
            }
        }
    }

    /// Density at `x`.
    pub fn density(&self, x: f64) -> f64 {
        self.logarithm_of_density(x).exp()
    }

    /// Logarithm of the density at `x`.
    pub fn logarithm_of_density(&self, x: f64) -> f64 {
        match *self {
            Distribution::Exponential { mean } if x >= 0.0 => -x / mean - mean.ln(),
            Distribution::Gamma { shape, scale } => {
                known::Gamma::new(shape, 1.0 / scale).map_or(f64::NAN, |law| law.ln_pdf(x))
            }
            Distribution::Weibull { shape, scale } => {
                known::Weibull::new(shape, scale).map_or(f64::NAN, |law| law.ln_pdf(x))
            }
            Distribution::Laplace { location, scale } => {
                -(x - location).abs() / scale - (2.0 * scale).ln()
            }
            Distribution::Normal { mean, deviation } => {
                known::Normal::new(mean, deviation).map_or(f64::NAN, |law| law.ln_pdf(x))
            }
            Distribution::StretchedExponential { power, scale } if x >= 0.0 => {
                power.ln() - scale.ln() - ln_gamma(1.0 / power) - (x / scale).powf(power)
            }
            Distribution::GaussianTail { shape, scale } if x > 0.0 => {
                let ratio = x / scale;
                std::f64::consts::LN_2 - scale.ln() - ln_gamma(shape)
                    + (2.0 * shape - 1.0) * ratio.ln()
                    - ratio * ratio
            }
            _ => f64::NEG_INFINITY,
        }
    }

    /// Σ ln f(x).
    pub fn log_likelihood(&self, values: &[f64]) -> f64 {
        let logarithms = values.iter().map(|value| self.logarithm_of_density(*value));
        logarithms.sum()
    }

    /// A value drawn from it.
    pub fn draw(&self, source: &mut Source) -> f64 {
        match *self {
            Distribution::Exponential { mean } => mean * source.exponential(),
            Distribution::Gamma { shape, scale } => scale * source.gamma(shape),
            Distribution::Weibull { shape, scale } => {
                scale * source.exponential().powf(1.0 / shape)
            }
            Distribution::Laplace { location, scale } => {
                location + scale * (source.exponential() - source.exponential())
            }
            Distribution::Normal { mean, deviation } => mean + deviation * source.normal(),
            Distribution::StretchedExponential { power, scale } => {
                scale * source.gamma(1.0 / power).powf(1.0 / power)
            }
            Distribution::GaussianTail { shape, scale } => scale * source.gamma(shape).sqrt(),
        }
    }
}

/// Maximum-likelihood shape k of a Gamma distribution: ln k − ψ(k) = ln x̄ − mean(ln x); 1 for an exponential. Values
/// at or below zero are left out. None for fewer than two different values.
pub fn gamma_shape(values: &[f64]) -> Option<f64> {
    let positive = positive(values);
    let logarithms: Vec<f64> = positive.iter().map(|value| value.ln()).collect();
    let wanted = mean(&positive).ln() - mean(&logarithms);
    if wanted.is_nan() || wanted <= 0.0 {
        return None;
    }
    // ln k − ψ(k) falls from ∞ to 0.
    falling_root(SHAPES, |k| k.ln() - digamma(k) - wanted)
}

/// Maximum-likelihood shape c of a Weibull distribution: Σxᶜ ln x/Σxᶜ − 1/c = mean(ln x); 1 for an exponential. Values
/// at or below zero are left out. None for fewer than two different values.
pub fn weibull_shape(values: &[f64]) -> Option<f64> {
    let positive = positive(values);
    let largest = positive.iter().copied().fold(0.0, f64::max);
    let logarithms = positive.iter().map(|value| (value / largest).ln());
    let logarithms: Vec<f64> = logarithms.collect();
    let centre = mean(&logarithms);
    if centre.is_nan() || centre >= 0.0 {
        return None;
    }
    falling_root(SHAPES, |c| {
        let (mut weighted, mut weights) = (0.0, 0.0);
        for logarithm in &logarithms {
            let weight = (c * logarithm).exp();
            weighted += weight * logarithm;
            weights += weight;
        }
        1.0 / c + centre - weighted / weights
    })
}

/// Maximum-likelihood power a of a stretched exponential: a + ψ(1/a) + ln(a S/n) = a S'/S with S = Σxᵃ, S' = Σxᵃ ln x. Towards
/// infinite powers the law is even up to the largest value, and some tens of values cannot tell; then there is none.
fn stretching(values: &[f64], highest: f64) -> Option<f64> {
    falling_root([1.0e-3, 50.0], |a| {
        let (mut sum, mut slope) = (0.0, 0.0);
        for value in values.iter().filter(|value| **value > 0.0) {
            let logarithm = (value / highest).ln();
            let power = (a * logarithm).exp();
            sum += power;
            slope += power * logarithm;
        }
        a + digamma(1.0 / a) + (a * sum / values.len() as f64).ln() - a * slope / sum
    })
}

/// The gamma law of scale 1.
fn gamma(shape: f64) -> Distribution {
    Distribution::Gamma { shape, scale: 1.0 }
}

fn positive(values: &[f64]) -> Vec<f64> {
    values
        .iter()
        .copied()
        .filter(|value| *value > 0.0)
        .collect()
}

/// Shapes that are looked at.
const SHAPES: [f64; 2] = [1.0e-3, 1.0e4];

/// A sign is computed where a value is nearer than this share to where the function seems to be zero; elsewhere it is known.
const NEAR: f64 = 1.0e-12;

/// Where a falling function is zero between these ends, by halving on a logarithmic scale. Computing it is most of the work.
fn falling_root(ends: [f64; 2], function: impl Fn(f64) -> f64) -> Option<f64> {
    let [low, high] = ends.map(&function);
    (low > 0.0 && high < 0.0).then(|| {
        let around = seemingly_zero(ends, &function).map(|x| [x * (1.0 - NEAR), x * (1.0 + NEAR)]);
        let [above, below] = around
            .filter(|[low, high]| function(*low) > 0.0 && function(*high) < 0.0)
            .unwrap_or(ends);
        halved(ends, 80, |value| {
            value <= above || value < below && function(value) > 0.0
        })
    })
}

/// By secants, from where eight halvings end; none where they lead out of what these leave.
fn seemingly_zero(ends: [f64; 2], function: impl Fn(f64) -> f64) -> Option<f64> {
    let [mut low, mut high] = ends;
    for _ in 0..8 {
        let middle = (low * high).sqrt();
        *if function(middle) > 0.0 {
            &mut low
        } else {
            &mut high
        } = middle;
    }
    let [mut before, mut now] = [(low, function(low)), (high, function(high))];
    for _ in 0..20 {
        let next = now.0 - now.1 * (now.0 - before.0) / (now.1 - before.1);
        if !(low..=high).contains(&next) {
            return None;
        }
        if (next - now.0).abs() <= 1.0e-13 * next {
            return Some(next);
        }
        (before, now) = (now, (next, function(next)));
    }
    None
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Hours between failures of the air conditioning of aeroplane 7912 (Proschan 1963).
    pub const AIR_CONDITIONING: [f64; 30] = [
        23.0, 261.0, 87.0, 7.0, 120.0, 14.0, 62.0, 47.0, 225.0, 71.0, 246.0, 21.0, 42.0, 20.0, 5.0,
        12.0, 120.0, 11.0, 3.0, 14.0, 71.0, 11.0, 14.0, 11.0, 16.0, 90.0, 1.0, 16.0, 52.0, 95.0,
    ];
    /// Millions of turns before ball bearings failed (Lieblein and Zelen 1956).
    pub const BEARINGS: [f64; 23] = [
        17.88, 28.92, 33.00, 41.52, 42.12, 45.60, 48.48, 51.84, 51.96, 54.12, 55.56, 67.80, 68.64,
        68.64, 68.88, 84.12, 93.12, 98.64, 105.12, 105.84, 127.92, 128.04, 173.40,
    ];

    pub fn close(found: f64, wanted: f64) {
        assert!((found / wanted - 1.0).abs() < 1.0e-5, "{found} {wanted}");
    }

    pub fn gamma(shape: f64, scale: f64) -> Distribution {
        Distribution::Gamma { shape, scale }
    }

    pub fn laplace(location: f64, scale: f64) -> Distribution {
        Distribution::Laplace { location, scale }
    }

    /// Bit by bit, also where a function bends as strongly as these do at their ends.
    #[test]
    fn a_root_is_that_of_halving_alone() {
        for exponent in 1..200 {
            let wanted = (-0.1 * f64::from(exponent)).exp() * 500.0;
            let function = |k: f64| k.ln() - digamma(k) - wanted;
            let sums = |k: f64| (1..50).map(|at| (-k * f64::from(at)).exp()).sum::<f64>() - wanted;
            for function in [&function as &dyn Fn(f64) -> f64, &sums] {
                let [low, high] = SHAPES.map(function);
                let plainly = (low > 0.0 && high < 0.0)
                    .then(|| halved(SHAPES, 80, |value| function(value) > 0.0));
                assert_eq!(falling_root(SHAPES, function), plainly, "{wanted}");
            }
        }
    }

    /// Fits and log-likelihoods computed independently with scipy 1.17.1 (`fit(x, floc=0)`, `logpdf`).
    #[test]
    fn fits_of_known_samples() {
        use Family::{Gamma, Weibull};
        let exponential = |values: &[f64]| {
            let law = Family::Exponential.fit(values).expect("positive values");
            law.log_likelihood(values)
        };
        close(exponential(&AIR_CONDITIONING), -152.629_667);
        close(exponential(&BEARINGS), -121.434_876);
        let (air, bearings) = (&AIR_CONDITIONING[..], &BEARINGS[..]);
        for (family, values, wanted) in [
            (Gamma, air, [0.811_911_6, 73.407_006, -152.167_331]),
            (Weibull, air, [0.853_587_9, 54.613_463, -151.936_889]),
            (Gamma, bearings, [4.025_414_6, 17.942_089, -113.029_281]),
            (Weibull, bearings, [2.102_060_1, 81.878_316, -113.691_291]),
        ] {
            let found = family.fit(values).expect("positive values");
            let (Distribution::Gamma { shape, scale } | Distribution::Weibull { shape, scale }) =
                found
            else {
                panic!("{found:?}")
            };
            close(shape, wanted[0]);
            close(scale, wanted[1]);
            close(found.log_likelihood(values), wanted[2]);
        }
        // scipy 1.17.1, laplace.fit: 67.8, 28.32.
        let Some(Distribution::Laplace { location, scale }) = Family::Laplace.fit(&BEARINGS) else {
            panic!("no Laplace law")
        };
        close(location, 67.8);
        close(scale, 28.32);
    }

    /// What is drawn from a law is found again by its fit, and the cumulative share of what is drawn is
    /// uniform, mean ½ and the quarter below ¼.
    #[test]
    fn draws_are_of_their_law() {
        let mut source = Source::new(b"crossgrain: tests of known laws.", 0);
        let weibull = |shape, scale| Distribution::Weibull { shape, scale };
        let normal = |mean, deviation| Distribution::Normal { mean, deviation };
        let stretched = |power, scale| Distribution::StretchedExponential { power, scale };
        let tail = |shape, scale| Distribution::GaussianTail { shape, scale };
        for law in [
            Distribution::Exponential { mean: 3.0 },
            gamma(0.6, 2.0),
            gamma(5.0, 2.0),
            normal(3.0, 2.0),
            weibull(1.8, 0.1),
            laplace(-1.0, 2.0),
            stretched(2.0, 3.0),
            stretched(0.7, 3.0),
            tail(0.9, 3.0),
        ] {
            let values: Vec<f64> = (0..20_000).map(|_| law.draw(&mut source)).collect();
            let shares: Vec<f64> = values.iter().map(|value| law.cumulative(*value)).collect();
            assert!((mean(&shares) - 0.5).abs() < 0.01, "{law:?}");
            let quarter = shares.iter().filter(|share| **share < 0.25).count();
            assert!((4700..5300).contains(&quarter), "{law:?} {quarter}");
            let fitted = law.family().fit(&values).expect("many values");
            let gain = fitted.log_likelihood(&values) - law.log_likelihood(&values);
            assert!((0.0..8.0).contains(&gain), "{law:?} {fitted:?} {gain}");
        }
    }

    #[test]
    fn what_cannot_be_fitted_is_not() {
        assert!(Family::Gamma.fit(&[1.0, 0.0]).is_none());
        assert!(Family::Exponential.fit(&[1.0, 0.0]).is_some());
        assert!(Family::Exponential.fit(&[1.0, -1.0]).is_none());
        assert!(Family::Laplace.fit(&[1.0, 1.0]).is_none());
        assert!(Family::Laplace.fit(&[1.0, f64::NAN]).is_none());
        assert!(Family::Weibull.fit(&[]).is_none());
    }

    #[test]
    fn equal_values_have_no_shape() {
        assert!(gamma_shape(&[2.0, 2.0, 2.0]).is_none());
        assert!(gamma_shape(&[]).is_none());
        assert!(weibull_shape(&[]).is_none());
    }
}
