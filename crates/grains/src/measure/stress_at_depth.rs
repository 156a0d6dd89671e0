//! The single-grain stresses of a layer, for the shape of their distribution.

use super::Bed;
use super::extensive_stress;
use crate::scene::Scene;

/// Depth of the middle of the layer, m: that of the paper's control points.
const DEPTH: f64 = 0.11;
/// The layer reaches so far up and down from its middle, m.
const REACH: f64 = 0.05;

/// Σ_zz over the depth below `surface`, J/m, of every grain of the layer that is five mean diameters away from
/// the walls. The division takes out that deeper grains bear more, so that all may be of one distribution.
pub fn scaled(scene: &Scene, bed: Bed<'_>, surface: f64) -> Vec<f64> {
    let inset = 5.0 * scene.particles.mean_diameter;
    let inside = inset..(scene.container.width - inset);
    extensive_stress::of_grains(bed)
        .iter()
        .enumerate()
        .filter_map(|(id, of_grain)| {
            let depth = surface - bed.bodies.z[id];
            let wanted = inside.contains(&bed.bodies.x[id]) && (depth - DEPTH).abs() <= REACH;
            wanted.then(|| of_grain[(1, 1)] / depth)
        })
        .collect()
}
