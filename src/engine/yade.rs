//! YADE as an engine of the protocol: finds Debian's YADE, starts its fixed scripts on a job folder without any listening
//! socket, and has what they write read as that of any engine is.

use std::env;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::ValueEnum;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::exec::{SAID, finish, usual_limits};
use super::limits::{Done, Limits};
use super::read::{Timed, TimedSteps};
use super::{
    Description, Engine, EngineError, EngineRecord, Part, ProgramError, Result, Run, ensure, exec,
    lacking_rules, nonsense, read, read_json,
};
use crate::child::on_path;
use crate::files::{
    Place, link, new_folder, regular, sha256_hex, whole_path, work_folder, write_whole,
};
use grains::model::Model;
use grains::obstacle::{Obstacle, Surface};
use grains::rules::Rules;
use grains::scene::{
    AdhesionLaw, ContactLaw, NewContactSlip, Scene, SlipVelocity, Springs, Tension, TorqueArms,
    Viscosity,
};
use grains::tables::{Bodies, Snapshot};
use grains::task::{Case, Effective, Load, Observer, Task};
use verdict::Answer;

/// The oldest YADE whose options this driver relies on.
pub const OLDEST_VERSION: (u32, u32) = (2023, 2);

/// What it has not.
const LACKED: [Part; 3] = [Part::Planes, Part::Dmt, Part::Jkr];

/// How YADE is run; none of it is physics, all of it may change bits.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Visit interactions in the order of their ids (slower): the mode that has the native
    /// engine's bits.
    pub sorted: bool,
    /// YADE's `verletDist`, m. In sorted mode the bits do not depend on it.
    pub verlet_distance: f64,
    pub limits: Limits,
    /// The `yade` to use instead of the one on the path.
    pub program: Option<PathBuf>,
    /// More than one add up forces in any order.
    pub threads: u32,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            sorted: true,
            verlet_distance: 1.0e-4,
            limits: usual_limits(),
            program: None,
            threads: 1,
        }
    }
}

impl Options {
    /// What the scripts are told besides the job.
    fn settings(&self) -> Value {
        json!({"sorted": self.sorted, "verlet_distance": self.verlet_distance})
    }

    fn order(&self) -> &'static str {
        ["ordinary", "sorted"][usize::from(self.sorted)]
    }
}

impl Engine for Options {
    fn name(&self) -> String {
        match self.sorted {
            true => "YADE sorted".to_owned(),
            false => format!("YADE ordinary {:?}", self.verlet_distance),
        }
    }

    fn words(&self) -> String {
        let (order, distance) = (self.order(), self.verlet_distance);
        format!("--engine yade --loop {order} --verlet-distance {distance:?}")
    }

    fn describe(&self) -> Result<Description, EngineError> {
        let work = work_folder().map_err(ProgramError::File)?;
        let (_, version) = run_cases(&[], self, work.path(), &mut ())?;
        let parts = Part::value_variants().iter().copied();
        let version = format!("{version}, {} loop", self.order());
        let parts = parts.filter(|part| !LACKED.contains(part));
        Ok(Description::of_this_program(
            "YADE",
            version,
            parts.collect(),
        ))
    }

    fn lacks(&self, scene: &Scene, _task: &Task) -> Option<String> {
        lacking(scene)
    }

    fn lacks_for(&self, case: &Case) -> Option<String> {
        unsupported(&case.model)
    }

    fn check(&self, scene: &Scene, _task: &Task) -> Result<(), EngineError> {
        check_scene(scene, self)?;
        Ok(())
    }

    fn run(
        &self,
        scene: &Scene,
        task: &Task,
        work: &Path,
        observer: &mut dyn Observer,
    ) -> Result<Run, EngineError> {
        let yade = check_scene(scene, self)?;
        exec::write_scene(work, scene, task, &self.settings())?;
        let scripts = scripts(RUN_SCENE, task.start.bodies.in_space());
        let (took, version) = start(&yade, &scripts, work, self, None, observer)?;
        Ok(Run {
            outcome: read::scene(work, scene, task, observer).map_err(hinted)?,
            engine: EngineRecord::Yade {
                version,
                sorted: self.sorted,
                verlet_distance: self.verlet_distance,
                script: script_digest(scene.in_space()),
            },
            log: exec::log(work),
            // Its stages tell what they took, without the start.
            took: Some(Done {
                processor_seconds: None,
                ..took
            }),
        })
    }

