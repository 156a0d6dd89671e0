//! The native engine: the kernels against the method written out plainly, exact solutions, rules and
//! troubles.

use crossgrain::engine::case::Case;
use crossgrain::engine::native::{self, CaseOptions, NativeError, Trouble, contact};
use crossgrain::engine::{Start, Task, Until};
use crossgrain::generate::initial_bodies;
use crossgrain::measure::{Bed, coordination, energy};
use crossgrain::model::Model;
use crossgrain::scene::{
    Damping, NewContactSlip, Rotation, Scene, Shape, SlipVelocity, TimeStep, TorqueArms,
};
use crossgrain::tables::{Bodies, Punch, Snapshot, Stage, StopReason};
use crossgrain::verify::build::{Grain, case, model, punch, springs};
use proptest::prelude::*;

use crate::support::all_pairs::AllPairs;
use crate::support::{frictional_scene, native_outcome, small_scene, sound};

/// Skins of the neighbour list: most pairs near one another or hardly any, m.
const SKINS: [f64; 4] = [2.0e-5, 2.0e-4, 1.0e-3, 4.0e-3];

fn assert_same(engine: &Snapshot, all: &AllPairs, when: &str) {
    assert_eq!(engine.bodies.digest(), all.bodies.digest(), "{when}");
    assert_eq!(engine.contacts, all.contacts, "{when}");
    assert_eq!(engine.punch, all.punch, "{when}");
}

/// Pours this scene, as long as asked and with each skin, and compares on the way.
fn pours_like_all_pairs(scene: &Scene, steps: u64) {
    let initial = initial_bodies(scene);
    let mut scene = scene.clone();
    scene.measurement.history_every = steps / 8;
    let mut all = AllPairs::new(&Model::of(&scene), &initial, None);
    let task = Task::pour(initial, steps);
    let runs = SKINS.map(|skin| native_outcome(&scene, &task, Some(skin)).1.0);
    for moment in 0..runs[0].len() {
        for (run, skin) in runs.iter().zip(SKINS) {
            let step = run[moment].step;
            assert_same(&run[moment], &all, &format!("step {step}, skin {skin}"));
        }
        if moment < 8 {
            (0..steps / 8).for_each(|_| all.step());
        }
    }
    let contacts = all.contacts.len();
    assert!(contacts > all.bodies.len(), "the bed has {contacts}");
}

/// A punch driven into the poured bed, compared with each skin. Returns the last moment.
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
            step: 0,
            bodies,
            punch: Some(punch),
        },
        until: Until::Step(steps),
    };
    let [last, ..] = SKINS.map(|skin| {
        let (outcome, _) = native_outcome(scene, &task, Some(skin));
        assert_same(&outcome.last, &all, &format!("skin {skin}"));
        outcome.last
    });
    let id = scene.particles.count + 3;
    let on_punch = last.contacts.iter().filter(|c| c.id1 == id).count();
    assert!(on_punch > 0, "it touches grains");
    last
}

#[test]
fn the_kernel_has_the_bits_of_looking_at_every_pair_while_pouring() {
    let mut scene = small_scene();
    scene.particles.count = 120;
    pours_like_all_pairs(&scene, 8000);
}

