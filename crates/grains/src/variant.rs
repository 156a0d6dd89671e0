//! What another engine may have otherwise than the model: constants that are a little larger, terms of another form, keys that it
//! does not read.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::constant::Constant;
use crate::model::{Law, Model};
use crate::native::first_contact_punch;
use crate::reference::Reference;
use crate::rules::Choice;
use crate::scene::{Scene, Springs, Viscosity, paper_scene};
use crate::tables::{Bodies, Body, Punch, Snapshot};
use crate::task::Case;

/// An enum each of whose variants has a row of what is told of it.
#[macro_export]
macro_rules! with_rows {
    ($(#[$about:meta])* $name:ident: $row:ty { $($variant:ident $cells:expr;)+ }) => {
        $(#[$about])*
        pub enum $name {
            $($variant,)+
        }

        impl $name {
            /// All of them, in this order.
            pub const ALL: [$name; [$(stringify!($variant)),+].len()] = [$($name::$variant),+];

            fn row(self) -> &'static $row {
                static ROWS: &[$row] = &[$($cells),+];
                &ROWS[self as usize]
            }
        }
    };
}

/// The friction angle of an engine that reads none, rad.
const USUAL_FRICTION: f64 = 0.5;

/// The paper's values.
struct Usual {
    scene: Scene,
    model: Model,
    punch: Punch,
}

with_rows! {
    /// A key of a job that an engine may leave unread: it computes with the paper's value then, whatever it is told. With where it
    /// stands in a job, and what is seen without it.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    Key: (&'static str, fn(&mut Case, &Usual)) {
        Gravity ("model.gravity", |seen, usual| seen.model.gravity = usual.model.gravity);
        Damping ("model.alpha", |seen, usual| seen.model.alpha = usual.model.alpha);
        TimeStep ("model.dt", |seen, usual| seen.model.dt = usual.model.dt);
        Modulus ("law.modulus", |seen, usual| seen.model.law.modulus = usual.model.law.modulus);
        StiffnessRatio ("law.stiffness_ratio", |seen, usual| seen.model.law.stiffness_ratio = usual.model.law.stiffness_ratio);
        Friction ("law.friction_angle", |seen, _| seen.model.law.friction_angle = USUAL_FRICTION);
        WallFriction ("law.wall_friction_angle", |seen, _| seen.model.law.wall_friction_angle = None);
        PunchFriction ("law.punch_friction_angle", |seen, _| seen.model.law.punch_friction_angle = None);
        Dashpots ("law.contact.viscosity", |seen, _| seen.model.law.contact.viscosity = Viscosity::None);
        PunchSpeed ("punch.velocity", |seen, usual| seen.punch.iter_mut().for_each(|punch| punch.velocity = usual.punch.velocity));
        PunchSize ("punch.half_extents", |seen, usual| seen.punch.iter_mut().for_each(|punch| punch.half_extents = usual.punch.half_extents));
        Mass ("mass in initial.csv", |Case { bodies, .. }, usual| {
            let grains = bodies.mass.iter_mut().zip(&bodies.radius);
            grains.for_each(|(mass, radius)| *mass = usual.scene.grain_mass(*radius));
        });
        Inertia ("inertia in initial.csv", |Case { bodies, .. }, usual| {
            let grains = bodies.inertia.iter_mut().zip(&bodies.radius).zip(&bodies.mass);
            grains.for_each(|((inertia, radius), mass)| *inertia = usual.scene.grain_inertia(*radius, *mass));
        });
    }
}

impl Key {
    /// Where it stands in a job.
    pub fn name(self) -> &'static str {
        self.row().0
    }

    /// The case as an engine sees it that does not read this key; none where it sees no other.
    pub fn unread(self, case: &Case) -> Option<Case> {
        let scene = paper_scene(1, 1);
        let usual = Usual {
            model: Model::of(&scene),
            punch: first_contact_punch(&scene, &Bodies::default()),
            scene,
        };
        let mut seen = case.clone();
        (self.row().1)(&mut seen, &usual);
        // Friction where there was none would be another law.
        let same_terms = seen.model.law.has_friction() == case.model.law.has_friction();
        (seen != *case && same_terms).then_some(seen)
    }
}

/// In what bodies differ where it makes a difference whose number is taken.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Differ {
    /// Masses go with them.
    Radii,
    Materials,
}

with_rows! {
    /// What a contact's formulas take of both its bodies, in what these differ, and in which laws. In words it is one body's.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    Input: (&'static str, Differ, fn(&Law) -> bool) {
        StiffnessRadii ("radius in the springs", Differ::Radii, |_| true);
        TangentialRadii ("radius in the spring along the tangent", Differ::Radii, Law::has_friction);
        NormalMaterials ("material in the spring along the normal", Differ::Materials, |_| true);
        TangentialMaterials ("material in the spring along the tangent", Differ::Materials, Law::has_friction);
        Masses ("mass in the dashpots", Differ::Radii, has_masses);
        FrictionAngles ("friction angle", Differ::Materials, Law::has_friction);
        RollingRadii ("radius in the limit of the moment against rolling", Differ::Radii,
            |law| law.contact.rolling.is_some_and(|rolling| rolling.limit.is_some()));
        SlipRadii ("radius in the slip", Differ::Radii, Law::rotates);
        TorqueArms ("radius in the torque", Differ::Radii, Law::rotates);
        NormalModuli ("modulus E in the spring along the normal", Differ::Materials, is_hertz);
        NormalPoissons ("Poisson's ratio ν in the spring along the normal", Differ::Materials, is_hertz);
        TangentialModuli ("modulus E in the spring along the tangent", Differ::Materials, |law| is_hertz(law) && law.has_friction());
        TangentialPoissons ("Poisson's ratio ν in the spring along the tangent", Differ::Materials, |law| is_hertz(law) && law.has_friction());
        AdhesionRadii ("radius in the pull of adhesion", Differ::Radii, |law| law.contact.adhesion.is_some());
        NormalMasses ("mass in the dashpot along the normal", Differ::Radii, |law| is_hertz(law) && has_masses(law));
        TangentialMasses ("mass in the dashpot along the tangent", Differ::Radii,
            |law| is_hertz(law) && has_masses(law) && law.has_friction());
    }
}

impl Input {
    /// In words.
    pub fn name(self) -> &'static str {
        self.row().0
    }

    pub fn is_of_materials(self) -> bool {
        self.row().1 == Differ::Materials
    }

    /// Whether formulas of this law have it.
    pub fn is_in(self, law: &Law) -> bool {
        (self.row().2)(law)
    }
}

fn is_hertz(law: &Law) -> bool {
    law.contact.springs == Springs::HertzMindlin
}

/// Whether dashpots are made of masses.
fn has_masses(law: &Law) -> bool {
    use Viscosity::{Ratio, Restitution};
    matches!(law.contact.viscosity, Restitution { .. } | Ratio { .. })
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
