//! What is wrong with an external engine: tiny jobs, each held against the native engine, and what is
//! found said in plain words.

mod jobs;
pub mod table;

use jobs::Job;
use serde::Serialize;

use crate::checks::{Check, Outcome};
use crate::compare::first_steps::{self, Asked, Beds};
use crate::document::{Document, Section};
use crate::engine::exec::{self, Description, Options, Part};
use crate::engine::{ProgramError, yade};
use crate::files::work_folder;
use crate::run::EngineError;
use grains::native::{self, NativeError};
use grains::tables::{Contact, Snapshot};
use grains::task::{Observer, Outcome as Ended};
use verdict::judge::{Judgement, Verdict};

/// The ids of the checks of first steps begin with this.
const FIRST_STEPS: &str = "engine/first-steps";

/// All checks of an engine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Conformance {
    /// What the engine says of itself.
    pub engine: Description,
    /// The checks, in order.
    pub checks: Vec<Check>,
    /// What its first steps from a bed say; none if a job before them found no engine to ask.
    pub first_steps: Option<Judgement>,
    /// A check failed because the engine gave nothing to judge: it crashed, hung or was not understood.
    pub engine_failed: bool,
}

impl Conformance {
    /// Different if a check failed, undecided if one was refused, else what its first steps say.
    pub fn verdict(&self) -> Verdict {
        if self.checks.iter().any(|of| of.outcome == Outcome::Fail) {
            return Verdict::Different;
        }
        // Required and not made: it was refused.
        if self
            .checks
            .iter()
            .any(|of| of.required && of.outcome == Outcome::Skipped)
        {
            return Verdict::Undecided;
        }
        let first_steps = self.first_steps.as_ref();
        first_steps.map_or(Verdict::Undecided, Judgement::verdict)
    }

    /// What people are told.
    pub fn document(&self) -> Document {
        let engine = &self.engine;
        let parts: Vec<&str> = engine.parts.iter().map(|part| part.name()).collect();
        let mut says = Section::new("What it says of itself", "");
        says = says.with(format!("{}: {}.", engine.label(), parts.join(", ")));
        for approximation in &engine.approximations {
            says = says.with(approximation.clone());
        }
        let mut sections = vec![says];
        sections.extend(self.first_steps.iter().flat_map(first_steps::sections));
        Document {
            title: format!("Conformance of {}", engine.label()),
            verdict: self.outcome(),
            answer: self.answer(),
            sections,
            checks: self.checks.clone(),
        }
    }

    /// The verdict as the outcome of a job.
    pub fn outcome(&self) -> Outcome {
        self.verdict().into()
    }

    fn answer(&self) -> String {
        let verdict = self.verdict().in_words();
        let small = self
            .checks
            .iter()
            .find(|of| of.outcome == Outcome::Fail && !of.id.starts_with(FIRST_STEPS));
        let first = self.first_steps.as_ref().map(first_steps::answer);
        match (small, first) {
            (Some(check), first) => {
                let first = first.map_or(String::new(), |of| format!(" {of}"));
                format!(
                    "{verdict}: {}. Mend this first: the rest may come from it.{first}",
                    check.found
                )
            }
            (None, Some(first)) => match self
                .checks
                .iter()
                .find(|of| of.required && of.outcome == Outcome::Skipped)
            {
                Some(of) => {
                    format!("{verdict}: {}. Its first steps: {first}", of.found)
                }
                None => format!("{verdict}: {first}"),
            },
            (None, None) => format!("{verdict}: its first steps were not looked at."),
        }
    }
}

/// Runs the small jobs, then the first steps from a bed; `progress` hears the name of each.
pub fn conformance(
    options: &Options,
    beds: &Beds,
    progress: &mut dyn FnMut(&str),
) -> Result<Conformance, EngineError> {
    let engine = exec::describe(options)?;
    let first_steps = if engine.has(Part::Cases) {
        first_steps::first_steps(Asked::Exec(&engine, options), beds, progress)
            .map_err(Trouble::from)
    } else {
        Err(Trouble::Skipped(
            "the engine says that it has no lists of small experiments (cases)".to_owned(),
        ))
    };
    // The jobs allow what double precision needs.
    let resolution = first_steps.as_ref().map(|of| of.resolution);
    let single = resolution.is_ok_and(|of| !of.is_double());
    let mut found = Conformance {
        engine,
        checks: Vec::new(),
        first_steps: None,
        engine_failed: false,
    };
    for job in jobs::all() {
        progress(job.id);
        let job = Job { single, ..job };
        let said = against_native(&found.engine, options, &job);
        found.add(job.id, job.what, said)?;
    }
    progress("again");
    let said = again(&found.engine, options);
    found.add("again", "the small bed once more", said)?;
    progress("cases");
    let said = cases(&found.engine, options, single);
    let what = "two lists of grains in one start, each looked at three times";
    found.add("cases", what, said)?;
    match first_steps {
        Ok(of) => {
            found.checks.extend(first_steps::checks(&of, FIRST_STEPS));
            found.first_steps = Some(of);
        }
        Err(trouble) => found.add("first-steps", "its first steps from a bed", Err(trouble))?,
    }
    Ok(found)
}

