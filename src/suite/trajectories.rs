//! Trajectories of 5, 500 and 5,000 spinning grains, poured and under the punch, with friction and with
//! dashpots.

use super::Group;
use super::parity::ParityRung;
use grains::case::Case;
use grains::generate::initial_bodies;
use grains::model::Model;
use grains::native::{first_contact_punch, run_case};
use grains::scene::{
    Cloud, ContactLaw, NewContactSlip, Rotation, Scene, SlipVelocity, Tension, TorqueArms,
    Viscosity, paper_scene,
};

/// Largest spin of the cloud, rad/s.
const SPIN: f64 = 50.0;

/// Grains, steps of pouring and steps under the punch.
const SIZES: [(u32, u64, u64); 3] = [
    (5, 20_000, 20_000),
    (500, 8_000, 3_000),
    (5_000, 3_000, 1_500),
];

/// Steps of pouring in the native engine that make the bed for the punch.
const BED_STEPS: u64 = 12_000;

/// A rung for each size up to `most_grains`, law and stage.
pub fn rungs(most_grains: u32) -> Vec<ParityRung> {
    let mut rungs = Vec::new();
    for (grains, pour, load) in SIZES {
        if grains > most_grains {
            continue;
        }
        for (law, scene) in [("friction", rough(grains)), ("dashpot", viscous(grains))] {
            rungs.push(rung(grains, law, "pouring", poured(&scene, pour)));
            if let Some(case) = pressed(&scene, load) {
                rungs.push(rung(grains, law, "under the punch", case));
            }
        }
    }
    rungs
}

/// The paper's scene with so many grains, friction 0.5 and spins.
pub fn rough(grains: u32) -> Scene {
    let mut scene = paper_scene(1, grains);
    scene.material.friction_angle = 0.5;
    scene.material.stiffness_ratio = 0.3;
    let Cloud::JitteredLattice { columns, spin, .. } = &mut scene.cloud;
    *spin = SPIN;
    // A few grains stand in a narrow box, so that they meet.
    if grains < 100 {
        *columns = 2;
        scene.container.width = 0.025;
        scene.loading.half_width = 0.006;
        scene.measurement.local_radius = 0.02;
    } else if grains < 1_000 {
        *columns = 25;
        scene.container.width = 0.3125;
    }
    scene
}

/// The same with dashpots of 0.3 of the critical constant of two mean grains.
pub fn viscous(grains: u32) -> Scene {
    let mut scene = rough(grains);
    let radius = 0.5 * scene.particles.mean_diameter;
    let stiffness = scene.material.youngs_modulus * radius;
    let effective_mass = 0.5 * scene.grain_mass(radius);
    scene.contact = ContactLaw {
        rotation: Rotation::Free,
        viscosity: Viscosity::Dashpot {
            c_n: 0.3 * 2.0 * (effective_mass * stiffness).sqrt(),
            tension: Tension::Clipped,
        },
        slip_velocity: SlipVelocity::ContactPoint,
        torque_arms: TorqueArms::ContactPoint,
        new_contact_slip: NewContactSlip::WholeStep,
    };
    scene
}

fn poured(scene: &Scene, steps: u64) -> Case {
    Case {
        name: format!("pour {}", scene.particles.count),
        model: Model::of(scene),
        bodies: initial_bodies(scene),
        punch: None,
        moments: moments(steps),
    }
}

/// A bed that the native engine poured, with the punch set on it; none if that failed, which a rung
/// of pouring shows.
fn pressed(scene: &Scene, steps: u64) -> Option<Case> {
    let mut bed = poured(scene, BED_STEPS);
    bed.moments = vec![BED_STEPS];
    let bodies = run_case(&bed, None).ok()?.pop()?.bodies;
    let punch = first_contact_punch(scene, &bodies);
    Some(Case {
        name: format!("press {}", scene.particles.count),
        bodies,
        punch: Some(punch),
        moments: moments(steps),
        ..bed
    })
}

/// Ten moments, evenly spread.
fn moments(steps: u64) -> Vec<u64> {
    (0..=10).map(|tenth| tenth * steps / 10).collect()
}

fn rung(grains: u32, law: &str, stage: &str, case: Case) -> ParityRung {
    let short = stage.split(' ').next_back().unwrap_or(stage);
    ParityRung {
        name: format!("trajectory-{grains}-{law}-{short}"),
        title: format!(
            "{grains} spinning grains with {law}, {} steps {stage}",
            case.moments.last().unwrap_or(&0)
        ),
        group: Group::Parity,
        case,
        places: Vec::new(),
    }
}
