//! What another engine may have otherwise than the model: constants that are a little larger, terms of another form, keys that it
//! does not read.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::constant::Constant;
use crate::model::Model;
use crate::native::first_contact_punch;
use crate::reference::Reference;
use crate::rules::Choice;
use crate::scene::{Viscosity, paper_scene};
use crate::tables::{Bodies, Body, Snapshot};
use crate::task::Case;

/// A key of a job that an engine may leave unread: it computes with the paper's value then, whatever it is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Key {
    Gravity,
    Damping,
    TimeStep,
    Modulus,
    StiffnessRatio,
    Friction,
    WallFriction,
    PunchFriction,
    Dashpots,
    PunchSpeed,
    PunchSize,
    Mass,
    Inertia,
}

/// The friction angle of an engine that reads none, rad.
const USUAL_FRICTION: f64 = 0.5;

impl Key {
    /// All of them, with where they stand in a job.
    pub const NAMES: [(Key, &str); 13] = [
        (Key::Gravity, "model.gravity"),
        (Key::Damping, "model.alpha"),
        (Key::TimeStep, "model.dt"),
        (Key::Modulus, "law.modulus"),
        (Key::StiffnessRatio, "law.stiffness_ratio"),
        (Key::Friction, "law.friction_angle"),
        (Key::WallFriction, "law.wall_friction_angle"),
        (Key::PunchFriction, "law.punch_friction_angle"),
        (Key::Dashpots, "law.contact.viscosity"),
        (Key::PunchSpeed, "punch.velocity"),
        (Key::PunchSize, "punch.half_extents"),
        (Key::Mass, "mass in initial.csv"),
        (Key::Inertia, "inertia in initial.csv"),
    ];

    /// Where it stands in a job.
    pub fn name(self) -> &'static str {
        Key::NAMES[self as usize].1
    }

    /// The case as an engine sees it that does not read this key; none where it sees no other.
    pub fn unread(self, case: &Case) -> Option<Case> {
        let usual = &paper_scene(1, 1);
        let (usual_model, usual_punch) = (
            Model::of(usual),
            first_contact_punch(usual, &Bodies::default()),
        );
        let mut seen = case.clone();
        let (model, bodies) = (&mut seen.model, &mut seen.bodies);
        match self {
            Key::Gravity => model.gravity = usual_model.gravity,
            Key::Damping => model.alpha = usual_model.alpha,
            Key::TimeStep => model.dt = usual_model.dt,
            Key::Modulus => model.law.modulus = usual_model.law.modulus,
            Key::StiffnessRatio => model.law.stiffness_ratio = usual_model.law.stiffness_ratio,
            Key::Friction => model.law.friction_angle = USUAL_FRICTION,
            Key::WallFriction => model.law.wall_friction_angle = None,
            Key::PunchFriction => model.law.punch_friction_angle = None,
            Key::Dashpots => model.law.contact.viscosity = Viscosity::None,
            Key::PunchSpeed => {
                let punch = seen.punch.as_mut()?;
                punch.velocity = usual_punch.velocity;
            }
            Key::PunchSize => {
                let punch = seen.punch.as_mut()?;
                punch.half_extents = usual_punch.half_extents;
            }
            Key::Mass => {
                let grains = bodies.mass.iter_mut().zip(&bodies.radius);
                grains.for_each(|(mass, radius)| *mass = usual.grain_mass(*radius));
            }
            Key::Inertia => {
                let grains = bodies
                    .inertia
                    .iter_mut()
                    .zip(&bodies.radius)
                    .zip(&bodies.mass);
                grains.for_each(|((inertia, radius), mass)| {
                    *inertia = usual.grain_inertia(*radius, *mass);
                });
            }
        }
        // Friction where there was none would be another law.
        let same_terms = seen.model.law.has_friction() == case.model.law.has_friction();
        (seen != *case && same_terms).then_some(seen)
    }
}

/// What a contact's formulas take of both its bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Input {
    /// The radii of which springs are made, and that along the tangent alone.
    StiffnessRadii,
    TangentialRadii,
    /// The materials of which the spring along the normal, or along the tangent, is made.
    NormalMaterials,
    TangentialMaterials,
    /// The masses of which the effective mass is made.
    Masses,
    /// The friction angles of two materials.
    FrictionAngles,
    /// The radii in the limit of the moment against rolling.
    RollingRadii,
    /// The radii in slips and torques.
    SlipRadii,
    TorqueArms,
    /// One number of the materials, in one spring.
    NormalModuli,
    NormalPoissons,
    TangentialModuli,
    TangentialPoissons,
    /// The radii in the pull of adhesion.
    AdhesionRadii,
    /// The masses in the dashpot along the normal, or along the tangent.
    NormalMasses,
    TangentialMasses,
}

/// Where another input is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Alone {
    Everywhere,
    BetweenGrains,
    AtObstacles,
}

/// Whose value an engine takes for both bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Whose {
    First,
    Second,
    Smaller,
    Larger,
    Mean,
    GeometricMean,
    /// Each has that of the other.
    Other,
}

impl Whose {
    pub const ALL: [Whose; 7] = [
        Whose::First,
        Whose::Second,
        Whose::Smaller,
        Whose::Larger,
        Whose::Mean,
        Whose::GeometricMean,
        Whose::Other,
    ];

    /// The value that is taken for both; of materials the one with the smaller or larger modulus, and the first where it is the mean.
    pub fn both<T: Copy>(self, [one, two]: [T; 2], number: impl Fn(T) -> f64) -> [T; 2] {
        let is_less = number(one) < number(two);
        let whose = match self {
            Whose::Second => two,
            Whose::Smaller if !is_less => two,
            Whose::Larger if is_less => two,
            Whose::Other => return [two, one],
            _ => one,
        };
        [whose; 2]
    }

