//! What changed over time: which check or speed became another in records that were kept, and the repository that has the
//! order of their commits.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde::Serialize;
use thiserror::Error;

use super::Baseline;
use super::diff::{Changed, Pace, diff, pair};
use crate::checks::{Check, Outcome, Speed};
use crate::files::{FileError, Place, TempDir, failed, link, read_text, work_folder, write_whole};

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
            let moved = |change: &Changed| !change.is_as_good() || change.has_other_bits();
            let found = found.changes.into_iter().filter(moved);
            changes.extend(found.map(|change| (index + 1, change)));
        }
        let paces = of_speeds(records);
        let mut steps: Vec<Step> = paces.iter().flat_map(|speeds| levels(speeds)).collect();
        steps.sort_by(|a, b| a.at.cmp(&b.at).then(a.id.cmp(&b.id)));
        let of_speeds = paces
            .iter()
            .map(|speeds| speed(speeds, &steps, records.len()));
        let series = of_speeds.chain(of_checks(records, &changes)).collect();
        History {
            names: records.iter().map(|record| record.name.clone()).collect(),
            changes,
            steps,
            series,
        }
    }

    /// Whether a speed became slower in the last two records; the one before the last is confirmed by it.
    pub fn slower(&self) -> Check {
        let recent = |step: &&Step| step.at + 2 >= self.names.len() && step.pace == Pace::Slower;
        let slower: Vec<&Step> = self.steps.iter().filter(recent).collect();
        let lines = slower
            .iter()
            .map(|step| format!("{}: {:.3} times the cost", step.what, step.cost));
        let found = lines.collect::<Vec<_>>().join("; ");
        let outcome = Outcome::pass_if(slower.is_empty());
        let what = "speeds that became slower in the last two records";
        Check::of_words("history/slower", what, outcome, &found)
            .with_limits(slower.len() as f64, 0.0, Some(0.0))
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
    for (index, record) in records.iter().enumerate() {
        if record.record.machine_kind == newest.record.machine_kind {
            for speed in &record.record.speeds {
                all.entry(&speed.id).or_default().push((index, speed));
            }
        }
    }
    all.into_values().collect()
}

/// One speed against another, of one kind of machine: the pace and the cost.
fn held(from: &Speed, to: &Speed) -> (Pace, f64) {
    let pair = pair(Some(from), Some(to), true);
    pair.map_or((Pace::NotJudged, 1.0), |pair| {
        (pair.pace, pair.cost.unwrap_or(1.0))
    })
}

