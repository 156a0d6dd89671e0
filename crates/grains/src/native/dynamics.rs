//! The step: integrate (leapfrog, with Cundall's local damping where the scene has it), move the punch, list neighbours
//! anew if need be, evaluate the forces.

use multiversion::multiversion;

use super::contact::ContactRules;
use super::general;
use super::health::Trouble;
use super::neighbours::{Neighbours, Skin};
use super::springs;
use super::state::{Constants, State, contact_row};
use crate::model::Kernel;
use crate::tables::{Bodies, Contact, Punch, Remembered, Snapshot, Stage};

/// The parts of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    Integration,
    NeighbourLists,
    /// Between grains; with friction all contacts.
    Contacts,
    /// Walls and punch.
    FlatBodies,
}

/// Told which part of a step is under way.
pub trait Clock {
    /// Does the work of this part.
    fn time<T>(&mut self, part: Part, work: impl FnOnce() -> T) -> T;
}

/// Nobody looks at the clock, and it costs nothing.
struct Untimed;

impl Clock for Untimed {
    #[inline(always)]
    fn time<T>(&mut self, _: Part, work: impl FnOnce() -> T) -> T {
        work()
    }
}

/// The state with what a step needs beside it. After [`Dynamics::new`] and after each
/// [`Dynamics::step`] the forces belong to the positions.
pub struct Dynamics {
    pub state: State,
    pub constants: Constants,
    pub neighbours: Neighbours,
    /// The punch has just been set on the bed: no forces have been evaluated with it yet, so it has no
    /// contacts, even where rounding makes it touch.
    pub punch_is_new: bool,
    /// The velocities of the start are taken for those at the start, and the first step is still to come.
    half_step_to_come: bool,
    kernel: Kernel,
    rules: ContactRules,
}

impl Dynamics {
    /// Lists the neighbours and evaluates the forces at the start. Where contacts remember something, the evaluation leaves it
    /// as it is; elsewhere they begin to.
    pub fn new(
        bodies: &Bodies,
        punch: Option<Punch>,
        memory: &[Remembered],
        constants: Constants,
        skin: Skin,
    ) -> Result<Self, Trouble> {
        let kernel = constants.kernel();
        let mut dynamics = Dynamics {
            state: State::new(bodies, punch, kernel),
            kernel,
            rules: constants.rules(),
            constants,
            neighbours: Neighbours::new(skin),
            punch_is_new: false,
            half_step_to_come: false,
        };
        if memory.is_empty() {
            dynamics.list_neighbours()?;
            dynamics.evaluate_forces();
        } else {
            dynamics.recall(memory)?;
            // Neither slip nor a limit: what is remembered stays to the bit.
            let rules = ContactRules {
                dt: 0.0,
                tan_squared: f64::INFINITY,
                ..dynamics.rules.clone()
            };
            let rules = std::mem::replace(&mut dynamics.rules, rules);
            dynamics.evaluate_forces();
            dynamics.rules = rules;
        }
        dynamics.half_step_to_come = dynamics.constants.half_step_start;
        Ok(dynamics)
    }

    /// Goes on with other constants. Forces stay what they are until the next step, and so do shear forces of contacts.
    pub fn change(&mut self, constants: Constants) -> Result<(), Trouble> {
        let memory = self.contacts().1;
        self.kernel = constants.kernel();
        self.rules = constants.rules();
        self.constants = constants;
        self.state.suit(self.kernel);
        self.recall(&memory)
    }

    /// Lists the neighbours anew, and contacts remember this.
    fn recall(&mut self, memory: &[Remembered]) -> Result<(), Trouble> {
        if self.kernel == Kernel::General {
            let grains = self.state.position.len();
            self.neighbours.recall(grains, &self.constants, memory);
        }
        self.list_neighbours()
    }

    /// One time step.
    pub fn step(&mut self) -> Result<(), Trouble> {
        self.step_timed(&mut Untimed)
    }

