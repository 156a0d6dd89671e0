//! The largest eigenvalue of a network by Lanczos iteration, and the largest stable step from it.
//!
//! The engines step x_{n+1} − 2x_n + x_{n−1} + dt M⁻¹C (x_n − x_{n−1}) + dt² M⁻¹K x_n = 0: leapfrog,
//! with velocities half a step behind in the dashpots. A solution that turns its sign with every step,
//! x_n = (−1)ⁿ u, has (dt² K + 2dt C) u = 4 M u. K and C are symmetric and not negative, so below the
//! smallest such dt every mode is bounded (Jury's conditions on λ² − (2 − c − k) λ + 1 − c with k + 2c < 4),
//! and above it this one grows: the limit is where the largest eigenvalue of
//! M^(−1/2)(dt² K + 2dt C)M^(−1/2) is 4. Without dashpots that is dt = 2/ω_max; for one oscillator it is
//! dt = (2/ω)(√(1+ζ²) − ζ).
//!
//! Cundall damping scales each component of the acceleration by 1 + α where it brakes and 1 − α where it
//! drives. Where the velocity turns its sign with every step the braking factor rules, for each
//! component, so the same mode u grows from (dt² K + 2dt C) u = 4/(1+α) M u on. That is a necessary condition;
//! that no other motion grows at a smaller step is measured, not proved.

use nalgebra::{DMatrix, SymmetricEigen};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

use super::network::{Matrix, Network};

/// Relative error of the largest eigenvalue at which iteration ends.
const TOLERANCE: f64 = 1.0e-6;
/// The same where the vector is what is wanted: it is a square root less exact than the value.
const OF_VECTOR: f64 = 1.0e-10;
/// The most Lanczos vectors; a bed of 5,000 grains takes about a hundred.
const MOST_VECTORS: usize = 600;
/// The small matrix is looked at every so many vectors.
const LOOK_EVERY: usize = 10;
/// Rounds of refining the step with dashpots; each squares the error.
const MOST_ROUNDS: usize = 60;

/// The largest eigenvalue and its vector.
#[derive(Debug, Clone, PartialEq)]
pub struct Top {
    /// In s⁻² for the stiffness.
    pub value: f64,
    /// Unit vector, in coordinates weighted by √mass.
    pub vector: Vec<f64>,
    /// Bound of the error of `value` by the residual, the same unit.
    pub residual: f64,
    /// Lanczos vectors that it took.
    pub vectors: usize,
}

/// The largest stable step of a network.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// s; infinite where nothing touches.
    pub dt: f64,
    /// ω_max of the springs alone, rad/s.
    pub omega: f64,
    /// Lanczos vectors that it took, over all rounds.
    pub vectors: usize,
    /// Relative bound of the error of the last eigenvalue.
    pub residual: f64,
}

/// The largest eigenvalue of M^(−1/2)(stiffness·K + damping·C)M^(−1/2). Lanczos from a fixed random vector,
/// without reorthogonalisation: what rounding brings back are copies of eigenvalues, which do no harm
/// to the largest one.
pub fn top(network: &Network, stiffness: f64, damping: f64) -> Top {
    lanczos(network, stiffness, damping, TOLERANCE)
}

/// The mode that first turns its sign with every step, with Cundall's α.
pub fn fastest_mode(network: &Network, alpha: f64) -> Vec<f64> {
    let dt = limit(network, alpha).dt;
    lanczos(network, dt * dt, 2.0 * dt, OF_VECTOR).vector
}

