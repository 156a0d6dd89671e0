//! Scenes in equilibrium: small ones and a crystal, whose largest stable step has a closed form, and beds of the paper's grains.

use std::collections::BTreeMap;
use std::f64::consts::{PI, SQRT_2};

use serde::{Deserialize, Serialize};

use super::Result;
use super::spheres::{self, Bearing};
use crate::study::realization::bed_of;
use crate::suite::{self, Grain};
use crate::workers::asked_to_end;
use grains::generate::initial_bodies;
use grains::measure::unbalanced_force;
use grains::model::{Law, Model};
use grains::native::{self, CaseOptions, NativeError, Options, Trouble, watch_case};
use grains::scene::{Cloud, Scene, Tension, Viscosity, paper_scene};
use grains::tables::{Bodies, Punch, Stage};
use grains::task::{Case, Task};

/// Radius of the ordinary grain, m.
const RADIUS: f64 = 0.005;
/// kg/m³.
const DENSITY: f64 = 2600.0;
/// Pa.
const MODULUS: f64 = 1.0e7;
/// Overlap over radius, where it is chosen, and of the crystal as it is laid out.
const SQUEEZED: f64 = 1.0e-4;
const CRYSTAL_OVERLAP: f64 = 1.0e-3;
/// k of a grain of the ordinary radius at a wall or another such grain, N/m.
const STIFFNESS: f64 = MODULUS * RADIUS;
/// Cundall's α while a bed is brought to rest. Stronger damping takes longer: the bed creeps.
const BRAKE: f64 = 0.2;
/// A bed rests when the mean unbalanced force of its grains is this share of the mean contact force.
const AT_REST: f64 = 1.0e-9;
/// Looked at every so many steps; after so many it is given up.
const LOOK_EVERY: usize = 10_000;
const MOST_RESTING_STEPS: u64 = 3_000_000;
/// The punch's force is looked at every so many steps.
const PRESS_LOOK_EVERY: usize = 100;
/// tan φ is that of this angle, rad, and k_s = k_n.
const FRICTION_ANGLE: f64 = 0.5;

#[derive(Debug, Clone, PartialEq)]
pub struct MapScene {
    pub name: String,
    pub title: String,
    /// In equilibrium, at rest.
    pub case: Case,
    /// Along which of x, y and z it is disturbed. A row of grains under load would buckle sideways.
    pub axes: [bool; 3],
    /// What the contacts of a bed of spheres bear.
    pub bearing: Option<Bearing>,
    /// The largest stable step without damping, if it has a closed form.
    pub closed: Option<ClosedForm>,
    /// What a reader should know of it; may be empty.
    pub remark: String,
}

/// A largest stable step by a formula.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ClosedForm {
    /// s.
    pub dt: f64,
    pub formula: String,
    /// How far the scene may be from it, relative: of the pre-stress, and of what the formula leaves out.
    pub tolerance: f64,
}

impl MapScene {
    pub(super) fn new(name: &str, title: &str, case: Case) -> Self {
        MapScene {
            name: name.to_owned(),
            title: title.to_owned(),
            case,
            axes: [true; 3],
            bearing: None,
            closed: None,
            remark: String::new(),
        }
    }

    pub(super) fn with_limit(mut self, dt: f64, formula: &str) -> Self {
        self.closed = Some(ClosedForm {
            dt,
            formula: formula.to_owned(),
            tolerance: 1.0e-3,
        });
        self
    }

    pub(super) fn along(mut self, axes: [bool; 3]) -> Self {
        self.axes = axes;
        self
    }

    /// With a closed form that leaves so much out, relative.
    pub(super) fn within(mut self, tolerance: f64) -> Self {
        if let Some(closed) = &mut self.closed {
            closed.tolerance = tolerance;
        }
        self
    }

    pub(super) fn with_remark(mut self, remark: &str) -> Self {
        remark.clone_into(&mut self.remark);
        self
    }
}

const CRYSTAL_ROWS: usize = 12;
pub(super) const CRYSTAL_REMARK: &str =
    "walls hold a crystal less than more crystal would, so its limit is a little above";