    /// The same with a clock that is told which part of the step is under way.
    pub fn step_timed(&mut self, clock: &mut impl Clock) -> Result<(), Trouble> {
        if self.half_step_to_come {
            self.half_a_step_back();
            self.half_step_to_come = false;
        }
        let Constants {
            dt, gravity, alpha, ..
        } = self.constants;
        let punch_height = self.state.punch.as_mut().map(|punch| {
            punch.centre[1] += punch.velocity * dt;
            punch.centre[1]
        });
        let held = clock.time(Part::Integration, || {
            let fastest = integrate(&mut self.state, dt, gravity, alpha);
            if self.constants.law.rotates() {
                integrate_spins(&mut self.state, dt, alpha);
            }
            let position = &self.state.position;
            self.neighbours.hold(fastest, dt, position, punch_height)
        });
        if !held {
            clock.time(Part::NeighbourLists, || self.list_neighbours())?;
        }
        self.evaluate_forces_timed(clock);
        Ok(())
    }

    /// Checks every grain and lists the neighbours anew.
    pub fn list_neighbours(&mut self) -> Result<(), Trouble> {
        super::health::check(&self.state, &self.constants)?;
        self.neighbours.build(&self.state, &self.constants);
        Ok(())
    }

    fn evaluate_forces(&mut self) {
        self.evaluate_forces_timed(&mut Untimed);
    }

    fn evaluate_forces_timed(&mut self, clock: &mut impl Clock) {
        self.punch_is_new = false;
        if self.kernel == Kernel::General {
            return clock.time(Part::Contacts, || {
                general::evaluate_forces(
                    &mut self.state,
                    &mut self.neighbours,
                    &self.constants,
                    &self.rules,
                );
            });
        }
        clock.time(Part::Contacts, || {
            let State {
                position, force, ..
            } = &mut self.state;
            springs::sum_forces(position, &self.neighbours.rows, force);
        });
        clock.time(Part::FlatBodies, || {
            self.add_wall_forces();
            self.add_punch_forces();
        });
    }

    fn add_wall_forces(&mut self) {
        for (wall, near) in self.constants.walls.iter().zip(&self.neighbours.by_wall) {
            for &id in near {
                let id = id as usize;
                if let Some(touch) = self.state.wall_touch(wall, id) {
                    let stiffness = self.state.flat_stiffness(&self.constants, id);
                    let force = touch.spring_force(stiffness);
                    self.state.force[id][0] += force[0];
                    self.state.force[id][1] += force[1];
                }
            }
        }
    }

    fn add_punch_forces(&mut self) {
        let Some(punch) = self.state.punch else {
            return;
        };
        let mut on_punch = 0.0;
        for &id in &self.neighbours.by_punch {
            let id = id as usize;
            if let Some(touch) = self.state.punch_touch(&punch, id) {
                let stiffness = self.state.flat_stiffness(&self.constants, id);
                let force = touch.spring_force(stiffness);
                self.state.force[id][0] += force[0];
                self.state.force[id][1] += force[1];
                on_punch -= force[1];
            }
        }
        if let Some(punch) = &mut self.state.punch {
            punch.force = on_punch;
        }
    }

    /// Takes the velocities for those at the start: v(−dt/2) = v(0) − ½dt·a.
    fn half_a_step_back(&mut self) {
        let Constants { dt, gravity, .. } = self.constants;
        let State {
            velocity,
            force,
            mass,
            spin,
            torque,
            inertia,
            ..
        } = &mut self.state;
        for ((velocity, force), mass) in velocity.iter_mut().zip(force).zip(mass) {
            for axis in 0..2 {
                velocity[axis] -= 0.5 * dt * (force[axis] / *mass + gravity[axis]);
            }
        }
        for ((spin, torque), inertia) in spin.iter_mut().zip(torque).zip(inertia) {
            *spin -= 0.5 * dt * (*torque / *inertia);
        }
    }

    /// This moment as a table.
    pub fn snapshot(&self, stage: Stage, step: u64) -> Snapshot {
        let (contacts, mut memory) = self.contacts();
        if !self.constants.law.has_history() {
            memory.clear();
        }
        Snapshot {
            stage,
            step,
            time: step as f64 * self.constants.dt,
            bodies: self.state.bodies(),
            contacts,
            memory,
            punch: self.state.punch,
        }
    }

    /// All contacts with what they remember, sorted by ids. Without friction that is the normal alone.
    fn contacts(&self) -> (Vec<Contact>, Vec<Remembered>) {
        let mut contacts = match self.kernel {
            Kernel::Frictionless => {
                let remembered = |contact: Contact| {
                    let of = Remembered {
                        id1: contact.id1,
                        id2: contact.id2,
                        normal: contact.normal,
                        shear: [0.0; 2],
                    };
                    (contact, of)
                };
                self.spring_contacts().into_iter().map(remembered).collect()
            }
            Kernel::General => {
                general::contacts(&self.state, &self.neighbours, &self.constants, &self.rules)
            }
        };
        contacts.sort_by_key(|(contact, _)| (contact.id1, contact.id2));
        contacts.into_iter().unzip()
    }

