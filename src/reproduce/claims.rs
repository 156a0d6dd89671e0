//! What one realization says about the figures that the paper got from simulation. One realization
//! decides nothing about a distribution, so these are findings, not checks.

use serde::Serialize;

use crate::compare::divergence::quantities;
use crate::paper::published::{HEIGHTS, POROSITIES, Printed, printed};
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
    let claim = |what: String, key: &str, id: &str| {
        let figure: &Printed = printed(id)?;
        let ours = measured.iter().find(|quantity| quantity.key == key)?.value;
        let has_scatter = id.starts_with("bed/");
        let reading = if !has_scatter {
            format!(
                "{:.2} of the published mean; one draw from a wide distribution",
                ours / figure.value
            )
        } else if (ours - figure.value).abs() <= figure.rounding {
            "within the published scatter".to_owned()
        } else {
            "outside the published scatter".to_owned()
        };
        Some(Claim {
            what,
            published: figure.value,
            scatter: has_scatter.then_some(figure.rounding),
            ours,
            unit: figure.unit.to_owned(),
            reading,
        })
    };
    let heights = HEIGHTS.map(|(key, words)| claim(format!("H, {words}"), key, "bed/height"));
    let porosities =
        POROSITIES.map(|(key, words)| claim(format!("n, {words}"), key, "bed/porosity"));
    let stresses = scene.control_points.iter().flat_map(|point| {
        let at = |what: &str, key: &str, column: &str| {
            let key = format!("loaded.stress.{}.{key}", point.name);
            let id = format!("table-4/{column}/{}", point.name);
            claim(format!("{what} at {}", point.name), &key, &id)
        };
        [
            at("local mean σ_zz", "local_zz", "stress"),
            at(
                "Σ_zz of V_c, nearest grain",
                "control_volume_zz",
                "extensive",
            ),
        ]
    });
    heights
        .into_iter()
        .chain(porosities)
        .chain(stresses)
        .flatten()
        .collect()
}
