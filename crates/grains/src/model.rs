//! The model: what a scene asks an engine to compute, resolved to numbers, and which terms of the
//! method are in it.
//!
//! Engines read this and never the scene's way of saying it, so a verification case, which is no
//! poured bed, is the same kind of thing to them.

use std::f64::consts::PI;

use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

use crate::obstacle::Obstacle;
use crate::rules::{
    Arms, NewContact, RestitutionFormula, Rules, Slip, TangentialDashpot, TensionRule,
};
use crate::scene::{
    AdhesionLaw, ContactLaw, NewContactSlip, Rotation, Scene, SlipVelocity, Springs, Tension,
    TorqueArms, Viscosity,
};
use crate::tables::{Body, Stage};

/// Everything that a step depends on besides the grains and the punch. SI units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Gravitational acceleration, m/s², x and z.
    pub gravity: [f64; 2],
    /// Cundall's α.
    pub alpha: f64,
    /// s.
    pub dt: f64,
    /// Infinite walls; their ids follow the grains' in this order.
    pub walls: Vec<Wall>,
    /// Bodies of any direction in space; their ids follow the walls' in this order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<Obstacle>,
    /// What happens at a contact.
    pub law: Law,
    /// The conventions of the step and the law.
    #[serde(default, skip_serializing_if = "Rules::are_usual")]
    pub rules: Rules,
}

/// The contact law with its parameters, the same for grains, walls and punch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Law {
    /// Young's modulus E, Pa.
    pub modulus: f64,
    /// k_s/k_n.
    pub stiffness_ratio: f64,
    /// Friction angle φ, rad.
    pub friction_angle: f64,
    /// At walls, where it is another one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wall_friction_angle: Option<f64>,
    /// At the punch likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub punch_friction_angle: Option<f64>,
    /// Poisson's ratio of Hertz's springs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poissons_ratio: Option<f64>,
    /// What grains of material 1, 2, … are made of, in space; those of material 0, walls and punch are of the law's own numbers.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub materials: Vec<Solid>,
    /// Dashpots, rotations and the choices that the paper does not print.
    pub contact: ContactLaw,
}

/// What grains are made of.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Solid {
    /// Young's modulus E, Pa.
    pub modulus: f64,
    /// k_s/k_n of linear springs.
    pub stiffness_ratio: f64,
    /// Poisson's ratio of Hertz's springs.
    pub poissons_ratio: f64,
    /// Friction angle φ, rad; of two that touch the smaller holds, unless walls or punch have their own.
    pub friction_angle: f64,
}

impl Solid {
    /// F_n/u^1.5 of Hertz's spring and k_s/u^0.5 of Mindlin's between two bodies with this R* = R_1 R_2/(R_1 + R_2): 4/3 E* √R*
    /// and 8 G* √R*, N/m^1.5.
    pub fn hertz_mindlin(self, other: Solid, radius: f64) -> [f64; 2] {
        // 1/E* = (1 − ν_1²)/E_1 + (1 − ν_2²)/E_2, and 1/G* = (2 − ν_1)/G_1 + (2 − ν_2)/G_2 with G = E/(2(1 + ν)).
        let give = |solid: Solid| 1.0 - solid.poissons_ratio * solid.poissons_ratio;
        let sum = give(self) * other.modulus + give(other) * self.modulus;
        let normal = self.modulus * other.modulus / sum;
        let [a, b] = [self, other].map(|solid| {
            let shear = solid.modulus / (2.0 * (1.0 + solid.poissons_ratio));
            (2.0 - solid.poissons_ratio) / shear
        });
        let shear = 1.0 / (a + b);
        [
            4.0 / 3.0 * normal * radius.sqrt(),
            8.0 * shear * radius.sqrt(),
        ]
    }
}

/// Which coordinate a wall holds fixed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// Across.
    X = 0,
    /// Up.
    Z = 1,
    /// In space, the third.
    Y = 2,
}

impl Axis {
    /// Which component of a vector in space.
    pub fn in_space(self) -> usize {
        match self {
            Axis::X => 0,
            Axis::Y => 1,
            Axis::Z => 2,
        }
    }
}

/// An infinite wall; grains feel it from both sides.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// The coordinate that it holds fixed.
    pub axis: Axis,
    /// Its place on that axis, m.
    pub place: f64,
}

impl Wall {
    /// At this place, m.
    pub fn at(axis: Axis, place: f64) -> Self {
        Wall { axis, place }
    }
}

