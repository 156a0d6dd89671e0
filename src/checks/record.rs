//! The part of a job's record that all jobs have in common, and reading it back from any of them, of any version.

use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{Check, Measured, Outcome, Speed, Tally};
use crate::files::{FileError, read_text};

/// Longest record that is read, bytes.
const LONGEST: u64 = 1 << 25;

/// Longest id that is made from the names in an old record, bytes.
const LONGEST_ID: usize = 2000;

/// What every job's record has; its other keys are the job's own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Record {
    /// `reproduce`, `verify`, `bench`, …
    pub job: String,
    /// Version of that job's format.
    pub version: u32,
    /// Version of crossgrain.
    pub crossgrain: String,
    /// How to do it again.
    pub command: String,
    /// Processor and vector unit; ratios of times travel between machines of one kind only.
    #[serde(default)]
    pub machine_kind: Option<String>,
    /// SHA-256 of the scene's canonical JSON, where there is one scene.
    #[serde(default)]
    pub scene_digest: Option<String>,
    /// The version of the YADE that ran live.
    #[serde(default)]
    pub yade: Option<String>,
    /// What the checks together come to.
    pub verdict: Outcome,
    /// Every check.
    pub checks: Vec<Check>,
    /// What was measured and is judged by nothing here.
    #[serde(default)]
    pub measured: Vec<Measured>,
    /// What may be compared between machines.
    #[serde(default)]
    pub speeds: Vec<Speed>,
}

/// A file is no record.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error(
        "{path} is no record of a job: {reason}; give run.json, verify.json, bench.json or stability.json of a finished job"
    )]
    Malformed { path: String, reason: String },
    #[error(
        "{path} is of version {found} of {job}'s format, and this program knows {known}; use a newer crossgrain"
    )]
    TooNew {
        path: String,
        job: String,
        found: u32,
        known: u32,
    },
}

/// The newest version of each job's format that this program knows, and the first that has checks.
const KNOWN: [(&str, u32, u32); 4] = [
    ("reproduce", 3, 3),
    ("verify", 2, 2),
    ("bench", 2, 2),
    ("stability", 2, 2),
];

/// Reads what is common from a job's record. Records from before the checks were one list have their verdicts gathered from where
/// they stood then.
pub fn read(path: &Path) -> Result<Record, RecordError> {
    parse(&path.display().to_string(), &read_text(path, LONGEST)?)
}

/// Reads a record from text; `path` is for messages.
pub fn parse(path: &str, text: &str) -> Result<Record, RecordError> {
    let malformed = |reason: String| RecordError::Malformed {
        path: path.to_owned(),
        reason,
    };
    let value: Value = serde_json::from_str(text).map_err(|error| malformed(error.to_string()))?;
    let version = value["version"]
        .as_u64()
        .and_then(|version| u32::try_from(version).ok())
        .ok_or_else(|| malformed("it has no version".to_owned()))?;
    let job = job(&value).ok_or_else(|| malformed("it does not say of which job".to_owned()))?;
    let known = KNOWN.iter().find(|(name, ..)| *name == job);
    let Some(&(_, newest, first)) = known else {
        return Err(malformed(format!("{job} keeps no checks")));
    };
    if version > newest {
        return Err(RecordError::TooNew {
            path: path.to_owned(),
            job,
            found: version,
            known: newest,
        });
    }
    if version < first {
        return older(job, version, &value).map_err(malformed);
    }
    serde_json::from_value(value).map_err(|error| malformed(error.to_string()))
}

/// Old records do not name their job, but each has a key of its own.
fn job(value: &Value) -> Option<String> {
    if let Some(job) = value["job"].as_str() {
        return Some(job.to_owned());
    }
    let own = [
        ("comparisons", "reproduce"),
        ("rungs", "verify"),
        ("contests", "bench"),
        ("failures", "stability"),
    ];
    let found = own.iter().find(|(key, _)| value.get(key).is_some());
    found.map(|(_, job)| (*job).to_owned())
}

fn older(job: String, version: u32, value: &Value) -> Result<Record, String> {
    let text = |key: &str| value[key].as_str().map(str::to_owned);
    let mut checks = Vec::new();
    gather(value, &job, &mut checks)?;
    super::number_repeated(&mut checks);
    Ok(Record {
        job,
        version,
        crossgrain: text("crossgrain").unwrap_or_default(),
        command: text("command").unwrap_or_default(),
        machine_kind: None,
        scene_digest: text("scene_digest"),
        yade: text("yade"),
        verdict: outcome(&value["verdict"]).unwrap_or(Outcome::NotMade),
        checks,
        measured: Vec::new(),
        speeds: Vec::new(),
    })
}

