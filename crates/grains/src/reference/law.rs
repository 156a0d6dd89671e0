//! What a contact does: springs, dashpots, Coulomb's limit and torques, by the law and the rules.

use std::f64::consts::PI;
use std::hint::black_box;

use super::touch::Touch;
use super::{Ids, Memory, Motion, Placed, Reference, series};
use crate::model::Solid;
use crate::rules::{
    Arms, ArmsAtWalls, ConstantMoment, LimitFrom, MomentLimit, MomentTurn, MomentsAtWalls,
    NewContact, RestitutionFormula, Slip, SlipAdded, SlipAtWalls, SpringMemory, SpringTurn,
    SpringWhenSliding, StiffnessMean, TangentialDashpot, TensionRule, WallMass, WallRadius,
    WallStiffness,
};
use crate::scene::{AdhesionLaw, Rolling, Springs, Tension, Viscosity};
use crate::tables::Body;
use crate::variant::{Form, Input};
use crate::vector::{Vector, cross, dot, hypot, minus, norm, plus, times};

/// What is the same for two bodies as long as the law is.
#[derive(Clone, Copy)]
pub(super) struct Pair {
    /// k_n and k_s of linear springs, N/m. Of Hertz's F_n/u^1.5 and k_s/u^0.5, N/m^1.5.
    pub k_n: f64,
    pub k_s: f64,
    /// Effective mass, kg, and that of the dashpot along the tangent.
    pub mass: f64,
    pub mass_along: f64,
    /// tan φ.
    pub tangent: f64,
    /// Pull of adhesion, N; of Johnson, Kendall and Roberts the largest one.
    pub pull: f64,
}

impl Pair {
    /// u/R* of Johnson, Kendall and Roberts where the pull is largest and the contact ends, in the way of [`Pair::root`].
    fn least_root(&self) -> f64 {
        (self.pull / self.k_n).cbrt()
    }

    /// The overlap at which such a contact ends, below 0, m.
    pub(super) fn least_overlap(&self) -> f64 {
        let root = self.least_root();
        -root * root / 3.0
    }

    fn root(&self, overlap: f64) -> f64 {
        root_of_jkr(self.k_n, self.pull, overlap)
    }
}

/// r = a/√R* of a contact of Johnson, Kendall and Roberts with the radius a at this overlap u, where F_n/u^1.5 without adhesion is k and
/// the largest pull P: the largest root of a²/R* − 2√(πγa/E*) = u, from above by Newton's way.
fn root_of_jkr(k_n: f64, pull: f64, overlap: f64) -> f64 {
    let energy = pull / k_n;
    let mut root = overlap.max(0.0).sqrt() + (16.0 / 9.0 * energy).cbrt();
    loop {
        let pulled = 4.0 / 3.0 * (energy * root).sqrt();
        let next = root - (root * root - pulled - overlap) / (2.0 * root - 0.5 * pulled / root);
        if next >= root || next.is_nan() {
            return root;
        }
        root = next;
    }
}

/// r of such a contact and ∫F du from where a is 0, J: 2/5 k r⁵ − 4/3 √(P k) r^3.5 + 2/3 P r².
pub(crate) fn energy_of_jkr(k_n: f64, pull: f64, overlap: f64) -> (f64, f64) {
    let root = root_of_jkr(k_n, pull, overlap);
    let [spring, both] = [
        0.4 * k_n * root.powi(5),
        (pull * k_n).sqrt() * root.powf(3.5),
    ];
    (
        root,
        spring - 4.0 / 3.0 * both + 2.0 / 3.0 * pull * root * root,
    )
}

/// A contact's constants at its overlap.
pub(super) struct Strength {
    /// Force of the normal spring, N.
    pub elastic: f64,
    /// Its slope.
    pub k_n: f64,
    pub k_s: f64,
    pub c_n: f64,
    /// Of the dashpot along the tangent.
    c_s: f64,
}

impl Strength {
    /// With the dashpots of the other.
    pub(super) fn take_dashpots(&mut self, other: &Strength) {
        (self.c_n, self.c_s) = (other.c_n, other.c_s);
    }
}

/// What a contact does in a step.
pub(super) struct Action {
    /// On body 2, N.
    pub force: Vector,
    /// On body 1 and body 2 by the force, N·m.
    pub torques: [Vector; 2],
    /// On body 2 by rolling and twisting, N·m; body 1 feels the opposite.
    pub moment: Vector,
    /// Where the law has friction.
    pub memory: Option<Memory>,
}

/// What a contact's table does not tell of its tangential force.
pub struct ByTable {
    /// The normal force that these places and velocities make, N.
    pub normal_force: f64,
    /// Coulomb's limit by that force and by the one that is told, N.
    pub limits: [f64; 2],
    /// What a dashpot along the tangent does, on body 2, N.
    pub braking: Vector,
    /// It does so while the contact slides too.
    pub brakes_sliding: bool,
}

/// What a contact had a step ago, as its table tells it.
#[derive(Debug, Clone, Copy)]
pub struct Told {
    pub normal: Vector,
    /// Of the spring along the tangent, N/m.
    pub k_s: f64,
    /// Tangential force on body 2, and the whole force on it, N.
    pub tangential: Vector,
    pub force: Vector,
    /// What the dashpot along the tangent did or would have done, N, and whether it did.
    pub braking: Vector,
    pub brakes: bool,
    /// What the slip of that step added, N.
    pub slip: Vector,
    /// Moments against rolling and twisting, and that against rolling had it no limit or one of each component, N·m.
    pub moments: [Vector; 2],
    pub without_limit: Vector,
    pub by_component: Vector,
}

impl Told {
    /// What a contact of these bodies remembers that had this a step ago.
    pub(super) fn memory(&self, ids: Ids, pair: Pair) -> Memory {
        Memory {
            normal: self.normal,
            shear: match self.brakes {
                true => minus(self.tangential, self.braking),
                false => self.tangential,
            },
            k_s: self.k_s,
            bending: self.moments[0],
            twisting: self.moments[1],
            ..Memory::new(ids, pair)
        }
    }
}

