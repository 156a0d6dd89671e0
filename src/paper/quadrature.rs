//! Numerical integration by the Gauss-Legendre rule.

use std::f64::consts::PI;
use std::iter::Sum;
use std::ops::Mul;
use std::sync::LazyLock;

/// Points of the rule on each panel.
const ORDER: usize = 16;

/// Places in [−1, 1] and their weights: the roots x of the Legendre polynomial P by Newton's method, with 2/((1−x²)P′²).
static RULE: LazyLock<[[f64; 2]; ORDER]> = LazyLock::new(|| {
    std::array::from_fn(|index| {
        // Near enough to its root that Newton's method takes no other.
        let mut x = (PI * (index as f64 + 0.75) / (ORDER as f64 + 0.5)).cos();
        // It doubles the digits each time.
        for _ in 0..8 {
            let [value, slope] = legendre(x);
            x -= value / slope;
        }
        let [_, slope] = legendre(x);
        [x, 2.0 / ((1.0 - x * x) * slope * slope)]
    })
});

/// The Legendre polynomial of this order and its slope at x, |x| < 1.
fn legendre(x: f64) -> [f64; 2] {
    let (mut before, mut value) = (1.0, x);
    for k in 2..=ORDER {
        let k = k as f64;
        let next = ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k;
        (before, value) = (value, next);
    }
    let slope = ORDER as f64 * (x * value - before) / (x * x - 1.0);
    [value, slope]
}

/// ∫ f from `from` to `to`, of numbers, vectors or matrices, with sixteen points on each of so many panels. The ends are
/// not asked for.
pub fn integrate<T>(from: f64, to: f64, panels: u32, f: impl Fn(f64) -> T) -> T
where
    T: Mul<f64, Output = T> + Sum<T>,
{
    let half = 0.5 * (to - from) / f64::from(panels);
    (0..panels)
        .flat_map(|panel| {
            let middle = from + half * (2.0 * f64::from(panel) + 1.0);
            RULE.iter()
                .map(move |[place, weight]| (middle + half * place, half * weight))
        })
        .map(|(x, weight)| f(x) * weight)
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_up_to_order_31_are_exact_and_others_nearly() {
        for power in 0..32 {
            let exact = (3f64.powi(power + 1) - 1.0) / f64::from(power + 1);
            let found = integrate(1.0, 3.0, 1, |x| x.powi(power));
            assert!((found / exact - 1.0).abs() < 1e-13, "{power}: {found}");
        }
        assert!((integrate(0.0, 60.0, 60, |x| (-x).exp()) - 1.0).abs() < 1e-14);
        assert!((integrate(0.0, PI, 3, f64::sin) - 2.0).abs() < 1e-14);
    }
}
