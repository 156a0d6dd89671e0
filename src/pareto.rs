//! Cost against error: what each way of running the paper's scene costs, and what it does to the results.

pub mod margins;
