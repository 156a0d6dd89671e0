//! Random numbers of the resampling: ChaCha8 under a named key, one stream a replicate, so that a replicate
//! does not depend on how many threads there are or in which order they come to it.

use chacha20::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

use super::in_parallel;

/// Key of the random numbers of one purpose.
pub type Key = [u8; 32];

/// The numbers of one replicate.
#[derive(Debug)]
pub struct Source(ChaCha8Rng);

impl Source {
    /// The numbers of this replicate under a key.
    pub fn new(key: &Key, replicate: u64) -> Self {
        let mut random = ChaCha8Rng::from_seed(*key);
        random.set_stream(replicate);
        Source(random)
    }

    /// Uniform in (0, 1), never an end: (k + ½)/2⁵³.
    pub fn uniform(&mut self) -> f64 {
        ((self.0.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    /// One of 0, 1, …, `count` − 1. The share of 64 bits that is lost to rounding is below count/2⁶⁴.
    pub fn below(&mut self, count: usize) -> usize {
        ((u128::from(self.0.next_u64()) * count as u128) >> 64) as usize
    }

    /// Standard exponential, −ln u.
    pub fn exponential(&mut self) -> f64 {
        -self.uniform().ln()
    }

    /// Standard normal (Box and Muller 1958; the second one is not kept).
    pub fn normal(&mut self) -> f64 {
        let radius = (2.0 * self.exponential()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }

    /// Gamma with scale 1 by squeezing a cubed normal (Marsaglia and Tsang 2000).
    pub fn gamma(&mut self, shape: f64) -> f64 {
        if shape < 1.0 {
            let power = self.uniform().ln() / shape;
            return self.gamma(shape + 1.0) * power.exp();
        }
        let depth = shape - 1.0 / 3.0;
        let width = 1.0 / (9.0 * depth).sqrt();
        loop {
            let normal = self.normal();
            let cube = (1.0 + width * normal).powi(3);
            if cube <= 0.0 {
                continue;
            }
            let limit = 0.5 * normal * normal + depth * (1.0 - cube + cube.ln());
            if self.uniform().ln() < limit {
                return depth * cube;
            }
        }
    }

    /// Puts the values into an order of which each is equally likely (Fisher and Yates).
    pub fn shuffle<T>(&mut self, values: &mut [T]) {
        for last in (1..values.len()).rev() {
            values.swap(last, self.below(last + 1));
        }
    }
}

/// `value(source)` for each of so many replicates, in their order, on all processors.
pub fn replicates<T: Send>(
    key: &Key,
    count: usize,
    value: impl Fn(&mut Source) -> T + Sync,
) -> Vec<T> {
    in_parallel(count, |replicate| {
        value(&mut Source::new(key, replicate as u64))
    })
}

/// Replicates at least as extreme as what was observed after which a p is known well enough, to a twentieth of itself.
const ENOUGH: usize = 400;
/// Replicates that are drawn before it is looked whether more are needed.
const BLOCK: usize = 2000;

/// The p of N statistics of what was observed, `extreme` saying of a replicate which of them are at least as extreme. Drawing ends
/// when each has had 400 such replicates, and p is then 400 over the number drawn up to the last of these; or after `most`, and p is
/// then (b + 1)/(most + 1), b the extreme ones. Either way a true statement has p ≤ x with probability x at most (Besag and
/// Clifford, Biometrika 78, 301, 1991), and no p is below 1/(most + 1).
pub fn p_values<const N: usize>(
    key: &Key,
    most: usize,
    extreme: impl Fn(&mut Source) -> [bool; N] + Sync,
) -> [f64; N] {
    let mut hits = [0; N];
    let mut found = [None; N];
    for start in (0..most).step_by(BLOCK) {
        let block = in_parallel(BLOCK.min(most - start), |replicate| {
            extreme(&mut Source::new(key, (start + replicate) as u64))
        });
        for (replicate, extremes) in (start..).zip(block) {
            for which in (0..N).filter(|which| extremes[*which]) {
                hits[which] += 1;
                if hits[which] == ENOUGH {
                    found[which] = Some(ENOUGH as f64 / (replicate + 1) as f64);
                }
            }
        }
        if found.iter().all(Option::is_some) {
            break;
        }
    }
    std::array::from_fn(|which| {
        found[which].unwrap_or((hits[which] + 1) as f64 / (most + 1) as f64)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::moments::{mean, standard_deviation};
    use crate::{assert_share, on_threads};

    const KEY: Key = *b"crossgrain: tests of the sources";

    #[test]
    fn threads_change_nothing() {
        let draw = |source: &mut Source| (source.uniform(), source.below(7), source.gamma(0.4));
        let on = |threads| on_threads(threads, 103, |at| draw(&mut Source::new(&KEY, at as u64)));
        let one = on(1);
        for threads in [2, 3, 8, 200] {
            assert_eq!(on(threads), one);
        }
        assert_eq!(replicates(&KEY, 103, draw), one);
        assert_ne!(one[0], one[1]);
        assert!(replicates(&KEY, 0, draw).is_empty());
    }

    /// A true statement is rejected as often as the level says, ended early or not; what is never seen gets the smallest p.
    #[test]
    fn sequential_p_keep_their_level() {
        let trials = 20_000;
        let found = replicates(&KEY, trials, |source| {
            let (observed, own) = (source.uniform(), source.below(1 << 60) as u64);
            let mut key = KEY;
            key[..8].copy_from_slice(&own.to_le_bytes());
            let [p] = p_values(&key, 1999, |drawn| [drawn.uniform() >= observed]);
            p
        });
        for level in [0.5, 0.05, 0.001] {
            assert_share(found.iter().map(|p| *p <= level), 0.999, level);
        }
        assert_eq!(p_values(&KEY, 4999, |_| [false, true]), [2.0e-4, 1.0]);
    }

    /// Mean and deviation of each law within five standard errors, n = 2·10⁵.
    #[test]
    fn laws_have_their_moments() {
        let mut source = Source::new(&KEY, 1);
        type Draw = fn(&mut Source) -> f64;
        let laws: [(Draw, f64, f64); 5] = [
            (Source::uniform, 0.5, 1.0 / 12.0f64.sqrt()),
            (Source::exponential, 1.0, 1.0),
            (Source::normal, 0.0, 1.0),
            (|source| source.gamma(0.5), 0.5, 0.5f64.sqrt()),
            (|source| source.gamma(3.0), 3.0, 3.0f64.sqrt()),
        ];
        for (law, centre, spread) in laws {
            let values: Vec<f64> = (0..200_000).map(|_| law(&mut source)).collect();
            let error = spread / (values.len() as f64).sqrt();
            assert!((mean(&values) - centre).abs() < 5.0 * error);
            assert!((standard_deviation(&values) / spread - 1.0).abs() < 0.02);
        }
    }

    #[test]
    fn every_order_is_equally_likely() {
        let mut source = Source::new(&KEY, 2);
        let mut counts = std::collections::BTreeMap::new();
        for _ in 0..6000 {
            let mut order = [0, 1, 2];
            source.shuffle(&mut order);
            *counts.entry(order).or_insert(0) += 1;
        }
        assert_eq!(counts.len(), 6);
        assert!(counts.values().all(|count| (850..1150).contains(count)));
    }
}
