//! Several steps in one sweep over memory. A bed that is larger than the caches is read and written once a step otherwise, and
//! a step waits for that.
//!
//! A step has two halves: grains advance, then forces are summed. Half h of a block of grains needs half h − 1 of all blocks
//! within the reach of its neighbours and nothing else. So the halves go through the bed behind each other, each a reach
//! behind the one before, and what they pass stays in the cache. Threads sweep their own places first, from open ends a
//! reach less each half; then the gaps at the borders between them are filled. The operations on a grain and their order
//! are those of single steps, and so are the bits.

use std::ops::Range;

use super::dynamics::{Fastest, Moved, faster, integrate, springs_and_walls};
use super::neighbours::{Border, Neighbours, Share};
use super::springs::At;
use super::state::{Constants, State};
use super::threads::each;

/// Steps of a sweep are at most so many: then memory is no longer what they wait for.
pub const MOST: usize = 8;

/// Below so many grains a bed fits in the caches, and sweeps are a little slower than single steps.
pub const FEWEST_GRAINS: usize = 20_000;

/// A share has at least so many times the blocks of a gap at its border: one thread fills the gap, and another waits.
pub const BLOCKS_OVER_GAP: usize = 12;

/// The fastest of each step.
pub type Speeds = [Fastest; MOST];

/// Positions, velocities and forces of a range of places.
type Window<'a> = ((&'a mut [[f64; 2]], &'a mut [[f64; 2]]), &'a mut [[f64; 2]]);

/// Advances the bed by so many steps, as long as the list holds; forces belong to the positions before and after.
pub fn sweep(
    state: &mut State,
    neighbours: &mut Neighbours,
    constants: &Constants,
    steps: usize,
) -> Speeds {
    let (reach, all, count) = (neighbours.reach, state.position.len(), 2 * steps);
    let (shares, borders) = (&mut neighbours.shares, &mut neighbours.borders);
    let fixed = (&state.component_mass[..], &state.radius[..], constants);
    let fastest = |a: Speeds, b: Speeds| std::array::from_fn(|step| faster(a[step], b[step]));
    let own = |share: &mut Share, window: Window| {
        let Range { start, end } = share.places;
        let (open, blocks) = ([start > 0, end < all], share.rows.blocks());
        let range = |half: usize| {
            let less = open.map(|open| if open { reach * half } else { 0 });
            less[0]..blocks.saturating_sub(less[1])
        };
        let sides = [&*share, &*share];
        halves(sides, range, (reach, count), At(start, window), fixed)
    };
    let window: Window = ((&mut state.position, &mut state.velocity), &mut state.force);
    let speeds = each(shares, Share::first, window, &own, &fastest);
    if borders.is_empty() {
        return speeds;
    }
    let gap = |border: &mut Border, window: Window| {
        let sides = [&shares[border.left], &shares[border.left + 1]];
        let at = sides[0].rows.blocks();
        let range = |half: usize| at - reach * half..at + reach * half;
        halves(
            sides,
            range,
            (reach, count),
            At(border.start, window),
            fixed,
        )
    };
    let window: Window = ((&mut state.position, &mut state.velocity), &mut state.force);
    let start = |border: &Border| border.start;
    fastest(speeds, each(borders, start, window, &gap, &fastest))
}

/// The halves of steps on the blocks that each is told to do, counted through both shares. Each begins behind the one before.
fn halves(
    shares: [&Share; 2],
    blocks: impl Fn(usize) -> Range<usize>,
    (reach, halves): (usize, usize),
    At(first, ((position, velocity), force)): At<Window>,
    (mass, radius, constants): (&[[f64; 2]], &[f64], &Constants),
) -> Speeds {
    let Constants {
        dt, gravity, alpha, ..
    } = *constants;
    let mut speeds = Speeds::default();
    let begin = |half| blocks(half).start + reach * half;
    let end = |half| blocks(half).end + reach * half;
    let from = (0..halves).map(begin).min().unwrap_or(0);
    let to = (0..halves).map(end).max().unwrap_or(0);
    let left = shares[0].rows.blocks();
    for front in from..to {
        for half in 0..halves {
            let Some(block) = front.checked_sub(reach * half) else {
                break;
            };
            if !blocks(half).contains(&block) {
                continue;
            }
            let (share, block) = match block < left {
                true => (shares[0], block),
                false => (shares[1], block - left),
            };
            if half % 2 == 1 {
                let seen = (At(first, &*position), radius);
                springs_and_walls(share, block, seen, At(first, &mut *force), constants);
                continue;
            }
            let places = share.block(block);
            let here = places.start - first..places.end - first;
            let moved: Moved = (
                (&mut position[here.clone()], &mut velocity[here.clone()]),
                (&force[here], &mass[places]),
            );
            let speed = &mut speeds[half / 2];
            *speed = faster(*speed, integrate(moved, dt, gravity, alpha));
        }
    }
    speeds
}

