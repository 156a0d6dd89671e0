//! Which term of an engine's step is another one, read from what it writes itself: its grains and contact tables at steps that follow
//! each other. Each force, torque, velocity and place is held against what the model makes of the numbers that the engine has
//! written besides, so that nothing which came before plays a part; what is left over is laid onto a few terms. Told is only what
//! explains all of it to rounding.

use std::collections::{BTreeMap, BTreeSet};

use evidence::in_parallel;
use grains::reference::{Parts, Reference, Told};
use grains::rules::{
    DampedGravity, DampedSpins, DampingComponents, DampingVelocity, GivenVelocities, Integration,
    SpringWhenSliding, TangentialDashpot, WrittenVelocities,
};
use grains::tables::{Body, Contact, Snapshot};
use grains::task::Case;
use grains::vector::{Vector, cross, dot, each, hypot, minus, plus, times};
use nalgebra::{DMatrix, DVector};

use crate::conditions;
use crate::contacts::Table;

/// Of a number that follows from others no more than this share is rounding.
const ROUNDED: f64 = 1.0e-9;
/// Some row is off by so many times what may be rounding before a term is looked for.
const PLAIN: f64 = 1.0e3;
/// So many rows of a kind are looked at.
const MOST_ROWS: usize = 300;
/// So many terms may be other ones at once.
const MOST_TERMS: usize = 3;
/// So many of the best sets of terms are looked at closely.
const TRIED: usize = 12;
/// So many grains or contacts are named.
const FEW: usize = 4;
/// Contacts stick or slide for certain below and above these shares of Coulomb's limit.
const STICKS: f64 = 0.5;
const SLIDES: f64 = 1.05;
/// A spring that is turned to the first order leaves the tangent by so many times the squared angles at most.
const LOOSE: f64 = 40.0;
/// So much of Coulomb's limit tells that a force has been cut to it.
const AT_LIMIT: f64 = 1.0e-6;

const NONE: Vector = [0.0; 3];

