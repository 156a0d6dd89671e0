//! The frictionless kernel: the normal springs of [`super::contact`] arranged for vector lanes, and the neighbour list laid
//! out for them.
//!
//! Every grain has a row of all its neighbours, so its force can stay in a register and no two lanes write to the same
//! place; each pair is computed twice, once from either side, which gives the same bits with the opposite sign. A row is in
//! the order in which the sorted loop adds to that grain: partners with lower ids first, then those with higher ones, so
//! its sum has the same bits too.
//!
//! No operation is fused, left out or reordered, so a lane gives the bits of the scalar law.

#[cfg(target_arch = "x86_64")]
mod avx512;

use std::ops::Range;

use multiversion::multiversion;

/// The summed spring forces on the grains of these groups, N; what was in `force` before is lost.
pub fn sum_forces(position: At<&[[f64; 2]]>, rows: &Rows, groups: Range<usize>, force: Sums) {
    #[cfg(target_arch = "x86_64")]
    if avx512::available() {
        return avx512::sum_forces(position, rows, groups, force);
    }
    without_avx512(position, rows, groups, force);
}

#[multiversion(targets("x86_64+avx2"))]
fn without_avx512(position: At<&[[f64; 2]]>, rows: &Rows, groups: Range<usize>, force: Sums) {
    sum_forces_plain(position, rows, groups, force);
}

/// As any machine can do it.
#[inline(always)]
fn sum_forces_plain(
    position: At<&[[f64; 2]]>,
    rows: &Rows,
    groups: Range<usize>,
    At(first, force): Sums,
) {
    let columns = rows.start[groups.start..=groups.end].windows(2);
    for (grain, columns) in rows.grain[groups].iter().zip(columns) {
        let columns = columns[0] as usize..columns[1] as usize;
        let neighbours = rows.other[columns.clone()]
            .iter()
            .zip(&rows.reach[columns.clone()])
            .zip(&rows.stiffness[columns]);
        let (own_x, own_z) = gather(position, grain);
        let (mut sum_x, mut sum_z) = ([0.0; LANES], [0.0; LANES]);
        for ((other, reach), stiffness) in neighbours {
            let (x, z) = gather(position, other);
            for lane in 0..LANES {
                let (dx, dz) = (x[lane] - own_x[lane], z[lane] - own_z[lane]);
                let distance = (dx * dx + dz * dz).sqrt();
                let overlap = reach[lane] - distance;
                let size = stiffness[lane] * overlap;
                let pull = [size * (dx / distance), size * (dz / distance)];
                // A mask instead of a choice, so that no lane becomes a branch.
                let touching = u64::from(overlap >= 0.0).wrapping_neg();
                sum_x[lane] -= f64::from_bits(pull[0].to_bits() & touching);
                sum_z[lane] -= f64::from_bits(pull[1].to_bits() & touching);
            }
        }
        for lane in 0..LANES {
            force[grain[lane] as usize - first] = [sum_x[lane], sum_z[lane]];
        }
    }
}

#[inline(always)]
fn gather(At(first, values): At<&[[f64; 2]]>, ids: &Lanes<u32>) -> (Lanes<f64>, Lanes<f64>) {
    let (mut x, mut z) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        [x[lane], z[lane]] = values[ids[lane] as usize - first];
    }
    (x, z)
}

/// The values of a range of places, which begins with this one.
#[derive(Debug, Clone, Copy)]
pub struct At<T>(pub usize, pub T);

/// Forces that are written.
pub type Sums<'a> = At<&'a mut [[f64; 2]]>;

/// Grains that are computed together.
pub const LANES: usize = 16;

/// Rows are sorted by length within blocks of so many grains: long enough that few lanes stay empty,
/// short enough that a block's grains are near each other in memory.
pub const BLOCK: usize = 512;

/// A value in each lane.
pub type Lanes<T> = [T; LANES];

/// Rows of neighbours, [`LANES`] grains a group. Group g has the columns `start[g]..start[g+1]`; column c
/// holds one neighbour of each of its grains. Reused from build to build.
#[derive(Debug, Default)]
pub struct Rows {
    /// The places of the grains of each group. Lanes left over in the last one repeat its first grain.
    grain: Vec<Lanes<u32>>,
    /// The first column of each group.
    start: Vec<u32>,
    /// The places of the neighbours, column by column; an empty place holds the grain itself.
    other: Vec<Lanes<u32>>,
    /// R_1 + R_2, m; −1, which nothing is nearer than, in an empty place.
    reach: Vec<Lanes<f64>>,
    /// k_n, N/m.
    stiffness: Vec<Lanes<f64>>,
    /// Grains by length of row, block after block.
    order: Vec<u32>,
    /// Where the rows of each length begin in a block.
    begin: Vec<u32>,
}

