//! The continuum's stress under the punch: the half-space that the paper uses, and beside it the bed's own
//! geometry, a layer on a base with or without side walls, under a uniform pressure or a rigid punch.
//!
//! Plane and linearly elastic, x across from the middle of the load, z down from the surface; surface, base,
//! walls and punch are smooth. Compression is positive, and so is a shear that a load drives outwards on its
//! right. `docs/continuum.md` says what comes out.

pub mod table;

use std::f64::consts::PI;

use nalgebra::{Complex, DMatrix, DVector, Vector3};
use serde::Serialize;

use crate::paper::integrate;
use grains::measure::stress::Components;

/// What the load stands on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Model {
    /// Without end to the sides and downwards.
    HalfSpace,
    /// On a rigid smooth base, without end to the sides.
    Layer {
        /// From surface to base, m.
        depth: f64,
    },
    /// The same between rigid smooth walls at x = ±width/2.
    Box {
        /// From wall to wall, m.
        width: f64,
        /// From surface to base, m.
        depth: f64,
    },
}

/// How the load is spread over its width 2a.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Spread {
    /// The same pressure everywhere.
    Uniform,
    /// As under a rigid, flat and smooth punch: the surface under it stays flat.
    RigidPunch,
}

/// A load on the surface, centred at x = 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Load {
    /// Over the width.
    pub spread: Spread,
    /// Mean pressure, Pa: force per metre of depth over 2a.
    pub pressure: f64,
    /// a, m.
    pub half_width: f64,
}

impl Load {
    /// 2ap, N per metre of depth.
    pub fn force(&self) -> f64 {
        2.0 * self.half_width * self.pressure
    }
}

/// A load's stress in the ground; its pressure p(s) is even in s.
#[derive(Debug, Clone)]
pub struct Field {
    model: Model,
    /// a, m.
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

impl Field {
    /// Finds the pressure under the load, which for a punch depends on what it stands on.
    pub fn new(model: Model, load: Load) -> Self {
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
        Field {
            model,
            half_width: load.half_width,
            shape,
        }
    }

    /// The load's stress in Pa at (x, z) without the ground's weight, 0 < z, within the model. In a box `xx` comes
    /// without the part that its walls add everywhere alike, K₀·force/width: that part alone depends on
    /// the material, K₀ being ν/(1−ν).
    pub fn stress(&self, x: f64, z: f64) -> Components {
        let stress = match self.model {
            Model::HalfSpace => self.on_half_space(x, z),
            Model::Layer { depth } => self.on_layer(depth, x, z),
            Model::Box { width, depth } => self.between_walls(width, depth, x, z),
        };
        Components {
            zz: stress[0],
            xx: stress[1],
            xz: stress[2],
        }
    }

    /// [σ_zz, σ_xx, σ_xz] in Pa. With F(w) = (1/π)∫p(s)/(w−s)ds they are −Im F + z Re F′, −Im F − z Re F′ and
    /// z Im F′; for a line load this is Flamant's solution.
    fn on_half_space(&self, x: f64, z: f64) -> Vector3<f64> {
        let [value, slope] = self.potential(x, z);
        Vector3::new(
            -value.im + z * slope.re,
            -value.im - z * slope.re,
            z * slope.im,
        )
    }

    // A layer on a rigid smooth base, by Fourier's integral, and between rigid smooth walls.
    //
    // A smooth rigid plane is a plane of symmetry. So the layer is the upper half of one twice as deep that is
    // loaded from below as well, and the walls are mirrors that repeat the load at every width. Then tractions
    // are given everywhere, no displacement is, and the stress of such a plane problem does not depend on the
    // elastic constants (Michell).

    /// [σ_zz, σ_xx, σ_xz] in Pa: the half-space's in closed form, and a smooth integral for what the base adds.
    fn on_layer(&self, depth: f64, x: f64, z: f64) -> Vector3<f64> {
        // What the base adds comes from its depth and goes on to z: e^{−k(2H−z)}.
        let end = DECAY / (2.0 * depth - z);
        let panels = oscillations(end, x.abs() + self.half_width + 2.0 * depth);
        let base = integrate(0.0, end, panels, |k| {
            let (sin, cos) = (k * x).sin_cos();
            let added = of_layer(k, depth, z) - of_half_space(k, z);
            added.component_mul(&Vector3::new(cos, cos, sin)) * (self.transform(k) / PI)
        });
        self.on_half_space(x, z) + base
    }

