//! The largest stable steps in an engine that is a program of its own: many steps of many scenes in one start of it,
//! then a finer round.

use crate::engine::exec::CaseResult;
use grains::case::Case;

use super::growth::{Disturbed, Found};

/// Half-width of the first round about where the limit is looked for, relative: without damping, and with it, where the
/// first unstable steps are a narrow range.
const FIRST: f64 = 0.06;
const FIRST_DAMPED: f64 = 0.012;
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
    /// Why the engine would not do it.
    refused: Option<String>,
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
            refused: None,
        }
    }

    /// The first trial, which has every part of the model that the others have.
    pub fn at_start(&self) -> Case {
        self.disturbed.at(self.low, self.alpha)
    }

    fn found(&self) -> Option<Found> {
        let (stable, unstable) = (self.stable?, self.unstable?);
        Some(Found::between(stable, unstable, self.trials))
    }

    fn is_done(&self) -> bool {
        self.refused.is_some() || self.is_fine()
    }

    fn is_fine(&self) -> bool {
        self.found()
            .is_some_and(|found| found.unstable / found.stable <= 1.0 + RESOLUTION)
    }

    fn result(self) -> Limit {
        let found = self.found().filter(|_| self.is_fine());
        self.refused.map_or(Ok(found), Err)
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

/// A limit, none where it was not found; or why the engine would not look for it.
pub type Limit = Result<Option<Found>, String>;

/// All limits, in the order of the searches. `run` runs cases in one start of the engine and gives what it made of each,
/// in order.
pub fn find_all<E>(
    mut searches: Vec<Search>,
    mut run: impl FnMut(&[&Case]) -> Result<Vec<CaseResult>, E>,
) -> Result<Vec<Limit>, E> {
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
        let cases: Vec<&Case> = cases.iter().collect();
        let mut tracks = run(&cases)?.into_iter();
        for (at, steps) in open.iter().zip(&trials) {
            let search = &mut searches[*at];
            let grew: Result<Vec<bool>, String> = tracks
                .by_ref()
                .take(steps.len())
                .collect::<Vec<_>>()
                .into_iter()
                .map(|track| track.map(|track| search.disturbed.has_grown(&track)))
                .collect();
            match grew {
                Ok(grew) => search.learn(steps, &grew),
                Err(reason) => search.refused = Some(reason),
            }
        }
    }
    Ok(searches.into_iter().map(Search::result).collect())
}
