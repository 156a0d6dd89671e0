//! Under which condition contacts or grains are wrong: what all wrong ones of a moment have and no right one. It is told only where so
//! clean a split is no chance among all that are tried.

use std::collections::{BTreeMap, BTreeSet};

use grains::model::Law;
use grains::scene::{NewContactSlip, SlipVelocity, Springs, Tension, TorqueArms, Viscosity};
use grains::tables::{Body, Contact, Snapshot};
use grains::task::Case;
use grains::vector::{Vector, dot, minus};
use statrs::function::factorial::ln_binomial;

use crate::contacts::{Table, at_a_corner};
use crate::exercise::slides;

/// How probable a split may be that says nothing, over all that are tried.
const LEVEL: f64 = 0.05;

/// What is known of each of some contacts or grains.
#[derive(Default)]
struct Properties {
    /// In words, and which have it.
    has: Vec<(String, Vec<bool>)>,
    /// In words, with the place of the number, and the numbers.
    numbers: Vec<(&'static str, Vec<f64>)>,
}

impl Properties {
    fn add(&mut self, words: impl Into<String>, has: Vec<bool>) {
        self.has.push((words.into(), has));
    }

    /// And the other way round.
    fn add_both(&mut self, [one, other]: [&str; 2], has: Vec<bool>) {
        let not = has.iter().map(|has| !has).collect();
        self.add(one, has);
        self.add(other, not);
    }

    /// What splits the wrong ones from all others: one property, two, or a number above or below a value, among those that have a
    /// property or among all.
    fn split(mut self, wrong: &[bool]) -> Option<String> {
        let count = |flags: &[bool]| flags.iter().filter(|is| **is).count();
        self.has.retain(|(_, has)| count(has) > 0);
        let tried =
            self.has.len() * (self.has.len() + 2 * self.numbers.len()) + 2 * self.numbers.len();
        let enough = (tried as f64 / LEVEL).ln();
        let is_no_chance = |among: usize| ln_binomial(among as u64, count(wrong) as u64) > enough;
        let both = |a: &[bool], b: &[bool]| -> Vec<bool> {
            a.iter().zip(b).map(|(a, b)| *a && *b).collect()
        };
        if is_no_chance(wrong.len()) {
            if let Some((words, _)) = self.has.iter().find(|(_, has)| has == wrong) {
                return Some(words.clone());
            }
            for (at, (words, has)) in self.has.iter().enumerate() {
                let mut more = self.has[at + 1..].iter();
                if let Some((and, _)) = more.find(|(_, other)| both(has, other) == wrong) {
                    return Some(format!("{words} and {and}"));
                }
            }
        }
        let all = (String::new(), vec![true; wrong.len()]);
        for (words, among) in [&all].into_iter().chain(&self.has) {
            let is_among = both(among, wrong) == wrong;
            if !is_among || !is_no_chance(count(among)) {
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
                    return Some(format!("{words}{and}{number} is {from:.4e} or more"));
                }
                if of_wrong.1 < of_right.0 {
                    let to = of_wrong.1;
                    return Some(format!("{words}{and}{number} is {to:.4e} or less"));
                }
            }
        }
        None
    }
}

