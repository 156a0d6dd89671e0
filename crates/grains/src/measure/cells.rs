//! Radical (power) Voronoi cells: the volume V_p of a grain and the void around it.
//!
//! A point belongs to the grain with the smallest |x − c|² − R². Between two grains at distance d
//! the border is the line at t = (d² + R_i² − R_j²)/2d from grain i. Cells are cut off at floor,
//! walls and the height of the highest grain, so together they tile that rectangle.

use std::f64::consts::PI;

use super::{highest_grain, porosity};
use crate::scene::{Cell, Scene};
use crate::tables::Bodies;

/// The cells of all grains.
#[derive(Debug, Clone, PartialEq)]
pub struct Cells {
    /// Area of each grain's cell, m²; times 1 m of depth it is V_p.
    pub area: Vec<f64>,
    /// Corners of each radical cell, counter-clockwise, m.
    pub corners: Vec<Vec<[f64; 2]>>,
}

/// The cells that the scene asks for.
pub fn of(scene: &Scene, bodies: &Bodies) -> Cells {
    let mut cells = radical(scene, bodies);
    if scene.measurement.cell == Cell::EqualPorosity {
        let over_solid = cells.area.iter().sum::<f64>() / porosity::solid_area(bodies);
        let of_grains = bodies.radius.iter().map(|radius| PI * radius * radius);
        cells.area = of_grains.map(|grain| grain * over_solid).collect();
    }
    cells
}

/// The radical cell of every grain.
pub fn radical(scene: &Scene, bodies: &Bodies) -> Cells {
    let top = highest_grain(bodies);
    let width = scene.container.width;
    let grid = Grid::new(bodies);
    let corners: Vec<Vec<[f64; 2]>> = (0..bodies.len())
        .map(|grain| {
            let rectangle = vec![[0.0, 0.0], [width, 0.0], [width, top], [0.0, top]];
            cell(grain, rectangle, bodies, &grid)
        })
        .collect();
    Cells {
        area: corners.iter().map(|corners| area(corners)).collect(),
        corners,
    }
}

/// Clips `polygon` by ever further rings of grains until none further off can reach it.
fn cell(grain: usize, mut polygon: Vec<[f64; 2]>, bodies: &Bodies, grid: &Grid) -> Vec<[f64; 2]> {
    let centre = [bodies.x[grain], bodies.z[grain]];
    let power = bodies.radius[grain] * bodies.radius[grain];
    let mut scratch = Vec::new();
    for ring in 0..=grid.columns.max(grid.rows) {
        for other in grid.ring(grain, ring) {
            if other == grain {
                continue;
            }
            let apart = [bodies.x[other] - centre[0], bodies.z[other] - centre[1]];
            let square = apart[0] * apart[0] + apart[1] * apart[1];
            let other_power = bodies.radius[other] * bodies.radius[other];
            // Points x of the cell have (x − c)·apart ≤ ½(d² + R_i² − R_j²).
            let bound = 0.5 * (square + power - other_power);
            clip(&mut polygon, &mut scratch, centre, apart, bound);
        }
        // The next ring is at least this far off.
        let distance = ring as f64 * grid.side;
        let reach = polygon
            .iter()
            .map(|corner| (corner[0] - centre[0]).hypot(corner[1] - centre[1]))
            .fold(0.0, f64::max);
        let nearest_border =
            0.5 * (distance * distance + power - grid.largest * grid.largest) / distance;
        if ring > 0 && nearest_border > reach {
            break;
        }
    }
    polygon
}

/// Keeps the part of the polygon where (x − origin)·direction ≤ bound.
fn clip(
    polygon: &mut Vec<[f64; 2]>,
    scratch: &mut Vec<[f64; 2]>,
    origin: [f64; 2],
    direction: [f64; 2],
    bound: f64,
) {
    let excess = |corner: &[f64; 2]| {
        (corner[0] - origin[0]) * direction[0] + (corner[1] - origin[1]) * direction[1] - bound
    };
    scratch.clear();
    for (corner, next) in sides(polygon) {
        let (here, there) = (excess(corner), excess(next));
        if here <= 0.0 {
            scratch.push(*corner);
        }
        if (here < 0.0 && there > 0.0) || (here > 0.0 && there < 0.0) {
            let share = here / (here - there);
            scratch.push([
                corner[0] + share * (next[0] - corner[0]),
                corner[1] + share * (next[1] - corner[1]),
            ]);
        }
    }
    std::mem::swap(polygon, scratch);
}

