//! u^0.5 and u^1.5 in eight lanes with the bits of the C library's `pow`, which Hertz's springs have in YADE. It is the algorithm
//! of glibc, which is that of ARM's optimized routines, with fused operations where glibc's compiler put them: log u as a sum of
//! two numbers, which both powers share, then exp of its multiple, each by a table and a polynomial. Where the library at hand
//! gives other bits, as glibc does on a processor without fused operations, the library is asked.

use std::array::from_fn;
use std::hint::black_box;
use std::sync::LazyLock;

use super::lanes::{LANES, Lanes, lanes};

/// Intervals of a table.
const INTERVALS: usize = 128;
/// Each interval's number stands in these bits of a float, above so many others.
const BELOW: u32 = 45;
/// Bits of the float at which the table of logarithms begins, about 0.706.
const FIRST: u64 = 0x3fe6_9555_0000_0000;
/// Within these, m, no power is too small for the plain way.
const LEAST: f64 = 1.0e-120;
const MOST: f64 = 0.5;

/// ln 2 to 42 bits, the rest of it, and of ln(1 + r) the coefficients, scaled by −1/2 to even powers.
const LN_2: [f64; 2] = [
    f64::from_bits(0x3fe6_2e42_fefa_3800),
    f64::from_bits(0x3d2e_f357_93c7_6730),
];
const LN: [f64; 7] = [
    -0.5,
    f64::from_bits(0xbfe5_5555_5555_5560),
    f64::from_bits(0x3fe0_0000_0000_0006),
    f64::from_bits(0x3fe9_9999_9959_554e),
    f64::from_bits(0xbfe5_5555_5529_a47a),
    f64::from_bits(0xbff2_495b_9b48_45e9),
    f64::from_bits(0x3ff0_002b_8b26_3fc3),
];
/// 128/ln 2, −ln 2/128 in two parts, and of exp r − 1 − r the coefficients.
const PARTS_OF_LN_2: f64 = f64::from_bits(0x4067_1547_652b_82fe);
const LN_2_PARTED: [f64; 2] = [
    f64::from_bits(0xbf76_2e42_fefa_0000),
    f64::from_bits(0xbd0c_f79a_bc9e_3b3a),
];
const EXP: [f64; 4] = [
    f64::from_bits(0x3fdf_ffff_ffff_fdbd),
    f64::from_bits(0x3fc5_5555_5555_543c),
    f64::from_bits(0x3fa5_5555_cf17_2b91),
    f64::from_bits(0x3f81_1111_67a4_d017),
];
/// Added to a number it leaves the nearest whole one in the lowest bits.
const SHIFT: f64 = 6_755_399_441_055_744.0;

/// What the algorithm looks up.
struct Tables {
    /// 1/c of a c in the interval; ln c to 43 bits behind the point, and the rest of it.
    ln: [[f64; 3]; INTERVALS],
    /// 2^(k/128): what rounding leaves out, over it, and its bits less those of the interval's number.
    exp: [(f64, u64); INTERVALS],
}

/// Numbers below 128 with 120 bits behind the point, from which the tables are rounded.
mod fixed {
    pub const POINT: u32 = 120;
    pub const ONE: u128 = 1 << POINT;

    /// Of numbers below 2.
    pub fn product(a: u128, b: u128) -> u128 {
        let split = |number: u128| (number >> 60, number & ((1 << 60) - 1));
        let ((a, small_a), (b, small_b)) = (split(a), split(b));
        a * b + ((a * small_b + small_a * b + ((small_a * small_b) >> 60)) >> 60)
    }

    /// ln(a/b) of a ≥ b, by atanh.
    pub fn ln(a: u128, b: u128) -> u128 {
        let x = ((a - b) << POINT) / (a + b);
        let (mut power, mut sum, mut odd) = (x, 0, 1);
        while power > 0 {
            sum += power / odd;
            (power, odd) = (product(power, product(x, x)), odd + 2);
        }
        2 * sum
    }

