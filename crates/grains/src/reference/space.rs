//! The step of spheres in space with lists, contacts eight at a time: the operations of the step that is written out in the same
//! order, so its bits, for the usual rules and laws with friction whose grains turn. Only what no rule changes is here; contacts of
//! obstacles and punch, which are few, are left to the reference.
//!
//! As in the plane a pair that does not touch remembers zeros and adds zeros, which change no bit of a sum that began at +0.

use multiversion::multiversion;

use super::law::Pair;
use super::touch::far;
use super::{Ids, Memory, Motion, Reference, Touching, series};
use crate::model::Wall;
use crate::native::lanes::{LANES, Lanes};
use crate::native::powers::Powers;
use crate::native::state::Constants;
use crate::rules::{Arms, NewContact, Rules, Slip, TensionRule};
use crate::scene::{AdhesionLaw, Springs, Viscosity};
use crate::tables::Body;
use crate::vector::{Vector, cross, dot, each, minus, norm, plus, times};

/// Lists of pairs that are near, and what they remember.
#[derive(Clone)]
pub(crate) struct Space {
    powers: Powers,
    /// Pairs of grains that are near, sorted by ids, then those of each wall.
    blocks: Vec<Block>,
    /// Where grains were when they were listed, m.
    at: Vec<Vector>,
    /// No grain is further from there, m.
    pub gone: f64,
    /// At which step that was, and how far apart surfaces are that are near, m.
    listed: u64,
    gap: f64,
}

/// Eight pairs that are near and what they remember, zeros where they do not touch. Places left over hold
/// pairs that never touch.
#[derive(Clone, Default)]
struct Block {
    ids: [[u32; LANES]; 2],
    /// −1 in a place that is left over, m.
    radii: [Lanes; 2],
    /// Less than 0 where they do not touch, m.
    overlap: Lanes,
    k_n: Lanes,
    k_s: Lanes,
    tangent: Lanes,
    normal: Vectors,
    shear: Vectors,
    /// On body 2 at the last evaluation, N.
    force: Vectors,
    /// What most laws do without is not read: 1 where the force is cut, where there is a dashpot along the tangent.
    slides: Lanes,
    mass: Lanes,
    pull: Lanes,
    /// Against rolling and twisting.
    moments: [Vectors; 2],
}