impl Model {
    /// How many ids are between the grains' and the punch's.
    pub fn walls_and_obstacles(&self) -> u32 {
        (self.walls.len() + self.obstacles.len()) as u32
    }

    /// What this scene asks for in this stage.
    pub fn in_stage(scene: &Scene, stage: Stage) -> Self {
        Model::of(&scene.in_stage(stage))
    }

    /// What this scene asks for in pouring.
    pub fn of(scene: &Scene) -> Self {
        let wall = |axis, place| Wall { axis, place };
        let mut walls = vec![
            wall(Axis::X, 0.0),
            wall(Axis::X, scene.container.width),
            wall(Axis::Z, 0.0),
        ];
        if let Some(depth) = scene.container.depth {
            walls.extend([wall(Axis::Y, 0.0), wall(Axis::Y, depth)]);
        }
        Model {
            gravity: [0.0, -scene.gravity],
            alpha: scene.damping.alpha(),
            dt: scene.time_step_seconds(),
            walls,
            obstacles: scene.obstacles.clone(),
            law: Law {
                modulus: scene.material.youngs_modulus,
                stiffness_ratio: scene.material.stiffness_ratio,
                friction_angle: scene.material.friction_angle,
                wall_friction_angle: scene.material.wall_friction_angle,
                punch_friction_angle: scene.material.punch_friction_angle,
                poissons_ratio: scene.material.poissons_ratio,
                materials: Vec::new(),
                contact: scene.contact.clone(),
            },
            rules: scene.rules,
        }
    }
}

impl Law {
    /// Whether contacts bear tangential forces.
    pub fn has_friction(&self) -> bool {
        let mut further = self.materials.iter();
        self.friction_angles().iter().any(|angle| *angle > 0.0)
            || further.any(|solid| solid.friction_angle > 0.0)
    }

    /// Friction angles between grains, at walls and at the punch, rad.
    pub fn friction_angles(&self) -> [f64; 3] {
        let bodies = [Body::Grain, Body::Wall, Body::Punch];
        bodies.map(|first| {
            self.friction_of_its_own(first)
                .unwrap_or(self.friction_angle)
        })
    }

    /// The friction angle that walls or the punch have whatever touches them, rad.
    pub fn friction_of_its_own(&self, first: Body) -> Option<f64> {
        match first {
            Body::Grain => None,
            Body::Wall => self.wall_friction_angle,
            Body::Punch => self.punch_friction_angle,
        }
    }

    /// Whether walls or punch have a friction of their own.
    pub fn has_friction_of_walls(&self) -> bool {
        self.friction_angles()
            .iter()
            .any(|angle| *angle != self.friction_angle)
    }

    /// What bodies of this material are made of.
    pub fn solid(&self, material: u32) -> Solid {
        match (material as usize).checked_sub(1) {
            Some(further) => self.materials[further],
            None => Solid {
                modulus: self.modulus,
                stiffness_ratio: self.stiffness_ratio,
                poissons_ratio: self.poissons_ratio.unwrap_or(f64::NAN),
                friction_angle: self.friction_angle,
            },
        }
    }

    /// Damping ratios of the dashpots along the normal and the tangent; 0 where they are none or have a constant.
    pub fn damping_ratios(&self) -> [f64; 2] {
        let contact = &self.contact;
        let springs = contact.springs;
        let ratio = |normal| contact.tangential_viscosity.unwrap_or(normal);
        match contact.viscosity {
            Viscosity::None | Viscosity::Dashpot { .. } => [0.0; 2],
            Viscosity::Ratio { ratio: normal, .. } => [normal, ratio(normal)],
            Viscosity::Restitution { e_n, tension } => {
                [e_n, ratio(e_n)].map(|e| springs.damping_ratio(e, tension))
            }
        }
    }

    /// Normal stiffness of two grains, N/m: Eq. 4 of the paper, 2E R_i R_j/(R_i + R_j). Engines have their own.
    pub fn normal_stiffness(&self, radius1: f64, radius2: f64) -> f64 {
        2.0 * self.modulus * radius1 * radius2 / (radius1 + radius2)
    }

