//! The report: one page that opens offline, and the pictures and charts on it.

pub mod chart;
pub mod disc_field;
pub mod packing;
pub mod page;
