//! How runs end: by the rules of the scene, or in trouble that names step and grain.

use crossgrain::suite::{Grain, case, model, springs};
use grains::native::{NativeError, Trouble};
use grains::scene::{Damping, TimeStep};

use crate::support::*;

#[test]
fn every_end_of_loading_is_typed() {
    let mut scene = small_scene();
    let task = Task::whole(initial_bodies(&scene));
    let (outcome, _) = native_outcome(&scene, &task, None);
    let stops: Vec<StopReason> = outcome.stages.iter().map(|stage| stage.stop).collect();
    assert_eq!(stops, [StopReason::Settled, StopReason::Reached]);
    let force = outcome.last.punch.expect("the punch").force;
    assert!(force >= scene.target_force());

    // A load that no bed bears: the punch sinks to the give-up depth, and the run says so.
    scene.loading.pressure = 1.0e9;
    scene.loading.give_up_depth = 0.02;
    let (outcome, _) = native_outcome(&scene, &task, None);
    let last = outcome.stages.last().expect("a stage");
    assert_eq!(last.stop, StopReason::TargetLoadNotReached);
    let depth = outcome.last.punch.expect("the punch").depth();
    assert!((0.02..0.0201).contains(&depth), "{depth}");

    scene.settle.max_steps = 5000;
    let (outcome, _) = native_outcome(&scene, &task, None);
    assert_eq!(outcome.stages.len(), 1);
    assert_eq!(outcome.stages[0].stop, StopReason::MaxSteps);
    assert_eq!(outcome.stages[0].steps, 5000);
}

fn trouble(scene: &Scene, bodies: Bodies) -> NativeError {
    let task = Task::pour(bodies, 3_000_000);
    native::run(scene, &task, &sound(), &mut ()).expect_err("a run that goes wrong")
}

#[test]
fn troubles_name_step_and_grain() {
    let scene = scene_of(2);
    let two = |x: f64, vx: f64| {
        let mut bodies = Bodies::default();
        bodies.push([0.1, 0.1], [0.0, 0.0], 0.005, 0.2);
        bodies.push([x, 0.1], [vx, 0.0], 0.005, 0.2);
        bodies
    };
    // Through the wall between two steps.
    let error = trouble(&scene, two(0.2, 2.0e4));
    assert!(matches!(error.trouble, Trouble::Lost { grain: 1, .. }));
    assert!(error.step > 0 && error.step < 100, "{error}");
    // Two grains at the same place have no normal, and overlap by more than springs mean.
    let error = trouble(&scene, two(0.1, 0.0));
    assert!(matches!(error.trouble, Trouble::BeyondRadius { .. }));
    // A start that is not a number.
    let error = trouble(&scene, two(f64::NAN, 0.0));
    assert_eq!(error.trouble, Trouble::NotFinite { grain: 1 });
    assert_eq!(error.step, 0);
}

/// Two centres in one place have no normal: noticed in the very step, though nobody looks for it.
#[test]
fn what_is_not_a_number_is_noticed_in_its_step() {
    let grains = [Grain::disc([0.1, 0.1], 0.005, 2600.0); 2];
    let model = model(springs(1.0e6), 1.0e-5);
    let case = case("two in one place", model, &grains, vec![900]);
    let error = native::run_case(&case, None).expect_err("0/0");
    assert!(matches!(error.trouble, Trouble::NotFinite { .. }));
    assert!(error.step <= 2, "{error}");
}

/// One grain on the floor with twice the stable step gains energy at every bounce.
#[test]
fn energy_from_a_step_beyond_the_limit_is_noticed() {
    let mut scene = scene_of(1);
    scene.damping = Damping::Cundall { alpha: 0.0 };
    let of_sqrt_m_over_k = 1.9;
    scene.time_step = TimeStep::Fraction { of_sqrt_m_over_k };
    // Little work for the punch to do, so little energy is allowed.
    scene.loading.pressure = 1.0;
    let mut bodies = Bodies::default();
    bodies.push([0.1, 0.0051], [0.0, 0.0], 0.005, scene.grain_mass(0.005));
    let error = trouble(&scene, bodies);
    let blown_up = matches!(error.trouble, Trouble::EnergyBlownUp { grain: 0, .. });
    assert!(blown_up, "{error}");
}
