//! Agreement to the last bit: tables number by number, histories state by state.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use serde::Serialize;
use serde_json::Value;

use crate::checks::Outcome;
use crate::run::folder::{Moment, RunFolder};
use grains::measure::HistoryRow;
use grains::scene::Scene;
use grains::tables::{Across, Bodies, Contact, Stage};

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TableBits {
    pub table: String,
    pub numbers: usize,
    /// How many of them differ in any bit; all, if the tables have not the same rows.
    pub differing: usize,
    /// The differing number of the lowest id.
    pub first: Option<NumberPair>,
}

/// A number that differs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NumberPair {
    /// Grain, or the pair of a contact.
    pub id: String,
    pub key: &'static str,
    pub a: f64,
    pub b: f64,
    /// How many floating-point numbers further b is than a.
    pub ulps: u64,
}

impl fmt::Display for NumberPair {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (a, b, ulps) = (self.a, self.b, self.ulps);
        let (key, id) = (self.key, &self.id);
        write!(out, "{key} of {id}: {a:e} against {b:e}, {ulps} ulp apart")
    }
}

impl TableBits {
    pub fn agrees(&self) -> bool {
        self.differing == 0
    }

    /// Holds two numbers against each other.
    pub fn hold(&mut self, id: impl Fn() -> String, key: &'static str, a: f64, b: f64) {
        if a.to_bits() != b.to_bits() {
            self.differing += 1;
            let ulps = ulps_between(a, b);
            self.first.get_or_insert_with(|| NumberPair {
                id: id(),
                key,
                a,
                b,
                ulps,
            });
        }
    }

    /// Passed if every bit is the same and there is at least one.
    pub fn verdict(&self) -> Outcome {
        match (self.differing, self.numbers) {
            (0, 0) => Outcome::Skipped,
            (0, _) => Outcome::Pass,
            _ => Outcome::Fail,
        }
    }
}

impl fmt::Display for TableBits {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} of {} numbers differ", self.differing, self.numbers)?;
        match &self.first {
            Some(first) => write!(out, ", first {first}"),
            None => Ok(()),
        }
    }
}

/// Every table that both runs have.
pub fn tables(a: &RunFolder, b: &RunFolder) -> Vec<TableBits> {
    let mut tables = vec![
        sizes("radii and masses", &a.initial, &b.initial),
        bodies("initial grains", &a.initial, &b.initial),
    ];
    let mut moment = |when: &str, a: &Moment, b: &Moment| {
        tables.push(bodies(&format!("{when} grains"), &a.bodies, &b.bodies));
        let table = format!("{when} contacts");
        tables.push(contacts(&table, &a.contacts, &b.contacts));
        if !a.across.is_empty() || !b.across.is_empty() {
            tables.push(across(&format!("{table} across"), &a.across, &b.across));
        }
    };
    if let (Some(a), Some(b)) = (&a.settled, &b.settled) {
        moment("settled", a, b);
    }
    moment("last", &a.last, &b.last);
    tables
}

/// Positions and velocities of every grain.
pub fn bodies(table: &str, a: &Bodies, b: &Bodies) -> TableBits {
    columns(table, &a.motion(), &b.motion())
}

/// What motion does not change.
fn sizes(table: &str, a: &Bodies, b: &Bodies) -> TableBits {
    fn columns_of(bodies: &Bodies) -> [Column<'_>; 3] {
        [
            ("radius", &bodies.radius),
            ("mass", &bodies.mass),
            ("inertia", &bodies.inertia),
        ]
    }
    columns(table, &columns_of(a), &columns_of(b))
}

/// What contacts in space have besides.
fn across(table: &str, a: &[Across], b: &[Across]) -> TableBits {
    type Number = fn(&Across) -> f64;
    let numbers: [(&str, Number); 5] = [
        ("ny", |contact| contact.normal),
        ("y", |contact| contact.point),
        ("ft x", |contact| contact.tangential[0]),
        ("ft y", |contact| contact.tangential[1]),
        ("ft z", |contact| contact.tangential[2]),
    ];
    let values =
        |all: &[Across]| numbers.map(|(_, number)| all.iter().map(number).collect::<Vec<f64>>());
    let [a, b] = [values(a), values(b)];
    let named = |at: usize, column| (numbers[at].0, column);
    let [a, b] = [&a, &b].map(|all| {
        let columns = all.iter().enumerate();
        columns
            .map(|(at, column)| named(at, &column[..]))
            .collect::<Vec<Column<'_>>>()
    });
    columns(table, &a, &b)
}

