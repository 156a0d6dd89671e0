//! The contact tables of two runs of one case at one moment, pair by pair: how far overlaps, forces, normals and points are apart,
//! which contacts are missing or invented, and what a wrong table looks like.

use std::f64::consts::PI;

use evidence::moments::median;
use grains::model::{Law, Wall};
use grains::native::{NativeError, run_case};
use grains::rules::TangentialDashpot;
use grains::scene::AdhesionLaw;
use grains::tables::{Across, Body, BodyIds, Contact, Snapshot};
use grains::task::Case;
use grains::vector::{Vector, hypot, in_space, minus, plus, times};

/// Numbers compared of a contact: overlap, normal force, tangential force, normal, point.
pub(crate) const NUMBERS: usize = 5;

/// Whether a contact is one of the punch with a grain that is neither below it nor beside it.
pub(crate) fn at_a_corner(ids: BodyIds, contact: &Contact) -> bool {
    let is_oblique = contact.normal.iter().all(|part| part.abs() > OBLIQUE);
    ids.body(contact.id1) == Body::Punch && is_oblique
}

/// A normal is not that of a face if both of its components are larger.
const OBLIQUE: f64 = 1.0e-9;

/// The contacts of a moment and what they have besides in space.
#[derive(Debug, Clone, Copy)]
pub struct Table<'a> {
    pub contacts: &'a [Contact],
    /// In the same order; empty in the plane.
    pub across: &'a [Across],
}

impl<'a> From<&'a Snapshot> for Table<'a> {
    fn from(snapshot: &'a Snapshot) -> Self {
        Table {
            contacts: &snapshot.contacts,
            across: &snapshot.across,
        }
    }
}

impl<'a> Table<'a> {
    pub(crate) fn rows(self) -> impl Iterator<Item = Row<'a>> {
        let row = move |(at, contact)| Row {
            contact,
            across: self.across.get(at),
        };
        self.contacts.iter().enumerate().map(row)
    }
}

#[derive(Clone, Copy)]
pub(crate) struct Row<'a> {
    pub contact: &'a Contact,
    across: Option<&'a Across>,
}

impl Row<'_> {
    pub fn ids(&self) -> (u32, u32) {
        self.contact.ids()
    }

    pub fn normal(&self) -> Vector {
        let [x, z] = self.contact.normal;
        [x, self.across.map_or(0.0, |across| across.normal), z]
    }

    pub fn point(&self) -> Vector {
        let [x, z] = self.contact.point;
        [x, self.across.map_or(0.0, |across| across.point), z]
    }

    /// Force on body 2, N.
    pub fn force(&self) -> Vector {
        let Contact { normal_force, .. } = *self.contact;
        match self.across {
            None => in_space(self.contact.force()),
            Some(across) => plus(times(normal_force, self.normal()), across.tangential),
        }
    }

    /// Tangential force on body 2, N; in the plane its component along (−n_z, n_x), in space all three.
    pub(crate) fn tangential(&self) -> Vector {
        let along = [self.contact.tangential_force, 0.0, 0.0];
        self.across.map_or(along, |across| across.tangential)
    }

    /// The numbers of its row, with their columns.
    fn columns(&self) -> Vec<(&'static str, f64)> {
        let Contact {
            overlap,
            normal_force,
            tangential_force,
            ..
        } = *self.contact;
        let ([nx, ny, nz], [x, y, z]) = (self.normal(), self.point());
        let [tx, ty, tz] = self.tangential();
        let mut columns = vec![
            ("overlap", overlap),
            ("fn", normal_force),
            ("ft", tangential_force),
            ("nx", nx),
            ("nz", nz),
            ("x", x),
            ("z", z),
        ];
        if self.across.is_some() {
            columns.extend([("ny", ny), ("y", y), ("ftx", tx), ("fty", ty), ("ftz", tz)]);
        }
        columns
    }
}

/// How far two points or vectors are apart.
fn distance(a: Vector, b: Vector) -> f64 {
    hypot(minus(a, b))
}

