//! Stress at the control points, section 3.2.3 of the paper.

use nalgebra::Matrix2;

use super::Bed;
use super::cells::Cells;
use super::extensive_stress::{self, Components};
use crate::scene::Scene;

/// What is read at one control point.
#[derive(Debug, Clone, PartialEq)]
pub struct ControlStress {
    /// The point's name in the scene.
    pub name: String,
    /// Place of the point, m.
    pub place: [f64; 2],
    /// The grain with the nearest centre.
    pub grain: u32,
    /// σ = Σ^p/V_p of that grain, Pa.
    pub grain_stress: Components,
    /// Σ^c_zz = Σ^p_zz V_c/V_p with V_c a square of the scene's side, J per metre of depth.
    pub control_volume_zz: f64,
    /// ΣΣ^p/ΣV_p over the grains with centres within the scene's local radius, Pa; none if there are none.
    pub local_mean: Option<Components>,
}

/// The stress at every control point, depths counted from `surface`; a point that is not inside the
/// bed has none.
pub fn all(scene: &Scene, bed: Bed<'_>, cells: &Cells, surface: f64) -> Vec<ControlStress> {
    let extensive = extensive_stress::of_grains(bed);
    let side = scene.measurement.control_volume_side;
    scene
        .control_points
        .iter()
        .filter_map(|point| {
            let place = [scene.punch_axis() + point.offset, surface - point.depth];
            if place[1] <= 0.0 {
                return None;
            }
            let distance =
                |id: usize| (bed.bodies.x[id] - place[0]).hypot(bed.bodies.z[id] - place[1]);
            let grain =
                (0..bed.bodies.len()).min_by(|a, b| distance(*a).total_cmp(&distance(*b)))?;
            let (mut total, mut volume) = (Matrix2::zeros(), 0.0);
            for (id, (of_grain, area)) in extensive.iter().zip(&cells.area).enumerate() {
                if distance(id) <= scene.measurement.local_radius {
                    total += of_grain;
                    volume += area;
                }
            }
            let stress = Components::from(extensive[grain] / cells.area[grain]);
            Some(ControlStress {
                name: point.name.clone(),
                place,
                grain: grain as u32,
                grain_stress: stress,
                control_volume_zz: stress.zz * side * side,
                local_mean: (volume > 0.0).then(|| Components::from(total / volume)),
            })
        })
        .collect()
}
