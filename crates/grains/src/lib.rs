//! Discs and planar spheres: scenes, initial grains, the native engine, and measures of a bed.
//!
//! Data flows one way: scene → model → generate → native → measure. Nothing here reads a file or writes to a terminal.

pub mod case;
pub mod digest;
pub mod generate;
pub mod measure;
pub mod model;
pub mod native;
pub mod scene;
pub mod stop;
pub mod tables;
pub mod task;
pub mod timing;

/// SHA-256 over every file of this crate's source, in hexadecimal: results with different digests may have different bits.
pub const SOURCE_DIGEST: &str = env!("GRAINS_SOURCE_DIGEST");
