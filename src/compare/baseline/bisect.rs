//! The commit that moved a check or a speed: git's bisection over a command that writes a record.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde::Serialize;
use thiserror::Error;

use super::diff::{Pace, speeds};
use crate::checks::record::{Record, RecordError, read};
use crate::checks::{Check, Outcome};
use crate::child::Group;
use crate::files::{FileError, failed, work_folder};
use crate::interrupt::asked_to_end;

#[derive(Debug, Error)]
pub enum BisectError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error("git {words}: {said}")]
    Git { words: String, said: String },
    #[error("{command} could not be started at {commit}: {reason}")]
    NotStarted {
        command: String,
        commit: String,
        reason: String,
    },
    #[error("at {commit}, which is to be {which}: {reason}")]
    End {
        commit: String,
        which: &'static str,
        reason: String,
    },
    #[error("{id} is at {bad} as it is at {good}; give two commits between which it changed")]
    Same {
        id: String,
        good: String,
        bad: String,
    },
    #[error("asked to end")]
    Interrupted,
}

/// What is run at each commit, and what is looked at.
#[derive(Debug)]
pub struct Bisection<'a> {
    pub repository: &'a Path,
    /// The program and its arguments, run in a checkout of the commit.
    pub command: &'a [String],
    /// The record that it writes, from the top of the checkout.
    pub record: &'a Path,
    /// A check or a speed.
    pub id: &'a str,
}

/// A commit that was looked at.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Tried {
    pub commit: String,
    pub subject: String,
    /// None where it cannot be told.
    pub as_before: Option<bool>,
    pub found: String,
}

/// Commits, the first of which or one of which changed it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bisected {
    pub id: String,
    /// More than one where those between them cannot be told.
    pub commits: Vec<String>,
    pub tried: Vec<Tried>,
}

/// What a record has of an id.
#[derive(Debug, Clone)]
enum State {
    Check(Check),
    Speed(crate::checks::Speed),
}

impl State {
    fn of(record: &Record, id: &str) -> Option<Self> {
        let check = record.checks.iter().find(|of| of.id == id);
        let check = check.filter(|of| of.outcome != Outcome::Skipped);
        let speed = record.speeds.iter().find(|of| of.id == id);
        let speed = || speed.cloned().map(State::Speed);
        check.cloned().map(State::Check).or_else(speed)
    }

    fn words(&self) -> String {
        match self {
            State::Check(check) => format!("{}: {}", check.outcome.word(), check.in_a_line()),
            State::Speed(speed) => format!("{} {}", speed.value, speed.unit),
        }
    }

    /// Whether it is as it was; by the outcome where that is what changed to `after`, else by every bit, and speeds beyond
    /// their scatter.
    fn is_as(&self, before: &State, after: Option<&State>) -> Option<bool> {
        match (before, self) {
            (State::Check(before), State::Check(now)) => {
                let by_outcome = match after {
                    Some(State::Check(after)) => after.outcome != before.outcome,
                    _ => false,
                };
                let bits = |of: &Check| (of.outcome, of.value.map(f64::to_bits));
                Some(match by_outcome {
                    true => now.outcome == before.outcome,
                    false => bits(now) == bits(before),
                })
            }
            (State::Speed(before), State::Speed(now)) => {
                let pair = speeds(
                    std::slice::from_ref(before),
                    std::slice::from_ref(now),
                    true,
                )
                .pop()?;
                (pair.pace != Pace::NotJudged).then_some(pair.pace == Pace::Same)
            }
            _ => None,
        }
    }
}

/// Finds the commit between a good one and a bad one.
///
/// # Errors
/// Git's own, a command that cannot be started, and ends of the history that do not differ.
pub fn bisect(
    of: &Bisection,
    [good, bad]: [&str; 2],
    mut told: impl FnMut(&Tried),
) -> Result<Bisected, BisectError> {
    let commit = |name: &str| {
        let name = format!("{name}^{{commit}}");
        git(of.repository, &["rev-parse", "--verify", &name])
    };
    let [good, bad] = &[commit(good)?, commit(bad)?];
    let checkout = Checkout::new(of.repository, bad)?;
    let mut tried = Vec::new();
    let at_end = |commit: &str, which| {
        git(
            &checkout.folder,
            &["checkout", "--quiet", "--detach", commit],
        )?;
        let state = of.state(&checkout.folder)?;
        state.map_err(|reason| BisectError::End {
            commit: commit.to_owned(),
            which,
            reason,
        })
    };
    let before = at_end(good, "good")?;
    let after = at_end(bad, "bad")?;
    if after.is_as(&before, Some(&after)) != Some(false) {
        return Err(BisectError::Same {
            id: of.id.to_owned(),
            good: good.clone(),
            bad: bad.clone(),
        });
    }
    let mut said = git(&checkout.folder, &["bisect", "start", bad, good])?;
    let commits = loop {
        if let Some(commits) = end(&said) {
            break commits;
        }
        let commit = git(&checkout.folder, &["rev-parse", "HEAD"])?;
        let (as_before, found) = match of.state(&checkout.folder)? {
            Ok(state) => (state.is_as(&before, Some(&after)), state.words()),
            Err(reason) => (None, reason),
        };
        let here = Tried {
            subject: git(&checkout.folder, &["log", "-1", "--format=%s"])?,
            commit,
            as_before,
            found,
        };
        told(&here);
        tried.push(here);
        let word = match as_before {
            Some(true) => "good",
            Some(false) => "bad",
            None => "skip",
        };
        git(&checkout.folder, &["reset", "--quiet", "--hard"])?;
        // Git's skip ends with 2 where nothing else is left.
        said = git_ended(&checkout.folder, &["bisect", word], &[0, 2])?;
    };
    Ok(Bisected {
        id: of.id.to_owned(),
        commits,
        tried,
    })
}

