//! crossgrain: a validation harness for discrete-element engines.
//!
//! Data flows one way, and imports point back along it only:
//! scene → model → generate → engine (native | yade | exec) → measure → statistics → folder → progress → run → continuum → paper → compare →
//! error → workers → verify → stability → bench → realization → pareto → campaign → claims → sensitivity → figures → reproduce → baseline →
//! explain → export → report → cli.
//! `docs/architecture.md` says what stands where.

pub mod files;

pub mod interrupt;

pub mod child;

pub mod checks;

pub mod scene;

pub mod model;

pub mod tables;

pub mod generate;

pub mod engine;

pub mod measure;

pub mod statistics;

pub mod folder;

pub mod progress;

pub mod run;

pub mod quadrature;

pub mod continuum;

pub mod paper;

pub mod compare;

pub mod error;

pub mod workers;

pub mod verify;

pub mod stability;

pub mod bench;

pub mod realization;

pub mod pareto;

pub mod campaign;

pub mod claims;

pub mod sensitivity;

pub mod figures;

pub mod reproduce;

pub mod baseline;

pub mod explain;

pub mod export;

pub mod report;

pub mod cli;
