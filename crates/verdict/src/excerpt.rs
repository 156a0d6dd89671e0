//! Excerpts of a scene's run: jobs that a case has no place for, judged as cases are.

use std::sync::OnceLock;

use evidence::in_parallel;
use grains::model::Model;
use grains::native::{self, NativeError, Noise};
use grains::scene::{AfterForce, Scene};
use grains::tables::{Bodies, Snapshot};
use grains::task::{Case, Seen, Start, Task, Until};

use crate::Answer;
use crate::envelope::{self, Envelope, Resolution};
use crate::judge::{NotAsked, OTHER_MOMENTS, OfStart, Verdict, verdict};

/// A few hundred steps of a scene's run, that an engine is asked for as it is for the whole: with its stages, its punch and
/// its count of steps, none of which a case has.
#[derive(Debug, Clone)]
pub struct Excerpt {
    /// In words, and for identifiers.
    pub start: String,
    pub key: String,
    pub scene: Scene,
    pub task: Task,
    /// For engines in double precision.
    double: OnceLock<Envelope>,
}

/// The steps of an excerpt, and at which multiples it is looked at.
pub const STEPS_OF_EXCERPT: u64 = 300;
pub const EXCERPT_EVERY: u64 = 25;

impl Excerpt {
    /// From this start on.
    pub fn new(start: &str, key: &str, scene: &Scene, from: Start) -> Self {
        let mut scene = scene.clone();
        scene.measurement.history_every = EXCERPT_EVERY;
        let until = Until::Step(from.step + STEPS_OF_EXCERPT);
        Excerpt {
            start: start.to_owned(),
            key: key.to_owned(),
            scene,
            task: Task { start: from, until },
            double: OnceLock::new(),
        }
    }

    /// That the engine lacks this.
    pub fn not_asked(&self, lacking: String) -> NotAsked {
        NotAsked {
            law: AS_A_SCENE.to_owned(),
            start: self.start.clone(),
            lacking,
        }
    }

    /// From a state that pours into loading: the rule that ends settling holds soon, and the punch goes a little way down. Contacts
    /// have a history by then.
    pub fn into_loading(start: &str, key: &str, scene: &Scene, from: Start) -> Self {
        let mut of = Excerpt::new(start, key, scene, from);
        let (scene, task) = (&mut of.scene, &mut of.task);
        task.until = Until::EndOfLoading;
        (task.start.step, task.start.seen) = (0, Seen::default());
        scene.settle.kinetic_energy_fraction = 1.0;
        scene.settle.check_every = 2 * EXCERPT_EVERY;
        // Between two steps, where rounding makes no difference.
        let steps = (STEPS_OF_EXCERPT - scene.settle.check_every) as f64 - 0.5;
        scene.loading.give_up_depth = steps * scene.loading.speed * scene.time_step_seconds();
        of
    }

    /// From a bed at rest to the end of loading, with a force that is reached in a few hundred steps, after which the punch stands still
    /// for some. None where the punch meets nothing so soon.
    pub fn to_end(
        start: &str,
        key: &str,
        scene: &Scene,
        from: Start,
    ) -> Result<Option<Self>, NativeError> {
        Excerpt::new(start, key, scene, from).ended_by_the_force()
    }

    /// The same with a force that its punch has soon.
    pub fn ended_by_the_force(mut self) -> Result<Option<Self>, NativeError> {
        let forces = self.native(None)?;
        let forces = forces.iter().filter_map(|of| of.punch).map(|of| of.force);
        let largest = forces.fold(0.0, f64::max);
        let dt = self.scene.time_step_seconds();
        let loading = &mut self.scene.loading;
        loading.pressure = 0.8 * largest / (2.0 * loading.half_width);
        loading.after_force = AfterForce::StandStill { seconds: 40.0 * dt };
        self.task.until = Until::EndOfLoading;
        Ok((largest > 0.0).then_some(self))
    }

