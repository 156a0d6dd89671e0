//! Spheres in space with the springs of Hertz and Mindlin: small scenes whose largest stable step has a closed form, beds under their
//! weight of ever softer spheres, so that overlaps grow from a ten-thousandth of the radius to a tenth, and what the field's rules of thumb go by.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::Result;
use super::scenes::{CRYSTAL_REMARK, MapScene, damped_limit, larger, poured, rested};
use crate::suite::spheres::{Sphere, case, hertz_mindlin};
use crate::suite::{wall, world};
use grains::model::{Axis, Law, Model};
use grains::native::linear;
use grains::reference::Linear;
use grains::scene::{
    Cloud, Rolling, Scene, Shape, Springs, Tension, TimeStep, TorqueArms, Viscosity, paper_scene,
};
use grains::task::Case;
use grains::vector::{Vector, times};

/// m, kg/m³, Pa.
const RADIUS: f64 = 0.005;
const DENSITY: f64 = 2600.0;
const MODULUS: f64 = 1.0e8;
const POISSONS_RATIO: f64 = 0.3;
/// Overlap over radius where it is chosen.
const SQUEEZED: f64 = 1.0e-3;
/// Friction angle where there is friction, rad.
const FRICTION_ANGLE: f64 = 0.5;
/// Restitution of the dashpots.
const RESTITUTION: f64 = 0.5;
/// Spheres along each edge of the crystal.
const CRYSTAL_EDGE: usize = 7;
/// Young's moduli of the beds, Pa.
pub const MODULI: [f64; 5] = [1.0e9, 1.0e8, 1.0e7, 1.0e6, 1.0e5];
const QUICK_MODULI: [f64; 2] = [1.0e9, 1.0e6];
/// The step of pouring and resting over the Rayleigh time of the smallest sphere.
const RESTING_STEP: f64 = 0.2;

/// What the contacts of a bed bear beside the normal force.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Bearing {
    Nothing,
    Friction,
    /// Friction, rolling and twisting.
    Moments,
}

impl Bearing {
    pub const ALL: [Bearing; 3] = [Bearing::Nothing, Bearing::Friction, Bearing::Moments];

    /// As in the name of a bed, and as on a page.
    pub fn words(self) -> [&'static str; 2] {
        match self {
            Bearing::Nothing => ["smooth", "no friction"],
            Bearing::Friction => ["rough", "friction"],
            Bearing::Moments => ["rolling", "friction and rolling"],
        }
    }
}

/// What rules of thumb for spheres go by.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spheres {
    /// What a bed's contacts bear; none of other scenes.
    pub bearing: Option<Bearing>,
    /// Mean and largest overlap over the mean radius of the two.
    pub overlap: f64,
    pub largest_overlap: f64,
    /// Rayleigh time of the smallest, s.
    pub rayleigh: f64,
}

impl Spheres {
    /// Of spheres in space with Hertz's springs.
    pub fn of(scene: &MapScene) -> Result<Option<Self>> {
        let case = &scene.case;
        if case.model.law.contact.springs == Springs::Linear {
            return Ok(None);
        }
        let contacts = linear(case)?;
        let overlaps = contacts.iter().map(over_radius);
        let spheres = case.bodies.radius.iter().zip(&case.bodies.mass);
        let rayleigh = spheres.map(|(radius, mass)| {
            let density = mass / (4.0 / 3.0 * PI * radius.powi(3));
            rayleigh(&case.model.law, *radius, density)
        });
        Ok(Some(Spheres {
            bearing: scene.bearing,
            overlap: overlaps.clone().sum::<f64>() / contacts.len() as f64,
            largest_overlap: overlaps.fold(0.0, f64::max),
            rayleigh: rayleigh.fold(f64::INFINITY, f64::min),
        }))
    }
}

fn over_radius(contact: &Linear) -> f64 {
    contact.overlap / (0.5 * (contact.radii[0] + contact.radii[1]))
}

/// π R √(ρ/G)/(0.1631 ν + 0.8766): how long a Rayleigh wave takes from pole to pole of a sphere, s.
fn rayleigh(law: &Law, radius: f64, density: f64) -> f64 {
    let solid = law.solid(0);
    let shear = solid.modulus / (2.0 * (1.0 + solid.poissons_ratio));
    PI * radius * (density / shear).sqrt() / (0.1631 * solid.poissons_ratio + 0.8766)
}

