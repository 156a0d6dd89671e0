//! The law of Kolmogorov's distance D of n values from a law that was known beforehand.

use nalgebra::{DMatrix, DVector};

/// Numbers are kept below this by taking out powers of ten.
const LARGE: f64 = 1.0e140;
const EXPONENT: i32 = 140;

/// The probability of a distance of at least `distance` for `count` values: exact, by the matrix power of
/// Marsaglia, Tsang and Wang (2003), to about 13 digits of 1 − p; in the far tail, nD² > 7.24 or > 3.76 for
/// n > 99, by their formula 2 exp(−(2.000071 + 0.331/√n + 1.409/n) nD²), good to seven decimals.
///
/// Not for parameters that were fitted to the values: see [`super::goodness::fitted`].
pub fn p_value(distance: f64, count: usize) -> f64 {
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

    /// D = 0.274 of ten values is the example of Marsaglia, Tsang and Wang, P(D < d) = 0.628480; the others
    /// are `scipy.stats.kstwo.sf` 1.17.1, which approximates for more than 140 values.
    #[test]
    fn known_values() {
        for (distance, count, wanted, tolerance) in [
            (0.274, 10, 0.371_520_384_543_495_7, 1.0e-12),
            (0.1, 100, 0.252_692_757_006_387_4, 1.0e-12),
            (0.04, 1000, 0.079_339_560_590_002_2, 1.0e-7),
            (0.03, 1000, 0.322_690_214_391_463_6, 1.0e-7),
            (0.05, 50, 0.999_023_809_846_183_8, 1.0e-12),
            (0.2, 170, 1.951e-6, 1.0e-7),
            (0.1, 1000, 3.704e-9, 1.0e-9),
        ] {
            let found = p_value(distance, count);
            assert!(
                (found - wanted).abs() < tolerance,
                "{distance} {count} {found}"
            );
        }
        // The 5 % point of many values is 1.358/√n.
        assert!((p_value(1.3581 / 5000.0f64.sqrt(), 5000) - 0.05).abs() < 0.001);
    }

    #[test]
    fn ends() {
        assert_eq!(p_value(0.0, 10), 1.0);
        assert_eq!(p_value(0.05, 10), 1.0);
        assert_eq!(p_value(1.0, 10), 0.0);
        assert!(p_value(f64::NAN, 10).is_nan());
        assert!(p_value(0.1, 0).is_nan());
    }
}
