//! What the judged states exercise: how much touches and slides in them, and whether an engine that does not read a key of its job
//! would have been noticed. A verdict of agreement needs both, and names what it has not.

use std::collections::BTreeSet;

use evidence::moments::mean;
use grains::obstacle::Surface;
use grains::rules::Choice;
use grains::scene::{Springs, Viscosity};
use grains::tables::{Contact, Snapshot};
use grains::task::Case;
use grains::variant::{Form, Key, Variant};
use grains::vector::{Vector, cross, minus};
use serde::Serialize;

use crate::constants::kind_of_pair;
use crate::contacts::at_a_corner;
use crate::envelope::{Envelope, STEPS_WRITTEN_OUT};
use crate::forms;

/// How many contacts of a kind there are at once in the state that has the most.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Count {
    pub what: &'static str,
    pub found: usize,
    /// With fewer nothing is said.
    pub least: usize,
}

impl Count {
    pub fn is_enough(&self) -> bool {
        self.found >= self.least
    }
}

/// From where to where a constant of the law or a quantity of the motion goes in the judged states; in SI units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Range {
    pub what: &'static str,
    pub unit: &'static str,
    pub in_space: bool,
    pub least: f64,
    pub most: f64,
}

/// Those of the native runs of these cases: what an engine does beyond them is not known.
pub fn ranges<'a>(runs: impl Iterator<Item = (&'a Case, &'a [Snapshot])>) -> Vec<Range> {
    let mut all: Vec<Range> = Vec::new();
    for (case, run) in runs {
        let in_space = case.bodies.in_space();
        let mut see = |what, unit, value: f64| {
            let same = |range: &&mut Range| range.what == what && range.in_space == in_space;
            match all.iter_mut().find(same) {
                Some(range) => {
                    range.least = range.least.min(value);
                    range.most = range.most.max(value);
                }
                None => all.push(Range {
                    what,
                    unit,
                    in_space,
                    least: value,
                    most: value,
                }),
            }
        };
        constants(case, &mut see);
        for moment in run {
            motion(moment, &mut see);
        }
    }
    all
}

/// What to call a value, its unit, and the value.
type See<'a> = dyn FnMut(&'static str, &'static str, f64) + 'a;

fn constants(case: &Case, see: &mut See<'_>) {
    let (model, law) = (&case.model, &case.model.law);
    let [x, z] = model.gravity;
    see("gravity", "m/s²", x.hypot(z));
    see("α", "", model.alpha);
    see("Δt", "s", model.dt);
    if case.bodies.in_space() {
        see("materials", "", 1.0 + law.materials.len() as f64);
    }
    if let Some(punch) = case.punch {
        see("the punch's velocity", "m/s", punch.velocity);
        see("its half-width", "m", punch.half_extents[0]);
        see("its half-height", "m", punch.half_extents[1]);
    }
    if case.bodies.in_space() {
        see("obstacles", "", model.obstacles.len() as f64);
    }
    let mean_radius = mean(&case.bodies.radius);
    for obstacle in &model.obstacles {
        see("speeds of obstacles", "m/s", size(obstacle.velocity));
        see("their spins", "rad/s", size(obstacle.spin));
        match obstacle.shape {
            Surface::Plane { .. } => {}
            Surface::Triangle { vertices } => {
                let edges = [0, 1, 2].map(|at| minus(vertices[(at + 1) % 3], vertices[at]));
                let longest = edges.map(size).into_iter().fold(0.0, f64::max);
                let area = 0.5 * size(cross(edges[0], edges[1]));
                see("edges of triangles", "mean R", longest / mean_radius);
                see(
                    "their heights over edges",
                    "",
                    2.0 * area / (longest * longest),
                );
            }
            Surface::Box { half_extents, .. } => {
                for half in half_extents {
                    see("half edges of boxes", "mean R", half / mean_radius);
                }
            }
        }
    }
    for (radius, mass) in case.bodies.radius.iter().zip(&case.bodies.mass) {
        see("radii", "mean R", radius / mean_radius);
        see("masses", "kg", *mass);
    }
    let is_hertz = law.contact.springs == Springs::HertzMindlin;
    for solid in std::iter::once(law.solid(0)).chain(law.materials.iter().copied()) {
        see("E", "Pa", solid.modulus);
        if is_hertz {
            see("ν", "", solid.poissons_ratio);
        }
    }
    if law.has_friction() {
        for angle in law.friction_angles() {
            see("φ", "rad", angle);
        }
        if !is_hertz {
            see("k_s/k_n", "", law.stiffness_ratio);
        }
    }
    match law.contact.viscosity {
        Viscosity::None => {}
        Viscosity::Dashpot { c_n, .. } => see("c_n", "N·s/m", c_n),
        Viscosity::Restitution { e_n, .. } => see("e_n", "", e_n),
        Viscosity::Ratio { ratio, .. } => see("the dashpots' ratio", "", ratio),
    }
    let mut see_some = |what, unit, value: Option<f64>| {
        value.into_iter().for_each(|value| see(what, unit, value));
    };
    see_some("tangential dashpots", "", law.contact.tangential_viscosity);
    see_some("γ", "J/m²", law.contact.adhesion);
    if let Some(rolling) = law.contact.rolling {
        see_some("bending stiffness", "N·m", rolling.bending_stiffness);
        see_some(
            "twisting stiffness",
            "N·m",
            Some(rolling.twisting_stiffness),
        );
        see_some("the limit of moments", "", rolling.limit);
    }
}

