//! Spheres in space without another engine: the plane is y = 0 in it, and what a restitution promises is what a collision gives.

use grains::generate::initial_bodies;
use grains::measure::porosity;
use grains::model::Model;
use grains::native::{self, Options};
use grains::scene::{Cloud, Scene, Tension, Viscosity, paper_scene, parse_scene};
use grains::tables::{Bodies, Snapshot};
use grains::task::{Case, Task};
use grains::variant::{self, Variant};

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
    let porosity = porosity::in_layer(&scene, &bed.bodies).expect("a layer");
    // Random loose and dense packings have 0.45 and 0.36; walls leave more room.
    assert!((0.38..0.56).contains(&porosity), "{porosity}");
    assert!(bed.contacts.len() > 600 && bed.contacts.len() == bed.across.len());
}
