//! crossgrain: a validation harness for discrete-element engines.
//!
//! Data flows one way, and imports only point back along it:
//! scene → generate → engine (native | yade) → measure → compare → report.

pub mod files;

pub mod scene;

pub mod tables;

pub mod generate;

pub mod engine;
