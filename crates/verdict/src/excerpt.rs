//! Excerpts of a scene's run: jobs that a case has no place for, judged as cases are.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use evidence::in_parallel;
use grains::generate::can_turn;
use grains::model::Model;
use grains::native::{self, NativeError, Noise};
use grains::reference::Reference;
use grains::rules::Rules;
use grains::scene::{AfterForce, Scene};
use grains::tables::{
    Bodies, BodyIds, Memories, Remembered, RememberedAcross, Snapshot, Stage, StopReason,
};
use grains::task::{Case, Observer, Seen, StageReport, Start, Task, Until};
use grains::vector::{Vector, hypot, minus, plus, times};

use crate::causes::Cause;
use crate::contacts::OUT_OF_TANGENT;
use crate::envelope::{self, Envelope, Resolution};
use crate::judge::{NotAsked, OTHER_MOMENTS, OfStart, Verdict, have_same_bits, verdict};
use crate::terms;

/// A few hundred steps of a scene's run, that an engine is asked for as it is for the whole: with its stages, its punch and
/// its count of steps, none of which a case has.
#[derive(Debug, Clone)]
pub struct Excerpt {
    /// In words, and for identifiers.
    pub start: String,
    pub key: String,
    pub scene: Scene,
    pub task: Task,
    /// What contacts remember at its start is taken from their table.
    remembers_by_tables: bool,
    /// For engines in double precision.
    double: OnceLock<Envelope>,
    /// Why the stages of the native run ended.
    ends: OnceLock<Ends>,
}

/// Why stages ended, in their order.
pub type Ends = Vec<(Stage, StopReason)>;

/// Of a run with these stages.
pub fn ends(stages: &[StageReport]) -> Ends {
    let all = stages.iter().map(|report| (report.stage, report.stop));
    all.collect()
}

/// The steps of an excerpt, and at which multiples it is looked at.
pub const STEPS_OF_EXCERPT: u64 = 300;
pub const EXCERPT_EVERY: u64 = 25;

