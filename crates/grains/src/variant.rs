//! The step written out, pair by pair, with constants that may be a little different and terms that may have another form: what
//! an engine has if it is not quite the model's. Without a difference it has the bits of [`crate::native`], whose obvious
//! reference it is; it looks for all pairs anew in each step and is meant for a few steps.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::model::Model;
use crate::native::contact::{self, Action, Memory, Motion, Parameters, Touch};
use crate::native::first_contact_punch;
use crate::native::state::{Constants, State, contact_row};
use crate::scene::{NewContactSlip, SlipVelocity, Tension, TorqueArms, Viscosity, paper_scene};
use crate::tables::{Bodies, Contact, Punch, Snapshot, Stage};
use crate::task::Case;

/// A constant of the model. Those of gravity are counted over |g|, places of walls over the mean radius.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Constant {
    GrainStiffness,
    WallStiffness,
    PunchStiffness,
    ShearStiffness,
    Friction,
    Dashpot,
    Damping,
    GravityAcross,
    GravityUp,
    TimeStep,
    Mass,
    Inertia,
    /// At contacts.
    Radius,
    /// Of the wall with this index.
    WallPlace(usize),
    PunchSpeed,
}

/// Every constant with its symbol, and of what it is.
const CONSTANTS: [(Constant, &str); 17] = [
    (Constant::GrainStiffness, "k_n between grains"),
    (Constant::WallStiffness, "k_n at walls"),
    (Constant::PunchStiffness, "k_n at the punch"),
    (Constant::ShearStiffness, "k_s"),
    (Constant::Friction, "tan φ"),
    (Constant::Dashpot, "c_n"),
    (Constant::Damping, "α"),
    (Constant::GravityAcross, "g_x"),
    (Constant::GravityUp, "g_z"),
    (Constant::TimeStep, "Δt"),
    (Constant::Mass, "mass"),
    (Constant::Inertia, "moment of inertia"),
    (Constant::Radius, "radius"),
    (Constant::WallPlace(0), "place of wall 0"),
    (Constant::WallPlace(1), "place of wall 1"),
    (Constant::WallPlace(2), "place of wall 2"),
    (Constant::PunchSpeed, "velocity of the punch"),
];

impl Constant {
    /// All of them.
    pub fn all() -> [Constant; 17] {
        CONSTANTS.map(|(constant, _)| constant)
    }

    /// Its symbol, and of what.
    pub fn symbol(self) -> &'static str {
        let known = CONSTANTS.iter().find(|(constant, _)| *constant == self);
        known.map_or("place of a wall", |(_, symbol)| symbol)
    }

    /// Whether it plays a part in this case.
    pub fn is_in(self, case: &Case) -> bool {
        let model = &case.model;
        match self {
            Constant::GrainStiffness | Constant::TimeStep | Constant::Mass | Constant::Radius => {
                true
            }
            Constant::WallStiffness => !model.walls.is_empty(),
            Constant::PunchStiffness | Constant::PunchSpeed => case.punch.is_some(),
            Constant::WallPlace(index) => index < model.walls.len(),
            Constant::ShearStiffness | Constant::Friction => model.law.has_friction(),
            Constant::Dashpot => model.law.has_dashpots(),
            Constant::Damping => model.alpha != 0.0,
            Constant::GravityAcross | Constant::GravityUp => model.gravity != [0.0; 2],
            Constant::Inertia => model.law.rotates(),
        }
    }
}

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
    pub const ALL: [Key; 13] = [
        Key::Gravity,
        Key::Damping,
        Key::TimeStep,
        Key::Modulus,
        Key::StiffnessRatio,
        Key::Friction,
        Key::WallFriction,
        Key::PunchFriction,
        Key::Dashpots,
        Key::PunchSpeed,
        Key::PunchSize,
        Key::Mass,
        Key::Inertia,
    ];

    /// Where it stands in a job.
    pub fn name(self) -> &'static str {
        match self {
            Key::Gravity => "model.gravity",
            Key::Damping => "model.alpha",
            Key::TimeStep => "model.dt",
            Key::Modulus => "law.modulus",
            Key::StiffnessRatio => "law.stiffness_ratio",
            Key::Friction => "law.friction_angle",
            Key::WallFriction => "law.wall_friction_angle",
            Key::PunchFriction => "law.punch_friction_angle",
            Key::Dashpots => "law.contact.viscosity",
            Key::PunchSpeed => "punch.velocity",
            Key::PunchSize => "punch.half_extents",
            Key::Mass => "mass in initial.csv",
            Key::Inertia => "inertia in initial.csv",
        }
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

