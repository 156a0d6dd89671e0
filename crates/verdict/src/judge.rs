//! The verdict on an engine's first steps: how coarsely it computes, whether it stays among the replicas, which faults would have
//! been seen, and what is wrong if it does not.

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::sync::{Arc, Mutex, OnceLock};

use evidence::in_parallel;
use grains::model::{Model, Wall};
use grains::native::{self, NativeError, Noise};
use grains::scene::{AfterForce, Scene};
use grains::tables::{Bodies, Snapshot};
use grains::task::{Case, Observer, Task, Until};
use grains::variant::{self, Constant, Form, Variant};
use serde::Serialize;

use crate::constants::{Fit, Fitted, Observed, Search, situations, until};
use crate::envelope::{self, Envelope, Farthest, Resolution};
use crate::exercise::{self, Count};
use crate::forms;
use crate::starts::{Bed, State};
use crate::{Answer, Engine};

/// What an engine is, compared with the native one; the first that holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Every bit is the same.
    Identical,
    /// It parts from the native engine as runs do that are the same but for rounding.
    EqualToRounding,
    /// Its packings have the same distribution, within margins set before.
    EqualInDistribution,
    /// It is another engine.
    Different,
    /// Evidence is missing.
    Undecided,
}

impl Verdict {
    pub fn in_words(self) -> &'static str {
        match self {
            Verdict::Identical => "identical",
            Verdict::EqualToRounding => "equal to rounding",
            Verdict::EqualInDistribution => "equal in distribution",
            Verdict::Different => "different",
            Verdict::Undecided => "undecided",
        }
    }
}

/// One start under one law.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OfStart {
    pub law: String,
    pub start: String,
    /// For identifiers.
    #[serde(skip)]
    pub key: String,
    pub verdict: Verdict,
    pub skipped: Option<String>,
    pub farthest: Option<Farthest>,
    /// What is wrong with its contact tables, where they are off before the motion is.
    pub tables: Option<String>,
}

/// A state that the engine was not asked for.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NotAsked {
    pub law: String,
    pub start: String,
    /// What the engine says it has not.
    pub lacking: String,
}

/// The smallest fault in a constant that would have been seen.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Limit {
    pub constant: &'static str,
    pub smallest: f64,
    pub law: String,
    pub start: String,
}

/// What is wrong, as far as it was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cause {
    /// Under this law it was found.
    pub law: String,
    /// The native engine with these constants and forms comes nearest.
    #[serde(skip)]
    pub variant: Variant,
    pub constants: Vec<Fitted>,
    /// Constants that the engine's first steps do not tell from the others; they were taken as given.
    #[serde(serialize_with = "symbols")]
    pub tied: Vec<Constant>,
    #[serde(serialize_with = "in_words")]
    pub forms: Vec<Form>,
    /// Other forms that explain it as well.
    #[serde(serialize_with = "in_words")]
    pub also: Vec<Form>,
    /// With them the engine stays among the replicas for its first ten steps and the one with which it left them.
    pub explained: bool,
    /// Grains that are farther off than rounding takes them, at the first moment at which there are any, though the constants
    /// and forms are taken into account.
    pub left: Vec<usize>,
    pub left_in: String,
    /// What those grains touch.
    pub left_at: String,
    /// The state, as it is handed to engines.
    #[serde(skip)]
    pub state: Option<Snapshot>,
    #[serde(skip)]
    pub walls: Vec<Wall>,
}

fn in_words<S: serde::Serializer>(of: &[Form], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(of.iter().map(|form| forms::in_words(*form)))
}

fn symbols<S: serde::Serializer>(of: &[Constant], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(of.iter().map(|of| of.symbol()))
}

