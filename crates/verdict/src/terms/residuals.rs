//! What is left over of each force that an engine writes, when the model makes it of the other numbers that the engine has written.

use std::collections::BTreeMap;

use grains::reference::{Made, Parts, Reference, Told};
use grains::rules::{Rules, SpringWhenSliding, TangentialDashpot, WrittenVelocities};
use grains::tables::{Body, Contact, Snapshot};
use grains::task::Case;
use grains::vector::{Vector, cross, dot, hypot, minus, plus, sum, times};

use super::elsewhere::{Around, Kept};
use super::seen::{Held, Seen};
use super::*;
use crate::contacts::Table;

/// Contacts stick or slide for certain below and above these shares of Coulomb's limit.
const STICKS: f64 = 0.5;
const SLIDES: f64 = 1.05;
/// A spring that is turned to the first order leaves the tangent by so many times the squared angles at most.
const LOOSE: f64 = 40.0;
/// So much of Coulomb's limit tells that a force has been cut to it.
const AT_LIMIT: f64 = 1.0e-6;

/// Goes along a run.
pub(super) struct Follower<'a> {
    pub(super) case: &'a Case,
    pub(super) run: usize,
    /// What each contact had at the moment before, and by how much its normal has turned so far, squared, rad².
    before: BTreeMap<(u32, u32), Before>,
    /// The same of contacts that have ended.
    ended: BTreeMap<(u32, u32), Before>,
    /// Moments have a history that is not written.
    pub(super) forgets_moments: bool,
    /// How far the velocity and the spin of each grain were off in the step before.
    pub(super) was_off: BTreeMap<(usize, usize), Vector>,
    /// What is not a sum of terms.
    pub(super) seen: Seen,
    /// Whether things from elsewhere are looked at, and what contacts were made of at the moment before.
    looks_elsewhere: bool,
    made_before: BTreeMap<(u32, u32), Made>,
    pub(super) kept: Kept,
}

struct Before {
    parts: Parts,
    overlap: f64,
    normal: Vector,
    normal_force: f64,
    tangential: Vector,
    turned: f64,
    /// By which it was made.
    rules: Rules,
    /// Whether its moment against rolling has ever been near its limit.
    has_rolled: bool,
    marks: Marks,
    /// k_s and c_n when it began.
    first: [f64; 2],
}

/// What a contact had a step ago and whether it was cut, and what a spring has that outlives its contact, turned with it and as it was.
type Past<'a> = (Option<(&'a Before, (Told, bool))>, [Vector; 2]);

/// Forces and torques on a grain of one kind.
#[derive(Clone, Copy, Default)]
pub(super) struct Load {
    /// By the normal and by the tangential force.
    pub(super) forces: [Vector; 2],
    pub(super) torque: Vector,
}

/// What acts on a grain: as the first and as the second of a pair, at walls, at the punch.
#[derive(Clone, Default)]
pub(super) struct Loads {
    pub(super) kinds: [Load; 4],
    pub(super) dashpots: [Vector; 2],
    /// Torques of the dashpots along the tangent, of what half of the overlap is of the arms, of the other grain's torque in the place of its own.
    pub(super) braking: Vector,
    pub(super) half: [Vector; 3],
    /// Torques of what Coulomb's limit has cut, and of the forces of the step before by this step's arms.
    pub(super) cut: Vector,
    pub(super) late: Vector,
    pub(super) others: [Vector; 2],
    /// Moments against rolling and twisting, of them those on the first of a pair and at walls; what this step adds to them, and against
    /// rolling those at their limit, as they were without one and where it holds for each component alone.
    pub(super) moments: [Vector; 2],
    pub(super) moments_on_first: [Vector; 2],
    pub(super) moments_at_walls: [Vector; 2],
    pub(super) added: [Vector; 2],
    pub(super) limited: Vector,
    /// Whether one of them has ever been near its limit, and whether one was beyond it before this step.
    pub(super) near_limit: bool,
    pub(super) was_beyond_limit: bool,
    pub(super) without_limit: Vector,
    pub(super) by_component: Vector,
    /// Against rolling by the spin of the first and of the second alone, and by the twist.
    pub(super) rolling_alone: [Vector; 2],
    pub(super) twist_as_rolling: Vector,
    /// What is kept of moments against rolling and twisting, and what would be were either taken for the other.
    pub(super) kept: [Vector; 2],
    pub(super) exchanged: [Vector; 2],
    /// What its contacts are, and the forces and torques of those that are so.
    pub(super) marks: Marks,
    pub(super) marked: [[Vector; 2]; MARKS.len()],
    /// The normal forces times the radius, against the spin.
    pub(super) rolling: Vector,
    /// By how much the force and the torque would be others with each thing from elsewhere.
    pub(super) elsewhere: [Vec<Vector>; 2],
}

