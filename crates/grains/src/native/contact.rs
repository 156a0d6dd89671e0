//! Contact geometry and normal stiffness: where two bodies touch, and how stiff the contact is
//! (Eq. 4 of the paper). Scalar and obvious: the reference for the fast kernel.
//!
//! The order of the operations is part of the definition: it is what gives YADE's bits.

pub use crate::model::Axis;

/// Where two bodies touch. The normal points from body 1 to body 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// u_n ≥ 0, m.
    pub overlap: f64,
    /// Unit vector from body 1 to body 2.
    pub normal: [f64; 2],
    /// m.
    pub point: [f64; 2],
    /// Radii of curvature of both sides, m; a flat body has the grain's.
    pub radii: [f64; 2],
    /// What kind of pair it is.
    pub pair: Pair,
}

/// The kinds of pairs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pair {
    /// Two grains.
    Grains,
    /// A wall and a grain.
    Wall,
    /// The punch and a grain whose centre is outside it: at a face, an edge or a corner.
    PunchOutside,
    /// The punch and a grain whose centre is inside it.
    PunchInside,
}

impl Touch {
    /// Force of a linear spring on body 2, N: (k_n u_n) n.
    pub fn spring_force(&self, stiffness: f64) -> [f64; 2] {
        let force = stiffness * self.overlap;
        [force * self.normal[0], force * self.normal[1]]
    }
}

/// Stiffness of two grains' springs k = E·R in series, N/m: 2 k_a k_b/(k_a + k_b), which for equal moduli is Eq. 4,
/// k_n = 2E R_i R_j/(R_i + R_j). A flat body counts as a grain of the same radius.
pub fn in_series(a: f64, b: f64) -> f64 {
    2.0 * a * b / (a + b)
}

/// The same of a/2 and b/2 by way of the compliances: 1/(1/a + 1/b).
pub fn compliances_in_series(a: f64, b: f64) -> f64 {
    1.0 / (1.0 / a + 1.0 / b)
}

/// Two grains: u_n = R_1 + R_2 − d, n along the line of centres.
pub fn grains(
    position1: [f64; 2],
    radius1: f64,
    position2: [f64; 2],
    radius2: f64,
) -> Option<Touch> {
    let dx = position2[0] - position1[0];
    let dz = position2[1] - position1[1];
    let distance = (dx * dx + dz * dz).sqrt();
    let overlap = radius1 + radius2 - distance;
    if overlap < 0.0 {
        return None;
    }
    let normal = [dx / distance, dz / distance];
    let arm = radius1 - 0.5 * overlap;
    Some(Touch {
        overlap,
        normal,
        point: [
            position1[0] + arm * normal[0],
            position1[1] + arm * normal[1],
        ],
        radii: [radius1, radius2],
        pair: Pair::Grains,
    })
}

/// An infinite wall (body 1) and a grain: u_n = R − |distance|, n towards the grain's side, the
/// contact point on the wall.
pub fn wall(axis: Axis, place: f64, position: [f64; 2], radius: f64) -> Option<Touch> {
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
    Some(Touch {
        overlap,
        normal,
        point,
        radii: [radius, radius],
        pair: Pair::Wall,
    })
}

/// The rectangular punch (body 1) and a grain. Centre outside: s from the grain's centre to the nearest
/// point of the rectangle, u_n = R − |s|, n = −s/|s|; corners act as points. Centre inside, faces
/// included: the nearest face decides, u_n = R + depth.
pub fn punch(
    centre: [f64; 2],
    half_extents: [f64; 2],
    position: [f64; 2],
    radius: f64,
) -> Option<Touch> {
    let relative = [position[0] - centre[0], position[1] - centre[1]];
    let nearest = [0, 1].map(|axis| relative[axis].clamp(-half_extents[axis], half_extents[axis]));
    if nearest == relative {
        return Some(inside_punch(relative, half_extents, position, radius));
    }
    let s = [nearest[0] - relative[0], nearest[1] - relative[1]];
    let distance = (s[0] * s[0] + s[1] * s[1]).sqrt();
    let overlap = radius - distance;
    if overlap < 0.0 {
        return None;
    }
    let towards = [s[0] / distance, s[1] / distance];
    // The middle between the rectangle's nearest point and the grain's deepest one.
    let middle = |axis: usize| {
        0.5 * ((nearest[axis] + centre[axis]) + (position[axis] + towards[axis] * radius))
    };
    Some(Touch {
        overlap,
        normal: [-towards[0], -towards[1]],
        point: [middle(0), middle(1)],
        radii: [radius, radius],
        pair: Pair::PunchOutside,
    })
}

fn inside_punch(
    relative: [f64; 2],
    half_extents: [f64; 2],
    position: [f64; 2],
    radius: f64,
) -> Touch {
    let depth = [0, 1].map(|axis: usize| half_extents[axis] - relative[axis].abs());
    let axis = usize::from(depth[1] < depth[0]);
    let nearest = depth[axis];
    let mut normal = [0.0, 0.0];
    normal[axis] = if relative[axis] > 0.0 { 1.0 } else { -1.0 };
    let face = [0, 1].map(|axis| position[axis] + normal[axis] * nearest);
    let deepest = [0, 1].map(|axis| position[axis] - normal[axis] * radius);
    Touch {
        overlap: (face[axis] - deepest[axis]).abs(),
        normal,
        point: [0, 1].map(|axis| 0.5 * (face[axis] + deepest[axis])),
        radii: [radius, radius],
        pair: Pair::PunchInside,
    }
}
