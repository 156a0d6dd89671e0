//! Under which condition contacts or grains are wrong: what all wrong ones of a moment have and no right one. It is told only where so
//! clean a split is no chance among all that are tried.

use std::collections::{BTreeMap, BTreeSet};

use grains::model::{Axis, Law};
use grains::obstacle::{Obstacle, Surface};
use grains::scene::{NewContactSlip, SlipVelocity, Springs, Tension, TorqueArms, Viscosity};
use grains::tables::{Contact, Snapshot};
use grains::task::Case;
use grains::vector::{dot, minus};
use statrs::function::factorial::ln_binomial;

use crate::contacts::{Row, Table, at_a_corner};
use crate::exercise::slides;

/// How probable a split may be that says nothing, over all that are tried.
const LEVEL: f64 = 0.05;

/// Of the right ones no more than one of so many has what is said of the wrong ones.
const MOST_RIGHT: usize = 2;

/// What is known of each of some contacts, grains or states.
struct Properties<'a, T> {
    all: &'a [T],
    wrong: Vec<bool>,
    /// Which contact or grain each is of: of one and the same many moments are no more evidence than one.
    subjects: Vec<usize>,
    /// In words, and which have it.
    has: Vec<(String, Vec<bool>)>,
    /// In words, with the place of the number, and the numbers.
    numbers: Vec<(&'static str, Vec<f64>)>,
}

impl<'a, T> Properties<'a, T> {
    /// None where all are wrong or none is.
    fn new(all: &'a [T], wrong: impl Fn(&T) -> bool) -> Option<Self> {
        let wrong: Vec<bool> = all.iter().map(wrong).collect();
        let are_both = wrong.contains(&true) && wrong.contains(&false);
        are_both.then(|| Properties {
            all,
            wrong,
            subjects: (0..all.len()).collect(),
            has: Vec::new(),
            numbers: Vec::new(),
        })
    }

    fn add(&mut self, words: impl Into<String>, has: impl Fn(&T) -> bool) {
        let has = self.all.iter().map(has).collect();
        self.has.push((words.into(), has));
    }

    /// And the other way round.
    fn add_both(&mut self, [one, other]: [&str; 2], has: impl Fn(&T) -> bool) {
        self.add(one, &has);
        self.add(other, |each| !has(each));
    }

    fn number(&mut self, words: &'static str, value: impl Fn(&T) -> f64) {
        let values: Vec<f64> = self.all.iter().map(value).collect();
        if values.iter().all(|value| !value.is_nan()) {
            self.numbers.push((words, values));
        }
    }

    /// How many contacts or grains these are.
    fn distinct(&self, is_one: impl Fn(usize) -> bool) -> u64 {
        let ones = (0..self.wrong.len()).filter(|at| is_one(*at));
        let subjects: BTreeSet<usize> = ones.map(|at| self.subjects[at]).collect();
        subjects.len() as u64
    }

    /// Where so many of them are wrong.
    fn told(self, what: &str, count: usize) -> Option<String> {
        let all = self.all.len();
        let (split, others) = (self.split()?, all - count);
        Some(format!(
            "{what} where {split}: all {count} of these and none of the other {others}"
        ))
    }

    /// What all wrong ones have and fewest of the others, and how many of these.
    fn within(&self) -> Option<(String, usize)> {
        let others = self.wrong.iter().filter(|is| !**is).count();
        let tried = 2 * (self.has.len() + 2 * self.numbers.len());
        let right = |has: &dyn Fn(usize) -> bool| {
            let all = || 0..self.wrong.len();
            let has_all = all().filter(|at| self.wrong[*at]).all(has);
            has_all.then(|| all().filter(|at| !self.wrong[*at] && has(*at)).count())
        };
        let has = self.has.iter();
        let has = has.filter_map(|(words, has)| Some((right(&|at| has[at])?, words.clone())));
        let beyond = self.numbers.iter().flat_map(|(words, values)| {
            let of_wrong = values.iter().zip(&self.wrong).filter(|(_, wrong)| **wrong);
            let of_wrong = of_wrong.map(|(value, _)| *value);
            let least = of_wrong.clone().fold(f64::INFINITY, f64::min);
            let most = of_wrong.fold(f64::NEG_INFINITY, f64::max);
            let above = right(&|at| values[at] >= least);
            let below = right(&|at| values[at] <= most);
            let above = above.map(|right| (right, format!("{words} is {} or more", plain(least))));
            let below = below.map(|right| (right, format!("{words} is {} or less", plain(most))));
            above.into_iter().chain(below)
        });
        let (right, words) = has.chain(beyond).min_by_key(|(right, _)| *right)?;
        let of_wrong = self.distinct(|at| self.wrong[at]);
        let all = of_wrong + self.distinct(|at| !self.wrong[at]);
        // As large a share of the right ones as of their rows.
        let among = of_wrong + (all - of_wrong) * right as u64 / others as u64;
        let chance = ln_binomial(among, of_wrong) - ln_binomial(all, of_wrong);
        let is_no_chance = chance < (LEVEL / tried as f64).ln();
        (is_no_chance && MOST_RIGHT * right <= others).then_some((words, right))
    }

