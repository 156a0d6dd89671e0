//! Beds of the paper's grains, brought to rest, as scenes of the map.

use super::scenes::MapScene;
use crate::interrupt::asked_to_end;
use crate::suite::build::{self, Grain};
use grains::case::Case;
use grains::generate::initial_bodies;
use grains::model::{Axis, Law, Model};
use grains::native::{self, NativeError, Options, Trouble};
use grains::scene::{Cloud, Scene, paper_scene};
use grains::tables::{Bodies, Punch, Snapshot, Stage};
use grains::task::Task;

/// Cundall's α while a bed is brought to rest. Stronger damping takes longer: the bed creeps.
const BRAKE: f64 = 0.2;
/// A bed rests when the mean unbalanced force of its grains is this share of the mean contact force.
const AT_REST: f64 = 1.0e-9;
/// Looked at every so many steps; after so many it is given up.
const LOOK_EVERY: usize = 10_000;
const MOST_RESTING_STEPS: u64 = 3_000_000;
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
    let rough_model = Model::of(&rough_scene);
    let frictional = rested("a frictional bed", &rough_model, &rough, None)?.ok_or_else(unrest)?;
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
            "bed-under-punch",
            format!("the dense bed of {grains} grains under the punch, pressed and held"),
            pressed,
            "",
        ),
        of(
            "frictional-bed",
            format!("{grains} grains poured with friction 0.5, every contact sticking, k_s = k_n"),
            frictional,
            "a case cannot be given the shear forces of a bed, so the bed rests without friction before it is switched \
             on again: as many contacts as without friction, all sticking, which is the harder case",
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
            grains.push(Grain::disc(
                [x, inset + height * row as f64],
                radius,
                density,
            ));
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
        ..build::model(
            build::springs(modulus),
            0.3 * (grains[0].mass / (modulus * radius)).sqrt(),
        )
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
        remark: "walls hold a crystal less than more crystal would, so its limit is a little above"
            .to_owned(),
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

/// Brought to rest, velocities then set to zero.
fn at_rest(
    name: &str,
    model: &Model,
    bodies: &Bodies,
    punch: Option<Punch>,
) -> Result<Case, NativeError> {
    let (case, rests) = braked(name, model, bodies, punch)?;
    if rests { Ok(case) } else { Err(unrest()) }
}

/// Why there is no bed at rest.
fn unrest() -> NativeError {
    let trouble = if asked_to_end() {
        Trouble::Interrupted
    } else {
        Trouble::DoesNotRest {
            steps: MOST_RESTING_STEPS,
        }
    };
    NativeError {
        stage: Stage::Settle,
        step: MOST_RESTING_STEPS,
        trouble,
    }
}

/// A bed brought to rest without friction, and then with the model's friction switched on, which no contact has
/// to bear yet; none if it does not come to rest.
pub fn rested(
    name: &str,
    model: &Model,
    bodies: &Bodies,
    punch: Option<Punch>,
) -> Result<Option<Case>, NativeError> {
    let smooth = Model {
        law: Law {
            friction_angle: 0.0,
            ..model.law.clone()
        },
        ..model.clone()
    };
    let unturned = Bodies {
        spin: Vec::new(),
        inertia: Vec::new(),
        ..bodies.clone()
    };
    let (mut case, rests) = braked(name, &smooth, &unturned, punch)?;
    case.model = model.clone();
    case.bodies.spin = vec![0.0; bodies.spin.len()];
    case.bodies.inertia.clone_from(&bodies.inertia);
    Ok(rests.then_some(case))
}

/// The case after braking, and whether it rests.
fn braked(
    name: &str,
    model: &Model,
    bodies: &Bodies,
    punch: Option<Punch>,
) -> Result<(Case, bool), NativeError> {
    let resting = Case {
        name: name.to_owned(),
        model: Model {
            alpha: BRAKE,
            ..model.clone()
        },
        bodies: bodies.clone(),
        punch,
        moments: (0..=MOST_RESTING_STEPS).step_by(LOOK_EVERY).collect(),
    };
    let mut bodies = bodies.clone();
    let mut rests = false;
    native::watch_case(&resting, &native::CaseOptions::default(), &mut |moment| {
        rests = moment.step > 0 && unbalanced(model, &moment) <= AT_REST;
        bodies = moment.bodies;
        !rests && !asked_to_end()
    })?;
    bodies.vx.fill(0.0);
    bodies.vz.fill(0.0);
    let case = Case {
        model: model.clone(),
        bodies,
        moments: vec![0],
        ..resting
    };
    Ok((case, rests))
}

/// Mean force that is left on a grain over the mean normal force of a contact.
fn unbalanced(model: &Model, moment: &Snapshot) -> f64 {
    let of = &moment.bodies;
    let mut left: Vec<[f64; 2]> = of
        .mass
        .iter()
        .map(|mass| model.gravity.map(|gravity| mass * gravity))
        .collect();
    let mut normal = 0.0;
    for contact in &moment.contacts {
        let force = contact.force();
        normal += contact.normal_force;
        for (id, sign) in [(contact.id1, -1.0), (contact.id2, 1.0)] {
            if let Some(left) = left.get_mut(id as usize) {
                left[0] += sign * force[0];
                left[1] += sign * force[1];
            }
        }
    }
    let sum: f64 = left.iter().map(|[x, z]| x.hypot(*z)).sum();
    (sum / of.len() as f64) / (normal / moment.contacts.len() as f64)
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
    let mut reached = false;
    native::watch_case(&pressing, &native::CaseOptions::default(), &mut |moment| {
        reached = moment.punch.is_some_and(|punch| punch.force >= target);
        pressed = moment.bodies;
        punch = moment.punch.unwrap_or(punch);
        !reached
    })?;
    if !reached {
        return Err(NativeError {
            stage: Stage::Load,
            step: steps,
            trouble: Trouble::DoesNotBear,
        });
    }
    punch.velocity = 0.0;
    at_rest("a bed under the punch", &model, &pressed, Some(punch))
}
