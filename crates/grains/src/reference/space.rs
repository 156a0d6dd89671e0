//! The step of spheres in space with lists, contacts eight at a time: the operations of the step that is written out in the same
//! order, so its bits, for the usual rules of contacts and laws with friction whose grains turn. Only what no rule changes is
//! here; grains are moved by the reference, and contacts of obstacles and punch, which are few, are left to it.

use multiversion::multiversion;

use super::law::Pair;
use super::touch::Touch;
use super::{Ids, Memory, Motion, Reference, Touching, series};
use crate::model::Law;
use crate::native::lanes::{LANES, Lanes};
use crate::native::powers::Powers;
use crate::native::state::Constants;
use crate::rules::{Arms, NewContact, Rules, Slip, TensionRule};
use crate::scene::{AdhesionLaw, Springs, Viscosity};
use crate::tables::Body;
use crate::vector::{Vector, cross, dot, each, minus, plus, times};

/// Lists of pairs that are near, and what they remember.
#[derive(Clone)]
pub(crate) struct Space {
    powers: Powers,
    /// Pairs of grains, then those of a wall and a grain, sorted by ids.
    near: Vec<Near>,
    kept: Kept,
    /// How many are pairs of grains.
    between: usize,
    /// Where grains were when they were listed, m.
    at: Vec<Vector>,
    /// At which step that was, and how far apart surfaces are that are near, m.
    listed: u64,
    gap: f64,
    /// Rows that touch or have touched before.
    now: Vec<u32>,
    /// The same at walls.
    walls: Vec<(u32, Touch)>,
}

#[derive(Clone, Copy)]
struct Near {
    ids: Ids,
    /// The distance of centres, squared, beyond which grains do not touch, m².
    reach: f64,
    touches: bool,
}

/// What near pairs remember, zeros where they do not touch. In columns, so that what a law does not use is not read.
#[derive(Clone, Default)]
struct Kept {
    normal: Vec<Vector>,
    shear: Vec<Vector>,
    /// Bending and twisting; empty for laws without them.
    moments: Vec<[Vector; 2]>,
    /// Whether they were cut by Coulomb's limit; empty for laws without a dashpot along the tangent.
    slides: Vec<bool>,
    pair: Vec<Pair>,
    /// On body 2 at the last evaluation, N.
    force: Vec<Vector>,
}

/// How far apart surfaces may be that are near, over the largest radius: at the start, the least and the most. A list that holds for
/// many steps is shorter the next time, and the other way round.
const NEAR: [f64; 3] = [0.1, 0.02, 0.4];
const MANY_STEPS: u64 = 200;
/// A square that rounding has made larger than that of the reach is not larger than this times it.
const ROUNDING: f64 = 1.0 + 1.0e-12;

impl Space {
    /// Takes over what the reference's contacts remember, but those of obstacles and punch; none where this is no step for it.
    pub fn of(reference: &mut Reference) -> Option<Self> {
        let Constants { law, rules, .. } = &reference.constants;
        let is_usual = law.resolved(Rules::default()) == *rules;
        let whole_step = rules.new_contact == NewContact::WholeStep;
        let plain = reference.variant.forms.is_empty() && reference.sizes.in_space;
        let plain = plain && law.contact.adhesion_law == AdhesionLaw::Pull;
        let plain = plain && reference.sizes.inertia.len() == reference.motions.len();
        if !(plain && is_usual && whole_step && law.rotates()) {
            return None;
        }
        let first = reference.constants.first_obstacle();
        let ahead = |at: &[Ids]| at.partition_point(|ids| ids.0 < first);
        let ids: Vec<Ids> = reference
            .touching
            .iter()
            .map(|touching| touching.ids)
            .collect();
        let touching: Vec<Touching> = reference.touching.drain(..ahead(&ids)).collect();
        let ids: Vec<Ids> = reference.memories.iter().map(|memory| memory.ids).collect();
        let memories: Vec<Memory> = reference.memories.drain(..ahead(&ids)).collect();
        let mut memories = memories.into_iter().peekable();
        let (mut near, mut kept) = (Vec::new(), Kept::default());
        let law = &reference.constants.law;
        let has = (law.contact.rolling.is_some(), brakes(law));
        for Touching { ids, force, .. } in touching {
            while memories.next_if(|memory| memory.ids < ids).is_some() {}
            near.push(Near {
                ids,
                reach: 0.0,
                touches: true,
            });
            let memory = memories.next_if(|memory| memory.ids == ids);
            let memory = memory.unwrap_or_else(|| Memory::new(ids, reference.pair(ids)));
            kept.push(memory, force, has);
        }
        Some(Space {
            powers: Powers::new(),
            near,
            kept,
            between: 0,
            at: Vec::new(),
            listed: 0,
            gap: NEAR[0] * reference.largest_radius(),
            now: Vec::new(),
            walls: Vec::new(),
        })
    }

