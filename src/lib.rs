//! crossgrain: a validation harness for discrete-element engines.
//!
//! Data flows one way: a module imports only modules that stand before it here.
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

pub mod report;

pub mod limits;

pub mod reproduce;

pub mod explain;

pub mod cli;
