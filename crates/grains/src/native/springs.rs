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

use multiversion::multiversion;

/// The summed spring force on every grain that is in the rows, N; what was in `force` before is lost.
pub fn sum_forces(position: &[[f64; 2]], rows: &Rows, force: &mut [[f64; 2]]) {
    #[cfg(target_arch = "x86_64")]
    if avx512::available() {
        return avx512::sum_forces(position, rows, force);
    }
    without_avx512(position, rows, force);
}

#[multiversion(targets("x86_64+avx2"))]
fn without_avx512(position: &[[f64; 2]], rows: &Rows, force: &mut [[f64; 2]]) {
    sum_forces_plain(position, rows, force);
}

/// As any machine can do it.
#[inline(always)]
fn sum_forces_plain(position: &[[f64; 2]], rows: &Rows, force: &mut [[f64; 2]]) {
    for (grain, columns) in rows.grain.iter().zip(rows.start.windows(2)) {
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
            force[grain[lane] as usize] = [sum_x[lane], sum_z[lane]];
        }
    }
}

#[inline(always)]
fn gather(of: &[[f64; 2]], ids: &Lanes<u32>) -> (Lanes<f64>, Lanes<f64>) {
    let (mut x, mut z) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        [x[lane], z[lane]] = of[ids[lane] as usize];
    }
    (x, z)
}

/// Grains that are computed together.
pub const LANES: usize = 16;

/// Rows are sorted by length within blocks of so many grains: long enough that few lanes stay empty,
/// short enough that a block's grains are near each other in memory.
const BLOCK: usize = 512;

/// A value in each lane.
pub type Lanes<T> = [T; LANES];

/// Rows of neighbours, [`LANES`] grains a group. Group g has the columns `start[g]..start[g+1]`; column c
/// holds one neighbour of each of its grains. Reused from build to build.
#[derive(Debug, Default)]
pub struct Rows {
    /// The grains of each group. Lanes left over in the last one repeat its first grain.
    pub grain: Vec<Lanes<u32>>,
    /// The first column of each group.
    pub start: Vec<u32>,
    /// The neighbours, column by column; an empty place holds the grain itself.
    pub other: Vec<Lanes<u32>>,
    /// R_1 + R_2, m; −1, which nothing is nearer than, in an empty place.
    pub reach: Vec<Lanes<f64>>,
    /// k_n, N/m.
    pub stiffness: Vec<Lanes<f64>>,
    /// Neighbours of each grain.
    length: Vec<u32>,
    /// Group and lane of each grain, as group·LANES + lane.
    place: Vec<u32>,
    /// Grains by length of row, block after block.
    order: Vec<u32>,
    /// Where the rows of each length begin in a block.
    begin: Vec<u32>,
}

/// One listed pair; `first` has the lower id.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    pub first: u32,
    pub second: u32,
    /// R_1 + R_2, m.
    pub reach: f64,
    /// k_n, N/m.
    pub stiffness: f64,
}

impl Rows {
    /// Lays out these pairs, given in the order in which their forces are summed.
    pub fn build(&mut self, grains: usize, pairs: impl Iterator<Item = Pair> + Clone) {
        self.length.clear();
        self.length.resize(grains, 0);
        for pair in pairs.clone() {
            self.length[pair.first as usize] += 1;
            self.length[pair.second as usize] += 1;
        }
        self.sort_by_length();
        self.make_room();
        for pair in pairs {
            self.put(pair.first, pair.second, &pair);
            self.put(pair.second, pair.first, &pair);
        }
        self.fill_last_group();
    }

    /// Grains in blocks, within a block the longest rows first.
    fn sort_by_length(&mut self) {
        self.order.clear();
        self.order.resize(self.length.len(), 0);
        let blocks = self.length.chunks(BLOCK).zip(self.order.chunks_mut(BLOCK));
        for (block, (length, order)) in blocks.enumerate() {
            // A counting sort: where the rows of each length begin, the longest first.
            let longest = length.iter().copied().max().unwrap_or(0) as usize;
            self.begin.clear();
            self.begin.resize(longest + 2, 0);
            for length in length {
                self.begin[longest - *length as usize + 1] += 1;
            }
            for shorter in 1..self.begin.len() {
                self.begin[shorter] += self.begin[shorter - 1];
            }
            for (index, length) in length.iter().enumerate() {
                let place = &mut self.begin[longest - *length as usize];
                order[*place as usize] = (block * BLOCK + index) as u32;
                *place += 1;
            }
        }
    }