    fn run_together(&self, runs: &[(&Scene, &Task)]) -> Option<Vec<Vec<Snapshot>>> {
        let (first, work) = (runs.first()?.0, work_folder().ok()?);
        let yade = find(self.program.as_deref()).ok()?;
        if runs.iter().any(|(scene, _)| lacking(scene).is_some()) {
            return None;
        }
        let place = |index: usize| work.path().join(index.to_string());
        for (index, (scene, task)) in runs.iter().enumerate() {
            new_folder(&place(index)).ok()?;
            exec::write_scene(&place(index), scene, task, &self.settings()).ok()?;
        }
        let scripts = scripts(RUN_SCENE, first.in_space());
        start(
            &yade,
            &scripts,
            work.path(),
            self,
            Some(runs.len()),
            &mut (),
        )
        .ok()?;
        let mut all = Vec::new();
        for (index, (scene, task)) in runs.iter().enumerate() {
            let mut seen: Vec<Snapshot> = Vec::new();
            read::scene(&place(index), scene, task, &mut seen).ok()?;
            all.push(seen);
        }
        Some(all)
    }

    fn run_cases(&self, cases: &[&Case], work: &Path) -> Result<Vec<Answer>, EngineError> {
        let (made, _) = run_cases(cases, self, work, &mut ())?;
        Ok(made.into_iter().map(|answer| Ok(answer.track)).collect())
    }

    fn time(
        &self,
        model: &Model,
        bodies: &Bodies,
        steps: TimedSteps,
        work: &Path,
    ) -> Result<(Timed, String), EngineError> {
        can(unsupported(model))?;
        let yade = find(self.program.as_deref())?;
        exec::write_timing(work, model, bodies, steps, &self.settings())?;
        let options = Options {
            threads: steps.processes,
            ..self.clone()
        };
        let scripts = scripts(TIME_STEPS, bodies.in_space());
        let (_, version) = start(&yade, &scripts, work, &options, None, &mut ())?;
        let timed = read::timed(work, model, bodies, steps).map_err(hinted)?;
        Ok((timed, version))
    }

    fn is_of_this_program(&self) -> bool {
        true
    }

    fn log(&self) -> [&'static str; 2] {
        [".yade.log", "YADE's"]
    }
}

type Script = (&'static str, &'static str);

macro_rules! script {
    ($name:literal) => {
        ($name, include_str!(concat!("../../yade_scripts/", $name)))
    };
}

/// In the plane, and as what a script in space begins with.
const RUN_SCENE: Script = script!("run_scene.py");
const RUN_CASES: Script = script!("run_cases.py");
const TIME_STEPS: Script = script!("time_steps.py");
const PROPOSE_STEPS: Script = script!("propose_steps.py");
const SHARED: Script = script!("model_in_yade.py");
/// Does any of these jobs in space.
const IN_SPACE: Script = script!("in_space.py");

/// SHA-256 of the scripts that run a scene in the plane or in space, in hexadecimal: what ran inside YADE.
pub fn script_digest(in_space: bool) -> String {
    let further = if in_space { IN_SPACE.1 } else { "" };
    sha256_hex(format!("{further}{}{}", RUN_SCENE.1, SHARED.1).as_bytes())
}

fn missing(reason: String) -> ProgramError {
    ProgramError::Missing {
        engine: "YADE",
        reason,
        package: "yade",
    }
}

fn lacks(what: String) -> ProgramError {
    ProgramError::Unsupported {
        engine: "YADE".to_owned(),
        missing: what,
        hint: "run this scene with the native engine",
    }
}

/// What helps against nonsense of another program than YADE.
fn hinted(error: ProgramError) -> ProgramError {
    match error {
        ProgramError::Nonsense(reason) => nonsense(format!(
            "{reason}; see that --yade, CROSSGRAIN_YADE or the path name Debian's YADE, and start the command again"
        )),
        other => other,
    }
}

/// What the scene asks for that YADE does not have, if there is anything.
pub fn lacking(scene: &Scene) -> Option<String> {
    let stages = scene.stages().map(|stage| Model::in_stage(scene, stage));
    let stages: Vec<Model> = stages.collect();
    let dashpots = stages
        .iter()
        .filter(|model| model.law.has_dashpots())
        .count();
    let in_one = 0 < dashpots && dashpots < stages.len();
    let in_one = in_one.then(|| "dashpots in one stage only".to_owned());
    let in_space = scene.in_space() && scene.has_stages();
    let in_space = in_space.then(|| "constants of loading in space".to_owned());
    stages.iter().find_map(unsupported).or(in_one).or(in_space)
}

