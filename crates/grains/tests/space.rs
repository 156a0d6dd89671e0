//! Spheres in space without another engine: the plane is y = 0 in it, and what a restitution promises is what a collision gives.

use grains::generate::initial_bodies;
use grains::measure::porosity;
use grains::model::{Model, Solid};
use grains::native::{self, Options};
use grains::rules::{SpringMemory, SpringTurn};
use grains::scene::{
    AdhesionLaw, Cloud, ContactLaw, Damping, Rolling, Scene, SlipVelocity, Springs, Tension,
    TorqueArms, Viscosity, paper_scene, parse_scene,
};
use grains::tables::{Bodies, Memories, Punch, Snapshot, Stage};
use grains::task::{Case, Start, Task, Until};
use grains::variant::{self, Variant};
use grains::vector::{cross, hypot};

fn run(scene: &Scene, bodies: Bodies, steps: u64) -> Snapshot {
    let task = Task::pour(bodies, steps);
    let outcome = native::run(scene, &task, &Options::default(), &mut ());
    outcome.expect("a run that finishes").last
}

#[test]
fn the_plane_has_the_same_bits_in_space() {
    let mut scene = paper_scene(1, 60);
    scene.container.width = 0.08;
    scene.material.friction_angle = 0.5;
    let Cloud::JitteredLattice { columns, spin, .. } = &mut scene.cloud;
    (*columns, *spin) = (5, 10.0);
    let planar = initial_bodies(&scene);
    let mut bodies = planar.clone();
    for column in [&mut bodies.y, &mut bodies.vy] {
        column.resize(planar.len(), 0.0);
    }
    for column in [&mut bodies.spin_x, &mut bodies.spin_z] {
        column.resize(planar.len(), 0.0);
    }
    let model = Model::of(&scene);
    let case = |bodies: Bodies| Case {
        name: "a plane".to_owned(),
        model: model.clone(),
        bodies,
        punch: None,
        moments: vec![9_000],
    };
    let end = |bodies: Bodies| native::run_case(&case(bodies), None).expect("a native run");
    let (plane, space) = (end(planar), end(bodies));
    let (plane, space) = (&plane[0], &space[0]);
    for ((name, a), (_, b)) in plane
        .bodies
        .motion()
        .iter()
        .zip(space.bodies.motion())
        .take(5)
    {
        assert_eq!(*a, b, "{name}");
    }
    assert!(space.bodies.y.iter().all(|y| *y == 0.0));
    assert!(plane.contacts.len() > 60 && plane.contacts.len() == space.contacts.len());
}

/// Rebound over approach speed of two unlike spheres, head on at 0.2 m/s.
fn rebound(viscosity: Viscosity) -> f64 {
    let mut scene = poured();
    (scene.contact.viscosity, scene.gravity) = (viscosity, 0.0);
    let mut bodies = Bodies::default();
    for (x, radius, speed) in [(0.0, 0.005, 0.1), (0.009001, 0.004, -0.1)] {
        bodies.push([x, 0.0], [speed, 0.0], radius, scene.grain_mass(radius));
        bodies.y.push(0.0);
        bodies.vy.push(0.0);
    }
    let mut model = Model::of(&scene);
    (model.dt, model.walls, model.gravity) = (1.0e-7, Vec::new(), [0.0; 2]);
    let case = Case {
        name: "two spheres".to_owned(),
        model,
        bodies,
        punch: None,
        moments: vec![20_000],
    };
    let end = variant::run(&case, &Variant::default());
    assert!(end[0].contacts.is_empty());
    (end[0].bodies.vx[1] - end[0].bodies.vx[0]) / 0.2
}

/// By the formula for forces that are cut at zero (Thornton 2013) and by the one for forces that are not.
#[test]
fn a_restitution_of_hertzian_springs_is_what_a_collision_gives() {
    for (tension, near) in [(Tension::Clipped, 3.0e-4), (Tension::Unclipped, 2.0e-5)] {
        for e_n in [0.4, 0.6, 0.8] {
            let found = rebound(Viscosity::Restitution { e_n, tension });
            assert!((found - e_n).abs() < near, "{tension:?} {e_n}: {found}");
        }
    }
}

