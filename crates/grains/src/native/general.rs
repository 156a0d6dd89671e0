//! The general kernel: friction with history, rotations and dashpots; pairs of grains in vector lanes, then walls and punch by
//! the scalar law, one after the other in the order of the list.

use super::contact::{Action, ContactRules, Memory, Motion};
use super::neighbours::{Neighbours, Share};
use super::state::{Constants, State, contact_row};
use crate::model::Kernel;
use crate::tables::{Body, Contact, Remembered};

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
    let [at_walls, _] = rules.tan_squared_at;
    let rules = rules.limited_by(at_walls);
    for ((at, wall), memory) in share.by_wall.iter().zip(&mut share.wall_memory) {
        let (at, wall) = (*at as usize, &constants.walls[*wall as usize]);
        let Some(touch) = state.wall_touch(wall, at) else {
            *memory = Memory::default();
            continue;
        };
        let parameters = constants.of_flat(state, Body::Wall, at);
        let wall = Motion::default();
        let action = rules.act(&touch, &parameters, &wall, &state.motion(at), memory);
        push(&mut force[at - first], &action);
        torque[at - first] += action.torques[1];
    }
}

/// The same of the contacts with the punch, for either kernel.
pub fn punch_contacts(
    state: &mut State,
    list: &mut Neighbours,
    constants: &Constants,
    rules: &ContactRules,
) {
    let Some(punch) = state.punch else {
        return;
    };
    let [_, at_punch] = rules.tan_squared_at;
    let (motion, rules) = (Motion::from(&punch), rules.limited_by(at_punch));
    let mut on_punch = 0.0;
    for (at, memory) in list.by_punch.iter().zip(&mut list.punch_memory) {
        let at = *at as usize;
        let Some(touch) = state.punch_touch(&punch, at) else {
            *memory = Memory::default();
            continue;
        };
        let parameters = constants.of_flat(state, Body::Punch, at);
        let action = rules.act(&touch, &parameters, &motion, &state.motion(at), memory);
        on_punch -= action.force[1];
        push(&mut state.force[at], &action);
        if let Some(torque) = state.torque.get_mut(at) {
            *torque += action.torques[1];
        }
    }
    if let Some(punch) = &mut state.punch {
        punch.force = on_punch;
    }
}

/// Adds the force of a contact on its second body.
fn push(force: &mut [f64; 2], action: &Action) {
    force[0] += action.force[0];
    force[1] += action.force[1];
}

/// What touching contacts remember, sorted by ids; for the frictionless kernel, all that is listed.
pub fn listed(state: &State, list: &Neighbours, constants: &Constants, into: &mut Vec<Remembered>) {
    let remembers = constants.kernel() == Kernel::General;
    let number = |at: u32| state.number[at as usize];
    let mut add = |id1: u32, id2: u32, memory: Option<&Memory>| {
        let memory = memory.filter(|_| remembers).copied().unwrap_or_default();
        if memory.touching() || !remembers {
            into.push(Remembered {
                id1,
                id2,
                normal: memory.normal,
                shear: memory.shear,
            });
        }
    };
    for share in &list.shares {
        if remembers {
            for ([first, second], memory) in share.pairs.memories() {
                // Across a border it stands in another share too.
                if share.places.contains(&first) {
                    add(state.number[first], state.number[second], Some(&memory));
                }
            }
        } else {
            for first in share.places.clone().map(|first| first as u32) {
                let others = share.row(first as usize).iter().map(|at| number(*at));
                let higher = others.filter(|second| *second > number(first));
                higher.for_each(|second| add(number(first), second, None));
            }
        }
        for (index, (at, wall)) in share.by_wall.iter().enumerate() {
            let wall = constants.ids.wall(*wall as usize);
            add(wall, number(*at), share.wall_memory.get(index));
        }
    }
    for (at, memory) in list.by_punch.iter().zip(&list.punch_memory) {
        add(constants.ids.punch(), number(*at), Some(memory));
    }
    into.sort_unstable_by_key(|memory| (memory.id1, memory.id2));
}

/// The contact of these bodies where they touch, with its tangential force as the last evaluation left it.
pub fn contact(
    state: &State,
    constants: &Constants,
    rules: &ContactRules,
    memory: Remembered,
) -> Option<(Contact, Remembered)> {
    let at = state.place[memory.id2 as usize] as usize;
    let mut one = Motion::default();
    let (touch, parameters) = if constants.ids.is_grain(memory.id1) {
        let first = state.place[memory.id1 as usize] as usize;
        one = state.motion(first);
        let parameters = constants.of_pair(state, first, at);
        (state.grain_touch(first, at)?, parameters)
    } else {
        let wall = constants
            .walls
            .get((memory.id1 - constants.ids.grains) as usize);
        let touch = if let Some(wall) = wall {
            state.wall_touch(wall, at)
        } else {
            let punch = state.punch.as_ref()?;
            one = punch.into();
            state.punch_touch(punch, at)
        };
        let flat = constants.ids.body(memory.id1);
        (touch?, constants.of_flat(state, flat, at))
    };
    let normal = rules.normal_force(&touch, &parameters, &one, &state.motion(at));
    let force = [normal[0] + memory.shear[0], normal[1] + memory.shear[1]];
    let memory = Remembered {
        normal: touch.normal,
        ..memory
    };
    Some((contact_row(memory.id1, memory.id2, &touch, force), memory))
}