/// The names of all scenes, from the simplest up; a quick map has two beds of each kind.
pub fn names(quick: bool) -> Vec<String> {
    let moduli: &[f64] = if quick { &QUICK_MODULI } else { &MODULI };
    let of_kind = |kind: &Bearing| {
        let kind = *kind;
        moduli.iter().map(move |modulus| bed_name(kind, *modulus))
    };
    let beds = Bearing::ALL.iter().flat_map(of_kind);
    let small = small(CRYSTAL_EDGE).into_iter().map(|scene| scene.name);
    small.chain(beds).collect()
}

fn bed_name(bearing: Bearing, modulus: f64) -> String {
    format!("{}-bed-{modulus:e}", bearing.words()[0])
}

/// The scene of this name, beds with so many spheres; `made` keeps beds that were made. None where it is no name of spheres.
pub fn named(
    name: &str,
    grains: u32,
    made: &mut BTreeMap<String, MapScene>,
) -> Result<Option<MapScene>> {
    if let Some(scene) = small(CRYSTAL_EDGE)
        .into_iter()
        .find(|scene| scene.name == name)
    {
        return Ok(Some(scene));
    }
    for bearing in Bearing::ALL {
        for modulus in MODULI {
            if bed_name(bearing, modulus) == name {
                return bed(bearing, modulus, grains, made).map(Some);
            }
        }
    }
    Ok(None)
}

/// The bed with contacts that bear this. All start from that without friction.
fn bed(
    bearing: Bearing,
    modulus: f64,
    grains: u32,
    made: &mut BTreeMap<String, MapScene>,
) -> Result<MapScene> {
    let smooth = bed_name(Bearing::Nothing, modulus);
    if !made.contains_key(&smooth) {
        let scene = bed_scene(grains, modulus);
        let mut model = Model::of(&scene);
        model.law.friction_angle = 0.0;
        let case = rested(&smooth, &model, &poured(&scene)?, None)?;
        let bed = bed_with(Bearing::Nothing, modulus, case);
        made.insert(smooth.clone(), bed);
    }
    let mut case = made[&smooth].case.clone();
    if bearing != Bearing::Nothing {
        case.model.law.friction_angle = FRICTION_ANGLE;
    }
    if bearing == Bearing::Moments {
        // k_s R² of the mean contact.
        let contacts = linear(&case)?;
        let each = contacts
            .iter()
            .map(|contact| contact.k_s * contact.radii[1].powi(2));
        let stiffness = each.sum::<f64>() / contacts.len() as f64;
        case.model.law.contact.rolling = Some(unlimited(stiffness));
    }
    Ok(bed_with(bearing, modulus, case))
}

fn bed_with(bearing: Bearing, modulus: f64, case: Case) -> MapScene {
    let grains = case.bodies.len();
    let bears = bearing.words()[1];
    let title = format!("{grains} spheres of E = {modulus:e} Pa under their weight, {bears}");
    let mut scene = MapScene::new(&bed_name(bearing, modulus), &title, case);
    scene.bearing = Some(bearing);
    scene
}

/// A scene that pours the bed.
pub fn bed_scene(grains: u32, modulus: f64) -> Scene {
    let mut scene = paper_scene(1, grains);
    "spheres".clone_into(&mut scene.name);
    scene.particles.dispersion = 0.2;
    scene.particles.shape = Shape::Sphere;
    scene.material.youngs_modulus = modulus;
    scene.material.poissons_ratio = Some(POISSONS_RATIO);
    scene.material.friction_angle = FRICTION_ANGLE;
    scene.contact.springs = Springs::HertzMindlin;
    scene.contact.torque_arms = TorqueArms::ContactPoint;
    (scene.container.width, scene.container.depth) = (0.06, Some(0.06));
    let Cloud::JitteredLattice { columns, .. } = &mut scene.cloud;
    *columns = 5;
    let radius = 0.5 * scene.particles.mean_diameter * (1.0 - scene.particles.dispersion);
    let seconds = RESTING_STEP * rayleigh(&Model::of(&scene).law, radius, scene.material.density);
    scene.time_step = TimeStep::Absolute { seconds };
    scene.choices.clear();
    scene
}

fn unlimited(stiffness: f64) -> Rolling {
    Rolling {
        bending_stiffness: Some(stiffness),
        twisting_stiffness: stiffness,
        limit: None,
    }
}

fn law(friction_angle: f64) -> Law {
    hertz_mindlin(MODULUS, POISSONS_RATIO, friction_angle)
}