type Column<'a> = (&'static str, &'a [f64]);

fn columns(table: &str, a: &[Column<'_>], b: &[Column<'_>]) -> TableBits {
    let length = |columns: &[Column<'_>]| {
        columns
            .iter()
            .map(|(_, column)| column.len())
            .sum::<usize>()
    };
    let mut result = TableBits {
        table: table.to_owned(),
        numbers: length(a).max(length(b)),
        differing: length(a).abs_diff(length(b)),
        first: None,
    };
    let rows = a.iter().map(|(_, column)| column.len()).max();
    for id in 0..rows.unwrap_or(0) {
        for ((key, of_a), (_, of_b)) in a.iter().zip(b) {
            if let (Some(in_a), Some(in_b)) = (of_a.get(id), of_b.get(id)) {
                result.hold(|| format!("grain {id}"), key, *in_a, *in_b);
            }
        }
    }
    result
}

/// The numbers of a contact that are compared, with the names of their columns.
fn of_contact(contact: &Contact) -> [(&'static str, f64); 7] {
    [
        ("overlap", contact.overlap),
        ("fn", contact.normal_force),
        ("ft", contact.tangential_force),
        ("nx", contact.normal[0]),
        ("nz", contact.normal[1]),
        ("x", contact.point[0]),
        ("z", contact.point[1]),
    ]
}

/// Every number of every contact; all of them, if the pairs are not the same.
pub fn contacts(table: &str, a: &[Contact], b: &[Contact]) -> TableBits {
    let numbers = 7 * a.len().max(b.len());
    let ids = |contact: &Contact| (contact.id1, contact.id2);
    let same_pairs = a.iter().map(ids).eq(b.iter().map(ids));
    let mut result = TableBits {
        table: table.to_owned(),
        numbers,
        differing: if same_pairs { 0 } else { numbers },
        first: None,
    };
    for (a, b) in a.iter().zip(b).filter(|_| same_pairs) {
        for ((key, in_a), (_, in_b)) in of_contact(a).into_iter().zip(of_contact(b)) {
            // A zero of either sign is the same absence of a tangential force.
            if key != "ft" || in_a != 0.0 || in_b != 0.0 {
                result.hold(|| format!("contact {}-{}", a.id1, a.id2), key, in_a, in_b);
            }
        }
    }
    result
}

/// How many steps of the floating-point number line lie between two finite numbers.
pub fn ulps_between(a: f64, b: f64) -> u64 {
    let place = |value: f64| {
        let bits = value.to_bits() as i64;
        if bits < 0 { i64::MIN - bits } else { bits }
    };
    place(a).abs_diff(place(b))
}

/// Agreement of the states along two runs.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HistoryBits {
    pub moments: usize,
    pub agreeing: usize,
    pub first_unequal: Option<(Stage, u64)>,
    /// The last moment before, and the first moment at which, grains or punch are elsewhere; forces may
    /// disagree a moment earlier.
    pub apart: Option<[(Stage, u64); 2]>,
    pub unpaired: usize,
}

impl HistoryBits {
    /// Whether all moments agree, and there are any.
    pub fn agrees(&self) -> bool {
        self.moments > 0 && self.first_unequal.is_none() && self.unpaired == 0
    }
}

impl fmt::Display for HistoryBits {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "{} of {} states agree in every bit",
            self.agreeing, self.moments
        )?;
        if let Some((stage, step)) = self.first_unequal {
            write!(out, "; the first that does not: {} {step}", stage.name())?;
        }
        if self.unpaired > 0 {
            write!(out, "; {} moments are in one run only", self.unpaired)?;
        }
        Ok(())
    }
}