/// Each corner with the next one.
fn sides(corners: &[[f64; 2]]) -> impl Iterator<Item = (&[f64; 2], &[f64; 2])> {
    corners.iter().zip(corners.iter().cycle().skip(1))
}

fn area(corners: &[[f64; 2]]) -> f64 {
    let cross = sides(corners).map(|(here, next)| here[0] * next[1] - next[0] * here[1]);
    0.5 * cross.fold(0.0, |sum, term| sum + term)
}

/// Grains by square cells one largest diameter wide.
struct Grid {
    side: f64,
    columns: usize,
    rows: usize,
    largest: f64,
    grains: Vec<Vec<u32>>,
    place: Vec<(usize, usize)>,
}

impl Grid {
    fn new(bodies: &Bodies) -> Self {
        let least = |column: &[f64]| column.iter().copied().fold(f64::INFINITY, f64::min);
        let most = |column: &[f64]| column.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let largest = most(&bodies.radius);
        let origin = [least(&bodies.x), least(&bodies.z)];
        let extent = [most(&bodies.x) - origin[0], most(&bodies.z) - origin[1]];
        // Far-flung grains must not cost more cells than a few a grain.
        let cells = 4.0 * bodies.len() as f64 + 64.0;
        let coarse = (extent[0] * extent[1] / cells).sqrt();
        let thin = extent[0].max(extent[1]) / cells;
        let side = (2.0 * largest).max(coarse).max(thin);
        let columns = (extent[0] / side) as usize + 1;
        let rows = (extent[1] / side) as usize + 1;
        let mut grains = vec![Vec::new(); columns * rows];
        let mut place = Vec::with_capacity(bodies.len());
        for id in 0..bodies.len() {
            let column = (((bodies.x[id] - origin[0]) / side) as usize).min(columns - 1);
            let row = (((bodies.z[id] - origin[1]) / side) as usize).min(rows - 1);
            grains[row * columns + column].push(id as u32);
            place.push((column, row));
        }
        Grid {
            side,
            columns,
            rows,
            largest,
            grains,
            place,
        }
    }

    /// Grains of the cells whose larger distance in rows or columns from the grain's cell is `ring`.
    fn ring(&self, grain: usize, ring: usize) -> impl Iterator<Item = usize> {
        let (column, row) = self.place[grain];
        let rows = row.saturating_sub(ring)..=(row + ring).min(self.rows - 1);
        rows.flat_map(move |r| {
            let edge_row = r.abs_diff(row) == ring;
            let from = column.saturating_sub(ring);
            let to = (column + ring).min(self.columns - 1);
            (from..=to)
                .filter(move |c| edge_row || c.abs_diff(column) == ring)
                .flat_map(move |c| self.grains[r * self.columns + c].iter())
                .map(|id| *id as usize)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::initial_bodies;
    use crate::scene::paper_scene;

    #[test]
    fn cells_tile_the_rectangle_below_the_highest_grain() {
        let scene = paper_scene(3, 700);
        let bodies = initial_bodies(&scene);
        let cells = radical(&scene, &bodies);
        let whole = scene.container.width * highest_grain(&bodies);
        let sum: f64 = cells.area.iter().sum();
        assert!((sum / whole - 1.0).abs() < 1e-12, "{sum} {whole}");
    }

    #[test]
    fn a_point_of_a_cell_has_its_least_power_distance_to_the_cells_own_grain() {
        let scene = paper_scene(4, 300);
        let bodies = initial_bodies(&scene);
        let cells = radical(&scene, &bodies);
        let power = |id: usize, point: [f64; 2]| {
            (point[0] - bodies.x[id]).powi(2) + (point[1] - bodies.z[id]).powi(2)
                - bodies.radius[id].powi(2)
        };
        for (grain, corners) in cells.corners.iter().enumerate() {
            for corner in corners {
                let least = (0..bodies.len())
                    .map(|id| power(id, *corner))
                    .fold(f64::INFINITY, f64::min);
                assert!(power(grain, *corner) - least < 1e-15);
            }
        }
    }
}
