//! Reading and validating a scene: every problem at once, each with its place and what would be right.

use std::f64::consts::FRAC_PI_2;

use serde_json::Value;

use super::fill::filled;
use super::paper_scene::OPEN_CHOICES;
use super::problem::{Findings, Problem, line_and_column, misfits, remove, twice};
use super::*;

/// The widest box, in mean diameters: room for the largest number of grains in a single row.
const WIDEST: f64 = 1.0e6;

const WIDTH: &str = "/box/width";

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

/// Validates the text of a scene.
pub fn parse_scene(text: &str) -> Result<Scene, SceneError> {
    let mut given: Value =
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
            problem.at = Some(line_and_column(text, &problem.place));
        }
        problems.sort_by_key(|of| of.at.unwrap_or((usize::MAX, 0)));
        SceneError::Problems(problems)
    };
    if let Some(place) = twice(text, "") {
        let problem = Problem::of(place, "a key that was there already", "each key once");
        return Err(located(vec![problem]));
    }
    let whole = |given: &Value| match given.is_object() {
        true => filled(given),
        false => given.clone(),
    };
    let mut problems = misfits(&super::whole_schema(), &whole(&given));
    // Beside keys that are not known or have another form, values that cannot be meant are named too.
    remove(&mut given, &problems);
    let scene: Scene = match serde_json::from_value(whole(&given)) {
        Ok(scene) => scene,
        Err(error) if problems.is_empty() => return Err(SceneError::Syntax(error.to_string())),
        Err(_) => return Err(located(problems)),
    };
    for problem in impossible(&scene) {
        if problems.iter().all(|of| of.place != problem.place) {
            problems.push(problem);
        }
    }
    if problems.is_empty() {
        Ok(scene)
    } else {
        Err(located(problems))
    }
}

