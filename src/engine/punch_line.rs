//! The punch as both drivers' programs write it in the line of a moment.

use serde::Deserialize;

use grains::tables::Punch;

/// Place and velocity of the punch and the force on it, SI units.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PunchLine {
    centre: [f64; 2],
    start: f64,
    velocity: f64,
    force: f64,
}

impl PunchLine {
    /// A punch of this size; else what is wrong with it `at` this place.
    pub fn read(&self, half_extents: [f64; 2], at: &str) -> Result<Punch, String> {
        let [x, z] = self.centre;
        let numbers = [x, z, self.start, self.velocity, self.force];
        if !numbers.iter().all(|value| value.is_finite()) {
            return Err(format!("{at}: the punch is not finite"));
        }
        Ok(Punch {
            centre: self.centre,
            half_extents,
            start: self.start,
            velocity: self.velocity,
            force: self.force,
        })
    }
}
