//! The step written out plainly, with no lists, no lanes and nothing of the engine but its constants: every pair that touches in
//! the order of ids, walls after grains, the punch last, and what contacts remember in a map. Slow and obvious; the engine must
//! have its bits. With a [`Variant`] it is what another engine may do instead. In space `space` is the engine.

mod law;
pub(crate) use law::energy_of_jkr;
pub use law::{Parts, Told};
mod linear;
pub use linear::Linear;
mod made;
pub use made::{Ingredient, Made, Makes, OF_FORCES, OF_TORQUES};
pub(crate) mod space;
mod touch;

use std::collections::{BTreeMap, BTreeSet};

use crate::constant::Given;
use crate::model::Model;
use crate::native::state::Constants;
use crate::obstacle::Placed;
use crate::rules::{
    DampedGravity, DampedSpins, DampingComponents, DampingVelocity, GivenVelocities, Integration,
    Rules, TangentialRestitution, WrittenVelocities,
};
use crate::tables::{
    Across, Bodies, Body, Contact, Memories, Punch, Remembered, RememberedAcross, Snapshot, Stage,
    tangential,
};
use crate::variant::{Alone, Form, Variant};
use crate::vector::{Vector, dot, each, hypot, in_plane, in_space, minus, norm, plus, times};
use law::Pair;
use touch::{Near, NearObstacles, Touch};

/// Grains, what their contacts remember and what pushes them. After each step the forces belong to the positions.
#[derive(Clone)]
pub struct Reference {
    variant: Variant,
    constants: Constants,
    /// tan φ between grains, at walls and at the punch.
    tangents: [f64; 3],
    /// Radii at contacts, masses and moments of inertia of the grains.
    sizes: Sizes,
    motions: Vec<Motion>,
    /// The punch now.
    pub punch: Option<Punch>,
    /// Those that touch since the last evaluation, sorted by ids.
    touching: Vec<Touching>,
    force: Vec<Vector>,
    torque: Vec<Vector>,
    /// What contacts remember, sorted by ids.
    memories: Vec<Memory>,
    steps: u64,
    /// The time step, s, while forces are evaluated in no time.
    looks: Option<f64>,
    /// The radii that stiffnesses are made from, m.
    stiffness_radius: Vec<f64>,
    /// The punch that grains feel.
    felt: Option<Punch>,
    /// Where grains were before the step, where forces are those of then.
    before: Option<Vec<Vector>>,
    /// Normals of the pairs that touched at the last evaluation, where a form asks for them.
    touched: BTreeMap<Ids, Vector>,
    /// Pairs that touched at the start, where others are not found.
    listed: Option<BTreeSet<Ids>>,
    near: Near,
    obstacles: Vec<Placed>,
    near_obstacles: NearObstacles,
    /// Room for what contacts remembered before.
    spare: Vec<Memory>,
    /// What some contacts alone have.
    there: Option<Box<There>>,
}

/// What contacts at one place have in the place of the law of all others.
#[derive(Clone)]
struct There {
    alone: Alone,
    variant: Variant,
    constants: Constants,
    tangents: [f64; 3],
}

type Ids = (u32, u32);

#[derive(Clone)]
struct Sizes {
    radius: Vec<f64>,
    mass: Vec<f64>,
    /// Empty where grains do not rotate.
    inertia: Vec<f64>,
    /// Empty where all are alike.
    material: Vec<u32>,
    in_space: bool,
}

/// How a body moves.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Motion {
    pub place: Vector,
    pub velocity: Vector,
    pub spin: Vector,
}

impl From<&Punch> for Motion {
    fn from(punch: &Punch) -> Self {
        Motion {
            place: in_space(punch.centre),
            velocity: [0.0, 0.0, punch.velocity],
            spin: [0.0; 3],
        }
    }
}

