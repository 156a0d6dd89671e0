//! How far measured quantities scatter between runs that differ in one last bit at the start: the
//! yardstick for runs whose bits cannot agree.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::Verdict;
use super::parting::Parting;
use crate::run::folder::{Moment, RunFolder};
use crate::run::{Engine, EngineError, recorded};
use grains::measure::{self, Quantity};
use grains::native;
use grains::tables::Bodies;

/// Twins that the spread is estimated from.
pub const TWINS: usize = 12;

/// The chance that any of the quantities of a comparison is called different though nothing is.
pub const FALSE_ALARM: f64 = 0.01;

/// Scatter of one quantity.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct QuantitySpread {
    /// The quantity, as in [`Quantity`].
    pub key: String,
    /// Over the twins, in the quantity's unit.
    pub mean: f64,
    /// Sample standard deviation over the twins.
    pub deviation: f64,
    /// How many there are.
    pub twins: usize,
}

/// Scatter of every quantity that all twins have.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Spread {
    /// In the order of the first twin.
    pub quantities: Vec<QuantitySpread>,
}

impl Spread {
    /// From the quantities of several twins.
    pub fn of(twins: &[Vec<Quantity>]) -> Self {
        let Some(first) = twins.first() else {
            return Spread {
                quantities: Vec::new(),
            };
        };
        let quantities = first.iter().filter_map(|quantity| {
            let values: Option<Vec<f64>> = twins
                .iter()
                .map(|twin| {
                    let same = twin.iter().find(|other| other.key == quantity.key);
                    same.map(|same| same.value)
                })
                .collect();
            let values = values?;
            let count = values.len() as f64;
            let mean = values.iter().sum::<f64>() / count;
            let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
            Some(QuantitySpread {
                key: quantity.key.clone(),
                mean,
                deviation: (squares / (count - 1.0)).sqrt(),
                twins: values.len(),
            })
        });
        Spread {
            quantities: quantities.collect(),
        }
    }

    /// The most that two runs may differ in this quantity: t·s·√2, with Student's t at the false-alarm
    /// rate shared among all quantities (Bonferroni). None for an unknown quantity or too few twins.
    pub fn allowed(&self, key: &str) -> Option<f64> {
        let of = self.quantities.iter().find(|of| of.key == key)?;
        let freedom = of.twins.checked_sub(1).filter(|freedom| *freedom > 0)? as f64;
        let student = StudentsT::new(0.0, 1.0, freedom).ok()?;
        let tail = 0.5 * FALSE_ALARM / self.quantities.len() as f64;
        Some(student.inverse_cdf(1.0 - tail) * of.deviation * std::f64::consts::SQRT_2)
    }

    /// Whether a value that is no twin's is within what twins scatter about their mean.
    pub fn judge(&self, key: &str, value: Option<f64>) -> (Verdict, String) {
        let Some(value) = value else {
            let found = format!("{key}: the runs do not part far enough to measure it");
            return (Verdict::NotMade, found);
        };
        let of = self.quantities.iter().find(|of| of.key == key);
        let Some((of, allowed)) = of.zip(self.allowed(key)) else {
            let found = format!("{key}: {value:.3}; no scatter of twins");
            return (Verdict::NotMade, found);
        };
        let verdict = if (value - of.mean).abs() <= allowed {
            Verdict::Pass
        } else {
            Verdict::Fail
        };
        let found = format!(
            "{key}: {value:.3}, twins {:.3}, allowed a difference of {allowed:.3}",
            of.mean
        );
        (verdict, found)
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

/// Runs `TWINS` native twins of a native run: twin k starts with grain 0 moved by k+1 floating-point
/// numbers in x. Scatters their measures, and how each parts from the run. `done` hears of each
/// that is finished.
pub fn of_twins(run: &RunFolder, done: &(dyn Fn() + Sync)) -> Result<Spread, EngineError> {
    let threads = std::thread::available_parallelism().map_or(1, |count| count.get().min(TWINS));
    let next = std::sync::atomic::AtomicUsize::new(0);
    let worker = || -> Result<Vec<(usize, Vec<Quantity>)>, EngineError> {
        let mut mine = Vec::new();
        loop {
            let twin = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            if twin >= TWINS {
                return Ok(mine);
            }
            let engine = Engine::Native(native::Options::default());
            let start = nudged(&run.initial, twin as u64 + 1);
            // The native engine leaves nothing in its work folder.
            let nowhere = std::path::Path::new("");
            let of_twin = recorded(
                &run.scene,
                &engine,
                run.record.protocol,
                start,
                nowhere,
                &mut |_, _, _| {},
            )?;
            let mut measured = quantities(&of_twin);
            measured.extend(Parting::of(run, &of_twin).quantities());
            mine.push((twin, measured));
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
    let mut twins = Vec::new();
    for result in results {
        twins.extend(result?);
    }
    twins.sort_by_key(|(twin, _)| *twin);
    let twins: Vec<Vec<Quantity>> = twins.into_iter().map(|(_, of)| of).collect();
    Ok(Spread::of(&twins))
}

/// The same start with one coordinate moved up by a few floating-point numbers.
fn nudged(initial: &Bodies, ulps: u64) -> Bodies {
    let mut bodies = initial.clone();
    if let Some(x) = bodies.x.first_mut() {
        *x = f64::from_bits(x.to_bits() + ulps);
    }
    bodies
}
