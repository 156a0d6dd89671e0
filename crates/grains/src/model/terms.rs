//! Which terms of the method a scene pays for, each with the reason that it is in or out.

use serde::{Deserialize, Serialize};

use super::Law;
use crate::scene::{Rotation, Scene};

/// One term of the method.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Term {
    /// What it is.
    pub term: String,
    /// Whether it is computed.
    pub computed: bool,
    /// Why, from the scene.
    pub reason: String,
}

/// The contact kernels of the native engine; the scene selects one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kernel {
    /// Normal springs only: no rotations, no history, no dashpots.
    Frictionless,
    /// Friction with history, dashpots, or both.
    General,
}

/// What is computed of a scene.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelRecord {
    /// The kernel of the native engine that computes the contacts; none for another engine.
    pub kernel: Option<Kernel>,
    /// The terms that may be in or out.
    pub terms: Vec<Term>,
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
    /// What this scene pays for, in the native engine or in another.
    pub fn of(scene: &Scene, native: bool) -> Self {
        let law = super::Model::of(scene).law;
        let angle = law.friction_angle;
        let alpha = scene.damping.alpha();
        let term = |term: &str, computed: bool, reason: String| Term {
            term: term.to_owned(),
            computed,
            reason,
        };
        let friction = if law.has_friction() {
            format!("friction_angle = {angle} rad")
        } else {
            "friction_angle = 0: the Coulomb limit is zero".to_owned()
        };
        let rotation = match (law.has_friction(), law.contact.rotation) {
            (false, _) => "without friction nothing turns a grain".to_owned(),
            (true, Rotation::Blocked) => "contact.rotation = blocked".to_owned(),
            (true, Rotation::Free) => "friction turns grains, contact.rotation = free".to_owned(),
        };
        let dashpots = if law.has_dashpots() {
            "contact.viscosity has a dashpot"
        } else {
            "contact.viscosity.kind = none"
        };
        ModelRecord {
            kernel: native.then(|| Kernel::of(&law)),
            terms: vec![
                term("normal spring", true, "every contact has one".to_owned()),
                term(
                    "tangential spring, Coulomb limit and their history",
                    law.has_friction(),
                    friction,
                ),
                term("rotation of the grains", law.rotates(), rotation),
                term("dashpots", law.has_dashpots(), dashpots.to_owned()),
                term(
                    "local damping",
                    alpha != 0.0,
                    format!("damping.alpha = {alpha}"),
                ),
                term(
                    "gravity",
                    scene.gravity != 0.0,
                    format!("gravity = {} m/s²", scene.gravity),
                ),
            ],
        }
    }
}
