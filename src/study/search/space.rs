//! The choices that are searched: for each an axis from 0 to 1, and what its values mean in a scene.

use grains::scene::{ControlPoint, Scene};

use crate::document::rounded;
use crate::study::change::{What, changed};
use crate::study::member::MIRRORED;
use crate::study::realization::{small_scene, whole_scene};

/// A choice that the paper leaves open, or that is doubted.
pub struct Axis {
    /// With its unit after the last comma.
    pub name: &'static str,
    /// What a value of it changes.
    change: What,
    pub scale: Scale,
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

/// The choices of [`AXES`] that the answer in a sentence has: both frictions, the diameter and the punch's speed.
const TOLD: [usize; 4] = [0, 4, 7, 8];

/// Of [`AXES`].
pub const LOADING_FRICTION: usize = 7;
pub const PUNCH_SPEED: usize = 8;

/// Beds differ in the first of [`AXES`], loads on them in the others.
pub const OF_POURING: usize = 7;

const FRICTION: Scale = Scale::FromZero(0.6);
const REST: Scale = Scale::PowersOfTen([1.0e-6, 1.0e-2]);
const ALPHA: Scale = Scale::Even([0.1, 0.8]);
const STIFFNESS: Scale = Scale::OneOf(&[("E·R", 1.0), ("E·D", 2.0)]);
const TURNS: Scale = Scale::OneOf(&[("yes", 0.0), ("no", 1.0)]);
const SPEED: Scale = Scale::PowersOfTen([0.02, 0.2]);
const MEASURED: Scale = Scale::OneOf(&[("at the force", 0.0), ("after 0.05 s at rest", 0.05)]);
const SURFACE: Scale = Scale::OneOf(&[
    ("mean surface", 0.0),
    ("highest grain", 1.0),
    ("twice the centre of mass", 2.0),
]);

const fn axis(name: &'static str, change: What, scale: Scale) -> Axis {
    Axis {
        name,
        change,
        scale,
    }
}

/// Table 2 prints φ = 0; its friction is doubted, since with friction in loading the load is borne at millimetres.
pub const AXES: [Axis; 12] = [
    axis("friction in pouring, rad", What::Friction, FRICTION),
    axis("k_s/k_n", What::StiffnessRatio, Scale::Even([0.1, 1.0])),
    axis(
        "settled at kinetic energy over its peak",
        What::Settled,
        REST,
    ),
    axis("damping α of pouring", What::Alpha, ALPHA),
    axis(
        "mean diameter, mm",
        What::Diameter,
        Scale::Even([9.0, 10.2]),
    ),
    axis("normal stiffness of Eq. 4", What::Modulus, STIFFNESS),
    axis("friction turns grains", What::Blocked, TURNS),
    axis(
        "friction in loading, rad",
        What::FrictionInLoading,
        FRICTION,
    ),
    axis("speed of the punch, m/s", What::PunchSpeed, SPEED),
    axis("damping α of loading", What::AlphaInLoading, ALPHA),
    axis("measured", What::Hold, MEASURED),
    axis("depth counted from", What::Surface, SURFACE),
];

impl Scale {
    pub fn value(&self, at: f64) -> f64 {
        match self {
            Scale::Even([low, high]) => low + at * (high - low),
            Scale::PowersOfTen([low, high]) => low * (high / low).powf(at),
            Scale::FromZero(high) => high * self.shown(at),
            Scale::OneOf(choices) => choices[level(at, choices.len())].1,
        }
    }

    /// For people.
    pub fn words(&self, at: f64) -> String {
        match self {
            Scale::PowersOfTen(_) => format!("{:.2e}", self.value(at)),
            Scale::OneOf(choices) => choices[level(at, choices.len())].0.to_owned(),
            _ => format!("{:.3}", self.value(at)),
        }
    }

    /// Places on the axis and what stands there: its ends, or its words.
    pub fn ticks(&self) -> Vec<(f64, String)> {
        let words = |at: f64| rounded(self.value(at), 3);
        match self {
            Scale::OneOf(choices) => {
                let all = choices.iter().zip(0..);
                let place = |at: u32| (f64::from(at) + 0.5) / choices.len() as f64;
                all.map(|((words, _), at)| (place(at), (*words).to_owned()))
                    .collect()
            }
            _ => [0.0, 1.0].map(|at| (at, words(at))).to_vec(),
        }
    }

