//! crossgrain: a validation harness for discrete-element engines.
//!
//! Data flows one way, and a module imports only modules that stand before it here; `tests/architecture.rs` fails otherwise.
//! `docs/architecture.md` says what stands where.

/// Exit codes; scripts rely on them.
pub mod exit {
    /// Everything agreed, or was done.
    pub const AGREED: u8 = 0;
    /// A check failed.
    pub const CHECK_FAILED: u8 = 1;
    /// The command line, a scene or a run folder cannot be used.
    pub const USAGE: u8 = 2;
    /// The run or the comparison is incomplete.
    pub const INCOMPLETE: u8 = 3;
    /// An engine failed.
    pub const ENGINE_FAILED: u8 = 4;
    /// The surroundings failed (a full disk, no permission to write, a signal to end): try again.
    pub const TRY_AGAIN: u8 = 75;
}

pub mod files;

pub mod workers;

pub mod child;

pub mod checks;

pub mod document;

pub mod tables;

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
