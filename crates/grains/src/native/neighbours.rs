//! The neighbour list: which pairs may touch before anything has moved further than the skin allows.
//!
//! Built on a grid of square cells, by which the grains are laid out in memory too. A grain's neighbours come out in the
//! order of their numbers, in which forces are summed. The skin decides how often the list is rebuilt and never what a
//! step gives: pairs that do not touch add nothing.

use std::ops::Range;

use super::contact::Memory;
use super::dynamics::Fastest;
use super::general;
use super::pairs::Pairs;
use super::springs::{BLOCK, Rows};
use super::state::{Constants, Spare, State};
use super::sweep;
use super::threads::{Team, each};
use crate::model::Kernel;
use crate::tables::Remembered;

/// What is listed and the positions it was listed for. Reused from build to build.
#[derive(Debug, Default)]
pub struct Neighbours {
    /// One a thread: who is near the grains of a range of places.
    pub shares: Vec<Share>,
    /// One less: where they meet.
    pub borders: Vec<Border>,
    /// So many [`BLOCK`]s away grains have neighbours at most; of the frictionless kernel.
    pub reach: usize,
    /// Sweeps even where they do not pay; for tests.
    pub sweeps_always: bool,
    /// Places of the grains near the punch, in order of number.
    pub by_punch: Vec<u32>,
    /// What contacts with the punch remember.
    pub punch_memory: Vec<Memory>,
    /// What contacts remembered before a build, sorted by ids.
    remembered: Vec<Remembered>,
    /// Positions at the build.
    pub reference: Vec<[f64; 2]>,
    /// Height of the punch's centre at the build, m.
    punch_reference: f64,
    policy: Skin,
    /// Pairs within this distance beyond touching are listed, m.
    skin: f64,
    /// No grain was further from its reference when that was last looked at, m.
    displaced: f64,
    /// No grain has gone further since, m.
    gone_since: f64,
    /// The way of the fastest in the last step, m.
    pub way: f64,
    /// Steps since the build.
    held: u32,
    pub builds: u64,
    cells: Cells,
    spare: Spare,
}

/// Where two shares meet.
#[derive(Debug)]
pub struct Border {
    /// The share to its left.
    pub left: usize,
    /// The first place that belongs to it: in the middle of that share, or the first of all.
    pub start: usize,
}

/// The grains of a range of places and what is near them.
#[derive(Debug, Default)]
pub struct Share {
    pub places: Range<usize>,
    /// Row pointers: the neighbours of the grain at `places.start + i` are `start[i]..start[i+1]`.
    start: Vec<u32>,
    /// Places of each grain's neighbours, in the order in which their forces are added.
    other: Vec<u32>,
    /// The neighbours laid out for vector lanes; empty for the general kernel.
    pub rows: Rows,
    /// Pairs with a grain of this range in the order of their sums, and what they remember; empty for the frictionless kernel.
    pub pairs: Pairs,
    /// Which grain is near which wall, by place: indices of place and of [`Constants::walls`].
    pub by_wall: Vec<(u32, u32)>,
    /// What contacts with walls remember; empty for the frictionless kernel.
    pub wall_memory: Vec<Memory>,
    row: Vec<u64>,
    border: Vec<[u32; 2]>,
}

/// Grains sorted into square cells, column by column: beds are wide, and so neighbours are near in memory.
#[derive(Debug, Default)]
struct Cells {
    /// One over the side of a cell, 1/m.
    cells_per_metre: f64,
    origin: [f64; 2],
    columns: usize,
    rows: usize,
    /// The grains of cell c are `grains[start[c]..start[c+1]]`.
    start: Vec<u32>,
    grains: Vec<Sorted>,
    /// The cell of each grain, by its place when they were sorted.
    of_grain: Vec<u32>,
    /// That place, of each of `grains`.
    order: Vec<u32>,
}

/// A grain in its cell, with what is asked of it.
#[derive(Debug, Clone, Copy, Default)]
struct Sorted {
    x: f64,
    z: f64,
    radius: f64,
    number: u32,
    place: u32,
}

/// How the skin is chosen at each build. It decides how often the list is rebuilt and nothing else.
#[derive(Debug, Clone, Copy)]
pub enum Skin {
    /// Always this, m.
    Fixed(f64),
    /// By how fast the grains move, for grains of about this radius, m.
    Adaptive { radius: f64 },
}

impl Default for Skin {
    fn default() -> Self {
        Skin::Fixed(0.0)
    }
}

