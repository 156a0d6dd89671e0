//! How two runs part that add the same forces in another order: rounding differences grow
//! exponentially while grains collide, until the runs are as far apart as two realizations.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::run::folder::RunFolder;
use crate::run::folder::record::TraceRow;
use grains::measure::Quantity;
use grains::tables::Stage;

/// Growth is measured from the first separation above this share of the mean radius …
const GROWING: f64 = 1.0e-13;
/// … to the first above this one.
const GROWN: f64 = 1.0e-3;

/// Quantity under which twins' growth is kept in a [`super::spread::Spread`].
pub const GROWTH_KEY: &str = "parting.steps_per_e";
/// Quantity under which twins' settled separation is kept in a [`super::spread::Spread`].
pub const SETTLED_KEY: &str = "parting.settled_median";

/// Separation of the marked grains at one moment of pouring, over the mean radius.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Separation {
    /// Step of pouring.
    pub step: u64,
    /// Of all marked grains.
    pub largest: f64,
    /// Over the marked grains.
    pub median: f64,
}

/// How one pair of runs parts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parting {
    /// All moments of pouring that both runs have.
    pub curve: Vec<Separation>,
    /// Steps in which the largest separation grows by a factor of e; none if it does not grow up.
    pub steps_per_e: Option<f64>,
    /// Median separation at the last moment of pouring that both have, over the mean radius.
    pub settled_median: f64,
}

impl Parting {
    /// As quantities, for the scatter of twins; empty where the runs do not part far enough.
    pub fn quantities(&self) -> Vec<Quantity> {
        let quantity = |key: &str, value: f64| Quantity {
            key: key.to_owned(),
            value,
            unit: "1".to_owned(),
        };
        match self.steps_per_e {
            Some(steps) => vec![
                quantity(GROWTH_KEY, steps),
                quantity(SETTLED_KEY, self.settled_median),
            ],
            None => Vec::new(),
        }
    }

    /// How two runs of the same start part while pouring.
    pub fn of(a: &RunFolder, b: &RunFolder) -> Self {
        let curve = curve(a, b);
        let first = |above: f64| curve.iter().find(|moment| moment.largest > above);
        let steps_per_e = first(GROWING).zip(first(GROWN)).and_then(|(from, to)| {
            let growth = (to.largest / from.largest).ln();
            (growth > 0.0).then(|| (to.step - from.step) as f64 / growth)
        });
        Parting {
            steps_per_e,
            settled_median: curve.last().map_or(0.0, |moment| moment.median),
            curve,
        }
    }
}

fn curve(a: &RunFolder, b: &RunFolder) -> Vec<Separation> {
    let radius = 0.5 * a.scene.particles.mean_diameter;
    let pouring = |row: &&TraceRow| row.stage == Stage::Settle;
    let places: BTreeMap<(u64, u32), [f64; 2]> = b
        .trace
        .iter()
        .filter(pouring)
        .map(|row| ((row.step, row.id), [row.x, row.z]))
        .collect();
    let mut apart: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    for row in a.trace.iter().filter(pouring) {
        if let Some([x, z]) = places.get(&(row.step, row.id)) {
            let distance = (row.x - x).hypot(row.z - z) / radius;
            apart.entry(row.step).or_default().push(distance);
        }
    }
    apart
        .into_iter()
        .map(|(step, mut distances)| {
            distances.sort_by(f64::total_cmp);
            Separation {
                step,
                largest: distances.last().copied().unwrap_or(0.0),
                median: distances[distances.len() / 2],
            }
        })
        .collect()
}
