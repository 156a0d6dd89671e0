//! The limits of all scenes in engines that are programs of their own.

use super::draft::Draft;
use super::rounds::{Search, find_all};
use crate::engine::exec::{Brought, missing_for_case, run_cases};
use crate::engine::yade::{self, YadeError, propose};
use crate::error::Error;
use crate::files::work_folder;
use crate::progress::{Display, StageObserver};
use crate::run::EngineError;
use grains::case::Case;

/// What YADE makes of all scenes, and its version; the inner error says why there is no YADE.
pub fn look_in_yade(
    drafts: &mut [Draft],
    options: &yade::Options,
    display: &Display,
) -> Result<Result<String, String>, Error> {
    let failed = |error: YadeError| Error::Engine(EngineError::Yade(error));
    let task = display.task("limits in YADE");
    let cases: Vec<&Case> = drafts.iter().map(|draft| &draft.case).collect();
    let work = work_folder()?;
    let (proposals, version) = match propose(&cases, options, work.path()) {
        Ok(answer) => answer,
        Err(error @ (YadeError::Missing(_) | YadeError::TooOld { .. })) => {
            task.done("YADE is missing or too old");
            return Ok(Err(error.to_string()));
        }
        Err(error) => return Err(failed(error)),
    };
    let searches: Vec<Search> = drafts.iter().flat_map(Draft::searches).collect();
    let mut observer = StageObserver::new(&task);
    let found = find_all(searches, |cases| -> Result<_, YadeError> {
        let work = work_folder()?;
        let run = yade::run_cases(cases, options, work.path(), &mut observer)?;
        Ok(run.cases.into_iter().map(|case| Ok(case.track)).collect())
    })
    .map_err(failed)?;
    for ((draft, proposal), found) in drafts.iter_mut().zip(proposals).zip(found.chunks(2)) {
        draft.row.proposal_of_yade = Some(proposal);
        if let [Ok(undamped), Ok(damped)] = found {
            draft.row.undamped.yade = *undamped;
            draft.row.damped.yade = *damped;
        }
    }
    task.done("done");
    Ok(Ok(version))
}

/// What an engine that was brought makes of the scenes that it has the parts for; the rows of all others say why not.
pub fn look_in_exec(
    drafts: &mut [Draft],
    engine: &Brought,
    display: &Display,
) -> Result<(), Error> {
    let Brought {
        options,
        description,
    } = engine;
    let name = &description.name;
    let task = display.task(&format!("limits in {name}"));
    let mut observer = StageObserver::new(&task);
    for draft in &mut *drafts {
        // The damped one asks for all that the other does.
        let [_, damped] = draft.searches();
        let missing = missing_for_case(description, &damped.at_start());
        if !missing.is_empty() {
            let words: Vec<&str> = missing.iter().map(|part| part.in_words()).collect();
            draft.row.not_made = Some(format!("{name} has no {}", words.join(", ")));
        }
    }
    let asked: Vec<&mut Draft> = drafts
        .iter_mut()
        .filter(|draft| draft.row.not_made.is_none())
        .collect();
    let searches: Vec<Search> = asked.iter().flat_map(|draft| draft.searches()).collect();
    let found = find_all(searches, |cases| {
        let work = work_folder()?;
        run_cases(cases, description, options, work.path(), &mut observer)
    })
    .map_err(EngineError::from)?;
    for (draft, found) in asked.into_iter().zip(found.chunks(2)) {
        let refused = found.iter().find_map(|found| found.as_ref().err());
        draft.row.not_made = refused.map(|reason| format!("{name} refused: {reason}"));
        if let [Ok(undamped), Ok(damped)] = found {
            draft.row.undamped.exec = *undamped;
            draft.row.damped.exec = *damped;
        }
    }
    task.done("done");
    Ok(())
}
