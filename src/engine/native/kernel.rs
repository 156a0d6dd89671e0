//! The step: the same law as [`super::contact`], arranged for vector lanes, with the same bits.
//!
//! Forces of all listed pairs are computed several at a time; they are then added one pair after
//! the other in the order of the list. Lanes change nothing: no operation is fused or reordered.

use multiversion::multiversion;

use super::constants::Constants;
use super::health::Trouble;
use super::neighbours::Neighbours;
use super::state::State;

/// Pairs handled together: a multiple of every vector width, small enough to stay in the nearest cache.
const BLOCK: usize = 256;

/// The state with what a step needs beside it. After [`Dynamics::new`] and after each
/// [`Dynamics::step`] the forces belong to the positions.
pub struct Dynamics {
    pub state: State,
    pub constants: Constants,
    pub neighbours: Neighbours,
    /// The punch has just been set on the bed: no forces have been evaluated with it yet, so it has no
    /// contacts, even where rounding makes it touch.
    pub punch_is_new: bool,
    /// Force of each listed pair on its second grain.
    pair_force: Vec<[f64; 2]>,
}

impl Dynamics {
    /// Lists the neighbours and evaluates the forces at the start.
    pub fn new(state: State, constants: Constants, skin: f64) -> Result<Self, Trouble> {
        let mut dynamics = Dynamics {
            state,
            constants,
            neighbours: Neighbours::new(skin),
            punch_is_new: false,
            pair_force: Vec::new(),
        };
        dynamics.list_neighbours()?;
        dynamics.evaluate_forces()?;
        Ok(dynamics)
    }

    /// One time step.
    pub fn step(&mut self) -> Result<(), Trouble> {
        let punch_height = self.state.punch.as_mut().map(|punch| {
            punch.centre[1] += punch.velocity * self.constants.dt;
            punch.centre[1]
        });
        let limit = self.neighbours.displacement_limit_squared(punch_height);
        let within = integrate(
            &mut self.state,
            &self.neighbours.reference,
            self.constants.dt,
            self.constants.gravity,
            self.constants.alpha,
            limit,
        );
        if !within {
            self.list_neighbours()?;
        }
        self.evaluate_forces()
    }

    /// Checks every grain and lists the neighbours anew.
    pub fn list_neighbours(&mut self) -> Result<(), Trouble> {
        super::health::check(&self.state, &self.constants)?;
        self.neighbours.build(&self.state, &self.constants);
        self.pair_force
            .resize(self.neighbours.other.len(), [0.0; 2]);
        Ok(())
    }

    fn evaluate_forces(&mut self) -> Result<(), Trouble> {
        pair_forces(&self.state.position, &self.neighbours, &mut self.pair_force);
        self.state.force.fill([0.0; 2]);
        sum_pair_forces(&self.neighbours, &self.pair_force, &mut self.state.force);
        self.add_wall_forces();
        self.punch_is_new = false;
        self.add_punch_forces()
    }

    fn add_wall_forces(&mut self) {
        for (wall, near) in self.constants.walls.iter().zip(&self.neighbours.by_wall) {
            for &id in near {
                let id = id as usize;
                if let Some(pair) = self.state.wall_contact(&self.constants, wall, id) {
                    self.state.force[id][0] += pair.force[0];
                    self.state.force[id][1] += pair.force[1];
                }
            }
        }
    }

    fn add_punch_forces(&mut self) -> Result<(), Trouble> {
        let Some(punch) = self.state.punch else {
            return Ok(());
        };
        let mut on_punch = 0.0;
        for &id in &self.neighbours.by_punch {
            let at = id as usize;
            super::health::check_outside(&self.state, &punch, at)?;
            if let Some(pair) = self.state.punch_contact(&self.constants, &punch, at) {
                self.state.force[at][0] += pair.force[0];
                self.state.force[at][1] += pair.force[1];
                on_punch -= pair.force[1];
            }
        }
        if let Some(punch) = &mut self.state.punch {
            punch.force = on_punch;
        }
        Ok(())
    }
}

/// [`pair_forces_plain`], compiled for the widest vector unit that the machine has.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn pair_forces(position: &[[f64; 2]], list: &Neighbours, out: &mut [[f64; 2]]) {
    pair_forces_plain(position, list, out);
}