/// The names of all scenes in the plane, from the simplest up.
pub fn names() -> Vec<String> {
    let small = small().into_iter().map(|scene| scene.name);
    let large = ["hexagonal-crystal"].into_iter().chain(BEDS);
    small.chain(large.map(str::to_owned)).collect()
}

/// The scene of this name, beds with so many grains; `made` keeps beds that were made. A name that is none is the dense bed's.
pub fn of(name: &str, grains: u32, made: &mut BTreeMap<String, MapScene>) -> Result<MapScene> {
    let small = small().into_iter().find(|scene| scene.name == name);
    match small.map_or_else(
        || spheres::named(name, grains, made),
        |scene| Ok(Some(scene)),
    )? {
        Some(scene) => Ok(scene),
        None if name == "hexagonal-crystal" => crystal(CRYSTAL_ROWS),
        None => bed(name, grains, made),
    }
}

/// The small scenes, whose limits have closed forms.
pub fn small() -> Vec<MapScene> {
    let mut scenes = vec![
        one_contact(),
        grain_on_wall(),
        sticking_grain(),
        chain(10, 0.0),
        unequal_sizes(),
        punch_corner(),
    ];
    scenes.extend([0.5, 0.99, 1.01, 3.0].map(dashpot));
    scenes.push(chain(10, 0.5));
    scenes
}

fn grain(position: [f64; 2]) -> Grain {
    Grain::disc(position, RADIUS, DENSITY)
}

/// Grains under this gravity downwards, with walls that hold x and z at these places, m.
fn case(name: &str, law: Law, gravity: f64, walls: [&[f64]; 2], grains: &[Grain]) -> Case {
    let model = suite::world(law, 1.0e-6, [0.0, 0.0 - gravity], 0.0, walls);
    suite::case(name, model, grains, vec![0])
}

/// Nothing but the floor.
const FLOOR: [&[f64]; 2] = [&[], &[0.0]];

fn with_dashpot(c_n: f64) -> Law {
    let tension = Tension::Clipped;
    suite::with_viscosity(suite::springs(MODULUS), Viscosity::Dashpot { c_n, tension })
}

/// Gravity that presses a grain of this mass into its support by [`SQUEEZED`], m/s².
fn gravity(mass: f64) -> f64 {
    STIFFNESS * SQUEEZED * RADIUS / mass
}

/// Largest of the two eigenvalues of [[a, b], [b, c]].
pub(super) fn larger(a: f64, b: f64, c: f64) -> f64 {
    let half = 0.5 * (a - c);
    0.5 * (a + c) + (half * half + b * b).sqrt()
}

/// The largest stable step of an oscillator with damping ratio ζ, s.
pub(super) fn damped_limit(omega: f64, ratio: f64) -> f64 {
    2.0 / omega * ((1.0 + ratio * ratio).sqrt() - ratio)
}

fn one_contact() -> MapScene {
    let ratio = 100.0;
    let light = grain([0.0, 0.0]);
    let mass = light.mass;
    // The heavy one is pressed into the floor by both.
    let floor = (ratio + 1.0) * SQUEEZED * RADIUS;
    let mut below = grain([0.0, RADIUS - floor]);
    below.mass = ratio * mass;
    let above = grain([0.0, below.position[1] + 2.0 * RADIUS - SQUEEZED * RADIUS]);
    let law = suite::springs(MODULUS);
    let case = case("one contact", law, gravity(mass), FLOOR, &[below, above]);
    let square = STIFFNESS / mass;
    let omega = larger(2.0 * square / ratio, square / ratio.sqrt(), square).sqrt();
    MapScene::new("one-contact", "a grain on a heavy one", case)
        .with_limit(
            2.0 / omega,
            "2/ω, ω² the larger root of (2k/M − ω²)(k/m − ω²) = k²/(mM), M = 100 m",
        )
        .along([false, false, true])
        .with_remark(
            "two free grains cannot be held in contact, so the lower one is a hundred times heavier and rests on the floor",
        )
}

fn resting(law: Law) -> Case {
    let resting = grain([0.0, RADIUS - SQUEEZED * RADIUS]);
    let gravity = gravity(resting.mass);
    case("a grain on a wall", law, gravity, FLOOR, &[resting])
}

