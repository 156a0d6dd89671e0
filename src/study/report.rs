//! What a study says: its own record with the checks in the shape of all jobs, and a document for people.

use serde::Serialize;
use serde_json::{Value, json};

use super::machine::{Folder, Machine as _};
use super::{Study, StudyError};
use crate::checks::record::{Found, Record, RecordError, write};
use crate::checks::{Check, Measured, Outcome, verdict};
use crate::document::Document;

/// The record's file in the study's folder.
pub const RECORD: &str = "report.json";

/// What a judge says.
#[derive(Debug)]
pub struct Judged {
    /// The study's own record, a JSON object.
    pub own: Value,
    /// Numbers that only a baseline judges.
    pub measured: Vec<Measured>,
    /// With the study's checks; the machine adds one that no row is missing, and the verdict.
    pub document: Document,
}

impl Judged {
    /// Of a study's own record, with nothing for a baseline alone.
    pub fn of(
        kind: &str,
        record: &impl Serialize,
        document: Document,
    ) -> Result<Judged, StudyError> {
        let own = serde_json::to_value(record).map_err(|error| RecordError::Malformed {
            path: format!("the record of {kind}"),
            reason: error.to_string(),
        })?;
        Ok(Judged {
            own,
            measured: Vec::new(),
            document,
        })
    }
}

/// What is written and shown.
#[derive(Debug)]
pub struct Report {
    /// `report.json`.
    pub text: String,
    /// The same, as all jobs have it.
    pub record: Record,
    /// For people.
    pub document: Document,
}

/// Judges the rows that are there.
pub fn of<S: Study>(folder: &Folder<S>) -> Result<Report, StudyError> {
    let status = folder.status()?;
    // Merged rows count without the records that they came from.
    let there = if status.merged {
        status.rows
    } else {
        status.finished
    };
    let Judged {
        mut own,
        measured,
        mut document,
    } = S::judge(folder)?;
    let outcome = if there == status.rows {
        Outcome::Pass
    } else {
        Outcome::Skipped
    };
    let found = format!("{there} of {} rows", status.rows);
    let check = Check::of_words(
        format!("{}/rows", S::KIND),
        "no row is missing",
        outcome,
        &found,
    );
    document.checks.insert(0, check.required());
    document.verdict = verdict(&document.checks);
    own["crossgrain"] = env!("CARGO_PKG_VERSION").into();
    own["command"] = "crossgrain study report DIR".into();
    own["plan"] = folder.plan.digest().into();
    own["made_with"] = json!(folder.plan.made_with);
    let found = Found {
        checks: document.checks.clone(),
        measured,
        speeds: Vec::new(),
    };
    // Nothing in it depends on the machine.
    let (text, record) = write(S::KIND, &own, String::new(), found)?;
    Ok(Report {
        text,
        record,
        document,
    })
}