#[test]
fn the_kernel_has_the_bits_of_looking_at_every_pair_under_the_punch() {
    let mut scene = small_scene();
    scene.particles.count = 120;
    is_pressed_like_all_pairs(&mut scene, 20_000, 1500);
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

/// Settled by its rule, then loaded: what contacts remember goes from one stage into the next.
#[test]
fn friction_has_the_bits_of_looking_at_every_pair_in_a_whole_experiment() {
    let scene = frictional_scene();
    let initial = initial_bodies(&scene);
    let task = Task::whole(initial.clone());
    let [outcome, ..] = SKINS.map(|skin| native_outcome(&scene, &task, Some(skin)).0);
    let steps: Vec<u64> = outcome.stages.iter().map(|stage| stage.steps).collect();
    let mut all = AllPairs::new(&Model::of(&scene), &initial, None);
    (0..steps[0]).for_each(|_| all.step());
    let settled = outcome.settled.as_ref().expect("a settled bed");
    assert_same(settled, &all, "settled");
    assert!(settled.contacts.iter().any(|c| c.tangential_force != 0.0));
    all.punch = Some(native::first_contact_punch(&scene, &all.bodies));
    (0..steps[1]).for_each(|_| all.step());
    assert_same(&outcome.last, &all, "loaded");
    for skin in &SKINS[1..] {
        let (other, _) = native_outcome(&scene, &task, Some(*skin));
        assert_eq!(other.last, outcome.last, "skin {skin}");
        assert_eq!(other.settled, outcome.settled, "skin {skin}");
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
        scene.time_step = TimeStep::Fraction {
            of_sqrt_m_over_k: 0.001,
        };
        let mut bodies = Bodies::default();
        bodies.push([0.0051, 0.1], [-0.5, 0.0], 0.005, scene.grain_mass(0.005));
        let (outcome, _) = native_outcome(&scene, &Task::pour(bodies, 40_000), None);
        let restitution = outcome.last.bodies.vx[0] / 0.5;
        let exact = ((1.0 - alpha) / (1.0 + alpha)).sqrt();
        assert!(
            (restitution - exact).abs() < 1e-3 * exact,
            "{restitution} against {exact}"
        );
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
    assert!(energy::kinetic(bodies) < 1e-3);
    let weight: f64 = bodies.mass.iter().sum::<f64>() * scene.gravity;
    let floor = scene.particles.count + 2;
    let borne: f64 = outcome
        .last
        .contacts
        .iter()
        .filter(|contact| contact.id1 == floor)
        .map(|contact| contact.force()[1])
        .sum();
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
    assert_eq!(last.stop, StopReason::SankToGiveUpDepth);
    let depth = outcome.last.punch.expect("the punch").depth();
    assert!((0.02..0.0201).contains(&depth), "{depth}");

    scene.settle.max_steps = 5000;
    let (outcome, _) = native_outcome(&scene, &task, None);
    assert_eq!(outcome.stages.len(), 1);
    assert_eq!(outcome.stages[0].stop, StopReason::MaxSteps);
    assert_eq!(outcome.stages[0].steps, 5000);
}

fn trouble(scene: &Scene, bodies: Bodies) -> NativeError {
    native::run(scene, &Task::pour(bodies, 5000), &sound(), &mut ())
        .expect_err("a run that goes wrong")
}

#[test]
fn troubles_name_step_and_grain() {
    let mut scene = small_scene();
    scene.particles.count = 2;
    let two = |x: f64, vx: f64| {
        let mut bodies = Bodies::default();
        bodies.push([0.1, 0.1], [0.0, 0.0], 0.005, 0.2);
        bodies.push([x, 0.1], [vx, 0.0], 0.005, 0.2);
        bodies
    };
    // Through the wall between two steps.
    let error = trouble(&scene, two(0.2, 2.0e4));
    assert!(
        matches!(error.trouble, Trouble::Lost { grain: 1, .. }),
        "{error}"
    );
    assert!(error.step > 0 && error.step < 100);
    // Two grains at the same place have no normal, and overlap by more than springs mean.
    let error = trouble(&scene, two(0.1, 0.0));
    assert!(
        matches!(error.trouble, Trouble::BeyondRadius { .. }),
        "{error}"
    );
    // A start that is not a number.
    let error = trouble(&scene, two(f64::NAN, 0.0));
    assert_eq!(error.trouble, Trouble::NotFinite { grain: 1 });
    assert_eq!(error.step, 0);
}

/// Two centres in one place have no normal: noticed in the very step, though nobody looks for it.
#[test]
fn what_is_not_a_number_is_noticed_in_its_step() {
    let grains = [Grain::disc([0.1, 0.1], 0.005, 2600.0); 2];
    let case = case(
        "two in one place",
        model(springs(1.0e6), 1.0e-5),
        &grains,
        vec![900],
    );
    let error = native::run_case(&case, None).expect_err("0/0");
    assert!(
        matches!(error.trouble, Trouble::NotFinite { .. }),
        "{error}"
    );
    assert!(error.step <= 2, "{error}");
}

/// One grain on the floor with twice the stable step gains energy at every bounce.
#[test]
fn energy_from_a_step_beyond_the_limit_is_noticed() {
    let mut scene = small_scene();
    scene.particles.count = 1;
    scene.damping = Damping::Cundall { alpha: 0.0 };
    scene.time_step = TimeStep::Fraction {
        of_sqrt_m_over_k: 1.9,
    };
    // Little work for the punch to do, so little energy is allowed.
    scene.loading.pressure = 1.0;
    let mut bodies = Bodies::default();
    bodies.push([0.1, 0.0051], [0.0, 0.0], 0.005, scene.grain_mass(0.005));
    let task = Task::pour(bodies, 3_000_000);
    let error = native::run(&scene, &task, &sound(), &mut ()).expect_err("energy from nowhere");
    assert!(
        matches!(error.trouble, Trouble::EnergyBlownUp { grain: 0, .. }),
        "{error}"
    );
}

/// A punch of 0.2 m by 0.4 m around the origin and a grain in it: in a corner's reach of each face and
/// on a face itself.
#[test]
fn a_grain_inside_the_punch_bears_the_force_of_the_nearest_face() {
    let (radius, modulus) = (0.01, 1.0e7);
    for (place, normal, depth) in [
        ([0.095, -0.185], [1.0, 0.0], 0.005),
        ([-0.095, -0.185], [-1.0, 0.0], 0.005),
        ([0.085, -0.195], [0.0, -1.0], 0.005),
        ([0.02, 0.15], [0.0, 1.0], 0.05),
        ([0.0, -0.2], [0.0, -1.0], 0.0),
        ([0.1, 0.03], [1.0, 0.0], 0.0),
        ([-0.02, -0.01], [-1.0, 0.0], 0.08),
    ] {
        let grain = Grain::disc(place, radius, 2600.0);
        let mut case = case(
            "in the punch",
            model(springs(modulus), 1.0e-5),
            &[grain],
            vec![0, 1],
        );
        case.punch = Some(punch(0.0, -0.2, [0.1, 0.2], 0.0));
        let moments = native::run_case(&case, None).expect("a sound run");
        let [contact] = moments[0].contacts[..] else {
            panic!("one contact at {place:?}");
        };
        assert_eq!((contact.id1, contact.id2), (1, 0));
        assert_eq!(contact.normal, normal, "{place:?}");
        assert!(
            (contact.overlap - (radius + depth)).abs() < 1.0e-16,
            "{place:?}"
        );
        let force = modulus * radius * (radius + depth);
        assert!(
            (contact.normal_force / force - 1.0).abs() < 1.0e-14,
            "{place:?}"
        );
        // The middle between the face and the deepest point of the grain.
        let middle = [0, 1].map(|axis| place[axis] + 0.5 * (depth - radius) * normal[axis]);
        let off = (contact.point[0] - middle[0]).hypot(contact.point[1] - middle[1]);
        assert!(off < 1.0e-16, "{place:?}");
        let pushed = [moments[1].bodies.vx[0], moments[1].bodies.vz[0]];
        let speed = force / grain.mass * 1.0e-5;
        let wrong = (pushed[0] - speed * normal[0]).hypot(pushed[1] - speed * normal[1]);
        assert!(wrong < 1.0e-14 * speed, "{place:?}: {pushed:?}");
    }
}

/// Grains at rest make no list old; the punch's own way must.
#[test]
fn the_punch_reaches_a_grain_that_was_far_when_the_list_was_made() {
    let mut scene = small_scene();
    scene.particles.count = 1;
    scene.gravity = 0.0;
    scene.loading.speed = 0.4;
    let mut bodies = Bodies::default();
    bodies.push([0.15, 0.05], [0.0, 0.0], 0.005, 0.2);
    let start = 0.055 + 0.02;
    let punch = Punch {
        centre: [0.15, start + 0.15],
        half_extents: [0.0225, 0.15],
        start,
        velocity: -0.4,
        force: 0.0,
    };
    let task = Task {
        start: Start {
            stage: Stage::Load,
            step: 0,
            bodies,
            punch: Some(punch),
        },
        until: Until::Step(1800),
    };
    let (outcome, _) = native_outcome(&scene, &task, None);
    let last = &outcome.last;
    let depth = last.punch.expect("the punch").depth();
    assert!(depth > 0.0201, "{depth}");
    assert!(last.bodies.vz[0] < -0.3, "{}", last.bodies.vz[0]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Contacts found through the neighbour list are those of looking at every pair, after motion
    /// that makes the list old.
    #[test]
    fn the_neighbour_list_misses_no_contact(
        places in proptest::collection::vec((0.01f64..0.29, 0.01f64..0.2, -1.0f64..1.0, -1.0f64..1.0), 2..120),
        steps in 1u64..40,
        skin in 1.0e-5f64..3.0e-3,
    ) {
        let mut scene = small_scene();
        scene.particles.count = places.len() as u32;
        // Soft grains: they may overlap deeply without flying apart.
        scene.material.youngs_modulus = 1.0e3;
        scene.time_step = TimeStep::Absolute { seconds: 1.0e-4 };
        let mut bodies = Bodies::default();
        for (index, (x, z, vx, vz)) in places.iter().enumerate() {
            let radius = 0.004 + 0.002 * (index % 7) as f64 / 7.0;
            bodies.push([*x, *z], [*vx, *vz], radius, scene.grain_mass(radius));
        }
        // A case, as nobody asks whether its overlaps mean anything.
        let case = Case {
            name: "random grains".to_owned(),
            model: Model::of(&scene),
            punch: None,
            moments: vec![steps],
            bodies,
        };
        let largest = case.bodies.radius.iter().copied().fold(0.0, f64::max);
        let options = CaseOptions {
            skin_over_radius: skin / largest,
            ..CaseOptions::default()
        };
        let moments = native::run_case(&case, options).expect("a case that finishes");
        let last = &moments[0];
        let mut expected = Vec::new();
        for i in 0..last.bodies.len() {
            for j in i + 1..last.bodies.len() {
                let at = |i: usize| [last.bodies.x[i], last.bodies.z[i]];
                let (a, b) = (last.bodies.radius[i], last.bodies.radius[j]);
                if contact::grains(at(i), a, at(j), b).is_some() {
                    expected.push((i as u32, j as u32));
                }
            }
        }
        let found: Vec<(u32, u32)> = last
            .contacts
            .iter()
            .filter(|contact| contact.id1 < scene.particles.count)
            .map(|contact| (contact.id1, contact.id2))
            .collect();
        prop_assert_eq!(&found, &expected);
        prop_assert!(last.contacts.iter().all(|contact| contact.normal_force >= 0.0));
        let bed = Bed { bodies: &last.bodies, contacts: &last.contacts };
        let ends = 2 * found.len() + (last.contacts.len() - found.len());
        let mean = coordination::of(bed).mean;
        prop_assert!((mean - ends as f64 / places.len() as f64).abs() < 1e-12);
    }
}
