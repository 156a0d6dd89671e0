//! The continuum's stress under the punch: the half-space that the paper uses, and beside it the bed's own
//! geometry, a layer on a base with or without side walls, under a uniform pressure or a rigid punch.
//!
//! Plane and linearly elastic, x across from the middle of the load, z down from the surface; surface, base,
//! walls and punch are smooth. Compression is positive, and so is a shear that a load drives outwards on its
//! right. `docs/continuum.md` says what comes out.

pub mod half_space;
mod layer;
mod pressure;
pub mod sunk;
pub mod table;

use serde::{Deserialize, Serialize};

use self::pressure::Pressure;
use grains::measure::extensive_stress::Components;

/// What the load stands on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Model {
    /// Without end to the sides and downwards.
    HalfSpace,
    /// On a rigid smooth base, without end to the sides.
    Layer {
        /// From surface to base, m.
        depth: f64,
    },
    /// The same between rigid smooth walls at x = ±width/2.
    Box {
        /// From wall to wall, m.
        width: f64,
        /// From surface to base, m.
        depth: f64,
    },
}

/// How the load is spread over its width 2a.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Spread {
    /// The same pressure everywhere.
    Uniform,
    /// As under a rigid, flat and smooth punch: the surface under it stays flat.
    RigidPunch,
}

/// A load on the surface, centred at x = 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Load {
    /// Over the width.
    pub spread: Spread,
    /// Mean pressure, Pa: force per metre of depth over 2a.
    pub pressure: f64,
    /// a, m.
    pub half_width: f64,
}

impl Load {
    /// 2ap, N per metre of depth.
    pub fn force(&self) -> f64 {
        2.0 * self.half_width * self.pressure
    }
}

/// The stress everywhere under one load.
#[derive(Debug, Clone)]
pub struct Field {
    model: Model,
    pressure: Pressure,
}

impl Field {
    /// Finds the pressure under the load, which for a punch depends on what it stands on.
    pub fn new(model: Model, load: Load) -> Self {
        Field {
            model,
            pressure: Pressure::under(model, load),
        }
    }

    /// The load's stress in Pa at (x, z) without the ground's weight, 0 < z, within the model. In a box `xx` comes
    /// without the part that its walls add everywhere alike, K₀·force/width: that part alone depends on
    /// the material, K₀ being ν/(1−ν).
    pub fn stress(&self, x: f64, z: f64) -> Components {
        let [zz, xx, xz] = match self.model {
            Model::HalfSpace => half_space::stress(&self.pressure, x, z),
            Model::Layer { depth } => layer::stress(&self.pressure, depth, x, z),
            Model::Box { width, depth } => layer::between_walls(&self.pressure, width, depth, x, z),
        };
        Components { xx, zz, xz }
    }

    /// The pressure on the surface, Pa; none beside the load and at the rim of a punch, where it has no bound.
    pub fn pressure(&self, x: f64) -> f64 {
        self.pressure.at(x)
    }
}

/// The load's stress at one place, Pa; see [`Field::stress`].
pub fn stress(model: Model, load: Load, x: f64, z: f64) -> Components {
    Field::new(model, load).stress(x, z)
}

/// σ_g,zz = ρ_s g (1−n) z, Pa: the same in all models, as smooth walls carry nothing of it.
pub fn weight(density: f64, gravity: f64, porosity: f64, z: f64) -> f64 {
    density * gravity * (1.0 - porosity) * z
}

#[cfg(test)]
mod tests;