impl Skin {
    /// The cost of a build, over the interval skin/(2v·dt) between builds, plus that of the pairs that the
    /// skin adds, is least at a skin in proportion to √(R·v·dt); `way` is v·dt of the fastest, m.
    fn of(self, way: f64) -> f64 {
        match self {
            Skin::Fixed(skin) => skin,
            Skin::Adaptive { radius } => (WAY_FACTOR * radius * way)
                .sqrt()
                .clamp(LEAST_SKIN * radius, LARGEST_SKIN * radius),
        }
    }
}

/// The way of the fastest grain or of the punch in a step, m.
fn fastest_way(state: &State, constants: &Constants) -> f64 {
    let punch = state
        .punch
        .map_or(0.0, |punch| punch.velocity * punch.velocity);
    let square = |v: &[f64; 2]| v[0] * v[0] + v[1] * v[1];
    let fastest = state.velocity.iter().map(square).fold(punch, f64::max);
    fastest.sqrt() * constants.dt
}

/// A list that has held for so many steps is looked at: a bed that has come to rest needs fewer pairs.
const OLD: u32 = 500;

/// Skin² over R·v·dt, found by trying.
const WAY_FACTOR: f64 = 64.0;

/// The skin over R is never less: a bed at rest still trembles.
const LEAST_SKIN: f64 = 0.005;

/// Nor more: in free flight a few more pairs cost nothing, in a bed they do.
const LARGEST_SKIN: f64 = 1.0;

/// For the few neighbours of a row.
fn insertion_sort(row: &mut [u64]) {
    for end in 1..row.len() {
        let mut at = end;
        while at > 0 && row[at - 1] > row[at] {
            row.swap(at - 1, at);
            at -= 1;
        }
    }
}

/// The largest distance between a position and its reference, m; infinite if one is not a number.
fn furthest(position: &[[f64; 2]], reference: &[[f64; 2]]) -> f64 {
    let mut largest = [0.0f64; 8];
    let mut total = 0.0;
    let pairs = position.chunks(8).zip(reference.chunks(8));
    for (position, reference) in pairs {
        for ((at, from), largest) in position.iter().zip(reference).zip(&mut largest) {
            let (dx, dz) = (at[0] - from[0], at[1] - from[1]);
            let square = dx * dx + dz * dz;
            total += square;
            *largest = if square > *largest { square } else { *largest };
        }
    }
    if total.is_nan() {
        return f64::INFINITY;
    }
    largest.into_iter().fold(0.0, f64::max).sqrt()
}

impl Neighbours {
    /// An empty list for so many threads and grains.
    pub fn new(policy: Skin, threads: usize, grains: usize) -> Self {
        // Whole blocks, unless they are few: a block of a few grains would lengthen the reach of its neighbours.
        let few = grains < 8 * BLOCK * threads;
        let end = |thread: usize| match thread * grains / threads {
            place if few || thread == threads => place,
            place => place - place % BLOCK,
        };
        let share = |thread| Share {
            places: end(thread)..end(thread + 1),
            ..Share::default()
        };
        let border = |left: usize| Border {
            left,
            start: match left {
                0 => 0,
                _ => end(left).midpoint(end(left + 1)),
            },
        };
        Neighbours {
            shares: (0..threads).map(share).collect(),
            borders: (0..threads - 1).map(border).collect(),
            policy,
            ..Neighbours::default()
        }
    }

    /// Whether every possible contact is still in the list after a step of `dt` seconds in which no
    /// component of a velocity was faster than these. Positions are looked at only when the
    /// speeds alone do not tell.
    pub fn hold(
        &mut self,
        fastest: Fastest,
        dt: f64,
        position: &[[f64; 2]],
        punch_height: Option<f64>,
    ) -> bool {
        let way = dt * (fastest[0] + fastest[1]).sqrt();
        self.gone_since += way;
        self.held += 1;
        if self.held.is_multiple_of(OLD) && self.policy.of(way) < 0.5 * self.skin {
            return false;
        }
        self.way = way;
        let limit = self.limit(punch_height);
        if self.displaced + self.gone_since <= limit {
            return true;
        }
        self.displaced = furthest(position, &self.reference);
        self.gone_since = 0.0;
        self.displaced <= limit
    }

    /// No grain may be further from its reference than this, m.
    fn limit(&self, punch_height: Option<f64>) -> f64 {
        let punch_moved = punch_height.map_or(0.0, |height| (height - self.punch_reference).abs());
        // Two grains may approach each other by twice a displacement, a grain and the punch by one each.
        let limit = (0.5 * self.skin).min(self.skin - punch_moved);
        // A little less, so that the rounding of distances does not matter.
        (1.0 - 1.0e-9) * limit
    }