    /// What splits the wrong ones from all others: one property, two, or a number above or below a value, among those that have a
    /// property or among all.
    fn split(mut self) -> Option<String> {
        let wrong = &self.wrong[..];
        let count = |flags: &[bool]| flags.iter().filter(|is| **is).count();
        self.has.retain(|(_, has)| count(has) > 0);
        // Half of the chance is for one alone, of which fewer are tried than of two.
        let [properties, numbers] = [self.has.len(), self.numbers.len()];
        let alone = properties + 2 * numbers;
        let pairs = properties * (properties + 2 * numbers);
        let of_wrong = self.distinct(|at| wrong[at]);
        let is_no_chance = |among: &[bool], tried: usize| {
            let enough = (2.0 * tried as f64 / LEVEL).ln();
            let of_right = self.distinct(|at| among[at] && !wrong[at]);
            ln_binomial(of_wrong + of_right, of_wrong) > enough
        };
        let everywhere = vec![true; wrong.len()];
        let both = |a: &[bool], b: &[bool]| -> Vec<bool> {
            a.iter().zip(b).map(|(a, b)| *a && *b).collect()
        };
        if is_no_chance(&everywhere, alone)
            && let Some((words, _)) = self.has.iter().find(|(_, has)| has == wrong)
        {
            return Some(words.clone());
        }
        if is_no_chance(&everywhere, pairs) {
            for (at, (words, has)) in self.has.iter().enumerate() {
                let mut more = self.has[at + 1..].iter();
                if let Some((and, _)) = more.find(|(_, other)| both(has, other) == wrong) {
                    return Some(format!("{words} and {and}"));
                }
            }
        }
        let all = (String::new(), everywhere.clone());
        for (words, among) in [&all].into_iter().chain(&self.has) {
            let is_among = both(among, wrong) == wrong;
            let tried = if words.is_empty() { alone } else { pairs };
            if !is_among || !is_no_chance(among, tried) {
                continue;
            }
            for (number, values) in &self.numbers {
                let values_where = |which: bool| {
                    let rows = values.iter().zip(wrong).zip(among);
                    let rows = rows.filter(move |((_, wrong), among)| **among && **wrong == which);
                    rows.map(|((value, _), _)| *value)
                };
                let [low, high] = [true, false].map(|which| {
                    (
                        values_where(which).fold(f64::INFINITY, f64::min),
                        values_where(which).fold(f64::NEG_INFINITY, f64::max),
                    )
                });
                let (of_wrong, of_right) = (low, high);
                let and = if words.is_empty() { "" } else { " and " };
                if of_wrong.0 > of_right.1 {
                    let from = of_wrong.0;
                    return Some(format!("{words}{and}{number} is {} or more", plain(from)));
                }
                if of_wrong.1 < of_right.0 {
                    let to = of_wrong.1;
                    return Some(format!("{words}{and}{number} is {} or less", plain(to)));
                }
            }
        }
        None
    }
}

/// In words of rows that have it and of those that have not.
pub(crate) type Property<'a, T> = ([&'static str; 2], &'a dyn Fn(&T) -> bool);
pub(crate) type Number<'a, T> = (&'static str, &'a dyn Fn(&T) -> f64);

