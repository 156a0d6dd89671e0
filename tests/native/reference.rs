//! The kernels and their neighbour list against the step written out plainly.

use grains::model::Model;
use grains::native::Threads;
use grains::reference::Reference;
use grains::scene::{
    NewContactSlip, Rotation, Shape, SlipVelocity, Tension, TorqueArms, Viscosity,
};
use grains::tables::BodyIds;
use grains::task::Outcome;
use grains::variant::Variant;

use crate::support::*;

/// Skins of the neighbour list, most pairs near one another or hardly any, m; and numbers of threads.
const WAYS: [(f64, usize); 4] = [(2.0e-5, 1), (2.0e-4, 1), (1.0e-3, 3), (4.0e-3, 1)];

fn outcome(scene: &Scene, task: &Task, (skin, most): (f64, usize)) -> (Outcome, Vec<Snapshot>) {
    let options = native::Options {
        skin: Some(skin),
        threads: Threads {
            most,
            grains_each: 1,
        },
        ..sound()
    };
    let mut keep = Vec::new();
    let outcome = native::run(scene, task, &options, &mut keep);
    (outcome.expect("a native run that finishes"), keep)
}

/// Runs this scene in each way and compares every moment; what contacts remember goes from one stage into the next.
fn is_like_the_reference(scene: &Scene, until: Until) -> Outcome {
    let mut scene = scene.clone();
    scene.measurement.history_every = 1000;
    let initial = initial_bodies(&scene);
    let model = Model::of(&scene);
    let mut reference = Reference::new(&model, &initial, None, &Variant::default());
    let start = initial.into();
    let task = Task { start, until };
    let [(first, moments), others @ ..] = WAYS.map(|way| outcome(&scene, &task, way));
    let mut begun = 0;
    for moment in &moments {
        if moment.stage == Stage::Load && reference.punch.is_none() {
            let punch = native::first_contact_punch(&scene, &reference.bodies());
            reference.press(Some(punch));
            reference.change(&Model::in_stage(&scene, Stage::Load));
            begun = reference.steps();
            continue;
        }
        while reference.steps() < begun + moment.step {
            reference.step();
        }
        let when = format!("{:?} {}", moment.stage, moment.step);
        assert_eq!(
            moment.bodies.digest(),
            reference.bodies().digest(),
            "{when}"
        );
        assert_eq!(moment.contacts, reference.contacts(), "{when}");
        assert_eq!(moment.punch, reference.punch, "{when}");
    }
    for ((other, same), way) in others.iter().zip(&WAYS[1..]) {
        assert_eq!(*same, moments, "{way:?}");
        assert_eq!(other.last, first.last, "{way:?}");
        assert_eq!(other.settled, first.settled, "{way:?}");
    }
    first
}

#[test]
fn friction_has_the_bits_of_the_reference_while_pouring() {
    let mut scene = frictional_scene();
    // Lighter grains, softer, so that the time step is about the same.
    scene.particles.shape = Shape::Sphere;
    scene.material.youngs_modulus *= 0.01;
    scene.contact.torque_arms = TorqueArms::ContactPoint;
    scene.contact.slip_velocity = SlipVelocity::ContactPoint;
    scene.contact.new_contact_slip = NewContactSlip::SinceTouch;
    for rotation in [Rotation::Free, Rotation::Blocked] {
        scene.contact.rotation = rotation;
        let poured = is_like_the_reference(&scene, Until::Step(16_000)).last;
        let contacts = poured.contacts.len();
        assert!(contacts > poured.bodies.len(), "the bed has {contacts}");
    }
}

/// Whether contacts bear more tangential force than rounding gives.
fn rubs(moment: &Snapshot) -> bool {
    let mut contacts = moment.contacts.iter();
    contacts.any(|contact| contact.tangential_force.abs() > 1.0e-6 * contact.normal_force.abs())
}

/// The punch goes deep, whatever it bears.
#[test]
fn every_kernel_has_the_bits_of_the_reference_in_a_whole_experiment() {
    for (mut scene, rough) in [(scene_of(120), false), (frictional_scene(), true)] {
        scene.loading.speed = 0.4;
        scene.loading.pressure = 1.0e9;
        scene.loading.give_up_depth = 0.02;
        let outcome = is_like_the_reference(&scene, Until::EndOfLoading);
        let settled = outcome.settled.expect("a settled bed");
        assert!(settled.contacts.len() > settled.bodies.len());
        let last = &outcome.last;
        assert_eq!([&settled, last].map(rubs), [rough; 2]);
        let turn = last.bodies.spin.iter().filter(|spin| **spin != 0.0);
        assert_eq!(turn.count(), if rough { last.bodies.len() } else { 0 });
        let punch = scene.particles.count + 3;
        assert!(last.contacts.iter().any(|contact| contact.id1 == punch));
    }
}

#[test]
fn constants_of_loading_have_the_bits_of_the_reference() {
    for (name, changes, expected, _) in stages() {
        let outcome = is_like_the_reference(&staged_scene(changes), Until::EndOfLoading);
        let settled = outcome.settled.expect("a settled bed");
        let rub = [&settled, &outcome.last].map(rubs);
        assert_eq!(rub, expected, "{name}");
    }
}

/// Contacts slide at each of the three limits, so that each angle counts, and grains turn.
#[test]
fn friction_apart_beside_dashpots_has_the_bits_of_the_reference() {
    let mut scene = frictional_scene();
    scene.material.wall_friction_angle = Some(0.2);
    scene.material.punch_friction_angle = Some(0.1);
    let tension = Tension::Clipped;
    scene.contact.viscosity = Viscosity::Restitution { e_n: 0.6, tension };
    scene.loading.speed = 0.4;
    scene.loading.pressure = 1.0e9;
    scene.loading.give_up_depth = 0.02;
    let last = is_like_the_reference(&scene, Until::EndOfLoading).last;
    assert!(last.bodies.spin.iter().all(|spin| *spin != 0.0));
    scene.measurement.history_every = 1000;
    let (_, moments) = outcome(&scene, &Task::whole(initial_bodies(&scene)), WAYS[0]);
    let limits = Model::of(&scene).law.friction_angles().map(f64::tan);
    let ids = BodyIds::of_box(scene.particles.count);
    let mut sliding = [0; 3];
    for contact in moments.iter().flat_map(|moment| &moment.contacts) {
        let kind = ids.body(contact.id1) as usize;
        let at_limit =
            (contact.tangential_force.abs() / contact.normal_force / limits[kind] - 1.0).abs();
        sliding[kind] += usize::from(at_limit < 1.0e-9);
    }
    assert!(!sliding.contains(&0), "{sliding:?}");
}
