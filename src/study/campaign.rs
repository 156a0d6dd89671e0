//! Campaigns: many realizations of one scene in one engine.

pub mod compare;

use std::collections::BTreeMap;
use std::path::Path;

use crate::document::{Cell, Document, Section, Table};
use crate::engine::EngineError;
use crate::study::folder::StudyFolder;
use crate::study::realization::{
    Ending, Engines, Runner, Specification, bed_of, ending_in_words, measured, went_wrong,
};
use crate::study::{Judged, Outline, Study, StudyError};
use grains::measure::neighbourhood::Neighbourhood;
use grains::measure::{self, cells, neighbourhood, stress};
use grains::native::pouring::Phase;
use grains::scene::Scene;
use grains::tables::Snapshot;
use serde::{Deserialize, Serialize};
use serde_json::json;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Campaign {
    pub runner: Runner,
    /// Pouring part by part, where the scene's own stages are not used.
    pub phases: Vec<Phase>,
    pub members: u64,
    /// Realization of member 1; member k pours realization `seed + k − 1`, whoever runs it.
    pub seed: u64,
    pub scene_digest: String,
    /// The scene; its own realization has no meaning here.
    pub scene: Scene,
}

pub type Merged = super::folder::Merged<Campaign>;

/// Reads a merged campaign and checks its bytes and members against summary and plan.
pub fn merged(folder: &Path) -> Result<Merged, StudyError> {
    StudyFolder::<Campaign>::open(folder)?.merged()
}

impl Campaign {
    pub fn new(scene: &Scene, runner: Runner, phases: Vec<Phase>, members: u64, seed: u64) -> Self {
        let mut scene = scene.clone();
        scene.realization = seed;
        Campaign {
            runner,
            phases,
            members,
            seed,
            scene_digest: scene.digest(),
            scene,
        }
    }

    /// Which cloud a member pours; members are counted from 1.
    pub fn realization(&self, member: u64) -> u64 {
        self.seed + (member - 1)
    }
}

impl Study for Campaign {
    const KIND: &'static str = "campaign";
    type Row = Member;

    fn count(&self) -> u64 {
        self.members
    }

    fn check(&self) -> Result<(), String> {
        if self.seed.checked_add(self.members).is_none() {
            let Campaign { seed, members, .. } = self;
            return Err(format!("seed {seed} leaves no room for {members} members"));
        }
        // What a scene must fulfil is checked where scenes are read.
        self.scene.check().map_err(|error| error.to_string())?;
        if self.scene.digest() != self.scene_digest {
            return Err("the scene is not the one that was planned".to_owned());
        }
        Ok(())
    }

    fn runner(&self, _: u64) -> Runner {
        self.runner
    }

    fn in_space(&self) -> bool {
        self.scene.in_space()
    }

    fn identity(&self, task: u64) -> String {
        // The seed in the scene is that of member 1.
        let phases = serde_json::to_string(&self.phases).expect("phases are JSON");
        let mut scene = self.scene.clone();
        scene.realization = self.realization(task);
        format!("{task} {} {phases} {}", self.runner.name(), scene.digest())
    }

    /// What goes wrong in a realization is a member too; an interrupt, a missing or broken YADE and a full disk are errors.
    fn run(&self, task: u64, engines: &Engines, work: &Path) -> Result<Member, EngineError> {
        let specification = Specification {
            scene: self.scene.clone(),
            runner: self.runner,
            phases: self.phases.clone(),
            program: None,
        };
        let realization = self.realization(task);
        let member = Member {
            member: task,
            realization,
            ..Member::default()
        };
        let run = match specification.run(realization, engines, work) {
            Ok(run) => run,
            Err(error) => {
                let ending = Ending::Failed(went_wrong(error)?);
                return Ok(Member { ending, ..member });
            }
        };
        let scene = &specification.scene_of(realization);
        let settled = run.outcome.settled.as_ref();
        let planar = settled.filter(|_| !scene.in_space());
        let surface = planar.map(|settled| measure::surface(scene, &settled.bodies));
        let fields = |snapshot: &Snapshot| surface.map(|surface| fields(scene, snapshot, surface));
        let last = &run.outcome.last;
        let reached = run.ending == Ending::Reached;
        Ok(Member {
            settled_state: settled.map(Snapshot::digest),
            loaded_state: Some(last.digest()),
            measured: measured(scene, &run),
            settled: settled.and_then(fields),
            loaded: reached.then(|| fields(last)).flatten(),
            pour_steps: run.pour_steps,
            load_steps: run.load_steps,
            engine: run.engine,
            ending: run.ending,
            ..member
        })
    }

    fn belongs(&self, task: u64, row: &Member) -> bool {
        row.member == task && row.realization == self.realization(task)
    }

