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
mod history;
mod integrate;
mod mode;
mod neighbours;
pub mod perturb;
pub mod pouring;
mod rows;
mod slow;
mod springs;
mod stages;
mod state;
pub mod timing;

pub use case::{CaseOptions, effective, loads, run_case, watch_case};
pub use health::{Trouble, check_moment};
pub use mode::Mode;
pub use perturb::{Perturbation, PerturbationError};
pub use stages::{NativeError, Options, first_contact_punch, run};