/// The commits that git's words name at the end.
fn end(said: &str) -> Option<Vec<String>> {
    let first = said
        .lines()
        .find(|line| line.ends_with(" is the first bad commit"));
    if let Some(line) = first {
        return Some(line.split(' ').take(1).map(str::to_owned).collect());
    }
    let mut lines = said.lines();
    lines.find(|line| line.starts_with("There are only 'skip'ped commits left"))?;
    let is_commit = |line: &&str| line.len() >= 40 && line.bytes().all(|of| of.is_ascii_hexdigit());
    Some(lines.filter(is_commit).map(str::to_owned).collect())
}

impl Bisection<'_> {
    /// What the record of a fresh checkout has, or why it has nothing.
    fn state(&self, checkout: &Path) -> Result<Result<State, String>, BisectError> {
        // A record of another commit must not be read, nor a job of another commit be taken up.
        git(checkout, &["clean", "-ffdxq"])?;
        let commit = || git(checkout, &["rev-parse", "HEAD"]);
        let (program, arguments) = self.command.split_first().unzip();
        let mut command = Command::new(program.map_or("", String::as_str));
        command
            .args(arguments.unwrap_or_default())
            .current_dir(checkout);
        // The result alone goes to the output.
        command.stdout(std::io::stderr());
        let not_started = |error: std::io::Error, commit| BisectError::NotStarted {
            command: self.command.join(" "),
            commit,
            reason: error.to_string(),
        };
        let mut child = match Group::spawn(&mut command) {
            Ok(child) => child,
            Err(error) => return Err(not_started(error, commit()?)),
        };
        let status = loop {
            if asked_to_end() {
                return Err(BisectError::Interrupted);
            }
            match child.status() {
                Ok(Some(status)) => break status,
                Ok(None) => std::thread::sleep(std::time::Duration::from_millis(20)),
                Err(error) => return Err(not_started(error, commit()?)),
            }
        };
        let of = match read(&checkout.join(self.record)) {
            Ok(record) => State::of(&record, self.id),
            Err(RecordError::File(_)) => {
                return Ok(Err(format!("no record; the command ended with {status}")));
            }
            Err(error) => {
                let here = format!("{}/", checkout.display());
                return Ok(Err(error.to_string().replace(&here, "")));
            }
        };
        Ok(of.ok_or_else(|| format!("{} was not made", self.id)))
    }
}

/// A working tree of its own, so that the user's stays as it is.
struct Checkout {
    repository: PathBuf,
    folder: PathBuf,
    _around: tempfile::TempDir,
}

impl Checkout {
    fn new(repository: &Path, commit: &str) -> Result<Self, BisectError> {
        let around = work_folder()?;
        let folder = around.path().join("checkout");
        let repository = std::path::absolute(repository).map_err(failed("find", repository))?;
        let path = folder.to_string_lossy();
        let words = ["worktree", "add", "--quiet", "--detach", &path, commit];
        git(&repository, &words)?;
        Ok(Checkout {
            repository,
            folder,
            _around: around,
        })
    }
}

impl Drop for Checkout {
    fn drop(&mut self) {
        let path = self.folder.to_string_lossy();
        let _ = git(&self.repository, &["worktree", "remove", "--force", &path]);
    }
}

/// What git says to this, without the spaces around it.
pub fn git(folder: &Path, words: &[&str]) -> Result<String, BisectError> {
    git_ended(folder, words, &[0])
}

fn git_ended(folder: &Path, words: &[&str], fine: &[i32]) -> Result<String, BisectError> {
    let complaint = |said: &str| BisectError::Git {
        words: words.join(" "),
        said: said.trim().to_owned(),
    };
    let mut git = Command::new("git");
    // Its words are read.
    git.arg("-C").arg(folder).args(words).env("LC_ALL", "C");
    for name in ["GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE"] {
        git.env_remove(name);
    }
    let done = git
        .output()
        .map_err(|error| complaint(&error.to_string()))?;
    let said = String::from_utf8_lossy(&done.stdout).trim().to_owned();
    match done.status.code() {
        Some(code) if fine.contains(&code) => Ok(said),
        _ => Err(complaint(&String::from_utf8_lossy(&done.stderr))),
    }
}