/// The first steps of YADE, whose small experiments are the verification suite's.
pub fn of_yade(
    options: &yade::Options,
    beds: &Beds,
    progress: &mut dyn FnMut(&str),
) -> Result<Conformance, EngineError> {
    let work = work_folder().map_err(ProgramError::File)?;
    let version = yade::run_cases(&[], options, work.path(), &mut ())?.version;
    let order = if options.sorted { "sorted" } else { "ordinary" };
    let judgement = first_steps::first_steps(Asked::Yade(options), beds, progress)?;
    Ok(Conformance {
        engine: Description {
            protocol: exec::PROTOCOL,
            name: "YADE".to_owned(),
            version: format!("{version}, {order} loop"),
            parts: Part::ALL.to_vec(),
            approximations: Vec::new(),
        },
        checks: first_steps::checks(&judgement, FIRST_STEPS),
        first_steps: Some(judgement),
        engine_failed: false,
    })
}

/// What a job came to if it is not right.
pub enum Trouble {
    /// It is wrong.
    Wrong(String),
    /// The engine has no such parts.
    Skipped(String),
    /// The engine has the parts and refused.
    Refused(String),
    /// The engine failed.
    Engine(ProgramError),
    /// The native engine failed.
    Native(NativeError),
}

impl From<ProgramError> for Trouble {
    fn from(error: ProgramError) -> Self {
        Trouble::Engine(error)
    }
}

impl From<EngineError> for Trouble {
    fn from(error: EngineError) -> Self {
        match error {
            EngineError::Native(error) => error.into(),
            EngineError::Program(error) => error.into(),
        }
    }
}

impl From<NativeError> for Trouble {
    fn from(error: NativeError) -> Self {
        Trouble::Native(error)
    }
}

impl Conformance {
    /// Adds a check; what is no fault of the engine's own is handed back.
    fn add(
        &mut self,
        id: &str,
        job: &str,
        said: Result<String, Trouble>,
    ) -> Result<(), EngineError> {
        let mut refused = false;
        let (outcome, found) = match said {
            Ok(said) => (Outcome::Pass, said),
            Err(Trouble::Wrong(said)) => (Outcome::Fail, said),
            Err(Trouble::Skipped(why)) => (Outcome::Skipped, why),
            Err(Trouble::Refused(reason) | Trouble::Engine(ProgramError::Refused(reason))) => {
                refused = true;
                (Outcome::Skipped, format!("the engine refused: {reason}"))
            }
            Err(Trouble::Native(error)) => return Err(error.into()),
            Err(Trouble::Engine(
                error @ (ProgramError::NotStarted { .. }
                | ProgramError::Interrupted
                | ProgramError::File(_)),
            )) => return Err(error.into()),
            Err(Trouble::Engine(error)) => {
                let understood = matches!(
                    error,
                    ProgramError::Nonsense(_) | ProgramError::WentWrong { .. }
                );
                self.engine_failed |= !understood;
                (Outcome::Fail, error.to_string())
            }
        };
        let check = Check::of_words(format!("engine/{id}"), job, outcome, &found);
        self.checks.push(Check {
            required: refused,
            ..check
        });
        Ok(())
    }
}

/// All moments of a run.
#[derive(Debug, Default, Clone, PartialEq)]
struct Moments(Vec<Snapshot>);

impl Observer for Moments {
    fn snapshot(&mut self, snapshot: &Snapshot) {
        self.0.push(snapshot.clone());
    }
}

/// A run of a job: its moments and how it ended.
#[derive(Debug, Clone)]
struct Story {
    moments: Vec<Snapshot>,
    outcome: Ended,
}

fn in_native(job: &Job) -> Result<Story, NativeError> {
    let mut moments = Moments::default();
    let sound = native::Options::default();
    let outcome = native::run(&job.scene, &job.task, &sound, &mut moments)?;
    Ok(Story {
        moments: moments.0,
        outcome,
    })
}