    /// Pouring that ends by its most steps before the rule holds: nothing is loaded then.
    pub fn to_most_steps(start: &str, key: &str, scene: &Scene, from: Start) -> Self {
        let mut of = Excerpt::new(start, key, scene, from);
        (of.task.start.step, of.task.start.seen) = (0, Seen::default());
        of.task.until = Until::EndOfLoading;
        let settle = &mut of.scene.settle;
        settle.kinetic_energy_fraction = 1.0e-12;
        settle.check_every = 2 * EXCERPT_EVERY;
        settle.max_steps = STEPS_OF_EXCERPT / 2;
        of
    }

    /// Pouring of a bed that was livelier at a look before: the rule holds at its first look, and would not by what this run sees.
    pub fn livelier_before(start: &str, key: &str, scene: &Scene, from: Start) -> Self {
        let energy = 100.0 * from.bodies.kinetic_energy();
        let mut of = Excerpt::to_most_steps(start, key, scene, from);
        of.task.start.seen.energy = energy;
        of.task.until = Until::EndOfSettling;
        of.scene.settle.kinetic_energy_fraction = 0.5;
        of
    }

    fn native(&self, noise: Option<Noise>) -> Result<Vec<Snapshot>, NativeError> {
        let mut seen: Vec<Snapshot> = Vec::new();
        let options = native::Options {
            noise,
            ..native::Options::default()
        };
        native::run(&self.scene, &self.task, &options, &mut seen)?;
        Ok(seen)
    }

    fn envelope(&self, noise: Noise) -> Result<Envelope, NativeError> {
        let own = self.native(None)?;
        let runs = in_parallel(envelope::replicas(noise), |replica| {
            self.native(Some(envelope::of_replica(noise, replica)))
        });
        let runs: Result<Vec<_>, _> = runs.into_iter().collect();
        let stage = self.task.start.stage;
        let case = Case {
            name: self.start.clone(),
            model: Model::in_stage(&self.scene, stage),
            bodies: own
                .first()
                .map_or_else(Bodies::default, |of| of.bodies.clone()),
            punch: None,
            moments: Vec::new(),
        };
        Ok(Envelope::of(case, own, &runs?, noise))
    }

    fn not_looked_at(&self, verdict: Verdict, why: Option<String>) -> OfStart {
        OfStart {
            law: AS_A_SCENE.to_owned(),
            start: self.start.clone(),
            key: self.key.clone(),
            verdict,
            skipped: why,
            farthest: None,
            tables: None,
        }
    }

    /// That the engine failed on it.
    pub fn failed(&self, why: String) -> OfStart {
        self.not_looked_at(Verdict::Different, Some(why))
    }

    /// Holds a run of it against replicas of the native one.
    pub fn judge(&self, answer: Answer, resolution: Resolution) -> Result<OfStart, NativeError> {
        let theirs = match answer {
            Ok(theirs) => theirs,
            Err(reason) => return Ok(self.not_looked_at(Verdict::Undecided, Some(reason))),
        };
        let mut judged = self.not_looked_at(Verdict::Undecided, None);
        let known = self
            .double
            .get()
            .filter(|_| resolution == Resolution::DOUBLE);
        let envelope = match known {
            Some(known) => known.clone(),
            None => self.envelope(resolution.noise())?,
        };
        if resolution == Resolution::DOUBLE {
            self.double.get_or_init(|| envelope.clone());
        }
        judged.farthest = envelope.farthest(&theirs);
        judged.verdict = verdict(&judged.farthest, &theirs, &envelope.own);
        judged.tables = envelope.tables_in_words(&theirs);
        if judged.farthest.is_none() {
            judged.skipped = Some(OTHER_MOMENTS.to_owned());
            // A rule that holds between two steps may hold at another one where a step is rounded so.
            if !resolution.is_double() {
                judged.verdict = Verdict::Undecided;
            }
        }
        Ok(judged)
    }
}

const AS_A_SCENE: &str = "as a scene";