/// The terms of a contact's law, each by itself: forces on body 2, N.
#[derive(Debug, Clone, Copy)]
pub struct Parts {
    pub first: Body,
    pub radii: [f64; 2],
    pub effective_mass: f64,
    /// Of the spring along the normal, of its dashpot and of adhesion, which pulls by so much.
    pub elastic: f64,
    pub viscous: f64,
    pub pull: f64,
    /// All of them, cut where the rules cut.
    pub normal_force: f64,
    pub c_n: f64,
    pub c_s: f64,
    pub k_s: f64,
    pub tangent: f64,
    /// Coulomb's limit by the normal force that is told.
    pub limit: f64,
    /// The spring's force of the step before, and what turning with the normal and about it adds.
    pub kept: Vector,
    pub turns: [Vector; 2],
    /// What turning about the normal adds by each spin alone.
    pub twists: [Vector; 2],
    /// Turned as the spring: the force that was told, what its dashpot did and what the slip added.
    pub turned: [Vector; 3],
    /// What this step's slip adds by the centres and by each spin; in its first step a contact gets this share.
    pub slips: [Vector; 3],
    /// The force of the normal dashpot and the slip by the velocity of the first alone, where it is no grain, and so had it what it has along
    /// z along x, and along y, N.
    pub first_alone: [(f64, Vector); 3],
    pub share: f64,
    /// How far bodies approach in this step, m.
    pub way: f64,
    /// What the dashpot along the tangent does by the centres and by each spin, and whether it acts while the contact slides.
    pub brakings: [Vector; 3],
    /// Tangential force by these.
    pub tangential: Vector,
    /// Torques on both of the force that is told, of the dashpot along the tangent, and of what Coulomb's limit has cut, N·m.
    pub torques: [Vector; 2],
    pub braking_torques: [Vector; 2],
    pub cut_torques: [Vector; 2],
    /// Torques that the force of the step before has at this step's arms, N·m.
    pub late_torques: [Vector; 2],
    /// Moments against rolling and twisting, what this step adds to them, and that against rolling had it no limit or one of each component
    /// by itself, N·m.
    pub moments: [Vector; 2],
    pub added: [Vector; 2],
    pub without_limit: Vector,
    pub by_component: Vector,
    /// What the step adds to that against rolling by each spin alone, or all of it where it is a constant torque, N·m.
    pub rolling_alone: [Vector; 2],
    /// What the stiffness against rolling would make of the twist, N·m.
    pub twist_as_rolling: Vector,
    /// What is kept of the moments against rolling and twisting of the step before, and what would be were either taken for the other, N·m.
    pub kept_moments: [Vector; 2],
    pub exchanged_moments: [Vector; 2],
    /// The largest moment against rolling, N·m; endless without a limit.
    pub most_moment: f64,
}

const NONE: Vector = [0.0; 3];
/// What the tangential spring has along the normal is no larger a share of a contact's forces.
const TOLD_WITH_IT: f64 = 1.0e-6;

impl Reference {
    /// Both numbers of a contact, or what another engine takes for both.
    fn numbers(&self, input: Input, both: [f64; 2]) -> [f64; 2] {
        let whose = self.variant.taken_for(input);
        whose.map_or(both, |whose| whose.of_numbers(both))
    }

    /// Both materials, or what another engine takes for both.
    fn solids(&self, both: [Solid; 2], moduli: Input, ratios: Input) -> [Solid; 2] {
        let modulus = self.numbers(moduli, both.map(|solid| solid.modulus));
        let ratio = self.numbers(ratios, both.map(|solid| solid.poissons_ratio));
        [0, 1].map(|at| Solid {
            modulus: modulus[at],
            poissons_ratio: ratio[at],
            ..both[at]
        })
    }

