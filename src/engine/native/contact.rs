//! The contact law, scalar and obvious: overlap, normal stiffness (Eq. 4 of the paper) and normal
//! force for each kind of pair. The reference for the fast kernel, and what snapshots report.
//!
//! The order of the operations is part of the definition: it is what gives YADE's bits.

/// Overlap, force and geometry of one pair in contact. The normal points from body 1 to body 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairForce {
    /// u_n ≥ 0, m.
    pub overlap: f64,
    /// Unit vector from body 1 to body 2.
    pub normal: [f64; 2],
    /// Force on body 2, N: (k_n u_n) n.
    pub force: [f64; 2],
    /// m.
    pub point: [f64; 2],
}

/// Normal stiffness of two grains, N/m: k_n = 2 k_a k_b/(k_a + k_b) with k = E·R, which for equal
/// moduli is Eq. 4, k_n = 2E R_i R_j/(R_i + R_j). A flat body counts as a grain of the same radius.
pub fn normal_stiffness(modulus: f64, radius1: f64, radius2: f64) -> f64 {
    let a = modulus * radius1;
    let b = modulus * radius2;
    2.0 * a * b / (a + b)
}

/// Two grains: u_n = R_1 + R_2 − d, n along the line of centres.
pub fn grains(
    position1: [f64; 2],
    radius1: f64,
    position2: [f64; 2],
    radius2: f64,
    stiffness: f64,
) -> Option<PairForce> {
    let dx = position2[0] - position1[0];
    let dz = position2[1] - position1[1];
    let distance = (dx * dx + dz * dz).sqrt();
    let overlap = radius1 + radius2 - distance;
    if overlap < 0.0 {
        return None;
    }
    let normal = [dx / distance, dz / distance];
    let arm = radius1 - 0.5 * overlap;
    Some(PairForce {
        overlap,
        normal,
        force: along(normal, stiffness * overlap),
        point: [
            position1[0] + arm * normal[0],
            position1[1] + arm * normal[1],
        ],
    })
}

/// Which coordinate a wall holds fixed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Across.
    X = 0,
    /// Up.
    Z = 1,
}

/// An infinite wall (body 1) and a grain: u_n = R − |distance|, n towards the grain's side, the
/// contact point on the wall.
pub fn wall(
    axis: Axis,
    place: f64,
    position: [f64; 2],
    radius: f64,
    stiffness: f64,
) -> Option<PairForce> {
    let axis = axis as usize;
    let distance = position[axis] - place;
    let overlap = -(distance.abs() - radius);
    if overlap < 0.0 {
        return None;
    }
    let mut normal = [0.0, 0.0];
    normal[axis] = if distance > 0.0 { 1.0 } else { -1.0 };
    let mut point = position;
    point[axis] = place;
    Some(PairForce {
        overlap,
        normal,
        force: along(normal, stiffness * overlap),
        point,
    })
}

/// The rectangular punch (body 1) and a grain whose centre is outside it: s from the grain's centre to the
/// nearest point of the rectangle, u_n = R − |s|, n = −s/|s|; corners act as points.
pub fn punch(
    centre: [f64; 2],
    half_extents: [f64; 2],
    position: [f64; 2],
    radius: f64,
    stiffness: f64,
) -> Option<PairForce> {
    let relative = [position[0] - centre[0], position[1] - centre[1]];
    let clamp = |axis: usize| relative[axis].clamp(-half_extents[axis], half_extents[axis]);
    let s = [clamp(0) - relative[0], clamp(1) - relative[1]];
    let distance = (s[0] * s[0] + s[1] * s[1]).sqrt();
    let overlap = radius - distance;
    if overlap < 0.0 || distance == 0.0 {
        return None;
    }
    let towards = [s[0] / distance, s[1] / distance];
    let normal = [-towards[0], -towards[1]];
    // The middle between the rectangle's nearest point and the grain's deepest one.
    let middle = |axis: usize| {
        0.5 * ((clamp(axis) + centre[axis]) + (position[axis] + towards[axis] * radius))
    };
    Some(PairForce {
        overlap,
        normal,
        force: along(normal, stiffness * overlap),
        point: [middle(0), middle(1)],
    })
}

fn along(normal: [f64; 2], force: f64) -> [f64; 2] {
    [force * normal[0], force * normal[1]]
}
