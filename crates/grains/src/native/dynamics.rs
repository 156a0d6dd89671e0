//! The step: integrate (leapfrog, with Cundall's local damping where the scene has it), move the punch, list neighbours
//! anew if need be, evaluate the forces.

use std::borrow::Cow;
use std::time::{Duration, Instant};

use multiversion::multiversion;

use super::contact::{self, ContactRules};
use super::general;
use super::health::{self, Trouble};
use super::neighbours::{Neighbours, Share, Skin};
use super::rounding::Shaker;
use super::springs::{self, At, Sums};
use super::state::{Constants, State};
use super::sweep;
use super::threads::{Team, Threads, each};
use crate::constant::Given;
use crate::model::Kernel;
use crate::reference::Reference;
use crate::reference::space::Space;
use crate::rules::GivenVelocities;
use crate::tables::{Bodies, Body, Contact, Memories, Punch, Remembered, Snapshot, Stage};
use crate::variant::Variant;
use crate::vector::in_plane;

/// The parts of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    Integration,
    NeighbourLists,
    /// Between grains and at walls.
    Contacts,
    Punch,
}

/// The time that the parts of steps took; where nobody asks for it nobody looks at the clock.
#[derive(Default)]
pub struct Clock(pub Option<[Duration; 4]>);

impl Clock {
    /// Does the work of this part.
    fn time<T>(&mut self, part: Part, work: impl FnOnce() -> T) -> T {
        let began = self.0.map(|_| Instant::now());
        let result = work();
        if let (Some(spent), Some(began)) = (&mut self.0, began) {
            spent[part as usize] += began.elapsed();
        }
        result
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
    /// Steps that were done in sweeps.
    pub swept: u64,
    /// The velocities of the start are taken for those at the start, and the first step is still to come.
    half_step_to_come: bool,
    rules: ContactRules,
    team: Team,
    kept: Kept,
    /// Makes the steps under unusual rules and in space.
    reference: Option<Box<Reference>>,
    /// Makes them faster where it can: the reference then has the contacts of the punch alone.
    space: Option<Space>,
}

/// Positions, velocities and forces before the first sweep with a list.
#[derive(Default)]
struct Kept {
    columns: [Vec<[f64; 2]>; 3],
    /// How many lists had been built, and for how many steps this one had held.
    builds: u64,
    held: u32,
}

impl Kept {
    fn keep(&mut self, state: &State, neighbours: &Neighbours) {
        if self.builds == neighbours.builds {
            return;
        }
        (self.builds, self.held) = (neighbours.builds, neighbours.held_for());
        let columns = [&state.position, &state.velocity, &state.force];
        for (kept, column) in self.columns.iter_mut().zip(columns) {
            kept.clone_from(column);
        }
    }

    fn put_back(&self, state: &mut State) {
        let columns = [&mut state.position, &mut state.velocity, &mut state.force];
        for (kept, column) in self.columns.iter().zip(columns) {
            column.copy_from_slice(kept);
        }
    }
}

impl Dynamics {
    /// Lists the neighbours and evaluates the forces at the start. Where contacts remember something, the evaluation leaves it
    /// as it is; elsewhere they begin to.
    pub fn new(
        bodies: &Bodies,
        punch: Option<Punch>,
        memory: &Memories,
        constants: Constants,
        skin: Skin,
        threads: Threads,
    ) -> Result<Self, Trouble> {
        let threads = threads.of(bodies.len());
        let mut dynamics = Dynamics {
            state: State::new(bodies, punch, constants.kernel()),
            rules: constants.contact_rules(),
            constants,
            neighbours: Neighbours::new(skin, threads, bodies.len()),
            team: Team::new(threads),
            punch_is_new: false,
            swept: 0,
            half_step_to_come: false,
            kept: Kept::default(),
            reference: None,
            space: None,
        };
        if bodies.in_space() {
            health::check(&dynamics.state, &dynamics.constants)?;
        } else if memory.is_empty() {
            dynamics.list_neighbours()?;
            dynamics.evaluate_forces(&mut Clock::default());
        } else {
            dynamics.list(Some(&memory.planar))?;
            // Neither slip nor a limit: what is remembered stays to the bit.
            let rules = ContactRules {
                dt: 0.0,
                tan_squared: f64::INFINITY,
                tan_squared_at: [f64::INFINITY; 2],
                ..dynamics.rules.clone()
            };
            let rules = std::mem::replace(&mut dynamics.rules, rules);
            dynamics.evaluate_forces(&mut Clock::default());
            dynamics.rules = rules;
        }
        dynamics.half_step_to_come = dynamics.constants.half_step_start;
        if bodies.in_space() || !dynamics.constants.rules.are_usual() {
            let mut given = Given {
                constants: dynamics.constants.clone(),
                bodies: bodies.clone(),
                punch,
            };
            if given.constants.half_step_start {
                given.constants.rules.given_velocities = GivenVelocities::AtStart;
            }
            let mut reference = Reference::going_on(given, memory, &Variant::default());
            take_over(&reference, &mut dynamics.state);
            dynamics.space = Space::of(&mut reference);
            dynamics.reference = Some(Box::new(reference));
        }
        Ok(dynamics)
    }