/// Another form of a term.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// The first kick is this share of a whole one: ½ where the given velocities are taken for those of the start.
    FirstKick(f64),
    /// Positions move with the velocity before the kick.
    MovedBeforeKick,
    /// Positions move with the velocity in the middle of the kick.
    MovedInMiddleOfKick,
    /// The sign in the damping is that of a·(v + share·Δt·a); ½ is right.
    DampingVelocity(f64),
    /// Gravity is not damped: contact forces alone are, by the sign of their own power.
    GravityUndamped,
    /// Both components are damped by the sign of the whole power a·v.
    DampingByWholePower,
    /// The damping force has the velocity's direction: α|F|, not component by component.
    DampingAlongVelocity,
    /// k = E(R₁ + R₂)/2.
    ArithmeticMean,
    /// k = E√(R₁R₂).
    GeometricMean,
    /// k = E·min(R₁, R₂).
    SmallerStiffness,
    /// k = E·max(R₁, R₂).
    LargerStiffness,
    /// k = E·R₁, of the grain with the lower id.
    StiffnessOfFirst,
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
    /// Velocities are written for whole steps, half a kick after those that belong to the half step.
    WrittenAtWholeSteps,
    /// Only one grain of a pair feels the force: the first or the second.
    OneSided(usize),
    /// The tangential spring forgets its force in each step.
    HistoryReset,
    /// The tangential force does not turn with the normal.
    HistoryNotTurned,
    /// The tangential force turns against the normal.
    HistoryTurnedBack,
    /// The tangential force turns with the normal and keeps its length; the model's grows by √(1 + sin²) of the angle.
    HistoryKeepsLength,
    /// The tangential force is projected onto the new tangent, and shrinks by the angle's cosine.
    HistoryProjected,
    /// The tangential force is not limited.
    NoCoulombLimit,
    /// Each component of the tangential force is limited by itself.
    CoulombByComponent,
    /// The limit is that of the spring without the dashpot.
    CoulombOfSpring,
    /// A dashpot that is made from a restitution has the mean of two masses in the place of the effective mass.
    DashpotOfMeanMass,
    /// The dashpot brakes the tangential velocity as well.
    DashpotOnWholeVelocity,
    /// Half overlap and contact point change places.
    OtherTorqueArms,
    /// The arms are the whole radii.
    WholeArms,
    /// The arms at walls and punch are the whole radii.
    WholeArmsAtFlatBodies,
    /// The torque on the second body has the other sign.
    TorqueSign,
    /// Corrected and contact point velocity change places.
    OtherSlip,
    /// Corrected slip is that of the centres' velocities as they are.
    SlipNotStretched,
    /// A new contact slips for the time that it has existed, or for the whole step: the other one.
    OtherNewContact,
    /// Clipped and unclipped tension change places.
    OtherClipping,
    /// Spins are not damped.
    SpinUndamped,
    /// Spins do not change.
    SpinsKept,
    /// The slip is that of the centres, whatever the spins.
    SlipOfCentres,
    /// Walls and punch do not turn grains.
    NoTorqueOfFlatBodies,
    /// A key of the job is not read.
    Unread(Key),
}