impl Cause {
    /// In a sentence: what the engine is, and where to look.
    pub fn sentence(&self) -> String {
        let mut with: Vec<String> = Vec::new();
        let mut look_at: Vec<&str> = Vec::new();
        let is_of_springs = |of: &&Fitted| {
            use Constant::{GrainStiffness, PunchStiffness, WallStiffness};
            [GrainStiffness, WallStiffness, PunchStiffness].contains(&of.constant)
        };
        let of_springs: Vec<&Fitted> = self.constants.iter().filter(is_of_springs).collect();
        let one_factor = of_springs.len() > 1
            && of_springs[0].constant == Constant::GrainStiffness
            && of_springs.iter().all(|of| {
                let apart = (of.larger - of_springs[0].larger).abs();
                apart <= 6.0 * (of.error + of_springs[0].error) + 1.0e-12
            });
        for of in &self.constants {
            let joint = one_factor && is_of_springs(&of);
            if joint && of.constant != of_springs[0].constant {
                continue;
            }
            let symbol = if joint { "k_n" } else { of.constant.symbol() };
            let (larger, error) = (of.larger, of.error);
            with.push(match of.constant {
                Constant::GravityAcross => format!("g_x = {larger:.3e}·|g| ± {error:.0e}"),
                Constant::WallPlace(_) => format!("{symbol} off by {larger:.3e} R ± {error:.0e}"),
                _ => {
                    let error = error.max(f64::EPSILON);
                    format!("{symbol} × {:.12} ± {error:.0e}", 1.0 + larger)
                }
            });
            let place = look_at_for(of.constant);
            if !look_at.contains(&place) {
                look_at.push(place);
            }
        }
        let forms = self.forms.iter().map(|form| forms::in_words(*form));
        let forms = forms.collect::<Vec<_>>().join(". And ");
        if !self.explained {
            return self.what_is_left(&forms);
        }
        let (with, look_at) = (with.join(", "), look_at.join(", "));
        let mut said = match with.is_empty() {
            true => forms,
            false => {
                let and = if forms.is_empty() { "" } else { ". And " };
                format!("equal to rounding with {with}; look at {look_at}{and}{forms}")
            }
        };
        for form in &self.also {
            said = format!("{said}. Or: {}", forms::in_words(*form));
        }
        let tied: Vec<&str> = self.tied.iter().map(|of| of.symbol()).collect();
        if !tied.is_empty() {
            let tied = tied.join(", ");
            let why = "from the other constants: taken as given";
            said = format!("{said}. Its first steps do not tell {tied} {why}");
        }
        format!("{said}.")
    }

    /// Where it differs, and behind it the nearest fit as a hint, without digits that it does not have.
    fn what_is_left(&self, forms: &str) -> String {
        let some: Vec<String> = self.left.iter().take(8).map(usize::to_string).collect();
        let (of_grains, state, at) = (some.join(", "), &self.left_in, &self.left_at);
        let more = if self.left.len() > 8 { ", …" } else { "" };
        let left = match self.left.len() {
            0 => format!("it parts from the model in {state}"),
            1..=3 => format!(
                "in {state} it sits on grain {of_grains} alone: look at its mass, its radius and its contacts"
            ),
            count => format!(
                "in {state} {count} grains are farther off than rounding takes them ({of_grains}{more}): {at}"
            ),
        };
        let hint =
            |of: &Fitted| format!("{} larger by about {:.0e}", of.constant.symbol(), of.larger);
        let mut hints: Vec<String> = self.constants.iter().map(hint).collect();
        hints.extend((!forms.is_empty()).then(|| forms.to_owned()));
        match hints.is_empty() {
            true => format!(
                "{left}. No constant and no form of a term that this program knows explains it."
            ),
            false => format!(
                "{left}. Nearest, though it does not explain it: {}.",
                hints.join(", ")
            ),
        }
    }
}

fn look_at_for(constant: Constant) -> &'static str {
    match constant {
        Constant::GrainStiffness => "k_n = 2·E·R1·R2/(R1 + R2) (Eq. 4)",
        Constant::WallStiffness => "k_n at walls: a wall counts as a grain of the same radius",
        Constant::PunchStiffness => "k_n at the punch: it counts as a grain of the same radius",
        Constant::ShearStiffness => "k_s = law.stiffness_ratio · k_n",
        Constant::Friction => "the limit |N| tan φ (Eq. 5)",
        Constant::Dashpot => "law.contact.viscosity",
        Constant::Damping => "model.alpha",
        Constant::GravityAcross | Constant::GravityUp => "model.gravity",
        Constant::TimeStep => "model.dt",
        Constant::Mass => "the masses in initial.csv",
        Constant::Inertia => "the moments of inertia in initial.csv",
        Constant::Radius => "the radii in initial.csv",
        Constant::WallPlace(_) => "model.walls",
        Constant::PunchSpeed => "punch.velocity, and when the punch moves: before the forces",
    }
}

