//! The law of [`super::contact`] between grains, eight pairs at a time: what each contact does is computed in vector lanes,
//! then added pair after pair in the order of the list, as the sorted loop does. No operation is fused, left out or
//! reordered, so every lane has the bits of the scalar law.
//!
//! A pair that does not touch has a memory of zeros, and what it adds are zeros. A sum that begins at +0 is never −0, so
//! adding a zero changes no bit of it.

use std::ops::Range;

use multiversion::multiversion;

use super::contact::{ContactRules, Memory, Parameters};
use super::lanes::{LANES, Lanes, Mask};
use super::state::State;
use crate::scene::{NewContactSlip, SlipVelocity, Tension, TorqueArms};

type Vector = [Lanes; 2];

/// Eight listed pairs: their grains, counted from the first place of all, their parameters, and what they remember. Places left over in the last block
/// hold pairs of the first place with itself that never touch.
#[derive(Debug, Clone, Default)]
pub struct Block {
    first: [u32; LANES],
    second: [u32; LANES],
    /// R_1 and R_2, m; −1 in a place that is left over.
    radius: Vector,
    k_n: Lanes,
    k_s: Lanes,
    c_n: Lanes,
    normal: Vector,
    shear: Vector,
}

/// The listed pairs in the order of their sums. Reused from build to build.
#[derive(Debug, Clone, Default)]
pub struct Pairs {
    blocks: Vec<Block>,
    len: usize,
    /// Where their grains are.
    places: Range<usize>,
    sums: Vec<Sum>,
}

/// Force across and up, N; torque, N·m; nothing.
type Sum = [f64; 4];

impl Pairs {
    /// Forgets all pairs; the new ones are of grains at these places.
    pub fn clear(&mut self, places: Range<usize>) {
        self.blocks.clear();
        self.len = 0;
        self.places = places;
    }

    /// Lists one more pair.
    pub fn push(
        &mut self,
        [first, second]: [usize; 2],
        radii: [f64; 2],
        parameters: &Parameters,
        memory: &Memory,
    ) {
        let lane = self.len % LANES;
        if lane == 0 {
            self.blocks.push(Block {
                radius: [Lanes::all(-1.0); 2],
                ..Block::default()
            });
        }
        self.len += 1;
        let block = self.blocks.last_mut().expect("one with a free lane");
        let from = self.places.start;
        (block.first[lane], block.second[lane]) = ((first - from) as u32, (second - from) as u32);
        let put = |to: &mut Vector, [a, b]: [f64; 2]| (to[0].0[lane], to[1].0[lane]) = (a, b);
        put(&mut block.radius, radii);
        put(&mut block.normal, memory.normal);
        put(&mut block.shear, memory.shear);
        block.k_n.0[lane] = parameters.k_n;
        block.k_s.0[lane] = parameters.k_s;
        block.c_n.0[lane] = parameters.c_n;
    }

    /// The places of each listed pair and what it remembers.
    pub fn memories(&self) -> impl Iterator<Item = ([usize; 2], Memory)> {
        (0..self.len).map(|at| {
            let (block, lane) = (&self.blocks[at / LANES], at % LANES);
            let components = |vector: &Vector| [vector[0].0[lane], vector[1].0[lane]];
            let memory = Memory {
                normal: components(&block.normal),
                shear: components(&block.shear),
            };
            let grains = [block.first[lane], block.second[lane]];
            (
                grains.map(|grain| self.places.start + grain as usize),
                memory,
            )
        })
    }

    /// Forces and torques of all listed pairs, summed on the grains from place `first` on; what was there before is lost.
    /// Every contact's memory moves on by a step.
    pub fn sum_forces(
        &mut self,
        state: &State,
        rules: &ContactRules,
        first: usize,
        (force, torque): (&mut [[f64; 2]], &mut [f64]),
    ) {
        self.sums.clear();
        self.sums.resize(self.places.len(), [0.0; 4]);
        let (blocks, sums) = (&mut self.blocks, &mut self.sums);
        sum_forces(blocks, (state, &self.places), rules, sums);
        let own = &self.sums[first - self.places.start..];
        for ((force, torque), [x, z, turn, _]) in force.iter_mut().zip(torque).zip(own) {
            *force = [*x, *z];
            *torque = *turn;
        }
    }
}

/// [`sum_forces_plain`], compiled for the widest vector unit that the machine has.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn sum_forces(
    blocks: &mut [Block],
    grains: (&State, &Range<usize>),
    rules: &ContactRules,
    sums: &mut [Sum],
) {
    sum_forces_plain(blocks, grains, rules, sums);
}

