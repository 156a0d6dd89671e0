//! The step written out plainly, with no lists, no lanes and nothing of the engine but its constants: every pair that touches in
//! the order of ids, walls after grains, the punch last, and what contacts remember in a map. Slow and obvious; the engine must
//! have its bits. With a [`Variant`] it is what another engine may do instead.

use std::collections::{BTreeMap, BTreeSet};

use crate::constant::Given;
use crate::model::{Model, Wall, damping_ratio};
use crate::native::state::Constants;
use crate::rules::{
    Arms, ArmsAtWalls, DampedGravity, DampedSpins, DampingComponents, DampingVelocity,
    GivenVelocities, Integration, LimitFrom, NewContact, RestitutionFormula, Rules, Slip,
    SlipAdded, SlipAtWalls, SpringTurn, SpringWhenSliding, StiffnessMean, TangentialDashpot,
    TensionRule, WallMass, WallStiffness, WrittenVelocities,
};
use crate::scene::{Tension, Viscosity};
use crate::tables::{Bodies, Body, Contact, Punch, Remembered, Snapshot, Stage, tangential};
use crate::variant::{Form, Variant};

/// Grains, what their contacts remember and what pushes them. After each step the forces belong to the positions.
#[derive(Clone)]
pub struct Reference {
    variant: Variant,
    constants: Constants,
    /// tan φ between grains, at walls and at the punch.
    tangents: [f64; 3],
    /// The grains now; radii are those at contacts.
    pub bodies: Bodies,
    /// The punch now.
    pub punch: Option<Punch>,
    /// The contacts of the last evaluation, sorted by ids.
    pub contacts: Vec<Contact>,
    force: Vec<[f64; 2]>,
    torque: Vec<f64>,
    /// What contacts remember, sorted by ids.
    pub memories: Vec<Remembered>,
    steps: u64,
    /// The radii that stiffnesses are made from, m.
    stiffness_radius: Vec<f64>,
    /// The punch that grains feel.
    felt: Option<Punch>,
    /// x and z before the step, where forces are those of them.
    before: Option<[Vec<f64>; 2]>,
    /// Normals of the pairs that touched at the last evaluation, where a form asks for them.
    touched: BTreeMap<Ids, [f64; 2]>,
    /// Pairs that touched at the start, where others are not found.
    listed: Option<BTreeSet<Ids>>,
    near: Near,
}

/// Pairs of grains that are not far apart, as long as no grain has gone far.
#[derive(Clone, Default)]
struct Near {
    pairs: Vec<(u32, u32)>,
    /// x and z where they were looked for.
    at: [Vec<f64>; 2],
}

/// How much farther apart than two of the largest grains is not far, over the largest radius.
const NEAR: f64 = 0.4;

type Ids = (u32, u32);

/// Where two bodies touch; the normal points from body 1 to body 2.
#[derive(Clone, Copy)]
struct Touch {
    first: Body,
    overlap: f64,
    normal: [f64; 2],
    point: [f64; 2],
    radii: [f64; 2],
    slip: Slip,
}

/// How one side of a contact moves.
#[derive(Clone, Copy, Default)]
struct Motion {
    place: [f64; 2],
    velocity: [f64; 2],
    spin: f64,
}

/// k_n, k_s and c_n of a pair.
struct Strength {
    k_n: f64,
    k_s: f64,
    c_n: f64,
}

impl Reference {
    /// The forces at the start belong to it.
    pub fn new(model: &Model, bodies: &Bodies, punch: Option<Punch>, variant: &Variant) -> Self {
        let mut given = Given::new(model, bodies, punch);
        for (constant, larger) in &variant.larger {
            constant.enlarge(&mut given, *larger);
        }
        Reference::going_on(given, &[], variant)
    }

    /// The same from contacts that remember something; where they do, the forces at the start are those that they remember.
    pub(crate) fn going_on(given: Given, memory: &[Remembered], variant: &Variant) -> Self {
        let Given {
            constants,
            mut bodies,
            punch,
        } = given;
        // A law without rotation may be followed by one with it.
        let spins = bodies.inertia.len();
        bodies.spin.resize(spins, 0.0);
        let in_classes = variant.forms.iter().find_map(|form| match form {
            Form::ClassesOfRadius(most) => in_classes(&bodies.radius, *most),
            _ => None,
        });
        let mut reference = Reference {
            variant: variant.clone(),
            tangents: [0.0; 3],
            stiffness_radius: in_classes.unwrap_or_else(|| bodies.radius.clone()),
            bodies,
            felt: punch,
            punch,
            contacts: Vec::new(),
            force: Vec::new(),
            torque: Vec::new(),
            memories: memory.to_vec(),
            steps: 0,
            before: None,
            touched: BTreeMap::new(),
            listed: None,
            near: Near::default(),
            constants,
        };
        reference.choose();
        match memory.is_empty() {
            true => reference.evaluate(),
            false => reference.look(),
        }
        reference
    }

