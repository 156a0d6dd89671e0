//! Vectors in space: x, y, z. Sums stand in Eigen's order, a·b = a_x b_x + (a_y b_y + a_z b_z), which decides the bits.

pub type Vector = [f64; 3];

#[inline]
pub fn plus(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline]
pub fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline]
pub fn times(factor: f64, a: Vector) -> Vector {
    [factor * a[0], factor * a[1], factor * a[2]]
}

#[inline]
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + (a[1] * b[1] + a[2] * b[2])
}

#[inline]
pub fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// √(a·a), which overflows where hypot does not.
#[inline]
pub fn norm(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// The length by hypot.
pub fn hypot([x, y, z]: Vector) -> f64 {
    x.hypot(z).hypot(y)
}

/// A vector of the plane.
#[inline]
pub fn in_space([x, z]: [f64; 2]) -> Vector {
    [x, 0.0, z]
}

/// Without what is across the plane.
#[inline]
pub fn in_plane([x, _, z]: Vector) -> [f64; 2] {
    [x, z]
}
