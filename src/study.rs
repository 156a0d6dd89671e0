//! Many runs of one scene.

pub mod campaign;
pub mod claims;
pub mod figures;
pub mod realization;
pub mod sensitivity;
pub mod tradeoff;
pub mod workers;
