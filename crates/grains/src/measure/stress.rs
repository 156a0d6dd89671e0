//! Stresses: the extensive stress of a grain, Eq. 7 of the paper, Σ_ij = Σ_l x_i F_j over its contacts; the stress at the control
//! points, section 3.2.3; the single-grain stresses of a layer, for the shape of their distribution; the mean vertical
//! stress along two lines, across the box at a depth and down the punch axis; and the mean stress of spheres inside their box.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};

use super::Bed;
use super::cells::Cells;
use super::porosity::Layer;
use crate::scene::Scene;

/// The three components of a plane stress or extensive stress, compression positive.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Components {
    /// Horizontal normal component.
    pub xx: f64,
    /// Vertical normal component.
    pub zz: f64,
    /// The symmetric part, ½(xz + zx).
    pub xz: f64,
}

impl From<Matrix3<f64>> for Components {
    fn from(tensor: Matrix3<f64>) -> Self {
        Components {
            xx: tensor[(0, 0)],
            zz: tensor[(2, 2)],
            xz: 0.5 * (tensor[(0, 2)] + tensor[(2, 0)]),
        }
    }
}

/// Σ of every grain, J (in the plane per metre of depth), rows and columns x, y, z: −Σ x_i F_j with x from the grain's centre to the
/// contact point and F the force on the grain, so that compression is positive.
pub fn of_grains(bed: Bed<'_>) -> Vec<Matrix3<f64>> {
    let ids = bed.ids();
    let mut extensive = vec![Matrix3::zeros(); bed.bodies.len()];
    for (at, (contact, force)) in bed.forces().enumerate() {
        let across = bed.across.get(at).map_or(0.0, |across| across.point);
        let force = Vector3::from(force);
        for (id, sign) in [(contact.id1, -1.0), (contact.id2, 1.0)] {
            if !ids.is_grain(id) {
                continue;
            }
            let id = id as usize;
            let centre = bed.bodies.y.get(id).copied().unwrap_or(0.0);
            let arm = Vector3::new(
                contact.point[0] - bed.bodies.x[id],
                across - centre,
                contact.point[1] - bed.bodies.z[id],
            );
            extensive[id] -= sign * (arm * force.transpose());
        }
    }
    extensive
}

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
pub fn at_control_points(
    scene: &Scene,
    bed: Bed<'_>,
    cells: &Cells,
    surface: f64,
) -> Vec<ControlStress> {
    let extensive = of_grains(bed);
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
            let (mut total, mut volume) = (Matrix3::zeros(), 0.0);
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

/// The mean stress of a bed of spheres in this layer, Pa: Σ of every sphere by the share of its volume that lies in the layer, over the
/// layer's volume.
pub fn in_layer(bed: Bed<'_>, layer: &Layer) -> Matrix3<f64> {
    let bodies = bed.bodies;
    let extensive = of_grains(bed);
    let parts = extensive.iter().enumerate().map(|(id, extensive)| {
        let radius = bodies.radius[id];
        let whole = 4.0 / 3.0 * PI * radius.powi(3);
        extensive * (layer.part(bodies.z[id], radius) / whole)
    });
    parts.sum::<Matrix3<f64>>() / layer.volume()
}

/// Depths of the middles of layers, m: that of the paper's control points, and below.
pub const LAYERS: [f64; 4] = [0.11, 0.21, 0.31, 0.41];
/// A layer reaches so far up and down from its middle, m.
const REACH: f64 = 0.05;

/// Σ_zz over the depth below `surface`, J/m, of every grain of the layer about the depth `middle` that is five mean diameters away from
/// the walls. The division takes out that deeper grains bear more, so that all may be of one distribution.
pub fn over_depth(scene: &Scene, bed: Bed<'_>, surface: f64, middle: f64) -> Vec<f64> {
    let inset = 5.0 * scene.particles.mean_diameter;
    let inside = inset..(scene.container.width - inset);
    of_grains(bed)
        .iter()
        .enumerate()
        .filter_map(|(id, of_grain)| {
            let depth = surface - bed.bodies.z[id];
            let wanted = inside.contains(&bed.bodies.x[id]) && (depth - middle).abs() <= REACH;
            wanted.then(|| of_grain[(2, 2)] / depth)
        })
        .collect()
}

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
    extensive: &[Matrix3<f64>],
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
    extensive: &[Matrix3<f64>],
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
    extensive: &[Matrix3<f64>],
    count: usize,
    piece_of: impl Fn(f64, f64) -> Option<usize>,
) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); count];
    for (id, of_grain) in extensive.iter().enumerate() {
        let piece = piece_of(bed.bodies.x[id], bed.bodies.z[id]);
        if let Some(sum) = piece.and_then(|piece| sums.get_mut(piece)) {
            sum.0 += of_grain[(2, 2)];
            sum.1 += cells.area[id];
        }
    }
    let mean = |(stress, cell): (f64, f64)| if cell > 0.0 { stress / cell } else { 0.0 };
    sums.into_iter().map(mean).collect()
}
