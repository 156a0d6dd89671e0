//! The parts of the model that an engine may have, and which of them a scene or a case asks for.

use serde::{Deserialize, Serialize};

use super::Description;
use grains::case::Case;
use grains::model::Model;
use grains::scene::Scene;
use grains::tables::Stage;
use grains::task::{Task, Until};

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
}

impl Part {
    /// All of them.
    pub const ALL: [Part; 10] = [
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