    /// Goes on with other constants. Forces stay what they are until the next step, and so do shear forces of contacts.
    pub fn change(&mut self, constants: Constants) -> Result<(), Trouble> {
        let memory = self.contacts().1;
        if let Some(reference) = &mut self.reference {
            if let Some(space) = self.space.take() {
                space.hand_back(reference);
            }
            reference.change_constants(constants.clone());
            self.space = Space::of(reference);
            if reference.is_in_space() {
                self.constants = constants;
                return Ok(());
            }
        }
        self.rules = constants.contact_rules();
        self.constants = constants;
        self.state.suit(self.constants.kernel());
        self.list(Some(&memory))
    }

    /// One time step.
    pub fn step(&mut self) -> Result<(), Trouble> {
        self.step_timed(&mut Clock::default())
    }

    /// The same with a clock that is told which part of the step is under way.
    pub fn step_timed(&mut self, clock: &mut Clock) -> Result<(), Trouble> {
        if let Some(reference) = &mut self.reference {
            self.punch_is_new = false;
            let (space, state) = (&mut self.space, &mut self.state);
            clock.time(Part::Contacts, || {
                match reference.is_in_space() {
                    true => reference.press(state.punch),
                    false => reference.put(&state.bodies(), state.punch),
                }
                written_out(reference, space);
                take_over(reference, state);
            });
            return Ok(());
        }
        let fastest = self.advance(clock);
        let held = clock.time(Part::Integration, || {
            let punch_height = self.state.punch.map(|punch| punch.centre[1]);
            let (dt, position) = (self.constants.dt, &self.state.position);
            self.neighbours.hold(fastest, dt, position, punch_height)
        });
        if !held {
            clock.time(Part::NeighbourLists, || self.list_neighbours())?;
        }
        self.evaluate_forces(clock);
        Ok(())
    }

    /// Moves grains and punch.
    fn advance(&mut self, clock: &mut Clock) -> Fastest {
        if self.half_step_to_come {
            self.half_a_step_back();
            self.half_step_to_come = false;
        }
        let Constants {
            dt, gravity, alpha, ..
        } = self.constants;
        if let Some(punch) = &mut self.state.punch {
            punch.centre[1] += punch.velocity * dt;
        }
        clock.time(Part::Integration, || {
            let state = &mut self.state;
            let moved: Moved = (
                (&mut state.position, &mut state.velocity),
                (&state.force, &state.component_mass),
            );
            let turned: Turned = (&mut state.spin, (&state.torque, &state.inertia));
            let rotates = self.constants.law.rotates();
            let advance = |_: &mut Share, (moved, turned): (Moved, Turned)| {
                if rotates {
                    integrate_spins(turned, dt, alpha);
                }
                integrate(moved, dt, gravity, alpha)
            };
            let shares = &mut self.neighbours.shares;
            let all = || each(shares, Share::first, (moved, turned), &advance, &faster);
            self.team.together(all)
        })
    }

