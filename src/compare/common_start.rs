//! The bits that no order of sums can change.
//!
//! The sum of two forces does not depend on their order, that of three does. So two runs that differ in the
//! order of sums alone have the same bits until some grain first bears three forces at once.

use std::fmt;

use serde::Serialize;

use super::Verdict;
use super::bits::{self, TableBits};
use super::first_difference::Locator;
use crate::run::folder::RunFolder;
use grains::model::Model;
use grains::native::{self, CaseOptions};
use grains::scene::Scene;
use grains::tables::{Bodies, BodyIds, Snapshot, Stage};
use grains::task::Case;

/// Up to where two runs agree, and up to where they must.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CommonStart {
    /// First step of pouring whose state has a grain with three contacts; states up to here
    /// must agree. None if no state of the run has one.
    pub three_forces: Option<u64>,
    /// The last moment of the histories before the first disagreement.
    pub last_equal: Option<u64>,
    /// The first moment of pouring that disagrees; none if none does.
    pub first_unequal: Option<u64>,
    /// Both engines run anew up to the step with three forces, number by number; none if that was not
    /// asked for.
    pub anew: Option<TableBits>,
}

impl CommonStart {
    /// From the histories, from a native run that is watched step by step and, with a locator, from
    /// both engines run anew up to the very step.
    pub fn of(a: &RunFolder, b: &RunFolder, locator: Option<&Locator>) -> Result<Self, String> {
        let history = bits::history(a, b);
        let pouring = |moment: Option<(Stage, u64)>| {
            moment.and_then(|(stage, step)| (stage == Stage::Settle).then_some(step))
        };
        let steps = a.record.stages.first().map_or(0, |stage| stage.steps);
        let three_forces = first_sum_of_three(&a.scene, &a.initial, steps)?;
        let anew = match (locator, three_forces) {
            (Some(locator), Some(step)) => Some(locator.after_pouring(a, b, step)?),
            _ => None,
        };
        Ok(CommonStart {
            three_forces,
            last_equal: pouring(history.last_equal),
            first_unequal: pouring(history.first_unequal),
            anew,
        })
    }

    /// No state differs before a grain has borne three forces. Not made where the histories have
    /// no moment in between to show it.
    pub fn verdict(&self) -> Verdict {
        if let Some(anew) = &self.anew {
            return anew.verdict();
        }
        match (self.last_equal, self.first_unequal, self.three_forces) {
            (_, Some(unequal), Some(three)) if unequal <= three => Verdict::Fail,
            (_, Some(_), None) => Verdict::Fail,
            (None | Some(0), _, _) => Verdict::Skipped,
            _ => Verdict::Pass,
        }
    }
}

impl fmt::Display for CommonStart {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let step = |step: Option<u64>| step.map_or("never".to_owned(), |s| format!("step {s}"));
        write!(
            out,
            "a grain first bears three forces after {}; ",
            step(self.three_forces)
        )?;
        match &self.anew {
            Some(anew) => write!(out, "both engines run anew up to there: {anew}; ")?,
            None => write!(out, "engines were not run anew up to there; ")?,
        }
        write!(
            out,
            "the histories agree up to {}, first differ at {}",
            step(self.last_equal),
            step(self.first_unequal)
        )
    }
}

/// The first step of pouring, up to `steps`, whose state has a grain with three contacts.
fn first_sum_of_three(scene: &Scene, initial: &Bodies, steps: u64) -> Result<Option<u64>, String> {
    let case = Case {
        name: "until a grain bears three forces".to_owned(),
        model: Model::of(scene),
        bodies: initial.clone(),
        punch: None,
        moments: (0..=steps).collect(),
    };
    let mut found = None;
    native::watch_case(&case, &CaseOptions::default(), &mut |snapshot| {
        if bears_three(&snapshot) {
            found = Some(snapshot.step);
        }
        found.is_none()
    })
    .map_err(|error| error.to_string())?;
    Ok(found)
}

fn bears_three(snapshot: &Snapshot) -> bool {
    let ids = BodyIds::of_box(snapshot.bodies.len() as u32);
    let mut forces = vec![0u8; snapshot.bodies.len()];
    for contact in &snapshot.contacts {
        for id in [contact.id1, contact.id2] {
            if ids.is_grain(id) {
                forces[id as usize] = forces[id as usize].saturating_add(1);
            }
        }
    }
    forces.iter().any(|count| *count >= 3)
}
