//! Conservation.

use crate::verify::Rung;

/// The rungs.
pub fn rungs() -> Vec<Rung> {
    vec![]
}
