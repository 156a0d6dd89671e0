//! The members of a plan, run on every core and written down one by one.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Mutex;

use super::plan::{Plan, Setting};
use super::push::{self, Push, Watched};
use super::row::{self, Poured, Row};
use crate::error::Error;
use crate::progress::Display;
use crate::study::tradeoff::ledger::{Entry, Ledger};
use crate::study::workers::{self, lock};
use grains::scene::Scene;

/// Every member of a plan.
#[derive(Debug, Default)]
pub struct Members {
    rows: BTreeMap<(String, u64), Row>,
    /// In the order of the plan's pushes and clouds.
    pub watched: Vec<Watched>,
}

impl Members {
    /// Those of a setting that were made, by cloud.
    pub fn of(&self, setting: &Setting) -> Vec<&Row> {
        let digest = setting.digest();
        (setting.first..setting.first + setting.clouds)
            .filter_map(|realization| self.rows.get(&(digest.clone(), realization)))
            .collect()
    }

    /// Adds a member.
    pub fn add(&mut self, row: Row) {
        self.rows
            .insert((row.setting.clone(), row.realization), row);
    }
}

/// A piece of work.
#[derive(Debug, Clone, PartialEq)]
enum Work<'a> {
    /// One bed, loaded in many ways.
    Bed(Vec<&'a Setting>),
    /// One realization from cloud to end.
    Whole(&'a Setting),
    /// One watched punch.
    Push(&'a Push),
}

/// All work, the first clouds of everything first, so that a job that is looked at early has a little of
/// everything.
fn work(plan: &Plan) -> Vec<(Work<'_>, u64)> {
    let mut all = Vec::new();
    let mut planned = BTreeSet::new();
    let pour_digests: Vec<String> = plan
        .settings
        .iter()
        .map(|setting| setting.pour_digest(&plan.base))
        .collect();
    let digests: Vec<String> = plan.settings.iter().map(Setting::digest).collect();
    let clouds: BTreeSet<u64> = plan
        .settings
        .iter()
        .flat_map(|setting| setting.first..setting.first + setting.clouds)
        .chain(plan.pushes.iter().flat_map(|push| 1..=push.clouds))
        .collect();
    for realization in clouds {
        // By what is poured, in the order of the plan.
        let mut beds: Vec<(&str, Vec<&Setting>)> = Vec::new();
        let mut whole = Vec::new();
        for (index, setting) in plan.settings.iter().enumerate() {
            let wanted = setting.first..setting.first + setting.clouds;
            if !wanted.contains(&realization)
                || !planned.insert((digests[index].as_str(), realization))
            {
                continue;
            }
            if !setting.can_share_beds() {
                whole.push((Work::Whole(setting), realization));
                continue;
            }
            let pour = pour_digests[index].as_str();
            match beds.iter_mut().find(|bed| bed.0 == pour) {
                Some(bed) => bed.1.push(setting),
                None => beds.push((pour, vec![setting])),
            }
        }
        all.extend(beds.into_iter().map(|bed| (Work::Bed(bed.1), realization)));
        let pushes = plan.pushes.iter().filter(|push| realization <= push.clouds);
        all.extend(pushes.map(|push| (Work::Push(push), realization)));
        all.append(&mut whole);
    }
    all
}

/// Runs what the folder's ledgers do not have.
pub fn run(plan: &Plan, out: &Path, display: &Display) -> Result<Members, Error> {
    let rows = Mutex::new(Ledger::<Row>::open(&out.join("members.jsonl"))?);
    let watched = Mutex::new(Ledger::<Watched>::open(&out.join("pushes.jsonl"))?);
    let all = work(plan);
    workers::all(all.len(), "beds", display, |index| {
        let (work, realization) = &all[index];
        let of = |scene: &Scene| Scene {
            realization: *realization,
            ..scene.clone()
        };
        match work {
            Work::Bed(settings) => {
                let missing = settings
                    .iter()
                    .filter(|setting| !has(&rows, &setting.digest(), *realization));
                // Poured when the first load asks for it.
                let mut poured: Option<Poured> = None;
                for setting in missing {
                    let scene = of(&setting.scene);
                    let bed = match poured.take() {
                        Some(bed) => bed,
                        None => row::pour(&scene)?,
                    };
                    let row = row::load(&setting.digest(), &scene, &bed)?;
                    lock(&rows).add(row)?;
                    poured = Some(bed);
                }
            }
            Work::Whole(setting) => {
                if !has(&rows, &setting.digest(), *realization) {
                    let row = row::whole(&setting.digest(), &of(&setting.scene))?;
                    lock(&rows).add(row)?;
                }
            }
            Work::Push(push) => {
                if !has(&watched, &push.digest(), *realization) {
                    let found = push::watch(push, *realization)?;
                    lock(&watched).add(found)?;
                }
            }
        }
        Ok(())
    })?;
    Ok(finished(plan, &lock(&rows), &lock(&watched)))
}

/// What a folder has of a plan, without running anything.
pub fn read(plan: &Plan, out: &Path) -> Result<Members, Error> {
    let rows = Ledger::<Row>::open(&out.join("members.jsonl"))?;
    let watched = Ledger::<Watched>::open(&out.join("pushes.jsonl"))?;
    Ok(finished(plan, &rows, &watched))
}

fn has<T: Entry>(ledger: &Mutex<Ledger<T>>, digest: &str, realization: u64) -> bool {
    lock(ledger).member(digest, realization).is_some()
}

fn finished(plan: &Plan, rows: &Ledger<Row>, watched: &Ledger<Watched>) -> Members {
    let mut members = Members::default();
    for setting in &plan.settings {
        let digest = setting.digest();
        for realization in setting.first..setting.first + setting.clouds {
            if let Some(row) = rows.member(&digest, realization) {
                members.add(row.clone());
            }
        }
    }
    for push in &plan.pushes {
        let digest = push.digest();
        let own = (1..=push.clouds).filter_map(|of| watched.member(&digest, of));
        members.watched.extend(own.cloned());
    }
    members
}
