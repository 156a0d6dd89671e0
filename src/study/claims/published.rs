//! What the paper says of its simulations, figure by figure: the yardstick of claims and of the sensitivity map.
//!
//! Where the paper prints a tolerance, it is taken; where not, one was set here before any run was looked at.

/// How a figure is got from members.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Of {
    /// Mean over members of a measured quantity.
    Mean,
    /// Coefficient of variation over members.
    Variation,
    /// Share of members above so many times the members' mean.
    ShareAbove(u32),
}

/// A published figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Published {
    /// Short and lasting: `height`, `stress.O`.
    pub id: &'static str,
    /// For people.
    pub title: &'static str,
    /// Where it stands in the paper.
    pub place: &'static str,
    /// The member's measured quantity.
    pub key: &'static str,
    /// What of it.
    pub of: Of,
    /// In `unit`.
    pub value: f64,
    /// Ours comes out if it is this near, in `unit`.
    pub tolerance: f64,
    /// SI unit, `1` for a ratio.
    pub unit: &'static str,
    /// Where the tolerance comes from.
    pub reason: &'static str,
}

const PRINTED: &str = "printed";
const TENTH: &str = "a tenth: the paper says that the means correspond and prints two digits; the three points differ by \
                     factors of two";
const SPREAD: &str =
    "a tenth: what the paper's thousand realizations could not miss in a histogram";

/// Every published figure of the simulations.
pub const PUBLISHED: &[Published] = &[
    Published {
        id: "height",
        title: "height H, mean surface",
        place: "section 4.2",
        key: "settled.height.mean_surface",
        of: Of::Mean,
        value: 0.46,
        tolerance: 0.01,
        unit: "m",
        reason: PRINTED,
    },
    Published {
        id: "porosity",
        title: "porosity n, from the mean surface",
        place: "section 4.2",
        key: "settled.porosity.from_mean_surface",
        of: Of::Mean,
        value: 0.17,
        tolerance: 0.01,
        unit: "1",
        reason: PRINTED,
    },
    mean(
        "stress.O",
        "mean σ_zz at O",
        "last.stress.O.local_zz",
        13.6e3,
    ),
    mean(
        "stress.A",
        "mean σ_zz at A",
        "last.stress.A.local_zz",
        7.4e3,
    ),
    mean(
        "stress.B",
        "mean σ_zz at B",
        "last.stress.B.local_zz",
        3.8e3,
    ),
    shape(
        "variation.O",
        "coefficient of variation of Σ_zz at O",
        "last.stress.O.grain_zz",
        Of::Variation,
        1.0,
    ),
    shape(
        "variation.A",
        "coefficient of variation of Σ_zz at A",
        "last.stress.A.grain_zz",
        Of::Variation,
        1.0,
    ),
    shape(
        "variation.B",
        "coefficient of variation of Σ_zz at B",
        "last.stress.B.grain_zz",
        Of::Variation,
        1.0,
    ),
    shape(
        "beyond.O",
        "share above twice the mean at O",
        "last.stress.O.grain_zz",
        Of::ShareAbove(2),
        E_TO_MINUS_2,
    ),
    shape(
        "beyond.A",
        "share above twice the mean at A",
        "last.stress.A.grain_zz",
        Of::ShareAbove(2),
        E_TO_MINUS_2,
    ),
    shape(
        "beyond.B",
        "share above twice the mean at B",
        "last.stress.B.grain_zz",
        Of::ShareAbove(2),
        E_TO_MINUS_2,
    ),
];

/// e⁻²: an exponential's share above twice its mean; 13.5 % in section 2.2.
const E_TO_MINUS_2: f64 = 0.135_335_283_236_612_7;

const fn mean(id: &'static str, title: &'static str, key: &'static str, value: f64) -> Published {
    Published {
        id,
        title,
        place: "Table 4",
        key,
        of: Of::Mean,
        value,
        tolerance: 0.1 * value,
        unit: "Pa",
        reason: TENTH,
    }
}

const fn shape(
    id: &'static str,
    title: &'static str,
    key: &'static str,
    of: Of,
    value: f64,
) -> Published {
    Published {
        id,
        title,
        place: "section 4.2, Figure 5",
        key,
        of,
        value,
        tolerance: 0.1 * value,
        unit: "1",
        reason: SPREAD,
    }
}

/// The figure of this name.
pub fn published(id: &str) -> Option<&'static Published> {
    PUBLISHED.iter().find(|of| of.id == id)
}