    /// Gives the contacts back.
    pub fn hand_back(&self, reference: &mut Reference) {
        let rows = self.near.iter().enumerate();
        let rows = rows.filter(|(_, near)| near.touches);
        let (mut memories, mut touching) = (Vec::new(), Vec::new());
        for (at, Near { ids, .. }) in rows {
            let touch = match reference.constants.ids.body(ids.0) {
                Body::Grain => reference.grains(*ids),
                _ => reference.wall(*ids, reference.constants.wall_of(ids.0)),
            };
            let (ids, force) = (*ids, self.kept.force[at]);
            touching.extend(touch.map(|touch| Touching { ids, touch, force }));
            memories.push(self.kept.memory(at, ids));
        }
        reference.memories.splice(0..0, memories);
        reference.touching.splice(0..0, touching);
    }

    /// One time step.
    pub fn step(&mut self, reference: &mut Reference) {
        reference.move_bodies();
        advance(reference);
        reference.steps += 1;
        if reference.have_gone(&self.at, self.gap) {
            self.list(reference);
        }
        reference.clear_sums();
        self.find(reference);
        add(self, reference);
        if reference.felt.is_some() || !reference.obstacles.is_empty() {
            let mut touching = std::mem::take(&mut reference.touching);
            touching.clear();
            reference.find_at_obstacles(&mut touching);
            reference.find_at_punch(&mut touching);
            reference.add_forces(touching);
        }
    }

    /// Lists those that are near; rows stay those of the same pairs.
    fn list(&mut self, reference: &Reference) {
        let radius = &reference.sizes.radius;
        let held = reference.steps - std::mem::replace(&mut self.listed, reference.steps);
        let [_, least, most] = NEAR.map(|near| near * reference.largest_radius());
        let change = if held > MANY_STEPS { 0.7 } else { 1.0 / 0.7 };
        self.gap = (change * self.gap).clamp(least, most);
        let gap = self.gap;
        let found = reference.near_pairs(gap);
        self.at = found.at;
        let apart = |ids, reach| Near {
            ids,
            reach,
            touches: false,
        };
        let between = found.pairs.into_iter().map(|ids| {
            let sum = radius[ids.0 as usize] + radius[ids.1 as usize];
            apart(ids, sum * sum * ROUNDING)
        });
        let mut near: Vec<Near> = between.collect();
        self.between = near.len();
        let constants = &reference.constants;
        for (index, wall) in constants.walls.iter().enumerate() {
            let (axis, id) = (wall.axis.in_space(), constants.ids.wall(index));
            let grains = (0..).zip(self.at.iter().zip(radius));
            let at_wall = grains
                .filter(|(_, (at, radius))| (at[axis] - wall.place).abs() <= **radius + gap)
                .map(|(grain, _)| apart((id, grain), 0.0));
            near.extend(at_wall);
        }
        let before = std::mem::take(&mut self.kept);
        let mut old = self.near.iter().enumerate().peekable();
        let has = (
            constants.law.contact.rolling.is_some(),
            brakes(&constants.law),
        );
        for now in &mut near {
            while old.next_if(|(_, old)| old.ids < now.ids).is_some() {}
            let (memory, force) = match old.next_if(|(_, old)| old.ids == now.ids) {
                Some((at, old)) => {
                    now.touches = old.touches;
                    (before.memory(at, now.ids), before.force[at])
                }
                None => (Memory::new(now.ids, reference.pair(now.ids)), [0.0; 3]),
            };
            self.kept.push(memory, force, has);
        }
        self.near = near;
    }