/// All that was found about an engine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judgement {
    pub grains: usize,
    /// How coarsely the engine computes; that of double precision where it was not measured.
    pub resolution: Resolution,
    /// The largest coordinate of the states that tell it, m.
    pub extent: f64,
    /// Every state under every law that the engine says it has.
    pub starts: Vec<OfStart>,
    /// What it says it has not, which counts neither way.
    pub not_asked: Vec<NotAsked>,
    /// What would have been seen, the smallest first.
    pub limits: Vec<Limit>,
    /// What touched and slid in the states that were looked at.
    pub counts: Vec<Count>,
    /// Constants and keys that change nothing in any of these states, so that nothing is known of them.
    pub unseen: Vec<String>,
    /// For each law that shows something else than the ones before.
    pub causes: Vec<Cause>,
}

impl Judgement {
    /// Of all states: different if one is, undecided if one was not looked at or the evidence is too thin.
    pub fn verdict(&self) -> Verdict {
        match self.of_states() {
            Verdict::EqualToRounding | Verdict::Identical if self.open().is_some() => {
                Verdict::Undecided
            }
            of_states => of_states,
        }
    }

    /// Why states that agree are too little evidence.
    pub fn open(&self) -> Option<String> {
        let short = self.counts.iter().filter(|of| !of.is_enough());
        let short: Vec<String> = short
            .map(|of| format!("{} {}", of.found, of.what))
            .collect();
        let coarse = self.limits.last().filter(|of| of.smallest > LARGEST_LIMIT);
        let identical = self.of_states() == Verdict::Identical;
        match coarse {
            _ if !short.is_empty() => {
                Some(format!("nothing has touched yet: {}", short.join(", ")))
            }
            _ if identical => None,
            _ if self.resolution.is_too_coarse(self.extent) => Some(format!(
                "it takes no notice of changes of its start that single precision notices ({:.0e} m in places, {:.0e} m in overlaps, \
                 {:.0e} of a velocity), so a fault of that size could not be seen",
                self.resolution.position, self.resolution.overlap, self.resolution.velocity
            )),
            Some(of) => Some(format!(
                "{} could be wrong by {:.0e} and would not be seen",
                of.constant, of.smallest
            )),
            None => None,
        }
    }

    fn of_states(&self) -> Verdict {
        let has = |verdict| self.starts.iter().any(|of| of.verdict == verdict);
        let order = [
            Verdict::Different,
            Verdict::Undecided,
            Verdict::EqualToRounding,
            Verdict::Identical,
        ];
        let found = order.into_iter().find(|of| has(*of));
        found.unwrap_or(Verdict::Undecided)
    }

    pub fn farthest(&self) -> Option<&OfStart> {
        let looked_at = self.starts.iter().filter(|of| of.farthest.is_some());
        looked_at.max_by(|a, b| ratio(&a.farthest).total_cmp(&ratio(&b.farthest)))
    }
}

fn of_motion(of: &Option<Farthest>) -> f64 {
    of.as_ref().map_or(0.0, |of| of.of_motion)
}

fn ratio(of: &Option<Farthest>) -> f64 {
    of.as_ref().map_or(0.0, |of| of.ratio)
}

/// Where a constant could be wrong by more than this share unseen, nothing agrees.
const LARGEST_LIMIT: f64 = 1.0e-3;
/// A cause is held against the first so many steps, or more where the engine parts from the native one later.
const EXPLAINED_UNTIL: u64 = 10;
/// So many of the best forms are fitted in full.
const TRIED: usize = 3;
/// Under one law at most so many terms are looked for in another form at once.
const MOST_FORMS: usize = 3;

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

#[derive(Default)]
struct Seen(Vec<Snapshot>);

impl Observer for Seen {
    fn snapshot(&mut self, snapshot: &Snapshot) {
        self.0.push(snapshot.clone());
    }
}

