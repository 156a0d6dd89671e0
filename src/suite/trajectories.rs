//! Trajectories of 5, 500 and 5,000 spinning grains, poured and under the punch, with friction and with
//! dashpots.

use super::cross_code::CrossCase;
use grains::generate::initial_bodies;
use grains::model::Model;
use grains::native::{first_contact_punch, run_case};
use grains::scene::{Cloud, Scene, Tension, Viscosity, paper_scene};
use grains::task::Case;

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

/// A case for each size up to `most_grains`, law and stage.
pub fn cases(most_grains: u32) -> Vec<CrossCase> {
    let mut cases = Vec::new();
    for (grains, pour, load) in SIZES {
        if grains > most_grains {
            continue;
        }
        for (law, scene) in [("friction", rough(grains)), ("dashpot", viscous(grains))] {
            let pouring = ["pouring", "pouring"];
            cases.push(cross_case(grains, law, pouring, poured(&scene, pour)));
            if let Some(case) = pressed(&scene, load) {
                cases.push(cross_case(grains, law, ["punch", "under the punch"], case));
            }
        }
    }
    cases
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
    let viscosity = Viscosity::Dashpot {
        c_n: 0.3 * 2.0 * (effective_mass * stiffness).sqrt(),
        tension: Tension::Clipped,
    };
    scene.contact = super::build::with_viscosity(super::build::springs(1.0), viscosity).contact;
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

/// A bed that the native engine poured, with the punch set on it; none if that failed, which a case
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

fn cross_case(grains: u32, law: &str, [id, stage]: [&str; 2], case: Case) -> CrossCase {
    let steps = case.moments.last().copied().unwrap_or(0);
    CrossCase {
        id: format!("trajectory-{grains}-{law}-{id}"),
        title: format!("{grains} spinning grains with {law}, {steps} steps {stage}"),
        case,
        places: Vec::new(),
    }
}