/// Blocks that are computed before what they do is added: a few, so that it stays near.
const CHUNK: usize = 8;

#[inline(always)]
fn sum_forces_plain(
    blocks: &mut [Block],
    (state, places): (&State, &Range<usize>),
    rules: &ContactRules,
    sums: &mut [Sum],
) {
    let grains = Grains::of(state, places);
    let mut actions: [Action; CHUNK] = Default::default();
    for blocks in blocks.chunks_mut(CHUNK) {
        for (block, action) in blocks.iter_mut().zip(&mut actions) {
            *action = act(block, &grains, rules);
        }
        for (block, action) in blocks.iter().zip(&actions) {
            for lane in 0..LANES {
                let [x, z] = [action.force[0].0[lane], action.force[1].0[lane]];
                let [one, two] = [action.torques[0].0[lane], action.torques[1].0[lane]];
                add(&mut sums[block.first[lane] as usize], [-x, -z, one, 0.0]);
                add(&mut sums[block.second[lane] as usize], [x, z, two, 0.0]);
            }
        }
    }
}

#[inline(always)]
fn add(sum: &mut Sum, more: Sum) {
    for (sum, more) in sum.iter_mut().zip(more) {
        *sum += more;
    }
}

/// What the contacts of a block do: [`super::contact::Action`] in lanes.
#[derive(Default)]
struct Action {
    force: Vector,
    torques: Vector,
}

/// One side of the contacts of a block.
#[derive(Default)]
struct Side {
    position: Vector,
    velocity: Vector,
    spin: Lanes,
}

/// How the grains at some places move: slices of one length, so that an index is checked once.
struct Grains<'a> {
    position: &'a [[f64; 2]],
    velocity: &'a [[f64; 2]],
    spin: &'a [f64],
}

impl<'a> Grains<'a> {
    #[inline(always)]
    fn of(state: &'a State, places: &Range<usize>) -> Self {
        let all = places.len();
        Grains {
            position: &state.position[places.start..][..all],
            velocity: &state.velocity[places.start..][..all],
            spin: &state.spin[places.start..][..all],
        }
    }
}

#[inline(always)]
fn gather(grains: &Grains, ids: &[u32; LANES]) -> Side {
    let mut side = Side::default();
    for (lane, id) in ids.iter().enumerate() {
        let id = *id as usize;
        [side.position[0].0[lane], side.position[1].0[lane]] = grains.position[id];
        [side.velocity[0].0[lane], side.velocity[1].0[lane]] = grains.velocity[id];
        side.spin.0[lane] = grains.spin[id];
    }
    side
}

/// [`ContactRules::act`] with [`super::contact::grains`], in its order of operations.
#[inline(always)]
fn act(block: &mut Block, grains: &Grains, rules: &ContactRules) -> Action {
    let one = gather(grains, &block.first);
    let two = gather(grains, &block.second);
    let zero = Lanes::all(0.0);
    let [r1, r2] = block.radius;
    let way = difference(two.position, one.position);
    let distance = dot(way, way).sqrt();
    let overlap = r1 + r2 - distance;
    let touching = overlap.reaches(zero);
    let normal = [way[0] / distance, way[1] / distance];
    let half_overlap = Lanes::all(0.5) * overlap;
    let mut arms = [[zero; 2]; 2];
    let mut at_point = [zero; 2];
    if rules.needs_points() {
        let point = sum(one.position, times(normal, r1 - half_overlap));
        arms = [
            difference(point, one.position),
            difference(point, two.position),
        ];
        at_point = difference(
            sum(two.velocity, cross(two.spin, arms[1])),
            sum(one.velocity, cross(one.spin, arms[0])),
        );
    }

    let mut size = block.k_n * overlap;
    if rules.dashpots {
        size = size - block.c_n * dot(normal, at_point);
    }
    let mut normal_force = times(normal, size);
    if rules.dashpots && rules.tension == Tension::Clipped {
        let pulls = zero.exceeds(size);
        normal_force = pulls.choose([zero; 2], normal_force);
    }

    let mut force = normal_force;
    if rules.friction {
        let mut relative = at_point;
        if rules.slip_velocity == SlipVelocity::RatchetingCorrected {
            let stretch = (r1 + r2) / (r1 + r2 - overlap);
            let of_two = cross(two.spin, times(normal, -r2));
            let of_one = cross(one.spin, times(normal, r1));
            let apart = times(difference(two.velocity, one.velocity), stretch);
            relative = difference(sum(apart, of_two), of_one);
        }
        let shear = move_on(block, rules, normal, overlap, normal_force, relative);
        block.shear = touching.choose(shear, [zero; 2]);
        force = sum(normal_force, shear);
    }
    block.normal = touching.choose(normal, [zero; 2]);

    let mut torques = [zero; 2];
    if rules.rotates {
        let on_one = [-force[0], -force[1]];
        torques = match rules.torque_arms {
            TorqueArms::HalfOverlap => {
                let turn = torque(normal, on_one);
                [(r1 - half_overlap) * turn, (r2 - half_overlap) * turn]
            }
            TorqueArms::ContactPoint => [torque(arms[0], on_one), torque(arms[1], force)],
        };
    }
    Action {
        force: touching.choose(force, [zero; 2]),
        torques: touching.choose(torques, [zero; 2]),
    }
}

