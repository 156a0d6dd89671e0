//! The same case in both engines: every number of every moment must have the same bits.

use super::{Group, Line, Track};
use grains::case::{Case, Load};
use grains::tables::{Bodies, BodyIds, Contact, Punch, Snapshot};

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
    /// Places that must be among its contacts; empty if it is about motion.
    pub places: Vec<Place>,
}

/// What YADE made of a rung's case.
#[derive(Debug, Clone)]
pub struct InYade {
    /// The state at each moment.
    pub track: Track,
    /// Forces and torques summed on each grain at each moment; empty for large cases.
    pub loads: Vec<Vec<Load>>,
}

/// The places at which contacts are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Two grains.
    Grains,
    /// A wall and a grain.
    Wall,
    /// A face of the punch and a grain.
    Face,
    /// A corner of the punch, which is an edge across the plane, and a grain.
    Corner,
    /// The punch and a grain whose centre is inside it.
    Inside,
}

impl Place {
    /// All of them.
    pub const ALL: [Place; 5] = [
        Place::Grains,
        Place::Wall,
        Place::Face,
        Place::Corner,
        Place::Inside,
    ];

    fn name(self) -> &'static str {
        match self {
            Place::Grains => "grain and grain",
            Place::Wall => "wall and grain",
            Place::Face => "punch face and grain",
            Place::Corner => "punch corner (edge) and grain",
            Place::Inside => "punch and grain inside it",
        }
    }

    fn of(contact: &Contact, moment: &Snapshot, ids: BodyIds) -> Option<Place> {
        if ids.is_grain(contact.id1) {
            return Some(Place::Grains);
        }
        if contact.id1 < ids.punch() {
            return Some(Place::Wall);
        }
        let at = contact.id2 as usize;
        let position = [moment.bodies.x[at], moment.bodies.z[at]];
        let Punch {
            centre,
            half_extents,
            ..
        } = moment.punch?;
        let beyond = [0, 1].map(|axis: usize| {
            usize::from((position[axis] - centre[axis]).abs() > half_extents[axis])
        });
        Some(match beyond[0] + beyond[1] {
            0 => Place::Inside,
            1 => Place::Face,
            _ => Place::Corner,
        })
    }
}

/// Why no tolerance is left to be argued about.
const BASIS: &str = "same operations in the same order: every bit";

/// Compares the native engine's track and loads of a rung's case with YADE's, number by number.
pub fn judge(rung: &ParityRung, native: &Track, loads: &[Vec<Load>], yade: &InYade) -> Vec<Line> {
    let moments = || native.iter().zip(&yade.track);
    let length = native.len().abs_diff(yade.track.len());
    let motion = moments().map(|(a, b)| differing_motion(&a.bodies, &b.bodies));
    let columns = native.iter().flat_map(|moment| moment.bodies.motion());
    let numbers: usize = columns.map(|(_, column)| column.len()).sum();
    let mut lines = vec![differing(
        &format!("positions, velocities and spins that differ, of {numbers}"),
        motion.sum::<usize>() + length,
        numbers,
    )];
    let contacts = moments().map(|(a, b)| differing_contacts(&a.contacts, &b.contacts));
    let numbers = native
        .iter()
        .map(|moment| moment.contacts.len())
        .sum::<usize>()
        * COLUMNS;
    lines.push(differing(
        &format!("numbers of contacts that differ, of {numbers}"),
        contacts.sum(),
        numbers,
    ));
    if !yade.loads.is_empty() {
        lines.push(of_loads(rung, loads, &yade.loads));
    }
    for &place in &rung.places {
        lines.push(contacts_at(place, rung, native, &yade.track));
    }
    lines
}

/// Forces and torques summed on grains; torques where they turn them.
fn of_loads(rung: &ParityRung, native: &[Vec<Load>], yade: &[Vec<Load>]) -> Line {
    let parts = if rung.case.model.law.rotates() { 3 } else { 2 };
    let rows = || native.iter().flatten().zip(yade.iter().flatten());
    let unequal =
        |(a, b): (&Load, &Load)| (0..parts).filter(|part| !same(a[*part], b[*part])).count();
    let count = |all: &[Vec<Load>]| all.iter().map(Vec::len).sum::<usize>();
    let missing = count(native).abs_diff(count(yade));
    let what = if parts == 3 {
        "forces and torques"
    } else {
        "forces"
    };
    let numbers = count(native) * parts;
    differing(
        &format!("{what} summed on grains that differ, of {numbers}"),
        rows().map(unequal).sum::<usize>() + missing,
        numbers,
    )
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

/// Contacts at one kind of place over all moments.
fn contacts_at(place: Place, rung: &ParityRung, one: &Track, other: &Track) -> Line {
    let ids = BodyIds {
        grains: rung.case.bodies.len() as u32,
        walls: rung.case.model.walls.len() as u32,
    };
    let pick = |moment: &Snapshot| -> Vec<Contact> {
        let there = |contact: &&Contact| Place::of(contact, moment, ids) == Some(place);
        moment.contacts.iter().filter(there).copied().collect()
    };
    let (mut count, mut numbers) = (0, 0);
    for (a, b) in one.iter().zip(other) {
        let (a, b) = (pick(a), pick(b));
        count += differing_contacts(&a, &b);
        numbers += a.len().max(b.len()) * COLUMNS;
    }
    let what = place.name();
    differing(
        &format!("{what}: numbers that differ, of {numbers}"),
        count,
        numbers,
    )
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
