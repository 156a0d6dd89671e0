//! What follows from the rest if one thing that forces or torques are made of is taken from elsewhere.

use std::collections::BTreeMap;

use grains::reference::{Ingredient, Made, Makes, OF_FORCES, OF_TORQUES, Reference};
use grains::vector::{Vector, dot, hypot, minus, plus, times};

use super::*;

/// So many rows that are off, and so many that are not, are looked at in each run.
const MOST: usize = 40;
/// So many rows that are off must follow.
const FEWEST: usize = 8;
/// So many times what may be rounding is left at most.
const LEFT: f64 = 5.0;

/// The contacts of a moment in the order of their table, and those of the one before.
pub(super) struct Around<'a> {
    pub(super) reference: &'a Reference,
    pub(super) now: &'a [Made],
    /// With what the contacts remember that stood a step before at their place in the table, and at their place among those of the first body.
    pub(super) in_slots: &'a [[Option<Made>; 2]],
    pub(super) before: &'a BTreeMap<(u32, u32), Made>,
}

/// From where something may be taken, in words, and what is there for a contact of the table.
type Source = (&'static str, fn(&Around<'_>, usize) -> Option<Made>);

/// The order decides which of several that explain the same is told.
const SOURCES: &[Source] = &[
    ("of the step before", |around, at| {
        around.before.get(&around.now[at].ids()).cloned()
    }),
    ("of the other one", |around, at| {
        Some(around.now[at].exchanged())
    }),
    ("left out", |around, at| {
        Some(around.now[at].changed(|_| NONE))
    }),
    ("of the other sign", |around, at| {
        Some(around.now[at].changed(|vector| times(-1.0, vector)))
    }),
    ("without what is along x", |around, at| {
        Some(around.now[at].changed(|[_, y, z]| [0.0, y, z]))
    }),
    ("without what is along y", |around, at| {
        Some(around.now[at].changed(|[x, _, z]| [x, 0.0, z]))
    }),
    ("without what is along z", |around, at| {
        Some(around.now[at].changed(|[x, y, _]| [x, y, 0.0]))
    }),
    ("along the normal alone", |around, at| {
        let normal = around.now[at].normal();
        let along = move |vector| times(dot(vector, normal), normal);
        Some(around.now[at].changed(along))
    }),
    ("across the normal alone", |around, at| {
        let normal = around.now[at].normal();
        let across = move |vector| minus(vector, times(dot(vector, normal), normal));
        Some(around.now[at].changed(across))
    }),
    ("with x and y exchanged", |around, at| {
        Some(around.now[at].changed(|[x, y, z]| [y, x, z]))
    }),
    ("with x and z exchanged", |around, at| {
        Some(around.now[at].changed(|[x, y, z]| [z, y, x]))
    }),
    ("with y and z exchanged", |around, at| {
        Some(around.now[at].changed(|[x, y, z]| [x, z, y]))
    }),
    ("of the contact before in the table", |around, at| {
        around.now.get(at.checked_sub(1)?).cloned()
    }),
    ("of the contact after in the table", |around, at| {
        around.now.get(at + 1).cloned()
    }),
    (
        "of the first contact of the same first body",
        |around, at| {
            let first = around.now[at].ids().0;
            around
                .now
                .iter()
                .find(|made| made.ids().0 == first)
                .cloned()
        },
    ),
    (
        "of the contact before of the same second body",
        |around, at| {
            let second = around.now[at].ids().1;
            let mut before = around.now[..at].iter().rev();
            before.find(|made| made.ids().1 == second).cloned()
        },
    ),
    (
        "of the contact that was at its place in the table a step before",
        |around, at| around.in_slots[at][0].clone(),
    ),
    (
        "of the contact that was at its place among those of its first body a step before",
        |around, at| around.in_slots[at][1].clone(),
    ),
    (
        "of the whole speed in the place of that along the normal",
        |around, at| Some(around.now[at].approaching_as_it_passes()),
    ),
    ("of the grain with the id before", |around, at| {
        around.reference.with_motions_of(&around.now[at], -1)
    }),
    ("of the grain with the id after", |around, at| {
        around.reference.with_motions_of(&around.now[at], 1)
    }),
];

/// How many rows of each kind that are right and that are off have been looked at in a run.
#[derive(Default)]
pub(super) struct Kept(BTreeMap<((usize, usize), bool), usize>);

