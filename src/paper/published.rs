//! Every figure that the paper prints and that is held against one of ours: recomputed ones, and those of its simulations.

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Printed {
    /// Short and lasting: `table-4/stress/O`.
    pub id: &'static str,
    pub place: &'static str,
    /// In `unit`.
    pub value: f64,
    /// Half a unit of the last printed digit, or the printed scatter; 0 for whole numbers and formulas.
    pub rounding: f64,
    /// SI unit, `1` for a ratio.
    pub unit: &'static str,
}

/// How a figure is got from realizations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Of {
    Mean,
    Variation,
    /// Share above so many times the mean.
    ShareAbove(u32),
}

/// A figure of the paper's simulations with the quantity of ours that is held against it.
///
/// Where the paper prints a tolerance, it is taken; where not, one was set here before any run was looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Published {
    /// Short and lasting: `height`, `stress.O`.
    pub id: &'static str,
    pub title: &'static str,
    pub place: &'static str,
    /// The measured quantity of a realization.
    pub key: &'static str,
    pub of: Of,
    /// In `unit`.
    pub value: f64,
    /// Ours comes out if it is this near, in `unit`.
    pub tolerance: f64,
    /// SI unit, `1` for a ratio.
    pub unit: &'static str,
    pub reason: &'static str,
}

impl Published {
    /// Value ± tolerance.
    pub fn limits(&self) -> [f64; 2] {
        [self.value - self.tolerance, self.value + self.tolerance]
    }
}

/// The control points of the paper, with their distances from the load's middle, m; 0.11 m below the surface.
pub const POINTS: [(&str, f64); 3] = [("O", 0.0), ("A", 0.08), ("B", 0.15)];

/// The subclasses of Table 1 with their printed names: how many of five piles bear 0, 1, … 5 units.
pub const TABLE_1: [(&str, [u32; 6]); 7] = [
    ("pessimistic", [4, 0, 0, 0, 0, 1]),
    ("second row", [3, 1, 0, 0, 1, 0]),
    ("third row", [3, 0, 1, 1, 0, 0]),
    ("most likely 1", [2, 2, 0, 1, 0, 0]),
    ("most likely 2", [2, 1, 2, 0, 0, 0]),
    ("sixth row", [1, 3, 1, 0, 0, 0]),
    ("optimistic", [0, 5, 0, 0, 0, 0]),
];

const fn at(
    id: &'static str,
    place: &'static str,
    value: f64,
    rounding: f64,
    unit: &'static str,
) -> Printed {
    Printed {
        id,
        place,
        value,
        rounding,
        unit,
    }
}

const PILES: &str = "section 2.2";
const STEP_3: &str = "section 3";
const BED: &str = "section 4.2";
const T1: &str = "Table 1";
const T3: &str = "Table 3";
const T4: &str = "Table 4";
const PI: f64 = std::f64::consts::PI;