/// What all of these contacts have and no other one among some of this moment; `before` is the moment before it.
pub(crate) fn of_contacts(
    case: &Case,
    before: Option<&Snapshot>,
    own: &Snapshot,
    wrong: &[(u32, u32)],
    among: &dyn Fn((u32, u32)) -> bool,
) -> Option<String> {
    let (ids, bodies) = (case.ids(), &own.bodies);
    let rows = Table::from(own).rows().filter(|row| among(row.ids()));
    let (all, normals): (Vec<&Contact>, Vec<Vector>) =
        rows.map(|row| (row.contact, row.normal())).unzip();
    let holds = |property: &dyn Fn(&Contact) -> bool| {
        all.iter().copied().map(property).collect::<Vec<bool>>()
    };
    let number =
        |value: &dyn Fn(&Contact) -> f64| all.iter().copied().map(value).collect::<Vec<f64>>();
    let is_wrong = holds(&|contact| wrong.contains(&(contact.id1, contact.id2)));
    if !is_wrong.contains(&true) || !is_wrong.contains(&false) {
        return None;
    }
    let mut properties = Properties::default();
    properties.add_both(
        ["they are of two grains", "they are at walls or punch"],
        holds(&|contact| ids.body(contact.id1) == Body::Grain),
    );
    for index in 0..case.model.walls.len() {
        let wall = ids.wall(index);
        properties.add(
            format!("they are at wall {index}"),
            holds(&|contact| contact.id1 == wall),
        );
    }
    properties.add(
        "they are at the punch",
        holds(&|contact| contact.id1 == ids.punch()),
    );
    properties.add(
        "they are at corners of the punch",
        holds(&|contact| at_a_corner(ids, contact)),
    );
    if case.model.law.has_friction() {
        properties.add_both(
            ["they slide", "they stick"],
            holds(&|contact| slides(case, contact)),
        );
    }
    let velocity = |id: u32| match (bodies.vx.get(id as usize), own.punch) {
        (Some(vx), _) => {
            let vy = bodies.vy.get(id as usize).copied().unwrap_or(0.0);
            [*vx, vy, bodies.vz[id as usize]]
        }
        (None, Some(punch)) if id == ids.punch() => [0.0, 0.0, punch.velocity],
        _ => [0.0; 3],
    };
    let part = all.iter().zip(&normals).map(|(contact, normal)| {
        dot(minus(velocity(contact.id2), velocity(contact.id1)), *normal) > 0.0
    });
    properties.add_both(
        ["their bodies part", "their bodies approach"],
        part.collect(),
    );
    if let Some(before) = before {
        let had = |contact: &Contact| {
            let same = |other: &Contact| (other.id1, other.id2) == (contact.id1, contact.id2);
            before.contacts.iter().any(same)
        };
        properties.add_both(["they touched before", "they have just begun"], holds(&had));
        let of_before = |contact: &Contact| {
            let ids = (contact.id1, contact.id2);
            let mut all = before.contacts.iter();
            all.find(|other| (other.id1, other.id2) == ids).copied()
        };
        let grows = |contact: &Contact| {
            of_before(contact).is_some_and(|before| before.overlap < contact.overlap)
        };
        properties.add_both(
            [
                "their overlap has grown in the step",
                "their overlap has not grown in the step",
            ],
            holds(&grows),
        );
        properties.add(
            "they slid a step before",
            holds(&|contact| of_before(contact).is_some_and(|before| slides(case, &before))),
        );
    }
    for axis in [0, 1] {
        let words = [
            [
                "their normals point to the right",
                "their normals point to the left",
            ],
            ["their normals point up", "their normals point down"],
        ];
        properties.add_both(words[axis], holds(&|contact| contact.normal[axis] > 0.0));
    }
    let mut partners: BTreeMap<u32, f64> = BTreeMap::new();
    for id in own
        .contacts
        .iter()
        .flat_map(|contact| [contact.id1, contact.id2])
    {
        *partners.entry(id).or_default() += 1.0;
    }
    for (index, words) in (0..case.model.walls.len())
        .map(|index| (index, format!("one of their grains touches wall {index}")))
    {
        let at_wall: BTreeSet<u32> = own
            .contacts
            .iter()
            .filter(|contact| contact.id1 == ids.wall(index))
            .map(|contact| contact.id2)
            .collect();
        properties.add(
            words,
            holds(&|contact| at_wall.contains(&contact.id1) || at_wall.contains(&contact.id2)),
        );
    }
    if !bodies.material.is_empty() {
        let material = |id: u32| bodies.material.get(id as usize).copied().unwrap_or(0);
        properties.add_both(
            ["their materials are two", "their materials are one"],
            holds(&|contact| material(contact.id1) != material(contact.id2)),
        );
    }
    let radius = |id: u32| bodies.radius.get(id as usize).copied();
    let smaller = |contact: &Contact| {
        let second = bodies.radius[contact.id2 as usize];
        radius(contact.id1).unwrap_or(second).min(second)
    };
    let larger = |contact: &Contact| {
        let second = bodies.radius[contact.id2 as usize];
        radius(contact.id1).unwrap_or(second).max(second)
    };
    let of_grains = |contact: &Contact, value: &dyn Fn(u32) -> f64| {
        let one = if ids.is_grain(contact.id1) {
            value(contact.id1)
        } else {
            f64::NEG_INFINITY
        };
        one.max(value(contact.id2))
    };
    properties.numbers = vec![
        (
            "their overlap over the smaller radius",
            number(&|contact| contact.overlap / smaller(contact)),
        ),
        ("their overlap, m,", number(&|contact| contact.overlap)),
        ("the larger radius, m,", number(&larger)),
        ("the smaller radius, m,", number(&smaller)),
        (
            "the ratio of their radii",
            number(&|contact| larger(contact) / smaller(contact)),
        ),
        (
            "the larger id of their grains",
            number(&|contact| of_grains(contact, &f64::from)),
        ),
        (
            "the number of contacts of one of their grains",
            number(&|contact| of_grains(contact, &|id| partners[&id])),
        ),
        ("their x, m,", number(&|contact| contact.point[0])),
        ("their z, m,", number(&|contact| contact.point[1])),
        (
            "their normal force, N,",
            number(&|contact| contact.normal_force),
        ),
    ];
    let split = properties.split(&is_wrong)?;
    let (count, others) = (wrong.len(), all.len() - wrong.len());
    Some(format!(
        "contacts are wrong where {split}: all {count} of these and none of the other {others}"
    ))
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
    let holds = |property: &dyn Fn(usize) -> bool| {
        let all = all.iter().copied();
        all.map(property).collect::<Vec<bool>>()
    };
    let is_wrong = holds(&|id| wrong.contains(&id));
    if wrong.is_empty() || wrong.len() == all.len() {
        return None;
    }
    let touches = |body: u32, id: usize| {
        let mut contacts = own.contacts.iter();
        contacts.any(|contact| contact.id1 == body && contact.id2 as usize == id)
    };
    let mut properties = Properties::default();
    for index in 0..case.model.walls.len() {
        properties.add(
            format!("they touch wall {index}"),
            holds(&|id| touches(ids.wall(index), id)),
        );
    }
    properties.add(
        "they touch the punch",
        holds(&|id| touches(ids.punch(), id)),
    );
    let mut partners = vec![0.0; bodies.len()];
    for id in own
        .contacts
        .iter()
        .flat_map(|contact| [contact.id1, contact.id2])
    {
        if let Some(count) = partners.get_mut(id as usize) {
            *count += 1.0;
        }
    }
    properties.add_both(
        ["they touch nothing", "they touch something"],
        holds(&|id| partners[id] == 0.0),
    );
    properties.add_both(
        ["they go right", "they go left"],
        holds(&|id| bodies.vx[id] > 0.0),
    );
    properties.add_both(["they rise", "they fall"], holds(&|id| bodies.vz[id] > 0.0));
    let of_all = |value: &dyn Fn(usize) -> f64| {
        let all = all.iter().copied();
        all.map(value).collect::<Vec<f64>>()
    };
    properties.numbers = vec![
        ("their radius, m,", of_all(&|id| bodies.radius[id])),
        ("their mass, kg,", of_all(&|id| bodies.mass[id])),
        ("their id", of_all(&|id| id as f64)),
        ("the number of their contacts", of_all(&|id| partners[id])),
        (
            "their speed, m/s,",
            of_all(&|id| bodies.vx[id].hypot(bodies.vz[id])),
        ),
        ("their x, m,", of_all(&|id| bodies.x[id])),
        ("their z, m,", of_all(&|id| bodies.z[id])),
    ];
    if bodies.spin.len() == bodies.len() {
        properties
            .numbers
            .push(("their spin, rad/s,", of_all(&|id| bodies.spin[id].abs())));
    }
    let split = properties.split(&is_wrong)?;
    let (count, others) = (wrong.len(), all.len() - wrong.len());
    Some(format!(
        "grains are wrong where {split}: all {count} of these and none of the other {others}"
    ))
}

