//! Campaigns: many realizations of one scene, shared out, written down one by one, merged.

pub mod member;
