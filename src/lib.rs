//! crossgrain: a validation harness for discrete-element engines.
//!
//! Data flows one way, and a module imports only modules that stand before it here; `tests/architecture.rs` fails otherwise.
//! `docs/architecture.md` says what stands where.

pub mod exit;

pub mod files;

pub mod workers;

mod control_group;

pub mod child;

pub mod checks;

pub mod document;

pub mod tables;

pub mod stl;

pub mod engine;

pub mod progress;

pub mod run;

pub mod paper;

pub mod compare;

pub mod suite;

pub mod study;

pub mod error;

pub mod report;

/// Where methods end, and what they cost.
pub mod limits {
    pub mod bench;
    pub mod stability;
}

pub mod reproduce;

pub mod explain;

pub mod cli;