/// Where a speed leaves its level: each record is held against the first of the level, so that a slow drift is seen too, and a
/// single record that the next one does not confirm is none.
fn levels(speeds: &[(usize, &Speed)]) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut level = 0;
    for (index, (at, speed)) in speeds.iter().enumerate().skip(1) {
        let (pace, cost) = held(speeds[level].1, speed);
        if !matches!(pace, Pace::Slower | Pace::Faster) {
            continue;
        }
        let next = speeds.get(index + 1);
        let next = next.map(|(_, next)| held(speeds[level].1, next).0 == pace);
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

fn speed(speeds: &[(usize, &Speed)], steps: &[Step], records: usize) -> Series {
    let speed = speeds[0].1;
    let mut values = vec![None; records];
    for (at, speed) in speeds {
        values[*at] = Some(Value {
            value: speed.value,
            between: speed.range.map_or([None; 2], |range| range.map(Some)),
        });
    }
    let changed = steps.iter().filter(|step| step.id == speed.id);
    Series {
        name: speed.what.clone(),
        unit: speed.unit.clone(),
        is_speed: true,
        values,
        changed: changed.map(|step| step.at).collect(),
    }
}

/// Those that changed, those whose outcome changed first.
fn of_checks(records: &[Baseline], changes: &[(usize, Changed)]) -> Vec<Series> {
    let mut found: BTreeMap<(bool, &str), Vec<usize>> = BTreeMap::new();
    let is_moved = |id: &str| {
        let mut changes = changes.iter().filter(|(_, change)| change.id == id);
        changes.all(|(_, change)| change.is_as_good())
    };
    for (at, change) in changes {
        found
            .entry((is_moved(&change.id), &change.id))
            .or_default()
            .push(*at);
    }
    let series = found.into_iter().map(|((_, id), changed)| {
        let check = |record: &Baseline| {
            record
                .record
                .checks
                .iter()
                .find(|check| check.id == id)
                .cloned()
        };
        let checks: Vec<_> = records.iter().map(check).collect();
        let unit = checks
            .iter()
            .flatten()
            .last()
            .map(|check| check.unit.clone());
        let value = checks.iter().map(|entry| {
            let check = entry.as_ref()?;
            check.value.map(|value| Value {
                value,
                between: [check.lower, check.upper],
            })
        });
        Series {
            name: id.to_owned(),
            unit: unit.expect("a check that changed is in a record"),
            is_speed: false,
            values: value.collect(),
            changed,
        }
    });
    series.collect()
}

/// A repository that cannot be read.
#[derive(Debug, Error)]
pub enum RepositoryError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error("git {words}: {said}")]
    Git { words: String, said: String },
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
    pub fn open(folder: &Path) -> Result<Self, RepositoryError> {
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
            let path = common.join(name);
            if Place::from(&path).is_taken() {
                link(&path, &around.path().join(name))?;
            }
        }
        Ok(Repository { around })
    }

    /// What git says to this.
    ///
    /// # Errors
    /// Git's own.
    pub fn git(&self, words: &[&str]) -> Result<String, RepositoryError> {
        let complaint = |said: &str| RepositoryError::Git {
            words: words.join(" "),
            said: said.trim().to_owned(),
        };
        let mut git = Command::new("git");
        git.arg("-C").arg(self.around.path()).args(words);
        // The user's own settings are not meant for it either.
        for (name, _) in std::env::vars_os() {
            if name.to_string_lossy().starts_with("GIT_") && name != "GIT_EXEC_PATH" {
                git.env_remove(name);
            }
        }
        // It asks nobody and fetches nothing.
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
        if !done.status.success() {
            return Err(complaint(&String::from_utf8_lossy(&done.stderr)));
        }
        Ok(String::from_utf8_lossy(&done.stdout).trim().to_owned())
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

#[cfg(test)]
mod tests {
    use super::*;
    use evidence::random::Source;

    const RECORDS: usize = 40;

    /// Five rounds a record, each of 4 % scatter; from the middle on `cost` times as much.
    fn rounds(seed: u64, cost: f64) -> Vec<Speed> {
        let mut random = Source::new(&[7; 32], seed);
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

    fn steps(seed: u64, cost: f64) -> Vec<Step> {
        let speeds = rounds(seed, cost);
        levels(&speeds.iter().enumerate().collect::<Vec<_>>())
    }

    #[test]
    fn a_step_of_a_fifth_is_found_and_scatter_is_not_one() {
        let is_it = |step: &Step| step.at == RECORDS / 2 && step.pace == Pace::Slower;
        let found = (0..200).filter(|seed| steps(*seed, 1.2).iter().any(is_it));
        let found = found.count();
        let alarms: usize = (0..200).map(|seed| steps(seed, 1.0).len()).sum();
        assert!(found >= 180, "{found} of 200");
        // In 39 records each.
        assert!(alarms <= 20, "{alarms} in 200 histories");
    }

    #[test]
    fn a_slow_drift_is_one_step_after_the_other() {
        let mut speeds = rounds(1, 1.0);
        for (at, speed) in speeds.iter_mut().enumerate() {
            speed.value = 1.02f64.powi(at as i32);
            speed.range = Some([0.99, 1.01].map(|share| share * speed.value));
        }
        let steps = levels(&speeds.iter().enumerate().collect::<Vec<_>>());
        assert!(steps.len() >= 8, "{steps:?}");
        assert!(steps.iter().all(|step| step.pace == Pace::Slower));
    }
}
