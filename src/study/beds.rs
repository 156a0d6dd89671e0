//! Beds that are loaded in several settings: the settings of a bed pour alike, so it is poured once on each of its clouds.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::engine::EngineError;
use crate::study::Outline;
use crate::study::member::{Member, of_one_bed};
use crate::study::realization::{Setting, sound};

/// All beds have as many clouds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Beds(pub Vec<Vec<Setting>>);

impl Beds {
    pub fn settings(&self) -> impl Iterator<Item = &Setting> {
        self.0.iter().flatten()
    }

    pub fn clouds(&self) -> u64 {
        let first = self.settings().next();
        first.map_or(0, |of| of.realizations().count() as u64)
    }

    /// Tasks: a bed on a cloud with all of its loads.
    pub fn count(&self) -> u64 {
        self.0.len() as u64 * self.clouds()
    }

    /// The bed of a task and its cloud; the first clouds of all beds come first.
    fn task(&self, task: u64) -> (&[Setting], u64) {
        let (beds, task) = (self.0.len() as u64, task - 1);
        let bed = &self.0[(task % beds) as usize];
        (bed, bed[0].clouds[0][0] + task / beds)
    }

    /// What is wrong with beds that may have been read from a file.
    pub fn check(&self) -> Result<(), String> {
        if self.0.iter().any(Vec::is_empty) {
            return Err("a bed has no loads".to_owned());
        }
        sound(self.settings())?;
        let clouds = self.clouds();
        if !self
            .settings()
            .all(|of| of.clouds.len() == 1 && of.realizations().count() as u64 == clouds)
        {
            return Err("beds have different numbers of clouds".to_owned());
        }
        for bed in &self.0 {
            let first = &bed[0];
            let pours_like = |of: &Setting| of.specification.pours_like(&first.specification);
            let other = |of: &&Setting| of.clouds != first.clouds || !pours_like(of);
            if let Some(other) = bed.iter().find(other) {
                return Err(format!(
                    "{} does not load the beds of {}",
                    other.id, first.id
                ));
            }
        }
        Ok(())
    }

    pub fn identity(&self, task: u64) -> String {
        let (bed, cloud) = self.task(task);
        let all = bed.iter().map(|of| of.specification.digest());
        format!("{} {cloud}", all.collect::<Vec<String>>().join(" "))
    }

    pub fn run(
        &self,
        task: u64,
        keep: impl Fn(&str) -> bool + Copy,
    ) -> Result<Vec<Member>, EngineError> {
        let (bed, cloud) = self.task(task);
        of_one_bed(&bed.iter().collect::<Vec<&Setting>>(), cloud, keep)
    }

    pub fn belongs(&self, task: u64, row: &[Member]) -> bool {
        let (bed, cloud) = self.task(task);
        let own = bed.iter().map(|of| of.specification.digest());
        own.eq(row.iter().map(|of| of.specification.clone()))
            && row.iter().all(|of| of.realization == cloud)
    }

    pub fn outline(row: &[Member]) -> Outline {
        let cloud = row.first().map_or(0, |of| of.realization);
        let cells = [
            ("realization", cloud.to_string()),
            ("loads", row.len().to_string()),
        ];
        Outline::new("loaded", cells, &BTreeMap::new())
    }
}