/// In the order of the paper.
pub const PRINTED: &[Printed] = &[
    at("piles/loads", PILES, 7726.0, 0.0, "cases"),
    at("piles/balanced", PILES, 126.0, 0.0, "cases"),
    at("table-1/1", T1, 5.0, 0.0, "cases"),
    at("table-1/2", T1, 20.0, 0.0, "cases"),
    at("table-1/3", T1, 20.0, 0.0, "cases"),
    at("table-1/4", T1, 30.0, 0.0, "cases"),
    at("table-1/5", T1, 30.0, 0.0, "cases"),
    at("table-1/6", T1, 20.0, 0.0, "cases"),
    at("table-1/7", T1, 1.0, 0.0, "cases"),
    at("table-1/subclasses", T1, 7.0, 0.0, "subclasses"),
    at("piles/most-likely", PILES, 30.0, 0.0, "cases"),
    at("piles/likely-over-optimistic", PILES, 30.0, 0.0, "1"),
    at("piles/likely-over-pessimistic", PILES, 6.0, 0.0, "1"),
    at("piles/pessimistic-over-optimistic", PILES, 5.0, 0.0, "1"),
    at("piles/symmetric", PILES, 6.0, 0.0, "cases"),
    at("piles/moment-balance", PILES, 6.0, 0.0, "cases"),
    at("piles/chance-optimistic", PILES, 0.01, 0.005, "1"),
    at("piles/chance-pessimistic", PILES, 0.04, 0.005, "1"),
    at("piles/twice-the-mean", PILES, 0.135, 0.0005, "1"),
    at("piles/twice-in-whole-units", PILES, 0.135, 0.0005, "1"),
    at("load/force", STEP_3, 1998.0, 0.0, "N/m"),
    at("load/pressure", STEP_3, PRESSURE, 50.0, "Pa"),
    at("table-3/volume", T3, 4.0, 0.0, "m³"),
    at("table-3/particle-volume", T3, PI, 0.0, "m³"),
    at("table-3/porosity", T3, 0.21, 0.005, "1"),
    at("table-3/sum-zz", T3, 2.0, 0.05, "J"),
    at("table-3/stress-zz", T3, 0.5, 0.05, "Pa"),
    at("table-3/sum-xx", T3, 1.0, 0.05, "J"),
    at("table-3/stress-xx", T3, 0.25, 0.005, "Pa"),
    at("table-3/sum-xy", T3, 0.0, 0.05, "J"),
    at("table-3/stress-xy", T3, 0.0, 0.05, "Pa"),
    at("eq-8/stacked", "Eq. 8", 1.0, 0.0, "1"),
    at("table-4/weight/O", T4, 2.3e3, 50.0, "Pa"),
    at("table-4/load/O", T4, 11.3e3, 50.0, "Pa"),
    at("table-4/stress/O", T4, STRESSES[0], 50.0, "Pa"),
    at("table-4/extensive/O", T4, 0.34, 0.005, "J"),
    at("table-4/weight/A", T4, 2.3e3, 50.0, "Pa"),
    at("table-4/load/A", T4, 5.0e3, 50.0, "Pa"),
    at("table-4/stress/A", T4, STRESSES[1], 50.0, "Pa"),
    at("table-4/extensive/A", T4, 0.18, 0.005, "J"),
    at("table-4/weight/B", T4, 2.3e3, 50.0, "Pa"),
    at("table-4/load/B", T4, 1.5e3, 50.0, "Pa"),
    at("table-4/stress/B", T4, STRESSES[2], 50.0, "Pa"),
    at("table-4/extensive/B", T4, 0.09, 0.005, "J"),
    at("table-4/control-volume", T4, CONTROL_VOLUME, 0.0, "m³"),
    at("bed/height", BED, HEIGHT, SCATTER, "m"),
    at("bed/porosity", BED, POROSITY, SCATTER, "1"),
    at("section-5/control-volume", "section 5", 1.0, 0.0, "1"),
];

pub fn printed(id: &str) -> Option<&'static Printed> {
    PRINTED.iter().find(|of| of.id == id)
}

/// H, m.
pub const HEIGHT: f64 = 0.46;
/// n.
pub const POROSITY: f64 = 0.17;
/// Of both.
const SCATTER: f64 = 0.01;
/// p, Pa.
pub const PRESSURE: f64 = 44.4e3;
/// V_c, m³.
pub const CONTROL_VOLUME: f64 = 2.5e-5;
/// σ_zz at O, A and B, Pa.
const STRESSES: [f64; 3] = [13.6e3, 7.4e3, 3.8e3];

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parts {
    /// σ_g,zz, Pa.
    pub weight: f64,
    /// σ_p,zz, Pa.
    pub load: f64,
    /// σ_zz, Pa.
    pub stress: f64,
    /// Σ_zz of the control volume, J.
    pub extensive: f64,
}

/// The row of a control point by its name.
pub fn table_4(point: &str) -> Option<Parts> {
    let of = |column: &str| Some(printed(&format!("table-4/{column}/{point}"))?.value);
    Some(Parts {
        weight: of("weight")?,
        load: of("load")?,
        stress: of("stress")?,
        extensive: of("extensive")?,
    })
}

/// Definitions of a bed's height; the paper does not say which is its own.
pub const HEIGHTS: [(&str, &str); 3] = [
    ("settled.height.mean_surface", "mean surface"),
    ("settled.height.highest_grain", "top of the highest grain"),
    (
        "settled.height.twice_centre_of_mass",
        "twice the centre of mass",
    ),
];

