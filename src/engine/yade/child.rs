//! YADE as a child process: its own home, no display, no socket, a watch on its heartbeat.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, ExitStatus};

use serde::Deserialize;

use super::{Installation, OLDEST_VERSION, Options, YadeError};
use crate::child::Group;
use crate::engine::watch::{Beats, Ended, Limits, end_of, length, watch};
use crate::files::{failed, read_text};
use grains::task::Observer;

/// What a finished child said about itself.
pub struct Finished {
    pub version: String,
    pub log: String,
}

#[derive(Deserialize)]
struct Hello {
    version: String,
}

/// Runs the script on the job in `work` to its end, or ends it.
pub fn run(
    installation: &Installation,
    script: &str,
    work: &Path,
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<Finished, YadeError> {
    let child = start(installation, script, work, &options.under)?;
    let mut beats = Beats::default();
    let mut version = Ok(None);
    let size = |name: &str| length(&work.join(name));
    let limits = Limits {
        time: options.time_limit,
        stall: options.stall_limit,
        memory: options.memory_limit,
        output: options.output_limit,
    };
    let done = watch(
        child,
        &limits,
        &mut || {
            if let Some((stage, step, share)) = beats.newest(&work.join("heartbeat")) {
                observer.progress(stage, step, share);
            }
            if matches!(version, Ok(None)) {
                version = hello(work);
            }
            let done = size("heartbeat") + size("frames.bin") + size("frames.jsonl");
            version.is_ok().then_some(done)
        },
        &|| size("frames.bin") + size("frames.jsonl") + size("yade.log"),
    );
    let version = version?;
    let hung = |reason| YadeError::Hung {
        reason,
        log: end_of(&log(work)),
    };
    match done {
        Ok(done) => finished(work, done.status, version),
        Err(Ended::Interrupted) => Err(YadeError::Interrupted),
        Err(Ended::TooMuch(reason)) => Err(YadeError::TooMuch { reason }),
        Err(Ended::Io(error)) => Err(failed("wait for", work)(error).into()),
        Err(other) => Err(hung(other.to_string())),
    }
}

fn finished(
    work: &Path,
    status: ExitStatus,
    version: Option<String>,
) -> Result<Finished, YadeError> {
    let log = log(work);
    let version = match version {
        Some(version) => Some(version),
        None => hello(work)?,
    };
    if !status.success() {
        return Err(YadeError::Crashed {
            status: status.to_string(),
            log: end_of(&log),
        });
    }
    let Some(version) = version else {
        return Err(YadeError::Nonsense(
            "it ended well without saying its version".to_owned(),
        ));
    };
    if !work.join("done.json").is_file() {
        return Err(YadeError::Nonsense(
            "it ended well before the run was done".to_owned(),
        ));
    }
    Ok(Finished { version, log })
}

fn start(
    installation: &Installation,
    script: &str,
    work: &Path,
    under: &[String],
) -> Result<Group, YadeError> {
    let work = fs::canonicalize(work).map_err(failed("find", work))?;
    // YADE ends with an error of its own where its home is not text.
    if work.to_str().is_none() {
        return Err(YadeError::Unsupported(format!(
            "a way to work in a folder whose name is not UTF-8 text, {}",
            work.display()
        )));
    }
    // Under this name Python imports the program, and the program then opens no socket.
    let link = work.join("yadeimport.py");
    symlink(&installation.program, &link).map_err(failed("create", &link))?;
    let path = work.join("yade.log");
    let output = fs::File::create(&path).map_err(failed("create", &path))?;
    let errors = output.try_clone().map_err(failed("create", &path))?;
    let mut command = match under.split_first() {
        None => Command::new(&installation.interpreter),
        Some((program, arguments)) => {
            let mut command = Command::new(program);
            command.args(arguments).arg(&installation.interpreter);
            command
        }
    };
    command
        .arg(script)
        .current_dir(&work)
        .env("CROSSGRAIN_JOB", &work)
        .env("CROSSGRAIN_PARENT", std::process::id().to_string())
        .env("PYTHONPATH", &work)
        .env("PYTHONUNBUFFERED", "1")
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("HOME", work.join("home"))
        .env("IPYTHONDIR", work.join("home"))
        .env("OMP_NUM_THREADS", "1")
        .env_remove("DISPLAY")
        .stdout(output)
        .stderr(errors);
    Group::spawn(&mut command).map_err(|error| {
        YadeError::Missing(format!(
            "{} cannot be started: {error}",
            installation.interpreter.display()
        ))
    })
}

/// The version, once the script has said it.
fn hello(work: &Path) -> Result<Option<String>, YadeError> {
    let path = work.join("hello.json");
    if !path.is_file() {
        return Ok(None);
    }
    let text = read_text(&path, 1 << 16).map_err(|error| YadeError::Nonsense(error.to_string()))?;
    let hello: Hello = serde_json::from_str(&text)
        .map_err(|error| YadeError::Nonsense(format!("hello.json: {error}")))?;
    let number = |text: &str| -> Option<u32> {
        let digits: String = text.chars().take_while(char::is_ascii_digit).collect();
        digits.parse().ok()
    };
    let mut parts = hello.version.split('.').map(number);
    match (parts.next().flatten(), parts.next().flatten()) {
        (Some(year), month) if (year, month.unwrap_or(0)) >= OLDEST_VERSION => {
            Ok(Some(hello.version))
        }
        (Some(_), _) => Err(YadeError::TooOld {
            found: hello.version,
        }),
        _ => Err(YadeError::Nonsense(format!(
            "its version is {:?}",
            hello.version
        ))),
    }
}

/// What YADE wrote on its standard output and error; of a very long log the end.
pub fn log(work: &Path) -> String {
    crate::engine::watch::log(&work.join("yade.log"))
}