    /// Finds those that may touch, and those that have touched and must forget.
    fn find(&mut self, reference: &Reference) {
        let motions = reference.motions.as_slice();
        self.now.resize(self.between, 0);
        let mut count = 0;
        let (between, at_walls) = self.near.split_at(self.between);
        for (at, near) in (0..).zip(between) {
            let (one, two) = (near.ids.0 as usize, near.ids.1 as usize);
            let way = minus(motions[two].place, motions[one].place);
            self.now[count] = at;
            // Without a branch, which would be guessed wrong.
            count += usize::from((dot(way, way) <= near.reach) | near.touches);
        }
        self.now.truncate(count);
        self.walls.clear();
        for (at, near) in (self.between as u32..).zip(at_walls) {
            let touch = reference.wall(near.ids, reference.constants.wall_of(near.ids.0));
            if touch.is_some() || near.touches {
                self.walls.push((at, touch.unwrap_or(Touch::NONE)));
            }
        }
    }
}

/// Whether a law has a dashpot along the tangent.
fn brakes(law: &Law) -> bool {
    law.has_dashpots() && law.contact.springs != Springs::Linear
}

impl Memory {
    /// Of a pair that does not touch.
    pub(super) fn new(ids: Ids, pair: Pair) -> Self {
        let none = [0.0; 3];
        Memory {
            ids,
            normal: none,
            shear: none,
            bending: none,
            twisting: none,
            slides: false,
            pair,
            k_s: 0.0,
        }
    }
}

impl Kept {
    fn push(&mut self, memory: Memory, force: Vector, (has_moments, brakes): (bool, bool)) {
        self.normal.push(memory.normal);
        self.shear.push(memory.shear);
        let moments = has_moments.then_some([memory.bending, memory.twisting]);
        self.moments.extend(moments);
        self.slides.extend(brakes.then_some(memory.slides));
        self.pair.push(memory.pair);
        self.force.push(force);
    }

    fn memory(&self, at: usize, ids: Ids) -> Memory {
        let [bending, twisting] = self.moments.get(at).copied().unwrap_or_default();
        Memory {
            ids,
            normal: self.normal[at],
            shear: self.shear[at],
            bending,
            twisting,
            slides: self.slides.get(at).is_some_and(|slides| *slides),
            pair: self.pair[at],
            k_s: 0.0,
        }
    }

    /// Remembers what the contact in this lane has done, forgets what is none any more; says whether there is one.
    fn keep(&mut self, at: usize, block: &Block, lane: usize) -> bool {
        let touches = block.overlap.0[lane] >= 0.0;
        let remembered = |vectors: &Vectors| match touches {
            true => in_lane(vectors, lane),
            false => [0.0; 3],
        };
        self.normal[at] = remembered(&block.normal);
        self.shear[at] = remembered(&block.shear);
        self.force[at] = remembered(&block.force);
        if let Some(moments) = self.moments.get_mut(at) {
            *moments = [remembered(&block.moments[0]), remembered(&block.moments[1])];
        }
        if let Some(slides) = self.slides.get_mut(at) {
            *slides = touches && block.slides.0[lane] > 0.0;
        }
        touches
    }
}

type Vectors = Vector<Lanes>;

