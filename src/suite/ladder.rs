//! Climbing the ladder: every rung in every engine that is asked for.

use serde::Serialize;

use super::facts::Answer;
use super::parity::{self, InYade, ParityRung};
use super::{
    Group, Line, Rung, Track, collisions, facts, field, frozen, motion, precision, recorded,
    symmetry, trajectories,
};
use crate::compare::Verdict;
use crate::engine::exec::{self, Description, ExecError};
use crate::engine::yade::{self, YadeError, run_cases, unsupported};
use crate::files::work_folder;
use crate::run::EngineError;
use grains::case::{Case, Load};
use grains::native::{CaseOptions, NativeError, loads, run_case};
use grains::task::Observer;

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

impl Climbers {
    /// On the command line.
    pub fn name(self) -> &'static str {
        match self {
            Climbers::Native => "native",
            Climbers::Yade => "yade",
            Climbers::Both => "both",
        }
    }
}

/// What YADE made of the ladder.
#[derive(Debug, Clone)]
pub struct ClimbedInYade {
    /// As YADE prints it.
    pub version: String,
    /// The rungs that YADE climbed alone.
    pub solo: Vec<Climbed>,
    /// The facts of the scenes.
    pub facts: Climbed,
    /// What it says of the scenes' parameters.
    pub answers: Vec<Answer>,
    /// What it made of the parity rungs.
    pub parity: Vec<InYade>,
}

const BOTH: &str = "native and YADE";
const FACTS: &str = "both engines use the same parameters";

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
        solo.extend(field::rungs());
        solo.extend(recorded::rungs());
        let mut parity = frozen::rungs();
        parity.extend(trajectories::rungs(most_grains));
        Ladder { solo, parity }
    }

    /// Every rung for the native engine.
    pub fn climb_native(&self) -> Vec<Climbed> {
        let climb = |rung: &Rung| {
            solo(
                rung,
                "native",
                native_tracks(&rung.cases, &CaseOptions::default()),
            )
        };
        self.solo.iter().map(climb).collect()
    }

    /// Every rung in YADE, which runs all cases in one process; the facts of the scenes; and the tracks
    /// of the parity rungs.
    pub fn climb_yade(
        &self,
        options: &yade::Options,
        observer: &mut dyn Observer,
    ) -> Result<ClimbedInYade, EngineError> {
        let can = |rung: &&Rung| why_not(rung).is_none();
        let scenes = facts::scenes().map(|(name, scene)| (name, facts::probe(&scene)));
        let mut cases: Vec<&Case> = scenes.iter().map(|(_, probe)| probe).collect();
        let solo_cases = self.solo.iter().filter(can).flat_map(|rung| &rung.cases);
        cases.extend(solo_cases);
        cases.extend(self.parity.iter().map(|rung| &rung.case));
        let work = work_folder().map_err(YadeError::File)?;
        let run = run_cases(&cases, options, work.path(), observer)?;
        let mut in_yade = run.cases.into_iter();
        let answers: Vec<Answer> = scenes
            .iter()
            .zip(in_yade.by_ref())
            .map(|((name, probe), of)| Answer {
                name,
                probe: probe.clone(),
                yade: of.effective,
            })
            .collect();
        let lines = facts::lines(&answers, None)?;
        let mut rest = in_yade;
        let mut climbed = Vec::new();
        for rung in &self.solo {
            climbed.push(match why_not(rung) {
                Some(reason) => not_made(rung.name, rung.title, rung.group, "YADE", &reason, true),
                None => {
                    let own = rest.by_ref().take(rung.cases.len());
                    solo(rung, "YADE", Ok(own.map(|case| case.track).collect()))
                }
            });
        }
        Ok(ClimbedInYade {
            version: run.version,
            solo: climbed,
            facts: Climbed {
                name: "facts".to_owned(),
                title: FACTS.to_owned(),
                group: Group::Parity,
                engine: BOTH.to_owned(),
                verdict: verdict(&lines),
                reason: String::new(),
                inapplicable: false,
                lines,
            },
            answers,
            parity: rest
                .map(|case| InYade {
                    track: case.track,
                    loads: case.loads,
                })
                .collect(),
        })
    }

    /// Every rung in an engine that was brought, each in a start of its own: what breaks one leaves the others.
    pub fn climb_exec(
        &self,
        engine: &Description,
        options: &exec::Options,
        progress: &dyn Fn(usize, usize),
    ) -> Result<Vec<Climbed>, ExecError> {
        let name = engine.name.as_str();
        let of_bits: Vec<&str> = recorded::rungs().iter().map(|rung| rung.name).collect();
        let mut climbed = Vec::with_capacity(self.solo.len());
        for (index, rung) in self.solo.iter().enumerate() {
            progress(index, self.solo.len());
            let lacks =
                |reason: String| not_made(rung.name, rung.title, rung.group, name, &reason, true);
            if of_bits.contains(&rung.name) {
                climbed.push(lacks(
                    "nobody has promised YADE's bits for an engine that is brought".to_owned(),
                ));
                continue;
            }
            let cases: Vec<&Case> = rung.cases.iter().collect();
            let missing = cases
                .iter()
                .flat_map(|case| exec::missing_for_case(engine, case))
                .next();
            if let Some(part) = missing {
                climbed.push(lacks(format!("{name} has no {}", part.in_words())));
                continue;
            }
            let work = work_folder()?;
            let results = exec::run_cases(&cases, engine, options, work.path(), &mut ());
            climbed.push(match results {
                Ok(results) => match results.into_iter().collect::<Result<Vec<Track>, String>>() {
                    Ok(tracks) => solo(rung, name, Ok(tracks)),
                    Err(reason) => lacks(format!("{name} refused: {reason}")),
                },
                Err(
                    error @ (ExecError::Missing { .. }
                    | ExecError::Interrupted
                    | ExecError::File(_)),
                ) => return Err(error),
                Err(error) => solo(rung, name, Err(error.to_string())),
            });
        }
        Ok(climbed)
    }

    /// Native against what YADE made of the parity rungs.
    pub fn compare(&self, in_yade: &[InYade]) -> Vec<Climbed> {
        let climb =
            |(rung, yade): (&ParityRung, &InYade)| match both(&rung.case, !yade.loads.is_empty()) {
                Ok((track, loads)) => {
                    let lines = parity::judge(rung, &track, &loads, yade);
                    of_parity(rung, verdict(&lines), String::new(), lines)
                }
                Err(error) => of_parity(rung, Verdict::Fail, error.to_string(), Vec::new()),
            };
        self.parity.iter().zip(in_yade).map(climb).collect()
    }

    /// All rungs that need YADE, as not made.
    pub fn without_yade(&self, reason: &str) -> Vec<Climbed> {
        let of_solo =
            |rung: &Rung| not_made(rung.name, rung.title, rung.group, "YADE", reason, false);
        let of_both =
            |rung: &ParityRung| of_parity(rung, Verdict::NotMade, reason.to_owned(), Vec::new());
        let facts = not_made("facts", FACTS, Group::Parity, BOTH, reason, false);
        let solo = self.solo.iter().map(of_solo);
        solo.chain([facts])
            .chain(self.parity.iter().map(of_both))
            .collect()
    }
}

