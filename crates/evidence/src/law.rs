//! The laws that a distribution of stresses is compared with, and their maximum-likelihood fits.

use serde::{Deserialize, Serialize};
use statrs::distribution::{self as known, Continuous, ContinuousCDF};

use super::moments::{mean, median};
use super::random::Source;
use super::shape;

/// A family of laws.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// One parameter, the mean.
    Exponential,
    /// Shape and scale; Erlang where the shape is a whole number.
    Gamma,
    /// Shape and scale.
    Weibull,
    /// Location and scale: two exponentials back to back.
    Laplace,
}

/// A law with its parameters, in the unit of the values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Law {
    /// f = e^{−x/mean}/mean.
    Exponential {
        /// Mean, which is also the standard deviation.
        mean: f64,
    },
    /// f ∝ x^{shape − 1} e^{−x/scale}; mean shape·scale.
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
    /// f = e^{−|x − location|/scale}/(2 scale).
    Laplace {
        /// Mean and median.
        location: f64,
        /// Mean absolute deviation; the standard deviation is √2 times it.
        scale: f64,
    },
}

impl Family {
    /// Number of its parameters.
    pub fn parameters(self) -> usize {
        match self {
            Family::Exponential => 1,
            _ => 2,
        }
    }

    /// The law of this family under which the values are likeliest. None where there is none: for fewer than
    /// two different values, and for values at or below zero in the families of positive ones (zero is
    /// possible under an exponential alone).
    pub fn fit(self, values: &[f64]) -> Option<Law> {
        let all = |holds: fn(f64) -> bool| values.iter().all(|value| holds(*value));
        let (lowest, highest) = range(values)?;
        if lowest == highest {
            return None;
        }
        match self {
            Family::Exponential => {
                all(|value| value >= 0.0).then(|| Law::Exponential { mean: mean(values) })
            }
            Family::Gamma if all(|value| value > 0.0) => {
                let shape = shape::gamma(values)?;
                let scale = mean(values) / shape;
                Some(Law::Gamma { shape, scale })
            }
            Family::Weibull if all(|value| value > 0.0) => {
                let shape = shape::weibull(values)?;
                let powers = values.iter().map(|value| (value / highest).powf(shape));
                let power = powers.sum::<f64>() / values.len() as f64;
                let scale = highest * power.powf(1.0 / shape);
                Some(Law::Weibull { shape, scale })
            }
            Family::Laplace => {
                let location = median(values)?;
                let off = values.iter().map(|value| (value - location).abs());
                let scale = off.sum::<f64>() / values.len() as f64;
                Some(Law::Laplace { location, scale })
            }
            _ => None,
        }
    }
}

/// Smallest and largest; none without values or with one that is not a number.
fn range(values: &[f64]) -> Option<(f64, f64)> {
    let mut ends = (*values.first()?, *values.first()?);
    for value in values {
        if !value.is_finite() {
            return None;
        }
        ends = (ends.0.min(*value), ends.1.max(*value));
    }
    Some(ends)
}

impl Law {
    /// Its family.
    pub fn family(&self) -> Family {
        match self {
            Law::Exponential { .. } => Family::Exponential,
            Law::Gamma { .. } => Family::Gamma,
            Law::Weibull { .. } => Family::Weibull,
            Law::Laplace { .. } => Family::Laplace,
        }
    }

    /// The law of the values over a unit above zero.
    pub fn over(&self, unit: f64) -> Law {
        match *self {
            Law::Exponential { mean } => Law::Exponential { mean: mean / unit },
            Law::Gamma { shape, scale } => Law::Gamma {
                shape,
                scale: scale / unit,
            },
            Law::Weibull { shape, scale } => Law::Weibull {
                shape,
                scale: scale / unit,
            },
            Law::Laplace { location, scale } => Law::Laplace {
                location: location / unit,
                scale: scale / unit,
            },
        }
    }

