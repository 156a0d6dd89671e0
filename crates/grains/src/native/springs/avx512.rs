//! The same in 512-bit vectors: compilers do not find the cheap way to gather pairs of coordinates.

use std::arch::x86_64::*;
use std::ops::Range;

use super::{At, LANES, Lanes, Rows, Sums};

/// Whether this machine has them.
pub fn available() -> bool {
    is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq")
}

/// See [`super::sum_forces`]; does nothing else where the machine has no such vectors.
#[allow(unsafe_code)]
pub fn sum_forces(position: At<&[[f64; 2]]>, rows: &Rows, groups: Range<usize>, force: Sums) {
    assert!(available(), "asked for vectors that this machine lacks");
    // SAFETY: the machine has the features that the function is compiled for, as just asserted; that is
    // all it needs.
    unsafe { in_vectors(position, rows, groups, force) }
}

#[target_feature(enable = "avx512f,avx512dq")]
fn in_vectors(
    position: At<&[[f64; 2]]>,
    rows: &Rows,
    groups: Range<usize>,
    At(first, force): Sums,
) {
    let columns = rows.start[groups.start..=groups.end].windows(2);
    for (grain, columns) in rows.grain[groups].iter().zip(columns) {
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
            sum[0] = add_spring(sum[0], own[0], there, reach[0], stiffness[0]);
            let there = gather::<8>(position, other);
            sum[1] = add_spring(sum[1], own[1], there, reach[1], stiffness[1]);
        }
        scatter::<0>(sum[0], grain, At(first, &mut *force));
        scatter::<8>(sum[1], grain, At(first, &mut *force));
    }
}

/// Takes the forces of eight springs off the sums.
#[inline]
#[target_feature(enable = "avx512f,avx512dq")]
fn add_spring(
    sum: [__m512d; 2],
    own: [__m512d; 2],
    other: [__m512d; 2],
    reach: __m512d,
    stiffness: __m512d,
) -> [__m512d; 2] {
    let dx = _mm512_sub_pd(other[0], own[0]);
    let dz = _mm512_sub_pd(other[1], own[1]);
    let square = _mm512_add_pd(_mm512_mul_pd(dx, dx), _mm512_mul_pd(dz, dz));
    let distance = _mm512_sqrt_pd(square);
    let overlap = _mm512_sub_pd(reach, distance);
    let touching = _mm512_cmp_pd_mask::<_CMP_GE_OQ>(overlap, _mm512_setzero_pd());
    let size = _mm512_mul_pd(stiffness, overlap);
    let fx = _mm512_mul_pd(size, _mm512_div_pd(dx, distance));
    let fz = _mm512_mul_pd(size, _mm512_div_pd(dz, distance));
    [
        _mm512_mask_sub_pd(sum[0], touching, sum[0], fx),
        _mm512_mask_sub_pd(sum[1], touching, sum[1], fz),
    ]
}

/// The pairs of these ids' lanes FROM to FROM + 8, as two vectors, one a component.
#[inline]
#[target_feature(enable = "avx512f,avx512dq")]
fn gather<const FROM: usize>(At(first, values): At<&[[f64; 2]]>, ids: &Lanes<u32>) -> [__m512d; 2] {
    let four = |at: usize| {
        let pair = |lane: usize| {
            let [x, z] = values[ids[FROM + at + lane] as usize - first];
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
fn scatter<const FROM: usize>(from: [__m512d; 2], ids: &Lanes<u32>, At(first, to): Sums) {
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
            to[ids[FROM + 4 * quarter + lane] as usize - first] = [
                _mm_cvtsd_f64(pair),
                _mm_cvtsd_f64(_mm_unpackhi_pd(pair, pair)),
            ];
        }
    }
}

const _: () = assert!(LANES == 16, "two halves of eight lanes");
