//! YADE as a child process: its own home, no display, no socket, a watch on its heartbeat.

use std::fs;
use std::io::{Read, Seek, SeekFrom};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, ExitStatus};
use std::thread;
use std::time::{Duration, Instant};

use serde::Deserialize;

use super::{Installation, OLDEST_VERSION, Options, YadeError};
use crate::child::{Group, LOOK_EVERY};
use crate::engine::Observer;
use crate::files::{failed, read_text};
use crate::interrupt::asked_to_end;
use crate::tables::Stage;

/// The most of a log that is kept, bytes.
const LONGEST_LOG: u64 = 1 << 20;

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
    let mut child = start(installation, script, work, &options.under)?;
    let began = Instant::now();
    let mut heart = Heart::default();
    let mut version = None;
    let status = loop {
        if let Some(status) = child.status().map_err(failed("wait for", work))? {
            break status;
        }
        if version.is_none() {
            version = hello(work)?;
        }
        heart.look(work, observer);
        if asked_to_end() {
            return Err(YadeError::Interrupted);
        }
        let hung = if began.elapsed() > options.time_limit {
            Some(format!("not done within {:?}", options.time_limit))
        } else if heart.still_for() > options.stall_limit {
            Some(format!("no sign of life for {:?}", options.stall_limit))
        } else {
            None
        };
        if let Some(reason) = hung {
            drop(child);
            return Err(YadeError::Hung {
                reason,
                log: end_of(&log(work)),
            });
        }
        thread::sleep(LOOK_EVERY);
    };
    heart.look(work, observer);
    finished(work, status, version)
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

/// The child's signs of life: the heartbeat and the tables grow.
struct Heart {
    read: u64,
    size: u64,
    changed: Instant,
}

impl Default for Heart {
    fn default() -> Self {
        Heart {
            read: 0,
            size: 0,
            changed: Instant::now(),
        }
    }
}

impl Heart {
    fn look(&mut self, work: &Path, observer: &mut dyn Observer) {
        let length = |name: &str| fs::metadata(work.join(name)).map_or(0, |data| data.len());
        let size = length("heartbeat") + length("frames.bin") + length("frames.jsonl");
        if size != self.size {
            self.size = size;
            self.changed = Instant::now();
        }
        if let Some((stage, step, share)) = self.last_beat(work) {
            observer.progress(stage, step, share);
        }
    }

    fn still_for(&self) -> Duration {
        self.changed.elapsed()
    }

    /// The newest whole line since the last look. The heartbeat is for display only, so what
    /// cannot be read is passed over.
    fn last_beat(&mut self, work: &Path) -> Option<(Stage, u64, f64)> {
        let mut file = fs::File::open(work.join("heartbeat")).ok()?;
        file.seek(SeekFrom::Start(self.read)).ok()?;
        let mut new = String::new();
        file.take(1 << 16).read_to_string(&mut new).ok()?;
        let whole = new.rfind('\n')? + 1;
        self.read += whole as u64;
        let mut words = new[..whole].lines().last()?.split(' ');
        let name = words.next()?;
        let stage = [Stage::Settle, Stage::Load]
            .into_iter()
            .find(|stage| stage.name() == name)?;
        Some((
            stage,
            words.next()?.parse().ok()?,
            words.next()?.parse().ok()?,
        ))
    }
}

/// What YADE wrote on its standard output and error; of a very long log the end.
pub fn log(work: &Path) -> String {
    let mut bytes = Vec::new();
    if let Ok(mut file) = fs::File::open(work.join("yade.log")) {
        let length = file.metadata().map_or(0, |data| data.len());
        // What could be read of it is better than nothing.
        let _ = file.seek(SeekFrom::Start(length.saturating_sub(LONGEST_LOG)));
        let _ = file.take(LONGEST_LOG).read_to_end(&mut bytes);
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

fn end_of(log: &str) -> String {
    let lines: Vec<&str> = log.lines().collect();
    let from = lines.len().saturating_sub(12);
    lines[from..].join("\n")
}
