//! Collisions of one or two grains, whose outcome is known in closed form.
//!
//! Two kinds of closed form stand behind them. `continuum` solves the equations of motion, as textbooks
//! do; what a run may be off it follows from the length of the step. `leapfrog` solves the scheme itself;
//! a run is off it by nothing but rounding, so the rungs on it feel the smallest faults.

mod ball;
mod bounces;
mod bouncing;
mod chung_ooi;
mod continuum;
mod drops;
mod experiment;
mod falling;
mod first_slip;
mod head_on;
mod leapfrog;
mod oblique;
mod pairs;
mod sharp;
mod slide;
mod sliding;
mod squeezed;
mod sticking;

#[cfg(test)]
mod tests;

use super::Rung;

/// The rungs.
pub fn rungs() -> Vec<Rung> {
    let parts = [
        bounces::rungs(),
        drops::rungs(),
        bouncing::rungs(),
        chung_ooi::rungs(),
        oblique::rungs(),
        pairs::rungs(),
        sharp::rungs(),
    ];
    parts.into_iter().flatten().collect()
}