impl Excerpt {
    /// From this start on.
    pub fn new(start: &str, key: &str, scene: &Scene, from: grains::task::Start) -> Self {
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
    pub fn into_loading(start: &str, key: &str, scene: &Scene, from: grains::task::Start) -> Self {
        let mut of = Excerpt::new(start, key, scene, from);
        let (scene, task) = (&mut of.scene, &mut of.task);
        task.until = Until::EndOfLoading;
        (task.start.step, task.start.seen) = (0, grains::task::Seen::default());
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
        from: grains::task::Start,
    ) -> Result<Option<Self>, NativeError> {
        let mut of = Excerpt::new(start, key, scene, from);
        let forces = of.native(None)?;
        let forces = forces.iter().filter_map(|of| of.punch).map(|of| of.force);
        let largest = forces.fold(0.0, f64::max);
        let dt = scene.time_step_seconds();
        let loading = &mut of.scene.loading;
        loading.pressure = 0.8 * largest / (2.0 * loading.half_width);
        loading.after_force = AfterForce::StandStill { seconds: 40.0 * dt };
        of.task.until = Until::EndOfLoading;
        Ok((largest > 0.0).then_some(of))
    }

    fn native(&self, noise: Option<Noise>) -> Result<Vec<Snapshot>, NativeError> {
        let mut seen = Seen::default();
        let options = native::Options {
            noise,
            ..native::Options::default()
        };
        native::run(&self.scene, &self.task, &options, &mut seen)?;
        Ok(seen.0)
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
        }
        Ok(judged)
    }
}

const AS_A_SCENE: &str = "as a scene";
const OTHER_MOMENTS: &str = "it wrote other moments than were asked for";

fn verdict(farthest: &Option<Farthest>, theirs: &[Snapshot], own: &[Snapshot]) -> Verdict {
    // By their bits: == takes −0 for 0.
    let same = |(a, b): (&Snapshot, &Snapshot)| a.digest() == b.digest();
    match farthest {
        None => Verdict::Different,
        Some(_) if theirs.iter().zip(own).all(same) => Verdict::Identical,
        Some(far) if far.is_rounding() => Verdict::EqualToRounding,
        Some(_) => Verdict::Different,
    }
}

/// The native engine's side of a judgement: made once, for any number of engines.
#[derive(Debug, Clone)]
pub struct Reference {
    states: Vec<State>,
    pub excerpts: Vec<Excerpt>,
    names_causes: bool,
    /// For engines in double precision, made when the first engine has answered the case.
    double: Vec<OnceLock<Native>>,
    /// What none of them shows, of the states that an engine was asked for.
    unseen: Arc<Mutex<BTreeMap<Vec<usize>, Vec<&'static str>>>>,
}

/// What is known of one case.
#[derive(Debug, Clone)]
struct Native {
    envelope: Envelope,
    limits: Vec<(Constant, f64)>,
}

/// A state with what is known of it and what an engine made of it.
struct Answered<'a> {
    asked: &'a State,
    native: Native,
    theirs: Vec<Snapshot>,
    /// None where it wrote other moments than were asked for.
    farthest: Option<Farthest>,
}

impl Answered<'_> {
    fn moves_right(&self) -> bool {
        self.farthest.as_ref().is_some_and(Farthest::moves_right)
    }

    fn verdict(&self) -> Verdict {
        verdict(&self.farthest, &self.theirs, &self.native.envelope.own)
    }
}

impl Native {
    fn new(case: &Case, resolution: Resolution) -> Result<Self, NativeError> {
        let envelope = Envelope::new(case, resolution.noise())?;
        let all = in_parallel(Constant::all().len(), |at| {
            envelope.detection_limit(Constant::all()[at])
        });
        let mut limits = Vec::new();
        for (constant, limit) in Constant::all().into_iter().zip(all) {
            limits.extend(limit?.map(|limit| (constant, limit)));
        }
        Ok(Native { envelope, limits })
    }
}

impl Reference {
    /// Of a bed of so many grains whose radii differ by this share from their mean; `progress` hears what is under way.
    pub fn new(
        grains: u32,
        dispersion: f64,
        progress: &mut dyn FnMut(&str),
    ) -> Result<Self, NativeError> {
        progress("pouring a bed");
        let bed = Bed::new(grains, dispersion)?;
        Ok(Reference::of(bed.states(), bed.excerpts()?))
    }

    /// Of these states and excerpts of scenes.
    pub fn of(states: Vec<State>, excerpts: Vec<Excerpt>) -> Self {
        Reference {
            excerpts,
            names_causes: true,
            double: states.iter().map(|_| OnceLock::new()).collect(),
            states,
            unseen: Arc::default(),
        }
    }

