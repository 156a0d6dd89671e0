//! How far measured quantities scatter between runs that differ in one last bit at the start: the
//! yardstick for runs whose bits cannot agree.

use evidence::moments;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::divergence::Divergence;
use crate::checks::Outcome;
use crate::run::folder::{Moment, RunFolder};
use crate::run::{Engine, EngineError, recorded};
use grains::measure::{self, Quantity};
use grains::native;
use grains::tables::Bodies;

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
    let threads = std::thread::available_parallelism().map_or(1, |count| count.get().min(REPLICAS));
    let next = std::sync::atomic::AtomicUsize::new(0);
    let worker = || -> Result<Vec<(usize, Vec<Quantity>)>, EngineError> {
        let mut mine = Vec::new();
        loop {
            let replica = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            if replica >= REPLICAS {
                return Ok(mine);
            }
            let engine = Engine::Native(native::Options::default());
            let start = nudged(&run.initial, replica as u64 + 1);
            // The native engine leaves nothing in its work folder.
            let nowhere = std::path::Path::new("");
            let of_replica = recorded(
                &run.scene,
                &engine,
                run.record.protocol,
                start,
                nowhere,
                &mut |_, _, _| {},
            )?;
            let mut measured = quantities(&of_replica);
            measured.extend(Divergence::of(run, &of_replica).quantities());
            mine.push((replica, measured));
            done();
        }
    };
    let results: Vec<Result<Vec<_>, EngineError>> = std::thread::scope(|scope| {
        let handles: Vec<_> = (0..threads).map(|_| scope.spawn(worker)).collect();
        handles
            .into_iter()
            .map(|handle| match handle.join() {
                Ok(result) => result,
                Err(panic) => std::panic::resume_unwind(panic),
            })
            .collect()
    });
    let mut replicas = Vec::new();
    for result in results {
        replicas.extend(result?);
    }
    replicas.sort_by_key(|(replica, _)| *replica);
    let replicas: Vec<Vec<Quantity>> = replicas.into_iter().map(|(_, of)| of).collect();
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
