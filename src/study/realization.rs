//! A run specification, and one realization of it, from the poured cloud to the loaded bed, in any engine.

use std::collections::BTreeMap;
use std::path::Path;

use crate::engine::exec::ExternalEngine;
use crate::engine::{Engine, Part, ProgramError, yade};
use crate::files::sha256_hex;
use crate::run::EngineError;
use crate::study::change::{GRAINS, What, changed};
use evidence::distribution::{self, Family};
use evidence::moments;
use grains::generate::initial_bodies;
use grains::measure::{self, Bed, stress};
use grains::native;
use grains::native::pouring::{Phase, Softly};
use grains::native::{NativeError, Trouble};
use grains::scene::{Scene, paper_scene};
use grains::tables::{Bodies, Snapshot, Stage, StopReason};
use grains::task::{Outcome, Task, Until};
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// Settled, and the punch got its force.
    Reached,
    /// Settled; the punch went to the give-up depth without the force.
    TargetLoadNotReached,
    /// Not settled within the scene's steps.
    #[default]
    NotSettled,
    /// Settled, in an engine that has no punch: nobody asked for more.
    Poured,
    Failed(String),
}

impl Ending {
    /// The word for it in records.
    pub fn name(&self) -> &'static str {
        match self {
            Ending::Reached => "reached",
            Ending::TargetLoadNotReached => "target_load_not_reached",
            Ending::NotSettled => "not_settled",
            Ending::Poured => "poured",
            Ending::Failed(_) => "failed",
        }
    }
}

/// For people, by its name in records; a study that loads beds in several ways counts those.
pub fn ending_in_words(name: &str) -> &str {
    match name.replace(' ', "_").as_str() {
        "reached" => "got the force on the punch",
        "target_load_not_reached" => "did not get the force on the punch",
        "not_settled" => "did not settle",
        "poured" => "settled, in an engine without a punch",
        "failed" => "ended by an error of the engine",
        "loaded" => "beds loaded in all of their settings",
        _ => name,
    }
}

/// Who runs it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Runner {
    /// In records `{"native": "exact"}`: with YADE's bits.
    #[serde(with = "exact")]
    Native,
    /// YADE's ordinary loop, as it is usually run.
    YadeOrdinary,
    /// YADE's loop over sorted interactions, which has the native engine's bits.
    YadeSorted,
    External,
}

impl Runner {
    /// For people and in job files: `native`, `yade-ordinary`.
    pub fn name(self) -> &'static str {
        match self {
            Runner::Native => "native",
            Runner::YadeOrdinary => "yade-ordinary",
            Runner::YadeSorted => "yade-sorted",
            Runner::External => "exec",
        }
    }

    pub fn is_native(self) -> bool {
        self == Runner::Native
    }

    /// Whether YADE is needed.
    pub fn is_yade(self) -> bool {
        matches!(self, Runner::YadeOrdinary | Runner::YadeSorted)
    }
}

/// The form of [`Runner::Native`] in records.
mod exact {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Bits {
        Exact,
    }

    pub fn serialize<S: Serializer>(to: S) -> Result<S::Ok, S::Error> {
        Bits::Exact.serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<(), D::Error> {
        Bits::deserialize(from).map(|Bits::Exact| ())
    }
}

/// How engines that are other programs are started.
#[derive(Debug, Clone, Default)]
pub struct Engines {
    pub yade: yade::Options,
    pub external: Option<ExternalEngine>,
}

impl Engines {
    pub fn engine(&self, runner: Runner) -> Result<Box<dyn Engine>, ProgramError> {
        Ok(match runner {
            Runner::Native => Box::new(native::Options::default()),
            Runner::YadeOrdinary | Runner::YadeSorted => Box::new(yade::Options {
                sorted: runner == Runner::YadeSorted,
                ..self.yade.clone()
            }),
            Runner::External => Box::new(self.external()?.clone()),
        })
    }

