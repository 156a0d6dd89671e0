//! What a run's record says of its engine.

use serde::{Deserialize, Serialize};

use super::Description;
use grains::native::Fault;
use grains::rules::Rules;

/// What a run says of its engine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "name", rename_all = "snake_case", deny_unknown_fields)]
pub enum EngineRecord {
    Native {
        version: String,
        perturbation: Option<Fault>,
    },
    Yade {
        version: String,
        /// Interactions visited in the order of their ids: the order with the native engine's bits.
        sorted: bool,
        /// `verletDist`, m.
        verlet_distance: f64,
        /// SHA-256 of the script that ran inside YADE.
        script: String,
    },
    /// A program that speaks the engine protocol.
    Exec {
        described: Description,
        /// SHA-256 of the program's file.
        digest: String,
    },
}

impl EngineRecord {
    /// Whether this run is meant to have the native engine's bits.
    pub fn keeps_order(&self) -> bool {
        match self {
            EngineRecord::Native { .. } => true,
            EngineRecord::Yade { sorted, .. } => *sorted,
            EngineRecord::Exec { .. } => false,
        }
    }

    /// Where the engine does something else than the model says, in its own words.
    pub fn approximations(&self) -> &[String] {
        match self {
            EngineRecord::Exec { described, .. } => &described.approximations,
            EngineRecord::Native { .. } | EngineRecord::Yade { .. } => &[],
        }
    }

    /// Rules that the engine says it has, whatever the model says.
    pub fn rules(&self) -> Rules {
        match self {
            EngineRecord::Exec { described, .. } => described.rules,
            EngineRecord::Native { .. } | EngineRecord::Yade { .. } => Rules::default(),
        }
    }

    /// Name and version.
    pub fn program(&self) -> String {
        match self {
            EngineRecord::Native { version, .. } => format!("native {version}"),
            EngineRecord::Yade { version, .. } => format!("YADE {version}"),
            EngineRecord::Exec { described, .. } => described.label(),
        }
    }

    pub fn version(&self) -> &str {
        match self {
            EngineRecord::Native { version, .. } | EngineRecord::Yade { version, .. } => version,
            EngineRecord::Exec { described, .. } => &described.version,
        }
    }

    pub fn label(&self) -> String {
        match self {
            EngineRecord::Native { perturbation, .. } => perturbation
                .map_or("native".to_owned(), |perturbation| {
                    format!("native with {perturbation}")
                }),
            EngineRecord::Yade {
                version,
                sorted,
                verlet_distance,
                ..
            } => {
                let order = if *sorted { "sorted" } else { "ordinary" };
                format!("YADE {version}, {order} loop, verletDist {verlet_distance:e}")
            }
            EngineRecord::Exec { described, .. } => format!("{} (exec)", described.label()),
        }
    }
}
