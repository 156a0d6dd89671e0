//! What changed over time: which check or speed became another in records that were kept, and the commit that moved one, by
//! git's bisection over a command that writes a record.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde::Serialize;
use thiserror::Error;

use super::Baseline;
use super::diff::{Changed, Pace, diff, pair};
use crate::checks::record::{Record, read};
use crate::checks::{Check, Outcome, Speed};
use crate::child::Group;
use crate::files::{FileError, Place, TempDir, failed, link, read_text, work_folder, write_whole};
use crate::workers::asked_to_end;

/// Records of one job in the order of time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct History {
    /// The names of the records.
    pub names: Vec<String>,
    /// Checks that are not as in the record before, by the index of the record; within it the worst first.
    pub changes: Vec<(usize, Changed)>,
    /// Speeds that changed, in the order of the records.
    pub steps: Vec<Step>,
    /// Every speed, and every check that changed.
    pub series: Vec<Series>,
}

/// A speed beyond the scatter of the record where its level began.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Step {
    /// Index of the record.
    pub at: usize,
    pub id: String,
    pub what: String,
    pub pace: Pace,
    /// Cost over that of the level before.
    pub cost: f64,
    /// The next record has it too; the newest record's steps cannot be confirmed yet.
    pub confirmed: bool,
}

/// A quantity through all records.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Series {
    pub name: String,
    pub unit: String,
    pub is_speed: bool,
    /// A value a record, if it was made there.
    pub values: Vec<Option<Value>>,
    /// Indices of the records where it changed.
    pub changed: Vec<usize>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Value {
    pub value: f64,
    /// A check's limits, or from the least to the largest of a speed's rounds.
    pub between: [Option<f64>; 2],
}

impl History {
    /// Of records of the same job. Speeds are those of the newest record's kind of machine.
    pub fn of(records: &[Baseline]) -> Self {
        let mut changes = Vec::new();
        for (index, pair) in records.windows(2).enumerate() {
            let found = diff(&pair[0], &pair[1].record);
            let moved = |of: &Changed| !of.is_as_good() || of.has_other_bits();
            let found = found.changes.into_iter().filter(moved);
            changes.extend(found.map(|of| (index + 1, of)));
        }
        let paces = of_speeds(records);
        let mut steps: Vec<Step> = paces.iter().flat_map(|of| levels(of)).collect();
        steps.sort_by(|a, b| a.at.cmp(&b.at).then(a.id.cmp(&b.id)));
        let of_speeds = paces.iter().map(|of| speed(of, &steps, records.len()));
        let series = of_speeds.chain(of_checks(records, &changes)).collect();
        History {
            names: records.iter().map(|of| of.name.clone()).collect(),
            changes,
            steps,
            series,
        }
    }

    /// Whether a speed became slower in the last two records; the one before the last is confirmed by it.
    pub fn slower(&self) -> Check {
        let recent = |of: &&Step| of.at + 2 >= self.names.len() && of.pace == Pace::Slower;
        let of: Vec<&Step> = self.steps.iter().filter(recent).collect();
        let lines = of
            .iter()
            .map(|of| format!("{}: {:.3} times the cost", of.what, of.cost));
        let found = lines.collect::<Vec<_>>().join("; ");
        let outcome = Outcome::pass_if(of.is_empty());
        let what = "speeds that became slower in the last two records";
        Check::of_words("history/slower", what, outcome, &found)
            .with_limits(of.len() as f64, 0.0, Some(0.0))
            .judged_by(
                "each record is held against the first of its level, beyond the scatter of rounds",
                "docs/checks.md",
            )
    }
}

/// Each speed with the indices of its records.
fn of_speeds(records: &[Baseline]) -> Vec<Vec<(usize, &Speed)>> {
    let Some(newest) = records.last() else {
        return Vec::new();
    };
    let mut all: BTreeMap<&str, Vec<(usize, &Speed)>> = BTreeMap::new();
    for (index, of) in records.iter().enumerate() {
        if of.record.machine_kind == newest.record.machine_kind {
            for speed in &of.record.speeds {
                all.entry(&speed.id).or_default().push((index, speed));
            }
        }
    }
    all.into_values().collect()
}

