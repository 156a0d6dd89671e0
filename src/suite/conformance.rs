//! What is wrong with an external engine: tiny jobs, each held against the native engine, and what is
//! found said in plain words.

mod diagnosis;
mod jobs;

use serde::Serialize;

use crate::checks::{Check, Outcome};
use crate::document::{Document, Section};
use crate::engine::ProgramError;
use crate::engine::exec::{self, Description, Options, Part};
use crate::files::work_folder;
use crate::run::EngineError;
use grains::native::{self, NativeError};
use grains::tables::Snapshot;
use grains::task::{Observer, Outcome as Ended};

use jobs::Job;

/// All checks of an engine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Conformance {
    /// What the engine says of itself.
    pub engine: Description,
    /// The checks, in order.
    pub checks: Vec<Check>,
    /// A check failed because the engine gave nothing to judge: it crashed, hung or was not understood.
    pub engine_failed: bool,
}

impl Conformance {
    /// Failed if a check failed; checks of what the engine does not have count neither way.
    pub fn verdict(&self) -> Outcome {
        let any = |outcome| self.checks.iter().any(|check| check.outcome == outcome);
        let worst = [Outcome::Fail, Outcome::Pass];
        worst
            .into_iter()
            .find(|of| any(*of))
            .unwrap_or(Outcome::Skipped)
    }

    /// What people are told.
    pub fn document(&self) -> Document {
        let engine = &self.engine;
        let parts: Vec<&str> = engine.parts.iter().map(|part| part.name()).collect();
        let mut says = Section::new("What it says of itself", "");
        says = says.with(format!("{}: {}.", engine.label(), parts.join(", ")));
        for approximation in &engine.approximations {
            says = says.with(approximation.clone());
        }
        let mut right = Section::new("What is right", "");
        for check in &self.checks {
            if check.outcome == Outcome::Pass {
                let found = check.found.trim_end();
                right = right.with(format!("{}: {}: {found}", check.id, check.quantity));
            }
        }
        Document {
            title: format!("Conformance of {}", engine.label()),
            verdict: self.verdict(),
            answer: match self.verdict() {
                Outcome::Fail => {
                    "Not sound: mend the first failure first, the others may come from it."
                }
                Outcome::Skipped => "Nothing was checked.",
                _ => "Sound: what was checked is right; what was skipped is not known.",
            }
            .to_owned(),
            sections: vec![says, right],
            checks: self.checks.clone(),
        }
    }
}

/// Runs the small jobs; `progress` hears the name of each.
pub fn conformance(
    options: &Options,
    progress: &mut dyn FnMut(&str),
) -> Result<Conformance, EngineError> {
    let engine = exec::describe(options)?;
    let mut found = Conformance {
        engine,
        checks: Vec::new(),
        engine_failed: false,
    };
    for job in jobs::all() {
        progress(job.id);
        let said = against_native(&found.engine, options, &job);
        found.add(job.id, job.what, said)?;
    }
    progress("again");
    let said = again(&found.engine, options);
    found.add("again", "the small bed once more", said)?;
    progress("cases");
    let said = cases(&found.engine, options);
    let what = "two lists of grains in one start, each looked at three times";
    found.add("cases", what, said)?;
    Ok(found)
}

/// What a job came to if it is not right.
enum Trouble {
    /// It is wrong.
    Wrong(String),
    /// The engine has no such parts, or refused.
    Skipped(String),
    /// The engine failed.
    Engine(ProgramError),
    /// The native engine failed.
    Native(NativeError),
}

impl From<ProgramError> for Trouble {
    fn from(error: ProgramError) -> Self {
        Trouble::Engine(error)
    }
}

impl From<NativeError> for Trouble {
    fn from(error: NativeError) -> Self {
        Trouble::Native(error)
    }
}