    /// So many steps, at which nobody looks but at the last. Where the model allows it several are done in one sweep over
    /// memory. An error says how many steps were done before it.
    pub fn steps(&mut self, steps: u64) -> Result<(), (u64, Trouble)> {
        let team = self.team.clone();
        team.together(|| {
            let mut done = 0;
            while done < steps {
                done += self
                    .some_steps(steps - done)
                    .map_err(|trouble| (done, trouble))?;
            }
            Ok(())
        })
    }

    /// At least one step and at most so many; says how many it were.
    fn some_steps(&mut self, most: u64) -> Result<u64, Trouble> {
        if let Some(reference) = self
            .reference
            .as_mut()
            .filter(|reference| reference.is_in_space())
        {
            self.punch_is_new = false;
            reference.press(self.state.punch);
            (0..most).for_each(|_| written_out(reference, &mut self.space));
            take_over(reference, &mut self.state);
            return Ok(most);
        }
        let general = self.constants.kernel() == Kernel::General;
        let alone = general || self.state.punch.is_some() || self.reference.is_some();
        let ahead = match alone || self.half_step_to_come {
            true => 1,
            false => self.neighbours.steps_ahead(most),
        };
        if ahead < 2 {
            self.step()?;
            return Ok(1);
        }
        self.kept.keep(&self.state, &self.neighbours);
        let (state, list) = (&mut self.state, &mut self.neighbours);
        let speeds = sweep::sweep(state, list, &self.constants, ahead);
        if !list.held(&speeds[..ahead], self.constants.dt) {
            self.go_back(ahead as u32)?;
            self.step()?;
            return Ok(1);
        }
        self.swept += ahead as u64;
        Ok(ahead as u64)
    }

    /// Takes back a sweep in which grains went further than its list allows.
    fn go_back(&mut self, steps: u32) -> Result<(), Trouble> {
        let since = self.neighbours.held_for() - steps - self.kept.held;
        self.kept.put_back(&mut self.state);
        for _ in 0..since {
            self.advance(&mut Clock::default());
            self.evaluate_forces(&mut Clock::default());
        }
        self.list_neighbours()
    }

    /// Checks every grain and lists the neighbours anew.
    pub fn list_neighbours(&mut self) -> Result<(), Trouble> {
        self.list(None)
    }

    fn list(&mut self, memory: Option<&[Remembered]>) -> Result<(), Trouble> {
        health::check(&self.state, &self.constants)?;
        if self.in_space().is_some() {
            return Ok(());
        }
        let state = &mut self.state;
        self.neighbours
            .build(state, &self.constants, memory, &self.team);
        Ok(())
    }

    fn evaluate_forces(&mut self, clock: &mut Clock) {
        self.punch_is_new = false;
        let general = self.constants.kernel() == Kernel::General;
        clock.time(Part::Contacts, || {
            // Apart from the state, which all read.
            let mut force = std::mem::take(&mut self.state.force);
            let mut torque = std::mem::take(&mut self.state.torque);
            let (seen, shares) = (&self.state, &mut self.neighbours.shares);
            let (constants, rules) = (&self.constants, &self.rules);
            let sums = (force.as_mut_slice(), torque.as_mut_slice());
            let evaluate = |share: &mut Share, sums: (&mut [[f64; 2]], &mut [f64])| match general {
                true => general::evaluate_forces(share, seen, sums, constants, rules),
                false => {
                    let position = (At(0, seen.position.as_slice()), seen.radius.as_slice());
                    for block in 0..share.rows.blocks() {
                        let sums = At(share.places.start, &mut *sums.0);
                        springs_and_walls(share, block, position, sums, constants);
                    }
                }
            };
            let both = |(), ()| ();
            let all = || each(shares, Share::first, sums, &evaluate, &both);
            self.team.together(all);
            (self.state.force, self.state.torque) = (force, torque);
        });
        clock.time(Part::Punch, || {
            let (state, list) = (&mut self.state, &mut self.neighbours);
            general::punch_contacts(state, list, &self.constants, &self.rules);
        });
    }