/// How far apart surfaces may be that are near, over the largest radius: at the start, the least and the most. A list that holds for
/// many steps is shorter the next time, and the other way round.
const NEAR: [f64; 3] = [0.1, 0.02, 0.4];
const MANY_STEPS: u64 = 60;

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
        let contacts = touching.into_iter().map(|Touching { ids, force, .. }| {
            while memories.next_if(|memory| memory.ids < ids).is_some() {}
            let memory = memories.next_if(|memory| memory.ids == ids);
            let memory = memory.unwrap_or_else(|| Memory::new(ids, reference.pair(ids)));
            (memory, force, 0.0)
        });
        let mut space = Space {
            powers: Powers::new(),
            blocks: Vec::new(),
            at: Vec::new(),
            gone: f64::INFINITY,
            listed: 0,
            gap: NEAR[0] * reference.largest_radius(),
        };
        space.lay_out(contacts, reference);
        Some(space)
    }

    /// Gives the contacts back.
    pub fn hand_back(&self, reference: &mut Reference) {
        let (mut memories, mut touching) = (Vec::new(), Vec::new());
        for (mut memory, force, overlap) in listed(&self.blocks) {
            if overlap < 0.0 {
                continue;
            }
            let ids = memory.ids;
            let touch = match reference.constants.ids.body(ids.0) {
                Body::Grain => reference.grains(ids),
                _ => reference.wall(ids, reference.constants.wall_of(ids.0)),
            };
            touching.extend(touch.map(|touch| Touching { ids, touch, force }));
            memory.pair = reference.pair(ids);
            memories.push(memory);
        }
        reference.memories.splice(0..0, memories);
        reference.touching.splice(0..0, touching);
    }

    /// One time step.
    pub fn step(&mut self, reference: &mut Reference) {
        reference.move_bodies();
        self.gone += advance(reference);
        reference.steps += 1;
        let far = far(self.gap);
        if self.gone > far {
            self.gone = reference.furthest(&self.at);
            if self.gone > far {
                self.list(reference);
            }
        }
        reference.clear_sums();
        add(self, reference);
        if reference.felt.is_some() || !reference.obstacles.is_empty() {
            let mut touching = std::mem::take(&mut reference.touching);
            touching.clear();
            reference.find_at_obstacles(&mut touching);
            reference.find_at_punch(&mut touching);
            reference.add_forces(touching);
        }
    }

    /// Lists those that are near.
    fn list(&mut self, reference: &Reference) {
        let held = reference.steps - std::mem::replace(&mut self.listed, reference.steps);
        let [_, least, most] = NEAR.map(|near| near * reference.largest_radius());
        let change = if held > MANY_STEPS { 0.7 } else { 1.0 / 0.7 };
        self.gap = (change * self.gap).clamp(least, most);
        let gap = self.gap;
        let found = reference.near_pairs(gap);
        (self.at, self.gone) = (found.at, 0.0);
        let mut near = found.pairs;
        let constants = &reference.constants;
        for (index, wall) in constants.walls.iter().enumerate() {
            let (axis, id) = (wall.axis.in_space(), constants.ids.wall(index));
            let grains = (0..).zip(self.at.iter().zip(&reference.sizes.radius));
            let at_wall = grains
                .filter(|(_, (at, radius))| (at[axis] - wall.place).abs() <= **radius + gap)
                .map(|(grain, _)| (id, grain));
            near.extend(at_wall);
        }
        let before = std::mem::take(&mut self.blocks);
        let mut old = listed(&before).peekable();
        let near = near.into_iter().map(move |ids| {
            while old.next_if(|(memory, ..)| memory.ids < ids).is_some() {}
            let old = old.next_if(|(memory, ..)| memory.ids == ids);
            old.unwrap_or_else(|| (Memory::new(ids, reference.pair(ids)), [0.0; 3], -1.0))
        });
        self.lay_out(near, reference);
    }

    /// Lays out these pairs, sorted by ids, where there is none: no block has grains of two walls.
    fn lay_out(&mut self, near: impl Iterator<Item = Near>, reference: &Reference) {
        let (mut wall, mut lane) = (None, 0);
        for near in near {
            let first = near.0.ids.0;
            let its = first.checked_sub(reference.motions.len() as u32);
            if its != wall {
                (wall, lane) = (its, 0);
            }
            if lane == 0 {
                self.blocks.push(Block {
                    ids: [[first; LANES], [0; LANES]],
                    radii: [Lanes::all(-1.0); 2],
                    overlap: Lanes::all(-1.0),
                    ..Block::default()
                });
            }
            if let Some(block) = self.blocks.last_mut() {
                block.put(lane, &near, &reference.sizes.radius);
            }
            lane = (lane + 1) % LANES;
        }
    }
}

/// What a pair remembers, the force on body 2, N, and the overlap, m.
type Near = (Memory, Vector, f64);