fn poured() -> Scene {
    parse_scene(include_str!("../../../examples/poured-spheres.json")).expect("an example")
}

#[test]
fn spheres_settle_in_a_box_at_a_sensible_porosity() {
    let mut scene = poured();
    scene.particles.count = 300;
    (scene.container.width, scene.container.depth) = (0.07, Some(0.06));
    let Cloud::JitteredLattice { columns, .. } = &mut scene.cloud;
    *columns = 5;
    let bed = run(&scene, initial_bodies(&scene), 30_000);
    assert!(bed.bodies.y.iter().all(|y| *y > 0.0 && *y < 0.06));
    let layer = porosity::Layer::interior(&scene, &bed.bodies).expect("a layer");
    let porosity = porosity::in_layer(&bed.bodies, &layer);
    // Random loose and dense packings have 0.45 and 0.36; walls leave more room.
    assert!((0.38..0.56).contains(&porosity), "{porosity}");
    assert!(bed.contacts.len() > 600 && bed.contacts.len() == bed.across.len());
}

/// Spheres of three materials that fall into a box under a punch that comes down.
fn falling(name: &str, contact: ContactLaw) -> Case {
    let scene = poured();
    let mut model = Model::of(&scene);
    let solid = |modulus, ratio, friction_angle| Solid {
        modulus,
        stiffness_ratio: ratio,
        poissons_ratio: ratio,
        friction_angle,
    };
    model.law.materials = vec![solid(1.0e7, 0.25, 0.4), solid(3.0e7, 0.35, 0.6)];
    model.law.contact = contact;
    (model.alpha, model.gravity) = (0.3, [2.0, -9.81]);
    let mut bodies = Bodies::default();
    // Any disorder serves.
    let mut state = 1_u64;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    for at in 0..160 {
        let cell = [at % 5, at / 5 % 4, at / 20].map(|cell| (f64::from(cell) + 0.5) * 0.0125);
        let radius = 0.0045 + 0.0015 * next();
        let [x, y, z] = cell.map(|middle| middle + 0.0001 * next());
        bodies.push(
            [x, z],
            [next(), -1.0 + next()],
            radius,
            scene.grain_mass(radius),
        );
        bodies.y.push(y);
        bodies.vy.push(next());
        bodies
            .inertia
            .push(0.4 * scene.grain_mass(radius) * radius * radius);
        for column in [&mut bodies.spin, &mut bodies.spin_x, &mut bodies.spin_z] {
            column.push(20.0 * next());
        }
        bodies.material.push((at % 3) as u32);
    }
    for (wall, place) in model.walls.iter_mut().zip([0.0, 0.0625, 0.0, 0.0, 0.05]) {
        wall.place = place;
    }
    let punch = Punch {
        centre: [0.03, 0.08],
        half_extents: [0.02, 0.01],
        velocity: -0.3,
        start: 0.07,
        force: 0.0,
    };
    Case {
        name: name.to_owned(),
        model,
        bodies,
        punch: Some(punch),
        moments: vec![0, 1, 2, 50, 1000, 2500, 6000],
    }
}

/// Steps that are too long, or engines that write nonsense, lead there.
#[test]
fn places_that_are_no_numbers_or_far_away_touch_nothing() {
    let mut case = falling("no number", ContactLaw::default());
    case.moments = vec![0, 2];
    let whole = variant::run(&case, &Variant::default());
    let pairs = |run: &[Snapshot]| {
        let grains = case.bodies.len() as u32;
        let contacts = run[0].contacts.iter();
        contacts
            .filter(|one| one.id1 < grains && one.id1 != 7 && one.id2 != 7)
            .count()
    };
    for place in [f64::NAN, f64::INFINITY, -1.0e300] {
        let mut odd = case.clone();
        odd.bodies.x[7] = place;
        let run = variant::run(&odd, &Variant::default());
        assert_eq!(pairs(&run), pairs(&whole), "{place}");
    }
}

