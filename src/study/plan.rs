//! The plan of a study on the disk: everything that its rows depend on, fixed before the first one is made.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{Study, StudyError, store};
use crate::engine::exec::{Description, ExternalEngine};
use crate::engine::yade;
use crate::files::{
    Place, new_folder, read_text, sha256_hex, whole_path, write_folder, write_whole,
};

const VERSION: u32 = 1;
/// The most rows that files, memory and merging were planned for.
pub const MOST_ROWS: u64 = 1_000_000;
/// The most text of a plan, bytes.
const LARGEST: u64 = 1 << 26;
const NAME: &str = "plan.json";
/// What stands between a plan and its digest.
const SEAL: &str = ",\n  \"digest\": \"";

/// What is run, and by which program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan<S> {
    pub kind: String,
    pub version: u32,
    pub made_with: MadeWith,
    /// The external engine, where rows are made in one.
    pub program: Option<Program>,
    pub study: S,
}

/// What decides the bits of rows besides the plan. Rows are made by the program that planned them only.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MadeWith {
    pub crossgrain: String,
    /// [`grains::SOURCE_DIGEST`].
    pub source: String,
    /// SHA-256 of the scripts that run inside YADE, where rows are made in YADE.
    pub yade_scripts: Option<String>,
    /// How it is known, where `source` was not written down when the rows were made.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Program {
    /// Where it is on the machine of the plan.
    pub path: PathBuf,
    pub described: Description,
    /// SHA-256 of its file.
    pub digest: String,
}

impl Program {
    /// Of an engine that was asked.
    pub fn of(engine: &ExternalEngine) -> Result<Self, StudyError> {
        let named = &engine.options.program;
        Ok(Program {
            path: whole_path(named)?,
            described: engine.description.clone(),
            digest: engine.digest.clone(),
        })
    }
}

impl MadeWith {
    /// This program for a study, with YADE's scripts where they take part.
    fn this<S: Study>(study: &S) -> Self {
        let with_yade = (1..=study.count()).any(|task| study.runner(task).is_yade());
        MadeWith {
            crossgrain: env!("CARGO_PKG_VERSION").to_owned(),
            source: grains::SOURCE_DIGEST.to_owned(),
            yade_scripts: with_yade.then(|| yade::script_digest(study.in_space())),
            note: None,
        }
    }

    fn in_words(&self) -> String {
        let short = |digest: &str| digest.chars().take(12).collect::<String>();
        let mut words = format!("{} with source {}", self.crossgrain, short(&self.source));
        if let Some(scripts) = &self.yade_scripts {
            words += &format!(" and YADE scripts {}", short(scripts));
        }
        words
    }
}

impl<S: Study> Plan<S> {
    /// Of this study, to be run by this program.
    pub fn new(study: S, program: Option<Program>) -> Result<Self, StudyError> {
        check(&study).map_err(StudyError::Usage)?;
        Ok(Plan {
            kind: S::KIND.to_owned(),
            version: VERSION,
            made_with: MadeWith::this(&study),
            program,
            study,
        })
    }

    /// SHA-256 of the whole plan, in hexadecimal; the check of every row covers it.
    pub fn digest(&self) -> String {
        let text = serde_json::to_string(self).expect("a plan is JSON");
        sha256_hex(text.as_bytes())
    }

    /// As it is on the disk: the plan with its digest at the end, so that a plan that was edited is noticed before
    /// anything is run.
    pub fn text(&self) -> String {
        let text = serde_json::to_string_pretty(self).expect("a plan is JSON");
        let body = text.strip_suffix("\n}").unwrap_or(&text);
        format!("{body}{SEAL}{}\"\n}}\n", self.digest())
    }

    /// Makes the study's folder, which must not exist.
    pub fn write(&self, folder: &Path) -> Result<(), StudyError> {
        let text = self.text();
        if text.len() as u64 > LARGEST {
            let why = format!("its plan would have more than {LARGEST} bytes; plan fewer rows");
            return Err(StudyError::Usage(why));
        }
        write_folder(folder, |aside| {
            new_folder((aside, store::RECORDS))?;
            Ok(write_whole((aside, NAME), text.as_bytes())?)
        })
    }

    /// Reads the plan of a study's folder and checks that it is whole.
    pub fn read(folder: &Path) -> Result<Self, StudyError> {
        let not_one = |reason: String| StudyError::not_a_study(folder, reason);
        let wrong = |error: serde_json::Error| not_one(format!("{NAME}: {error}"));
        let (head, text) = stored(folder)?;
        if let Some(kind) = head.kind.filter(|kind| *kind != S::KIND) {
            let reason = format!(
                "it is a study of kind {kind}, and one of kind {} is wanted",
                S::KIND
            );
            return Err(not_one(reason));
        }
        let body = text.rsplit_once(SEAL).map_or(&*text, |(body, _)| body);
        let plan: Plan<S> = serde_json::from_str(&format!("{body}\n}}")).map_err(wrong)?;
        if text != plan.text() {
            return Err(not_one(format!(
                "{NAME} was changed after it was made, and plans never change; put back what was there, or plan anew"
            )));
        }
        check(&plan.study).map_err(|reason| not_one(format!("{NAME}: {reason}")))?;
        Ok(plan)
    }

    /// That this program gives the bits that were planned.
    pub fn check_program(&self, folder: &Path) -> Result<(), StudyError> {
        let this = MadeWith::this(&self.study);
        let planned = MadeWith {
            note: None,
            ..self.made_with.clone()
        };
        if planned == this {
            return Ok(());
        }
        Err(StudyError::OtherProgram {
            path: folder.to_owned(),
            planned: planned.in_words(),
            present: this.in_words(),
        })
    }
}

fn check<S: Study>(study: &S) -> Result<(), String> {
    study.check()?;
    match study.count() {
        1..=MOST_ROWS => Ok(()),
        count => Err(format!("{count} rows; a study has 1 to {MOST_ROWS}")),
    }
}

pub fn kind(folder: &Path) -> Result<String, StudyError> {
    let kind = stored(folder)?.0.kind;
    kind.ok_or_else(|| StudyError::not_a_study(folder, format!("{NAME} names no kind")))
}

/// Looked at before the rest, which another kind or version does not have.
#[derive(Deserialize)]
struct Head {
    kind: Option<String>,
    version: Option<u64>,
}

/// The head of a plan of a version that is known, and its whole text; that of a recorded study may be packed (`plan.json.gz`).
fn stored(folder: &Path) -> Result<(Head, String), StudyError> {
    let not_one = |why: String| StudyError::not_a_study(folder, why);
    let packed = format!("{NAME}.gz");
    let mut places = [NAME, &packed].into_iter();
    let place = places.find(|name| Place::from((folder, *name)).is_taken());
    let name = place.ok_or_else(|| match Place::from(folder).is_taken() {
        true => not_one(format!("it has no {NAME}")),
        false => not_one("there is no such folder".to_owned()),
    })?;
    let text = read_text((folder, name), LARGEST)?;
    let head: Result<Head, _> = serde_json::from_str(&text);
    let head = head.map_err(|error| not_one(format!("{NAME}: {error}")))?;
    match head.version {
        Some(version) if version != u64::from(VERSION) => Err(not_one(format!(
            "{NAME} has version {version}, and this program reads {VERSION}"
        ))),
        _ => Ok((head, text)),
    }
}