/// The pairs in these blocks.
fn listed(blocks: &[Block]) -> impl Iterator<Item = Near> {
    let places = blocks
        .iter()
        .flat_map(|block| (0..LANES).map(move |lane| (block, lane)));
    let taken = places.filter(|(block, lane)| block.radii[1].0[*lane] >= 0.0);
    taken.map(|(block, lane)| block.near(lane))
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

type Vectors = Vector<Lanes>;

/// How eight bodies move.
#[derive(Clone, Copy, Default)]
struct Motions {
    place: Vectors,
    velocity: Vectors,
    spin: Vectors,
}

impl Motions {
    /// Number by number: machines that gather vectors take longer.
    fn take(&mut self, motions: &[Motion], ids: &[u32; LANES]) {
        for (lane, id) in ids.iter().enumerate() {
            let grain = &motions[*id as usize];
            put(&mut self.place, lane, grain.place);
            put(&mut self.velocity, lane, grain.velocity);
            put(&mut self.spin, lane, grain.spin);
        }
    }

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

/// What eight contacts do besides the force on body 2, as [`Action`](super::law::Action) says of one.
#[derive(Clone, Copy, Default)]
struct Action {
    torques: [Vectors; 2],
    moment: Vectors,
}

/// Overlap, normal and point of eight contacts.
type Met = (Lanes, Vectors, Vectors);

/// Blocks that are worked out before what they do is added: a few, so that it stays near.
const BLOCKS: usize = 4;

fn put(to: &mut Vectors, lane: usize, vector: Vector) {
    for (to, part) in to.iter_mut().zip(vector) {
        to.0[lane] = part;
    }
}

#[inline(always)]
fn in_lane(vectors: &Vectors, lane: usize) -> Vector {
    [vectors[0].0[lane], vectors[1].0[lane], vectors[2].0[lane]]
}

impl Block {
    fn put(&mut self, lane: usize, (memory, force, overlap): &Near, radius: &[f64]) {
        let ((one, two), pair) = (memory.ids, memory.pair);
        (self.ids[0][lane], self.ids[1][lane]) = (one, two);
        let r2 = radius[two as usize];
        self.radii[0].0[lane] = radius.get(one as usize).copied().unwrap_or(r2);
        self.radii[1].0[lane] = r2;
        self.overlap.0[lane] = *overlap;
        self.k_n.0[lane] = pair.k_n;
        self.k_s.0[lane] = pair.k_s;
        self.tangent.0[lane] = pair.tangent;
        self.mass.0[lane] = pair.mass;
        self.pull.0[lane] = pair.pull;
        put(&mut self.normal, lane, memory.normal);
        put(&mut self.shear, lane, memory.shear);
        put(&mut self.force, lane, *force);
        put(&mut self.moments[0], lane, memory.bending);
        put(&mut self.moments[1], lane, memory.twisting);
        self.slides.0[lane] = f64::from(memory.slides);
    }

    fn near(&self, lane: usize) -> Near {
        let memory = Memory {
            ids: (self.ids[0][lane], self.ids[1][lane]),
            normal: in_lane(&self.normal, lane),
            shear: in_lane(&self.shear, lane),
            bending: in_lane(&self.moments[0], lane),
            twisting: in_lane(&self.moments[1], lane),
            slides: self.slides.0[lane] > 0.0,
            pair: Pair {
                k_n: self.k_n.0[lane],
                k_s: self.k_s.0[lane],
                tangent: self.tangent.0[lane],
                mass: self.mass.0[lane],
                mass_along: self.mass.0[lane],
                pull: self.pull.0[lane],
            },
            k_s: 0.0,
        };
        (memory, in_lane(&self.force, lane), self.overlap.0[lane])
    }

    /// The wall that its grains are near, if it is none of pairs of grains.
    #[inline(always)]
    fn wall<'a>(&self, constants: &'a Constants) -> Option<&'a Wall> {
        let first = self.ids[0][0];
        (!constants.ids.is_grain(first)).then(|| constants.wall_of(first))
    }

    /// Where grains touch.
    #[inline(always)]
    fn meet(&self, [one, two]: &[Motions; 2]) -> Met {
        let way = minus(two.place, one.place);
        let distance = dot(way, way).sqrt();
        let overlap = self.radii[0] + self.radii[1] - distance;
        let normal = each(way, |part| part / distance);
        let arm = self.radii[0] - Lanes::all(0.5) * overlap;
        (overlap, normal, plus(one.place, times(arm, normal)))
    }

    /// The same of a wall and grains.
    #[inline(always)]
    fn meet_wall(&self, wall: &Wall, grains: &Motions) -> Met {
        let (all, axis) = (Lanes::all, wall.axis.in_space());
        let distance = grains.place[axis] - all(wall.place);
        let before = distance.exceeds(all(0.0));
        let [size] = before.choose([distance], [-distance]);
        let mut normal = [all(0.0); 3];
        [normal[axis]] = before.choose([all(1.0)], [all(-1.0)]);
        let mut point = grains.place;
        point[axis] = all(wall.place);
        (self.radii[1] - size, normal, point)
    }
}

/// Moves the grains as the reference does, velocity and spin of each in the lanes of a vector. No grain goes further than it says,
/// m. Compiled for the widest vector unit that the machine has.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn advance(reference: &mut Reference) -> f64 {
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
    let mut fastest = [0.0; 3];
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
        for (fastest, part) in fastest.iter_mut().zip(grain.velocity) {
            *fastest = part.abs().max(*fastest);
        }
    }
    dt * norm(fastest)
}