/// What a number has to be, and how that is said.
type Range = (fn(f64) -> bool, &'static str);

const POSITIVE: Range = (|of| of > 0.0, "a finite number above 0");
const NOT_NEGATIVE: Range = (|of| of >= 0.0, "a finite number, 0 or more");
const BELOW_ONE: Range = (|of| (0.0..1.0).contains(&of), "a number in [0, 1)");
const UP_TO_ONE: Range = (|of| (0.0..=1.0).contains(&of), "a number in [0, 1]");
const REAL_SHARE: Range = (|of| of > 0.0 && of < 1.0, "a number in (0, 1)");
const RESTITUTION: Range = (|of| of > 0.0 && of <= 1.0, "a number in (0, 1]");
const ANGLE: Range = (|of| (0.0..FRAC_PI_2).contains(&of), "a number in [0, π/2)");

/// Numbers that are right or wrong by themselves.
const NUMBERS: [(&str, Range); 17] = [
    ("/particles/mean_diameter", POSITIVE),
    ("/particles/dispersion", BELOW_ONE),
    (WIDTH, POSITIVE),
    ("/cloud/spin", NOT_NEGATIVE),
    ("/cloud/jitter", UP_TO_ONE),
    ("/cloud/speed", NOT_NEGATIVE),
    ("/gravity", NOT_NEGATIVE),
    ("/time_step/seconds", POSITIVE),
    ("/time_step/of_sqrt_m_over_k", POSITIVE),
    ("/settle/kinetic_energy_fraction", REAL_SHARE),
    ("/loading/half_width", POSITIVE),
    ("/loading/pressure", POSITIVE),
    ("/loading/speed", POSITIVE),
    ("/loading/give_up_depth", POSITIVE),
    ("/loading/after_force/stand_still/seconds", POSITIVE),
    ("/measurement/control_volume_side", POSITIVE),
    ("/measurement/local_radius", POSITIVE),
];

/// The same of the constants of a stage.
const CONSTANTS: [(&str, Range); 9] = [
    ("/material/youngs_modulus", POSITIVE),
    ("/material/density", POSITIVE),
    ("/material/stiffness_ratio", POSITIVE),
    ("/material/friction_angle", ANGLE),
    ("/material/wall_friction_angle", ANGLE),
    ("/material/punch_friction_angle", ANGLE),
    ("/contact/viscosity/c_n", POSITIVE),
    ("/contact/viscosity/e_n", RESTITUTION),
    ("/damping/alpha", BELOW_ONE),
];

/// Values that have the right type and cannot be meant.
fn impossible(scene: &Scene) -> Vec<Problem> {
    let mut found = Findings(Vec::new());
    found.name("/name", &scene.name);
    numbers("", scene, &NUMBERS, &mut found);
    for (at, stage) in stages(scene) {
        numbers(at, &*stage, &CONSTANTS, &mut found);
    }
    inside_box(scene, &mut found);
    loading(scene, &mut found);
    control_points(scene, &mut found);
    derived(scene, &mut found);
    let choice = |key: &str| format!("/choices/{}", key.replace('/', "~1"));
    for (key, _) in OPEN_CHOICES {
        // A scene that gives no reasons is its own; one of before there was a choice means the default.
        let means_default = *key == "/contact" && scene.contact == ContactLaw::default();
        if !scene.choices.is_empty() && !means_default {
            let reason = scene.choices.get(*key).map_or("", |reason| reason.trim());
            let holds = !reason.is_empty() && !reason.contains('\n');
            let wanted = "one line of reason: the paper leaves this open";
            found.unless(holds, &choice(key), &reason, wanted);
        }
    }
    let value = serde_json::to_value(scene).unwrap_or_default();
    for key in scene.choices.keys() {
        let wanted = "the JSON pointer of a key of this scene";
        found.unless(value.pointer(key).is_some(), &choice(key), key, wanted);
    }
    found.0
}

/// Holds those numbers of a part of the scene that are in a table against it; the part stands under `at`.
fn numbers(at: &str, part: &impl Serialize, table: &[(&str, Range)], found: &mut Findings) {
    let part = serde_json::to_value(part).unwrap_or_default();
    for (key, (holds, wanted)) in table {
        if let Some(number) = part.pointer(key).and_then(Value::as_f64) {
            found.unless(holds(number), &format!("{at}{key}"), &number, wanted);
        }
    }
}

/// The box and what has to be inside it, for which a wrong width is problem enough.
fn inside_box(scene: &Scene, found: &mut Findings) {
    let (width, particles) = (scene.container.width, &scene.particles);
    if found.is_sound("/particles/mean_diameter") {
        let wanted = format!("at most {WIDEST} mean diameters");
        let holds = width <= WIDEST * particles.mean_diameter;
        found.unless(holds, WIDTH, &width, &wanted);
    }
    if !found.is_sound(WIDTH) {
        return;
    }
    let Cloud::JitteredLattice { columns, over, .. } = scene.cloud;
    let [from, to] = over.unwrap_or([0.0, width]);
    let wanted = "two places inside the box, the left one first";
    let holds = 0.0 <= from && from < to && to <= width;
    found.unless(holds, "/cloud/over", &[from, to], wanted);
    let largest = particles.mean_diameter * (1.0 + particles.dispersion);
    let fits = ((to - from) / largest).floor();
    let wanted = format!("at most {fits}, so that the largest grain fits into a cell");
    let holds = f64::from(columns) <= fits || largest <= 0.0;
    found.unless(holds, "/cloud/columns", &columns, &wanted);
    let half = scene.loading.half_width;
    let wanted = "less than half the box's width";
    found.unless(2.0 * half < width, "/loading/half_width", &half, wanted);
    let wanted = "no more than the box's width";
    for (key, length) in [
        ("control_volume_side", scene.measurement.control_volume_side),
        ("local_radius", scene.measurement.local_radius),
    ] {
        let place = format!("/measurement/{key}");
        found.unless(length <= width, &place, &length, wanted);
    }
}

fn loading(scene: &Scene, found: &mut Findings) {
    let loading = &scene.loading;
    if let Some(Material { density, .. }) = loading.material {
        let wanted = "the density of pouring: grains keep their masses";
        let holds = density == scene.material.density;
        found.unless(holds, "/loading/material/density", &density, wanted);
    }
    let height = loading.punch_height;
    let wanted = "a finite number larger than /loading/give_up_depth";
    let holds = height > loading.give_up_depth;
    found.unless(holds, "/loading/punch_height", &height, wanted);
    if let AfterForce::StandStill { seconds } = loading.after_force {
        let place = "/loading/after_force/stand_still/seconds";
        let wanted = format!("at most {MOST_LOADING_STEPS:e} steps");
        let holds = seconds / scene.time_step_seconds() <= MOST_LOADING_STEPS;
        found.unless(holds, place, &seconds, &wanted);
    }
}

fn control_points(scene: &Scene, found: &mut Findings) {
    let points = &scene.control_points;
    let holds = (1..=100).contains(&points.len());
    found.unless(holds, "/control_points", &points.len(), "1 to 100 points");
    for (index, point) in points.iter().enumerate() {
        let at = format!("/control_points/{index}");
        let [offset, name] = ["offset", "name"].map(|key| format!("{at}/{key}"));
        let inside = point.offset.abs() < 0.5 * scene.container.width;
        let holds = inside || !found.is_sound(WIDTH);
        found.unless(holds, &offset, &point.offset, "a place inside the box");
        numbers(&at, point, &[("/depth", POSITIVE)], found);
        found.name(&name, &point.name);
        let twice = points[..index].iter().any(|of| of.name == point.name);
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

/// What follows from several keys must be usable too.
fn derived(scene: &Scene, found: &mut Findings) {
    if !found.0.is_empty() {
        return;
    }
    let radius = 0.5 * scene.particles.mean_diameter;
    let smallest = scene.grain_mass(radius * (1.0 - scene.particles.dispersion));
    let dt = scene.time_step_seconds();
    for (place, what, value) in [
        ("/particles", "mass of the smallest grain", smallest),
        ("/time_step", "time step in seconds", dt),
        ("/loading", "target force 2ap", scene.target_force()),
    ] {
        let wanted = format!("a {what} that is a normal number above 0");
        found.unless(value.is_normal() && value > 0.0, place, &value, &wanted);
    }
    let Cloud::JitteredLattice { spin, .. } = scene.cloud;
    let wanted = "a spin of at most one radian a step";
    found.unless(spin * dt <= 1.0, "/cloud/spin", &spin, wanted);
    for (at, stage) in stages(scene) {
        let place = |key: &str| format!("{at}{key}");
        let normal = stage.material.youngs_modulus * radius;
        let wanted = "a stiffness E·R that is a normal number above 0";
        found.unless(normal.is_normal(), &place("/material"), &normal, wanted);
        let ratio = stage.material.stiffness_ratio;
        let wanted = "a ratio for which k_s = E·R·(k_s/k_n) is a normal number above 0";
        let (holds, key) = ((ratio * normal).is_normal(), "/material/stiffness_ratio");
        found.unless(holds, &place(key), &ratio, wanted);
        if let Viscosity::Dashpot { c_n, .. } = stage.contact.viscosity {
            let wanted = "a dashpot that takes no more than the approach speed of the two lightest grains in a \
                          step: c_n·dt ≤ m_eff";
            let (holds, key) = (c_n * dt <= 0.5 * smallest, "/contact/viscosity/c_n");
            found.unless(holds, &place(key), &c_n, wanted);
        }
    }
    let speed = scene.loading.speed;
    let wanted = format!("a punch that moves at most {LONGEST_STRIDE} mean radii a step");
    let holds = speed * dt <= LONGEST_STRIDE * radius;
    found.unless(holds, "/loading/speed", &speed, &wanted);
    let wanted =
        format!("a punch that reaches /loading/give_up_depth in {MOST_LOADING_STEPS:e} steps");
    let holds = scene.loading.give_up_depth / (speed * dt) <= MOST_LOADING_STEPS;
    found.unless(holds, "/loading/speed", &speed, &wanted);
}
