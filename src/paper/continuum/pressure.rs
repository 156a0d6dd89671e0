//! The pressure under the load, its Fourier transform and its potential.

use std::f64::consts::PI;

use nalgebra::{Complex, DMatrix, DVector};

use super::layer;
use super::{Load, Model, Spread};

/// Even Chebyshev polynomials in the pressure under a punch. A punch as wide as the layer is deep needs five
/// for a relative accuracy of 10⁻⁶.
const TERMS: usize = 8;
/// Places at which the punch's pressure is sampled for integrals over it.
const SAMPLES: usize = 4 * TERMS;

/// p(s) for |s| < a, even in s.
#[derive(Debug, Clone)]
pub(super) struct Pressure {
    half_width: f64,
    shape: Shape,
}

#[derive(Debug, Clone)]
enum Shape {
    /// Pa.
    Uniform(f64),
    /// p(s) = Σ c_n T_{2n}(s/a)/(π√(a²−s²)).
    Punch {
        /// c in N/m; c₀ is the force.
        coefficients: [f64; TERMS],
        /// The same as line loads for integrals: places in half-widths above zero and forces in N/m, of each with its mirror
        /// image.
        lines: Vec<(f64, f64)>,
    },
}

impl Pressure {
    /// Under this load on this ground.
    pub fn under(model: Model, load: Load) -> Self {
        let shape = match load.spread {
            Spread::Uniform => Shape::Uniform(load.pressure),
            Spread::RigidPunch => {
                let coefficients = punch(model, load);
                let force = |t: f64| 2.0 * chebyshev_sum(&coefficients, t) / SAMPLES as f64;
                Shape::Punch {
                    coefficients,
                    lines: samples().take(SAMPLES / 2).map(|t| (t, force(t))).collect(),
                }
            }
        };
        Pressure {
            half_width: load.half_width,
            shape,
        }
    }

    /// a, m.
    pub fn half_width(&self) -> f64 {
        self.half_width
    }

    /// Pa.
    pub fn at(&self, s: f64) -> f64 {
        let t = s / self.half_width;
        if t.abs() >= 1.0 {
            return 0.0;
        }
        match &self.shape {
            Shape::Uniform(pressure) => *pressure,
            Shape::Punch { coefficients, .. } => {
                chebyshev_sum(coefficients, t) / (PI * self.half_width * (1.0 - t * t).sqrt())
            }
        }
    }

    /// ∫p(s) cos ks ds, N/m. For a punch by the Gauss-Chebyshev rule, exact while ka is below the number of samples.
    pub fn transform(&self, k: f64) -> f64 {
        let ka = k * self.half_width;
        match &self.shape {
            Shape::Uniform(pressure) => {
                let share = if ka < 1e-8 { 1.0 } else { ka.sin() / ka };
                2.0 * self.half_width * pressure * share
            }
            Shape::Punch { lines, .. } => {
                let of = |(t, force): &(f64, f64)| force * (ka * t).cos();
                lines.iter().map(of).sum()
            }
        }
    }

    /// F(w) = (1/π)∫p(s)/(w−s)ds and F′(w) at w = x + iz, z > 0, in Pa and Pa/m, in closed form.
    pub fn potential(&self, x: f64, z: f64) -> [Complex<f64>; 2] {
        let a = self.half_width;
        let w = Complex::new(x, z);
        let (left, right) = (w + a, w - a);
        match &self.shape {
            Shape::Uniform(pressure) => {
                let scale = pressure / PI;
                // The logarithms apart: each has its angle between 0 and π, so that none jumps.
                [
                    (left.ln() - right.ln()) * scale,
                    (left.inv() - right.inv()) * scale,
                ]
            }
            Shape::Punch { coefficients, .. } => {
                // ∫T_n(t)/(√(1−t²)(v−t))dt = πρⁿ/√(v²−1), ρ = v−√(v²−1), for even n.
                let root = left.sqrt() * right.sqrt();
                let ratio = (w + root).inv() * a;
                let square = ratio * ratio;
                let mut power = Complex::new(1.0, 0.0);
                let (mut value, mut slope) = (Complex::ZERO, Complex::ZERO);
                for (index, c) in coefficients.iter().enumerate() {
                    let term = power * *c / (root * PI);
                    value += term;
                    let order = 2.0 * index as f64;
                    slope -= term * (Complex::new(order, 0.0) / root + w / (root * root));
                    power *= square;
                }
                [value, slope]
            }
        }
    }
}

/// The coefficients under a punch: the surface sinks by the same everywhere under it. With −ln|x−s| the
/// half-space's answer to a line load and K(x−s) what the ground differs by,
/// ∫p(s)(−ln|x−s| + K(x−s))ds is constant. Chebyshev polynomials are the logarithm's own functions:
/// ∫T_n(t)(−ln|v−t|)/(π√(1−t²))dt = T_n(v)/n, ln 2 for n = 0. The rest is collocation.
fn punch(model: Model, load: Load) -> [f64; TERMS] {
    let mut coefficients = [0.0; TERMS];
    coefficients[0] = load.force();
    let Some(answer) = layer::Answer::of(model) else {
        return coefficients;
    };
    let mut equations = DMatrix::zeros(TERMS, TERMS);
    let mut right = DVector::zeros(TERMS);
    for row in 0..TERMS {
        // Even in v, so half of it will do.
        let v = (PI * (2.0 * row as f64 + 1.0) / (4.0 * TERMS as f64)).cos();
        let kernel: Vec<(f64, f64)> = samples()
            .map(|t| {
                (
                    t,
                    answer.difference(load.half_width * (v - t)) / SAMPLES as f64,
                )
            })
            .collect();
        let term = |index: usize| {
            let smooth: f64 = kernel.iter().map(|(t, k)| chebyshev(index, *t) * k).sum();
            let logarithm = match index {
                0 => 2f64.ln(),
                _ => chebyshev(index, v) / (2.0 * index as f64),
            };
            smooth + logarithm
        };
        // The first unknown is how far the punch sinks.
        equations[(row, 0)] = -1.0;
        right[row] = -load.force() * term(0);
        for index in 1..TERMS {
            equations[(row, index)] = term(index);
        }
    }
    // The equations of a flat punch on any ground have a solution; without one the half-space's stays.
    if let Some(solution) = equations.lu().solve(&right) {
        coefficients[1..].copy_from_slice(&solution.as_slice()[1..]);
    }
    coefficients
}

/// The roots of the Chebyshev polynomial of order [`SAMPLES`].
fn samples() -> impl Iterator<Item = f64> {
    (0..SAMPLES).map(|index| (PI * (index as f64 + 0.5) / SAMPLES as f64).cos())
}

/// T_{2·index}(t).
fn chebyshev(index: usize, t: f64) -> f64 {
    (2.0 * index as f64 * t.acos()).cos()
}

fn chebyshev_sum(coefficients: &[f64; TERMS], t: f64) -> f64 {
    let of = |(index, c): (usize, &f64)| c * chebyshev(index, t);
    coefficients.iter().enumerate().map(of).sum()
}