    /// Evaluates the forces without slip or limit, so that what contacts remember stays.
    fn look(&mut self) {
        let dt = std::mem::replace(&mut self.constants.dt, 0.0);
        let tangents = std::mem::replace(&mut self.tangents, [f64::INFINITY; 3]);
        self.forces();
        (self.constants.dt, self.tangents) = (dt, tangents);
    }

    /// The same grains where they are told to be instead, by an engine with errors of its own.
    pub(crate) fn moved(&self, bodies: &Bodies, punch: Option<Punch>) -> Self {
        let mut moved = self.clone();
        moved.put(bodies, punch);
        if moved.bodies != self.bodies {
            moved.look();
        }
        moved
    }

    /// Puts grains and punch there; forces stay those of the last evaluation.
    pub(crate) fn put(&mut self, bodies: &Bodies, punch: Option<Punch>) {
        let to = &mut self.bodies;
        to.x.clone_from(&bodies.x);
        to.z.clone_from(&bodies.z);
        to.vx.clone_from(&bodies.vx);
        to.vz.clone_from(&bodies.vz);
        to.spin.clone_from(&bodies.spin);
        if self.punch.is_none() {
            self.felt = punch;
        }
        self.punch = punch;
    }

    /// Force, N, and torque, N·m, on each grain.
    pub(crate) fn loads(&self) -> (&[[f64; 2]], &[f64]) {
        (&self.force, &self.torque)
    }

