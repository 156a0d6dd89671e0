//! The native engine: the fast kernel against the scalar law, exact solutions, rules and troubles.

use crossgrain::engine::native::contact::{self, Axis};
use crossgrain::engine::native::{self, NativeError, Trouble};
use crossgrain::engine::{Start, Task, Until};
use crossgrain::generate::initial_bodies;
use crossgrain::measure::{Bed, coordination, energy};
use crossgrain::scene::{Damping, Scene, TimeStep};
use crossgrain::tables::{Bodies, Punch, Stage, StopReason};
use proptest::prelude::*;

use crate::support::{native_outcome, small_scene, sound};

/// The law written out without lists, lanes or registers: every pair is looked at in the order of
/// ids, walls after grains, the punch last. Slow and obvious; the engine must have its bits.
struct Reference {
    scene: Scene,
    bodies: Bodies,
    punch: Option<Punch>,
    force: Vec<[f64; 2]>,
}

impl Reference {
    fn new(scene: &Scene, bodies: Bodies, punch: Option<Punch>) -> Self {
        let mut reference = Reference {
            scene: scene.clone(),
            force: vec![[0.0; 2]; bodies.len()],
            bodies,
            punch,
        };
        reference.forces();
        reference
    }

    fn forces(&mut self) {
        let Reference {
            scene,
            bodies,
            punch,
            force,
        } = self;
        let count = bodies.len();
        let modulus = scene.material.youngs_modulus;
        let place = |i: usize| [bodies.x[i], bodies.z[i]];
        let of_flat = |radius: f64| contact::normal_stiffness(modulus, radius, radius);
        force.fill([0.0; 2]);
        for i in 0..count {
            for j in i + 1..count {
                let (a, b) = (bodies.radius[i], bodies.radius[j]);
                let stiffness = contact::normal_stiffness(modulus, a, b);
                if let Some(pair) = contact::grains(place(i), a, place(j), b, stiffness) {
                    add(&mut force[i], -1.0, pair.force);
                    add(&mut force[j], 1.0, pair.force);
                }
            }
        }
        let walls = [
            (Axis::X, 0.0),
            (Axis::X, scene.container.width),
            (Axis::Z, 0.0),
        ];
        for (axis, wall) in walls {
            for (i, force) in force.iter_mut().enumerate() {
                let radius = bodies.radius[i];
                let pair = contact::wall(axis, wall, place(i), radius, of_flat(radius));
                if let Some(pair) = pair {
                    add(force, 1.0, pair.force);
                }
            }
        }
        if let Some(Punch {
            centre,
            half_extents,
            ..
        }) = *punch
        {
            for (i, force) in force.iter_mut().enumerate() {
                let radius = bodies.radius[i];
                let stiffness = of_flat(radius);
                let pair = contact::punch(centre, half_extents, place(i), radius, stiffness);
                if let Some(pair) = pair {
                    add(force, 1.0, pair.force);
                }
            }
        }
    }

    fn step(&mut self) {
        let dt = self.scene.time_step_seconds();
        let alpha = self.scene.damping.alpha();
        let gravity = [0.0, -self.scene.gravity];
        if let Some(punch) = &mut self.punch {
            punch.centre[1] += punch.velocity * dt;
        }
        for i in 0..self.bodies.len() {
            let Bodies {
                x, z, vx, vz, mass, ..
            } = &mut self.bodies;
            let mass = mass[i];
            let columns = [(&mut x[i], &mut vx[i]), (&mut z[i], &mut vz[i])];
            for (axis, (place, velocity)) in columns.into_iter().enumerate() {
                let mut acceleration = self.force[i][axis] / mass + gravity[axis];
                let power = acceleration * (*velocity + 0.5 * dt * acceleration);
                if power > 0.0 {
                    acceleration *= 1.0 - alpha;
                } else if power < 0.0 {
                    acceleration *= 1.0 + alpha;
                }
                *velocity += dt * acceleration;
                *place += dt * *velocity;
            }
        }
        self.forces();
    }
}