/// What a contact remembers from step to step.
#[derive(Clone, Copy)]
struct Memory {
    ids: Ids,
    normal: Vector,
    /// Tangential force on body 2, N.
    shear: Vector,
    /// Moments on body 2 against rolling and twisting, N·m.
    bending: Vector,
    twisting: Vector,
    /// The force was cut, so that no dashpot was added along the tangent.
    slides: bool,
    pair: Pair,
    /// k_s at the last overlap, N/m; 0 where that is not known.
    k_s: f64,
}

impl From<&Memory> for Remembered {
    fn from(memory: &Memory) -> Self {
        Remembered {
            id1: memory.ids.0,
            id2: memory.ids.1,
            normal: in_plane(memory.normal),
            shear: in_plane(memory.shear),
        }
    }
}

impl From<&Memory> for RememberedAcross {
    fn from(memory: &Memory) -> Self {
        RememberedAcross {
            normal: memory.normal[1],
            shear: memory.shear[1],
            bending: memory.bending,
            twisting: memory.twisting,
            slides: memory.slides,
        }
    }
}

/// Two bodies that touch.
#[derive(Clone)]
struct Touching {
    ids: Ids,
    touch: Touch,
    /// On body 2, N.
    force: Vector,
}

impl Reference {
    /// The forces at the start belong to it.
    pub fn new(model: &Model, bodies: &Bodies, punch: Option<Punch>, variant: &Variant) -> Self {
        let mut given = Given::new(model, bodies, punch);
        let usual = (variant.alone != Alone::Everywhere).then(|| given.clone());
        for (constant, larger) in &variant.larger {
            constant.enlarge(&mut given, *larger);
        }
        let changed = Reference::going_on(given, &Memories::default(), variant);
        let Some(usual) = usual else {
            return changed;
        };
        let mut reference = Reference::going_on(usual, &Memories::default(), &Variant::default());
        let mut there = There {
            alone: variant.alone,
            variant: changed.variant,
            constants: changed.constants,
            tangents: changed.tangents,
        };
        there.constants.dt = reference.constants.dt;
        reference.there = Some(Box::new(there));
        reference.memories.clear();
        reference.evaluate();
        reference
    }

    /// With what contacts of this first body have.
    fn at<T>(&mut self, first: Body, with: impl FnOnce(&Self) -> T) -> T {
        let Some(mut there) = self.there.take_if(|there| there.alone.is_at(first)) else {
            return with(self);
        };
        let mut exchange = |reference: &mut Self| {
            std::mem::swap(&mut reference.variant, &mut there.variant);
            std::mem::swap(&mut reference.constants, &mut there.constants);
            std::mem::swap(&mut reference.tangents, &mut there.tangents);
        };
        exchange(self);
        let found = with(self);
        exchange(self);
        self.there = Some(there);
        found
    }

    /// The same where these touched a moment ago, of which adhesion may hold some.
    pub fn holding(
        model: &Model,
        bodies: &Bodies,
        punch: Option<Punch>,
        contacts: &[Contact],
    ) -> Self {
        let variant = &Variant::default();
        if !model.law.holds() {
            return Reference::new(model, bodies, punch, variant);
        }
        let memory = Memories {
            planar: contacts.iter().map(Remembered::from).collect(),
            across: Vec::new(),
        };
        Reference::going_on(Given::new(model, bodies, punch), &memory, variant)
    }

