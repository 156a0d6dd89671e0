//! The part of a job's record that all jobs have in common, and reading it back from any of them.

use std::collections::HashSet;
use std::fmt::Display;
use std::path::Path;

use schemars::JsonSchema;
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{Check, Measured, Outcome, Speed};
use crate::files::{FileError, read_text, sha256_hex};

/// Longest record that is read, bytes.
const LONGEST: u64 = 1 << 25;

/// The version of this format.
pub const VERSION: u32 = 2;

/// Records of this version have no digest.
pub const UNSEALED: u32 = 1;

/// What stands between a file's JSON and its digest.
const SEAL: &str = ",\n  \"record_digest\": \"";

/// The pretty JSON object with the digest of its text as the last key.
pub fn sealed(json: &str) -> String {
    let body = json.strip_suffix("\n}").unwrap_or(json);
    format!("{body}{SEAL}{}\"\n}}\n", sha256_hex(body.as_bytes()))
}

/// Whether the text ends with its own digest.
pub fn is_sealed(text: &str) -> bool {
    text.rsplit_once(SEAL)
        .is_some_and(|(body, _)| sealed(&format!("{body}\n}}")) == text)
}

/// What every job's record has; its other keys are the job's own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Record {
    /// `reproduce`, `verify`, `bench`, …
    pub job: String,
    /// From 2 on the last key is `record_digest`: SHA-256 of the text before it, up to the comma.
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

/// What is no record.
pub fn malformed(path: &str, reason: impl Display) -> FileError {
    FileError::Unfit(format!(
        "{path} is no record of a job: {reason}; give run.json, verify.json, bench.json, check.json or report.json of a finished job"
    ))
}

/// Reads what is common from a job's record.
pub fn read(path: &Path) -> Result<Record, FileError> {
    parse(&path.display().to_string(), &read_text(path, LONGEST)?)
}

/// Only what tells whether the rest can be read.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Head {
    job: Option<IgnoredAny>,
    version: u32,
}

/// Reads a record from text and holds its ids and its verdict against its checks; `path` is for messages.
pub fn parse(path: &str, text: &str) -> Result<Record, FileError> {
    let broken = |error: serde_json::Error| malformed(path, error);
    let unfit = |words: String| Err(FileError::Unfit(format!("{path} {words}")));
    let Head { job, version } = serde_json::from_str(text).map_err(broken)?;
    if job.is_none() {
        return Err(malformed(path, "it names no job"));
    }
    if version > VERSION {
        return unfit(format!(
            "is of version {version} of the format of records, and this program knows {VERSION}; use a newer crossgrain"
        ));
    }
    let changed = "was changed after it was written";
    if !is_sealed(text) && version != UNSEALED {
        let help = "put back what was there, or do the job again";
        return unfit(format!("{changed}; {help}"));
    }
    let record: Record = serde_json::from_str(text).map_err(broken)?;
    let mut seen = HashSet::new();
    if let Some(Check { id, .. }) = record.checks.iter().find(|check| !seen.insert(&check.id)) {
        let why = "a failure of one would be hidden by the other";
        return unfit(format!("has two checks with the id {id}; {why}"));
    }
    let (stated, derived) = (record.verdict, super::verdict(&record.checks));
    if stated != derived {
        let [stated, derived] = [stated, derived].map(Outcome::word);
        return unfit(format!(
            "says {stated}, but its checks come to {derived}; it {changed}"
        ));
    }
    Ok(record)
}

/// What a job found, in the shape of all jobs.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Found {
    pub checks: Vec<Check>,
    pub measured: Vec<Measured>,
    pub speeds: Vec<Speed>,
}

impl From<&[Check]> for Found {
    fn from(checks: &[Check]) -> Self {
        Found {
            checks: checks.to_vec(),
            ..Found::default()
        }
    }
}