fn grain_on_wall() -> MapScene {
    let case = resting(suite::springs(MODULUS));
    let omega = (STIFFNESS / case.bodies.mass[0]).sqrt();
    MapScene::new("grain-on-wall", "a grain on a wall", case).with_limit(2.0 / omega, "2√(m/k)")
}

/// A grain that sticks to the wall sways and turns: the two springs' k_s (1/m + R²/I).
fn sticking_grain() -> MapScene {
    let case = resting(suite::friction(MODULUS, 1.0, 0.5));
    let bodies = &case.bodies;
    let omega = (STIFFNESS * (1.0 / bodies.mass[0] + RADIUS * RADIUS / bodies.inertia[0])).sqrt();
    let title = "a grain on a wall that sticks to it, free to turn, k_s = k_n";
    MapScene::new("sticking-grain", title, case)
        .with_limit(2.0 / omega, "2/√(k_s(1/m + R²/I)) = 2√(m/3k)")
}

/// A grain on a wall with a dashpot of this damping ratio.
fn dashpot(ratio: f64) -> MapScene {
    let mass = grain([0.0; 2]).mass;
    let omega = (STIFFNESS / mass).sqrt();
    let case = resting(with_dashpot(2.0 * ratio * mass * omega));
    let side = if ratio < 1.0 { "below" } else { "past" };
    let title = format!("a grain on a wall with a dashpot {side} critical, ζ = {ratio}");
    MapScene::new(&format!("dashpot-{ratio}"), &title, case)
        .with_limit(damped_limit(omega, ratio), "(2/ω)(√(1+ζ²) − ζ)")
}

/// Grains in a row between two walls; modes 4k/m sin²(jπ/2(N+1)), of which the fastest has this damping ratio.
fn chain(count: usize, ratio: f64) -> MapScene {
    let overlap = SQUEEZED * RADIUS;
    let pitch = 2.0 * RADIUS - overlap;
    let grains: Vec<Grain> = (0..count)
        .map(|at| grain([RADIUS - overlap + pitch * at as f64, 0.0]))
        .collect();
    let end = grains[count - 1].position[0] + RADIUS - overlap;
    let share = (0.5 * PI * count as f64 / (count as f64 + 1.0)).sin();
    let omega = 2.0 * share * (STIFFNESS / grains[0].mass).sqrt();
    let title = format!("{count} grains in a row between walls");
    let of_law = |law| case("a chain", law, 0.0, [&[0.0, end], &[]], &grains);
    let scene = if ratio > 0.0 {
        let title = format!("{title}, dashpots of ζ = {ratio} in the fastest mode");
        // C is c/k times K.
        let case = of_law(with_dashpot(2.0 * ratio * STIFFNESS / omega));
        MapScene::new("chain-with-dashpots", &title, case).with_limit(
            damped_limit(omega, ratio),
            "(2/ω)(√(1+ζ²) − ζ), ω = 2√(k/m) sin(Nπ/(2N+2))",
        )
    } else {
        MapScene::new("chain", &title, of_law(suite::springs(MODULUS)))
            .with_limit(2.0 / omega, "2/ω, ω = 2√(k/m) sin(Nπ/(2N+2))")
    };
    scene.along([true, false, false])
}

/// A small grain between two large ones between two walls: the small one moves against both, or the large ones
/// against each other.
fn unequal_sizes() -> MapScene {
    let small = RADIUS / 10.0;
    let inner = 2.0 * MODULUS * RADIUS * small / (RADIUS + small);
    // The same force in all four contacts.
    let force = inner * SQUEEZED * small;
    let (at_wall, between) = (force / STIFFNESS, force / inner);
    let first = grain([RADIUS - at_wall, 0.0]);
    let second = first.position[0] + RADIUS + small - between;
    let middle = Grain::disc([second, 0.0], small, DENSITY);
    let last = grain([second + RADIUS + small - between, 0.0]);
    let end = last.position[0] + RADIUS - at_wall;
    let grains = [first, middle, last];
    let (large, light) = (first.mass, middle.mass);
    let coupling = SQRT_2 * inner / (large * light).sqrt();
    let square = larger((STIFFNESS + inner) / large, coupling, 2.0 * inner / light);
    let law = suite::springs(MODULUS);
    let case = case("unequal sizes", law, 0.0, [&[0.0, end], &[]], &grains);
    let title = "a grain between two that are ten times larger, between walls";
    let formula = "2/ω, ω² the larger root of ((K+k)/M − ω²)(2k/m − ω²) = 2k²/(mM)";
    MapScene::new("unequal-sizes", title, case)
        .with_limit(2.0 / square.sqrt(), formula)
        .along([true, false, false])
}