/// How eight bodies move.
#[derive(Clone, Copy, Default)]
struct Motions {
    place: Vectors,
    velocity: Vectors,
    spin: Vectors,
}

impl Motions {
    /// Velocities of the bodies at these points, m/s.
    #[inline(always)]
    fn at(&self, point: Vectors) -> Vectors {
        let arm = minus(point, self.place);
        plus(self.velocity, cross(self.spin, arm))
    }
}

/// Turned with the normal and about it.
#[inline(always)]
fn turned(vector: Vectors, [turn, about]: [Vectors; 2]) -> Vectors {
    let vector = minus(vector, cross(vector, turn));
    minus(vector, cross(vector, about))
}

/// Eight contacts: what goes into the law and what comes of it.
#[derive(Clone, Copy, Default)]
struct Block {
    on: [Motions; 2],
    radii: [Lanes; 2],
    /// Where they touch: at walls it is given.
    overlap: Lanes,
    normal: Vectors,
    point: Vectors,
    k_n: Lanes,
    k_s: Lanes,
    mass: Lanes,
    tangent: Lanes,
    pull: Lanes,
    /// The normal of the step before.
    before: Vectors,
    /// What springs remember, before the step and after it.
    shear: Vectors,
    moments: [Vectors; 2],
    /// 1 where it is cut, where the law has a dashpot along the tangent.
    slides: Lanes,
    /// As [`Action`](super::law::Action) says of one contact.
    force: Vectors,
    torques: [Vectors; 2],
    moment: Vectors,
}

/// Blocks that are filled, worked out and read together: what has just been written in parts is not yet read as a whole.
const BLOCKS: usize = 4;

fn put(to: &mut Vectors, lane: usize, vector: &Vector) {
    for (to, part) in to.iter_mut().zip(vector) {
        to.0[lane] = *part;
    }
}

fn in_lane(vectors: &Vectors, lane: usize) -> Vector {
    [vectors[0].0[lane], vectors[1].0[lane], vectors[2].0[lane]]
}

impl Block {
    fn move_one(&mut self, side: usize, lane: usize, motion: &Motion) {
        let on = &mut self.on[side];
        put(&mut on.place, lane, &motion.place);
        put(&mut on.velocity, lane, &motion.velocity);
        put(&mut on.spin, lane, &motion.spin);
    }

    fn remember(&mut self, lane: usize, kept: &Kept, at: usize, law: &Law) {
        let (dashpots, adhesion) = (law.has_dashpots(), law.contact.adhesion.is_some());
        put(&mut self.before, lane, &kept.normal[at]);
        put(&mut self.shear, lane, &kept.shear[at]);
        if let Some(moments) = kept.moments.get(at) {
            put(&mut self.moments[0], lane, &moments[0]);
            put(&mut self.moments[1], lane, &moments[1]);
        }
        let pair = &kept.pair[at];
        self.k_n.0[lane] = pair.k_n;
        self.k_s.0[lane] = pair.k_s;
        self.tangent.0[lane] = pair.tangent;
        // Each number takes time; these two most laws do without.
        if dashpots {
            self.mass.0[lane] = pair.mass;
        }
        if adhesion {
            self.pull.0[lane] = pair.pull;
        }
    }

    /// Where grains touch.
    #[inline(always)]
    fn meet(&mut self) {
        let [one, two] = [&self.on[0].place, &self.on[1].place];
        let way = minus(*two, *one);
        let distance = dot(way, way).sqrt();
        self.overlap = self.radii[0] + self.radii[1] - distance;
        self.normal = each(way, |part| part / distance);
        let arm = self.radii[0] - Lanes::all(0.5) * self.overlap;
        self.point = plus(*one, times(arm, self.normal));
    }
}