    /// So many steps a sweep may go ahead where there is no punch: the list holds if no grain becomes twice as fast.
    pub fn steps_ahead(&self, most: u64) -> usize {
        if self.reference.len() < sweep::FEWEST_GRAINS && !self.sweeps_always {
            return 1;
        }
        let room = self.limit(None) - self.displaced - self.gone_since;
        let held = (room / (2.0 * self.way)) as usize;
        // An old list is looked at.
        let old = (OLD - 1 - self.held % OLD) as usize;
        // A step leaves a gap of two reaches on each side of a border; no gap may go beyond the middle of a share.
        let over_gap = match self.sweeps_always {
            true => 2,
            false => sweep::BLOCKS_OVER_GAP,
        };
        let blocks = self.shares.iter().map(|share| share.rows.blocks()).min();
        let apart = match self.borders.is_empty() {
            true => sweep::MOST,
            false => blocks.unwrap_or(0) / (2 * self.reach * over_gap),
        };
        (most.min(sweep::MOST as u64) as usize)
            .min(held)
            .min(old)
            .min(apart)
    }

    /// Takes note of steps of `dt` seconds that were done; whether every possible contact was in the list.
    pub fn held(&mut self, fastest: &[Fastest], dt: f64) -> bool {
        for fastest in fastest {
            self.way = dt * (fastest[0] + fastest[1]).sqrt();
            self.gone_since += self.way;
            self.held += 1;
        }
        self.displaced + self.gone_since <= self.limit(None)
    }

    /// Steps since the build.
    pub fn held_for(&self) -> u32 {
        self.held
    }

    /// Lists anew what is near what, after putting the grains in memory where their neighbours are. Contacts remember what
    /// they did, or this, sorted by ids.
    pub fn build(
        &mut self,
        state: &mut State,
        constants: &Constants,
        recalled: Option<&[Remembered]>,
        team: &Team,
    ) {
        self.builds += 1;
        self.skin = self.policy.of(fastest_way(state, constants));
        self.held = 0;
        let general = constants.kernel() == Kernel::General;
        let mut remembered = std::mem::take(&mut self.remembered);
        remembered.clear();
        if general {
            match recalled {
                Some(recalled) => remembered.extend_from_slice(recalled),
                None => general::listed(state, self, constants, &mut remembered),
            }
            // It goes through pairs in the order of numbers, so that is how its grains are near at hand.
            state.rearrange_by_number(&mut self.spare);
        }
        self.cells.sort(state, self.skin, !general);
        if !general {
            state.rearrange(&self.cells.order, &mut self.spare);
        }
        let (cells, skin, state, remembered) = (&self.cells, self.skin, &*state, remembered);
        let list = |share: &mut Share, ()| {
            let furthest = share.list(cells, state, skin, constants);
            if general {
                share.take_over(state, constants, &remembered);
            } else {
                share.lay_out_rows(state, constants);
            }
            furthest
        };
        let furthest = team.together(|| each(&mut self.shares, Share::first, (), &list, &u32::max));
        self.reach = (furthest as usize).div_ceil(BLOCK).max(1);
        self.near_punch(state);
        let number = self.by_punch.iter().map(|at| state.number[*at as usize]);
        let memory = number.map(|id| memory_of(&remembered, constants.ids.punch(), id));
        self.punch_memory.clear();
        self.punch_memory.extend(memory);
        self.remembered = remembered;
        self.reference.clone_from(&state.position);
        self.punch_reference = state.punch.map_or(0.0, |punch| punch.centre[1]);
        self.displaced = 0.0;
        self.gone_since = 0.0;
    }

    pub fn len(&self) -> usize {
        self.shares
            .iter()
            .map(|share| share.other.len())
            .sum::<usize>()
            / 2
    }

    fn near_punch(&mut self, state: &State) {
        self.by_punch.clear();
        let Some(punch) = &state.punch else {
            return;
        };
        let near = |at: &u32| {
            let at = *at as usize;
            let far = state.radius[at] + self.skin;
            (0..2).all(|axis| {
                let distance = (state.position[at][axis] - punch.centre[axis]).abs();
                distance <= punch.half_extents[axis] + far
            })
        };
        let grains = state.position.len() as u32;
        self.by_punch.extend((0..grains).filter(near));
        self.by_punch
            .sort_unstable_by_key(|at| state.number[*at as usize]);
    }
}

