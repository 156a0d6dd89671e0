//! What a run is: a scene in an engine, with one digest. Also the changes of scenes that studies are made of.

use serde::{Deserialize, Serialize};

use super::realization::Runner;
use crate::files::sha256_hex;
use grains::native::Mode;
use grains::native::pouring::{Phase, Softly};
use grains::scene::{AfterForce, Cloud, Damping, Scene, Shape, TimeStep, paper_scene, parse_scene};

/// Everything that the numbers of a run depend on, but its realization.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Specification {
    /// The scene of loading and measuring, and of pouring where there are no phases; its realization is replaced.
    pub scene: Scene,
    /// In which engine.
    pub runner: Runner,
    /// Pouring, part by part; without any the scene's own stages and rules are used.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub phases: Vec<Phase>,
    /// SHA-256 of the file of the external engine, for its runner.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub program: Option<String>,
}

impl Specification {
    /// The scene by its own rules in the native engine.
    pub fn native(mode: Mode, scene: Scene) -> Self {
        Specification {
            scene,
            runner: Runner::Native(mode),
            phases: Vec::new(),
            program: None,
        }
    }

    /// The scene poured softly in the native engine.
    pub fn soft(mode: Mode, scene: &Scene, softly: &Softly) -> Self {
        let longer = changed(scene.clone(), &[Change::Step(softly.step)]);
        Specification {
            phases: softly.phases(scene),
            ..Specification::native(mode, longer)
        }
    }

    /// The first 64 bits of SHA-256, in hexadecimal. Specifications of one digest give the same members.
    pub fn digest(&self) -> String {
        let of = Specification {
            scene: self.scene_of(0),
            ..self.clone()
        };
        let text = serde_json::to_string(&of).unwrap_or_default();
        sha256_hex(text.as_bytes())[..16].to_owned()
    }

    /// The scene of a realization.
    pub fn scene_of(&self, realization: u64) -> Scene {
        Scene {
            realization,
            ..self.scene.clone()
        }
    }
}

/// Of one range of a setting.
const MOST_CLOUDS: u64 = 1_000_000;

/// A specification among those that a study compares.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setting {
    /// Lasting, and unique in its study: `step-0.65`.
    pub id: String,
    /// For people.
    pub name: String,
    /// What is varied: `time step`.
    pub axis: String,
    /// Its place on the axis, and on the second of a crossed axis, in the units of the name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub at: Vec<f64>,
    /// What is run.
    pub specification: Specification,
    /// Realizations: first and last of each range.
    pub clouds: Vec<[u64; 2]>,
}

impl Setting {
    /// The specification on clouds from 1 on.
    pub fn new(id: &str, name: &str, axis: &str, of: Specification, clouds: u64) -> Self {
        Setting {
            id: id.to_owned(),
            name: name.to_owned(),
            axis: axis.to_owned(),
            at: Vec::new(),
            specification: of,
            clouds: vec![[1, clouds]],
        }
    }

    /// Every realization.
    pub fn realizations(&self) -> impl Iterator<Item = u64> {
        self.clouds.iter().flat_map(|[first, last]| *first..=*last)
    }
}

/// What is wrong with settings that may have been read from a file.
pub fn sound<'a>(settings: impl IntoIterator<Item = &'a Setting>) -> Result<(), String> {
    for Setting {
        id,
        specification,
        clouds,
        ..
    } in settings
    {
        let scene = serde_json::to_string(&specification.scene).unwrap_or_default();
        parse_scene(&scene).map_err(|error| format!("{id}: {error}"))?;
        let ends = |[first, last]: &[u64; 2]| first <= last && last - first < MOST_CLOUDS;
        if clouds.is_empty() || !clouds.iter().all(ends) {
            return Err(format!("{id} has clouds {clouds:?}"));
        }
    }
    Ok(())
}