/// The YADE that is to run the scene, which has all that it asks for.
pub fn check_scene(scene: &Scene, options: &Options) -> Result<Installation> {
    can(lacking(scene))?;
    find(options.program.as_deref())
}

/// What the model asks for that YADE does not have, if there is anything.
pub fn unsupported(model: &Model) -> Option<String> {
    let contact = &model.law.contact;
    let reason = match contact.viscosity {
        _ if contact.springs == Springs::HertzMindlin => lacking_of_hertz(contact),
        _ if contact.rolling.is_some() => Some("moments beside linear springs"),
        Viscosity::None => None,
        Viscosity::Ratio { .. } => Some("dashpots by their ratio beside linear springs"),
        Viscosity::Restitution { .. } => Some(
            "dashpots by restitution (it solves for them to 1 % only); give c_n with \
             contact.viscosity.kind = dashpot",
        ),
        Viscosity::Dashpot {
            tension: Tension::Unclipped,
            ..
        } => Some("dashpots that pull (contact.viscosity.tension = unclipped)"),
        Viscosity::Dashpot { .. } if model.law.has_friction_of_walls() => {
            Some("friction of its own at walls or punch beside dashpots")
        }
        Viscosity::Dashpot { .. }
            if model.law.has_friction()
                && (contact.slip_velocity != SlipVelocity::ContactPoint
                    || contact.torque_arms != TorqueArms::ContactPoint) =>
        {
            Some(
                "dashpots with friction other than by contact.slip_velocity = contact_point and \
                 contact.torque_arms = contact_point",
            )
        }
        Viscosity::Dashpot { .. } => None,
    };
    let timed = model.law.has_friction() && contact.new_contact_slip == NewContactSlip::SinceTouch;
    let is_plane = |obstacle: &Obstacle| matches!(obstacle.shape, Surface::Plane { .. });
    let planes = model.obstacles.iter().any(is_plane);
    reason
        .or(planes.then_some(
            "planes of any direction (its walls are normal to an axis); give triangles or a box",
        ))
        .or(timed.then_some("slip since touch (contact.new_contact_slip = since_touch)"))
        .map(str::to_owned)
        .or_else(|| lacking_rules(model.rules, Rules::default()))
}

