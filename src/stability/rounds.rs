//! The largest stable step in YADE: many steps of many scenes in one process, then a finer round.

use crate::engine::Observer;
use crate::engine::case::Case;
use crate::engine::yade::{self, YadeError, run_cases};
use crate::files::work_folder;

use super::growth::{Disturbed, Found};

/// Half-width of the first round about where the limit is looked for, relative: without damping, and with it, where the
/// first unstable steps are a narrow range.
const FIRST: f64 = 0.06;
const FIRST_DAMPED: f64 = 0.02;
/// Trials a round.
const TRIALS: usize = 5;
/// Rounds at most: two that halve in, and some to find the limit where it is not expected.
const MOST_ROUNDS: usize = 5;
/// The limit is known to this share.
const RESOLUTION: f64 = 6.0e-3;

/// One limit to be found.
#[derive(Debug, Clone)]
pub struct Search {
    disturbed: Disturbed,
    alpha: f64,
    low: f64,
    high: f64,
    /// The bracket, once each side has been seen.
    stable: Option<f64>,
    unstable: Option<f64>,
    trials: u32,
}

impl Search {
    /// Looks about this step first.
    pub fn new(disturbed: Disturbed, alpha: f64, about: f64) -> Self {
        let first = if alpha > 0.0 { FIRST_DAMPED } else { FIRST };
        Search {
            disturbed,
            alpha,
            low: about / (1.0 + first),
            high: about * (1.0 + first),
            stable: None,
            unstable: None,
            trials: 0,
        }
    }

    fn found(&self) -> Option<Found> {
        let (stable, unstable) = (self.stable?, self.unstable?);
        Some(Found::between(stable, unstable, self.trials))
    }

    fn is_done(&self) -> bool {
        self.found()
            .is_some_and(|found| found.unstable / found.stable <= 1.0 + RESOLUTION)
    }

    /// The steps of the next round: evenly between what is known, or over the range with its ends.
    fn steps(&self) -> Vec<f64> {
        let (low, high, parts, from) = match self.found() {
            Some(found) => (found.stable, found.unstable, TRIALS + 1, 1),
            None => (self.low, self.high, TRIALS - 1, 0),
        };
        let ratio = (high / low).ln() / parts as f64;
        (from..from + TRIALS)
            .map(|at| low * (ratio * at as f64).exp())
            .collect()
    }

    /// Takes over what a round has shown: up to the first step at which it grew.
    fn learn(&mut self, steps: &[f64], grew: &[bool]) {
        self.trials += steps.len() as u32;
        let first = grew.iter().position(|grew| *grew);
        let last_stable = first.unwrap_or(steps.len()).checked_sub(1);
        if let Some(at) = last_stable {
            self.stable = Some(steps[at]);
        }
        if let Some(at) = first {
            self.unstable = Some(steps[at]);
        }
        // Not in the range: the next round looks beside it.
        let width = self.high / self.low;
        if self.stable.is_none() {
            (self.low, self.high) = (self.low / width, self.low);
        } else if self.unstable.is_none() {
            (self.low, self.high) = (self.high, self.high * width);
        }
    }
}

/// All limits, in the order of the searches; none where it was not found.
pub fn find_all(
    mut searches: Vec<Search>,
    options: &yade::Options,
    observer: &mut dyn Observer,
) -> Result<Vec<Option<Found>>, YadeError> {
    for _ in 0..MOST_ROUNDS {
        let open: Vec<usize> = (0..searches.len())
            .filter(|at| !searches[*at].is_done())
            .collect();
        if open.is_empty() {
            break;
        }
        let trials: Vec<Vec<f64>> = open.iter().map(|at| searches[*at].steps()).collect();
        let cases: Vec<Case> = open
            .iter()
            .zip(&trials)
            .flat_map(|(at, steps)| {
                let search = &searches[*at];
                steps
                    .iter()
                    .map(|dt| search.disturbed.at(*dt, search.alpha))
            })
            .collect();
        let work = work_folder()?;
        let cases: Vec<&Case> = cases.iter().collect();
        let run = run_cases(&cases, options, work.path(), observer)?;
        let mut tracks = run.cases.into_iter();
        for (at, steps) in open.iter().zip(&trials) {
            let search = &mut searches[*at];
            let grew: Vec<bool> = tracks
                .by_ref()
                .take(steps.len())
                .map(|of| search.disturbed.has_grown(&of.track))
                .collect();
            search.learn(steps, &grew);
        }
    }
    Ok(searches
        .iter()
        .map(|search| search.found().filter(|_| search.is_done()))
        .collect())
}
