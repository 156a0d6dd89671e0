//! The kernels and their neighbour list against the method written out plainly, which looks at every pair.

use grains::model::Model;
use grains::native::Threads;
use grains::scene::{NewContactSlip, Rotation, Shape, SlipVelocity, TorqueArms};
use grains::task::Outcome;

use crate::support::all_pairs::AllPairs;
use crate::support::*;

/// Skins of the neighbour list, most pairs near one another or hardly any, m; and numbers of threads.
const WAYS: [(f64, usize); 4] = [(2.0e-5, 1), (2.0e-4, 1), (1.0e-3, 3), (4.0e-3, 1)];

fn outcome(scene: &Scene, task: &Task, (skin, most): (f64, usize)) -> (Outcome, Keep) {
    let options = native::Options {
        skin: Some(skin),
        threads: Threads {
            most,
            grains_each: 1,
        },
        ..sound()
    };
    let mut keep = Keep::default();
    let outcome = native::run(scene, task, &options, &mut keep);
    (outcome.expect("a native run that finishes"), keep)
}

fn assert_same(engine: &Snapshot, all: &AllPairs, when: &str) {
    assert_eq!(engine.bodies.digest(), all.bodies.digest(), "{when}");
    assert_eq!(engine.contacts, all.contacts, "{when}");
    assert_eq!(engine.punch, all.punch, "{when}");
}

/// Pours this scene, as long as asked and in each way, and compares on the way.
fn pours_like_all_pairs(scene: &Scene, steps: u64) {
    let initial = initial_bodies(scene);
    let mut scene = scene.clone();
    scene.measurement.history_every = steps / 8;
    let mut all = AllPairs::new(&Model::of(&scene), &initial, None);
    let task = Task::pour(initial, steps);
    let runs = WAYS.map(|way| outcome(&scene, &task, way).1.0);
    for moment in 0..runs[0].len() {
        for (run, way) in runs.iter().zip(WAYS) {
            let step = run[moment].step;
            assert_same(&run[moment], &all, &format!("step {step}, {way:?}"));
        }
        if moment < 8 {
            (0..steps / 8).for_each(|_| all.step());
        }
    }
    let contacts = all.contacts.len();
    assert!(contacts > all.bodies.len(), "the bed has {contacts}");
}

/// A punch driven into the poured bed, compared in each way. Returns the last moment.
fn is_pressed_like_all_pairs(scene: &mut Scene, poured: u64, steps: u64) -> Snapshot {
    let (settled, _) = native_outcome(scene, &Task::pour(initial_bodies(scene), poured), None);
    let bodies = settled.last.bodies;
    scene.loading.speed = 0.4;
    let punch = native::first_contact_punch(scene, &bodies);
    let mut all = AllPairs::new(&Model::of(scene), &bodies, Some(punch));
    (0..steps).for_each(|_| all.step());
    let task = Task {
        start: Start {
            stage: Stage::Load,
            punch: Some(punch),
            ..bodies.into()
        },
        until: Until::Step(steps),
    };
    let [last, ..] = WAYS.map(|way| {
        let (outcome, _) = outcome(scene, &task, way);
        assert_same(&outcome.last, &all, &format!("{way:?}"));
        outcome.last
    });
    let id = scene.particles.count + 3;
    let on_punch = last.contacts.iter().filter(|c| c.id1 == id).count();
    assert!(on_punch > 0, "it touches grains");
    last
}

#[test]
fn the_kernel_has_the_bits_of_looking_at_every_pair_while_pouring() {
    pours_like_all_pairs(&scene_of(120), 8000);
}

#[test]
fn the_kernel_has_the_bits_of_looking_at_every_pair_under_the_punch() {
    is_pressed_like_all_pairs(&mut scene_of(120), 20_000, 1500);
}

#[test]
fn friction_has_the_bits_of_looking_at_every_pair_while_pouring() {
    let mut scene = frictional_scene();
    pours_like_all_pairs(&scene, 16_000);
    // Lighter grains, softer, so that the time step is about the same.
    scene.particles.shape = Shape::Sphere;
    scene.material.youngs_modulus *= 0.01;
    scene.contact.torque_arms = TorqueArms::ContactPoint;
    scene.contact.slip_velocity = SlipVelocity::ContactPoint;
    scene.contact.new_contact_slip = NewContactSlip::SinceTouch;
    pours_like_all_pairs(&scene, 16_000);
    scene.contact.rotation = Rotation::Blocked;
    pours_like_all_pairs(&scene, 16_000);
}

#[test]
fn friction_has_the_bits_of_looking_at_every_pair_under_the_punch() {
    let last = is_pressed_like_all_pairs(&mut frictional_scene(), 30_000, 4000);
    let turned = last.bodies.spin.iter().all(|spin| *spin != 0.0);
    let rubbed = last.contacts.iter().any(|c| c.tangential_force != 0.0);
    assert!(turned && rubbed);
}

/// Settled by its rule, then loaded: what contacts remember goes from one stage into the next. Returns the outcome.
fn is_loaded_like_all_pairs(scene: &Scene) -> Outcome {
    let initial = initial_bodies(scene);
    let task = Task::whole(initial.clone());
    let [first, others @ ..] = WAYS.map(|way| outcome(scene, &task, way).0);
    let steps: Vec<u64> = first.stages.iter().map(|stage| stage.steps).collect();
    let mut all = AllPairs::new(&Model::of(scene), &initial, None);
    (0..steps[0]).for_each(|_| all.step());
    let settled = first.settled.as_ref().expect("a settled bed");
    assert_same(settled, &all, "settled");
    all.punch = Some(native::first_contact_punch(scene, &all.bodies));
    all.change(&Model::in_stage(scene, Stage::Load));
    (0..steps[1]).for_each(|_| all.step());
    assert_same(&first.last, &all, "loaded");
    for (other, way) in others.iter().zip(&WAYS[1..]) {
        assert_eq!(other.last, first.last, "{way:?}");
        assert_eq!(other.settled, first.settled, "{way:?}");
    }
    first
}

/// Whether contacts bear more tangential force than rounding gives.
fn rubs(moment: &Snapshot) -> bool {
    let mut contacts = moment.contacts.iter();
    contacts.any(|of| of.tangential_force.abs() > 1.0e-6 * of.normal_force.abs())
}

#[test]
fn friction_has_the_bits_of_looking_at_every_pair_in_a_whole_experiment() {
    let outcome = is_loaded_like_all_pairs(&frictional_scene());
    assert!(outcome.settled.is_some_and(|settled| rubs(&settled)));
}

#[test]
fn constants_of_loading_have_the_bits_of_looking_at_every_pair() {
    for (name, changes, expected, _) in stages() {
        let outcome = is_loaded_like_all_pairs(&staged_scene(changes));
        let settled = outcome.settled.expect("a settled bed");
        let rub = [&settled, &outcome.last].map(rubs);
        assert_eq!(rub, expected, "{name}");
    }
}

#[test]
fn bits_do_not_depend_on_the_skin() {
    let scene = small_scene();
    let task = Task::whole(initial_bodies(&scene));
    let (thin, thin_history) = native_outcome(&scene, &task, Some(2.0e-5));
    for skin in [2.0e-4, 1.0e-3, 4.0e-3] {
        let (other, history) = native_outcome(&scene, &task, Some(skin));
        assert_eq!(other.last, thin.last, "skin {skin}");
        assert_eq!(history.0, thin_history.0, "skin {skin}");
    }
}