    /// Goes on with another model: forces are those of the old one until the next step, contacts keep what they remember.
    pub fn change(&mut self, model: &Model) {
        let mut given = Given::new(model, &self.bodies, self.punch);
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

    /// Sets a punch on the bed; grains feel it from the next step on.
    pub fn press(&mut self, punch: Punch) {
        (self.punch, self.felt) = (Some(punch), Some(punch));
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
        if let Some(punch) = &mut self.punch {
            self.felt = Some(*punch);
            punch.centre[1] += punch.velocity * self.constants.dt;
        }
        if !self.has(Form::PunchLate) {
            self.felt = self.punch;
        }
        if self.has(Form::OldPositions) {
            self.before = Some([self.bodies.x.clone(), self.bodies.z.clone()]);
        }
        self.integrate();
        self.steps += 1;
        self.evaluate();
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
        for i in 0..self.bodies.len() {
            let before = [self.bodies.vx[i], self.bodies.vz[i]];
            let a = self.acceleration(i, before);
            // Multiplied by one where the kick is whole, which keeps the bits.
            let after = [0, 1].map(|axis| before[axis] + dt * a[axis] * kick);
            let moving = match integration {
                Integration::KickDrift => after,
                Integration::DriftKick => before,
                // As far in the first step too, whose kick may be half of one.
                Integration::Taylor => [0, 1].map(|axis| before[axis] + 0.5 * dt * a[axis]),
            };
            let bodies = &mut self.bodies;
            [bodies.vx[i], bodies.vz[i]] = after;
            bodies.x[i] += dt * moving[0];
            bodies.z[i] += dt * moving[1];
        }
        if self.constants.law.rotates() && !self.has(Form::SpinsKept) {
            for i in 0..self.bodies.spin.len() {
                self.bodies.spin[i] += dt * self.spin_rate(i) * kick;
            }
        }
    }

    /// How fast the spin of grain `i` grows with local damping, rad/s².
    fn spin_rate(&self, i: usize) -> f64 {
        let Constants { dt, alpha, .. } = self.constants;
        let turn = self.torque[i] / self.bodies.inertia[i];
        match self.rules().damped_spins {
            DampedSpins::Undamped => turn,
            DampedSpins::Damped => {
                let judged = self.bodies.spin[i] + self.judged_at() * dt * turn;
                turn * (1.0 - alpha * sign(turn * judged))
            }
        }
    }

    /// How much of the kick the velocity has whose sign local damping takes.
    fn judged_at(&self) -> f64 {
        match self.rules().damping_velocity {
            DampingVelocity::Middle => 0.5,
            DampingVelocity::Before => 0.0,
            DampingVelocity::After => 1.0,
        }
    }

    /// That of grain `i` with local damping, m/s².
    fn acceleration(&self, i: usize, velocity: [f64; 2]) -> [f64; 2] {
        let Constants {
            dt, gravity, alpha, ..
        } = self.constants;
        let by_contacts = self.force[i].map(|force| force / self.bodies.mass[i]);
        let a = [0, 1].map(|axis| by_contacts[axis] + gravity[axis]);
        if alpha == 0.0 {
            return a;
        }
        let spared = self.rules().damped_gravity == DampedGravity::Spared;
        let acting = if spared { by_contacts } else { a };
        let judged = [0, 1].map(|axis| velocity[axis] + self.judged_at() * dt * a[axis]);
        let power = [0, 1].map(|axis| acting[axis] * judged[axis]);
        let damped = match self.rules().damping_components {
            DampingComponents::Each => {
                [0, 1].map(|axis| acting[axis] * (1.0 - alpha * sign(power[axis])))
            }
            DampingComponents::WholePower => {
                acting.map(|part| part * (1.0 - alpha * sign(power[0] + power[1])))
            }
            DampingComponents::AlongVelocity => {
                let speed = judged[0].hypot(judged[1]).max(f64::MIN_POSITIVE);
                let size = acting[0].hypot(acting[1]);
                [0, 1].map(|axis| acting[axis] - alpha * size * judged[axis] / speed)
            }
        };
        match spared {
            true => [0, 1].map(|axis| damped[axis] + gravity[axis]),
            false => damped,
        }
    }

    fn evaluate(&mut self) {
        if let Some([x, z]) = self.before.take() {
            let x = std::mem::replace(&mut self.bodies.x, x);
            let z = std::mem::replace(&mut self.bodies.z, z);
            self.forces();
            (self.bodies.x, self.bodies.z) = (x, z);
        } else {
            self.forces();
        }
    }

    fn forces(&mut self) {
        let grains = self.bodies.len();
        self.force = vec![[0.0; 2]; grains];
        self.torque = vec![0.0; grains];
        self.contacts.clear();
        let touching = self.touching();
        let room = Vec::with_capacity(touching.len());
        let before = std::mem::replace(&mut self.memories, room);
        // Both are sorted by ids.
        let mut before = before.into_iter().peekable();
        let mut on_punch = 0.0;
        for (ids, touch) in &touching {
            if !self.is_found(*ids) {
                continue;
            }
            let mut touch = *touch;
            if self.has(Form::OldNormals) {
                touch.normal = *self.touched.get(ids).unwrap_or(&touch.normal);
            }
            let (one, two) = (ids.0 as usize, ids.1 as usize);
            while before
                .next_if(|memory| (memory.id1, memory.id2) < *ids)
                .is_some()
            {}
            let remembered = before.next_if(|memory| (memory.id1, memory.id2) == *ids);
            let (force, torques) = self.act(*ids, &touch, remembered);
            let only = |side| touch.first == Body::Grain && self.has(Form::OneSided(side));
            let (first_feels, second_feels) = (!only(1), !only(0));
            if touch.first == Body::Grain && first_feels {
                self.force[one][0] -= force[0];
                self.force[one][1] -= force[1];
                self.torque[one] += torques[0];
            }
            if second_feels {
                self.force[two][0] += force[0];
                self.force[two][1] += force[1];
                self.torque[two] += torques[1];
            }
            if touch.first == Body::Punch {
                on_punch -= force[1];
            }
        }
        if let Some(punch) = &mut self.punch {
            punch.force = on_punch;
        }
        let ids = touching.iter().map(|(ids, _)| *ids);
        if self.has(Form::NotFound) && self.listed.is_none() {
            self.listed = Some(ids.collect());
        }
        if self.has(Form::FoundLate) || self.has(Form::OldNormals) {
            let normals = touching.iter().map(|(ids, touch)| (*ids, touch.normal));
            self.touched = normals.collect();
        }
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

    /// Bodies that touch, in the order in which their forces are summed: grains, then walls and grains, then the punch.
    fn touching(&mut self) -> Vec<(Ids, Touch)> {
        let mut all = self.touching_grains();
        let (grains, ids) = (self.bodies.len(), self.constants.ids);
        for (index, wall) in self.constants.walls.iter().enumerate() {
            if !self.has(Form::WallMissing(index)) {
                let touch = |i| Some(((ids.wall(index), i as u32), self.wall(wall, i)?));
                all.extend((0..grains).filter_map(touch));
            }
        }
        if let Some(punch) = &self.felt {
            let touch = |i| Some(((ids.punch(), i as u32), self.punch(punch, i)?));
            all.extend((0..grains).filter_map(touch));
        }
        all
    }

    /// Grains that touch, in the order of their ids.
    fn touching_grains(&mut self) -> Vec<(Ids, Touch)> {
        let largest = self.bodies.radius.iter().copied().fold(0.0, f64::max);
        let [x, z] = &self.near.at;
        let gone = |(now, then): (&f64, &f64)| (now - then).abs() > 0.25 * NEAR * largest;
        let has_gone =
            |now: &[f64], then: &[f64]| now.len() != then.len() || now.iter().zip(then).any(gone);
        if has_gone(&self.bodies.x, x) || has_gone(&self.bodies.z, z) {
            self.near = near(&self.bodies, (2.0 + NEAR) * largest);
        }
        let pairs = self.near.pairs.iter();
        let touch = |(i, j): &Ids| Some(((*i, *j), self.grains(*i as usize, *j as usize)?));
        pairs.filter_map(touch).collect()
    }

    fn place(&self, i: usize) -> [f64; 2] {
        [self.bodies.x[i], self.bodies.z[i]]
    }

    fn grains(&self, i: usize, j: usize) -> Option<Touch> {
        let ([x1, z1], [x2, z2]) = (self.place(i), self.place(j));
        let (r1, r2) = (self.bodies.radius[i], self.bodies.radius[j]);
        let (dx, dz) = (x2 - x1, z2 - z1);
        let distance = (dx * dx + dz * dz).sqrt();
        let overlap = r1 + r2 - distance;
        let normal = [dx / distance, dz / distance];
        let arm = r1 - 0.5 * overlap;
        let is_lost = self.variant.forms.iter().any(|form| match form {
            Form::LostNear(near) => distance < *near,
            Form::LostFar(far) => distance > *far,
            _ => false,
        });
        (overlap >= 0.0 && !is_lost).then_some(Touch {
            first: Body::Grain,
            overlap,
            normal,
            point: [x1 + arm * normal[0], z1 + arm * normal[1]],
            radii: [r1, r2],
            slip: self.rules().slip,
        })
    }

    fn wall(&self, wall: &Wall, i: usize) -> Option<Touch> {
        let (axis, radius) = (wall.axis as usize, self.bodies.radius[i]);
        let mut point = self.place(i);
        let distance = point[axis] - wall.place;
        let overlap = radius - distance.abs();
        let mut normal = [0.0; 2];
        normal[axis] = if distance > 0.0 { 1.0 } else { -1.0 };
        point[axis] = wall.place;
        (overlap >= 0.0).then_some(Touch {
            first: Body::Wall,
            overlap,
            normal,
            point,
            radii: [radius; 2],
            slip: self.slip_at_walls(self.rules().slip),
        })
    }

    fn punch(&self, punch: &Punch, i: usize) -> Option<Touch> {
        let ([x, z], radius) = (self.place(i), self.bodies.radius[i]);
        let ([cx, cz], [ex, ez]) = (punch.centre, punch.half_extents);
        let (rx, rz) = (x - cx, z - cz);
        let flat = |overlap, normal, point, slip| Touch {
            first: Body::Punch,
            overlap,
            normal,
            point,
            radii: [radius; 2],
            slip,
        };
        if rx.abs() <= ex && rz.abs() <= ez {
            // Centre inside: out by the nearest face.
            let (to_side, to_end) = (ex - rx.abs(), ez - rz.abs());
            let side = |offset: f64| if offset > 0.0 { 1.0 } else { -1.0 };
            let (normal, depth) = if to_end < to_side {
                ([0.0, side(rz)], to_end)
            } else {
                ([side(rx), 0.0], to_side)
            };
            let face = [x + normal[0] * depth, z + normal[1] * depth];
            let deepest = [x - normal[0] * radius, z - normal[1] * radius];
            return Some(flat(
                (face[0] - deepest[0]).hypot(face[1] - deepest[1]),
                normal,
                [0.5 * (face[0] + deepest[0]), 0.5 * (face[1] + deepest[1])],
                // As in YADE, whatever is chosen; its law with dashpots never corrects.
                self.slip_at_walls(match self.constants.law.has_dashpots() {
                    false => Slip::Corrected,
                    true => Slip::ContactPoint,
                }),
            ));
        }
        if rx.abs() > ex && rz.abs() > ez && self.has(Form::CornersMissing) {
            return None;
        }
        let (nearest_x, nearest_z) = (rx.max(-ex).min(ex), rz.max(-ez).min(ez));
        let (sx, sz) = (nearest_x - rx, nearest_z - rz);
        let distance = (sx * sx + sz * sz).sqrt();
        let overlap = radius - distance;
        let normal = [-(sx / distance), -(sz / distance)];
        let deepest = [x - normal[0] * radius, z - normal[1] * radius];
        let [px, pz] = [nearest_x + cx, nearest_z + cz];
        let point = [0.5 * (px + deepest[0]), 0.5 * (pz + deepest[1])];
        let slip = self.slip_at_walls(Slip::ContactPoint);
        (overlap >= 0.0).then(|| flat(overlap, normal, point, slip))
    }

    /// Which slip a flat body has that has this one as between grains.
    fn slip_at_walls(&self, as_slip: Slip) -> Slip {
        match self.rules().slip_at_walls {
            SlipAtWalls::AsSlip => as_slip,
            SlipAtWalls::ContactPoint => Slip::ContactPoint,
            SlipAtWalls::Unstretched | SlipAtWalls::HalfOverlap => Slip::Unstretched,
        }
    }

    /// k_n, k_s and c_n of these bodies.
    fn strength(&self, ids: Ids, touch: &Touch) -> Strength {
        let constants = &self.constants;
        let two = ids.1 as usize;
        let m2 = self.bodies.mass[two];
        let (radii, mass) = match touch.first {
            Body::Grain => {
                let one = ids.0 as usize;
                let m1 = self.bodies.mass[one];
                let radii = [one, two].map(|i| self.stiffness_radius[i]);
                (radii, m1 * m2 / (m1 + m2))
            }
            Body::Wall => ([self.stiffness_radius[two]; 2], self.wall_mass(m2)),
            Body::Punch => (touch.radii, self.wall_mass(m2)),
        };
        let [a, b] = radii.map(|radius| constants.law.modulus * radius);
        let [c, d] = [a, b].map(|side| side * constants.law.stiffness_ratio);
        let (mut k_n, mut k_s) = match constants.law.has_dashpots() {
            false => (2.0 * a * b / (a + b), 2.0 * c * d / (c + d)),
            true => (series(a, b), series(c, d)),
        };
        let rigid = self.rules().wall_stiffness == WallStiffness::Rigid;
        if rigid && touch.first != Body::Grain {
            k_n *= 2.0;
            k_s *= 2.0;
        }
        k_n *= constants.normal_factors[touch.first as usize];
        k_s *= constants.tangential_factor;
        if touch.first == Body::Grain {
            let [r1, r2] = radii;
            let mean = match self.rules().stiffness_mean {
                _ if self.has(Form::StiffnessOfFirst) => Some(r1),
                StiffnessMean::Harmonic => None,
                StiffnessMean::Arithmetic => Some(0.5 * (r1 + r2)),
                StiffnessMean::Geometric => Some((r1 * r2).sqrt()),
                StiffnessMean::Smaller => Some(r1.min(r2)),
                StiffnessMean::Larger => Some(r1.max(r2)),
            };
            if let Some(mean) = mean {
                let right = 2.0 * r1 * r2 / (r1 + r2);
                k_n *= mean / right;
                k_s *= mean / right;
            }
        }
        let mut c_n = match constants.law.contact.viscosity {
            Viscosity::None => 0.0,
            Viscosity::Dashpot { c_n, .. } => series(c_n, c_n),
            Viscosity::Restitution { .. } => {
                2.0 * constants.damping_ratio * (mass * k_n).max(0.0).sqrt()
            }
        };
        c_n *= self.restitution_factor();
        if touch.first == Body::Grain && self.has(Form::DashpotOfMeanMass) {
            let m1 = self.bodies.mass[ids.0 as usize];
            c_n *= 0.5 * (m1 + m2) / (m1 * m2).sqrt() * std::f64::consts::SQRT_2;
        }
        Strength { k_n, k_s, c_n }
    }

    /// The effective mass at walls and punch, kg.
    fn wall_mass(&self, mass: f64) -> f64 {
        match self.rules().wall_mass {
            WallMass::Whole => mass,
            WallMass::Half => 0.5 * mass,
        }
    }

    /// The dashpot by the chosen formula over that of the model.
    fn restitution_factor(&self) -> f64 {
        let Viscosity::Restitution { e_n, tension } = self.constants.law.contact.viscosity else {
            return 1.0;
        };
        let chosen = match self.rules().restitution {
            RestitutionFormula::Cut => Tension::Clipped,
            _ => Tension::Unclipped,
        };
        if chosen == tension {
            return 1.0;
        }
        match damping_ratio(e_n, tension) {
            0.0 => 1.0,
            ratio => damping_ratio(e_n, chosen) / ratio,
        }
    }

    /// How the first of a pair and its grain move; what other forms leave out is left out.
    fn motions(&self, ids: Ids, first: Body) -> [Motion; 2] {
        let spins = !self.has(Form::SlipOfCentres);
        let grain = |id: u32| Motion {
            place: self.place(id as usize),
            velocity: [self.bodies.vx[id as usize], self.bodies.vz[id as usize]],
            spin: match self.bodies.spin.get(id as usize) {
                Some(spin) if spins => *spin,
                _ => 0.0,
            },
        };
        let one = match (first, &self.felt) {
            (Body::Grain, _) => grain(ids.0),
            (Body::Punch, Some(punch)) => Motion {
                place: punch.centre,
                velocity: [0.0, punch.velocity],
                spin: 0.0,
            },
            _ => Motion::default(),
        };
        [one, grain(ids.1)]
    }

    /// What a contact does: the force on body 2, and the torques on both. What it remembers moves on by a step.
    fn act(
        &mut self,
        ids: Ids,
        touch: &Touch,
        remembered: Option<Remembered>,
    ) -> ([f64; 2], [f64; 2]) {
        let strength = self.strength(ids, touch);
        let on = self.motions(ids, touch.first);
        let [nx, nz] = touch.normal;
        let mut normal_force = strength.k_n * touch.overlap;
        let mut clips = false;
        if self.constants.law.has_dashpots() {
            let [vx, vz] = at_contact_point(touch, on);
            normal_force -= strength.c_n * (nx * vx + nz * vz);
            clips = self.rules().tension == TensionRule::Cut;
        }
        // A force that is cut has no direction, not that of −0.
        let normal_force = match normal_force < 0.0 && clips {
            true => [0.0; 2],
            false => [normal_force * nx, normal_force * nz],
        };
        let mut shear = [0.0; 2];
        if self.constants.law.has_friction() {
            let kept;
            (shear, kept) = self.shear(touch, on, &strength, normal_force, remembered);
            self.memories.push(Remembered {
                id1: ids.0,
                id2: ids.1,
                normal: touch.normal,
                shear: kept,
            });
        }
        let force = [normal_force[0] + shear[0], normal_force[1] + shear[1]];
        let [fx, fz] = force;
        self.contacts.push(Contact {
            id1: ids.0,
            id2: ids.1,
            overlap: touch.overlap,
            normal_force: fx * nx + fz * nz,
            tangential_force: tangential(fz * nx - fx * nz),
            normal: touch.normal,
            point: touch.point,
        });
        (force, self.torques(touch, on, force))
    }

    /// The tangential force on body 2, N, and what its spring remembers of it.
    fn shear(
        &self,
        touch: &Touch,
        on: [Motion; 2],
        strength: &Strength,
        normal_force: [f64; 2],
        remembered: Option<Remembered>,
    ) -> ([f64; 2], [f64; 2]) {
        let dt = self.constants.dt;
        let [nx, nz] = touch.normal;
        let before_turn = self.rules().slip_added == SlipAdded::BeforeTurn;
        let before = remembered.map(|memory| (memory.normal, memory.shear));
        let [mut sx, mut sz] = match before {
            Some((_, shear)) if before_turn => shear,
            Some((normal, shear)) => self.turned(normal, shear, touch.normal),
            None => [0.0; 2],
        };
        let [vx, vz] = self.slip_velocity(touch, on);
        let along = nx * vx + nz * vz;
        let [tx, tz] = [vx - along * nx, vz - along * nz];
        // The way since they met, over the way in this step.
        let mut share = 1.0;
        let way = -along * dt;
        match self.rules().new_contact {
            _ if remembered.is_some() => {}
            NewContact::SinceTouch if way > touch.overlap => share = touch.overlap / way,
            NewContact::Nothing => share = 0.0,
            _ => {}
        }
        // YADE's laws with and without a dashpot multiply in different orders.
        let [gx, gz] = match self.constants.law.has_dashpots() {
            false => [strength.k_s * (tx * dt), strength.k_s * (tz * dt)],
            true => [strength.k_s * dt * tx, strength.k_s * dt * tz],
        };
        sx -= share * gx;
        sz -= share * gz;
        if let (true, Some((normal, _))) = (before_turn, before) {
            [sx, sz] = self.turned(normal, [sx, sz], touch.normal);
        }
        let tangent = self.tangents[touch.first as usize];
        let [fx, fz] = normal_force;
        if self.has(Form::NoCoulombLimit) {
            return ([sx, sz], [sx, sz]);
        }
        if self.has(Form::CoulombByComponent) {
            let limit = fx.hypot(fz) * tangent;
            let limited = [sx, sz].map(|part| part.max(-limit).min(limit));
            return (limited, limited);
        }
        let limit_squared = match self.rules().limit_from {
            LimitFrom::Spring => (strength.k_n * touch.overlap * tangent).powi(2),
            LimitFrom::WholeForce => (fx * fx + fz * fz) * (tangent * tangent),
        };
        let limited = |[x, z]: [f64; 2]| {
            let squared = x * x + z * z;
            if squared > limit_squared {
                let cut = limit_squared.sqrt() / squared.sqrt();
                return [x * cut, z * cut];
            }
            [x, z]
        };
        let dashpot = self.rules().tangential_dashpot;
        let braking = match dashpot {
            TangentialDashpot::None => [0.0; 2],
            _ => [-strength.c_n * tx, -strength.c_n * tz],
        };
        let within = match dashpot {
            TangentialDashpot::Within => [sx + braking[0], sz + braking[1]],
            _ => [sx, sz],
        };
        let cut = limited(within);
        let slides = cut != within;
        let kept = match (slides, self.rules().spring_when_sliding, dashpot) {
            // What is left for the spring where both are limited together.
            (true, SpringWhenSliding::Limited, TangentialDashpot::Within) => {
                [cut[0] - braking[0], cut[1] - braking[1]]
            }
            (true, SpringWhenSliding::Limited, _) => cut,
            (true, SpringWhenSliding::Nothing, _) => [0.0; 2],
            _ => [sx, sz],
        };
        let is_added = match dashpot {
            TangentialDashpot::Beyond => true,
            TangentialDashpot::WhileSticking => !slides,
            _ => false,
        };
        let force = match is_added {
            true => [cut[0] + braking[0], cut[1] + braking[1]],
            false => cut,
        };
        (force, kept)
    }

    /// The tangential force of the step before, turned with the normal.
    fn turned(&self, normal: [f64; 2], shear: [f64; 2], [nx, nz]: [f64; 2]) -> [f64; 2] {
        let [sx, sz] = shear;
        if self.has(Form::HistoryReset) {
            return [0.0; 2];
        }
        if normal == [nx, nz] {
            return shear;
        }
        let rule = self.rules().spring_turn;
        if rule == SpringTurn::NotTurned {
            return shear;
        }
        if rule != SpringTurn::FirstOrder {
            let along = sx * nx + sz * nz;
            let projected = [sx - along * nx, sz - along * nz];
            let size = projected[0].hypot(projected[1]);
            let grows = rule == SpringTurn::KeepsLength && size > 0.0;
            let factor = if grows { sx.hypot(sz) / size } else { 1.0 };
            return projected.map(|part| factor * part);
        }
        let mut turn = normal[1] * nx - normal[0] * nz;
        if self.has(Form::HistoryTurnedBack) {
            turn = -turn;
        }
        [sx + sz * turn, sz - sx * turn]
    }

    /// That of body 2 against body 1, of which the tangential part is the slip, m/s.
    fn slip_velocity(&self, touch: &Touch, on: [Motion; 2]) -> [f64; 2] {
        if touch.slip == Slip::ContactPoint {
            return at_contact_point(touch, on);
        }
        let ([mut r1, mut r2], [nx, nz], [one, two]) = (touch.radii, touch.normal, on);
        if touch.first != Body::Grain && self.rules().slip_at_walls == SlipAtWalls::HalfOverlap {
            [r1, r2] = [r1, r2].map(|radius| radius - 0.5 * touch.overlap);
        }
        let stretch = match touch.slip {
            Slip::Unstretched => 1.0,
            _ => (r1 + r2) / (r1 + r2 - touch.overlap),
        };
        let [vx, vz] = [0, 1].map(|axis| (two.velocity[axis] - one.velocity[axis]) * stretch);
        [
            (vx + two.spin * (-r2 * nz)) - one.spin * (r1 * nz),
            (vz + -(two.spin * (-r2 * nx))) - -(one.spin * (r1 * nx)),
        ]
    }

    /// On body 1 and body 2 of a force on body 2, N·m.
    fn torques(&self, touch: &Touch, on: [Motion; 2], force: [f64; 2]) -> [f64; 2] {
        let is_flat = touch.first != Body::Grain;
        if !self.constants.law.rotates() || is_flat && self.has(Form::NoTorqueOfFlatBodies) {
            return [0.0; 2];
        }
        let [nx, nz] = touch.normal;
        let [fx, fz] = force.map(|part| -part);
        let arms = match self.rules().torque_arms_at_walls {
            ArmsAtWalls::HalfOverlap if is_flat => Arms::HalfOverlap,
            ArmsAtWalls::ContactPoint if is_flat => Arms::ContactPoint,
            ArmsAtWalls::WholeRadius if is_flat => Arms::WholeRadii,
            _ => self.rules().torque_arms,
        };
        let mut torques = match arms {
            Arms::WholeRadii => touch.radii.map(|radius| radius * (nz * fx - nx * fz)),
            Arms::HalfOverlap | Arms::AsModel => {
                let turn = nz * fx - nx * fz;
                touch.radii.map(|r| (r - 0.5 * touch.overlap) * turn)
            }
            Arms::ContactPoint => {
                let [[x1, z1], [x2, z2]] =
                    on.map(|motion| [0, 1].map(|axis| touch.point[axis] - motion.place[axis]));
                [z1 * fx - x1 * fz, z2 * -fx - x2 * -fz]
            }
        };
        if self.has(Form::TorqueSign) {
            torques[1] = -torques[1];
        }
        torques
    }

    /// The grains as they are written.
    pub(crate) fn written(&self) -> Bodies {
        let mut bodies = self.bodies.clone();
        let dt = self.constants.dt;
        if self.steps > 0 && self.rules().written_velocities == WrittenVelocities::WholeStep {
            for i in 0..bodies.len() {
                let velocity = [bodies.vx[i], bodies.vz[i]];
                let a = self.acceleration(i, velocity);
                bodies.vx[i] += 0.5 * dt * a[0];
                bodies.vz[i] += 0.5 * dt * a[1];
                if self.constants.law.rotates() {
                    bodies.spin[i] += 0.5 * dt * self.spin_rate(i);
                }
            }
        }
        bodies
    }

    /// This moment as a table.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            stage: Stage::Settle,
            step: self.steps,
            time: self.steps as f64 * self.constants.dt,
            bodies: self.written(),
            contacts: self.contacts.clone(),
            memory: Vec::new(),
            punch: self.punch,
        }
    }
}