/// Every number at every moment, contacts and the force on the punch among them.
#[test]
fn lists_and_lanes_have_the_bits_of_the_step_written_out() {
    let tension = Tension::Clipped;
    let hertz = ContactLaw {
        springs: Springs::HertzMindlin,
        torque_arms: TorqueArms::ContactPoint,
        ..ContactLaw::default()
    };
    let with_restitution = ContactLaw {
        viscosity: Viscosity::Restitution { e_n: 0.6, tension },
        ..hertz.clone()
    };
    let rolling = Rolling {
        bending_stiffness: Some(0.5),
        twisting_stiffness: 0.3,
        limit: Some(0.1),
    };
    let laws = [
        ("linear", ContactLaw::default()),
        (
            "linear at the contact point with a dashpot",
            ContactLaw {
                slip_velocity: SlipVelocity::ContactPoint,
                torque_arms: TorqueArms::ContactPoint,
                viscosity: Viscosity::Dashpot { c_n: 0.5, tension },
                ..ContactLaw::default()
            },
        ),
        ("hertz", hertz.clone()),
        ("en", with_restitution.clone()),
        (
            "a dashpot that pulls",
            ContactLaw {
                viscosity: Viscosity::Ratio {
                    ratio: 0.2,
                    tension: Tension::Unclipped,
                },
                tangential_viscosity: Some(0.1),
                slip_velocity: SlipVelocity::ContactPoint,
                ..hertz.clone()
            },
        ),
        (
            "moments",
            ContactLaw {
                rolling: Some(rolling),
                ..with_restitution.clone()
            },
        ),
        (
            "a constant torque",
            ContactLaw {
                rolling: Some(Rolling {
                    bending_stiffness: None,
                    ..rolling
                }),
                ..with_restitution.clone()
            },
        ),
        (
            "adhesion",
            ContactLaw {
                adhesion: Some(1.0),
                ..hertz
            },
        ),
        (
            "adhesion and en",
            ContactLaw {
                adhesion: Some(1.0),
                ..with_restitution
            },
        ),
    ];
    for (name, law) in laws {
        let case = falling(name, law);
        let fast = native::run_case(&case, None).expect("a native run");
        let plain = variant::run(&case, &Variant::default());
        let (mut at_walls, mut at_punch) = (0, 0);
        for (fast, plain) in fast.iter().zip(&plain) {
            let when = format!("{name}, step {}", fast.step);
            assert_eq!(fast.bodies.digest(), plain.bodies.digest(), "{when}");
            assert_eq!(fast.contacts, plain.contacts, "{when}");
            assert_eq!(fast.across, plain.across, "{when}");
            assert_eq!(fast.memory, plain.memory, "{when}");
            assert_eq!(fast.punch, plain.punch, "{when}");
            at_walls += plain
                .contacts
                .iter()
                .filter(|contact| contact.id1 < 165 && contact.id1 >= 160)
                .count();
            at_punch += plain
                .contacts
                .iter()
                .filter(|contact| contact.id1 == 165)
                .count();
        }
        let last = plain.last().expect("moments").contacts.len();
        assert!(
            last > 120 && at_walls > 30 && at_punch > 5,
            "{name}: {last} {at_walls} {at_punch}"
        );
    }
}

/// With dashpots, moments and the punch, between two steps in which contacts stick and slide.
#[test]
fn a_run_goes_on_from_its_moments_with_the_same_bits() {
    goes_on_from_its_moments(poured());
}

/// The radius of the contact a step ago and contacts beyond their surfaces come back too.
#[test]
fn a_run_with_springs_that_shrink_and_adhesion_that_holds_goes_on_with_the_same_bits() {
    let mut scene = poured();
    scene.contact.adhesion = Some(0.5);
    scene.contact.adhesion_law = AdhesionLaw::Jkr;
    scene.rules.spring_memory = SpringMemory::DisplacementRescaled;
    goes_on_from_its_moments(scene);
}

