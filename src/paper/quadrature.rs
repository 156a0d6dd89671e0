//! Integration by Simpson's rule.

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