/// What a number is made of: in words, how often the model has it, and its value.
type Term = (&'static str, f64, Vector);

/// Rows of words, how often, and value.
macro_rules! terms {
    ($($words:literal, $usual:expr => $value:expr;)*) => { vec![$(($words, $usual, $value)),*] };
}

/// A number that an engine writes, held against the model's.
struct Row {
    /// Which run and moment, and the contact or the grain there.
    at: (usize, usize),
    of: Of,
    /// How far it is off the model's, and how far it may be by rounding.
    off: Vector,
    least: f64,
    terms: Vec<Term>,
    /// Lengths and masses on which a factor may hang.
    sizes: Vec<(&'static str, f64)>,
    /// What it is between, where that is not the same for all.
    between: String,
}

#[derive(Clone, Copy, PartialEq)]
enum Of {
    Contact(u32, u32),
    Grain(usize),
}

/// What is held against the model: first comes what others follow from.
const QUANTITIES: [&str; 16] = [
    "contact points",
    "normal forces",
    "normal forces that the dashpot would make pull",
    "tangential forces of contacts that begin and stick",
    "tangential forces of contacts that begin and slide",
    "tangential forces at Coulomb's limit of contacts whose spring is below it",
    "tangential forces of contacts that stick",
    "tangential forces of contacts that slide",
    "tangential forces of contacts that stick again",
    "tangential forces of contacts that go on sliding",
    "velocities",
    "spins",
    "places",
    "forces on the punch",
    "normal forces that are cut to nothing",
    "tangential forces beyond Coulomb's limit that are not cut",
];
const POINTS: usize = 0;
const NORMAL: usize = 1;
const PULLED: usize = 2;
const NEW_STICKS: usize = 3;
const NEW_SLIDES: usize = 4;
const CUT_EARLY: usize = 5;
const STICKING: usize = 6;
const SLIDING: usize = 7;
const STICKING_AGAIN: usize = 8;
const SLIDING_ON: usize = 9;
const VELOCITIES: usize = 10;
const SPINS: usize = 11;
const PLACES: usize = 12;
const PUNCH: usize = 13;
const CUT_AWAY: usize = 14;
const NOT_CUT: usize = 15;

type Rows = BTreeMap<(usize, usize), Vec<Row>>;

/// Runs of one law, each with moments that follow each other step by step from the start.
/// Motion that follows from forces which are not those that are written is not told.
pub(crate) fn found(runs: &[(&Case, &[Snapshot])], moves: bool) -> Vec<String> {
    let all = in_parallel(runs.len(), |run| {
        let (case, moments) = runs[run];
        let mut rows = Rows::new();
        Follower::new(case, run).follow(moments, &mut rows);
        rows
    });
    let mut rows = Rows::new();
    for (key, of_run) in all.into_iter().flatten() {
        rows.entry(key).or_default().extend(of_run);
    }
    let keys: Vec<(usize, usize)> = rows.keys().copied().collect();
    let said = in_parallel(keys.len(), |at| explained(&rows[&keys[at]], runs));
    let is_off = |quantity: usize| {
        let mut of = rows.iter().filter(|(key, _)| key.0 == quantity);
        // Few may have remembered something that is not written.
        of.any(|(_, rows)| 2 * rows.iter().filter(|row| row.ratio() > PLAIN).count() > rows.len())
    };
    let is_told = |quantity: usize| {
        keys.iter()
            .zip(&said)
            .any(|(key, said)| key.0 == quantity && said.is_some())
    };
    let mut told: Vec<String> = Vec::new();
    for (quantity, name) in QUANTITIES.into_iter().enumerate() {
        // What slides goes the way of what sticks, and contacts that go on have all that new ones have.
        let sticks_otherwise = [NEW_STICKS, STICKING]
            .into_iter()
            .any(|of| is_off(of) || is_told(of));
        let follows = match quantity {
            CUT_AWAY => true,
            PULLED => is_told(NORMAL),
            of if (NEW_STICKS..=SLIDING_ON).contains(&of) && is_told(NORMAL) => true,
            NEW_STICKS => is_told(STICKING),
            CUT_EARLY | STICKING_AGAIN => sticks_otherwise,
            SLIDING => sticks_otherwise || is_told(CUT_EARLY),
            NEW_SLIDES => is_off(NEW_STICKS) || is_told(CUT_EARLY) || is_told(SLIDING),
            SLIDING_ON => (NEW_STICKS..SLIDING_ON).any(&is_off),
            NOT_CUT => {
                let slide = |of| keys.iter().any(|key| key.0 == of);
                sticks_otherwise || [NEW_SLIDES, SLIDING, SLIDING_ON].into_iter().any(slide)
            }
            VELOCITIES | SPINS => !moves,
            _ => false,
        };
        if follows {
            continue;
        }
        let of_kinds = keys.iter().zip(&said).filter(|(key, _)| key.0 == quantity);
        let of_kinds: Vec<_> = of_kinds.collect();
        let some_right = of_kinds
            .iter()
            .any(|(key, _)| !rows[key].iter().any(Row::is_off));
        let mut seen: Vec<&String> = Vec::new();
        for (_, said) in &of_kinds {
            let Some((said, place_of)) = said.as_ref().filter(|said| !seen.contains(&&said.0))
            else {
                continue;
            };
            seen.push(said);
            let is_same = |other: &Option<(String, String)>| {
                other.as_ref().is_some_and(|other| other.0 == *said)
            };
            let same = of_kinds.iter().filter(|(_, other)| is_same(other));
            let kinds: Vec<&str> = same.map(|(key, _)| KINDS[key.1]).collect();
            let place = match quantity < VELOCITIES || quantity == NOT_CUT {
                true if some_right => format!(" {} alone", kinds.join(" and ")),
                true => format!(" {}", kinds.join(" and ")),
                false => String::new(),
            };
            told.push(format!("{name}{place}: {said}{place_of}"));
        }
    }
    told
}

const KINDS: [&str; 3] = ["between grains", "at walls", "at the punch"];

/// Goes along a run.
struct Follower<'a> {
    case: &'a Case,
    run: usize,
    /// What each contact had at the moment before, and by how much its normal has turned so far, squared, rad².
    before: BTreeMap<(u32, u32), Before>,
}

struct Before {
    parts: Parts,
    overlap: f64,
    normal: Vector,
    normal_force: f64,
    tangential: Vector,
    turned: f64,
}

/// Forces and torques on a grain of one kind.
#[derive(Clone, Copy, Default)]
struct Load {
    /// By the normal and by the tangential force.
    forces: [Vector; 2],
    torque: Vector,
}

/// What acts on a grain: as the first and as the second of a pair, at walls, at the punch.
#[derive(Clone, Default)]
struct Loads {
    kinds: [Load; 4],
    dashpots: [Vector; 2],
    /// Torques of the dashpots along the tangent, of what half of the overlap is of the arms, of the other grain's torque in the place of its own.
    braking: Vector,
    half: [Vector; 3],
    /// Torques of what Coulomb's limit has cut.
    cut: Vector,
    others: [Vector; 2],
    moments: [Vector; 2],
    /// The normal forces times the radius, against the spin.
    rolling: Vector,
}

impl Loads {
    fn force(&self) -> Vector {
        let all = self.kinds.iter().flat_map(|kind| kind.forces);
        all.fold(NONE, plus)
    }

    fn torque(&self) -> Vector {
        self.kinds
            .iter()
            .fold(NONE, |sum, kind| plus(sum, kind.torque))
    }
}

impl<'a> Follower<'a> {
    fn new(case: &'a Case, run: usize) -> Self {
        Follower {
            case,
            run,
            before: BTreeMap::new(),
        }
    }

    fn follow(&mut self, moments: &[Snapshot], rows: &mut Rows) {
        let rules = self.case.model.law.resolved(self.case.model.rules);
        if rules.written_velocities != WrittenVelocities::HalfStep {
            return;
        }
        let mut past: Option<(&Snapshot, Vec<Loads>)> = None;
        let mut before: Option<Vec<Loads>> = None;
        for (at, now) in moments.iter().enumerate() {
            let mut now_bodies = now.bodies.clone();
            let given = &self.case.bodies;
            now_bodies.radius.clone_from(&given.radius);
            now_bodies.mass.clone_from(&given.mass);
            now_bodies.inertia.clone_from(&given.inertia);
            now_bodies.material.clone_from(&given.material);
            if let Some((was, loads)) = &past {
                self.motion((*was, now), (loads, before.as_deref()), at, rows);
            }
            before = past.take().map(|(_, loads)| loads);
            let model = &self.case.model;
            let reference = Reference::holding(model, &now_bodies, now.punch, &now.contacts);
            let loads = self.contacts(&reference, now, at, rows);
            past = Some((now, loads));
        }
    }

    /// The contacts of a moment; what they do to each grain.
    fn contacts(
        &mut self,
        reference: &Reference,
        now: &Snapshot,
        at: usize,
        rows: &mut Rows,
    ) -> Vec<Loads> {
        let case = self.case;
        let (law, dt) = (&case.model.law, case.model.dt);
        let rules = law.resolved(case.model.rules);
        let mut loads = vec![Loads::default(); case.bodies.len()];
        let own = reference.contacts_with_across();
        let mut own = Table {
            contacts: &own.0,
            across: &own.1,
        }
        .rows()
        .peekable();
        let mut after = BTreeMap::new();
        for row in Table::from(now).rows() {
            let (contact, ids) = (row.contact, row.ids());
            while own.next_if(|own| own.ids() < ids).is_some() {}
            let Some(made) = own.next_if(|own| own.ids() == ids) else {
                continue;
            };
            let (normal, fn_told, u) = (row.normal(), contact.normal_force, contact.overlap);
            let tangential = match case.bodies.in_space() {
                true => row.tangential(),
                false => times(contact.tangential_force, [-normal[2], 0.0, normal[0]]),
            };
            let was = self.before.get(&ids);
            let told = was.map(|was| {
                // A force that is at its limit had no dashpot added.
                let limit = was.parts.limit;
                let cut = is_at(hypot(was.tangential), limit, was.turned);
                let acts = match rules.tangential_dashpot {
                    TangentialDashpot::None => false,
                    TangentialDashpot::WhileSticking => !cut,
                    _ => true,
                };
                let whole = was
                    .parts
                    .brakings
                    .iter()
                    .fold(NONE, |sum, of| plus(sum, *of));
                // What of the spring lies along the normal is told with the normal force.
                let more = was.normal_force - was.parts.normal_force;
                let most = LOOSE * was.turned * hypot(was.tangential).max(was.parts.limit);
                let along = if more.abs() <= most {
                    times(more, was.normal)
                } else {
                    NONE
                };
                let told = Told {
                    normal: was.normal,
                    overlap: was.overlap,
                    tangential: plus(was.tangential, along),
                    braking: whole,
                    brakes: acts,
                    slip: was.parts.slips.iter().fold(NONE, |sum, of| plus(sum, *of)),
                };
                (told, cut)
            });
            let Some(parts) = reference.parts(ids, (fn_told, tangential), told.map(|told| told.0))
            else {
                continue;
            };
            let turn = was.map_or(0.0, |was| hypot(cross(was.normal, normal)).powi(2));
            let turned = was.map_or(0.0, |was| was.turned) + turn;
            let size = [parts.elastic, parts.viscous, parts.pull, fn_told]
                .map(f64::abs)
                .into_iter()
                .fold(0.0, f64::max);
            let before = was.map_or(0.0, |was| was.parts.limit.max(hypot(was.tangential)));
            let loose = LOOSE * turned * hypot(tangential).max(parts.limit).max(before);
            let kind = parts.first as usize;
            let [r1, r2] = parts.radii;
            let m2 = case.bodies.mass[ids.1 as usize];
            let m1 = case.bodies.mass.get(ids.0 as usize).copied().unwrap_or(m2);
            let sizes = vec![
                ("u", u),
                ("R₁", r1),
                ("R₂", r2),
                ("(R₁ + R₂)", r1 + r2),
                ("R₁R₂/(R₁ + R₂)", r1 * r2 / (r1 + r2)),
                ("min(R₁, R₂)", r1.min(r2)),
                ("max(R₁, R₂)", r1.max(r2)),
                ("m₁m₂/(m₁ + m₂)", m1 * m2 / (m1 + m2)),
                ("m₁", m1),
                ("m₂", m2),
                ("(m₁ + m₂)", m1 + m2),
                ("(R₂ − u)", r2 - u),
                ("(R₂ − u/2)", r2 - 0.5 * u),
                ("max(m₁, m₂)", m1.max(m2)),
                ("u of the step before", was.map_or(u, |was| was.overlap)),
                (
                    "|k_s·Δt·slip|",
                    hypot(parts.slips.iter().fold(NONE, |sum, of| plus(sum, *of))),
                ),
                ("F_s", parts.elastic),
                ("|F_s − F_a|", (parts.elastic - parts.pull).abs()),
            ];
            let material = |id: u32| case.bodies.material.get(id as usize).copied().unwrap_or(0);
            let (a, b) = (material(ids.0), material(ids.1));
            let between = match (case.bodies.material.is_empty(), parts.first) {
                (false, _) => format!("materials {} and {}", a.min(b), a.max(b)),
                (true, Body::Wall) => {
                    format!("wall {} and grains", ids.0 - case.bodies.len() as u32)
                }
                _ => String::new(),
            };
            let mut add = |quantity: usize, off: Vector, least: f64, terms: Vec<Term>| {
                rows.entry((quantity, kind)).or_default().push(Row {
                    at: (self.run, at),
                    of: Of::Contact(ids.0, ids.1),
                    off,
                    least,
                    terms,
                    sizes: sizes.clone(),
                    between: between.clone(),
                });
            };
            let one = |number: f64| [number, 0.0, 0.0];
            // Lengths are rounded as places are.
            let length = ROUNDED * r2;
            let (own_u, own_normal) = (made.contact.overlap, made.normal());
            add(
                POINTS,
                minus(row.point(), made.point()),
                length,
                terms! {
                    "R of the first along the normal", 0.0 => times(r1, own_normal);
                    "R of the second along the normal", 0.0 => times(r2, own_normal);
                    "the overlap along the normal", 0.0 => times(own_u, own_normal);
                },
            );
            let mut of_normal = terms! {
                "the spring's force", 1.0 => one(parts.elastic);
                "the dashpot's force", 1.0 => one(parts.viscous);
                "the pull of adhesion", 1.0 => one(-parts.pull);
            };
            let [change, elastic, viscous] = was.map_or([0.0; 3], |was| {
                [
                    parts.c_n * (u - was.overlap) / dt,
                    was.parts.elastic,
                    was.parts.viscous,
                ]
            });
            of_normal.extend(terms! {
                "c_n·(change of overlap in the step)/Δt", 0.0 => one(change);
                "the spring's force of the step before", 0.0 => one(elastic);
                "the dashpot's force of the step before", 0.0 => one(viscous);
            });
            let punch = now
                .punch
                .filter(|_| parts.first == Body::Punch)
                .map_or(0.0, |punch| punch.velocity);
            of_normal.extend(terms! {
                "the size of the dashpot's force", 0.0 => one(parts.viscous.abs());
                "the dashpot's force by the punch's velocity", 1.0 => one(parts.c_n * punch * normal[2]);
            });
            let whole = parts.elastic + parts.viscous - parts.pull;
            let is_cut = (parts.normal_force - whole).abs() > ROUNDED * size;
            if is_cut {
                of_normal.iter_mut().for_each(|term| term.1 = 0.0);
            }
            let gone = fn_told == 0.0 && !is_cut && law.has_dashpots();
            let quantity = match gone {
                true => CUT_AWAY,
                false if is_cut => PULLED,
                false => NORMAL,
            };
            add(
                quantity,
                one(fn_told - parts.normal_force),
                ROUNDED * size + loose,
                of_normal,
            );
            self.tangential(
                &parts,
                (tangential, normal, u, loose, turned),
                was.zip(told),
                &mut add,
            );
            // Loads by what is written.
            let pairs = parts.first == Body::Grain;
            let sides = [(0, ids.0, -1.0), (1 + kind, ids.1, 1.0)];
            let acting = told_braking(&parts, (tangential, turned), rules.tangential_dashpot);
            for (side, (which, id, sign)) in sides.into_iter().enumerate() {
                if side == 0 && !pairs {
                    continue;
                }
                let load = &mut loads[id as usize];
                let spin = [&now.bodies.spin_x, &now.bodies.spin, &now.bodies.spin_z]
                    .map(|of| of.get(id as usize).copied().unwrap_or(0.0));
                let against = -fn_told * parts.radii[side] / hypot(spin).max(f64::MIN_POSITIVE);
                load.rolling = plus(load.rolling, times(against, spin));
                let by = [times(sign * fn_told, normal), times(sign, tangential)];
                let of_kind = &mut load.kinds[which];
                for (sum, by) in of_kind.forces.iter_mut().zip(by) {
                    *sum = plus(*sum, by);
                }
                of_kind.torque = plus(of_kind.torque, parts.torques[side]);
                let arm = |force: Vector, arm: f64| times(-arm, cross(normal, force));
                load.dashpots[0] = plus(load.dashpots[0], times(sign * parts.viscous, normal));
                load.dashpots[1] = plus(load.dashpots[1], times(sign, acting));
                if acting != NONE {
                    load.braking = plus(load.braking, parts.braking_torques[side]);
                }
                if is_at(hypot(tangential), parts.limit, turned) {
                    load.cut = plus(load.cut, parts.cut_torques[side]);
                }
                let half = &mut load.half[kind];
                *half = plus(*half, arm(tangential, 0.5 * u));
                if pairs {
                    let more = times(
                        parts.radii[1 - side] - parts.radii[side],
                        cross(tangential, normal),
                    );
                    for (sum, counts) in load.others.iter_mut().zip([true, side == 1]) {
                        *sum = plus(*sum, if counts { more } else { NONE });
                    }
                }
                for (sum, moment) in load.moments.iter_mut().zip(parts.moments) {
                    *sum = plus(*sum, times(sign, moment));
                }
            }
            after.insert(
                ids,
                Before {
                    parts,
                    overlap: u,
                    normal,
                    normal_force: fn_told,
                    tangential,
                    turned,
                },
            );
        }
        self.before = after;
        if let Some(punch) = now.punch {
            let force = |contact: &Contact, first: bool| {
                let is_of_it = contact.id1 == case.ids().punch();
                let size = contact.normal_force.hypot(contact.tangential_force);
                match first {
                    true if is_of_it => {
                        contact.normal_force * contact.normal[1]
                            + contact.tangential_force * contact.normal[0]
                    }
                    false => size,
                    _ => 0.0,
                }
            };
            let sum = |first: bool| {
                now.contacts
                    .iter()
                    .map(|contact| force(contact, first))
                    .sum::<f64>()
            };
            let [on_punch, sizes] = [-sum(true), sum(false)];
            if !case.bodies.in_space() {
                rows.entry((PUNCH, 2)).or_default().push(Row {
                    at: (self.run, at),
                    of: Of::Contact(case.ids().punch(), 0),
                    off: [punch.force - on_punch, 0.0, 0.0],
                    least: ROUNDED * (on_punch.abs() + punch.force.abs() + 1.0e-6 * sizes),
                    terms: terms! {
                        "the sum of its contacts' forces", 1.0 => [on_punch, 0.0, 0.0];
                        "the sum of the sizes of all contacts' forces", 0.0 => [sizes, 0.0, 0.0];
                    },
                    sizes: Vec::new(),
                    between: String::new(),
                });
            }
        }
        loads
    }

    /// A tangential force: that of a contact that begins or goes on, and that sticks or slides for certain.
    fn tangential(
        &self,
        parts: &Parts,
        (tangential, normal, u, loose, turned): (Vector, Vector, f64, f64, f64),
        before: Option<(&Before, (Told, bool))>,
        add: &mut dyn FnMut(usize, Vector, f64, Vec<Term>),
    ) {
        let case = self.case;
        let rules = case.model.law.resolved(case.model.rules);
        if !case.model.law.has_friction() {
            return;
        }
        let kept_is_told = rules.spring_when_sliding == SpringWhenSliding::Limited;
        if before.is_some_and(|(_, (_, cut))| cut && !kept_is_told) {
            return;
        }
        let across = |of: Vector| minus(of, times(dot(of, normal), normal));
        let sum = |of: &[Vector; 3]| of.iter().fold(NONE, |sum, part| plus(sum, *part));
        let (slip, braking) = (sum(&parts.slips), sum(&parts.brakings));
        let trial = plus(
            plus(parts.kept, times(parts.share, slip)),
            plus(parts.turns[0], parts.turns[1]),
        );
        let spins = |of: &[Vector; 3]| plus(of[1], of[2]);
        let u_of = u / (parts.radii[0] + parts.radii[1]);
        let (size, told, limit) = (hypot(trial), hypot(tangential), parts.limit);
        let off = across(minus(tangential, parts.tangential));
        let begins = before.is_none();
        let mut of_before = Vec::new();
        let has = |does: bool| if does { 1.0 } else { 0.0 };
        if let Some((was, (told, cut))) = before {
            let growth = (parts.k_s / was.parts.k_s - 1.0) * has(was.parts.k_s > 0.0);
            let whole = plus(parts.kept, plus(parts.turns[0], parts.turns[1]));
            let [force, braking, slip] = parts.turned;
            of_before = terms! {
                "k_s·Δt·slip of the step before", 0.0 => times(1.0 + growth, told.slip);
                "k_s·Δt·slip of the step before, turned", 0.0 => slip;
                "the dashpot's force of the step before, which the spring keeps,", 0.0 => times(has(told.brakes), braking);
                "the spring's force of the step before, times the growth of k_s since, as of a spring that keeps a displacement,", 0.0 => times(growth, whole);
                "the dashpot's force of the step before, where it slid,", 0.0 => times(has(cut && !told.brakes), braking);
                "the whole force of the step before", 0.0 => force;
                "the force of the step before, not turned", 0.0 => told.tangential;
            };
        }
        let scale = [size, told, hypot(slip), hypot(braking)]
            .into_iter()
            .fold(0.0, f64::max);
        let beyond = rules.tangential_dashpot == TangentialDashpot::Beyond;
        let none = rules.tangential_dashpot == TangentialDashpot::None;
        let within = rules.tangential_dashpot == TangentialDashpot::Within;
        // What a contact keeps that slid is not for certain what it wrote.
        let was_cut = before.is_some_and(|(_, (_, cut))| cut);
        if !told.is_finite() {
            let quantity = if begins { NEW_STICKS } else { STICKING };
            return add(quantity, tangential, 1.0, Vec::new());
        }
        let is_early = !was_cut && size < limit / SLIDES && is_at(told, limit, turned);
        let mut terms: Vec<Term>;
        let quantity;
        if size < STICKS * limit && told < STICKS * limit {
            terms = terms! {
                "k_s·Δt·slip", parts.share => slip;
                "the dashpot's force", has(!none) => braking;
                "the spring's force of the step before", 1.0 => plus(parts.kept, plus(parts.turns[0], parts.turns[1]));
                "the spring's force of the step before, not turned,", 1.0 => parts.kept;
                "the turn of the spring with the normal", 1.0 => parts.turns[0];
                "the turn of the spring about the normal", 1.0 => parts.turns[1];
                "k_s·Δt·slip of the spins", parts.share => spins(&parts.slips);
                "k_s·Δt·slip of the centres", parts.share => parts.slips[0];
                "the dashpot's force by the spins", has(!none) => spins(&parts.brakings);
                "the dashpot's force by the centres", has(!none) => parts.brakings[0];
                "k_s·Δt·slip of the first one's spin", parts.share => parts.slips[1];
                "k_s·Δt·slip of the second one's spin", parts.share => parts.slips[2];
                "k_s·Δt·slip of the punch's velocity", parts.share => parts.slip_of_first;
                "k_s·Δt·slip of the spins, times u/(R₁ + R₂),", 0.0 => times(u_of, spins(&parts.slips));
                "k_s·Δt·slip of the centres, times u/(R₁ + R₂),", 0.0 => times(u_of, parts.slips[0]);
            };
            quantity = match was_cut {
                _ if begins => NEW_STICKS,
                true => STICKING_AGAIN,
                false => STICKING,
            };
        } else if (size > SLIDES * limit || is_early) && (limit > 0.0 || told > 0.0) && !within {
            let way = times(1.0 / size, trial);
            let elastic = parts.tangent * parts.elastic;
            let along = |of: Vector| match hypot(of) {
                0.0 => NONE,
                size => times(limit / size, of),
            };
            terms = terms! {
                "Coulomb's limit along the spring's force", has(!is_early) => times(limit, way);
                "the force of spring and dashpot without a limit", has(is_early) => plus(trial, times(has(!none), braking));
                "the dashpot's force, also while it slides,", has(beyond && !is_early) => braking;
                "tan φ·(the normal spring's force)", 0.0 => times(elastic, way);
                "tan φ·(the normal dashpot's force)", 0.0 => times(parts.tangent * parts.viscous, way);
                "tan φ·(the normal force before its tension is cut)", 0.0 => times(has(limit <= ROUNDED * parts.tangent * parts.elastic.abs()) * parts.tangent * (parts.elastic + parts.viscous - parts.pull).abs(), way);
                "tan φ·(the pull of adhesion)", 0.0 => times(parts.tangent * parts.pull, way);
                "the spring's force without a limit", 0.0 => trial;
                "Coulomb's limit against the slip", 0.0 => along(slip);
                "Coulomb's limit along spring and dashpot together", 0.0 => along(plus(trial, braking));
                "the spring's force before this step's slip is added", 0.0 => minus(trial, slip);
                "k_s·Δt·slip", 0.0 => slip;
            };
            let (limit_before, old) = before.map_or((0.0, NONE), |(was, (old, _))| {
                (was.parts.limit, old.tangential)
            });
            terms.extend(terms! {
                "tan φ·(the normal force of the step before)", 0.0 => times(limit_before, way);
                "Coulomb's limit along the force of the step before", 0.0 => along(old);
            });
            quantity = match is_early {
                true => CUT_EARLY,
                // The limit of the engine may be larger.
                _ if (told - hypot(plus(trial, times(has(!none), braking)))).abs()
                    <= AT_LIMIT * told =>
                {
                    NOT_CUT
                }
                false if begins => NEW_SLIDES,
                false if was_cut => SLIDING_ON,
                false => SLIDING,
            };
        } else {
            return;
        }
        if !is_early {
            terms.extend(of_before);
        }
        terms.iter_mut().for_each(|term| term.2 = across(term.2));
        let scale = if [NEW_STICKS, STICKING, STICKING_AGAIN].contains(&quantity) {
            scale
        } else {
            limit
                .max(told)
                .max(1.0e-3 * size)
                .max(1.0e-3 * parts.tangent * parts.elastic.abs())
        };
        add(quantity, off, ROUNDED * scale + loose, terms);
    }

    /// Velocities, spins and places after a step, from the forces that are written before it.
    fn motion(
        &self,
        (was, now): (&Snapshot, &Snapshot),
        (loads, before): (&[Loads], Option<&[Loads]>),
        at: usize,
        rows: &mut Rows,
    ) {
        let model = &self.case.model;
        let rules = model.law.resolved(model.rules);
        let first_is_half = rules.given_velocities != GivenVelocities::HalfStepBefore && at == 1;
        let plain = rules.damping_velocity == DampingVelocity::Middle
            && rules.damped_gravity == DampedGravity::Damped
            && rules.damping_components == DampingComponents::Each;
        if now.step != was.step + 1 || first_is_half || !(plain || model.alpha == 0.0) {
            return;
        }
        let (dt, bodies) = (model.dt, &self.case.bodies);
        let vector = |columns: [&[f64]; 3], id: usize| {
            columns.map(|column| column.get(id).copied().unwrap_or(0.0))
        };
        let places = |of: &Snapshot, id| vector([&of.bodies.x, &of.bodies.y, &of.bodies.z], id);
        let velocity =
            |of: &Snapshot, id| vector([&of.bodies.vx, &of.bodies.vy, &of.bodies.vz], id);
        let spin =
            |of: &Snapshot, id| vector([&of.bodies.spin_x, &of.bodies.spin, &of.bodies.spin_z], id);
        let sum = |of: &mut dyn Iterator<Item = Vector>| of.fold(NONE, plus);
        let rolls = model.law.contact.rolling.is_some();
        for (id, load) in loads.iter().enumerate() {
            let (mass, radius) = (bodies.mass[id], bodies.radius[id]);
            let mut add = |quantity: usize, off: Vector, least: f64, terms: Vec<Term>| {
                let mut sizes = vec![("m", mass), ("R", radius)];
                sizes.extend(bodies.inertia.get(id).map(|inertia| ("I", *inertia)));
                rows.entry((quantity, 0)).or_default().push(Row {
                    at: (self.run, at),
                    of: Of::Grain(id),
                    off,
                    least,
                    terms,
                    sizes,
                    between: String::new(),
                });
            };
            let ([x0, x1], [v0, v1]) = (
                [was, now].map(|of| places(of, id)),
                [was, now].map(|of| velocity(of, id)),
            );
            if rules.integration == Integration::KickDrift {
                let gone = times(1.0 / dt, minus(x1, x0));
                let least =
                    ROUNDED * hypot(v1).max(hypot(gone)) + 4.0 * f64::EPSILON * hypot(x1) / dt;
                add(
                    PLACES,
                    minus(gone, v1),
                    least,
                    terms! {
                        "Δt·v after the kick", 1.0 => v1;
                        "the kick of this step in Δt·v", 1.0 => minus(v1, v0);
                        "Δt·v before the kick", 0.0 => v0;
                    },
                );
            }
            // The acceleration before local damping, from the change after it: of both signs the one that it follows from.
            let undamped = |change: Vector, before: Vector, is_damped: bool| {
                each([0, 1, 2], |axis| {
                    let a = change[axis] / dt;
                    let of = |sign: f64| a / (1.0 - model.alpha * sign);
                    let follows =
                        |sign: &f64| sign * of(*sign) * (before[axis] + 0.5 * dt * of(*sign)) > 0.0;
                    // Where both do, nothing is known.
                    match [1.0, -1.0].map(|sign| follows(&sign)) {
                        _ if !is_damped || model.alpha == 0.0 => (a, 0.0),
                        [true, true] => (f64::NAN, 0.0),
                        [true, false] => (of(1.0), 1.0),
                        [false, true] => (of(-1.0), -1.0),
                        [false, false] => (a, 0.0),
                    }
                })
            };
            let damping = |acting: Vector, signs: Vector, axes: &[usize]| {
                each([0, 1, 2], |axis| {
                    let share = model.alpha * signs[axis];
                    acting[axis] * share / (1.0 - share) * f64::from(u8::from(axes.contains(&axis)))
                })
            };
            let weight = times(mass, [model.gravity[0], 0.0, model.gravity[1]]);
            let of_kind =
                |kind: usize| plus(load.kinds[kind].forces[0], load.kinds[kind].forces[1]);
            let forces = load.force();
            let acting = plus(forces, weight);
            let a = undamped(minus(v1, v0), v0, true);
            let (gained, signs) = (times(mass, a.map(|a| a.0)), a.map(|a| a.1));
            let largest = load
                .kinds
                .iter()
                .flat_map(|kind| kind.forces)
                .map(hypot)
                .fold(hypot(weight), f64::max);
            let least =
                ROUNDED * largest + 4.0 * f64::EPSILON * mass * hypot(v1).max(hypot(v0)) / dt;
            let terms: Vec<Term> = terms! {
                "all contact forces", 1.0 => forces;
                "the weight", 1.0 => weight;
                "normal forces", 1.0 => sum(&mut load.kinds.iter().map(|kind| kind.forces[0]));
                "tangential forces", 1.0 => sum(&mut load.kinds.iter().map(|kind| kind.forces[1]));
                "forces on the first of a pair", 1.0 => of_kind(0);
                "forces on the second of a pair", 1.0 => of_kind(1);
                "forces of walls", 1.0 => of_kind(2);
                "forces of the punch", 1.0 => of_kind(3);
                "tangential forces of walls", 1.0 => load.kinds[2].forces[1];
                "tangential forces of the punch", 1.0 => load.kinds[3].forces[1];
                "tangential forces on the first of a pair", 1.0 => load.kinds[0].forces[1];
                "tangential forces on the second of a pair", 1.0 => load.kinds[1].forces[1];
                "the normal dashpots' forces", 1.0 => load.dashpots[0];
                "the tangential dashpots' forces", 1.0 => load.dashpots[1];
                "local damping", -1.0 => damping(acting, signs, &[0, 1, 2]);
                "local damping along x", -1.0 => damping(acting, signs, &[0]);
                "local damping along y", -1.0 => damping(acting, signs, &[1]);
                "local damping along z", -1.0 => damping(acting, signs, &[2]);
                "contact forces of the step before", 0.0 => before.map_or(NONE, |before| before[id].force());
                "m·v/Δt", 0.0 => times(mass / dt, v0);
            };
            if gained.iter().all(|of| of.is_finite()) {
                add(VELOCITIES, minus(gained, acting), least, terms);
            }
            // What moments remember is not written.
            if !model.law.rotates() || rolls && was.step > 0 {
                continue;
            }
            let ([w0, w1], inertia) = ([was, now].map(|of| spin(of, id)), bodies.inertia[id]);
            let is_damped = rules.damped_spins == DampedSpins::Damped;
            let torque = plus(load.torque(), plus(load.moments[0], load.moments[1]));
            let a = undamped(minus(w1, w0), w0, is_damped);
            let (gained, signs) = (times(inertia, a.map(|a| a.0)), a.map(|a| a.1));
            let largest = load
                .kinds
                .iter()
                .map(|kind| hypot(kind.torque))
                .chain(load.moments.map(hypot));
            let least = ROUNDED * largest.fold(radius * 1.0e-6 * hypot(weight), f64::max)
                + 4.0 * f64::EPSILON * inertia * hypot(w1).max(hypot(w0)) / dt;
            let of_kind = |kind: usize| load.kinds[kind].torque;
            let terms: Vec<Term> = terms! {
                "all torques of forces", 1.0 => load.torque();
                "moments against rolling", 1.0 => load.moments[0];
                "moments against twisting", 1.0 => load.moments[1];
                "torques on the first of a pair", 1.0 => of_kind(0);
                "torques on the second of a pair", 1.0 => of_kind(1);
                "torques at walls", 1.0 => of_kind(2);
                "torques at the punch", 1.0 => of_kind(3);
                "the tangential dashpots' torques", 1.0 => load.braking;
                "the tangential force times u/2, of grains,", 0.0 => load.half[0];
                "the tangential force times u/2, at walls,", 0.0 => load.half[1];
                "the tangential force times u/2, at the punch,", 0.0 => load.half[2];
                "the torques of what Coulomb's limit cuts", 0.0 => load.cut;
                "torques of the step before", 0.0 => before.map_or(NONE, |before| before[id].torque());
                "what the other grain's arm gives it more than its own", 0.0 => load.others[0];
                "what the first one's arm gives the second more than its own", 0.0 => load.others[1];
                "R·(normal force) against the spin", 0.0 => load.rolling;
                "local damping of spins", -1.0 => damping(torque, signs, &[0, 1, 2]);
                "I·ω/Δt", 0.0 => times(inertia / dt, w0);
            };
            if gained.iter().all(|of| of.is_finite()) {
                add(SPINS, minus(gained, torque), least, terms);
            }
        }
    }
}

/// Whether a force was cut to this limit, which is told with what the spring has along the normal after so much turning.
fn is_at(force: f64, limit: f64, turned: f64) -> bool {
    (force - limit).abs() <= (AT_LIMIT + LOOSE * turned) * limit
}

/// What the dashpot along the tangent has of a force that is told.
fn told_braking(
    parts: &Parts,
    (tangential, turned): (Vector, f64),
    rule: TangentialDashpot,
) -> Vector {
    match rule {
        TangentialDashpot::None => NONE,
        TangentialDashpot::WhileSticking if is_at(hypot(tangential), parts.limit, turned) => NONE,
        _ => parts.brakings.iter().fold(NONE, |sum, of| plus(sum, *of)),
    }
}

impl Row {
    fn ratio(&self) -> f64 {
        hypot(self.off) / self.least
    }

    fn is_off(&self) -> bool {
        self.ratio() > 1.0 || self.ratio().is_nan()
    }

    /// What is left of it with so much more of some terms.
    fn left(&self, more: &[(usize, f64)]) -> f64 {
        let left = more.iter().fold(self.off, |left, (term, more)| {
            minus(left, times(*more, self.terms[*term].2))
        });
        hypot(left) / self.least
    }
}

/// What explains all rows of a kind, or all that are off, and which those are.
fn explained(rows: &[Row], runs: &[(&Case, &[Snapshot])]) -> Option<(String, String)> {
    let none = rows
        .iter()
        .filter(|row| !row.off.iter().all(|part| part.is_finite()))
        .count();
    if none > 0 {
        return Some((
            format!("{none} of {} are no numbers", rows.len()),
            String::new(),
        ));
    }
    let off: Vec<&Row> = rows.iter().filter(|row| row.is_off()).collect();
    let plainly = off.iter().filter(|row| row.ratio() > 30.0).count();
    if plainly == 0 || !off.iter().any(|row| row.ratio() > PLAIN) {
        return None;
    }
    let right = rows.iter().filter(|row| !row.is_off());
    let some = |rows: &[&Row]| -> usize { rows.len().div_ceil(MOST_ROWS).max(1) };
    let right: Vec<&Row> = right.collect();
    let both: Vec<&Row> = off
        .iter()
        .step_by(some(&off))
        .chain(right.iter().step_by(some(&right)))
        .copied()
        .collect();
    let all: Vec<&Row> = rows.iter().collect();
    let said = of_terms(&both, &all, plainly);
    if said.is_some() || right.is_empty() {
        return said.map(|said| (said, String::new()));
    }
    let some: Vec<&Row> = off.iter().step_by(some(&off)).copied().collect();
    let said = of_terms(&some, &off, plainly)?;
    Some((said, format!(" ({})", place(rows, &off, runs))))
}

/// Multiples that a formula has before all others, and after them factors that hang on sizes.
fn of_terms(some: &[&Row], all: &[&Row], plainly: usize) -> Option<String> {
    let plain = search(some, all, plainly, true);
    let by_sizes = || factor(some, all, plainly);
    let any = || search(some, all, plainly, false);
    plain.or_else(by_sizes).or_else(any)
}

/// The fewest terms of which another multiple explains all rows.
fn search(some: &[&Row], all: &[&Row], plainly: usize, only_plain: bool) -> Option<String> {
    let count = some[0].terms.len();
    let most = |term: usize| {
        some.iter()
            .map(|row| hypot(row.terms[term].2) / row.least)
            .fold(0.0, f64::max)
    };
    let live: Vec<usize> = (0..count).filter(|term| most(*term) > 1.0).collect();
    let column = |of: &dyn Fn(&Row) -> Vector| {
        let values = some
            .iter()
            .flat_map(|row| of(row).map(|part| part / row.least));
        DVector::from_iterator(3 * some.len(), values)
    };
    let off = column(&|row| row.off);
    let columns: Vec<DVector<f64>> = live
        .iter()
        .map(|term| column(&|row| row.terms[*term].2))
        .collect();
    let gram = DMatrix::from_fn(live.len(), live.len(), |a, b| columns[a].dot(&columns[b]));
    let onto = DVector::from_fn(live.len(), |a, _| columns[a].dot(&off));
    for size in 1..=MOST_TERMS.min(plainly) {
        let mut sets: Vec<(f64, Vec<usize>)> = subsets(live.len(), size)
            .into_iter()
            .filter_map(|set| {
                let part = DMatrix::from_fn(size, size, |a, b| gram[(set[a], set[b])]);
                let of = DVector::from_fn(size, |a, _| onto[set[a]]);
                let found = part.cholesky()?.solve(&of);
                Some((-found.dot(&of), set))
            })
            .collect();
        sets.sort_by(|a, b| a.0.total_cmp(&b.0));
        let fitted = sets.into_iter().take(TRIED).filter_map(|(_, set)| {
            let matrix = DMatrix::from_columns(
                &set.iter()
                    .map(|at| columns[*at].clone())
                    .collect::<Vec<_>>(),
            );
            let found = matrix.svd(true, true).solve(&off, 1.0e-13).ok()?;
            let more: Vec<(usize, f64)> = set
                .iter()
                .map(|at| live[*at])
                .zip(found.iter().copied())
                .collect();
            all.iter().all(|row| row.left(&more) <= 5.0).then_some(more)
        });
        let mut fitted: Vec<Vec<(usize, f64)>> = fitted.collect();
        let ugly = |more: &Vec<(usize, f64)>| {
            more.iter()
                .filter(|(term, more)| !is_plain(some[0].terms[*term].1 + more))
                .count()
        };
        // As many free numbers as rows explain anything.
        fitted
            .retain(|more| plainly > 5 * size && !only_plain || plainly > size && ugly(more) == 0);
        fitted.sort_by_key(|more| {
            (
                ugly(more),
                more.iter().map(|(term, _)| *term).sum::<usize>(),
            )
        });
        if let Some(more) = fitted.first() {
            let rounded = more.iter().map(|(term, more)| {
                let usual = some[0].terms[*term].1;
                let error = (4.0 / most(*term)).clamp(1.0e-6, 1.0e-2);
                let now = usual + more;
                let near = (2.0 * now).round() / 2.0;
                (
                    *term,
                    if (now - near).abs() <= error {
                        near - usual
                    } else {
                        *more
                    },
                )
            });
            let rounded: Vec<(usize, f64)> = rounded.filter(|(_, more)| *more != 0.0).collect();
            return Some(in_words(&some[0].terms, &rounded));
        }
    }
    None
}

fn subsets(of: usize, size: usize) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new()];
    for _ in 0..size {
        let longer = all.iter().flat_map(|set: &Vec<usize>| {
            let from = set.last().map_or(0, |last| last + 1);
            (from..of).map(move |next| [&set[..], &[next]].concat())
        });
        all = longer.collect();
    }
    all
}

