//! The same in 512-bit vectors: compilers do not find the cheap way to gather pairs of coordinates.

use std::arch::x86_64::*;

use super::{Column, LANES, Lanes, Rows};

/// Whether this machine has them.
pub fn available() -> bool {
    is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq")
}

/// See [`super::sum_forces`]; does nothing else where the machine has no such vectors.
#[allow(unsafe_code)]
pub fn sum_forces<const FREE: bool>(position: &[[f64; 2]], rows: &Rows, force: &mut [[f64; 2]]) {
    assert!(available(), "asked for vectors that this machine lacks");
    // SAFETY: the machine has the features that the function is compiled for, as just asserted; that is
    // all it needs.
    unsafe { in_vectors::<FREE>(position, rows, force) }
}

#[target_feature(enable = "avx512f,avx512dq")]
fn in_vectors<const FREE: bool>(position: &[[f64; 2]], rows: &Rows, force: &mut [[f64; 2]]) {
    for (grain, columns) in rows.grain.iter().zip(rows.start.windows(2)) {
        let columns = columns[0] as usize..columns[1] as usize;
        let neighbours = rows.other[columns.clone()]
            .iter()
            .zip(&rows.reach[columns.clone()])
            .zip(&rows.stiffness[columns]);
        let own = [gather::<0>(position, grain), gather::<8>(position, grain)];
        let mut sum = [[_mm512_setzero_pd(); 2]; 2];
        for ((other, reach), stiffness) in neighbours {
            let (reach, stiffness) = (halves(*reach), halves(*stiffness));
            let there = gather::<0>(position, other);
            sum[0] = add_spring::<FREE>(sum[0], own[0], there, reach[0], stiffness[0]);
            let there = gather::<8>(position, other);
            sum[1] = add_spring::<FREE>(sum[1], own[1], there, reach[1], stiffness[1]);
        }
        scatter::<0>(sum[0], grain, force);
        scatter::<8>(sum[1], grain, force);
    }
}

/// Takes the forces of eight springs off the sums.
#[inline]
#[target_feature(enable = "avx512f,avx512dq")]
fn add_spring<const FREE: bool>(
    sum: [__m512d; 2],
    own: [__m512d; 2],
    other: [__m512d; 2],
    reach: __m512d,
    stiffness: __m512d,
) -> [__m512d; 2] {
    let dx = _mm512_sub_pd(other[0], own[0]);
    let dz = _mm512_sub_pd(other[1], own[1]);
    let square = _mm512_add_pd(_mm512_mul_pd(dx, dx), _mm512_mul_pd(dz, dz));
    let (touching, fx, fz);
    if FREE {
        let share = _mm512_sub_pd(
            _mm512_mul_pd(reach, inverse_root(square)),
            _mm512_set1_pd(1.0),
        );
        touching = _mm512_cmp_pd_mask::<_CMP_GE_OQ>(share, _mm512_setzero_pd());
        let size = _mm512_mul_pd(stiffness, share);
        fx = _mm512_mul_pd(size, dx);
        fz = _mm512_mul_pd(size, dz);
    } else {
        let distance = _mm512_sqrt_pd(square);
        let overlap = _mm512_sub_pd(reach, distance);
        touching = _mm512_cmp_pd_mask::<_CMP_GE_OQ>(overlap, _mm512_setzero_pd());
        let size = _mm512_mul_pd(stiffness, overlap);
        fx = _mm512_mul_pd(size, _mm512_div_pd(dx, distance));
        fz = _mm512_mul_pd(size, _mm512_div_pd(dz, distance));
    }
    [
        _mm512_mask_sub_pd(sum[0], touching, sum[0], fx),
        _mm512_mask_sub_pd(sum[1], touching, sum[1], fz),
    ]
}

/// 1/√a by two Newton steps from a first guess of 14 bits: y ← y·(3/2 − a/2·y²).
#[inline]
#[target_feature(enable = "avx512f,avx512dq")]
fn inverse_root(a: __m512d) -> __m512d {
    let half = _mm512_mul_pd(a, _mm512_set1_pd(0.5));
    let mut y = _mm512_rsqrt14_pd(a);
    for _ in 0..2 {
        let square = _mm512_mul_pd(y, y);
        y = _mm512_mul_pd(y, _mm512_fnmadd_pd(half, square, _mm512_set1_pd(1.5)));
    }
    y
}

/// The pairs of these ids' lanes FROM to FROM + 8, as two vectors, one a component.
#[inline]
#[target_feature(enable = "avx512f,avx512dq")]
fn gather<const FROM: usize>(of: &[[f64; 2]], ids: &Lanes<u32>) -> [__m512d; 2] {
    let four = |at: usize| {
        let pair = |lane: usize| {
            let [x, z] = of[ids[FROM + at + lane] as usize];
            _mm_set_pd(z, x)
        };
        let low = _mm256_set_m128d(pair(1), pair(0));
        let high = _mm256_set_m128d(pair(3), pair(2));
        _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low), high)
    };
    let (low, high) = (four(0), four(4));
    let first = _mm512_set_epi64(14, 12, 10, 8, 6, 4, 2, 0);
    let second = _mm512_set_epi64(15, 13, 11, 9, 7, 5, 3, 1);
    [
        _mm512_permutex2var_pd(low, first, high),
        _mm512_permutex2var_pd(low, second, high),
    ]
}

/// The lanes as two vectors.
#[inline]
#[allow(unsafe_code)]
#[target_feature(enable = "avx512f,avx512dq")]
fn halves(lanes: Lanes<f64>) -> [__m512d; 2] {
    // SAFETY: sixteen numbers and two vectors of eight have the same size, and any bits are valid in both.
    unsafe { std::mem::transmute::<Lanes<f64>, [__m512d; 2]>(lanes) }
}

