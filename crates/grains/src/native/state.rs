//! The state of the native engine: what a step reads and changes.

use super::constants::{Constants, Wall};
use super::contact::{self, Touch};
use super::friction::Motion;
use crate::model::Kernel;
use crate::tables::{Bodies, Contact, Punch};

/// Positions, velocities and forces, a pair of components a grain.
#[derive(Debug, Clone)]
pub struct State {
    pub position: Vec<[f64; 2]>,
    pub velocity: Vec<[f64; 2]>,
    pub force: Vec<[f64; 2]>,
    pub radius: Vec<f64>,
    pub mass: Vec<f64>,
    /// The mass of each grain twice, once for each of its components: what vector lanes divide by, kg.
    pub component_mass: Vec<f64>,
    /// rad/s; empty for the frictionless kernel, zeros where grains do not rotate.
    pub spin: Vec<f64>,
    /// N·m; empty for the frictionless kernel.
    pub torque: Vec<f64>,
    /// kg·m²; empty where grains do not rotate.
    pub inertia: Vec<f64>,
    pub punch: Option<Punch>,
}

impl State {
    /// The state of these grains for this kernel; forces are still to be evaluated.
    pub fn new(bodies: &Bodies, punch: Option<Punch>, kernel: Kernel) -> Self {
        let pairs = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| [*a, *b]).collect();
        let turning = match kernel {
            Kernel::Frictionless => 0,
            Kernel::General => bodies.len(),
        };
        let mut spin = bodies.spin.clone();
        // Spins are kept even where a fault has taken the friction away.
        spin.resize(turning.max(bodies.spin.len()), 0.0);
        State {
            position: pairs(&bodies.x, &bodies.z),
            velocity: pairs(&bodies.vx, &bodies.vz),
            force: vec![[0.0; 2]; bodies.len()],
            radius: bodies.radius.clone(),
            mass: bodies.mass.clone(),
            component_mass: bodies.mass.iter().flat_map(|mass| [*mass; 2]).collect(),
            spin,
            torque: vec![0.0; turning],
            inertia: bodies.inertia.clone(),
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
            spin: if self.inertia.is_empty() {
                Vec::new()
            } else {
                self.spin.clone()
            },
            inertia: self.inertia.clone(),
        }
    }

    /// Σ ½mv², then Σ ½Iω², grain by grain, J. Both engines add in this order, so a stop rule on it
    /// stops both at the same step.
    pub fn kinetic_energy(&self) -> f64 {
        let mut energy = 0.0;
        for (mass, [vx, vz]) in self.mass.iter().zip(&self.velocity) {
            energy += 0.5 * mass * (vx * vx + vz * vz);
        }
        for (inertia, spin) in self.inertia.iter().zip(&self.spin) {
            energy += 0.5 * inertia * (spin * spin);
        }
        energy
    }

    /// How grain `id` moves.
    pub fn motion(&self, id: usize) -> Motion {
        Motion {
            position: self.position[id],
            velocity: self.velocity[id],
            spin: self.spin[id],
        }
    }

    /// Where grains `a` and `b` touch.
    pub fn grain_touch(&self, a: usize, b: usize) -> Option<Touch> {
        contact::grains(
            self.position[a],
            self.radius[a],
            self.position[b],
            self.radius[b],
        )
    }

    /// Where grain `id` touches a wall.
    pub fn wall_touch(&self, wall: &Wall, id: usize) -> Option<Touch> {
        contact::wall(wall.axis, wall.place, self.position[id], self.radius[id])
    }

    /// Where grain `id` touches the punch.
    pub fn punch_touch(&self, punch: &Punch, id: usize) -> Option<Touch> {
        let (position, radius) = (self.position[id], self.radius[id]);
        contact::punch(punch.centre, punch.half_extents, position, radius)
    }

    /// k_n of grain `id` at a flat body, N/m.
    pub fn flat_stiffness(&self, constants: &Constants, id: usize) -> f64 {
        constants.stiffness(self.radius[id], self.radius[id])
    }
}

/// A row of the table of contacts.
pub fn contact_row(id1: u32, id2: u32, touch: &Touch, force: [f64; 2]) -> Contact {
    let [nx, nz] = touch.normal;
    let [fx, fz] = force;
    Contact {
        id1,
        id2,
        overlap: touch.overlap,
        normal_force: fx * nx + fz * nz,
        tangential_force: fz * nx - fx * nz,
        normal: touch.normal,
        point: touch.point,
    }
}