/// Whether a factor is one that a formula has: halves, and roots of two.
fn is_plain(factor: f64) -> bool {
    let near = |multiple: f64| (multiple - multiple.round()).abs() < 1.0e-6;
    near(2.0 * factor) || near(factor.abs() * std::f64::consts::SQRT_2)
}

fn in_words(terms: &[Term], more: &[(usize, f64)]) -> String {
    let close = |a: f64, b: f64| (a - b).abs() < 1.0e-6;
    let gone = |of: &&(usize, f64)| terms[of.0].1 != 0.0 && close(of.1, -terms[of.0].1);
    let new = |of: &&(usize, f64)| terms[of.0].1 == 0.0 && close(of.1, 1.0);
    if let (2, Some(gone), Some(new)) = (more.len(), more.iter().find(gone), more.iter().find(new))
    {
        return format!(
            "with {} in the place of {}",
            terms[new.0].0, terms[gone.0].0
        );
    }
    let said = more.iter().map(|(term, more)| {
        let (name, usual, _) = terms[*term];
        let now = usual + more;
        match usual {
            _ if close(now, 0.0) => format!("without {name}"),
            0.0 if close(now, 1.0) => format!("with {name} besides"),
            0.0 => format!("with {} × {name} besides", number(now)),
            _ if close(now, -usual) => format!("with {name} of the other sign"),
            _ => format!("with {name} × {}", number(now / usual)),
        }
    });
    said.collect::<Vec<_>>().join(", and ")
}

