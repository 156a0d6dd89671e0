//! Two engines part as YADE parts from itself: growth as fast as between two YADE runs that differ in
//! `verletDist` only, and the same separation in the end. How much two such pairs may differ is
//! measured on native twins that differ in one last bit of the start.
//!
//! When the control pair begins to part says nothing: it depends on how many sums happen to have
//! another order.

use serde::Serialize;

use super::Verdict;
use super::parting::{GROWTH_KEY, Parting, SETTLED_KEY};
use super::spread::Spread;
use crate::run::folder::RunFolder;

/// Engines against control.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Partings {
    /// Run A from run B.
    pub engines: Parting,
    /// Run B from its control.
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
