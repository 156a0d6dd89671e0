//! The members of a plan, run on every core and written down one by one.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Mutex;

use super::ledger::Ledger;
use super::member::{self, Member};
use super::method::{Method, Runner};
use super::plan::{FIRST_CONFIRMING, Plan};
use crate::engine::exec::{Brought, ExecError};
use crate::engine::yade::{self, YadeError};
use crate::error::Error;
use crate::files::work_folder;
use crate::progress::Display;
use crate::run::EngineError;
use crate::study::workers::{self, lock};

/// Where and how the job runs.
#[derive(Debug, Clone)]
pub struct Job {
    /// `members.jsonl` is in here.
    pub out: PathBuf,
    /// How YADE is started.
    pub yade: yade::Options,
    /// The program that was brought, if the plan has methods of one.
    pub brought: Option<Brought>,
}

/// All members of a plan that could be made.
#[derive(Debug, Default)]
pub struct Members {
    of: BTreeMap<(String, u64), Member>,
    /// Why members are missing, by method.
    pub not_made: BTreeMap<String, String>,
}

impl Members {
    /// The member of this method and realization.
    pub fn get(&self, method: &Method, realization: u64) -> Option<&Member> {
        self.of.get(&(method.digest(), realization))
    }

    /// Adds a member.
    pub fn add(&mut self, member: Member) {
        self.of
            .insert((member.method.clone(), member.realization), member);
    }
}

/// Every method and realization of the plan. The charted realizations come first, by their number, so that a job
/// that is looked at early has a little of everything.
pub fn wanted(plan: &Plan) -> Vec<(&Method, u64)> {
    let mut wanted = Vec::new();
    for realization in 1..=plan.charting {
        wanted.push((&plan.reference, realization));
        for planned in &plan.methods {
            if realization <= planned.charting {
                wanted.push((&planned.method, realization));
            }
        }
    }
    // The reference against itself on other clouds needs as many of those.
    let others = plan.confirming.max(plan.charting);
    for realization in FIRST_CONFIRMING..FIRST_CONFIRMING + others {
        wanted.push((&plan.reference, realization));
        for planned in plan.methods.iter().filter(|planned| planned.candidate) {
            if realization < FIRST_CONFIRMING + plan.confirming {
                wanted.push((&planned.method, realization));
            }
        }
    }
    wanted
}

/// Runs what the ledger does not have.
pub fn run(plan: &Plan, job: &Job, display: &Display) -> Result<Members, Error> {
    let ledger = Mutex::new(Ledger::<Member>::open(&job.out.join("members.jsonl"))?);
    let work = work_folder()?;
    let wanted = wanted(plan);
    let not_made: Mutex<BTreeMap<String, String>> = Mutex::default();
    let one = |index: usize| -> Result<(), Error> {
        let (method, realization) = wanted[index];
        let digest = method.digest();
        if lock(&ledger).member(&digest, realization).is_some() {
            return Ok(());
        }
        let folder = work.path().join(index.to_string());
        if !matches!(method.runner, Runner::Native(_)) {
            std::fs::create_dir(&folder).map_err(crate::files::failed("create", &folder))?;
        }
        match member::run(
            method,
            realization,
            &job.yade,
            job.brought.as_ref(),
            &folder,
        ) {
            Ok(member) => lock(&ledger).add(member)?,
            Err(EngineError::Yade(error @ (YadeError::Missing(_) | YadeError::TooOld { .. }))) => {
                lock(&not_made).insert(digest, error.to_string());
            }
            Err(EngineError::Exec(
                error @ (ExecError::Unsupported { .. } | ExecError::Refused(_)),
            )) => {
                lock(&not_made).insert(digest, error.to_string());
            }
            Err(error) => return Err(error.into()),
        }
        Ok(())
    };
    workers::all(wanted.len(), "realizations", display, one)?;
    let mut members = Members {
        not_made: std::mem::take(&mut lock(&not_made)),
        ..Members::default()
    };
    let ledger = lock(&ledger);
    for (method, realization) in wanted {
        if let Some(member) = ledger.member(&method.digest(), realization) {
            members.add(member.clone());
        }
    }
    Ok(members)
}