    /// The external engine, which must have been named.
    pub fn external(&self) -> Result<&ExternalEngine, ProgramError> {
        let missing = || ProgramError::NotStarted {
            path: "exec:PATH".into(),
            reason: "it was not named".to_owned(),
        };
        self.external.as_ref().ok_or_else(missing)
    }
}

#[derive(Debug)]
pub struct Realization {
    pub outcome: Outcome,
    /// [`Ending::Reached`], [`Ending::TargetLoadNotReached`] or [`Ending::NotSettled`].
    pub ending: Ending,
    pub pour_steps: u64,
    pub load_steps: u64,
    /// Processor time of an engine in another process, s.
    pub elsewhere: f64,
    pub engine: String,
}

impl Specification {
    /// Runs a realization; `work` is an empty folder for an engine that is another program.
    pub fn run(
        &self,
        realization: u64,
        engines: &Engines,
        work: &Path,
    ) -> Result<Realization, EngineError> {
        let scene = unobserved(&self.scene_of(realization));
        let engine = engines.engine(self.runner)?;
        let initial = initial_bodies(&scene);
        if let Some(options) = engine.native().filter(|_| !self.phases.is_empty())
            && let Some(poured) =
                native::pouring::pour(&scene, &self.phases, options, initial.clone())?
        {
            return Ok(Realization {
                pour_steps: poured.steps,
                ..loaded(&scene, &poured.bed, poured.settled)?
            });
        }
        whole_in(engine.as_ref(), &scene, initial, work)
    }
}

/// The scene without a history, at which nobody looks.
pub fn unobserved(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.measurement.history_every = 1_000_000_000;
    scene
}

/// Pours and loads. An engine that has everything but a punch pours and settles.
fn whole_in(
    engine: &dyn Engine,
    scene: &Scene,
    initial: Bodies,
    work: &Path,
) -> Result<Realization, EngineError> {
    let mut task = Task::whole(initial);
    let only_poured = engine.lacks(scene, &task) == Some(Part::Punch.in_words());
    if only_poured {
        task.until = Until::EndOfSettling;
    }
    let run = engine.run(scene, &task, work, &mut ())?;
    let elsewhere = run.elsewhere();
    let mut made = whole(run.outcome, elsewhere, run.engine.program());
    if only_poured && made.ending != Ending::NotSettled {
        made.ending = Ending::Poured;
        made.outcome.settled = Some(made.outcome.last.clone());
    }
    Ok(made)
}

/// The words of an engine for which the realization itself went wrong, as numbers that are not finite or grains that
/// left the box; any other failure – an interrupt, a missing or broken YADE, a full disk – is handed back.
pub fn went_wrong(error: EngineError) -> Result<String, EngineError> {
    match error {
        EngineError::Native(error) if error.trouble != Trouble::Interrupted => {
            Ok(error.to_string())
        }
        EngineError::Program(error @ ProgramError::WentWrong { .. }) => Ok(error.to_string()),
        error => Err(error),
    }
}

/// Loads a bed that was poured before, in the native engine, with the bits of the whole run; a bed that has not `settled`
/// is none to judge by.
pub fn loaded(scene: &Scene, bed: &Snapshot, settled: bool) -> Result<Realization, NativeError> {
    let scene = &unobserved(scene);
    let (task, options) = (Task::load(bed.clone()), native::Options::default());
    let mut outcome = native::run(scene, &task, &options, &mut ())?;
    outcome.settled = Some(bed.clone());
    Ok(Realization {
        ending: ending(&outcome, !settled),
        pour_steps: bed.step,
        ..whole(outcome, 0.0, native_engine())
    })
}

fn native_engine() -> String {
    format!("native {}", env!("CARGO_PKG_VERSION"))
}

fn whole(outcome: Outcome, elsewhere: f64, engine: String) -> Realization {
    let mut pouring = outcome.stages.iter();
    let unsettled =
        pouring.any(|stage| stage.stage == Stage::Settle && stage.stop != StopReason::Settled);
    Realization {
        ending: ending(&outcome, unsettled),
        pour_steps: steps_of(&outcome, Stage::Settle),
        load_steps: steps_of(&outcome, Stage::Load),
        elsewhere,
        engine,
        outcome,
    }
}

fn steps_of(outcome: &Outcome, wanted: Stage) -> u64 {
    let stages = outcome.stages.iter();
    let steps = stages.filter(|stage| stage.stage == wanted);
    steps.map(|stage| stage.steps).sum()
}

fn ending(outcome: &Outcome, unsettled: bool) -> Ending {
    match outcome.stages.last().map(|stage| stage.stop) {
        _ if unsettled => Ending::NotSettled,
        Some(StopReason::Reached) => Ending::Reached,
        _ => Ending::TargetLoadNotReached,
    }
}

/// Every measured number of a realization by its key, SI units: those of [`measure::all`], the shape of the settled
/// bed's stresses (`settled.distribution.*`), what the floor bears, and the punch's depth and force. Those of the last moment only where
/// the force was reached, none of a bed that did not settle.
pub fn measured(scene: &Scene, realization: &Realization) -> BTreeMap<String, f64> {
    let outcome = &realization.outcome;
    let Some(settled) = &outcome.settled else {
        return BTreeMap::new();
    };
    let (settled_bed, last_bed) = (bed_of(settled), bed_of(&outcome.last));
    let all = measure::all(scene, Some(settled_bed), last_bed).into_iter();
    let mut measured: BTreeMap<String, f64> =
        all.map(|quantity| (quantity.key, quantity.value)).collect();
    // Layers are at depths of the paper's bed.
    let layer = match scene.in_space() {
        true => Vec::new(),
        false => {
            let surface = measure::surface(scene, &settled.bodies);
            stress::over_depth(scene, settled_bed, surface, stress::LAYERS[0])
        }
    };
    let shapes = [
        ("variation", Some(moments::coefficient_of_variation(&layer))),
        ("above_two_means", Some(moments::share_above(&layer, 2.0))),
        ("gamma_shape", distribution::gamma_shape(&layer)),
        ("weibull_shape", distribution::weibull_shape(&layer)),
    ];
    let shapes = shapes.into_iter().filter_map(|(name, value)| {
        let key = format!("settled.distribution.{name}");
        value.map(|value| (key, value))
    });
    measured.extend(shapes);
    let mut insert = |key: &str, value: f64| measured.insert(key.to_owned(), value);
    let by_floor = |bed, load| measure::borne_by_floor(scene, bed, load);
    insert("settled.support.by_floor", by_floor(settled_bed, 0.0));
    if let Some(punch) = &outcome.last.punch {
        insert("loaded.punch.depth", punch.depth());
        insert("loaded.punch.force", punch.force);
        insert("loaded.support.by_floor", by_floor(last_bed, punch.force));
    }
    let reached = realization.ending == Ending::Reached;
    measured.retain(|key, value| (reached || !key.starts_with("loaded.")) && value.is_finite());
    measured
}

/// Before the keys of [`laws`].
pub const LAWS: &str = "settled.laws.";

/// The key of a law in a layer about this depth, m.
pub fn law_key(layer: f64, family: Family) -> String {
    format!("{LAWS}{layer}.{family:?}")
}

/// How well laws describe the grains that bear load in each layer of the settled bed: the mean logarithm of the density of a
/// stress over the layer's mean, under the likeliest law of each family.
pub fn laws(scene: &Scene, settled: &Snapshot) -> BTreeMap<String, f64> {
    let surface = measure::surface(scene, &settled.bodies);
    let mut found = BTreeMap::new();
    for layer in stress::LAYERS {
        let mut stress = stress::over_depth(scene, bed_of(settled), surface, layer);
        stress.retain(|value| *value > 0.0);
        let unit = moments::mean(&stress);
        stress.iter_mut().for_each(|value| *value /= unit);
        for family in Family::OF_STRESSES {
            if let Some(law) = family.fit(&stress) {
                let density = law.log_likelihood(&stress) / stress.len() as f64;
                found.insert(law_key(layer, family), density);
            }
        }
    }
    found
}

pub fn bed_of(snapshot: &Snapshot) -> Bed<'_> {
    Bed {
        bodies: &snapshot.bodies,
        contacts: &snapshot.contacts,
        across: &snapshot.across,
    }
}

