//! Sections 3.3 and 5: the exponential law, and sums of it. Recomputed by convolving the law with
//! itself on a grid.

use statrs::distribution::{ContinuousCDF, Erlang};

use super::Number;
use crate::paper::quadrature::integrate;

/// Grid step over the mean.
const STEP: f64 = 0.01;
/// Length of the grid over the mean.
const LENGTH: f64 = 60.0;

/// Weights of the exponential law of mean 1 on the grid, each from its own stretch.
fn exponential() -> Vec<f64> {
    let count = (LENGTH / STEP) as usize;
    (0..count)
        .map(|index| (-STEP * index as f64).exp() * -(-STEP).exp_m1())
        .collect()
}

/// Weights of the sum of `terms` independent draws on the grid.
fn sum_of(terms: u32) -> Vec<f64> {
    let one = exponential();
    let mut sum = one.clone();
    for _ in 1..terms {
        let mut next = vec![0.0; one.len()];
        for (index, weight) in sum.iter().enumerate() {
            if *weight < 1e-18 {
                continue;
            }
            for (of_next, of_one) in next[index..].iter_mut().zip(&one) {
                *of_next += weight * of_one;
            }
        }
        sum = next;
    }
    sum
}

/// Mean and standard deviation of a sum of `terms` draws, each at its stretch's middle.
fn moments(sum: &[f64], terms: u32) -> (f64, f64) {
    let middle = 0.5 * f64::from(terms);
    let place = |index: usize| STEP * (index as f64 + middle);
    let mean: f64 = sum.iter().enumerate().map(|(i, w)| place(i) * w).sum();
    let variance: f64 = sum
        .iter()
        .enumerate()
        .map(|(i, w)| (place(i) - mean).powi(2) * w)
        .sum();
    (mean, variance.sqrt())
}

/// The numbers of sections 3.3 and 5.
pub fn numbers() -> Vec<Number> {
    let density = |x: f64| (-x).exp();
    let quadrature = "numerical integration of the density";
    // The grid's own error is a few parts in a hundred thousand.
    let grid = 1e-4;
    let mut numbers = vec![
        Number::new(
            "Eq. 7, section 3.3",
            "integral of the density",
            1.0,
            1e-9,
            integrate(0.0, LENGTH, 20_000, density),
            "1",
            quadrature,
        ),
        Number::new(
            "Eq. 7, section 3.3",
            "mean over μ",
            1.0,
            1e-9,
            integrate(0.0, LENGTH, 20_000, |x| x * density(x)),
            "1",
            quadrature,
        ),
    ];
    for terms in [2u32, 5, 10] {
        let sum = sum_of(terms);
        let (mean, deviation) = moments(&sum, terms);
        let how = format!("convolving the exponential law with itself, N = {terms}");
        let count = f64::from(terms);
        numbers.push(Number::new(
            "section 5",
            &format!("mean over Vσ of {terms} cells"),
            1.0,
            grid,
            mean / count,
            "1",
            &how,
        ));
        numbers.push(Number::new(
            "section 5",
            &format!("variance over (Vσ)² of {terms} cells, printed 1/N"),
            1.0 / count,
            grid,
            (deviation / count).powi(2),
            "1",
            &how,
        ));
        numbers.push(Number::new(
            "section 5",
            &format!("coefficient of variation of {terms} cells, printed 1/√N"),
            1.0 / count.sqrt(),
            grid,
            deviation / mean,
            "1",
            &how,
        ));
        // The grid knows the chance of ending before a whole step; half a stretch a term is added back.
        let steps = ((count / STEP) - 0.5 * count) as usize;
        let below: f64 = sum[..steps].iter().sum();
        numbers.push(Number::new(
            "section 5",
            &format!("chance that {terms} cells have less than their mean, printed Erlang(N)"),
            Erlang::new(u64::from(terms), 1.0).map_or(f64::NAN, |law| law.cdf(count)),
            2e-3,
            below,
            "1",
            &how,
        ));
    }
    numbers
}
