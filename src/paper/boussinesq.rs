//! Section 3.1 and Table 4: the continuum's stress at the control points. Recomputed by integrating
//! Flamant's solution numerically and by weighing grains.

use std::f64::consts::PI;

use super::packing::mean_solid_area;
use super::{Finding, Number};
use crate::paper::continuum::half_space::strip_load;
use crate::paper::continuum::table::{Point, Setup};
use crate::paper::continuum::{Load, Spread};
use crate::paper::quadrature::integrate;

const GRAVITY: f64 = 9.81;
const DENSITY: f64 = 2600.0;
const POROSITY: f64 = 0.17;
/// Pa.
const PRESSURE: f64 = 44.4e3;
/// a, m.
const HALF_WIDTH: f64 = 0.0225;
const DEPTH: f64 = 0.11;
/// V_c, m³.
const CONTROL_VOLUME: f64 = 0.005 * 0.005 * 1.0;

/// A control point with the row of Table 4: σ_g, σ_p, σ_zz in kPa, Σ_zz in J.
struct Row {
    point: &'static str,
    offset: f64,
    weight: f64,
    load: f64,
    stress: f64,
    extensive: f64,
}

const TABLE_4: [Row; 3] = [
    Row {
        point: "O",
        offset: 0.0,
        weight: 2.3,
        load: 11.3,
        stress: 13.6,
        extensive: 0.34,
    },
    Row {
        point: "A",
        offset: 0.08,
        weight: 2.3,
        load: 5.0,
        stress: 7.4,
        extensive: 0.18,
    },
    Row {
        point: "B",
        offset: 0.15,
        weight: 2.3,
        load: 1.5,
        stress: 3.8,
        extensive: 0.09,
    },
];

/// A row of Table 4 in Pa and J.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parts {
    /// σ_g,zz.
    pub weight: f64,
    /// σ_p,zz.
    pub load: f64,
    /// σ_zz.
    pub stress: f64,
    /// Σ_zz of the control volume.
    pub extensive: f64,
}

/// What Table 4 prints for a control point, by its name.
pub fn published_parts(point: &str) -> Option<Parts> {
    let row = TABLE_4.iter().find(|row| row.point == point)?;
    Some(Parts {
        weight: 1e3 * row.weight,
        load: 1e3 * row.load,
        stress: 1e3 * row.stress,
        extensive: row.extensive,
    })
}

/// What Table 4 prints for a control point, by its name: σ_zz in Pa and Σ_zz in J.
pub fn published_stress(point: &str) -> Option<(f64, f64)> {
    let row = TABLE_4.iter().find(|row| row.point == point)?;
    Some((1e3 * row.stress, row.extensive))
}

/// The published load, bed and control points. The bed's height is section 4.2's.
pub fn setup() -> Setup {
    Setup {
        load: Load {
            spread: Spread::Uniform,
            pressure: PRESSURE,
            half_width: HALF_WIDTH,
        },
        points: TABLE_4
            .iter()
            .map(|row| Point {
                name: row.point.to_owned(),
                offset: row.offset,
                depth: DEPTH,
            })
            .collect(),
        width: 1.0,
        height: 0.46,
        density: DENSITY,
        gravity: GRAVITY,
        porosity: POROSITY,
    }
}

/// σ_g,zz, Pa, by weighing: discs of the mean size on a triangular lattice that is so wide that its
/// porosity is the published one; those with centres above the depth are counted for many heights of
/// the lattice, and their weight is set on the width that they stand on.
fn weight() -> f64 {
    const HEIGHTS: u32 = 1000;
    let solid = mean_solid_area();
    // A disc has the cell s·(√3/2)s.
    let spacing = (solid / (1.0 - POROSITY) * 2.0 / 3f64.sqrt()).sqrt();
    let row_height = 0.5 * 3f64.sqrt() * spacing;
    let weight_of_row = DENSITY * GRAVITY * solid / spacing;
    let mut rows = 0;
    for height in 0..HEIGHTS {
        let first = row_height * (f64::from(height) + 0.5) / f64::from(HEIGHTS);
        rows += (0..1000)
            .take_while(|row| first + row_height * f64::from(*row) < DEPTH)
            .count();
    }
    weight_of_row * rows as f64 / f64::from(HEIGHTS)
}