/// One speed against another, of one kind of machine: the pace and the cost.
fn held(from: &Speed, to: &Speed) -> (Pace, f64) {
    let pair = pair(Some(from), Some(to), true);
    pair.map_or((Pace::NotJudged, 1.0), |of| {
        (of.pace, of.cost.unwrap_or(1.0))
    })
}

/// Where a speed leaves its level: each record is held against the first of the level, so that a slow drift is seen too, and a
/// single record that the next one does not confirm is none.
fn levels(of: &[(usize, &Speed)]) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut level = 0;
    for (index, (at, speed)) in of.iter().enumerate().skip(1) {
        let (pace, cost) = held(of[level].1, speed);
        if !matches!(pace, Pace::Slower | Pace::Faster) {
            continue;
        }
        let next = of.get(index + 1);
        let next = next.map(|(_, next)| held(of[level].1, next).0 == pace);
        if next != Some(false) {
            level = index;
            steps.push(Step {
                at: *at,
                id: speed.id.clone(),
                what: speed.what.clone(),
                pace,
                cost,
                confirmed: next.is_some(),
            });
        }
    }
    steps
}

fn speed(of: &[(usize, &Speed)], steps: &[Step], records: usize) -> Series {
    let speed = of[0].1;
    let mut values = vec![None; records];
    for (at, of) in of {
        values[*at] = Some(Value {
            value: of.value,
            between: of.range.map_or([None; 2], |range| range.map(Some)),
        });
    }
    let changed = steps.iter().filter(|of| of.id == speed.id);
    Series {
        name: speed.what.clone(),
        unit: speed.unit.clone(),
        is_speed: true,
        values,
        changed: changed.map(|of| of.at).collect(),
    }
}