impl Conformance {
    /// Adds a check; what is no fault of the engine's own is handed back.
    fn add(
        &mut self,
        id: &str,
        job: &str,
        said: Result<String, Trouble>,
    ) -> Result<(), EngineError> {
        let (outcome, found) = match said {
            Ok(said) => (Outcome::Pass, said),
            Err(Trouble::Wrong(said)) => (Outcome::Fail, said),
            Err(Trouble::Skipped(why)) => (Outcome::Skipped, why),
            Err(Trouble::Native(error)) => return Err(error.into()),
            Err(Trouble::Engine(
                error @ (ProgramError::NotStarted { .. }
                | ProgramError::Interrupted
                | ProgramError::File(_)),
            )) => return Err(error.into()),
            Err(Trouble::Engine(ProgramError::Refused(reason))) => {
                (Outcome::Skipped, format!("the engine refused: {reason}"))
            }
            Err(Trouble::Engine(error)) => {
                let understood = matches!(
                    error,
                    ProgramError::Nonsense(_) | ProgramError::WentWrong { .. }
                );
                self.engine_failed |= !understood;
                (Outcome::Fail, error.to_string())
            }
        };
        let check = Check::of_words(format!("engine/{id}"), job, outcome, &found);
        self.checks.push(check);
        Ok(())
    }
}

/// All moments of a run.
#[derive(Debug, Default, Clone, PartialEq)]
struct Moments(Vec<Snapshot>);

impl Observer for Moments {
    fn snapshot(&mut self, snapshot: &Snapshot) {
        self.0.push(snapshot.clone());
    }
}

/// A run of a job: its moments and how it ended.
#[derive(Debug, Clone)]
struct Story {
    moments: Vec<Snapshot>,
    outcome: Ended,
}

fn in_native(job: &Job) -> Result<Story, NativeError> {
    let mut moments = Moments::default();
    let sound = native::Options::default();
    let outcome = native::run(&job.scene, &job.task, &sound, &mut moments)?;
    Ok(Story {
        moments: moments.0,
        outcome,
    })
}

fn in_engine(options: &Options, job: &Job) -> Result<Story, ProgramError> {
    let mut moments = Moments::default();
    let work = work_folder()?;
    let run = exec::run(&job.scene, &job.task, options, work.path(), &mut moments)?;
    Ok(Story {
        moments: moments.0,
        outcome: run.outcome,
    })
}

/// Whether the engine says that it has everything that is asked.
fn has_all(missing: &[Part]) -> Result<(), Trouble> {
    if missing.is_empty() {
        return Ok(());
    }
    let missing: Vec<&str> = missing.iter().map(|part| part.in_words()).collect();
    let why = format!("the engine says that it has no {}", missing.join(", "));
    Err(Trouble::Skipped(why))
}

fn against_native(engine: &Description, options: &Options, job: &Job) -> Result<String, Trouble> {
    has_all(&exec::missing_for_scene(engine, &job.scene, &job.task))?;
    let native = in_native(job)?;
    let theirs = in_engine(options, job)?;
    (job.judge)(job, &theirs, &native).map_err(Trouble::Wrong)
}

/// The same job twice must give the same bits.
fn again(engine: &Description, options: &Options) -> Result<String, Trouble> {
    let job = jobs::bed();
    has_all(&exec::missing_for_scene(engine, &job.scene, &job.task))?;
    if in_engine(options, &job)?.moments == in_engine(options, &job)?.moments {
        return Ok("the same bits both times".to_owned());
    }
    let why = "two runs of one job have other bits: threads that add forces in the order in which they come, or a random \
               number without a fixed seed";
    Err(Trouble::Wrong(why.to_owned()))
}

/// A list of two small experiments in one start.
fn cases(engine: &Description, options: &Options) -> Result<String, Trouble> {
    let cases = jobs::cases();
    let missing = cases
        .iter()
        .flat_map(|case| exec::missing_for_case(engine, case));
    let mut missing: Vec<Part> = missing.collect();
    missing.dedup();
    has_all(&missing)?;
    let work = work_folder().map_err(ProgramError::File)?;
    let asked: Vec<_> = cases.iter().collect();
    let results = exec::run_cases(&asked, engine, options, work.path(), &mut ())?;
    for (case, result) in cases.iter().zip(results) {
        let refused = |reason| format!("the engine refused {}: {reason}", case.name);
        let theirs = result.map_err(|reason| Trouble::Skipped(refused(reason)))?;
        let native = native::run_case(case, None)?;
        diagnosis::moments_agree(&theirs, &native, jobs::ROUNDING)
            .map_err(|said| Trouble::Wrong(format!("{}: {said}", case.name)))?;
    }
    Ok("both as they should be".to_owned())
}
