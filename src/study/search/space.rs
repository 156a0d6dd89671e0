//! The choices that are searched: for each an axis from 0 to 1, and what its values mean in a scene.

use grains::scene::{AfterForce, ControlPoint, Damping, Material, Rotation, Scene, SurfaceHeight};

use crate::study::member::MIRRORED;
use crate::study::realization::{Change, changed, small_scene, whole_scene};

/// A choice that the paper leaves open, or that is doubted.
pub struct Axis {
    /// With its unit after the last comma.
    pub name: &'static str,
    pub scale: Scale,
    /// Whether the answer in a sentence has it.
    pub is_told: bool,
    put: fn(&mut Scene, f64),
}

/// From a coordinate in 0 to 1 to a value.
pub enum Scale {
    Even([f64; 2]),
    PowersOfTen([f64; 2]),
    /// Zero in the first sixth, then even up to this.
    FromZero(f64),
    /// The values of words, which share the axis evenly.
    OneOf(&'static [(&'static str, f64)]),
}

/// Beds differ in the first of [`AXES`], loads on them in the others.
pub const OF_POURING: usize = 7;

const FRICTION: Scale = Scale::FromZero(0.6);
const ALPHA: Scale = Scale::Even([0.1, 0.8]);

/// Table 2 prints φ = 0; its friction is doubted, since with friction in loading the load is borne at millimetres.
pub const AXES: [Axis; 12] = [
    Axis {
        name: "friction in pouring, rad",
        scale: FRICTION,
        is_told: true,
        put: |scene, value| scene.material.friction_angle = value,
    },
    Axis {
        name: "k_s/k_n",
        scale: Scale::Even([0.1, 1.0]),
        is_told: false,
        put: |scene, value| scene.material.stiffness_ratio = value,
    },
    Axis {
        name: "settled at kinetic energy over its peak",
        scale: Scale::PowersOfTen([1.0e-6, 1.0e-2]),
        is_told: false,
        put: |scene, value| scene.settle.kinetic_energy_fraction = value,
    },
    Axis {
        name: "damping α of pouring",
        scale: ALPHA,
        is_told: false,
        put: |scene, alpha| scene.damping = Damping::Cundall { alpha },
    },
    Axis {
        name: "mean diameter, mm",
        scale: Scale::Even([9.0, 10.2]),
        is_told: true,
        put: |scene, value| put(scene, Change::Diameter(1.0e-3 * value)),
    },
    Axis {
        name: "normal stiffness of Eq. 4",
        scale: Scale::OneOf(&[("E·R", 1.0), ("E·D", 2.0)]),
        is_told: false,
        put: |scene, value| put(scene, Change::Modulus(value)),
    },
    Axis {
        name: "friction turns grains",
        scale: Scale::OneOf(&[("yes", 0.0), ("no", 1.0)]),
        is_told: false,
        put: |scene, value| {
            scene.contact.rotation = match value < 0.5 {
                true => Rotation::Free,
                false => Rotation::Blocked,
            };
        },
    },
    Axis {
        name: "friction in loading, rad",
        scale: FRICTION,
        is_told: true,
        put: |scene, value| {
            scene.loading.material = Some(Material {
                friction_angle: value,
                ..scene.material.clone()
            });
        },
    },
    Axis {
        name: "speed of the punch, m/s",
        scale: Scale::PowersOfTen([0.02, 0.2]),
        is_told: true,
        put: |scene, value| scene.loading.speed = value,
    },
    Axis {
        name: "damping α of loading",
        scale: ALPHA,
        is_told: false,
        put: |scene, alpha| scene.loading.damping = Some(Damping::Cundall { alpha }),
    },
    Axis {
        name: "measured",
        scale: Scale::OneOf(&[("at the force", 0.0), ("after 0.05 s at rest", 0.05)]),
        is_told: false,
        put: |scene, seconds| {
            scene.loading.after_force = match seconds > 0.0 {
                true => AfterForce::StandStill { seconds },
                false => AfterForce::MeasureAtOnce,
            };
        },
    },
    Axis {
        name: "depth counted from",
        scale: Scale::OneOf(&[
            ("mean surface", 0.0),
            ("highest grain", 1.0),
            ("twice the centre of mass", 2.0),
        ]),
        is_told: false,
        put: |scene, value| {
            scene.measurement.surface_height = match value {
                ..0.5 => SurfaceHeight::MeanSurface,
                ..1.5 => SurfaceHeight::HighestGrain,
                _ => SurfaceHeight::TwiceCentreOfMass,
            };
        },
    },
];