    fn outline(&self, row: &Member) -> Outline {
        let cells = [
            ("member", row.member.to_string()),
            ("realization", row.realization.to_string()),
            ("ending", row.ending.name().to_owned()),
            ("pour_steps", row.pour_steps.to_string()),
            ("load_steps", row.load_steps.to_string()),
        ];
        Outline {
            // An engine that gave up has not told its name.
            engine: (!row.engine.is_empty()).then(|| row.engine.clone()),
            ..Outline::new(row.ending.name(), cells, &row.measured)
        }
    }

    fn judge(folder: &StudyFolder<Self>) -> Result<Judged, StudyError> {
        let mut endings: BTreeMap<&'static str, u64> = BTreeMap::new();
        let mut measured: BTreeMap<String, Sums> = BTreeMap::new();
        folder.each(|_, row| {
            *endings.entry(row.ending.name()).or_default() += 1;
            for (key, value) in row.measured {
                measured.entry(key).or_default().add(value);
            }
        })?;
        let of_endings = Table::of("endings", "How the members ended", &endings)
            .column("ending", |(ending, _)| ending_in_words(ending))
            .column("members", |(_, count)| *count);
        let title = "Every measured quantity over the members that have it";
        let table = Table::of("measured", title, &measured)
            .column("quantity", |(key, _)| Cell::Code(key.clone()))
            .column("members", |(_, sums)| sums.count)
            .column("mean, SI", |(_, sums)| sums.mean)
            .column("standard deviation, SI", |(_, sums)| {
                (sums.count > 1).then(|| sums.deviation())
            });
        let study = &folder.plan.study;
        let answer = format!(
            "{} of {} realizations of {:?} in {}, from {} to {}.",
            endings.values().sum::<u64>(),
            study.members,
            study.scene.name,
            study.runner.name(),
            study.seed,
            study.realization(study.members)
        );
        let digest = &study.scene_digest;
        let own = json!({"scene_digest": digest, "endings": endings, "quantities": measured});
        let document = Document::new("Campaign", answer, Vec::new()).with([
            Section::new("Endings", "").with(of_endings),
            Section::new("Quantities", "").with(table),
        ]);
        Judged::of(Self::KIND, &own, document)
    }
}

/// Mean and deviation of values that are not kept (Welford 1962).
#[derive(Debug, Clone, Copy, Default, Serialize)]
struct Sums {
    count: u64,
    mean: f64,
    /// Sum of squares about the mean.
    squares: f64,
}

impl Sums {
    fn add(&mut self, value: f64) {
        self.count += 1;
        let before = value - self.mean;
        self.mean += before / self.count as f64;
        self.squares += before * (value - self.mean);
    }

    /// Of the sample; not a number for one value.
    fn deviation(&self) -> f64 {
        (self.squares / (self.count as f64 - 1.0)).sqrt()
    }
}

/// What one realization gave; nothing in it depends on when, where or beside whom it was run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Member {
    pub member: u64,
    pub realization: u64,
    /// Engine and version; empty where the engine gave up.
    pub engine: String,
    pub ending: Ending,
    pub pour_steps: u64,
    pub load_steps: u64,
    /// Digest of all bits of the settled bed, its contacts included.
    pub settled_state: Option<String>,
    /// The same of the last moment, punch included.
    pub loaded_state: Option<String>,
    pub measured: BTreeMap<String, f64>,
    /// Around the control points under gravity alone; none where the bed did not settle, and in space.
    pub settled: Option<Fields>,
    /// Around the control points when the force is reached; none where it was not, and in space.
    pub loaded: Option<Fields>,
}

/// Stresses of one moment around the control points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fields {
    /// [`stress::across`] at the depth of the first control point.
    pub across: Vec<f64>,
    pub down: Vec<f64>,
    /// In the order of the scene's control points; a point that is not inside the bed has none.
    pub points: Vec<Neighbourhood>,
}

fn fields(scene: &Scene, snapshot: &Snapshot, surface: f64) -> Fields {
    let bed = bed_of(snapshot);
    let cells = cells::of(scene, bed.bodies);
    let extensive = stress::of_grains(bed);
    let places = scene.control_points.iter().map(|point| {
        let place = [scene.punch_axis() + point.offset, surface - point.depth];
        (point, place)
    });
    let inside = places.filter(|(_, place)| place[1] > 0.0);
    let first = scene.control_points.first();
    let depth = first.map_or(0.0, |point| point.depth);
    Fields {
        across: stress::across(scene, bed, &cells, &extensive, surface - depth),
        down: stress::down(scene, bed, &cells, &extensive, surface),
        points: inside
            .map(|(point, place)| neighbourhood::of(&point.name, place, bed, &cells, &extensive))
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::Sums;

    #[test]
    fn sums_have_the_mean_and_the_deviation_of_the_values() {
        let mut sums = Sums::default();
        for value in [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0] {
            sums.add(value);
        }
        assert!((sums.mean - 5.0).abs() < 1.0e-15);
        assert!((sums.deviation() - (32.0f64 / 7.0).sqrt()).abs() < 1.0e-15);
    }
}