    /// exp of a number below 1.
    pub fn exp(x: u128) -> u128 {
        let (mut term, mut sum, mut order) = (ONE, 0, 0);
        while term > 0 {
            (sum, order) = (sum + term, order + 1);
            term = product(term, x) / order;
        }
        sum
    }

    /// Rounded to the nearest.
    pub fn float(number: i128) -> f64 {
        number as f64 / ONE as f64
    }
}

impl Tables {
    fn new() -> Self {
        let ln = from_fn(|at| {
            let middle = f64::from_bits(FIRST + (2 * at as u64 + 1) * (1 << (BELOW - 1)));
            // 256/c is a whole number, and even where c is below 1.
            let even = if middle < 1.0 { 2.0 } else { 1.0 };
            let inverse = even * (256.0 / even / middle).round();
            let whole = inverse as u128;
            let ln = fixed::ln(whole.max(256), whole.min(256));
            let cut = fixed::POINT - 43;
            let high = ((ln + (1 << (cut - 1))) >> cut) << cut;
            let sign = if inverse > 256.0 { -1.0 } else { 1.0 };
            let [high, low] = [high as i128, ln as i128 - high as i128].map(fixed::float);
            [inverse / 256.0, sign * high, sign * low]
        });
        let part = fixed::ln(2, 1) / INTERVALS as u128;
        let exp = from_fn(|at| {
            let power = fixed::exp(at as u128 * part);
            let rounded = power as f64 / fixed::ONE as f64;
            let exact = (rounded * fixed::ONE as f64) as u128;
            // In 2^-52 of the rounded number's own bits, so that it is rounded once.
            let left = ((power as i128 - exact as i128) << 52) / (exact >> 68) as i128;
            let left = left as f64 / (1_u128 << 120) as f64;
            (left, rounded.to_bits() - ((at as u64) << BELOW))
        });
        Tables { ln, exp }
    }

    /// [`powers`] where all are within the limits.
    #[inline(always)]
    fn powers(&self, u: Lanes) -> [Lanes; 2] {
        let above: [u64; LANES] = lanes(|lane| u.0[lane].to_bits().wrapping_sub(FIRST));
        let row: [&[f64; 3]; LANES] =
            lanes(|lane| &self.ln[(above[lane] >> BELOW) as usize % INTERVALS]);
        let column = |at: usize| Lanes(lanes(|lane| row[lane][at]));
        let [inverse, ln_c, rest] = [column(0), column(1), column(2)];
        let z = Lanes(lanes(|lane| {
            f64::from_bits(u.0[lane].to_bits() - (above[lane] & (0xfff << 52)))
        }));
        let twos = Lanes(lanes(|lane| ((above[lane] as i64) >> 52) as f64));
        let all = Lanes::all;
        // u = 2^twos·c·(1 + r).
        let r = fused(z, inverse, all(-1.0));
        let t1 = fused(twos, all(LN_2[0]), ln_c);
        let t2 = t1 + r;
        let low1 = fused(twos, all(LN_2[1]), rest);
        let low2 = t1 - t2 + r;
        let half = all(LN[0]) * r;
        let square = r * half;
        let cube = r * square;
        let high = t2 + square;
        let low3 = fused(half, r, -square);
        let low4 = t2 - high + square;
        let outer = fused(r, all(LN[6]), all(LN[5]));
        let middle = fused(outer, square, fused(r, all(LN[4]), all(LN[3])));
        let inner = fused(square, middle, fused(r, all(LN[2]), all(LN[1])));
        let low = fused(cube, inner, low1 + low2 + low3 + low4);
        let ln = high + low;
        let ln = [ln, high - ln + low];
        [self.exp(all(0.5), ln), self.exp(all(1.5), ln)]
    }