    /// What these bodies have between them; a flat one has the grain's radius.
    pub(super) fn pair(&self, ids: Ids) -> Pair {
        let first = self.constants.ids.body(ids.0);
        let (constants, law) = (&self.constants, &self.constants.law);
        let material = |i: usize| law.solid(self.sizes.material.get(i).copied().unwrap_or(0));
        let two = ids.1 as usize;
        let m2 = self.sizes.mass[two];
        let (radii, masses, solids) = match first {
            Body::Grain => {
                let one = ids.0 as usize;
                let m1 = self.sizes.mass[one];
                let radii = [one, two].map(|i| self.stiffness_radius[i]);
                let both = self.numbers(Input::Masses, [m1, m2]);
                let masses = [Input::NormalMasses, Input::TangentialMasses].map(|input| {
                    let [m1, m2] = self.numbers(input, both);
                    m1 * m2 / (m1 + m2)
                });
                (radii, masses, [one, two].map(material))
            }
            flat => {
                let radii = match flat {
                    Body::Wall => &self.stiffness_radius,
                    _ => &self.sizes.radius,
                };
                let solids = [law.solid(0), material(two)];
                let radii = self.radii_at_obstacle(ids.0, radii[two]);
                (radii, [self.wall_mass(m2); 2], solids)
            }
        };
        let radii = self.numbers(Input::StiffnessRadii, radii);
        let tangential_radii = self.numbers(Input::TangentialRadii, radii);
        let [one, two] = solids;
        let both = |solids: [Solid; 2], input: Input| {
            let whose = self.variant.taken_for(input);
            whose.map_or(solids, |whose| whose.both(solids, |solid| solid.modulus))
        };
        let of_both = both(solids, Input::Materials);
        let [of_normal, of_tangential] =
            [Input::NormalMaterials, Input::TangentialMaterials].map(|input| both(of_both, input));
        let of_normal = self.solids(of_normal, Input::NormalModuli, Input::NormalPoissons);
        let of_tangential = self.solids(
            of_tangential,
            Input::TangentialModuli,
            Input::TangentialPoissons,
        );
        let (mut k_n, mut k_s, pull) = match law.contact.springs {
            Springs::Linear => {
                let [[a, b], [c, d]] = [(of_normal, radii), (of_tangential, tangential_radii)]
                    .map(|([one, two], radii)| [one.modulus * radii[0], two.modulus * radii[1]]);
                let [one, two] = of_tangential;
                let [c, d] = [c * one.stiffness_ratio, d * two.stiffness_ratio];
                match law.has_dashpots() {
                    false => (2.0 * a * b / (a + b), 2.0 * c * d / (c + d), 0.0),
                    true => (series(a, b), series(c, d), 0.0),
                }
            }
            Springs::HertzMindlin => {
                let mixed = |[one, two]: [f64; 2]| match self.rules().wall_radius {
                    WallRadius::Flat if first != Body::Grain => two,
                    _ => one * two / (one + two),
                };
                let [[k_n, _], [_, mut k_s]] =
                    [(of_normal, radii), (of_tangential, tangential_radii)]
                        .map(|([one, two], radii)| one.hertz_mindlin(two, mixed(radii)));
                if self.variant.taken_for(Input::PoissonsOverShear).is_some() {
                    let own = of_tangential.map(|solid| solid.poissons_ratio);
                    // 2/G* with these ν beside the materials' G.
                    let give = |ratios: [f64; 2]| -> f64 {
                        let both = of_tangential.iter().zip(ratios);
                        both.map(|(solid, ratio)| {
                            (2.0 - ratio) * (1.0 + solid.poissons_ratio) / solid.modulus
                        })
                        .sum()
                    };
                    k_s *= give(own) / give(self.numbers(Input::PoissonsOverShear, own));
                }
                let energy = law.contact.adhesion.unwrap_or(0.0);
                let radius = mixed(self.numbers(Input::AdhesionRadii, radii));
                let pull = match law.holds() {
                    true => 3.0 * PI * radius * energy,
                    false => 4.0 * PI * radius * energy,
                };
                (k_n, k_s, pull)
            }
        };
        let rigid = self.rules().wall_stiffness == WallStiffness::Rigid;
        if rigid && first != Body::Grain {
            k_n *= 2.0;
            k_s *= 2.0;
        }
        k_n *= constants.normal_factors[first as usize];
        k_s *= constants.tangential_factor;
        if first == Body::Grain && law.contact.springs == Springs::Linear {
            let [r1, r2] = radii;
            let mean = match self.rules().stiffness_mean {
                StiffnessMean::Harmonic => None,
                StiffnessMean::Arithmetic => Some(0.5 * (r1 + r2)),
                StiffnessMean::Geometric => Some((r1 * r2).sqrt()),
                StiffnessMean::Smaller => Some(r1.min(r2)),
                StiffnessMean::Larger => Some(r1.max(r2)),
            };
            if let Some(mean) = mean {
                let right = 2.0 * r1 * r2 / (r1 + r2);
                k_n *= mean / right;
                k_s *= mean / right;
            }
        }
        let whose = self.variant.forms.iter().find_map(|form| match form {
            Form::FrictionOf([at, whose]) if *at == first => Some(*whose),
            _ => None,
        });
        let whose = whose.unwrap_or(first);
        let mut tangent = self.tangents[whose as usize];
        let has_its_own = law.friction_of_its_own(whose).is_some();
        if !law.materials.is_empty() && !has_its_own {
            let angles = [one.friction_angle, two.friction_angle];
            let [one, two] = self.numbers(Input::FrictionAngles, angles);
            tangent = one.min(two).tan();
        }
        Pair {
            k_n,
            k_s,
            mass: masses[0],
            mass_along: masses[1],
            tangent,
            pull,
        }
    }

    /// The constants of these bodies' contact at this overlap.
    pub(super) fn strength(&self, ids: Ids, touch: &Touch, pair: &Pair) -> Strength {
        self.strength_at(ids, touch.overlap, touch.first, pair)
    }

    pub(super) fn strength_at(&self, ids: Ids, u: f64, first: Body, pair: &Pair) -> Strength {
        let constants = &self.constants;
        let contact = &constants.law.contact;
        let (elastic, k_n, k_s) = match contact.springs {
            Springs::Linear => (pair.k_n * u, pair.k_n, pair.k_s),
            Springs::HertzMindlin if constants.law.holds() => {
                let root = pair.root(u);
                // 4 E* a³/(3 R*) − 4 a^1.5 √(π γ E*) is (p − √A)² − A.
                let above = (pair.k_n * root * root * root).sqrt() - pair.pull.sqrt();
                (above * above, 1.5 * pair.k_n * root, pair.k_s * root)
            }
            Springs::HertzMindlin => {
                let root = power(u, 0.5);
                (
                    pair.k_n * power(u, 1.5),
                    1.5 * pair.k_n * root,
                    pair.k_s * root,
                )
            }
        };
        let by_ratio = |ratio: f64, mass: f64, k: f64| 2.0 * ratio * (mass * k).max(0.0).sqrt();
        let [normal, along] = constants.damping_ratios;
        let mut c_n = match contact.viscosity {
            Viscosity::None => 0.0,
            Viscosity::Dashpot { c_n, .. } => series(c_n, c_n),
            Viscosity::Restitution { .. } | Viscosity::Ratio { .. } => {
                by_ratio(normal, pair.mass, k_n)
            }
        };
        c_n *= self.restitution_factor();
        if first == Body::Grain && self.has(Form::DashpotOfMeanMass) {
            let [m1, m2] = [ids.0, ids.1].map(|id| self.sizes.mass[id as usize]);
            c_n *= 0.5 * (m1 + m2) / (m1 * m2).sqrt() * std::f64::consts::SQRT_2;
        }
        let c_s = match contact.springs {
            Springs::Linear => c_n,
            Springs::HertzMindlin => by_ratio(along, pair.mass_along, k_s),
        };
        Strength {
            elastic,
            k_n,
            k_s,
            c_n,
            c_s,
        }
    }