/// Steps after which an engine ends whose rule has not: it is wrong then, and would write for as long as the scene allows.
const MOST_STEPS: u64 = 4 * STEPS_OF_EXCERPT;

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
            remembers_by_tables: false,
            double: OnceLock::new(),
            ends: OnceLock::new(),
        }
    }

    /// The same as an engine computes it that has these rules otherwise than the scene.
    pub fn under(&self, rules: Rules) -> Self {
        let mut excerpt = Excerpt {
            double: OnceLock::new(),
            ends: OnceLock::new(),
            ..self.clone()
        };
        excerpt.scene.rules = rules.over(excerpt.scene.rules);
        excerpt
    }

    /// Whether unusual rules are such that the native engine does not end it.
    pub fn has_no_run(&self) -> bool {
        !self.scene.rules.are_usual() && self.native(None).is_err()
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
        let mut excerpt = Excerpt::new(start, key, scene, from);
        let (scene, task) = (&mut excerpt.scene, &mut excerpt.task);
        task.until = Until::EndOfLoading;
        (task.start.step, task.start.seen) = (0, Seen::default());
        scene.settle.kinetic_energy_fraction = 1.0;
        scene.settle.check_every = 2 * EXCERPT_EVERY;
        scene.settle.max_steps = MOST_STEPS;
        // The depth ends it, and no force that is reached at the first touch.
        scene.loading.pressure = UNREACHED;
        // Between two steps, where rounding makes no difference.
        let steps = (STEPS_OF_EXCERPT - scene.settle.check_every) as f64 - 0.5;
        scene.loading.give_up_depth = steps * scene.loading.speed * scene.time_step_seconds();
        excerpt
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

    /// The same with a force that its punch has soon: the one that grew least in the step that reached it, so that another force would
    /// be reached in another step.
    pub fn ended_by_the_force(mut self) -> Result<Option<Self>, NativeError> {
        let every = std::mem::replace(&mut self.scene.measurement.history_every, 1);
        let mut forces = Forces(Vec::new());
        self.run(None, &mut forces)?;
        self.scene.measurement.history_every = every;
        let (mut largest, mut slowest) = (0.0, None);
        for (at, [force, _]) in forces.0.iter().enumerate() {
            let grown = force / largest;
            let target = (force * largest).sqrt();
            let by_normals = forces.0.iter().position(|row| row[1] >= target);
            // Best where normal forces alone have it in another step.
            let rank = (by_normals == Some(at), grown);
            if grown.is_finite()
                && grown > LEAST_GROWN
                && slowest.is_none_or(|(least, _)| rank < least)
            {
                slowest = Some((rank, target));
            }
            largest = force.max(largest);
        }
        let Some((_, target)) = slowest else {
            return Ok(None);
        };
        let dt = self.scene.time_step_seconds();
        let loading = &mut self.scene.loading;
        loading.pressure = target / (2.0 * loading.half_width);
        loading.after_force = AfterForce::StandStill { seconds: 40.0 * dt };
        loading.give_up_depth = MOST_STEPS as f64 * loading.speed * dt;
        self.task.until = Until::EndOfLoading;
        self.ends_for_sure()
    }

    /// None where rounding decides in which step it ends.
    fn ends_for_sure(self) -> Result<Option<Self>, NativeError> {
        let steps = |noise| -> Result<Vec<u64>, NativeError> {
            let moments = self.native(noise)?;
            Ok(moments.iter().map(|moment| moment.step).collect())
        };
        let own = steps(None)?;
        let noise = Resolution::COARSE_DOUBLE.noise();
        let ends = in_parallel(envelope::replicas(noise), |replica| {
            steps(Some(envelope::of_replica(noise, replica)))
        });
        for other in ends {
            if other? != own {
                return Ok(None);
            }
        }
        Ok(Some(self))
    }

    /// Has the rule of settling end it at a look, with some share that is still to be set; the moments of these looks.
    fn ended_by_a_look(&mut self) -> Result<Vec<Snapshot>, NativeError> {
        let first = self.task.start.step;
        self.task.start.seen = Seen::default();
        let moments = self.native(None)?;
        self.scene.settle.check_every = EXCERPT_EVERY;
        self.scene.settle.max_steps = first + MOST_STEPS;
        self.task.until = Until::EndOfSettling;
        Ok(moments)
    }

    /// From a state that still gains energy to the first look at which it has less than at the one before, where the rule holds: by
    /// another share of it, or of another energy than the largest, it holds elsewhere. None where the energy does not rise and fall so soon.
    pub fn until_settled(mut self) -> Result<Option<Self>, NativeError> {
        let moments = self.ended_by_a_look()?;
        let looks: Vec<f64> = moments[1..]
            .iter()
            .map(|moment| moment.bodies.kinetic_energy())
            .collect();
        // The first look with less of the largest energy so far than any before, once energy has risen above that of the first.
        let (mut largest, mut least) = (looks[0], 1.0f64);
        let mut share = None;
        for energy in looks.iter().skip(1) {
            largest = largest.max(*energy);
            let of_largest = energy / largest;
            let others = least.min(energy / looks[0]);
            if largest > looks[0] && of_largest < others {
                share = share.or(Some((of_largest * others).sqrt()));
            }
            least = least.min(of_largest);
        }
        self.scene.settle.kinetic_energy_fraction = share.unwrap_or(0.0);
        Ok(share.map(|_| self))
    }

    /// From a state whose grains spin to a look at which the rule holds by all kinetic energy, and by as few as possible of those that
    /// leave something out or count spins twice. None where there is no such look.
    pub fn until_spins_settle(mut self) -> Result<Option<Self>, NativeError> {
        let moments = self.ended_by_a_look()?;
        let looks = moments[1..].iter().map(|moment| {
            let all = moment.bodies.kinetic_energy();
            let without = |leave: fn(&mut Bodies)| {
                let mut bodies = moment.bodies.clone();
                leave(&mut bodies);
                bodies.kinetic_energy()
            };
            let still = without(|bodies| bodies.inertia.fill(0.0));
            let parts: [fn(&mut Bodies); 4] = [
                |bodies| bodies.vy.fill(0.0),
                |bodies| bodies.spin.fill(0.0),
                |bodies| bodies.spin_x.fill(0.0),
                |bodies| bodies.spin_z.fill(0.0),
            ];
            let parts = parts.into_iter().map(without);
            [all, still, 2.0 * all - still]
                .into_iter()
                .chain(parts)
                .collect()
        });
        let looks: Vec<Vec<f64>> = looks.collect();
        // The first look at which the rule holds with this share of the largest energy so far.
        let holds = |which: usize, share: f64| {
            let mut peak = 0.0;
            looks.iter().position(|energies| {
                peak = energies[which].max(peak);
                energies[which] <= share * peak
            })
        };
        let shares = (1..200).map(|number| f64::from(number) / 200.0);
        let seen = shares.map(|share| {
            let at = holds(0, share);
            let is_safe = [0.999, 1.001].iter().all(|by| holds(0, by * share) == at);
            let is_one = at.is_some_and(|at| at > 0) && is_safe;
            let others = (1..looks[0].len()).filter(|which| is_one && holds(*which, share) != at);
            (others.count(), share)
        });
        // The first of several that tell as many.
        let best = seen.rev().max_by_key(|(others, _)| *others);
        let best = best.filter(|(others, _)| *others > 0);
        self.scene.settle.kinetic_energy_fraction = best.map_or(0.0, |best| best.1);
        Ok(best.map(|_| self))
    }

    /// Moments that a run itself has told, of which the native engine goes on from the first.
    pub fn of_moments(scene: &Scene, first: &Snapshot, last: u64) -> Result<Self, NativeError> {
        let mut excerpt = Excerpt::new("", "", scene, first.clone().into());
        excerpt.scene.measurement.history_every = scene.measurement.history_every;
        excerpt.task.until = Until::Step(last);
        excerpt.remembers_by_tables = Model::in_stage(scene, first.stage).law.has_history();
        if excerpt.remembers_by_tables {
            excerpt.task.start.memory = remembered(scene, first)?;
        }
        Ok(excerpt)
    }

    /// Pouring that ends by its most steps before the rule holds: nothing is loaded then.
    pub fn to_most_steps(mut self) -> Self {
        self.task.start.seen = Seen::default();
        self.task.until = Until::EndOfLoading;
        let settle = &mut self.scene.settle;
        settle.kinetic_energy_fraction = 1.0e-12;
        settle.check_every = 2 * EXCERPT_EVERY;
        settle.max_steps = self.task.start.step + STEPS_OF_EXCERPT / 2;
        self
    }

    /// Pouring of a bed that was livelier at a look before: the rule holds at its first look, and would not by what this run sees.
    pub fn livelier_before(self) -> Self {
        let mut excerpt = self.to_most_steps();
        let start = &mut excerpt.task.start;
        start.seen.energy = 100.0 * start.bodies.kinetic_energy();
        excerpt.task.until = Until::EndOfSettling;
        excerpt.scene.settle.kinetic_energy_fraction = 0.5;
        excerpt
    }

    /// The same, looked at in each of its steps.
    pub fn step_by_step(&self) -> Self {
        let mut excerpt = self.clone();
        excerpt.scene.measurement.history_every = 1;
        excerpt
    }

    /// What does not follow from the rest in the first steps of one of its stages, of moments one step apart; of motion too, if that
    /// is not right.
    pub fn followed(&self, moments: &[Snapshot], moves: bool) -> Option<Cause> {
        let mut bodies = self.task.start.bodies.clone();
        can_turn(&self.scene, &mut bodies);
        let case = |stage: Stage| {
            let model = Model::in_stage(&self.scene, stage);
            Case::new(&self.start, model, bodies.clone(), Vec::new())
        };
        let stages = moments.chunk_by(|one, next| one.stage == next.stage);
        stages.into_iter().find_map(|moments| {
            let first = moments.first()?;
            let made_under = case(first.constants());
            let found = terms::found(&[(&case(first.stage), moments)], Some(&made_under), moves);
            let stage = match first.stage {
                Stage::Settle => "pouring",
                Stage::Load => "loading",
            };
            let title = format!("{}, in {stage} from step {} on", self.start, first.step);
            let terms = found.terms.iter().map(|term| format!("{title}: {term}"));
            let terms: Vec<String> = terms.collect();
            (!terms.is_empty() || !found.unexplained.is_empty()).then(|| Cause {
                law: AS_A_SCENE.to_owned(),
                left_in: title,
                terms,
                unexplained: found.unexplained,
                ..Cause::default()
            })
        })
    }

    /// Whether the native engine makes these moments, to the last bit.
    pub fn has_bits(&self, moments: &[Snapshot]) -> bool {
        self.native(None)
            .is_ok_and(|own| have_same_bits(moments, &own))
    }

    /// Its moments as the native engine makes them.
    pub fn native(&self, noise: Option<Noise>) -> Result<Vec<Snapshot>, NativeError> {
        let mut seen: Vec<Snapshot> = Vec::new();
        self.run(noise, &mut seen)?;
        Ok(seen)
    }

    fn run(
        &self,
        noise: Option<Noise>,
        observer: &mut dyn Observer,
    ) -> Result<Vec<StageReport>, NativeError> {
        let options = native::Options {
            noise,
            ..native::Options::default()
        };
        native::run(&self.scene, &self.task, &options, observer).map(|outcome| outcome.stages)
    }

    fn envelope(&self, noise: Noise) -> Result<Envelope, NativeError> {
        let mut own: Vec<Snapshot> = Vec::new();
        let stages = self.run(None, &mut own)?;
        self.ends.get_or_init(|| ends(&stages));
        let runs = in_parallel(envelope::replicas(noise), |replica| {
            self.native(Some(envelope::of_replica(noise, replica)))
        });
        let runs: Result<Vec<_>, _> = runs.into_iter().collect();
        let stage = self.task.start.stage;
        let model = Model::in_stage(&self.scene, stage);
        let bodies = own
            .first()
            .map_or_else(Bodies::default, |snapshot| snapshot.bodies.clone());
        let case = Case::new(&self.start, model, bodies, Vec::new());
        let again = self.remembering_again(&own)?;
        let envelope = Envelope::of(case, own, &runs?, noise);
        Ok(again.iter().fold(envelope, |envelope, again| {
            envelope.reaching_the_last(again)
        }))
    }

    /// The last moment of the native run, made from its second one with what tables have of that one's memory.
    fn remembering_again(&self, own: &[Snapshot]) -> Result<Option<Snapshot>, NativeError> {
        let [first, .., last] = own else {
            return Ok(None);
        };
        if !self.remembers_by_tables {
            return Ok(None);
        }
        let mut finer = self.clone();
        if own.len() == 2 {
            finer.scene.measurement.history_every = ((last.step - first.step) / 2).max(1);
        }
        let moments = finer.native(None)?;
        let [_, before, .., _] = &moments[..] else {
            return Ok(None);
        };
        let mut again = self.clone();
        again.task = Task {
            start: Start {
                memory: remembered(&self.scene, before)?,
                ..before.clone().into()
            },
            until: Until::Step(last.step),
        };
        Ok(again.native(None)?.pop())
    }

    fn not_looked_at(&self, verdict: Verdict, why: Option<String>) -> OfStart {
        OfStart {
            verdict,
            skipped: why,
            ..OfStart::new(AS_A_SCENE, &self.start, &self.key)
        }
    }

    /// That the engine failed on it.
    pub fn failed(&self, why: String) -> OfStart {
        self.not_looked_at(Verdict::Different, Some(why))
    }

    /// Holds a run of it, and why its stages ended where that is told, against replicas of the native one.
    pub fn judge(
        &self,
        answer: Result<(Vec<Snapshot>, Option<Ends>), String>,
        resolution: Resolution,
    ) -> Result<OfStart, NativeError> {
        let (theirs, ended) = match answer {
            Ok(theirs) => theirs,
            Err(reason) => return Ok(self.not_looked_at(Verdict::Undecided, Some(reason))),
        };
        let mut judged = self.not_looked_at(Verdict::Undecided, None);
        let make = || self.envelope(resolution.noise());
        let envelope = envelope::once(&self.double, resolution, make)?;
        judged.farthest = envelope.farthest(&theirs);
        judged.verdict = verdict(&judged.farthest, &theirs, &envelope.own);
        judged.tables = envelope.tables_in_words(&theirs);
        judged.wide_from = envelope.wide_from();
        if let (Some(_), Some(ended), Some(own)) = (&judged.farthest, ended, self.ends.get())
            && ended != *own
        {
            let [told, right] = [&ended[..], &own[..]].map(in_words);
            return Ok(self.failed(format!(
                "it says {told}, and by the scene's rules it is {right}"
            )));
        }
        if judged.farthest.is_none() {
            judged.skipped = Some(other_moments(&envelope, &theirs));
            // A rule that holds between two steps may hold at another one where a step is rounded so.
            if !resolution.is_double() {
                judged.verdict = Verdict::Undecided;
            }
        }
        Ok(judged)
    }
}

