//! What a specification gives on one cloud: the row of the studies that compare specifications. And beds that are loaded in
//! several settings: the settings of a bed pour alike, so it is poured once on each of its clouds.

use std::collections::BTreeMap;
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::folder::StudyFolder;
use super::realization::{
    self, Ending, Engines, LAWS, Realization, Runner, Setting, Specification, sound, went_wrong,
};
use super::{Judged, Outline, Study, StudyError};
use crate::engine::EngineError;
use crate::paper::published::{Of, Published};
use grains::generate::initial_bodies;
use grains::native;
use grains::native::timing::ThreadTime;
use grains::scene::Scene;
use grains::tables::StopReason;
use grains::task::Task;

/// One realization of a specification.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Member {
    /// Digest of the specification.
    pub specification: String,
    /// Which cloud.
    pub realization: u64,
    pub ending: Ending,
    pub pour_steps: u64,
    pub load_steps: u64,
    /// What it cost; none where its bed was poured for other loads too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cost: Option<Cost>,
    /// Digest of all bits of the last moment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loaded_state: Option<String>,
    /// The quantities that the study asks for, SI units; those of the loaded bed only where the force was reached.
    pub measured: BTreeMap<String, f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cost {
    /// Processor time from the scene to the measured numbers, s; of an engine in another process, also its own.
    pub cpu_seconds: f64,
    /// The part of it that went into measuring, s.
    pub measuring_seconds: f64,
}

/// Members by specification and realization.
#[derive(Debug, Default)]
pub struct Members(BTreeMap<(String, u64), Member>);

impl Members {
    pub fn get(&self, specification: &Specification, realization: u64) -> Option<&Member> {
        self.0.get(&(specification.digest(), realization))
    }

    /// Those of a setting that were made, by cloud.
    pub fn of(&self, setting: &Setting) -> Vec<&Member> {
        let digest = setting.specification.digest();
        let all = setting.realizations();
        all.filter_map(|realization| self.0.get(&(digest.clone(), realization)))
            .collect()
    }
}

impl FromIterator<Member> for Members {
    fn from_iter<T: IntoIterator<Item = Member>>(all: T) -> Self {
        let key = |member: &Member| (member.specification.clone(), member.realization);
        Members(
            all.into_iter()
                .map(|member| (key(&member), member))
                .collect(),
        )
    }
}

/// A measured quantity of all members that have it.
pub fn values(members: &[&Member], key: &str) -> Vec<f64> {
    let values = members.iter().filter_map(|member| member.measured.get(key));
    values.copied().collect()
}

/// Of a heap against the left wall, °.
pub const ANGLE: &str = "settled.angle";

/// Before the name of a point on the other side of the punch.
pub const MIRRORED: &str = "mirrored ";

impl Member {
    /// The quantity of a published figure; a mean beside the punch is that of both sides.
    pub fn published(&self, figure: &Published) -> Option<f64> {
        match figure.statistic {
            Of::Mean => self.of_both_sides(&figure.key),
            _ => self.measured.get(&figure.key).copied(),
        }
    }

    /// A stress at a point, the mean of both sides of the punch where both were measured.
    pub fn of_both_sides(&self, key: &str) -> Option<f64> {
        let own = *self.measured.get(key)?;
        let mirrored = key.replace("stress.", &format!("stress.{MIRRORED}"));
        let other = self.measured.get(&mirrored).filter(|_| mirrored != key);
        Some(other.map_or(own, |other| 0.5 * (own + other)))
    }

    /// Runs a realization from cloud to end and keeps these quantities. An engine that fails is a result; an interrupt, an
    /// engine that is missing and one that does not have what it takes are errors.
    pub fn run(
        specification: &Specification,
        realization: u64,
        engines: &Engines,
        work: &Path,
        keep: impl Fn(&str) -> bool,
    ) -> Result<Member, EngineError> {
        let clock = ThreadTime::now();
        let scene = specification.scene_of(realization);
        let run = match specification.run(realization, engines, work) {
            Ok(run) => run,
            Err(error) => {
                // That a YADE or an external engine breaks is a result.
                let reason = match error {
                    EngineError::Program(error) if error.is_failure() => error.to_string(),
                    error => went_wrong(error)?,
                };
                let mut cost = Cost::default();
                if specification.runner.is_native() {
                    cost.cpu_seconds = clock.elapsed().as_secs_f64();
                }
                return Ok(Member {
                    cost: Some(cost),
                    ..Member::without(specification, realization, Ending::Failed(reason))
                });
            }
        };
        let measuring = ThreadTime::now();
        let mut member = Member::measured(specification, &scene, &run, keep);
        member.cost = Some(Cost {
            cpu_seconds: clock.elapsed().as_secs_f64() + run.elsewhere,
            measuring_seconds: measuring.elapsed().as_secs_f64(),
        });
        Ok(member)
    }

