//! Spheres in space against the real YADE, to the bit. Without the feature `yade` these tests are listed as ignored.

use std::ops::Range;

use chacha20::ChaCha8Rng;
use crossgrain::compare::compare;
use crossgrain::engine::yade;
use grains::generate::symmetric;
use grains::model::{Axis, Law, Model, Solid, Wall};
use grains::native;
use grains::obstacle::{Obstacle, Surface};
use grains::rules::Rules;
use grains::scene::{ContactLaw, Rolling, SlipVelocity, Springs, Tension, TorqueArms, Viscosity};
use grains::task::Case;
use grains::variant::{self, Variant};
use rand_core::SeedableRng;

use crate::support::*;

/// Inner width of the box, m.
const WIDTH: f64 = 0.11;

fn linear() -> Law {
    Law {
        modulus: 2.0e7,
        stiffness_ratio: 0.3,
        friction_angle: 0.5,
        wall_friction_angle: None,
        punch_friction_angle: None,
        poissons_ratio: Some(0.3),
        materials: [(1.0e7, 0.25, 0.4), (3.0e7, 0.35, 0.6)]
            .map(|(modulus, ratio, friction_angle)| Solid {
                modulus,
                stiffness_ratio: ratio,
                poissons_ratio: ratio,
                friction_angle,
            })
            .to_vec(),
        contact: ContactLaw::default(),
    }
}

fn hertzian(change: impl Fn(&mut ContactLaw)) -> Law {
    let mut law = linear();
    law.contact.springs = Springs::HertzMindlin;
    law.contact.torque_arms = TorqueArms::ContactPoint;
    change(&mut law.contact);
    law
}

fn restitution(e_n: f64) -> Viscosity {
    let tension = Tension::Clipped;
    Viscosity::Restitution { e_n, tension }
}

/// Spheres of three materials with velocities and spins at random that fall into a box of six walls.
fn poured(name: &str, law: Law, count: usize, moments: &[u64]) -> Case {
    let mut random = ChaCha8Rng::from_seed(*b"crossgrain: spheres in a box ...");
    let mut next = || symmetric(&mut random);
    let mut bodies = Bodies::default();
    let pitch = WIDTH / 9.0;
    for at in 0..count {
        let cell = [at % 9, at / 9 % 9, at / 81].map(|cell| (cell as f64 + 0.5) * pitch);
        let radius = 0.0045 + 0.0015 * next();
        let [x, y, z] = cell.map(|middle| middle + 0.0001 * next());
        let mass = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3) * 2600.0;
        bodies.push([x, z], [next(), -1.0 + next()], radius, mass);
        bodies.y.push(y);
        bodies.vy.push(next());
        bodies.inertia.push(0.4 * mass * radius * radius);
        for column in [&mut bodies.spin, &mut bodies.spin_x, &mut bodies.spin_z] {
            column.push(10.0 * next());
        }
        bodies.material.push((at % 3) as u32);
    }
    let wall = |axis, place| Wall { axis, place };
    let model = Model {
        gravity: [2.0, -9.81],
        alpha: 0.3,
        dt: 2.0e-5,
        walls: vec![
            wall(Axis::X, 0.0),
            wall(Axis::X, WIDTH),
            wall(Axis::Z, 0.0),
            wall(Axis::Z, 0.3),
            wall(Axis::Y, 0.0),
            wall(Axis::Y, WIDTH),
        ],
        obstacles: Vec::new(),
        law,
        rules: Rules::default(),
    };
    Case {
        name: name.to_owned(),
        model,
        bodies,
        punch: None,
        moments: moments.to_vec(),
    }
}

/// Every position, velocity, spin and contact of these cases in YADE and in the written-out step; how many numbers and contacts.
fn same_bits(cases: &[Case]) -> (usize, usize) {
    let work = new_folder();
    let all: Vec<&Case> = cases.iter().collect();
    let (in_yade, _) = yade::run_cases(&all, &yade::Options::default(), &work, &mut ())
        .expect("cases that YADE runs");
    let (mut numbers, mut contacts) = (0, 0);
    for (case, theirs) in cases.iter().zip(in_yade) {
        let ours = variant::run(case, &Variant::default());
        for (ours, theirs) in ours.iter().zip(&theirs.track) {
            let mut differ = Vec::new();
            for ((name, a), (_, b)) in ours.bodies.motion().iter().zip(theirs.bodies.motion()) {
                assert_eq!(a.len(), case.bodies.len());
                numbers += a.len();
                let pairs = a.iter().zip(b).enumerate();
                let other = pairs.filter(|(_, (a, b))| a.to_bits() != b.to_bits());
                differ.extend(other.map(|(id, (a, b))| format!("{name} of {id}: {a:e} {b:e}")));
            }
            let (found, step) = (differ.len(), ours.step);
            assert_eq!(
                found,
                0,
                "{} step {step}: {:?}",
                case.name,
                &differ[..found.min(3)]
            );
        }
        let last = ours.last().expect("moments");
        println!("{}: {} contacts at the end", case.name, last.contacts.len());
        contacts += last.contacts.len();
    }
    (numbers, contacts)
}