    /// Causes are not looked for: that takes most of the time.
    pub fn without_causes(self) -> Self {
        Reference {
            names_causes: false,
            ..self
        }
    }

    /// Judges an engine that says it has these terms in another form; `lacks` says what it has not that a case asks for, and such a case is not handed to it.
    pub fn judge<E: From<NativeError>>(
        &self,
        declared: &[Form],
        lacks: &dyn Fn(&Case) -> Option<String>,
        engine: &mut Engine<'_, E>,
        progress: &mut dyn FnMut(&str),
    ) -> Result<Judgement, E> {
        let (mut states, mut not_asked) = (Vec::new(), Vec::new());
        for (index, of) in self.states.iter().enumerate() {
            match lacks(&of.case) {
                Some(lacking) => not_asked.push(NotAsked {
                    law: of.law.clone(),
                    start: of.start.clone(),
                    lacking,
                }),
                None => states.push((index, of)),
            }
        }
        let cases: Vec<&Case> = states.iter().map(|(_, of)| &of.case).collect();
        let probed = states.iter().filter(|(_, of)| of.probed);
        let probed: Vec<&Case> = probed.map(|(_, of)| &of.case).collect();
        let probes: Vec<Vec<Case>> = probed.iter().map(|case| Resolution::cases(case)).collect();
        progress("the engine runs");
        let asked: Vec<&Case> = probes.iter().flatten().chain(cases).collect();
        let mut of_cases = engine(&asked)?;
        let mut judgement = Judgement {
            grains: states.first().map_or(0, |(_, of)| of.case.bodies.len()),
            resolution: Resolution::DOUBLE,
            extent: 0.0,
            starts: Vec::new(),
            not_asked,
            limits: Vec::new(),
            counts: Vec::new(),
            unseen: Vec::new(),
            causes: Vec::new(),
        };
        let mut resolution = Resolution::DOUBLE;
        for (case, probes) in probed.iter().zip(&probes) {
            let rest = of_cases.split_off(probes.len().min(of_cases.len()));
            let answers = std::mem::replace(&mut of_cases, rest);
            let measured = Resolution::measured(case, &answers);
            resolution = measured.map_or(resolution, |of| resolution.coarser(of));
        }
        let mut all = Vec::with_capacity(states.len());
        let mut looked_at = Vec::new();
        for ((index, of), answer) in states.into_iter().zip(of_cases) {
            let mut judged = OfStart {
                law: of.law.clone(),
                start: of.start.clone(),
                key: of.key.clone(),
                verdict: Verdict::Undecided,
                skipped: None,
                farthest: None,
                tables: None,
            };
            match answer {
                // Nothing need be known of it.
                Err(reason) => judged.skipped = Some(reason),
                Ok(theirs) => {
                    progress(&format!("replicas: {}", of.case.name));
                    let is_double = resolution == Resolution::DOUBLE;
                    if envelope::is_rounded(&theirs) {
                        let why = "it writes at most 8 digits, and numbers must read back to the same bits (17 digits)";
                        judged.skipped = Some(why.to_owned());
                        judgement.starts.push(judged);
                        continue;
                    }
                    looked_at.push(index);
                    let double = &self.double[index];
                    let native = match double.get() {
                        Some(native) if is_double => native.clone(),
                        _ => Native::new(&of.case, resolution)?,
                    };
                    if is_double {
                        double.get_or_init(|| native.clone());
                    }
                    let answered = Answered {
                        asked: of,
                        farthest: native.envelope.farthest(&theirs),
                        native,
                        theirs,
                    };
                    if of.probed {
                        let (extent, _) = envelope::largest(&answered.native.envelope.own);
                        judgement.extent = judgement.extent.max(extent);
                    }
                    judged.verdict = answered.verdict();
                    judged.farthest = answered.farthest.clone();
                    judged.tables = answered.native.envelope.tables_in_words(&answered.theirs);
                    let is_other = judged.farthest.is_none();
                    judged.skipped = is_other.then(|| OTHER_MOMENTS.to_owned());
                    all.push(answered);
                }
            }
            judgement.starts.push(judged);
        }
        judgement.limits = limits(&all);
        judgement.resolution = resolution;
        let runs = all
            .iter()
            .map(|of| (&of.asked.case, &of.native.envelope.own[..]));
        judgement.counts = exercise::counts(runs);
        if judgement.of_states() != Verdict::Different {
            progress("what would not have been seen");
            judgement.unseen = self.unseen(looked_at, &all);
        }
        if self.names_causes && judgement.verdict() == Verdict::Different {
            judgement.causes = causes(&all, resolution, declared, progress);
        }
        Ok(judgement)
    }
}