/// Moves the grains as the reference does, velocity and spin of each in the lanes of a vector. Compiled for the widest vector
/// unit that the machine has.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn advance(reference: &mut Reference) {
    let (motions, sizes) = (&mut reference.motions, &reference.sizes);
    let Constants {
        dt, alpha, gravity, ..
    } = reference.constants;
    let (all, [gx, gz]) = (Lanes::all, gravity);
    let six = |[a, b, c]: Vector, [d, e, f]: Vector| Lanes([a, b, c, d, e, f, 1.0, 1.0]);
    // A spin has none; −0 changes no number that it is added to.
    let pull = six([gx, 0.0, gz], [-0.0; 3]);
    let loads = reference.force.iter().zip(&reference.torque);
    let inert = sizes.mass.iter().zip(&sizes.inertia);
    for ((grain, (force, torque)), (mass, inertia)) in motions.iter_mut().zip(loads).zip(inert) {
        let before = six(grain.velocity, grain.spin);
        let undamped = six(*force, *torque) / six([*mass; 3], [*inertia; 3]) + pull;
        let power = undamped * (before + all(0.5 * dt) * undamped);
        let (gains, loses) = (power.exceeds(all(0.0)), all(0.0).exceeds(power));
        let [share] = gains.choose([all(1.0 - alpha)], [all(1.0)]);
        let [share] = loses.choose([all(1.0 + alpha)], [share]);
        let after = before + all(dt) * (undamped * share);
        let [vx, vy, vz, wx, wy, wz, ..] = after.0;
        (grain.velocity, grain.spin) = ([vx, vy, vz], [wx, wy, wz]);
        grain.place = plus(grain.place, times(dt, grain.velocity));
    }
}

/// What contacts between grains and at walls do, added to the sums.
fn add(space: &mut Space, reference: &mut Reference) {
    let Reference {
        motions,
        sizes,
        force,
        torque,
        constants,
        ..
    } = reference;
    let Space {
        near,
        kept,
        now,
        walls,
        powers,
        ..
    } = space;
    let has_moments = !kept.moments.is_empty();
    let laws = Laws {
        constants,
        powers: *powers,
    };
    let mut blocks = [Block::default(); BLOCKS];
    for now in now.chunks(BLOCKS * LANES) {
        for (block, now) in blocks.iter_mut().zip(now.chunks(LANES)) {
            for (lane, at) in now.iter().enumerate() {
                let Near { ids, .. } = near[*at as usize];
                for (side, id) in [ids.0, ids.1].into_iter().enumerate() {
                    block.move_one(side, lane, &motions[id as usize]);
                    block.radii[side].0[lane] = sizes.radius[id as usize];
                }
                block.remember(lane, kept, *at as usize, &constants.law);
            }
        }
        act(&mut blocks[..now.len().div_ceil(LANES)], &laws, false);
        for (block, now) in blocks.iter().zip(now.chunks(LANES)) {
            for (lane, at) in now.iter().enumerate() {
                let at = *at as usize;
                near[at].touches = kept.keep(at, block, lane);
                if !near[at].touches {
                    continue;
                }
                let (one, two) = (near[at].ids.0 as usize, near[at].ids.1 as usize);
                let on_two = in_lane(&block.force, lane);
                force[one] = minus(force[one], on_two);
                force[two] = plus(force[two], on_two);
                torque[one] = plus(torque[one], in_lane(&block.torques[0], lane));
                torque[two] = plus(torque[two], in_lane(&block.torques[1], lane));
                if has_moments {
                    let moment = in_lane(&block.moment, lane);
                    torque[one] = minus(torque[one], moment);
                    torque[two] = plus(torque[two], moment);
                }
            }
        }
    }
    let block = &mut blocks[0];
    block.on[0] = Motions::default();
    for now in walls.chunks(LANES) {
        for (lane, (at, touch)) in now.iter().enumerate() {
            let at = *at as usize;
            block.move_one(1, lane, &motions[near[at].ids.1 as usize]);
            block.radii[0].0[lane] = touch.radii[0];
            block.radii[1].0[lane] = touch.radii[1];
            block.overlap.0[lane] = touch.overlap;
            put(&mut block.normal, lane, &touch.normal);
            put(&mut block.point, lane, &touch.point);
            block.remember(lane, kept, at, &constants.law);
        }
        act(std::slice::from_mut(block), &laws, true);
        for (lane, (at, _)) in now.iter().enumerate() {
            let at = *at as usize;
            near[at].touches = kept.keep(at, block, lane);
            if near[at].touches {
                let two = near[at].ids.1 as usize;
                force[two] = plus(force[two], in_lane(&block.force, lane));
                torque[two] = plus(torque[two], in_lane(&block.torques[1], lane));
                if has_moments {
                    torque[two] = plus(torque[two], in_lane(&block.moment, lane));
                }
            }
        }
    }
}

