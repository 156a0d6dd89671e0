//! What happens at a contact besides its normal spring: rotation, dashpots and slip.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What happens at a contact besides its normal spring: the choices that YADE makes are the default.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactLaw {
    /// Whether friction turns grains.
    pub rotation: Rotation,
    /// Dashpots beside the normal springs.
    pub viscosity: Viscosity,
    /// Which velocity counts as slip.
    pub slip_velocity: SlipVelocity,
    /// Where the contact force acts on a grain.
    pub torque_arms: TorqueArms,
    /// How much of the first step's slip a new contact is given.
    pub new_contact_slip: NewContactSlip,
}

impl Default for ContactLaw {
    fn default() -> Self {
        ContactLaw {
            rotation: Rotation::Free,
            viscosity: Viscosity::None,
            slip_velocity: SlipVelocity::RatchetingCorrected,
            torque_arms: TorqueArms::HalfOverlap,
            new_contact_slip: NewContactSlip::WholeStep,
        }
    }
}

impl ContactLaw {
    /// Whether this is what a scene without the key means.
    pub fn is_default(&self) -> bool {
        *self == ContactLaw::default()
    }
}

/// Whether friction turns grains.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Rotation {
    /// Grains spin about the axis across the plane.
    Free,
    /// Grains keep the spin zero.
    Blocked,
}

/// Dashpots beside the normal springs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Viscosity {
    /// Springs only.
    None,
    /// The same damping constant at every contact: F_n = k_n u_n + c_n du_n/dt.
    Dashpot {
        /// c_n, N·s/m.
        c_n: f64,
        /// Whether the dashpot may pull.
        tension: Tension,
    },
    /// At each contact the damping constant that gives its pair this restitution.
    Restitution {
        /// Rebound speed over approach speed, in (0, 1].
        e_n: f64,
        /// Whether the dashpot may pull.
        tension: Tension,
    },
}

/// Whether a dashpot may pull.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Tension {
    /// The normal force is never less than zero.
    Clipped,
    /// It pulls until the grains have parted.
    Unclipped,
}

/// Which velocity counts as slip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SlipVelocity {
    /// That of the surfaces of the undeformed grains, so that a cycle of rolling under changing overlap
    /// leaves no displacement; at the outside of the punch, as in YADE, that of the contact point.
    RatchetingCorrected,
    /// That of the two bodies at the contact point.
    ContactPoint,
}

/// Where the contact force acts on a grain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TorqueArms {
    /// At the distance R − u_n/2 from the centre, at walls too.
    HalfOverlap,
    /// At the contact point: at a wall, R − u_n.
    ContactPoint,
}

/// How much of the first step's slip a new contact is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum NewContactSlip {
    /// The slip of the whole step, though the grains met during it.
    WholeStep,
    /// The slip since they met: overlap over approach speed, a step at most.
    SinceTouch,
}
