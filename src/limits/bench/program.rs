//! This program and valgrind as processes of their own, in a folder and under a time limit.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use super::BenchError;
use crate::child::{Group, Unfinished};
use crate::files::{failed, read_text};

/// The most of a log or table that is read, bytes.
const LARGEST: u64 = 1 << 28;

/// Runs a program in `work` and returns what it wrote on both outputs.
pub fn run(
    program: &Path,
    arguments: &[&str],
    work: &Path,
    limit: Duration,
) -> Result<String, BenchError> {
    let path = work.join("program.log");
    let output = File::create(&path).map_err(failed("create", &path))?;
    let errors = output.try_clone().map_err(failed("create", &path))?;
    let mut command = Command::new(program);
    command
        .args(arguments)
        .current_dir(work)
        .env("OMP_NUM_THREADS", "1")
        .env_remove("DISPLAY")
        .stdout(output)
        .stderr(errors);
    let name = program.file_name().unwrap_or_default().to_string_lossy();
    let group = Group::spawn(&mut command)
        .map_err(|error| BenchError::Failed(format!("{name} cannot be started: {error}")))?;
    let status = group.wait(limit).map_err(|error| match error {
        Unfinished::Interrupted => BenchError::Interrupted,
        other => BenchError::Failed(format!("{name}: {other}")),
    })?;
    let log = read_text(&path, LARGEST)?;
    if status.success() {
        return Ok(log);
    }
    let lines: Vec<&str> = log.lines().collect();
    let end = lines[lines.len().saturating_sub(8)..].join("\n");
    Err(BenchError::Failed(format!("{name}: {status}; {end}")))
}

/// Where a program of this name may have failed to be found.
pub fn missing(name: &str, package: &str) -> BenchError {
    BenchError::Missing(format!(
        "there is no program `{name}` on the path; on Debian install it with \
         `apt-get install --no-install-recommends {package}`"
    ))
}

/// A folder inside `work` for one run.
pub fn folder(work: &Path, name: &str) -> Result<PathBuf, BenchError> {
    let folder = work.join(name);
    if folder.exists() {
        fs::remove_dir_all(&folder).map_err(failed("remove", &folder))?;
    }
    fs::create_dir(&folder).map_err(failed("create", &folder))?;
    Ok(folder)
}