/// Everything below this value that has a verdict and a name.
fn gather(value: &Value, id: &str, checks: &mut Vec<Check>) -> Result<(), String> {
    const NAMES: [&str; 7] = ["key", "name", "fault", "title", "what", "table", "rung"];
    // Every check has all names above it in its id.
    if id.len() > LONGEST_ID {
        return Err(format!(
            "the names in it come to an id of more than {LONGEST_ID} bytes"
        ));
    }
    match value {
        Value::Array(values) => {
            for value in values {
                let name = NAMES.iter().find_map(|name| value[*name].as_str());
                let id = match name {
                    Some(name) => format!("{id}/{}", super::slug(name)),
                    None => id.to_owned(),
                };
                if let (Some(name), Some(outcome)) = (name, outcome(&value["verdict"])) {
                    let found = value["found"].as_str().or(value["reason"].as_str());
                    checks.push(Check::of_words(
                        id.clone(),
                        name,
                        outcome,
                        found.unwrap_or_default(),
                    ));
                }
                gather(value, &id, checks)?;
            }
        }
        Value::Object(keys) => {
            for (key, value) in keys {
                if value.is_array() || value.is_object() {
                    gather(value, &format!("{id}/{}", super::slug(key)), checks)?;
                }
            }
        }
        _ => {}
    }
    Ok(())
}

fn outcome(value: &Value) -> Option<Outcome> {
    serde_json::from_value(value.clone()).ok()
}

/// A job's own record with what all jobs have; the own one has `version`, `crossgrain`, `command` and `verdict`.
#[derive(Debug, Clone, Serialize)]
pub struct Whole<'a, T: Serialize> {
    job: &'static str,
    #[serde(flatten)]
    own: &'a T,
    machine_kind: String,
    #[serde(flatten)]
    found: Found,
}

/// What a job found, in the shape of all jobs.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Found {
    pub checks: Vec<Check>,
    pub measured: Vec<Measured>,
    pub speeds: Vec<Speed>,
}

impl<'a, T: Serialize> Whole<'a, T> {
    /// Of this job, one of those that [`read`] knows.
    pub fn of(job: &'static str, own: &'a T, machine_kind: String, found: Found) -> Self {
        Whole {
            job,
            own,
            machine_kind,
            found,
        }
    }
}

impl Record {
    /// How many checks came to what.
    pub fn tally(&self) -> Tally {
        Tally::of(&self.checks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEW: &str = r#"{"job": "verify", "version": 2, "crossgrain": "0.1.0", "command": "crossgrain verify",
        "verdict": "pass", "own": 1, "checks": [{"id": "a/b", "quantity": "q", "unit": "m", "value": 1.0, "expected": 1.0,
        "lower": 0.5, "upper": 1.5, "method": "", "basis": "", "n": 1, "interval": null, "outcome": "pass", "found": ""}]}"#;

    #[test]
    fn the_common_part_is_read_and_the_rest_left() {
        let record = parse("r", NEW).expect("a record");
        assert_eq!(record.tally().passed, 1);
        assert_eq!(record.scene_digest, None);
    }

    #[test]
    fn records_from_before_the_list_are_read() {
        let old = r#"{"version": 2, "crossgrain": "0.1.0", "command": "crossgrain reproduce", "verdict": "fail", "comparisons": [{
            "title": "native against YADE", "comparison": {"checks": [{"name": "same scene", "verdict": "pass", "found": "digest"}],
            "quantities": [{"key": "settled.height", "verdict": "fail"}]}}], "faults": [{"fault": "wall=missing",
            "verdict": "not_made", "found": ""}], "runs": []}"#;
        let record = parse("r", old).expect("a record");
        let ids: Vec<&str> = record
            .checks
            .iter()
            .map(|check| check.id.as_str())
            .collect();
        assert_eq!(
            ids,
            [
                "reproduce/comparisons/native-against-yade/comparison/checks/same-scene",
                "reproduce/comparisons/native-against-yade/comparison/quantities/settled.height",
                "reproduce/faults/wall-missing",
            ]
        );
        let tally = record.tally();
        assert_eq!((tally.passed, tally.failed, tally.not_made), (1, 1, 1));
        assert_eq!(record.verdict, Outcome::Fail);
    }

    #[test]
    fn what_is_no_record_is_refused_with_what_to_do() {
        let newer = NEW.replace("\"version\": 2", "\"version\": 9");
        for (text, words) in [
            ("", "no record"),
            ("[]", "no version"),
            ("{\"version\": -1}", "no version"),
            ("{\"version\": 2}", "of which job"),
            ("{\"version\": 2, \"job\": \"bake\"}", "keeps no checks"),
            (newer.as_str(), "newer crossgrain"),
            ("{\"version\": 2, \"job\": \"verify\"}", "missing field"),
        ] {
            let error = parse("r", text).expect_err("no record").to_string();
            assert!(error.contains(words), "{text}: {error}");
        }
    }
}
