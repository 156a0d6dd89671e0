//! The tables that every engine takes and returns. SI units; x across, z up.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::vector::Vector;

/// Grains, column by column; all columns have the same length and the row is the grain's id.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bodies {
    /// Centre, m.
    pub x: Vec<f64>,
    /// Centre, m.
    pub z: Vec<f64>,
    /// Velocity, m/s. In both engines it belongs to the half step before the position.
    pub vx: Vec<f64>,
    /// Velocity, m/s.
    pub vz: Vec<f64>,
    /// m.
    pub radius: Vec<f64>,
    /// kg.
    pub mass: Vec<f64>,
    /// Spin about the y axis (from z towards x), rad/s, at the half step like the velocity; empty where
    /// grains do not rotate.
    pub spin: Vec<f64>,
    /// Moment of inertia about the centre, kg·m²; empty where grains do not rotate.
    pub inertia: Vec<f64>,
    /// The third coordinate, which makes x, y, z right-handed, m; this and the columns below are empty in the plane.
    pub y: Vec<f64>,
    /// Velocity, m/s.
    pub vy: Vec<f64>,
    /// Spin about the x axis, rad/s; empty where grains do not rotate.
    pub spin_x: Vec<f64>,
    /// Spin about the z axis, rad/s; empty where grains do not rotate.
    pub spin_z: Vec<f64>,
    /// Material; empty where all are of material 0.
    pub material: Vec<u32>,
}

impl Bodies {
    /// Σ ½mv², then Σ ½Iω², grain by grain, J, with the velocities as stored: half a step before the positions.
    pub fn kinetic_energy(&self) -> f64 {
        let mut energy = 0.0;
        let moving = self
            .mass
            .iter()
            .zip(&self.vx)
            .zip(&self.vz)
            .zip(across(&self.vy));
        for (((mass, vx), vz), vy) in moving {
            energy += 0.5 * mass * (vx * vx + (vy * vy + vz * vz));
        }
        let spins = across(&self.spin_x)
            .zip(&self.spin)
            .zip(across(&self.spin_z));
        for (inertia, ((x, y), z)) in self.inertia.iter().zip(spins) {
            energy += 0.5 * inertia * (x * x + (y * y + z * z));
        }
        energy
    }

    /// Whether they are in space.
    pub fn in_space(&self) -> bool {
        !self.y.is_empty()
    }

    /// Adds a grain; its id is the number of grains before it.
    pub fn push(&mut self, position: [f64; 2], velocity: [f64; 2], radius: f64, mass: f64) {
        self.x.push(position[0]);
        self.z.push(position[1]);
        self.vx.push(velocity[0]);
        self.vz.push(velocity[1]);
        self.radius.push(radius);
        self.mass.push(mass);
    }

    /// Centre of a grain, m; in the plane y is 0.
    pub fn position(&self, id: usize) -> Vector {
        [&self.x, &self.y, &self.z].map(|column| or_zero(column, id))
    }

    /// Velocity of a grain, m/s.
    pub fn velocity(&self, id: usize) -> Vector {
        [&self.vx, &self.vy, &self.vz].map(|column| or_zero(column, id))
    }

    /// Its spin, rad/s; 0 where grains do not rotate.
    pub fn angular_velocity(&self, id: usize) -> Vector {
        [&self.spin_x, &self.spin, &self.spin_z].map(|column| or_zero(column, id))
    }

    /// Every column of numbers, for changes that hold of a grain as a whole.
    pub fn columns_mut(&mut self) -> [&mut Vec<f64>; 12] {
        [
            &mut self.x,
            &mut self.y,
            &mut self.z,
            &mut self.vx,
            &mut self.vy,
            &mut self.vz,
            &mut self.spin_x,
            &mut self.spin,
            &mut self.spin_z,
            &mut self.radius,
            &mut self.mass,
            &mut self.inertia,
        ]
    }

