//! What is wrong with an external engine: tiny jobs, each held against the native engine, and what is
//! found said in plain words.

pub mod table;

use serde::Serialize;

use crate::checks::{Check, ITSELF, Outcome};
use crate::compare::first_steps::{self, Beds};
use crate::document::{Document, Section};
use crate::engine::{Description, Engine, Part, ProgramError};
use crate::files::work_folder;
use crate::run::EngineError;
use crate::run::folder::stages_in_words;
use crate::suite::parameters::apart;
use crate::suite::{Grain, case, model, springs, world};
use grains::generate::{can_turn, initial_bodies};
use grains::native;
use grains::rules::{GivenVelocities, WrittenVelocities};
use grains::scene::{Cloud, Damping, Scene, paper_scene};
use grains::tables::{Bodies, Contact, Snapshot, Stage};
use grains::task::{Case, StageReport, Task};
use verdict::causes::Cause;
use verdict::envelope::Resolution;
use verdict::excerpt::Excerpt;
use verdict::invariance::{Depth, Held, Itself, RELATIONS, Relation};
use verdict::judge::{Judgement, Verdict};
use verdict::starts;

/// The ids of the checks of first steps begin with this.
const FIRST_STEPS: &str = "engine/first-steps";

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Conformance {
    pub engine: Description,
    #[serde(skip)]
    pub checks: Vec<Check>,
    /// What its first steps from a bed say; none if a job before them found no engine to ask.
    pub first_steps: Option<Judgement>,
}

impl Conformance {
    /// Different if a check failed, undecided if one was refused, else what its first steps say.
    pub fn verdict(&self) -> Verdict {
        if self
            .checks
            .iter()
            .any(|check| check.outcome == Outcome::Fail)
        {
            return Verdict::Different;
        }
        // Where nothing presses, relations hold of nothing.
        let presses = |check: &Check| {
            check.id == format!("{ITSELF}contacts") && check.outcome == Outcome::Pass
        };
        if self.engine.own_law.is_some() {
            return match self.checks.iter().any(presses) {
                true => Verdict::ConsistentWithItself,
                false => Verdict::Undecided,
            };
        }
        match &self.first_steps {
            Some(first_steps) if self.refused().is_none() => first_steps.verdict(),
            _ => Verdict::Undecided,
        }
    }

    /// A check that was required and not made.
    fn refused(&self) -> Option<&Check> {
        let mut checks = self.checks.iter();
        checks.find(|check| check.required && check.outcome == Outcome::Skipped)
    }

    /// Adds a check; what is no fault of the engine's own is handed back.
    fn add(&mut self, id: &str, job: &str, said: Said) -> Result<(), EngineError> {
        let (mut refused, mut failed) = (false, false);
        let (outcome, found) = match said {
            Ok(said) => (Outcome::Pass, said),
            Err(Trouble::Wrong(said)) => (Outcome::Fail, said),
            Err(Trouble::Skipped(why)) => (Outcome::Skipped, why),
            Err(Trouble::Engine(EngineError::Program(error))) if !error.is_no_fault_of_it() => {
                refused = matches!(error, ProgramError::Refused(_));
                failed = !refused && !error.was_understood();
                let outcome = [Outcome::Fail, Outcome::Skipped][usize::from(refused)];
                (outcome, error.to_string())
            }
            Err(Trouble::Engine(error)) => return Err(error),
        };
        let mut check = Check::of_words(format!("engine/{id}"), job, outcome, &found);
        (check.required, check.engine_failed) = (refused, failed);
        self.checks.push(check);
        Ok(())
    }

    fn with(mut self, first_steps: Judgement) -> Self {
        let checks = first_steps::checks(&first_steps, FIRST_STEPS);
        self.checks.extend(checks);
        self.first_steps = Some(first_steps);
        self
    }

    pub fn document(&self) -> Document {
        let engine = &self.engine;
        let parts: Vec<String> = engine.parts.iter().map(|part| part.name()).collect();
        let says = Section::new("What it says of itself", "")
            .with(format!("{}: {}.", engine.label(), parts.join(", ")))
            .with_all(engine.approximations.clone());
        let mut sections = vec![says];
        sections.extend(self.first_steps.iter().flat_map(first_steps::sections));
        if engine.own_law.is_some() {
            let about = format!(
                "It has a contact law of its own. States of a bed of {} grains are changed, run, and changed back; how far rounding takes the engine is \
                 told by its runs from starts with other last digits. What it does to every grain alike and nothing here changes is not seen, nor is what \
                 begins after {} steps, with more grains or with more contacts than are told of.",
                verdict::invariance::GRAINS,
                starts::MOMENTS[starts::MOMENTS.len() - 1]
            );
            sections.push(Section::new("Against itself", about));
        }
        Document {
            title: format!("Conformance of {}", engine.label()),
            verdict: self.verdict().into(),
            answer: self.answer(),
            sections,
            checks: self.checks.clone(),
        }
    }