/// The native engine's track of a case, and its loads if they are asked for.
fn both(case: &Case, with_loads: bool) -> Result<(Track, Vec<Vec<Load>>), NativeError> {
    let loads = if with_loads {
        loads(case, None)?
    } else {
        Vec::new()
    };
    Ok((run_case(case, None)?, loads))
}

/// Why YADE cannot climb a rung, if it cannot.
fn why_not(rung: &Rung) -> Option<String> {
    let reason = rung.cases.iter().find_map(|case| unsupported(&case.model));
    reason.map(|reason| format!("YADE has no {reason}"))
}

/// The tracks of a rung's cases in the native engine, or why there are none.
pub fn native_tracks(cases: &[Case], options: &CaseOptions) -> Result<Vec<Track>, String> {
    cases
        .iter()
        .map(|case| run_case(case, *options).map_err(|error| format!("{}: {error}", case.name)))
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
        engine: BOTH.to_owned(),
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

/// Why rounding errors were not measured.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Unmeasured {
    /// There is no YADE of that precision.
    Missing(String),
    /// There is one, and it failed.
    Failed(String),
}

/// The rounding errors as a rung.
pub fn of_precision(errors: Result<&[precision::Errors], &Unmeasured>) -> Climbed {
    let (found, reason, lines) = match errors {
        Ok(errors) => {
            let lines = precision::lines(errors);
            (verdict(&lines), String::new(), lines)
        }
        Err(Unmeasured::Missing(reason)) => (Verdict::NotMade, reason.clone(), Vec::new()),
        Err(Unmeasured::Failed(reason)) => (Verdict::Fail, reason.clone(), Vec::new()),
    };
    Climbed {
        name: "precision".to_owned(),
        title: "rounding errors of both engines against 128-bit arithmetic".to_owned(),
        group: Group::Precision,
        engine: BOTH.to_owned(),
        verdict: found,
        reason,
        inapplicable: false,
        lines,
    }
}