    /// Adds these grains after its own.
    pub fn append(&mut self, mut more: Bodies) {
        let both = self.columns_mut().into_iter().zip(more.columns_mut());
        both.for_each(|(all, more)| all.append(more));
        self.material.append(&mut more.material);
    }

    /// Whether grains rotate.
    pub fn rotate(&self) -> bool {
        !self.spin.is_empty()
    }

    /// Takes away spins and moments of inertia.
    pub fn do_not_turn(&mut self) {
        let columns = [
            &mut self.spin,
            &mut self.spin_x,
            &mut self.spin_z,
            &mut self.inertia,
        ];
        columns.into_iter().for_each(Vec::clear);
    }

    /// Number of grains.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there are no grains.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// The columns that motion changes, with their names: x, z, vx, vz, spin, of which the last one is empty where grains do not
    /// rotate; then those that are empty in the plane.
    pub fn motion(&self) -> [(&'static str, &[f64]); 9] {
        [
            ("x", &self.x),
            ("z", &self.z),
            ("vx", &self.vx),
            ("vz", &self.vz),
            ("spin", &self.spin),
            ("y", &self.y),
            ("vy", &self.vy),
            ("spin_x", &self.spin_x),
            ("spin_z", &self.spin_z),
        ]
    }

    /// 64 bits of SHA-256 over the bits of every position, velocity and spin (little endian, column
    /// by column): two states have the same digest if and only if, for practical purposes, they
    /// have the same bits.
    pub fn digest(&self) -> String {
        let mut hash = Sha256::new();
        for value in self.motion().into_iter().flat_map(|(_, column)| column) {
            hash.update(value.to_le_bytes());
        }
        short_hex(hash)
    }
}

/// A column that is empty in the plane: zeros there, without an end.
fn across(column: &[f64]) -> impl Iterator<Item = &f64> {
    let zeros = if column.is_empty() { usize::MAX } else { 0 };
    column.iter().chain(std::iter::repeat_n(&0.0, zeros))
}

fn or_zero(column: &[f64], id: usize) -> f64 {
    column.get(id).copied().unwrap_or(0.0)
}

/// A contact between two bodies, evaluated at the positions of the same snapshot.
///
/// Grain–grain pairs have `id1 < id2`. Walls and the punch have the ids after the grains
/// ([`BodyIds`]) and always stand first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Body 1; a wall or the punch, if there is one in the pair.
    pub id1: u32,
    /// Body 2; always a grain.
    pub id2: u32,
    /// Overlap u_n, m, positive in contact.
    pub overlap: f64,
    /// Force on body 2 along the normal, N, positive in compression.
    pub normal_force: f64,
    /// Force on body 2 along (−n_z, n_x), N; see [`tangential`]. In space its size.
    pub tangential_force: f64,
    /// Unit normal from body 1 to body 2.
    pub normal: [f64; 2],
    /// Contact point, m.
    pub point: [f64; 2],
}

impl Contact {
    /// The ids of its bodies.
    pub fn ids(&self) -> (u32, u32) {
        (self.id1, self.id2)
    }

    /// Force on body 2, N; body 1 bears the opposite.
    pub fn force(&self) -> [f64; 2] {
        let [nx, nz] = self.normal;
        [
            self.normal_force * nx - self.tangential_force * nz,
            self.normal_force * nz + self.tangential_force * nx,
        ]
    }
}

/// What a contact has in space besides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Across {
    /// The y component of the normal.
    pub normal: f64,
    /// That of the contact point, m.
    pub point: f64,
    /// Tangential force on body 2, N.
    pub tangential: [f64; 3],
}

/// A tangential force of zero has no direction, so −0 is written as 0: without friction the sign would depend
/// on whether an engine computes a slip that it does not need.
pub fn tangential(force: f64) -> f64 {
    force + 0.0
}

