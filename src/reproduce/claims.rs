//! What one realization says about the figures that the paper got from simulation. One realization
//! decides nothing about a distribution, so these are findings, not checks.

use serde::Serialize;

use crate::compare::spread::quantities;
use crate::paper::boussinesq::published_stress;
use crate::run::folder::RunFolder;
use grains::scene::paper_scene;

/// A published figure beside ours.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Claim {
    /// What it is.
    pub what: String,
    /// As printed, in `unit`.
    pub published: f64,
    /// The published scatter, where there is one.
    pub scatter: Option<f64>,
    /// From this run, in `unit`.
    pub ours: f64,
    /// SI unit, `1` for a ratio.
    pub unit: String,
    /// What the two say to each other.
    pub reading: String,
}

/// The claims that this run has a figure for; none for a scene that is not the paper's.
pub fn of(run: &RunFolder) -> Vec<Claim> {
    let scene = &run.scene;
    if scene.digest() != paper_scene(scene.realization, 5000).digest() {
        return Vec::new();
    }
    let measured = quantities(run);
    let value = |key: &str| {
        measured
            .iter()
            .find(|quantity| quantity.key == key)
            .map(|quantity| quantity.value)
    };
    let mut claims = Vec::new();
    let mut bounded = |what: &str, key: &str, published: f64, unit: &str| {
        if let Some(ours) = value(key) {
            claims.push(Claim {
                what: what.to_owned(),
                published,
                scatter: Some(0.01),
                ours,
                unit: unit.to_owned(),
                reading: if (ours - published).abs() <= 0.01 {
                    "within the published scatter".to_owned()
                } else {
                    "outside the published scatter".to_owned()
                },
            });
        }
    };
    for (name, key) in [
        ("highest grain", "highest_grain"),
        ("mean surface", "mean_surface"),
        ("twice the centre of mass", "twice_centre_of_mass"),
    ] {
        let what = format!("H, {name}");
        bounded(&what, &format!("settled.height.{key}"), 0.46, "m");
    }
    for (name, key) in [
        ("from the highest grain", "from_highest_grain"),
        ("from the mean surface", "from_mean_surface"),
        ("from the centre of mass", "from_twice_centre_of_mass"),
        ("in an interior window", "in_window"),
        ("from cells", "of_cells"),
    ] {
        let what = format!("n, {name}");
        bounded(&what, &format!("settled.porosity.{key}"), 0.17, "1");
    }
    for point in &run.scene.control_points {
        let Some((stress, extensive)) = published_stress(&point.name) else {
            continue;
        };
        for (what, key, published, unit) in [
            ("local mean σ_zz", "local_zz", stress, "Pa"),
            (
                "Σ_zz of V_c, nearest grain",
                "control_volume_zz",
                extensive,
                "J",
            ),
        ] {
            if let Some(ours) = value(&format!("last.stress.{}.{key}", point.name)) {
                claims.push(Claim {
                    what: format!("{what} at {}", point.name),
                    published,
                    scatter: None,
                    ours,
                    unit: unit.to_owned(),
                    reading: format!(
                        "{:.2} of the published mean; one draw from a wide distribution",
                        ours / published
                    ),
                });
            }
        }
    }
    claims
}
