//! Running a shard: the members that no record has yet, on so many threads, each written down when it is finished.

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

use super::CampaignError;
use super::member::{self, Member};
use super::plan::Plan;
use super::records::{Damaged, Index, Writer};
use super::shard::Shard;
use crate::engine::yade::{self, YadeError};
use crate::files::{failed, work_folder};
use crate::interrupt::asked_to_end;
use crate::progress::Display;
use crate::run::EngineError;
use crate::study::realization::Way;

/// What one process is to do.
#[derive(Debug, Clone)]
pub struct Job<'a> {
    /// The campaign.
    pub folder: &'a Path,
    /// Its members.
    pub shard: Shard,
    /// Members at a time.
    pub threads: usize,
    /// How YADE is started, where the plan has it.
    pub yade: &'a yade::Options,
}

/// What it did.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Done {
    /// Members of the shard.
    pub wanted: u64,
    /// How many of them had been finished before.
    pub before: u64,
    /// Whether no member of the whole campaign is missing now.
    pub complete: bool,
    /// Lines in record files that are not believed.
    pub damaged: Vec<Damaged>,
}

/// Runs what is missing of the shard.
pub fn run(job: &Job<'_>, display: &Display) -> Result<Done, CampaignError> {
    let plan = Plan::read(job.folder)?;
    plan.check_version(job.folder)?;
    let digest = plan.digest();
    // Before the records are read: nothing can be added to this file afterwards by anyone else.
    let writer = Writer::open(job.folder, job.shard)?;
    let index = Index::read(job.folder, &digest, plan.members)?;
    let missing: Vec<u64> = job
        .shard
        .members(plan.members)
        .filter(|member| !index.places.contains_key(member))
        .collect();
    let wanted = job.shard.members(plan.members).count() as u64;
    let before = wanted - missing.len() as u64;
    for damaged in &index.damaged {
        display.line(&format!(
            "{} line {} is no whole record and is not believed; its member is run again",
            damaged.path.display(),
            damaged.line
        ));
    }
    let work = Work {
        plan: &plan,
        digest: &digest,
        job,
        missing: &missing,
        writer: Mutex::new(writer),
        next: AtomicUsize::new(0),
        finished: AtomicUsize::new(0),
        stop: AtomicBool::new(false),
        failure: Mutex::default(),
        engine_failures: Mutex::default(),
    };
    work.run(display)?;
    let finished = before + work.finished.load(Ordering::Relaxed) as u64;
    if let Some(error) = take(&work.failure) {
        return Err(error);
    }
    if asked_to_end() && finished < wanted {
        return Err(CampaignError::Interrupted { finished, wanted });
    }
    let mut broken = take(&work.engine_failures);
    if let Some((_, first)) = broken.first().cloned() {
        broken.sort_unstable();
        let members: Vec<u64> = broken.iter().map(|(member, _)| *member).collect();
        return Err(CampaignError::EnginesFailed {
            finished,
            members: in_words(&members),
            first,
        });
    }
    let now = index.places.len() + work.finished.load(Ordering::Relaxed);
    Ok(Done {
        wanted,
        before,
        complete: now as u64 == plan.members,
        damaged: index.damaged,
    })
}

struct Work<'a> {
    plan: &'a Plan,
    digest: &'a str,
    job: &'a Job<'a>,
    missing: &'a [u64],
    writer: Mutex<Writer>,
    next: AtomicUsize,
    finished: AtomicUsize,
    stop: AtomicBool,
    failure: Mutex<Option<CampaignError>>,
    engine_failures: Mutex<Vec<(u64, String)>>,
}