    /// The same from contacts that remember something; where they do, the forces at the start are those that they remember.
    pub(crate) fn going_on(given: Given, memory: &Memories, variant: &Variant) -> Self {
        let Given {
            constants,
            bodies,
            punch,
        } = given;
        let in_classes = variant.forms.iter().find_map(|form| match form {
            Form::ClassesOfRadius(most) => in_classes(&bodies.radius, *most),
            _ => None,
        });
        let mut reference = Reference {
            variant: variant.clone(),
            tangents: [0.0; 3],
            stiffness_radius: in_classes.unwrap_or_else(|| bodies.radius.clone()),
            motions: motions(&bodies),
            sizes: Sizes {
                in_space: bodies.in_space(),
                radius: bodies.radius,
                mass: bodies.mass,
                inertia: bodies.inertia,
                material: bodies.material,
            },
            felt: punch,
            punch,
            touching: Vec::new(),
            force: Vec::new(),
            torque: Vec::new(),
            memories: Vec::new(),
            steps: 0,
            looks: None,
            before: None,
            touched: BTreeMap::new(),
            listed: None,
            near: Near::default(),
            obstacles: {
                let placed = constants.obstacles.iter().map(Placed::new);
                match variant.has(Form::BoxTurnedBack) {
                    true => placed.map(Placed::turned_back).collect(),
                    false => placed.collect(),
                }
            },
            near_obstacles: NearObstacles::default(),
            spare: Vec::new(),
            there: None,
            constants,
        };
        reference.choose();
        let remembered = memory.planar.iter().enumerate().map(|(at, planar)| {
            let ids = (planar.id1, planar.id2);
            let mut kept = Memory {
                normal: in_space(planar.normal),
                shear: in_space(planar.shear),
                ..Memory::new(ids, reference.pair(ids))
            };
            if let Some(across) = memory.across.get(at) {
                (kept.normal[1], kept.shear[1]) = (across.normal, across.shear);
                (kept.bending, kept.twisting) = (across.bending, across.twisting);
                kept.slides = across.slides;
            }
            kept
        });
        reference.memories = remembered.collect();
        match memory.is_empty() {
            true => reference.evaluate(),
            false => reference.look(),
        }
        reference
    }

    /// Evaluates the forces without slip or limit, so that what contacts remember stays.
    fn look(&mut self) {
        let dt = std::mem::replace(&mut self.constants.dt, 0.0);
        self.looks = Some(dt);
        let tangents = std::mem::replace(&mut self.tangents, [f64::INFINITY; 3]);
        self.pair_again();
        self.forces();
        (self.constants.dt, self.tangents, self.looks) = (dt, tangents, None);
        self.pair_again();
    }

    /// Works out what pairs keep of the constants.
    fn pair_again(&mut self) {
        for at in 0..self.memories.len() {
            self.memories[at].pair = self.pair(self.memories[at].ids);
        }
    }

    /// The same grains where they are told to be instead, by an engine with errors of its own.
    pub(crate) fn moved(&self, bodies: &Bodies, punch: Option<Punch>) -> Self {
        let mut moved = self.clone();
        moved.put(bodies, punch);
        if moved.motions != self.motions {
            moved.look();
        }
        moved
    }

    /// Puts grains and punch there; forces stay those of the last evaluation.
    pub(crate) fn put(&mut self, bodies: &Bodies, punch: Option<Punch>) {
        self.motions = motions(bodies);
        self.press(punch);
    }

    /// Whether it is not in the plane.
    pub fn is_in_space(&self) -> bool {
        self.sizes.in_space
    }

    /// How each grain moves, and the force, N, and torque, N·m, on it.
    pub(crate) fn moving(&self) -> impl Iterator<Item = (&Motion, (Vector, Vector))> {
        let loads = self.force.iter().copied().zip(self.torque.iter().copied());
        self.motions.iter().zip(loads)
    }

    /// The contacts of the last evaluation, sorted by ids.
    pub fn contacts(&self) -> Vec<Contact> {
        self.contacts_with_across().0
    }

    /// With what they have in space besides.
    pub fn contacts_with_across(&self) -> (Vec<Contact>, Vec<Across>) {
        let touching = self.touching.iter();
        match self.sizes.in_space {
            false => (touching.map(Touching::in_plane).collect(), Vec::new()),
            true => touching.map(Touching::in_space).unzip(),
        }
    }