/// Eq. 3 as printed, Pa, with θ read as arctan((X−x)/z), X₁ left and X₂ right.
fn equation_3_as_printed(offset: f64) -> f64 {
    let angle = |edge: f64| ((edge - offset) / DEPTH).atan();
    let (one, two) = (angle(-HALF_WIDTH), angle(HALF_WIDTH));
    PRESSURE / PI * ((one - two) + one.sin() * two.cos() - two.sin() * one.cos())
}

/// The numbers of section 3.1 and Table 4.
pub fn numbers() -> Vec<Number> {
    let mut numbers = Vec::new();
    let weight = weight();
    for row in &TABLE_4 {
        let at = |what: &str| format!("{what} at {}", row.point);
        let load = strip_load(PRESSURE, HALF_WIDTH, row.offset, DEPTH);
        let stress = weight + load;
        let flamant = "Flamant's line load integrated over the strip";
        let both = "weighed discs plus Flamant's integral";
        numbers.push(Number::new(
            "Table 4",
            &at("σ_g,zz"),
            row.weight,
            0.05,
            weight / 1e3,
            "kPa",
            "weighing discs on a lattice of porosity n, counted above the depth",
        ));
        numbers.push(Number::new(
            "Table 4",
            &at("σ_p,zz"),
            row.load,
            0.05,
            load / 1e3,
            "kPa",
            flamant,
        ));
        let sum = Number::new(
            "Table 4",
            &at("σ_zz"),
            row.stress,
            0.05,
            stress / 1e3,
            "kPa",
            both,
        );
        let of_printed = row.weight + row.load;
        numbers.push(if (of_printed - row.stress).abs() > 0.05 {
            sum.remark(&format!(
                "right; the printed parts sum to {of_printed:.1} because each is rounded"
            ))
        } else {
            sum
        });
        numbers.push(Number::new(
            "Table 4",
            &at("Σ_zz"),
            row.extensive,
            0.005,
            stress * CONTROL_VOLUME,
            "J",
            both,
        ));
        let printed_formula = equation_3_as_printed(row.offset);
        let mut as_printed = Number::new(
            "Eq. 3",
            &format!("Eq. 3 as printed at {} against Table 4", row.point),
            row.load,
            0.05,
            printed_formula / 1e3,
            "kPa",
            "the printed formula, θ read as arctan((X−x)/z)",
        );
        as_printed.finding = Finding::Misprint;
        numbers.push(as_printed.remark(&format!(
            "the formula is at fault, not the table: its sign is wrong (X₁ is the left limit), and \
             its size is {:.2} times the integral",
            printed_formula.abs() / load
        )));
    }
    numbers.push(
        Number::new(
            "section 3",
            "force 2ap on the punch",
            1998.0,
            0.0,
            integrate(-HALF_WIDTH, HALF_WIDTH, 1, |_| PRESSURE),
            "N/m",
            "the load integrated over the strip",
        )
        .derived("the target of loading"),
    );
    numbers.push(Number::new(
        "Table 4",
        "V_c, a square of side R and 1 m deep",
        2.5e-5,
        0.0,
        integrate(-0.0025, 0.0025, 1, |_| 0.005),
        "m³",
        "area of the square",
    ));
    numbers.push(
        Number::new(
            "section 5",
            "V_c over the mean cell of a grain",
            1.0,
            0.0,
            CONTROL_VOLUME / (mean_solid_area() / (1.0 - POROSITY)),
            "1",
            "mean area of the grains over 1−n",
        )
        .misprint(
            "1 if V_c were the particle and its void, as section 5 says; section 3.2.3 and Table 4 use a \
             square of side R. The exponential law scales, so only the name is at fault",
        ),
    );
    numbers
}