/// What the laws of all states that are wrong have and those of no other: which part of the law it is.
pub(crate) fn of_states(states: &[(&Case, bool)]) -> Option<String> {
    let wrong: Vec<bool> = states.iter().map(|(_, wrong)| *wrong).collect();
    if !wrong.contains(&true) || !wrong.contains(&false) {
        return None;
    }
    let holds = |property: &dyn Fn(&Case) -> bool| {
        let states = states.iter();
        states
            .map(|(case, _)| property(case))
            .collect::<Vec<bool>>()
    };
    let law = |property: &dyn Fn(&Law) -> bool| holds(&|case| property(&case.model.law));
    let mut properties = Properties::default();
    for (words, has) in [
        (
            ["there is friction", "there is no friction"],
            law(&Law::has_friction),
        ),
        (
            ["there are dashpots", "there are no dashpots"],
            law(&Law::has_dashpots),
        ),
        (["grains turn", "grains do not turn"], law(&Law::rotates)),
        (
            ["there is local damping", "there is no local damping"],
            holds(&|case| case.model.alpha != 0.0),
        ),
        (
            ["there is a punch", "there is no punch"],
            holds(&|case| case.punch.is_some()),
        ),
        (
            ["springs are Hertz's and Mindlin's", "springs are linear"],
            law(&|law| law.contact.springs == Springs::HertzMindlin),
        ),
        (
            [
                "the slip is corrected",
                "the slip is that of the contact point",
            ],
            law(&|law| law.contact.slip_velocity == SlipVelocity::RatchetingCorrected),
        ),
        (
            [
                "torques have arms to half the overlap",
                "torques have arms to the contact point",
            ],
            law(&|law| law.contact.torque_arms == TorqueArms::HalfOverlap),
        ),
    ] {
        properties.add_both(words, has);
    }
    for (words, has) in [
        (
            "there are moments against rolling",
            law(&|law| law.contact.rolling.is_some()),
        ),
        (
            "there is adhesion",
            law(&|law| law.contact.adhesion.is_some()),
        ),
        ("adhesion holds what has touched", law(&Law::holds)),
        (
            "there are several materials",
            law(&|law| !law.materials.is_empty()),
        ),
        (
            "walls or punch have friction of their own",
            law(&Law::has_friction_of_walls),
        ),
        ("grains are in space", holds(&|case| case.bodies.in_space())),
        (
            "dashpots may pull",
            law(&|law| law.has_dashpots() && law.contact.viscosity.tension() == Tension::Unclipped),
        ),
        (
            "dashpots have a restitution",
            law(&|law| matches!(law.contact.viscosity, Viscosity::Restitution { .. })),
        ),
        (
            "new contacts are given the slip since they touched",
            law(&|law| law.contact.new_contact_slip == NewContactSlip::SinceTouch),
        ),
    ] {
        properties.add(words, has);
    }
    let number = |value: &dyn Fn(&Case) -> f64| {
        let states = states.iter();
        states.map(|(case, _)| value(case)).collect::<Vec<f64>>()
    };
    properties.numbers = vec![
        ("φ, rad,", number(&|case| case.model.law.friction_angle)),
        ("k_s/k_n", number(&|case| case.model.law.stiffness_ratio)),
        ("α", number(&|case| case.model.alpha)),
    ];
    let split = properties.split(&wrong)?;
    let count = wrong.iter().filter(|wrong| **wrong).count();
    let others = wrong.len() - count;
    Some(format!(
        "states are wrong where {split}: all {count} of these and none of the other {others}"
    ))
}