/// Definitions of a bed's porosity, the first three by the heights above.
pub const POROSITIES: [(&str, &str); 5] = [
    (
        "settled.porosity.from_mean_surface",
        "from the mean surface",
    ),
    (
        "settled.porosity.from_highest_grain",
        "from the highest grain",
    ),
    (
        "settled.porosity.from_twice_centre_of_mass",
        "from twice the centre of mass",
    ),
    (
        "settled.porosity.in_window",
        "in a window away from the walls",
    ),
    (
        "settled.porosity.of_cells",
        "of the cells of whole grains in that window",
    ),
];

const TENTH: &str = "a tenth: the paper says that the means correspond and prints two digits; the three points differ by \
                     factors of two";
const SPREAD: &str =
    "a tenth: what the paper's thousand realizations could not miss in a histogram";

/// e⁻²: an exponential's share above twice its mean; 13.5 % in section 2.2.
pub const E_TO_MINUS_2: f64 = 0.135_335_283_236_612_7;

/// The figures of the simulations that depend on their open choices: the reference of the claims and of the candidates.
pub const PUBLISHED: &[Published] = &[
    Published {
        id: "height",
        title: "height H, mean surface",
        place: BED,
        key: HEIGHTS[0].0,
        of: Of::Mean,
        value: HEIGHT,
        tolerance: SCATTER,
        unit: "m",
        reason: "printed",
    },
    Published {
        id: "porosity",
        title: "porosity n, from the mean surface",
        place: BED,
        key: POROSITIES[0].0,
        of: Of::Mean,
        value: POROSITY,
        tolerance: SCATTER,
        unit: "1",
        reason: "printed",
    },
    mean("stress.O", "mean σ_zz at O", LOCAL[0], STRESSES[0]),
    mean("stress.A", "mean σ_zz at A", LOCAL[1], STRESSES[1]),
    mean("stress.B", "mean σ_zz at B", LOCAL[2], STRESSES[2]),
    shape("variation.O", VARIATIONS[0], GRAINS[0], Of::Variation),
    shape("variation.A", VARIATIONS[1], GRAINS[1], Of::Variation),
    shape("variation.B", VARIATIONS[2], GRAINS[2], Of::Variation),
    shape("beyond.O", BEYONDS[0], GRAINS[0], Of::ShareAbove(2)),
    shape("beyond.A", BEYONDS[1], GRAINS[1], Of::ShareAbove(2)),
    shape("beyond.B", BEYONDS[2], GRAINS[2], Of::ShareAbove(2)),
];

const VARIATIONS: [&str; 3] = [
    "coefficient of variation of Σ_zz at O",
    "coefficient of variation of Σ_zz at A",
    "coefficient of variation of Σ_zz at B",
];
const BEYONDS: [&str; 3] = [
    "share above twice the mean at O",
    "share above twice the mean at A",
    "share above twice the mean at B",
];
const LOCAL: [&str; 3] = [
    "loaded.stress.O.local_zz",
    "loaded.stress.A.local_zz",
    "loaded.stress.B.local_zz",
];
const GRAINS: [&str; 3] = [
    "loaded.stress.O.grain_zz",
    "loaded.stress.A.grain_zz",
    "loaded.stress.B.grain_zz",
];

const fn mean(id: &'static str, title: &'static str, key: &'static str, value: f64) -> Published {
    Published {
        id,
        title,
        place: T4,
        key,
        of: Of::Mean,
        value,
        tolerance: 0.1 * value,
        unit: "Pa",
        reason: TENTH,
    }
}

const fn shape(id: &'static str, title: &'static str, key: &'static str, of: Of) -> Published {
    Published {
        place: "section 4.2, Figure 5",
        of,
        unit: "1",
        reason: SPREAD,
        ..mean(
            id,
            title,
            key,
            match of {
                Of::ShareAbove(_) => E_TO_MINUS_2,
                _ => 1.0,
            },
        )
    }
}

pub fn published(id: &str) -> Option<&'static Published> {
    PUBLISHED.iter().find(|of| of.id == id)
}
