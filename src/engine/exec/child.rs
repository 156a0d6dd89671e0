//! The engine as a child process: in the job's folder, without a display, watched.

use std::cell::Cell;
use std::fs::{self, File};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use super::{ExecError, Options};
use crate::child::Group;
use crate::engine::watch::{self, Beats, Done, Ended, end_of, length, watch};
use crate::files::failed;
use grains::task::Observer;

/// What the engine prints goes here, in the job's folder; of `describe` its standard output alone.
pub const SAID: &str = "engine.log";
/// Standard error of `describe`.
const COMPLAINED: &str = "engine-errors.log";

/// What the engine wrote on its standard output and error; of a very long log the end.
pub fn log(work: &Path) -> String {
    watch::log(&work.join(SAID))
}

/// Has the engine do the job in `work`.
pub fn run(options: &Options, work: &Path, observer: &mut dyn Observer) -> Result<Done, ExecError> {
    let work = &fs::canonicalize(work).map_err(failed("find", work))?;
    let said = work.join(SAID);
    let output = File::create(&said).map_err(failed("create", &said))?;
    let errors = output.try_clone().map_err(failed("create", &said))?;
    let mut command = command(options, work)?;
    command.arg("run").arg(work).stdout(output).stderr(errors);
    finish(options, work, &mut command, observer)
}

/// Has the engine describe itself into `work`.
pub fn describe(options: &Options, work: &Path) -> Result<(), ExecError> {
    let create = |name: &str| {
        let path = work.join(name);
        File::create(&path).map_err(failed("create", &path))
    };
    let mut command = command(options, work)?;
    command
        .arg("describe")
        .stdout(create(SAID)?)
        .stderr(create(COMPLAINED)?);
    finish(options, work, &mut command, &mut ())?;
    Ok(())
}

fn command(options: &Options, work: &Path) -> Result<Command, ExecError> {
    // The path as it is: nothing is looked up, and no shell sees it.
    let program = fs::canonicalize(&options.program).map_err(|error| ExecError::Missing {
        path: options.program.clone(),
        reason: error.to_string(),
    })?;
    let mut command = Command::new(program);
    command
        .current_dir(work)
        .env("PYTHONUNBUFFERED", "1")
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("OMP_NUM_THREADS", "1")
        .env_remove("DISPLAY");
    Ok(command)
}

fn finish(
    options: &Options,
    work: &Path,
    command: &mut Command,
    observer: &mut dyn Observer,
) -> Result<Done, ExecError> {
    let child = Group::spawn(command).map_err(|error| ExecError::Missing {
        path: options.program.clone(),
        reason: error.to_string(),
    })?;
    let mut beats = Beats::default();
    let said = work.join(SAID);
    let written = Written::new(work);
    let mut look = || {
        if let Some((stage, step, share)) = beats.newest(&said) {
            observer.progress(stage, step, share);
        }
        Some(length(&said) + written.bytes())
    };
    let done = watch(child, &options.limits, &mut look, &|| written.bytes());
    let log = || end_of(&[log(work), watch::log(&work.join(COMPLAINED))].concat());
    match done {
        Ok(done) if done.status.success() => Ok(done),
        Ok(done) => Err(ExecError::Crashed {
            status: done.status.to_string(),
            log: log(),
        }),
        Err(Ended::Interrupted) => Err(ExecError::Interrupted),
        Err(Ended::Hung(reason)) => Err(ExecError::Hung { reason, log: log() }),
        Err(Ended::TooMuch(reason)) => Err(ExecError::TooMuch { reason }),
        Err(Ended::Io(error)) => Err(failed("wait for", work)(error).into()),
        Err(Ended::RuledOut) => Err(ExecError::Interrupted),
    }
}

/// How much a program has written, counted now and then: of thousands of files each count takes its time.
struct Written<'a> {
    folder: &'a Path,
    /// When it is counted again, and what it was.
    counted: Cell<(Instant, u64)>,
}

impl<'a> Written<'a> {
    fn new(folder: &'a Path) -> Self {
        Written {
            folder,
            counted: Cell::new((Instant::now(), 0)),
        }
    }

    fn bytes(&self) -> u64 {
        let (again, bytes) = self.counted.get();
        let began = Instant::now();
        if began < again {
            return bytes;
        }
        let bytes = size_of_folder(self.folder);
        let pause = (began.elapsed() * 20).max(Duration::from_millis(200));
        self.counted.set((Instant::now() + pause, bytes));
        bytes
    }
}

/// Bytes of all files in a folder and in those inside it. What comes or goes meanwhile counts or does not.
fn size_of_folder(folder: &Path) -> u64 {
    let Ok(entries) = fs::read_dir(folder) else {
        return 0;
    };
    let size = |entry: fs::DirEntry| match entry.metadata() {
        Ok(of) if of.is_dir() => size_of_folder(&entry.path()),
        Ok(of) => of.len(),
        Err(_) => 0,
    };
    entries.flatten().map(size).sum()
}
