//! What can be changed in a scene, by a word and a number: what settings of a study differ in.

use grains::scene::{
    AfterForce, Cell, Cloud, ContactLaw, Damping, Material, Rotation, Scene, Shape, SurfaceHeight,
    Tension, TimeStep, Viscosity,
};
use serde::Deserialize;

/// What is changed, and its value.
pub type Change = (What, f64);

/// Choices of a scene; which values they take stands where they are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum What {
    Step,
    Modulus,
    StiffnessRatio,
    Alpha,
    AlphaInLoading,
    Settled,
    Columns,
    CloudSpeed,
    Width,
    Depth,
    GrainsAsPrinted,
    Diameter,
    DiameterOfSameArea,
    Dispersion,
    Spheres,
    Density,
    Friction,
    FrictionInLoading,
    WallFriction,
    PunchFriction,
    Blocked,
    BlockedInLoading,
    Dashpots,
    DashpotsAndPouredAlpha,
    DashpotsAlone,
    PunchSpeed,
    Hold,
    CellsOfEqualPorosity,
    Surface,
}

/// The paper's number of grains.
pub const GRAINS: u32 = 5000;

const UNDAMPED: Damping = Damping::Cundall { alpha: 0.0 };

/// The scene with these changes, one after the other.
pub fn changed(mut scene: Scene, changes: &[Change]) -> Scene {
    for (what, value) in changes {
        apply(&mut scene, *what, *value);
    }
    scene
}

/// Shares are of what the scene has, angles in rad, speeds in m/s.
fn apply(scene: &mut Scene, what: What, value: f64) {
    let Cloud::JitteredLattice { columns, speed, .. } = &mut scene.cloud;
    match what {
        // dt over √(m/k). The settle rule is looked at just as often in time.
        What::Step => {
            if let TimeStep::Fraction { of_sqrt_m_over_k } = &mut scene.time_step {
                let ratio = *of_sqrt_m_over_k / value;
                *of_sqrt_m_over_k = value;
                check_settling(scene, ratio);
            }
        }
        // A share. The settle rule's times stay as they are while dt grows as 1/√E.
        What::Modulus => {
            scene.material.youngs_modulus *= value;
            check_settling(scene, value.sqrt());
        }
        What::StiffnessRatio => scene.material.stiffness_ratio = value,
        What::Alpha => scene.damping = Damping::Cundall { alpha: value },
        What::AlphaInLoading => scene.loading.damping = Some(Damping::Cundall { alpha: value }),
        // The bed counts as settled at this share of the largest kinetic energy.
        What::Settled => scene.settle.kinetic_energy_fraction = value,
        What::Columns => *columns = value as u32,
        What::CloudSpeed => *speed = value,
        // A share, at the same looseness of the cloud.
        What::Width => {
            *columns = (f64::from(*columns) * value).round().max(1.0) as u32;
            scene.container.width *= value;
            multiply_grains(scene, [value, 1.0]);
        }
        What::Depth => multiply_grains(scene, [1.0, value]),
        What::GrainsAsPrinted => multiply_grains(scene, [1.0, value / f64::from(GRAINS)]),
        // The mean, mm, in a cloud that is as loose: with as many grains, or with grains of the same area.
        What::Diameter | What::DiameterOfSameArea => {
            let diameter = 1.0e-3 * value;
            let ratio = scene.particles.mean_diameter / diameter;
            *columns = (f64::from(*columns) * ratio).floor().max(1.0) as u32;
            scene.particles.mean_diameter = diameter;
            if what == What::DiameterOfSameArea {
                multiply_grains(scene, [ratio, ratio]);
            }
        }
        // ΔD/D.
        What::Dispersion => scene.particles.dispersion = value,
        // Grains have the mass of spheres.
        What::Spheres => scene.particles.shape = Shape::Sphere,
        What::Density => of_stages(scene).for_each(|material| material.density *= value),
        // Between grains.
        What::Friction => scene.material.friction_angle = value,
        What::FrictionInLoading => {
            scene.loading.material = Some(Material {
                friction_angle: value,
                ..scene.material.clone()
            });
        }
        // Of grains on floor and walls, in both stages.
        What::WallFriction => of_stages(scene).for_each(|material| {
            let differs = value != material.friction_angle;
            material.wall_friction_angle = differs.then_some(value);
        }),
        // Of grains on the punch.
        What::PunchFriction => {
            let own = scene.loading.material.as_mut();
            let material = own.unwrap_or(&mut scene.material);
            let differs = value != material.friction_angle;
            material.punch_friction_angle = differs.then_some(value);
        }
        // At one, friction turns no grains.
        What::Blocked => {
            scene.contact.rotation = match value < 0.5 {
                true => Rotation::Free,
                false => Rotation::Blocked,
            };
        }
        What::BlockedInLoading => {
            scene.loading.contact = Some(ContactLaw {
                rotation: Rotation::Blocked,
                ..scene.contact.clone()
            });
        }
        // With this restitution of each pair and without pull, in both stages; Cundall's damping is left beside them in both, in
        // pouring or nowhere.
        What::Dashpots | What::DashpotsAndPouredAlpha | What::DashpotsAlone => {
            let tension = Tension::Clipped;
            let of_loading = scene.loading.contact.iter_mut();
            for contact in of_loading.chain([&mut scene.contact]) {
                let e_n = value;
                contact.viscosity = Viscosity::Restitution { e_n, tension };
            }
            match what {
                What::Dashpots => {}
                What::DashpotsAlone => (scene.damping, scene.loading.damping) = (UNDAMPED, None),
                _ => scene.loading.damping = Some(UNDAMPED),
            }
        }
        What::PunchSpeed => scene.loading.speed = value,
        // The punch stands still for so many seconds after the force; at zero it does not wait.
        What::Hold => {
            scene.loading.after_force = match value > 0.0 {
                true => AfterForce::StandStill { seconds: value },
                false => AfterForce::MeasureAtOnce,
            };
        }
        What::CellsOfEqualPorosity => scene.measurement.cell = Cell::EqualPorosity,
        // Mean surface, highest grain or twice the centre of mass: 0, 1 or 2.
        What::Surface => {
            scene.measurement.surface_height = match value {
                ..0.5 => SurfaceHeight::MeanSurface,
                ..1.5 => SurfaceHeight::HighestGrain,
                _ => SurfaceHeight::TwiceCentreOfMass,
            };
        }
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