/// Changing the sign first or last gives the same bits.
fn add(sum: &mut [f64; 2], sign: f64, force: [f64; 2]) {
    sum[0] += sign * force[0];
    sum[1] += sign * force[1];
}

#[test]
fn the_kernel_has_the_bits_of_the_scalar_law_while_pouring() {
    let mut scene = small_scene();
    scene.particles.count = 120;
    let initial = initial_bodies(&scene);
    let mut reference = Reference::new(&scene, initial.clone(), None);
    for steps in (1000..=8000).step_by(1000) {
        for _ in 0..1000 {
            reference.step();
        }
        let task = Task::pour(initial.clone(), steps);
        let (outcome, _) = native_outcome(&scene, &task, None);
        assert_eq!(
            outcome.last.bodies.digest(),
            reference.bodies.digest(),
            "after {steps} steps"
        );
        if steps == 8000 {
            assert!(outcome.last.contacts.len() > 100, "the bed has formed");
        }
    }
}

#[test]
fn the_kernel_has_the_bits_of_the_scalar_law_under_the_punch() {
    let mut scene = small_scene();
    scene.particles.count = 120;
    let (settled, _) = native_outcome(&scene, &Task::pour(initial_bodies(&scene), 20_000), None);
    let mut punch = native::first_contact_punch(&scene, &settled.last.bodies);
    punch.velocity = -0.4;
    scene.loading.speed = 0.4;
    let steps = 1500;
    let mut reference = Reference::new(&scene, settled.last.bodies.clone(), Some(punch));
    for _ in 0..steps {
        reference.step();
    }
    let task = Task {
        start: Start {
            stage: Stage::Load,
            step: 0,
            bodies: settled.last.bodies,
            punch: Some(punch),
        },
        until: Until::Step(steps),
    };
    let (outcome, _) = native_outcome(&scene, &task, None);
    assert_eq!(outcome.last.bodies.digest(), reference.bodies.digest());
    let after = outcome.last.punch.expect("the punch");
    assert_eq!(after.centre, reference.punch.expect("the punch").centre);
    let on_punch = |id| outcome.last.contacts.iter().filter(|c| c.id1 == id).count();
    assert!(on_punch(scene.particles.count + 3) > 0, "it touches grains");
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
    // Two grains at the same place have no normal.
    let error = trouble(&scene, two(0.1, 0.0));
    assert!(
        matches!(error.trouble, Trouble::NotFinite { .. }),
        "{error}"
    );
    // A start that is not a number.
    let error = trouble(&scene, two(f64::NAN, 0.0));
    assert_eq!(error.trouble, Trouble::NotFinite { grain: 1 });
    assert_eq!(error.step, 0);
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

#[test]
fn a_grain_inside_the_punch_is_noticed() {
    let mut scene = small_scene();
    scene.particles.count = 1;
    let mut bodies = Bodies::default();
    bodies.push([0.15, 0.05], [0.0, 0.0], 0.005, 0.2);
    let punch = Punch {
        centre: [0.15, 0.15],
        half_extents: [0.0225, 0.15],
        start: 0.0,
        velocity: -0.1,
        force: 0.0,
    };
    let task = Task {
        start: Start {
            stage: Stage::Load,
            step: 0,
            bodies,
            punch: Some(punch),
        },
        until: Until::Step(10),
    };
    let error = native::run(&scene, &task, &sound(), &mut ()).expect_err("inside");
    assert_eq!(error.trouble, Trouble::InsidePunch { grain: 0 });
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
        let (outcome, _) = native_outcome(&scene, &Task::pour(bodies, steps), Some(skin));
        let last = &outcome.last;
        let mut expected = Vec::new();
        for i in 0..last.bodies.len() {
            for j in i + 1..last.bodies.len() {
                let at = |i: usize| [last.bodies.x[i], last.bodies.z[i]];
                let (a, b) = (last.bodies.radius[i], last.bodies.radius[j]);
                if contact::grains(at(i), a, at(j), b, 1.0).is_some() {
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