    /// Takes the velocities for those at the start: v(−dt/2) = v(0) − ½dt·a.
    fn half_a_step_back(&mut self) {
        let Constants { dt, gravity, .. } = self.constants;
        let state = &mut self.state;
        let pushed = state.force.iter().zip(&state.mass);
        for (velocity, (force, mass)) in state.velocity.iter_mut().zip(pushed) {
            for axis in 0..2 {
                velocity[axis] -= 0.5 * dt * (force[axis] / mass + gravity[axis]);
            }
        }
        let turned = state.torque.iter().zip(&state.inertia);
        for (spin, (torque, inertia)) in state.spin.iter_mut().zip(turned) {
            *spin -= 0.5 * dt * (torque / inertia);
        }
    }

    /// The reference with all its contacts.
    fn with_contacts(&self) -> Option<Cow<'_, Reference>> {
        let reference = self.reference.as_deref()?;
        let Some(space) = &self.space else {
            return Some(Cow::Borrowed(reference));
        };
        let mut whole = reference.clone();
        space.clone().hand_back(&mut whole);
        Some(Cow::Owned(whole))
    }

    /// The step in space, where there is one.
    fn in_space(&self) -> Option<&Reference> {
        self.reference
            .as_deref()
            .filter(|reference| reference.is_in_space())
    }

    /// Puts in rounding errors of another engine, before the first step or after one.
    pub(super) fn shake(&mut self, noise: &mut Shaker) {
        let Some(reference) = self
            .reference
            .as_mut()
            .filter(|reference| reference.is_in_space())
        else {
            return noise.shake(&mut self.state, &self.constants);
        };
        let mut bodies = reference.bodies();
        let moving = reference.moving();
        let loaded: Vec<bool> = moving.map(|(_, (force, _))| force != [0.0; 3]).collect();
        noise.shake_in_space(&mut bodies, |id| loaded[id], &self.constants);
        reference.put(&bodies, self.state.punch);
        if let Some(space) = &mut self.space {
            space.gone = f64::INFINITY;
        }
        take_over(reference, &mut self.state);
    }

    /// Σ ½mv², then Σ ½Iω², J.
    pub fn kinetic_energy(&self) -> f64 {
        match self.in_space() {
            Some(reference) => reference.bodies().kinetic_energy(),
            None => self.state.kinetic_energy(),
        }
    }

    /// This moment as a table.
    pub fn snapshot(&self, stage: Stage, step: u64) -> Snapshot {
        let reference = self.with_contacts();
        if let Some(reference) = reference
            .as_ref()
            .filter(|reference| reference.is_in_space())
        {
            return Snapshot {
                stage,
                step,
                time: step as f64 * self.constants.dt,
                punch: self.state.punch,
                ..reference.snapshot()
            };
        }
        let reference =
            reference.map(|reference| reference.moved(&self.state.bodies(), self.state.punch));
        if let Some(reference) = reference {
            let Snapshot {
                bodies, contacts, ..
            } = reference.snapshot();
            return Snapshot {
                stage,
                step,
                time: step as f64 * self.constants.dt,
                bodies,
                contacts,
                across: Vec::new(),
                memory: reference.memory(),
                punch: self.state.punch,
            };
        }
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
            across: Vec::new(),
            memory: Memories {
                planar: memory,
                across: Vec::new(),
            },
            punch: self.state.punch,
        }
    }

    /// All contacts with what they remember, sorted by ids. Without friction that is the normal alone.
    fn contacts(&self) -> (Vec<Contact>, Vec<Remembered>) {
        if let Some(reference) = self.with_contacts() {
            return (reference.contacts(), reference.memory().planar);
        }
        let (state, constants) = (&self.state, &self.constants);
        let mut listed = Vec::new();
        general::listed(state, &self.neighbours, constants, &mut listed);
        if self.punch_is_new {
            listed.retain(|memory| memory.id1 != constants.ids.punch());
        }
        let mut contacts = Vec::with_capacity(listed.len());
        // In its own place, for a million contacts take as much memory as their grains.
        listed.retain_mut(|memory| {
            let touching = general::contact(state, constants, &self.rules, *memory);
            contacts.extend(touching.map(|(contact, now)| {
                *memory = now;
                contact
            }));
            touching.is_some()
        });
        (contacts, listed)
    }
}

