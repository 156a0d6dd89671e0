//! The neighbour list: which pairs may touch before anything has moved further than the skin allows.
//!
//! Built on a grid of square cells; pairs come out sorted by (id1, id2), the order in which forces
//! are summed. The skin decides how often the list is rebuilt and never what a step gives: pairs
//! that do not touch add nothing.

use super::contact::{Memory, Parameters};
use super::dynamics::Fastest;
use super::general::History;
use super::springs::{Pair, Rows};
use super::state::{Constants, State};
use crate::model::Kernel;
use crate::tables::Remembered;

/// Candidate pairs and the positions they were made for. Reused from build to build.
#[derive(Debug, Default)]
pub struct Neighbours {
    /// Row pointers: the pairs of grain i are `start[i]..start[i+1]`.
    pub start: Vec<u32>,
    /// The other grain of each pair, higher than the row's.
    pub other: Vec<u32>,
    /// The row's grain, pair by pair.
    pub grain: Vec<u32>,
    /// The pairs laid out for vector lanes; empty for the general kernel.
    pub rows: Rows,
    /// Grains near each wall, in order of id; one list a wall of [`Constants::walls`].
    pub by_wall: Vec<Vec<u32>>,
    /// Grains near the punch, in order of id.
    pub by_punch: Vec<u32>,
    /// What contacts remember; empty for the frictionless kernel.
    pub history: History,
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
    /// Steps since the build.
    held: u32,
    /// How often it was built.
    pub builds: u64,
    cells: Cells,
    row: Vec<u32>,
}

/// Grains sorted into square cells.
#[derive(Debug, Default)]
struct Cells {
    /// One over the side of a cell, 1/m.
    cells_per_metre: f64,
    origin: [f64; 2],
    columns: usize,
    rows: usize,
    /// The grains of cell c are `grains[start[c]..start[c+1]]`, in order of id.
    start: Vec<u32>,
    grains: Vec<Sorted>,
    /// The cell of each grain.
    of_grain: Vec<u32>,
}