/// The shear force after this step; that of a pair which did not touch begins at zero.
#[inline(always)]
fn move_on(
    block: &Block,
    rules: &ContactRules,
    normal: Vector,
    overlap: Lanes,
    normal_force: Vector,
    relative: Vector,
) -> Vector {
    let turn = block.normal[1] * normal[0] - block.normal[0] * normal[1];
    let [sx, sz] = block.shear;
    let turned = [sx + sz * turn, sz - sx * turn];
    let along = dot(normal, relative);
    let slip = difference(relative, times(normal, along));
    let dt = Lanes::all(rules.dt);
    let mut growth = if rules.dashpots {
        times(slip, block.k_s * dt)
    } else {
        times(times(slip, dt), block.k_s)
    };
    if rules.new_contact_slip == NewContactSlip::SinceTouch {
        let way = -along * dt;
        let timed = way.exceeds(overlap).but_not(block.touched());
        growth = timed.choose(times(growth, overlap / way), growth);
    }
    let shear = difference(turned, growth);
    let limit_squared = dot(normal_force, normal_force) * Lanes::all(rules.tan_squared);
    let squared = dot(shear, shear);
    let slides = squared.exceeds(limit_squared);
    if !slides.any() {
        return shear;
    }
    let ratio = limit_squared.sqrt() / squared.sqrt();
    slides.choose(times(shear, ratio), shear)
}

impl Block {
    /// Which pairs touched a step ago.
    #[inline(always)]
    fn touched(&self) -> Mask {
        let [x, z] = self.normal;
        (x * x + z * z).exceeds(Lanes::all(0.0))
    }
}

#[inline(always)]
fn dot(a: Vector, b: Vector) -> Lanes {
    a[0] * b[0] + a[1] * b[1]
}

#[inline(always)]
fn times(a: Vector, by: Lanes) -> Vector {
    [a[0] * by, a[1] * by]
}

#[inline(always)]
fn sum(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1]]
}

#[inline(always)]
fn difference(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1]]
}

/// ω × a.
#[inline(always)]
fn cross(spin: Lanes, arm: Vector) -> Vector {
    [spin * arm[1], -(spin * arm[0])]
}

/// (a × F) about y.
#[inline(always)]
fn torque(arm: Vector, force: Vector) -> Lanes {
    arm[1] * force[0] - arm[0] * force[1]
}

#[cfg(test)]
mod tests {
    use super::super::dynamics::Dynamics;
    use super::super::dynamics::tests::SKIN;
    use super::super::state::Constants;
    use super::super::threads::Threads;
    use super::*;
    use crate::generate::initial_bodies;
    use crate::model::Model;
    use crate::scene::{Viscosity, paper_scene};
    use crate::tables::Memories;

    /// The obvious version: the scalar law, one pair after the other in the order of the sorted loop.
    fn reference(state: &State, pairs: &Pairs, rules: &ContactRules) -> (Vec<Sum>, Vec<Memory>) {
        let mut sums = vec![[0.0; 4]; state.position.len()];
        let mut memories = Vec::new();
        for (at, ([a, b], mut memory)) in pairs.memories().enumerate() {
            let (block, lane) = (&pairs.blocks[at / LANES], at % LANES);
            let parameters = Parameters {
                k_n: block.k_n.0[lane],
                k_s: block.k_s.0[lane],
                c_n: block.c_n.0[lane],
            };
            let Some(touch) = state.grain_touch(a, b) else {
                memories.push(Memory::default());
                continue;
            };
            let action = rules.act(
                &touch,
                &parameters,
                &state.motion(a),
                &state.motion(b),
                &mut memory,
            );
            memories.push(memory);
            let [x, z] = action.force;
            (sums[a][0], sums[a][1]) = (sums[a][0] - x, sums[a][1] - z);
            (sums[b][0], sums[b][1]) = (sums[b][0] + x, sums[b][1] + z);
            sums[a][2] += action.torques[0];
            sums[b][2] += action.torques[1];
        }
        (sums, memories)
    }