#[cfg(test)]
mod tests {
    use super::Properties;

    fn properties(count: usize) -> Properties {
        let mut properties = Properties::default();
        let holds =
            |property: &dyn Fn(usize) -> bool| (0..count).map(property).collect::<Vec<bool>>();
        properties.add_both(["they slide", "they stick"], holds(&|at| at % 3 == 0));
        properties.add("they are at wall 1", holds(&|at| at % 20 == 0));
        properties.numbers = vec![("their x, m,", (0..count).map(|at| at as f64).collect())];
        properties
    }

    fn split(count: usize, wrong: &dyn Fn(usize) -> bool) -> Option<String> {
        let wrong: Vec<bool> = (0..count).map(wrong).collect();
        properties(count).split(&wrong)
    }

    #[test]
    fn a_clean_split_is_told_and_no_other() {
        assert_eq!(
            split(200, &|at| at % 20 == 0).as_deref(),
            Some("they are at wall 1")
        );
        let both = "they slide and they are at wall 1";
        assert_eq!(split(200, &|at| at % 60 == 0).as_deref(), Some(both));
        let above = "their x, m, is 1.9500e2 or more";
        assert_eq!(split(200, &|at| at >= 195).as_deref(), Some(above));
        let among = "they slide and their x, m, is 1.8000e2 or more";
        assert_eq!(
            split(200, &|at| at >= 180 && at % 3 == 0).as_deref(),
            Some(among)
        );
        assert_eq!(split(200, &|at| at % 7 == 0), None);
    }

    #[test]
    fn what_may_be_chance_is_not_told() {
        assert_eq!(split(200, &|at| at == 199), None);
        assert_eq!(split(6, &|at| at >= 4), None);
    }
}