    /// The effective mass at walls and punch, kg.
    fn wall_mass(&self, mass: f64) -> f64 {
        match self.rules().wall_mass {
            WallMass::Whole => mass,
            WallMass::Half => 0.5 * mass,
        }
    }

    /// The dashpot by the chosen formula over that of the model.
    fn restitution_factor(&self) -> f64 {
        let Viscosity::Restitution { e_n, tension } = self.constants.law.contact.viscosity else {
            return 1.0;
        };
        let chosen = match self.rules().restitution {
            RestitutionFormula::Cut => Tension::Clipped,
            _ => Tension::Unclipped,
        };
        if chosen == tension {
            return 1.0;
        }
        let springs = self.constants.law.contact.springs;
        match springs.damping_ratio(e_n, tension) {
            0.0 => 1.0,
            ratio => springs.damping_ratio(e_n, chosen) / ratio,
        }
    }

    /// How the first of a pair and its grain move; what other forms leave out is left out.
    pub(super) fn motions(&self, ids: Ids, touch: &Touch) -> [Motion; 2] {
        let spins = !self.has(Form::SlipOfCentres);
        let grain = |id: u32| {
            let motion = self.motions[id as usize];
            let spin = if spins { motion.spin } else { NONE };
            Motion { spin, ..motion }
        };
        let obstacle = || self.obstacle_of(ids.0);
        let mut one = match (touch.first, &self.felt) {
            (Body::Grain, _) => grain(ids.0),
            (Body::Punch, Some(punch)) => Motion::from(punch),
            _ => {
                obstacle().map_or_else(Motion::default, |obstacle| obstacle.motion_at(touch.point))
            }
        };
        if touch.first == Body::Wall && self.has(Form::ObstacleSpinUnfelt) {
            let own = obstacle().map_or(NONE, |obstacle| obstacle.motion.velocity);
            (one.velocity, one.spin) = (own, NONE);
        }
        if touch.first == Body::Wall && self.has(Form::ObstacleTurnsAboutOrigin) {
            let about = |obstacle: &Placed| cross(obstacle.motion.spin, obstacle.motion.place);
            one.velocity = plus(one.velocity, obstacle().map_or(NONE, about));
        }
        if touch.first == Body::Wall && self.has(Form::ObstacleVelocityUnfelt) {
            let own = obstacle().map_or(NONE, |obstacle| obstacle.motion.velocity);
            one.velocity = minus(one.velocity, own);
        }
        [one, grain(ids.1)]
    }

    /// Where these bodies touch, if they do.
    pub(super) fn touch_of(&self, ids: Ids) -> Option<&Touch> {
        let at = self.touching.binary_search_by_key(&ids, |pair| pair.ids);
        at.ok().map(|at| &self.touching[at].touch)
    }

    /// What these bodies' contact does besides its spring along the tangent, where its table tells this normal force; none where they do
    /// not touch.
    pub fn by_table(&self, ids: (u32, u32), normal_force: f64) -> Option<ByTable> {
        let touch = self.touch_of(ids)?;
        let pair = self.pair(ids);
        let strength = self.strength(ids, touch, &pair);
        let on = self.motions(ids, touch);
        let made = self.normal_force(touch, on, &strength, pair.pull);
        let told = times(normal_force, touch.normal);
        Some(ByTable {
            normal_force: dot(made, touch.normal),
            limits: [made, told].map(|force| self.limit(&pair, &strength, force).0),
            braking: self.braking(&strength, self.slip(touch, on).0),
            brakes_sliding: self.rules().tangential_dashpot != TangentialDashpot::WhileSticking,
        })
    }