    /// All laws that the general kernel has, on the paper's grains; 3,001 of them, so that a block stays unfilled.
    fn laws() -> Vec<Constants> {
        let viscosity = |tension| Viscosity::Dashpot {
            c_n: 900.0,
            tension,
        };
        let viscosities = [
            Viscosity::None,
            viscosity(Tension::Clipped),
            viscosity(Tension::Unclipped),
        ];
        let mut laws = Vec::new();
        for (friction_angle, viscosity) in [(0.0, 1), (0.0, 2), (0.5, 0), (0.1, 1), (0.5, 2)] {
            for slip_velocity in [
                SlipVelocity::RatchetingCorrected,
                SlipVelocity::ContactPoint,
            ] {
                for torque_arms in [TorqueArms::HalfOverlap, TorqueArms::ContactPoint] {
                    for new_contact_slip in [NewContactSlip::WholeStep, NewContactSlip::SinceTouch]
                    {
                        let scene = paper_scene(1, 3001);
                        let mut constants = Constants::new(&Model::of(&scene), 3001);
                        constants.change_law(|law| {
                            law.friction_angle = friction_angle;
                            law.stiffness_ratio = 0.3;
                            law.contact.viscosity = viscosities[viscosity].clone();
                            law.contact.slip_velocity = slip_velocity;
                            law.contact.torque_arms = torque_arms;
                            law.contact.new_contact_slip = new_contact_slip;
                        });
                        laws.push(constants);
                    }
                }
            }
        }
        laws
    }

    #[test]
    fn lanes_have_the_bits_of_the_scalar_law_summed_pair_after_pair() {
        let scene = paper_scene(1, 3001);
        let mut bodies = initial_bodies(&scene);
        let mass = bodies.mass.iter().zip(&bodies.radius);
        bodies.inertia = mass.map(|(m, r)| 0.5 * m * r * r).collect();
        bodies.spin = (0..bodies.len()).map(|id| (id as f64).sin()).collect();
        let (mut touching, mut sheared) = (0, 0);
        for constants in laws() {
            let rules = constants.contact_rules();
            let dynamics = Dynamics::new(
                &bodies,
                None,
                &Memories::default(),
                constants,
                SKIN,
                Threads::default(),
            );
            let mut dynamics = dynamics.expect("a sound start");
            for step in 1..=4000 {
                // What contacts remember of the step before; a list that was made anew has other pairs.
                let list = &dynamics.neighbours;
                let pairs = (step % 1999 == 0).then(|| list.shares[0].pairs.clone());
                let builds = list.builds;
                dynamics.step().expect("a sound step");
                let Some(pairs) = pairs.filter(|_| dynamics.neighbours.builds == builds) else {
                    continue;
                };
                let state = &dynamics.state;
                let (expected, memories) = reference(state, &pairs, &rules);
                let all = (state, &(0..state.position.len()));
                let plain = |blocks: &mut [Block], sums: &mut [Sum]| {
                    sum_forces_plain(blocks, all, &rules, sums);
                };
                let widest = |blocks: &mut [Block], sums: &mut [Sum]| {
                    sum_forces(blocks, all, &rules, sums);
                };
                for sum in [&plain as &dyn Fn(&mut [Block], &mut [Sum]), &widest] {
                    let mut after = pairs.clone();
                    let mut sums = vec![[0.0; 4]; expected.len()];
                    sum(&mut after.blocks, &mut sums);
                    for (id, (sum, expected)) in sums.iter().zip(&expected).enumerate() {
                        assert_eq!(
                            sum.map(f64::to_bits),
                            expected.map(f64::to_bits),
                            "grain {id}, step {step}: {sum:?} for {expected:?}, {rules:?}"
                        );
                    }
                    for (at, (expected, (_, memory))) in
                        memories.iter().zip(after.memories()).enumerate()
                    {
                        let bits = |memory: &Memory| {
                            let [[a, b], [c, d]] = [memory.normal, memory.shear];
                            [a, b, c, d].map(f64::to_bits)
                        };
                        assert_eq!(bits(&memory), bits(expected), "pair {at}, {rules:?}");
                    }
                }
                touching += memories.iter().filter(|memory| memory.touching()).count();
                sheared += memories
                    .iter()
                    .filter(|memory| memory.shear != [0.0; 2])
                    .count();
            }
        }
        assert!(touching > 10_000, "{touching}");
        assert!(sheared > 5_000, "{sheared}");
    }
}
