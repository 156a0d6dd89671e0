//! What can be changed in a scene, by a word and a number: what settings of a study differ in.

use grains::scene::{
    AfterForce, Cell, Cloud, ContactLaw, Damping, Material, Rotation, Scene, Shape, SurfaceHeight,
    Tension, TimeStep, Viscosity,
};

/// A word of `apply` and its value.
pub type Change = (&'static str, f64);

/// The paper's number of grains.
pub const GRAINS: u32 = 5000;

const UNDAMPED: Damping = Damping::Cundall { alpha: 0.0 };

/// The scene with these changes, one after the other.
pub fn changed(mut scene: Scene, changes: &[Change]) -> Scene {
    for (word, value) in changes {
        apply(&mut scene, word, *value);
    }
    scene
}

/// Shares are of what the scene has, angles in rad, speeds in m/s.
fn apply(scene: &mut Scene, word: &str, value: f64) {
    let Cloud::JitteredLattice { columns, speed, .. } = &mut scene.cloud;
    match word {
        // dt over √(m/k). The settle rule is looked at just as often in time.
        "step" => {
            if let TimeStep::Fraction { of_sqrt_m_over_k } = &mut scene.time_step {
                let ratio = *of_sqrt_m_over_k / value;
                *of_sqrt_m_over_k = value;
                check_settling(scene, ratio);
            }
        }
        // A share. The settle rule's times stay as they are while dt grows as 1/√E.
        "modulus" => {
            scene.material.youngs_modulus *= value;
            check_settling(scene, value.sqrt());
        }
        "stiffness_ratio" => scene.material.stiffness_ratio = value,
        "alpha" => scene.damping = Damping::Cundall { alpha: value },
        "alpha_in_loading" => scene.loading.damping = Some(Damping::Cundall { alpha: value }),
        // The bed counts as settled at this share of the largest kinetic energy.
        "settled" => scene.settle.kinetic_energy_fraction = value,
        "columns" => *columns = value as u32,
        "cloud_speed" => *speed = value,
        // A share, at the same looseness of the cloud.
        "width" => {
            *columns = (f64::from(*columns) * value).round().max(1.0) as u32;
            scene.container.width *= value;
            multiply_grains(scene, [value, 1.0]);
        }
        "depth" => multiply_grains(scene, [1.0, value]),
        "grains_as_printed" => multiply_grains(scene, [1.0, value / f64::from(GRAINS)]),
        // The mean, mm, in a cloud that is as loose: with as many grains, or with grains of the same area.
        "diameter" | "diameter_of_same_area" => {
            let diameter = 1.0e-3 * value;
            let ratio = scene.particles.mean_diameter / diameter;
            *columns = (f64::from(*columns) * ratio).floor().max(1.0) as u32;
            scene.particles.mean_diameter = diameter;
            if word == "diameter_of_same_area" {
                multiply_grains(scene, [ratio, ratio]);
            }
        }
        // ΔD/D.
        "dispersion" => scene.particles.dispersion = value,
        // Grains have the mass of spheres.
        "spheres" => scene.particles.shape = Shape::Sphere,
        "density" => of_stages(scene).for_each(|material| material.density *= value),
        // Between grains.
        "friction" => scene.material.friction_angle = value,
        "friction_in_loading" => {
            scene.loading.material = Some(Material {
                friction_angle: value,
                ..scene.material.clone()
            });
        }
        // Of grains on floor and walls, in both stages.
        "wall_friction" => of_stages(scene).for_each(|material| {
            let differs = value != material.friction_angle;
            material.wall_friction_angle = differs.then_some(value);
        }),
        // Of grains on the punch.
        "punch_friction" => {
            let own = scene.loading.material.as_mut();
            let material = own.unwrap_or(&mut scene.material);
            let differs = value != material.friction_angle;
            material.punch_friction_angle = differs.then_some(value);
        }
        // At one, friction turns no grains.
        "blocked" => {
            scene.contact.rotation = match value < 0.5 {
                true => Rotation::Free,
                false => Rotation::Blocked,
            };
        }
        "blocked_in_loading" => {
            scene.loading.contact = Some(ContactLaw {
                rotation: Rotation::Blocked,
                ..scene.contact.clone()
            });
        }
        // With this restitution of each pair and without pull, in both stages; Cundall's damping is left beside them in both, in
        // pouring or nowhere.
        "dashpots" | "dashpots_and_poured_alpha" | "dashpots_alone" => {
            let tension = Tension::Clipped;
            let of_loading = scene.loading.contact.iter_mut();
            for contact in of_loading.chain([&mut scene.contact]) {
                let e_n = value;
                contact.viscosity = Viscosity::Restitution { e_n, tension };
            }
            match word {
                "dashpots" => {}
                "dashpots_alone" => (scene.damping, scene.loading.damping) = (UNDAMPED, None),
                _ => scene.loading.damping = Some(UNDAMPED),
            }
        }
        "punch_speed" => scene.loading.speed = value,
        // The punch stands still for so many seconds after the force; at zero it does not wait.
        "hold" => {
            scene.loading.after_force = match value > 0.0 {
                true => AfterForce::StandStill { seconds: value },
                false => AfterForce::MeasureAtOnce,
            };
        }
        "cells_of_equal_porosity" => scene.measurement.cell = Cell::EqualPorosity,
        // Mean surface, highest grain or twice the centre of mass: 0, 1 or 2.
        "surface" => {
            scene.measurement.surface_height = match value {
                ..0.5 => SurfaceHeight::MeanSurface,
                ..1.5 => SurfaceHeight::HighestGrain,
                _ => SurfaceHeight::TwiceCentreOfMass,
            };
        }
        other => unreachable!("{other} is no change"),
    }
}

/// The materials of both stages.
fn of_stages(scene: &mut Scene) -> impl Iterator<Item = &mut Material> {
    let of_loading = scene.loading.material.iter_mut();
    of_loading.chain([&mut scene.material])
}

fn multiply_grains(scene: &mut Scene, [width, depth]: [f64; 2]) {
    let count = f64::from(scene.particles.count) * width * depth;
    scene.particles.count = count.round() as u32;
}

/// The settle rule in steps that are shorter by this ratio.
fn check_settling(scene: &mut Scene, ratio: f64) {
    let scaled = |steps: u64| ((steps as f64 * ratio).round() as u64).max(1);
    scene.settle.check_every = scaled(scene.settle.check_every);
    scene.settle.max_steps = scaled(scene.settle.max_steps);
}
