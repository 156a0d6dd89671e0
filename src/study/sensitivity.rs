//! What the published figures depend on: the experiment over the choices that the paper does not print.

pub mod bearing;
pub mod choices;
pub mod job;
pub mod judge;
pub mod plan;
pub mod push;
pub mod record;
pub mod row;
