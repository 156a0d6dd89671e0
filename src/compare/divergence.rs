//! How two runs whose bits cannot agree diverge: growth as fast as between two YADE runs that differ in `verletDist` only, and
//! the same separation in the end. How much two such pairs may differ, and how far every measured quantity scatters, is measured
//! on perturbed replicas: runs that differ in one last bit at the start. When the control pair begins to diverge says nothing: it
//! depends on how many sums happen to have another order.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::checks::Outcome;
use crate::run::folder::record::TraceRow;
use crate::run::folder::{Moment, RunFolder};
use crate::run::{Engine, EngineError, recorded};
use crate::workers;
use evidence::moments::{self, median};
use grains::measure::{self, Quantity};
use grains::native::{self, NativeError, Trouble};
use grains::tables::{Bodies, Stage};

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

/// Perturbed replicas that the spread is estimated from.
pub const REPLICAS: usize = 12;

/// The chance that any of the quantities of a comparison is called different though nothing is.
pub const FALSE_ALARM: f64 = 0.01;

/// Scatter of one quantity.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct QuantityScatter {
    /// The quantity, as in [`Quantity`].
    pub key: String,
    /// Over the replicas, in the quantity's unit.
    pub mean: f64,
    /// Sample standard deviation over the replicas.
    pub standard_deviation: f64,
    /// How many there are.
    pub replicas: usize,
}

/// Scatter of every quantity that all replicas have.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scatter {
    /// In the order of the first replica.
    pub quantities: Vec<QuantityScatter>,
}

impl Scatter {
    /// From the quantities of several replicas.
    pub fn of(replicas: &[Vec<Quantity>]) -> Self {
        let Some(first) = replicas.first() else {
            return Scatter {
                quantities: Vec::new(),
            };
        };
        let quantities = first.iter().filter_map(|quantity| {
            let values: Option<Vec<f64>> = replicas
                .iter()
                .map(|replica| {
                    let same = replica.iter().find(|other| other.key == quantity.key);
                    same.map(|same| same.value)
                })
                .collect();
            let values = values?;
            Some(QuantityScatter {
                key: quantity.key.clone(),
                mean: moments::mean(&values),
                standard_deviation: moments::standard_deviation(&values),
                replicas: values.len(),
            })
        });
        Scatter {
            quantities: quantities.collect(),
        }
    }

    /// The most that two runs may differ in this quantity: t·s·√2, with Student's t at the false-alarm
    /// rate shared among all quantities (Bonferroni). None for an unknown quantity or too few replicas.
    pub fn allowed(&self, key: &str) -> Option<f64> {
        let of = self.quantities.iter().find(|of| of.key == key)?;
        let freedom = of.replicas.checked_sub(1).filter(|freedom| *freedom > 0)? as f64;
        let student = StudentsT::new(0.0, 1.0, freedom).ok()?;
        let tail = 0.5 * FALSE_ALARM / self.quantities.len() as f64;
        Some(student.inverse_cdf(1.0 - tail) * of.standard_deviation * std::f64::consts::SQRT_2)
    }

    /// Whether the value of another run is within what replicas scatter about their mean.
    pub fn judge(&self, key: &str, value: Option<f64>) -> (Outcome, String) {
        let Some(value) = value else {
            let found = format!("{key}: the runs do not diverge far enough to measure it");
            return (Outcome::Skipped, found);
        };
        let of = self.quantities.iter().find(|of| of.key == key);
        let Some((of, allowed)) = of.zip(self.allowed(key)) else {
            let found = format!("{key}: {value:.3}; no scatter of replicas");
            return (Outcome::Skipped, found);
        };
        let outcome = Outcome::pass_if((value - of.mean).abs() <= allowed);
        let found = format!(
            "{key}: {value:.3}, replicas {:.3}, allowed a difference of {allowed:.3}",
            of.mean
        );
        (outcome, found)
    }
}

/// The measures of a run, made anew from its tables, and how long its stages took.
pub fn quantities(run: &RunFolder) -> Vec<Quantity> {
    let settled = run.settled.as_ref().map(Moment::bed);
    let mut quantities = measure::all(&run.scene, settled, run.last.bed());
    let mut add = |key: String, value: f64, unit: &str| {
        quantities.push(Quantity {
            key,
            value,
            unit: unit.to_owned(),
        });
    };
    for stage in &run.record.stages {
        add(
            format!("{}.steps", stage.stage.name()),
            stage.steps as f64,
            "1",
        );
    }
    if let Some(last) = run.history.last() {
        if let Some(depth) = last.punch_depth {
            add("load.punch_depth".to_owned(), depth, "m");
        }
        if let Some(force) = last.punch_force {
            add("load.punch_force".to_owned(), force, "N");
        }
    }
    quantities
}

/// Runs `REPLICAS` native replicas of a native run: replica k starts with grain 0 moved by k+1 floating-point
/// numbers in x. Scatters their measures, and how each diverges from the run. `done` hears of each
/// that is finished.
pub fn of_replicas(run: &RunFolder, done: &(dyn Fn() + Sync)) -> Result<Scatter, EngineError> {
    let replicas = workers::map(REPLICAS, |replica| {
        let of_replica = recorded(
            &run.scene,
            &Engine::Native(native::Options::default()),
            run.record.protocol,
            nudged(&run.initial, replica as u64 + 1),
            // The native engine leaves nothing in its work folder.
            Path::new(""),
            &mut |_, _, _| {},
        )?;
        let mut measured = quantities(&of_replica);
        measured.extend(Divergence::of(run, &of_replica).quantities());
        done();
        Ok::<_, EngineError>(measured)
    })?;
    if replicas.len() < REPLICAS {
        return Err(EngineError::Native(NativeError {
            stage: Stage::Settle,
            step: 0,
            trouble: Trouble::Interrupted,
        }));
    }
    Ok(Scatter::of(&replicas))
}

/// The same start with one coordinate moved up by a few floating-point numbers.
fn nudged(initial: &Bodies, ulps: u64) -> Bodies {
    let mut bodies = initial.clone();
    if let Some(x) = bodies.x.first_mut() {
        *x = f64::from_bits(x.to_bits() + ulps);
    }
    bodies
}
