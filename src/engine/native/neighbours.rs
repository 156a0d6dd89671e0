//! The neighbour list: which pairs may touch before anything has moved further than the skin allows.
//!
//! Built on a grid of square cells; pairs come out sorted by (id1, id2), the order in which forces
//! are summed. The skin decides how often the list is rebuilt and never what a step gives: pairs
//! that do not touch add nothing.

use super::constants::Constants;
use super::history::History;
use super::state::State;
use crate::model::terms::Kernel;

/// Candidate pairs and the positions they were made for. Reused from build to build.
#[derive(Debug, Default)]
pub struct Neighbours {
    /// Row pointers: the pairs of grain i are `start[i]..start[i+1]`.
    pub start: Vec<u32>,
    /// The other grain of each pair, higher than the row's.
    pub other: Vec<u32>,
    /// The row's grain, pair by pair.
    pub grain: Vec<u32>,
    /// R_1 + R_2 of each pair, m.
    pub reach: Vec<f64>,
    /// k_n of each pair, N/m.
    pub stiffness: Vec<f64>,
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
    /// Pairs within this distance beyond touching are listed, m.
    skin: f64,
    /// How often it was built.
    pub builds: u64,
    cells: Cells,
    row: Vec<u32>,
}

/// Grains sorted into square cells.
#[derive(Debug, Default)]
struct Cells {
    /// Side of a cell, m.
    side: f64,
    origin: [f64; 2],
    columns: usize,
    rows: usize,
    /// The grains of cell c are `grains[start[c]..start[c+1]]`, in order of id.
    start: Vec<u32>,
    grains: Vec<u32>,
    /// The cell of each grain.
    of_grain: Vec<u32>,
}

impl Neighbours {
    /// An empty list with this skin, m.
    pub fn new(skin: f64) -> Self {
        Neighbours {
            skin,
            ..Neighbours::default()
        }
    }

    /// The largest square of a grain's displacement that leaves every possible contact in the list;
    /// negative, which no displacement is, once the punch alone has moved too far.
    pub fn displacement_limit_squared(&self, punch_height: Option<f64>) -> f64 {
        let punch_moved = punch_height.map_or(0.0, |height| (height - self.punch_reference).abs());
        // Two grains may approach each other by twice a displacement, a grain and the punch by one each.
        let limit = (0.5 * self.skin).min(self.skin - punch_moved);
        // A little less, so that the rounding of distances does not matter.
        (1.0 - 1.0e-9) * limit * limit.abs()
    }

    /// Lists anew what is near what.
    pub fn build(&mut self, state: &State, constants: &Constants) {
        self.builds += 1;
        self.cells.sort(state, self.skin);
        let general = constants.kernel() == Kernel::General;
        if general {
            self.history
                .set_aside(&self.start, &self.other, &self.by_wall, &self.by_punch);
        }
        self.grain_pairs(state, constants);
        self.flat_bodies(state, constants);
        if general {
            self.history
                .take_over(&self.start, &self.other, &self.by_wall, &self.by_punch);
            self.pair_parameters(state, constants);
        }
        self.reference.clear();
        self.reference.extend_from_slice(&state.position);
        self.punch_reference = state.punch.map_or(0.0, |punch| punch.centre[1]);
    }

    /// The listed pairs as (id1, id2).
    pub fn pairs(&self) -> impl Iterator<Item = (u32, u32)> {
        self.grain.iter().copied().zip(self.other.iter().copied())
    }

    fn pair_parameters(&mut self, state: &State, constants: &Constants) {
        self.history.parameters.clear();
        for (a, b) in self.grain.iter().zip(&self.other) {
            let (a, b) = (*a as usize, *b as usize);
            let (m1, m2) = (state.mass[a], state.mass[b]);
            let effective = m1 * m2 / (m1 + m2);
            let (r1, r2) = (state.radius[a], state.radius[b]);
            let parameters = constants.parameters(r1, r2, effective);
            self.history.parameters.push(parameters);
        }
    }

    fn grain_pairs(&mut self, state: &State, constants: &Constants) {
        self.start.clear();
        self.other.clear();
        self.grain.clear();
        self.reach.clear();
        self.stiffness.clear();
        self.start.push(0);
        for i in 0..state.position.len() {
            let [x, z] = state.position[i];
            let radius = state.radius[i];
            self.row.clear();
            for cell_row in self.cells.around(i) {
                for &other in cell_row {
                    let j = other as usize;
                    if j <= i {
                        continue;
                    }
                    let (dx, dz) = (state.position[j][0] - x, state.position[j][1] - z);
                    let far = radius + state.radius[j] + self.skin;
                    if dx * dx + dz * dz <= far * far {
                        self.row.push(other);
                    }
                }
            }
            self.row.sort_unstable();
            if constants.reversed_sums {
                self.row.reverse();
            }
            for &other in &self.row {
                let j = other as usize;
                self.grain.push(i as u32);
                self.other.push(other);
                self.reach.push(radius + state.radius[j]);
                self.stiffness
                    .push(constants.stiffness(radius, state.radius[j]));
            }
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
        self.side = (2.0 * largest + skin).max(coarse).max(thin);
        self.columns = (extent[0] / self.side) as usize + 1;
        self.rows = (extent[1] / self.side) as usize + 1;

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
        self.grains.resize(state.position.len(), 0);
        // Filling moves each start to the cell's end; going backwards keeps the ids in order.
        for (id, cell) in self.of_grain.iter().enumerate() {
            let place = &mut self.start[*cell as usize];
            self.grains[*place as usize] = id as u32;
            *place += 1;
        }
        for cell in (1..=self.columns * self.rows).rev() {
            self.start[cell] = self.start[cell - 1];
        }
        self.start[0] = 0;
    }

    fn cell(&self, position: [f64; 2]) -> usize {
        let column = ((position[0] - self.origin[0]) / self.side) as usize;
        let row = ((position[1] - self.origin[1]) / self.side) as usize;
        row.min(self.rows - 1) * self.columns + column.min(self.columns - 1)
    }

    /// The grains of the cells around grain `id`, a run of up to three cells a row of cells.
    fn around(&self, id: usize) -> impl Iterator<Item = &[u32]> {
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
