//! Beds of the paper's grains, brought to rest, as scenes of the map.

use super::scenes::MapScene;
use crate::engine::Task;
use crate::engine::case::Case;
use crate::engine::native::{self, NativeError, Options, run_case};
use crate::generate::initial_bodies;
use crate::model::{Axis, Law, Model};
use crate::scene::{Cloud, Scene, paper_scene};
use crate::tables::{Bodies, Punch};
use crate::verify::build::{self, Grain};

/// Cundall's α while a bed is brought to rest.
const BRAKE: f64 = 0.7;
/// Steps of bringing to rest.
const RESTING_STEPS: u64 = 40_000;
/// Overlap over radius of the crystal as it is laid out.
const CRYSTAL_OVERLAP: f64 = 1.0e-3;
/// tan φ is that of this angle, rad, and k_s = k_n.
const FRICTION_ANGLE: f64 = 0.5;

/// The paper's scene with so many grains; a few stand in a narrower box, so that the bed is about as deep as
/// it is wide.
pub fn bed_scene(grains: u32) -> Scene {
    let mut scene = paper_scene(1, grains);
    if grains < 5000 {
        scene.container.width = 0.25;
        let Cloud::JitteredLattice { columns, .. } = &mut scene.cloud;
        *columns = 20;
    }
    scene
}

/// The beds: poured, settled, brought to rest without friction; in one of them friction is then switched on, and one stands
/// under the punch.
pub fn beds(grains: u32) -> Result<Vec<MapScene>, NativeError> {
    let scene = bed_scene(grains);
    let smooth = poured(&scene)?;
    let model = still_model(&scene);
    let dense = at_rest("a dense bed", &model, &smooth, None)?;
    let mut rough_scene = scene.clone();
    rough_scene.material.friction_angle = FRICTION_ANGLE;
    let rough = poured(&rough_scene)?;
    let frictional = frictional("a frictional bed", &scene, &rough_scene, &rough)?;
    let pressed = pressed(&scene, &dense.bodies)?;
    let of = |name: &str, title: String, case: Case, remark: &str| MapScene {
        name: name.to_owned(),
        title,
        case,
        axes: [true; 2],
        closed: None,
        remark: remark.to_owned(),
    };
    Ok(vec![
        of(
            "dense-bed",
            format!("the paper's bed of {grains} grains, settled"),
            dense,
            "",
        ),
        of(
            "frictional-bed",
            format!("{grains} grains poured with friction 0.5, every contact sticking, k_s = k_n"),
            frictional,
            "a case cannot be given the shear forces of a bed, so the bed rests without friction before it is switched \
             on again: as many contacts as without friction, all sticking, which is the harder case",
        ),
        of(
            "bed-under-punch",
            format!("the dense bed of {grains} grains under the punch, pressed and held"),
            pressed,
            "",
        ),
    ])
}

/// A crystal between four walls: rows one over the other, every other one moved by half a grain.
pub fn crystal(rows: usize) -> Result<MapScene, NativeError> {
    let (radius, density, modulus) = (0.005, 2600.0, 1.0e7);
    let pitch = 2.0 * radius * (1.0 - CRYSTAL_OVERLAP);
    let height = 0.75f64.sqrt() * pitch;
    let inset = radius * (1.0 - CRYSTAL_OVERLAP);
    let mut grains = Vec::new();
    for row in 0..rows {
        for column in 0..rows {
            let x = inset + pitch * (column as f64 + 0.5 * (row % 2) as f64);
            grains.push(Grain::disc([x, inset + height * row as f64], radius, density));
        }
    }
    let width = 2.0 * inset + pitch * (rows as f64 - 0.5);
    let top = 2.0 * inset + height * (rows as f64 - 1.0);
    let model = Model {
        walls: vec![
            build::wall(Axis::X, 0.0),
            build::wall(Axis::X, width),
            build::wall(Axis::Z, 0.0),
            build::wall(Axis::Z, top),
        ],
        ..build::model(build::springs(modulus), 0.3 * (grains[0].mass / (modulus * radius)).sqrt())
    };
    let laid = build::case("a crystal", model.clone(), &grains, vec![0]);
    let case = at_rest("a crystal", &model, &laid.bodies, None)?;
    Ok(MapScene {
        name: "hexagonal-crystal".to_owned(),
        title: format!("{rows} by {rows} equal grains in a hexagonal crystal between four walls"),
        case,
        axes: [true; 2],
        closed: Some(super::scenes::ClosedForm {
            dt: 2.0 / (6.0 * modulus * radius / grains[0].mass).sqrt(),
            formula: "2√(m/6k), of the endless crystal".to_owned(),
            tolerance: 0.01,
        }),
        remark: "walls hold a crystal less than more crystal would, so its limit is a little above".to_owned(),
    })
}