/// Which kind of body the first of a pair is; the second is always a grain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Body {
    Grain = 0,
    Wall = 1,
    Punch = 2,
}

/// Ids of the bodies that are not grains: the walls follow the grains, the punch the walls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BodyIds {
    /// Number of grains; they have the ids below it.
    pub grains: u32,
    /// Number of walls; three in a box, five in space.
    pub walls: u32,
}

impl BodyIds {
    /// The ids in a box: left wall, right wall, floor, punch.
    pub fn of_box(grains: u32) -> Self {
        BodyIds { grains, walls: 3 }
    }
    /// The ids in a box with these grains, in space those of its front and its back before the punch's.
    pub fn of(bodies: &Bodies) -> Self {
        BodyIds {
            walls: if bodies.in_space() { 5 } else { 3 },
            ..BodyIds::of_box(bodies.len() as u32)
        }
    }
    /// The wall with this index.
    pub fn wall(self, index: usize) -> u32 {
        self.grains + index as u32
    }
    /// The wall x = 0.
    pub fn left(self) -> u32 {
        self.grains
    }
    /// The wall x = width.
    pub fn right(self) -> u32 {
        self.grains + 1
    }
    /// The floor z = 0.
    pub fn floor(self) -> u32 {
        self.grains + 2
    }
    /// The punch.
    pub fn punch(self) -> u32 {
        self.grains + self.walls
    }
    /// Whose id this is.
    pub fn body(self, id: u32) -> Body {
        match id {
            id if self.is_grain(id) => Body::Grain,
            id if id < self.punch() => Body::Wall,
            _ => Body::Punch,
        }
    }
    /// Whether this id is a grain's.
    pub fn is_grain(self, id: u32) -> bool {
        id < self.grains
    }
}

/// The stages of the experiment.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Pouring until the settle rule holds.
    Settle,
    /// Pressing the punch until the force is reached or it has sunk too deep.
    Load,
}

impl Stage {
    /// The stage whose constants contacts have after so many steps of this one: those of loading hold from its first step on.
    pub fn of_constants(self, step: u64) -> Stage {
        match step {
            0 => Stage::Settle,
            _ => self,
        }
    }

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Stage::Settle => "settle",
            Stage::Load => "load",
        }
    }
}

/// The rigid punch at one moment.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Punch {
    /// Centre of the rectangle, m.
    pub centre: [f64; 2],
    /// Half-width and half-height, m.
    pub half_extents: [f64; 2],
    /// Height at which its bottom started, m.
    pub start: f64,
    /// Vertical velocity, m/s, negative downwards.
    pub velocity: f64,
    /// Vertical force of the grains on it, N, positive upwards.
    pub force: f64,
}

impl Punch {
    /// Height of its bottom, m.
    pub fn bottom(&self) -> f64 {
        self.centre[1] - self.half_extents[1]
    }

    /// How far it has gone down since it started, m.
    pub fn depth(&self) -> f64 {
        self.start - self.bottom()
    }
}

/// What a contact with friction remembers from step to step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Remembered {
    /// Body 1; a wall or the punch, if there is one in the pair.
    pub id1: u32,
    /// Body 2; always a grain.
    pub id2: u32,
    /// From body 1 to body 2, a unit vector.
    pub normal: [f64; 2],
    /// Tangential force on body 2, N.
    pub shear: [f64; 2],
}

impl From<&Contact> for Remembered {
    /// As a contact's own numbers tell it.
    fn from(contact: &Contact) -> Self {
        let [nx, nz] = contact.normal;
        let along = contact.tangential_force;
        Remembered {
            id1: contact.id1,
            id2: contact.id2,
            normal: contact.normal,
            shear: [-along * nz, along * nx],
        }
    }
}