/// A grain in the corner of floor and wall, held there by the corner of the punch.
fn punch_corner() -> MapScene {
    let overlap = SQUEEZED * RADIUS;
    let half_extents = [2.0 * RADIUS, 2.0 * RADIUS];
    // Both sides bear F/√2 of the corner's F.
    let side = RADIUS - overlap / SQRT_2;
    let corner = side + (RADIUS - overlap) / SQRT_2;
    let held = grain([side, side]);
    let omega = (2.0 * STIFFNESS / held.mass).sqrt();
    let law = suite::springs(MODULUS);
    let mut case = case("a punch corner", law, 0.0, [&[0.0], &[0.0]], &[held]);
    let axis = corner + half_extents[0];
    case.punch = Some(suite::punch(axis, corner, half_extents, 0.0));
    let title = "a grain in a corner of the box, held by the corner of the punch";
    MapScene::new("punch-corner", title, case).with_limit(2.0 / omega, "2√(m/2k)")
}

/// A crystal between four walls: rows one over the other, every other one moved by half a grain.
pub fn crystal(rows: usize) -> Result<MapScene> {
    let pitch = 2.0 * RADIUS * (1.0 - CRYSTAL_OVERLAP);
    let height = 0.75f64.sqrt() * pitch;
    let inset = RADIUS * (1.0 - CRYSTAL_OVERLAP);
    let places = (0..rows).flat_map(|row| (0..rows).map(move |column| (row, column)));
    let grains: Vec<Grain> = places
        .map(|(row, column)| {
            let x = inset + pitch * (column as f64 + 0.5 * (row % 2) as f64);
            grain([x, inset + height * row as f64])
        })
        .collect();
    let right = 2.0 * inset + pitch * (rows as f64 - 0.5);
    let top = 2.0 * inset + height * (rows as f64 - 1.0);
    let walls: [&[f64]; 2] = [&[0.0, right], &[0.0, top]];
    let mass = grains[0].mass;
    let mut laid = case("a crystal", suite::springs(MODULUS), 0.0, walls, &grains);
    laid.model.dt = 0.3 * (mass / STIFFNESS).sqrt();
    let case = rested("a crystal", &laid.model, &laid.bodies, None)?;
    let title = format!("{rows} by {rows} equal grains in a hexagonal crystal between four walls");
    let limit = 2.0 / (6.0 * MODULUS * RADIUS / mass).sqrt();
    Ok(MapScene::new("hexagonal-crystal", &title, case)
        .with_limit(limit, "2√(m/6k), of the endless crystal")
        .with_remark(CRYSTAL_REMARK)
        .within(0.01))
}

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
pub const BEDS: [&str; 3] = ["dense-bed", "bed-under-punch", "frictional-bed"];

/// The bed of this name; `made` keeps beds, as some come from others.
fn bed(name: &str, grains: u32, made: &mut BTreeMap<String, MapScene>) -> Result<MapScene> {
    if let Some(known) = made.get(name) {
        return Ok(known.clone());
    }
    let mut scene = bed_scene(grains);
    let rested =
        |label: &str, scene: &Scene| rested(label, &Model::of(scene), &poured(scene)?, None);
    let bed = match name {
        "bed-under-punch" => {
            let dense = bed("dense-bed", grains, made)?;
            let title =
                format!("the dense bed of {grains} grains under the punch, pressed and held");
            MapScene::new(name, &title, pressed(&scene, &dense.case.bodies)?)
        }
        "frictional-bed" => {
            scene.material.friction_angle = FRICTION_ANGLE;
            let title = format!(
                "{grains} grains poured with friction 0.5, every contact sticking, k_s = k_n"
            );
            MapScene::new(name, &title, rested("a frictional bed", &scene)?).with_remark(
                "a case cannot be given the shear forces of a bed, so the bed rests without friction before it is \
                 switched on again: as many contacts as without friction, all sticking, which is the harder case",
            )
        }
        _ => {
            let title = format!("the paper's bed of {grains} grains, settled");
            MapScene::new(name, &title, rested("a dense bed", &scene)?)
        }
    };
    made.insert(name.to_owned(), bed.clone());
    Ok(bed)
}

