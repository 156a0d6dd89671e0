//! The paper's claims about its simulations, held against a campaign's members.
//!
//! One number a packing throughout; what is decided is whether an effect is smaller than a tolerance that was set
//! beforehand, never whether a p-value is small: with a thousand packings every difference has a small one.

mod bed;
mod cells;
pub mod claim;
mod exponential;
mod figures;
mod means;
pub mod published;
mod quantities;
mod record;
mod sample;
mod section_5;
mod signs;
mod volumes;

pub use figures::{Figures, Histogram};
pub use record::{CLAIMS_VERSION, Claims, Origin, of};
pub use sample::Moment;
pub use volumes::{Volume, Volumes, continuum};
