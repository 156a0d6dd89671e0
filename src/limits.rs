//! Where methods end, and what they cost.

pub mod bench;
pub mod stability;