    /// The contacts of the frictionless kernel, evaluated by the scalar law.
    fn spring_contacts(&self) -> Vec<Contact> {
        let (state, constants) = (&self.state, &self.constants);
        let mut contacts = Vec::new();
        for (id1, id2) in self.neighbours.pairs() {
            let (a, b) = (id1 as usize, id2 as usize);
            if let Some(touch) = state.grain_touch(a, b) {
                let stiffness = constants.stiffness(state.radius[a], state.radius[b]);
                contacts.push(contact_row(id1, id2, &touch, touch.spring_force(stiffness)));
            }
        }
        let flat = |contacts: &mut Vec<Contact>, body: u32, id: u32, touch| {
            if let Some(touch) = touch {
                let touch: super::contact::Touch = touch;
                let force = touch.spring_force(state.flat_stiffness(constants, id as usize));
                contacts.push(contact_row(body, id, &touch, force));
            }
        };
        for (wall, near) in constants.walls.iter().zip(&self.neighbours.by_wall) {
            for &id in near {
                let touch = state.wall_touch(wall, id as usize);
                flat(&mut contacts, wall.id, id, touch);
            }
        }
        if let Some(punch) = state.punch.filter(|_| !self.punch_is_new) {
            for &id in &self.neighbours.by_punch {
                let touch = state.punch_touch(&punch, id as usize);
                flat(&mut contacts, constants.ids.punch(), id, touch);
            }
        }
        contacts
    }
}

/// Components that are advanced together: those of eight grains.
const WIDTH: usize = 16;

/// The fastest component of a step, squared, m²/s²: across and up.
pub type Fastest = [f64; 2];

/// Advances velocities and positions: v += dt·a, x += dt·v. With damping the acceleration, gravity
/// included, is scaled by 1 − α·sign(a·(v + ½dt·a)); without it nothing is computed for it. Where a velocity is not
/// a number, the fastest is not one either.
pub fn integrate(state: &mut State, dt: f64, gravity: [f64; 2], alpha: f64) -> Fastest {
    if alpha == 0.0 {
        undamped(state, dt, gravity)
    } else {
        damped(state, dt, gravity, alpha)
    }
}

/// [`integrate_plain`] with local damping, compiled for the widest vector unit that the machine has.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn damped(state: &mut State, dt: f64, gravity: [f64; 2], alpha: f64) -> Fastest {
    integrate_plain::<true>(state, dt, gravity, alpha)
}

/// [`integrate_plain`] without it, likewise.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn undamped(state: &mut State, dt: f64, gravity: [f64; 2]) -> Fastest {
    integrate_plain::<false>(state, dt, gravity, 0.0)
}

#[inline(always)]
fn integrate_plain<const DAMPED: bool>(
    state: &mut State,
    dt: f64,
    gravity: [f64; 2],
    alpha: f64,
) -> Fastest {
    let pull: [f64; WIDTH] = std::array::from_fn(|lane| gravity[lane % 2]);
    let mut fastest = [0.0; WIDTH];
    // A maximum passes over what is not a number, a sum does not.
    let mut total = [0.0; WIDTH];
    let (positions, last_positions) = state.position.as_flattened_mut().as_chunks_mut::<WIDTH>();
    let (velocities, last_velocities) = state.velocity.as_flattened_mut().as_chunks_mut::<WIDTH>();
    let (forces, last_forces) = state.force.as_flattened().as_chunks::<WIDTH>();
    let (masses, last_masses) = state.component_mass.as_chunks::<WIDTH>();
    let moving = positions.iter_mut().zip(velocities);
    for ((position, velocity), (force, mass)) in moving.zip(forces.iter().zip(masses)) {
        for lane in 0..WIDTH {
            advance::<DAMPED>(
                (&mut position[lane], &mut velocity[lane]),
                force[lane] / mass[lane] + pull[lane],
                dt,
                alpha,
                (&mut fastest[lane], &mut total[lane]),
            );
        }
    }
    let moving = last_positions.iter_mut().zip(last_velocities);
    let pushed = last_forces.iter().zip(last_masses);
    for (lane, ((position, velocity), (force, mass))) in moving.zip(pushed).enumerate() {
        let acceleration = force / mass + pull[lane];
        advance::<DAMPED>(
            (position, velocity),
            acceleration,
            dt,
            alpha,
            (&mut fastest[lane], &mut total[lane]),
        );
    }
    if total.iter().any(|total: &f64| total.is_nan()) {
        return [f64::NAN; 2];
    }
    let of = |axis: usize| {
        fastest
            .iter()
            .skip(axis)
            .step_by(2)
            .copied()
            .fold(0.0, f64::max)
    };
    [of(0), of(1)]
}

