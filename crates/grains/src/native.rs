//! The native engine: discs or planar spheres between walls under a rigid punch, in the same operations
//! and the same order as YADE's sorted loop, so with the same bits.
//!
//! A step is: integrate (forces → velocities → positions), move the punch, rebuild the neighbour
//! list if anything moved too far, evaluate the forces at the new positions. The model selects the
//! kernel that evaluates them: the frictionless one computes normal springs and nothing else.

mod case;
mod constants;
pub mod contact;
mod dynamics;
pub mod friction;
mod general;
mod health;
mod integrate;
mod neighbours;
pub mod perturb;
pub mod pouring;
mod rows;
mod springs;
mod stages;
mod state;
pub mod timing;

pub use case::{CaseOptions, effective, loads, run_case, watch_case};
pub use health::{Trouble, check_moment};
pub use perturb::{Perturbation, PerturbationError};
pub use stages::{NativeError, Options, first_contact_punch, run};

use serde::{Deserialize, Serialize};

/// How sums and precision are chosen. Every result of another mode than the exact one is labelled with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// YADE's operations in YADE's order: the same bits as its sorted loop
    #[default]
    Exact,
    /// Double precision, operations and sums in any order; frictionless scenes only
    Free,
    /// As free, with contact forces in single precision from cell-relative coordinates
    Single,
}

impl std::str::FromStr for Mode {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        [Mode::Exact, Mode::Free, Mode::Single]
            .into_iter()
            .find(|mode| mode.name() == text)
            .ok_or_else(|| "a mode is exact, free or single".to_owned())
    }
}

impl Mode {
    /// The word for it, as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Mode::Exact => "exact",
            Mode::Free => "free",
            Mode::Single => "single",
        }
    }

    /// Whether this is the mode that records and commands need not mention.
    pub fn is_exact(&self) -> bool {
        *self == Mode::Exact
    }
}