    /// Normal stiffness of two grains of this radius and of the stiffest material, N/m; that of Hertz's springs at an overlap of a
    /// hundredth of the radius.
    pub fn usual_stiffness(&self, radius: f64) -> f64 {
        let materials = (0..=self.materials.len() as u32).map(|material| self.solid(material));
        let stiffnesses = materials.map(|solid| match self.contact.springs {
            Springs::Linear => solid.modulus * radius,
            Springs::HertzMindlin => {
                let [k_n, _] = solid.hertz_mindlin(solid, 0.5 * radius);
                1.5 * k_n * (0.01 * radius).sqrt()
            }
        });
        stiffnesses.fold(0.0, f64::max)
    }

    /// These rules with what the law's own keys say in the place of "as the model says".
    pub fn resolved(&self, mut rules: Rules) -> Rules {
        let contact = &self.contact;
        if rules.slip == Slip::AsModel {
            rules.slip = match contact.slip_velocity {
                SlipVelocity::RatchetingCorrected => Slip::Corrected,
                SlipVelocity::ContactPoint => Slip::ContactPoint,
            };
        }
        if rules.torque_arms == Arms::AsModel {
            rules.torque_arms = match contact.torque_arms {
                TorqueArms::HalfOverlap => Arms::HalfOverlap,
                TorqueArms::ContactPoint => Arms::ContactPoint,
            };
        }
        if rules.new_contact == NewContact::AsModel {
            rules.new_contact = match contact.new_contact_slip {
                NewContactSlip::WholeStep => NewContact::WholeStep,
                NewContactSlip::SinceTouch => NewContact::SinceTouch,
            };
        }
        let is_cut = contact.viscosity.tension() == Tension::Clipped;
        if rules.tension == TensionRule::AsModel {
            rules.tension = [TensionRule::NotCut, TensionRule::Cut][usize::from(is_cut)];
        }
        if rules.restitution == RestitutionFormula::AsModel {
            let formulas = [RestitutionFormula::Uncut, RestitutionFormula::Cut];
            rules.restitution = formulas[usize::from(is_cut)];
        }
        // As in YADE; a damping ratio of 0 along the tangent is no dashpot there.
        let hertz = contact.springs == Springs::HertzMindlin && self.has_dashpots();
        if hertz && rules.tangential_dashpot == TangentialDashpot::None {
            rules.tangential_dashpot = TangentialDashpot::WhileSticking;
        }
        rules
    }

    /// Whether contacts have dashpots.
    pub fn has_dashpots(&self) -> bool {
        self.contact.viscosity != Viscosity::None
    }

    /// Whether grains can change their spin: only a tangential force turns a grain.
    pub fn rotates(&self) -> bool {
        self.has_friction() && self.contact.rotation == Rotation::Free
    }

    /// Whether forces depend on what was before, so that positions and velocities alone do not
    /// tell how a run goes on.
    pub fn has_history(&self) -> bool {
        self.has_friction() || self.holds()
    }

    /// Whether what has touched goes on touching beyond its surfaces.
    pub fn holds(&self) -> bool {
        self.contact.adhesion_law == AdhesionLaw::Jkr
    }
}

/// Whether grains can change their spin in any stage of the scene.
pub fn rotates(scene: &Scene) -> bool {
    let mut stages = scene.stages();
    stages.any(|stage| Model::in_stage(scene, stage).law.rotates())
}

/// The contact kernels of the native engine, the cheaper one first; the contact law selects one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kernel {
    /// Normal springs only: no rotations, no history, no dashpots.
    Frictionless,
    /// Friction with history, dashpots, or both.
    General,
    /// Spheres in space: the step as it is written out.
    Space,
}

/// What computes a scene, as the record of a run says it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelRecord {
    /// The kernel of the native engine that computes the contacts; none for another engine.
    pub kernel: Option<Kernel>,
    /// Older records list here which terms the scene needs. The scene says the same, so nothing reads them and none are written.
    #[serde(default, skip_serializing)]
    terms: IgnoredAny,
}

impl Kernel {
    /// The cheapest kernel that has every term of the law.
    pub fn of(law: &Law) -> Self {
        if law.has_friction() || law.has_dashpots() {
            Kernel::General
        } else {
            Kernel::Frictionless
        }
    }
}

impl ModelRecord {
    /// Of the native engine or of another; the dearer kernel where pouring and loading differ.
    pub fn of(scene: &Scene, native: bool) -> Self {
        let needed = |stage| Kernel::of(&Model::in_stage(scene, stage).law);
        let kernel = match scene.in_space() {
            true => Some(Kernel::Space),
            false => scene.stages().map(needed).max(),
        };
        ModelRecord {
            kernel: kernel.filter(|_| native),
            terms: IgnoredAny,
        }
    }
}