fn put(scene: &mut Scene, change: Change) {
    *scene = changed(scene.clone(), &[change]);
}

impl Scale {
    pub fn value(&self, at: f64) -> f64 {
        match self {
            Scale::Even([low, high]) => low + at * (high - low),
            Scale::PowersOfTen([low, high]) => low * (high / low).powf(at),
            Scale::FromZero(high) => high * (1.2 * at - 0.2).max(0.0),
            Scale::OneOf(of) => of[level(at, of.len())].1,
        }
    }

    /// For people.
    pub fn words(&self, at: f64) -> String {
        match self {
            Scale::PowersOfTen(_) => format!("{:.2e}", self.value(at)),
            Scale::OneOf(of) => of[level(at, of.len())].0.to_owned(),
            _ => format!("{:.3}", self.value(at)),
        }
    }

    /// The nearest coordinate that there is.
    fn snapped(&self, at: f64) -> f64 {
        match self {
            Scale::FromZero(_) => at.max(1.0 / 6.0),
            Scale::OneOf(of) => (level(at, of.len()) as f64 + 0.5) / of.len() as f64,
            _ => at,
        }
    }
}

fn level(at: f64, levels: usize) -> usize {
    ((at * levels as f64) as usize).min(levels - 1)
}

/// The choices that the answer in a sentence has, at these coordinates.
pub fn told(at: &[f64]) -> String {
    let choices = AXES.iter().zip(at).filter(|(axis, _)| axis.is_told);
    let choices = choices.map(|(axis, at)| {
        let (title, unit) = axis.name.rsplit_once(", ").unwrap_or((axis.name, ""));
        format!("{title} {} {unit}", axis.scale.words(*at))
    });
    choices.collect::<Vec<String>>().join(", ")
}

/// Moves coordinates to those of their settings.
pub fn snap(at: &mut [f64]) {
    for (at, axis) in at.iter_mut().zip(&AXES) {
        *at = axis.scale.snapped(*at);
    }
}

/// The scene at these coordinates.
pub fn scene(base: &Scene, at: &[f64]) -> Scene {
    let mut scene = base.clone();
    for (at, axis) in at.iter().zip(&AXES) {
        (axis.put)(&mut scene, axis.scale.value(*at));
    }
    scene
}

/// dt over √(m/k) of all settings. The default of 0.45 is beyond the largest stable step where grains with friction can turn.
pub const STEP: f64 = 0.3;

/// The paper's scene, or a small one, with A and B on both sides of the punch.
pub fn printed(quick: bool) -> Scene {
    on_both_sides(if quick { small_scene() } else { whole_scene() })
}

/// The same with a step that is stable for all settings.
pub fn base(quick: bool) -> Scene {
    changed(printed(quick), &[Change::Step(STEP)])
}

/// With the points beside the punch on its other side too.
pub fn on_both_sides(mut scene: Scene) -> Scene {
    let aside = scene.control_points.iter().filter(|of| of.offset > 0.0);
    let mirrored = aside.map(|of| ControlPoint {
        name: format!("{MIRRORED}{}", of.name),
        offset: -of.offset,
        ..of.clone()
    });
    let mirrored: Vec<ControlPoint> = mirrored.collect();
    scene.control_points.extend(mirrored);
    scene
}
