//! How the trajectories of two runs diverge that add the same forces in another order: rounding differences grow exponentially
//! while grains collide, until the runs are as far apart as two realizations.
//!
//! Two engines diverge as YADE diverges from itself: growth as fast as between two YADE runs that differ in `verletDist` only,
//! and the same separation in the end. How much two such pairs may differ is measured on perturbed replicas. When the control
//! pair begins to diverge says nothing: it depends on how many sums happen to have another order.

use std::collections::BTreeMap;

use evidence::moments::median;
use serde::Serialize;

use super::replicas::Scatter;
use crate::checks::Outcome;
use crate::run::folder::RunFolder;
use crate::run::folder::record::TraceRow;
use grains::measure::Quantity;
use grains::tables::Stage;

/// Growth is measured from the first separation above this share of the mean radius …
const GROWING: f64 = 1.0e-13;
/// … to the first above this one.
const GROWN: f64 = 1.0e-3;

/// Quantity under which the growth of replicas is kept in a [`Scatter`].
pub const GROWTH_KEY: &str = "divergence.e_folding_steps";
/// Quantity under which the final separation of replicas is kept in a [`Scatter`].
pub const SETTLED_KEY: &str = "divergence.settled_median";

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

/// How one pair of runs diverges.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Divergence {
    /// All moments of pouring that both runs have.
    pub curve: Vec<Separation>,
    /// Steps in which the largest separation grows by a factor of e; none if it does not grow up.
    pub e_folding_steps: Option<f64>,
    /// Median separation at the last moment of pouring that both have, over the mean radius.
    pub settled_median: f64,
}

impl Divergence {
    /// As quantities, for the scatter of replicas; empty where the runs do not diverge far enough.
    pub fn quantities(&self) -> Vec<Quantity> {
        let quantity = |key: &str, value: f64| Quantity {
            key: key.to_owned(),
            value,
            unit: "1".to_owned(),
        };
        match self.e_folding_steps {
            Some(steps) => vec![
                quantity(GROWTH_KEY, steps),
                quantity(SETTLED_KEY, self.settled_median),
            ],
            None => Vec::new(),
        }
    }

    /// How two runs of the same start diverge while pouring.
    pub fn of(a: &RunFolder, b: &RunFolder) -> Self {
        let curve = curve(a, b);
        let first = |above: f64| curve.iter().find(|moment| moment.largest > above);
        let e_folding_steps = first(GROWING).zip(first(GROWN)).and_then(|(from, to)| {
            let growth = (to.largest / from.largest).ln();
            (growth > 0.0).then(|| (to.step - from.step) as f64 / growth)
        });
        Divergence {
            e_folding_steps,
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
        .map(|(step, distances)| Separation {
            step,
            largest: distances.iter().copied().fold(0.0, f64::max),
            median: median(&distances).unwrap_or(0.0),
        })
        .collect()
}

/// Engines against control.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Divergences {
    /// Run A from run B.
    pub engines: Divergence,
    /// Run B from its control.
    pub control: Divergence,
}

impl Divergences {
    /// Runs A and B, and B with its control.
    pub fn of(a: &RunFolder, b: &RunFolder, control: &RunFolder) -> Self {
        Divergences {
            engines: Divergence::of(a, b),
            control: Divergence::of(b, control),
        }
    }

    /// Growth as fast as the control pair's, within the scatter of replicas.
    pub fn growth(&self, scatter: &Scatter) -> (Outcome, String) {
        let pair = self
            .engines
            .e_folding_steps
            .zip(self.control.e_folding_steps);
        judged("e-folding steps", pair, scatter, GROWTH_KEY)
    }

    /// As far apart in the end as the control pair, within the scatter of replicas.
    pub fn settled(&self, scatter: &Scatter) -> (Outcome, String) {
        let grown = self
            .engines
            .e_folding_steps
            .and(self.control.e_folding_steps);
        let pair = grown.map(|_| (self.engines.settled_median, self.control.settled_median));
        let what = "median separation of marked grains at the end of pouring, over R";
        judged(what, pair, scatter, SETTLED_KEY)
    }
}

fn judged(what: &str, pair: Option<(f64, f64)>, scatter: &Scatter, key: &str) -> (Outcome, String) {
    let Some((engines, control)) = pair else {
        let found = format!("{what}: the runs do not diverge far enough to measure it");
        return (Outcome::Skipped, found);
    };
    let pair = format!("{what}: engines {engines:.3}, control pair {control:.3}");
    match scatter.allowed(key) {
        None => (Outcome::Skipped, format!("{pair}; no scatter of replicas")),
        Some(allowed) => (
            Outcome::pass_if((engines - control).abs() <= allowed),
            format!("{pair}; replicas allow a difference of {allowed:.3}"),
        ),
    }
}