/// Writes the pairs of these ids' lanes FROM to FROM + 8.
#[inline]
#[target_feature(enable = "avx512f,avx512dq")]
fn scatter<const FROM: usize>(from: [__m512d; 2], ids: &Lanes<u32>, to: &mut [[f64; 2]]) {
    let pairs = [
        _mm512_permutex2var_pd(from[0], _mm512_set_epi64(11, 3, 10, 2, 9, 1, 8, 0), from[1]),
        _mm512_permutex2var_pd(
            from[0],
            _mm512_set_epi64(15, 7, 14, 6, 13, 5, 12, 4),
            from[1],
        ),
    ];
    for (quarter, four) in pairs.into_iter().enumerate() {
        let halves = [
            _mm512_castpd512_pd128(four),
            _mm512_extractf64x2_pd::<1>(four),
            _mm512_extractf64x2_pd::<2>(four),
            _mm512_extractf64x2_pd::<3>(four),
        ];
        for (lane, pair) in halves.into_iter().enumerate() {
            to[ids[FROM + 4 * quarter + lane] as usize] = [
                _mm_cvtsd_f64(pair),
                _mm_cvtsd_f64(_mm_unpackhi_pd(pair, pair)),
            ];
        }
    }
}

/// See [`super::Single`].
#[allow(unsafe_code)]
pub fn sum_single(local: &[[f32; 2]], all: &[Column], rows: &Rows, force: &mut [[f64; 2]]) {
    assert!(available(), "asked for vectors that this machine lacks");
    // SAFETY: as above.
    unsafe { single_in_vectors(local, all, rows, force) }
}

#[target_feature(enable = "avx512f,avx512dq")]
fn single_in_vectors(local: &[[f32; 2]], all: &[Column], rows: &Rows, force: &mut [[f64; 2]]) {
    for (grain, columns) in rows.grain.iter().zip(rows.start.windows(2)) {
        let columns = columns[0] as usize..columns[1] as usize;
        let own = gather_single(local, grain);
        let mut sum = [_mm512_setzero_ps(); 2];
        for (column, other) in all[columns.clone()].iter().zip(&rows.other[columns]) {
            let there = gather_single(local, other);
            let dx = _mm512_add_ps(_mm512_sub_ps(there[0], own[0]), sixteen(column.x));
            let dz = _mm512_add_ps(_mm512_sub_ps(there[1], own[1]), sixteen(column.z));
            let square = _mm512_fmadd_ps(dx, dx, _mm512_mul_ps(dz, dz));
            // One Newton step brings 14 bits to 24.
            let guess = _mm512_rsqrt14_ps(square);
            let half = _mm512_mul_ps(square, _mm512_set1_ps(0.5));
            let rest = _mm512_fnmadd_ps(half, _mm512_mul_ps(guess, guess), _mm512_set1_ps(1.5));
            let inverse = _mm512_mul_ps(guess, rest);
            let share = _mm512_fmsub_ps(sixteen(column.reach), inverse, _mm512_set1_ps(1.0));
            let touching = _mm512_cmp_ps_mask::<_CMP_GE_OQ>(share, _mm512_setzero_ps());
            let size = _mm512_mul_ps(sixteen(column.stiffness), share);
            sum[0] = _mm512_mask_sub_ps(sum[0], touching, sum[0], _mm512_mul_ps(size, dx));
            sum[1] = _mm512_mask_sub_ps(sum[1], touching, sum[1], _mm512_mul_ps(size, dz));
        }
        let double = |of: __m512| {
            let high = _mm512_extractf32x8_ps::<1>(of);
            [
                _mm512_cvtps_pd(_mm512_castps512_ps256(of)),
                _mm512_cvtps_pd(high),
            ]
        };
        let (x, z) = (double(sum[0]), double(sum[1]));
        scatter::<0>([x[0], z[0]], grain, force);
        scatter::<8>([x[1], z[1]], grain, force);
    }
}

/// The pairs of these ids as two vectors, one a component.
#[inline]
#[target_feature(enable = "avx512f,avx512dq")]
fn gather_single(of: &[[f32; 2]], ids: &Lanes<u32>) -> [__m512; 2] {
    let eight = |from: usize| {
        let two = |lane: usize| {
            let (a, b) = (
                of[ids[from + lane] as usize],
                of[ids[from + lane + 1] as usize],
            );
            _mm_set_ps(b[1], b[0], a[1], a[0])
        };
        let low = _mm256_set_m128(two(2), two(0));
        let high = _mm256_set_m128(two(6), two(4));
        _mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high)
    };
    let (low, high) = (eight(0), eight(8));
    let first = _mm512_set_epi32(30, 28, 26, 24, 22, 20, 18, 16, 14, 12, 10, 8, 6, 4, 2, 0);
    let second = _mm512_set_epi32(31, 29, 27, 25, 23, 21, 19, 17, 15, 13, 11, 9, 7, 5, 3, 1);
    [
        _mm512_permutex2var_ps(low, first, high),
        _mm512_permutex2var_ps(low, second, high),
    ]
}

#[inline]
#[allow(unsafe_code)]
#[target_feature(enable = "avx512f,avx512dq")]
fn sixteen(lanes: Lanes<f32>) -> __m512 {
    // SAFETY: the same size, and any bits are valid in both.
    unsafe { std::mem::transmute::<Lanes<f32>, __m512>(lanes) }
}

const _: () = assert!(LANES == 16, "two halves of eight lanes");