/// Squares are added in this order.
fn size([a, b, c]: Vector) -> f64 {
    (a * a + b * b + c * c).sqrt()
}

fn motion(moment: &Snapshot, see: &mut See<'_>) {
    let bodies = &moment.bodies;
    let mut touching = vec![0.0f64; bodies.len()];
    for contact in &moment.contacts {
        let ids = [contact.id1, contact.id2].map(|id| id as usize);
        let radii = ids.map(|id| bodies.radius.get(id).copied().unwrap_or(f64::INFINITY));
        see("overlaps", "R", contact.overlap / radii[0].min(radii[1]));
        for id in ids {
            if let Some(count) = touching.get_mut(id) {
                *count += 1.0;
            }
        }
    }
    for (id, touching) in touching.into_iter().enumerate() {
        see("contacts of a grain", "", touching);
        let [vx, vy, vz] = bodies.velocity(id);
        see("speeds", "m/s", size([vx, vz, vy]));
        if bodies.rotate() {
            let [x, y, z] = bodies.angular_velocity(id);
            see("spins", "rad/s", size([y, x, z]));
        }
    }
    for place in [&bodies.x, &bodies.z, &bodies.y].into_iter().flatten() {
        see("coordinates", "m", *place);
    }
}

/// Contacts of grains, contacts that slide and contacts at walls are at least so many; at the punch one.
const LEAST: usize = 3;
/// A contact slides if its tangential force is its limit but for this share.
const AT_LIMIT: f64 = 1.0e-9;

/// Of the native runs of these cases; kinds that the cases do not have are left out.
pub fn counts<'a>(runs: impl Iterator<Item = (&'a Case, &'a [Snapshot])>) -> Vec<Count> {
    // Each with what it needs of a case, and how many at least.
    type Has = fn(&Case) -> bool;
    let kinds: [(&'static str, Has, usize); 5] = [
        ("pairs of grains", |_| true, LEAST),
        (
            "sliding contacts",
            |case| case.model.law.has_friction(),
            LEAST,
        ),
        (
            "contacts at walls",
            |case| !case.model.walls.is_empty(),
            LEAST,
        ),
        ("contacts at the punch", |case| case.punch.is_some(), 1),
        (
            "contacts at obstacles",
            |case| !case.model.obstacles.is_empty(),
            LEAST,
        ),
    ];
    let mut asked = [true, false, false, false, false];
    let mut most = [0; 5];
    for (case, run) in runs {
        for (asked, (_, has, _)) in asked.iter_mut().zip(kinds) {
            *asked |= has(case);
        }
        // Their ids follow those of the walls.
        let obstacles = (case.bodies.len() + case.model.walls.len()) as u32..case.ids().punch();
        for moment in run {
            let mut found = [0; 5];
            for contact in &moment.contacts {
                let kind = match obstacles.contains(&contact.id1) {
                    true => 4,
                    false => [0, 2, 3][kind_of_pair(case, contact.id1)],
                };
                found[kind] += 1;
                found[1] += usize::from(slides(case, contact));
            }
            let both = most.iter_mut().zip(found);
            both.for_each(|(most, found)| *most = found.max(*most));
        }
    }
    let all = kinds
        .into_iter()
        .zip(most)
        .zip(asked)
        .filter(|(_, asked)| *asked);
    let count = |(((what, _, least), found), _)| Count { what, found, least };
    all.map(count).collect()
}

