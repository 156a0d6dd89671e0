//! What is charted, and by how much a method may move it.
//!
//! The margins were written down before any of the runs that they judge, and one place has them all. A margin is
//! a fifth of what the paper says of its own precision where it says something, and else the smallest shift that
//! would change a statement of the paper.

/// A measured quantity with its margin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Charted {
    /// Its key in a member's record.
    pub key: &'static str,
    /// For people.
    pub title: &'static str,
    /// SI unit, `1` for a ratio.
    pub unit: &'static str,
    /// The largest bias that is no matter; none where the quantity is shown and judges nothing.
    pub margin: Option<Margin>,
    /// Why this margin, or why none.
    pub reason: &'static str,
}

/// The largest bias that is no matter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Margin {
    /// In the quantity's unit.
    Absolute(f64),
    /// As a share of the reference's mean.
    OfMean(f64),
}

impl Margin {
    /// In the quantity's unit, for this mean of the reference.
    pub fn absolute(&self, mean: f64) -> f64 {
        match self {
            Margin::Absolute(margin) => *margin,
            Margin::OfMean(share) => share * mean.abs(),
        }
    }
}

const HEIGHT: &str = "a fifth of the ±0.01 m that the paper gives its height";
const POROSITY: &str = "a fifth of the ±0.01 that the paper gives its porosity";
const STRESS: &str = "the least that a hundred packings can show where one varies by a third (at O it varies by a half, which \
                      takes two hundred); the three points of Table 4 differ by factors of two";
const ONE_GRAIN: &str = "one grain's stress varies by three quarters of its mean: no margin that matters could be shown";

/// Every charted quantity.
pub const CHARTED: &[Charted] = &[
    absolute(
        "settled.height.mean_surface",
        "height, mean surface",
        "m",
        0.002,
        HEIGHT,
    ),
    absolute(
        "settled.height.twice_centre_of_mass",
        "height, twice centre of mass",
        "m",
        0.002,
        HEIGHT,
    ),
    Charted {
        key: "settled.height.highest_grain",
        title: "height, highest grain",
        unit: "m",
        margin: Some(Margin::Absolute(0.005)),
        reason: "one grain, and it is an extreme: a grain's radius",
    },
    absolute(
        "settled.porosity.from_mean_surface",
        "porosity from mean surface",
        "1",
        0.002,
        POROSITY,
    ),
    absolute(
        "settled.porosity.of_cells",
        "porosity of inner cells",
        "1",
        0.002,
        POROSITY,
    ),
    absolute(
        "settled.coordination.mean_without_rattlers",
        "coordination without rattlers",
        "1",
        0.05,
        "about 1 % of 4, and less than the difference between a poured and a rested bed",
    ),
    stress("last.stress.O.local_zz", "local mean stress at O"),
    stress("last.stress.A.local_zz", "local mean stress at A"),
    stress("last.stress.B.local_zz", "local mean stress at B"),
    grain("last.stress.O.grain_zz", "nearest grain's stress at O"),
    grain("last.stress.A.grain_zz", "nearest grain's stress at A"),
    grain("last.stress.B.grain_zz", "nearest grain's stress at B"),
    absolute(
        "settled.distribution.variation",
        "single-grain stress: deviation over mean",
        "1",
        0.05,
        "a quarter of what parts the settled bed from an exponential",
    ),
    absolute(
        "settled.distribution.above_two_means",
        "single-grain stress: share above two means",
        "1",
        0.008,
        "half of what parts the settled bed from an exponential",
    ),
    absolute(
        "settled.distribution.gamma_shape",
        "single-grain stress: Gamma shape",
        "1",
        0.15,
        "a quarter of what parts the settled bed from an exponential",
    ),
    Charted {
        key: "settled.distribution.weibull_shape",
        title: "single-grain stress: Weibull shape",
        unit: "1",
        margin: None,
        reason: "goes with the other numbers of the shape",
    },
    Charted {
        key: "settled.coordination.rattlers",
        title: "share of rattlers",
        unit: "1",
        margin: None,
        reason: "contacts that open and close at rest's threshold decide it; the paper says nothing of it",
    },
    Charted {
        key: "last.punch.depth",
        title: "depth of the punch at the force",
        unit: "m",
        margin: None,
        reason: "varies by its own size from bed to bed",
    },
];

/// How much more often or more rarely than the reference's may a method's punch miss the force, as a share of
/// the realizations: about the least that a hundred packings can show of a rare event.
pub const MISSED: f64 = 0.10;

const fn absolute(
    key: &'static str,
    title: &'static str,
    unit: &'static str,
    margin: f64,
    reason: &'static str,
) -> Charted {
    Charted {
        key,
        title,
        unit,
        margin: Some(Margin::Absolute(margin)),
        reason,
    }
}

const fn stress(key: &'static str, title: &'static str) -> Charted {
    Charted {
        key,
        title,
        unit: "Pa",
        margin: Some(Margin::OfMean(0.15)),
        reason: STRESS,
    }
}

const fn grain(key: &'static str, title: &'static str) -> Charted {
    Charted {
        key,
        title,
        unit: "Pa",
        margin: None,
        reason: ONE_GRAIN,
    }
}