    /// The terms of these bodies' contact, whose table tells this normal force and the tangential force that follows it; `before` is
    /// what it told a step ago. None where they do not touch.
    pub fn parts(
        &self,
        ids: (u32, u32),
        (normal_force, tangential): (f64, Vector),
        before: Option<Told>,
    ) -> Option<Parts> {
        let touch = self.touch_of(ids)?;
        let pair = self.pair(ids);
        let strength = self.strength(ids, touch, &pair);
        let on = self.motions(ids, touch);
        let told = times(normal_force, touch.normal);
        let made = self.normal_force(touch, on, &strength, pair.pull);
        let viscous = -strength.c_n * dot(touch.normal, at_contact_point(touch, on));
        // Of each alone: the slip is linear in velocities and spins.
        let alone = |which: usize| {
            let one = [0, 1].map(|side| Motion {
                velocity: if which == 0 { on[side].velocity } else { NONE },
                spin: if which == side + 1 {
                    on[side].spin
                } else {
                    NONE
                },
                ..on[side]
            });
            self.slip(touch, one).0
        };
        let slips = [0, 1, 2].map(alone);
        let growth = strength.k_s * self.constants.dt;
        let memory = before.map(|told| told.memory(ids, pair));
        let slip = self.slip(touch, on);
        let (tangential_by_law, ..) =
            self.shear(touch, on, (&pair, &strength), told, memory.as_ref(), slip);
        let kept = memory.map_or(NONE, |memory| self.rescaled(&memory, &strength));
        let ([with, both], twists) = memory.map_or(([kept; 2], [NONE; 2]), |memory| {
            let turned = |has_spin: [bool; 2]| {
                let on = [0, 1].map(|side| Motion {
                    spin: if has_spin[side] { on[side].spin } else { NONE },
                    ..on[side]
                });
                self.turned(memory.normal, kept, touch, on)
            };
            let with = turned([false; 2]);
            let alone = [[true, false], [false, true]].map(|spin| minus(turned(spin), with));
            ([with, turned([true; 2])], alone)
        });
        let turns = [minus(with, kept), minus(both, with)];
        let way = -slip.1 * self.constants.dt;
        let share = match self.rules().new_contact {
            _ if before.is_some() => 1.0,
            NewContact::SinceTouch if way > touch.overlap => touch.overlap / way,
            NewContact::Nothing => 0.0,
            _ => 1.0,
        };
        let rolling = self.constants.law.contact.rolling;
        // What the tangential spring has along the normal is told with the normal force, and limits nothing.
        let size = strength.elastic.abs() + norm(tangential);
        let force = match norm(minus(told, made)) <= TOLD_WITH_IT * size {
            true => made,
            false => told,
        };
        let moments_of = |on: [Motion; 2], limited: bool, memory: Option<&Memory>| {
            rolling.map_or([NONE; 2], |rolling| {
                let limit = rolling.limit.filter(|_| limited);
                let rolling = Rolling { limit, ..rolling };
                let constants = (&pair, &strength);
                let [bending, twisting, _] =
                    self.moments(&rolling, touch, on, constants, force, memory);
                [bending, twisting]
            })
        };
        let moments = |limited: bool, memory: Option<&Memory>| moments_of(on, limited, memory);
        let is_constant = rolling.is_some_and(|rolling| rolling.bending_stiffness.is_none());
        let rolling_alone = [0, 1].map(|side| {
            let mut one = on;
            one[1 - side].spin = NONE;
            moments_of(one, is_constant, None)[0]
        });
        let stiffer = rolling.map_or(0.0, |rolling| {
            rolling.bending_stiffness.unwrap_or(0.0) / rolling.twisting_stiffness
        });
        let with_memory = moments(true, memory.as_ref());
        let twist_as_rolling = match stiffer.is_finite() {
            true => times(stiffer, with_memory[1]),
            false => NONE,
        };
        // Its velocity with components that are so many axes on.
        let first_along = |axes: usize| {
            let mut moves = on.map(|motion| Motion {
                velocity: NONE,
                spin: NONE,
                ..motion
            });
            if touch.first != Body::Grain {
                let [x, y, z] = on[0].velocity;
                moves[0].velocity = [[x, y, z], [z, x, y], [y, z, x]][axes];
            }
            let (slip, along) = self.slip(touch, moves);
            (-strength.c_n * along, times(-growth, slip))
        };
        let most_moment = rolling.map_or(f64::INFINITY, |rolling| {
            self.most_moment(&rolling, touch, (&pair, &strength), force)
        });
        // Without a limit in this step, by what was kept of another limit so far.
        let unlimited = |bending: fn(Told) -> Vector| {
            let kept = before.zip(memory).map(|(told, memory)| Memory {
                bending: bending(told),
                ..memory
            });
            moments(false, kept.as_ref())[0]
        };
        let by_component = unlimited(|told| told.by_component);
        let added = moments(false, None);
        let of_memory = |memory: Option<Memory>| {
            let all = memory.map_or(added, |memory| moments(false, Some(&memory)));
            [0, 1].map(|at| minus(all[at], added[at]))
        };
        Some(Parts {
            first: touch.first,
            radii: touch.radii,
            effective_mass: pair.mass,
            elastic: strength.elastic,
            viscous: if self.constants.law.has_dashpots() {
                viscous
            } else {
                0.0
            },
            pull: pair.pull,
            normal_force: dot(made, touch.normal),
            c_n: strength.c_n,
            c_s: strength.c_s,
            k_s: strength.k_s,
            tangent: pair.tangent,
            limit: self.limit(&pair, &strength, told).0,
            kept,
            turns,
            twists,
            turned: before.map_or([NONE; 3], |told| {
                let all = [told.tangential, told.braking, told.slip];
                all.map(|force| self.turned(told.normal, force, touch, on))
            }),
            slips: slips.map(|slip| times(-growth, slip)),
            first_alone: [0, 1, 2].map(first_along),
            share,
            way,
            brakings: slips.map(|slip| self.braking(&strength, slip)),
            tangential: tangential_by_law,
            torques: self.torques(touch, on, plus(told, tangential)),
            cut_torques: {
                let sum = |parts: [Vector; 3]| parts.into_iter().fold(NONE, plus);
                let trial = sum([kept, turns[0], turns[1]]);
                let trial = plus(trial, times(-share * growth, sum(slips)));
                self.torques(touch, on, minus(trial, tangential))
            },
            late_torques: before.map_or([NONE; 2], |told| self.torques(touch, on, told.force)),
            braking_torques: self.torques(touch, on, self.braking(&strength, slip.0)),
            moments: with_memory,
            rolling_alone,
            twist_as_rolling,
            kept_moments: of_memory(memory),
            exchanged_moments: of_memory(memory.map(|memory| Memory {
                bending: memory.twisting,
                twisting: memory.bending,
                ..memory
            })),
            added,
            without_limit: unlimited(|told| told.without_limit),
            by_component: by_component.map(|part| part.clamp(-most_moment, most_moment)),
            most_moment,
        })
    }

    /// What a contact does that remembers this, and what it remembers after this step.
    pub(super) fn act(&self, ids: Ids, touch: &Touch, remembered: Option<&Memory>) -> Action {
        let pair = remembered.map_or_else(|| self.pair(ids), |memory| memory.pair);
        let strength = self.strength(ids, touch, &pair);
        let on = self.motions(ids, touch);
        let normal_force = self.normal_force(touch, on, &strength, pair.pull);
        if !self.constants.law.has_friction() {
            return Action {
                force: plus(normal_force, NONE),
                torques: [NONE; 2],
                moment: NONE,
                memory: self.constants.law.holds().then(|| Memory {
                    normal: touch.normal,
                    ..Memory::new(ids, pair)
                }),
            };
        }
        let slip = self.slip(touch, on);
        let (shear, kept, slides) = self.shear(
            touch,
            on,
            (&pair, &strength),
            normal_force,
            remembered,
            slip,
        );
        let force = plus(normal_force, shear);
        let [bending, twisting, kept_bending] = match self.constants.law.contact.rolling {
            Some(rolling) => {
                let constants = (&pair, &strength);
                self.moments(&rolling, touch, on, constants, normal_force, remembered)
            }
            None => [NONE; 3],
        };
        Action {
            force,
            torques: self.torques(touch, on, force),
            moment: plus(bending, twisting),
            memory: Some(Memory {
                ids,
                normal: touch.normal,
                shear: kept,
                bending: kept_bending,
                twisting,
                slides,
                pair,
                k_s: strength.k_s,
            }),
        }
    }

