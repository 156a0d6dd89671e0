//! The verification suite: small experiments with known answers, run by any engine and judged by the same code.
//!
//! A group of cases has experiments; each is some cases with a judge that turns their tracks into checks. A judge reads
//! snapshots only and never knows which engine made them.

pub mod analytic;
pub mod card;
mod collisions;
pub mod conformance;
mod conservation;
pub mod cross_code;
pub mod detection;
mod drops;
mod exact;
mod oscillators;
pub mod parameters;
mod rolling;
pub mod run;
mod sliding;
pub(crate) mod spheres;
mod statics;
mod symmetry;

use std::f64::consts::PI;

use serde::Serialize;

use crate::checks::{Check, Outcome};
use grains::model::{Axis, Law, Model, Wall};
use grains::rules::Rules;
use grains::scene::{ContactLaw, SlipVelocity, TorqueArms, Viscosity};
use grains::tables::{Bodies, Contact, Punch, Snapshot};
use grains::task::Case;

/// The states of a case at its moments.
pub type Track = Vec<Snapshot>;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Evidence {
    /// A solution in closed form.
    Exact,
    /// The same experiment seen in another way.
    Symmetry,
    /// One engine against another, bit by bit.
    CrossCode,
    /// Against higher precision.
    Precision,
    /// That the suite itself can fail.
    Detection,
}

/// How the tracks of an experiment's cases are judged.
type Judge = Box<dyn Fn(&[Track], &mut Figures) + Send + Sync>;

/// Cases that one engine can run alone, and what their tracks must show.
pub struct CaseGroup {
    /// Lasting and unique, in kebab-case.
    pub id: &'static str,
    pub title: &'static str,
    pub evidence: Evidence,
    pub cases: Vec<Case>,
    /// Judges, each with what the ids of its checks begin with and the number of cases that are its own.
    judges: Vec<(String, usize, Judge)>,
}

impl CaseGroup {
    /// A group of closed forms without experiments.
    pub fn new(id: &'static str, title: &'static str) -> Self {
        CaseGroup {
            id,
            title,
            evidence: Evidence::Exact,
            cases: Vec::new(),
            judges: Vec::new(),
        }
    }

    /// Adds an experiment of one case. The ids of its checks begin with this one, which may be empty.
    #[must_use]
    pub fn with(
        self,
        id: impl Into<String>,
        case: Case,
        judge: impl Fn(&Track, &mut Figures) + Send + Sync + 'static,
    ) -> Self {
        self.with_all(id, [case], move |tracks, figures| {
            judge(&tracks[0], figures)
        })
    }

    /// Adds an experiment of some cases.
    #[must_use]
    pub fn with_all<const N: usize>(
        mut self,
        id: impl Into<String>,
        cases: [Case; N],
        judge: impl Fn(&[Track], &mut Figures) + Send + Sync + 'static,
    ) -> Self {
        self.cases.extend(cases);
        self.judges.push((id.into(), N, Box::new(judge)));
        self
    }

    /// What the tracks show, in the order of the cases; nothing if one is missing.
    pub fn judge(&self, tracks: &[Track]) -> Vec<Check> {
        if tracks.len() != self.cases.len() {
            return Vec::new();
        }
        let mut rest = tracks;
        let mut figures = Figures::default();
        for (id, count, judge) in &self.judges {
            let (own, others) = rest.split_at(*count);
            figures.case(id);
            judge(own, &mut figures);
            rest = others;
        }
        figures.done()
    }
}

/// All groups, those of spheres as an engine with these rules has them.
pub fn groups(rules: Rules) -> Vec<CaseGroup> {
    let parts = [
        collisions::groups(),
        drops::groups(),
        sliding::groups(),
        oscillators::groups(),
        rolling::groups(),
        conservation::groups(),
        statics::groups(),
        symmetry::groups(),
        spheres::groups(rules),
        cross_code::recorded(),
    ];
    parts.into_iter().flatten().collect()
}

/// Passed if there are checks and all hold.
pub fn outcome(checks: &[Check]) -> Outcome {
    let holds = |check: &Check| check.outcome == Outcome::Pass;
    Outcome::pass_if(!checks.is_empty() && checks.iter().all(holds))
}

/// The checks of experiments. One rule for all: |value − expected| ≤ tolerance, and what is no number fails.
#[derive(Default)]
pub struct Figures {
    case: String,
    basis: &'static str,
    checks: Vec<Check>,
}