    /// What relations hold of an engine with a law of its own.
    fn of_itself(&self) -> String {
        let relations = |outcome| {
            self.checks
                .iter()
                .filter(move |check| check.outcome == outcome)
        };
        let [held, open] =
            [Outcome::Pass, Outcome::Skipped].map(|outcome| relations(outcome).count());
        let open = match open {
            0 => String::new(),
            open => format!(" and {open} were not decided"),
        };
        let broken =
            relations(Outcome::Fail).map(|check| format!("{}: {}. ", check.quantity, check.found));
        let broken: String = broken.collect();
        format!("{broken}{held} relations hold{open}; it was not held against any reference.")
    }

    /// The relations that do not hold.
    fn broken(&self) -> Vec<&str> {
        let failed =
            |check: &&Check| check.outcome == Outcome::Fail && check.id.starts_with(ITSELF);
        let checks = self.checks.iter().filter(failed);
        checks.map(|check| check.quantity.as_str()).collect()
    }

    /// A cause that the first steps name is what the failures of the small jobs come from: it is said alone.
    fn answer(&self) -> String {
        if self.engine.own_law.is_some() {
            return first_steps::sentence(&self.of_itself());
        }
        let small =
            |check: &&Check| check.outcome == Outcome::Fail && !check.id.starts_with(FIRST_STEPS);
        let causes = self
            .first_steps
            .as_ref()
            .map_or(&[][..], |judgement| &judgement.causes);
        let explained = !causes.is_empty() && causes.iter().all(Cause::is_named);
        let differs = self.first_steps.as_ref().is_some_and(|judgement| {
            judgement.verdict() == Verdict::Different && !judgement.causes.is_empty()
        });
        // A job that says no more than that grains are elsewhere, or that the engine contradicts itself, says less than first steps.
        let says_less =
            |check: &Check| check.id.starts_with(ITSELF) || check.found.starts_with("step ");
        let mut small = self.checks.iter().filter(small).filter(|_| !explained);
        let small = small.find(|check| !(differs && says_less(check)));
        let first = self.first_steps.as_ref().map(first_steps::answer);
        let said = match (small, self.refused(), first) {
            (Some(check), _, first) => {
                let says = |cause: &Cause| cause.condition.is_some() || !cause.terms.is_empty();
                let first = first.filter(|_| causes.is_empty() || causes.iter().any(says));
                let first = first.map_or(String::new(), |answer| {
                    format!(" Its first steps: {answer}")
                });
                let found = match check.id.starts_with(ITSELF) {
                    true => format!("{}: {}", check.quantity, check.found),
                    false => check.found.clone(),
                };
                let broken = self.broken();
                let broken = match broken.is_empty() {
                    true => String::new(),
                    false => format!(" It contradicts itself: {}.", broken.join("; ")),
                };
                format!("{found}. Mend this first: the rest may come from it.{broken}{first}")
            }
            (_, Some(check), Some(first)) => format!("{}. Its first steps: {first}", check.found),
            (_, None, Some(first)) => match self.broken() {
                broken if !broken.is_empty() => {
                    format!("{first} It contradicts itself: {}.", broken.join("; "))
                }
                _ => first,
            },
            (_, _, None) => {
                let why = self.checks.iter().find(|check| check.id == FIRST_STEPS);
                let why = why.map_or(String::new(), |check| format!(": {}", check.found));
                format!("its first steps were not looked at{why}.")
            }
        };
        let id = "engine/every-step";
        let followed = |check: &Check| check.id == id && check.outcome == Outcome::Pass;
        let agrees = [Verdict::Identical, Verdict::EqualToRounding].contains(&self.verdict());
        let more = match agrees && self.checks.iter().any(followed) {
            true => format!(" Of a small bed {LONG} steps were looked at, each of them."),
            false => String::new(),
        };
        first_steps::with_verdict(self.verdict(), &(said + &more))
    }
}