    /// The same with walls at ±width/2: the sum over the load's images at every width, the infinite layer's stress falling
    /// as e^{−2.1|x|/H} beside a load.
    fn between_walls(&self, width: f64, depth: f64, x: f64, z: f64) -> Vector3<f64> {
        let images = (16.0 * depth / width).ceil() as i32 + 1;
        (-images..=images)
            .map(|image| self.on_layer(depth, x - width * f64::from(image), z))
            .sum()
    }

    /// The pressure on the surface, Pa; none beside the load and at the rim of a punch, where it has no bound.
    pub fn pressure(&self, s: f64) -> f64 {
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
    fn transform(&self, k: f64) -> f64 {
        let ka = k * self.half_width;
        match &self.shape {
            Shape::Uniform(pressure) => {
                let share = if ka < 1e-8 { 1.0 } else { ka.sin() / ka };
                2.0 * self.half_width * pressure * share
            }
            Shape::Punch { lines, .. } => {
                let term = |(t, force): &(f64, f64)| force * (ka * t).cos();
                lines.iter().map(term).sum()
            }
        }
    }

    /// F(w) = (1/π)∫p(s)/(w−s)ds and F′(w) at w = x + iz, z > 0, in Pa and Pa/m, in closed form.
    fn potential(&self, x: f64, z: f64) -> [Complex<f64>; 2] {
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

/// σ_zz in Pa under a uniform strip load by another route: Flamant's line load 2p/π·z³/((x−s)²+z²)² integrated
/// numerically over the strip.
pub fn strip_load(pressure: f64, half_width: f64, offset: f64, depth: f64) -> f64 {
    integrate(-half_width, half_width, 16, |s| {
        let square = (offset - s).powi(2) + depth * depth;
        2.0 * pressure / PI * depth.powi(3) / (square * square)
    })
}

/// Even Chebyshev polynomials in the pressure under a punch. A punch as wide as the layer is deep needs five
/// for a relative accuracy of 10⁻⁶.
const TERMS: usize = 8;
/// Places at which the punch's pressure is sampled for integrals over it.
const SAMPLES: usize = 4 * TERMS;

/// The coefficients under a punch: the surface sinks by the same everywhere under it. With −ln|x−s| the
/// half-space's answer to a line load and K(x−s) what the ground differs by,
/// ∫p(s)(−ln|x−s| + K(x−s))ds is constant. Chebyshev polynomials are the logarithm's own functions:
/// ∫T_n(t)(−ln|v−t|)/(π√(1−t²))dt = T_n(v)/n, ln 2 for n = 0. The rest is collocation.
fn punch(model: Model, load: Load) -> [f64; TERMS] {
    let mut coefficients = [0.0; TERMS];
    coefficients[0] = load.force();
    let Some(ground) = bounded(model) else {
        return coefficients;
    };
    let mut equations = DMatrix::zeros(TERMS, TERMS);
    let mut right = DVector::zeros(TERMS);
    for row in 0..TERMS {
        // Even in v, so half of it will do.
        let v = (PI * (2.0 * row as f64 + 1.0) / (4.0 * TERMS as f64)).cos();
        let kernel = |t| difference(ground, load.half_width * (v - t)) / SAMPLES as f64;
        let kernel: Vec<(f64, f64)> = samples().map(|t| (t, kernel(t))).collect();
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
    let term = |(index, c): (usize, &f64)| c * chebyshev(index, t);
    coefficients.iter().enumerate().map(term).sum()
}

/// Where the integrands below have fallen by e^{−45} they are zero.
const DECAY: f64 = 45.0;

/// The amplitudes of σ_zz, σ_xx (times cos kx) and σ_xz (times sin kx) at z under cos kx on the layer's surface, from
/// the even Airy function of a strip of 2H. Written in falling exponentials only.
fn of_layer(k: f64, depth: f64, z: f64) -> Vector3<f64> {
    let (kh, ky) = (k * depth, k * (depth - z));
    let (q, w) = ((-2.0 * kh).exp(), (-2.0 * ky).exp());
    let (sinh, cosh) = (-(-2.0 * kh).exp_m1(), 1.0 + q);
    let (sinh_y, cosh_y) = (-(-2.0 * ky).exp_m1(), 1.0 + w);
    let scale = (-k * z).exp() / (sinh * cosh + 4.0 * kh * q);
    scale
        * Vector3::new(
            (sinh + kh * cosh) * cosh_y - ky * sinh * sinh_y,
            (sinh - kh * cosh) * cosh_y + ky * sinh * sinh_y,
            kh * cosh * sinh_y - ky * sinh * cosh_y,
        )
}

/// The same of the half-space.
fn of_half_space(k: f64, z: f64) -> Vector3<f64> {
    let kz = k * z;
    (-kz).exp() * Vector3::new(1.0 + kz, 1.0 - kz, kz)
}

/// Depth and, between walls, width; none of the half-space, whose surface answers to a line load by the logarithm alone.
fn bounded(model: Model) -> Option<(f64, Option<f64>)> {
    match model {
        Model::HalfSpace => None,
        Model::Layer { depth } => Some((depth, None)),
        Model::Box { width, depth } => Some((depth, Some(width))),
    }
}

/// The surface's sinking at x beside a line load without its −ln|x|, up to a constant, in the same unit (2(1−ν²)/πE of
/// the force). Under cos kx it sinks by L(k)/k with L = (cosh 2kH − 1)/(sinh 2kH + 2kH), in the half-space
/// by 1/k, and −ln|x| is ∫(cos kx − e^{−k})/k dk up to a constant.
fn difference((depth, walls): (f64, Option<f64>), x: f64) -> f64 {
    // L(k) − 1.
    let less_than_open = |k: f64| {
        let kh = k * depth;
        let q = (-2.0 * kh).exp();
        let m = (-2.0 * kh).exp_m1();
        2.0 * q * (m - 2.0 * kh) / (-(-4.0 * kh).exp_m1() + 4.0 * kh * q)
    };
    let end = DECAY / (2.0 * depth);
    let Some(width) = walls else {
        let decay = |k: f64| (-2.0 * k * depth).exp();
        let integrand = |k: f64| (less_than_open(k) * (k * x).cos() + decay(k)) / k;
        return integrate(
            0.0,
            end,
            oscillations(end, x.abs() + 2.0 * depth),
            integrand,
        );
    };
    // Σ cos(2πmx/width)/m = −ln(2 sin(π|x|/width)); near the load that is −ln|x|.
    let angle = PI * x.abs() / width;
    let ratio = if angle < 1e-8 {
        1.0
    } else {
        angle.sin() / angle
    };
    let first = 2.0 * PI / width;
    let wall = |m: f64| less_than_open(m * first) * (m * first * x).cos() / m;
    let walls = (1..=(end / first).ceil() as u32).map(f64::from).map(wall);
    walls.sum::<f64>() - ratio.ln()
}

/// Panels from 0 to `end` that are no longer than half a wave of a length of `reach`.
fn oscillations(end: f64, reach: f64) -> u32 {
    (end * reach / PI).ceil() as u32
}

// A punch that has gone down by d presses nearer to the control points. Two bounds of what the ground beside and above its
// base does: nothing, so that the surface may be taken at d ([`beneath`]); or as much as an elastic body that fills the hole
// and is stuck to the base ([`within`]).

/// The ground under the depth d, which then is its surface: what lies above bears nothing.
pub fn beneath(model: Model, sunk: f64) -> Model {
    match model {
        Model::HalfSpace => Model::HalfSpace,
        Model::Layer { depth } => Model::Layer {
            depth: depth - sunk,
        },
        Model::Box { width, depth } => Model::Box {
            width,
            depth: depth - sunk,
        },
    }
}

/// σ_zz in Pa at (x, z), z from the surface, under a uniform strip load at the depth `sunk` inside the half-space: Melan's line
/// load (Melan 1932; in the form of Poulos and Davis 1974) summed over the strip. Depends on `poisson`, ν.
pub fn within(load: Load, sunk: f64, poisson: f64, x: f64, z: f64) -> f64 {
    let a = load.half_width;
    load.pressure * integrate(-a, a, 4, |s| melan(sunk, poisson, x - s, z))
}

/// σ_zz over the force of a line load at depth d, 1/m.
fn melan(d: f64, poisson: f64, x: f64, z: f64) -> f64 {
    let m = (1.0 - poisson) / poisson;
    let (near, far) = (x * x + (z - d).powi(2), x * x + (z + d).powi(2));
    let first = (z - d).powi(3) / (near * near)
        + (z + d) * ((z + d).powi(2) + 2.0 * d * z) / (far * far)
        - 8.0 * d * z * (d + z) * x * x / far.powi(3);
    let second = (z - d) / near + (3.0 * z + d) / far - 4.0 * z * x * x / (far * far);
    ((m + 1.0) / (2.0 * m) * first + (m - 1.0) / (4.0 * m) * second) / PI
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, wanted: f64, within: f64) {
        assert!(
            (found - wanted).abs() <= within,
            "{found} instead of {wanted}"
        );
    }

    const fn load(spread: Spread, pressure: f64, half_width: f64) -> Load {
        Load {
            spread,
            pressure,
            half_width,
        }
    }

    const UNIFORM: Load = load(Spread::Uniform, 44.4e3, 0.0225);
    const PUNCH: Load = load(Spread::RigidPunch, 44.4e3, 0.0225);
    /// As wide as the layers below are deep.
    const WIDE: Load = load(Spread::RigidPunch, 1.0, 1.0);
    const DEPTH: f64 = 0.46;
    const LAYER: Model = Model::Layer { depth: DEPTH };
    const BOX: Model = Model::Box {
        width: 1.0,
        depth: DEPTH,
    };

    /// Both loads on every ground.
    fn fields() -> impl Iterator<Item = (Model, Field)> {
        let models = [Model::HalfSpace, LAYER, BOX].into_iter();
        models.flat_map(|model| [UNIFORM, PUNCH].map(|load| (model, Field::new(model, load))))
    }

    const PLACES: [[f64; 2]; 5] = [
        [0.0, 0.11],
        [0.08, 0.11],
        [0.15, 0.11],
        [0.3, 0.3],
        [0.01, 0.45],
    ];

    fn largest_difference(a: Components, b: Components) -> f64 {
        let parts = [a.zz - b.zz, a.xx - b.xx, a.xz - b.xz];
        parts.into_iter().map(f64::abs).fold(0.0, f64::max)
    }

    /// Textbook form of the strip load: (p/π)(α + sinα cos(α+2β)) and so on, α the angle in which the load is seen and β from the
    /// vertical to its nearer edge (Newcastle, Fundamentals of Foundation Engineering, eqs. 3.10 to 3.12).
    #[test]
    fn the_strip_load_is_the_textbooks() {
        let field = Field::new(Model::HalfSpace, UNIFORM);
        for [x, z] in PLACES {
            let angle = |edge: f64| ((x - edge) / z).atan();
            let (far, near) = (angle(-0.0225), angle(0.0225));
            let alpha = far - near;
            let (sum, scale) = (alpha + 2.0 * near, 44.4e3 / PI);
            let stress = field.stress(x, z);
            close(stress.zz, scale * (alpha + alpha.sin() * sum.cos()), 1e-8);
            close(stress.xx, scale * (alpha - alpha.sin() * sum.cos()), 1e-8);
            close(stress.xz, scale * alpha.sin() * sum.sin(), 1e-8);
        }
    }

    /// p = P/(π√(a²−x²)) of a punch on a half-space, summed as line loads at x = a cos θ.
    #[test]
    fn the_punch_on_the_half_space_is_sadowskys() {
        let field = Field::new(Model::HalfSpace, PUNCH);
        close(field.pressure(0.0), 2.0 / PI * 44.4e3, 1e-6);
        for [x, z] in PLACES {
            let integral = |part: fn(f64, f64) -> f64| {
                integrate(0.0, PI, 20, |angle| {
                    let x = x - 0.0225 * angle.cos();
                    2.0 * 1998.0 / (PI * PI) * part(x, z) / (x * x + z * z).powi(2)
                })
            };
            let stress = field.stress(x, z);
            close(stress.zz, integral(|_, z| z.powi(3)), 1e-8);
            close(stress.xx, integral(|x, z| x * x * z), 1e-8);
            close(stress.xz, integral(|x, z| x * z * z), 1e-8);
        }
    }

    /// A line load on a layer with a smooth base, after Timoshenko and Goodier, Theory of Elasticity, article 24: the base bears
    /// 0.918 P/H under the load, 44 % more than the half-space there, and nothing at about 1.35 H beside it. Theirs are
    /// sums by hand; the integral is 0.9195.
    #[test]
    fn the_pressure_on_a_smooth_base_is_the_textbooks() {
        let narrow = load(Spread::Uniform, 1e6, 0.5e-6);
        let layer = Field::new(Model::Layer { depth: 1.0 }, narrow);
        close(layer.stress(0.0, 1.0).zz, 0.918, 2e-3);
        let open = Field::new(Model::HalfSpace, narrow);
        close(
            layer.stress(0.0, 1.0).zz / open.stress(0.0, 1.0).zz,
            1.44,
            5e-3,
        );
        assert!(layer.stress(1.33, 1.0).zz > 0.0 && layer.stress(1.36, 1.0).zz < 0.0);
    }

    #[test]
    fn a_deep_layer_is_the_half_space_and_a_wide_box_the_layer() {
        for load in [UNIFORM, PUNCH] {
            for [x, z] in PLACES {
                let at = |model| Field::new(model, load).stress(x, z);
                let error = |depth: f64| {
                    largest_difference(at(Model::Layer { depth }), at(Model::HalfSpace))
                };
                // What the base adds to σ_xx falls as force/depth, to the others faster.
                assert!(error(1e4) < 0.6 * load.force() / 1e4);
                assert!((error(1e3) / error(2e3) - 2.0).abs() < 0.01);
                let zz = at(Model::Layer { depth: 1e3 }).zz - at(Model::HalfSpace).zz;
                close(zz, 0.0, 1e-3);
                let (width, depth) = (20.0, DEPTH);
                let wide = at(Model::Box { width, depth });
                assert!(largest_difference(wide, at(LAYER)) < 1e-6);
            }
        }
    }

    #[test]
    fn smooth_planes_bear_no_shear_and_both_sides_are_alike() {
        for (model, field) in fields() {
            for [x, z] in PLACES {
                let (right, left) = (field.stress(x, z), field.stress(-x, z));
                close(right.zz, left.zz, 1e-7);
                close(right.xx, left.xx, 1e-7);
                close(right.xz, -left.xz, 1e-7);
                if model != Model::HalfSpace {
                    close(field.stress(x, DEPTH).xz, 0.0, 1e-7);
                }
                // The surface beside the load is free.
                let surface = field.stress(0.05 + x, 1e-9);
                close(surface.zz, 0.0, 1e-2);
                close(surface.xz, 0.0, 1e-2);
            }
            if model == BOX {
                close(field.stress(0.5, 0.11).xz, 0.0, 1e-7);
            }
        }
    }

    /// ∂σ_xx/∂x + ∂σ_xz/∂z = 0 and ∂σ_xz/∂x + ∂σ_zz/∂z = 0, and σ_xx + σ_zz is harmonic: equilibrium and compatibility.
    #[test]
    fn the_stresses_are_an_elastic_field() {
        for (_, field) in fields() {
            let h = 1e-3;
            for [x, z] in [[0.02, 0.11], [0.15, 0.2], [0.3, 0.4]] {
                let at = |i: f64, k: f64| field.stress(x + i * h, z + k * h);
                let [east, west, down, up] =
                    [at(1.0, 0.0), at(-1.0, 0.0), at(0.0, 1.0), at(0.0, -1.0)];
                let scale = 2.0 * h * 44.4e3;
                close((east.xx - west.xx + down.xz - up.xz) / scale, 0.0, 2e-3);
                close((east.xz - west.xz + down.zz - up.zz) / scale, 0.0, 2e-3);
                let sum = |stress: Components| stress.xx + stress.zz;
                let laplace = sum(east) + sum(west) + sum(down) + sum(up) - 4.0 * sum(at(0.0, 0.0));
                close(laplace / (h * h * 44.4e3), 0.0, 5e-3);
            }
        }
    }

    /// The box by another route: the cosine series of its load, with hyperbolic functions as they stand.
    #[test]
    fn the_images_are_the_cosine_series() {
        let field = Field::new(BOX, UNIFORM);
        for [x, z] in PLACES {
            let mut zz = UNIFORM.force();
            for m in 1..200 {
                let k = 2.0 * PI * f64::from(m);
                let (h, y) = (k * DEPTH, k * (DEPTH - z));
                let amplitude = 2.0 * 2.0 * 44.4e3 * (k * 0.0225).sin() / k;
                let shape = (h.sinh() + h * h.cosh()) * y.cosh() - y * h.sinh() * y.sinh();
                zz += amplitude * shape / (h.sinh() * h.cosh() + h) * (k * x).cos();
                if h > 300.0 {
                    break;
                }
            }
            close(field.stress(x, z).zz, zz, 1e-6);
        }
    }

    /// The surface under the punch is flat: its sinking by another route, from the pressure's transform and the layer's
    /// answer L(k)/k, against a half-space that is far deeper.
    #[test]
    fn a_punch_leaves_the_surface_flat() {
        let depth = 1.0;
        for model in [Model::Layer { depth }, Model::Box { width: 3.0, depth }] {
            let field = Field::new(model, WIDE);
            let ground = bounded(model).expect("not the half-space");
            // ∫p(s)(−ln|x−s| + K(x−s))ds with s = cos θ, the logarithm's singular point cut out on both sides alike.
            let sinking = |x: f64| {
                let density = |angle: f64| {
                    let s = f64::cos(angle);
                    field.pressure(s)
                        * angle.sin()
                        * (difference(ground, x - s) - (x - s).abs().ln())
                };
                let pole = x.acos();
                let (mut sum, mut from, mut to) = (0.0, pole, PI - pole);
                while from.max(to) > 1e-9 {
                    sum += integrate(pole - from, pole - 0.5 * from, 1, |angle| {
                        density(angle.max(1e-4))
                    });
                    sum += integrate(pole + 0.5 * to, pole + to, 1, |angle| {
                        density(angle.min(PI - 1e-4))
                    });
                    (from, to) = (0.5 * from, 0.5 * to);
                }
                sum
            };
            let middle = sinking(0.0);
            for x in [0.2, 0.55, 0.83, 0.97] {
                close(sinking(x) / middle, 1.0, 1e-5);
            }
            let force = integrate(0.0, PI, 10, |angle| {
                let inner = angle.clamp(1e-4, PI - 1e-4);
                field.pressure(inner.cos()) * inner.sin()
            });
            close(force, 2.0, 1e-6);
        }
    }

    #[test]
    fn a_load_at_the_surface_is_flamants() {
        let load = load(Spread::Uniform, 3.0, 0.2);
        for (x, z) in [(0.0, 0.1), (0.5, 0.3), (1.5, 2.0)] {
            for poisson in [0.1, 0.5] {
                let flamant = strip_load(3.0, 0.2, x, z);
                close(within(load, 0.0, poisson, x, z), flamant, 1e-7);
            }
        }
    }

    /// Every horizontal cut below the load carries all of it, and one above carries nothing; the surface is free.
    #[test]
    fn equilibrium_above_and_below() {
        for poisson in [0.1, 0.3, 0.5] {
            let carried = |z: f64| {
                // x = tan u: the tails fall as 1/x⁴ and 1/x².
                integrate(-0.5 * PI, 0.5 * PI, 2_000, |u| {
                    let x = u.tan();
                    melan(1.0, poisson, x, z) / u.cos().powi(2)
                })
            };
            close(carried(1.5), 1.0, 1e-4);
            close(carried(3.0), 1.0, 1e-4);
            close(carried(0.5), 0.0, 1e-4);
            for x in [0.0, 0.3, 2.0] {
                close(melan(1.0, poisson, x, 0.0), 0.0, 1e-14);
            }
        }
    }

    /// Deep inside, half of the force hangs above: Kelvin's line load, whose σ_zz on the axis is (3−2ν)/(4π(1−ν)r).
    #[test]
    fn deep_inside_it_is_kelvins() {
        for poisson in [0.0f64, 0.3, 0.5] {
            let nu = poisson.max(1e-9);
            let kelvin = (3.0 - 2.0 * nu) / (4.0 * PI * (1.0 - nu));
            close(melan(1e5, nu, 0.0, 1e5 + 1.0), kelvin, 1e-4);
            close(melan(1e5, nu, 0.0, 1e5 - 1.0), -kelvin, 1e-4);
        }
    }
}
