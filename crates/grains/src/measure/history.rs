//! The time series of a run: one row a moment.

use serde::{Deserialize, Serialize};

use super::{Bed, equilibrium};
use crate::scene::Scene;
use crate::tables::{Snapshot, Stage};

/// One moment of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HistoryRow {
    /// The stage that is under way.
    pub stage: Stage,
    /// Steps since the start of the stage.
    pub step: u64,
    /// s since the start of the stage.
    pub time: f64,
    /// J.
    pub kinetic_energy: f64,
    /// J, above the floor.
    pub potential_energy: f64,
    /// J.
    pub elastic_energy: f64,
    /// Empty without contacts.
    pub unbalanced_force: Option<f64>,
    /// How many pairs touch, walls and punch included.
    pub contacts: u64,
    /// m, empty without a punch.
    pub punch_depth: Option<f64>,
    /// N, positive upwards, empty without a punch.
    pub punch_force: Option<f64>,
    /// Digest of the bits of every position and velocity.
    pub state: String,
}

impl HistoryRow {
    /// The columns of `history.csv`.
    pub const HEADER: &[&str] = &[
        "stage",
        "step",
        "time",
        "kinetic_energy",
        "potential_energy",
        "elastic_energy",
        "unbalanced_force",
        "contacts",
        "punch_depth",
        "punch_force",
        "state",
    ];

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        let always = [
            self.time,
            self.kinetic_energy,
            self.potential_energy,
            self.elastic_energy,
        ];
        let sometimes = [self.unbalanced_force, self.punch_depth, self.punch_force];
        always
            .into_iter()
            .chain(sometimes.into_iter().flatten())
            .all(f64::is_finite)
    }
}

/// The row of a moment.
pub fn row(scene: &Scene, snapshot: &Snapshot) -> HistoryRow {
    let bed = Bed {
        bodies: &snapshot.bodies,
        contacts: &snapshot.contacts,
    };
    HistoryRow {
        stage: snapshot.stage,
        step: snapshot.step,
        time: snapshot.time,
        kinetic_energy: equilibrium::kinetic_energy(bed.bodies),
        potential_energy: equilibrium::potential_energy(scene, bed.bodies),
        elastic_energy: equilibrium::elastic_energy(scene, bed),
        unbalanced_force: equilibrium::unbalanced_force(scene, bed),
        contacts: bed.contacts.len() as u64,
        punch_depth: snapshot.punch.map(|punch| punch.depth()),
        punch_force: snapshot.punch.map(|punch| punch.force),
        state: snapshot.bodies.digest(),
    }
}