    /// What contacts remember, sorted by ids.
    pub fn memory(&self) -> Memories {
        let across = self.memories.iter().filter(|_| self.sizes.in_space);
        Memories {
            planar: self.memories.iter().map(Remembered::from).collect(),
            across: across.map(RememberedAcross::from).collect(),
        }
    }

    /// The grains now; radii are those at contacts.
    pub fn bodies(&self) -> Bodies {
        self.table(&self.motions)
    }

    fn table(&self, motions: &[Motion]) -> Bodies {
        let column = |is_there: bool, number: fn(&Motion) -> f64| {
            let there = motions.iter().filter(|_| is_there);
            there.map(number).collect()
        };
        let (space, spins) = (self.sizes.in_space, !self.sizes.inertia.is_empty());
        Bodies {
            x: column(true, |grain| grain.place[0]),
            z: column(true, |grain| grain.place[2]),
            vx: column(true, |grain| grain.velocity[0]),
            vz: column(true, |grain| grain.velocity[2]),
            radius: self.sizes.radius.clone(),
            mass: self.sizes.mass.clone(),
            spin: column(spins, |grain| grain.spin[1]),
            inertia: self.sizes.inertia.clone(),
            y: column(space, |grain| grain.place[1]),
            vy: column(space, |grain| grain.velocity[1]),
            spin_x: column(space && spins, |grain| grain.spin[0]),
            spin_z: column(space && spins, |grain| grain.spin[2]),
            material: self.sizes.material.clone(),
        }
    }

    /// Goes on with another model: forces are those of the old one until the next step, contacts keep what they remember.
    pub fn change(&mut self, model: &Model) {
        let mut given = Given::new(model, &self.bodies(), self.punch);
        for (constant, larger) in &self.variant.larger {
            constant.enlarge(&mut given, *larger);
        }
        self.change_constants(given.constants);
    }

    /// The same with constants that are worked out already.
    pub(crate) fn change_constants(&mut self, constants: Constants) {
        self.constants = constants;
        self.choose();
    }

    /// Sets a punch on the bed, or moves it; grains feel it from the next step on.
    pub fn press(&mut self, punch: Option<Punch>) {
        if self.punch.is_none() {
            self.felt = punch;
        }
        self.punch = punch;
    }

    /// Takes the model's rules, or the other ones of the variant.
    fn choose(&mut self) {
        for form in &self.variant.forms {
            if let Form::Rule(choice) = form {
                choice.set(&mut self.constants.rules);
            }
        }
        let law = &self.constants.law;
        self.tangents = law.friction_angles().map(f64::tan);
        self.constants.rules = law.resolved(self.constants.rules);
        if self.constants.rules.tangential_restitution == TangentialRestitution::AsNormal {
            let [normal, along] = law.damping_ratios();
            // Whatever it was changed by stays.
            let changed = self.constants.damping_ratios[1] / along;
            self.constants.damping_ratios[1] = normal * if along > 0.0 { changed } else { 1.0 };
        }
        self.pair_again();
    }

    fn rules(&self) -> &Rules {
        &self.constants.rules
    }

    fn has(&self, form: Form) -> bool {
        self.variant.has(form)
    }

    /// How many there have been.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// One time step.
    pub fn step(&mut self) {
        self.advance();
        self.evaluate();
    }

    /// A step without its forces.
    fn advance(&mut self) {
        self.move_bodies();
        if self.has(Form::OldPositions) {
            self.before = Some(self.places());
        }
        self.integrate();
        self.steps += 1;
    }

    /// Moves those that are no grains.
    fn move_bodies(&mut self) {
        if let Some(punch) = &mut self.punch {
            self.felt = Some(*punch);
            punch.centre[1] += punch.velocity * self.constants.dt;
        }
        let about_own_axes = self.has(Form::ObstacleTurnsAboutOwnAxes);
        for obstacle in &mut self.obstacles {
            let spin = obstacle.motion.spin;
            if about_own_axes {
                obstacle.motion.spin = obstacle.outward(spin);
            }
            obstacle.advance(self.constants.dt);
            obstacle.motion.spin = spin;
        }
        if !self.has(Form::PunchLate) {
            self.felt = self.punch;
        }
    }

