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

/// Values that have the right type and cannot be meant.
fn impossible(scene: &Scene) -> Vec<Problem> {
    let mut found = Findings(Vec::new());
    found.name("/name", &scene.name);
    grains(scene, &mut found);
    for (at, stage) in stages(scene) {
        constants(at, &stage, &mut found);
    }
    dynamics(scene, &mut found);
    loading(scene, &mut found);
    measurement(scene, &mut found);
    derived(scene, &mut found);
    for (key, _) in OPEN_CHOICES {
        // A scene that gives no reasons is its own; one of before there was a choice means the default.
        if !scene.choices.is_empty() && (*key != "/contact" || !scene.contact.is_default()) {
            reason(scene, key, &mut found);
        }
    }
    if let Ok(value) = serde_json::to_value(scene) {
        for key in scene.choices.keys() {
            found.unless(
                value.pointer(key).is_some(),
                &format!("/choices/{}", key.replace('/', "~1")),
                key,
                "the JSON pointer of a key of this scene",
            );
        }
    }
    found.0
}

fn grains(scene: &Scene, found: &mut Findings) {
    let particles = &scene.particles;
    found.positive("/particles/mean_diameter", particles.mean_diameter);
    found.below_one("/particles/dispersion", particles.dispersion);
    found.positive(WIDTH, scene.container.width);
    found.unless_by(
        "/particles/mean_diameter",
        scene.container.width <= WIDEST * particles.mean_diameter,
        WIDTH,
        &scene.container.width,
        &format!("at most {WIDEST} mean diameters"),
    );
    let Cloud::JitteredLattice {
        columns,
        jitter,
        speed,
        spin,
        over,
    } = scene.cloud;
    let [from, to] = over.unwrap_or([0.0, scene.container.width]);
    found.unless_by(
        WIDTH,
        0.0 <= from && from < to && to <= scene.container.width,
        "/cloud/over",
        &[from, to],
        "two places inside the box, the left one first",
    );
    found.not_negative("/cloud/spin", spin);
    found.unless(
        (0.0..=1.0).contains(&jitter),
        "/cloud/jitter",
        &jitter,
        "a number in [0, 1]",
    );
    found.not_negative("/cloud/speed", speed);
    let largest = particles.mean_diameter * (1.0 + particles.dispersion);
    let fits = ((to - from) / largest).floor();
    found.unless_by(
        WIDTH,
        f64::from(columns) <= fits || largest <= 0.0,
        "/cloud/columns",
        &columns,
        &format!("at most {fits}, so that the largest grain fits into a cell"),
    );
}

/// The constants of a stage, which stand under `at`.
fn constants(at: &str, stage: &Scene, found: &mut Findings) {
    let place = |key: &str| format!("{at}{key}");
    let material = &stage.material;
    found.positive(&place("/material/youngs_modulus"), material.youngs_modulus);
    found.positive(&place("/material/density"), material.density);
    found.positive(
        &place("/material/stiffness_ratio"),
        material.stiffness_ratio,
    );
    for (key, angle) in [
        ("friction_angle", Some(material.friction_angle)),
        ("wall_friction_angle", material.wall_friction_angle),
        ("punch_friction_angle", material.punch_friction_angle),
    ] {
        found.unless(
            angle.is_none_or(|angle| (0.0..FRAC_PI_2).contains(&angle)),
            &place(&format!("/material/{key}")),
            &angle.unwrap_or_default(),
            "a number in [0, π/2)",
        );
    }
    match stage.contact.viscosity {
        Viscosity::None => {}
        Viscosity::Dashpot { c_n, .. } => found.positive(&place("/contact/viscosity/c_n"), c_n),
        Viscosity::Restitution { e_n, .. } => found.unless(
            e_n > 0.0 && e_n <= 1.0,
            &place("/contact/viscosity/e_n"),
            &e_n,
            "a number in (0, 1]",
        ),
    }
    found.below_one(&place("/damping/alpha"), stage.damping.alpha());
}

/// The stages with constants of their own, and under what these stand.
fn stages(scene: &Scene) -> impl Iterator<Item = (&'static str, Cow<'_, Scene>)> {
    let at = |stage| match stage {
        Stage::Settle => "",
        Stage::Load => "/loading",
    };
    scene
        .stages()
        .map(move |stage| (at(stage), scene.in_stage(stage)))
}

fn reason(scene: &Scene, key: &str, found: &mut Findings) {
    let reason = scene.choices.get(key).map_or("", |reason| reason.trim());
    found.unless(
        !reason.is_empty() && !reason.contains('\n'),
        &format!("/choices/{}", key.replace('/', "~1")),
        &reason,
        "one line of reason: the paper leaves this open",
    );
}

fn dynamics(scene: &Scene, found: &mut Findings) {
    found.not_negative("/gravity", scene.gravity);
    match scene.time_step {
        TimeStep::Absolute { seconds } => found.positive("/time_step/seconds", seconds),
        TimeStep::Fraction { of_sqrt_m_over_k } => {
            found.positive("/time_step/of_sqrt_m_over_k", of_sqrt_m_over_k);
        }
    }
    let fraction = scene.settle.kinetic_energy_fraction;
    found.unless(
        fraction > 0.0 && fraction < 1.0,
        "/settle/kinetic_energy_fraction",
        &fraction,
        "a number in (0, 1)",
    );
}