/// Runs the small jobs, which a program that this one translates for is spared, and the first steps from a bed; `progress` hears
/// the name of each.
pub fn conformance(
    engine: &dyn Engine,
    beds: &Beds,
    progress: &mut dyn FnMut(&str),
) -> Result<Conformance, EngineError> {
    let mut found = Conformance {
        engine: engine.describe()?,
        checks: Vec::new(),
        first_steps: None,
    };
    if found.engine.own_law.is_some() {
        against_itself(engine, beds, &mut found, progress)?;
        return Ok(found);
    }
    let first_steps = match found.engine.has(Part::Cases) {
        true => first_steps::first_steps(engine, beds, progress).map_err(Trouble::from),
        false => Err(has_no_cases()),
    };
    // The jobs allow what double precision needs.
    let resolution = first_steps.as_ref().map(|judgement| judgement.resolution);
    let single = resolution.is_ok_and(|resolution| !resolution.is_double());
    if engine.is_of_this_program() {
        return match first_steps {
            Ok(first_steps) => Ok(found.with(first_steps)),
            Err(Trouble::Engine(error)) => Err(error),
            Err(_) => Ok(found),
        };
    }
    for job in jobs() {
        progress(job.id);
        let job = Job { single, ..job };
        let said = against_native(engine, &job);
        found.add(job.id, job.what, said)?;
    }
    progress("again");
    let said = again(engine);
    found.add("again", "the small bed once more", said)?;
    progress("every step");
    let differs = |found: &Judgement| found.verdict() == Verdict::Different;
    let known = found.verdict() == Verdict::Different || first_steps.as_ref().is_ok_and(differs);
    let said = match known {
        // Thousands of steps of an engine that differs in its first hundred say nothing more.
        true => Err(Trouble::Skipped("it differs before".to_owned())),
        false => {
            let resolution = first_steps.as_ref().map(|found| found.resolution);
            every_step(engine, resolution.unwrap_or(Resolution::COARSE_DOUBLE))
        }
    };
    found.add("every-step", "a small bed poured for some thousand steps, native going on from each of its moments to the next", said)?;
    progress("cases");
    let said = cases(engine, single);
    let what = "two lists of grains in one start, each looked at three times";
    found.add("cases", what, said)?;
    match first_steps {
        Ok(judgement) => found = found.with(judgement),
        Err(trouble) => {
            found.add("first-steps", "its first steps from a bed", Err(trouble))?;
            // Without them nothing is decided.
            for check in &mut found.checks {
                check.required |= check.id == FIRST_STEPS;
            }
        }
    }
    against_itself(engine, beds, &mut found, progress)?;
    Ok(found)
}

/// Adds what must be true of any law.
fn against_itself(
    engine: &dyn Engine,
    beds: &Beds,
    found: &mut Conformance,
    progress: &mut dyn FnMut(&str),
) -> Result<(), EngineError> {
    if !found.engine.has(Part::Cases) {
        return found.add("itself/cases", "held against itself", Err(has_no_cases()));
    }
    let own = found.engine.own_law.clone();
    let lacks = |case: &Case| engine.lacks_for(case);
    let mut run = |cases: &[&Case]| {
        let work = work_folder().map_err(ProgramError::File)?;
        engine.run_cases(cases, work.path())
    };
    progress("against itself");
    let known = found.first_steps.as_ref();
    let resolution = known.map_or(Resolution::DOUBLE, |known| known.resolution);
    let depth = match beds.thorough || found.engine.own_law.is_some() {
        true => Depth::All,
        false => Depth::Richest(resolution),
    };
    let itself = match Itself::new(beds.for_itself()?, depth, own.as_deref(), &lacks, &mut run) {
        Ok(itself) => itself.under(engine.rules()),
        Err(error) => {
            let what = "small beds as they are";
            return found.add("itself/beds", what, Err(Trouble::Engine(error)));
        }
    };
    let asked = |relation: &&Relation| relation.is_asked(depth);
    for relation in RELATIONS.iter().filter(asked) {
        progress(relation.name);
        let said = match relation.held(&itself, &mut run) {
            Ok(Held::Holds(said)) => Ok(said),
            Ok(Held::Open(why)) => Err(Trouble::Skipped(why)),
            Ok(Held::Breaks(said)) => Err(Trouble::Wrong(format!(
                "{said}. What usually breaks this: {}",
                relation.breaks
            ))),
            Err(error) => Err(Trouble::Engine(error)),
        };
        let id = format!("itself/{}", relation.key);
        found.add(&id, relation.name, said)?;
    }
    Ok(())
}

/// What a job came to if it is not right.
enum Trouble {
    Wrong(String),
    /// The engine has no such parts.
    Skipped(String),
    /// One of the two engines failed, or the other one has the parts and refused.
    Engine(EngineError),
}

/// What a job came to.
type Said = Result<String, Trouble>;

impl<E: Into<EngineError>> From<E> for Trouble {
    fn from(error: E) -> Self {
        Trouble::Engine(error.into())
    }
}

/// A run of a job: its moments and how its stages ended.
#[derive(Debug, Default, Clone)]
struct Story {
    moments: Vec<Snapshot>,
    stages: Vec<StageReport>,
}

fn in_engine(engine: &dyn Engine, job: &Job) -> Result<Story, EngineError> {
    let mut story = Story::default();
    let work = work_folder().map_err(ProgramError::File)?;
    let run = engine.run(&job.scene, &job.task, work.path(), &mut story.moments)?;
    story.stages = run.outcome.stages;
    Ok(story)
}

fn has_no_cases() -> Trouble {
    let why = "the engine says that it has no lists of small experiments (cases)";
    Trouble::Skipped(why.to_owned())
}

/// Whether the engine says that it has everything that is asked.
fn has_all(lacking: Option<String>) -> Result<(), Trouble> {
    lacking.map_or(Ok(()), |parts| {
        let why = format!("the engine says that it has no {parts}");
        Err(Trouble::Skipped(why))
    })
}

