//! The native engine: exact solutions here; the kernels against the method written out plainly, rules, troubles and
//! the punch in files of their own.

mod all_pairs;
mod ends;
mod punch;

use grains::scene::{Damping, TimeStep};

use crate::support::*;

#[test]
fn free_fall_is_the_half_step_formula() {
    let mut scene = small_scene();
    scene.damping = Damping::Cundall { alpha: 0.0 };
    scene.particles.count = 1;
    scene.time_step = TimeStep::Absolute { seconds: 1.0e-4 };
    let mut bodies = Bodies::default();
    bodies.push([0.1, 1.0], [0.5, 0.2], 0.005, 0.2);
    let (outcome, _) = native_outcome(&scene, &Task::pour(bodies, 1000), None);
    let (n, dt, g) = (1000.0, 1.0e-4, 9.81);
    let z = 1.0 + 0.2 * n * dt - 0.5 * g * dt * dt * n * (n + 1.0);
    assert!((outcome.last.bodies.z[0] - z).abs() < 1e-12);
    assert!((outcome.last.bodies.x[0] - 0.15).abs() < 1e-13);
}

/// Closed form for a linear spring with local damping: e = √((1−α)/(1+α)).
#[test]
fn a_bounce_off_the_wall_has_the_restitution_of_local_damping() {
    for alpha in [0.1, 0.3, 0.7] {
        let mut scene = small_scene();
        scene.gravity = 0.0;
        scene.particles.count = 1;
        scene.damping = Damping::Cundall { alpha };
        let of_sqrt_m_over_k = 0.001;
        scene.time_step = TimeStep::Fraction { of_sqrt_m_over_k };
        let mut bodies = Bodies::default();
        bodies.push([0.0051, 0.1], [-0.5, 0.0], 0.005, scene.grain_mass(0.005));
        let (outcome, _) = native_outcome(&scene, &Task::pour(bodies, 40_000), None);
        let restitution = outcome.last.bodies.vx[0] / 0.5;
        let exact = ((1.0 - alpha) / (1.0 + alpha)).sqrt();
        near(restitution, exact, 1e-3 * exact);
    }
}

#[test]
fn collisions_keep_momentum_and_a_settled_bed_weighs_what_it_weighs() {
    let mut scene = small_scene();
    scene.settle.kinetic_energy_fraction = 1.0e-9;
    scene.damping = Damping::Cundall { alpha: 0.3 };
    let initial = initial_bodies(&scene);
    let (outcome, _) = native_outcome(&scene, &Task::pour(initial, 120_000), None);
    let bodies = &outcome.last.bodies;
    assert!(bodies.kinetic_energy() < 1e-3);
    let weight: f64 = bodies.mass.iter().sum::<f64>() * scene.gravity;
    let floor = scene.particles.count + 2;
    let on_floor = outcome.last.contacts.iter().filter(|of| of.id1 == floor);
    let borne: f64 = on_floor.map(|of| of.force()[1]).sum();
    assert!((borne / weight - 1.0).abs() < 0.05, "{borne} of {weight}");

    // Without gravity, damping and walls in reach, Σmv stays.
    scene.gravity = 0.0;
    scene.damping = Damping::Cundall { alpha: 0.0 };
    let mut cloud = Bodies::default();
    for (x, vx) in [(0.10, 1.0), (0.12, -1.0), (0.14, 0.5), (0.155, -2.0)] {
        cloud.push([x, 0.1 + 0.1 * x], [vx, 0.1 * vx], 0.005, 0.2 + x);
    }
    scene.particles.count = 4;
    let momentum =
        |bodies: &Bodies| -> f64 { bodies.mass.iter().zip(&bodies.vx).map(|(m, v)| m * v).sum() };
    let before = momentum(&cloud);
    let (outcome, _) = native_outcome(&scene, &Task::pour(cloud.clone(), 1000), None);
    assert!((momentum(&outcome.last.bodies) - before).abs() < 1e-14);
    assert_ne!(outcome.last.bodies.vx, cloud.vx, "they did collide");
}

#[test]
fn a_task_may_end_with_settling() {
    let scene = small_scene();
    let whole = Task::whole(initial_bodies(&scene));
    let settle = Task::settle(initial_bodies(&scene));
    assert_eq!(settle.until, Until::EndOfSettling);
    let whole = native::run(&scene, &whole, &sound(), &mut ()).expect("a sound run");
    let settled = native::run(&scene, &settle, &sound(), &mut ()).expect("a sound run");
    assert_eq!(settled.stages.len(), 1);
    assert_eq!(settled.stages[0].stop, StopReason::Settled);
    let bed = whole.settled.expect("a settled bed");
    assert_eq!(settled.last.bodies, bed.bodies);
    assert_eq!(settled.last.contacts, bed.contacts);
}

/// So many steps of a settled bed between two looks of anybody: what a steady step allocates would show.
fn allocations(mut scene: Scene, steps: u64) -> u64 {
    scene.measurement.history_every = 1_000_000;
    let (bed, _) = native_outcome(&scene, &Task::settle(initial_bodies(&scene)), None);
    let task = Task::pour(bed.last.bodies, steps);
    allocation_counter::measure(|| {
        native::run(&scene, &task, &sound(), &mut ()).expect("a sound run");
    })
    .count_total
}

#[test]
fn a_steady_step_allocates_nothing() {
    let mut rough = small_scene();
    rough.material.friction_angle = 0.5;
    for scene in [small_scene(), rough] {
        let short = allocations(scene.clone(), 200);
        let long = allocations(scene, 900);
        assert!(short > 0, "starting a run allocates");
        // The table at the end grows with its contacts; 700 steps of their own would show.
        assert!(long < short + 20, "{short}, {long}");
    }
}
