//! A run that is watched and kept: progress shown, the folder written, what a failed engine left saved.

use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::{Engine, EngineError, recorded};
use crate::engine::ProgramError;
use crate::engine::exec::log;
use crate::files::{FileError, folder_aside, keep_folder, write_beside};
use crate::progress::{Display, say};
use crate::run::folder::record::{Protocol, Softened, StepChoice};
use crate::run::folder::{FolderError, RunFolder};
use grains::generate::initial_bodies;
use grains::scene::Scene;
use grains::tables::Bodies;

/// The run was not made, or not kept.
#[derive(Debug, thiserror::Error)]
pub enum KeptError {
    #[error(transparent)]
    Engine(#[from] EngineError),
    #[error(transparent)]
    Folder(#[from] FolderError),
    #[error(transparent)]
    File(#[from] FileError),
}

/// Runs the scene and writes its folder. When YADE fails, its log is kept beside.
pub fn to_folder(
    scene: &Scene,
    engine: &Engine,
    protocol: Protocol,
    out: &Path,
    display: &Display,
) -> Result<RunFolder, KeptError> {
    prepared(
        scene,
        Preparation::default(),
        engine,
        protocol,
        out,
        display,
    )
}

/// What was done before a run, for its record.
#[derive(Debug, Default)]
pub struct Preparation {
    /// The evidence for the scene's time step, where the program chose it.
    pub step_choice: Option<StepChoice>,
    /// Grains that were poured softly, with what that took; else the scene's cloud is the start.
    pub softened: Option<(Softened, Bodies)>,
}

/// The same after a preparation.
pub fn prepared(
    scene: &Scene,
    preparation: Preparation,
    engine: &Engine,
    protocol: Protocol,
    out: &Path,
    display: &Display,
) -> Result<RunFolder, KeptError> {
    let name = match engine {
        Engine::Native(_) => "native".to_owned(),
        Engine::Yade(options) if options.sorted => "YADE sorted".to_owned(),
        Engine::Yade(options) => format!("YADE ordinary {:?}", options.verlet_distance),
        Engine::Exec(options) => {
            let name = options.program.file_name().unwrap_or_default();
            format!("exec {}", name.to_string_lossy())
        }
    };
    let task = display.task(&name);
    let work = folder_aside(out)?;
    let (softened, initial) = match preparation.softened {
        Some((softened, bodies)) => (Some(softened), bodies),
        None => (None, initial_bodies(scene)),
    };
    let run = recorded(
        scene,
        engine,
        protocol,
        initial,
        work.path(),
        &mut |stage, step, share| task.run(stage, step, share),
    );
    let mut run = match run {
        Ok(run) => run,
        Err(error) => {
            task.done("failed");
            keep_evidence(engine, &error, work, out);
            return Err(error.into());
        }
    };
    run.record.step_choice = preparation.step_choice;
    if softened.is_some() {
        run.record.command = run.record.command.replace(" --out ", " --soft-pour --out ");
    }
    run.record.softened = softened;
    run.write(out)?;
    task.done(&run.stages_in_words());
    Ok(run)
}

/// An engine that failed leaves its whole log beside where its run folder would have been; one whose files cannot be used
/// leaves them all, since the message names one of them. Said even where no progress is shown.
fn keep_evidence(engine: &Engine, error: &EngineError, work: TempDir, out: &Path) {
    let (end, whose) = match engine {
        Engine::Native(_) => return,
        Engine::Yade(_) => (".yade.log", "YADE's"),
        Engine::Exec(_) => (".engine.log", "the engine's"),
    };
    // An engine that was never started has said nothing.
    let EngineError::Program(error) = error else {
        return;
    };
    if matches!(
        error,
        ProgramError::Missing { .. } | ProgramError::Interrupted
    ) {
        return;
    }
    let beside = |end: &str| {
        let mut name = out.as_os_str().to_owned();
        name.push(end);
        PathBuf::from(name)
    };
    let log = log(work.path());
    if !log.is_empty()
        && let Ok(kept) = write_beside(&beside(end), log.as_bytes())
    {
        say(&format!("{whose} log is kept in {}", kept.display()));
    }
    if matches!(error, ProgramError::Nonsense(_))
        && let Ok(kept) = keep_folder(work, &beside(".job"))
    {
        say(&format!("what it wrote is kept in {}", kept.display()));
    }
}
