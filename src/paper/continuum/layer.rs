//! A layer on a rigid smooth base, by Fourier's integral, and between rigid smooth walls.
//!
//! A smooth rigid plane is a plane of symmetry. So the layer is the upper half of one twice as deep that is
//! loaded from below as well, and the walls are mirrors that repeat the load at every width. Then tractions
//! are given everywhere, no displacement is, and the stress of such a plane problem does not depend on the
//! elastic constants (Michell).

use std::f64::consts::PI;
use std::sync::LazyLock;

use super::Model;
use super::half_space;
use super::pressure::Pressure;
use crate::paper::quadrature::{Node, gauss_legendre};

static RULE: LazyLock<Vec<Node>> = LazyLock::new(|| gauss_legendre(16));

/// Where the integrands below have fallen by e^{−45} they are zero.
const DECAY: f64 = 45.0;

/// [σ_zz, σ_xx, σ_xz] in Pa: the half-space's in closed form, and a smooth integral for what the base adds.
pub(super) fn stress(pressure: &Pressure, depth: f64, x: f64, z: f64) -> [f64; 3] {
    let mut stress = half_space::stress(pressure, x, z);
    // What the base adds comes from its depth and goes on to z: e^{−k(2H−z)}.
    let end = DECAY / (2.0 * depth - z);
    let panels = oscillations(end, x.abs() + pressure.half_width() + 2.0 * depth);
    for (k, weight) in places(end, panels) {
        let transform = weight * pressure.transform(k) / PI;
        let [layer, open] = [of_layer(k, depth, z), of_half_space(k, z)];
        let (sin, cos) = (k * x).sin_cos();
        for (index, wave) in [cos, cos, sin].into_iter().enumerate() {
            stress[index] += transform * wave * (layer[index] - open[index]);
        }
    }
    stress
}

/// The same with walls at ±width/2: the sum over the load's images at every width, the infinite layer's stress falling
/// as e^{−2.1|x|/H} beside a load.
pub(super) fn between_walls(
    pressure: &Pressure,
    width: f64,
    depth: f64,
    x: f64,
    z: f64,
) -> [f64; 3] {
    let images = (16.0 * depth / width).ceil() as i32 + 1;
    let mut sum = [0.0; 3];
    for image in -images..=images {
        let of_image = stress(pressure, depth, x - width * f64::from(image), z);
        for (total, part) in sum.iter_mut().zip(of_image) {
            *total += part;
        }
    }
    sum
}

/// The amplitudes of σ_zz, σ_xx (times cos kx) and σ_xz (times sin kx) at z under cos kx on the layer's surface, from
/// the even Airy function of a strip of 2H. Written in falling exponentials only.
fn of_layer(k: f64, depth: f64, z: f64) -> [f64; 3] {
    let (kh, ky) = (k * depth, k * (depth - z));
    let (q, w) = ((-2.0 * kh).exp(), (-2.0 * ky).exp());
    let (sinh, cosh) = (-(-2.0 * kh).exp_m1(), 1.0 + q);
    let (sinh_y, cosh_y) = (-(-2.0 * ky).exp_m1(), 1.0 + w);
    let scale = (-k * z).exp() / (sinh * cosh + 4.0 * kh * q);
    [
        scale * ((sinh + kh * cosh) * cosh_y - ky * sinh * sinh_y),
        scale * ((sinh - kh * cosh) * cosh_y + ky * sinh * sinh_y),
        scale * (kh * cosh * sinh_y - ky * sinh * cosh_y),
    ]
}

/// The same of the half-space.
fn of_half_space(k: f64, z: f64) -> [f64; 3] {
    let kz = k * z;
    let fall = (-kz).exp();
    [(1.0 + kz) * fall, (1.0 - kz) * fall, kz * fall]
}

/// How the surface answers to a line load.
pub(super) struct Answer {
    depth: f64,
    walls: Option<f64>,
}

impl Answer {
    /// None for the half-space, whose answer is the logarithm alone.
    pub fn of(model: Model) -> Option<Self> {
        match model {
            Model::HalfSpace => None,
            Model::Layer { depth } => Some(Answer { depth, walls: None }),
            Model::Box { width, depth } => Some(Answer {
                depth,
                walls: Some(width),
            }),
        }
    }

    /// The surface's sinking at x beside a line load without its −ln|x|, up to a constant, in the same unit (2(1−ν²)/πE of
    /// the force). Under cos kx it sinks by L(k)/k with L = (cosh 2kH − 1)/(sinh 2kH + 2kH), in the half-space
    /// by 1/k, and −ln|x| is ∫(cos kx − e^{−k})/k dk up to a constant.
    pub fn difference(&self, x: f64) -> f64 {
        let end = DECAY / (2.0 * self.depth);
        match self.walls {
            None => {
                let of = |k: f64| {
                    (self.less_than_open(k) * (k * x).cos() + (-2.0 * k * self.depth).exp()) / k
                };
                let panels = oscillations(end, x.abs() + 2.0 * self.depth);
                places(end, panels).map(|(k, weight)| weight * of(k)).sum()
            }
            Some(width) => {
                // Σ cos(2πmx/width)/m = −ln(2 sin(π|x|/width)); near the load that is −ln|x|.
                let angle = PI * x.abs() / width;
                let ratio = if angle < 1e-8 {
                    1.0
                } else {
                    angle.sin() / angle
                };
                let first = 2.0 * PI / width;
                let walls: f64 = (1..=(end / first).ceil() as u32)
                    .map(f64::from)
                    .map(|m| self.less_than_open(m * first) * (m * first * x).cos() / m)
                    .sum();
                walls - ratio.ln()
            }
        }
    }

    /// L(k) − 1.
    fn less_than_open(&self, k: f64) -> f64 {
        let kh = k * self.depth;
        let q = (-2.0 * kh).exp();
        let m = (-2.0 * kh).exp_m1();
        2.0 * q * (m - 2.0 * kh) / (-(-4.0 * kh).exp_m1() + 4.0 * kh * q)
    }
}

/// Panels from 0 to `end` that are no longer than half a wave of a length of `reach`.
fn oscillations(end: f64, reach: f64) -> u32 {
    (end * reach / PI).ceil() as u32
}

/// Places and weights from 0 to `end`.
fn places(end: f64, panels: u32) -> impl Iterator<Item = (f64, f64)> {
    let half = 0.5 * end / f64::from(panels);
    (0..panels).flat_map(move |panel| {
        let middle = half * (2.0 * f64::from(panel) + 1.0);
        RULE.iter()
            .map(move |node| (middle + half * node.place, half * node.weight))
    })
}