/// Pairs the moments of two histories by stage and step. Every column counts: the digest of the
/// grains' bits, and the punch's force and depth beside it.
pub fn history(a: &RunFolder, b: &RunFolder) -> HistoryBits {
    let moment = |row: &HistoryRow| (row.stage, row.step);
    let others: BTreeMap<(Stage, u64), &HistoryRow> =
        b.history.iter().map(|row| (moment(row), row)).collect();
    let mut result = HistoryBits::default();
    let mut together = None;
    for row in &a.history {
        let Some(other) = others.get(&moment(row)) else {
            result.unpaired += 1;
            continue;
        };
        result.moments += 1;
        if row.state != other.state || row.punch_depth != other.punch_depth {
            let before = together.unwrap_or((row.stage, 0));
            result.apart.get_or_insert([before, moment(row)]);
        } else {
            together = Some(moment(row));
        }
        if row == *other {
            result.agreeing += 1;
        } else {
            result.first_unequal.get_or_insert(moment(row));
        }
    }
    result.unpaired += b.history.len() - result.moments;
    result
}

/// Of such sums a share of this much may be rounding: the order in which contacts are added is an engine's own.
const SUMMED: f64 = 1.0e-6;

/// Where two runs tell otherwise of a moment at which all their grains are the same to the bit: energies, forces, the time or a path.
pub fn contradiction(a: &RunFolder, b: &RunFolder) -> Option<String> {
    // Forces that nearly cancel are rounded as the largest are.
    type Number = (&'static str, bool, fn(&HistoryRow) -> Option<f64>);
    let numbers: [Number; 8] = [
        ("the time", false, |row| Some(row.time)),
        ("the kinetic energy", false, |row| Some(row.kinetic_energy)),
        ("the potential energy", false, |row| {
            Some(row.potential_energy)
        }),
        ("the elastic energy", false, |row| Some(row.elastic_energy)),
        ("the number of contacts", false, |row| {
            Some(row.contacts as f64)
        }),
        ("the depth of the punch", false, |row| row.punch_depth),
        ("the unbalanced force", true, |row| row.unbalanced_force),
        ("the force on the punch", true, |row| row.punch_force),
    ];
    let others: BTreeMap<(Stage, u64), &HistoryRow> = b
        .history
        .iter()
        .map(|row| ((row.stage, row.step), row))
        .collect();
    let rows = a.history.iter().filter_map(|row| {
        let other = others.get(&(row.stage, row.step))?;
        (row.state == other.state && row.punch_depth == other.punch_depth).then_some((row, *other))
    });
    let same: Vec<(&HistoryRow, &HistoryRow)> = rows.collect();
    for (name, cancels, number) in numbers {
        let sizes = same.iter().filter_map(|(row, _)| number(row)).map(f64::abs);
        let largest = if cancels {
            sizes.fold(0.0, f64::max)
        } else {
            0.0
        };
        let is_off = |(row, other): &&(&HistoryRow, &HistoryRow)| {
            let (Some(one), Some(two)) = (number(row), number(other)) else {
                return number(row).is_some() != number(other).is_some();
            };
            let apart = (one - two).abs();
            apart > SUMMED * largest.max(one.abs()) || apart.is_nan()
        };
        if let Some((row, _)) = same.iter().find(is_off) {
            let (stage, step) = (row.stage.name(), row.step);
            return Some(format!(
                "{name} at {stage} {step} is another one in history.csv, and all grains are the same"
            ));
        }
    }
    let stages = a.record.stages.iter().zip(&b.record.stages);
    let mut otherwise = stages.filter(|(one, two)| {
        (one.stage, one.steps) == (two.stage, two.steps) && one.stop != two.stop
    });
    if let Some((one, two)) = otherwise.next() {
        let (stage, of_a, of_b) = (one.stage.name(), one.stop.name(), two.stop.name());
        if a.last.bodies.digest() == b.last.bodies.digest() {
            return Some(format!(
                "{stage} ended as {of_a} in A and as {of_b} in B, after the same steps and with the same grains"
            ));
        }
    }
    let is_same: BTreeSet<(Stage, u64)> =
        same.iter().map(|(row, _)| (row.stage, row.step)).collect();
    let paths = |run: &RunFolder| -> Vec<String> {
        let rows = run
            .trace
            .iter()
            .filter(|row| is_same.contains(&(row.stage, row.step)));
        rows.map(|row| format!("{row:?}")).collect()
    };
    let [of_a, of_b] = [a, b].map(paths);
    (of_a != of_b).then(|| "trace.csv has other paths where all grains are the same".to_owned())
}

/// JSON pointers of the keys in which two scenes differ; name and reasons do not count.
pub fn differing_keys(a: &Scene, b: &Scene) -> Vec<String> {
    let mut keys = Vec::new();
    if let (Ok(a), Ok(b)) = (serde_json::to_value(a), serde_json::to_value(b)) {
        walk("", &a, &b, &mut keys);
    }
    keys
}

fn walk(place: &str, a: &Value, b: &Value, keys: &mut Vec<String>) {
    let (Some(of_a), Some(of_b)) = (a.as_object(), b.as_object()) else {
        if a != b {
            keys.push(place.to_owned());
        }
        return;
    };
    let names: BTreeSet<&String> = of_a.keys().chain(of_b.keys()).collect();
    for name in names {
        if !(place.is_empty() && matches!(name.as_str(), "name" | "choices")) {
            let [a, b] = [of_a, of_b].map(|object| object.get(name).unwrap_or(&Value::Null));
            walk(&format!("{place}/{name}"), a, b, keys);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Across, Column, across, columns, contacts, ulps_between};
    use grains::tables::Contact;

    #[test]
    fn each_number_that_differs_counts_and_the_lowest_grain_is_first() {
        let contact = |id1| Contact {
            id1,
            id2: 9,
            overlap: 0.0,
            normal_force: 0.0,
            tangential_force: 0.0,
            normal: [0.0, 1.0],
            point: [0.0; 2],
        };
        let differing = |a: &[u32], b: &[u32]| {
            let [a, b] = [a, b].map(|ids| ids.iter().map(|id| contact(*id)).collect::<Vec<_>>());
            contacts("contacts", &a, &b).differing
        };
        assert_eq!(differing(&[1, 2], &[1, 2]), 0);
        assert_eq!(differing(&[1, 2], &[1]), 14, "one is missing");
        assert_eq!(differing(&[1, 2], &[1, 3]), 14, "one is of another pair");
        let force = |normal_force, tangential_force| Contact {
            normal_force,
            tangential_force,
            ..contact(1)
        };
        let numbers = |a, b| contacts("contacts", &[a], &[b]).differing;
        assert_eq!(numbers(force(0.0, 0.0), force(0.0, -0.0)), 0);
        assert_eq!(numbers(force(0.0, 0.0), force(-0.0, 0.0)), 1);
        assert_eq!(numbers(force(1.0, 1.0), force(0.0, 0.0)), 2);
        let (x, z): ([f64; 3], [f64; 3]) = ([0.0, 1.0, 2.0], [0.0, 1.0, 2.0]);
        let (other_x, other_z) = ([0.0, 1.0, 3.0], [0.0, 3.0, 2.0]);
        let other: [Column<'_>; 2] = [("x", &other_x), ("z", &other_z)];
        let found = columns("t", &[("x", &x), ("z", &z)], &other);
        let first = found.first.expect("two differ");
        assert_eq!((first.id.as_str(), first.key), ("grain 1", "z"));
        assert_eq!(found.differing, 2);
    }

    #[test]
    fn ulps_count_numbers_across_zero() {
        assert_eq!(ulps_between(1.0, 1.0 + f64::EPSILON), 1);
        assert_eq!(ulps_between(-1.0, -1.0), 0);
        assert_eq!(ulps_between(0.0, -0.0), 0);
        // One step up from zero and one down.
        assert_eq!(ulps_between(f64::from_bits(1), -f64::from_bits(1)), 2);
    }

    #[test]
    fn every_number_that_contacts_have_in_space_counts() {
        let one = Across {
            normal: 0.1,
            point: 0.2,
            tangential: [0.3, 0.4, 0.5],
        };
        let change: [fn(&mut Across); 5] = [
            |contact| contact.normal = 1.0,
            |contact| contact.point = 1.0,
            |contact| contact.tangential[0] = 1.0,
            |contact| contact.tangential[1] = 1.0,
            |contact| contact.tangential[2] = 1.0,
        ];
        assert_eq!(across("contacts", &[one], &[one]).differing, 0);
        for change in change {
            let mut other = one;
            change(&mut other);
            assert_eq!(across("contacts", &[one], &[other]).differing, 1);
        }
        assert_eq!(across("contacts", &[one], &[]).differing, 5);
    }
}