impl Kept {
    /// Whether one more is looked at.
    pub(super) fn takes(&mut self, key: (usize, usize), row: &Row) -> bool {
        let count = self.0.entry((key, row.is_off())).or_default();
        *count += 1;
        *count <= MOST
    }
}

impl Around<'_> {
    /// What a contact makes of each thing from each place.
    fn makes(&self, at: usize, ingredients: &'static [Ingredient]) -> Vec<Makes> {
        let found: Vec<Option<Made>> = SOURCES.iter().map(|source| source.1(self, at)).collect();
        let mut makes = Vec::with_capacity(ingredients.len() * SOURCES.len());
        for ingredient in ingredients {
            for found in &found {
                let mut made = self.now[at].clone();
                if let Some(found) = found {
                    ingredient.1(&mut made, found);
                }
                makes.push(self.reference.makes(&made));
            }
        }
        makes
    }

    /// Adds to the rows of this moment by how much forces would be others.
    pub(super) fn add_to(&self, rows: &mut Rows, moment: (usize, usize), kept: &mut Kept) {
        let place: BTreeMap<(u32, u32), usize> = self
            .now
            .iter()
            .enumerate()
            .map(|(at, made)| (made.ids(), at))
            .collect();
        let mut known: BTreeMap<usize, Vec<Makes>> = BTreeMap::new();
        for (key, rows) in rows.iter_mut() {
            let quantity = &key.0;
            let is_normal = *quantity == NORMAL;
            if !is_normal && !(NEW_STICKS..=SLIDING_ON).contains(quantity) {
                continue;
            }
            for row in rows.iter_mut().filter(|row| row.at == moment) {
                let Of::Contact(one, two) = row.subject else {
                    continue;
                };
                let Some(&at) = place.get(&(one, two)).filter(|_| kept.takes(*key, row)) else {
                    continue;
                };
                let makes = known.entry(at).or_insert_with(|| self.makes(at, OF_FORCES));
                let usual = self.reference.makes(&self.now[at]);
                let normal = self.now[at].normal();
                let across = |vector| minus(vector, times(dot(vector, normal), normal));
                row.elsewhere = makes
                    .iter()
                    .map(|makes| match is_normal {
                        true => [makes.normal_force - usual.normal_force, 0.0, 0.0],
                        false => across(minus(makes.tangential, usual.tangential)),
                    })
                    .collect();
            }
        }
    }

    /// By how much the force and the torque on each grain would be others.
    pub(super) fn on_grains(&self, grains: usize) -> Vec<[Vec<Vector>; 2]> {
        let none = || vec![NONE; OF_TORQUES.len() * SOURCES.len()];
        let mut sums: Vec<[Vec<Vector>; 2]> = (0..grains).map(|_| [none(), none()]).collect();
        for (at, made) in self.now.iter().enumerate() {
            let usual = self.reference.makes(made);
            let (one, two) = made.ids();
            for (which, makes) in self.makes(at, OF_TORQUES).iter().enumerate() {
                let force = minus(makes.force, usual.force);
                for (side, id, sign) in [(0, one, -1.0), (1, two, 1.0)] {
                    let Some([forces, torques]) = sums.get_mut(id as usize) else {
                        continue;
                    };
                    forces[which] = plus(forces[which], times(sign, force));
                    let torque = minus(makes.torques[side], usual.torques[side]);
                    torques[which] = plus(torques[which], torque);
                }
            }
        }
        sums
    }
}

/// What explains all of these rows of which it is known, and which of all it is.
pub(super) fn explained(quantity: usize, rows: &[&Row]) -> Option<(String, usize)> {
    let known = || rows.iter().filter(|row| !row.elsewhere.is_empty());
    let ingredients = match quantity < VELOCITIES {
        true => OF_FORCES,
        false => OF_TORQUES,
    };
    let off = known().filter(|row| row.ratio() > PLAIN).count();
    if off < FEWEST {
        return None;
    }
    let explains = |which: &usize| {
        known().all(|row| hypot(minus(row.off, row.elsewhere[*which])) <= LEFT * row.least)
    };
    let both = ingredients
        .iter()
        .flat_map(|one| SOURCES.iter().map(move |source| (one, source)));
    let mut all = both.enumerate();
    let (which, (ingredient, source)) = all.find(|(which, _)| explains(which))?;
    Some((format!("with {} {}", ingredient.0, source.0), which))
}
