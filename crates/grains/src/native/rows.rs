//! The neighbour list of the frictionless kernel, laid out for vector lanes.
//!
//! Every grain has a row of all its neighbours, so its force can stay in a register and no two lanes
//! write to the same place; each pair is computed twice, once from either side, which gives the same
//! bits with the opposite sign. A row is in the order in which the sorted loop adds to that grain:
//! partners with lower ids first, then those with higher ones, so its sum has the same bits too.

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