/// What a contact remembers, found by its ids; zeros if nothing.
fn memory_of(remembered: &[Remembered], id1: u32, id2: u32) -> Memory {
    let found = remembered.binary_search_by_key(&(id1, id2), |contact| (contact.id1, contact.id2));
    found.map_or_else(|_| Memory::default(), |at| memory(&remembered[at]))
}

fn memory(remembered: &Remembered) -> Memory {
    Memory {
        normal: remembered.normal,
        shear: remembered.shear,
    }
}

impl Share {
    pub fn first(&self) -> usize {
        self.places.start
    }

    /// The places of a block of its rows.
    pub fn block(&self, block: usize) -> Range<usize> {
        let from = self.places.start + block * BLOCK;
        from..(from + BLOCK).min(self.places.end)
    }

    /// Which of these grains is near which wall.
    pub fn at_walls(&self, places: Range<usize>) -> &[(u32, u32)] {
        let before = |end: usize| self.by_wall.partition_point(|(at, _)| (*at as usize) < end);
        &self.by_wall[before(places.start)..before(places.end)]
    }

    /// Places of the neighbours of the grain at this place.
    pub fn row(&self, place: usize) -> &[u32] {
        let at = place - self.places.start;
        &self.other[self.start[at] as usize..self.start[at + 1] as usize]
    }

    /// Lists who is near whom and near which wall. Says how many places away a neighbour is at most where grains lie by place.
    fn list(&mut self, cells: &Cells, state: &State, skin: f64, constants: &Constants) -> u32 {
        let mut furthest = 0;
        self.start.clear();
        self.other.clear();
        self.by_wall.clear();
        self.start.push(0);
        for place in self.places.clone() {
            let ([x, z], radius) = (state.position[place], state.radius[place]);
            let number = state.number[place];
            let mut found = 0;
            for near in cells.around(x, z) {
                let last = near.last().map_or(0, |last| last.place);
                furthest = furthest.max(last.saturating_sub(place as u32));
                if self.row.len() < found + near.len() {
                    self.row.resize(found + near.len(), 0);
                }
                for grain in near {
                    let (dx, dz) = (grain.x - x, grain.z - z);
                    let far = radius + grain.radius + skin;
                    let listed = (grain.number != number) & (dx * dx + dz * dz <= far * far);
                    // Written in any case and kept by counting, so that nothing has to be guessed.
                    self.row[found] = u64::from(grain.number) << 32 | u64::from(grain.place);
                    found += usize::from(listed);
                }
            }
            let row = &mut self.row[..found];
            insertion_sort(row);
            if constants.reversed_sums {
                let lower = row.partition_point(|entry| entry >> 32 < u64::from(number));
                row[lower..].reverse();
            }
            self.other.extend(row.iter().map(|entry| *entry as u32));
            self.start.push(self.other.len() as u32);
            for (index, wall) in constants.walls.iter().enumerate() {
                let distance = (state.position[place][wall.axis as usize] - wall.place).abs();
                if distance <= radius + skin {
                    self.by_wall.push((place as u32, index as u32));
                }
            }
        }
        furthest
    }

    fn lay_out_rows(&mut self, state: &State, constants: &Constants) {
        let radius = &state.radius;
        let of_pair = |one: usize, other: usize| {
            let (r1, r2) = (radius[one], radius[other]);
            (r1 + r2, constants.stiffness(r1, r2))
        };
        let first = self.places.start;
        self.rows.build(first, &self.start, &self.other, of_pair);
    }