impl Form {
    /// Whether the tangential force is not limited, or in another way.
    fn is_unlimited(self) -> bool {
        use Form::{CoulombByComponent, CoulombOfSpring, NoCoulombLimit};
        matches!(self, NoCoulombLimit | CoulombByComponent | CoulombOfSpring)
    }
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

    fn factor(&self, constant: Constant) -> f64 {
        1.0 + self.larger.get(&constant).copied().unwrap_or(0.0)
    }

    pub fn has(&self, form: Form) -> bool {
        self.forms.contains(&form)
    }
}

/// Each radius as the middle of its class; none where there are no more radii than classes.
fn in_classes(radii: &[f64], most: u32) -> Option<Vec<f64>> {
    let mut sorted = radii.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    let (low, high) = (sorted.first()?, sorted.last()?);
    let width = (high - low) / f64::from(most);
    let middle = |radius: &f64| {
        let class = ((radius - low) / width).floor().min(f64::from(most) - 1.0);
        low + (class + 0.5) * width
    };
    (sorted.len() > most as usize).then(|| radii.iter().map(middle).collect())
}

/// The state at each moment of the case. Radii and masses are shown as given.
pub fn run(given: &Case, variant: &Variant) -> Vec<Snapshot> {
    let unread = variant.forms.iter().fold(None, |seen: Option<Case>, form| {
        let Form::Unread(key) = form else {
            return seen;
        };
        key.unread(seen.as_ref().unwrap_or(given)).or(seen)
    });
    let case = unread.as_ref().unwrap_or(given);
    let mut stepper = Stepper::new(case, variant);
    stepper.evaluate();
    let mut step = 0;
    let mut all = Vec::with_capacity(case.moments.len());
    for &moment in &case.moments {
        while step < moment {
            stepper.integrate(step == 0);
            stepper.evaluate();
            step += 1;
        }
        all.push(stepper.snapshot(step, &given.bodies));
    }
    all
}

/// Two bodies that touch, each with its motion.
struct Meeting {
    ids: (u32, u32),
    touch: Touch,
    of: Parameters,
    one: Motion,
    two: Motion,
}

struct Stepper<'a> {
    variant: &'a Variant,
    state: State,
    constants: Constants,
    /// Between grains, at walls and at the punch.
    rules: [contact::ContactRules; 3],
    /// That stiffnesses are made from, m.
    stiffness_radius: Vec<f64>,
    memories: BTreeMap<(u32, u32), Memory>,
    /// Normals of the pairs that touched in the last step, for contacts that are found late.
    touched: BTreeMap<(u32, u32), [f64; 2]>,
    /// Positions before the step, for forces that are those of them.
    before: Vec<[f64; 2]>,
    /// Pairs that touched at the start, for contacts that are not found.
    listed: BTreeSet<(u32, u32)>,
    contacts: Vec<Contact>,
    /// Of the punch, one step late or not.
    punch_centre: [f64; 2],
    begun: bool,
    /// tan²φ between grains, at walls and at the punch, also where the rules have none.
    tan_squared: [f64; 3],
    /// Whether a step depends on the one before by more than positions and velocities.
    remembers: bool,
}