impl Work<'_> {
    fn run(&self, display: &Display) -> Result<(), CampaignError> {
        if self.missing.is_empty() {
            return Ok(());
        }
        let folder = work_folder()?;
        let began = Instant::now();
        let task = display.task(&format!("members, shard {}", self.job.shard));
        let worker = || {
            while let Some(member) = self.take_one() {
                match self.one(member, folder.path()) {
                    Ok(true) => {
                        let finished = self.finished.fetch_add(1, Ordering::Relaxed) + 1;
                        let an_hour = finished as f64 / began.elapsed().as_secs_f64() * 3600.0;
                        let wanted = self.missing.len();
                        let share = finished as f64 / wanted as f64;
                        task.share(
                            share,
                            &format!("{finished} of {wanted}, {an_hour:.0} an hour"),
                        );
                    }
                    Ok(false) => {}
                    Err(error) => {
                        self.stop.store(true, Ordering::Relaxed);
                        locked(&self.failure).get_or_insert(error);
                    }
                }
            }
        };
        std::thread::scope(|scope| {
            for _ in 0..self.job.threads.clamp(1, self.missing.len()) {
                scope.spawn(worker);
            }
        });
        let finished = self.finished.load(Ordering::Relaxed);
        let an_hour = finished as f64 / began.elapsed().as_secs_f64() * 3600.0;
        task.done(&format!(
            "{finished} of {} written down, {an_hour:.0} an hour,",
            self.missing.len()
        ));
        Ok(())
    }

    fn take_one(&self) -> Option<u64> {
        if self.stop.load(Ordering::Relaxed) || asked_to_end() {
            return None;
        }
        let index = self.next.fetch_add(1, Ordering::Relaxed);
        self.missing.get(index).copied()
    }

    /// Whether the member is written down now.
    fn one(&self, member: u64, folder: &Path) -> Result<bool, CampaignError> {
        let work = folder.join(member.to_string());
        if self.plan.runner.is_yade() {
            std::fs::create_dir(&work).map_err(failed("create", &work))?;
        }
        let made = self.make(member, &work);
        if self.plan.runner.is_yade() {
            // The tables of a run are large, and nobody looks at them again; what stays goes with the folder.
            let _ = std::fs::remove_dir_all(&work);
        }
        let made = match made {
            Ok(made) => made,
            Err(_) if asked_to_end() => return Ok(false),
            // Another member may fare better, and this one another time.
            Err(EngineError::Yade(
                error @ (YadeError::Crashed { .. }
                | YadeError::Hung { .. }
                | YadeError::TooMuch { .. }
                | YadeError::Nonsense(_)),
            )) => {
                locked(&self.engine_failures).push((member, error.to_string()));
                return Ok(false);
            }
            Err(error) => return Err(error.into()),
        };
        locked(&self.writer).add(self.digest, &made)?;
        Ok(true)
    }

    fn make(&self, member: u64, work: &Path) -> Result<Member, EngineError> {
        let way = Way {
            runner: self.plan.runner,
            phases: &self.plan.phases,
            yade: self.job.yade,
            brought: None,
            work,
        };
        member::run(
            member,
            self.plan.realization(member),
            &self.plan.scene,
            &way,
        )
    }
}

/// The member, run anew outside of any campaign: what a record must be equal to.
pub fn again(plan: &Plan, member: u64) -> Result<Member, CampaignError> {
    let work = work_folder()?;
    let way = Way {
        runner: plan.runner,
        phases: &plan.phases,
        yade: &yade::Options::default(),
        brought: None,
        work: work.path(),
    };
    Ok(member::run(
        member,
        plan.realization(member),
        &plan.scene,
        &way,
    )?)
}

/// Numbers for people: the first few, and how many more.
pub fn in_words(members: &[u64]) -> String {
    const SHOWN: usize = 8;
    let shown: Vec<String> = members.iter().take(SHOWN).map(u64::to_string).collect();
    let mut text = shown.join(", ");
    if members.len() > SHOWN {
        text += &format!(" and {} more", members.len() - SHOWN);
    }
    text
}

/// A worker that panicked left nothing half done behind.
fn locked<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}

fn take<T: Default>(mutex: &Mutex<T>) -> T {
    std::mem::take(&mut *locked(mutex))
}