/// Whether its tangential force is its limit.
pub(crate) fn slides(case: &Case, contact: &Contact) -> bool {
    let limit = case.tangent(contact.id1, contact.id2) * contact.normal_force.abs();
    limit > 0.0 && contact.tangential_force.abs() >= (1.0 - AT_LIMIT) * limit
}

/// The punch's corners, where there is a punch and its flat faces alone are touched.
pub(crate) fn untouched_corners<'a>(
    runs: impl Iterator<Item = (&'a Case, &'a [Snapshot])>,
) -> Option<&'static str> {
    let mut punched = runs.filter(|(case, _)| case.punch.is_some()).peekable();
    punched.peek()?;
    let mut at_corners = punched.map(|(case, run)| {
        let mut contacts = run.iter().flat_map(|snapshot| &snapshot.contacts);
        contacts.any(|contact| at_a_corner(case.ids(), contact))
    });
    let touched = at_corners.any(|touched| touched);
    (!touched).then_some("the punch's corners")
}

/// The grains with a contact that slides at any of these moments.
pub(crate) fn sliding(case: &Case, run: &[Snapshot]) -> BTreeSet<u32> {
    let contacts = run.iter().flat_map(|snapshot| &snapshot.contacts);
    let sliding = contacts.filter(|contact| slides(case, contact));
    sliding
        .flat_map(|contact| [contact.id1, contact.id2])
        .collect()
}

/// Every key with the forms of which an engine that does not read it, or takes the other choice, has one.
fn keys() -> impl Iterator<Item = (&'static str, Vec<Form>)> {
    let unread = Key::ALL.map(|key| (key.name(), vec![Form::Unread(key)]));
    let rule = |key: &str, either: [&str; 2]| {
        let both = either.map(|alternative| Choice::of(key, alternative));
        both.into_iter()
            .flatten()
            .map(Form::Rule)
            .collect::<Vec<Form>>()
    };
    let choices = [
        ("law.contact.rotation", vec![Form::SpinsKept]),
        (
            "law.contact.slip_velocity",
            rule("slip", ["corrected", "contact_point"]),
        ),
        (
            "law.contact.torque_arms",
            rule("torque_arms", ["half_overlap", "contact_point"]),
        ),
        (
            "law.contact.new_contact_slip",
            rule("new_contact", ["whole_step", "since_touch"]),
        ),
        (
            "law.contact.viscosity.tension",
            rule("tension", ["cut", "not_cut"]),
        ),
    ];
    unread.into_iter().chain(choices)
}

/// The keys with another value than the usual one that none of these states would show if an engine did not read them, and the
/// alternatives that none of them tells from the one that is judged by.
pub fn unseen(states: &[&Envelope]) -> Vec<String> {
    let is_unseen = |(_, key): &(&'static str, Vec<Form>)| {
        let asked = states.iter().flat_map(|envelope| {
            let forms = forms::candidates(&envelope.case);
            let of_key = forms.into_iter().filter(|form| key.contains(form));
            of_key.map(move |form| (envelope, form))
        });
        let mut asked = asked.peekable();
        asked.peek().is_some()
            && !asked.any(|(envelope, form)| {
                let changed = envelope.changed(&Variant::of(form), STEPS_WRITTEN_OUT);
                changed.is_some_and(|far| !far.is_rounding())
            })
    };
    let unread = keys().filter(is_unseen).map(|(name, _)| name.to_owned());
    let rules = Choice::all().filter(|choice| is_untold(*choice, states));
    unread.chain(rules.map(Choice::name)).collect()
}

/// Whether this other alternative plays a part in a state, and takes no engine away from what it does without.
fn is_untold(choice: Choice, states: &[&Envelope]) -> bool {
    let of_state =
        |envelope: &&&Envelope| forms::other_rules(&envelope.case).any(|other| other == choice);
    let mut asked = states.iter().filter(of_state).peekable();
    let shows = |envelope: &&Envelope| {
        // Few steps show most.
        [STEPS_WRITTEN_OUT, u64::MAX].into_iter().any(|steps| {
            let changed = envelope.changed(&Variant::of(Form::Rule(choice)), steps);
            changed.is_some_and(|far| !far.is_rounding())
        })
    };
    asked.peek().is_some() && !asked.any(shows)
}