impl<'a> Stepper<'a> {
    fn new(case: &Case, variant: &'a Variant) -> Self {
        let model: &Model = &case.model;
        let mut constants = Constants::new(model, case.bodies.len() as u32);
        let size = model.gravity[0].hypot(model.gravity[1]);
        let of_gravity = [Constant::GravityAcross, Constant::GravityUp];
        for (axis, constant) in of_gravity.into_iter().enumerate() {
            if let Some(larger) = variant.larger.get(&constant) {
                let sign = if model.gravity[axis] < 0.0 { -1.0 } else { 1.0 };
                constants.gravity[axis] += sign * size * larger;
            }
        }
        constants.alpha *= variant.factor(Constant::Damping);
        constants.dt *= variant.factor(Constant::TimeStep);
        let mut bodies = case.bodies.clone();
        let scale = |column: &mut Vec<f64>, factor: f64| {
            column.iter_mut().for_each(|value| *value *= factor);
        };
        scale(&mut bodies.mass, variant.factor(Constant::Mass));
        scale(&mut bodies.inertia, variant.factor(Constant::Inertia));
        let mut rules = constants.rules();
        let friction = variant.factor(Constant::Friction).powi(2);
        let [walls, punch] = rules.tan_squared_at;
        let tan_squared = [rules.tan_squared, walls, punch].map(|of| of * friction);
        for form in &variant.forms {
            change(*form, &mut rules);
        }
        let unlimited = variant.forms.iter().any(|form| form.is_unlimited());
        let rules = tan_squared.map(|of| rules.limited_by(if unlimited { UNLIMITED } else { of }));
        let mean = bodies.radius.iter().sum::<f64>() / bodies.radius.len().max(1) as f64;
        for (index, wall) in constants.walls.iter_mut().enumerate() {
            wall.place += mean * (variant.factor(Constant::WallPlace(index)) - 1.0);
        }
        let punch = case.punch.map(|of| Punch {
            velocity: of.velocity * variant.factor(Constant::PunchSpeed),
            ..of
        });
        let mut state = State::new(&bodies, punch, constants.kernel());
        scale(&mut state.radius, variant.factor(Constant::Radius));
        let stiffness_radius = variant.forms.iter().find_map(|form| match form {
            Form::ClassesOfRadius(most) => in_classes(&state.radius, *most),
            _ => None,
        });
        // Both kernels are written as one here, and one of them has no room for spins.
        state.spin.resize(bodies.len(), 0.0);
        state.torque.resize(bodies.len(), 0.0);
        Stepper {
            variant,
            stiffness_radius: stiffness_radius.unwrap_or_else(|| state.radius.clone()),
            state,
            tan_squared,
            remembers: rules[0].friction || !variant.forms.is_empty(),
            rules,
            constants,
            memories: BTreeMap::new(),
            touched: BTreeMap::new(),
            before: Vec::new(),
            listed: BTreeSet::new(),
            contacts: Vec::new(),
            punch_centre: case.punch.map_or([0.0; 2], |punch| punch.centre),
            begun: false,
        }
    }

    fn integrate(&mut self, first: bool) {
        let Constants {
            dt, gravity, alpha, ..
        } = self.constants;
        if let Some(punch) = &mut self.state.punch {
            self.punch_centre = punch.centre;
            punch.centre[1] += punch.velocity * dt;
            if !self.variant.has(Form::PunchLate) {
                self.punch_centre = punch.centre;
            }
        }
        if self.variant.has(Form::OldPositions) {
            self.before.clone_from(&self.state.position);
        }
        let mut kick = 1.0;
        let mut judged_at = 0.5;
        for form in &self.variant.forms {
            match form {
                Form::FirstKick(share) if first => kick = *share,
                Form::DampingVelocity(share) => judged_at = *share,
                _ => {}
            }
        }
        let state = &mut self.state;
        for id in 0..state.mass.len() {
            let before = state.velocity[id];
            let contact = [0, 1].map(|axis| state.force[id][axis] / state.mass[id]);
            let mut a = [0, 1].map(|axis| contact[axis] + gravity[axis]);
            if self.variant.has(Form::DampingAlongVelocity) {
                let (speed, size) = (before[0].hypot(before[1]), a[0].hypot(a[1]));
                for axis in 0..2 {
                    a[axis] -= alpha * size * before[axis] / speed.max(f64::MIN_POSITIVE);
                }
            } else if alpha != 0.0 {
                let undamped = self.variant.has(Form::GravityUndamped);
                let acting = if undamped { contact } else { a };
                let mut power =
                    [0, 1].map(|axis| acting[axis] * (before[axis] + judged_at * dt * a[axis]));
                if self.variant.has(Form::DampingByWholePower) {
                    power = [power[0] + power[1]; 2];
                }
                for axis in 0..2 {
                    a[axis] = acting[axis] * (1.0 - alpha * sign(power[axis]));
                    if undamped {
                        a[axis] += gravity[axis];
                    }
                }
            }
            for axis in 0..2 {
                // Multiplied by one where the kick is whole, which keeps the bits.
                state.velocity[id][axis] += dt * a[axis] * kick;
                let mut moving = state.velocity[id][axis];
                if self.variant.has(Form::MovedBeforeKick) {
                    moving = before[axis];
                } else if self.variant.has(Form::MovedInMiddleOfKick) {
                    moving = 0.5 * (before[axis] + moving);
                }
                state.position[id][axis] += dt * moving;
            }
        }
        if self.rules[0].rotates && !self.variant.has(Form::SpinsKept) {
            let turning = state.spin.iter_mut().zip(&state.torque).zip(&state.inertia);
            for ((spin, torque), inertia) in turning {
                let mut turn = torque / inertia;
                if !self.variant.has(Form::SpinUndamped) {
                    turn *= 1.0 - alpha * sign(turn * (*spin + 0.5 * dt * turn));
                }
                *spin += dt * turn * kick;
            }
        }
    }

