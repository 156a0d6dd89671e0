//! Climbing the ladder: every rung in every engine that is asked for.

use serde::Serialize;

use super::parity::{self, ParityRung};
use super::{Group, Line, Rung, Track, collisions, motion, symmetry};
use crate::compare::Verdict;
use crate::engine::Observer;
use crate::engine::case::Case;
use crate::engine::native::{Perturbation, run_case};
use crate::engine::yade::{self, YadeError, run_cases, unsupported};
use crate::files::work_folder;
use crate::run::EngineError;

/// One rung as it was climbed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Climbed {
    /// The rung's name.
    pub name: String,
    /// What it shows.
    pub title: String,
    /// What kind of evidence it gives.
    pub group: Group,
    /// Which engines it is about.
    pub engine: String,
    /// Passed if every line holds and there is one.
    pub verdict: Verdict,
    /// Why it was not made, or what went wrong; empty otherwise.
    pub reason: String,
    /// Not made because the engine has no such option: nothing is missing.
    pub inapplicable: bool,
    /// Its figures.
    pub lines: Vec<Line>,
}

/// Which engines climb.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Climbers {
    /// Our own.
    Native,
    /// YADE alone.
    Yade,
    /// Both, and one against the other.
    Both,
}

/// All rungs.
pub struct Ladder {
    /// Those that one engine can climb alone.
    pub solo: Vec<Rung>,
    /// Those that take both engines.
    pub parity: Vec<ParityRung>,
}

impl Ladder {
    /// The ladder with trajectories of so many grains at most.
    pub fn new(most_grains: u32) -> Self {
        let mut solo = collisions::rungs();
        solo.extend(motion::rungs());
        solo.extend(symmetry::rungs());
        Ladder {
            solo,
            parity: parity::rungs(most_grains),
        }
    }

    /// Every rung for the native engine.
    pub fn climb_native(&self) -> Vec<Climbed> {
        let climb = |rung: &Rung| solo(rung, "native", native_tracks(&rung.cases, None));
        self.solo.iter().map(climb).collect()
    }

    /// Every rung in YADE, which runs all cases in one process, and the tracks of the parity rungs.
    pub fn climb_yade(
        &self,
        options: &yade::Options,
        observer: &mut dyn Observer,
    ) -> Result<(Vec<Climbed>, Vec<Track>), EngineError> {
        let can = |rung: &&Rung| why_not(rung).is_none();
        let mut cases: Vec<&Case> = self.solo.iter().filter(can).flat_map(|r| &r.cases).collect();
        cases.extend(self.parity.iter().map(|rung| &rung.case));
        let work = work_folder().map_err(YadeError::File)?;
        let mut run = run_cases(&cases, options, work.path(), observer)?
            .into_iter()
            .map(|case| case.track);
        let mut climbed = Vec::new();
        for rung in &self.solo {
            climbed.push(match why_not(rung) {
                Some(reason) => not_made(rung.name, rung.title, rung.group, "YADE", &reason, true),
                None => solo(rung, "YADE", Ok(run.by_ref().take(rung.cases.len()).collect())),
            });
        }
        Ok((climbed, run.collect()))
    }

    /// Native against the tracks that YADE made of the parity rungs.
    pub fn compare(&self, in_yade: &[Track]) -> Vec<Climbed> {
        let rungs = self.parity.iter().zip(in_yade);
        rungs
            .map(|(rung, track)| match run_case(&rung.case, None) {
                Ok(native) => {
                    let lines = parity::judge(rung, &native, track);
                    of_parity(rung, verdict(&lines), String::new(), lines)
                }
                Err(error) => of_parity(rung, Verdict::Fail, error.to_string(), Vec::new()),
            })
            .collect()
    }

    /// All rungs that need YADE, as not made.
    pub fn without_yade(&self, reason: &str) -> Vec<Climbed> {
        let of_solo = |rung: &Rung| not_made(rung.name, rung.title, rung.group, "YADE", reason, false);
        let of_both =
            |rung: &ParityRung| of_parity(rung, Verdict::NotMade, reason.to_owned(), Vec::new());
        let solo = self.solo.iter().map(of_solo);
        solo.chain(self.parity.iter().map(of_both)).collect()
    }
}

/// Why YADE cannot climb a rung, if it cannot.
fn why_not(rung: &Rung) -> Option<String> {
    let reason = rung.cases.iter().find_map(|case| unsupported(&case.model));
    reason.map(|reason| format!("YADE has no {reason}"))
}

/// The tracks of a rung's cases in the native engine, or why there are none.
pub fn native_tracks(cases: &[Case], fault: Option<Perturbation>) -> Result<Vec<Track>, String> {
    cases
        .iter()
        .map(|case| run_case(case, fault).map_err(|error| format!("{}: {error}", case.name)))
        .collect()
}

/// A rung from its tracks.
fn solo(rung: &Rung, engine: &str, tracks: Result<Vec<Track>, String>) -> Climbed {
    let (lines, reason) = match tracks {
        Ok(tracks) => ((rung.judge)(&tracks), String::new()),
        Err(reason) => (Vec::new(), reason),
    };
    Climbed {
        name: rung.name.to_owned(),
        title: rung.title.to_owned(),
        group: rung.group,
        engine: engine.to_owned(),
        verdict: verdict(&lines),
        reason,
        inapplicable: false,
        lines,
    }
}

fn of_parity(rung: &ParityRung, verdict: Verdict, reason: String, lines: Vec<Line>) -> Climbed {
    Climbed {
        name: rung.name.clone(),
        title: rung.title.clone(),
        group: rung.group,
        engine: "native and YADE".to_owned(),
        verdict,
        reason,
        inapplicable: false,
        lines,
    }
}

fn not_made(
    name: &str,
    title: &str,
    group: Group,
    engine: &str,
    reason: &str,
    inapplicable: bool,
) -> Climbed {
    Climbed {
        name: name.to_owned(),
        title: title.to_owned(),
        group,
        engine: engine.to_owned(),
        verdict: Verdict::NotMade,
        reason: reason.to_owned(),
        inapplicable,
        lines: Vec::new(),
    }
}

/// Passed if every line holds and there is one.
pub fn verdict(lines: &[Line]) -> Verdict {
    if !lines.is_empty() && lines.iter().all(Line::holds) {
        Verdict::Pass
    } else {
        Verdict::Fail
    }
}
