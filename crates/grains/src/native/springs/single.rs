//! The springs in single precision. Coordinates are taken from a corner of the grain's cell, so that their
//! last digit is some 10⁻⁸ of a diameter whatever the size of the box; corners are multiples of a
//! power of two, so that the way from one to another is exact.

use multiversion::multiversion;

use super::super::rows::{LANES, Lanes, Rows};

/// What single precision needs beside the rows. Reused from build to build.
#[derive(Debug, Default)]
pub struct Single {
    /// The corner from which each grain's coordinates are taken, m.
    corner: Vec<[f64; 2]>,
    /// Each grain's coordinates from there, m.
    local: Vec<[f32; 2]>,
    /// Of each place in the rows: from the neighbour's corner to the grain's own, R_1 + R_2, k_n.
    columns: Vec<Column>,
}

/// One neighbour of each grain of a group.
#[derive(Debug, Clone)]
pub struct Column {
    pub x: Lanes<f32>,
    pub z: Lanes<f32>,
    pub reach: Lanes<f32>,
    pub stiffness: Lanes<f32>,
}

impl Single {
    /// Takes over new rows. Cells are about as wide as `size`, m.
    pub fn build(&mut self, position: &[[f64; 2]], rows: &Rows, size: f64) {
        let side = size.log2().round().exp2();
        self.corner.clear();
        let corner = |value: f64| (value / side).floor() * side;
        self.corner
            .extend(position.iter().map(|[x, z]| [corner(*x), corner(*z)]));
        self.columns.clear();
        for (grain, columns) in rows.grain.iter().zip(rows.start.windows(2)) {
            for column in columns[0] as usize..columns[1] as usize {
                let way = |lane: usize, axis: usize| {
                    let (own, other) = (grain[lane], rows.other[column][lane]);
                    self.corner[other as usize][axis] - self.corner[own as usize][axis]
                };
                self.columns.push(Column {
                    x: std::array::from_fn(|lane| way(lane, 0) as f32),
                    z: std::array::from_fn(|lane| way(lane, 1) as f32),
                    reach: rows.reach[column].map(|reach| reach as f32),
                    stiffness: rows.stiffness[column].map(|stiffness| stiffness as f32),
                });
            }
        }
    }

    /// The summed spring force on every grain, N.
    pub fn sum_forces(&mut self, position: &[[f64; 2]], rows: &Rows, force: &mut [[f64; 2]]) {
        self.local.clear();
        self.local.extend(
            position
                .iter()
                .zip(&self.corner)
                .map(|(at, corner)| [(at[0] - corner[0]) as f32, (at[1] - corner[1]) as f32]),
        );
        #[cfg(target_arch = "x86_64")]
        if super::avx512::available() {
            return super::avx512::sum_single(&self.local, &self.columns, rows, force);
        }
        sum_forces_plain(&self.local, &self.columns, rows, force);
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn sum_forces_plain(local: &[[f32; 2]], all: &[Column], rows: &Rows, force: &mut [[f64; 2]]) {
    for (grain, columns) in rows.grain.iter().zip(rows.start.windows(2)) {
        let columns = columns[0] as usize..columns[1] as usize;
        let own = gather(local, grain);
        let (mut sum_x, mut sum_z) = ([0.0f32; LANES], [0.0f32; LANES]);
        for (column, other) in all[columns.clone()].iter().zip(&rows.other[columns]) {
            let there = gather(local, other);
            for lane in 0..LANES {
                let dx = (there.0[lane] - own.0[lane]) + column.x[lane];
                let dz = (there.1[lane] - own.1[lane]) + column.z[lane];
                let distance = (dx * dx + dz * dz).sqrt();
                let share = column.reach[lane] / distance - 1.0;
                let size = column.stiffness[lane] * share;
                let touching = u32::from(share >= 0.0).wrapping_neg();
                sum_x[lane] -= f32::from_bits((size * dx).to_bits() & touching);
                sum_z[lane] -= f32::from_bits((size * dz).to_bits() & touching);
            }
        }
        for lane in 0..LANES {
            force[grain[lane] as usize] = [f64::from(sum_x[lane]), f64::from(sum_z[lane])];
        }
    }
}

#[inline(always)]
fn gather(of: &[[f32; 2]], ids: &Lanes<u32>) -> (Lanes<f32>, Lanes<f32>) {
    let (mut x, mut z) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        [x[lane], z[lane]] = of[ids[lane] as usize];
    }
    (x, z)
}