impl Reference {
    /// Constants and keys of which these states say nothing.
    fn unseen(&self, looked_at: Vec<usize>, all: &[Answered]) -> Vec<String> {
        let known = self
            .unseen
            .lock()
            .ok()
            .and_then(|of| of.get(&looked_at).cloned());
        let keys = known.unwrap_or_else(|| {
            let envelopes: Vec<&Envelope> = all.iter().map(|of| &of.native.envelope).collect();
            let keys = exercise::unseen(&envelopes);
            if let Ok(mut of) = self.unseen.lock() {
                of.insert(looked_at, keys.clone());
            }
            keys
        });
        let limits = || all.iter().flat_map(|of| &of.native.limits);
        let constants = Constant::all().into_iter().filter(|constant| {
            let mut states = all.iter();
            states.any(|of| constant.is_in(&of.asked.case)) && !limits().any(|of| of.0 == *constant)
        });
        let constants: Vec<&str> = constants.map(Constant::symbol).collect();
        constants
            .into_iter()
            .chain(keys)
            .map(str::to_owned)
            .collect()
    }
}

/// For each constant the smallest fault that any of the states that were looked at shows.
fn limits(all: &[Answered]) -> Vec<Limit> {
    let mut limits: Vec<Limit> = Vec::new();
    for answered in all.iter().filter(|of| of.farthest.is_some()) {
        let limit = |(constant, smallest): &(Constant, f64)| Limit {
            constant: constant.symbol(),
            smallest: *smallest,
            law: answered.asked.law.clone(),
            start: answered.asked.start.clone(),
        };
        limits.extend(answered.native.limits.iter().map(limit));
    }
    // The first of several that are as small.
    limits.sort_by(|a, b| a.smallest.total_cmp(&b.smallest));
    let mut seen = BTreeSet::new();
    limits.retain(|of| seen.insert(of.constant));
    limits
}

/// Law by law: the constants and forms of one are taken for known under the next. What the engine declares is tried before
/// anything else: all of it, then each.
fn causes(
    all: &[Answered],
    resolution: Resolution,
    declared: &[Form],
    progress: &mut dyn FnMut(&str),
) -> Vec<Cause> {
    let mut causes: Vec<Cause> = Vec::new();
    let mut known = Variant::default();
    let mut fitted: Vec<Constant> = Vec::new();
    let mut judged: Vec<Form> = Vec::new();
    let mut laws: Vec<&str> = all.iter().map(|of| of.asked.law.as_str()).collect();
    laws.dedup();
    for law in laws {
        let ruled_out = judged.clone();
        let of_law = all.iter().filter(|of| of.asked.law == law);
        let of_law: Vec<&Answered> = of_law.collect();
        progress(&format!("what is wrong: {law}"));
        let farthest = of_law.iter().filter_map(|of| of.farthest.as_ref());
        let left_after = farthest.filter_map(|of| of.left_after);
        let until = left_after.min().unwrap_or(0).max(EXPLAINED_UNTIL);
        let cases = of_law.iter().map(|answered| &answered.asked.case);
        judged.extend(cases.flat_map(forms::candidates));
        let tried = Tried {
            of_law,
            resolution,
            until,
            ruled_out: &ruled_out,
        };
        if tried.is_explained(&known) {
            continue;
        }
        let mut told = [declared].into_iter().chain(declared.chunks(1));
        let told = told.find_map(|forms| {
            let mut variant = known.clone();
            variant
                .forms
                .extend(forms.iter().filter(|of| !known.has(**of)));
            let explains = variant != known && tried.is_explained(&variant);
            explains.then(|| tried.cause(Fit::known(variant), true, Vec::new()))
        });
        let cause = told.unwrap_or_else(|| tried.search(&known, &fitted, MOST_FORMS - 1));
        let before = std::mem::replace(&mut known, cause.variant.clone());
        fitted.extend(tried.free(&fitted));
        // A length that is not quite met leaves a few grains in every law: that was said.
        let new = !cause.constants.is_empty() || !same_kinds(&cause.forms, &before.forms);
        if new || causes.is_empty() {
            causes.push(cause);
        }
    }
    causes
}