    /// exp of the exponent times this logarithm.
    #[inline(always)]
    fn exp(&self, exponent: Lanes, ln: [Lanes; 2]) -> Lanes {
        let all = Lanes::all;
        let high = exponent * ln[0];
        let low = fused(exponent, ln[1], fused(exponent, ln[0], -high));
        let parts = fused(high, all(PARTS_OF_LN_2), all(SHIFT));
        let number: [u64; LANES] = lanes(|lane| parts.0[lane].to_bits());
        let parts = parts - all(SHIFT);
        let r = fused(parts, all(LN_2_PARTED[0]), high);
        let r = low + fused(parts, all(LN_2_PARTED[1]), r);
        let row: [&(f64, u64); LANES] = lanes(|lane| &self.exp[number[lane] as usize % INTERVALS]);
        let left = Lanes(lanes(|lane| row[lane].0));
        let scale = Lanes(lanes(|lane| {
            f64::from_bits(row[lane].1.wrapping_add(number[lane] << BELOW))
        }));
        let square = r * r;
        let inner = fused(fused(r, all(EXP[1]), all(EXP[0])), square, r + left);
        let outer = fused(r, all(EXP[3]), all(EXP[2]));
        fused(fused(outer, square * square, inner), scale, scale)
    }
}

/// a·b + c, rounded once.
#[inline(always)]
fn fused(a: Lanes, b: Lanes, c: Lanes) -> Lanes {
    Lanes(lanes(|lane| a.0[lane].mul_add(b.0[lane], c.0[lane])))
}

/// u^0.5 and u^1.5.
#[derive(Clone, Copy)]
pub struct Powers(Option<&'static Tables>);

static TABLES: LazyLock<Option<Tables>> = LazyLock::new(|| {
    let tables = has_fused().then(Tables::new);
    tables.filter(|tables| (0..PROBES).all(|at| is_like_the_library(tables, probe(at))))
});

/// Of a thousand numbers seven have other bits without fused operations.
const PROBES: u64 = 4096;

/// Eight numbers between 2^-41 and 2^-1.
fn probe(at: u64) -> Lanes {
    Lanes(from_fn(|lane| {
        let stride = (40 << 52) / (PROBES * LANES as u64);
        f64::from_bits((982 << 52) + (at * LANES as u64 + lane as u64) * stride + 977 * at)
    }))
}

/// Whether the processor has fused operations, without which they would take hundreds of instructions.
fn has_fused() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::arch::is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    return cfg!(target_arch = "aarch64");
}

fn is_like_the_library(tables: &Tables, u: Lanes) -> bool {
    let bits = |powers: [Lanes; 2]| powers.map(|lanes| lanes.0.map(f64::to_bits));
    bits(tables.powers(u)) == bits(by_the_library(u))
}

/// The compiler may take other bits for an exponent that it knows.
fn by_the_library(u: Lanes) -> [Lanes; 2] {
    [0.5, 1.5].map(|exponent| Lanes(u.0.map(|u| u.powf(black_box(exponent)))))
}

impl Powers {
    pub fn new() -> Self {
        Powers(TABLES.as_ref())
    }

    /// Of lengths, m.
    #[inline(always)]
    pub fn of(self, u: Lanes) -> [Lanes; 2] {
        let within = u
            .reaches(Lanes::all(LEAST))
            .and(Lanes::all(MOST).reaches(u));
        match self.0 {
            Some(tables) if within.all() => tables.powers(u),
            _ => by_the_library(u),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where the processor has fused operations and glibc is the library, no value is asked from it.
    #[test]
    fn powers_have_the_bits_of_the_library() {
        let powers = Powers::new();
        assert_eq!(powers.0.is_some(), has_fused());
        let mut state = 1_u64;
        for round in 0..1_250_000_u64 {
            let u = Lanes(from_fn(|_| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(round | 1);
                f64::from_bits((970 << 52) + state % (54 << 52))
            }));
            let bits = |powers: [Lanes; 2]| powers.map(|lanes| lanes.0.map(f64::to_bits));
            assert_eq!(bits(powers.of(u)), bits(by_the_library(u)), "{u:?}");
        }
        for u in [0.0, f64::MIN_POSITIVE, 1.0e-300, 0.6, 1.0, 30.0, f64::NAN] {
            let u = Lanes::all(u);
            let bits = |powers: [Lanes; 2]| powers.map(|lanes| lanes.0.map(f64::to_bits));
            assert_eq!(bits(powers.of(u)), bits(by_the_library(u)), "{u:?}");
        }
    }
}
