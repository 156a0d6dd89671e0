//! What the same author's earlier paper says of the same set-up, by its summary: I. G. Tejada, "Boussinesq-like problems in discrete
//! media", arXiv:1812.08424. Its laws are said to hold along the principal directions.

use super::means::POINTS;
use super::sample::{self, Moment};
use super::shapes::{DECIDED_BY, DECIDED_BY_PEAKEDNESS, rows_of, rows_of_shear};
use super::{Claim, Rule, together};
use crate::study::campaign::Member;
use evidence::distribution::Family;
use evidence::likelihood::not_nested;
use evidence::moments::mean;
use evidence::zeros::Parted;

pub const SOURCE: &str = "arXiv:1812.08424, summary";

/// Extensive stress of the nearest grain in every packing, J/m, along the principal directions of its mean over the packings.
struct Principal {
    /// Along the direction nearer to the vertical.
    upright: Vec<f64>,
    /// Across it.
    level: Vec<f64>,
    shear: Vec<f64>,
}

impl Principal {
    fn at(members: &[Member], point: &str) -> Self {
        let nearest = sample::nearest(members, Moment::Loaded, point, 1);
        let parts = nearest.iter().map(|of| [of[0].xx, of[0].zz, of[0].xz]);
        let parts: Vec<[f64; 3]> = parts.collect();
        let middle = |part: usize| mean(&parts.iter().map(|of| of[part]).collect::<Vec<f64>>());
        // From z towards x, at most an eighth of a turn while σ_zz is the larger one.
        let turn = 0.5 * (2.0 * middle(2)).atan2(middle(1) - middle(0));
        let (sin, cos) = turn.sin_cos();
        let along =
            |[xx, zz, xz]: &[f64; 3], [x, z]: [f64; 2]| x * x * xx + z * z * zz + 2.0 * x * z * xz;
        let across = |[xx, zz, xz]: &[f64; 3]| sin * cos * (xx - zz) + (cos * cos - sin * sin) * xz;
        Principal {
            upright: parts.iter().map(|of| along(of, [sin, cos])).collect(),
            level: parts.iter().map(|of| along(of, [cos, -sin])).collect(),
            shear: parts.iter().map(across).collect(),
        }
    }
}

pub fn claims(members: &[Member], others: &[Claim]) -> Vec<Claim> {
    let points = POINTS.map(|point| (point, Principal::at(members, point)));
    let (mut normal, mut shear, mut shapes, mut peaks) = (vec![], vec![], vec![], vec![]);
    for (point, of) in &points {
        for (name, values) in [
            ("nearer to the vertical", &of.upright),
            ("across it", &of.level),
        ] {
            let name = format!("{point}, {name}");
            let rows = rows_of(&name, values);
            shapes.push(format!("{name} {:.2}", rows[1].estimate()));
            normal.extend(rows);
        }
        let (mut rows, found) = rows_of_shear(point, &of.shear, "J/m");
        let loaded = Parted::of(&of.shear).others;
        if let Some(between) = not_nested(Family::Laplace, Family::Normal, &loaded) {
            let test = "Laplace and normal equally far from the truth (Vuong's z; positive: Laplace nearer)";
            let first = rows.remove(0);
            rows.insert(0, first.with(test, between.z, between.p));
        }
        peaks.push(found);
        shear.extend(rows);
    }
    let means = others
        .iter()
        .filter(|of| POINTS.iter().any(|point| of.id == format!("mean.{point}")));
    let means: Vec<&Claim> = means.collect();
    let said = means.iter().map(|of| format!("{} {}", of.id, of.word()));
    vec![
        Claim::of("earlier.normal", SOURCE, "figure5")
            .says("In principal directions the normal components of a grain's extensive stress are exponential.")
            .found(format!(
                "Gamma shapes of grains that bear load, instead of 1: {}.",
                shapes.join("; ")
            ))
            .decided_by(format!("In both directions at every point: {DECIDED_BY}"))
            .by(Rule::All, normal),
        Claim::of("earlier.shear", SOURCE, "shear")
            .says("The shear component has a Laplace law.")
            .found(format!("{}.", peaks.join(", ")))
            .decided_by(DECIDED_BY_PEAKEDNESS)
            .by(Rule::All, shear),
        Claim::of("earlier.scale", SOURCE, "figure5")
            .says("The scales of these laws follow from the continuum's solution.")
            .found(format!("{}.", said.collect::<Vec<String>>().join("; ")))
            .decided_by("Holds where the mean vertical stress does at O, A and B.")
            .with(together(&means), Vec::new()),
    ]
}