    fn integrate(&mut self) {
        let dt = self.constants.dt;
        let mut kick = 1.0;
        if self.steps == 0 {
            if self.rules().given_velocities == GivenVelocities::AtStart {
                kick = 0.5;
            }
            for form in &self.variant.forms {
                if let Form::FirstKick(share) = form {
                    kick = *share;
                }
            }
        }
        let integration = self.rules().integration;
        let turns = self.constants.law.rotates() && !self.has(Form::SpinsKept);
        let turning = if turns { self.sizes.inertia.len() } else { 0 };
        for i in 0..self.motions.len() {
            let before = self.motions[i].velocity;
            let a = self.acceleration(i, before);
            // Multiplied by one where the kick is whole, which keeps the bits.
            let after = each([0, 1, 2], |axis| before[axis] + dt * a[axis] * kick);
            let moving = match integration {
                Integration::KickDrift => after,
                Integration::DriftKick => before,
                // As far in the first step too, whose kick may be half of one.
                Integration::Taylor => plus(before, times(0.5 * dt, a)),
            };
            let spin_rate = if i < turning {
                self.spin_rate(i)
            } else {
                [0.0; 3]
            };
            let grain = &mut self.motions[i];
            grain.velocity = after;
            grain.place = plus(grain.place, times(dt, moving));
            if i < turning {
                for (spin, rate) in grain.spin.iter_mut().zip(spin_rate) {
                    *spin += dt * rate * kick;
                }
            }
        }
    }

    /// How fast the spin of grain `i` grows with local damping, rad/s².
    #[inline(always)]
    fn spin_rate(&self, i: usize) -> Vector {
        let Constants { dt, alpha, .. } = self.constants;
        let (spin, inertia) = (self.motions[i].spin, self.sizes.inertia[i]);
        let turn = each(self.torque[i], |torque| torque / inertia);
        if self.rules().damped_spins == DampedSpins::Undamped {
            return turn;
        }
        let judged_at = match self.has(Form::SpinsDampedByOld) {
            true => 0.0,
            false => self.judged_at(),
        };
        let judged = plus(spin, times(judged_at * dt, turn));
        if self.has(Form::SpinsDampedTogether) {
            return times(1.0 - alpha * sign(dot(turn, judged)), turn);
        }
        if self.has(Form::SpinsDampedAlong) {
            let speed = hypot(judged).max(f64::MIN_POSITIVE);
            return minus(turn, times(alpha * hypot(turn) / speed, judged));
        }
        if self.has(Form::SpinsDampedAsVelocities) {
            let by_contacts = each(self.force[i], |force| force / self.sizes.mass[i]);
            let a = plus(by_contacts, in_space(self.constants.gravity));
            let middle = plus(self.motions[i].velocity, times(judged_at * dt, a));
            return each([0, 1, 2], |axis| {
                turn[axis] * (1.0 - alpha * sign(a[axis] * middle[axis]))
            });
        }
        each([0, 1, 2], |axis| {
            turn[axis] * (1.0 - alpha * sign(turn[axis] * judged[axis]))
        })
    }

    /// How much of the kick the velocity has whose sign local damping takes.
    #[inline(always)]
    fn judged_at(&self) -> f64 {
        match self.rules().damping_velocity {
            DampingVelocity::Middle => 0.5,
            DampingVelocity::Before => 0.0,
            DampingVelocity::After => 1.0,
        }
    }