/// A contact of either table with its pair in the other.
struct Paired<'a> {
    ids: (u32, u32),
    their: Option<Row<'a>>,
    own: Option<Row<'a>>,
}

/// Both tables are sorted by ids.
fn paired<'a>(theirs: Table<'a>, own: Table<'a>) -> Vec<Paired<'a>> {
    let (mut theirs, mut own) = (theirs.rows().peekable(), own.rows().peekable());
    let mut all = Vec::new();
    loop {
        let next = [theirs.peek(), own.peek()].map(|head| head.map(Row::ids));
        let Some(first) = next.into_iter().flatten().min() else {
            return all;
        };
        all.push(Paired {
            ids: first,
            their: theirs.next_if(|row| row.ids() == first),
            own: own.next_if(|row| row.ids() == first),
        });
    }
}

/// How far each contact is off: lengths over the radius of its grain, forces as the displacement over the radius that they give it
/// in a step, the normal as an angle. A missing contact counts as one without overlap and force, an invented one by its overlap,
/// its force and the gap that is there.
pub(crate) fn apart(
    their: &Snapshot,
    own: &Snapshot,
    walls: &[Wall],
    dt: f64,
) -> (Vec<(u32, u32)>, [Vec<f64>; NUMBERS]) {
    let bodies = &own.bodies;
    let gap = |contact: &Contact| {
        let radius = |id: usize| bodies.radius.get(id).copied();
        let [one, two] = [contact.id1, contact.id2].map(|id| id as usize);
        let (own, centre) = (radius(two)?, bodies.position(two));
        let far = match radius(one) {
            Some(other) => distance(centre, bodies.position(one)) - other,
            None => {
                let wall = walls.get(one.checked_sub(bodies.len())?)?;
                (centre[wall.axis.in_space()] - wall.place).abs()
            }
        };
        Some((far - own).max(0.0))
    };
    let mut ids = Vec::new();
    let mut numbers: [Vec<f64>; NUMBERS] = Default::default();
    for Paired {
        ids: pair,
        their,
        own,
    } in paired(their.into(), own.into())
    {
        let grain = pair.1 as usize;
        let (radius, mass) = (bodies.radius[grain], bodies.mass[grain]);
        let push = dt * dt / (mass * radius);
        let differences = match (their, own) {
            (Some(a), Some(b)) => [
                (a.contact.overlap - b.contact.overlap).abs() / radius,
                (a.contact.normal_force - b.contact.normal_force).abs() * push,
                // In space its size is told besides.
                distance(a.tangential(), b.tangential())
                    .max((a.contact.tangential_force - b.contact.tangential_force).abs())
                    * push,
                distance(a.normal(), b.normal()),
                distance(a.point(), b.point()) / radius,
            ],
            (Some(one), None) | (None, Some(one)) => {
                let one = one.contact;
                let gap = if own.is_none() {
                    gap(one).unwrap_or(0.0)
                } else {
                    0.0
                };
                let [normal, tangential] = [one.normal_force, one.tangential_force];
                let forces = [normal, tangential].map(|force| force.abs() * push);
                [(one.overlap + gap) / radius, forces[0], forces[1], 0.0, 0.0]
            }
            (None, None) => continue,
        };
        ids.push(pair);
        numbers
            .iter_mut()
            .zip(differences)
            .for_each(|(all, difference)| all.push(difference));
    }
    (ids, numbers)
}