    /// The pairs in the order of numbers, which are places here, with what they remember. A pair across the border of two
    /// ranges is in both, and both compute the same of it.
    fn take_over(&mut self, state: &State, constants: &Constants, remembered: &[Remembered]) {
        let mut pairs = std::mem::take(&mut self.pairs);
        let places = self.other.iter().map(|other| *other as usize);
        let (from, to) = places.fold((self.places.start, self.places.end), |(from, to), at| {
            (from.min(at), to.max(at + 1))
        });
        pairs.clear(from..to);
        let mut border = std::mem::take(&mut self.border);
        border.clear();
        for second in self.places.clone() {
            let outside = |first: &&u32| (**first as usize) < self.places.start;
            let before = self.row(second).iter().filter(outside);
            border.extend(before.map(|first| [*first, second as u32]));
        }
        border.sort_unstable();
        let own = self.places.clone().flat_map(|first| {
            let others = self.row(first).iter();
            let higher = others.filter(move |second| **second as usize > first);
            higher.map(move |second| [first as u32, *second])
        });
        let mut left = remembered;
        for [id1, id2] in border.iter().copied().chain(own) {
            let before = left.iter().take_while(|contact| contact.id1 < id1).count();
            left = &left[before..];
            let mut of_first = left.iter().take_while(|contact| contact.id1 == id1);
            let old = of_first.find(|contact| contact.id2 == id2);
            let old = old.map(memory).unwrap_or_default();
            let [first, second] = [id1, id2].map(|id| id as usize);
            let radii = [state.radius[first], state.radius[second]];
            let parameters = constants.of_pair(state, first, second);
            pairs.push([first, second], radii, &parameters, &old);
        }
        (self.pairs, self.border) = (pairs, border);
        let memory = |(at, wall): &(u32, u32)| {
            memory_of(remembered, constants.ids.wall(*wall as usize), *at)
        };
        self.wall_memory.clear();
        self.wall_memory.extend(self.by_wall.iter().map(memory));
    }
}

impl Cells {
    /// Counting sort of the grains into cells that are as wide as the furthest listed pair.
    /// The grains are told to be at the places of this order if they are to be put there.
    fn sort(&mut self, state: &State, skin: f64, to_be_put: bool) {
        let largest = state.radius.iter().copied().fold(0.0, f64::max);
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for position in &state.position {
            for axis in 0..2 {
                low[axis] = low[axis].min(position[axis]);
                high[axis] = high[axis].max(position[axis]);
            }
        }
        self.origin = low;
        // A few grains far off must not cost memory: never more than a few cells a grain.
        let extent = [high[0] - low[0], high[1] - low[1]];
        let most = 4.0 * state.position.len() as f64 + 64.0;
        let coarse = (extent[0] * extent[1] / most).sqrt();
        let thin = extent[0].max(extent[1]) / most;
        // A little wider than the furthest pair, so that rounding does not matter.
        let side = (1.0 + 1.0e-9) * (2.0 * largest + skin).max(coarse).max(thin);
        self.cells_per_metre = 1.0 / side;
        self.columns = (extent[0] * self.cells_per_metre) as usize + 1;
        self.rows = (extent[1] * self.cells_per_metre) as usize + 1;

        self.start.clear();
        self.start.resize(self.columns * self.rows + 1, 0);
        self.of_grain.clear();
        for position in &state.position {
            let (column, row) = self.at(position[0], position[1]);
            let cell = column * self.rows + row;
            self.of_grain.push(cell as u32);
            self.start[cell + 1] += 1;
        }
        for cell in 0..self.columns * self.rows {
            self.start[cell + 1] += self.start[cell];
        }
        self.grains.clear();
        self.grains.resize(state.position.len(), Sorted::default());
        self.order.clear();
        self.order.resize(state.position.len(), 0);
        // Filling moves each start to the cell's end, and is taken back afterwards.
        for (before, cell) in self.of_grain.iter().enumerate() {
            let at = &mut self.start[*cell as usize];
            let [x, z] = state.position[before];
            self.grains[*at as usize] = Sorted {
                x,
                z,
                radius: state.radius[before],
                number: state.number[before],
                place: if to_be_put { *at } else { before as u32 },
            };
            self.order[*at as usize] = before as u32;
            *at += 1;
        }
        for cell in (1..=self.columns * self.rows).rev() {
            self.start[cell] = self.start[cell - 1];
        }
        self.start[0] = 0;
    }

    /// Column and row of a place.
    fn at(&self, x: f64, z: f64) -> (usize, usize) {
        let column = ((x - self.origin[0]) * self.cells_per_metre) as usize;
        let row = ((z - self.origin[1]) * self.cells_per_metre) as usize;
        (column.min(self.columns - 1), row.min(self.rows - 1))
    }

    /// The grains of the cells around this place, a run of up to three cells a column.
    fn around(&self, x: f64, z: f64) -> impl Iterator<Item = &[Sorted]> {
        let (column, row) = self.at(x, z);
        let first = row.saturating_sub(1);
        let last = (row + 1).min(self.rows - 1);
        let columns = column.saturating_sub(1)..=(column + 1).min(self.columns - 1);
        columns.map(move |column| {
            let from = self.start[column * self.rows + first] as usize;
            let to = self.start[column * self.rows + last + 1] as usize;
            &self.grains[from..to]
        })
    }
}
