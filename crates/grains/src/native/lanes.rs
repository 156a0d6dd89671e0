//! Eight numbers at a time. Each operation is the scalar one in every lane, so a formula written with them has the bits of
//! the same formula written with numbers; compiled into a function for a machine with vectors it is as many instructions.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Numbers that are computed together.
pub const LANES: usize = 8;

/// A number in each lane.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(align(64))]
pub struct Lanes(pub [f64; LANES]);

/// Yes or no in each lane: all bits or none, so that a choice is no branch.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Mask([u64; LANES]);

/// What there is in each lane. In a function for a machine with vectors it must be no call.
#[inline(always)]
pub fn lanes<T>(lane: impl Fn(usize) -> T) -> [T; LANES] {
    [
        lane(0),
        lane(1),
        lane(2),
        lane(3),
        lane(4),
        lane(5),
        lane(6),
        lane(7),
    ]
}

impl Lanes {
    /// The same number in each lane.
    #[inline(always)]
    pub fn all(number: f64) -> Self {
        Lanes([number; LANES])
    }

    /// √ of each.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Lanes(lanes(|lane| self.0[lane].sqrt()))
    }

    /// Where this is the larger one; nowhere where one of them is not a number.
    #[inline(always)]
    pub fn exceeds(self, other: Self) -> Mask {
        Mask(lanes(|lane| {
            u64::from(self.0[lane] > other.0[lane]).wrapping_neg()
        }))
    }

    /// Where this is not the smaller one; nowhere where one of them is not a number.
    #[inline(always)]
    pub fn reaches(self, other: Self) -> Mask {
        Mask(lanes(|lane| {
            u64::from(self.0[lane] >= other.0[lane]).wrapping_neg()
        }))
    }
}

impl Mask {
    /// Whether it is yes in any lane.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.0.iter().fold(0, |any, lane| any | lane) != 0
    }

    /// Whether it is yes in every lane.
    #[inline(always)]
    pub fn all(self) -> bool {
        self.0.iter().fold(u64::MAX, |all, lane| all & lane) != 0
    }

    /// Yes where this is and the other is not.
    #[inline(always)]
    pub fn but_not(self, other: Mask) -> Mask {
        Mask(lanes(|lane| self.0[lane] & !other.0[lane]))
    }

    /// Yes where both are.
    #[inline(always)]
    pub fn and(self, other: Mask) -> Mask {
        Mask(lanes(|lane| self.0[lane] & other.0[lane]))
    }

    /// The components of one or the other vector in each lane.
    #[inline(always)]
    pub fn choose<const N: usize>(self, yes: [Lanes; N], no: [Lanes; N]) -> [Lanes; N] {
        let mut chosen = no;
        for axis in 0..N {
            for lane in 0..LANES {
                let (yes, no) = (yes[axis].0[lane].to_bits(), no[axis].0[lane].to_bits());
                chosen[axis].0[lane] = f64::from_bits(yes & self.0[lane] | no & !self.0[lane]);
            }
        }
        chosen
    }
}

macro_rules! in_each_lane {
    ($($operation:ident :: $name:ident),*) => {$(
        impl $operation for Lanes {
            type Output = Lanes;
            #[inline(always)]
            fn $name(self, other: Lanes) -> Lanes {
                Lanes(lanes(|lane| self.0[lane].$name(other.0[lane])))
            }
        }
    )*};
}

in_each_lane!(Add::add, Sub::sub, Mul::mul, Div::div);

impl Neg for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn neg(self) -> Lanes {
        Lanes(lanes(|lane| -self.0[lane]))
    }
}