/// Pairs of grains no farther apart than this in x and in z, in the order of their ids.
fn near(bodies: &Bodies, reach: f64) -> Near {
    let mut order: Vec<usize> = (0..bodies.len()).collect();
    order.sort_by(|a, b| bodies.x[*a].total_cmp(&bodies.x[*b]));
    let mut pairs = Vec::new();
    for (at, a) in order.iter().enumerate() {
        let beyond = order[at + 1..].iter();
        for b in beyond.take_while(|b| bodies.x[**b] - bodies.x[*a] <= reach) {
            if (bodies.z[*b] - bodies.z[*a]).abs() <= reach {
                pairs.push((*a.min(b) as u32, *a.max(b) as u32));
            }
        }
    }
    pairs.sort_unstable();
    let at = [bodies.x.clone(), bodies.z.clone()];
    Near { pairs, at }
}

/// Velocity of body 2 against body 1 at the contact point, m/s.
fn at_contact_point(touch: &Touch, on: [Motion; 2]) -> [f64; 2] {
    let [v1, v2] = on.map(|motion| {
        let [ax, az] = [0, 1].map(|axis| touch.point[axis] - motion.place[axis]);
        let [vx, vz] = motion.velocity;
        [vx + motion.spin * az, vz - motion.spin * ax]
    });
    [v2[0] - v1[0], v2[1] - v1[1]]
}

/// Two bodies of twice these constants in series, as the law with dashpots adds them.
fn series(a: f64, b: f64) -> f64 {
    1.0 / (1.0 / (2.0 * a) + 1.0 / (2.0 * b))
}

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
