//! A contact's forces and torques where one thing that they are made of is taken from elsewhere: another contact's, another moment's, or
//! changed in itself.

use super::law::{Pair, Told};
use super::touch::Touch;
use super::{Ids, Memory, Motion, Reference};
use crate::vector::{Vector, dot, norm, plus, times};

/// What a contact's forces and torques are made of, each thing as often as it stands in them.
#[derive(Clone)]
pub struct Made {
    ids: Ids,
    pair: Pair,
    /// Where they touch, as it stands in the dashpot along the normal, the slip, the turning of the spring, the torques and the moments.
    in_dashpot: Touch,
    in_slip: Touch,
    in_turn: Touch,
    in_torque: Touch,
    in_moment: Touch,
    moves_in_dashpot: [Motion; 2],
    moves_in_slip: [Motion; 2],
    moves_in_turn: [Motion; 2],
    moves_in_moment: [Motion; 2],
    /// How fast they part along the normal, for the slip since a new contact's bodies touched, m/s, and how fast they pass each other.
    parting: f64,
    passing: f64,
    /// Overlaps that the springs along the normal and along the tangent and the dashpots are made of, m.
    overlaps: [f64; 3],
    /// The normal forces that limit the tangential force and the moment against rolling, N.
    limiting: [Vector; 2],
    /// The force whose torque it is, N.
    force: Vector,
    memory: Option<Memory>,
}

/// What a contact makes of that.
#[derive(Clone, Copy)]
pub struct Makes {
    /// Along its normal and along the tangent, on body 2, N.
    pub normal_force: f64,
    pub tangential: Vector,
    /// The force on body 2, N, the torques of it and of moments on both, N·m.
    pub force: Vector,
    pub torques: [Vector; 2],
}