fn same_kinds(a: &[Form], b: &[Form]) -> bool {
    let kinds = |of: &[Form]| -> HashSet<_> { of.iter().map(std::mem::discriminant).collect() };
    kinds(a) == kinds(b)
}

struct Tried<'a> {
    of_law: Vec<&'a Answered<'a>>,
    resolution: Resolution,
    /// The step that first steps go to.
    until: u64,
    /// Forms that would have shown under a law before.
    ruled_out: &'a [Form],
}

impl Tried<'_> {
    /// The first steps with this variant, and the answer cut to them.
    fn first_steps<'a>(
        &self,
        of: &'a Answered<'_>,
        variant: &Variant,
    ) -> (Vec<Snapshot>, &'a [Snapshot]) {
        let case = until(&of.asked.case, self.until);
        let count = case.moments.len().min(of.theirs.len());
        (variant::run(&case, variant), &of.theirs[..count])
    }

    fn farthest(&self, variant: &Variant) -> Vec<Option<Farthest>> {
        in_parallel(self.of_law.len(), |at| {
            let of = self.of_law[at];
            let (own, theirs) = self.first_steps(of, variant);
            of.native.envelope.farthest_from(&own, theirs)
        })
    }

    fn is_explained(&self, variant: &Variant) -> bool {
        let mut farthest = self.farthest(variant).into_iter();
        farthest.all(|of| of.is_some_and(|of| of.moves_right()))
    }

    /// The constants that play a part under this law and did not under those before.
    fn free(&self, fitted: &[Constant]) -> Vec<Constant> {
        let plays_a_part = |constant: &Constant| {
            let mut of_law = self.of_law.iter();
            of_law.any(|answered| constant.is_in(&answered.asked.case))
                && !fitted.contains(constant)
        };
        Constant::all().into_iter().filter(plays_a_part).collect()
    }

    /// `more` forms may be taken besides the best one, if all together explain the law.
    fn search(&self, known: &Variant, fitted: &[Constant], more: usize) -> Cause {
        // States in which nothing differs have nothing to say.
        let differing = self.of_law.iter().filter(|of| !of.moves_right());
        let observed = differing.map(|of| (&of.asked.case, &of.theirs[..]));
        let observed: Vec<Observed<'_>> = observed.collect();
        let with = |form: Form| {
            let mut variant = known.clone();
            variant.forms.push(form);
            variant
        };
        // A key that is not read explains all by itself, and better than numbers do.
        let mut forms: Vec<Form> = Vec::new();
        let candidates = observed.iter().map(|(case, _)| forms::candidates(case));
        for form in candidates.flatten() {
            let taken = [self.ruled_out, &known.forms, &forms];
            if !taken.iter().any(|of| of.contains(&form)) {
                forms.push(form);
            }
        }
        let mut unread = forms.iter().filter(|form| matches!(form, Form::Unread(_)));
        if let Some(form) = unread.find(|form| self.is_explained(&with(**form))) {
            return self.cause(Fit::known(with(*form)), true, Vec::new());
        }
        let free = self.free(fitted);
        let search = Search::new(&observed, self.resolution, self.until);
        let full = search.fit(known, &free);
        let constants_alone = search.pruned(known, &full);
        if self.is_explained(&constants_alone.variant) {
            return self.cause(constants_alone, true, Vec::new());
        }
        if self.ruled_out.is_empty() {
            forms.extend(search.lost_contacts(known));
        }
        let misfits = in_parallel(forms.len(), |at| {
            search.misfit(&search.refit(&with(forms[at]), &full))
        });
        let mut order: Vec<usize> = (0..forms.len()).collect();
        order.sort_by(|a, b| misfits[*a].total_cmp(&misfits[*b]));
        let mut best: Option<(Fit, f64, Form)> = None;
        let mut explaining: Vec<(Fit, Form)> = Vec::new();
        for at in order.into_iter().take(TRIED) {
            let with = with(forms[at]);
            let fit = search.pruned(&with, &search.fit(&with, &free));
            if self.is_explained(&fit.variant) {
                explaining.push((fit, forms[at]));
            } else {
                let misfit = search.misfit(&fit.variant);
                if best.as_ref().is_none_or(|(_, of, _)| misfit < *of) {
                    best = Some((fit, misfit, forms[at]));
                }
            }
        }
        if !explaining.is_empty() {
            // Of several the one that needs the fewest constants besides.
            explaining.sort_by_key(|(fit, _)| fit.wrong().len());
            let also = explaining[1..].iter().map(|(_, form)| *form).collect();
            return self.cause(explaining.swap_remove(0).0, true, also);
        }
        let alone = search.misfit(&constants_alone.variant);
        match best {
            Some((fit, misfit, form)) if misfit < 0.5 * alone => {
                let with_more = (more > 0).then(|| self.search(&with(form), fitted, more - 1));
                let explained = with_more.filter(|of| of.explained);
                explained.unwrap_or_else(|| self.cause(fit, false, Vec::new()))
            }
            _ => self.cause(constants_alone, false, Vec::new()),
        }
    }

    fn cause(&self, fit: Fit, explained: bool, also: Vec<Form>) -> Cause {
        let farthest = self.farthest(&fit.variant);
        let worst = (0..farthest.len())
            .max_by(|a, b| of_motion(&farthest[*a]).total_cmp(&of_motion(&farthest[*b])));
        let of = self.of_law[worst.unwrap_or(0)];
        let (mut left, mut left_at) = (Vec::new(), String::new());
        if !explained {
            let (own, theirs) = self.first_steps(of, &fit.variant);
            let (outside, step) = of.native.envelope.outside(&own, theirs);
            left_at = what_they_touch(&of.asked.case, &outside, &own, step);
            left = around_one(outside, own.iter().chain(theirs));
        }
        Cause {
            law: of.asked.law.clone(),
            constants: fit.wrong(),
            tied: fit.tied,
            forms: fit.variant.forms.clone(),
            variant: fit.variant,
            explained,
            also,
            left,
            left_in: of.asked.start.clone(),
            left_at,
            state: of.native.envelope.own.first().cloned(),
            walls: of.asked.case.model.walls.clone(),
        }
    }
}