/// The damping ratio ζ = c_n/(2√(m_eff k_n)) whose collisions have the restitution e in (0, 1].
///
/// Unclipped, e = exp(−πζ/√(1−ζ²)) and ζ follows in closed form. Clipped, the bodies part as soon
/// as the force is zero (Schwager and Pöschel 2007); ζ is then found by halving.
pub fn damping_ratio(restitution: f64, tension: Tension) -> f64 {
    let logarithm = -restitution.ln();
    let unclipped = logarithm / (PI * PI + logarithm * logarithm).sqrt();
    if tension == Tension::Unclipped || restitution == 1.0 {
        return unclipped;
    }
    // Clipping raises e, so more damping is needed than without.
    let (mut low, mut high) = (unclipped, 1.0);
    while clipped_restitution(high) > restitution {
        low = high;
        high *= 2.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if clipped_restitution(middle) > restitution {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

impl Springs {
    /// The damping ratio β of a dashpot c_n = 2β√(m_eff k_n) at these springs, k_n = dF_n/du, whose collisions have the
    /// restitution e in (0, 1].
    pub fn damping_ratio(self, restitution: f64, tension: Tension) -> f64 {
        match (self, tension) {
            (Springs::Linear, _) => damping_ratio(restitution, tension),
            // Tsuji, Tanaka and Ishida 1992: the equation of motion is that of a linear spring.
            (Springs::HertzMindlin, Tension::Unclipped) => {
                (5.0f64 / 6.0).sqrt() * damping_ratio(restitution, tension)
            }
            (Springs::HertzMindlin, Tension::Clipped) => clipped_hertz(restitution),
        }
    }
}

/// β of a Hertzian spring whose force is cut at zero: Thornton, Cummins and Cleary (2013), Eq. B6, in the order of operations
/// that YADE has.
fn clipped_hertz(restitution: f64) -> f64 {
    const H: [f64; 10] = [
        -6.918798, -16.41105, 146.8049, -796.4559, 2928.711, -7206.864, 11494.29, -11342.18,
        6276.757, -1489.915,
    ];
    let e = restitution;
    let exponent = e * H.iter().rev().fold(0.0, |sum, h| h + e * sum);
    (1.0 / (1.0 - (1.0 + e) * (1.0 + e) * exponent.exp()) - 1.0).sqrt()
}

/// e of a spring and dashpot without tension, for any damping ratio ζ ≥ 0:
/// exp(−(ζ/s)(π − atan2(2ζs, 1 − 2ζ²))) with s = √(1−ζ²) below critical damping, and
/// exp(−(ζ/s)·2 ln(ζ+s)) with s = √(ζ²−1) above it.
pub fn clipped_restitution(ratio: f64) -> f64 {
    let off = 1.0 - ratio * ratio;
    if off.abs() < 1.0e-12 {
        return (-2.0f64).exp();
    }
    let s = off.abs().sqrt();
    let angle = if off > 0.0 {
        PI - (2.0 * ratio * s).atan2(1.0 - 2.0 * ratio * ratio)
    } else {
        2.0 * (ratio + s).ln()
    };
    (-(ratio / s) * angle).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damping_ratio_gives_back_its_restitution() {
        for restitution in [1.0e-15, 1.0e-3, 0.05, 0.13, 0.14, 0.3, 0.5, 0.8, 0.95, 1.0] {
            let ratio = damping_ratio(restitution, Tension::Clipped);
            let back = clipped_restitution(ratio);
            assert!((back / restitution - 1.0).abs() < 1.0e-9, "{restitution}");
            let ratio: f64 = damping_ratio(restitution, Tension::Unclipped);
            let back = (-PI * ratio / (1.0 - ratio * ratio).sqrt()).exp();
            assert!((back / restitution - 1.0).abs() < 1.0e-12, "{restitution}");
        }
    }

    #[test]
    fn clipping_raises_the_restitution_as_published() {
        // The nominal ones are those of the same dashpot unclipped.
        for (nominal, clipped) in [(0.1, 0.252729), (0.5, 0.550283), (0.9, 0.902026)] {
            let ratio = damping_ratio(nominal, Tension::Unclipped);
            assert!((clipped_restitution(ratio) - clipped).abs() < 1.0e-6);
        }
    }
}