    /// Spring, dashpot and adhesion, on body 2, N.
    pub(super) fn normal_force(
        &self,
        touch: &Touch,
        on: [Motion; 2],
        strength: &Strength,
        pull: f64,
    ) -> Vector {
        let law = &self.constants.law;
        let clips = law.has_dashpots() && self.rules().tension == TensionRule::Cut;
        let speed = || dot(touch.normal, at_contact_point(touch, on));
        let is_left_out = || self.has(Form::DashpotWhileApproaching) && speed() > 0.0;
        if law.contact.springs == Springs::Linear {
            let mut force = strength.elastic;
            if law.has_dashpots() && !is_left_out() {
                force -= strength.c_n * speed();
            }
            // A force that is cut has no direction, not that of −0.
            return match force < 0.0 && clips {
                true => NONE,
                false => times(force, touch.normal),
            };
        }
        let spring = times(strength.elastic - pull, touch.normal);
        if !law.has_dashpots() || is_left_out() {
            return spring;
        }
        let viscous = times(strength.c_n, times(speed(), touch.normal));
        let force = minus(spring, viscous);
        if !clips || dot(force, touch.normal) >= 0.0 {
            return force;
        }
        if law.contact.adhesion.is_none() {
            return NONE;
        }
        if law.contact.adhesion_law != AdhesionLaw::Pull {
            return force;
        }
        // YADE's: where the dashpot pulls more than adhesion does, it is left out and adhesion counted twice.
        let size = norm(viscous);
        match size > pull {
            true => minus(spring, times(pull, viscous.map(|part| part / size))),
            false => force,
        }
    }

    /// The largest moment against rolling, N·m. As in YADE, a normal force of zero limits nothing.
    fn most_moment(
        &self,
        rolling: &Rolling,
        touch: &Touch,
        (pair, strength): (&Pair, &Strength),
        normal_force: Vector,
    ) -> f64 {
        let force = match self.rules().moment_limit {
            MomentLimit::AsFriction => self.pressing(pair, strength, normal_force),
            MomentLimit::NormalForce => norm(normal_force),
            MomentLimit::Spring => strength.elastic.abs(),
        };
        let [one, two] = self.numbers(Input::RollingRadii, touch.radii);
        match rolling.limit {
            Some(limit) if limit > 0.0 && force > 0.0 => force * (limit * ((one + two) / 2.0)),
            _ => f64::INFINITY,
        }
    }

    /// Moments against rolling and twisting, on body 2, N·m.
    pub(super) fn moments(
        &self,
        rolling: &Rolling,
        touch: &Touch,
        on: [Motion; 2],
        constants: (&Pair, &Strength),
        normal_force: Vector,
        remembered: Option<&Memory>,
    ) -> [Vector; 3] {
        let is_flat = touch.first != Body::Grain;
        let is_free = self.looks.is_none()
            && self.rules().moment_limit == MomentLimit::AsFriction
            && self.pressing(constants.0, constants.1, normal_force) <= 0.0;
        if is_free || is_flat && self.rules().moments_at_walls == MomentsAtWalls::None {
            return [NONE; 3];
        }
        let relative = minus(on[1].spin, on[0].spin);
        let twist = times(dot(relative, touch.normal), touch.normal);
        let rolls = minus(relative, twist);
        let before = remembered.map_or([NONE; 2], |memory| {
            let turned = |vector| self.turned(memory.normal, vector, touch, on);
            let bending = match self.rules().moment_turn {
                _ if self.has(Form::MomentNotTurned) => memory.bending,
                MomentTurn::Moment => turned(memory.bending),
                MomentTurn::Force => {
                    cross(touch.normal, turned(cross(memory.bending, memory.normal)))
                }
            };
            let twisting = match self.has(Form::TwistingNotTurned) {
                true => memory.twisting,
                false => self.turned_along(memory, touch, on),
            };
            [bending, twisting]
        });
        let grown = |before: Vector, stiffness: f64, rate: Vector| {
            minus(before, times(stiffness, times(self.constants.dt, rate)))
        };
        let mut twisting = grown(before[1], rolling.twisting_stiffness, twist);
        let most = self.most_moment(rolling, touch, constants, normal_force);
        let mut kept = None;
        let bending = match rolling.bending_stiffness {
            Some(stiffness) => {
                let bending = grown(before[0], stiffness, rolls);
                kept = self.has(Form::MomentKeptUnlimited).then_some(bending);
                let size = norm(bending);
                match self.looks.is_none() && size > most {
                    true => times(most / size, bending),
                    false => bending,
                }
            }
            None => {
                let size = match self.rules().constant_moment {
                    ConstantMoment::AlongRolling => norm(rolls),
                    ConstantMoment::ShareOfSpin => norm(relative),
                };
                match most.is_finite() && size > 0.0 {
                    true => times(-(most / size), rolls),
                    false => NONE,
                }
            }
        };
        let size = norm(twisting);
        if self.has(Form::TwistingLimited) && size > most {
            twisting = times(most / size, twisting);
        }
        [bending, twisting, kept.unwrap_or(bending)]
    }