fn against_native(engine: &dyn Engine, job: &Job) -> Said {
    has_all(engine.lacks(&job.scene, &job.task))?;
    // By the rules that it declares.
    let mut under = Job {
        scene: job.scene.clone(),
        task: job.task.clone(),
        ..*job
    };
    under.scene.rules = engine.rules().over(under.scene.rules);
    let native = match in_engine(&native::Options::default(), &under) {
        Err(error) if !engine.rules().are_usual() => return no_run(&error),
        native => native?,
    };
    let theirs = in_engine(engine, job)?;
    let tolerance = job.slack * rounding(job.single);
    (job.judge)(job, &theirs, &native)
        .and_then(|()| moments_agree(&theirs.moments, &native.moments, tolerance))
        .map(|()| how_close(&theirs, &native))
        .map_err(Trouble::Wrong)
}

/// Rules may be such that nothing stays in the box.
fn no_run(error: &EngineError) -> Said {
    let why = format!("by the engine's rules there is no such run: {error}");
    Err(Trouble::Skipped(why))
}

/// The same job twice must give the same bits.
fn again(engine: &dyn Engine) -> Said {
    let job = bed();
    has_all(engine.lacks(&job.scene, &job.task))?;
    if in_engine(engine, &job)?.moments == in_engine(engine, &job)?.moments {
        return Ok("the same bits both times".to_owned());
    }
    let why = "two runs of one job have other bits: threads that add forces in the order in which they come, or a random \
               number without a fixed seed";
    Err(Trouble::Wrong(why.to_owned()))
}

/// What is wrong late in a run alone, or now and then, is in no first steps: the native engine goes on from each moment that a longer run
/// tells, and what the run tells next is among its replicas.
fn every_step(engine: &dyn Engine, resolution: Resolution) -> Said {
    let rules = engine.rules();
    if rules.written_velocities == WrittenVelocities::WholeStep {
        let why = "by the engine's rules the velocities that are written are no start";
        return Err(Trouble::Skipped(why.to_owned()));
    }
    let lacks = |job: &Job| engine.lacks(&job.scene, &job.task);
    let jobs = [
        (true, long_pouring as fn(bool) -> Job),
        (false, long_pouring),
        (true, long_pouring_in_space),
        (false, long_pouring_in_space),
    ];
    let told = jobs
        .into_iter()
        .filter(|(rough, _)| !rough || rules.springs_are_forces());
    let mut jobs = told.map(|(rough, job)| job(rough));
    let asked = jobs.find(|job| lacks(job).is_none());
    let mut job = asked.unwrap_or_else(|| long_pouring(false));
    has_all(lacks(&job))?;
    let run = in_engine(engine, &job);
    job.scene.rules = rules.over(job.scene.rules);
    let moments = match run {
        Err(error) if !rules.are_usual() => {
            return match in_engine(&native::Options::default(), &job) {
                Err(own) => no_run(&own),
                Ok(_) => Err(error.into()),
            };
        }
        run => run?.moments,
    };
    let mut scene = job.scene;
    for pair in moments.windows(2) {
        let (from, to) = (pair[0].step, pair[1].step);
        let excerpt = Excerpt::of_moments(&scene, &pair[0], to)?;
        let judged = excerpt.judge(
            Ok((pair.to_vec(), None)),
            resolution.coarser(Resolution::COARSE_DOUBLE),
        )?;
        // What was written goes on as it is written.
        scene.rules.given_velocities = GivenVelocities::HalfStepBefore;
        if judged.verdict == Verdict::Different {
            let found = judged.skipped.clone().unwrap_or(judged.in_words());
            let why = format!("gone on with by native from step {from} to step {to}: {found}");
            return Err(Trouble::Wrong(why));
        }
    }
    match moments.last() {
        Some(last) if last.step == LONG => Ok(format!(
            "equal to rounding from each moment to the next, {} steps in all; {} contacts at the end",
            LONG,
            last.contacts.len()
        )),
        _ => Err(Trouble::Wrong(format!(
            "it did not make the {LONG} steps that were asked for"
        ))),
    }
}

/// A list of two small experiments in one start.
fn cases(engine: &dyn Engine, single: bool) -> Said {
    let cases = two_cases();
    has_all(cases.iter().find_map(|case| engine.lacks_for(case)))?;
    let work = work_folder().map_err(ProgramError::File)?;
    let asked: Vec<_> = cases.iter().collect();
    let results = engine.run_cases(&asked, work.path())?;
    for (case, result) in cases.iter().zip(results) {
        let refused = |reason| ProgramError::Refused(format!("{}: {reason}", case.name));
        let theirs = result.map_err(refused)?;
        let mut under = case.clone();
        under.model.rules = engine.rules().over(under.model.rules);
        let native = native::run_case(&under, None)?;
        moments_agree(&theirs, &native, rounding(single))
            .map_err(|said| Trouble::Wrong(format!("{}: {said}", case.name)))?;
    }
    Ok("both as they should be".to_owned())
}

