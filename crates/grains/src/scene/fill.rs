//! What a scene file leaves out: the defaults, which a run's record then states in full.

use serde_json::{Map, Value};

use super::paper_scene::paper_scene;
use super::{Cloud, ControlPoint, Scene, Shape, SurfaceHeight, TimeStep, TorqueArms};

/// What every scene file has to say, by JSON pointer.
const GIVEN: [(&str, &str); 3] = [
    ("/particles", "count"),
    ("/particles", "mean_diameter"),
    ("/box", "width"),
];
/// Of the cloud, over the mean diameter.
const PITCH: f64 = 1.25;

/// The value of a scene file with everything that it leaves out and may leave out.
pub(super) fn filled(given: &Value) -> Value {
    fill(given, &GIVEN)
}

/// The same with what it may not leave out.
pub(super) fn filled_anyway(given: &Value) -> Value {
    fill(given, &[])
}

fn fill(given: &Value, required: &[(&str, &str)]) -> Value {
    let number = |place: &str| given.pointer(place).and_then(Value::as_f64);
    let number = |place: &str| number(place).filter(|value| value.is_finite() && *value > 0.0);
    let diameter = number("/particles/mean_diameter").unwrap_or(0.01);
    let width = number("/box/width").unwrap_or(1.0);
    let dispersion = number("/particles/dispersion").unwrap_or(0.05);
    let scene = defaults(diameter, width, dispersion, given);
    let mut all = scene.json();
    for (place, key) in required {
        let object = all.pointer_mut(place).and_then(Value::as_object_mut);
        object.and_then(|object| object.shift_remove(*key));
    }
    put_over(&mut all, given);
    // Of loading's constants the default is pouring's.
    for key in ["material", "contact", "damping"] {
        if let Some(given) = given.pointer(&format!("/loading/{key}")) {
            let mut of_stage = all[key].clone();
            put_over(&mut of_stage, given);
            all["loading"][key] = of_stage;
        }
    }
    all
}

/// Takes from a schema of whole scenes what it requires and has a default.
pub(super) fn relax(schema: &mut Value) {
    let given = |name: &str| {
        GIVEN
            .iter()
            .any(|(place, key)| *key == name || place[1..] == *name)
    };
    let keep = |object: Option<&mut Value>| {
        let list = object.and_then(|object| object.get_mut("required"));
        if let Some(Value::Array(list)) = list {
            list.retain(|key| key.as_str().is_some_and(given));
        }
    };
    keep(Some(schema));
    for name in [
        "Particles",
        "Material",
        "ContactLaw",
        "Container",
        "Settle",
        "Loading",
        "Measurement",
    ] {
        keep(schema.pointer_mut(&format!("/$defs/{name}")));
    }
    // Of these there is one kind.
    for name in ["Cloud", "Damping"] {
        keep(schema.pointer_mut(&format!("/$defs/{name}/oneOf/0")));
    }
}

/// The paper's scene with its lengths in mean diameters of this one, and no reasons for choices.
fn defaults(diameter: f64, width: f64, dispersion: f64, given: &Value) -> Scene {
    let mut scene = paper_scene(1, 1);
    scene.name = "scene".to_owned();
    scene.choices.clear();
    scene.particles.dispersion = dispersion;
    let end = |at: usize| {
        given
            .pointer(&format!("/cloud/over/{at}"))
            .and_then(Value::as_f64)
    };
    let room = match (end(0), end(1)) {
        (Some(from), Some(to)) => to - from,
        _ => width,
    };
    let Cloud::JitteredLattice { columns, .. } = &mut scene.cloud;
    let pitch = diameter * PITCH.max(1.0 + dispersion);
    *columns = (room / pitch).round().max(1.0) as u32;
    if f64::from(*columns) * diameter * (1.0 + dispersion) > room {
        *columns = (*columns - 1).max(1);
    }
    if let TimeStep::Fraction { of_sqrt_m_over_k } = &mut scene.time_step {
        *of_sqrt_m_over_k /= sticking(given);
    }
    if given.pointer("/box/depth").is_some() {
        scene.particles.shape = Shape::Sphere;
        scene.measurement.surface_height = SurfaceHeight::TwiceCentreOfMass;
    }
    if given.pointer("/contact/springs") == Some(&Value::from("hertz_mindlin")) {
        // As in YADE.
        scene.contact.torque_arms = TorqueArms::ContactPoint;
    }
    scene.loading.half_width = (2.25 * diameter).min(0.25 * width);
    scene.loading.punch_height = 30.0 * diameter;
    scene.loading.give_up_depth = 11.0 * diameter;
    scene.measurement.control_volume_side = (0.5 * diameter).min(width);
    scene.measurement.local_radius = (2.0 * diameter).min(width);
    scene.control_points = vec![ControlPoint {
        name: "O".to_owned(),
        offset: 0.0,
        depth: 11.0 * diameter,
    }];
    scene
}

/// By how much contacts that can stick shorten the largest stable step: √(1 + 1.75 k_s/k_n), to two digits; 1 without friction.
fn sticking(given: &Value) -> f64 {
    let in_stages = |key: &str| {
        ["", "/loading"].map(|at| {
            let value = given.pointer(&format!("{at}/material/{key}"));
            value.and_then(Value::as_f64).unwrap_or(0.0)
        })
    };
    let largest = |key: &str| in_stages(key).into_iter().fold(0.0, f64::max);
    let angles = [
        "friction_angle",
        "wall_friction_angle",
        "punch_friction_angle",
    ]
    .map(largest);
    if angles.iter().all(|angle| *angle <= 0.0) {
        return 1.0;
    }
    let ratio = match largest("stiffness_ratio") {
        0.0 => paper_scene(1, 1).material.stiffness_ratio,
        ratio => ratio,
    };
    (100.0 * (1.0 + 1.75 * ratio).sqrt()).ceil() / 100.0
}

/// Puts what is given over the defaults, key by key; one of another kind than the default replaces it whole.
fn put_over(default: &mut Value, given: &Value) {
    let of_kind = |object: &Map<String, Value>| object.get("kind").cloned();
    match (default, given) {
        (Value::Object(default), Value::Object(given))
            if of_kind(given).is_none() || of_kind(given) == of_kind(default) =>
        {
            for (key, value) in given {
                match default.get_mut(key) {
                    Some(of_key) => put_over(of_key, value),
                    None => drop(default.insert(key.clone(), value.clone())),
                }
            }
        }
        (default, given) => *default = given.clone(),
    }
}