fn goes_on_from_its_moments(mut scene: Scene) {
    scene.particles.count = 60;
    (scene.container.width, scene.container.depth) = (0.05, Some(0.04));
    let Cloud::JitteredLattice { columns, .. } = &mut scene.cloud;
    *columns = 4;
    scene.damping = Damping::Cundall { alpha: 0.3 };
    scene.contact.torque_arms = TorqueArms::ContactPoint;
    scene.contact.rolling = Some(Rolling {
        bending_stiffness: Some(0.5),
        twisting_stiffness: 0.3,
        limit: Some(0.1),
    });
    scene.settle.kinetic_energy_fraction = 0.01;
    scene.measurement.history_every = 37;
    scene.loading.speed = 0.5;
    scene.loading.half_width = 0.015;
    scene.loading.pressure = 1.0e9;
    scene.loading.give_up_depth = 0.005;
    let mut whole: Vec<Snapshot> = Vec::new();
    let task = Task::whole(initial_bodies(&scene));
    native::run(&scene, &task, &Options::default(), &mut whole).expect("a run that finishes");
    let punched = |moment: &Snapshot| moment.contacts.iter().any(|contact| contact.id1 == 65);
    let slides = |moment: &Snapshot| moment.memory.across.iter().any(|contact| contact.slides);
    let sticks = |moment: &Snapshot| moment.memory.across.iter().any(|contact| !contact.slides);
    let is_lively = |moment: &&Snapshot| slides(moment) && sticks(moment);
    let of_stage = |stage| whole.iter().filter(move |moment| moment.stage == stage);
    let pouring: Vec<_> = of_stage(Stage::Settle).filter(is_lively).collect();
    let loading = of_stage(Stage::Load).filter(is_lively);
    let loading: Vec<_> = loading.filter(|moment| punched(moment)).collect();
    assert!(pouring.len() > 5 && loading.len() > 5);
    let held = whole.iter().flat_map(|moment| &moment.contacts);
    let held = held.filter(|contact| contact.overlap < 0.0).count();
    assert_eq!(held > 0, scene.contact.adhesion.is_some());
    for from in [
        pouring[2],
        pouring[pouring.len() / 2],
        loading[1],
        loading[3],
    ] {
        let rest: Vec<&Snapshot> = of_stage(from.stage)
            .filter(|moment| moment.step >= from.step)
            .collect();
        let last = rest.last().expect("moments").step;
        let goes_on = |start: Start| {
            let mut again: Vec<Snapshot> = Vec::new();
            let until = Until::Step(last);
            let task = Task { start, until };
            let done = native::run(&scene, &task, &Options::default(), &mut again);
            done.expect("a run that finishes");
            again
        };
        let again = goes_on(from.clone().into());
        assert_eq!(again.len(), rest.len());
        for (again, whole) in again.iter().zip(rest) {
            let when = format!("{:?} {} {}", from.stage, from.step, whole.step);
            assert_eq!(again.digest(), whole.digest(), "{when}");
            assert_eq!(again.memory, whole.memory, "{when}");
        }
        let forgets = goes_on(Start {
            memory: Memories::default(),
            ..from.clone().into()
        });
        let [forgot, kept] = [&forgets, &again].map(|moments| moments[1].digest());
        assert_ne!(forgot, kept, "contacts remember nothing");
    }
}

/// A twisting moment is along the normal: rules that take the tangential spring onto the tangent take the moment onto the normal.
#[test]
fn twisting_moments_stay_along_the_normal_where_springs_are_projected() {
    for turn in [SpringTurn::KeepsLength, SpringTurn::Projected] {
        let mut case = falling(
            "twisting",
            ContactLaw {
                springs: Springs::HertzMindlin,
                torque_arms: TorqueArms::ContactPoint,
                rolling: Some(Rolling {
                    bending_stiffness: Some(0.1),
                    twisting_stiffness: 0.1,
                    limit: None,
                }),
                ..ContactLaw::default()
            },
        );
        case.model.rules.spring_turn = turn;
        case.moments = vec![2500];
        let memory = &variant::run(&case, &Variant::default())[0].memory;
        let mut twisted = 0;
        for (planar, across) in memory.planar.iter().zip(&memory.across) {
            let normal = [planar.normal[0], across.normal, planar.normal[1]];
            let size = hypot(across.twisting);
            twisted += usize::from(size > 0.0);
            let aside = hypot(cross(normal, across.twisting));
            assert!(aside <= 1.0e-12 * size, "{turn:?}: {aside} of {size}");
        }
        assert!(twisted > 20, "{twisted}");
    }
}