fn in_engine(options: &Options, job: &Job) -> Result<Story, ProgramError> {
    let mut moments = Moments::default();
    let work = work_folder()?;
    let run = exec::run(&job.scene, &job.task, options, work.path(), &mut moments)?;
    Ok(Story {
        moments: moments.0,
        outcome: run.outcome,
    })
}

/// Whether the engine says that it has everything that is asked.
fn has_all(missing: &[Part]) -> Result<(), Trouble> {
    if missing.is_empty() {
        return Ok(());
    }
    let missing: Vec<&str> = missing.iter().map(|part| part.in_words()).collect();
    let why = format!("the engine says that it has no {}", missing.join(", "));
    Err(Trouble::Skipped(why))
}

fn against_native(engine: &Description, options: &Options, job: &Job) -> Result<String, Trouble> {
    has_all(&exec::missing_for_scene(engine, &job.scene, &job.task))?;
    let native = in_native(job)?;
    let theirs = in_engine(options, job)?;
    (job.judge)(job, &theirs, &native).map_err(Trouble::Wrong)
}

/// The same job twice must give the same bits.
fn again(engine: &Description, options: &Options) -> Result<String, Trouble> {
    let job = jobs::bed();
    has_all(&exec::missing_for_scene(engine, &job.scene, &job.task))?;
    if in_engine(options, &job)?.moments == in_engine(options, &job)?.moments {
        return Ok("the same bits both times".to_owned());
    }
    let why = "two runs of one job have other bits: threads that add forces in the order in which they come, or a random \
               number without a fixed seed";
    Err(Trouble::Wrong(why.to_owned()))
}

/// A list of two small experiments in one start.
fn cases(engine: &Description, options: &Options, single: bool) -> Result<String, Trouble> {
    let cases = jobs::cases();
    let missing = cases
        .iter()
        .flat_map(|case| exec::missing_for_case(engine, case));
    let mut missing: Vec<Part> = missing.collect();
    missing.dedup();
    has_all(&missing)?;
    let work = work_folder().map_err(ProgramError::File)?;
    let asked: Vec<_> = cases.iter().collect();
    let results = exec::run_cases(&asked, engine, options, work.path(), &mut ())?;
    for (case, result) in cases.iter().zip(results) {
        let refused = |reason| Trouble::Refused(format!("{}: {reason}", case.name));
        let theirs = result.map_err(refused)?;
        let native = native::run_case(case, None)?;
        moments_agree(&theirs, &native, jobs::rounding(single))
            .map_err(|said| Trouble::Wrong(format!("{}: {said}", case.name)))?;
    }
    Ok("both as they should be".to_owned())
}

/// Nearer than this, over what the step changes, two numbers are one.
fn near(a: f64, b: f64, scale: f64, single: bool) -> bool {
    (a - b).abs() <= jobs::rounding(single) * scale
}

/// How much more is allowed where a number looks like another cause's.
fn rough(single: bool) -> f64 {
    if single { 1.0 } else { 1.0e3 }
}

