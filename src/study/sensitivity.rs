//! What the published figures depend on: the experiment over the choices that the paper does not print.

pub mod bearing;
pub mod document;
pub mod judge;
pub mod penetration;
pub mod plan;
pub mod record;

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::machine::Folder;
use super::member::{Member, Poured};
use super::realization::{Engines, Runner};
use super::report::Judged;
use super::specification::{Setting, sound};
use super::{Outline, Study, StudyError};
use crate::engine::EngineError;
use crate::paper::published::PUBLISHED;
use grains::native::Mode;
use penetration::Watched;
use plan::{Plan, Task, can_share_beds};
use record::Sensitivity;

/// Kept besides the published figures' quantities.
const KEPT: [&str; 7] = [
    "settled.porosity.of_cells",
    "settled.coordination.mean",
    "settled.stress.O.local_zz",
    "settled.stress.A.local_zz",
    "settled.stress.B.local_zz",
    "loaded.punch.depth",
    "loaded.punch.force",
];

/// What a task gives.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Row {
    /// One bed in all its loads.
    Loads(Vec<Member>),
    /// A penetration or relaxation test.
    Penetration(Watched),
}

/// Whether a quantity stays in the rows.
pub fn keep(key: &str) -> bool {
    KEPT.contains(&key) || PUBLISHED.iter().any(|figure| figure.key == key)
}

/// Members of one cloud; settings that share beds are loaded from one. With friction the realization is run whole.
pub fn load_all(settings: &[&Setting], cloud: u64) -> Result<Vec<Member>, EngineError> {
    let [first, ..] = settings else {
        return Ok(Vec::new());
    };
    if !can_share_beds(first) {
        let engines = Engines::default();
        let whole = |of: &&Setting| {
            let run = Member::run(&of.specification, cloud, &engines, Path::new(""), keep)?;
            // Time has no place among bits.
            Ok(Member { cost: None, ..run })
        };
        return settings.iter().map(whole).collect();
    }
    let poured = Poured::of(&first.specification.scene_of(cloud))?;
    let load = |of: &&Setting| poured.load(&of.specification, cloud, keep);
    settings.iter().map(load).collect()
}

impl Study for Plan {
    const KIND: &'static str = "sensitivity";
    type Row = Row;

    fn count(&self) -> u64 {
        self.tasks().len() as u64
    }

    fn check(&self) -> Result<(), String> {
        sound(&self.settings)
    }

    fn runner(&self, _: u64) -> Runner {
        Runner::Native(Mode::Exact)
    }

    fn identity(&self, task: u64) -> String {
        match self.task(task) {
            Task::Loads(settings, cloud) => {
                let own = settings
                    .iter()
                    .map(|of| self.settings[*of].specification.digest());
                format!("loads {} {cloud}", own.collect::<Vec<String>>().join(" "))
            }
            Task::Penetration(of, cloud) => {
                format!("penetration {} {cloud}", self.penetrations[*of].digest())
            }
        }
    }

    fn run(&self, task: u64, _: &Engines, _: &Path) -> Result<Row, EngineError> {
        match self.task(task) {
            Task::Loads(settings, cloud) => {
                let settings: Vec<&Setting> =
                    settings.iter().map(|of| &self.settings[*of]).collect();
                load_all(&settings, *cloud).map(Row::Loads)
            }
            Task::Penetration(of, cloud) => {
                penetration::watch(&self.penetrations[*of], *cloud).map(Row::Penetration)
            }
        }
    }

    fn belongs(&self, task: u64, row: &Row) -> bool {
        match (self.task(task), row) {
            (Task::Loads(settings, cloud), Row::Loads(members)) => {
                let digests = settings
                    .iter()
                    .map(|of| self.settings[*of].specification.digest());
                let own = members.iter().map(|of| of.specification.clone());
                digests.eq(own) && members.iter().all(|of| of.realization == *cloud)
            }
            (Task::Penetration(of, cloud), Row::Penetration(row)) => {
                row.realization == *cloud && row.penetration == self.penetrations[*of].digest()
            }
            _ => false,
        }
    }

    fn outline(&self, row: &Row) -> Outline {
        let (ending, cloud, of) = match row {
            Row::Loads(members) => {
                let cloud = members.first().map_or(0, |of| of.realization);
                ("loaded", cloud, members.len())
            }
            Row::Penetration(of) => ("watched", of.realization, of.windows.len()),
        };
        let cells = [
            ("realization", cloud.to_string()),
            ("loads_or_windows", of.to_string()),
        ];
        Outline {
            engine: None,
            ending,
            cells: cells.map(|(name, value)| (name.to_owned(), value)).into(),
        }
    }

    fn judge(folder: &Folder<Self>) -> Result<Judged, StudyError> {
        let (mut members, mut watched) = (Vec::new(), Vec::new());
        folder.each(|_, row| match row {
            Row::Loads(of) => members.extend(of),
            Row::Penetration(of) => watched.push(of),
        })?;
        let record = Sensitivity::of(&folder.plan.study, members.into_iter().collect(), &watched);
        let document = record.document();
        Judged::of(Self::KIND, &record, document)
    }
}
