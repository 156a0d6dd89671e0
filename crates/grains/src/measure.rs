//! Measures of a bed, one definition a file. Blind to the engine: they read the tables alone.

pub mod cells;
pub mod control_stress;
pub mod coordination;
pub mod energy;
pub mod extensive_stress;
pub mod height;
pub mod history;
pub mod neighbourhood;
pub mod porosity;
pub mod profile;
pub mod stress_at_depth;
pub mod support;
pub mod unbalanced_force;

use serde::{Deserialize, Serialize};

use crate::scene::Scene;
use crate::tables::{Bodies, BodyIds, Contact};

/// A measured number.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quantity {
    /// What it is, dots from the general to the special: `settled.height.mean_surface`.
    pub key: String,
    /// In `unit`.
    pub value: f64,
    /// SI unit, `1` for a ratio.
    pub unit: String,
}

/// A bed at one moment, as a run folder holds it.
#[derive(Debug, Clone, Copy)]
pub struct Bed<'a> {
    /// All grains.
    pub bodies: &'a Bodies,
    /// All contacts at the grains' positions, sorted by ids.
    pub contacts: &'a [Contact],
}

impl Bed<'_> {
    /// Ids of walls and punch.
    pub fn ids(&self) -> BodyIds {
        BodyIds::of_box(self.bodies.len() as u32)
    }
}

/// Every measure of the beds of one run: of the settled one, if loading followed, and of the last.
/// Depths are counted from the settled surface in both.
pub fn all(scene: &Scene, settled: Option<Bed<'_>>, last: Bed<'_>) -> Vec<Quantity> {
    let surface = height::surface(scene, settled.unwrap_or(last).bodies);
    let mut quantities = Vec::new();
    if let Some(settled) = settled {
        quantities.extend(bed(scene, "settled", settled, surface));
    }
    quantities.extend(bed(scene, "loaded", last, surface));
    quantities
}

fn bed(scene: &Scene, moment: &str, bed: Bed<'_>, surface: f64) -> Vec<Quantity> {
    let mut quantities = Vec::new();
    let mut add = |key: &str, value: f64, unit: &str| {
        quantities.push(Quantity {
            key: format!("{moment}.{key}"),
            value,
            unit: unit.to_owned(),
        });
    };
    let heights = [
        ("highest_grain", height::highest_grain(bed.bodies)),
        ("mean_surface", height::mean_surface(scene, bed.bodies)),
        (
            "twice_centre_of_mass",
            height::twice_centre_of_mass(bed.bodies),
        ),
    ];
    for (name, height) in heights {
        add(&format!("height.{name}"), height, "m");
    }
    for (name, height) in heights {
        let porosity = porosity::from_height(bed.bodies, scene.container.width, height);
        add(&format!("porosity.from_{name}"), porosity, "1");
    }
    let window = porosity::Window::interior(scene, surface);
    let cells = cells::radical(scene, bed.bodies);
    if let Some(value) = porosity::in_window(bed.bodies, &window) {
        add("porosity.in_window", value, "1");
    }
    if let Some(value) = porosity::of_cells(bed.bodies, &cells, &window) {
        add("porosity.of_cells", value, "1");
    }
    let coordination = coordination::of(bed);
    add("coordination.mean", coordination.mean, "1");
    if let Some(value) = coordination.mean_without_rattlers {
        add("coordination.mean_without_rattlers", value, "1");
    }
    add("coordination.rattlers", coordination.rattler_share, "1");
    if let Some(value) = unbalanced_force::of(scene, bed) {
        add("unbalanced_force", value, "1");
    }
    add("energy.kinetic", energy::kinetic(bed.bodies), "J");
    add("energy.elastic", energy::elastic(scene, bed), "J");
    add(
        "energy.potential",
        energy::potential(scene, bed.bodies),
        "J",
    );
    for at in control_stress::all(scene, bed, &cells, surface) {
        let name = &at.name;
        add(&format!("stress.{name}.grain_zz"), at.grain_stress.zz, "Pa");
        add(&format!("stress.{name}.grain_xx"), at.grain_stress.xx, "Pa");
        add(&format!("stress.{name}.grain_xz"), at.grain_stress.xz, "Pa");
        add(
            &format!("stress.{name}.control_volume_zz"),
            at.control_volume_zz,
            "J",
        );
        if let Some(local) = at.local_mean {
            add(&format!("stress.{name}.local_zz"), local.zz, "Pa");
            add(&format!("stress.{name}.local_xx"), local.xx, "Pa");
            add(&format!("stress.{name}.local_xz"), local.xz, "Pa");
        }
    }
    quantities
}
