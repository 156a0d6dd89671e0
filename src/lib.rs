//! crossgrain: a validation harness for discrete-element engines.
//!
//! Data flows one way, and imports point back along it only:
//! scene → model → generate → engine (native | yade | exec) → measure → statistics → folder → progress → run → continuum → paper → compare →
//! error → workers → verify → stability → bench → realization → tradeoff → campaign → claims → sensitivity → figures → reproduce → baseline →
//! explain → export → report → cli.
//! `docs/architecture.md` says what stands where.

pub mod exit;

pub mod files;

pub mod interrupt;

pub mod child;

pub mod checks;

pub mod document;

pub mod tables;

pub mod engine;

pub mod progress;

pub mod run;

pub mod paper;

pub mod compare;

pub mod error;

pub mod suite;

pub mod study;

pub mod limits;

pub mod reproduce;

pub mod explain;

pub mod report;

pub mod cli;
