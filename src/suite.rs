//! The ladder: small cases with known answers, each run by any engine and judged by the same code.

pub mod brought;
pub mod build;
pub mod checks;
pub mod collisions;
pub mod facts;
pub mod field;
pub mod frozen;
pub mod ladder;
pub mod limits;
pub mod motion;
pub mod parity;
pub mod precision;
pub mod record;
pub mod recorded;
pub mod symmetry;
pub mod trajectories;

use serde::Serialize;

use grains::case::Case;
use grains::tables::Snapshot;

/// The states of a case at its moments.
pub type Track = Vec<Snapshot>;

/// One figure of a rung: it holds if |value − expected| ≤ tolerance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Line {
    /// What was measured.
    pub quantity: String,
    /// SI unit, `1` for a ratio.
    pub unit: String,
    /// As measured.
    pub value: f64,
    /// What it should be.
    pub expected: f64,
    /// The most that the two may be apart, in the same unit.
    pub tolerance: f64,
    /// Where the tolerance comes from.
    pub basis: String,
}

/// A line of these.
pub fn line(
    quantity: impl Into<String>,
    unit: &str,
    value: f64,
    expected: f64,
    tolerance: f64,
    basis: impl Into<String>,
) -> Line {
    Line {
        quantity: quantity.into(),
        unit: unit.to_owned(),
        value,
        expected,
        tolerance,
        basis: basis.into(),
    }
}

impl Line {
    /// Whether it holds; a value that is not a number does not.
    pub fn holds(&self) -> bool {
        (self.value - self.expected).abs() <= self.tolerance
    }
}

/// What kind of evidence a rung gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    /// A solution in closed form.
    Exact,
    /// The same experiment seen in another way.
    Symmetry,
    /// Native against YADE.
    Parity,
    /// Against higher precision.
    Precision,
    /// That the ladder itself can fail.
    Proof,
}

/// How the tracks of a rung's cases are judged.
pub type Judge = Box<dyn Fn(&[Track]) -> Vec<Line> + Send + Sync>;

/// A rung that one engine can climb alone: cases, and what their tracks must show.
pub struct Rung {
    /// A short name of its own, in kebab-case.
    pub name: &'static str,
    /// What it shows, in one line.
    pub title: &'static str,
    /// What kind of evidence it gives.
    pub group: Group,
    /// What is run.
    pub cases: Vec<Case>,
    /// Judges the tracks, in the order of the cases; never knows which engine made them.
    pub judge: Judge,
}

/// Climbing rungs in tests.
#[cfg(test)]
mod climbing {
    use super::{Line, Rung, Track};
    use grains::native::{Perturbation, run_case};

    /// A rung's lines with a fault; none if a case did not run.
    pub fn climb(rung: &Rung, fault: Option<Perturbation>) -> Vec<Line> {
        let run = |case| run_case(case, fault).ok();
        let tracks: Option<Vec<Track>> = rung.cases.iter().map(run).collect();
        tracks.map_or(Vec::new(), |tracks| (rung.judge)(&tracks))
    }

    /// Whether there are lines, and all hold.
    pub fn holds(lines: &[Line]) -> bool {
        !lines.is_empty() && lines.iter().all(Line::holds)
    }

    /// Every rung holds as it is.
    pub fn all_hold(rungs: &[Rung]) {
        for rung in rungs {
            let lines = climb(rung, None);
            assert!(!lines.is_empty(), "{}", rung.name);
            for line in lines {
                assert!(line.holds(), "{}: {line:?}", rung.name);
            }
        }
    }

    /// Every rung stands in the list, and fails with each of its faults.
    pub fn all_notice(rungs: &[Rung], faults: &[(&str, &str)]) {
        for rung in rungs {
            let listed = faults.iter().any(|(name, _)| *name == rung.name);
            assert!(listed, "{}", rung.name);
        }
        for (name, fault) in faults {
            let rung = rungs.iter().find(|rung| rung.name == *name);
            let fault = fault.parse().expect("a fault");
            let lines = climb(rung.expect("a rung"), Some(fault));
            assert!(!holds(&lines), "{name} passes with {fault}");
        }
    }

    /// A rung that is shown empty tracks, or too few, does not hold.
    pub fn none_holds_of_nothing(rungs: &[Rung]) {
        for rung in rungs {
            let tracks = vec![Track::new(); rung.cases.len()];
            assert!(!holds(&(rung.judge)(&tracks)), "{}", rung.name);
            assert!(!holds(&(rung.judge)(&tracks[1..])), "{}", rung.name);
        }
    }
}
