//! What an engine says of itself: its name, and which parts of the model it has; and what a scene or a case asks for.

use std::path::Path;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::exec::{self, Options, PROTOCOL};
use crate::engine::ProgramError;
use crate::engine::watch::Limits;
use crate::files::{read_text, work_folder};
use grains::model::Model;
use grains::scene::Scene;
use grains::tables::Stage;
use grains::task::Case;
use grains::task::{Task, Until};

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
    pub fn parse(path: &Path, text: &str) -> Result<Self, ProgramError> {
        parse(text, &|reason| ProgramError::Undescribed {
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
pub fn describe(options: &Options) -> Result<Description, ProgramError> {
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
    let undescribed = |reason: String| ProgramError::Undescribed {
        path: options.program.clone(),
        reason,
    };
    exec::ask(&asked, work.path()).map_err(|error| match error {
        ProgramError::Crashed { status, log } => {
            undescribed(format!("it ended with {status}\n{log}"))
        }
        ProgramError::Hung { reason, .. } => undescribed(reason),
        ProgramError::TooMuch { reason } => undescribed(format!("it took {reason}")),
        other => other,
    })?;
    let text = read_text(&work.path().join(exec::SAID), LONGEST)
        .map_err(|error| undescribed(error.to_string()))?;
    Description::parse(&options.program, &text)
}

fn parse(
    text: &str,
    undescribed: &dyn Fn(String) -> ProgramError,
) -> Result<Description, ProgramError> {
    let broken = |error: serde_json::Error| {
        let printed: String = text.chars().take(200).collect();
        undescribed(format!("{error}; it printed {printed:?}"))
    };
    let Versioned { protocol } = serde_json::from_str(text).map_err(broken)?;
    if protocol != u64::from(PROTOCOL) {
        return Err(ProgramError::OtherProtocol { found: protocol });
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

/// What an engine may have; the vocabulary of version 1 of the protocol.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// Linear springs along the normal.
    NormalSpring,
    /// Tangential springs with a Coulomb limit and their history.
    TangentialSpring,
    /// Grains that turn.
    Rotation,
    /// Dashpots along the normal.
    Dashpots,
    /// Cundall's damping.
    LocalDamping,
    /// Gravity.
    Gravity,
    /// Infinite walls.
    Walls,
    /// The rigid punch.
    Punch,
    /// The rules that end stages.
    StopRules,
    /// Lists of small experiments in one start.
    Cases,
    /// Beds whose steps it times by its own clock.
    Timing,
}

impl Part {
    /// All of them.
    pub const ALL: [Part; 11] = [
        Part::NormalSpring,
        Part::TangentialSpring,
        Part::Rotation,
        Part::Dashpots,
        Part::LocalDamping,
        Part::Gravity,
        Part::Walls,
        Part::Punch,
        Part::StopRules,
        Part::Cases,
        Part::Timing,
    ];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Part::NormalSpring => "normal_spring",
            Part::TangentialSpring => "tangential_spring",
            Part::Rotation => "rotation",
            Part::Dashpots => "dashpots",
            Part::LocalDamping => "local_damping",
            Part::Gravity => "gravity",
            Part::Walls => "walls",
            Part::Punch => "punch",
            Part::StopRules => "stop_rules",
            Part::Cases => "cases",
            Part::Timing => "timing",
        }
    }

    /// For messages.
    pub fn in_words(self) -> &'static str {
        match self {
            Part::NormalSpring => "normal springs (normal_spring)",
            Part::TangentialSpring => "friction (tangential_spring)",
            Part::Rotation => "rotating grains (rotation)",
            Part::Dashpots => "dashpots (dashpots)",
            Part::LocalDamping => "Cundall's damping (local_damping)",
            Part::Gravity => "gravity (gravity)",
            Part::Walls => "walls (walls)",
            Part::Punch => "punch (punch)",
            Part::StopRules => "rules that end a stage (stop_rules)",
            Part::Cases => "lists of small experiments (cases)",
            Part::Timing => "clock of its own steps (timing)",
        }
    }
}

/// What this model asks for.
fn of_model(model: &Model) -> Vec<Part> {
    let asked = [
        (Part::NormalSpring, true),
        (Part::TangentialSpring, model.law.has_friction()),
        (Part::Rotation, model.law.rotates()),
        (Part::Dashpots, model.law.has_dashpots()),
        (Part::LocalDamping, model.alpha != 0.0),
        (Part::Gravity, model.gravity != [0.0; 2]),
        (Part::Walls, !model.walls.is_empty()),
    ];
    let asked = asked.into_iter().filter(|(_, asked)| *asked);
    asked.map(|(part, _)| part).collect()
}

/// What a task of this scene asks for and the engine does not have.
pub fn missing_for_scene(engine: &Description, scene: &Scene, task: &Task) -> Vec<Part> {
    let mut asked = of_model(&Model::of(scene));
    if task.start.stage == Stage::Load || task.until == Until::EndOfLoading {
        asked.push(Part::Punch);
    }
    if !matches!(task.until, Until::Step(_)) {
        asked.push(Part::StopRules);
    }
    asked.retain(|part| !engine.has(*part));
    asked
}

/// What this case asks for and the engine does not have.
pub fn missing_for_case(engine: &Description, case: &Case) -> Vec<Part> {
    let mut asked = of_model(&case.model);
    asked.push(Part::Cases);
    if case.punch.is_some() {
        asked.push(Part::Punch);
    }
    asked.retain(|part| !engine.has(*part));
    asked
}
