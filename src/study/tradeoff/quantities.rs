//! What is compared, and by how much a method may move it.
//!
//! The margins were written down before any of the runs that they judge, and one place has them all. A margin is
//! a fifth of what the paper says of its own precision where it says something, and else the smallest shift that
//! would change a statement of the paper.

/// A measured quantity with its margin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantity {
    /// Its key in a member.
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
const HIGHEST: &str = "one grain, and it is an extreme: a grain's radius";
const POROSITY: &str = "a fifth of the ±0.01 that the paper gives its porosity";
const COORDINATION: &str =
    "about 1 % of 4, and less than the difference between a poured and a rested bed";
const STRESS: &str = "the least that a hundred packings can show where one varies by a third (at O it varies by a half, which \
                      takes two hundred); the three points of Table 4 differ by factors of two";
const ONE_GRAIN: &str = "one grain's stress varies by three quarters of its mean: no margin that matters could be shown";
const QUARTER: &str = "a quarter of what parts the settled bed from an exponential";
const HALF: &str = "half of what parts the settled bed from an exponential";
const WITH_OTHERS: &str = "goes with the other numbers of the shape";
const RATTLERS: &str =
    "contacts that open and close at rest's threshold decide it; the paper says nothing of it";
const DEPTH: &str = "varies by its own size from bed to bed";

const RATIO: Option<Margin> = Some(Margin::OfMean(0.15));

/// Every quantity.
pub const QUANTITIES: [Quantity; 18] = [
    of(
        "settled.height.mean_surface",
        "height, mean surface",
        "m",
        at(0.002),
        HEIGHT,
    ),
    of(
        "settled.height.twice_centre_of_mass",
        "height, twice centre of mass",
        "m",
        at(0.002),
        HEIGHT,
    ),
    of(
        "settled.height.highest_grain",
        "height, highest grain",
        "m",
        at(0.005),
        HIGHEST,
    ),
    of(
        "settled.porosity.from_mean_surface",
        "porosity from mean surface",
        "1",
        at(0.002),
        POROSITY,
    ),
    of(
        "settled.porosity.of_cells",
        "porosity of inner cells",
        "1",
        at(0.002),
        POROSITY,
    ),
    of(
        "settled.coordination.mean_without_rattlers",
        "coordination without rattlers",
        "1",
        at(0.05),
        COORDINATION,
    ),
    of(
        "loaded.stress.O.local_zz",
        "local mean stress at O",
        "Pa",
        RATIO,
        STRESS,
    ),
    of(
        "loaded.stress.A.local_zz",
        "local mean stress at A",
        "Pa",
        RATIO,
        STRESS,
    ),
    of(
        "loaded.stress.B.local_zz",
        "local mean stress at B",
        "Pa",
        RATIO,
        STRESS,
    ),
    of(
        "loaded.stress.O.grain_zz",
        "nearest grain's stress at O",
        "Pa",
        None,
        ONE_GRAIN,
    ),
    of(
        "loaded.stress.A.grain_zz",
        "nearest grain's stress at A",
        "Pa",
        None,
        ONE_GRAIN,
    ),
    of(
        "loaded.stress.B.grain_zz",
        "nearest grain's stress at B",
        "Pa",
        None,
        ONE_GRAIN,
    ),
    of(
        "settled.distribution.variation",
        "single-grain stress: deviation over mean",
        "1",
        at(0.05),
        QUARTER,
    ),
    of(
        "settled.distribution.above_two_means",
        "single-grain stress: share above two means",
        "1",
        at(0.008),
        HALF,
    ),
    of(
        "settled.distribution.gamma_shape",
        "single-grain stress: Gamma shape",
        "1",
        at(0.15),
        QUARTER,
    ),
    of(
        "settled.distribution.weibull_shape",
        "single-grain stress: Weibull shape",
        "1",
        None,
        WITH_OTHERS,
    ),
    of(
        "settled.coordination.rattlers",
        "share of rattlers",
        "1",
        None,
        RATTLERS,
    ),
    of(
        "loaded.punch.depth",
        "depth of the punch at the force",
        "m",
        None,
        DEPTH,
    ),
];

/// How much more often or more rarely than the reference's may a method's punch miss the force, as a share of
/// the realizations: about the least that a hundred packings can show of a rare event.
pub const MISSED: f64 = 0.10;

const fn at(margin: f64) -> Option<Margin> {
    Some(Margin::Absolute(margin))
}

const fn of(
    key: &'static str,
    title: &'static str,
    unit: &'static str,
    margin: Option<Margin>,
    reason: &'static str,
) -> Quantity {
    Quantity {
        key,
        title,
        unit,
        margin,
        reason,
    }
}

/// Quantities with a margin.
pub fn judged() -> impl Iterator<Item = &'static Quantity> {
    QUANTITIES.iter().filter(|of| of.margin.is_some())
}