fn number(value: f64) -> String {
    let short = format!("{value:.6}");
    match short.contains('.') && value.abs() >= 1.0e-3 {
        true => short.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => format!("{value:.6e}"),
    }
}

/// One term whose factor goes by powers of sizes, or hangs on what touches.
fn factor(some: &[&Row], all: &[&Row], plainly: usize) -> Option<String> {
    if plainly < 6 {
        return None;
    }
    let count = some[0].terms.len();
    (0..count).find_map(|term| {
        let (name, usual, _) = some[0].terms[term];
        // A row without the term says nothing of its factor, and must be right.
        let of = |row: &Row| -> Option<f64> {
            let value = row.terms[term].2;
            let more = dot(row.off, value) / dot(value, value);
            (row.left(&[(term, more)]) <= 2.0).then_some(usual + more)
        };
        let has = |row: &&&Row| hypot(row.terms[term].2) > row.least;
        let clear = |row: &&&Row| hypot(row.terms[term].2) > 1.0e3 * row.least;
        let without = all.iter().filter(|row| !has(row)).any(|row| row.is_off());
        if without || !all.iter().filter(has).all(|row| of(row).is_some()) {
            return None;
        }
        let rows: Vec<&&Row> = some.iter().filter(clear).collect();
        let factors: Vec<f64> = rows.iter().filter_map(|row| of(row)).collect();
        let (low, high) = factors
            .iter()
            .fold((f64::MAX, f64::MIN), |(low, high), of| {
                (low.min(*of), high.max(*of))
            });
        if rows.len() < 6 || high - low <= 1.0e-6 * high.abs().max(usual) {
            return None;
        }
        by_powers(name, &rows, &factors, term).or_else(|| by_groups(name, &rows, &factors))
    })
}

