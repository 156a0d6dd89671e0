//! Reading and validating a scene: every problem at once, each with its place and what would be right.

use std::f64::consts::FRAC_PI_2;

use serde_json::Value;

use super::fill::{filled, filled_anyway};
use super::paper_scene::open_choices;
use super::problem::{Findings, Problem, line_and_column, misfits, remove, twice};
use super::*;
use crate::obstacle::{Surface, Triangles};

/// The widest box, in mean diameters: room for the largest number of grains in a single row.
const WIDEST: f64 = 1.0e6;

const WIDTH: &str = "/box/width";
const DEPTH: &str = "/box/depth";

/// A faster punch would jump over what it should touch; in mean radii a step.
const LONGEST_STRIDE: f64 = 0.1;

/// A slower punch would never arrive.
const MOST_LOADING_STEPS: f64 = 1.0e9;

/// So many problems get their line; each search reads the text again.
const LOCATED: usize = 100;

/// A scene that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    #[error("the scene is not JSON: {0}")]
    Syntax(String),
    #[error("the scene has format version {found}, this program reads version {SCENE_VERSION}")]
    Version { found: String },
    #[error("the scene cannot be used:\n{}", lines(.0))]
    Problems(Vec<Problem>),
}

fn lines(problems: &[Problem]) -> String {
    let lines: Vec<String> = problems.iter().map(|p| format!("  {p}")).collect();
    lines.join("\n")
}

impl Scene {
    /// Validates a scene as [`parse_scene`] does its file.
    ///
    /// # Errors
    /// What its file would be refused for.
    pub fn check(&self) -> Result<(), SceneError> {
        parse_scene(&self.json().to_string()).map(drop)
    }

    /// As its file has it.
    pub fn json(&self) -> Value {
        serde_json::to_value(self).expect("a scene is JSON")
    }
}

/// Validates the text of a scene.
pub fn parse_scene(text: &str) -> Result<Scene, SceneError> {
    let refuse =
        |_: &Mesh| Err("no file: triangles are read where a scene's own file is".to_owned());
    parse_scene_with(text, &refuse)
}

/// The same of the text of a file, with a reader of the files of triangles that it names.
pub fn parse_scene_with(
    text: &str,
    triangles: &dyn Fn(&Mesh) -> Result<Triangles, String>,
) -> Result<Scene, SceneError> {
    let given: Value =
        serde_json::from_str(text).map_err(|error| SceneError::Syntax(error.to_string()))?;
    if let Some(version) = given.get("version")
        && version.as_u64() != Some(u64::from(SCENE_VERSION))
    {
        return Err(SceneError::Version {
            found: version.to_string(),
        });
    }
    let located = |mut problems: Vec<Problem>| {
        for problem in problems.iter_mut().take(LOCATED) {
            problem.at = line_and_column(text, &problem.place);
        }
        problems.sort_by_key(|problem| problem.at.unwrap_or((usize::MAX, 0)));
        SceneError::Problems(problems)
    };
    let whole = match given.is_object() {
        true => filled(&given),
        false => given.clone(),
    };
    let mut problems = misfits(&super::whole_schema(), &whole);
    for place in twice(text, "") {
        let found = "a key that was there already";
        problems.push(Problem::of(place, found, "each key once"));
    }
    let mut scene: Scene = match serde_json::from_value(whole) {
        Err(error) if problems.is_empty() => return Err(SceneError::Syntax(error.to_string())),
        Ok(scene) => scene,
        // Beside keys that are not known or have another form, values that cannot be meant are named too.
        Err(_) => match repaired(&given, &problems) {
            Some(scene) => scene,
            None => return Err(located(problems)),
        },
    };
    for (index, mesh) in std::mem::take(&mut scene.meshes).iter().enumerate() {
        match triangles(mesh) {
            Ok(found) => {
                let shapes = found
                    .into_iter()
                    .map(|vertices| Surface::Triangle { vertices });
                scene.obstacles.extend(shapes.map(Obstacle::still));
            }
            Err(reason) => {
                let place = format!("/meshes/{index}/path");
                problems.push(Problem::of(place, format!("{:?}", mesh.path), reason));
            }
        }
    }
    let problems = impossible(&scene, &given, problems);
    if problems.is_empty() {
        Ok(scene)
    } else {
        Err(located(problems))
    }
}

