//! The general kernel: friction with history, rotations and dashpots; pairs of grains in vector lanes, then walls and punch by
//! the scalar law, one after the other in the order of the list.

use super::contact::{Action, ContactRules, Memory, Motion, Parameters, Touch};
use super::neighbours::Neighbours;
use super::pairs::Pairs;
use super::state::{Constants, State, contact_row};
use crate::tables::{Contact, Punch, Remembered};

/// Evaluates all contacts at the present positions and velocities and sums forces and torques.
/// Every contact's memory moves on by a step.
pub fn evaluate_forces(
    state: &mut State,
    list: &mut Neighbours,
    constants: &Constants,
    rules: &ContactRules,
) {
    list.history.pairs.sum_forces(state, rules);
    for (index, wall) in constants.walls.iter().enumerate() {
        let memories = &mut list.history.by_wall[index];
        for (id, memory) in list.by_wall[index].iter().zip(memories) {
            let id = *id as usize;
            let Some(touch) = state.wall_touch(wall, id) else {
                *memory = Memory::default();
                continue;
            };
            let of = flat_parameters(state, constants, id);
            let wall = Motion::default();
            let action = rules.act(&touch, &of, &wall, &state.motion(id), memory);
            push(state, id, &action);
        }
    }
    punch_contacts(state, list, constants, rules);
}

fn punch_contacts(
    state: &mut State,
    list: &mut Neighbours,
    constants: &Constants,
    rules: &ContactRules,
) {
    let Some(punch) = state.punch else {
        return;
    };
    let motion = punch_motion(&punch);
    let mut on_punch = 0.0;
    for (id, memory) in list.by_punch.iter().zip(&mut list.history.by_punch) {
        let id = *id as usize;
        let Some(touch) = state.punch_touch(&punch, id) else {
            *memory = Memory::default();
            continue;
        };
        let of = flat_parameters(state, constants, id);
        let action = rules.act(&touch, &of, &motion, &state.motion(id), memory);
        on_punch -= action.force[1];
        push(state, id, &action);
    }
    if let Some(punch) = &mut state.punch {
        punch.force = on_punch;
    }
}

/// Adds what a contact does to its second body.
fn push(state: &mut State, id: usize, action: &Action) {
    state.force[id][0] += action.force[0];
    state.force[id][1] += action.force[1];
    state.torque[id] += action.torques[1];
}

fn flat_parameters(state: &State, constants: &Constants, id: usize) -> Parameters {
    let radius = state.radius[id];
    constants.parameters(radius, radius, state.mass[id])
}

fn punch_motion(punch: &Punch) -> Motion {
    Motion {
        position: punch.centre,
        velocity: [0.0, punch.velocity],
        spin: 0.0,
    }
}

/// The contacts as the last evaluation left them, and what they remember.
pub fn contacts(
    state: &State,
    list: &Neighbours,
    constants: &Constants,
    rules: &ContactRules,
) -> Vec<(Contact, Remembered)> {
    let mut contacts = Vec::new();
    let mut add =
        |ids: (u32, u32), touch: Option<Touch>, of: &Parameters, one: &Motion, memory: &Memory| {
            let Some(touch) = touch.filter(|_| memory.touching()) else {
                return;
            };
            let normal = rules.normal_force(&touch, of, one, &state.motion(ids.1 as usize));
            let force = [normal[0] + memory.shear[0], normal[1] + memory.shear[1]];
            let remembered = Remembered {
                id1: ids.0,
                id2: ids.1,
                normal: memory.normal,
                shear: memory.shear,
            };
            contacts.push((contact_row(ids.0, ids.1, &touch, force), remembered));
        };
    let history = &list.history;
    for (at, ids) in list.pairs().enumerate() {
        let (a, b) = (ids.0 as usize, ids.1 as usize);
        let (of, memory) = history.pairs.get(at);
        let touch = state.grain_touch(a, b);
        add(ids, touch, &of, &state.motion(a), &memory);
    }
    for (index, wall) in constants.walls.iter().enumerate() {
        for (id, memory) in list.by_wall[index].iter().zip(&history.by_wall[index]) {
            let at = *id as usize;
            let of = flat_parameters(state, constants, at);
            let touch = state.wall_touch(wall, at);
            add((wall.id, *id), touch, &of, &Motion::default(), memory);
        }
    }
    if let Some(punch) = state.punch {
        for (id, memory) in list.by_punch.iter().zip(&history.by_punch) {
            let at = *id as usize;
            let of = flat_parameters(state, constants, at);
            let touch = state.punch_touch(&punch, at);
            let ids = (constants.ids.punch(), *id);
            add(ids, touch, &of, &punch_motion(&punch), memory);
        }
    }
    contacts
}

