//! The general kernel: friction with history, rotations and dashpots; pairs of grains in vector lanes, then walls and punch by
//! the scalar law, one after the other in the order of the list.

use super::contact::{Action, ContactRules, Memory, Motion, Parameters};
use super::neighbours::{Neighbours, Share};
use super::state::{Constants, State, contact_row};
use crate::tables::{Contact, Punch, Remembered};

/// Evaluates the contacts of a share but for those with the punch, at the present positions and velocities, and sums forces
/// and torques on its grains. Every contact's memory moves on by a step.
pub fn evaluate_forces(
    share: &mut Share,
    state: &State,
    (force, torque): (&mut [[f64; 2]], &mut [f64]),
    constants: &Constants,
    rules: &ContactRules,
) {
    let first = share.places.start;
    share
        .pairs
        .sum_forces(state, rules, first, (&mut *force, &mut *torque));
    let rules = rules.at_walls();
    for ((at, wall), memory) in share.by_wall.iter().zip(&mut share.wall_memory) {
        let (at, wall) = (*at as usize, &constants.walls[*wall as usize]);
        let Some(touch) = state.wall_touch(wall, at) else {
            *memory = Memory::default();
            continue;
        };
        let of = flat_parameters(state, constants, at);
        let wall = Motion::default();
        let action = rules.act(&touch, &of, &wall, &state.motion(at), memory);
        push(&mut force[at - first], &mut torque[at - first], &action);
    }
}

/// The same of the contacts with the punch.
pub fn punch_contacts(
    state: &mut State,
    list: &mut Neighbours,
    constants: &Constants,
    rules: &ContactRules,
) {
    let Some(punch) = state.punch else {
        return;
    };
    let (motion, rules) = (punch_motion(&punch), rules.at_punch());
    let mut on_punch = 0.0;
    for (at, memory) in list.by_punch.iter().zip(&mut list.punch_memory) {
        let at = *at as usize;
        let Some(touch) = state.punch_touch(&punch, at) else {
            *memory = Memory::default();
            continue;
        };
        let of = flat_parameters(state, constants, at);
        let action = rules.act(&touch, &of, &motion, &state.motion(at), memory);
        on_punch -= action.force[1];
        push(&mut state.force[at], &mut state.torque[at], &action);
    }
    if let Some(punch) = &mut state.punch {
        punch.force = on_punch;
    }
}

/// Adds what a contact does to its second body.
fn push(force: &mut [f64; 2], torque: &mut f64, action: &Action) {
    force[0] += action.force[0];
    force[1] += action.force[1];
    *torque += action.torques[1];
}

fn flat_parameters(state: &State, constants: &Constants, at: usize) -> Parameters {
    let radius = state.radius[at];
    constants.parameters(radius, radius, state.mass[at])
}

fn punch_motion(punch: &Punch) -> Motion {
    Motion {
        position: punch.centre,
        velocity: [0.0, punch.velocity],
        spin: 0.0,
    }
}

/// What touching contacts remember, sorted by ids.
pub fn remembered(
    state: &State,
    list: &Neighbours,
    constants: &Constants,
    into: &mut Vec<Remembered>,
) {
    let number = |at: u32| state.number[at as usize];
    let mut add = |id1: u32, id2: u32, memory: Memory| {
        if memory.touching() {
            into.push(Remembered {
                id1,
                id2,
                normal: memory.normal,
                shear: memory.shear,
            });
        }
    };
    for share in &list.shares {
        for ([first, second], memory) in share.pairs.memories() {
            // Across a border it stands in another share too.
            if share.places.contains(&first) {
                add(state.number[first], state.number[second], memory);
            }
        }
        for ((at, wall), memory) in share.by_wall.iter().zip(&share.wall_memory) {
            add(constants.walls[*wall as usize].id, number(*at), *memory);
        }
    }
    for (at, memory) in list.by_punch.iter().zip(&list.punch_memory) {
        add(constants.ids.punch(), number(*at), *memory);
    }
    into.sort_unstable_by_key(|of| (of.id1, of.id2));
}

/// The contacts as the last evaluation left them, and what they remember, sorted by ids.
pub fn contacts(
    state: &State,
    list: &Neighbours,
    constants: &Constants,
    rules: &ContactRules,
) -> Vec<(Contact, Remembered)> {
    let mut all = Vec::new();
    remembered(state, list, constants, &mut all);
    let contact = |of: Remembered| {
        let at = state.place[of.id2 as usize] as usize;
        let wall = constants.walls.iter().find(|wall| wall.id == of.id1);
        let (touch, parameters, one) = if constants.ids.is_grain(of.id1) {
            let first = state.place[of.id1 as usize] as usize;
            let parameters = constants.of_pair(state, first, at);
            (
                state.grain_touch(first, at),
                parameters,
                state.motion(first),
            )
        } else {
            let (touch, motion) = match (wall, &state.punch) {
                (Some(wall), _) => (state.wall_touch(wall, at), Motion::default()),
                (None, Some(punch)) => (state.punch_touch(punch, at), punch_motion(punch)),
                (None, None) => (None, Motion::default()),
            };
            (touch, flat_parameters(state, constants, at), motion)
        };
        let touch = touch?;
        let normal = rules.normal_force(&touch, &parameters, &one, &state.motion(at));
        let force = [normal[0] + of.shear[0], normal[1] + of.shear[1]];
        Some((contact_row(of.id1, of.id2, &touch, force), of))
    };
    all.into_iter().filter_map(contact).collect()
}