    fn evaluate(&mut self) {
        if self.variant.has(Form::OldPositions) && !self.before.is_empty() {
            let new = std::mem::replace(&mut self.state.position, std::mem::take(&mut self.before));
            self.evaluate_here();
            self.state.position = new;
        } else {
            self.evaluate_here();
        }
    }

    fn evaluate_here(&mut self) {
        self.state.force.fill([0.0; 2]);
        self.state.torque.fill(0.0);
        self.contacts.clear();
        let meetings = self.meetings();
        let mut on_punch = 0.0;
        for meeting in &meetings {
            let Some(Action { force, torques }) = self.act(meeting) else {
                continue;
            };
            let (one, two) = (meeting.ids.0 as usize, meeting.ids.1 as usize);
            let of_grains = one < self.state.mass.len();
            let only = |side| of_grains && self.variant.has(Form::OneSided(side));
            if of_grains && !only(1) {
                self.state.force[one][0] -= force[0];
                self.state.force[one][1] -= force[1];
                self.state.torque[one] += torques[0];
            }
            if !only(0) {
                self.state.force[two][0] += force[0];
                self.state.force[two][1] += force[1];
                self.state.torque[two] += torques[1];
            }
            if meeting.ids.0 == self.constants.ids.punch() {
                on_punch -= force[1];
            }
        }
        if let Some(punch) = &mut self.state.punch {
            punch.force = on_punch;
        }
        if self.remembers {
            let normals = meetings.iter().map(|of| (of.ids, of.touch.normal));
            self.touched = normals.collect();
            let touched = &self.touched;
            self.memories.retain(|ids, _| touched.contains_key(ids));
        }
        self.begun = true;
    }