impl Figures {
    /// The checks that follow are of a case with this id, which may be empty.
    pub fn case(&mut self, id: impl Into<String>) {
        self.case = id.into();
        self.basis = "";
    }

    /// Where the tolerances of the checks that follow come from.
    pub fn because(&mut self, basis: &'static str) {
        self.basis = basis;
    }

    /// Adds a check. `what` is `id, unit`, or `id: words, unit` where the id does not say it.
    pub fn is(&mut self, what: &str, value: f64, expected: f64, tolerance: f64) {
        let (what, unit) = what.rsplit_once(", ").unwrap_or((what, "1"));
        let (id, words) = match what.split_once(": ") {
            Some((id, words)) => (id, words.to_owned()),
            None => (what, what.replace('-', " ")),
        };
        let (id, words) = match self.case.as_str() {
            "" => (id.to_owned(), words),
            case => (
                format!("{case}/{id}"),
                format!("{words}, {}", case.replace('-', " ")),
            ),
        };
        let outcome = Outcome::pass_if((value - expected).abs() <= tolerance);
        let check = Check::of_words(id, &words, outcome, "");
        let mut check = check.with_limits(value, expected, Some(tolerance));
        unit.clone_into(&mut check.unit);
        self.basis.clone_into(&mut check.basis);
        self.checks.push(check);
    }

    /// Adds a check that only rounding over so many steps may move, in a number of this size.
    pub fn exact(&mut self, what: &str, value: f64, expected: f64, steps: u64, size: f64) {
        self.basis = "exact but for rounding: eight roundings a step of half a unit in the last place, added up";
        self.is(what, value, expected, rounding(steps, size));
    }

    pub fn done(self) -> Vec<Check> {
        self.checks
    }
}

/// What so many steps of rounding may add up to in a number of this size. A step rounds the overlap,
/// the force, the acceleration, the velocity and the position, some of them twice.
fn rounding(steps: u64, size: f64) -> f64 {
    8.0 * 0.5 * f64::EPSILON * steps as f64 * size
}

/// One moment of a track. What is not there reads as not a number, which no check takes for right.
#[derive(Clone, Copy)]
struct View<'a>(Option<&'a Snapshot>);

fn at(track: &Track, step: u64) -> View<'_> {
    View(track.iter().find(|snapshot| snapshot.step == step))
}

impl<'a> View<'a> {
    /// Centre of a grain, m.
    fn position(self, id: usize) -> [f64; 2] {
        self.pair(id, |bodies| [&bodies.x, &bodies.z])
    }

    /// Velocity of a grain at the half step before, m/s.
    fn velocity(self, id: usize) -> [f64; 2] {
        self.pair(id, |bodies| [&bodies.vx, &bodies.vz])
    }

    /// Spin of a grain at the half step before, rad/s.
    fn spin(self, id: usize) -> f64 {
        self.pair(id, |bodies| [&bodies.spin, &bodies.spin])[0]
    }

    /// A number of the contact with the lowest ids.
    fn contact(self, number: fn(&Contact) -> f64) -> f64 {
        let contact = self.0.and_then(|snapshot| snapshot.contacts.first());
        contact.map_or(f64::NAN, number)
    }

    fn pair(self, id: usize, columns: fn(&'a Bodies) -> [&'a Vec<f64>; 2]) -> [f64; 2] {
        self.0.map_or([f64::NAN; 2], |snapshot| {
            columns(&snapshot.bodies).map(|column| column.get(id).copied().unwrap_or(f64::NAN))
        })
    }
}

/// The value that is furthest from this one; not a number if one of them is none.
fn furthest(from: f64, values: impl IntoIterator<Item = f64>) -> f64 {
    let off = |value: f64| (value - from).abs();
    let nearer = |worst: f64, value: f64| worst.is_nan() || off(value) <= off(worst);
    let further = |worst, value| if nearer(worst, value) { worst } else { value };
    values.into_iter().fold(from, further)
}

/// One grain at the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grain {
    /// Centre, m.
    pub position: [f64; 2],
    /// At the half step before the start, m/s.
    pub velocity: [f64; 2],
    /// rad/s, positive from z towards x.
    pub spin: f64,
    /// m.
    pub radius: f64,
    /// kg.
    pub mass: f64,
    /// kg·m².
    pub inertia: f64,
}