/// What its Hertzian law does not have.
fn lacking_of_hertz(contact: &ContactLaw) -> Option<&'static str> {
    match contact.viscosity {
        Viscosity::Dashpot { .. } => Some("dashpots of one constant beside Hertz's springs"),
        Viscosity::Restitution { tension, .. } | Viscosity::Ratio { tension, .. }
            if tension == Tension::Unclipped =>
        {
            Some("dashpots that pull (contact.viscosity.tension = unclipped)")
        }
        _ if contact.torque_arms != TorqueArms::ContactPoint => {
            Some("Hertz's springs other than with contact.torque_arms = contact_point")
        }
        _ if contact.adhesion_law != AdhesionLaw::Pull => Some("adhesion other than a pull"),
        _ if contact.rolling.is_some_and(|rolling| rolling.is_constant()) => {
            Some("constant torque against rolling")
        }
        _ => None,
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct CaseInYade {
    /// The parameters that YADE says it uses.
    pub effective: Effective,
    pub track: Vec<Snapshot>,
    /// Force and torque summed on each grain at each moment; empty for large cases and in space.
    pub loads: Vec<Vec<Load>>,
}

/// Grains of the largest case whose summed forces and torques are written too.
const MOST_LOADED: usize = 200;

/// Runs the cases in one start of YADE, or in two if some are in space and some are not; in order, and its version. `work` is an empty
/// folder.
pub fn run_cases(
    cases: &[&Case],
    options: &Options,
    work: &Path,
    observer: &mut dyn Observer,
) -> Result<(Vec<CaseInYade>, String)> {
    let in_space = |case: &&Case| case.bodies.in_space();
    let (space, plane): (Vec<&Case>, Vec<&Case>) = cases.iter().partition(|case| in_space(case));
    if space.is_empty() || plane.is_empty() {
        return run_alike(cases, options, work, observer);
    }
    let mut run = |cases: &[&Case], name: &str| {
        let work = work.join(name);
        new_folder(&work)?;
        run_alike(cases, options, &work, observer)
    };
    let ((plane, version), (space, _)) = (run(&plane, "plane")?, run(&space, "space")?);
    let (mut plane, mut space) = (plane.into_iter(), space.into_iter());
    let own = |case: &&Case| {
        if in_space(case) {
            space.next()
        } else {
            plane.next()
        }
    };
    Ok((cases.iter().filter_map(own).collect(), version))
}

fn run_alike(
    cases: &[&Case],
    options: &Options,
    work: &Path,
    observer: &mut dyn Observer,
) -> Result<(Vec<CaseInYade>, String)> {
    let version = start_cases(cases, RUN_CASES, options, work, observer)?;
    let runs = read::cases(work, cases).map_err(hinted)?;
    let complete = |(case, run): (&&Case, Result<read::CaseRun, String>)| {
        let run = run.map_err(ProgramError::Refused)?;
        let has_loads = case.bodies.len() <= MOST_LOADED && !case.bodies.in_space();
        let wanted = if has_loads { case.moments.len() } else { 0 };
        let effective = run.effective.filter(|_| run.loads.len() == wanted);
        let lacking = || format!("{}: no parameters, or loads of other grains", case.name);
        Ok(CaseInYade {
            effective: effective.ok_or_else(|| hinted(nonsense(lacking())))?,
            track: run.track,
            loads: run.loads,
        })
    };
    let cases: Result<_> = cases.iter().zip(runs).map(complete).collect();
    Ok((cases?, version))
}

/// The scripts of a job: the one that is started, and what it needs.
fn scripts(script: Script, in_space: bool) -> Vec<Script> {
    match in_space {
        false => vec![script, SHARED],
        true => vec![IN_SPACE, script, SHARED],
    }
}

/// Starts the script on these cases, and returns YADE's version.
fn start_cases(
    cases: &[&Case],
    script: Script,
    options: &Options,
    work: &Path,
    observer: &mut dyn Observer,
) -> Result<String> {
    for case in cases {
        can(unsupported(&case.model))?;
    }
    let yade = find(options.program.as_deref())?;
    let mut settings = options.settings();
    settings["loads_up_to"] = MOST_LOADED.into();
    // In space the script that is started imports it.
    settings["script"] = script.0.trim_end_matches(".py").into();
    exec::write_cases(work, cases, &settings)?;
    let in_space = cases.iter().any(|case| case.bodies.in_space());
    let scripts = scripts(script, in_space);
    Ok(start(&yade, &scripts, work, options, None, observer)?.1)
}

/// What YADE would choose, s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Proposal {
    /// `utils.PWaveTimeStep()`.
    pub p_wave: f64,
    /// `GlobalStiffnessTimeStepper` as it is by default, with its safety factor of 0.8.
    pub global_stiffness: f64,
    /// The same with `viscEl=True`, which looks at dashpots; asked only where there are some.
    pub with_dashpots: f64,
}

/// Asks YADE which time steps it would choose for the cases; `work` is an empty folder. The answers in the order of the
/// cases, and YADE's version.
pub fn propose(cases: &[&Case], options: &Options, work: &Path) -> Result<(Vec<Proposal>, String)> {
    let version = start_cases(cases, PROPOSE_STEPS, options, work, &mut ())?;
    let name = "proposals.json";
    let proposals: Vec<Proposal> = read_json(Place::from((work, name)), 1 << 24, name)?;
    let (found, wanted) = (proposals.len(), cases.len());
    ensure(found == wanted, || {
        format!("{name} has {found} steps for {wanted} cases")
    })?;
    Ok((proposals, version))
}

/// Tells the scripts of several jobs.
const JOBS: &str = "CROSSGRAIN_JOBS";

fn can(lacking: Option<String>) -> Result<()> {
    lacking.map_or(Ok(()), |what| Err(lacks(what)))
}