/// A change of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// dt over √(m/k). The settle rule is looked at just as often in time.
    Step(f64),
    /// Share of Young's modulus. The settle rule's times stay as they are while dt grows as 1/√E.
    Modulus(f64),
    /// Damping number α.
    Alpha(f64),
    /// The bed counts as settled at this share of the largest kinetic energy.
    Settled(f64),
    /// Columns of the cloud.
    Columns(u32),
    /// Speed of the cloud's grains, m/s.
    CloudSpeed(f64),
    /// Shares of the width and of the depth, at the same looseness of the cloud.
    Size(f64, f64),
    /// Speed of the punch, m/s.
    Speed(f64),
    /// Friction angle between grains, rad.
    Friction(f64),
    /// The punch stands still for so long after the force, s; at zero it does not wait.
    Hold(f64),
    /// Grains have the mass of spheres.
    Spheres,
    /// Mean diameter, m, with as many grains in a cloud that is as loose.
    Diameter(f64),
    /// Mean diameter, m, with the same area of grains.
    DiameterSameArea(f64),
}

/// The scene with these changes, one after the other.
pub fn changed(mut scene: Scene, changes: &[Change]) -> Scene {
    for change in changes {
        change.apply(&mut scene);
    }
    scene
}

impl Change {
    fn apply(self, scene: &mut Scene) {
        let Cloud::JitteredLattice { columns, speed, .. } = &mut scene.cloud;
        match self {
            Change::Step(step) => {
                if let TimeStep::Fraction { of_sqrt_m_over_k } = scene.time_step {
                    check_settling(scene, of_sqrt_m_over_k / step);
                    scene.time_step = TimeStep::Fraction {
                        of_sqrt_m_over_k: step,
                    };
                }
            }
            Change::Modulus(share) => {
                scene.material.youngs_modulus *= share;
                check_settling(scene, share.sqrt());
            }
            Change::Alpha(alpha) => scene.damping = Damping::Cundall { alpha },
            Change::Settled(share) => scene.settle.kinetic_energy_fraction = share,
            Change::Columns(wanted) => *columns = wanted,
            Change::CloudSpeed(wanted) => *speed = wanted,
            Change::Size(width, depth) => {
                *columns = (f64::from(*columns) * width).round().max(1.0) as u32;
                scene.container.width *= width;
                let count = f64::from(scene.particles.count) * width * depth;
                scene.particles.count = count.round() as u32;
            }
            Change::Speed(speed) => scene.loading.speed = speed,
            Change::Friction(angle) => scene.material.friction_angle = angle,
            Change::Hold(seconds) if seconds > 0.0 => {
                scene.loading.after_force = AfterForce::StandStill { seconds };
            }
            Change::Hold(_) => {}
            Change::Spheres => scene.particles.shape = Shape::Sphere,
            Change::Diameter(diameter) | Change::DiameterSameArea(diameter) => {
                let ratio = scene.particles.mean_diameter / diameter;
                *columns = (f64::from(*columns) * ratio).floor().max(1.0) as u32;
                scene.particles.mean_diameter = diameter;
                if matches!(self, Change::DiameterSameArea(_)) {
                    let count = f64::from(scene.particles.count) * ratio * ratio;
                    scene.particles.count = count.round() as u32;
                }
            }
        }
    }
}

/// The settle rule in steps that are shorter by this ratio.
fn check_settling(scene: &mut Scene, ratio: f64) {
    let scaled = |steps: u64| ((steps as f64 * ratio).round() as u64).max(1);
    scene.settle.check_every = scaled(scene.settle.check_every);
    scene.settle.max_steps = scaled(scene.settle.max_steps);
}

/// Grains of the paper's bed.
const GRAINS: u32 = 5000;
/// dt over √(m/k) of the free mode's default.
pub const FREE_MODE_STEP: f64 = 0.65;

/// The paper's scene; realizations are put in later.
pub fn whole_scene() -> Scene {
    paper_scene(1, GRAINS)
}

/// The paper's scene, 0.4 m wide with half of the depth and the points at half the distances.
pub fn small_scene() -> Scene {
    let mut scene = changed(whole_scene(), &[Change::Size(0.4, 0.5)]);
    for point in &mut scene.control_points {
        point.offset *= 0.5;
    }
    scene
}

/// The paper's scene with the choices that are the free mode's default: those of the candidate of that step, which
/// was tested to be equivalent.
pub fn free_mode_scene(realization: u64, grains: u32) -> Scene {
    let paper = paper_scene(realization, grains);
    let mut scene = changed(paper, &[Change::Step(FREE_MODE_STEP)]);
    let reason = format!(
        "not printed; {FREE_MODE_STEP} of sqrt(m/k) was tested to be equivalent to 0.45 (docs/tradeoff.md)"
    );
    scene.choices.insert("/time_step".to_owned(), reason);
    scene
}
