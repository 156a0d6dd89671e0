//! Rounding errors as another engine makes them, for replicas of a run: how far runs part that are the same but for rounding.

use chacha20::ChaCha8Rng;
use rand_core::SeedableRng;

use super::state::{Constants, State};
use crate::generate::symmetric;
use crate::tables::Bodies;

/// How coarsely an engine computes. At the start and after each step every position and velocity is off by up to so much, and
/// every grain that bears a force is kicked by what its contacts are off. A replica with an odd number makes the same errors in
/// each step: a number that grows by the same amount in each step is rounded the same way, for a while.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Of positions, over the largest coordinate: some engines count from a corner of their own.
    pub position: f64,
    /// Of velocities and spins, over their size.
    pub velocity: f64,
    /// Of the overlaps that forces are made of, m.
    pub overlap: f64,
    /// Which replica.
    pub replica: u64,
    /// The errors of so many steps are made at once, as large as their sum is likely to be.
    pub every: u64,
}

/// The noise under way.
pub(super) struct Shaker {
    noise: Noise,
    random: ChaCha8Rng,
}

const KEY: &[u8; 32] = b"crossgrain: rounding of replicas";

impl Noise {
    pub(super) fn begin(self) -> Shaker {
        let mut random = ChaCha8Rng::from_seed(*KEY);
        random.set_stream(self.replica);
        let noise = self;
        Shaker { noise, random }
    }
}

impl Shaker {
    pub(super) fn every(&self) -> u64 {
        self.noise.every
    }

    /// Before the first step or after one.
    pub(super) fn shake(&mut self, state: &mut State, constants: &Constants) {
        if self.noise.replica % 2 == 1 {
            *self = self.noise.begin();
        }
        let off = self.noise;
        let sum = self.steps_at_once();
        let coordinates = state.position.iter().flatten();
        let extent = coordinates.fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let (length, share) = (sum * off.position * extent, sum * off.velocity);
        for id in 0..state.mass.len() {
            let id = state.place[id] as usize;
            let (radius, mass) = (state.radius[id], state.mass[id]);
            let kick = if state.force[id] == [0.0; 2] {
                0.0
            } else {
                sum * constants.dt * constants.stiffness(radius, radius) * off.overlap / mass
            };
            for axis in 0..2 {
                let random = &mut self.random;
                state.position[id][axis] += length * symmetric(random);
                state.velocity[id][axis] *= 1.0 + share * symmetric(random);
                let kick = kick * symmetric(random);
                state.velocity[id][axis] += kick;
                // The step has moved it already.
                state.position[id][axis] += constants.dt * kick;
            }
            if !state.inertia.is_empty() {
                // A force that is off by k times the overlap's error turns the grain at most with the arm R.
                let turn = kick * mass * radius / state.inertia[id];
                state.spin[id] *= 1.0 + share * symmetric(&mut self.random);
                state.spin[id] += turn * symmetric(&mut self.random);
            }
        }
    }

    /// The same of spheres in space, of which those with `loaded` bear a force.
    pub(super) fn shake_in_space(
        &mut self,
        bodies: &mut Bodies,
        loaded: impl Fn(usize) -> bool,
        constants: &Constants,
    ) {
        if self.noise.replica % 2 == 1 {
            *self = self.noise.begin();
        }
        let off = self.noise;
        let sum = self.steps_at_once();
        let coordinates = bodies.x.iter().chain(&bodies.y).chain(&bodies.z);
        let extent = coordinates.fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let (length, share) = (sum * off.position * extent, sum * off.velocity);
        for id in 0..bodies.len() {
            let (radius, mass) = (bodies.radius[id], bodies.mass[id]);
            let stiffness = constants.law.usual_stiffness(radius);
            let kick = match loaded(id) {
                true => sum * constants.dt * stiffness * off.overlap / mass,
                false => 0.0,
            };
            let axes = [
                (&mut bodies.x, &mut bodies.vx),
                (&mut bodies.y, &mut bodies.vy),
                (&mut bodies.z, &mut bodies.vz),
            ];
            for (place, velocity) in axes {
                let random = &mut self.random;
                let kick = kick * symmetric(random);
                velocity[id] *= 1.0 + share * symmetric(random);
                velocity[id] += kick;
                place[id] += length * symmetric(random) + constants.dt * kick;
            }
            let Some(inertia) = bodies.inertia.get(id) else {
                continue;
            };
            let turn = kick * mass * radius / inertia;
            for spin in [&mut bodies.spin_x, &mut bodies.spin, &mut bodies.spin_z] {
                spin[id] *= 1.0 + share * symmetric(&mut self.random);
                spin[id] += turn * symmetric(&mut self.random);
            }
        }
    }

    /// Errors of so many steps add up to so many times those of one.
    fn steps_at_once(&self) -> f64 {
        (self.noise.every as f64).sqrt()
    }
}