/// What contacts between grains and at walls do, added to the sums.
fn add(space: &mut Space, reference: &mut Reference) {
    let (motions, constants) = (reference.motions.as_slice(), &reference.constants);
    // Of one length, so that an index is checked once.
    let force = &mut reference.force[..motions.len()];
    let torque = &mut reference.torque[..motions.len()];
    let has_moments = constants.law.contact.rolling.is_some();
    let laws = Laws {
        constants,
        powers: space.powers,
    };
    let mut on = [[Motions::default(); 2]; BLOCKS];
    let mut actions = [Action::default(); BLOCKS];
    for blocks in space.blocks.chunks_mut(BLOCKS) {
        for (block, [one, two]) in blocks.iter().zip(&mut on) {
            match block.wall(constants) {
                None => one.take(motions, &block.ids[0]),
                Some(_) => *one = Motions::default(),
            }
            two.take(motions, &block.ids[1]);
        }
        act(blocks, &on, &laws, &mut actions);
        for (block, action) in blocks.iter().zip(&actions) {
            let is_at_wall = block.wall(constants).is_some();
            for lane in 0..LANES {
                let (one, two) = (block.ids[0][lane] as usize, block.ids[1][lane] as usize);
                let (on_two, moment) = (in_lane(&block.force, lane), &action.moment);
                if !is_at_wall {
                    force[one] = minus(force[one], on_two);
                    torque[one] = plus(torque[one], in_lane(&action.torques[0], lane));
                    if has_moments {
                        torque[one] = minus(torque[one], in_lane(moment, lane));
                    }
                }
                force[two] = plus(force[two], on_two);
                torque[two] = plus(torque[two], in_lane(&action.torques[1], lane));
                if has_moments {
                    torque[two] = plus(torque[two], in_lane(moment, lane));
                }
            }
        }
    }
}

/// What they do. Compiled for the widest vector unit that the machine has.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
fn act(blocks: &mut [Block], on: &[[Motions; 2]], laws: &Laws, actions: &mut [Action]) {
    match laws.is_simple() {
        true => act_plain::<true>(blocks, on, laws, actions),
        false => act_plain::<false>(blocks, on, laws, actions),
    }
}

/// The usual law of Hertz and Mindlin and nothing more is compiled by itself, for what is chosen while it runs takes time. What is
/// worked out goes through memory twice, for compilers do not see vectors in one long formula.
#[inline(always)]
fn act_plain<const SIMPLE: bool>(
    blocks: &mut [Block],
    on: &[[Motions; 2]],
    laws: &Laws,
    actions: &mut [Action],
) {
    let mut met = [Met::default(); BLOCKS];
    let mut powers = [[Lanes::default(); 2]; BLOCKS];
    for ((block, on), met) in blocks.iter().zip(on).zip(&mut met) {
        *met = match block.wall(laws.constants) {
            None => block.meet(on),
            Some(wall) => block.meet_wall(wall, &on[1]),
        };
    }
    if SIMPLE || laws.constants.law.contact.springs == Springs::HertzMindlin {
        for ((overlap, ..), powers) in met[..blocks.len()].iter().zip(&mut powers) {
            // The library is not asked for the sake of those that do not touch.
            let touches = overlap.reaches(Lanes::all(0.0));
            let [shown] = touches.choose([*overlap], [Lanes::all(0.5)]);
            *powers = laws.powers.of(shown);
        }
    }
    let acting = blocks.iter_mut().zip(on).zip(actions);
    for ((((block, on), action), met), powers) in acting.zip(&met).zip(&powers) {
        *action = laws.act::<SIMPLE>(block, on, *met, *powers);
    }
}

/// What eight contacts do by the law.
struct Laws<'a> {
    constants: &'a Constants,
    powers: Powers,
}