/// The scene with defaults in the place of what has these problems, and of what that belongs to if need be.
fn repaired(given: &Value, problems: &[Problem]) -> Option<Scene> {
    let mut given = given.clone();
    // What is in a list has no defaults.
    let place = |problem: &'_ Problem| {
        let in_list = |list: &&&str| problem.place.starts_with(**list);
        let list = [POINTS, OBSTACLES, MESHES].iter().find(in_list).copied();
        list.unwrap_or(&problem.place).to_owned()
    };
    let places: Vec<String> = problems.iter().map(place).collect();
    let mut places: Vec<&str> = places.iter().map(String::as_str).collect();
    while places.iter().any(|place| !place.is_empty()) {
        for place in &mut places {
            let is_there = given.pointer(place).is_some();
            remove(&mut given, place);
            // One that is missing is given by none of its parents.
            if !is_there && let Some((parent, _)) = place.rsplit_once('/') {
                remove(&mut given, parent);
                *place = parent;
            }
        }
        if let Ok(scene) = serde_json::from_value(filled_anyway(&given)) {
            return Some(scene);
        }
        for place in &mut places {
            *place = place.rsplit_once('/').map_or("", |(parent, _)| parent);
        }
    }
    None
}

/// What a number has to be, and how that is said.
type Range = (fn(f64) -> bool, &'static str);

const POSITIVE: Range = (|value| value > 0.0, "a finite number above 0");
const NOT_NEGATIVE: Range = (|value| value >= 0.0, "a finite number, 0 or more");
const BELOW_ONE: Range = (|value| (0.0..1.0).contains(&value), "a number in [0, 1)");
const UP_TO_ONE: Range = (|value| (0.0..=1.0).contains(&value), "a number in [0, 1]");
const REAL_SHARE: Range = (|value| value > 0.0 && value < 1.0, "a number in (0, 1)");
const RESTITUTION: Range = (|value| value > 0.0 && value <= 1.0, "a number in (0, 1]");
const POISSON: Range = (|value| (0.0..=0.5).contains(&value), "a number in [0, 0.5]");
const ANGLE: Range = (
    |value| (0.0..FRAC_PI_2).contains(&value),
    "a number in [0, π/2)",
);
/// The unit of an angle.
const RADIANS: &str = "rad";

/// Numbers that are right or wrong by themselves, with their units.
const NUMBERS: [(&str, Range, &str); 18] = [
    (DIAMETER, POSITIVE, "m"),
    (DISPERSION, BELOW_ONE, ""),
    (WIDTH, POSITIVE, "m"),
    (DEPTH, POSITIVE, "m"),
    ("/cloud/spin", NOT_NEGATIVE, "rad/s"),
    ("/cloud/jitter", UP_TO_ONE, ""),
    ("/cloud/speed", NOT_NEGATIVE, "m/s"),
    ("/gravity", NOT_NEGATIVE, "m/s²"),
    (SECONDS, POSITIVE, "s"),
    (FRACTION, POSITIVE, ""),
    ("/settle/kinetic_energy_fraction", REAL_SHARE, ""),
    ("/loading/half_width", POSITIVE, "m"),
    ("/loading/pressure", POSITIVE, "Pa"),
    ("/loading/speed", POSITIVE, "m/s"),
    ("/loading/give_up_depth", POSITIVE, "m"),
    (STANDS, POSITIVE, "s"),
    ("/measurement/control_volume_side", POSITIVE, "m"),
    ("/measurement/local_radius", POSITIVE, "m"),
];

const POINTS: &str = "/control_points";
const OBSTACLES: &str = "/obstacles";
const MESHES: &str = "/meshes";
const DIAMETER: &str = "/particles/mean_diameter";
const DISPERSION: &str = "/particles/dispersion";
const SECONDS: &str = "/time_step/seconds";
const FRACTION: &str = "/time_step/of_sqrt_m_over_k";
const STANDS: &str = "/loading/after_force/stand_still/seconds";
const DENSITY: &str = "/material/density";
const MODULUS: &str = "/material/youngs_modulus";

/// The same of the constants of a stage.
const CONSTANTS: [(&str, Range, &str); 16] = [
    (MODULUS, POSITIVE, "Pa"),
    (DENSITY, POSITIVE, "kg/m³"),
    ("/material/stiffness_ratio", POSITIVE, ""),
    ("/material/friction_angle", ANGLE, RADIANS),
    ("/material/wall_friction_angle", ANGLE, RADIANS),
    ("/material/punch_friction_angle", ANGLE, RADIANS),
    ("/contact/viscosity/c_n", POSITIVE, "N·s/m"),
    ("/contact/viscosity/e_n", RESTITUTION, ""),
    ("/contact/viscosity/ratio", NOT_NEGATIVE, ""),
    ("/contact/tangential_viscosity", UP_TO_ONE, ""),
    (
        "/contact/rolling/bending_stiffness",
        NOT_NEGATIVE,
        "N·m/rad",
    ),
    (
        "/contact/rolling/twisting_stiffness",
        NOT_NEGATIVE,
        "N·m/rad",
    ),
    ("/contact/rolling/limit", POSITIVE, ""),
    ("/contact/adhesion", NOT_NEGATIVE, "J/m²"),
    ("/material/poissons_ratio", POISSON, ""),
    ("/damping/alpha", BELOW_ONE, ""),
];

/// These problems, and values that have the right type and cannot be meant.
fn impossible(scene: &Scene, given: &Value, problems: Vec<Problem>) -> Vec<Problem> {
    let whole = &scene.json();
    let mut found = Findings {
        given,
        whole,
        problems,
    };
    found.name("/name", &scene.name);
    numbers("", scene, &NUMBERS, &mut found);
    for (at, stage) in stages(scene) {
        numbers(at, &*stage, &CONSTANTS, &mut found);
    }
    inside_box(scene, &mut found);
    for (at, stage) in stages(scene) {
        in_space(at, &stage, &mut found);
    }
    loading(scene, &mut found);
    obstacles(scene, &mut found);
    control_points(scene, &mut found);
    derived(scene, &mut found);
    let choice = |key: &str| format!("/choices/{}", key.replace('/', "~1"));
    for key in open_choices() {
        // A scene that gives no reasons is its own; one of before there was a choice means the default.
        let means_default = key == "/contact" && scene.contact == ContactLaw::default();
        if !scene.choices.is_empty() && !means_default && found.is_sound(key) {
            let reason = scene.choices.get(key).map_or("", |reason| reason.trim());
            let holds = !reason.is_empty() && !reason.contains('\n');
            let wanted = "one line of reason: the paper leaves this open";
            found.unless(holds, &choice(key), &reason, wanted);
        }
    }
    for key in scene
        .choices
        .keys()
        .filter(|_| given.get("choices").is_some())
    {
        let wanted = "the JSON pointer of a key of this scene";
        let is_there = whole.pointer(key).is_some() || !found.is_sound(key);
        found.unless(is_there, &choice(key), key, wanted);
    }
    found.problems
}

/// Holds those numbers of a part of the scene that are in a table against it; the part stands under `at`.
fn numbers(
    at: &str,
    part: &impl Serialize,
    table: &[(&str, Range, &str)],
    found: &mut Findings<'_>,
) {
    let part = serde_json::to_value(part).expect("a scene is JSON");
    for (key, (holds, wanted), unit) in table {
        let place = format!("{at}{key}");
        // What loading has from pouring is named there.
        let is_own = at != "/loading" || found.given.pointer(&place).is_some();
        if let Some(number) = part.pointer(key).and_then(Value::as_f64)
            && is_own
            && found.is_sound(&place)
        {
            let unit = match *unit {
                "" => String::new(),
                RADIANS if (FRAC_PI_2..=90.0).contains(&number) => {
                    format!(" rad; {number} degrees are {:.4} rad", number.to_radians())
                }
                unit => format!(" {unit}"),
            };
            found.unless(holds(number), &place, &number, &format!("{wanted}{unit}"));
        }
    }
}

/// The box and what has to be inside it.
fn inside_box(scene: &Scene, found: &mut Findings<'_>) {
    let (width, particles) = (scene.container.width, &scene.particles);
    let wanted = format!("at most {WIDEST} mean diameters");
    let holds = width <= WIDEST * particles.mean_diameter;
    found.follows(holds, &[WIDTH, DIAMETER], &wanted);
    let Cloud::JitteredLattice { columns, over, .. } = scene.cloud;
    let [from, to] = over.unwrap_or([0.0, width]);
    let wanted = "two places inside the box, the left one first";
    let holds = 0.0 <= from && from < to && to <= width;
    found.follows(holds, &["/cloud/over", WIDTH], wanted);
    let largest = particles.mean_diameter * (1.0 + particles.dispersion);
    let fits = ((to - from) / largest).floor();
    let wanted = format!("room for the largest grain, {largest} m across");
    let keys = ["/cloud/over", WIDTH, DIAMETER, DISPERSION];
    found.follows(fits >= 1.0, &keys, &wanted);
    let wanted = format!("at most {fits}, so that the largest grain fits into a cell");
    let holds = f64::from(columns) <= fits;
    let keys = ["/cloud/columns", "/cloud/over", WIDTH, DIAMETER, DISPERSION];
    found.follows(holds, &keys, &wanted);
    let half = scene.loading.half_width;
    let wanted = "less than half the box's width";
    found.follows(2.0 * half < width, &["/loading/half_width", WIDTH], wanted);
    let wanted = "no more than the box's width";
    for (key, length) in [
        ("control_volume_side", scene.measurement.control_volume_side),
        ("local_radius", scene.measurement.local_radius),
    ] {
        let place = format!("/measurement/{key}");
        found.follows(length <= width, &[&place, WIDTH], wanted);
    }
}

/// What grains in space may have and grains in the plane may not, in a stage.
fn in_space(at: &str, scene: &Scene, found: &mut Findings<'_>) {
    let (contact, depth) = (&scene.contact, scene.container.depth);
    let place = |key: &str| format!("{at}{key}");
    let sphere = scene.particles.shape == Shape::Sphere;
    let wanted = "\"sphere\", which alone is in space (/box/depth)";
    found.follows(
        depth.is_none() || sphere,
        &["/particles/shape", DEPTH],
        wanted,
    );
    let Cloud::JitteredLattice { columns, over, .. } = scene.cloud;
    let [from, to] = over.unwrap_or([0.0, scene.container.width]);
    let holds = depth.is_none_or(|depth| depth >= (to - from) / f64::from(columns));
    found.follows(
        holds,
        &[DEPTH, "/cloud/columns"],
        "room for a cell of the cloud",
    );
    let height = "/measurement/surface_height";
    let holds = depth.is_none() || scene.measurement.surface_height != SurfaceHeight::MeanSurface;
    found.follows(holds, &[height, DEPTH], "a height that there is in space");
    let hertz = contact.springs == Springs::HertzMindlin;
    let ratio = matches!(contact.viscosity, Viscosity::Ratio { .. });
    for (key, given, wanted, holds) in [
        (
            "springs",
            hertz,
            "linear in the plane: /box/depth is for spheres in space",
            depth.is_some(),
        ),
        (
            "springs",
            hertz,
            "linear, or /material/poissons_ratio given",
            scene.material.poissons_ratio.is_some(),
        ),
        (
            "viscosity",
            ratio,
            "another kind beside linear springs",
            hertz,
        ),
        (
            "tangential_viscosity",
            contact.tangential_viscosity.is_some(),
            "left out beside linear springs",
            hertz,
        ),
        (
            "adhesion",
            contact.adhesion.is_some(),
            "left out beside linear springs",
            hertz,
        ),
        (
            "adhesion_law",
            !contact.adhesion_law.is_pull(),
            "left out, or /contact/adhesion given",
            contact.adhesion.is_some(),
        ),
        (
            "rolling",
            contact.rolling.is_some(),
            "left out in the plane",
            depth.is_some(),
        ),
        (
            "rolling",
            contact.rolling.is_some(),
            "given a bending_stiffness, or a limit that is the constant torque",
            contact
                .rolling
                .is_none_or(|rolling| !rolling.is_constant() || rolling.limit.is_some()),
        ),
    ] {
        let [here, pouring] = [place(&format!("/contact/{key}")), format!("/contact/{key}")];
        found.follows(!given || holds, &[here.as_str(), &pouring, DEPTH], wanted);
    }
}

fn loading(scene: &Scene, found: &mut Findings<'_>) {
    let loading = &scene.loading;
    if let Some(Material { density, .. }) = loading.material {
        let wanted = "the density of pouring: grains keep their masses";
        let holds = density == scene.material.density;
        found.follows(holds, &["/loading/material/density", DENSITY], wanted);
    }
    let (height, depth) = (loading.punch_height, loading.give_up_depth);
    let keys = ["/loading/punch_height", "/loading/give_up_depth"];
    let wanted = match found.given.pointer(keys[0]) {
        Some(_) => "a finite number larger than /loading/give_up_depth",
        None => "a finite number smaller than /loading/punch_height",
    };
    found.follows(height > depth, &keys, wanted);
    if let AfterForce::StandStill { seconds } = loading.after_force {
        let wanted = format!("at most {MOST_LOADING_STEPS:e} steps");
        let holds = seconds / scene.time_step_seconds() <= MOST_LOADING_STEPS;
        found.follows(holds, &[&[STANDS][..], &TIME_STEP].concat(), &wanted);
    }
}

/// More make a scene that is no file to be read at once.
const MOST_OBSTACLES: usize = 5_000;

fn obstacles(scene: &Scene, found: &mut Findings<'_>) {
    let all = &scene.obstacles;
    let count = found.given.pointer(OBSTACLES).and_then(Value::as_array);
    let count = count.map_or(0, Vec::len);
    let keys = [OBSTACLES, MESHES];
    let wanted = format!("at most {MOST_OBSTACLES} in all, {} are given", all.len());
    found.follows(all.len() <= MOST_OBSTACLES, &keys, &wanted);
    let in_space = all.is_empty() || scene.in_space();
    let wanted = "left out in the plane: /box/depth is for spheres in space";
    found.follows(in_space, &[&keys[..], &[DEPTH]].concat(), wanted);
    for (index, obstacle) in all.iter().enumerate() {
        // What comes of a file has no place in the text.
        let place = match index < count {
            true => format!("{OBSTACLES}/{index}"),
            false => MESHES.to_owned(),
        };
        if let Some(wanted) = obstacle.lacks() {
            found.unless(false, &place, &obstacle.shape, wanted);
        }
    }
}

fn control_points(scene: &Scene, found: &mut Findings<'_>) {
    let points = &scene.control_points;
    let holds = (1..=100).contains(&points.len());
    found.unless(holds, "/control_points", &points.len(), "1 to 100 points");
    for (index, point) in points.iter().enumerate() {
        let at = format!("/control_points/{index}");
        let [offset, name] = ["offset", "name"].map(|key| format!("{at}/{key}"));
        let inside = point.offset.abs() < 0.5 * scene.container.width;
        found.follows(inside, &[&offset, WIDTH], "a place inside the box");
        numbers(&at, point, &[("/depth", POSITIVE, "m")], found);
        found.name(&name, &point.name);
        let twice = points[..index].iter().any(|other| other.name == point.name);
        found.unless(!twice, &name, &point.name, "a name of its own");
    }
}

/// The stages with constants of their own, and under what these stand.
fn stages(scene: &Scene) -> impl Iterator<Item = (&'static str, Cow<'_, Scene>)> {
    let at = |stage| match stage {
        Stage::Settle => "",
        Stage::Load => "/loading",
    };
    let stages = scene.stages();
    stages.map(move |stage| (at(stage), scene.in_stage(stage)))
}

/// What the time step follows from.
const TIME_STEP: [&str; 5] = [SECONDS, FRACTION, DIAMETER, MODULUS, DENSITY];

/// What follows from several keys must be usable too.
fn derived(scene: &Scene, found: &mut Findings<'_>) {
    let radius = 0.5 * scene.particles.mean_diameter;
    let smallest = scene.grain_mass(radius * (1.0 - scene.particles.dispersion));
    let dt = scene.time_step_seconds();
    for (keys, what, value) in [
        (
            &[DIAMETER, DENSITY, DISPERSION][..],
            "mass of the smallest grain",
            smallest,
        ),
        (&TIME_STEP, "time step in seconds", dt),
        (
            &["/loading/half_width", "/loading/pressure", DIAMETER, WIDTH],
            "target force 2ap",
            scene.target_force(),
        ),
    ] {
        let wanted = format!("a {what} that is a normal number above 0");
        found.follows(value.is_normal() && value > 0.0, keys, &wanted);
    }
    // Beyond √(m/k) the time step is to blame for whatever takes too large a share of it.
    let stiffness = scene.material.youngs_modulus * radius;
    let is_long = dt * dt * stiffness > scene.grain_mass(radius);
    let with_step = |keys: &[&'static str]| match is_long {
        true => [&TIME_STEP, keys].concat(),
        false => [keys, &TIME_STEP].concat(),
    };
    let Cloud::JitteredLattice { spin, .. } = scene.cloud;
    let wanted = format!("a spin of at most one radian a step, of {dt:.4e} s");
    found.follows(spin * dt <= 1.0, &with_step(&["/cloud/spin"]), &wanted);
    for (at, stage) in stages(scene) {
        let own = |key: &'static str| [format!("{at}{key}"), key.to_owned()];
        let normal = stage.material.youngs_modulus * radius;
        let wanted = "a stiffness E·R that is a normal number above 0";
        let [here, pouring] = own(MODULUS);
        let keys = [here.as_str(), &pouring, DIAMETER];
        found.follows(normal.is_normal(), &keys, wanted);
        let ratio = stage.material.stiffness_ratio;
        let wanted = "a ratio for which k_s = E·R·(k_s/k_n) is a normal number above 0";
        let [of_ratio, in_pouring] = own("/material/stiffness_ratio");
        let keys = [&[of_ratio.as_str(), &in_pouring], &keys[..]].concat();
        found.follows((ratio * normal).is_normal(), &keys, wanted);
        if let Viscosity::Dashpot { c_n, .. } = stage.contact.viscosity {
            let wanted = "a dashpot that takes no more than the approach speed of the two lightest grains in a \
                          step: c_n·dt ≤ m_eff";
            let [here, pouring] = own("/contact/viscosity/c_n");
            let keys = [&[here.as_str(), &pouring, DISPERSION], &TIME_STEP[..]].concat();
            found.follows(c_n * dt <= 0.5 * smallest, &keys, wanted);
        }
    }
    let speed = scene.loading.speed;
    let wanted =
        format!("a punch that moves at most {LONGEST_STRIDE} mean radii a step, of {dt:.4e} s");
    let holds = speed * dt <= LONGEST_STRIDE * radius;
    found.follows(holds, &with_step(&["/loading/speed"]), &wanted);
    let wanted =
        format!("a punch that reaches /loading/give_up_depth in {MOST_LOADING_STEPS:e} steps");
    let holds = scene.loading.give_up_depth / (speed * dt) <= MOST_LOADING_STEPS;
    let keys = ["/loading/speed", "/loading/give_up_depth"];
    found.follows(holds, &[&keys, &TIME_STEP[..]].concat(), &wanted);
}
