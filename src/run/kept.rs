//! A run that is watched and kept: progress shown, the folder written, a failed YADE's log saved.

use std::path::Path;

use super::{Engine, EngineError, recorded};
use crate::engine::ProgramError;
use crate::engine::exec::log;
use crate::files::{FileError, failed, write_beside};
use crate::progress::Display;
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
    let parent = match out.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(parent).map_err(failed("create", parent))?;
    let work = tempfile::Builder::new()
        .prefix(".crossgrain.partial-")
        .tempdir_in(parent)
        .map_err(failed("write into", parent))?;
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
            keep_log(engine, &error, work.path(), out, display);
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

/// An engine that failed leaves its whole log beside where its run folder would have been.
fn keep_log(engine: &Engine, error: &EngineError, work: &Path, out: &Path, display: &Display) {
    let (end, whose) = match engine {
        Engine::Native(_) => return,
        Engine::Yade(_) => (".yade.log", "YADE's"),
        Engine::Exec(_) => (".engine.log", "the engine's"),
    };
    let log = log(work);
    // An engine that was never started has said nothing.
    let ended = matches!(
        error,
        EngineError::Program(ProgramError::Missing { .. } | ProgramError::Interrupted)
    );
    if log.is_empty() || ended {
        return;
    }
    let mut wanted = out.as_os_str().to_owned();
    wanted.push(end);
    if let Ok(kept) = write_beside(Path::new(&wanted), log.as_bytes()) {
        display.line(&format!("{whose} log is kept in {}", kept.display()));
    }
}
