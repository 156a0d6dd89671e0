//! A method: one way of running a scene, from the cloud to the measured bed.

use serde::{Deserialize, Serialize};

use crate::engine::exec::Description;
pub use crate::study::realization::Runner;
use grains::native::Mode;
use grains::native::pouring::Phase;
use grains::scene::{Cloud, Damping, Scene, TimeStep};

/// What a method changes; methods of a family are compared along one axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// What all others are compared with.
    Reference,
    /// The time step.
    Step,
    /// Exact, free or single precision.
    Mode,
    /// Softened contacts, stiffened in the end or not.
    Soft,
    /// Fewer grains, narrower boxes.
    Size,
    /// When the bed counts as settled.
    Settle,
    /// Amount of damping.
    Damping,
    /// The cloud that is poured.
    Cloud,
    /// Several changes at once.
    Combined,
    /// YADE at the same settings.
    Yade,
    /// An engine that was brought.
    Brought,
}

impl Family {
    /// For people.
    pub fn title(self) -> &'static str {
        match self {
            Family::Reference => "reference",
            Family::Step => "time step",
            Family::Mode => "mode",
            Family::Soft => "softened contacts",
            Family::Size => "size",
            Family::Settle => "settle rule",
            Family::Damping => "damping",
            Family::Cloud => "cloud",
            Family::Combined => "combined",
            Family::Yade => "YADE",
            Family::Brought => "brought",
        }
    }
}

/// One way of running a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Method {
    /// Says what is changed.
    pub name: String,
    /// On which axis.
    pub family: Family,
    /// In which engine.
    pub runner: Runner,
    /// The scene of loading and measuring, and of pouring where there are no phases; its realization is replaced.
    pub scene: Scene,
    /// Pouring, part by part; without any the engine's own stages and rules are used.
    pub phases: Vec<Phase>,
    /// The engine that was brought, for its runner.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub engine: Option<Program>,
}

/// An engine that was brought, as far as its results depend on it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Program {
    /// What it says of itself.
    pub described: Description,
    /// SHA-256 of its file.
    pub digest: String,
}

impl Method {
    /// The scene as it is, in this mode.
    pub fn plain(name: &str, family: Family, mode: Mode, scene: Scene) -> Self {
        Method {
            name: name.to_owned(),
            family,
            runner: Runner::Native(mode),
            scene,
            phases: Vec::new(),
            engine: None,
        }
    }

    /// What the method is, without its name: two methods with the same digest give the same members.
    pub fn digest(&self) -> String {
        let phases = serde_json::to_string(&(&self.runner, &self.phases)).unwrap_or_default();
        let version = env!("CARGO_PKG_VERSION");
        let mut text = format!("{version} {} {phases}", self.scene.digest());
        if let Some(engine) = &self.engine {
            text += &serde_json::to_string(engine).unwrap_or_default();
        }
        crate::files::sha256_hex(text.as_bytes())[..16].to_owned()
    }

    /// dt of loading over √(m/k), where the scene gives it so.
    pub fn step(&self) -> Option<f64> {
        match self.scene.time_step {
            TimeStep::Fraction { of_sqrt_m_over_k } => Some(of_sqrt_m_over_k),
            TimeStep::Absolute { .. } => None,
        }
    }
}

/// The scene with another time step, the settle rule looked at just as often in time.
pub fn with_step(mut scene: Scene, step: f64) -> Scene {
    if let TimeStep::Fraction { of_sqrt_m_over_k } = scene.time_step {
        let longer = of_sqrt_m_over_k / step;
        let scaled = |steps: u64| ((steps as f64 * longer).round() as u64).max(1);
        scene.settle.check_every = scaled(scene.settle.check_every);
        scene.settle.max_steps = scaled(scene.settle.max_steps);
        scene.time_step = TimeStep::Fraction {
            of_sqrt_m_over_k: step,
        };
    }
    scene
}

/// The scene with a share of Young's modulus.
pub fn with_modulus(mut scene: Scene, share: f64) -> Scene {
    scene.material.youngs_modulus *= share;
    // Times, and so the settle rule, stay as they are while dt grows as 1/√E.
    let longer = share.sqrt();
    let scaled = |steps: u64| ((steps as f64 * longer).round() as u64).max(1);
    scene.settle.check_every = scaled(scene.settle.check_every);
    scene.settle.max_steps = scaled(scene.settle.max_steps);
    scene
}

/// The scene with another damping number.
pub fn with_alpha(mut scene: Scene, alpha: f64) -> Scene {
    scene.damping = Damping::Cundall { alpha };
    scene
}

/// The scene settled at another share of the largest kinetic energy.
pub fn with_tolerance(mut scene: Scene, fraction: f64) -> Scene {
    scene.settle.kinetic_energy_fraction = fraction;
    scene
}

/// The scene poured from another cloud.
pub fn with_cloud(mut scene: Scene, columns: u32, speed: f64) -> Scene {
    let Cloud::JitteredLattice { jitter, spin, .. } = scene.cloud;
    scene.cloud = Cloud::JitteredLattice {
        columns,
        jitter,
        speed,
        spin,
    };
    scene
}

/// The scene with a share of the width and of the depth, at the same looseness.
pub fn with_size(mut scene: Scene, width: f64, depth: f64) -> Scene {
    let Cloud::JitteredLattice {
        columns,
        jitter,
        speed,
        spin,
    } = scene.cloud;
    let columns = (f64::from(columns) * width).round().max(1.0);
    scene.cloud = Cloud::JitteredLattice {
        columns: columns as u32,
        jitter,
        speed,
        spin,
    };
    scene.container.width *= width;
    scene.particles.count = (f64::from(scene.particles.count) * width * depth).round() as u32;
    scene
}
