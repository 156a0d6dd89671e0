//! Mean vertical stress along two lines: across the box at a depth, and down the punch axis.

use nalgebra::Matrix2;

use super::Bed;
use super::cells::Cells;
use crate::scene::Scene;

/// A piece of a line is so many mean diameters long, and so many high where the line is level.
const PIECE: f64 = 2.0;

/// Length of a piece, m, for a line of this length: it is divided evenly.
pub fn piece(scene: &Scene, length: f64) -> f64 {
    length / pieces(scene, length) as f64
}

fn pieces(scene: &Scene, length: f64) -> usize {
    ((length / (PIECE * scene.particles.mean_diameter)).round() as usize).max(1)
}

/// σ_zz, Pa, in every piece of the level line at `height`, wall to wall: ΣΣ_zz/ΣV_p over the grains with centres in
/// the piece and at most one mean diameter above or below the line. Zero where there is no grain.
pub fn across(
    scene: &Scene,
    bed: Bed<'_>,
    cells: &Cells,
    extensive: &[Matrix2<f64>],
    height: f64,
) -> Vec<f64> {
    let width = scene.container.width;
    let reach = 0.5 * PIECE * scene.particles.mean_diameter;
    let (count, length) = (pieces(scene, width), piece(scene, width));
    mean_stress(bed, cells, extensive, count, |x, z| {
        ((z - height).abs() <= reach).then_some((x / length) as usize)
    })
}

/// σ_zz, Pa, in every piece down the punch axis from `surface` to the floor: ΣΣ_zz/ΣV_p over the grains with
/// centres in the piece and no further from the axis than the punch's half-width. Zero where there is no grain.
pub fn down(
    scene: &Scene,
    bed: Bed<'_>,
    cells: &Cells,
    extensive: &[Matrix2<f64>],
    surface: f64,
) -> Vec<f64> {
    let axis = scene.punch_axis();
    let (count, length) = (pieces(scene, surface), piece(scene, surface));
    mean_stress(bed, cells, extensive, count, |x, z| {
        let under = (x - axis).abs() <= scene.loading.half_width && z <= surface;
        under.then(|| ((surface - z) / length) as usize)
    })
}

fn mean_stress(
    bed: Bed<'_>,
    cells: &Cells,
    extensive: &[Matrix2<f64>],
    count: usize,
    piece_of: impl Fn(f64, f64) -> Option<usize>,
) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); count];
    for (id, of_grain) in extensive.iter().enumerate() {
        let piece = piece_of(bed.bodies.x[id], bed.bodies.z[id]);
        if let Some(sum) = piece.and_then(|piece| sums.get_mut(piece)) {
            sum.0 += of_grain[(1, 1)];
            sum.1 += cells.area[id];
        }
    }
    let mean = |(stress, cell): (f64, f64)| if cell > 0.0 { stress / cell } else { 0.0 };
    sums.into_iter().map(mean).collect()
}