/// Everything that the numbers of a run depend on, but its realization.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Specification {
    /// The scene of loading and measuring, and of pouring where there are no phases; its realization is replaced.
    pub scene: Scene,
    pub runner: Runner,
    /// Pouring, part by part; without any the scene's own stages and rules are used.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub phases: Vec<Phase>,
    /// SHA-256 of the file of the external engine, for its runner.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub program: Option<String>,
}

impl Specification {
    /// The scene by its own rules in the native engine.
    pub fn native(scene: Scene) -> Self {
        Specification {
            scene,
            runner: Runner::Native,
            phases: Vec::new(),
            program: None,
        }
    }

    /// The scene poured softly in the native engine.
    pub fn soft(scene: &Scene, softly: &Softly) -> Self {
        let longer = changed(scene.clone(), &[(What::Step, softly.step)]);
        Specification {
            phases: softly.phases(scene),
            ..Specification::native(longer)
        }
    }

    /// The first 64 bits of SHA-256, in hexadecimal. Specifications of one digest give the same members.
    pub fn digest(&self) -> String {
        let specification = Specification {
            scene: self.scene_of(0),
            ..self.clone()
        };
        let text = serde_json::to_string(&specification).expect("a specification is JSON");
        sha256_hex(text.as_bytes())[..16].to_owned()
    }

