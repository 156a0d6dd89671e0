//! The bits that no order of sums can change.
//!
//! The sum of two forces does not depend on their order, that of three does. So two runs that differ in the
//! order of sums alone have the same bits until some grain first bears three forces at once.

use std::fmt;

use serde::Serialize;

use super::Verdict;
use crate::engine::native;
use crate::engine::{Observer, Task};
use crate::folder::RunFolder;
use crate::scene::{Measurement, Scene};
use crate::tables::{BodyIds, Snapshot, Stage};

/// Up to where two runs agree, and up to where they must.
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
