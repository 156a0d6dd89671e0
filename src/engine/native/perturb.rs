//! Deliberate small faults, so that a comparison can prove that it would notice them.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::constants::Constants;
use super::contact::Axis;
use crate::scene::Scene;

/// One fault in the native engine, as written on the command line: `stiffness=1e-12`,
/// `gravity=1e-12`, `damping=1e-12`, `wall=1e-12`, `sums=reversed`, `wall=missing`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Perturbation {
    /// Every k_n is multiplied by 1 + this.
    Stiffness(f64),
    /// Gravity is multiplied by 1 + this.
    Gravity(f64),
    /// The damping number is multiplied by 1 + this.
    Damping(f64),
    /// The right wall is moved by this share of the box's width.
    Wall(f64),
    /// The right wall is not there.
    MissingWall,
    /// The forces on a grain are summed from the highest partner down.
    ReversedSums,
}

/// A perturbation that this engine does not know.
#[derive(Debug, thiserror::Error)]
#[error(
    "unknown perturbation {0:?}; write stiffness=S, gravity=S, damping=S or wall=S with a number S, \
     wall=missing or sums=reversed"
)]
pub struct PerturbationError(String);

impl Perturbation {
    /// Whether a run of this scene is any different with the fault: without gravity, a fault in
    /// gravity is none.
    pub fn changes(self, scene: &Scene) -> bool {
        let sound = Constants::new(scene);
        let mut faulty = sound.clone();
        self.apply(&mut faulty);
        faulty != sound
    }

    /// Puts the fault in.
    pub(super) fn apply(self, constants: &mut Constants) {
        let is_right = |axis: Axis, place: f64| axis == Axis::X && place > 0.0;
        match self {
            Perturbation::Stiffness(size) => constants.stiffness_factor *= 1.0 + size,
            Perturbation::Gravity(size) => constants.gravity *= 1.0 + size,
            Perturbation::Damping(size) => constants.alpha *= 1.0 + size,
            Perturbation::Wall(size) => {
                for wall in &mut constants.walls {
                    if is_right(wall.axis, wall.place) {
                        wall.place += size * constants.width;
                    }
                }
            }
            Perturbation::MissingWall => constants
                .walls
                .retain(|wall| !is_right(wall.axis, wall.place)),
            Perturbation::ReversedSums => constants.reversed_sums = true,
        }
    }
}

impl FromStr for Perturbation {
    type Err = PerturbationError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let unknown = || PerturbationError(text.to_owned());
        let (what, size) = text.split_once('=').ok_or_else(unknown)?;
        match (what, size) {
            ("wall", "missing") => return Ok(Perturbation::MissingWall),
            ("sums", "reversed") => return Ok(Perturbation::ReversedSums),
            _ => {}
        }
        let size: f64 = size.parse().map_err(|_| unknown())?;
        if !size.is_finite() {
            return Err(unknown());
        }
        match what {
            "stiffness" => Ok(Perturbation::Stiffness(size)),
            "gravity" => Ok(Perturbation::Gravity(size)),
            "damping" => Ok(Perturbation::Damping(size)),
            "wall" => Ok(Perturbation::Wall(size)),
            _ => Err(unknown()),
        }
    }
}

impl fmt::Display for Perturbation {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Perturbation::Stiffness(size) => write!(out, "stiffness={size:e}"),
            Perturbation::Gravity(size) => write!(out, "gravity={size:e}"),
            Perturbation::Damping(size) => write!(out, "damping={size:e}"),
            Perturbation::Wall(size) => write!(out, "wall={size:e}"),
            Perturbation::MissingWall => write!(out, "wall=missing"),
            Perturbation::ReversedSums => write!(out, "sums=reversed"),
        }
    }
}

impl TryFrom<String> for Perturbation {
    type Error = PerturbationError;
    fn try_from(text: String) -> Result<Self, Self::Error> {
        text.parse()
    }
}

impl From<Perturbation> for String {
    fn from(perturbation: Perturbation) -> String {
        perturbation.to_string()
    }
}
