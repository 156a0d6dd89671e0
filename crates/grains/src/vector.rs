//! Vectors in space: x, y, z. Sums stand in Eigen's order, a·b = a_x b_x + (a_y b_y + a_z b_z), which decides the bits.

use std::ops::{Add, Mul, Sub};

pub type Vector<N = f64> = [N; 3];

/// What vectors are made of: a number, or several that are computed together.
pub trait Number: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {}

impl<N: Copy + Add<Output = N> + Sub<Output = N> + Mul<Output = N>> Number for N {}

#[inline(always)]
pub fn plus<N: Number>(a: Vector<N>, b: Vector<N>) -> Vector<N> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub fn minus<N: Number>(a: Vector<N>, b: Vector<N>) -> Vector<N> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub fn times<N: Number>(factor: N, a: Vector<N>) -> Vector<N> {
    [factor * a[0], factor * a[1], factor * a[2]]
}

#[inline(always)]
pub fn dot<N: Number>(a: Vector<N>, b: Vector<N>) -> N {
    a[0] * b[0] + (a[1] * b[1] + a[2] * b[2])
}

#[inline(always)]
pub fn cross<N: Number>(a: Vector<N>, b: Vector<N>) -> Vector<N> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Each component by itself; in a function for a machine with vectors it is no call.
#[inline(always)]
pub fn each<N: Copy, M>(a: Vector<N>, map: impl Fn(N) -> M) -> Vector<M> {
    [map(a[0]), map(a[1]), map(a[2])]
}

/// Added one after the other, from nothing on.
pub fn sum(all: impl IntoIterator<Item = Vector>) -> Vector {
    all.into_iter().fold([0.0; 3], plus)
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
