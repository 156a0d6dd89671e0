//! Cost against error: what each way of running the paper's scene costs, and what it does to the results.

pub mod choice;
pub mod convergence;
pub mod job;
pub mod judge;
pub mod ledger;
pub mod margins;
pub mod member;
pub mod method;
pub mod plan;
pub mod record;
