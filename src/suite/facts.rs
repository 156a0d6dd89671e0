//! Facts of a scene: the parameters that an engine says it uses, for each kind of contact, asked of a
//! few grains that touch each other, a wall and the punch.

use serde::Serialize;

use super::build::{Grain, case, punch};
use super::{Line, trajectories};
use crate::compare::Verdict;
use crate::engine::yade::{self, YadeError};
use grains::case::{Case, Effective};
use grains::model::Model;
use grains::native::{self, CaseOptions, NativeError};
use grains::scene::{Scene, paper_scene};

/// The most that two engines' facts may differ, relative.
pub const TOLERANCE: f64 = 1.0e-14;

/// One parameter as an engine uses it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fact {
    /// Between what, or of what.
    pub of: String,
    /// Its symbol.
    pub symbol: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Its value.
    pub value: f64,
}

/// A fact in both engines.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FactPair {
    /// As the native engine uses it.
    pub native: Fact,
    /// In YADE; none if YADE does not tell it.
    pub yade: Option<f64>,
    /// |native − YADE| over the larger of the two; none if there is none in YADE.
    pub difference: Option<f64>,
}

impl FactPair {
    /// Whether the two are equal to [`TOLERANCE`].
    pub fn agrees(&self) -> bool {
        self.difference
            .is_some_and(|difference| difference <= TOLERANCE)
    }
}

/// Grains of the smallest, the mean and the largest size that touch each other, the left wall and the
/// punch, in the scene's model.
pub fn probe(scene: &Scene) -> Case {
    let mean = 0.5 * scene.particles.mean_diameter;
    let [small, large] = [-1.0, 1.0].map(|sign| mean * (1.0 + sign * scene.particles.dispersion));
    let grain = |position: [f64; 2], radius: f64| {
        let mass = scene.grain_mass(radius);
        Grain {
            position,
            velocity: [0.0; 2],
            spin: 0.0,
            radius,
            mass,
            inertia: scene.grain_inertia(radius, mass),
        }
    };
    // Touching by a hundredth of a radius, floors of four radii apart.
    let floor = |index: usize| (4.0 * index as f64 + 3.0) * large;
    let touch = 0.99;
    let mut grains = Vec::new();
    for (index, radius) in [small, mean, large].into_iter().enumerate() {
        grains.push(grain([touch * radius, floor(index)], radius));
    }
    for (index, (low, high)) in [(small, large), (mean, mean), (large, large)]
        .into_iter()
        .enumerate()
    {
        let (x, z) = (scene.punch_axis(), floor(3 + 2 * index));
        grains.push(grain([x, z], low));
        grains.push(grain([x, z + touch * (low + high)], high));
    }
    let bottom = floor(10);
    let below = [scene.punch_axis(), bottom - touch * mean];
    grains.push(grain(below, mean));
    let half_extents = [scene.loading.half_width, 0.5 * scene.loading.punch_height];
    let mut case = case("facts", Model::of(scene), &grains, vec![0]);
    case.punch = Some(punch(
        scene.punch_axis(),
        bottom,
        half_extents,
        -scene.loading.speed,
    ));
    case
}

/// What the native engine uses.
pub fn of_native(scene: &Scene) -> Result<Vec<Fact>, NativeError> {
    let case = probe(scene);
    Ok(in_words(&case, &native::effective(&case, None)?))
}

/// What YADE says it uses; `work` is an empty folder.
pub fn of_yade(
    scene: &Scene,
    options: &yade::Options,
    work: &std::path::Path,
) -> Result<Vec<Fact>, YadeError> {
    let case = probe(scene);
    let run = yade::run_cases(&[&case], options, work, &mut ())?;
    Ok(run
        .cases
        .first()
        .map(|of| in_words(&case, &of.effective))
        .unwrap_or_default())
}