/// Where some rows are wrong: what they have and no other one, or what they all have and few others.
pub(crate) fn of_rows<T, K: Ord>(
    all: &[T],
    (wrong, subject): (impl Fn(&T) -> bool, impl Fn(&T) -> K),
    properties: &[Property<'_, T>],
    numbers: &[Number<'_, T>],
) -> Option<String> {
    let mut of_all = Properties::new(all, wrong)?;
    let mut known: BTreeMap<K, usize> = BTreeMap::new();
    for (at, row) in all.iter().enumerate() {
        let next = known.len();
        of_all.subjects[at] = *known.entry(subject(row)).or_insert(next);
    }
    for (words, has) in properties.iter().filter(|(words, _)| !words[0].is_empty()) {
        of_all.add_both(*words, has);
    }
    for (words, value) in numbers {
        of_all.number(words, value);
    }
    let count = of_all.wrong.iter().filter(|is| **is).count();
    let others = all.len() - count;
    let within = of_all.within();
    let split = of_all
        .split()
        .map(|split| format!("where {split}: all {count} of these and none of the other {others}"));
    split.or_else(|| {
        let (words, right) = within?;
        Some(format!(
            "{count} of {}, all of them where {words}, as {right} that are right",
            all.len()
        ))
    })
}

/// Whole numbers, such as ids and counts, in full.
fn plain(value: f64) -> String {
    match value.fract() == 0.0 && value.abs() < 1.0e6 {
        true => format!("{value}"),
        false => format!("{value:.4e}"),
    }
}

/// Each grain's number of contacts.
fn partners(own: &Snapshot) -> Vec<f64> {
    let mut partners = vec![0.0; own.bodies.len()];
    for contact in &own.contacts {
        for id in [contact.id1, contact.id2] {
            if let Some(count) = partners.get_mut(id as usize) {
                *count += 1.0;
            }
        }
    }
    partners
}

/// The grains that touch a wall or the punch.
fn touching(own: &Snapshot, body: u32) -> BTreeSet<u32> {
    let touching = own.contacts.iter().filter(|contact| contact.id1 == body);
    touching.map(|contact| contact.id2).collect()
}

/// What all of these contacts have that are wrong or missing, as `what` says, and no other one among some of this moment; `past` has
/// the moments before it.
pub(crate) fn of_contacts(
    case: &Case,
    past: &[Snapshot],
    own: &Snapshot,
    (what, wrong): (&str, &[(u32, u32)]),
    among: &dyn Fn((u32, u32)) -> bool,
) -> Option<String> {
    let (ids, bodies) = (case.ids(), &own.bodies);
    let all: Vec<Row> = Table::from(own)
        .rows()
        .filter(|row| among(row.ids()))
        .collect();
    let mut properties = Properties::new(&all, |row| wrong.contains(&row.ids()))?;
    properties.add_both(
        ["they are of two grains", "they are at walls or punch"],
        |row| ids.is_grain(row.contact.id1),
    );
    for index in 0..case.model.walls.len() {
        let wall = ids.wall(index);
        properties.add(format!("they are at wall {index}"), |row| {
            row.contact.id1 == wall
        });
    }
    let axes = [(Axis::X, "x"), (Axis::Y, "y"), (Axis::Z, "z")];
    for (axis, name) in axes {
        properties.add(format!("they are at walls across {name}"), |row| {
            case.wall(row.contact.id1)
                .is_some_and(|wall| wall.axis == axis)
        });
    }
    let first = ids.wall(case.model.walls.len());
    let obstacle = |row: &Row| {
        let index = row.contact.id1.checked_sub(first)?;
        case.model.obstacles.get(index as usize)
    };
    for (name, at_edges) in [
        ("planes", ""),
        ("triangles", "they are at edges or corners of triangles"),
        ("boxes", "they are at edges or corners of boxes"),
    ] {
        let is_one = |row: &Row| {
            let kind = obstacle(row).map(|obstacle| match obstacle.shape {
                Surface::Plane { .. } => "planes",
                Surface::Triangle { .. } => "triangles",
                Surface::Box { .. } => "boxes",
            });
            kind == Some(name)
        };
        properties.add(format!("they are at {name}"), is_one);
        if !at_edges.is_empty() {
            properties.add(at_edges, |row| {
                let at_edge = |obstacle: &Obstacle| {
                    obstacle.is_at_edge(row.normal(), own.step, case.model.dt)
                };
                is_one(row) && obstacle(row).is_some_and(at_edge)
            });
        }
    }
    properties.add("they are at the punch", |row| {
        row.contact.id1 == ids.punch()
    });
    properties.add("they are at corners of the punch", |row| {
        at_a_corner(ids, row.contact)
    });
    if case.model.law.has_friction() {
        properties.add_both(["they slide", "they stick"], |row| {
            slides(case, row.contact)
        });
    }
    let velocity = |id: u32| match own.punch {
        _ if ids.is_grain(id) => bodies.velocity(id as usize),
        Some(punch) if id == ids.punch() => [0.0, 0.0, punch.velocity],
        _ => [0.0; 3],
    };
    properties.add_both(["their bodies part", "their bodies approach"], |row| {
        let [one, two] = [row.contact.id1, row.contact.id2].map(velocity);
        dot(minus(two, one), row.normal()) > 0.0
    });
    if let Some(before) = past.last() {
        let before: BTreeMap<_, _> = Table::from(before)
            .rows()
            .map(|row| (row.ids(), row.contact))
            .collect();
        let had = |row: &Row, what: &dyn Fn(&Contact) -> bool| {
            before.get(&row.ids()).is_some_and(|contact| what(contact))
        };
        properties.add_both(["they touched before", "they have just begun"], |row| {
            had(row, &|_| true)
        });
        properties.add_both(
            [
                "their overlap has grown in the step",
                "their overlap has not grown in the step",
            ],
            |row| had(row, &|before| before.overlap < row.contact.overlap),
        );
        properties.add("they slid a step before", |row| {
            had(row, &|before| slides(case, before))
        });
        // In how many moments up to this one without a break, and whether ever before such a break.
        let mut ages: BTreeMap<_, (f64, bool)> = BTreeMap::new();
        let latest = past.iter().rev();
        for (age, moment) in latest.enumerate().map(|(age, moment)| (age as f64, moment)) {
            for contact in &moment.contacts {
                let (since, again) = ages.entry(contact.ids()).or_default();
                match *since == age {
                    true => *since += 1.0,
                    false => *again = true,
                }
            }
        }
        let age = |row: &Row| ages.get(&row.ids()).copied().unwrap_or_default();
        properties.add("they have parted and touch again", |row| age(row).1);
        properties.add("they have just begun, of two that touched before", |row| {
            let (since, again) = age(row);
            since == 0.0 && again
        });
        properties.number("the number of moments that they have been there", |row| {
            age(row).0
        });
    }
    let directions = [
        [
            "their normals point to the right",
            "their normals point to the left",
        ],
        ["their normals point up", "their normals point down"],
    ];
    for (axis, words) in directions.into_iter().enumerate() {
        properties.add_both(words, |row| row.contact.normal[axis] > 0.0);
    }
    for index in 0..case.model.walls.len() {
        let at_wall = touching(own, ids.wall(index));
        properties.add(format!("one of their grains touches wall {index}"), |row| {
            at_wall.contains(&row.contact.id1) || at_wall.contains(&row.contact.id2)
        });
    }
    if !bodies.material.is_empty() {
        let material = |id: u32| bodies.material.get(id as usize).copied().unwrap_or(0);
        properties.add_both(
            ["their materials are two", "their materials are one"],
            |row| material(row.contact.id1) != material(row.contact.id2),
        );
    }
    // Where a program has its grains in several pieces.
    let half = |id: u32| 2 * id as usize >= bodies.len();
    properties.add("their ids are of different halves of all grains", |row| {
        ids.is_grain(row.contact.id1) && half(row.contact.id1) != half(row.contact.id2)
    });
    let is_even = |id: u32| id.is_multiple_of(2);
    properties.add_both(
        [
            "the id of their second body is even",
            "the id of their second body is odd",
        ],
        |row| is_even(row.contact.id2),
    );
    properties.add("one of their ids is even and the other odd", |row| {
        is_even(row.contact.id1) != is_even(row.contact.id2)
    });
    // The smaller and the larger one.
    let radii = |row: &Row| {
        let two = bodies.radius[row.contact.id2 as usize];
        let one = bodies
            .radius
            .get(row.contact.id1 as usize)
            .copied()
            .unwrap_or(two);
        [one.min(two), one.max(two)]
    };
    let of_grains = |row: &Row, value: &dyn Fn(u32) -> f64| {
        let grains = [row.contact.id1, row.contact.id2].into_iter();
        let values = grains.filter(|id| ids.is_grain(*id)).map(value);
        values.fold(f64::NEG_INFINITY, f64::max)
    };
    let partners = partners(own);
    properties.number("their overlap over the smaller radius", |row| {
        row.contact.overlap / radii(row)[0]
    });
    properties.number("their overlap, m,", |row| row.contact.overlap);
    properties.number("the larger radius, m,", |row| radii(row)[1]);
    properties.number("the smaller radius, m,", |row| radii(row)[0]);
    properties.number("the ratio of their radii", |row| {
        radii(row)[1] / radii(row)[0]
    });
    properties.number("the larger id of their grains", |row| {
        of_grains(row, &f64::from)
    });
    properties.number("the number of contacts of one of their grains", |row| {
        of_grains(row, &|id| partners[id as usize])
    });
    properties.number("the smaller id of their grains", |row| {
        -of_grains(row, &|id| -f64::from(id))
    });
    let apart = |row: &Row| f64::from(row.contact.id1.abs_diff(row.contact.id2));
    properties.number("how far apart the ids of two grains are", |row| {
        if ids.is_grain(row.contact.id1) {
            apart(row)
        } else {
            0.0
        }
    });
    // Where each stands among all, among those of its first and of its second body that have rising ids, and among those at walls.
    let mut counts: BTreeMap<(u32, bool), f64> = BTreeMap::new();
    let mut at_walls: BTreeMap<u32, f64> = BTreeMap::new();
    let mut places: BTreeMap<(u32, u32), [f64; 6]> = BTreeMap::new();
    for (place, contact) in (1..).map(f64::from).zip(&own.contacts) {
        let (one, two) = contact.ids();
        let mut next = |id: u32, is_first: bool| {
            let count = counts.entry((id, is_first)).or_default();
            *count += 1.0;
            *count
        };
        let (as_first, as_second) = (next(one, true), next(two, false));
        let so_far = |id: u32, counts: &BTreeMap<(u32, bool), f64>| -> f64 {
            let both = [true, false].map(|is_first| counts.get(&(id, is_first)).copied());
            both.into_iter().flatten().sum()
        };
        let of_both = [one, two].map(|id| so_far(id, &counts));
        let walls = at_walls.entry(two).or_default();
        let of_walls = if ids.is_grain(one) { 0.0 } else { *walls + 1.0 };
        *walls = walls.max(of_walls);
        let values = [place, as_first, as_second, of_both[0], of_both[1], of_walls];
        places.insert((one, two), values);
    }
    let words = [
        "their place in the table of contacts",
        "their place among those of their first body with a higher id",
        "their place among those of their second grain with a lower id",
        "their place among those of their first body",
        "their place among those of their second grain",
        "their place among walls and punch that their grain touches",
    ];
    for (at, words) in words.into_iter().enumerate() {
        properties.number(words, |row| places[&row.ids()][at]);
    }
    // Of both grains.
    let least = |row: &Row, column: &[f64]| -of_grains(row, &|id| -column[id as usize]);
    properties.number("the sum of their radii, m,", |row| radii(row).iter().sum());
    properties.number("the smaller x of their grains, m,", |row| {
        least(row, &bodies.x)
    });
    properties.number("the smaller z of their grains, m,", |row| {
        least(row, &bodies.z)
    });
    if bodies.in_space() {
        properties.number("the smaller y of their grains, m,", |row| {
            least(row, &bodies.y)
        });
    }
    properties.number("their x, m,", |row| row.contact.point[0]);
    properties.number("their z, m,", |row| row.contact.point[1]);
    properties.number("their normal force, N,", |row| row.contact.normal_force);
    properties.told(what, wrong.len())
}

/// The columns of velocities and spins in which grains are off, as far as one in a hundred of the largest difference.
pub(crate) fn off_in(their: &Snapshot, own: &Snapshot) -> Option<String> {
    let (their, own) = (&their.bodies, &own.bodies);
    let mean = own.radius.iter().sum::<f64>() / own.len() as f64;
    let columns = their.motion().into_iter().zip(own.motion());
    // Places follow velocities.
    let columns = columns.filter(|((name, _), _)| !["x", "y", "z"].contains(name));
    let apart = columns.map(|((name, their), (_, own))| {
        let unit = if name.starts_with("spin") { mean } else { 1.0 };
        let apart = their.iter().zip(own).map(|(a, b)| unit * (a - b).abs());
        (name, apart.collect::<Vec<f64>>())
    });
    let apart: Vec<(&str, Vec<f64>)> = apart.collect();
    let all = apart.iter().flat_map(|(_, column)| column);
    let largest = all.copied().fold(0.0, f64::max);
    let said = apart.iter().filter_map(|(name, column)| {
        let is_off = |apart: &&f64| **apart > 0.01 * largest || apart.is_nan();
        let off = column.iter().filter(is_off).count();
        (off > 0).then(|| format!("{name} is off in {off} of {} grains", column.len()))
    });
    let said: Vec<String> = said.collect();
    (!said.is_empty()).then(|| said.join("; "))
}

/// What all of these grains have and no other one among some of this moment.
pub(crate) fn of_grains(
    case: &Case,
    own: &Snapshot,
    wrong: &[usize],
    among: &dyn Fn(usize) -> bool,
) -> Option<String> {
    let (ids, bodies) = (case.ids(), &own.bodies);
    let all: Vec<usize> = (0..bodies.len()).filter(|id| among(*id)).collect();
    let mut properties = Properties::new(&all, |id| wrong.contains(id))?;
    let walls = (0..case.model.walls.len()).map(|index| (format!("wall {index}"), ids.wall(index)));
    for (name, body) in walls.chain([("the punch".to_owned(), ids.punch())]) {
        let touching = touching(own, body);
        properties.add(format!("they touch {name}"), |id| {
            touching.contains(&(*id as u32))
        });
    }
    let partners = partners(own);
    properties.add_both(["they touch nothing", "they touch something"], |id| {
        partners[*id] == 0.0
    });
    properties.add_both(["they go right", "they go left"], |id| bodies.vx[*id] > 0.0);
    properties.add_both(["they rise", "they fall"], |id| bodies.vz[*id] > 0.0);
    properties.add_both(["their id is even", "their id is odd"], |id| id % 2 == 0);
    let materials: BTreeSet<u32> = bodies.material.iter().copied().collect();
    for material in materials {
        let words = format!("they are of material {material}");
        properties.add(words, |id| bodies.material[*id] == material);
    }
    properties.number("their radius, m,", |id| bodies.radius[*id]);
    properties.number("their mass, kg,", |id| bodies.mass[*id]);
    properties.number("their id", |id| *id as f64);
    properties.number("the number of their contacts", |id| partners[*id]);
    properties.number("their speed, m/s,", |id| {
        bodies.vx[*id].hypot(bodies.vz[*id])
    });
    properties.number("their x, m,", |id| bodies.x[*id]);
    properties.number("their z, m,", |id| bodies.z[*id]);
    if bodies.in_space() {
        properties.add_both(["they go along y", "they go against y"], |id| {
            bodies.vy[*id] > 0.0
        });
        properties.number("their y, m,", |id| bodies.y[*id]);
    }
    if bodies.spin.len() == bodies.len() {
        properties.number("their spin, rad/s,", |id| bodies.spin[*id].abs());
    }
    properties.told("grains are wrong", wrong.len())
}

/// What the laws of all states that are wrong have and those of no other: which part of the law it is.
pub(crate) fn of_states(states: &[(&Case, bool)]) -> Option<String> {
    macro_rules! rows {
        ($($words:expr, $has:expr;)+) => { [$(($words, $has)),+] };
    }
    type Has = fn(&Case, &Law) -> bool;
    let either: [([&str; 2], Has); 8] = rows! {
        ["there is friction", "there is no friction"], |_, law| law.has_friction();
        ["there are dashpots", "there are no dashpots"], |_, law| law.has_dashpots();
        ["grains turn", "grains do not turn"], |_, law| law.rotates();
        ["there is local damping", "there is no local damping"], |case, _| case.model.alpha != 0.0;
        ["there is a punch", "there is no punch"], |case, _| case.punch.is_some();
        ["springs are Hertz's and Mindlin's", "springs are linear"], |_, law| law.contact.springs == Springs::HertzMindlin;
        ["the slip is corrected", "the slip is that of the contact point"],
            |_, law| law.contact.slip_velocity == SlipVelocity::RatchetingCorrected;
        ["torques have arms to half the overlap", "torques have arms to the contact point"],
            |_, law| law.contact.torque_arms == TorqueArms::HalfOverlap;
    };
    let some: [(&str, Has); 10] = rows! {
        "there are moments against rolling", |_, law| law.contact.rolling.is_some();
        "moments are a constant torque", |_, law| law.contact.rolling.is_some_and(|rolling| rolling.bending_stiffness.is_none());
        "there is adhesion", |_, law| law.contact.adhesion.is_some();
        "adhesion holds what has touched", |_, law| law.holds();
        "there are several materials", |_, law| !law.materials.is_empty();
        "walls or punch have friction of their own", |_, law| law.has_friction_of_walls();
        "grains are in space", |case, _| case.bodies.in_space();
        "dashpots may pull", |_, law| law.has_dashpots() && law.contact.viscosity.tension() == Tension::Unclipped;
        "dashpots have a restitution", |_, law| matches!(law.contact.viscosity, Viscosity::Restitution { .. });
        "new contacts are given the slip since they touched", |_, law| law.contact.new_contact_slip == NewContactSlip::SinceTouch;
    };
    let mut properties = Properties::new(states, |(_, wrong)| *wrong)?;
    for (words, has) in either {
        properties.add_both(words, |(case, _)| has(case, &case.model.law));
    }
    for (words, has) in some {
        properties.add(words, |(case, _)| has(case, &case.model.law));
    }
    properties.number("φ, rad,", |(case, _)| case.model.law.friction_angle);
    properties.number("k_s/k_n", |(case, _)| case.model.law.stiffness_ratio);
    properties.number("α", |(case, _)| case.model.alpha);
    let count = properties.wrong.iter().filter(|wrong| **wrong).count();
    properties.told("states are wrong", count)
}

#[cfg(test)]
mod tests {
    use grains::variant::{self, Variant};

    use super::{Properties, Property, of_contacts, of_rows};
    use crate::contacts::Table;
    use crate::spheres::reference;

    fn split(count: usize, wrong: &dyn Fn(usize) -> bool) -> Option<String> {
        let all: Vec<usize> = (0..count).collect();
        let mut properties = Properties::new(&all, |at| wrong(*at))?;
        properties.add_both(["they slide", "they stick"], |at| at % 3 == 0);
        properties.add("they are at wall 1", |at| at % 20 == 0);
        properties.number("their x, m,", |at| *at as f64);
        properties.split()
    }

    #[test]
    fn what_all_have_and_few_others_is_told() {
        let rows: Vec<usize> = (0..400).collect();
        let is_even = |at: &usize| at.is_multiple_of(2);
        let told = |wrong: &dyn Fn(&usize) -> bool| {
            let properties: [Property<'_, usize>; 1] =
                [(["they are even", "they are odd"], &is_even)];
            of_rows(
                &rows,
                (wrong, |at: &usize| *at),
                &properties,
                &[("their number", &|at| *at as f64)],
            )
        };
        let said = told(&|at| at.is_multiple_of(20)).unwrap_or_default();
        assert_eq!(
            said,
            "20 of 400, all of them where they are even, as 180 that are right"
        );
        assert_eq!(told(&|at| *at == 7 || *at == 200), None);
        let said = told(&|at| *at >= 300 && is_even(at)).unwrap_or_default();
        let split = "where they are even and their number is 300 or more: all 50 of these and none of the other 350";
        assert_eq!(said, split);
        // The same of two contacts alone is chance, at however many moments.
        let of_two = of_rows(
            &rows,
            (|at: &usize| at.is_multiple_of(20), |at: &usize| at % 40),
            &[(["they are even", "they are odd"], &is_even)],
            &[],
        );
        assert_eq!(of_two, None);
    }

    #[test]
    fn a_clean_split_is_told_and_no_other() {
        assert_eq!(
            split(200, &|at| at % 20 == 0).as_deref(),
            Some("they are at wall 1")
        );
        let both = "they slide and they are at wall 1";
        assert_eq!(split(200, &|at| at % 60 == 0).as_deref(), Some(both));
        let above = "their x, m, is 195 or more";
        assert_eq!(split(200, &|at| at >= 195).as_deref(), Some(above));
        let among = "they slide and their x, m, is 180 or more";
        assert_eq!(
            split(200, &|at| at >= 180 && at % 3 == 0).as_deref(),
            Some(among)
        );
        assert_eq!(split(200, &|at| at % 7 == 0), None);
    }

    /// A grid that ends before the bed does, and boxes that are forgotten.
    #[test]
    fn contacts_that_are_missing_have_a_place() {
        let reference = reference().expect("a bed");
        let told = |is_missing: &dyn Fn(&crate::contacts::Row, &[f64]) -> bool, key: &str| {
            let mut states = reference.states().iter();
            let state = states.find(|state| state.key.starts_with(key)).expect(key);
            let own = &grains::variant::run(&state.case, &Default::default())[0];
            let rows = Table::from(own).rows();
            let missing = rows.filter(|row| is_missing(row, &own.bodies.x));
            let missing: Vec<_> = missing.map(|row| row.ids()).collect();
            let what = ("contacts are missing", &missing[..]);
            of_contacts(&state.case, &[], own, what, &|_| true).unwrap_or_default()
        };
        let far = |row: &crate::contacts::Row, x: &[f64]| {
            let ends = [row.contact.id1, row.contact.id2];
            ends.iter()
                .all(|id| x.get(*id as usize).is_some_and(|x| *x > 0.03))
        };
        let said = told(&far, "space-3-pouring");
        assert!(
            said.contains("missing where they are of two grains and the smaller x of their grains"),
            "{said}"
        );
        // Behind five walls, before the punch.
        let boxes = |row: &crate::contacts::Row, x: &[f64]| {
            (x.len() + 5..x.len() + 7).contains(&(row.contact.id1 as usize))
        };
        let said = told(&boxes, "space-14-under-punch");
        assert!(said.contains("missing where they are at boxes"), "{said}");
    }

    /// Triangles and boxes that are felt at their faces alone.
    #[test]
    fn contacts_that_are_missing_at_edges_are_told_so() {
        let reference = reference().expect("a bed");
        let mut told = Vec::new();
        for state in reference.states() {
            let (case, own) = (
                &state.case,
                &variant::run(&state.case, &Variant::default())[0],
            );
            let first = case.ids().wall(case.model.walls.len());
            let is_at_edge = |row: &crate::contacts::Row| {
                let index = row.contact.id1.checked_sub(first);
                let obstacle = index.and_then(|at| case.model.obstacles.get(at as usize));
                obstacle.is_some_and(|obstacle| obstacle.is_at_edge(row.normal(), 0, 1.0))
            };
            let missing = Table::from(own).rows().filter(is_at_edge);
            let missing: Vec<_> = missing.map(|row| row.ids()).collect();
            let what = ("contacts are missing", &missing[..]);
            told.extend(of_contacts(case, &[], own, what, &|_| true));
        }
        // All contacts of boxes are at edges there.
        for words in ["edges or corners of triangles", "boxes"] {
            let words = format!("missing where they are at {words}");
            assert!(told.iter().any(|said| said.contains(&words)), "{told:?}");
        }
    }

    /// An array that is too short, and one of each grain that is.
    #[test]
    fn contacts_that_are_missing_have_a_place_in_a_table() {
        let reference = reference().expect("a bed");
        let mut states = reference.states().iter();
        let state = states.find(|state| state.key == "space-0-at-rest");
        let state = state.expect("a bed at rest");
        let own = &grains::variant::run(&state.case, &Default::default())[0];
        let rows: Vec<_> = Table::from(own).rows().map(|row| row.ids()).collect();
        let told = |missing: &[(u32, u32)]| {
            let what = ("contacts are missing", missing);
            of_contacts(&state.case, &[], own, what, &|_| true).unwrap_or_default()
        };
        let said = told(&rows[150..]);
        let of_table = "their place in the table of contacts is 151 or more";
        assert!(said.contains(of_table), "{said}");
        let is_third = |at: &usize| *at >= 3 && rows[*at].0 == rows[*at - 3].0;
        let third =
            (0..rows.len()).filter(|at| (rows[*at].0 as usize) < own.bodies.len() && is_third(at));
        let third: Vec<(u32, u32)> = third.map(|at| rows[at]).collect();
        let said = told(&third);
        let of_grain = "among those of their first body with a higher id is 4 or more";
        assert!(said.contains(of_grain), "{said}");
        // A grain touches one wall at most.
        let is_at_wall = |row: &(u32, u32)| row.0 as usize >= own.bodies.len();
        let at_walls: Vec<(u32, u32)> = rows.iter().copied().filter(is_at_wall).collect();
        let is_later = |at: &usize| at_walls[..*at].iter().any(|row| row.1 == at_walls[*at].1);
        let later = (0..at_walls.len()).filter(is_later);
        let said = told(&later.map(|at| at_walls[at]).collect::<Vec<_>>());
        let of_walls = "their place among walls and punch that their grain touches is 2 or more";
        assert!(said.contains(of_walls), "{said}");
    }

    #[test]
    fn what_may_be_chance_is_not_told() {
        assert_eq!(split(200, &|at| at == 199), None);
        assert_eq!(split(6, &|at| at >= 4), None);
    }
}