    /// That of grain `i` with local damping, m/s².
    #[inline(always)]
    fn acceleration(&self, i: usize, velocity: Vector) -> Vector {
        let Constants { dt, alpha, .. } = self.constants;
        let gravity = in_space(self.constants.gravity);
        let by_contacts = each(self.force[i], |force| force / self.sizes.mass[i]);
        let a = plus(by_contacts, gravity);
        if alpha == 0.0 {
            return a;
        }
        let spared = self.rules().damped_gravity == DampedGravity::Spared;
        let acting = if spared { by_contacts } else { a };
        let kick = self.judged_at() * dt;
        let judged = plus(velocity, times(kick, a));
        let damped = match self.rules().damping_components {
            DampingComponents::Each => each([0, 1, 2], |axis| {
                acting[axis] * (1.0 - alpha * sign(acting[axis] * judged[axis]))
            }),
            DampingComponents::WholePower => times(1.0 - alpha * sign(dot(acting, judged)), acting),
            DampingComponents::AlongVelocity => {
                let speed = hypot(judged).max(f64::MIN_POSITIVE);
                let drag = alpha * hypot(acting);
                [0, 1, 2].map(|axis| acting[axis] - drag * judged[axis] / speed)
            }
        };
        match spared {
            true => plus(damped, gravity),
            false => damped,
        }
    }

    fn places(&self) -> Vec<Vector> {
        self.motions.iter().map(|grain| grain.place).collect()
    }

    fn evaluate(&mut self) {
        let Some(before) = self.before.take() else {
            return self.forces();
        };
        let now = self.places();
        self.put_at(&before);
        self.forces();
        self.put_at(&now);
    }

    fn put_at(&mut self, places: &[Vector]) {
        for (grain, place) in self.motions.iter_mut().zip(places) {
            grain.place = *place;
        }
    }

    fn forces(&mut self) {
        self.clear_sums();
        let mut touching = std::mem::take(&mut self.touching);
        touching.clear();
        self.find_touching(&mut touching);
        self.find_at_obstacles(&mut touching);
        self.find_at_punch(&mut touching);
        self.add_forces(touching);
    }

    fn clear_sums(&mut self) {
        let grains = self.motions.len();
        for sums in [&mut self.force, &mut self.torque] {
            sums.clear();
            sums.resize(grains, [0.0; 3]);
        }
    }

    /// Adds what these contacts do to the sums.
    fn add_forces(&mut self, mut touching: Vec<Touching>) {
        let ids = touching.iter().map(|touch| touch.ids);
        let all: Option<BTreeSet<Ids>> = self.has(Form::NotFound).then(|| ids.collect());
        let mut found = None;
        if self.has(Form::FoundLate) || self.has(Form::OldNormals) {
            let normals = touching.iter().map(|pair| (pair.ids, pair.touch.normal));
            found = Some(normals.collect());
        }
        touching.retain(|pair| self.is_found(pair.ids));
        let mut before = std::mem::take(&mut self.spare);
        before.clear();
        std::mem::swap(&mut before, &mut self.memories);
        // Both are sorted by ids.
        let mut remembering = before.iter().peekable();
        let mut on_punch = 0.0;
        for Touching { ids, touch, force } in &mut touching {
            if self.has(Form::OldNormals) {
                touch.normal = *self.touched.get(ids).unwrap_or(&touch.normal);
            }
            let (one, two) = (ids.0 as usize, ids.1 as usize);
            while remembering.next_if(|memory| memory.ids < *ids).is_some() {}
            let remembered = remembering.next_if(|memory| memory.ids == *ids);
            let action = self.at(touch.first, |there| there.act(*ids, touch, remembered));
            *force = action.force;
            self.memories.extend(action.memory);
            let only = |side| touch.first == Body::Grain && self.has(Form::OneSided(side));
            let (first_feels, second_feels) = (!only(1), !only(0));
            if touch.first == Body::Grain && first_feels {
                self.force[one] = minus(self.force[one], action.force);
                let torque = plus(self.torque[one], action.torques[0]);
                self.torque[one] = minus(torque, action.moment);
            }
            if second_feels {
                self.force[two] = plus(self.force[two], action.force);
                let torque = plus(self.torque[two], action.torques[1]);
                self.torque[two] = plus(torque, action.moment);
            }
            if touch.first == Body::Punch {
                on_punch -= action.force[2];
            }
        }
        if let Some(punch) = &mut self.punch {
            punch.force = on_punch;
        }
        if self.listed.is_none() {
            self.listed = all;
        }
        if let Some(found) = found {
            self.touched = found;
        }
        (self.touching, self.spare) = (touching, before);
    }