    /// Empty columns for every group, as many as its longest row has neighbours.
    fn make_room(&mut self) {
        let Rows {
            grain,
            start,
            other,
            reach,
            stiffness,
            length,
            place,
            order,
            begin: _,
        } = self;
        grain.clear();
        start.clear();
        other.clear();
        start.push(0);
        place.clear();
        place.resize(length.len(), 0);
        for (group, ids) in order.chunks(LANES).enumerate() {
            let mut lanes = [ids[0]; LANES];
            lanes[..ids.len()].copy_from_slice(ids);
            grain.push(lanes);
            let mut longest = 0;
            for (lane, id) in ids.iter().enumerate() {
                place[*id as usize] = (group * LANES + lane) as u32;
                longest = longest.max(length[*id as usize]);
            }
            other.resize(other.len() + longest as usize, lanes);
            start.push(other.len() as u32);
        }
        reach.clear();
        reach.resize(other.len(), [-1.0; LANES]);
        stiffness.clear();
        stiffness.resize(other.len(), [0.0; LANES]);
        // From here on a row's length counts the neighbours that it has already.
        length.fill(0);
    }

    fn put(&mut self, grain: u32, neighbour: u32, pair: &Pair) {
        let place = self.place[grain as usize] as usize;
        let (group, lane) = (place / LANES, place % LANES);
        let column = (self.start[group] + self.length[grain as usize]) as usize;
        self.length[grain as usize] += 1;
        self.other[column][lane] = neighbour;
        self.reach[column][lane] = pair.reach;
        self.stiffness[column][lane] = pair.stiffness;
    }

    fn fill_last_group(&mut self) {
        let used = self.length.len() % LANES;
        let [.., from, _] = self.start[..] else {
            return;
        };
        if used == 0 {
            return;
        }
        for column in from as usize..self.other.len() {
            let first = self.other[column][0];
            self.other[column][used..].fill(first);
            let first = self.reach[column][0];
            self.reach[column][used..].fill(first);
            let first = self.stiffness[column][0];
            self.stiffness[column][used..].fill(first);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::dynamics::Dynamics;
    use super::super::neighbours::Skin;
    use super::super::state::{Constants, State};
    use super::*;
    use crate::generate::initial_bodies;
    use crate::model::Model;
    use crate::scene::paper_scene;

    /// The obvious version: the scalar law, one pair after the other in the order of the sorted loop.
    fn reference(state: &State, constants: &Constants) -> Vec<[f64; 2]> {
        let mut force = vec![[0.0; 2]; state.position.len()];
        for a in 0..force.len() {
            for b in a + 1..force.len() {
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
        let scene = paper_scene(1, 3001);
        let constants = Constants::new(&Model::of(&scene), scene.particles.count);
        let bodies = initial_bodies(&scene);
        let skin = Skin::Adaptive { radius: 0.005 };
        let mut dynamics =
            Dynamics::new(&bodies, None, &[], constants, skin).expect("a sound start");
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
            let Dynamics {
                state, neighbours, ..
            } = dynamics;
            let expected = reference(state, &dynamics.constants);
            touching += expected.iter().filter(|force| **force != [0.0; 2]).count();
            let mut force = vec![[f64::NAN; 2]; expected.len()];
            sum_forces(&state.position, &neighbours.rows, &mut force);
            assert_eq!(
                bits(&force),
                bits(&expected),
                "this machine's widest vectors"
            );
            sum_forces_plain(&state.position, &neighbours.rows, &mut force);
            assert_eq!(bits(&force), bits(&expected), "the plainest machine's code");
            without_avx512(&state.position, &neighbours.rows, &mut force);
            assert_eq!(bits(&force), bits(&expected), "as without 512-bit vectors");
        });
        assert!(touching > 1000, "{touching}");
    }
}