/// The scene's bed when it has settled.
fn poured(scene: &Scene) -> Result<Bodies, NativeError> {
    let task = Task::settle(initial_bodies(scene));
    let outcome = native::run(scene, &task, &Options::default(), &mut ())?;
    Ok(outcome.last.bodies)
}

/// The model of a scene without friction.
fn still_model(scene: &Scene) -> Model {
    let model = Model::of(scene);
    Model {
        law: Law {
            friction_angle: 0.0,
            ..model.law.clone()
        },
        ..model
    }
}

/// Brought to rest by strong damping, velocities then set to zero.
fn at_rest(
    name: &str,
    model: &Model,
    bodies: &Bodies,
    punch: Option<Punch>,
) -> Result<Case, NativeError> {
    let resting = Case {
        name: name.to_owned(),
        model: Model {
            alpha: BRAKE,
            ..model.clone()
        },
        bodies: bodies.clone(),
        punch,
        moments: vec![RESTING_STEPS],
    };
    let track = run_case(&resting, None)?;
    let mut bodies = track
        .into_iter()
        .next_back()
        .map_or(bodies.clone(), |moment| moment.bodies);
    bodies.vx.fill(0.0);
    bodies.vz.fill(0.0);
    Ok(Case {
        model: model.clone(),
        bodies,
        moments: vec![0],
        ..resting
    })
}

fn frictional(
    name: &str,
    scene: &Scene,
    rough_scene: &Scene,
    rough: &Bodies,
) -> Result<Case, NativeError> {
    let smooth = Bodies {
        spin: Vec::new(),
        inertia: Vec::new(),
        ..rough.clone()
    };
    let mut case = at_rest(name, &still_model(scene), &smooth, None)?;
    case.model = Model::of(rough_scene);
    case.bodies.spin = vec![0.0; case.bodies.len()];
    case.bodies.inertia = rough.inertia.clone();
    Ok(case)
}

/// The punch goes down on the bed by a share of the grains' overlaps at its load, and is held there.
fn pressed(scene: &Scene, bodies: &Bodies) -> Result<Case, NativeError> {
    let model = still_model(scene);
    let mut punch = native::first_contact_punch(scene, bodies);
    let steps = (scene.loading.give_up_depth / (scene.loading.speed * model.dt)) as u64;
    let every = 100;
    let pressing = Case {
        name: "pressing".to_owned(),
        model: model.clone(),
        bodies: bodies.clone(),
        punch: Some(punch),
        moments: (0..=steps).step_by(every).collect(),
    };
    let mut pressed = bodies.clone();
    let target = scene.target_force();
    native::watch_case(&pressing, &native::CaseOptions::default(), &mut |moment| {
        let reached = moment.punch.is_some_and(|punch| punch.force >= target);
        pressed = moment.bodies;
        punch = moment.punch.unwrap_or(punch);
        !reached
    })?;
    punch.velocity = 0.0;
    at_rest("a bed under the punch", &model, &pressed, Some(punch))
}
