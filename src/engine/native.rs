//! The native engine: frictionless discs or planar spheres between three walls under a rigid
//! punch, in the same operations and the same order as YADE's sorted loop, so with the same bits.
//!
//! A step is: integrate (forces → velocities → positions), move the punch, rebuild the neighbour
//! list if anything moved too far, evaluate the forces at the new positions.

mod constants;
pub mod contact;
mod health;
mod kernel;
mod neighbours;
pub mod perturb;
mod stages;
mod state;

pub use health::Trouble;
pub use perturb::{Perturbation, PerturbationError};
pub use stages::{NativeError, Options, first_contact_punch, run};