/// k_n and k_s of spheres of these radii at this overlap, N/m.
fn stiffnesses(radii: [f64; 2], overlap: f64) -> [f64; 2] {
    let solid = law(0.0).solid(0);
    let mean = radii[0] * radii[1] / (radii[0] + radii[1]);
    let [k_n, k_s] = solid.hertz_mindlin(solid, mean);
    [1.5 * k_n * overlap.sqrt(), k_s * overlap.sqrt()]
}

/// A sphere that its weight presses into the floor.
fn resting(law: Law) -> Case {
    let overlap = SQUEEZED * RADIUS;
    let sphere = Sphere::new([0.0, 0.0, RADIUS - overlap], RADIUS, DENSITY);
    // Two thirds of k_n u are the force.
    let force = stiffnesses([RADIUS; 2], overlap)[0] * overlap / 1.5;
    let gravity = [0.0, -force / sphere.mass];
    let model = world(law, 1.0e-6, gravity, 0.0, [&[], &[0.0]]);
    case("a sphere on a wall", model, &[sphere], vec![0])
}

/// Scenes whose limits have closed forms, the last one a crystal with so many spheres along each edge.
pub fn small(edge: usize) -> Vec<MapScene> {
    vec![
        sphere_on_wall(),
        sticking_sphere(),
        rolling_sphere(),
        damped_sphere(),
        heavy_sphere(),
        crystal(edge),
    ]
}

fn sphere_on_wall() -> MapScene {
    let case = resting(law(0.0));
    let [k_n, _] = stiffnesses([RADIUS; 2], SQUEEZED * RADIUS);
    MapScene::new("sphere-on-wall", "a sphere on a wall", case.clone()).with_limit(
        2.0 * (case.bodies.mass[0] / k_n).sqrt(),
        "2√(m/k_n), k_n = 2E*√(R*u)",
    )
}

/// It sways and turns: k_s (1/m + R²/I).
fn sticking_sphere() -> MapScene {
    let case = resting(law(FRICTION_ANGLE));
    let [_, k_s] = stiffnesses([RADIUS; 2], SQUEEZED * RADIUS);
    let title = "a sphere on a wall that sticks to it, free to turn";
    let limit = 2.0 * (case.bodies.mass[0] / (3.5 * k_s)).sqrt();
    MapScene::new("sticking-sphere", title, case).with_limit(
        limit,
        "2/√(k_s(1/m + R²/I)) = 2√(m/3.5k_s), k_s = 8G*√(R*u)",
    )
}

/// The same with resistance to rolling as stiff as k_s R².
fn rolling_sphere() -> MapScene {
    let [_, k_s] = stiffnesses([RADIUS; 2], SQUEEZED * RADIUS);
    let mut law = law(FRICTION_ANGLE);
    let bending = k_s * RADIUS * RADIUS;
    law.contact.rolling = Some(unlimited(bending));
    let case = resting(law);
    let (mass, inertia) = (case.bodies.mass[0], case.bodies.inertia[0]);
    let coupling = k_s * RADIUS / (mass * inertia).sqrt();
    let square = larger(
        k_s / mass,
        coupling,
        (k_s * RADIUS * RADIUS + bending) / inertia,
    );
    let title = "the same with resistance to rolling, k_r = k_s R²";
    MapScene::new("rolling-sphere", title, case).with_limit(
        2.0 / square.sqrt(),
        "2/ω, ω² the larger root of (k_s/m − ω²)((k_s R² + k_r)/I − ω²) = k_s² R²/(mI)",
    )
}

fn damped_sphere() -> MapScene {
    let mut law = law(0.0);
    law.contact.viscosity = Viscosity::Restitution {
        e_n: RESTITUTION,
        tension: Tension::Clipped,
    };
    let [ratio, _] = law.damping_ratios();
    let case = resting(law);
    let [k_n, _] = stiffnesses([RADIUS; 2], SQUEEZED * RADIUS);
    let omega = (k_n / case.bodies.mass[0]).sqrt();
    let title = format!("a sphere on a wall with the dashpot of e = {RESTITUTION}");
    MapScene::new("damped-sphere", &title, case)
        .with_limit(damped_limit(omega, ratio), "(2/ω)(√(1+β²) − β)")
}