/// The contacts of one moment.
fn contacts_agree(theirs: &Snapshot, native: &Snapshot, single: bool) -> Result<(), String> {
    let pairs = |of: &Snapshot| -> Vec<(u32, u32)> {
        of.contacts.iter().map(|of| (of.id1, of.id2)).collect()
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
    for (their, own) in theirs.contacts.iter().zip(&native.contacts) {
        contact_agrees(their, own, single)?;
    }
    Ok(())
}

fn contact_agrees(their: &Contact, own: &Contact, single: bool) -> Result<(), String> {
    let near = |a, b, scale| near(a, b, scale, single);
    let of = format!("contact of bodies {} and {}", own.id1, own.id2);
    // Lengths against the size of a grain, about a hundred times an overlap at most.
    let length = 1.0e-2;
    if !near(their.overlap, own.overlap, length) {
        return Err(format!(
            "{of}: overlap {:e} m where {:e} m is right: R1 + R2 − distance, and R − distance at a wall",
            their.overlap, own.overlap
        ));
    }
    let flipped =
        near(their.normal[0], -own.normal[0], 1.0) && near(their.normal[1], -own.normal[1], 1.0);
    if flipped {
        return Err(format!(
            "{of}: the normal points from body 2 to body 1, and is to point from body 1 to body 2"
        ));
    }
    if !(near(their.normal[0], own.normal[0], 1.0) && near(their.normal[1], own.normal[1], 1.0)) {
        return Err(format!(
            "{of}: normal {:?} where {:?} is right",
            their.normal, own.normal
        ));
    }
    // An overlap's own rounding, times the stiffness.
    let slack = own.normal_force * length / own.overlap.max(f64::MIN_POSITIVE);
    if !near(their.normal_force, own.normal_force, slack) {
        return Err(format!(
            "{of}: normal force {:e} N where {:e} N is right, {:.6} of it; k_n = 2·E·R1·R2/(R1 + R2), a wall counts as a grain \
             of the same radius, and compression is positive",
            their.normal_force,
            own.normal_force,
            their.normal_force / own.normal_force
        ));
    }
    if !(near(their.point[0], own.point[0], 1.0) && near(their.point[1], own.point[1], 1.0)) {
        return Err(format!(
            "{of}: contact point {:?} where {:?} is right: from body 1's centre by R1 − overlap/2 along the normal; on the wall",
            their.point, own.point
        ));
    }
    Ok(())
}

/// The first moment and grain that is farther off than `tolerance` of its radius, or has another velocity.
fn moments_agree(theirs: &[Snapshot], native: &[Snapshot], tolerance: f64) -> Result<(), String> {
    if theirs.len() != native.len() {
        return Err(format!(
            "{} moments instead of {}",
            theirs.len(),
            native.len()
        ));
    }
    for (their, own) in theirs.iter().zip(native) {
        let (of_them, of_us) = (&their.bodies, &own.bodies);
        for id in 0..of_us.len() {
            let apart = (of_them.x[id] - of_us.x[id]).hypot(of_them.z[id] - of_us.z[id]);
            let slower = (of_them.vx[id] - of_us.vx[id]).hypot(of_them.vz[id] - of_us.vz[id]);
            // A velocity of 1 m/s is about what grains have.
            if !(apart <= tolerance * of_us.radius[id] && slower <= 100.0 * tolerance) {
                return Err(format!(
                    "step {}, grain {id}: at ({:e}, {:e}) m with ({:e}, {:e}) m/s, and should be at ({:e}, {:e}) m with ({:e}, \
                     {:e}) m/s: {:.2e} R off, and {tolerance:.0e} R is the most. If the checks before this one hold, forces of \
                     several contacts are added wrongly, or a contact is found too late or lost",
                    own.step,
                    of_them.x[id],
                    of_them.z[id],
                    of_them.vx[id],
                    of_them.vz[id],
                    of_us.x[id],
                    of_us.z[id],
                    of_us.vx[id],
                    of_us.vz[id],
                    apart / of_us.radius[id]
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
    let mut largest = 0.0f64;
    for (their, own) in theirs.moments.iter().zip(&native.moments) {
        for id in 0..own.bodies.len() {
            let apart = (their.bodies.x[id] - own.bodies.x[id])
                .hypot(their.bodies.z[id] - own.bodies.z[id]);
            largest = largest.max(apart / own.bodies.radius[id]);
        }
    }
    format!("within {largest:.1e} R of the native engine: rounding")
}

/// Gravity and the order of a step, by what the numbers look like.
fn flight(job: &Job, theirs: &Story, native: &Story) -> Result<String, String> {
    let (given, dt, g) = (
        &job.task.start.bodies,
        job.scene.time_step_seconds(),
        job.scene.gravity,
    );
    let (their, own) = (&theirs.moments[1].bodies, &native.moments[1].bodies);
    let (z, v) = (given.z[0], given.vz[0]);
    let (fallen, gained) = (their.z[0] - z, their.vz[0] - v);
    let is = |value: f64, expected: f64, scale: f64| {
        near(value, expected, rough(job.single) * scale, job.single)
    };
    if is(gained, 0.0, g * dt) {
        return Err("after a step the velocity is the one of the start: gravity is missing, or velocities are written before \
                    the step"
            .to_owned());
    }
    if is(gained, g * dt, g * dt) {
        return Err("gravity points up; model.gravity is (x, z) with its sign".to_owned());
    }
    if is(gained, -0.5 * g * dt, g * dt) || is(gained, -1.5 * g * dt, g * dt) {
        return Err("after a step the velocity has half a kick too few or too many: velocities here belong to the half step \
                    before the positions, so each step gives a whole kick, v += dt·a, and then x += dt·v"
            .to_owned());
    }
    if is(fallen, v * dt, g * dt * dt) {
        return Err("the grain was moved with the velocity before the kick: first v += dt·a, then x += dt·v".to_owned());
    }
    if is(fallen, v * dt - 0.5 * g * dt * dt, g * dt * dt) {
        return Err("the grain was moved by v·dt + ½a·dt²: the velocity that is given belongs to the half step before, so it is \
                    moved by (v + dt·a)·dt"
            .to_owned());
    }
    if !is(gained, own.vz[0] - v, g * dt) {
        return Err(format!(
            "after a step vz has changed by {gained:e} m/s, and {:e} m/s is right (dt = {dt:e} s, gravity {g} m/s²)",
            own.vz[0] - v
        ));
    }
    moments_agree(&theirs.moments, &native.moments, jobs::rounding(job.single))?;
    Ok("gravity and the order of a step are right".to_owned())
}

/// Cundall's damping.
fn damping(job: &Job, theirs: &Story, native: &Story) -> Result<String, String> {
    let given = &job.task.start.bodies;
    let (dt, g, alpha) = (
        job.scene.time_step_seconds(),
        job.scene.gravity,
        job.scene.damping.alpha(),
    );
    let (their, own) = (&theirs.moments[1].bodies, &native.moments[1].bodies);
    let names = ["falls", "rises", "turns round in the step"];
    for (id, name) in names.iter().enumerate() {
        let (gained, wanted) = (their.vz[id] - given.vz[id], own.vz[id] - given.vz[id]);
        let is = |expected: f64| near(gained, expected, rough(job.single) * g * dt, job.single);
        if is(wanted) {
            continue;
        }
        let why = if is(-g * dt) {
            "it is not damped at all"
        } else if id == 2 {
            "the sign is that of a·(v + ½dt·a), with the velocity in the middle of the kick"
        } else if is(-2.0 * g * dt - wanted) {
            "the sign is the wrong way round: what speeds a grain up is made smaller, what slows it down larger"
        } else {
            "each component of the acceleration, gravity included, is multiplied by 1 − α·sign(a·(v + ½dt·a))"
        };
        return Err(format!(
            "the grain that {name}: vz changes by {gained:e} m/s and should by {wanted:e} m/s (α = {alpha}): {why}"
        ));
    }
    moments_agree(&theirs.moments, &native.moments, jobs::rounding(job.single))?;
    Ok("what speeds up is damped, what slows down is helped, by the right amount".to_owned())
}

/// The settle rule ended the run where it should.
fn rules(job: &Job, theirs: &Story, native: &Story) -> Result<String, String> {
    let end = |story: &Story| {
        let stage = story.outcome.stages.last();
        stage.map(|stage| (stage.steps, stage.stop))
    };
    let (found, wanted) = (end(theirs), end(native));
    if found != wanted {
        return Err(format!(
            "settling ended with {found:?} and should with {wanted:?} (steps, reason): every settle.check_every steps, not at \
             step 0, the kinetic energy Σ½mv² of the written velocities is compared with kinetic_energy_fraction times the \
             largest that was seen at such a step, this one included"
        ));
    }
    moments_agree(&theirs.moments, &native.moments, jobs::rounding(job.single))?;
    Ok(format!(
        "it ended after {} steps, as it should",
        wanted.map_or(0, |(steps, _)| steps)
    ))
}

/// The punch, its force and the grains below it.
fn punch(job: &Job, theirs: &Story, native: &Story) -> Result<String, String> {
    let near = |a, b, scale| near(a, b, scale, job.single);
    for (their, own) in theirs.moments.iter().zip(&native.moments) {
        let (Some(found), Some(wanted)) = (their.punch, own.punch) else {
            return Err(format!(
                "step {}: no punch is written, and loading has one from its start",
                own.step
            ));
        };
        if !near(found.centre[0], wanted.centre[0], 1.0e-2)
            || !near(found.centre[1], wanted.centre[1], 1.0e-2)
        {
            return Err(format!(
                "step {}: the punch's centre is at {:?} m and should be at {:?} m: it starts on the highest grain below it and \
                 moves by its velocity times dt a step",
                own.step, found.centre, wanted.centre
            ));
        }
        // Rounding of overlaps, times a stiffness.
        if !near(
            found.force,
            wanted.force,
            rough(job.single) * wanted.force.abs().max(1.0),
        ) {
            return Err(format!(
                "step {}: the force on the punch is {:e} N and should be {:e} N: what grains push it up with, positive upwards",
                own.step, found.force, wanted.force
            ));
        }
    }
    moments_agree(&theirs.moments, &native.moments, jobs::rounding(job.single))?;
    Ok("the punch goes down and bears what it should".to_owned())
}