    /// The tangential force on body 2 that slips so and parts so fast along the normal, N, what its spring remembers of it, and whether it
    /// was cut and a dashpot left out.
    pub(super) fn shear(
        &self,
        touch: &Touch,
        on: [Motion; 2],
        (pair, strength): (&Pair, &Strength),
        normal_force: Vector,
        remembered: Option<&Memory>,
        (slip, along): (Vector, f64),
    ) -> (Vector, Vector, bool) {
        let dt = self.constants.dt;
        let before_turn = self.rules().slip_added == SlipAdded::BeforeTurn;
        let mut shear = match remembered {
            Some(memory) if before_turn => self.rescaled(memory, strength),
            Some(memory) => self.turned(memory.normal, self.rescaled(memory, strength), touch, on),
            None => NONE,
        };
        // The way since they met, over the way in this step.
        let mut share = 1.0;
        let way = -along * dt;
        match self.rules().new_contact {
            _ if remembered.is_some() => {}
            NewContact::SinceTouch if way > touch.overlap => share = touch.overlap / way,
            NewContact::Nothing => share = 0.0,
            _ => {}
        }
        let (law, is_linear) = (&self.constants.law, self.is_linear());
        // YADE's linear laws with and without a dashpot multiply in different orders.
        let growth = match law.has_dashpots() && is_linear {
            false => times(strength.k_s, times(dt, slip)),
            true => times(strength.k_s * dt, slip),
        };
        shear = minus(shear, times(share, growth));
        if let (true, Some(memory)) = (before_turn, remembered) {
            shear = self.turned(memory.normal, shear, touch, on);
        }
        if self.has(Form::NoCoulombLimit) {
            return (shear, shear, false);
        }
        if self.has(Form::CoulombByComponent) {
            let limit = hypot(normal_force) * pair.tangent;
            let limited = shear.map(|part| part.max(-limit).min(limit));
            return (limited, limited, false);
        }
        let (limit, limit_squared) = self.limit(pair, strength, normal_force);
        let dashpot = self.rules().tangential_dashpot;
        let braking = self.braking(strength, slip);
        let within = match dashpot {
            TangentialDashpot::Within => plus(shear, braking),
            _ => shear,
        };
        let left_out = self.variant.forms.iter().find_map(|form| match form {
            Form::CoulombWithout(axis) => Some(within[*axis]),
            _ => None,
        });
        let squared = dot(within, within) - left_out.map_or(0.0, |part| part * part);
        let slides = squared > limit_squared;
        // Where forces are looked at nothing is cut, and a contact goes on sliding.
        let slid = match (self.looks, remembered) {
            (Some(_), Some(memory)) => memory.slides,
            _ => slides,
        };
        let cut = match slides {
            true => times(limit / squared.sqrt(), within),
            false => within,
        };
        let kept = match (slides, self.rules().spring_when_sliding, dashpot) {
            // What is left for the spring where both are limited together.
            (true, SpringWhenSliding::Limited, TangentialDashpot::Within) => minus(cut, braking),
            (true, SpringWhenSliding::Limited, _) => cut,
            (true, SpringWhenSliding::Nothing, _) => NONE,
            _ => shear,
        };
        let kept = match remembered {
            Some(memory) if slides && self.has(Form::SlidingKeepsOld) => memory.shear,
            _ => kept,
        };
        let is_added = match dashpot {
            TangentialDashpot::Beyond => true,
            TangentialDashpot::WhileSticking => !slid,
            _ => false,
        };
        let force = match is_added {
            true => plus(cut, braking),
            false => cut,
        };
        // Only such a law needs it in order to go on.
        (
            force,
            kept,
            slid && dashpot == TangentialDashpot::WhileSticking,
        )
    }

    /// What the spring keeps of its force of the step before, N, now that k_s is another one.
    fn rescaled(&self, memory: &Memory, strength: &Strength) -> Vector {
        if memory.k_s <= 0.0 {
            return memory.shear;
        }
        let growth = strength.k_s / memory.k_s;
        let factor = match self.rules().spring_memory {
            SpringMemory::Force => return memory.shear,
            SpringMemory::Displacement => growth,
            SpringMemory::DisplacementRescaled => growth * growth.min(1.0),
            SpringMemory::ForceRescaled => growth.min(1.0),
        };
        times(factor, memory.shear)
    }

    /// Coulomb's, N, and its square. Of linear springs the square comes first, as in YADE. Adhesion presses as much as it pulls,
    /// and twice as much by the laws that say nothing of the dashpot.
    fn limit(&self, pair: &Pair, strength: &Strength, normal_force: Vector) -> (f64, f64) {
        match (self.rules().limit_from, self.is_linear()) {
            (LimitFrom::WholeForce, true) => {
                let squared = dot(normal_force, normal_force) * (pair.tangent * pair.tangent);
                (squared.sqrt(), squared)
            }
            _ => {
                let limit = self.pressing(pair, strength, normal_force) * pair.tangent;
                (limit, limit * limit)
            }
        }
    }

    /// The force that Coulomb's limit is taken from, N.
    fn pressing(&self, pair: &Pair, strength: &Strength, normal_force: Vector) -> f64 {
        match (
            self.rules().limit_from,
            self.constants.law.contact.adhesion_law,
        ) {
            (LimitFrom::Spring, _) => strength.elastic,
            (LimitFrom::WholeForce, AdhesionLaw::Pull) => norm(normal_force) + pair.pull,
            (LimitFrom::WholeForce, AdhesionLaw::Dmt | AdhesionLaw::Jkr) => {
                strength.elastic + pair.pull
            }
        }
    }

    /// What a dashpot along the tangent does, on body 2, N.
    pub(super) fn braking(&self, strength: &Strength, slip: Vector) -> Vector {
        let dt = self.looks.unwrap_or(self.constants.dt);
        match self.rules().tangential_dashpot {
            TangentialDashpot::None => NONE,
            _ if self.is_linear() => times(-strength.c_n, slip),
            // Divided by dt again, as in YADE.
            _ => times(-strength.c_s, times(dt, slip).map(|way| way / dt)),
        }
    }

    fn is_linear(&self) -> bool {
        self.constants.law.contact.springs == Springs::Linear
    }