    /// For a table, under the id of its setting.
    pub fn outline(&self, id: &str) -> Outline {
        let seconds = self.cost.map(|cost| cost.cpu_seconds.to_string());
        let cells = [
            ("setting", id.to_owned()),
            ("realization", self.realization.to_string()),
            ("ending", self.ending.name().to_owned()),
            ("pour_steps", self.pour_steps.to_string()),
            ("load_steps", self.load_steps.to_string()),
            ("cpu_seconds", seconds.unwrap_or_default()),
        ];
        Outline::new(self.ending.name(), cells, &self.measured)
    }

    fn measured(
        specification: &Specification,
        scene: &Scene,
        run: &Realization,
        keep: impl Fn(&str) -> bool,
    ) -> Self {
        let mut measured = realization::measured(scene, run);
        if let Some(settled) = run.outcome.settled.as_ref().filter(|_| keep(LAWS)) {
            measured.extend(realization::laws(scene, settled));
        }
        measured.retain(|key, _| keep(key));
        Member {
            pour_steps: run.pour_steps,
            load_steps: run.load_steps,
            loaded_state: Some(run.outcome.last.digest()),
            measured,
            ..Member::without(specification, scene.realization, run.ending.clone())
        }
    }

    /// One that gave nothing.
    pub fn without(specification: &Specification, realization: u64, ending: Ending) -> Self {
        Member {
            specification: specification.digest(),
            realization,
            ending,
            ..Member::default()
        }
    }
}

/// Members of settings that have one bed, on one cloud: it is poured once in the native engine, and their bits are those of whole
/// runs.
pub fn of_one_bed(
    settings: &[Setting],
    cloud: u64,
    keep: impl Fn(&str) -> bool + Copy,
) -> Result<Vec<Member>, EngineError> {
    let [first, ..] = settings else {
        return Ok(Vec::new());
    };
    let scene = realization::unobserved(&first.specification.scene_of(cloud));
    let task = Task::settle(initial_bodies(&scene));
    let poured = match native::run(&scene, &task, &native::Options::default(), &mut ()) {
        Ok(outcome) => match outcome.stages.last().map(|stage| stage.stop) {
            Some(StopReason::Settled) => Ok(outcome.last),
            _ => Err(Ending::NotSettled),
        },
        Err(error) => Err(Ending::Failed(went_wrong(EngineError::Native(error))?)),
    };
    let load = |setting: &Setting| {
        let specification = &setting.specification;
        let scene = specification.scene_of(cloud);
        let loaded = poured.as_ref();
        let ending = match loaded.map(|bed| realization::loaded(&scene, bed, true)) {
            Ok(Ok(run)) => return Ok(Member::measured(specification, &scene, &run, keep)),
            Ok(Err(error)) => Ending::Failed(went_wrong(EngineError::Native(error))?),
            Err(ending) => ending.clone(),
        };
        Ok(Member::without(specification, cloud, ending))
    };
    settings.iter().map(load).collect()
}

#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Endings {
    pub reached: usize,
    pub target_load_not_reached: usize,
    pub not_settled: usize,
    /// Settled in an engine without a punch: these count for the bed, not for the force.
    #[serde(default)]
    pub poured: usize,
    /// The engine gave up: in which words, how often.
    pub failed: BTreeMap<String, usize>,
}

impl Endings {
    pub fn of<'a>(all: impl IntoIterator<Item = &'a Member>) -> Self {
        let mut endings = Endings::default();
        for member in all {
            match &member.ending {
                Ending::Reached => endings.reached += 1,
                Ending::TargetLoadNotReached => endings.target_load_not_reached += 1,
                Ending::NotSettled => endings.not_settled += 1,
                Ending::Poured => endings.poured += 1,
                Ending::Failed(reason) => {
                    *endings.failed.entry(without_numbers(reason)).or_default() += 1;
                }
            }
        }
        endings
    }

    /// All members with a punch.
    pub fn all(&self) -> usize {
        self.reached + self.missed()
    }

    /// Members without the force.
    pub fn missed(&self) -> usize {
        self.target_load_not_reached + self.not_settled + self.failed.values().sum::<usize>()
    }

    /// What went wrong, in words.
    pub fn remarks(&self) -> impl Iterator<Item = String> {
        let failed = self.failed.iter();
        let failed = failed.map(|(reason, count)| format!("{count} failed: {reason}"));
        let loose = self.not_settled;
        failed.chain((loose > 0).then(|| format!("{loose} did not settle")))
    }
}

