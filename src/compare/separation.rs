//! How fast two runs part that add the same forces in another order.
//!
//! Rounding differences grow exponentially while grains collide, so such runs part for good after
//! some thousand steps. What can be asked is that two engines part no sooner than one engine from
//! itself.

use std::fmt;

use serde::Serialize;

use super::Verdict;
use crate::folder::RunFolder;
use crate::tables::Stage;

/// Runs count as parted once a marked grain is this share of the mean radius off.
pub const PARTED: f64 = 1.0e-6;

/// The engines may part this much sooner than the control pair, as a share of its horizon: the
/// onset depends on a single rounding, so it varies from pair to pair.
pub const SOONER: f64 = 0.8;

/// The largest separation of a marked grain at one moment of pouring.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Separation {
    pub step: u64,
    /// max |Δx| over marked grains, over the mean radius.
    pub engines: f64,
    /// The same within the control pair.
    pub control: f64,
}

/// When runs part.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Horizons {
    pub curve: Vec<Separation>,
    /// First step of pouring at which A and B are more than [`PARTED`] apart.
    pub engines: Option<u64>,
    /// The same for B and its control.
    pub control: Option<u64>,
}

impl Horizons {
    /// Passed if the engines part no sooner than the control pair, within [`SOONER`]. Where the
    /// control pair does not part there is no yardstick: then only parting engines are a finding.
    pub fn verdict(&self) -> Verdict {
        match (self.engines, self.control) {
            (Some(engines), Some(control)) if (engines as f64) < SOONER * control as f64 => {
                Verdict::Fail
            }
            (Some(_), None) => Verdict::Fail,
            (None, None) => Verdict::NotMade,
            _ => Verdict::Pass,
        }
    }
}

impl fmt::Display for Horizons {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let step = |step: Option<u64>| step.map_or("never".to_owned(), |s| format!("step {s}"));
        write!(
            out,
            "{PARTED:e} R apart: the engines at {}, the control pair at {} (allowed from {SOONER} of it)",
            step(self.engines),
            step(self.control)
        )
    }
}

/// Separation of the marked grains over pouring: A from B, and B from its control.
pub fn horizons(a: &RunFolder, b: &RunFolder, control: &RunFolder) -> Horizons {
    let radius = 0.5 * a.scene.particles.mean_diameter;
    let engines = apart(a, b, radius);
    let control = apart(b, control, radius);
    let parted = |curve: &[(u64, f64)]| {
        curve
            .iter()
            .find(|(_, apart)| *apart > PARTED)
            .map(|(step, _)| *step)
    };
    Horizons {
        engines: parted(&engines),
        control: parted(&control),
        curve: engines
            .iter()
            .filter_map(|(step, engines)| {
                let (_, control) = control.iter().find(|(other, _)| other == step)?;
                Some(Separation {
                    step: *step,
                    engines: *engines,
                    control: *control,
                })
            })
            .collect(),
    }
}

/// Steps of pouring that both traces have, with the largest separation over the radius.
fn apart(a: &RunFolder, b: &RunFolder, radius: f64) -> Vec<(u64, f64)> {
    let mut curve: Vec<(u64, f64)> = Vec::new();
    let key = |row: &crate::folder::record::TraceRow| (row.stage, row.step, row.id);
    let mut others = b.trace.iter().peekable();
    for row in a.trace.iter().filter(|row| row.stage == Stage::Settle) {
        while others.next_if(|other| key(other) < key(row)).is_some() {}
        let Some(other) = others.peek().filter(|other| key(other) == key(row)) else {
            continue;
        };
        let apart = (row.x - other.x).hypot(row.z - other.z) / radius;
        match curve.last_mut() {
            Some((step, largest)) if *step == row.step => *largest = largest.max(apart),
            _ => curve.push((row.step, apart)),
        }
    }
    curve
}
