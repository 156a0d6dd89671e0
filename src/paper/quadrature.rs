//! Integration by Simpson's rule, and by Gauss-Legendre rules for smooth tensors.

use std::f64::consts::PI;

use nalgebra::Matrix2;

/// ∫ f from `from` to `to` with `pieces` parabolas.
pub fn integrate(from: f64, to: f64, pieces: u32, f: impl Fn(f64) -> f64) -> f64 {
    let half = (to - from) / (2.0 * f64::from(pieces));
    let at = |index: u32| f(from + half * f64::from(index));
    let mut sum = at(0) + at(2 * pieces);
    for index in 1..2 * pieces {
        sum += at(index) * if index % 2 == 1 { 4.0 } else { 2.0 };
    }
    sum * half / 3.0
}

/// A place in [−1, 1] and its weight.
#[derive(Debug, Clone, Copy)]
pub struct Node {
    /// In [−1, 1].
    pub place: f64,
    /// Its share of the interval's length 2.
    pub weight: f64,
}

/// The Gauss-Legendre rule of `order` points: the roots x of the Legendre polynomial P by Newton's
/// method, with weights 2/((1−x²)P′²).
pub fn gauss_legendre(order: usize) -> Vec<Node> {
    let n = order as f64;
    (0..order)
        .map(|index| {
            // Near enough to its root that Newton's method takes no other.
            let mut x = (PI * (index as f64 + 0.75) / (n + 0.5)).cos();
            // It doubles the digits each time.
            for _ in 0..8 {
                let [value, slope] = legendre(order, x);
                x -= value / slope;
            }
            let [_, slope] = legendre(order, x);
            Node {
                place: x,
                weight: 2.0 / ((1.0 - x * x) * slope * slope),
            }
        })
        .collect()
}

/// The Legendre polynomial of `order` (at least 1) and its slope at x, |x| < 1.
fn legendre(order: usize, x: f64) -> [f64; 2] {
    let (mut before, mut value) = (1.0, x);
    for k in 2..=order {
        let k = k as f64;
        let next = ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k;
        (before, value) = (value, next);
    }
    let slope = order as f64 * (x * value - before) / (x * x - 1.0);
    [value, slope]
}

/// ∫ f from `from` to `to` by this rule.
pub fn sum_over(
    rule: &[Node],
    from: f64,
    to: f64,
    f: impl Fn(f64) -> Matrix2<f64>,
) -> Matrix2<f64> {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    rule.iter()
        .map(|node| half * node.weight * f(middle + half * node.place))
        .sum()
}
