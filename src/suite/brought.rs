//! What is wrong with an engine that somebody brings: tiny jobs, each held against the native engine, and what is
//! found said in plain words.

mod trials;
mod words;

use serde::Serialize;

use crate::compare::Verdict;
use crate::engine::exec::{self, Description, ExecError, Options, Part};
use crate::files::work_folder;
use crate::run::EngineError;
use grains::native::{self, NativeError};
use grains::tables::Snapshot;
use grains::task::{Observer, Outcome};

use trials::Trial;

/// One check of an engine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Found {
    /// A short name.
    pub name: String,
    /// What the job was, in one line.
    pub job: String,
    /// What that amounts to.
    pub verdict: Verdict,
    /// What was found, in words and figures.
    pub found: String,
    /// The engine did not give anything to judge: it crashed, hung or was not understood.
    pub engine_failed: bool,
}

/// All checks of an engine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Examination {
    /// What the engine says of itself.
    pub engine: Description,
    /// The checks, in order.
    pub checks: Vec<Found>,
}

impl Examination {
    /// Failed if a check failed; checks of what the engine does not have count neither way.
    pub fn verdict(&self) -> Verdict {
        let any = |verdict| self.checks.iter().any(|check| check.verdict == verdict);
        if any(Verdict::Fail) {
            Verdict::Fail
        } else if any(Verdict::Pass) {
            Verdict::Pass
        } else {
            Verdict::NotMade
        }
    }

    /// Whether a check failed because the engine gave nothing to judge.
    pub fn engine_failed(&self) -> bool {
        self.checks.iter().any(|check| check.engine_failed)
    }
}

/// Runs the small jobs; `progress` hears the name of each.
pub fn examine(
    options: &Options,
    progress: &mut dyn FnMut(&str),
) -> Result<Examination, EngineError> {
    let engine = exec::describe(options)?;
    let mut checks = Vec::new();
    for trial in trials::all() {
        progress(trial.name);
        checks.push(try_one(&engine, options, &trial)?);
    }
    progress("again");
    checks.push(again(&engine, options)?);
    progress("cases");
    checks.push(cases(&engine, options)?);
    Ok(Examination { engine, checks })
}

/// All moments of a run.
#[derive(Debug, Default, Clone, PartialEq)]
struct Moments(Vec<Snapshot>);

impl Observer for Moments {
    fn snapshot(&mut self, snapshot: &Snapshot) {
        self.0.push(snapshot.clone());
    }
}

/// A run of a trial: its moments and how it ended.
#[derive(Debug, Clone)]
struct Story {
    moments: Vec<Snapshot>,
    outcome: Outcome,
}

fn in_native(trial: &Trial) -> Result<Story, NativeError> {
    let mut moments = Moments::default();
    let sound = native::Options::default();
    let outcome = native::run(&trial.scene, &trial.task, &sound, &mut moments)?;
    Ok(Story {
        moments: moments.0,
        outcome,
    })
}

fn in_engine(options: &Options, trial: &Trial) -> Result<Story, ExecError> {
    let mut moments = Moments::default();
    let work = work_folder()?;
    let run = exec::run(
        &trial.scene,
        &trial.task,
        options,
        work.path(),
        &mut moments,
    )?;
    Ok(Story {
        moments: moments.0,
        outcome: run.outcome,
    })
}

/// A check of which nothing else is known yet.
fn found(name: &str, job: &str, verdict: Verdict, found: impl Into<String>) -> Found {
    Found {
        name: name.to_owned(),
        job: job.to_owned(),
        verdict,
        found: found.into(),
        engine_failed: false,
    }
}

fn lacks(name: &str, job: &str, missing: &[Part]) -> Found {
    let missing: Vec<&str> = missing.iter().map(|part| part.in_words()).collect();
    let why = format!("the engine says that it has no {}", missing.join(", "));
    found(name, job, Verdict::NotMade, why)
}

/// An engine's error as a check that failed; what is no fault of its own is handed back.
fn failure(name: &str, job: &str, error: ExecError) -> Result<Found, EngineError> {
    match error {
        error @ (ExecError::Missing { .. } | ExecError::Interrupted | ExecError::File(_)) => {
            Err(error.into())
        }
        ExecError::Refused(reason) => {
            let why = format!("the engine refused: {reason}");
            Ok(found(name, job, Verdict::NotMade, why))
        }
        error @ (ExecError::Nonsense(_) | ExecError::WentWrong { .. }) => {
            Ok(found(name, job, Verdict::Fail, error.to_string()))
        }
        error => Ok(Found {
            engine_failed: true,
            ..found(name, job, Verdict::Fail, error.to_string())
        }),
    }
}

fn try_one(engine: &Description, options: &Options, trial: &Trial) -> Result<Found, EngineError> {
    let missing = exec::missing_for_scene(engine, &trial.scene, &trial.task);
    if !missing.is_empty() {
        return Ok(lacks(trial.name, trial.job, &missing));
    }
    let native = in_native(trial)?;
    let theirs = match in_engine(options, trial) {
        Ok(theirs) => theirs,
        Err(error) => return failure(trial.name, trial.job, error),
    };
    Ok(match (trial.judge)(trial, &theirs, &native) {
        Ok(said) => found(trial.name, trial.job, Verdict::Pass, said),
        Err(said) => found(trial.name, trial.job, Verdict::Fail, said),
    })
}

/// The same job twice must give the same bits.
fn again(engine: &Description, options: &Options) -> Result<Found, EngineError> {
    let (name, job) = ("again", "the small bed once more");
    let trial = trials::bed();
    let missing = exec::missing_for_scene(engine, &trial.scene, &trial.task);
    if !missing.is_empty() {
        return Ok(lacks(name, job, &missing));
    }
    let run = || in_engine(options, &trial).map(|story| story.moments);
    Ok(match (run(), run()) {
        (Ok(one), Ok(other)) if one == other => {
            found(name, job, Verdict::Pass, "the same bits both times")
        }
        (Ok(_), Ok(_)) => found(
            name,
            job,
            Verdict::Fail,
            "two runs of one job have other bits: threads that add forces in the order in which they come, or a random \
             number without a fixed seed",
        ),
        (Err(error), _) | (_, Err(error)) => return failure(name, job, error),
    })
}

/// A list of two small experiments in one start.
fn cases(engine: &Description, options: &Options) -> Result<Found, EngineError> {
    let (name, job) = (
        "cases",
        "two lists of grains in one start, each looked at three times",
    );
    let cases = trials::cases();
    let mut missing: Vec<Part> = cases
        .iter()
        .flat_map(|case| exec::missing_for_case(engine, case))
        .collect();
    missing.dedup();
    if !missing.is_empty() {
        return Ok(lacks(name, job, &missing));
    }
    let work = work_folder().map_err(ExecError::File)?;
    let asked: Vec<_> = cases.iter().collect();
    let results = match exec::run_cases(&asked, engine, options, work.path(), &mut ()) {
        Ok(results) => results,
        Err(error) => return failure(name, job, error),
    };
    for (case, result) in cases.iter().zip(results) {
        let theirs = match result {
            Ok(theirs) => theirs,
            Err(reason) => {
                let why = format!("the engine refused {}: {reason}", case.name);
                return Ok(found(name, job, Verdict::NotMade, why));
            }
        };
        let native = native::run_case(case, None)?;
        if let Err(said) = words::moments_agree(&theirs, &native, trials::ROUNDING) {
            let said = format!("{}: {said}", case.name);
            return Ok(found(name, job, Verdict::Fail, said));
        }
    }
    Ok(found(name, job, Verdict::Pass, "both as they should be"))
}