fn in_words(ends: &[(Stage, StopReason)]) -> String {
    let each = ends
        .iter()
        .map(|(stage, stop)| format!("{} ended as {}", stage.name(), stop.name()));
    each.collect::<Vec<_>>().join(", ")
}

/// Where a run has other moments than the native one, and what became of it before.
fn other_moments(envelope: &Envelope, theirs: &[Snapshot]) -> String {
    let both = envelope.own.iter().zip(theirs);
    let alike =
        both.take_while(|(own, theirs)| (own.stage, own.step) == (theirs.stage, theirs.step));
    let count = alike.count();
    let at = |run: &[Snapshot]| {
        let moment = run.get(count);
        moment.map_or("none".to_owned(), |moment| {
            format!("{} {}", moment.stage.name(), moment.step)
        })
    };
    let [its, own] = [at(theirs), at(&envelope.own)];
    let far = envelope.farthest_from(&envelope.own[..count], &theirs[..count]);
    let before = match far.and_then(|far| far.left_after) {
        Some(step) => {
            format!("after {step} steps it was already farther off than rounding takes it")
        }
        None => "before that it is as far off as rounding takes it at most".to_owned(),
    };
    format!("{OTHER_MOMENTS}: {its} where {own} is to come; {before}")
}

const AS_A_SCENE: &str = "as a scene";