impl Laws<'_> {
    /// Whether the law is Hertz's and Mindlin's with what is usual and nothing more. Whoever asks must not be told why: a compiler
    /// that knows it makes one long formula of the law, and sees no vectors in it.
    #[inline(never)]
    fn is_simple(&self) -> bool {
        let (law, rules) = (&self.constants.law, &self.constants.rules);
        law.contact.springs == Springs::HertzMindlin
            && !law.has_dashpots()
            && law.contact.adhesion.is_none()
            && law.contact.rolling.is_none()
            && rules.slip != Slip::ContactPoint
            && rules.torque_arms == Arms::ContactPoint
    }

    /// As the reference's `act`, of bodies that move and meet so.
    #[inline(always)]
    fn act<const SIMPLE: bool>(
        &self,
        block: &mut Block,
        on: &[Motions; 2],
        (u, n, point): Met,
        [root, power]: [Lanes; 2],
    ) -> Action {
        let (constants, law, rules) = (self.constants, &self.constants.law, &self.constants.rules);
        let (all, none) = (Lanes::all, [Lanes::all(0.0); 3]);
        let contact = &law.contact;
        let is_linear = !SIMPLE && contact.springs == Springs::Linear;
        let dashpots = !SIMPLE && law.has_dashpots();
        let adhesion = contact.adhesion.filter(|_| !SIMPLE);
        let rolling = contact.rolling.filter(|_| !SIMPLE);
        let points = [
            !SIMPLE && rules.slip == Slip::ContactPoint,
            SIMPLE || rules.torque_arms == Arms::ContactPoint,
        ];
        let clips = dashpots && rules.tension == TensionRule::Cut;
        let dt = all(constants.dt);
        let Block {
            k_n,
            k_s,
            mass,
            tangent,
            ..
        } = *block;
        let pull = adhesion.map_or(all(0.0), |_| block.pull);
        let touches = u.reaches(all(0.0));

        // The constants at this overlap.
        let (elastic, k_n, k_s) = match is_linear {
            true => (k_n * u, k_n, k_s),
            false => (k_n * power, all(1.5) * k_n * root, k_s * root),
        };
        let by_ratio = |ratio: f64, k: Lanes| all(2.0 * ratio) * (mass * k).sqrt();
        let [normal_ratio, along_ratio] = constants.damping_ratios;

        // The normal force.
        let with_points = dashpots || points[0];
        let at_contact_point = match with_points {
            true => minus(on[1].at(point), on[0].at(point)),
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
                match (clips, adhesion) {
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
        let before = block.normal;
        let turn = cross(before, n);
        let spins = plus(on[0].spin, on[1].spin);
        let about = times(all(0.5 * constants.dt) * dot(before, spins), before);
        let turns = [turn, about];
        let [r1, r2] = block.radii;
        let relative = match points[0] {
            true => at_contact_point,
            false => {
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
        let shear = match slides.and(touches).any() {
            true => slides.choose(times(limit / squared.sqrt(), shear), shear),
            false => shear,
        };
        let tangential = match dashpots && !is_linear {
            true => {
                let c_s = by_ratio(along_ratio, k_s);
                let braking = times(-c_s, each(times(dt, slip), |way| way / dt));
                [block.slides] = slides.and(touches).choose([all(1.0)], [all(0.0)]);
                slides.choose(shear, plus(shear, braking))
            }
            false => shear,
        };
        let force = plus(normal_force, tangential);

        // Moments against rolling and twisting.
        let mut moments = [none; 2];
        if let Some(rolling) = rolling {
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
            block.moments = [
                touches.choose(bending, none),
                touches.choose(twisting, none),
            ];
        }

        // Torques of the force.
        let on_first = each(force, |part| -part);
        let torques = match points[1] {
            true => [
                cross(minus(point, on[0].place), on_first),
                cross(minus(point, on[1].place), force),
            ],
            false => {
                let turn = cross(n, on_first);
                [r1, r2].map(|radius| times(radius - all(0.5) * u, turn))
            }
        };
        block.overlap = u;
        block.normal = touches.choose(n, none);
        block.shear = touches.choose(shear, none);
        block.force = touches.choose(force, none);
        let moment = plus(moments[0], moments[1]);
        Action {
            torques: [
                touches.choose(torques[0], none),
                touches.choose(torques[1], none),
            ],
            moment: touches.choose(moment, none),
        }
    }
}