fn by_powers(name: &str, rows: &[&&Row], factors: &[f64], term: usize) -> Option<String> {
    if factors.iter().any(|factor| *factor <= 0.0) {
        return None;
    }
    let sizes = &rows[0].sizes;
    let logarithm = |row: &Row, size: usize| row.sizes[size].1.ln();
    // What adhesion holds has an overlap below 0.
    let has_power = |size: &usize| rows.iter().all(|row| logarithm(row, *size).is_finite());
    let sets = (1..=2).flat_map(|count| subsets(sizes.len(), count));
    let sets = sets.filter(|set| set.iter().all(has_power));
    let found = sets.filter_map(|set| {
        let matrix = DMatrix::from_fn(rows.len(), set.len() + 1, |row, column| match column {
            0 => 1.0,
            _ => logarithm(rows[row], set[column - 1]),
        });
        let logarithms =
            DVector::from_iterator(factors.len(), factors.iter().map(|factor| factor.ln()));
        let found = matrix.svd(true, true).solve(&logarithms, 1.0e-13).ok()?;
        let powers: Vec<f64> = found
            .iter()
            .skip(1)
            .map(|power| (6.0 * power).round() / 6.0)
            .collect();
        if powers.contains(&0.0) || powers.iter().any(|power| power.abs() > 3.0) {
            return None;
        }
        let sum = |row: &Row| {
            set.iter()
                .zip(&powers)
                .map(|(size, power)| power * logarithm(row, *size))
                .sum::<f64>()
        };
        let constants: Vec<f64> = rows
            .iter()
            .zip(factors)
            .map(|(row, factor)| factor.ln() - sum(row))
            .collect();
        let constant = constants.iter().sum::<f64>() / constants.len() as f64;
        let fits = rows.iter().zip(factors).all(|(row, factor)| {
            let off = (constant + sum(row)).exp() - factor;
            off.abs() * hypot(row.terms[term].2)
                <= 3.0 * row.least + 1.0e-8 * factor.abs() * hypot(row.terms[term].2)
        });
        fits.then(|| {
            let power = |(size, power): (&usize, &f64)| match *power {
                1.0 => sizes[*size].0.to_owned(),
                0.5 => format!("√{}", sizes[*size].0),
                power => format!("{}^{}", sizes[*size].0, number(power)),
            };
            let by: Vec<String> = set.iter().zip(&powers).map(power).collect();
            let (by, of) = (by.join(" × "), constant.exp());
            match (of - 1.0).abs() < 1.0e-6 {
                true => (0, format!("with {name} × {by} (SI)")),
                false => (1, format!("with {name} × {} × {by} (SI)", number(of))),
            }
        })
    });
    // Two powers and a number besides fit too much.
    let found = found.filter(|(own, said)| *own == 0 || said.matches(" × ").count() < 3);
    // A formula has no number of its own, if there is such a one.
    found.min_by_key(|found| found.0).map(|found| found.1)
}