fn contacts_agree(job: &Job, theirs: &Snapshot, native: &Snapshot) -> Result<(), String> {
    let pairs = |snapshot: &Snapshot| {
        snapshot
            .contacts
            .iter()
            .map(Contact::ids)
            .collect::<Vec<_>>()
    };
    let (found, wanted) = (pairs(theirs), pairs(native));
    if let Some((one, two)) = wanted.iter().find(|pair| !found.contains(pair)) {
        return Err(format!(
            "bodies {one} and {two} touch, and no contact of them is written: grains have the ids from 0, then come the walls \
             in the order of job.json, then the punch; a wall stands first"
        ));
    }
    if let Some((one, two)) = found.iter().find(|pair| !wanted.contains(pair)) {
        return Err(format!(
            "bodies {one} and {two} do not touch, and a contact of them is written"
        ));
    }
    let mut contacts = theirs.contacts.iter().zip(&native.contacts);
    contacts.try_for_each(|(their, own)| contact_agrees(job, their, own))
}

fn contact_agrees(job: &Job, their: &Contact, own: &Contact) -> Result<(), String> {
    let near = |a, b, scale| job.near(a, b, scale);
    let pair = format!("contact of bodies {} and {}", own.id1, own.id2);
    // Lengths against the size of a grain, about a hundred times an overlap at most.
    let length = 1.0e-2;
    if !near(their.overlap, own.overlap, length) {
        return Err(format!(
            "{pair}: overlap {:e} m where {:e} m is right: R1 + R2 − distance, and R − distance at a wall",
            their.overlap, own.overlap
        ));
    }
    let both = |a: [f64; 2], b: [f64; 2]| near(a[0], b[0], 1.0) && near(a[1], b[1], 1.0);
    if both(their.normal, own.normal.map(|component| -component)) {
        return Err(format!(
            "{pair}: the normal points from body 2 to body 1, and is to point from body 1 to body 2"
        ));
    }
    if !both(their.normal, own.normal) {
        let (found, right) = (their.normal, own.normal);
        return Err(format!("{pair}: normal {found:?} where {right:?} is right"));
    }
    // An overlap's own rounding, times the stiffness.
    let slack = own.normal_force * length / own.overlap.max(f64::MIN_POSITIVE);
    if !near(their.normal_force, own.normal_force, slack) {
        return Err(format!(
            "{pair}: normal force {:e} N where {:e} N is right, {:.6} of it; k_n = 2·E·R1·R2/(R1 + R2), a wall counts as a grain \
             of the same radius, and compression is positive",
            their.normal_force,
            own.normal_force,
            their.normal_force / own.normal_force
        ));
    }
    if !both(their.point, own.point) {
        return Err(format!(
            "{pair}: contact point {:?} where {:?} is right: from body 1's centre by R1 − overlap/2 along the normal; on the wall",
            their.point, own.point
        ));
    }
    Ok(())
}

/// The first moment and grain that is farther off than `tolerance` of its radius, or has another velocity.
fn moments_agree(theirs: &[Snapshot], native: &[Snapshot], tolerance: f64) -> Result<(), String> {
    let (found, wanted) = (theirs.len(), native.len());
    if found != wanted {
        return Err(format!("{found} moments instead of {wanted}"));
    }
    for (their, own) in theirs.iter().zip(native) {
        let (of_them, of_us) = (&their.bodies, &own.bodies);
        for id in 0..of_us.len() {
            let apart = (of_them.x[id] - of_us.x[id]).hypot(of_them.z[id] - of_us.z[id]);
            let slower = (of_them.vx[id] - of_us.vx[id]).hypot(of_them.vz[id] - of_us.vz[id]);
            // A velocity of 1 m/s is about what grains have.
            if !(apart <= tolerance * of_us.radius[id] && slower <= 100.0 * tolerance) {
                let state = |bodies: &Bodies| {
                    let (x, z, vx, vz) = (bodies.x[id], bodies.z[id], bodies.vx[id], bodies.vz[id]);
                    format!("at ({x:e}, {z:e}) m with ({vx:e}, {vz:e}) m/s")
                };
                let (found, wanted, step) = (state(of_them), state(of_us), own.step);
                let off = apart / of_us.radius[id];
                return Err(format!(
                    "step {step}, grain {id}: {found}, and should be {wanted}: {off:.2e} R off, and {tolerance:.0e} R is the most"
                ));
            }
        }
    }
    Ok(())
}

/// How close a run is that is close enough.
fn how_close(theirs: &Story, native: &Story) -> String {
    if theirs.moments == native.moments {
        return "every bit is the native engine's".to_owned();
    }
    let moments = theirs.moments.iter().zip(&native.moments);
    let largest = moments
        .flat_map(|(their, own)| apart(their, own))
        .fold(0.0, f64::max);
    format!("within {largest:.1e} R of the native engine: rounding")
}

