//! What a contact does: springs, dashpots, Coulomb's limit and torques, by the law and the rules.

use super::touch::Touch;
use super::{Ids, Memory, Motion, Reference, series};
use crate::model::damping_ratio;
use crate::rules::{
    Arms, ArmsAtWalls, LimitFrom, NewContact, RestitutionFormula, Slip, SlipAdded, SlipAtWalls,
    SpringTurn, SpringWhenSliding, StiffnessMean, TangentialDashpot, TensionRule, WallMass,
    WallStiffness,
};
use crate::scene::{Tension, Viscosity};
use crate::tables::Body;
use crate::variant::Form;
use crate::vector::{Vector, cross, dot, hypot, minus, plus, times};

/// k_n, k_s and c_n of a pair.
struct Strength {
    k_n: f64,
    k_s: f64,
    c_n: f64,
}

/// What a contact does in a step.
pub(super) struct Action {
    /// On body 2, N.
    pub force: Vector,
    /// On body 1 and body 2, N·m.
    pub torques: [Vector; 2],
    /// Where the law has friction.
    pub memory: Option<Memory>,
}

const NONE: Vector = [0.0; 3];

impl Reference {
    /// k_n, k_s and c_n of these bodies.
    fn strength(&self, ids: Ids, touch: &Touch) -> Strength {
        let constants = &self.constants;
        let two = ids.1 as usize;
        let m2 = self.sizes.mass[two];
        let (radii, mass) = match touch.first {
            Body::Grain => {
                let one = ids.0 as usize;
                let m1 = self.sizes.mass[one];
                let radii = [one, two].map(|i| self.stiffness_radius[i]);
                (radii, m1 * m2 / (m1 + m2))
            }
            Body::Wall => ([self.stiffness_radius[two]; 2], self.wall_mass(m2)),
            Body::Punch => (touch.radii, self.wall_mass(m2)),
        };
        let [a, b] = radii.map(|radius| constants.law.modulus * radius);
        let [c, d] = [a, b].map(|side| side * constants.law.stiffness_ratio);
        let (mut k_n, mut k_s) = match constants.law.has_dashpots() {
            false => (2.0 * a * b / (a + b), 2.0 * c * d / (c + d)),
            true => (series(a, b), series(c, d)),
        };
        let rigid = self.rules().wall_stiffness == WallStiffness::Rigid;
        if rigid && touch.first != Body::Grain {
            k_n *= 2.0;
            k_s *= 2.0;
        }
        k_n *= constants.normal_factors[touch.first as usize];
        k_s *= constants.tangential_factor;
        if touch.first == Body::Grain {
            let [r1, r2] = radii;
            let mean = match self.rules().stiffness_mean {
                _ if self.has(Form::StiffnessOfFirst) => Some(r1),
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
        let mut c_n = match constants.law.contact.viscosity {
            Viscosity::None => 0.0,
            Viscosity::Dashpot { c_n, .. } => series(c_n, c_n),
            Viscosity::Restitution { .. } => {
                2.0 * constants.damping_ratio * (mass * k_n).max(0.0).sqrt()
            }
        };
        c_n *= self.restitution_factor();
        if touch.first == Body::Grain && self.has(Form::DashpotOfMeanMass) {
            let m1 = self.sizes.mass[ids.0 as usize];
            c_n *= 0.5 * (m1 + m2) / (m1 * m2).sqrt() * std::f64::consts::SQRT_2;
        }
        Strength { k_n, k_s, c_n }
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
        match damping_ratio(e_n, tension) {
            0.0 => 1.0,
            ratio => damping_ratio(e_n, chosen) / ratio,
        }
    }

    /// How the first of a pair and its grain move; what other forms leave out is left out.
    fn motions(&self, ids: Ids, first: Body) -> [Motion; 2] {
        let spins = !self.has(Form::SlipOfCentres);
        let grain = |id: u32| {
            let motion = self.motions[id as usize];
            let spin = if spins { motion.spin } else { NONE };
            Motion { spin, ..motion }
        };
        let one = match (first, &self.felt) {
            (Body::Grain, _) => grain(ids.0),
            (Body::Punch, Some(punch)) => Motion::from(punch),
            _ => Motion::default(),
        };
        [one, grain(ids.1)]
    }

    /// What a contact does that remembers this, and what it remembers after this step.
    pub(super) fn act(&self, ids: Ids, touch: &Touch, remembered: Option<&Memory>) -> Action {
        let strength = self.strength(ids, touch);
        let on = self.motions(ids, touch.first);
        let mut normal_force = strength.k_n * touch.overlap;
        let mut clips = false;
        if self.constants.law.has_dashpots() {
            normal_force -= strength.c_n * dot(touch.normal, at_contact_point(touch, on));
            clips = self.rules().tension == TensionRule::Cut;
        }
        // A force that is cut has no direction, not that of −0.
        let normal_force = match normal_force < 0.0 && clips {
            true => NONE,
            false => times(normal_force, touch.normal),
        };
        if !self.constants.law.has_friction() {
            return Action {
                force: plus(normal_force, NONE),
                torques: self.torques(touch, on, normal_force),
                memory: None,
            };
        }
        let (shear, kept) = self.shear(touch, on, &strength, normal_force, remembered);
        let force = plus(normal_force, shear);
        Action {
            force,
            torques: self.torques(touch, on, force),
            memory: Some(Memory {
                ids,
                normal: touch.normal,
                shear: kept,
            }),
        }
    }

    /// The tangential force on body 2, N, and what its spring remembers of it.
    fn shear(
        &self,
        touch: &Touch,
        on: [Motion; 2],
        strength: &Strength,
        normal_force: Vector,
        remembered: Option<&Memory>,
    ) -> (Vector, Vector) {
        let dt = self.constants.dt;
        let before_turn = self.rules().slip_added == SlipAdded::BeforeTurn;
        let mut shear = match remembered {
            Some(memory) if before_turn => memory.shear,
            Some(memory) => self.turned(memory.normal, memory.shear, touch, on),
            None => NONE,
        };
        let relative = self.slip_velocity(touch, on);
        let along = dot(touch.normal, relative);
        let slip = minus(relative, times(along, touch.normal));
        // The way since they met, over the way in this step.
        let mut share = 1.0;
        let way = -along * dt;
        match self.rules().new_contact {
            _ if remembered.is_some() => {}
            NewContact::SinceTouch if way > touch.overlap => share = touch.overlap / way,
            NewContact::Nothing => share = 0.0,
            _ => {}
        }
        // YADE's laws with and without a dashpot multiply in different orders.
        let growth = match self.constants.law.has_dashpots() {
            false => times(strength.k_s, times(dt, slip)),
            true => times(strength.k_s * dt, slip),
        };
        shear = minus(shear, times(share, growth));
        if let (true, Some(memory)) = (before_turn, remembered) {
            shear = self.turned(memory.normal, shear, touch, on);
        }
        let tangent = self.tangents[touch.first as usize];
        if self.has(Form::NoCoulombLimit) {
            return (shear, shear);
        }
        if self.has(Form::CoulombByComponent) {
            let limit = hypot(normal_force) * tangent;
            let limited = shear.map(|part| part.max(-limit).min(limit));
            return (limited, limited);
        }
        let limit_squared = match self.rules().limit_from {
            LimitFrom::Spring => (strength.k_n * touch.overlap * tangent).powi(2),
            LimitFrom::WholeForce => dot(normal_force, normal_force) * (tangent * tangent),
        };
        let dashpot = self.rules().tangential_dashpot;
        let braking = match dashpot {
            TangentialDashpot::None => NONE,
            _ => times(-strength.c_n, slip),
        };
        let within = match dashpot {
            TangentialDashpot::Within => plus(shear, braking),
            _ => shear,
        };
        let squared = dot(within, within);
        let slides = squared > limit_squared;
        let cut = match slides {
            true => times(limit_squared.sqrt() / squared.sqrt(), within),
            false => within,
        };
        let kept = match (slides, self.rules().spring_when_sliding, dashpot) {
            // What is left for the spring where both are limited together.
            (true, SpringWhenSliding::Limited, TangentialDashpot::Within) => minus(cut, braking),
            (true, SpringWhenSliding::Limited, _) => cut,
            (true, SpringWhenSliding::Nothing, _) => NONE,
            _ => shear,
        };
        let is_added = match dashpot {
            TangentialDashpot::Beyond => true,
            TangentialDashpot::WhileSticking => !slides,
            _ => false,
        };
        let force = match is_added {
            true => plus(cut, braking),
            false => cut,
        };
        (force, kept)
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

    /// That of body 2 against body 1, of which the tangential part is the slip, m/s.
    fn slip_velocity(&self, touch: &Touch, on: [Motion; 2]) -> Vector {
        if touch.slip == Slip::ContactPoint {
            return at_contact_point(touch, on);
        }
        let ([mut r1, mut r2], [one, two]) = (touch.radii, on);
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
    fn torques(&self, touch: &Touch, on: [Motion; 2], force: Vector) -> [Vector; 2] {
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
        let mut torques = match arms {
            Arms::WholeRadii => touch.radii.map(|radius| times(radius, turn)),
            Arms::HalfOverlap | Arms::AsModel => touch
                .radii
                .map(|radius| times(radius - 0.5 * touch.overlap, turn)),
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