/// What of a contact table does not follow from the grains of the state that it belongs to, though lengths are rounded by so much, m:
/// pairs, overlaps, normals, points; normal forces where springs alone make them; a tangential force beyond its limit.
pub fn contradiction(
    state: &Case,
    theirs: Table<'_>,
    length: f64,
) -> Result<Option<String>, NativeError> {
    let own = run_case(&state.at(vec![0]), None)?;
    let own = own.first().expect("the one moment that is asked for");
    let law = &state.model.law;
    let radius = state.bodies.radius.iter().copied().fold(f64::MAX, f64::min);
    // A force that grows as u^1.5 grows by at most so many times its mean slope.
    let slope = |contact: &Contact| 2.0 * (contact.normal_force / contact.overlap).abs();
    let is_off = |pair: &Paired<'_>| match (pair.their, pair.own) {
        (Some(a), Some(b)) => {
            // A spring that is turned to the first order leaves the tangent a little.
            let out_of_tangent = OUT_OF_TANGENT * hypot(a.tangential());
            let (normal, point) = (
                distance(a.normal(), b.normal()),
                distance(a.point(), b.point()),
            );
            let (a, b) = (a.contact, b.contact);
            let force = (a.normal_force - b.normal_force).abs() - out_of_tangent;
            (a.overlap - b.overlap).abs() > length
                || normal > 4.0 * length / radius
                || point > 8.0 * length
                || !law.has_dashpots() && force > slope(b) * length + ROUNDED * b.normal_force.abs()
        }
        (Some(one), None) | (None, Some(one)) => one.contact.overlap > length,
        (None, None) => false,
    };
    if paired(theirs, own.into()).iter().any(is_off) {
        // What friction remembers is not made anew.
        let without = |contact: &Contact| Contact {
            tangential_force: 0.0,
            ..*contact
        };
        let contacts: Vec<Contact> = theirs.contacts.iter().map(without).collect();
        let across = theirs.across.iter().map(|across| Across {
            tangential: [0.0; 3],
            ..*across
        });
        let across: Vec<Across> = across.collect();
        let of_grains = Table {
            contacts: &contacts,
            across: &across,
        };
        return Ok(Some(in_words(of_grains, own.into())));
    }
    if is_beyond_the_limit(law, state) {
        return Ok(None);
    }
    let limit = |contact: &Contact| {
        let pull = law.contact.adhesion.map_or(0.0, |energy| {
            let radius = state.bodies.radius[contact.id2 as usize];
            // Twice the pull that there may be at most.
            8.0 * PI * radius * energy
        });
        state.tangent(contact.id1, contact.id2) * (contact.normal_force.abs() + pull)
    };
    let beyond = |row: &Row<'_>| {
        let contact = row.contact;
        hypot(row.tangential()) > (1.0 + SAME) * limit(contact) + slope(contact) * length
    };
    let found = theirs.rows().find(beyond);
    Ok(found.map(|Row { contact, .. }| {
        format!(
            "ft of {}–{} is {:e} N, and its limit is {:e} N",
            contact.id1,
            contact.id2,
            contact.tangential_force,
            limit(contact)
        )
    }))
}

/// Whether the law adds a tangential dashpot to what Coulomb's limit has cut, or takes the limit from a force that is not written.
fn is_beyond_the_limit(law: &Law, state: &Case) -> bool {
    let dashpot = law.resolved(state.model.rules).tangential_dashpot;
    let of_springs = law.contact.adhesion_law != AdhesionLaw::Pull;
    let within = [TangentialDashpot::None, TangentialDashpot::Within].contains(&dashpot);
    law.has_dashpots() && (of_springs || !within)
}

/// A share of a number that is rounding.
const ROUNDED: f64 = 1.0e-12;
/// How much of a tangential force may lie along the normal.
pub(crate) const OUT_OF_TANGENT: f64 = 0.01;

/// A factor is told if all rows have it but for this share of it.
const SAME: f64 = 1.0e-6;
/// So many pairs are named at most.
const NAMED: usize = 3;

/// What is wrong with a table whose motion is right.
pub(crate) fn in_words(theirs: Table<'_>, own: Table<'_>) -> String {
    let said = what_is_off(theirs, own);
    said.unwrap_or_else(|| "its numbers are off by more than rounding".to_owned())
}