/// So many moments of a stage are looked at step by step.
const MOST_FOLLOWED: usize = 12;

/// The first moments of each stage.
#[derive(Debug, Default)]
pub struct FirstMoments(pub Vec<Snapshot>);

impl Observer for FirstMoments {
    fn snapshot(&mut self, snapshot: &Snapshot) {
        let of_stage = self.0.iter().filter(|one| one.stage == snapshot.stage);
        if of_stage.count() < MOST_FOLLOWED {
            self.0.push(snapshot.clone());
        }
    }
}

/// A pressure that no punch has, Pa.
const UNREACHED: f64 = 1.0e15;

/// A force that grows by less in a step may be reached in another one by rounding.
const LEAST_GROWN: f64 = 1.0 + 1.0e-4;

/// What contacts remember, as far as their table tells it: the tangential force; and along the normal what the force has more than spring
/// and dashpot, for a spring that is turned to the first order does not quite stay in the tangent.
fn remembered(scene: &Scene, snapshot: &Snapshot) -> Result<Memories, NativeError> {
    if snapshot.bodies.in_space() {
        return Ok(remembered_in_space(scene, snapshot));
    }
    let planar = snapshot.contacts.iter().map(Remembered::from).collect();
    let mut memory = Memories {
        planar,
        across: Vec::new(),
    };
    let task = Task {
        start: Start {
            memory: memory.clone(),
            ..snapshot.clone().into()
        },
        until: Until::Step(snapshot.step),
    };
    let mut seen: Vec<Snapshot> = Vec::new();
    native::run(scene, &task, &native::Options::default(), &mut seen)?;
    let made = seen.iter().flat_map(|moment| &moment.contacts);
    let made: BTreeMap<_, _> = made
        .map(|contact| (contact.ids(), contact.normal_force))
        .collect();
    for (memory, told) in memory.planar.iter_mut().zip(&snapshot.contacts) {
        let Some(made) = made.get(&told.ids()) else {
            continue;
        };
        let more = told.normal_force - made;
        let most = OUT_OF_TANGENT * told.tangential_force.abs() + ROUNDED * made.abs();
        if more.abs() <= most {
            memory.shear[0] += more * told.normal[0];
            memory.shear[1] += more * told.normal[1];
        }
    }
    Ok(memory)
}

