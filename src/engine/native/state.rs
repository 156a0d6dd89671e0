//! The state of the native engine: what a step reads and changes.

use super::constants::{Constants, Wall};
use super::contact::{self, PairForce};
use crate::tables::{Bodies, Contact, Punch, Snapshot, Stage};

/// Positions, velocities and forces, a pair of components a grain.
#[derive(Debug, Clone)]
pub struct State {
    pub position: Vec<[f64; 2]>,
    pub velocity: Vec<[f64; 2]>,
    pub force: Vec<[f64; 2]>,
    pub radius: Vec<f64>,
    pub mass: Vec<f64>,
    pub punch: Option<Punch>,
}

impl State {
    /// The state of these grains; forces are still to be evaluated.
    pub fn new(bodies: &Bodies, punch: Option<Punch>) -> Self {
        let pairs = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| [*a, *b]).collect();
        State {
            position: pairs(&bodies.x, &bodies.z),
            velocity: pairs(&bodies.vx, &bodies.vz),
            force: vec![[0.0; 2]; bodies.len()],
            radius: bodies.radius.clone(),
            mass: bodies.mass.clone(),
            punch,
        }
    }

    /// The grains as a table.
    pub fn bodies(&self) -> Bodies {
        let column = |of: &[[f64; 2]], axis: usize| of.iter().map(|v| v[axis]).collect();
        Bodies {
            x: column(&self.position, 0),
            z: column(&self.position, 1),
            vx: column(&self.velocity, 0),
            vz: column(&self.velocity, 1),
            radius: self.radius.clone(),
            mass: self.mass.clone(),
        }
    }

    /// Σ ½mv², grain by grain, J. Both engines add in this order, so a stop rule on it stops both
    /// at the same step.
    pub fn kinetic_energy(&self) -> f64 {
        let mut energy = 0.0;
        for (mass, [vx, vz]) in self.mass.iter().zip(&self.velocity) {
            energy += 0.5 * mass * (vx * vx + vz * vz);
        }
        energy
    }

    /// The contact of grain `id` with a wall.
    pub fn wall_contact(&self, constants: &Constants, wall: &Wall, id: usize) -> Option<PairForce> {
        let radius = self.radius[id];
        let stiffness = constants.stiffness(radius, radius);
        contact::wall(wall.axis, wall.place, self.position[id], radius, stiffness)
    }

    /// The contact of grain `id` with the punch.
    pub fn punch_contact(
        &self,
        constants: &Constants,
        punch: &Punch,
        id: usize,
    ) -> Option<PairForce> {
        let radius = self.radius[id];
        let stiffness = constants.stiffness(radius, radius);
        contact::punch(
            punch.centre,
            punch.half_extents,
            self.position[id],
            radius,
            stiffness,
        )
    }

    /// This moment as a table, its contacts evaluated by the scalar law among `candidates`,
    /// the grain pairs near enough to touch.
    pub fn snapshot(
        &self,
        constants: &Constants,
        candidates: impl Iterator<Item = (u32, u32)>,
        stage: Stage,
        step: u64,
    ) -> Snapshot {
        let mut contacts = Vec::new();
        let mut add = |id1: u32, id2: u32, pair: PairForce| {
            let [nx, nz] = pair.normal;
            let [fx, fz] = pair.force;
            contacts.push(Contact {
                id1,
                id2,
                overlap: pair.overlap,
                normal_force: fx * nx + fz * nz,
                tangential_force: fz * nx - fx * nz,
                normal: pair.normal,
                point: pair.point,
            });
        };
        for (id1, id2) in candidates {
            let (a, b) = (id1 as usize, id2 as usize);
            let stiffness = constants.stiffness(self.radius[a], self.radius[b]);
            if let Some(pair) = contact::grains(
                self.position[a],
                self.radius[a],
                self.position[b],
                self.radius[b],
                stiffness,
            ) {
                add(id1, id2, pair);
            }
        }
        for wall in &constants.walls {
            for id in 0..self.position.len() {
                if let Some(pair) = self.wall_contact(constants, wall, id) {
                    add(wall.id, id as u32, pair);
                }
            }
        }
        if let Some(punch) = &self.punch {
            for id in 0..self.position.len() {
                if let Some(pair) = self.punch_contact(constants, punch, id) {
                    add(constants.ids.punch(), id as u32, pair);
                }
            }
        }
        contacts.sort_by_key(|contact| (contact.id1, contact.id2));
        Snapshot {
            stage,
            step,
            time: step as f64 * constants.dt,
            bodies: self.bodies(),
            contacts,
            punch: self.punch,
        }
    }
}