    /// Bodies that touch, in the order in which their forces are summed: grains, then walls and grains, then the punch.
    fn meetings(&self) -> Vec<Meeting> {
        let (state, variant) = (&self.state, self.variant);
        let mut all = Vec::new();
        for (a, b) in near(state) {
            let Some(touch) = state.grain_touch(a, b) else {
                continue;
            };
            let ([x1, z1], [x2, z2]) = (state.position[a], state.position[b]);
            let distance = (x2 - x1).hypot(z2 - z1);
            let lost = variant.forms.iter().any(|form| match form {
                Form::LostNear(near) => distance < *near,
                Form::LostFar(far) => distance > *far,
                _ => false,
            });
            if lost {
                continue;
            }
            let (m1, m2) = (state.mass[a], state.mass[b]);
            let (s1, s2) = (self.stiffness_radius[a], self.stiffness_radius[b]);
            let mut of = self.constants.parameters(s1, s2, m1 * m2 / (m1 + m2));
            self.other_mean(&mut of, s1, s2);
            if variant.has(Form::DashpotOfMeanMass) {
                of.c_n *= 0.5 * (m1 + m2) / (m1 * m2).sqrt() * std::f64::consts::SQRT_2;
            }
            self.scale(&mut of, Constant::GrainStiffness);
            all.push(Meeting {
                ids: (a as u32, b as u32),
                touch,
                of,
                one: state.motion(a),
                two: state.motion(b),
            });
        }
        let mut flat = |body, id: usize, touch, one, stiffness| {
            let radius = match stiffness {
                Constant::PunchStiffness => state.radius[id],
                _ => self.stiffness_radius[id],
            };
            let mut of = self.constants.parameters(radius, radius, state.mass[id]);
            self.scale(&mut of, stiffness);
            all.push(Meeting {
                ids: (body, id as u32),
                touch,
                of,
                one,
                two: state.motion(id),
            });
        };
        for (index, wall) in self.constants.walls.iter().enumerate() {
            let grains = 0..state.mass.len();
            for id in grains.filter(|_| !variant.has(Form::WallMissing(index))) {
                if let Some(touch) = state.wall_touch(wall, id) {
                    let still = Motion::default();
                    let body = self.constants.ids.wall(index);
                    flat(body, id, touch, still, Constant::WallStiffness);
                }
            }
        }
        if let Some(punch) = state.punch {
            let centre = self.punch_centre;
            let punch = Punch { centre, ..punch };
            let moving = Motion::from(&punch);
            for id in 0..state.mass.len() {
                let beyond = |axis: usize| {
                    let apart = state.position[id][axis] - centre[axis];
                    apart.abs() > punch.half_extents[axis]
                };
                let at_corner = beyond(0) && beyond(1);
                if let Some(touch) = state.punch_touch(&punch, id)
                    && !(at_corner && variant.has(Form::CornersMissing))
                {
                    let body = self.constants.ids.punch();
                    flat(body, id, touch, moving, Constant::PunchStiffness);
                }
            }
        }
        all
    }