/// Runs the script on the job in `work`, or on so many in the folders 0, 1, … of it, to its end, or ends it; what it took, and YADE's
/// version.
fn start(
    yade: &Installation,
    scripts: &[Script],
    work: &Path,
    options: &Options,
    jobs: Option<usize>,
    observer: &mut dyn Observer,
) -> Result<(Done, String)> {
    let work = &whole_path(work)?;
    // YADE ends with an error of its own where its home is not text.
    if work.to_str().is_none() {
        let folder = work.display();
        return Err(lacks(format!(
            "way to work in a folder whose name is not UTF-8 text, {folder}"
        )));
    }
    let home = work.join("home");
    new_folder(&home)?;
    for (name, text) in scripts {
        write_whole((work, *name), text.as_bytes())?;
    }
    // Under this name Python imports the program, and the program then opens no socket.
    link(&yade.program, &work.join("yadeimport.py"))?;
    let mut command = Command::new(&yade.interpreter);
    command
        .args(scripts.first().map(|(name, _)| name))
        .env("OMP_NUM_THREADS", options.threads.to_string())
        .env("CROSSGRAIN_JOB", work)
        .env("CROSSGRAIN_PARENT", std::process::id().to_string())
        .env("PYTHONPATH", work)
        .env("HOME", &home)
        .env("IPYTHONDIR", &home)
        .env_remove(JOBS)
        .envs(jobs.map(|jobs| (JOBS, jobs.to_string())));
    let mut version = Ok(None);
    let mut fits = || {
        if matches!(version, Ok(None)) {
            version = hello(work);
        }
        version.is_ok()
    };
    let limits = &options.limits;
    let done = finish(&mut command, SAID, limits, work, observer, &mut fits);
    let version = version.and_then(|version| match version {
        Some(_) => Ok(version),
        None => hello(work),
    });
    let version = version.map_err(hinted)?;
    let done = done.map_err(|error| match error {
        ProgramError::NotStarted { reason, .. } => missing(format!(
            "{} cannot be started: {reason}",
            yade.interpreter.display()
        )),
        other => other,
    })?;
    let silent = || hinted(nonsense("it ended well without saying its version"));
    Ok((done, version.ok_or_else(silent)?))
}

/// The version, once the script has said it.
fn hello(work: &Path) -> Result<Option<String>> {
    #[derive(Deserialize)]
    struct Hello {
        version: String,
    }
    let place = Place::from((work, "hello.json"));
    if !place.is_file() {
        return Ok(None);
    }
    let hello: Hello = read_json(place, 1 << 16, "hello.json")?;
    let number = |text: &str| -> Option<u32> {
        let digits: String = text.chars().take_while(char::is_ascii_digit).collect();
        digits.parse().ok()
    };
    let mut parts = hello.version.split('.').map(number);
    match (parts.next().flatten(), parts.next().flatten()) {
        (Some(year), month) if (year, month.unwrap_or(0)) >= OLDEST_VERSION => {
            Ok(Some(hello.version))
        }
        (Some(_), _) => Err(ProgramError::TooOld {
            found: hello.version,
            oldest: OLDEST_VERSION,
        }),
        _ => Err(nonsense(format!("its version is {:?}", hello.version))),
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Installation {
    /// The `yade` program, itself a Python file that can be imported.
    pub program: PathBuf,
    /// The Python that it was built for.
    pub interpreter: PathBuf,
}

/// The first line of a program is no longer, bytes.
const LONGEST_LINE: u64 = 4096;

/// Finds YADE: `program` if given, else the variable `CROSSGRAIN_YADE`, else `yade` on the path.
pub fn find(program: Option<&Path>) -> Result<Installation> {
    let program = match (program, env::var_os("CROSSGRAIN_YADE")) {
        (Some(program), _) => program.to_owned(),
        (None, Some(named)) if !named.is_empty() => PathBuf::from(named),
        _ => on_path("yade")
            .ok_or_else(|| missing("there is no program `yade` on the path".to_owned()))?,
    };
    let unusable = |why: &str| missing(format!("{} {why}", program.display()));
    let program = whole_path(&program).map_err(|_| unusable("does not exist"))?;
    if !Place::from(&program).is_file() {
        return Err(unusable("is not a file"));
    }
    let file = regular(&program).map_err(|_| unusable("cannot be opened"))?;
    let mut first = String::new();
    BufReader::new(file.take(LONGEST_LINE))
        .read_line(&mut first)
        .map_err(|_| unusable("is not the Python file that Debian's yade is"))?;
    let interpreter = first
        .strip_prefix("#!")
        .and_then(interpreter)
        .filter(|interpreter| Place::from(interpreter).is_file())
        .ok_or_else(|| unusable("does not name a Python interpreter in its first line"))?;
    Ok(Installation {
        program,
        interpreter,
    })
}

/// The build of the same YADE that has this name (`yade-float128`), which stands beside it.
pub fn sibling(program: Option<&Path>, name: &str) -> Result<PathBuf> {
    let path = find(program)?.program.with_file_name(name);
    match Place::from(&path).is_file() {
        true => Ok(path),
        false => Err(missing(format!("{} does not exist", path.display()))),
    }
}

/// The program of a first line, looked up if it is left to `env`.
fn interpreter(command: &str) -> Option<PathBuf> {
    let mut words = command.split_whitespace();
    let program = PathBuf::from(words.next()?);
    if program.file_name().is_some_and(|name| name == "env") {
        return on_path(words.next()?);
    }
    Some(program)
}
