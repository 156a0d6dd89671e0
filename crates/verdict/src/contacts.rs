//! The contact tables of two runs of one case at one moment, pair by pair: how far overlaps, forces, normals and points are apart,
//! which contacts are missing or invented, and what a wrong table looks like.

use evidence::moments::median;
use grains::model::Wall;
use grains::native::{NativeError, run_case};
use grains::tables::{Body, BodyIds, Contact, Snapshot};
use grains::task::Case;

use crate::constants::{kind_of_pair, until};

/// Numbers compared of a contact: overlap, normal force, tangential force, normal, point.
pub(crate) const NUMBERS: usize = 5;

/// Whether a contact is one of the punch with a grain that is neither below it nor beside it.
pub(crate) fn at_a_corner(ids: BodyIds, contact: &Contact) -> bool {
    let is_oblique = contact.normal.iter().all(|part| part.abs() > OBLIQUE);
    ids.body(contact.id1) == Body::Punch && is_oblique
}

/// A normal is not that of a face if both of its components are larger.
const OBLIQUE: f64 = 1.0e-9;

/// A contact of either table with its pair in the other.
struct Paired<'a> {
    ids: (u32, u32),
    their: Option<&'a Contact>,
    own: Option<&'a Contact>,
}

/// Both tables are sorted by ids.
fn paired<'a>(theirs: &'a [Contact], own: &'a [Contact]) -> Vec<Paired<'a>> {
    let ids = |contact: &Contact| (contact.id1, contact.id2);
    let (mut theirs, mut own) = (theirs.iter().peekable(), own.iter().peekable());
    let mut all = Vec::new();
    loop {
        let next = [theirs.peek(), own.peek()].map(|head| head.map(|contact| ids(contact)));
        let Some(first) = next.into_iter().flatten().min() else {
            return all;
        };
        all.push(Paired {
            ids: first,
            their: theirs.next_if(|contact| ids(contact) == first),
            own: own.next_if(|contact| ids(contact) == first),
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
        let at = |id: u32| Some([*bodies.x.get(id as usize)?, *bodies.z.get(id as usize)?]);
        let radius = |id: u32| bodies.radius.get(id as usize).copied();
        let centre = at(contact.id2)?;
        let far = match at(contact.id1) {
            Some(one) => (centre[0] - one[0]).hypot(centre[1] - one[1]) - radius(contact.id1)?,
            None => {
                let wall = walls.get((contact.id1 as usize).checked_sub(bodies.len())?)?;
                (centre[wall.axis as usize] - wall.place).abs()
            }
        };
        Some((far - radius(contact.id2)?).max(0.0))
    };
    let mut ids = Vec::new();
    let mut numbers: [Vec<f64>; NUMBERS] = Default::default();
    for Paired {
        ids: pair,
        their,
        own,
    } in paired(&their.contacts, &own.contacts)
    {
        let grain = pair.1 as usize;
        let (radius, mass) = (bodies.radius[grain], bodies.mass[grain]);
        let push = dt * dt / (mass * radius);
        let differences = match (their, own) {
            (Some(a), Some(b)) => [
                (a.overlap - b.overlap).abs() / radius,
                (a.normal_force - b.normal_force).abs() * push,
                (a.tangential_force - b.tangential_force).abs() * push,
                (a.normal[0] - b.normal[0]).hypot(a.normal[1] - b.normal[1]),
                (a.point[0] - b.point[0]).hypot(a.point[1] - b.point[1]) / radius,
            ],
            (Some(one), None) | (None, Some(one)) => {
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
    theirs: &[Contact],
    length: f64,
) -> Result<Option<String>, NativeError> {
    let start = until(state, 0);
    let own = run_case(&start, None)?;
    let own = own.first().map_or(&[][..], |snapshot| &snapshot.contacts);
    let law = &state.model.law;
    let radius = state.bodies.radius.iter().copied().fold(f64::MAX, f64::min);
    let apart = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let is_off = |pair: &Paired<'_>| match (pair.their, pair.own) {
        (Some(a), Some(b)) => {
            let by_length = 2.0 * b.normal_force / b.overlap * length;
            // A spring that is turned to the first order leaves the tangent a little.
            let out_of_tangent = OUT_OF_TANGENT * a.tangential_force.abs();
            let force = (a.normal_force - b.normal_force).abs() - out_of_tangent;
            (a.overlap - b.overlap).abs() > length
                || apart(a.normal, b.normal) > 4.0 * length / radius
                || apart(a.point, b.point) > 8.0 * length
                || !law.has_dashpots() && force > by_length + ROUNDED * b.normal_force
        }
        (Some(one), None) | (None, Some(one)) => one.overlap > length,
        (None, None) => false,
    };
    if paired(theirs, own).iter().any(is_off) {
        // What friction remembers is not made anew.
        let of_grains = theirs.iter().map(|contact| Contact {
            tangential_force: 0.0,
            ..*contact
        });
        return Ok(Some(in_words(&of_grains.collect::<Vec<_>>(), own)));
    }
    let limit = |contact: &Contact| {
        let angle = law.friction_angles()[kind_of_pair(state, contact.id1)];
        angle.tan() * contact.normal_force.abs()
    };
    let beyond = |contact: &&Contact| {
        let rounding = 2.0 * (contact.normal_force / contact.overlap).abs() * length;
        contact.tangential_force.abs() > (1.0 + SAME) * limit(contact) + rounding
    };
    Ok(theirs.iter().find(beyond).map(|contact| {
        format!(
            "ft of {}–{} is {:e} N, and its limit is {:e} N",
            contact.id1,
            contact.id2,
            contact.tangential_force,
            limit(contact)
        )
    }))
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
pub(crate) fn in_words(theirs: &[Contact], own: &[Contact]) -> String {
    let all = paired(theirs, own);
    let mut said = Vec::new();
    let mut name = |what: &str, pairs: Vec<(u32, u32)>| {
        let some = pairs.iter().take(NAMED).map(|(a, b)| format!("{a}–{b}"));
        let some: Vec<String> = some.collect();
        let more = if pairs.len() > NAMED { ", …" } else { "" };
        if !pairs.is_empty() {
            let (count, of_all) = (pairs.len(), own.len());
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
    type Number = fn(&Contact) -> f64;
    let columns: [(&str, Number); 7] = [
        ("overlap", |contact| contact.overlap),
        ("fn", |contact| contact.normal_force),
        ("ft", |contact| contact.tangential_force),
        ("nx", |contact| contact.normal[0]),
        ("nz", |contact| contact.normal[1]),
        ("x", |contact| contact.point[0]),
        ("z", |contact| contact.point[1]),
    ];
    for (column, number) in columns {
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
        let off_in = format!("{column} is off in {off} of {} rows", pairs.len());
        said.push(match one && factor.is_finite() {
            true => format!("{off_in}, × {factor:.6}"),
            false => off_in,
        });
    }
    match said.is_empty() {
        true => "its numbers are off by more than rounding".to_owned(),
        false => said.join("; "),
    }
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
        let own = [contact(1, 2.0), contact(2, 3.0), contact(4, 5.0)];
        let theirs = [contact(1, 3.0), contact(2, 4.5), contact(5, 1.0)];
        let said = in_words(&theirs, &own);
        assert!(
            said.contains("1 contacts are missing, where 3 touch (4–9)"),
            "{said}"
        );
        assert!(
            said.contains("1 contacts are invented, where 3 touch (5–9)"),
            "{said}"
        );
        assert!(
            said.contains("fn is off in 2 of 2 rows, × 1.500000"),
            "{said}"
        );
        assert!(!said.contains("overlap is off"), "{said}");
    }
}