    /// What a contact does, unless it is not found yet; its memory moves on.
    fn act(&mut self, meeting: &Meeting) -> Option<Action> {
        let Meeting {
            ids, of, one, two, ..
        } = meeting;
        let mut touch = meeting.touch;
        let before = self.touched.get(ids);
        if self.begun && before.is_none() && self.variant.has(Form::FoundLate) {
            return None;
        }
        if self.variant.has(Form::NotFound) {
            if !self.begun {
                self.listed.insert(*ids);
            } else if !self.listed.contains(ids) {
                return None;
            }
        }
        if self.variant.has(Form::OldNormals)
            && let Some(normal) = before
        {
            touch.normal = *normal;
        }
        let mut memory = self.memories.remove(ids).unwrap_or_default();
        if self.variant.has(Form::HistoryReset) {
            memory.shear = [0.0; 2];
        }
        if self.variant.has(Form::HistoryNotTurned) {
            memory.normal = touch.normal;
        }
        if self.variant.has(Form::HistoryTurnedBack) {
            // Mirrored at the normal of now, it turns the other way.
            let [[ox, oz], [nx, nz]] = [memory.normal, touch.normal];
            let twice = 2.0 * (ox * nx + oz * nz);
            memory.normal = [twice * nx - ox, twice * nz - oz];
        }
        let keeps_length = self.variant.has(Form::HistoryKeepsLength);
        if (keeps_length || self.variant.has(Form::HistoryProjected)) && memory.touching() {
            let ([sx, sz], [nx, nz]) = (memory.shear, touch.normal);
            let along = sx * nx + sz * nz;
            let turned = [sx - along * nx, sz - along * nz];
            let size = turned[0].hypot(turned[1]);
            let grows = keeps_length && size > 0.0;
            let factor = if grows { sx.hypot(sz) / size } else { 1.0 };
            memory.normal = touch.normal;
            memory.shear = turned.map(|of| factor * of);
        }
        let which = match touch.pair {
            contact::Pair::Grains => 0,
            contact::Pair::Wall => 1,
            contact::Pair::PunchOutside | contact::Pair::PunchInside => 2,
        };
        let (rules, tangent) = (&self.rules[which], self.tan_squared[which].sqrt());
        let of_centres = self.variant.has(Form::SlipOfCentres);
        let [one_of_slip, two_of_slip] = [one, two].map(|of| Motion {
            spin: if of_centres { 0.0 } else { of.spin },
            ..*of
        });
        let mut action = rules.act(&touch, of, &one_of_slip, &two_of_slip, &mut memory);
        let mut force = action.force;
        if self.variant.has(Form::DashpotOnWholeVelocity) {
            let apart = [0, 1].map(|axis| two.velocity[axis] - one.velocity[axis]);
            let along = apart[0] * touch.normal[0] + apart[1] * touch.normal[1];
            force = [0, 1]
                .map(|axis| force[axis] - of.c_n * (apart[axis] - along * touch.normal[axis]));
        }
        if self.variant.has(Form::CoulombByComponent) {
            let normal = rules.normal_force(&touch, of, one, two);
            let limit = normal[0].hypot(normal[1]) * tangent;
            memory.shear = memory.shear.map(|of| of.clamp(-limit, limit));
            force = [0, 1].map(|axis| normal[axis] + memory.shear[axis]);
        }
        if self.variant.has(Form::CoulombOfSpring) {
            let normal = rules.normal_force(&touch, of, one, two);
            let limit = of.k_n * touch.overlap * tangent;
            let ratio = limit / memory.shear[0].hypot(memory.shear[1]);
            if ratio < 1.0 {
                memory.shear = memory.shear.map(|of| of * ratio);
            }
            force = [0, 1].map(|axis| normal[axis] + memory.shear[axis]);
        }
        if force != action.force {
            action.force = force;
            if rules.rotates {
                action.torques = rules.torques(&touch, force, one, two);
            }
        }
        let is_flat = touch.pair != contact::Pair::Grains;
        if self.variant.has(Form::NoTorqueOfFlatBodies) && is_flat {
            action.torques = [0.0; 2];
        }
        let whole_arms = self.variant.has(Form::WholeArms)
            || is_flat && self.variant.has(Form::WholeArmsAtFlatBodies);
        if whole_arms && rules.rotates {
            let [r1, r2] = touch.radii;
            let turn = touch.normal[0] * action.force[1] - touch.normal[1] * action.force[0];
            action.torques = [r1 * turn, r2 * turn];
        }
        if self.variant.has(Form::TorqueSign) {
            action.torques[1] = -action.torques[1];
        }
        if self.remembers {
            self.memories.insert(*ids, memory);
        }
        let row = contact_row(ids.0, ids.1, &touch, action.force);
        self.contacts.push(row);
        Some(action)
    }

    fn scale(&self, of: &mut Parameters, stiffness: Constant) {
        let stiffer = self.variant.factor(stiffness);
        of.k_n *= stiffer;
        of.k_s *= self.variant.factor(Constant::ShearStiffness);
        of.c_n *= self.variant.factor(Constant::Dashpot);
        // A dashpot that is made from a restitution is made from the stiffness too: c_n ~ √k_n.
        let viscosity = &self.constants.law.contact.viscosity;
        if matches!(viscosity, Viscosity::Restitution { .. }) {
            of.c_n *= stiffer.max(0.0).sqrt();
        }
    }

    fn other_mean(&self, of: &mut Parameters, r1: f64, r2: f64) {
        let right = 2.0 * r1 * r2 / (r1 + r2);
        let mean = self.variant.forms.iter().find_map(|form| match form {
            Form::ArithmeticMean => Some(0.5 * (r1 + r2)),
            Form::GeometricMean => Some((r1 * r2).sqrt()),
            Form::SmallerStiffness => Some(r1.min(r2)),
            Form::LargerStiffness => Some(r1.max(r2)),
            Form::StiffnessOfFirst => Some(r1),
            _ => None,
        });
        if let Some(mean) = mean {
            of.k_n *= mean / right;
            of.k_s *= mean / right;
        }
    }