/// A step that is written out, or with lists.
fn written_out(reference: &mut Reference, space: &mut Option<Space>) {
    match space {
        Some(space) => space.step(reference),
        None => reference.step(),
    }
}

/// The state is what the reference has.
fn take_over(reference: &Reference, state: &mut State) {
    for (number, (moving, (force, torque))) in reference.moving().enumerate() {
        let at = state.place[number] as usize;
        state.position[at] = in_plane(moving.place);
        state.velocity[at] = in_plane(moving.velocity);
        state.force[at] = in_plane(force);
        // Zero where grains have no spins.
        if let Some(to) = state.spin.get_mut(at) {
            *to = moving.spin[1];
        }
        if let Some(to) = state.torque.get_mut(at) {
            *to = torque[1];
        }
    }
    state.punch = reference.punch;
}

/// The summed forces of springs between grains and at walls on the grains of a block of a share.
pub fn springs_and_walls(
    share: &Share,
    block: usize,
    (At(first, position), radius): (At<&[[f64; 2]]>, &[f64]),
    At(from, force): Sums,
    constants: &Constants,
) {
    let (groups, places) = (share.rows.block(block), share.block(block));
    let seen = At(first, position);
    springs::sum_forces(seen, &share.rows, groups, At(from, &mut *force));
    for (at, wall) in share.at_walls(places) {
        let (at, wall) = (*at as usize, &constants.walls[*wall as usize]);
        let radius = radius[at];
        if let Some(touch) = contact::wall(wall, position[at - first], radius) {
            let of_wall = touch.spring_force(constants.flat_stiffness(Body::Wall, radius));
            force[at - from][0] += of_wall[0];
            force[at - from][1] += of_wall[1];
        }
    }
}

/// Components that are advanced together: those of eight grains.
const WIDTH: usize = 16;

/// The fastest component of a step, squared, m²/s²: across and up.
pub type Fastest = [f64; 2];

/// The larger ones; not a number where one is not.
pub fn faster(a: Fastest, b: Fastest) -> Fastest {
    [0, 1].map(|axis| {
        if a[axis] > b[axis] || a[axis].is_nan() {
            a[axis]
        } else {
            b[axis]
        }
    })
}

/// Positions and velocities, forces and masses of a range of places.
pub type Moved<'a> = (
    (&'a mut [[f64; 2]], &'a mut [[f64; 2]]),
    (&'a [[f64; 2]], &'a [[f64; 2]]),
);

/// Spins, torques and moments of inertia of a range of places.
type Turned<'a> = (&'a mut [f64], (&'a [f64], &'a [f64]));

/// Advances velocities and positions: v += dt·a, x += dt·v. With damping the acceleration, gravity
/// included, is scaled by 1 − α·sign(a·(v + ½dt·a)); without it nothing is computed for it. Where a velocity is not
/// a number, the fastest is not one either. Compiled for the widest vector unit that the machine has.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
pub fn integrate(moved: Moved, dt: f64, gravity: [f64; 2], alpha: f64) -> Fastest {
    match alpha == 0.0 {
        true => integrate_plain::<false>(moved, dt, gravity, alpha),
        false => integrate_plain::<true>(moved, dt, gravity, alpha),
    }
}