    /// Where it is drawn, from 0 to 1: a zero that takes a sixth has no width.
    pub fn shown(&self, at: f64) -> f64 {
        match self {
            Scale::FromZero(_) => (1.2 * at - 0.2).max(0.0),
            _ => at,
        }
    }

    /// The part of the axis that stands for a bin of so many.
    pub fn part(&self, bin: usize, bins: usize) -> [f64; 2] {
        let (bin, bins) = match self {
            Scale::OneOf(words) => {
                let middle = (bin as f64 + 0.5) / bins as f64;
                (level(middle, words.len()), words.len())
            }
            _ => (bin, bins),
        };
        [bin, bin + 1].map(|end| end as f64 / bins as f64)
    }

    /// What the values of such parts are, from the least to the largest.
    pub fn told(&self, parts: &[[f64; 2]]) -> String {
        match self {
            Scale::OneOf(_) => {
                let words = parts
                    .iter()
                    .map(|[low, high]| self.words(0.5 * (low + high)));
                words.collect::<Vec<_>>().join(" or ")
            }
            _ => {
                let low = parts.first().map_or(0.0, |part| part[0]);
                let high = parts.last().map_or(1.0, |part| part[1]);
                let [low, high] = [low, high].map(|at| rounded(self.value(at), 3));
                if low == high {
                    low
                } else {
                    format!("{low} to {high}")
                }
            }
        }
    }

    /// The nearest coordinate that there is.
    fn snapped(&self, at: f64) -> f64 {
        match self {
            Scale::FromZero(_) => at.max(1.0 / 6.0),
            Scale::OneOf(choices) => (level(at, choices.len()) as f64 + 0.5) / choices.len() as f64,
            _ => at,
        }
    }
}

fn level(at: f64, levels: usize) -> usize {
    ((at * levels as f64) as usize).min(levels - 1)
}

/// Title and unit.
pub fn split(name: &str) -> (&str, &str) {
    name.rsplit_once(", ").unwrap_or((name, ""))
}

/// The choices that the answer in a sentence has, at these coordinates.
pub fn told(at: &[f64]) -> String {
    let choices = TOLD.map(|index| {
        let Axis { name, scale, .. } = &AXES[index];
        let (title, unit) = split(name);
        format!("{title} {} {unit}", scale.words(at[index]))
    });
    choices.join(", ")
}

/// Moves coordinates to those of their settings.
pub fn snap(at: &mut [f64]) {
    for (at, axis) in at.iter_mut().zip(&AXES) {
        *at = axis.scale.snapped(*at);
    }
}

/// The scene at these coordinates.
pub fn scene(base: &Scene, at: &[f64]) -> Scene {
    let changes = at.iter().zip(&AXES);
    let changes = changes.map(|(at, axis)| (axis.change, axis.scale.value(*at)));
    changed(base.clone(), &changes.collect::<Vec<_>>())
}

/// dt over √(m/k) of all settings. The default of 0.45 is beyond the largest stable step where grains with friction can turn.
pub const STEP: f64 = 0.3;

/// The paper's scene, or a small one, with A and B on both sides of the punch.
pub fn printed(quick: bool) -> Scene {
    on_both_sides(if quick { small_scene() } else { whole_scene() })
}

/// The same with a step that is stable for all settings.
pub fn base(quick: bool) -> Scene {
    changed(printed(quick), &[(What::Step, STEP)])
}

/// With the points beside the punch on its other side too.
pub fn on_both_sides(mut scene: Scene) -> Scene {
    let aside = scene
        .control_points
        .iter()
        .filter(|point| point.offset > 0.0);
    let mirrored = aside.map(|point| ControlPoint {
        name: format!("{MIRRORED}{}", point.name),
        offset: -point.offset,
        ..point.clone()
    });
    let mirrored: Vec<ControlPoint> = mirrored.collect();
    scene.control_points.extend(mirrored);
    scene
}