/// Gravity and the order of a step, by what the numbers look like.
fn judge_flight(job: &Job, theirs: &Story, native: &Story) -> Result<(), String> {
    let given = &job.task.start.bodies;
    let (dt, g) = (job.scene.time_step_seconds(), job.scene.gravity);
    let (their, own) = (&theirs.moments[1].bodies, &native.moments[1].bodies);
    let (z, v) = (given.z[0], given.vz[0]);
    let (fallen, gained) = (their.z[0] - z, their.vz[0] - v);
    let gained_is = |share: f64| job.nearly(gained, share * g * dt, g * dt);
    // In single precision the last bit of a place may be larger than what gravity does in a step.
    let last_bit = if job.single {
        f64::from(f32::EPSILON) * z.abs()
    } else {
        0.0
    };
    let is_told = last_bit < 0.1 * g * dt * dt;
    let fallen_is =
        |way: f64| (fallen - way).abs() <= last_bit || job.nearly(fallen, way, g * dt * dt);
    let wanted = own.vz[0] - v;
    let right = own.z[0] - z;
    let gains = job.nearly(gained, wanted, g * dt);
    if gains && fallen_is(right) {
        return Ok(());
    }
    let looks_like = [
        (
            gained_is(0.0),
            "after a step the velocity is the one of the start: gravity is missing, or velocities are written before the step",
        ),
        (
            gained_is(1.0),
            "gravity points up; model.gravity is (x, z) with its sign",
        ),
        (
            gained_is(-0.5) || gained_is(-1.5),
            "after a step the velocity has half a kick too few or too many: velocities here belong to the half step before the \
             positions, so each step gives a whole kick, v += dt·a, and then x += dt·v",
        ),
        (
            is_told && fallen_is(v * dt),
            "the grain was moved with the velocity before the kick: first v += dt·a, then x += dt·v",
        ),
        (
            is_told && fallen_is(v * dt - 0.5 * g * dt * dt),
            "the grain was moved by v·dt + ½a·dt²: the velocity that is given belongs to the half step before, so it is moved by \
             (v + dt·a)·dt",
        ),
    ];
    if let Some((_, why)) = looks_like.into_iter().find(|(so, _)| *so) {
        return Err(why.to_owned());
    }
    if gains {
        return Err(format!(
            "after a step the velocity is right and z has changed by {fallen:e} m, where {right:e} m is right: x += dt·v with \
             the velocity after the kick, and nothing else"
        ));
    }
    Err(format!(
        "after a step vz has changed by {gained:e} m/s, and {wanted:e} m/s is right (dt = {dt:e} s, gravity {g} m/s²)"
    ))
}

fn judge_damping(job: &Job, theirs: &Story, native: &Story) -> Result<(), String> {
    let given = &job.task.start.bodies;
    let kick = job.scene.gravity * job.scene.time_step_seconds();
    let alpha = job.scene.damping.alpha();
    let (their, own) = (&theirs.moments[1].bodies, &native.moments[1].bodies);
    let names = ["falls", "rises", "turns round in the step"];
    for (id, name) in names.iter().enumerate() {
        let (gained, wanted) = (their.vz[id] - given.vz[id], own.vz[id] - given.vz[id]);
        let is = |expected: f64| job.nearly(gained, expected, kick);
        let why = match id {
            _ if is(wanted) => continue,
            _ if is(-kick) => "it is not damped at all",
            2 => {
                "the sign must be that of a·(v + ½Δt·a), with the velocity in the middle of the kick"
            }
            _ if is(-2.0 * kick - wanted) => {
                "the sign is the wrong way round: what speeds a grain up is made smaller, what slows it down larger"
            }
            _ => {
                "each component of the acceleration, gravity included, must be multiplied by 1 − α·sign(a·(v + ½Δt·a))"
            }
        };
        return Err(format!(
            "the grain that {name}: vz changes by {gained:e} m/s, and should change by {wanted:e} m/s (α = {alpha}): {why}"
        ));
    }
    Ok(())
}

/// The settle rule ended the run where it should.
fn judge_rules(_: &Job, theirs: &Story, native: &Story) -> Result<(), String> {
    let end = |story: &Story| story.stages.last().map(|stage| (stage.steps, stage.stop));
    if end(theirs) == end(native) {
        return Ok(());
    }
    let [found, wanted] = [theirs, native].map(|story| stages_in_words(&story.stages));
    Err(format!(
        "it ended after {found}, and should after {wanted}: every settle.check_every steps, not at step 0, \
         the kinetic energy Σ½mv² + Σ½Iω² of the written velocities is compared with kinetic_energy_fraction times the largest that was \
         seen at such a step, this one included"
    ))
}

