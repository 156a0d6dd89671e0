//! The same case in both engines: every number of every moment must have the same bits.

use super::{Group, Line, Track};
use crate::engine::case::Case;
use crate::engine::native::contact::{self, Pair};
use crate::tables::{Bodies, BodyIds, Contact, Punch, Snapshot};

/// A case that two engines must agree on.
pub struct ParityRung {
    /// A short name of its own, in kebab-case.
    pub name: String,
    /// What it shows, in one line.
    pub title: String,
    /// What kind of evidence it gives.
    pub group: Group,
    /// What is run in both engines.
    pub case: Case,
    /// The kinds of pairs that must be among its contacts; empty if it is about motion.
    pub pairs: Vec<Pair>,
}

/// Why no tolerance is left to be argued about.
const BASIS: &str = "same operations in the same order: every bit";

/// Compares two tracks of a rung's case, number by number.
pub fn judge(rung: &ParityRung, one: &Track, other: &Track) -> Vec<Line> {
    let moments = || one.iter().zip(other);
    let length = one.len().abs_diff(other.len());
    let motion = moments().map(|(a, b)| differing_motion(&a.bodies, &b.bodies));
    let numbers: usize = one
        .iter()
        .map(|moment| {
            moment
                .bodies
                .motion()
                .iter()
                .map(|(_, c)| c.len())
                .sum::<usize>()
        })
        .sum();
    let mut lines = vec![differing(
        &format!("positions, velocities and spins that differ, of {numbers}"),
        motion.sum::<usize>() + length,
        numbers,
    )];
    if rung.pairs.is_empty() {
        let contacts = moments().map(|(a, b)| differing_contacts(&a.contacts, &b.contacts));
        let numbers = one
            .iter()
            .map(|moment| moment.contacts.len())
            .sum::<usize>()
            * COLUMNS;
        lines.push(differing(
            &format!("numbers of contacts that differ, of {numbers}"),
            contacts.sum(),
            numbers,
        ));
    }
    for &pair in &rung.pairs {
        lines.push(contacts_of(pair, rung, one, other));
    }
    lines
}

/// A count that must be zero, out of at least one.
fn differing(quantity: &str, count: usize, of: usize) -> Line {
    Line {
        quantity: quantity.to_owned(),
        unit: "1".to_owned(),
        value: if of == 0 { f64::NAN } else { count as f64 },
        expected: 0.0,
        tolerance: 0.0,
        basis: BASIS.to_owned(),
    }
}

/// Contacts of one kind over all moments.
fn contacts_of(pair: Pair, rung: &ParityRung, one: &Track, other: &Track) -> Line {
    let ids = BodyIds {
        grains: rung.case.bodies.len() as u32,
        walls: rung.case.model.walls.len() as u32,
    };
    let pick = |moment: &Snapshot| -> Vec<Contact> {
        let of_kind = |contact: &&Contact| kind(contact, moment, ids) == Some(pair);
        moment.contacts.iter().filter(of_kind).copied().collect()
    };
    let (mut count, mut numbers) = (0, 0);
    for (a, b) in one.iter().zip(other) {
        let (a, b) = (pick(a), pick(b));
        count += differing_contacts(&a, &b);
        numbers += a.len().max(b.len()) * COLUMNS;
    }
    let what = match pair {
        Pair::Grains => "grain and grain",
        Pair::Wall => "wall and grain",
        Pair::PunchOutside => "punch face, edge or corner and grain",
        Pair::PunchInside => "punch and grain inside it",
    };
    differing(
        &format!("{what}: numbers that differ, of {numbers}"),
        count,
        numbers,
    )
}

fn kind(contact: &Contact, moment: &Snapshot, ids: BodyIds) -> Option<Pair> {
    if ids.is_grain(contact.id1) {
        return Some(Pair::Grains);
    }
    if contact.id1 < ids.punch() {
        return Some(Pair::Wall);
    }
    let at = contact.id2 as usize;
    let position = [moment.bodies.x[at], moment.bodies.z[at]];
    let Punch {
        centre,
        half_extents,
        ..
    } = moment.punch?;
    contact::punch(centre, half_extents, position, moment.bodies.radius[at]).map(|touch| touch.pair)
}

/// Whether any number of two moments differs.
pub fn differ(a: &Snapshot, b: &Snapshot) -> bool {
    differing_motion(&a.bodies, &b.bodies) + differing_contacts(&a.contacts, &b.contacts) > 0
}

/// Numbers of motion that have not the same bits.
fn differing_motion(a: &Bodies, b: &Bodies) -> usize {
    let columns = a.motion().into_iter().zip(b.motion());
    columns
        .map(|((_, a), (_, b))| {
            let unequal = a.iter().zip(b).filter(|(a, b)| !same(**a, **b)).count();
            unequal + a.len().abs_diff(b.len())
        })
        .sum()
}

/// Columns of a contact that are compared.
const COLUMNS: usize = 7;

fn differing_contacts(a: &[Contact], b: &[Contact]) -> usize {
    let key = |contact: &Contact| (contact.id1, contact.id2);
    let columns = |contact: &Contact| -> [f64; COLUMNS] {
        let Contact {
            overlap,
            normal_force,
            tangential_force,
            normal,
            point,
            ..
        } = contact;
        [
            *overlap,
            *normal_force,
            *tangential_force,
            normal[0],
            normal[1],
            point[0],
            point[1],
        ]
    };
    let found = |of: &Contact| b.binary_search_by_key(&key(of), key).ok().map(|at| &b[at]);
    let mut differing = 0;
    let mut partners = 0;
    for contact in a {
        match found(contact) {
            None => differing += COLUMNS,
            Some(partner) => {
                partners += 1;
                let pairs = columns(contact).into_iter().zip(columns(partner));
                differing += pairs.filter(|(a, b)| !same(*a, *b)).count();
            }
        }
    }
    differing + (b.len() - partners) * COLUMNS
}

/// The same bits; the two zeros are one number.
fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || (a == 0.0 && b == 0.0)
}