/// The scenes whose facts the ladder compares: the paper's, and the same with friction and dashpots.
pub fn scenes() -> [(&'static str, Scene); 3] {
    [
        ("paper", paper_scene(1, 5000)),
        ("friction", trajectories::rough(5000)),
        ("dashpot", trajectories::viscous(5000)),
    ]
}

/// A scene's probe, and what YADE says of it.
#[derive(Debug, Clone)]
pub struct Answer {
    /// The scene's name.
    pub name: &'static str,
    /// The grains that were asked of.
    pub probe: Case,
    /// What YADE says.
    pub yade: Effective,
}

/// A line for each scene, from the native engine with these options against YADE's answers.
pub fn lines(
    answers: &[Answer],
    options: impl Into<CaseOptions>,
) -> Result<Vec<Line>, NativeError> {
    let options = options.into();
    let of = |answer: &Answer| {
        let native = native::effective(&answer.probe, options)?;
        Ok(line(answer.name, &native, &answer.yade, &answer.probe))
    };
    answers.iter().map(of).collect()
}

/// A line for a scene: the largest relative difference of its facts.
fn line(name: &str, native: &Effective, yade: &Effective, case: &Case) -> Line {
    let pairs = side_by_side(in_words(case, native), &in_words(case, yade));
    let largest = pairs
        .iter()
        .map(|pair| pair.difference.unwrap_or(f64::INFINITY))
        .fold(0.0, f64::max);
    Line {
        quantity: format!(
            "{name} scene: largest relative difference of {} facts",
            pairs.len()
        ),
        unit: "1".to_owned(),
        value: largest,
        expected: 0.0,
        tolerance: TOLERANCE,
        basis: "the same formulas of the same numbers".to_owned(),
    }
}

/// The facts of both, side by side.
pub fn side_by_side(native: Vec<Fact>, yade: &[Fact]) -> Vec<FactPair> {
    native
        .into_iter()
        .map(|fact| {
            let same = |other: &&Fact| other.of == fact.of && other.symbol == fact.symbol;
            let yade = yade.iter().find(same).map(|other| other.value);
            let difference = yade.map(|yade| relative(fact.value, yade));
            FactPair {
                native: fact,
                yade,
                difference,
            }
        })
        .collect()
}

/// Passed if all facts agree; none if there are none.
pub fn verdict(pairs: &[FactPair]) -> Option<Verdict> {
    let agree = pairs.iter().all(FactPair::agrees);
    let verdict = if agree { Verdict::Pass } else { Verdict::Fail };
    (!pairs.is_empty()).then_some(verdict)
}

fn relative(a: f64, b: f64) -> f64 {
    if a == b {
        0.0
    } else {
        (a - b).abs() / a.abs().max(b.abs())
    }
}

fn in_words(case: &Case, effective: &Effective) -> Vec<Fact> {
    let fact = |of: &str, symbol, unit, value| Fact {
        of: of.to_owned(),
        symbol,
        unit,
        value,
    };
    let radius = |id: u32| case.bodies.radius.get(id as usize).copied();
    let millimetres = |radius: Option<f64>| format!("{:.4} mm", 1e3 * radius.unwrap_or(f64::NAN));
    let walls = case.bodies.len()..case.bodies.len() + case.model.walls.len();
    let mut facts = vec![
        fact("everything", "dt", "s", effective.dt),
        fact("everything", "alpha", "1", effective.alpha),
        fact("everything", "g_x", "m/s²", effective.gravity[0]),
        fact("everything", "g_z", "m/s²", effective.gravity[1]),
    ];
    for (id, mass) in effective.mass.iter().enumerate() {
        let of = format!("grain {id}, R {}", millimetres(radius(id as u32)));
        facts.push(fact(&of, "m", "kg", *mass));
        if let Some(inertia) = effective.inertia.get(id) {
            facts.push(fact(&of, "I", "kg·m²", *inertia));
        }
    }
    let mut contacts = effective.contacts.clone();
    contacts.sort_by_key(|contact| (contact.id1, contact.id2));
    for contact in contacts {
        let other = match contact.id1 as usize {
            id if id < walls.start => format!("grain {id}, R {}", millimetres(radius(contact.id1))),
            id if walls.contains(&id) => format!("wall {}", id - walls.start),
            _ => "punch".to_owned(),
        };
        let of = format!(
            "{other}, and grain {}, R {}",
            contact.id2,
            millimetres(radius(contact.id2))
        );
        facts.push(fact(&of, "k_n", "N/m", contact.k_n));
        if let Some(k_s) = contact.k_s {
            facts.push(fact(&of, "k_s", "N/m", k_s));
            facts.push(fact(&of, "tan_phi", "1", contact.tan_phi));
        }
        facts.push(fact(&of, "c_n", "N·s/m", contact.c_n));
    }
    facts
}