/// The punch, its force and the grains below it.
fn judge_punch(job: &Job, theirs: &Story, native: &Story) -> Result<(), String> {
    for (their, own) in theirs.moments.iter().zip(&native.moments) {
        let step = own.step;
        let (Some(found), Some(wanted)) = (their.punch, own.punch) else {
            let why = "no punch is written, and loading has one from its start";
            return Err(format!("step {step}: {why}"));
        };
        let near = |axis: usize| job.near(found.centre[axis], wanted.centre[axis], 1.0e-2);
        if !(near(0) && near(1)) {
            return Err(format!(
                "step {step}: the punch's centre is at {:?} m and should be at {:?} m: it starts on the highest grain below it and \
                 moves by its velocity times dt a step",
                found.centre, wanted.centre
            ));
        }
        // Rounding of overlaps, times a stiffness: of coordinates in single precision k_n = 2ER.
        let least = match job.single {
            true => {
                let length = f64::from(f32::EPSILON) * wanted.centre[1].abs();
                let (modulus, size) = (
                    job.scene.material.youngs_modulus,
                    job.scene.particles.mean_diameter,
                );
                FLOAT_OVERLAPS * length * modulus * size / rounding(true)
            }
            false => 1.0,
        };
        let (found, wanted) = (found.force, wanted.force);
        if !job.nearly(found, wanted, wanted.abs().max(least)) {
            return Err(format!(
                "step {step}: the force on the punch is {found:e} N and should be {wanted:e} N: what grains push it up with, \
                 positive upwards"
            ));
        }
    }
    Ok(())
}

/// An overlap is a difference of so many rounded lengths.
const FLOAT_OVERLAPS: f64 = 4.0;
/// In a bed after some hundred steps rounding has grown by so much.
const GROWN: f64 = 1.0e3;

/// What the numbers of a run look like, if they are wrong; held against the native run.
type Judge = fn(&Job, &Story, &Story) -> Result<(), String>;

struct Job {
    id: &'static str,
    what: &'static str,
    scene: Scene,
    task: Task,
    /// The engine computes in single precision.
    single: bool,
    /// How much more than rounding's beginnings its moments may be off.
    slack: f64,
    judge: Judge,
}

impl Job {
    fn new(id: &'static str, what: &'static str, run: (Scene, Task), judge: Judge) -> Self {
        let (scene, task) = run;
        Job {
            id,
            what,
            scene,
            task,
            single: false,
            slack: 1.0,
            judge,
        }
    }

    /// Nearer than this, over what the step changes, two numbers are one.
    fn near(&self, a: f64, b: f64, scale: f64) -> bool {
        (a - b).abs() <= rounding(self.single) * scale
    }

    /// The same with more room, where a number looks like another cause's.
    fn nearly(&self, a: f64, b: f64, scale: f64) -> bool {
        self.near(a, b, if self.single { scale } else { 1.0e3 * scale })
    }
}

/// Largest difference over the radius that rounding explains after some tens of steps of one contact.
fn rounding(single: bool) -> f64 {
    if single { 1.0e-3 } else { 1.0e-9 }
}

/// All of them, from what everything rests on to what rests on all of it.
fn jobs() -> [Job; 8] {
    let moments_alone: Judge = |_, _, _| Ok(());
    let three = [
        ([0.004999, 0.004999], [0.0, 0.0], 0.005),
        ([0.014997, 0.0051], [0.1, 0.2], 0.005),
        ([0.5, 0.3], [0.0, 0.0], 0.004),
    ];
    let flying = [
        ([0.3, 0.3], [0.2, -0.1], 0.005),
        ([0.5, 0.3], [0.2, 0.1], 0.005),
        ([0.7, 0.3], [0.0, 0.00001], 0.005),
    ];
    let into_a_corner = [([0.0051, 0.0052], [-0.3, -0.4], 0.005)];
    let meeting = [
        ([0.5, 0.3], [0.3, 0.0], 0.005),
        ([0.5091, 0.3005], [-0.3, 0.1], 0.004),
    ];
    [
        Job::new(
            "start",
            "three grains, no step: the start and its contacts as they are",
            grains(&three, 0, 1),
            |job, theirs, native| contacts_agree(job, &theirs.moments[0], &native.moments[0]),
        ),
        flight(),
        Job::new(
            "damping",
            "grains in the air that rise, fall and turn round, two steps with Cundall's damping",
            grains(&flying, 2, 1),
            judge_damping,
        ),
        Job::new(
            "walls",
            "one grain into the corner of floor and wall",
            grains(&into_a_corner, 60, 10),
            moments_alone,
        ),
        Job::new(
            "pair",
            "two grains of other sizes meet",
            grains(&meeting, 40, 5),
            moments_alone,
        ),
        bed(),
        rules(),
        punch(),
    ]
}

/// One grain: place, velocity, radius.
type Given = ([f64; 2], [f64; 2], f64);

/// Some grains in the paper's box for so many steps, looked at every `every`.
fn grains(given: &[Given], steps: u64, every: u64) -> (Scene, Task) {
    let mut scene = paper_scene(1, given.len() as u32);
    scene.measurement.history_every = every;
    let mut bodies = Bodies::default();
    for &(position, velocity, radius) in given {
        bodies.push(position, velocity, radius, scene.grain_mass(radius));
    }
    (scene, Task::pour(bodies, steps))
}

