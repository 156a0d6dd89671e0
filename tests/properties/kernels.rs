//! The two kernels: the same bits where both apply, and what the cheap one saves.

use grains::model::{Kernel, Model};

use super::*;

/// An angle above zero whose tan² is zero: the general kernel with every shear force cut to nothing.
const CUTS_ALL_SHEAR: f64 = 1.0e-200;

fn general(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.material.friction_angle = CUTS_ALL_SHEAR;
    assert_eq!(Kernel::of(&Model::of(&scene).law), Kernel::General);
    scene
}

#[test]
fn friction_of_nothing_has_the_bits_of_no_friction() {
    let mut scene = paper_scene(1, 500);
    scene.container.width = 0.3;
    scene.cloud = small_scene().cloud;
    scene.measurement.history_every = 1000;
    assert_eq!(Kernel::of(&Model::of(&scene).law), Kernel::Frictionless);
    let poured = |scene: &Scene| {
        let task = Task::pour(initial_bodies(scene), 12_000);
        native_outcome(scene, &task, None).1
    };
    let (smooth, rough) = (poured(&scene), poured(&general(&scene)));
    assert_eq!(smooth.len(), 13);
    for (smooth, mut rough) in smooth.iter().zip(rough) {
        let step = smooth.step;
        assert_eq!(smooth.contacts, rough.contacts, "step {step}");
        // A normal force turns a grain by its rounding.
        let spins = std::mem::take(&mut rough.bodies.spin);
        assert!(spins.iter().all(|spin| spin.abs() < 1.0e-9));
        let [smooth, rough] = [&smooth.bodies, &rough.bodies].map(Bodies::digest);
        assert_eq!(smooth, rough, "step {step}");
    }
    let contacts = smooth[12].contacts.len();
    assert!(contacts > 500, "{contacts}");
}

/// Processor time of so many steps of the poured bed, s.
fn seconds(scene: &Scene, poured: &Bodies, steps: u64) -> f64 {
    let mut bodies = initial_bodies(scene);
    let Bodies { x, z, vx, vz, .. } = poured.clone();
    (bodies.x, bodies.z, bodies.vx, bodies.vz) = (x, z, vx, vz);
    let (outcome, _) = native_outcome(scene, &Task::pour(bodies, steps), None);
    let contacts = outcome.last.contacts.len();
    assert!(contacts > 5000, "{contacts}");
    outcome.stages[0].cpu_seconds
}

#[test]
fn the_frictionless_kernel_takes_at_most_two_thirds_of_the_time() {
    let mut smooth = paper_scene(1, 5000);
    smooth.measurement.history_every = 1_000_000;
    let rough = general(&smooth);
    let task = Task::pour(initial_bodies(&smooth), 30_000);
    let poured = native_outcome(&smooth, &task, None).0.last.bodies;
    let ratio = |_| seconds(&rough, &poured, 300) / seconds(&smooth, &poured, 300);
    let mut ratios: Vec<f64> = (0..15).map(ratio).collect();
    ratios.sort_by(f64::total_cmp);
    println!("general over frictionless: {ratios:.2?}");
    assert!(ratios[7] >= 1.5, "{ratios:?}");
}
