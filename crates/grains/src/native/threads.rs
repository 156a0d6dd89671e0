//! One bed on several threads. Each has a range of places of its own, for which alone it writes; what it reads of other ranges
//! nobody writes meanwhile. A grain's sum is made by one thread in the order of numbers, so the bits are those of one thread.

use std::sync::Arc;

use rayon_core::{ThreadPool, ThreadPoolBuilder, join};

/// How many threads may compute a bed. A bed that is too small for several has one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Threads {
    /// At most so many.
    pub most: usize,
    /// Each has at least so many grains.
    pub grains_each: usize,
}

/// Below it a step is so short that meeting costs more than sharing saves.
const GRAINS_EACH: usize = 10_000;

impl Threads {
    /// As many as this where the bed is big enough.
    pub fn at_most(most: usize) -> Self {
        Threads {
            most,
            grains_each: GRAINS_EACH,
        }
    }

    /// For so many grains.
    pub fn of(self, grains: usize) -> usize {
        let worth = grains / self.grains_each.max(1);
        worth.min(self.most).max(1)
    }
}

impl Default for Threads {
    /// One, whatever the size: studies have a bed a core.
    fn default() -> Self {
        Threads::at_most(1)
    }
}

/// The threads of one bed; none but the caller's for one.
#[derive(Clone)]
pub struct Team {
    pool: Option<Arc<ThreadPool>>,
}

impl Team {
    /// So many threads; they end with it. Where the system gives none, the caller's does all the work.
    pub fn new(threads: usize) -> Self {
        let builder = ThreadPoolBuilder::new().num_threads(threads);
        let builder = builder.thread_name(|_| "bed".to_owned());
        let pool = (threads > 1).then(|| builder.build().ok().map(Arc::new));
        Team {
            pool: pool.flatten(),
        }
    }

    /// Does the work on these threads, so that [`each`] finds them.
    pub fn together<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }
}

/// Does the work for every range, each with its first place, with its part of what is by place, beside each other, and puts
/// the results together in their order. Nothing is allocated.
pub fn each<I: Send, T: ByPlace, R: Send>(
    ranges: &mut [I],
    first: fn(&I) -> usize,
    data: T,
    work: &(impl Fn(&mut I, T) -> R + Sync),
    both: &(impl Fn(R, R) -> R + Sync),
) -> R {
    if let [range] = ranges {
        return work(range, data);
    }
    let (left, right) = ranges.split_at_mut(ranges.len() / 2);
    let places = first(&right[0]) - first(&left[0]);
    let (of_left, of_right) = data.split(places);
    let (left, right) = join(
        || each(left, first, of_left, work, both),
        || each(right, first, of_right, work, both),
    );
    both(left, right)
}

/// What has an entry for each place, or none at all.
pub trait ByPlace: Send {
    /// Those of the first places and the others.
    fn split(self, places: usize) -> (Self, Self)
    where
        Self: Sized;
}

impl ByPlace for () {
    fn split(self, _: usize) -> ((), ()) {
        ((), ())
    }
}

impl<T: Sync> ByPlace for &[T] {
    fn split(self, places: usize) -> (Self, Self) {
        self.split_at(places.min(self.len()))
    }
}

impl<T: Send> ByPlace for &mut [T] {
    fn split(self, places: usize) -> (Self, Self) {
        self.split_at_mut(places.min(self.len()))
    }
}

impl<A: ByPlace, B: ByPlace> ByPlace for (A, B) {
    fn split(self, places: usize) -> (Self, Self) {
        let ((a0, a1), (b0, b1)) = (self.0.split(places), self.1.split(places));
        ((a0, b0), (a1, b1))
    }
}

#[cfg(test)]
mod tests {
    use super::super::dynamics::tests::{SKIN, start};
    use super::*;
    use crate::scene::{Scene, paper_scene};
    use crate::tables::{Snapshot, Stage};

    /// Moments of a pour on so many threads, in which grains touch, go from one thread's places to another's and are listed anew.
    fn moments(scene: &Scene, threads: usize) -> Vec<Snapshot> {
        let mut dynamics = start(scene, SKIN, threads);
        assert_eq!(dynamics.neighbours.shares.len(), threads);
        let before = dynamics.state.number.clone();
        let mut all = Vec::new();
        for step in 1..=9000 {
            dynamics.step().expect("a sound step");
            if step % 1500 == 0 {
                all.push(dynamics.snapshot(Stage::Settle, step));
            }
        }
        assert!(dynamics.neighbours.builds > 20);
        // With friction memory has the order of numbers.
        let is_smooth = scene.material.friction_angle == 0.0;
        assert_eq!(dynamics.state.number != before, is_smooth);
        all
    }

    #[test]
    fn any_number_of_threads_has_the_bits_of_one() {
        let smooth = paper_scene(1, 1003);
        let mut rough = smooth.clone();
        rough.material.friction_angle = 0.5;
        for scene in [smooth, rough] {
            let one = moments(&scene, 1);
            assert!(one.iter().any(|moment| moment.contacts.len() > 1000));
            for threads in [2, 3, 5] {
                for (moment, expected) in moments(&scene, threads).iter().zip(&one) {
                    let (bits, expected_bits) = (moment.bodies.digest(), expected.bodies.digest());
                    assert_eq!(
                        bits, expected_bits,
                        "{threads} threads, step {}",
                        moment.step
                    );
                    assert_eq!(moment, expected, "{threads} threads");
                }
            }
        }
    }

    #[test]
    fn a_small_bed_has_one_thread() {
        let count = |most: usize, grains: usize| Threads::at_most(most).of(grains);
        let found = [
            count(8, 0),
            count(8, 5000),
            count(8, 100_000),
            count(2, 100_000),
        ];
        assert_eq!(found, [1, 1, 8, 2]);
        assert_eq!(
            [count(0, 100_000), Threads::default().of(1_000_000)],
            [1, 1]
        );
    }

    #[test]
    fn a_panic_on_a_thread_reaches_the_caller() {
        let team = Team::new(2);
        let caught = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            team.together(|| join(|| (), || panic!("on purpose")));
        }));
        assert!(caught.is_err());
        assert_eq!(team.together(|| 7), 7, "and the others go on");
    }
}