fn by_groups(name: &str, rows: &[&&Row], factors: &[f64]) -> Option<String> {
    let mut groups: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for (row, factor) in rows.iter().zip(factors) {
        groups.entry(&row.between).or_default().push(*factor);
    }
    let same = |of: &Vec<f64>| {
        of.iter()
            .all(|factor| (factor - of[0]).abs() <= 1.0e-6 * of[0].abs().max(1.0e-3))
    };
    let told = groups.len() > 1 && groups.len() <= 9 && groups.values().all(same);
    told.then(|| {
        let other = groups.iter().filter(|(_, of)| (of[0] - 1.0).abs() > 1.0e-6);
        let said: Vec<String> = other
            .map(|(between, of)| format!("{} between {between}", number(of[0])))
            .collect();
        format!("with {name} × {}", said.join(", by "))
    })
}

/// Where rows are off: what all of them have at the moment that has most, or which they are.
fn place(rows: &[Row], off: &[&Row], runs: &[(&Case, &[Snapshot])]) -> String {
    let mut few: Vec<String> = Vec::new();
    for row in off {
        let name = match row.of {
            Of::Contact(one, two) => format!("{one}–{two}"),
            Of::Grain(id) => format!("grain {id}"),
        };
        if !few.contains(&name) {
            few.push(name);
        }
        if few.len() > FEW {
            break;
        }
    }
    if few.len() <= FEW {
        return format!("{} alone", few.join(", "));
    }
    let mut moments: BTreeMap<(usize, usize), (usize, usize)> = BTreeMap::new();
    for row in rows {
        let of = moments.entry(row.at).or_default();
        of.0 += 1;
        of.1 += usize::from(row.is_off());
    }
    let whole = moments
        .values()
        .filter(|(_, off)| *off > 0)
        .all(|(all, off)| all == off);
    if whole {
        let steps = moments.iter().filter(|(_, of)| of.1 > 0);
        let steps: BTreeSet<usize> = steps.map(|(at, _)| at.1).collect();
        let steps: Vec<String> = steps.iter().map(usize::to_string).collect();
        let more = if steps.len() > 6 { ", …" } else { "" };
        return format!(
            "in step {}{more} alone, and in all of them there",
            steps[..steps.len().min(6)].join(", ")
        );
    }
    let (run, at) = moments
        .iter()
        .max_by_key(|(_, of)| of.1)
        .map_or((0, 0), |(at, _)| *at);
    let here: Vec<&&Row> = off.iter().filter(|row| row.at == (run, at)).collect();
    let (case, moments) = runs[run];
    let contacts: Vec<(u32, u32)> = here
        .iter()
        .filter_map(|row| match row.of {
            Of::Contact(one, two) => Some((one, two)),
            Of::Grain(_) => None,
        })
        .collect();
    let grains: Vec<usize> = here
        .iter()
        .filter_map(|row| match row.of {
            Of::Grain(id) => Some(id),
            Of::Contact(..) => None,
        })
        .collect();
    let before = at.checked_sub(1).map(|before| &moments[before]);
    let all: Vec<Of> = rows
        .iter()
        .filter(|row| row.at == (run, at))
        .map(|row| row.of)
        .collect();
    let condition = match contacts.is_empty() {
        true => {
            let among = |id: usize| all.contains(&Of::Grain(id));
            conditions::of_grains(case, &moments[at.saturating_sub(1)], &grains, &among)
        }
        false => {
            let among = |ids: (u32, u32)| all.contains(&Of::Contact(ids.0, ids.1));
            conditions::of_contacts(case, before, &moments[at], &contacts, &among)
        }
    };
    condition.unwrap_or_else(|| format!("{} of {}", off.len(), rows.len()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::starts::{Bed, DISPERSION, State};
    use grains::rules::Choice;
    use grains::variant::{Form, Variant};

    fn states() -> Vec<State> {
        let bed = Bed::new(100, DISPERSION).expect("a bed");
        let in_space = crate::spheres::reference().expect("a bed");
        bed.states()
            .iter()
            .chain(in_space.states())
            .cloned()
            .collect()
    }

    fn run(state: &State, variant: &Variant) -> (Case, Vec<Snapshot>) {
        let moments = (0..=8).collect();
        let case = Case {
            moments,
            ..state.case.clone()
        };
        let run = grains::variant::run(&case, variant);
        (case, run)
    }

    /// What the native engine writes follows from the rest, whatever the law is, but for what springs have along the normal.
    #[test]
    fn nothing_is_left_of_a_right_engine() {
        for state in states() {
            let (case, run) = run(&state, &Variant::default());
            let mut rows = Rows::new();
            Follower::new(&case, 0).follow(&run, &mut rows);
            assert!(!rows.is_empty(), "{}", case.name);
            for ((quantity, kind), rows) in rows {
                let off = rows.iter().filter(|row| row.is_off()).count();
                let (name, kind) = (QUANTITIES[quantity], KINDS[kind]);
                assert!(
                    20 * off <= rows.len().max(20),
                    "{}: {name} {kind}: {off} of {}",
                    case.name,
                    rows.len()
                );
            }
            assert_eq!(found(&[(&case, &run)], true), [""; 0], "{}", case.name);
        }
    }

    #[test]
    fn a_term_that_is_another_one_is_told() {
        let drift = Choice::of("integration", "drift_kick").expect("a rule");
        let faults = [
            (
                Form::HistoryReset,
                "contacts that stick between grains and at walls",
                "without the spring's force of the step before",
            ),
            (
                Form::SlipOfCentres,
                "contacts that stick",
                "without k_s·Δt·slip of the spins",
            ),
            (Form::TorqueSign, "spins", "of the other sign"),
            (
                Form::OneSided(1),
                "velocities",
                "without forces on the first of a pair",
            ),
            (
                Form::Rule(drift),
                "places",
                "without the kick of this step in Δt·v",
            ),
        ];
        let states = states();
        for law in ["friction", "linear springs and friction in space"] {
            let of_law: Vec<&State> = states.iter().filter(|state| state.law == law).collect();
            for (form, what, words) in faults {
                let runs = of_law.iter().map(|state| run(state, &Variant::of(form)));
                let runs: Vec<(Case, Vec<Snapshot>)> = runs.collect();
                let runs: Vec<(&Case, &[Snapshot])> =
                    runs.iter().map(|(case, run)| (case, &run[..])).collect();
                let told = found(&runs, true).join("; ");
                assert!(
                    told.contains(what) && told.contains(words),
                    "{law}: {form:?}: {told}"
                );
            }
        }
    }
}