/// A job's own keys (`crossgrain` and `command` among them) with what all jobs have, as the text of its record, and what is
/// common read back from it. Ids that repeat are an error.
pub fn write(
    job: &str,
    own: &impl Serialize,
    machine_kind: String,
    found: Found,
) -> Result<(String, Record), FileError> {
    let path = format!("the record of {job}");
    let broken = |error: serde_json::Error| malformed(&path, error);
    #[derive(Serialize)]
    struct Whole<'a> {
        job: &'a str,
        version: u32,
        machine_kind: String,
        verdict: Outcome,
        #[serde(flatten)]
        own: Value,
        #[serde(flatten)]
        found: Found,
    }
    let mut own = serde_json::to_value(own).map_err(broken)?;
    if let Value::Object(keys) = &mut own {
        let common = ["job", "version", "machine_kind", "verdict", "record_digest"];
        keys.retain(|key, _| !common.contains(&key.as_str()));
    }
    let whole = Whole {
        job,
        version: VERSION,
        machine_kind,
        verdict: super::verdict(&found.checks),
        own,
        found,
    };
    let text = sealed(&serde_json::to_string_pretty(&whole).map_err(broken)?);
    let record = parse(&path, &text)?;
    Ok((text, record))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::Tally;

    const SOUND: &str = r#"{"job": "verify", "version": 1, "crossgrain": "0.1.0", "command": "crossgrain verify",
        "verdict": "pass", "own": 1, "checks": [{"id": "a/b", "quantity": "q", "unit": "m", "value": 1.0, "expected": 1.0,
        "lower": 0.5, "upper": 1.5, "method": "", "basis": "", "n": 1, "interval": null, "outcome": "pass", "found": ""}]}"#;

    fn refused(text: &str) -> String {
        parse("r", text).expect_err("is refused").to_string()
    }

    #[test]
    fn the_common_part_is_read_and_the_rest_left() {
        let record = parse("r", SOUND).expect("a record");
        assert_eq!(Tally::of(&record.checks).passed, 1);
        assert_eq!(record.scene_digest, None);
    }

    #[test]
    fn a_verdict_that_is_not_that_of_the_checks_is_refused() {
        let failed = r#""outcome": "fail""#;
        let skipped = r#""required": true, "outcome": "skipped""#;
        for (old, new, words) in [
            (
                r#""outcome": "pass""#,
                failed,
                "says pass, but its checks come to FAIL",
            ),
            (r#""outcome": "pass""#, skipped, "come to skipped"),
            (r#""verdict": "pass""#, r#""verdict": "fail""#, "says FAIL"),
        ] {
            assert!(refused(&SOUND.replace(old, new)).contains(words));
        }
    }

    #[test]
    fn an_id_that_repeats_is_refused_when_read_and_when_made() {
        let mut record = parse("r", SOUND).expect("a record");
        let failed = Check::of_words("a/b", "", Outcome::Fail, "");
        record.checks.push(failed);
        record.verdict = Outcome::Fail;
        let text = serde_json::to_string(&record).expect("JSON");
        assert!(refused(&text).contains("two checks with the id a/b"));
        let own = serde_json::json!({"crossgrain": "", "command": ""});
        let found = record.checks[..].into();
        let made = write("verify", &own, String::new(), found).expect_err("is refused");
        assert!(made.to_string().contains("two checks"), "{made}");
    }

    #[test]
    fn what_is_no_record_is_refused_with_what_to_do() {
        let newer = SOUND.replace("\"version\": 1", "\"version\": 9");
        for (text, words) in [
            ("", "no record"),
            ("[]", "it names no job"),
            ("{\"job\": \"x\", \"version\": -1}", "invalid value"),
            (newer.as_str(), "newer crossgrain"),
            ("{\"version\": 4, \"engine\": {}}", "it names no job"),
            ("{\"version\": 1, \"job\": \"verify\"}", "missing field"),
        ] {
            let error = refused(text);
            assert!(error.contains(words), "{text}: {error}");
        }
    }
}