/// A grain in its cell, with what is asked of it.
#[derive(Debug, Clone, Copy, Default)]
struct Sorted {
    x: f64,
    z: f64,
    radius: f64,
    id: u32,
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
const LEAST_SKIN: f64 = 0.02;

/// Nor more: in free flight a few more pairs cost nothing, in a bed they do.
const LARGEST_SKIN: f64 = 1.0;

/// For the few ids of a row.
fn insertion_sort(row: &mut [u32]) {
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
    /// An empty list.
    pub fn new(policy: Skin) -> Self {
        Neighbours {
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
        let punch_moved = punch_height.map_or(0.0, |height| (height - self.punch_reference).abs());
        // Two grains may approach each other by twice a displacement, a grain and the punch by one each.
        let limit = (0.5 * self.skin).min(self.skin - punch_moved);
        // A little less, so that the rounding of distances does not matter.
        let limit = (1.0 - 1.0e-9) * limit;
        if self.displaced + self.gone_since <= limit {
            return true;
        }
        self.displaced = furthest(position, &self.reference);
        self.gone_since = 0.0;
        self.displaced <= limit
    }

    /// Lists anew what is near what.
    pub fn build(&mut self, state: &State, constants: &Constants) {
        self.builds += 1;
        self.skin = self.policy.of(fastest_way(state, constants));
        self.held = 0;
        self.cells.sort(state, self.skin);
        let general = constants.kernel() == Kernel::General;
        if general {
            self.history
                .set_aside(&self.start, &self.other, &self.by_wall, &self.by_punch);
        }
        self.grain_pairs(state, constants);
        self.flat_bodies(state, constants);
        if general {
            let of_pair = |first: u32, second: u32| {
                let of = |id: u32| (state.radius[id as usize], state.mass[id as usize]);
                let ((r1, m1), (r2, m2)) = (of(first), of(second));
                let effective = m1 * m2 / (m1 + m2);
                ([r1, r2], constants.parameters(r1, r2, effective))
            };
            self.history.take_over(
                &self.start,
                &self.other,
                &self.by_wall,
                &self.by_punch,
                of_pair,
            );
        } else {
            self.lay_out_rows(state, constants);
        }
        self.reference.clear();
        self.reference.extend_from_slice(&state.position);
        self.punch_reference = state.punch.map_or(0.0, |punch| punch.centre[1]);
        self.displaced = 0.0;
        self.gone_since = 0.0;
    }

    /// Lists these contacts, sorted by ids, and nothing else: the next [`Neighbours::build`] finds their memory.
    pub fn recall(&mut self, grains: usize, constants: &Constants, contacts: &[Remembered]) {
        self.start.clear();
        self.other.clear();
        let of = |id: u32| {
            let first = contacts.partition_point(|of| of.id1 < id);
            let last = contacts.partition_point(|of| of.id1 <= id);
            &contacts[first..last]
        };
        let memory = |of: &Remembered| Memory {
            normal: of.normal,
            shear: of.shear,
        };
        let History {
            pairs,
            by_wall,
            by_punch,
            ..
        } = &mut self.history;
        pairs.clear();
        self.start.push(0);
        for id in 0..grains as u32 {
            for contact in of(id) {
                let ids = (id, contact.id2);
                pairs.push(ids, [0.0; 2], &Parameters::default(), &memory(contact));
                self.other.push(contact.id2);
            }
            self.start.push(self.other.len() as u32);
        }
        let flat = |id| of(id).iter().map(|of| (of.id2, memory(of))).unzip();
        let ids = constants.walls.iter().map(|wall| wall.id);
        (self.by_wall, *by_wall) = ids.map(flat).unzip();
        (self.by_punch, *by_punch) = flat(constants.ids.punch());
    }

    /// The listed pairs as (id1, id2).
    pub fn pairs(&self) -> impl Iterator<Item = (u32, u32)> {
        self.grain.iter().copied().zip(self.other.iter().copied())
    }

    fn lay_out_rows(&mut self, state: &State, constants: &Constants) {
        let radius = &state.radius;
        let pairs = self.grain.iter().zip(&self.other).map(|(first, second)| {
            let (r1, r2) = (radius[*first as usize], radius[*second as usize]);
            Pair {
                first: *first,
                second: *second,
                reach: r1 + r2,
                stiffness: constants.stiffness(r1, r2),
            }
        });
        self.rows.build(radius.len(), pairs);
    }

    fn grain_pairs(&mut self, state: &State, constants: &Constants) {
        self.start.clear();
        self.other.clear();
        self.grain.clear();
        self.start.push(0);
        for (i, ([x, z], radius)) in state.position.iter().zip(&state.radius).enumerate() {
            let id = i as u32;
            let mut found = 0;
            for near in self.cells.around(i) {
                if self.row.len() < found + near.len() {
                    self.row.resize(found + near.len(), 0);
                }
                for grain in near {
                    let (dx, dz) = (grain.x - x, grain.z - z);
                    let far = radius + grain.radius + self.skin;
                    let listed = (grain.id > id) & (dx * dx + dz * dz <= far * far);
                    // Written in any case and kept by counting, so that nothing has to be guessed.
                    self.row[found] = grain.id;
                    found += usize::from(listed);
                }
            }
            let row = &mut self.row[..found];
            insertion_sort(row);
            if constants.reversed_sums {
                row.reverse();
            }
            self.other.extend_from_slice(row);
            self.grain.resize(self.other.len(), id);
            self.start.push(self.other.len() as u32);
        }
    }

    fn flat_bodies(&mut self, state: &State, constants: &Constants) {
        self.by_wall.resize_with(constants.walls.len(), Vec::new);
        for (wall, near) in constants.walls.iter().zip(&mut self.by_wall) {
            near.clear();
            let axis = wall.axis as usize;
            near.extend((0..state.position.len() as u32).filter(|&id| {
                let distance = (state.position[id as usize][axis] - wall.place).abs();
                distance <= state.radius[id as usize] + self.skin
            }));
        }
        self.by_punch.clear();
        if let Some(punch) = &state.punch {
            self.by_punch
                .extend((0..state.position.len() as u32).filter(|&id| {
                    let position = state.position[id as usize];
                    let far = state.radius[id as usize] + self.skin;
                    (0..2).all(|axis| {
                        (position[axis] - punch.centre[axis]).abs()
                            <= punch.half_extents[axis] + far
                    })
                }));
        }
    }
}

impl Cells {
    /// Counting sort of the grains into cells that are as wide as the furthest listed pair.
    fn sort(&mut self, state: &State, skin: f64) {
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
            let cell = self.cell(*position);
            self.of_grain.push(cell as u32);
            self.start[cell + 1] += 1;
        }
        for cell in 0..self.columns * self.rows {
            self.start[cell + 1] += self.start[cell];
        }
        self.grains.clear();
        self.grains.resize(state.position.len(), Sorted::default());
        // Filling moves each start to the cell's end; going backwards keeps the ids in order.
        for (id, cell) in self.of_grain.iter().enumerate() {
            let place = &mut self.start[*cell as usize];
            let [x, z] = state.position[id];
            self.grains[*place as usize] = Sorted {
                x,
                z,
                radius: state.radius[id],
                id: id as u32,
            };
            *place += 1;
        }
        for cell in (1..=self.columns * self.rows).rev() {
            self.start[cell] = self.start[cell - 1];
        }
        self.start[0] = 0;
    }

    fn cell(&self, position: [f64; 2]) -> usize {
        let column = ((position[0] - self.origin[0]) * self.cells_per_metre) as usize;
        let row = ((position[1] - self.origin[1]) * self.cells_per_metre) as usize;
        row.min(self.rows - 1) * self.columns + column.min(self.columns - 1)
    }

    /// The grains of the cells around grain `id`, a run of up to three cells a row of cells.
    fn around(&self, id: usize) -> impl Iterator<Item = &[Sorted]> {
        let cell = self.of_grain[id] as usize;
        let (row, column) = (cell / self.columns, cell % self.columns);
        let first = column.saturating_sub(1);
        let last = (column + 1).min(self.columns - 1);
        let rows = row.saturating_sub(1)..=(row + 1).min(self.rows - 1);
        rows.map(move |row| {
            let from = self.start[row * self.columns + first] as usize;
            let to = self.start[row * self.columns + last + 1] as usize;
            &self.grains[from..to]
        })
    }
}