pub(super) fn poured(scene: &Scene) -> Result<Bodies> {
    let task = Task::settle(initial_bodies(scene));
    let outcome = native::run(scene, &task, &Options::default(), &mut ())?;
    Ok(outcome.last.bodies)
}

/// The punch goes down on the bed by a share of the grains' overlaps at its load, and is held there.
fn pressed(scene: &Scene, bodies: &Bodies) -> Result<Case> {
    let model = Model::of(scene);
    let mut punch = native::first_contact_punch(scene, bodies);
    let steps = (scene.loading.give_up_depth / (scene.loading.speed * model.dt)) as u64;
    let pressing = Case {
        name: "pressing".to_owned(),
        model: model.clone(),
        bodies: bodies.clone(),
        punch: Some(punch),
        moments: (0..=steps).step_by(PRESS_LOOK_EVERY).collect(),
    };
    let mut pressed = bodies.clone();
    let mut reached = false;
    watch_case(&pressing, &CaseOptions::default(), &mut |moment| {
        pressed = moment.bodies;
        punch = moment.punch.unwrap_or(punch);
        reached = punch.force >= scene.target_force();
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
    rested("a bed under the punch", &model, &pressed, Some(punch))
}

/// A bed brought to rest without friction, its velocities then set to zero, and then with the model's friction switched on,
/// which no contact has to bear yet.
pub fn rested(name: &str, model: &Model, bodies: &Bodies, punch: Option<Punch>) -> Result<Case> {
    let mut smooth = model.clone();
    smooth.alpha = BRAKE;
    smooth.law.friction_angle = 0.0;
    (
        smooth.law.wall_friction_angle,
        smooth.law.punch_friction_angle,
    ) = (None, None);
    let resting = Case {
        name: name.to_owned(),
        model: smooth,
        bodies: Bodies {
            spin: Vec::new(),
            spin_x: Vec::new(),
            spin_z: Vec::new(),
            inertia: Vec::new(),
            ..bodies.clone()
        },
        punch,
        moments: (0..=MOST_RESTING_STEPS).step_by(LOOK_EVERY).collect(),
    };
    let mut last = resting.bodies.clone();
    let mut rests = false;
    watch_case(&resting, &CaseOptions::default(), &mut |moment| {
        let unbalanced = unbalanced_force(-model.gravity[1], bed_of(&moment));
        rests = moment.step > 0 && unbalanced.is_some_and(|force| force <= AT_REST);
        last = moment.bodies;
        !rests && !asked_to_end()
    })?;
    if rests {
        (last.spin, last.inertia) = (bodies.spin.clone(), bodies.inertia.clone());
        (last.spin_x, last.spin_z) = (bodies.spin_x.clone(), bodies.spin_z.clone());
        return Ok(still(name, model.clone(), last, punch));
    }
    let steps = MOST_RESTING_STEPS;
    let ended = asked_to_end().then_some(Trouble::Interrupted);
    Err(NativeError {
        stage: Stage::Settle,
        step: steps,
        trouble: ended.unwrap_or(Trouble::DoesNotRest { steps }),
    })
}

/// Bodies as they stand, at rest.
pub fn still(name: &str, model: Model, mut bodies: Bodies, punch: Option<Punch>) -> Case {
    let velocities = [&mut bodies.vx, &mut bodies.vy, &mut bodies.vz];
    let spins = [&mut bodies.spin_x, &mut bodies.spin, &mut bodies.spin_z];
    let columns = velocities.into_iter().chain(spins);
    columns.for_each(|column| column.fill(0.0));
    Case {
        name: name.to_owned(),
        model,
        bodies,
        punch,
        moments: vec![0],
    }
}