    /// The twisting moment of the step before, which is along the normal. Rules that take a vector onto the tangent take it onto the normal.
    fn turned_along(&self, memory: &Memory, touch: &Touch, on: [Motion; 2]) -> Vector {
        let along = dot(memory.twisting, touch.normal);
        match self.rules().spring_turn {
            SpringTurn::KeepsLength => times(hypot(memory.twisting).copysign(along), touch.normal),
            SpringTurn::Projected => times(along, touch.normal),
            SpringTurn::FirstOrder | SpringTurn::NotTurned => {
                self.turned(memory.normal, memory.twisting, touch, on)
            }
        }
    }

    /// A vector of the step before, turned with the normal and with the spins about it.
    fn turned(&self, before: Vector, shear: Vector, touch: &Touch, on: [Motion; 2]) -> Vector {
        if self.has(Form::HistoryReset) {
            return NONE;
        }
        let rule = self.rules().spring_turn;
        if rule == SpringTurn::NotTurned {
            return shear;
        }
        if rule != SpringTurn::FirstOrder {
            if before == touch.normal {
                return shear;
            }
            let projected = minus(shear, times(dot(shear, touch.normal), touch.normal));
            let size = hypot(projected);
            let grows = rule == SpringTurn::KeepsLength && size > 0.0;
            let factor = if grows { hypot(shear) / size } else { 1.0 };
            return times(factor, projected);
        }
        let mut turn = cross(before, touch.normal);
        if self.has(Form::HistoryTurnedBack) {
            turn = times(-1.0, turn);
        }
        let turned = minus(shear, cross(shear, turn));
        let spins = plus(on[0].spin, on[1].spin);
        let half = 0.5 * self.constants.dt * dot(before, spins);
        minus(turned, cross(turned, times(half, before)))
    }

    /// The slip, and how fast they part along the normal, m/s.
    pub(super) fn slip(&self, touch: &Touch, on: [Motion; 2]) -> (Vector, f64) {
        let relative = self.slip_velocity(touch, on);
        let along = dot(touch.normal, relative);
        (minus(relative, times(along, touch.normal)), along)
    }

    /// That of body 2 against body 1, of which the tangential part is the slip, m/s.
    fn slip_velocity(&self, touch: &Touch, on: [Motion; 2]) -> Vector {
        if touch.slip == Slip::ContactPoint {
            return at_contact_point(touch, on);
        }
        let radii = self.numbers(Input::SlipRadii, touch.radii);
        let ([mut r1, mut r2], [one, two]) = (radii, on);
        if touch.first != Body::Grain && self.rules().slip_at_walls == SlipAtWalls::HalfOverlap {
            [r1, r2] = [r1, r2].map(|radius| radius - 0.5 * touch.overlap);
        }
        let stretch = match touch.slip {
            Slip::Unstretched => 1.0,
            _ => (r1 + r2) / (r1 + r2 - touch.overlap),
        };
        let relative = times(stretch, minus(two.velocity, one.velocity));
        minus(
            plus(relative, cross(two.spin, times(-r2, touch.normal))),
            cross(one.spin, times(r1, touch.normal)),
        )
    }

    /// On body 1 and body 2 of a force on body 2, N·m.
    pub(super) fn torques(&self, touch: &Touch, on: [Motion; 2], force: Vector) -> [Vector; 2] {
        let is_flat = touch.first != Body::Grain;
        if !self.constants.law.rotates() || is_flat && self.has(Form::NoTorqueOfFlatBodies) {
            return [NONE; 2];
        }
        let on_first = force.map(|part| -part);
        let arms = match self.rules().torque_arms_at_walls {
            ArmsAtWalls::HalfOverlap if is_flat => Arms::HalfOverlap,
            ArmsAtWalls::ContactPoint if is_flat => Arms::ContactPoint,
            ArmsAtWalls::WholeRadius if is_flat => Arms::WholeRadii,
            _ => self.rules().torque_arms,
        };
        let turn = cross(touch.normal, on_first);
        let radii = self.numbers(Input::TorqueArms, touch.radii);
        let mut torques = match arms {
            Arms::WholeRadii => radii.map(|radius| times(radius, turn)),
            Arms::HalfOverlap | Arms::AsModel => {
                radii.map(|radius| times(radius - 0.5 * touch.overlap, turn))
            }
            Arms::ContactPoint => {
                let [one, two] = on.map(|motion| minus(touch.point, motion.place));
                [cross(one, on_first), cross(two, force)]
            }
        };
        if self.has(Form::TorqueSign) {
            torques[1] = times(-1.0, torques[1]);
        }
        torques
    }
}

/// Velocity of body 2 against body 1 at the contact point, m/s.
fn at_contact_point(touch: &Touch, on: [Motion; 2]) -> Vector {
    let [v1, v2] = on.map(|motion| {
        let arm = minus(touch.point, motion.place);
        plus(motion.velocity, cross(motion.spin, arm))
    });
    minus(v2, v1)
}

/// By the C library's `pow`, whose bits YADE has; the compiler may take others for an exponent that it knows.
fn power(base: f64, exponent: f64) -> f64 {
    base.powf(black_box(exponent))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From the neck to where it presses.
    #[test]
    fn the_force_of_jkr_is_the_slope_of_its_energy() {
        let (k_n, pull) = (2.0e6, 1.0e-3);
        let force = |overlap: f64| {
            let root = root_of_jkr(k_n, pull, overlap);
            ((k_n * root.powi(3)).sqrt() - pull.sqrt()).powi(2) - pull
        };
        for overlap in [-2.0e-7, -1.0e-7, 0.0, 1.0e-6, 1.0e-5] {
            let step = 1.0e-10;
            let [less, more] = [-step, step].map(|by| energy_of_jkr(k_n, pull, overlap + by).1);
            let slope = (more - less) / (2.0 * step);
            assert!(
                (slope - force(overlap)).abs() < 1.0e-5 * pull,
                "{overlap}: {slope}"
            );
        }
    }
}