/// What follows from several keys must be usable too.
fn derived(scene: &Scene, found: &mut Findings) {
    if !found.0.is_empty() {
        return;
    }
    let radius = 0.5 * scene.particles.mean_diameter;
    let smallest = radius * (1.0 - scene.particles.dispersion);
    for (place, what, value) in [
        (
            "/particles",
            "mass of the smallest grain",
            scene.grain_mass(smallest),
        ),
        (
            "/time_step",
            "time step in seconds",
            scene.time_step_seconds(),
        ),
        ("/loading", "target force 2ap", scene.target_force()),
    ] {
        found.unless(
            value.is_normal() && value > 0.0,
            place,
            &value,
            &format!("a {what} that is a normal number above 0"),
        );
    }
    let Cloud::JitteredLattice { spin, .. } = scene.cloud;
    let dt = scene.time_step_seconds();
    found.unless(
        spin * dt <= 1.0,
        "/cloud/spin",
        &spin,
        "a spin of at most one radian a step",
    );
    for (at, stage) in stages(scene) {
        let normal = stage.material.youngs_modulus * radius;
        found.unless(
            normal.is_normal(),
            &format!("{at}/material"),
            &normal,
            "a stiffness E·R that is a normal number above 0",
        );
        found.unless(
            (stage.material.stiffness_ratio * normal).is_normal(),
            &format!("{at}/material/stiffness_ratio"),
            &stage.material.stiffness_ratio,
            "a ratio for which k_s = E·R·(k_s/k_n) is a normal number above 0",
        );
        if let Viscosity::Dashpot { c_n, .. } = stage.contact.viscosity {
            let lightest = 0.5 * scene.grain_mass(smallest);
            found.unless(
                c_n * dt <= lightest,
                &format!("{at}/contact/viscosity/c_n"),
                &c_n,
                "a dashpot that takes no more than the approach speed of the two lightest grains in a \
                 step: c_n·dt ≤ m_eff",
            );
        }
    }
    let stride = scene.loading.speed * scene.time_step_seconds();
    found.unless(
        stride <= LONGEST_STRIDE * radius,
        "/loading/speed",
        &scene.loading.speed,
        &format!("a punch that moves at most {LONGEST_STRIDE} mean radii a step"),
    );
    found.unless(
        scene.loading.give_up_depth / stride <= MOST_LOADING_STEPS,
        "/loading/speed",
        &scene.loading.speed,
        &format!("a punch that reaches /loading/give_up_depth in {MOST_LOADING_STEPS:e} steps"),
    );
}

fn loading(scene: &Scene, found: &mut Findings) {
    let loading = &scene.loading;
    found.positive("/loading/half_width", loading.half_width);
    found.unless_by(
        WIDTH,
        2.0 * loading.half_width < scene.container.width,
        "/loading/half_width",
        &loading.half_width,
        "less than half the box's width",
    );
    found.positive("/loading/pressure", loading.pressure);
    found.positive("/loading/speed", loading.speed);
    found.positive("/loading/give_up_depth", loading.give_up_depth);
    if let Some(material) = &loading.material {
        found.unless(
            material.density == scene.material.density,
            "/loading/material/density",
            &material.density,
            "the density of pouring: grains keep their masses",
        );
    }
    found.unless(
        loading.punch_height.is_finite() && loading.punch_height > loading.give_up_depth,
        "/loading/punch_height",
        &loading.punch_height,
        "a finite number larger than /loading/give_up_depth",
    );
    if let AfterForce::StandStill { seconds } = loading.after_force {
        found.positive("/loading/after_force/stand_still/seconds", seconds);
        found.unless(
            seconds / scene.time_step_seconds() <= MOST_LOADING_STEPS,
            "/loading/after_force/stand_still/seconds",
            &seconds,
            &format!("at most {MOST_LOADING_STEPS:e} steps"),
        );
    }
}

fn measurement(scene: &Scene, found: &mut Findings) {
    let measurement = &scene.measurement;
    for (place, length) in [
        (
            "/measurement/control_volume_side",
            measurement.control_volume_side,
        ),
        ("/measurement/local_radius", measurement.local_radius),
    ] {
        found.positive(place, length);
        found.unless_by(
            WIDTH,
            length <= scene.container.width,
            place,
            &length,
            "no more than the box's width",
        );
    }
    found.unless(
        (1..=100).contains(&scene.control_points.len()),
        "/control_points",
        &scene.control_points.len(),
        "1 to 100 points",
    );
    for (index, point) in scene.control_points.iter().enumerate() {
        let place = format!("/control_points/{index}");
        found.unless_by(
            WIDTH,
            point.offset.is_finite() && point.offset.abs() < 0.5 * scene.container.width,
            &format!("{place}/offset"),
            &point.offset,
            "a place inside the box",
        );
        found.positive(&format!("{place}/depth"), point.depth);
        found.name(&format!("{place}/name"), &point.name);
        let twice = scene.control_points[..index]
            .iter()
            .any(|other| other.name == point.name);
        found.unless(
            !twice,
            &format!("{place}/name"),
            &point.name,
            "a name of its own",
        );
    }
}