impl Grain {
    /// A disc one metre long of this density, at rest: m = ρπR², I = ½mR².
    pub fn disc(position: [f64; 2], radius: f64, density: f64) -> Self {
        let mass = density * PI * radius * radius;
        Grain {
            position,
            velocity: [0.0; 2],
            spin: 0.0,
            radius,
            mass,
            inertia: 0.5 * mass * radius * radius,
        }
    }

    /// A sphere of this density, at rest: m = ρ·4/3·πR³, I = 2/5 mR².
    pub fn sphere(position: [f64; 2], radius: f64, density: f64) -> Self {
        let mass = density * (4.0 / 3.0) * PI * radius * radius * radius;
        Grain {
            mass,
            inertia: 0.4 * mass * radius * radius,
            ..Grain::disc(position, radius, density)
        }
    }

    /// The same grain with its centre here, m.
    pub fn at(self, position: [f64; 2]) -> Self {
        Grain { position, ..self }
    }

    /// The same grain with this velocity, m/s.
    pub fn moving(self, velocity: [f64; 2]) -> Self {
        Grain { velocity, ..self }
    }

    /// The same grain with this spin, rad/s.
    pub fn spinning(self, spin: f64) -> Self {
        Grain { spin, ..self }
    }
}

/// A law with normal springs only.
pub fn springs(modulus: f64) -> Law {
    Law {
        modulus,
        stiffness_ratio: 1.0,
        friction_angle: 0.0,
        wall_friction_angle: None,
        punch_friction_angle: None,
        poissons_ratio: None,
        materials: Vec::new(),
        contact: ContactLaw::default(),
    }
}

/// A law with springs and friction of this angle (rad) and stiffness ratio k_s/k_n, grains free to spin,
/// YADE's default choices.
pub fn friction(modulus: f64, stiffness_ratio: f64, friction_angle: f64) -> Law {
    Law {
        stiffness_ratio,
        friction_angle,
        ..springs(modulus)
    }
}

/// The same law with slip and torque arms at the contact point.
pub fn at_contact_point(mut law: Law) -> Law {
    law.contact.slip_velocity = SlipVelocity::ContactPoint;
    law.contact.torque_arms = TorqueArms::ContactPoint;
    law
}

/// The same law with these dashpots, slip and torque arms at the contact point: the form that YADE's viscous law has.
pub fn with_viscosity(law: Law, viscosity: Viscosity) -> Law {
    let mut law = at_contact_point(law);
    law.contact.viscosity = viscosity;
    law
}

/// A model without gravity, local damping and walls.
pub fn model(law: Law, dt: f64) -> Model {
    world(law, dt, [0.0; 2], 0.0, [&[], &[]])
}

/// A wall that holds this coordinate fixed at this place, m.
pub fn wall(axis: Axis, place: f64) -> Wall {
    Wall::at(axis, place)
}

/// The same under this gravity, with this α, and with walls that hold x and z at these places, m.
pub fn world(law: Law, dt: f64, gravity: [f64; 2], alpha: f64, [x, z]: [&[f64]; 2]) -> Model {
    let across = x.iter().map(|place| Wall::at(Axis::X, *place));
    let up = z.iter().map(|place| Wall::at(Axis::Z, *place));
    Model {
        gravity,
        alpha,
        dt,
        walls: across.chain(up).collect(),
        obstacles: Vec::new(),
        law,
        rules: Rules::default(),
    }
}

pub fn case(name: &str, model: Model, grains: &[Grain], moments: Vec<u64>) -> Case {
    let mut bodies = Bodies::default();
    let rotates = model.law.rotates();
    for grain in grains {
        bodies.push(grain.position, grain.velocity, grain.radius, grain.mass);
        if rotates {
            bodies.spin.push(grain.spin);
            bodies.inertia.push(grain.inertia);
        }
    }
    Case::new(name, model, bodies, moments)
}

/// A punch with its bottom at this height, moving at this vertical velocity.
pub fn punch(axis: f64, bottom: f64, half_extents: [f64; 2], velocity: f64) -> Punch {
    Punch {
        centre: [axis, bottom + half_extents[1]],
        half_extents,
        start: bottom,
        velocity,
        force: 0.0,
    }
}