    /// Whether it loads the same beds.
    pub fn pours_like(&self, other: &Specification) -> bool {
        let scene = other.scene.clone();
        let same_but_scene = Specification {
            scene,
            ..self.clone()
        };
        same_but_scene == *other && self.scene.pours_like(&other.scene)
    }

    pub fn scene_of(&self, realization: u64) -> Scene {
        Scene {
            realization,
            ..self.scene.clone()
        }
    }
}

/// Of one range of a setting.
const MOST_CLOUDS: u64 = 1_000_000;

/// A specification among those that a study compares.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setting {
    /// Lasting, and unique in its study: `step-0.65`.
    pub id: String,
    pub name: String,
    /// What is varied: `time step`.
    pub axis: String,
    /// Its place on the axis, and on the second of a crossed axis, in the units of the name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub at: Vec<f64>,
    pub specification: Specification,
    /// Realizations: first and last of each range.
    pub clouds: Vec<[u64; 2]>,
}

impl Setting {
    /// The specification on clouds from 1 on.
    pub fn new(
        id: &str,
        name: &str,
        axis: &str,
        specification: Specification,
        clouds: u64,
    ) -> Self {
        Setting {
            id: id.to_owned(),
            name: name.to_owned(),
            axis: axis.to_owned(),
            at: Vec::new(),
            specification,
            clouds: vec![[1, clouds]],
        }
    }

    pub fn realizations(&self) -> impl Iterator<Item = u64> {
        self.clouds.iter().flat_map(|[first, last]| *first..=*last)
    }
}

/// What is wrong with settings that may have been read from a file.
pub fn sound<'a>(settings: impl IntoIterator<Item = &'a Setting>) -> Result<(), String> {
    for setting in settings {
        let (id, clouds) = (&setting.id, &setting.clouds);
        let checked = setting.specification.scene.check();
        checked.map_err(|error| format!("{id}: {error}"))?;
        let ends = |[first, last]: &[u64; 2]| first <= last && last - first < MOST_CLOUDS;
        if clouds.is_empty() || !clouds.iter().all(ends) {
            return Err(format!("{id} has clouds {clouds:?}"));
        }
    }
    Ok(())
}

/// Before what a study on another bed says of the published figures.
pub const OTHER_BED: &str =
    "On a bed that is not the paper's, of which the published figures are not to be expected: ";
/// dt over √(m/k) of the fast protocol.
pub const FAST_STEP: f64 = 0.65;

/// The paper's scene; realizations are put in later.
pub fn whole_scene() -> Scene {
    paper_scene(1, GRAINS)
}

/// The paper's scene, 0.4 m wide with half of the depth and the points at half the distances.
pub fn small_scene() -> Scene {
    let mut scene = changed(whole_scene(), &[(What::Width, 0.4), (What::Depth, 0.5)]);
    for point in &mut scene.control_points {
        point.offset *= 0.5;
    }
    scene
}

/// The paper's scene with the fast protocol's step: that of the candidate that was tested to be equivalent.
pub fn fast_scene(realization: u64, grains: u32) -> Scene {
    let paper = paper_scene(realization, grains);
    let mut scene = changed(paper, &[(What::Step, FAST_STEP)]);
    let reason = format!(
        "not printed; {FAST_STEP} of sqrt(m/k) was tested to be equivalent to 0.45 (docs/tradeoff.md)"
    );
    scene.choices.insert("/time_step".to_owned(), reason);
    scene
}