/// Which contacts are missing or invented and which columns are off; none where no number is off by a share that can be told.
pub(crate) fn what_is_off(theirs: Table<'_>, own: Table<'_>) -> Option<String> {
    let all = paired(theirs, own);
    let mut said = Vec::new();
    let mut name = |what: &str, pairs: Vec<(u32, u32)>| {
        let some = pairs.iter().take(NAMED).map(|(a, b)| format!("{a}–{b}"));
        let some: Vec<String> = some.collect();
        let more = if pairs.len() > NAMED { ", …" } else { "" };
        if !pairs.is_empty() {
            let (count, of_all) = (pairs.len(), own.contacts.len());
            said.push(format!(
                "{count} {what}, where {of_all} touch ({}{more})",
                some.join(", ")
            ));
        }
    };
    let without = |one: fn(&Paired<'_>) -> bool| {
        let pairs = all.iter().filter(|pair| one(pair));
        pairs.map(|pair| pair.ids).collect::<Vec<_>>()
    };
    name("contacts are missing", without(|pair| pair.their.is_none()));
    name("contacts are invented", without(|pair| pair.own.is_none()));
    let both = || all.iter().filter_map(|pair| Some((pair.their?, pair.own?)));
    let names = theirs.rows().chain(own.rows()).next();
    let names = names.map_or_else(Vec::new, |row| row.columns());
    for (at, (column, _)) in names.into_iter().enumerate() {
        let number = |row: Row<'_>| row.columns().get(at).map_or(f64::NAN, |column| column.1);
        let pairs: Vec<(f64, f64)> = both().map(|(a, b)| (number(a), number(b))).collect();
        let largest = pairs
            .iter()
            .fold(0.0, |most: f64, pair| most.max(pair.1.abs()));
        let is_off = |pair: &&(f64, f64)| {
            let most = SAME * pair.1.abs().max(SAME * largest);
            (pair.0 - pair.1).abs() > most
        };
        let off = pairs.iter().filter(is_off).count();
        if off == 0 {
            continue;
        }
        let ratios: Vec<f64> = pairs
            .iter()
            .filter(|pair| pair.1 != 0.0)
            .map(|pair| pair.0 / pair.1)
            .collect();
        let factor = median(&ratios).unwrap_or(f64::NAN);
        let one = ratios
            .iter()
            .all(|ratio| (ratio - factor).abs() <= SAME * factor.abs().max(SAME));
        let rows = both().zip(&pairs).filter(|(_, pair)| is_off(pair));
        let ids = rows.map(|((row, _), _)| format!("{}–{}", row.contact.id1, row.contact.id2));
        let ids: Vec<String> = ids.take(NAMED).collect();
        let ids = match off <= NAMED {
            true => format!(" ({})", ids.join(", ")),
            false => String::new(),
        };
        let off_in = format!("{column} is off in {off} of {} rows{ids}", pairs.len());
        said.push(match one && factor.is_finite() {
            true => format!("{off_in}, × {factor:.6}"),
            false => off_in,
        });
    }
    (!said.is_empty()).then(|| said.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_table_is_told_by_what_is_wrong_with_it() {
        let contact = |id1: u32, force: f64| Contact {
            id1,
            id2: 9,
            overlap: 1.0e-6,
            normal_force: force,
            tangential_force: 0.0,
            normal: [0.0, 1.0],
            point: [0.0; 2],
        };
        let table = |contacts| Table {
            contacts,
            across: &[],
        };
        let own = [contact(1, 2.0), contact(2, 3.0), contact(4, 5.0)];
        let theirs = [contact(1, 3.0), contact(2, 4.5), contact(5, 1.0)];
        let said = in_words(table(&theirs), table(&own));
        assert!(
            said.contains("1 contacts are missing, where 3 touch (4–9)"),
            "{said}"
        );
        assert!(
            said.contains("1 contacts are invented, where 3 touch (5–9)"),
            "{said}"
        );
        assert!(
            said.contains("fn is off in 2 of 2 rows (1–9, 2–9), × 1.500000"),
            "{said}"
        );
        assert!(!said.contains("overlap is off"), "{said}");
    }
}