    /// Whether a pair that touches is noticed.
    fn is_found(&self, ids: Ids) -> bool {
        let late = self.has(Form::FoundLate) && self.steps > 0 && !self.touched.contains_key(&ids);
        !late
            && self
                .listed
                .as_ref()
                .is_none_or(|pairs| pairs.contains(&ids))
    }

    /// The grains as they are written.
    fn written(&self) -> Bodies {
        let dt = self.constants.dt;
        if self.steps == 0 || self.rules().written_velocities != WrittenVelocities::WholeStep {
            return self.bodies();
        }
        let mut motions = self.motions.clone();
        for (i, grain) in motions.iter_mut().enumerate() {
            let a = self.acceleration(i, grain.velocity);
            grain.velocity = plus(grain.velocity, times(0.5 * dt, a));
            if self.constants.law.rotates() {
                grain.spin = plus(grain.spin, times(0.5 * dt, self.spin_rate(i)));
            }
        }
        self.table(&motions)
    }

    /// This moment as a table.
    pub fn snapshot(&self) -> Snapshot {
        let (contacts, across) = self.contacts_with_across();
        Snapshot {
            stage: Stage::Settle,
            step: self.steps,
            time: self.steps as f64 * self.constants.dt,
            bodies: self.written(),
            contacts,
            across,
            memory: match self.sizes.in_space {
                true => self.memory(),
                false => Memories::default(),
            },
            punch: self.punch,
        }
    }
}

impl Touching {
    /// A row of the table of contacts in the plane.
    fn in_plane(&self) -> Contact {
        let (touch, [fx, fz]) = (&self.touch, in_plane(self.force));
        let [nx, nz] = in_plane(touch.normal);
        Contact {
            id1: self.ids.0,
            id2: self.ids.1,
            overlap: touch.overlap,
            normal_force: fx * nx + fz * nz,
            tangential_force: tangential(fz * nx - fx * nz),
            normal: [nx, nz],
            point: in_plane(touch.point),
        }
    }

    /// The same in space.
    fn in_space(&self) -> (Contact, Across) {
        let touch = &self.touch;
        let normal_force = dot(self.force, touch.normal);
        let tangential = minus(self.force, times(normal_force, touch.normal));
        let across = Across {
            normal: touch.normal[1],
            point: touch.point[1],
            tangential,
        };
        let contact = Contact {
            normal_force,
            tangential_force: norm(tangential),
            ..self.in_plane()
        };
        (contact, across)
    }
}

fn motions(bodies: &Bodies) -> Vec<Motion> {
    // A law without rotation may be followed by one with it; what is across the plane is zero in it.
    let value = |column: &[f64], i: usize| column.get(i).copied().unwrap_or(0.0);
    let motion = |i: usize| Motion {
        place: [bodies.x[i], value(&bodies.y, i), bodies.z[i]],
        velocity: [bodies.vx[i], value(&bodies.vy, i), bodies.vz[i]],
        spin: [&bodies.spin_x, &bodies.spin, &bodies.spin_z].map(|column| value(column, i)),
    };
    (0..bodies.len()).map(motion).collect()
}

/// Two bodies of twice these constants in series, as the law with dashpots adds them.
fn series(a: f64, b: f64) -> f64 {
    1.0 / (1.0 / (2.0 * a) + 1.0 / (2.0 * b))
}

#[inline(always)]
fn sign(number: f64) -> f64 {
    f64::from(u8::from(number > 0.0)) - f64::from(u8::from(number < 0.0))
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