/// What they do. Compiled for the widest vector unit that the machine has.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
fn act(blocks: &mut [Block], laws: &Laws, at_walls: bool) {
    for block in blocks {
        if !at_walls {
            block.meet();
        }
        laws.act(block);
    }
}

/// What eight contacts do by the law.
struct Laws<'a> {
    constants: &'a Constants,
    powers: Powers,
}

impl Laws<'_> {
    /// As the reference's `act`.
    #[inline(always)]
    fn act(&self, block: &mut Block) {
        let (constants, law, rules) = (self.constants, &self.constants.law, &self.constants.rules);
        let (all, none) = (Lanes::all, [Lanes::all(0.0); 3]);
        let contact = &law.contact;
        let is_linear = contact.springs == Springs::Linear;
        let dashpots = law.has_dashpots();
        let clips = dashpots && rules.tension == TensionRule::Cut;
        let dt = all(constants.dt);
        let Block {
            k_n,
            k_s,
            mass,
            tangent,
            pull,
            ..
        } = *block;
        let (u, n, on) = (block.overlap, block.normal, &block.on);

        // The constants at this overlap.
        let (elastic, k_n, k_s) = match is_linear {
            true => (k_n * u, k_n, k_s),
            false => {
                let [root, power] = self.powers.of(u);
                (k_n * power, all(1.5) * k_n * root, k_s * root)
            }
        };
        let by_ratio = |ratio: f64, k: Lanes| all(2.0 * ratio) * (mass * k).sqrt();
        let [normal_ratio, along_ratio] = constants.damping_ratios;

        // The normal force.
        let with_points = dashpots || rules.slip == Slip::ContactPoint;
        let at_contact_point = match with_points {
            true => minus(on[1].at(block.point), on[0].at(block.point)),
            false => none,
        };
        let c_n = match contact.viscosity {
            Viscosity::Dashpot { c_n, .. } => all(series(c_n, c_n)),
            _ if dashpots => by_ratio(normal_ratio, k_n),
            _ => all(0.0),
        };
        let normal_force = if is_linear {
            let mut force = elastic;
            if dashpots {
                force = force - c_n * dot(n, at_contact_point);
            }
            let pulls = all(0.0).exceeds(force);
            match clips {
                true => pulls.choose(none, times(force, n)),
                false => times(force, n),
            }
        } else {
            let spring = times(elastic - pull, n);
            if dashpots {
                let viscous = times(c_n, times(dot(n, at_contact_point), n));
                let force = minus(spring, viscous);
                let pushes = dot(force, n).reaches(all(0.0));
                match (clips, contact.adhesion) {
                    (false, _) => force,
                    (true, None) => pushes.choose(force, none),
                    (true, Some(_)) => {
                        let size = dot(viscous, viscous).sqrt();
                        let twice = minus(spring, times(pull, each(viscous, |part| part / size)));
                        let cut = size.exceeds(pull).choose(twice, force);
                        pushes.choose(force, cut)
                    }
                }
            } else {
                spring
            }
        };

        // The tangential force.
        let before = block.before;
        let turn = cross(before, n);
        let spins = plus(on[0].spin, on[1].spin);
        let about = times(all(0.5 * constants.dt) * dot(before, spins), before);
        let turns = [turn, about];
        let [r1, r2] = block.radii;
        let relative = match rules.slip {
            Slip::ContactPoint => at_contact_point,
            _ => {
                let stretch = (r1 + r2) / (r1 + r2 - u);
                let relative = times(stretch, minus(on[1].velocity, on[0].velocity));
                minus(
                    plus(relative, cross(on[1].spin, times(-r2, n))),
                    cross(on[0].spin, times(r1, n)),
                )
            }
        };
        let slip = minus(relative, times(dot(n, relative), n));
        let growth = match dashpots && is_linear {
            false => times(k_s, times(dt, slip)),
            true => times(k_s * dt, slip),
        };
        let shear = minus(turned(block.shear, turns), growth);
        let size_squared = dot(normal_force, normal_force);
        let (limit, limit_squared) = match is_linear {
            true => {
                let squared = size_squared * (tangent * tangent);
                (squared.sqrt(), squared)
            }
            false => {
                let limit = (size_squared.sqrt() + pull) * tangent;
                (limit, limit * limit)
            }
        };
        let squared = dot(shear, shear);
        let slides = squared.exceeds(limit_squared);
        let shear = slides.choose(times(limit / squared.sqrt(), shear), shear);
        let tangential = match dashpots && !is_linear {
            true => {
                let c_s = by_ratio(along_ratio, k_s);
                let braking = times(-c_s, each(times(dt, slip), |way| way / dt));
                [block.slides] = slides.choose([all(1.0)], [all(0.0)]);
                slides.choose(shear, plus(shear, braking))
            }
            false => shear,
        };
        let force = plus(normal_force, tangential);

        // Moments against rolling and twisting.
        let mut moments = [none; 2];
        if let Some(rolling) = contact.rolling {
            let relative = minus(on[1].spin, on[0].spin);
            let twist = times(dot(relative, n), n);
            let grown = |before: Vectors, stiffness: f64, rate: Vectors| {
                minus(before, times(all(stiffness), times(dt, rate)))
            };
            let rolls = minus(relative, twist);
            let twisting = turned(block.moments[1], turns);
            let twisting = grown(twisting, rolling.twisting_stiffness, twist);
            let force = size_squared.sqrt();
            let limit = rolling.limit.filter(|limit| *limit > 0.0);
            let most = |limit| force * (all(limit) * ((r1 + r2) / all(2.0)));
            let bending = match (rolling.bending_stiffness, limit) {
                (Some(stiffness), limit) => {
                    let bending = turned(block.moments[0], turns);
                    let bending = grown(bending, stiffness, rolls);
                    limit.map_or(bending, |limit| {
                        let (most, size) = (most(limit), dot(bending, bending).sqrt());
                        let is_cut = size.exceeds(most).and(force.exceeds(all(0.0)));
                        is_cut.choose(times(most / size, bending), bending)
                    })
                }
                (None, Some(limit)) => {
                    let (most, size) = (most(limit), dot(rolls, rolls).sqrt());
                    let acts = size.exceeds(all(0.0)).and(force.exceeds(all(0.0)));
                    acts.choose(times(-(most / size), rolls), none)
                }
                (None, None) => none,
            };
            moments = [bending, twisting];
        }

        // Torques of the force.
        let on_first = each(force, |part| -part);
        block.torques = match rules.torque_arms {
            Arms::ContactPoint => [
                cross(minus(block.point, on[0].place), on_first),
                cross(minus(block.point, on[1].place), force),
            ],
            _ => {
                let turn = cross(n, on_first);
                [r1, r2].map(|radius| times(radius - all(0.5) * u, turn))
            }
        };
        block.force = force;
        block.moment = plus(moments[0], moments[1]);
        block.moments = moments;
        block.shear = shear;
    }
}