/// How many of these grains touch other grains alone, walls or the punch, and whether contacts of theirs slide.
fn what_they_touch(case: &Case, left: &[usize], own: &[Snapshot], step: u64) -> String {
    let until: Vec<Snapshot> = own.iter().filter(|of| of.step <= step).cloned().collect();
    let situations = situations(case, &until);
    let of_kind = |kind: usize| left.iter().filter(|id| situations[**id] == kind).count();
    let kinds = [
        "fly",
        "touch grains alone",
        "touch a wall",
        "touch the punch",
    ];
    let found = kinds
        .iter()
        .enumerate()
        .map(|(kind, what)| (of_kind(kind), what));
    let found: Vec<String> = found
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| format!("{count} {what}"))
        .collect();
    let slides = exercise::sliding(case, &until);
    let among = left
        .iter()
        .filter(|id| slides.contains(&(**id as u32)))
        .count();
    match case.model.law.has_friction() {
        true => format!("{}; contacts of {among} slide", found.join(", ")),
        false => found.join(", "),
    }
}

/// Of grains that are one and those that it touches that one alone: what is wrong with it moves them. Where it may be more
/// than one of them, all.
fn around_one<'a>(
    left: Vec<usize>,
    runs: impl Iterator<Item = &'a Snapshot> + Clone,
) -> Vec<usize> {
    let touch = |a: usize, b: usize| {
        let mut contacts = runs.clone().flat_map(|of| &of.contacts);
        contacts.any(|of| [(a, b), (b, a)].contains(&(of.id1 as usize, of.id2 as usize)))
    };
    let few = left.len() <= MOST_NEIGHBOURS;
    let is_centre =
        |one: &usize| few && left.iter().all(|other| other == one || touch(*one, *other));
    let centres: Vec<usize> = left.iter().copied().filter(is_centre).collect();
    match centres[..] {
        [one] => vec![one],
        _ => left,
    }
}

/// A disc and those that can touch it.
const MOST_NEIGHBOURS: usize = 7;
