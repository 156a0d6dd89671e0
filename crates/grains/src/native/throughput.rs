//! The operations of a step alone, in the vector lanes that it is compiled for: how fast this machine can do them.

use multiversion::multiversion;

/// 1.5 over each number.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
pub fn divide(numbers: &[f64], out: &mut [f64]) {
    for (out, number) in out.iter_mut().zip(numbers) {
        *out = 1.5 / number;
    }
}

/// The root of each number.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
pub fn square_root(numbers: &[f64], out: &mut [f64]) {
    for (out, number) in out.iter_mut().zip(numbers) {
        *out = number.sqrt();
    }
}

/// Additions and multiplications of [`add_and_multiply`] for each number.
pub const OPERATIONS: usize = 16;

/// Half as many additions and multiplications, never fused; of a multiple of 64 numbers.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
pub fn add_and_multiply(numbers: &[f64], out: &mut [f64]) {
    // Several vectors side by side, so that no operation waits for the one before it.
    for (out, numbers) in out.chunks_exact_mut(64).zip(numbers.chunks_exact(64)) {
        let mut values = [0.0; 64];
        values.copy_from_slice(numbers);
        for _ in 0..OPERATIONS / 2 {
            for value in &mut values {
                *value = *value * 0.999 + 0.001;
            }
        }
        out.copy_from_slice(&values);
    }
}

/// The sum of a multiple of 64 numbers, which are read once.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
pub fn sum(words: &[f64]) -> f64 {
    let mut lanes = [0.0; 64];
    for chunk in words.chunks_exact(64) {
        for (lane, word) in lanes.iter_mut().zip(chunk) {
            *lane += word;
        }
    }
    lanes.iter().sum()
}