impl Rows {
    /// Lays out the neighbours of the grains from place `first` on: those of grain i are `other[start[i]..start[i+1]]`, in the
    /// order in which their forces are added.
    pub fn build(
        &mut self,
        first: usize,
        start: &[u32],
        other: &[u32],
        of_pair: impl Fn(usize, usize) -> (f64, f64),
    ) {
        self.sort_by_length(start);
        self.grain.clear();
        self.start.clear();
        self.other.clear();
        self.reach.clear();
        self.stiffness.clear();
        self.start.push(0);
        let row = |grain: u32| {
            let grain = grain as usize;
            &other[start[grain] as usize..start[grain + 1] as usize]
        };
        for ids in self.order.chunks(LANES) {
            let mut lanes = [ids[0]; LANES];
            lanes[..ids.len()].copy_from_slice(ids);
            let from = self.other.len();
            let longest = ids.iter().map(|grain| row(*grain).len()).max();
            let to = from + longest.unwrap_or(0);
            let places = lanes.map(|grain| first as u32 + grain);
            self.other.resize(to, places);
            self.reach.resize(to, [-1.0; LANES]);
            self.stiffness.resize(to, [0.0; LANES]);
            for (lane, grain) in lanes.iter().enumerate() {
                let place = places[lane] as usize;
                for (column, neighbour) in (from..).zip(row(*grain)) {
                    let (reach, stiffness) = of_pair(place, *neighbour as usize);
                    self.other[column][lane] = *neighbour;
                    self.reach[column][lane] = reach;
                    self.stiffness[column][lane] = stiffness;
                }
            }
            self.grain.push(places);
            self.start.push(to as u32);
        }
    }

    /// How many blocks there are.
    pub fn blocks(&self) -> usize {
        self.grain.len().div_ceil(BLOCK / LANES)
    }

    /// The groups of a block.
    pub fn block(&self, block: usize) -> Range<usize> {
        const GROUPS: usize = BLOCK / LANES;
        block * GROUPS..((block + 1) * GROUPS).min(self.grain.len())
    }

    /// Grains in blocks, within a block the longest rows first.
    fn sort_by_length(&mut self, start: &[u32]) {
        self.order.clear();
        self.order.resize(start.len() - 1, 0);
        for (block, order) in self.order.chunks_mut(BLOCK).enumerate() {
            let from = block * BLOCK;
            let lengths = start[from..=from + order.len()].windows(2);
            let lengths = lengths.map(|row| (row[1] - row[0]) as usize);
            // A counting sort: where the rows of each length begin, the longest first.
            let longest = lengths.clone().max().unwrap_or(0);
            self.begin.clear();
            self.begin.resize(longest + 2, 0);
            for length in lengths.clone() {
                self.begin[longest - length + 1] += 1;
            }
            for shorter in 1..self.begin.len() {
                self.begin[shorter] += self.begin[shorter - 1];
            }
            for (index, length) in lengths.enumerate() {
                let place = &mut self.begin[longest - length];
                order[*place as usize] = (from + index) as u32;
                *place += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::dynamics::Dynamics;
    use super::super::dynamics::tests::{SKIN, start};
    use super::super::state::{Constants, State};
    use super::*;
    use crate::scene::paper_scene;

    /// The obvious version: the scalar law, one pair after the other in the order of the sorted loop.
    fn reference(state: &State, constants: &Constants) -> Vec<[f64; 2]> {
        let mut force = vec![[0.0; 2]; state.position.len()];
        let places = state.place.iter().map(|at| *at as usize);
        for (first, a) in places.clone().enumerate() {
            for b in places.clone().skip(first + 1) {
                let Some(touch) = state.grain_touch(a, b) else {
                    continue;
                };
                let stiffness = constants.stiffness(state.radius[a], state.radius[b]);
                let pair = touch.spring_force(stiffness);
                for axis in 0..2 {
                    force[a][axis] -= pair[axis];
                    force[b][axis] += pair[axis];
                }
            }
        }
        force
    }

    fn bits(force: &[[f64; 2]]) -> Vec<[u64; 2]> {
        force.iter().map(|f| f.map(f64::to_bits)).collect()
    }

    /// Moments of a pour in which grains touch; 3,001 of them, so that a group stays unfilled.
    fn moments(mut look: impl FnMut(&Dynamics)) {
        let mut dynamics = start(&paper_scene(1, 3001), SKIN, 1);
        for step in 1..=9000 {
            dynamics.step().expect("a sound step");
            if step % 3000 == 0 {
                look(&dynamics);
            }
        }
    }

    #[test]
    fn lanes_have_the_bits_of_the_scalar_law_summed_pair_after_pair() {
        let mut touching = 0;
        moments(|dynamics| {
            let (state, neighbours) = (&dynamics.state, &dynamics.neighbours);
            let expected = reference(state, &dynamics.constants);
            touching += expected.iter().filter(|force| **force != [0.0; 2]).count();
            let mut force = vec![[f64::NAN; 2]; expected.len()];
            let rows = &neighbours.shares[0].rows;
            let groups = 0..rows.grain.len();
            let (position, all) = (At(0, state.position.as_slice()), || groups.clone());
            sum_forces(position, rows, all(), At(0, &mut force));
            assert_eq!(bits(&force), bits(&expected), "the widest vectors");
            sum_forces_plain(position, rows, all(), At(0, &mut force));
            assert_eq!(bits(&force), bits(&expected), "the plainest machine's code");
            without_avx512(position, rows, all(), At(0, &mut force));
            assert_eq!(bits(&force), bits(&expected), "as without 512-bit vectors");
        });
        assert!(touching > 1000, "{touching}");
    }
}
