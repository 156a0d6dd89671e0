//! A deliberate slowness: the same steps, to the bit, in a multiple of their time. A job proves with it that it would notice a
//! slower kernel. Where it is not asked for it costs nothing.

use std::time::Instant;

/// Makes the time since it last did so longer.
#[derive(Debug)]
pub struct Slowness {
    factor: f64,
    since: Instant,
}

impl Slowness {
    /// From now on everything takes `factor` times as long; below 1 is 1.
    pub fn new(factor: f64) -> Self {
        Slowness {
            factor,
            since: Instant::now(),
        }
    }

    /// Works on nothing for as long as is missing, so that wall time and processor time both grow.
    pub fn stretch(&mut self) {
        let wanted = self.since.elapsed().mul_f64(self.factor.max(1.0));
        while self.since.elapsed() < wanted {
            std::hint::spin_loop();
        }
        self.since = Instant::now();
    }
}
