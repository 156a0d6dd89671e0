//! What an engine says of itself.

use std::path::Path;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::{ExecError, Options, PROTOCOL, Part, child};
use crate::engine::watch::Limits;
use crate::files::{read_text, work_folder};

/// What `describe` printed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Description {
    /// [`PROTOCOL`].
    pub protocol: u32,
    /// Its name.
    pub name: String,
    /// Its version.
    pub version: String,
    /// What it has.
    pub parts: Vec<Part>,
    /// Where it does something else than the model says, in words; shown wherever its results are.
    #[serde(default)]
    pub approximations: Vec<String>,
}

impl Description {
    /// Reads what `path` printed when it was asked what it is.
    pub fn parse(path: &Path, text: &str) -> Result<Self, ExecError> {
        parse(text, &|reason| ExecError::Undescribed {
            path: path.to_owned(),
            reason,
        })
    }

    /// Whether it has this part.
    pub fn has(&self, part: Part) -> bool {
        self.parts.contains(&part)
    }

    /// Name and version.
    pub fn label(&self) -> String {
        format!("{} {}", self.name, self.version)
    }
}

/// Looked at before the rest, which another version may not have.
#[derive(Deserialize)]
struct Versioned {
    protocol: u64,
}

/// The most that a description may say, bytes.
const LONGEST: u64 = 1 << 16;
/// Longest name, version or approximation, characters.
const LONGEST_WORDS: usize = 400;
/// A description takes no longer.
const TIME: Duration = Duration::from_secs(30);

/// Asks the engine what it is.
pub fn describe(options: &Options) -> Result<Description, ExecError> {
    let work = work_folder()?;
    let limits = Limits {
        time: options.limits.time.min(TIME),
        stall: TIME,
        output: 1 << 20,
        ..options.limits
    };
    let asked = Options {
        program: options.program.clone(),
        limits,
    };
    let undescribed = |reason: String| ExecError::Undescribed {
        path: options.program.clone(),
        reason,
    };
    child::describe(&asked, work.path()).map_err(|error| match error {
        ExecError::Crashed { status, log } => undescribed(format!("it ended with {status}\n{log}")),
        ExecError::Hung { reason, .. } => undescribed(reason),
        ExecError::TooMuch { reason } => undescribed(format!("it took {reason}")),
        other => other,
    })?;
    let text = read_text(&work.path().join(child::SAID), LONGEST)
        .map_err(|error| undescribed(error.to_string()))?;
    Description::parse(&options.program, &text)
}

fn parse(text: &str, undescribed: &dyn Fn(String) -> ExecError) -> Result<Description, ExecError> {
    let broken = |error: serde_json::Error| {
        let printed: String = text.chars().take(200).collect();
        undescribed(format!("{error}; it printed {printed:?}"))
    };
    let Versioned { protocol } = serde_json::from_str(text).map_err(broken)?;
    if protocol != u64::from(PROTOCOL) {
        return Err(ExecError::OtherProtocol { found: protocol });
    }
    let description: Description = serde_json::from_str(text).map_err(broken)?;
    let words = [&description.name, &description.version];
    for word in words.into_iter().chain(&description.approximations) {
        let length = word.chars().count();
        if length > LONGEST_WORDS || word.chars().any(char::is_control) {
            return Err(undescribed(format!(
                "names and notes are at most {LONGEST_WORDS} characters without line breaks, and it says {word:?}"
            )));
        }
    }
    if description.name.trim().is_empty() {
        return Err(undescribed("its name is empty".to_owned()));
    }
    if !description.has(Part::NormalSpring) {
        return Err(undescribed(
            "it has no normal_spring, without which there is nothing to ask".to_owned(),
        ));
    }
    Ok(description)
}