/// Those that changed, those whose outcome changed first.
fn of_checks(records: &[Baseline], changes: &[(usize, Changed)]) -> Vec<Series> {
    let mut found: BTreeMap<(bool, &str), Vec<usize>> = BTreeMap::new();
    let is_moved = |id: &str| {
        let mut of = changes.iter().filter(|(_, of)| of.id == id);
        of.all(|(_, of)| of.is_as_good())
    };
    for (at, of) in changes {
        found
            .entry((is_moved(&of.id), &of.id))
            .or_default()
            .push(*at);
    }
    let of = found.into_iter().map(|((_, id), changed)| {
        let check = |of: &Baseline| of.record.checks.iter().find(|of| of.id == id).cloned();
        let checks: Vec<_> = records.iter().map(check).collect();
        let unit = checks.iter().flatten().last().map(|of| of.unit.clone());
        let value = checks.iter().map(|of| {
            let of = of.as_ref()?;
            of.value.map(|value| Value {
                value,
                between: [of.lower, of.upper],
            })
        });
        Series {
            name: id.to_owned(),
            unit: unit.unwrap_or_default(),
            is_speed: false,
            values: value.collect(),
            changed,
        }
    });
    of.collect()
}

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
    Speed(Speed),
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
                let pace = held(before, now).0;
                (pace != Pace::NotJudged).then_some(pace == Pace::Same)
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
    let repository = Repository::open(of.repository)?;
    let commit = |name: &str| {
        let name = format!("{name}^{{commit}}");
        repository.git(&["rev-parse", "--verify", &name])
    };
    let [good, bad] = &[commit(good)?, commit(bad)?];
    let checkout = Checkout::new(&repository, bad)?;
    let git_there = |words: &[&str]| git(&checkout.folder, words);
    let mut tried = Vec::new();
    let at_end = |commit: &str, which| {
        git_there(&["checkout", "--quiet", "--detach", commit])?;
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
    let mut said = git_there(&["bisect", "start", bad, good])?;
    let commits = loop {
        if let Some(commits) = end(&said) {
            break commits;
        }
        let commit = git_there(&["rev-parse", "HEAD"])?;
        let (as_before, found) = match of.state(&checkout.folder)? {
            Ok(state) => (state.is_as(&before, Some(&after)), state.words()),
            Err(reason) => (None, reason),
        };
        let here = Tried {
            subject: git_there(&["log", "-1", "--format=%s"])?,
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
        git_there(&["reset", "--quiet", "--hard"])?;
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
        let (program, arguments) = self.command.split_first().unzip();
        let mut command = Command::new(program.map_or("", String::as_str));
        command
            .args(arguments.unwrap_or_default())
            .current_dir(checkout);
        // The result alone goes to the output.
        command.stdout(std::io::stderr());
        let not_started = |error: std::io::Error| match git(checkout, &["rev-parse", "HEAD"]) {
            Ok(commit) => BisectError::NotStarted {
                command: self.command.join(" "),
                commit,
                reason: error.to_string(),
            },
            Err(of_git) => of_git,
        };
        let mut child = Group::spawn(&mut command).map_err(not_started)?;
        let status = loop {
            if asked_to_end() {
                return Err(BisectError::Interrupted);
            }
            match child.status().map_err(not_started)? {
                Some(status) => break status,
                None => std::thread::sleep(std::time::Duration::from_millis(20)),
            }
        };
        let of = match read(&checkout.join(self.record)) {
            Ok(record) => State::of(&record, self.id),
            Err(FileError::Unfit(why)) => {
                let here = format!("{}/", checkout.display());
                return Ok(Err(why.replace(&here, "")));
            }
            Err(_) => return Ok(Err(format!("no record; the command ended with {status}"))),
        };
        Ok(of.ok_or_else(|| format!("there is no check {} in its record; `crossgrain report checks RECORD --all` names the checks", self.id)))
    }
}

/// A repository of others, seen through a git folder of one's own: its commits and names are its own, and nothing of its
/// configuration, hooks and filters is there, none of which may start a program. Nothing is written into it.
#[derive(Debug)]
pub struct Repository {
    around: TempDir,
}

/// The longest file with a name of a commit or a folder, bytes.
const LONGEST_NAME: u64 = 1 << 16;

impl Repository {
    /// The one that this folder is in.
    ///
    /// # Errors
    /// There is none, or it cannot be read.
    pub fn open(folder: &Path) -> Result<Self, BisectError> {
        let start = std::path::absolute(folder).map_err(failed("find", folder))?;
        let own = start.ancestors().find_map(git_folder);
        let own = own.ok_or_else(|| {
            let what = "is in no git repository; name the folder of one";
            FileError::Unfit(format!("{} {what}", folder.display()))
        })?;
        // The folder of a further working tree has its own HEAD alone.
        let common = match read_text(&own.join("commondir"), LONGEST_NAME) {
            Ok(path) => own.join(path.trim_end()),
            Err(_) => own.clone(),
        };
        let around = work_folder()?;
        let write = |name: &str, text: &str| write_whole((around.path(), name), text.as_bytes());
        write("HEAD", &read_text(&own.join("HEAD"), LONGEST_NAME)?)?;
        write(
            "config",
            "[core]\n\trepositoryformatversion = 0\n\tbare = true\n",
        )?;
        for name in ["objects", "refs", "packed-refs", "shallow"] {
            let of = common.join(name);
            if Place::from(&of).is_taken() {
                link(&of, &around.path().join(name))?;
            }
        }
        Ok(Repository { around })
    }

    /// What git says to this.
    ///
    /// # Errors
    /// Git's own.
    pub fn git(&self, words: &[&str]) -> Result<String, BisectError> {
        git(self.around.path(), words)
    }
}

/// The git folder of this very folder, if it has or is one.
fn git_folder(folder: &Path) -> Option<PathBuf> {
    let inside = folder.join(".git");
    if Place::from(&inside).is_folder() {
        return Some(inside);
    }
    if let Ok(text) = read_text(&inside, LONGEST_NAME) {
        return Some(folder.join(text.strip_prefix("gitdir: ")?.trim_end()));
    }
    let has = |name: &str| Place::from((folder, name)).is_taken();
    (has("HEAD") && has("objects") && has("refs")).then(|| folder.to_owned())
}

/// A working tree of its own, so that the user's stays as it is.
struct Checkout {
    folder: PathBuf,
    _around: TempDir,
}

impl Checkout {
    fn new(repository: &Repository, commit: &str) -> Result<Self, BisectError> {
        let around = work_folder()?;
        let folder = around.path().join("checkout");
        let path = folder.to_string_lossy();
        repository.git(&["worktree", "add", "--quiet", "--detach", &path, commit])?;
        Ok(Checkout {
            folder,
            _around: around,
        })
    }
}

fn git(folder: &Path, words: &[&str]) -> Result<String, BisectError> {
    git_ended(folder, words, &[0])
}

fn git_ended(folder: &Path, words: &[&str], fine: &[i32]) -> Result<String, BisectError> {
    let complaint = |said: &str| BisectError::Git {
        words: words.join(" "),
        said: said.trim().to_owned(),
    };
    let mut git = Command::new("git");
    git.arg("-C").arg(folder).args(words);
    // The user's own settings are not meant for it either.
    for (name, _) in std::env::vars_os() {
        if name.to_string_lossy().starts_with("GIT_") && name != "GIT_EXEC_PATH" {
            git.env_remove(name);
        }
    }
    // Its words are read, and it asks nobody and fetches nothing.
    git.envs([
        ("LC_ALL", "C"),
        ("GIT_CONFIG_NOSYSTEM", "1"),
        ("GIT_CONFIG_GLOBAL", "/dev/null"),
        ("GIT_ATTR_NOSYSTEM", "1"),
        ("GIT_NO_LAZY_FETCH", "1"),
        ("GIT_TERMINAL_PROMPT", "0"),
    ]);
    git.stdin(Stdio::null());
    let done = git
        .output()
        .map_err(|error| complaint(&error.to_string()))?;
    let said = String::from_utf8_lossy(&done.stdout).trim().to_owned();
    match done.status.code() {
        Some(code) if fine.contains(&code) => Ok(said),
        _ => Err(complaint(&String::from_utf8_lossy(&done.stderr))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use evidence::random::Source;

    const RECORDS: usize = 40;

    /// Five rounds a record, each of 4 % scatter; from the middle on `cost` times as much.
    fn rounds(of: u64, cost: f64) -> Vec<Speed> {
        let mut random = Source::new(&[7; 32], of);
        let records = (0..RECORDS).map(|at| {
            let cost = if at < RECORDS / 2 { 1.0 } else { cost };
            let mut rounds = [0.0; 5].map(|_: f64| cost * (0.04 * random.normal()).exp());
            rounds.sort_by(f64::total_cmp);
            Speed {
                id: "time/yade".to_owned(),
                what: "YADE over native".to_owned(),
                unit: "times native".to_owned(),
                value: rounds[2],
                range: Some([rounds[0], rounds[4]]),
                less_is_better: true,
            }
        });
        records.collect()
    }

    fn steps(of: u64, cost: f64) -> Vec<Step> {
        let speeds = rounds(of, cost);
        levels(&speeds.iter().enumerate().collect::<Vec<_>>())
    }

    #[test]
    fn a_step_of_a_fifth_is_found_and_scatter_is_not_one() {
        let is_it = |of: &Step| of.at == RECORDS / 2 && of.pace == Pace::Slower;
        let found = (0..200).filter(|of| steps(*of, 1.2).iter().any(is_it));
        let found = found.count();
        let alarms: usize = (0..200).map(|of| steps(of, 1.0).len()).sum();
        assert!(found >= 180, "{found} of 200");
        // In 39 records each.
        assert!(alarms <= 20, "{alarms} in 200 histories");
    }

    #[test]
    fn a_slow_drift_is_one_step_after_the_other() {
        let mut speeds = rounds(1, 1.0);
        for (at, of) in speeds.iter_mut().enumerate() {
            of.value = 1.02f64.powi(at as i32);
            of.range = Some([0.99, 1.01].map(|share| share * of.value));
        }
        let steps = levels(&speeds.iter().enumerate().collect::<Vec<_>>());
        assert!(steps.len() >= 8, "{steps:?}");
        assert!(steps.iter().all(|of| of.pace == Pace::Slower));
    }
}