/// The step and the grain are another in every cloud: one mark for each number.
fn without_numbers(words: &str) -> String {
    let mut text = String::new();
    for letter in words.chars() {
        match letter {
            '0'..='9' if text.ends_with('#') => {}
            '0'..='9' => text.push('#'),
            letter => text.push(letter),
        }
    }
    text.replace("#.#", "#").replace("-#", "#")
}

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
        first.map_or(0, |setting| setting.realizations().count() as u64)
    }

    /// What is wrong with beds that may have been read from a file.
    pub fn check(&self) -> Result<(), String> {
        if self.0.iter().any(Vec::is_empty) {
            return Err("a bed has no loads".to_owned());
        }
        sound(self.settings())?;
        let clouds = self.clouds();
        let as_many = |setting: &Setting| {
            setting.clouds.len() == 1 && setting.realizations().count() as u64 == clouds
        };
        if !self.settings().all(as_many) {
            return Err("beds have different numbers of clouds".to_owned());
        }
        for bed in &self.0 {
            let first = &bed[0];
            let pours_like =
                |setting: &Setting| setting.specification.pours_like(&first.specification);
            let other = |setting: &&Setting| setting.clouds != first.clouds || !pours_like(setting);
            if let Some(other) = bed.iter().find(other) {
                let (other, first) = (&other.id, &first.id);
                return Err(format!("{other} does not load the beds of {first}"));
            }
        }
        Ok(())
    }
}

/// A study of beds and their loads: a task is a bed on a cloud, its row the members of all of its loads.
pub trait OfBeds: Serialize + DeserializeOwned + Sync {
    /// As [`Study::KIND`].
    const NAME: &'static str;

    fn beds(&self) -> &Beds;

    /// What is wrong besides the beds.
    fn is_whole(&self) -> Result<(), String>;

    /// Whether a quantity stays in the rows.
    fn keeps(key: &str) -> bool;

    fn judged(&self, members: &Members) -> Result<Judged, StudyError>;
}

/// The bed of a task and its cloud; the first clouds of all beds come first.
fn bed_of(beds: &Beds, task: u64) -> (&[Setting], u64) {
    let (count, task) = (beds.0.len() as u64, task - 1);
    let bed = &beds.0[(task % count) as usize];
    (bed, bed[0].clouds[0][0] + task / count)
}

impl<P: OfBeds> Study for P {
    const KIND: &'static str = P::NAME;
    type Row = Vec<Member>;

    fn count(&self) -> u64 {
        self.beds().0.len() as u64 * self.beds().clouds()
    }

    fn check(&self) -> Result<(), String> {
        self.is_whole()?;
        self.beds().check()
    }

    fn runner(&self, _: u64) -> Runner {
        Runner::Native
    }

    fn identity(&self, task: u64) -> String {
        let (bed, cloud) = bed_of(self.beds(), task);
        let all = bed.iter().map(|setting| setting.specification.digest());
        format!("{} {cloud}", all.collect::<Vec<String>>().join(" "))
    }

    fn run(&self, task: u64, _: &Engines, _: &Path) -> Result<Vec<Member>, EngineError> {
        let (bed, cloud) = bed_of(self.beds(), task);
        of_one_bed(bed, cloud, P::keeps)
    }

    fn belongs(&self, task: u64, row: &Vec<Member>) -> bool {
        let (bed, cloud) = bed_of(self.beds(), task);
        let own = bed.iter().map(|setting| setting.specification.digest());
        own.eq(row.iter().map(|member| member.specification.clone()))
            && row.iter().all(|member| member.realization == cloud)
    }

    fn outline(&self, row: &Vec<Member>) -> Outline {
        let cloud = row.first().map_or(0, |member| member.realization);
        let cells = [
            ("realization", cloud.to_string()),
            ("loads", row.len().to_string()),
        ];
        Outline::new("loaded", cells, &BTreeMap::new())
    }

    fn judge(folder: &StudyFolder<Self>) -> Result<Judged, StudyError> {
        let members = folder.rows()?.into_iter().flatten().collect();
        folder.plan.study.judged(&members)
    }
}