fn flight() -> Job {
    let (mut scene, task) = grains(&[([0.5, 0.3], [0.2, -0.1], 0.005)], 2, 1);
    scene.damping = Damping::Cundall { alpha: 0.0 };
    let what = "one grain in the air for two steps, no damping: gravity and the order of a step";
    Job::new("flight", what, (scene, task), judge_flight)
}

/// A small bed of one size.
fn small_bed(grains: u32) -> Scene {
    let mut scene = paper_scene(1, grains);
    scene.particles.dispersion = 0.0;
    scene.container.width = 0.06;
    let Cloud::JitteredLattice { columns, .. } = &mut scene.cloud;
    *columns = 5;
    scene.loading.half_width = 0.012;
    scene.loading.give_up_depth = 0.005;
    scene.control_points.clear();
    scene.measurement.history_every = 100;
    scene
}

fn bed() -> Job {
    let scene = small_bed(20);
    let task = Task::pour(initial_bodies(&scene), 400);
    let what = "twenty grains of one size, poured for 400 steps";
    let mut job = Job::new("bed", what, (scene, task), |_, _, _| Ok(()));
    job.slack = GROWN;
    job
}

/// Steps of the longest of these jobs.
const LONG: u64 = 6400;

/// With friction, or springs alone.
fn long_pouring(rough: bool) -> Job {
    let mut scene = small_bed(60);
    scene.particles.dispersion = 0.05;
    if rough {
        scene.material.friction_angle = 0.5;
        scene.material.stiffness_ratio = 0.3;
    }
    let mut bodies = initial_bodies(&scene);
    // Few radii: some engines have stiffnesses for so many.
    for id in 0..bodies.len() {
        let radius = 0.005 * (1.0 - 0.01 * (id % 5) as f64);
        (bodies.radius[id], bodies.mass[id]) = (radius, scene.grain_mass(radius));
    }
    // They are on the floor soon.
    bodies.vz.fill(-2.0);
    can_turn(&scene, &mut bodies);
    let task = Task::pour(bodies, LONG);
    Job::new("every-step", "", (scene, task), |_, _, _| Ok(()))
}

/// Of spheres, with friction and dashpots, or frictionless.
fn long_pouring_in_space(rough: bool) -> Job {
    let mut scene = verdict::spheres::scene();
    scene.particles.count = 60;
    if !rough {
        scene.material.friction_angle = 0.0;
    }
    scene.measurement.history_every = 100;
    let mut bodies = initial_bodies(&scene);
    bodies.vz.fill(-2.0);
    let task = Task::pour(bodies, LONG);
    Job::new("every-step", "", (scene, task), |_, _, _| Ok(()))
}

fn rules() -> Job {
    let mut scene = small_bed(3);
    // The energy grows until the grains meet the floor, so the largest is not that of the first look.
    scene.settle.kinetic_energy_fraction = 0.3;
    scene.settle.check_every = 200;
    let mut bodies = Bodies::default();
    for (x, z) in [(0.01, 0.010), (0.03, 0.012), (0.05, 0.015)] {
        bodies.push([x, z], [0.0; 2], 0.005, scene.grain_mass(0.005));
    }
    let task = Task::settle(bodies);
    let what = "three grains that fall and rebound apart, until the settle rule holds";
    let mut job = Job::new("rules", what, (scene, task), judge_rules);
    job.slack = GROWN;
    job
}

fn punch() -> Job {
    let mut scene = small_bed(5);
    scene.loading.speed = 0.5;
    scene.measurement.history_every = 20;
    let radius = 0.005;
    let mut bodies = Bodies::default();
    for column in 0..5 {
        let x = 0.008 + 0.011 * f64::from(column);
        bodies.push([x, radius], [0.0; 2], radius, scene.grain_mass(radius));
    }
    let mut task = Task::pour(bodies, 60);
    task.start.stage = Stage::Load;
    let what = "the punch comes down on five grains on the floor for 60 steps";
    Job::new("punch", what, (scene, task), judge_punch)
}

/// Two experiments that are no scenes.
fn two_cases() -> [Case; 2] {
    let small = |x: f64, speed: f64| Grain::disc([x, 0.0], 0.5, 1000.0).moving([speed, 0.0]);
    let law = springs(1.0e6);
    let on_wall = world(law.clone(), 1.0e-3, [0.0; 2], 0.0, [&[2.0], &[]]);
    let two = [small(0.0, 1.0), small(1.001, -1.0)];
    [
        ("two grains meet", model(law, 1.0e-3), &two[..]),
        (
            "a grain meets a wall from the left",
            on_wall,
            &[small(1.499, 1.0)],
        ),
    ]
    .map(|(name, model, grains)| case(name, model, grains, vec![0, 7, 30]))
}