/// What contacts remember, kept in step with the neighbour list: a contact that is listed before and after a rebuild keeps
/// its memory. Memories and parameters stand in the order of the list and are reused from build to build.
#[derive(Debug, Default)]
pub struct History {
    /// Of each listed pair of grains, with its parameters.
    pub pairs: Pairs,
    /// Of each grain near each wall.
    pub by_wall: Vec<Vec<Memory>>,
    /// Of each grain near the punch.
    pub by_punch: Vec<Memory>,
    aside: Aside,
}

/// The lists and memories before a rebuild.
#[derive(Debug, Default)]
struct Aside {
    start: Vec<u32>,
    other: Vec<u32>,
    pairs: Pairs,
    by_wall: Vec<(Vec<u32>, Vec<Memory>)>,
    by_punch: (Vec<u32>, Vec<Memory>),
}

impl History {
    /// Before a rebuild: keeps what is remembered, and for whom.
    pub fn set_aside(
        &mut self,
        start: &[u32],
        other: &[u32],
        by_wall: &[Vec<u32>],
        by_punch: &[u32],
    ) {
        let aside = &mut self.aside;
        copy(&mut aside.start, start);
        copy(&mut aside.other, other);
        std::mem::swap(&mut aside.pairs, &mut self.pairs);
        aside.by_wall.resize_with(by_wall.len(), Default::default);
        self.by_wall.resize_with(by_wall.len(), Default::default);
        for ((aside, ids), memories) in aside.by_wall.iter_mut().zip(by_wall).zip(&mut self.by_wall)
        {
            copy(&mut aside.0, ids);
            std::mem::swap(&mut aside.1, memories);
        }
        copy(&mut aside.by_punch.0, by_punch);
        std::mem::swap(&mut aside.by_punch.1, &mut self.by_punch);
    }

    /// After a rebuild: hands each memory to its pair in the new list.
    pub fn take_over(
        &mut self,
        start: &[u32],
        other: &[u32],
        by_wall: &[Vec<u32>],
        by_punch: &[u32],
        of_pair: impl Fn(u32, u32) -> ([f64; 2], Parameters),
    ) {
        let aside = &self.aside;
        self.pairs.clear();
        for (i, row) in start.windows(2).enumerate() {
            let before = match aside.start.get(i..i + 2) {
                Some(row) => row[0] as usize..row[1] as usize,
                None => 0..0,
            };
            let old = &aside.other[before.clone()];
            for id in &other[row[0] as usize..row[1] as usize] {
                let found = old.iter().position(|old| old == id);
                let memory = found.map(|at| aside.pairs.get(before.start + at).1);
                let (radii, parameters) = of_pair(i as u32, *id);
                let memory = memory.unwrap_or_default();
                self.pairs
                    .push((i as u32, *id), radii, &parameters, &memory);
            }
        }
        self.by_wall.resize_with(by_wall.len(), Default::default);
        for (index, (ids, memories)) in by_wall.iter().zip(&mut self.by_wall).enumerate() {
            match aside.by_wall.get(index) {
                Some(old) => of_flat_body(old, ids, memories),
                None => of_flat_body(&Default::default(), ids, memories),
            }
        }
        of_flat_body(&aside.by_punch, by_punch, &mut self.by_punch);
    }
}

/// Ids in rising order, old and new.
fn of_flat_body(old: &(Vec<u32>, Vec<Memory>), ids: &[u32], memories: &mut Vec<Memory>) {
    memories.clear();
    memories.extend(ids.iter().map(|id| match old.0.binary_search(id) {
        Ok(at) => old.1[at],
        Err(_) => Memory::default(),
    }));
}

fn copy(to: &mut Vec<u32>, from: &[u32]) {
    to.clear();
    to.extend_from_slice(from);
}
