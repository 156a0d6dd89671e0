//! How runs part that add the same forces in another order.
//!
//! Two such runs have the same bits until some grain first bears three forces at once: the sum of two does
//! not depend on their order. From then on rounding differences grow exponentially while grains
//! collide, until the runs are as far apart as two realizations. So three things can be asked of an
//! engine against YADE's ordinary loop: the same bits up to that step; growth as fast as between two
//! YADE runs that differ in `verletDist` only; and the same separation in the end. How much two such
//! pairs may differ is measured on native twins that differ in one last bit of the start.
//! (When the control pair begins to part says nothing: it depends on how many sums happen to have
//! another order.)

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;

use super::Verdict;
use super::spread::Spread;
use crate::engine::native;
use crate::engine::{Observer, Task};
use crate::folder::RunFolder;
use crate::folder::record::TraceRow;
use crate::measure::Quantity;
use crate::scene::{Measurement, Scene};
use crate::tables::{BodyIds, Snapshot, Stage};

/// Growth is measured from the first separation above this share of the mean radius …
const GROWING: f64 = 1.0e-13;
/// … to the first above this one.
const GROWN: f64 = 1.0e-3;

/// Separation of the marked grains at one moment of pouring, over the mean radius.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Separation {
    pub step: u64,
    pub largest: f64,
    pub median: f64,
}

/// How one pair of runs parts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parting {
    pub curve: Vec<Separation>,
    /// Steps in which the largest separation grows by a factor of e; none if it does not grow up.
    pub steps_per_e: Option<f64>,
    /// Median separation at the last moment of pouring that both have, over the mean radius.
    pub settled_median: f64,
}

/// Engines against control.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Partings {
    pub engines: Parting,
    pub control: Parting,
}

impl Partings {
    /// Runs A and B, and B with its control.
    pub fn of(a: &RunFolder, b: &RunFolder, control: &RunFolder) -> Self {
        Partings {
            engines: Parting::of(a, b),
            control: Parting::of(b, control),
        }
    }

    /// Growth as fast as the control pair's, within the scatter of twins.
    pub fn growth(&self, spread: &Spread) -> (Verdict, String) {
        let pair = self.engines.steps_per_e.zip(self.control.steps_per_e);
        judged("steps to grow by a factor of e", pair, spread, GROWTH_KEY)
    }

    /// As far apart in the end as the control pair, within the scatter of twins.
    pub fn settled(&self, spread: &Spread) -> (Verdict, String) {
        let grown = self.engines.steps_per_e.and(self.control.steps_per_e);
        let pair = grown.map(|_| (self.engines.settled_median, self.control.settled_median));
        judged(
            "median separation of marked grains at the end of pouring, over R",
            pair,
            spread,
            SETTLED_KEY,
        )
    }
}

/// Quantity under which twins' growth is kept in a [`Spread`].
const GROWTH_KEY: &str = "parting.steps_per_e";
/// Quantity under which twins' settled separation is kept in a [`Spread`].
const SETTLED_KEY: &str = "parting.settled_median";

fn judged(what: &str, pair: Option<(f64, f64)>, spread: &Spread, key: &str) -> (Verdict, String) {
    let Some((engines, control)) = pair else {
        return (
            Verdict::NotMade,
            format!("{what}: the runs do not part far enough to measure it"),
        );
    };
    let Some(allowed) = spread.allowed(key) else {
        return (
            Verdict::NotMade,
            format!("{what}: engines {engines:.3}, control pair {control:.3}; no scatter of twins"),
        );
    };
    let verdict = if (engines - control).abs() <= allowed {
        Verdict::Pass
    } else {
        Verdict::Fail
    };
    (
        verdict,
        format!(
            "{what}: engines {engines:.3}, control pair {control:.3}; twins allow a difference of \
             {allowed:.3}"
        ),
    )
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

/// The bits that no order of sums can change.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct CommonStart {
    /// First step of pouring whose state has a grain with three contacts; states up to here
    /// must agree. None if there is none up to the first disagreement.
    pub three_forces: Option<u64>,
    /// The last moment of the histories before the first disagreement.
    pub last_equal: Option<u64>,
    /// The first moment that disagrees; none if none does.
    pub first_unequal: Option<u64>,
}

impl CommonStart {
    /// From the histories, and from a native run that is watched step by step.
    pub fn of(a: &RunFolder, b: &RunFolder) -> Result<Self, String> {
        let history = super::bits::history(a, b);
        let pouring = |moment: Option<(Stage, u64)>| {
            moment.and_then(|(stage, step)| (stage == Stage::Settle).then_some(step))
        };
        let first_unequal = pouring(history.first_unequal);
        let three_forces = match first_unequal {
            Some(steps) => first_sum_of_three(&a.scene, a.initial.clone(), steps)?,
            None => None,
        };
        Ok(CommonStart {
            three_forces,
            last_equal: pouring(history.last_equal),
            first_unequal,
        })
    }

    /// No state differs before a grain has borne three forces.
    pub fn verdict(&self) -> Verdict {
        match (self.first_unequal, self.three_forces) {
            (None, _) => Verdict::Pass,
            (Some(unequal), Some(three)) if unequal > three => Verdict::Pass,
            _ => Verdict::Fail,
        }
    }
}

impl fmt::Display for CommonStart {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let step = |step: Option<u64>| step.map_or("never".to_owned(), |s| format!("step {s}"));
        write!(
            out,
            "the order of sums can matter after {}; states agree in every bit up to {}, first differ \
             at {}",
            step(self.three_forces),
            step(self.last_equal),
            step(self.first_unequal)
        )
    }
}

/// The first step of pouring, up to `steps`, whose state has a grain with three contacts.
fn first_sum_of_three(
    scene: &Scene,
    initial: crate::tables::Bodies,
    steps: u64,
) -> Result<Option<u64>, String> {
    struct Watch(Option<u64>);
    impl Observer for Watch {
        fn snapshot(&mut self, snapshot: &Snapshot) {
            if self.0.is_some() {
                return;
            }
            let ids = BodyIds {
                grains: snapshot.bodies.len() as u32,
            };
            let mut forces = vec![0u8; snapshot.bodies.len()];
            for contact in &snapshot.contacts {
                for id in [contact.id1, contact.id2] {
                    if ids.is_grain(id) {
                        forces[id as usize] = forces[id as usize].saturating_add(1);
                    }
                }
            }
            if forces.iter().any(|count| *count >= 3) {
                self.0 = Some(snapshot.step);
            }
        }
    }
    let every_step = Scene {
        measurement: Measurement {
            history_every: 1,
            ..scene.measurement.clone()
        },
        ..scene.clone()
    };
    let mut watch = Watch(None);
    let options = native::Options {
        skin: None,
        perturbation: None,
    };
    let task = Task::pour(initial, steps);
    native::run(&every_step, &task, &options, &mut watch).map_err(|error| error.to_string())?;
    Ok(watch.0)
}