#[inline(always)]
fn advance<const DAMPED: bool>(
    (position, velocity): (&mut f64, &mut f64),
    mut acceleration: f64,
    dt: f64,
    alpha: f64,
    (fastest, total): (&mut f64, &mut f64),
) {
    if DAMPED {
        let power = acceleration * (*velocity + 0.5 * dt * acceleration);
        let sign = f64::from(u8::from(power > 0.0)) - f64::from(u8::from(power < 0.0));
        acceleration *= 1.0 - alpha * sign;
    }
    *velocity += dt * acceleration;
    *position += dt * *velocity;
    let square = *velocity * *velocity;
    *total += square;
    *fastest = if square > *fastest { square } else { *fastest };
}

/// The spins, damped and advanced like a velocity component.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
pub fn integrate_spins(state: &mut State, dt: f64, alpha: f64) {
    let half_step = 0.5 * dt;
    for ((spin, torque), inertia) in state.spin.iter_mut().zip(&state.torque).zip(&state.inertia) {
        let undamped = torque / inertia;
        let power = undamped * (*spin + half_step * undamped);
        let sign = f64::from(u8::from(power > 0.0)) - f64::from(u8::from(power < 0.0));
        *spin += dt * (undamped * (1.0 - alpha * sign));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::initial_bodies;
    use crate::model::Kernel;
    use crate::scene::paper_scene;

    /// One component as it is written down in the documentation.
    fn reference(
        x: f64,
        v: f64,
        force: f64,
        mass: f64,
        pull: f64,
        dt: f64,
        alpha: f64,
    ) -> [f64; 2] {
        let undamped = force / mass + pull;
        let power = undamped * (v + 0.5 * dt * undamped);
        let sign = if power > 0.0 {
            1.0
        } else if power < 0.0 {
            -1.0
        } else {
            0.0
        };
        let acceleration = if alpha == 0.0 {
            undamped
        } else {
            undamped * (1.0 - alpha * sign)
        };
        let v = v + dt * acceleration;
        [x + dt * v, v]
    }

    #[test]
    fn lanes_have_the_bits_of_one_component_after_the_other() {
        // Not a multiple of the width, so that the last lanes have their own loop.
        let mut start = State::new(
            &initial_bodies(&paper_scene(1, 1003)),
            None,
            Kernel::Frictionless,
        );
        for (id, force) in start.force.iter_mut().enumerate() {
            *force = [
                (id as f64).sin() * 90.0,
                if id % 7 == 0 { 0.0 } else { 3.0 },
            ];
        }
        for alpha in [0.0, 0.2] {
            let mut state = start.clone();
            let (dt, gravity) = (1.3e-5, [0.0, -9.81]);
            let mut fastest = integrate(&mut state, dt, gravity, alpha);
            for id in 0..start.position.len() {
                for axis in 0..2 {
                    let [x, v] = reference(
                        start.position[id][axis],
                        start.velocity[id][axis],
                        start.force[id][axis],
                        start.mass[id],
                        gravity[axis],
                        dt,
                        alpha,
                    );
                    assert_eq!(state.position[id][axis].to_bits(), x.to_bits());
                    assert_eq!(state.velocity[id][axis].to_bits(), v.to_bits());
                    assert!(v * v <= fastest[axis]);
                }
            }
            // Once more: the speeds reported are reached, not merely not exceeded.
            for axis in 0..2 {
                let speeds = state.velocity.iter().map(|v| v[axis] * v[axis]);
                fastest[axis] -= speeds.fold(0.0, f64::max);
            }
            assert_eq!(fastest, [0.0; 2]);
        }
    }
}