/// A small sphere on a large one: two free spheres cannot be held in contact.
fn heavy_sphere() -> MapScene {
    let ratio = 5.0;
    let below = Sphere::new([0.0; 3], ratio * RADIUS, DENSITY);
    let above = Sphere::new([0.0; 3], RADIUS, DENSITY);
    let overlap = SQUEEZED * RADIUS;
    let radii = [below.radius, above.radius];
    let [k_n, _] = stiffnesses(radii, overlap);
    let gravity = k_n * overlap / 1.5 / above.mass;
    // The floor bears both; F = (2/3) k u grows with u^1.5.
    let unit = stiffnesses([below.radius; 2], 1.0)[0] / 1.5;
    let on_floor = (gravity * (below.mass + above.mass) / unit).powf(2.0 / 3.0);
    let [floor, _] = stiffnesses([below.radius; 2], on_floor);
    let low = below.radius - on_floor;
    let spheres = [
        below.at([0.0, 0.0, low]),
        above.at([0.0, 0.0, low + below.radius + above.radius - overlap]),
    ];
    let coupling = k_n / (below.mass * above.mass).sqrt();
    let square = larger((floor + k_n) / below.mass, coupling, k_n / above.mass);
    let model = world(law(0.0), 1.0e-6, [0.0, -gravity], 0.0, [&[], &[0.0]]);
    let case = case("spheres", model, &spheres, vec![0]);
    let title = "a sphere on one that is five times larger";
    MapScene::new("sphere-on-sphere", title, case)
        .with_limit(
            2.0 / square.sqrt(),
            "2/ω, ω² the larger root of ((K+k)/M − ω²)(k/m − ω²) = k²/(mM)",
        )
        .along([false, false, true])
}

/// A simple cubic crystal between six walls that all its spheres stick to: all turn the same way.
fn crystal(edge: usize) -> MapScene {
    let overlap = SQUEEZED * RADIUS;
    let pitch = 2.0 * RADIUS - overlap;
    let place = |at: usize| RADIUS - overlap + pitch * at as f64;
    let end = place(edge - 1) + RADIUS - overlap;
    let sides = 0..edge;
    let spheres: Vec<Sphere> = sides
        .clone()
        .flat_map(|z| sides.clone().map(move |y| (z, y)))
        .flat_map(|(z, y)| sides.clone().map(move |x| [x, y, z]))
        .map(|at| Sphere::new(at.map(place), RADIUS, DENSITY))
        .collect();
    let walls: [&[f64]; 2] = [&[0.0, end], &[0.0, end]];
    let mut model = world(law(FRICTION_ANGLE), 1.0e-6, [0.0; 2], 0.0, walls);
    model
        .walls
        .extend([0.0, end].map(|place| wall(Axis::Y, place)));
    let [_, k_s] = stiffnesses([RADIUS; 2], overlap);
    let limit = 2.0 * (spheres[0].mass / (20.0 * k_s)).sqrt();
    let title = format!(
        "{} equal spheres in a cubic crystal between six walls",
        spheres.len()
    );
    let case = case("a crystal", model, &spheres, vec![0]);
    MapScene::new("cubic-crystal", &title, case)
        .with_limit(limit, "2√(m/20k_s), of the endless crystal")
        .with_remark(CRYSTAL_REMARK)
        .within(0.02)
}

/// Two free spheres that overlap, which no walls hold.
pub fn pair(friction_angle: f64) -> Case {
    let apart = 2.0 * RADIUS - SQUEEZED * RADIUS;
    let places = [[0.0; 3], [0.36 * apart, 0.48 * apart, 0.8 * apart]];
    let spheres = places.map(|place| Sphere::new(place, RADIUS, DENSITY));
    let model = world(law(friction_angle), 1.0e-6, [0.0; 2], 0.0, [&[], &[]]);
    case("two spheres", model, &spheres, vec![0])
}

/// Three unequal spheres without friction that overlap by a few hundredths of their radii, two of them with the floor too.
pub fn cluster() -> Case {
    let sphere =
        |place: Vector, share: f64| Sphere::new(times(RADIUS, place), share * RADIUS, DENSITY);
    let spheres = [
        sphere([0.0, 0.0, 0.97], 1.0),
        sphere([1.5, 0.5, 0.68], 0.7),
        sphere([1.15, 0.4, 1.74], 0.5),
    ];
    let model = world(law(0.0), 1.0e-6, [0.0; 2], 0.0, [&[], &[0.0]]);
    case("three spheres", model, &spheres, vec![0])
}