/// What such a contact remembers in space besides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RememberedAcross {
    /// The y component of the normal.
    pub normal: f64,
    /// That of the tangential force, N, which in space is the spring's alone.
    pub shear: f64,
    /// Moments on body 2 against rolling and twisting, N·m.
    pub bending: [f64; 3],
    pub twisting: [f64; 3],
    /// The force was cut by Coulomb's limit, so that a dashpot along the tangent was left out.
    pub slides: bool,
}

/// What contacts remember, sorted by (id1, id2).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Memories {
    /// Of each contact.
    pub planar: Vec<Remembered>,
    /// Of each contact, in the same order; empty in the plane.
    pub across: Vec<RememberedAcross>,
}

impl Memories {
    /// Of how many contacts.
    pub fn len(&self) -> usize {
        self.planar.len()
    }

    /// Whether nothing is remembered.
    pub fn is_empty(&self) -> bool {
        self.planar.is_empty()
    }
}

/// One moment of a run: the state after `step` steps of its stage, contacts at these positions.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// The stage that is under way.
    pub stage: Stage,
    /// Steps of the stage so far.
    pub step: u64,
    /// Time since the start of the stage, s.
    pub time: f64,
    /// All grains.
    pub bodies: Bodies,
    /// Sorted by (id1, id2).
    pub contacts: Vec<Contact>,
    /// Of all contacts, in the same order; empty in the plane.
    pub across: Vec<Across>,
    /// Of all contacts, in the same order; empty without friction and of engines that do not tell.
    pub memory: Memories,
    /// The punch, once there is one.
    pub punch: Option<Punch>,
}

impl Snapshot {
    /// The stage whose constants its contacts have.
    pub fn constants(&self) -> Stage {
        self.stage.of_constants(self.step)
    }

    /// 64 bits of SHA-256 over the bits of grains, contacts and punch: as [`Bodies::digest`], for a whole moment.
    pub fn digest(&self) -> String {
        let mut hash = Sha256::new();
        let mut number = |value: f64| hash.update(value.to_le_bytes());
        for (_, column) in self.bodies.motion() {
            column.iter().copied().for_each(&mut number);
        }
        for contact in &self.contacts {
            number(f64::from(contact.id1));
            number(f64::from(contact.id2));
            number(contact.overlap);
            number(contact.normal_force);
            number(contact.tangential_force);
            contact.normal.into_iter().for_each(&mut number);
            contact.point.into_iter().for_each(&mut number);
        }
        for across in &self.across {
            let [x, y, z] = across.tangential;
            [across.normal, across.point, x, y, z]
                .into_iter()
                .for_each(&mut number);
        }
        if let Some(punch) = &self.punch {
            number(punch.centre[1]);
            number(punch.force);
        }
        short_hex(hash)
    }
}

/// Why a stage ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// The settle rule holds.
    Settled,
    /// The punch bears the force 2ap.
    Reached,
    /// The punch went to the give-up depth without the force.
    TargetLoadNotReached,
    /// The steps asked for are done; no rule was applied.
    StepsDone,
    /// The most steps that the scene allows are done and the rule does not hold.
    MaxSteps,
    /// It was asked to end.
    Interrupted,
}

impl StopReason {
    /// As files name it.
    pub fn name(self) -> &'static str {
        match self {
            StopReason::Settled => "settled",
            StopReason::Reached => "reached",
            StopReason::TargetLoadNotReached => "target_load_not_reached",
            StopReason::StepsDone => "steps_done",
            StopReason::MaxSteps => "max_steps",
            StopReason::Interrupted => "interrupted",
        }
    }
}

/// SHA-256 of these bytes.
pub fn sha256_hex(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// The first 64 bits of a running SHA-256.
pub fn short_hex(hash: Sha256) -> String {
    hex(&hash.finalize()[..8])
}

/// Two digits a byte.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::tangential;

    #[test]
    fn a_tangential_force_of_zero_has_no_sign() {
        assert_eq!(tangential(-0.0).to_bits(), 0.0f64.to_bits());
        assert_eq!(tangential(-5e-324), -5e-324);
    }
}