    fn snapshot(&self, step: u64, given: &Bodies) -> Snapshot {
        let mut bodies = self.state.bodies();
        if step > 0 && self.variant.has(Form::WrittenAtWholeSteps) {
            let Constants {
                dt, gravity, alpha, ..
            } = self.constants;
            for id in 0..bodies.len() {
                let [x, z] = [0, 1].map(|axis| {
                    let a = self.state.force[id][axis] / self.state.mass[id] + gravity[axis];
                    let v = self.state.velocity[id][axis];
                    v + 0.5 * dt * a * (1.0 - alpha * sign(a * (v + 0.5 * dt * a)))
                });
                (bodies.vx[id], bodies.vz[id]) = (x, z);
            }
        }
        bodies.radius.clone_from(&given.radius);
        bodies.mass.clone_from(&given.mass);
        bodies.inertia.clone_from(&given.inertia);
        let mut contacts = self.contacts.clone();
        contacts.sort_by_key(|of| (of.id1, of.id2));
        Snapshot {
            stage: Stage::Settle,
            step,
            time: step as f64 * self.constants.dt,
            bodies,
            contacts,
            memory: Vec::new(),
            punch: self.state.punch,
        }
    }
}

/// tan²φ with which nothing is larger than |N| tan φ, of a force that is finite.
const UNLIMITED: f64 = 1.0e60;

fn sign(of: f64) -> f64 {
    f64::from(u8::from(of > 0.0)) - f64::from(u8::from(of < 0.0))
}

fn change(form: Form, rules: &mut contact::ContactRules) {
    match form {
        Form::OtherTorqueArms => {
            rules.torque_arms = match rules.torque_arms {
                TorqueArms::HalfOverlap => TorqueArms::ContactPoint,
                TorqueArms::ContactPoint => TorqueArms::HalfOverlap,
            }
        }
        Form::OtherSlip => {
            rules.slip_velocity = match rules.slip_velocity {
                SlipVelocity::RatchetingCorrected => SlipVelocity::ContactPoint,
                SlipVelocity::ContactPoint => SlipVelocity::RatchetingCorrected,
            }
        }
        Form::SlipNotStretched => rules.stretched = false,
        Form::OtherNewContact => {
            rules.new_contact_slip = match rules.new_contact_slip {
                NewContactSlip::WholeStep => NewContactSlip::SinceTouch,
                NewContactSlip::SinceTouch => NewContactSlip::WholeStep,
            }
        }
        Form::OtherClipping => {
            rules.tension = match rules.tension {
                Tension::Clipped => Tension::Unclipped,
                Tension::Unclipped => Tension::Clipped,
            }
        }
        _ => {}
    }
}

/// Pairs of grains whose cells are neighbours, in order.
fn near(state: &State) -> Vec<(usize, usize)> {
    let radii = state.radius.iter().copied();
    let side = 2.0 * radii.fold(f64::MIN_POSITIVE, f64::max);
    let cell = |id: usize| {
        let [x, z] = state.position[id].map(|x| (x / side).floor() as i64);
        (z, x)
    };
    let mut cells: Vec<((i64, i64), usize)> =
        (0..state.radius.len()).map(|id| (cell(id), id)).collect();
    cells.sort_unstable();
    let mut pairs = Vec::new();
    for a in 0..state.radius.len() {
        let (z, x) = cell(a);
        let from = pairs.len();
        for row in [z - 1, z, z + 1] {
            let first = cells.partition_point(|of| of.0 < (row, x - 1));
            let beside = cells[first..].iter().take_while(|of| of.0 <= (row, x + 1));
            pairs.extend(beside.filter(|(_, b)| *b > a).map(|(_, b)| (a, *b)));
        }
        pairs[from..].sort_unstable();
    }
    pairs
}