impl Loads {
    pub(super) fn force(&self) -> Vector {
        sum(self.kinds.iter().flat_map(|kind| kind.forces))
    }

    pub(super) fn torque(&self) -> Vector {
        sum(self.kinds.map(|kind| kind.torque))
    }
}

impl<'a> Follower<'a> {
    pub(super) fn new(case: &'a Case, run: usize, looks_elsewhere: bool) -> Self {
        Follower {
            case,
            run,
            before: BTreeMap::new(),
            ended: BTreeMap::new(),
            was_off: BTreeMap::new(),
            forgets_moments: false,
            seen: Seen::default(),
            looks_elsewhere,
            made_before: BTreeMap::new(),
            kept: Kept::default(),
        }
    }

    /// Contacts of the first moment have a history where it was made under another law: they are no more than what others follow from.
    pub(super) fn follow(
        &mut self,
        moments: &[Snapshot],
        made_under: Option<&'a Case>,
        rows: &mut Rows,
    ) {
        let rules = self.case.model.law.resolved(self.case.model.rules);
        if rules.written_velocities != WrittenVelocities::HalfStep {
            return;
        }
        let rolling = self.case.model.law.contact.rolling;
        let remembers = rolling.is_some_and(|rolling| {
            rolling.bending_stiffness.is_some() || rolling.twisting_stiffness > 0.0
        });
        self.forgets_moments = made_under.is_some() && remembers;
        let mut past: Option<(&Snapshot, Vec<Loads>)> = None;
        let mut before: Option<Vec<Loads>> = None;
        for (at, now) in moments.iter().enumerate() {
            let mut now_bodies = now.bodies.clone();
            let given = &self.case.bodies;
            now_bodies.radius.clone_from(&given.radius);
            now_bodies.mass.clone_from(&given.mass);
            now_bodies.inertia.clone_from(&given.inertia);
            now_bodies.material.clone_from(&given.material);
            if let Some((was, loads)) = past.as_ref().filter(|_| at > 1 || made_under.is_none()) {
                self.motion((*was, now), (loads, before.as_deref()), at, rows);
            }
            before = past.take().map(|(_, loads)| loads);
            let mut model = self.case.model.clone();
            let dt = model.dt;
            for obstacle in &mut model.obstacles {
                *obstacle = obstacle.after(now.step, dt);
            }
            let reference = Reference::holding(&model, &now_bodies, now.punch, &now.contacts);
            if let Some(was) = at.checked_sub(1).filter(|_| model.law.holds()) {
                let was = &moments[was];
                let held = Reference::holding(&model, &now_bodies, now.punch, &was.contacts);
                let (held, _) = held.contacts_with_across();
                let there: BTreeMap<_, _> = now
                    .contacts
                    .iter()
                    .map(|one| (one.ids(), one.overlap))
                    .collect();
                let to_be: BTreeMap<_, _> =
                    held.iter().map(|one| (one.ids(), one.overlap)).collect();
                let all = to_be
                    .iter()
                    .chain(there.iter().filter(|(ids, _)| !to_be.contains_key(*ids)));
                let all = all.filter(|(_, overlap)| **overlap < 0.0);
                self.seen.held.extend(all.map(|(ids, overlap)| Held {
                    share: overlap / reference.lets_go_at(*ids),
                    is_there: there.contains_key(ids),
                    radii: {
                        let second = given.radius[ids.1 as usize];
                        [
                            given.radius.get(ids.0 as usize).copied().unwrap_or(second),
                            second,
                        ]
                    },
                }));
            }
            let mut loads = self.contacts(&reference, now, at, rows);
            if let (0, Some(before)) = (at, made_under) {
                rows.clear();
                (self.before, self.seen) = Default::default();
                let case = std::mem::replace(&mut self.case, before);
                let reference =
                    Reference::holding(&before.model, &now_bodies, now.punch, &now.contacts);
                loads = self.contacts(&reference, now, at, &mut Rows::new());
                self.case = case;
            }
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
        let (case, run) = (self.case, self.run);
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
        let (mut after, mut slid) = (BTreeMap::new(), Vec::new());
        let mut walls_before: BTreeMap<u32, u32> = BTreeMap::new();
        let past = std::mem::take(&mut self.before);
        for (first, second) in past.keys() {
            *walls_before.entry(*second).or_default() += u32::from(case.wall(*first).is_some());
        }
        // What a number that is kept for a list of contacts, and not for each, may be of.
        let (mut made_now, mut in_slots) = (Vec::new(), Vec::new());
        let past_ids: Vec<(u32, u32)> = past.keys().copied().collect();
        let (mut first_of_body, mut last) = ((u32::MAX, 0.0), None);
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
            let was = past.get(&ids);
            let told_of = |was: &Before| {
                // A force that is at its limit had no dashpot added.
                let limit = was.parts.limit;
                let cut = limit == 0.0 || is_at(hypot(was.tangential), limit, was.turned);
                let acts = match was.rules.tangential_dashpot {
                    TangentialDashpot::None => false,
                    TangentialDashpot::WhileSticking => !cut,
                    _ => true,
                };
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
                    k_s: was.parts.k_s,
                    tangential: plus(was.tangential, along),
                    force: plus(times(was.normal_force, was.normal), was.tangential),
                    braking: sum(was.parts.brakings),
                    brakes: acts,
                    slip: sum(was.parts.slips),
                    moments: was.parts.moments,
                    without_limit: was.parts.without_limit,
                    by_component: was.parts.by_component,
                };
                (told, cut)
            };
            let told = was.map(told_of);
            if self.looks_elsewhere {
                let told = |told: Option<Told>| reference.made_of(ids, (fn_told, tangential), told);
                if let Some(made) = told(was.map(|was| told_of(was).0)) {
                    // The places of the contact in the table and among those of its first body.
                    let place = made_now.len();
                    let of_first = |other: &&(u32, u32)| other.0 == ids.0;
                    let among = made_now
                        .iter()
                        .rev()
                        .take_while(|made: &&Made| made.ids().0 == ids.0);
                    let among = among.count();
                    let slots = [
                        past_ids.get(place),
                        past_ids.iter().filter(of_first).nth(among),
                    ];
                    in_slots.push(slots.map(|other| told(Some(told_of(&past[other?]).0))));
                    made_now.push(made);
                }
            }
            let Some(parts) = reference.parts(ids, (fn_told, tangential), told.map(|told| told.0))
            else {
                continue;
            };
            // What a spring has that outlives its contact: turned with it, and as it was.
            let outlived = self.ended.get(&ids).filter(|_| was.is_none());
            let outlived = outlived.and_then(|ended| {
                let (told, _) = told_of(ended);
                let again = |told| reference.parts(ids, (fn_told, tangential), Some(told));
                let (turned, as_it_was) = (again(told)?, again(Told { normal, ..told })?);
                Some(
                    [turned, as_it_was]
                        .map(|parts| plus(parts.kept, plus(parts.turns[0], parts.turns[1]))),
                )
            });
            let turn = was.map_or(0.0, |was| hypot(cross(was.normal, normal)).powi(2));
            let turned = was.map_or(0.0, |was| was.turned) + turn;
            let size = [parts.elastic, parts.viscous, parts.pull, fn_told]
                .map(f64::abs)
                .into_iter()
                .fold(0.0, f64::max);
            let before = was.map_or(0.0, |was| was.parts.limit.max(hypot(was.tangential)));
            let bodies = [ids.0, ids.1].map(|id| id as usize);
            let bodies = bodies.into_iter().filter(|id| *id < case.bodies.len());
            let speeds = bodies.map(|id| {
                let spin = now.bodies.angular_velocity(id);
                hypot(now.bodies.velocity(id)) + case.bodies.radius[id] * hypot(spin)
            });
            // Velocities of two are nearly one where they hardly slip.
            let rounded = 4.0 * f64::EPSILON * speeds.sum::<f64>();
            let loose = LOOSE * turned * hypot(tangential).max(parts.limit).max(before)
                + rounded * (parts.k_s * dt + parts.c_s.max(parts.c_n));
            let kind = parts.first as usize;
            let [r1, r2] = parts.radii;
            let m2 = case.bodies.mass[ids.1 as usize];
            let m1 = case.bodies.mass.get(ids.0 as usize).copied().unwrap_or(m2);
            let both = r1 * r2 / (r1 + r2);
            if first_of_body.0 != ids.0 {
                first_of_body = (ids.0, both);
            }
            let sizes = vec![
                ("u", u),
                ("R₁", r1),
                ("R₂", r2),
                ("(R₁ + R₂)", r1 + r2),
                ("R₁R₂/(R₁ + R₂)", both),
                (
                    "R₁R₂/(R₁ + R₂) of the first contact of the same body 1 in the table",
                    first_of_body.1,
                ),
                (
                    "R₁R₂/(R₁ + R₂) of the contact before in the table",
                    last.replace(both).unwrap_or(both),
                ),
                ("min(R₁, R₂)", r1.min(r2)),
                ("max(R₁, R₂)", r1.max(r2)),
                ("m₁m₂/(m₁ + m₂)", m1 * m2 / (m1 + m2)),
                ("m₁", m1),
                ("m₂", m2),
                ("(m₁ + m₂)", m1 + m2),
                ("(R₁ + R₂ − u)", r1 + r2 - u),
                ("(R₂ − u)", r2 - u),
                ("(R₂ − u/2)", r2 - 0.5 * u),
                ("max(m₁, m₂)", m1.max(m2)),
                ("u of the step before", was.map_or(u, |was| was.overlap)),
                ("|k_s·Δt·slip|", hypot(sum(parts.slips))),
                (
                    "the speed of slip",
                    hypot(sum(parts.slips)) / (parts.k_s * dt),
                ),
                ("the speed along the normal", (parts.way / dt).abs()),
                ("F_s", parts.elastic),
                ("|F_s − F_a|", (parts.elastic - parts.pull).abs()),
                (
                    "the number of walls that its second grain touched a step before",
                    walls_before
                        .get(&ids.1)
                        .map_or(0.0, |count| f64::from(*count)),
                ),
            ];
            let material = |id: u32| case.bodies.material.get(id as usize).copied().unwrap_or(0);
            let (a, b) = (material(ids.0), material(ids.1));
            let is = |does: bool, mark: Marks| if does { mark } else { 0 };
            let lasting = was.map_or(0, |was| {
                was.marks & BEYOND_LIMIT | is(was.marks & (SLIDES_NOW | SLID) != 0, SLID)
            });
            let half = |id: u32| 2 * id as usize >= case.bodies.len();
            let pairs = parts.first == Body::Grain;
            let marks = lasting
                | is(pairs && half(ids.0) != half(ids.1), OF_HALVES)
                | is(pairs && ids.0 % 2 != ids.1 % 2, EVEN_AND_ODD)
                | is(is_at(hypot(tangential), parts.limit, turned), SLIDES_NOW)
                | is(was.is_none(), BEGINS)
                | is(parts.way < 0.0, PARTS)
                | is(kind == 1, AT_WALL)
                | is(kind == 2, AT_PUNCH)
                | case
                    .wall(ids.0)
                    .map_or(0, |wall| ACROSS[wall.axis as usize])
                | is(
                    hypot(parts.without_limit) >= parts.most_moment,
                    BEYOND_LIMIT,
                );
            let between = match (case.bodies.material.is_empty(), parts.first) {
                (false, _) => format!("materials {} and {}", a.min(b), a.max(b)),
                (true, Body::Wall) => {
                    format!("wall {} and grains", ids.0 - case.bodies.len() as u32)
                }
                _ => String::new(),
            };
            let mut add = |quantity: usize, off: Vector, least: f64, terms: Vec<Term>| {
                rows.entry((quantity, kind)).or_default().push(Row {
                    at: (run, at),
                    subject: Of::Contact(ids.0, ids.1),
                    off,
                    least,
                    terms,
                    sizes: sizes.clone(),
                    marks,
                    between: between.clone(),
                    elsewhere: Vec::new(),
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
                fit::SPRING, 1.0 => one(parts.elastic);
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
            let by_first = parts.first_alone.map(|first| one(first.0));
            let first = was.map_or([parts.k_s, parts.c_n], |was| was.first);
            let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
            let grown = share(parts.c_n - first[1], parts.c_n);
            let acts = told_braking(&parts, (tangential, turned), rules.tangential_dashpot);
            let whole = if acts == NONE {
                0.0
            } else {
                share(parts.c_s, parts.c_n)
            };
            of_normal.extend(terms! {
                "what c_n has changed since the contact began, in the dashpot's force", 1.0 => one(grown * parts.viscous);
                "what the dashpot along the tangent has by the velocity along the normal", 0.0 => one(whole * parts.viscous);
            });
            of_normal.extend(terms! {
                "the size of the dashpot's force", 0.0 => one(parts.viscous.abs());
                "the dashpot's force by the punch's velocity", 1.0 => by_first[0];
                "the dashpot's force by the punch's velocity put along x", 0.0 => by_first[1];
                "the dashpot's force by the punch's velocity put along y", 0.0 => by_first[2];
                "k_s·(approach in the step)", 0.0 => one(parts.share * parts.k_s * parts.way);
                "what it was off by in the step before", 0.0 => one(was.map_or(0.0, |was| was.normal_force - was.parts.normal_force));
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
            slid.extend(self.tangential(
                &parts,
                (tangential, normal, u, loose, turned),
                (was.zip(told), outlived.unwrap_or_default()),
                &mut add,
            ));
            let is_near = hypot(parts.without_limit) > STICKS * parts.most_moment;
            let has_rolled = is_near || was.is_some_and(|was| was.has_rolled);
            // Loads by what is written.
            let sides = [(0, ids.0, -1.0), (1 + kind, ids.1, 1.0)];
            let acting = told_braking(&parts, (tangential, turned), rules.tangential_dashpot);
            for (side, (which, id, sign)) in sides.into_iter().enumerate() {
                if side == 0 && !pairs {
                    continue;
                }
                let load = &mut loads[id as usize];
                let spin = now.bodies.angular_velocity(id as usize);
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
                load.late = plus(load.late, parts.late_torques[side]);
                load.marks |= marks;
                for (sums, (mark, _)) in load.marked.iter_mut().zip(MARKS) {
                    if marks & mark != 0 {
                        let force = plus(by[0], by[1]);
                        *sums = [plus(sums[0], force), plus(sums[1], parts.torques[side])];
                    }
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
                let add = |sum: &mut Vector, moment: Vector| {
                    *sum = plus(*sum, times(sign, moment));
                };
                for at in [0, 1] {
                    add(&mut load.moments[at], parts.moments[at]);
                    add(&mut load.added[at], parts.added[at]);
                    add(&mut load.rolling_alone[at], parts.rolling_alone[at]);
                    add(&mut load.kept[at], parts.kept_moments[at]);
                    add(&mut load.exchanged[at], parts.exchanged_moments[at]);
                    match which {
                        0 => add(&mut load.moments_on_first[at], parts.moments[at]),
                        2 => add(&mut load.moments_at_walls[at], parts.moments[at]),
                        _ => {}
                    }
                }
                add(&mut load.twist_as_rolling, parts.twist_as_rolling);
                add(&mut load.by_component, parts.by_component);
                if parts.moments[0] != parts.without_limit {
                    add(&mut load.limited, parts.moments[0]);
                }
                add(&mut load.without_limit, parts.without_limit);
                load.was_beyond_limit |= was.is_some_and(|was| was.marks & BEYOND_LIMIT != 0);
                load.near_limit |= has_rolled;
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
                    rules,
                    has_rolled,
                    marks,
                    first,
                },
            );
        }
        if self.looks_elsewhere {
            let around = Around {
                reference,
                now: &made_now,
                in_slots: &in_slots,
                before: &self.made_before,
            };
            around.add_to(rows, (run, at), &mut self.kept);
            for (load, elsewhere) in loads.iter_mut().zip(around.on_grains(case.bodies.len())) {
                load.elsewhere = elsewhere;
            }
            self.made_before = made_now
                .into_iter()
                .map(|made| (made.ids(), made))
                .collect();
        }
        self.seen.slid.extend(slid);
        self.before = after;
        self.ended.extend(
            past.into_iter()
                .filter(|(ids, _)| !self.before.contains_key(ids)),
        );
        if let Some(punch) = now.punch {
            let size = |contact: &Contact| contact.normal_force.hypot(contact.tangential_force);
            let sizes: f64 = now.contacts.iter().map(size).sum();
            let id = case.ids().punch();
            let at_punch = now.contacts.iter().filter(|contact| contact.id1 == id);
            let on_punch = -at_punch
                .clone()
                .map(|contact| contact.force()[1])
                .sum::<f64>();
            let along = |contact: &Contact| contact.normal_force * contact.normal[1];
            let by_normals = -at_punch.map(along).sum::<f64>();
            if !case.bodies.in_space() {
                rows.entry((PUNCH, 2)).or_default().push(Row {
                    at: (self.run, at),
                    subject: Of::Contact(id, 0),
                    off: [punch.force - on_punch, 0.0, 0.0],
                    least: ROUNDED * (on_punch.abs() + punch.force.abs() + 1.0e-6 * sizes),
                    terms: terms! {
                        "the sum of its contacts' forces", 1.0 => [on_punch, 0.0, 0.0];
                        "the sum of its contacts' tangential forces", 1.0 => [on_punch - by_normals, 0.0, 0.0];
                        "the sum of the sizes of all contacts' forces", 0.0 => [sizes, 0.0, 0.0];
                    },
                    sizes: Vec::new(),
                    marks: 0,
                    between: String::new(),
                    elsewhere: Vec::new(),
                });
            }
        }
        loads
    }

    /// A tangential force: that of a contact that begins or goes on, and that sticks or slides for certain. Of one that stuck a
    /// step before its spring's force over Coulomb's limit, and whether it is cut.
    fn tangential(
        &mut self,
        parts: &Parts,
        (tangential, normal, u, loose, turned): (Vector, Vector, f64, f64, f64),
        (before, outlived): Past<'_>,
        add: &mut dyn FnMut(usize, Vector, f64, Vec<Term>),
    ) -> Option<(f64, bool)> {
        let case = self.case;
        let rules = case.model.law.resolved(case.model.rules);
        if !case.model.law.has_friction() {
            return None;
        }
        if before.is_some_and(|(was, (_, cut))| {
            cut && was.rules.spring_when_sliding != SpringWhenSliding::Limited
        }) {
            return None;
        }
        let across = |vector: Vector| minus(vector, times(dot(vector, normal), normal));
        let (slip, braking) = (sum(parts.slips), sum(parts.brakings));
        let trial = plus(
            plus(parts.kept, times(parts.share, slip)),
            plus(parts.turns[0], parts.turns[1]),
        );
        let spins = |vectors: &[Vector; 3]| plus(vectors[1], vectors[2]);
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
            let since = (1.0 - was.first[0] / parts.k_s) * has(parts.k_s > 0.0);
            of_before = terms! {
                "what k_s has changed since the contact began, in k_s·Δt·slip", 1.0 => times(since, sum(parts.slips));
                "k_s·Δt·slip of the step before", 0.0 => times(1.0 + growth, told.slip);
                "k_s·Δt·slip of the step before, turned", 0.0 => slip;
                "the dashpot's force of the step before, which the spring keeps,", 0.0 => times(has(told.brakes), braking);
                "the spring's force of the step before, times the growth of k_s since, as of a spring that keeps a displacement,", 0.0 => times(growth, whole);
                "the dashpot's force of the step before, where it slid,", 0.0 => times(has(cut && !told.brakes), braking);
                "the whole force of the step before", 0.0 => force;
                "the force of the step before, not turned", 0.0 => told.tangential;
            };
        }
        if begins {
            let more = has(parts.way != 0.0) * (u / parts.way) - parts.share;
            of_before = terms! {
                "the force of the spring when these two parted the last time, turned with the contact", 0.0 => outlived[0];
                "the force of the spring when these two parted the last time", 0.0 => outlived[1];
                "what the slip of more than a step has, as the share of a new contact is not capped at 1", 0.0 => times(more.max(0.0), slip);
                "what the slip has of a new contact whose share is not between 0 and 1", 0.0 => times(more, slip);
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
            add(quantity, tangential, 1.0, Vec::new());
            return None;
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
                "the turn of the spring about the normal by the first one's spin", 1.0 => parts.twists[0];
                "the turn of the spring about the normal by the second one's spin", 1.0 => parts.twists[1];
                "k_s·Δt·slip of the spins", parts.share => spins(&parts.slips);
                "k_s·Δt·slip of the centres", parts.share => parts.slips[0];
                "the dashpot's force by the spins", has(!none) => spins(&parts.brakings);
                "the dashpot's force by the centres", has(!none) => parts.brakings[0];
                "k_s·Δt·slip of the first one's spin", parts.share => parts.slips[1];
                "k_s·Δt·slip of the second one's spin", parts.share => parts.slips[2];
                "k_s·Δt·slip of the punch's velocity", parts.share => parts.first_alone[0].1;
                "k_s·Δt·slip of the punch's velocity put along x", 0.0 => times(parts.share, parts.first_alone[1].1);
                "k_s·Δt·slip of the punch's velocity put along y", 0.0 => times(parts.share, parts.first_alone[2].1);
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
            let along = |vector: Vector| match hypot(vector) {
                0.0 => NONE,
                size => times(limit / size, vector),
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
                "Coulomb's limit along what the spring had when these two parted the last time, turned with the contact,", 0.0 => along(plus(outlived[0], trial));
                "Coulomb's limit along what the spring had when these two parted the last time", 0.0 => along(plus(outlived[1], trial));
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
            return None;
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
        let least = ROUNDED * scale + loose;
        if [NEW_STICKS, STICKING].contains(&quantity) && limit > 0.0 {
            self.seen.stuck.push((
                parts.first as usize,
                told / limit,
                hypot(off) > PLAIN * least,
            ));
        }
        add(quantity, off, least, terms);
        let is_of_slid = [NOT_CUT, SLIDING].contains(&quantity) && !begins && !was_cut;
        is_of_slid.then(|| (size / limit, quantity != NOT_CUT))
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
        _ => sum(parts.brakings),
    }
}