/// The same in space, where the tangential force is the spring's and the dashpot's; of a contact that slides it is the spring's alone,
/// which is at its limit.
fn remembered_in_space(scene: &Scene, snapshot: &Snapshot) -> Memories {
    let start = Start::from(snapshot.clone());
    let model = Model::in_stage(scene, start.constants());
    let punch = start.punch_in(scene);
    let reference = Reference::holding(&model, &snapshot.bodies, punch, &snapshot.contacts);
    let mut memories = Memories::default();
    for (told, across) in snapshot.contacts.iter().zip(&snapshot.across) {
        let ([nx, nz], ny) = (told.normal, across.normal);
        let mut shear: Vector = across.tangential;
        let mut slides = false;
        if let Some(by) = reference.by_table(told.ids(), told.normal_force) {
            let more = told.normal_force - by.normal_force;
            let most = OUT_OF_TANGENT * hypot(shear) + ROUNDED * by.normal_force.abs();
            let told_shear = shear;
            if more.abs() <= most {
                shear = plus(shear, times(more, [nx, ny, nz]));
            }
            // In tables of fewer digits both forces have those of the engine, and the places make others.
            let uncertain = (more / by.normal_force).abs().min(UNCERTAIN);
            let is_at = |force: Vector, limit: f64, share: f64| {
                (hypot(force) - limit).abs() <= share * limit
            };
            slides =
                is_at(shear, by.limits[0], ROUNDED) || is_at(told_shear, by.limits[1], uncertain);
            if by.brakes_sliding || !slides {
                shear = minus(shear, by.braking);
            }
        }
        memories.planar.push(Remembered {
            shear: [shear[0], shear[2]],
            ..Remembered::from(told)
        });
        memories.across.push(RememberedAcross {
            normal: ny,
            shear: shear[1],
            bending: [0.0; 3],
            twisting: [0.0; 3],
            slides,
        });
    }
    memories
}

/// How much at most of Coulomb's limit is uncertain where a table has fewer digits.
const UNCERTAIN: f64 = 1.0e-6;

/// How much of a normal force is rounding.
const ROUNDED: f64 = 1.0e-9;

/// The forces on the punch, and what normal forces have of them, N.
struct Forces(Vec<[f64; 2]>);

impl Observer for Forces {
    fn snapshot(&mut self, snapshot: &Snapshot) {
        let id = BodyIds::of_box(snapshot.bodies.len() as u32).punch();
        let at_punch = snapshot.contacts.iter().filter(|contact| contact.id1 == id);
        let normal: f64 = at_punch
            .map(|contact| -contact.normal_force * contact.normal[1])
            .sum();
        self.0
            .extend(snapshot.punch.map(|punch| [punch.force, normal]));
    }
}
