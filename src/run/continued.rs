//! Stretches of another engine's run that the native engine makes too, while that engine runs: it goes on from a moment that the run has
//! told. What is wrong late in a long run shows there, and no first steps show it.

use std::collections::VecDeque;

use grains::scene::Scene;
use grains::tables::{Snapshot, Stage};
use serde::{Deserialize, Serialize};
use verdict::envelope::{FACTOR, Resolution};
use verdict::excerpt::{Excerpt, STEPS_OF_EXCERPT};
use verdict::judge::OfStart;

/// What the native engine makes of one stretch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Continued {
    pub stage: Stage,
    /// The steps of the stage between which it lies.
    pub from: u64,
    pub to: u64,
    /// How many times as far off the run is as replicas of the native engine in double precision.
    pub ratio: f64,
    /// The same of replicas in single precision, where those in double precision are left.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub in_single: Option<f64>,
    /// Where it is farthest off, in words.
    pub found: String,
}

impl Continued {
    pub fn is_rounding(&self, of: Resolution) -> bool {
        let coarse = self.in_single.filter(|_| !of.is_double());
        coarse.unwrap_or(self.ratio) <= FACTOR
    }
}

/// A stretch is of so many moments at equal distances; the end of a stage may be one more.
const MOMENTS: usize = 3;
/// The first stretch ends at this moment of a stage, counted from 0, and each further one at twice the moment; the last one ends with the
/// stage.
const FIRST: usize = 4;
/// Larger beds would cost too much memory.
const LARGEST: usize = 100_000;

/// Watches a run.
pub struct Continuing<'a> {
    scene: &'a Scene,
    last: VecDeque<Snapshot>,
    /// Of this stage.
    moments: usize,
    pub found: Vec<Continued>,
}

impl<'a> Continuing<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        Continuing {
            scene,
            last: VecDeque::new(),
            moments: 0,
            found: Vec::new(),
        }
    }

    pub fn moment(&mut self, of: &Snapshot) {
        if of.bodies.len() > LARGEST {
            return;
        }
        if self.last.back().is_some_and(|last| last.stage != of.stage) {
            self.end_of_stage();
        }
        if self.last.len() > MOMENTS {
            self.last.pop_front();
        }
        self.last.push_back(of.clone());
        if self.moments >= FIRST && self.moments.is_power_of_two() {
            self.judge(MOMENTS);
        }
        self.moments += 1;
    }

    pub fn end_of_stage(&mut self) {
        let last = self.last.back().map(|of| (of.stage, of.step));
        let judged = self.found.last().map(|of| (of.stage, of.to));
        if self.moments > MOMENTS && last != judged {
            let steps: Vec<u64> = self.last.iter().map(|of| of.step).collect();
            let is_short = steps[2] + steps[2] > steps[1] + steps[3];
            self.judge(MOMENTS + usize::from(is_short));
        }
        (self.moments, self.last) = (0, VecDeque::new());
    }

    /// What native cannot go on from is no stretch; which is the last one is said.
    fn judge(&mut self, moments: usize) {
        let before = self.last.len().saturating_sub(moments);
        let moments: Vec<Snapshot> = self.last.iter().skip(before).cloned().collect();
        let [first, .., last] = &moments[..] else {
            return;
        };
        let (stage, from, to) = (first.stage, first.step, last.step);
        let speed = |of: &Snapshot| of.punch.map(|of| of.velocity);
        let same_speed = moments.iter().all(|of| speed(of) == speed(first));
        // First steps are looked at elsewhere, and longer stretches rounding takes too far.
        if from == 0 || !same_speed || to.saturating_sub(from) > 3 * STEPS_OF_EXCERPT {
            return;
        }
        let Ok(excerpt) = Excerpt::of_moments(self.scene, first, to) else {
            return;
        };
        let judge = |of: Resolution| excerpt.judge(Ok(moments.clone()), of).ok();
        let ratio = |of: &OfStart| {
            let far = of.farthest.as_ref();
            far.map_or(f64::MAX, |of| of.ratio.min(f64::MAX))
        };
        let Some(double) = judge(Resolution::COARSE_DOUBLE) else {
            return;
        };
        let single = Some(&double).filter(|of| ratio(of) > FACTOR);
        let single = single.and_then(|_| judge(Resolution::SINGLE));
        self.found.push(Continued {
            stage,
            from,
            to,
            ratio: ratio(&double),
            in_single: single.as_ref().map(ratio),
            found: double.skipped.clone().unwrap_or(double.in_words()),
        });
    }
}