#[cfg(test)]
mod tests {
    use super::super::dynamics::Dynamics;
    use super::super::dynamics::tests::{SKIN, start};
    use super::super::neighbours::Skin;
    use crate::scene::{Cloud, paper_scene};
    use crate::tables::{Snapshot, Stage};

    /// The moments of a pour on so many threads; `go` makes the steps from one to the next.
    fn poured(
        (grains, width): (u32, f64),
        skin: Skin,
        threads: usize,
        moments: u64,
        mut go: impl FnMut(&mut Dynamics, u64),
    ) -> Vec<Snapshot> {
        let mut scene = paper_scene(1, grains);
        scene.container.width = width;
        scene.cloud = Cloud::JitteredLattice {
            columns: (80.0 * width) as u32,
            jitter: 0.9,
            speed: 0.3,
            spin: 0.0,
            over: None,
        };
        let mut dynamics = start(&scene, skin, threads);
        dynamics.neighbours.sweeps_always = true;
        let moment = |moment| {
            go(&mut dynamics, 750);
            dynamics.snapshot(Stage::Settle, 750 * moment)
        };
        (1..=moments).map(moment).collect()
    }

    fn singly(dynamics: &mut Dynamics, steps: u64) {
        (0..steps).for_each(|_| dynamics.step().expect("a sound step"));
    }

    /// Counts the steps that were done in sweeps.
    fn in_sweeps(swept: &mut u64) -> impl FnMut(&mut Dynamics, u64) {
        |dynamics, steps| {
            dynamics.steps(steps).expect("sound steps");
            *swept = dynamics.swept;
        }
    }

    #[test]
    fn sweeps_have_the_bits_of_single_steps() {
        let expected = poured((3001, 1.0), SKIN, 1, 12, singly);
        assert!(expected.iter().any(|moment| moment.contacts.len() > 1000));
        let mut swept = 0;
        let made = poured((3001, 1.0), SKIN, 1, 12, in_sweeps(&mut swept));
        assert_eq!(made, expected);
        assert!(swept > 7000, "of 9000 steps {swept}");
    }

    #[test]
    fn a_bed_is_swept_where_that_pays() {
        for (grains, threads, pays) in [(19_999, 1, false), (20_000, 1, true), (50_000, 2, true)] {
            let mut swept = 0;
            poured((grains, 4.0), SKIN, threads, 1, |dynamics, steps| {
                dynamics.neighbours.sweeps_always = false;
                dynamics.steps(steps).expect("sound steps");
                swept = dynamics.swept;
            });
            assert_eq!(swept > 0, pays, "{grains} grains on {threads} threads");
        }
    }

    #[test]
    fn sweeps_on_several_threads_have_the_bits_of_single_steps() {
        let wide = (20_000, 4.0);
        let expected = poured(wide, SKIN, 1, 12, singly);
        let contacts = expected.iter().map(|moment| moment.contacts.len()).max();
        assert!(contacts > Some(1000), "{contacts:?}");
        for threads in [2, 3, 5] {
            let mut swept = 0;
            let made = poured(wide, SKIN, threads, 12, in_sweeps(&mut swept));
            assert!(made == expected, "{threads} threads");
            assert!(swept > 6000, "of 9000 steps {swept} on {threads} threads");
        }
    }

    #[test]
    fn a_sweep_that_went_too_far_is_taken_back() {
        let expected = poured((1003, 1.0), SKIN, 1, 12, singly);
        // Less than the way of a sweep, and of a few.
        for skin in [2.0e-5, 4.0e-4] {
            let made = poured((1003, 1.0), Skin::Fixed(skin), 1, 12, |dynamics, steps| {
                for _ in 0..steps / 10 {
                    // As if nothing moved.
                    dynamics.neighbours.way = 0.0;
                    dynamics.steps(10).expect("sound steps");
                }
            });
            assert!(made == expected, "skin {skin}");
        }
    }
}
