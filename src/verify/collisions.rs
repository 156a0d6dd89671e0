//! To be written.

use super::Rung;

/// The rungs.
pub fn rungs() -> Vec<Rung> {
    Vec::new()
}