    /// The probability of a value up to `x`; not a number for impossible parameters.
    pub fn cumulative(&self, x: f64) -> f64 {
        match *self {
            Law::Exponential { mean } => -(-x.max(0.0) / mean).exp_m1(),
            Law::Gamma { shape, scale } => {
                known::Gamma::new(shape, 1.0 / scale).map_or(f64::NAN, |law| law.cdf(x))
            }
            Law::Weibull { shape, scale } => -(-(x.max(0.0) / scale).powf(shape)).exp_m1(),
            Law::Laplace { location, scale } => {
                let off = (x - location) / scale;
                let tail = 0.5 * (-off.abs()).exp();
                if off < 0.0 { tail } else { 1.0 - tail }
            }
        }
    }

    /// The probability of a value above `x`, to full precision where it is small.
    pub fn survival(&self, x: f64) -> f64 {
        match *self {
            Law::Exponential { mean } => (-x.max(0.0) / mean).exp(),
            Law::Gamma { shape, scale } => {
                known::Gamma::new(shape, 1.0 / scale).map_or(f64::NAN, |law| law.sf(x))
            }
            Law::Weibull { shape, scale } => (-(x.max(0.0) / scale).powf(shape)).exp(),
            Law::Laplace { location, scale } => {
                let off = (x - location) / scale;
                let tail = 0.5 * (-off.abs()).exp();
                if off > 0.0 { tail } else { 1.0 - tail }
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
            Law::Exponential { mean } if x >= 0.0 => -x / mean - mean.ln(),
            Law::Exponential { .. } => f64::NEG_INFINITY,
            Law::Gamma { shape, scale } => {
                known::Gamma::new(shape, 1.0 / scale).map_or(f64::NAN, |law| law.ln_pdf(x))
            }
            Law::Weibull { shape, scale } => {
                known::Weibull::new(shape, scale).map_or(f64::NAN, |law| law.ln_pdf(x))
            }
            Law::Laplace { location, scale } => -(x - location).abs() / scale - (2.0 * scale).ln(),
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
            Law::Exponential { mean } => mean * source.exponential(),
            Law::Gamma { shape, scale } => scale * source.gamma(shape),
            Law::Weibull { shape, scale } => scale * source.exponential().powf(1.0 / shape),
            Law::Laplace { location, scale } => {
                location + scale * (source.exponential() - source.exponential())
            }
        }
    }
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

    /// Fits and log-likelihoods computed independently with scipy 1.17.1 (`fit(x, floc=0)`, `logpdf`).
    #[test]
    fn fits_of_known_samples() {
        let close = |found: f64, wanted: f64| {
            assert!((found / wanted - 1.0).abs() < 1.0e-5, "{found} {wanted}");
        };
        let cases: [(&[f64], [f64; 7]); 2] = [
            (
                &AIR_CONDITIONING,
                [
                    -152.629_667,
                    0.811_911_6,
                    73.407_006,
                    -152.167_331,
                    0.853_587_9,
                    54.613_463,
                    -151.936_889,
                ],
            ),
            (
                &BEARINGS,
                [
                    -121.434_876,
                    4.025_414_6,
                    17.942_089,
                    -113.029_281,
                    2.102_060_1,
                    81.878_316,
                    -113.691_291,
                ],
            ),
        ];
        for (values, wanted) in cases {
            let fit = |family: Family| family.fit(values).expect("positive values");
            close(fit(Family::Exponential).log_likelihood(values), wanted[0]);
            let gamma = fit(Family::Gamma);
            let Law::Gamma { shape, scale } = gamma else {
                panic!("{gamma:?}")
            };
            close(shape, wanted[1]);
            close(scale, wanted[2]);
            close(gamma.log_likelihood(values), wanted[3]);
            let weibull = fit(Family::Weibull);
            let Law::Weibull { shape, scale } = weibull else {
                panic!("{weibull:?}")
            };
            close(shape, wanted[4]);
            close(scale, wanted[5]);
            close(weibull.log_likelihood(values), wanted[6]);
        }
        // scipy 1.17.1, laplace.fit: 67.8, 28.32.
        let Some(Law::Laplace { location, scale }) = Family::Laplace.fit(&BEARINGS) else {
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
        for law in [
            Law::Exponential { mean: 3.0 },
            Law::Gamma {
                shape: 0.6,
                scale: 2.0,
            },
            Law::Gamma {
                shape: 5.0,
                scale: 2.0,
            },
            Law::Weibull {
                shape: 1.8,
                scale: 0.1,
            },
            Law::Laplace {
                location: -1.0,
                scale: 2.0,
            },
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
}
