//! The stability map: the largest stable time step of scene after scene, predicted and found, and the places
//! where the method fails.

pub mod automatic;
pub mod beds;
pub mod checks;
pub mod draft;
pub mod failures;
pub mod growth;
pub mod map;
pub mod network;
pub mod others;
pub mod proposals;
pub mod rounds;
pub mod scenes;
pub mod spectrum;

pub use map::{Map, Options, map};