/// One thing that they are made of, in words, and how it is taken from elsewhere.
pub type Ingredient = (&'static str, fn(&mut Made, &Made));

/// Rows of words and of what is taken from elsewhere; what contacts remember only where both remember something.
macro_rules! ingredients {
    (
        $($words:literal: $($place:ident $([$side:literal])? $(.$part:ident)*),+;)+
        remembered { $($kept_words:literal: $kept:ident;)* }
    ) => {
        &[
            $(($words, |made, other| {
                $(made.$place $([$side])? $(.$part)* = other.$place $([$side])? $(.$part)*;)+
            }),)+
            $(($kept_words, |made, other| {
                if let (Some(memory), Some(other)) = (&mut made.memory, &other.memory) {
                    memory.$kept = other.$kept;
                }
            }),)*
        ]
    };
}

/// Of forces.
pub const OF_FORCES: &[Ingredient] = ingredients! {
    "the overlap in the spring along the normal": overlaps[0];
    "the overlap in k_s": overlaps[1];
    "the overlap in the dashpots": overlaps[2];
    "k_n": pair.k_n;
    "k_s": pair.k_s;
    "both stiffnesses": pair.k_n, pair.k_s;
    "the effective mass": pair.mass, pair.mass_along;
    "the coefficient of friction": pair.tangent;
    "the pull of adhesion": pair.pull;
    "all constants": pair;
    "the normal in the dashpot along the normal": in_dashpot.normal;
    "the contact point in the dashpot along the normal": in_dashpot.point;
    "the velocities in the dashpot along the normal": moves_in_dashpot[0].velocity, moves_in_dashpot[1].velocity;
    "the first one's velocity in the dashpot along the normal": moves_in_dashpot[0].velocity;
    "the second one's velocity in the dashpot along the normal": moves_in_dashpot[1].velocity;
    "the spins in the dashpot along the normal": moves_in_dashpot[0].spin, moves_in_dashpot[1].spin;
    "the first one's spin in the dashpot along the normal": moves_in_dashpot[0].spin;
    "the speed of approach in what a new contact slips": parting;
    "the normal in the slip": in_slip.normal;
    "the overlap in the slip": in_slip.overlap;
    "the radii in the slip": in_slip.radii;
    "the velocities in the slip": moves_in_slip[0].velocity, moves_in_slip[1].velocity;
    "the first one's velocity in the slip": moves_in_slip[0].velocity;
    "the second one's velocity in the slip": moves_in_slip[1].velocity;
    "the spins in the slip": moves_in_slip[0].spin, moves_in_slip[1].spin;
    "the first one's spin in the slip": moves_in_slip[0].spin;
    "the second one's spin in the slip": moves_in_slip[1].spin;
    "velocities and spins in the slip": moves_in_slip;
    "the normal with which the spring turns": in_turn.normal;
    "the spins with which the spring turns": moves_in_turn[0].spin, moves_in_turn[1].spin;
    "the first one's spin with which the spring turns": moves_in_turn[0].spin;
    "the second one's spin with which the spring turns": moves_in_turn[1].spin;
    "all that contacts remember of their springs": memory;
    "the normal force in Coulomb's limit": limiting[0];
    remembered {
        "the normal of the step before, from which the spring turns,": normal;
        "the spring's force of the step before": shear;
        "k_s of the step before": k_s;
    }
};

/// Of torques and of the sum of forces.
pub const OF_TORQUES: &[Ingredient] = ingredients! {
    "the forces on grains": force;
    "the normal in torques": in_torque.normal;
    "the overlap in torques": in_torque.overlap;
    "the radii in torques": in_torque.radii;
    "the contact point in torques": in_torque.point;
    "the normal in moments against rolling and twisting": in_moment.normal;
    "the radii in the limit of moments": in_moment.radii;
    "the spins in moments": moves_in_moment[0].spin, moves_in_moment[1].spin;
    "the first one's spin in moments": moves_in_moment[0].spin;
    "the second one's spin in moments": moves_in_moment[1].spin;
    "the normal force in the limit of moments": limiting[1];
    remembered {
        "the moment against rolling of the step before": bending;
        "the moment against twisting of the step before": twisting;
    }
};

impl Made {
    pub fn ids(&self) -> Ids {
        self.ids
    }

    /// The direction in which it pushes the second body.
    pub fn normal(&self) -> Vector {
        self.in_torque.normal
    }

    /// With all vectors that change from step to step changed so.
    pub fn changed(&self, change: impl Fn(Vector) -> Vector) -> Made {
        let mut all = self.clone();
        for touch in all.touches() {
            touch.normal = change(touch.normal);
        }
        for motion in all.motions() {
            (motion.velocity, motion.spin) = (change(motion.velocity), change(motion.spin));
        }
        all.limiting = all.limiting.map(&change);
        all.force = change(all.force);
        if let Some(memory) = &mut all.memory {
            for vector in [
                &mut memory.normal,
                &mut memory.shear,
                &mut memory.bending,
                &mut memory.twisting,
            ] {
                *vector = change(*vector);
            }
        }
        all
    }

    /// With bodies that approach as fast as they pass each other.
    pub fn approaching_as_it_passes(&self) -> Made {
        Made {
            parting: -self.passing,
            ..self.clone()
        }
    }

    /// With what is of one body taken of the other.
    pub fn exchanged(&self) -> Made {
        let mut all = self.clone();
        all.touches()
            .into_iter()
            .for_each(|touch| touch.radii.reverse());
        for moves in all.moves() {
            moves.reverse();
        }
        all
    }

    fn touches(&mut self) -> [&mut Touch; 5] {
        [
            &mut self.in_dashpot,
            &mut self.in_slip,
            &mut self.in_turn,
            &mut self.in_torque,
            &mut self.in_moment,
        ]
    }

    fn moves(&mut self) -> [&mut [Motion; 2]; 4] {
        [
            &mut self.moves_in_dashpot,
            &mut self.moves_in_slip,
            &mut self.moves_in_turn,
            &mut self.moves_in_moment,
        ]
    }

    fn motions(&mut self) -> impl Iterator<Item = &mut Motion> {
        self.moves().into_iter().flatten()
    }
}

impl Reference {
    /// What these bodies' contact is made of, whose table tells this normal force and the tangential force, N; `before` is what it told a
    /// step ago. None where they do not touch.
    pub fn made_of(
        &self,
        ids: (u32, u32),
        (normal_force, tangential): (f64, Vector),
        before: Option<Told>,
    ) -> Option<Made> {
        let touch = *self.touch_of(ids)?;
        let (pair, on) = (self.pair(ids), self.motions(ids, &touch));
        let told = times(normal_force, touch.normal);
        let (slip, parting) = self.slip(&touch, on);
        Some(Made {
            ids,
            pair,
            in_dashpot: touch,
            in_slip: touch,
            in_turn: touch,
            in_torque: touch,
            in_moment: touch,
            moves_in_dashpot: on,
            moves_in_slip: on,
            moves_in_turn: on,
            moves_in_moment: on,
            parting,
            passing: norm(plus(slip, times(parting, touch.normal))),
            overlaps: [touch.overlap; 3],
            limiting: [told; 2],
            force: plus(told, tangential),
            memory: before.map(|told| told.memory(ids, pair)),
        })
    }

    /// The same with the motions of the grains whose ids are so many larger; none where there are none.
    pub fn with_motions_of(&self, made: &Made, by: i64) -> Option<Made> {
        let mut all = made.clone();
        let grains = self.motions.len();
        let sides = [made.ids.0, made.ids.1].map(i64::from);
        for (side, id) in sides.into_iter().enumerate() {
            if id as usize >= grains {
                continue;
            }
            let other = usize::try_from(id + by).ok().filter(|id| *id < grains)?;
            for moves in all.moves() {
                moves[side].velocity = self.motions[other].velocity;
                moves[side].spin = self.motions[other].spin;
            }
        }
        Some(all)
    }

    /// What it makes.
    pub fn makes(&self, made: &Made) -> Makes {
        let first = made.in_slip.first;
        let strength = |at: usize| self.strength_at(made.ids, made.overlaps[at], first, &made.pair);
        let [mut all, along, dashpots] = [0, 1, 2].map(strength);
        all.k_s = along.k_s;
        all.take_dashpots(&dashpots);
        let normal_force = self.normal_force(
            &made.in_dashpot,
            made.moves_in_dashpot,
            &all,
            made.pair.pull,
        );
        let (slip, _) = self.slip(&made.in_slip, made.moves_in_slip);
        let slip = (slip, made.parting);
        let constants = (&made.pair, &all);
        let memory = made.memory.as_ref();
        let (tangential, ..) = match self.constants.law.has_friction() {
            true => self.shear(
                &made.in_turn,
                made.moves_in_turn,
                constants,
                made.limiting[0],
                memory,
                slip,
            ),
            false => ([0.0; 3], [0.0; 3], false),
        };
        let moments = self.constants.law.contact.rolling.map(|rolling| {
            self.moments(
                &rolling,
                &made.in_moment,
                made.moves_in_moment,
                constants,
                made.limiting[1],
                memory,
            )
        });
        let moment = moments.map_or([0.0; 3], |[bending, twisting, _]| plus(bending, twisting));
        let [one, two] = self.torques(&made.in_torque, made.moves_in_slip, made.force);
        Makes {
            normal_force: dot(normal_force, made.in_dashpot.normal),
            tangential,
            force: made.force,
            torques: [plus(one, times(-1.0, moment)), plus(two, moment)],
        }
    }
}