/// The normal force of every listed pair on its second grain; zero where the pair does not touch.
#[inline(always)]
fn pair_forces_plain(position: &[[f64; 2]], list: &Neighbours, out: &mut [[f64; 2]]) {
    let mut x = [1.0; BLOCK];
    let mut z = [1.0; BLOCK];
    let mut reach = [0.0; BLOCK];
    let mut stiffness = [0.0; BLOCK];
    let blocks = list
        .grain
        .chunks(BLOCK)
        .zip(list.other.chunks(BLOCK))
        .zip(list.reach.chunks(BLOCK).zip(list.stiffness.chunks(BLOCK)))
        .zip(out.chunks_mut(BLOCK));
    for (((grain, other), (of_reach, of_stiffness)), out) in blocks {
        // Gathering and arithmetic are loops of their own: mixed, they do not become vector code.
        for (((dx, dz), grain), other) in x.iter_mut().zip(&mut z).zip(grain).zip(other) {
            let (a, b) = (position[*grain as usize], position[*other as usize]);
            *dx = b[0] - a[0];
            *dz = b[1] - a[1];
        }
        reach[..of_reach.len()].copy_from_slice(of_reach);
        stiffness[..of_stiffness.len()].copy_from_slice(of_stiffness);
        for lane in 0..BLOCK {
            let (dx, dz) = (x[lane], z[lane]);
            let distance = (dx * dx + dz * dz).sqrt();
            let overlap = reach[lane] - distance;
            let force = stiffness[lane] * overlap;
            let touching = overlap >= 0.0;
            x[lane] = if touching {
                force * (dx / distance)
            } else {
                0.0
            };
            z[lane] = if touching {
                force * (dz / distance)
            } else {
                0.0
            };
        }
        for ((out, x), z) in out.iter_mut().zip(&x).zip(&z) {
            *out = [*x, *z];
        }
    }
}

/// Adds the pair forces to both grains of each pair, pair after pair in the order of the list.
/// The sum of the row's grain stays in a register meanwhile; the order of its terms is the same.
fn sum_pair_forces(list: &Neighbours, pair_force: &[[f64; 2]], force: &mut [[f64; 2]]) {
    for (i, row) in list.start.windows(2).enumerate() {
        let row = row[0] as usize..row[1] as usize;
        let mut own = force[i];
        for (other, pair) in list.other[row.clone()].iter().zip(&pair_force[row]) {
            own[0] -= pair[0];
            own[1] -= pair[1];
            let partner = &mut force[*other as usize];
            partner[0] += pair[0];
            partner[1] += pair[1];
        }
        force[i] = own;
    }
}

/// [`integrate_plain`], compiled for the widest vector unit that the machine has.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn integrate(
    state: &mut State,
    reference: &[[f64; 2]],
    dt: f64,
    gravity: f64,
    alpha: f64,
    limit_squared: f64,
) -> bool {
    integrate_plain(state, reference, dt, gravity, alpha, limit_squared)
}

/// Cundall-damped leapfrog (the acceleration includes gravity and is scaled by
/// 1 − α·sign(a·(v + ½dt·a)), then v += dt·a, x += dt·v). Says whether every grain is still within
/// the displacement that the neighbour list allows; a NaN is not.
#[inline(always)]
fn integrate_plain(
    state: &mut State,
    reference: &[[f64; 2]],
    dt: f64,
    gravity: f64,
    alpha: f64,
    limit_squared: f64,
) -> bool {
    let half_step = 0.5 * dt;
    let pull = [0.0, -gravity];
    let mut within = true;
    let moving = state.position.iter_mut().zip(&mut state.velocity);
    let pushed = state.force.iter().zip(&state.mass);
    for (((position, velocity), (force, mass)), reference) in moving.zip(pushed).zip(reference) {
        let mut moved = [0.0; 2];
        for axis in 0..2 {
            let undamped = force[axis] / mass + pull[axis];
            let power = undamped * (velocity[axis] + half_step * undamped);
            let sign = f64::from(u8::from(power > 0.0)) - f64::from(u8::from(power < 0.0));
            let acceleration = undamped * (1.0 - alpha * sign);
            velocity[axis] += dt * acceleration;
            position[axis] += dt * velocity[axis];
            moved[axis] = position[axis] - reference[axis];
        }
        within &= moved[0] * moved[0] + moved[1] * moved[1] <= limit_squared;
    }
    within
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::initial_bodies;
    use crate::scene::paper_scene;

    /// The functions compiled for this machine's vector unit against the same code compiled for the
    /// plainest machine of its kind.
    #[test]
    fn this_machines_vector_unit_gives_the_plain_bits() {
        let scene = paper_scene(1, 3000);
        let constants = Constants::new(&scene);
        let state = State::new(&initial_bodies(&scene), None);
        let mut dynamics = Dynamics::new(state, constants, 1.0e-3).expect("a sound start");
        let mut touching = 0;
        for _ in 0..9000 {
            dynamics.step().expect("a sound step");
            let count = dynamics.neighbours.other.len();
            if !dynamics.neighbours.builds.is_multiple_of(50) {
                continue;
            }
            let mut plain = vec![[0.0; 2]; count];
            pair_forces_plain(&dynamics.state.position, &dynamics.neighbours, &mut plain);
            touching += plain.iter().filter(|force| **force != [0.0; 2]).count();
            assert_eq!(plain, dynamics.pair_force);

            let (mut one, mut other) = (dynamics.state.clone(), dynamics.state.clone());
            let reference = dynamics.state.position.clone();
            let of_one = integrate(&mut one, &reference, 1.0e-5, 9.81, 0.2, 1.0e-6);
            let of_other = integrate_plain(&mut other, &reference, 1.0e-5, 9.81, 0.2, 1.0e-6);
            assert_eq!(of_one, of_other);
            assert_eq!(one.position, other.position);
            assert_eq!(one.velocity, other.velocity);
        }
        assert!(touching > 1000, "{touching}");
    }
}
