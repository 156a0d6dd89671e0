//! What another engine may have otherwise than the model: constants that are a little larger, terms of another form, keys that it
//! does not read.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::constant::Constant;
use crate::model::{Law, Model};
use crate::native::first_contact_punch;
use crate::obstacle::Surface;
use crate::reference::Reference;
use crate::rules::Choice;
use crate::scene::{Scene, Springs, Viscosity, paper_scene};
use crate::tables::{Bodies, Body, Punch, Snapshot};
use crate::task::Case;

/// An enum each of whose variants has a row of what is told of it.
#[macro_export]
macro_rules! with_rows {
    ($(#[$about:meta])* $name:ident: $row:ty { $($(#[$of_one:meta])* $variant:ident $cells:expr;)+ }) => {
        $(#[$about])*
        pub enum $name {
            $($(#[$of_one])* $variant,)+
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
        Materials ("material in the springs", Differ::Materials, Law::has_friction);
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
        PoissonsOverShear ("Poisson's ratio ν in (2 − ν)/G of the spring along the tangent", Differ::Materials, |law| is_hertz(law) && law.has_friction());
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

with_rows! {
    /// At which contacts alone something is otherwise.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    Alone: (&'static str, fn(Body) -> bool) {
        #[default]
        Everywhere ("", |_| true);
        AtObstacles ("at walls, punch and obstacles", |first| first != Body::Grain);
        AtWalls ("at walls", |first| first == Body::Wall);
        AtPunch ("at the punch", |first| first == Body::Punch);
        BetweenGrains ("between grains", |first| first == Body::Grain);
    }
}

impl Alone {
    /// In words; empty of all contacts.
    pub fn place(self) -> &'static str {
        self.row().0
    }

    /// Whether contacts whose first body is of this kind are among them.
    pub fn is_at(self, first: Body) -> bool {
        (self.row().1)(first)
    }
}

with_rows! {
    /// Whose value an engine takes for both bodies.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    Whose: &'static str {
        First "the first one's";
        Second "the second one's";
        Smaller "the smaller one";
        Larger "the larger one";
        Mean "the mean";
        GeometricMean "the geometric mean";
        Other "the other one's";
    }
}

impl Whose {
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

macro_rules! forms {
    (
        in any case { $($early:ident $early_words:literal;)+ }
        in some { $($late:ident $late_words:literal, $plays:expr;)+ }
        with numbers { $($(#[$about:meta])* $other:ident($($number:ident: $type:ty),+) $words:expr;)+ }
    ) => {
        /// Another form of a term.
        #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum Form {
            $(#[doc = $early_words] $early,)+
            $(#[doc = $late_words] $late,)+
            $($(#[$about])* $other($($type),+),)+
        }

        impl Form {
            /// Those without numbers that make a difference in any case.
            pub const OF_ANY_CASE: &[Form] = &[$(Form::$early),+];

            /// Those without numbers that make a difference in this case, and not in any.
            pub fn of_case(case: &Case) -> impl Iterator<Item = Form> {
                let all: &[(Form, fn(&Case) -> bool)] = &[$((Form::$late, $plays)),+];
                all.iter().filter(|(_, plays)| plays(case)).map(|(form, _)| *form)
            }

            /// What an engine with this form does, and what is right.
            pub fn in_words(self) -> String {
                match self {
                    $(Form::$early => $early_words.into(),)+
                    $(Form::$late => $late_words.into(),)+
                    $(Form::$other($($number),+) => $words,)+
                }
            }
        }
    };
}

// One of several forms that explain the same is told by this order.
forms! {
    in any case {
        FoundLate "contacts are found a step after they begin";
        NotFound "contacts that begin are not found for some steps: the search is made too seldom for its skin";
        OldNormals "normals are those of the step before";
        OldPositions "forces are those of the positions before the step";
    }
    in some {
        CornersMissing "the punch's corners are not there: a corner acts as a point", |case| case.punch.is_some();
        PunchLate "the punch moves after the forces: it is to move before them, as grains do", |case| case.punch.is_some();
        HistoryReset "the tangential force is forgotten in each step", rubs;
        HistoryTurnedBack "the tangential force turns against the normal, and is to turn with it", rubs;
        NoCoulombLimit "the tangential force is not limited by |N| tan φ", rubs;
        CoulombByComponent "each component of the tangential force is limited by itself: its size is to be limited", rubs;
        TorqueSign "the torque on the second body of a pair has the wrong sign", turns;
        SpinsKept "spins do not change", turns;
        SlipOfCentres "the slip leaves the spins out", turns;
        NoTorqueOfFlatBodies "walls and punch do not turn grains", turns;
        DashpotOfMeanMass "c_n is made from the mean of two masses: the effective mass is m1·m2/(m1 + m2)",
            |case| matches!(case.model.law.contact.viscosity, Viscosity::Restitution { .. });
        DashpotWhileApproaching "the dashpot along the normal acts while bodies approach alone", |case| case.model.law.has_dashpots();
        SlidingKeepsOld "a spring that is cut to Coulomb's limit keeps its force of the step before: it is to keep what was cut", rubs;
        SpinsDampedByOld "local damping of spins takes the sign of the spin before the step, and is to take that of its middle", damps_spins;
        // In the plane a spin has one component, along which nothing moves.
        SpinsDampedTogether "local damping of spins takes the sign of the power of all components together, and is to take that of each",
            |case| damps_spins(case) && case.bodies.in_space();
        SpinsDampedAsVelocities "local damping of spins takes the sign of the power of the velocity along the same axis, and is to take that of the spin",
            |case| damps_spins(case) && case.bodies.in_space();
        SpinsDampedAlong "local damping of spins is α|ω̇| against the spin: each component is to be damped by itself",
            |case| damps_spins(case) && case.bodies.in_space();
        MomentNotTurned "the moment against rolling does not turn with the normal",
            |case| case.model.law.contact.rolling.is_some_and(|rolling| !rolling.is_constant());
        TwistingLimited "the moment against twisting has the limit of that against rolling, and is to have none",
            |case| case.model.law.contact.rolling.is_some_and(|rolling| rolling.limit.is_some());
        TwistingNotTurned "the moment against twisting does not turn with the normal",
            |case| case.model.law.contact.rolling.is_some_and(|rolling| !rolling.is_constant());
        MomentKeptUnlimited "what contacts keep of the moment against rolling is not limited: they are to keep what was cut",
            |case| case.model.law.contact.rolling.is_some_and(|rolling| !rolling.is_constant() && rolling.limit.is_some());
        HeldBeforeTouch "adhesion acts before bodies touch, from where it would end on: it is to begin where they touch", |case| case.model.law.holds();
        LetGoAtTouch "adhesion ends where bodies no longer overlap: it is to hold them beyond that", |case| case.model.law.holds();
        EdgesAsFaces "at edges and corners of triangles normals are those of the face: they are to point from the nearest point",
            |case| case.model.obstacles.iter().any(|obstacle| matches!(obstacle.shape, Surface::Triangle { .. }));
        BoxTurnedBack "boxes are turned the other way: their orientation is from the axes to their own", boxes_are_turned;
        ObstacleTurnsAboutOrigin "what touches an obstacle feels that it turns about the origin: it turns about its own point", obstacles_move;
        ObstacleSpinUnfelt "what touches an obstacle does not feel that it turns: its velocity is v + ω × r", obstacles_move;
        ObstacleVelocityUnfelt "what touches an obstacle does not feel that it moves", obstacles_move;
        ObstacleTurnsAboutOwnAxes "an obstacle turns about axes that turn with it: its spin is in fixed ones", obstacles_move;
    }
    with numbers {
        FirstKick(share: f64) format!("the first kick is {share} of one, and is to be a whole one");
        /// A bed of more radii than this has so many classes of equal widths, and stiffnesses are those of the classes' middle radii,
        /// but for the punch's.
        ClassesOfRadius(most: u32)
            format!("the stiffness of a pair is that of the middle radii of at most {most} classes: k_n = 2·E·R1·R2/(R1 + R2)");
        WallMissing(index: usize) format!("wall {index} of model.walls is not there");
        LostNear(length: f64) format!("contacts of grains nearer than {length:.6} m are lost");
        LostFar(length: f64) format!("contacts of grains farther apart than {length:.6} m are lost");
        OneSided(side: usize) format!("of a pair only the {} grain feels the force", if side == 0 { "first" } else { "second" });
        /// The tangential force is compared with its limit, and cut to it, by two of its components.
        CoulombWithout(axis: usize)
            format!("Coulomb's limit leaves out what the tangential force has along {}: it is of its whole size", ["x", "y", "z"][axis]);
        /// Whose input is taken for both bodies of a contact.
        TakenFor(input: Input, whose: Whose) format!("the {} is {} for both bodies", input.name(), whose.row());
        /// The friction at the first of these is that at the second.
        FrictionOf(both: [Body; 2]) {
            let [at, whose] = both.map(|body| ["between grains", "at walls", "at the punch"][body as usize]);
            format!("friction {at} is that {whose}")
        };
        Unread(key: Key) format!("{} is not read: the paper's value takes its place", key.name());
        /// Another convention.
        #[serde(skip)]
        Rule(choice: Choice) choice.in_words();
    }
}

fn rubs(case: &Case) -> bool {
    case.model.law.has_friction()
}

fn turns(case: &Case) -> bool {
    case.model.law.rotates()
}

fn damps_spins(case: &Case) -> bool {
    turns(case) && case.model.alpha != 0.0
}

fn boxes_are_turned(case: &Case) -> bool {
    let mut obstacles = case.model.obstacles.iter();
    obstacles.any(|obstacle| {
        matches!(obstacle.shape, Surface::Box { orientation: [_, x, y, z], .. } if [x, y, z] != [0.0; 3])
    })
}

fn obstacles_move(case: &Case) -> bool {
    let mut obstacles = case.model.obstacles.iter();
    obstacles.any(|obstacle| obstacle.velocity != [0.0; 3] || obstacle.spin != [0.0; 3])
}

/// What an engine has otherwise than the model.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Variant {
    /// How much larger constants are, relative; those of gravity over |g|.
    pub larger: BTreeMap<Constant, f64>,
    /// Terms in another form.
    pub forms: Vec<Form>,
    /// These contacts alone have all of it, and whatever is not of contacts is as in the model.
    pub alone: Alone,
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

    /// Whose of an input is taken for both bodies of a contact, if not of each its own.
    pub fn taken_for(&self, input: Input) -> Option<Whose> {
        self.forms.iter().find_map(|form| match *form {
            Form::TakenFor(other, whose) if other == input => Some(whose),
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