    /// The same of numbers, which have a mean.
    pub fn of_numbers(self, [one, two]: [f64; 2]) -> [f64; 2] {
        match self {
            Whose::Mean => [0.5 * (one + two); 2],
            Whose::GeometricMean => [(one * two).sqrt(); 2],
            _ => self.both([one, two], |number| number),
        }
    }
}

/// Another form of a term.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// The first kick is this share of a whole one.
    FirstKick(f64),
    /// A bed of more radii than this has so many classes of equal widths, and stiffnesses are those of the classes' middle radii,
    /// but for the punch's.
    ClassesOfRadius(u32),
    /// The wall with this index is not there.
    WallMissing(usize),
    /// Grains beside the punch's faces do not touch its corners.
    CornersMissing,
    /// The punch moves after the forces are evaluated.
    PunchLate,
    /// Pairs of grains nearer than this, m, do not touch.
    LostNear(f64),
    /// Pairs of grains farther than this, m, do not touch.
    LostFar(f64),
    /// A contact is found one step after it began.
    FoundLate,
    /// Contacts that begin are not found, for as long as is looked at.
    NotFound,
    /// Normals are those of the step before.
    OldNormals,
    /// Forces are those of the positions before the step.
    OldPositions,
    /// Only one grain of a pair feels the force: the first or the second.
    OneSided(usize),
    /// The tangential spring forgets its force in each step.
    HistoryReset,
    /// The tangential force turns against the normal.
    HistoryTurnedBack,
    /// The tangential force is not limited.
    NoCoulombLimit,
    /// Each component of the tangential force is limited by itself.
    CoulombByComponent,
    /// A dashpot that is made from a restitution has the mean of two masses in the place of the effective mass.
    DashpotOfMeanMass,
    /// The torque on the second body has the other sign.
    TorqueSign,
    /// Spins do not change.
    SpinsKept,
    /// The slip is that of the centres, whatever the spins.
    SlipOfCentres,
    /// Walls and punch do not turn grains.
    NoTorqueOfFlatBodies,
    /// Both bodies of a contact are taken to have this of one of them; at walls, punch and obstacles alone, or between grains too.
    TakenFor(Input, Whose, Alone),
    /// The friction at the first of these is that at the second.
    FrictionOf([Body; 2]),
    /// What touches an obstacle does not feel that it turns, or that it moves.
    ObstacleSpinUnfelt,
    ObstacleVelocityUnfelt,
    /// An obstacle turns about axes that turn with it.
    ObstacleTurnsAboutOwnAxes,
    /// The moment against rolling does not turn with the normal.
    MomentNotTurned,
    /// The moment against twisting has the limit of that against rolling.
    TwistingLimited,
    /// A spring that is cut keeps its force of the step before.
    SlidingKeepsOld,
    /// A dashpot along the normal acts while bodies approach alone.
    DashpotWhileApproaching,
    /// The sign in the local damping of spins is that of the spin before the step.
    SpinsDampedByOld,
    /// In the local damping of spins it is that of the power of all components together, or of the velocity along the same axis.
    SpinsDampedTogether,
    SpinsDampedAsVelocities,
    /// Local damping of spins is α|ω̇| against the spin.
    SpinsDampedAlong,
    /// A key of the job is not read.
    Unread(Key),
    /// Another convention.
    #[serde(skip)]
    Rule(Choice),
}

/// What an engine has otherwise than the model.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Variant {
    /// How much larger constants are, relative; those of gravity over |g|.
    pub larger: BTreeMap<Constant, f64>,
    /// Terms in another form.
    pub forms: Vec<Form>,
}

impl Variant {
    /// With this constant larger by so much, relative, besides.
    pub fn and(&self, constant: Constant, larger: f64) -> Self {
        let mut variant = self.clone();
        *variant.larger.entry(constant).or_insert(0.0) += larger;
        variant
    }

    /// With one term in another form.
    pub fn of(form: Form) -> Self {
        Variant {
            forms: vec![form],
            ..Variant::default()
        }
    }

    pub fn has(&self, form: Form) -> bool {
        self.forms.contains(&form)
    }

    /// Whose of an input is taken for both bodies of a contact whose first one is of this kind, if not of each its own.
    pub fn taken_for(&self, input: Input, first: Body) -> Option<Whose> {
        self.forms.iter().find_map(|form| match *form {
            Form::TakenFor(other, whose, alone) if other == input => match alone {
                Alone::BetweenGrains if first != Body::Grain => None,
                Alone::AtObstacles if first == Body::Grain => None,
                _ => Some(whose),
            },
            _ => None,
        })
    }
}

/// The state at each moment of the case, of the reference with this variant. Radii and masses are shown as given.
pub fn run(given: &Case, variant: &Variant) -> Vec<Snapshot> {
    let unread = variant.forms.iter().fold(None, |seen: Option<Case>, form| {
        let Form::Unread(key) = form else {
            return seen;
        };
        key.unread(seen.as_ref().unwrap_or(given)).or(seen)
    });
    let case = unread.as_ref().unwrap_or(given);
    let mut reference = Reference::new(&case.model, &case.bodies, case.punch, variant);
    let mut all = Vec::with_capacity(case.moments.len());
    for &moment in &case.moments {
        while reference.steps() < moment {
            reference.step();
        }
        let mut seen = reference.snapshot();
        seen.bodies.radius.clone_from(&given.bodies.radius);
        seen.bodies.mass.clone_from(&given.bodies.mass);
        seen.bodies.inertia.clone_from(&given.bodies.inertia);
        all.push(seen);
    }
    all
}