const MOMENTS: [u64; 8] = [0, 1, 10, 100, 1000, 3000, 6000, 12_000];

#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn poured_spheres_have_the_bits_of_yade() {
    let cases = [
        poured("linear", linear(), 810, &MOMENTS),
        poured(
            "hertz with en",
            hertzian(|law| law.viscosity = restitution(0.6)),
            810,
            &MOMENTS,
        ),
    ];
    let (numbers, contacts) = same_bits(&cases);
    assert_eq!(numbers, 2 * 8 * 810 * 9);
    assert!(contacts > 2000, "{contacts}");
}

fn rolling() -> Rolling {
    Rolling {
        bending_stiffness: Some(0.5),
        twisting_stiffness: 0.3,
        limit: Some(0.1),
    }
}

/// Each term of the laws, in fewer spheres.
#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn each_term_in_space_has_the_bits_of_yade() {
    let elastic = Rolling {
        limit: None,
        ..rolling()
    };
    let tension = Tension::Clipped;
    let mut unlike = linear();
    unlike.contact.slip_velocity = SlipVelocity::ContactPoint;
    unlike.contact.torque_arms = TorqueArms::ContactPoint;
    let laws = [
        ("linear at the contact point", unlike),
        ("hertz", hertzian(|_| ())),
        (
            "en and es",
            hertzian(|law| {
                law.viscosity = restitution(0.7);
                law.tangential_viscosity = Some(0.4);
            }),
        ),
        (
            "betan and betas",
            hertzian(|law| {
                law.viscosity = Viscosity::Ratio {
                    ratio: 0.2,
                    tension,
                };
                law.tangential_viscosity = Some(0.1);
            }),
        ),
        (
            "uncorrected slip",
            hertzian(|law| {
                law.viscosity = restitution(0.6);
                law.slip_velocity = SlipVelocity::ContactPoint;
            }),
        ),
        (
            "elastic moments",
            hertzian(|law| law.rolling = Some(elastic)),
        ),
        (
            "limited moments",
            hertzian(|law| {
                law.viscosity = restitution(0.6);
                law.rolling = Some(rolling());
            }),
        ),
        ("adhesion", hertzian(|law| law.adhesion = Some(1.0))),
        (
            "adhesion with en",
            hertzian(|law| {
                law.adhesion = Some(1.0);
                law.viscosity = restitution(0.6);
            }),
        ),
    ];
    let cases = laws.map(|(name, law)| poured(name, law, 243, &MOMENTS));
    let (numbers, contacts) = same_bits(&cases);
    assert_eq!(numbers, 9 * 8 * 243 * 9);
    assert!(contacts > 9 * 243, "{contacts}");
}

/// The same poured from this much higher onto these bodies.
fn onto(obstacles: &[Obstacle], height: f64, case: Case) -> Case {
    let mut case = case;
    case.bodies.z.iter_mut().for_each(|z| *z += height);
    case.model.obstacles = obstacles.to_vec();
    case
}

/// A floor of triangles smaller than the spheres, up and down at random by this much; each moves and turns by itself where it does.
fn bumpy(cells: usize, height: f64, velocity: f64, spin: f64) -> Vec<Obstacle> {
    let mut random = ChaCha8Rng::from_seed(*b"crossgrain: a floor of triangles");
    let mut next = || symmetric(&mut random);
    let heights: Vec<f64> = (0..(cells + 1) * (cells + 1))
        .map(|_| 0.01 + height * next())
        .collect();
    let vertex = |column: usize, row: usize| {
        let [x, y] = [column, row].map(|at| at as f64 * (WIDTH / cells as f64));
        [x, y, heights[row * (cells + 1) + column]]
    };
    let mut all = Vec::new();
    for at in 0..cells * cells {
        let (column, row) = (at % cells, at / cells);
        let [a, b, c, d] = [(0, 0), (1, 0), (0, 1), (1, 1)]
            .map(|(right, back)| vertex(column + right, row + back));
        for vertices in [[a, b, c], [d, b, c]] {
            all.push(Obstacle {
                shape: Surface::Triangle { vertices },
                velocity: [next(), next(), next()].map(|part| velocity * part),
                spin: [next(), next(), next()].map(|part| spin * part),
            });
        }
    }
    all
}

/// Boxes of this motion and turned by these quaternions.
fn boxes(still: bool) -> Vec<Obstacle> {
    let turned = [0.9, 0.3, -0.2, 0.1];
    let length = turned.iter().map(|part: &f64| part * part).sum::<f64>();
    let turned = turned.map(|part| part / length.sqrt());
    let motion = |velocity, spin| match still {
        true => ([0.0; 3], [0.0; 3]),
        false => (velocity, spin),
    };
    [
        (
            [0.03, 0.03, 0.01],
            [0.02, 0.015, 0.01],
            [1.0, 0.0, 0.0, 0.0],
            motion([0.0; 3], [0.0; 3]),
        ),
        (
            [0.07, 0.06, 0.02],
            [0.025, 0.01, 0.012],
            turned,
            motion([0.05, -0.02, 0.1], [1.0, 3.0, 5.0]),
        ),
    ]
    .map(
        |(centre, half_extents, orientation, (velocity, spin))| Obstacle {
            shape: Surface::Box {
                centre,
                half_extents,
                orientation,
            },
            velocity,
            spin,
        },
    )
    .to_vec()
}

