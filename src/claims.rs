//! The paper's claims about its simulations, held against a campaign's members.

pub mod published;