fn lanczos(network: &Network, stiffness: f64, damping: f64, tolerance: f64) -> Top {
    let size = network.freedoms();
    let mut basis = vec![start(network, size)];
    let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
    let mut w = vec![0.0; size];
    loop {
        let at = diagonal.len();
        let newest = &basis[at];
        network.apply(stiffness, damping, newest, &mut w);
        let along = dot(&w, newest);
        for (w, v) in w.iter_mut().zip(newest) {
            *w -= along * v;
        }
        if let Some(before) = at.checked_sub(1).map(|before| &basis[before]) {
            let back: f64 = beside[at - 1];
            for (w, v) in w.iter_mut().zip(before) {
                *w -= back * v;
            }
        }
        diagonal.push(along);
        let rest = dot(&w, &w).sqrt();
        let scale = diagonal.iter().copied().fold(0.0, f64::max);
        // Nothing is left: the vectors span all that the start has a share in.
        let whole = rest <= 1.0e-13 * scale || rest == 0.0;
        let enough = diagonal.len() >= MOST_VECTORS;
        if whole || enough || diagonal.len().is_multiple_of(LOOK_EVERY) {
            let (value, of_basis) = ritz(&diagonal, &beside);
            let residual = rest * of_basis.last().copied().unwrap_or(0.0).abs();
            if whole || enough || residual <= tolerance * value {
                let mut vector = vec![0.0; size];
                for (share, of) in of_basis.iter().zip(&basis) {
                    for (sum, v) in vector.iter_mut().zip(of) {
                        *sum += share * v;
                    }
                }
                let length = dot(&vector, &vector).sqrt();
                if length > 0.0 {
                    vector.iter_mut().for_each(|v| *v /= length);
                }
                return Top {
                    value,
                    vector,
                    residual,
                    vectors: diagonal.len(),
                };
            }
        }
        beside.push(rest);
        basis.push(w.iter().map(|w| w / rest).collect());
    }
}

/// The largest stable step, with Cundall's α: the smallest dt at which the largest eigenvalue of
/// M^(−1/2)(dt² K + 2dt C)M^(−1/2) is 4/(1+α).
///
/// With dashpots the step is found from above: of any vector, dt² k + 2dt c = 4/(1+α) with
/// k and c its shares of K and C has a solution that is no smaller than the limit.
pub fn limit(network: &Network, alpha: f64) -> Limit {
    let wanted = 4.0 / (1.0 + alpha);
    let springs = top(network, 1.0, 0.0);
    let omega = springs.value.max(0.0).sqrt();
    let mut limit = Limit {
        dt: wanted.sqrt() / omega,
        omega,
        vectors: springs.vectors,
        residual: springs.residual / springs.value,
    };
    if !network.has_dashpots() || omega == 0.0 {
        return limit;
    }
    for _ in 0..MOST_ROUNDS {
        let found = top(network, limit.dt * limit.dt, 2.0 * limit.dt);
        limit.vectors += found.vectors;
        limit.residual = found.residual / found.value;
        let k = network.form(Matrix::Stiffness, &found.vector);
        let c = network.form(Matrix::Damping, &found.vector);
        // The root of k dt² + 2c dt − wanted, in the form that does not cancel.
        let dt = wanted / (c + (c * c + k * wanted).sqrt());
        let change = (limit.dt - dt) / dt;
        limit.dt = dt;
        if change.abs() < TOLERANCE {
            break;
        }
    }
    limit
}

/// The largest eigenvalue of the small tridiagonal matrix, and its vector.
fn ritz(diagonal: &[f64], beside: &[f64]) -> (f64, Vec<f64>) {
    let size = diagonal.len();
    let matrix = DMatrix::from_fn(size, size, |i, j| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => beside[i.min(j)],
        _ => 0.0,
    });
    let eigen = SymmetricEigen::new(matrix);
    let values = eigen.eigenvalues.iter().copied().enumerate();
    let (at, value) = values
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((0, 0.0));
    (
        value,
        eigen.eigenvectors.column(at).iter().copied().collect(),
    )
}

/// A random unit vector on the degrees of freedom that move, always the same.
fn start(network: &Network, size: usize) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(size as u64);
    let mut vector: Vec<f64> = (0..size)
        .map(|at| {
            let share = symmetric(&mut random);
            if network.moves(at) { share } else { 0.0 }
        })
        .collect();
    let length = dot(&vector, &vector).sqrt();
    if length > 0.0 {
        vector.iter_mut().for_each(|v| *v /= length);
    }
    vector
}

/// Uniform in [−1, 1).
pub(super) fn symmetric(random: &mut ChaCha8Rng) -> f64 {
    let bits = random.next_u64() >> 11;
    bits as f64 * (2.0 / (1u64 << 53) as f64) - 1.0
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