/// Triangles and boxes, at rest and in motion, under both laws.
#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn obstacles_have_the_bits_of_yade() {
    let moments = [0, 1, 10, 100, 1000, 3000, 6000];
    let laws = [
        ("linear", linear()),
        ("hertz", hertzian(|law| law.viscosity = restitution(0.6))),
        (
            "moments",
            hertzian(|law| {
                law.viscosity = restitution(0.6);
                law.rolling = Some(rolling());
            }),
        ),
    ];
    let floors = [
        ("facets", bumpy(16, 0.003, 0.0, 0.0)),
        ("moving facets", bumpy(12, 0.003, 0.02, 3.0)),
        ("boxes", boxes(true)),
        ("moving boxes", boxes(false)),
    ];
    let mut cases = Vec::new();
    for (name, law) in &laws {
        // Moments ask for no more of bodies than that they have a radius.
        let floors = floors.iter().take(if *name == "moments" { 1 } else { 4 });
        for (floor, obstacles) in floors {
            let case = poured(&format!("{floor}, {name}"), law.clone(), 243, &moments);
            cases.push(onto(obstacles, 0.03, case));
        }
    }
    let (numbers, contacts) = same_bits(&cases);
    assert_eq!(numbers, 9 * 7 * 243 * 9);
    assert!(contacts > 1500, "{contacts}");
    let mut at_obstacles = 0;
    for case in &cases {
        // The step with lists has those of the one that is written out.
        let quick = native::run_case(case, None).expect("a case");
        let plain = variant::run(case, &Variant::default());
        assert_eq!(quick, plain, "{}", case.name);
        let last = &plain.last().expect("moments").contacts;
        let first = case.bodies.len() + case.model.walls.len();
        at_obstacles += last
            .iter()
            .filter(|contact| contact.id1 as usize >= first)
            .count();
    }
    assert!(at_obstacles > 300, "{at_obstacles}");
}

/// The scene of the examples with moments, poured by both engines onto triangles and boxes and pressed, and compared as any two runs are.
#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn a_scene_of_800_spheres_has_the_bits_of_yade_under_the_punch_too() {
    let mut scene = json_scene("examples/poured-spheres.json");
    scene.contact.rolling = Some(rolling());
    scene.obstacles = bumpy(8, 0.003, 0.0, 0.0);
    scene.obstacles.extend(boxes(true));
    scene.measurement.history_every = 500;
    // At the second look the bed has less energy than at the first, so pouring ends there.
    scene.settle.check_every = 6_000;
    scene.settle.max_steps = 12_000;
    scene.settle.kinetic_energy_fraction = 0.99;
    scene.loading.speed = 0.2;
    scene.loading.pressure = 1.0e9;
    scene.loading.give_up_depth = 1999.5 * 0.2 * scene.time_step_seconds();
    let native = native_run(&scene, sound(), Protocol::Whole);
    let yade = run_of(&scene, &yade::Options::default(), Protocol::Whole);
    let comparison = compare(&native, &yade, None);
    assert!(comparison.same_bits, "{}", comparison.answer());
    assert_eq!(native.record.stages.len(), 2);
    assert_eq!(native.last.across, yade.last.across);
    let count = scene.particles.count;
    assert_eq!(count, 800);
    let obstacles = count + 5..count + 5 + scene.obstacles.len() as u32;
    let meets = |ids: Range<u32>| {
        native
            .last
            .contacts
            .iter()
            .any(|contact| ids.contains(&contact.id1))
    };
    assert!(meets(obstacles.clone()), "triangles and boxes");
    assert!(meets(obstacles.end..obstacles.end + 1), "the punch");
}

/// A column of spheres that collapses.
#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn a_column_of_spheres_has_the_bits_of_yade() {
    let mut scene = json_scene("examples/column-of-spheres.json");
    scene.particles.count = 300;
    scene.measurement.history_every = 500;
    scene.settle.max_steps = 8_000;
    let native = native_run(&scene, sound(), Protocol::Whole);
    let yade = run_of(&scene, &yade::Options::default(), Protocol::Whole);
    let comparison = compare(&native, &yade, None);
    assert!(comparison.same_bits, "{}", comparison.answer());
    let farthest = native
        .last
        .bodies
        .x
        .iter()
        .fold(0.0, |far: f64, x| far.max(*x));
    assert!(farthest > 0.11, "{farthest}");
}

fn json_scene(path: &str) -> Scene {
    parse_scene(&text_of(root(path))).expect("an example")
}