#[inline(always)]
fn integrate_plain<const DAMPED: bool>(
    ((positions, velocities), (forces, masses)): Moved,
    dt: f64,
    gravity: [f64; 2],
    alpha: f64,
) -> Fastest {
    let pull: [f64; WIDTH] = std::array::from_fn(|lane| gravity[lane % 2]);
    // Bits of squares are in the order of squares, and those of what is not a number come last.
    let mut fastest = [0; WIDTH];
    let (positions, last_positions) = positions.as_flattened_mut().as_chunks_mut::<WIDTH>();
    let (velocities, last_velocities) = velocities.as_flattened_mut().as_chunks_mut::<WIDTH>();
    let (forces, last_forces) = forces.as_flattened().as_chunks::<WIDTH>();
    let (masses, last_masses) = masses.as_flattened().as_chunks::<WIDTH>();
    let moving = positions.iter_mut().zip(velocities);
    for ((position, velocity), (force, mass)) in moving.zip(forces.iter().zip(masses)) {
        // In registers, or the compiler fears that writing one changes another.
        let (mut x, mut v, force, mass) = (*position, *velocity, *force, *mass);
        for lane in 0..WIDTH {
            advance::<DAMPED>(
                (&mut x[lane], &mut v[lane]),
                force[lane] / mass[lane] + pull[lane],
                dt,
                alpha,
                &mut fastest[lane],
            );
        }
        (*position, *velocity) = (x, v);
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
            &mut fastest[lane],
        );
    }
    let largest = |axis: usize| {
        fastest
            .iter()
            .skip(axis)
            .step_by(2)
            .fold(0, |a: u64, b| a.max(*b))
    };
    [f64::from_bits(largest(0)), f64::from_bits(largest(1))]
}

#[inline(always)]
fn advance<const DAMPED: bool>(
    (position, velocity): (&mut f64, &mut f64),
    mut acceleration: f64,
    dt: f64,
    alpha: f64,
    fastest: &mut u64,
) {
    if DAMPED {
        let power = acceleration * (*velocity + 0.5 * dt * acceleration);
        acceleration *= left_by_damping(power, alpha);
    }
    *velocity += dt * acceleration;
    *position += dt * *velocity;
    let square = *velocity * *velocity;
    *fastest = square.to_bits().max(*fastest);
}

/// The spins, damped and advanced like a velocity component.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn integrate_spins((spins, (torques, inertia)): Turned, dt: f64, alpha: f64) {
    let half_step = 0.5 * dt;
    for ((spin, torque), inertia) in spins.iter_mut().zip(torques).zip(inertia) {
        let undamped = torque / inertia;
        let power = undamped * (*spin + half_step * undamped);
        *spin += dt * (undamped * left_by_damping(power, alpha));
    }
}

/// 1 − α·sign(power): three numbers to choose from, which takes less than working it out.
#[inline(always)]
fn left_by_damping(power: f64, alpha: f64) -> f64 {
    let not_more = if power < 0.0 { 1.0 + alpha } else { 1.0 };
    if power > 0.0 { 1.0 - alpha } else { not_more }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::generate::initial_bodies;
    use crate::model::{Kernel, Model};
    use crate::scene::{Scene, paper_scene};

    pub const SKIN: Skin = Skin::Adaptive { radius: 0.005 };

    /// The grains of a scene before the first step, on exactly so many threads.
    pub fn start(scene: &Scene, skin: Skin, threads: usize) -> Dynamics {
        let bodies = initial_bodies(scene);
        let constants = Constants::new(&Model::of(scene), scene.particles.count);
        let threads = Threads {
            most: threads,
            grains_each: 100,
        };
        let dynamics = Dynamics::new(
            &bodies,
            None,
            &Memories::default(),
            constants,
            skin,
            threads,
        );
        dynamics.expect("a sound start")
    }

    /// One component as it is written down in the documentation.
    fn reference([x, v]: [f64; 2], undamped: f64, dt: f64, alpha: f64) -> [f64; 2] {
        let power = undamped * (v + 0.5 * dt * undamped);
        let sign = if power == 0.0 { 0.0 } else { power.signum() };
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
            let moved: Moved = (
                (&mut state.position, &mut state.velocity),
                (&state.force, &state.component_mass),
            );
            let mut fastest = integrate(moved, dt, gravity, alpha);
            for id in 0..start.position.len() {
                for axis in 0..2 {
                    let before = [start.position[id][axis], start.velocity[id][axis]];
                    let acceleration = start.force[id][axis] / start.mass[id] + gravity[axis];
                    let [x, v] = reference(before, acceleration, dt, alpha);
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
