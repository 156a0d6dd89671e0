//! Engines: what is asked of any of them, and the three kinds that there are, the native one, YADE, and programs that speak the
//! engine protocol. And what an engine says of itself: its name, and which parts of the model it has.

pub mod exec;
pub mod limits;
pub mod named;
pub mod native;
pub mod read;
mod record;

pub mod yade;

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::ValueEnum;
use exec::{Options, PROTOCOL};
use limits::{Done, Limits};
use read::{Timed, TimedSteps};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::exit;
use crate::files::{FileError, Place, read_text, work_folder};
use grains::model::Model;
use grains::native::{self as own, NativeError, Trouble};
use grains::obstacle::Surface;
use grains::rules::Rules;
use grains::scene::{AdhesionLaw, Rolling, Scene, Springs};
use grains::tables::{Bodies, Snapshot, Stage};
use grains::task::{Case, Observer, Outcome, Task, Until};
use grains::variant::Form;
use verdict::Answer;
use verdict::invariance::Own;

pub use record::EngineRecord;

/// With the error of an engine that is a program, if no other is named.
pub type Result<T, E = ProgramError> = std::result::Result<T, E>;

/// An engine, ready to be asked. Whoever has one can be asked for runs and small experiments; the rest says what is
/// told of it.
pub trait Engine: std::fmt::Debug + Send + Sync {
    /// For whoever waits for it: `YADE sorted`.
    fn name(&self) -> String;

    /// How `crossgrain run` is told to take it, the path left out: it belongs to a machine.
    fn words(&self) -> String {
        "--engine exec:PATH".to_owned()
    }

    /// What it says of itself. YADE is started for its version.
    fn describe(&self) -> Result<Description, EngineError>;

    /// Terms of the model that it says it has in another form.
    fn forms(&self) -> &[Form] {
        &[]
    }

    /// Rules that it says it has, whatever the model says.
    fn rules(&self) -> Rules {
        Rules::default()
    }

    /// What it does not have of what the task asks for, in words.
    fn lacks(&self, _scene: &Scene, _task: &Task) -> Option<String> {
        None
    }

    /// What it does not have of what the case asks for, in words.
    fn lacks_for(&self, _case: &Case) -> Option<String> {
        None
    }

    /// That it is here, and has all that the task asks for.
    fn check(&self, scene: &Scene, task: &Task) -> Result<(), EngineError> {
        let lacking = self.lacks(scene, task);
        Ok(has_all(&self.describe()?.name, lacking, exec::HINT_SCENE)?)
    }

    /// Runs the task. `work` is an empty folder on a disk with room for about 2 MB a moment of history, for engines in other
    /// processes.
    fn run(
        &self,
        scene: &Scene,
        task: &Task,
        work: &Path,
        observer: &mut dyn Observer,
    ) -> Result<Run, EngineError>;

    /// The moments of each of these runs, in order, in one start; nothing where it makes them one by one, or where one of them fails.
    fn run_together(&self, _runs: &[(&Scene, &Task)]) -> Option<Vec<Vec<Snapshot>>> {
        None
    }

    /// What it makes of each case, in order, in one start; `work` is an empty folder.
    fn run_cases(&self, cases: &[&Case], work: &Path) -> Result<Vec<Answer>, EngineError>;

    /// Times steps of this bed by its own clock, and its version; `work` is an empty folder.
    fn time(
        &self,
        _model: &Model,
        _bodies: &Bodies,
        _steps: TimedSteps,
        _work: &Path,
    ) -> Result<(Timed, String), EngineError> {
        let error = ProgramError::Unsupported {
            engine: self.describe()?.name,
            missing: Part::Timing.in_words(),
            hint: exec::HINT_CASES,
        };
        Err(error.into())
    }

    /// The options of the native engine where it is that one, for what no other does: going on from a state, and pouring with
    /// softened grains.
    fn native(&self) -> Option<&own::Options> {
        None
    }

    /// Whether this program has it or translates for it, so that nobody can have misread the protocol.
    fn is_of_this_program(&self) -> bool {
        false
    }

    /// The end of the name of its log where one is kept, and whose it is.
    fn log(&self) -> [&'static str; 2] {
        [".engine.log", "the engine's"]
    }
}

/// What an engine makes of a task.
#[derive(Debug)]
pub struct Run {
    pub outcome: Outcome,
    pub engine: EngineRecord,
    /// What it printed.
    pub log: String,
    /// What the job took in another process, its start and its tables included, as this program has seen it.
    pub took: Option<Done>,
}

impl Run {
    /// Processor time in another process, s: as the system tells it, or else as the engine does.
    pub fn elsewhere(&self) -> f64 {
        let stages = self.outcome.stages.iter();
        self.took.map_or(0.0, |took| {
            let told = stages.map(|stage| stage.cpu_seconds).sum();
            took.processor_seconds.unwrap_or(told)
        })
    }
}

/// That nothing is missing.
fn has_all(engine: &str, missing: Option<String>, hint: &'static str) -> Result<()> {
    let engine = engine.to_owned();
    missing.map_or(Ok(()), |missing| {
        Err(ProgramError::Unsupported {
            engine,
            missing,
            hint,
        })
    })
}

#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    #[error(transparent)]
    Native(#[from] NativeError),
    #[error(transparent)]
    Program(#[from] ProgramError),
}

impl EngineError {
    pub fn exit_code(&self) -> u8 {
        match self {
            EngineError::Native(_) if self.is_interruption() => exit::TRY_AGAIN,
            EngineError::Native(_) => exit::ENGINE_FAILED,
            EngineError::Program(error) => error.exit_code(),
        }
    }

    /// Whether a signal ended it.
    pub fn is_interruption(&self) -> bool {
        match self {
            EngineError::Native(error) => error.trouble == Trouble::Interrupted,
            EngineError::Program(error) => matches!(error, ProgramError::Interrupted),
        }
    }
}

/// An engine that is a program did not give a run that can be used.
#[derive(Debug, thiserror::Error)]
pub enum ProgramError {
    #[error(
        "{engine} is missing: {reason}; on Debian 12 install it with `apt-get install --no-install-recommends {package}`"
    )]
    Missing {
        engine: &'static str,
        reason: String,
        package: &'static str,
    },
    #[error(
        "the engine {path} cannot be started: {reason}; after exec: comes the path of an executable file (chmod +x, \
         and an interpreter in its first line if it is a script)"
    )]
    NotStarted { path: PathBuf, reason: String },
    #[error("YADE {found} is too old: this driver needs {}.{:02} or later, as in Debian 12", oldest.0, oldest.1)]
    TooOld { found: String, oldest: (u32, u32) },
    #[error(
        "`{path} describe` did not say what the engine is: {reason}; it must print one JSON object, see \
         docs/engine-protocol.md"
    )]
    Undescribed { path: PathBuf, reason: String },
    #[error(
        "the engine speaks version {found} of the protocol, and this program speaks {}; take the engine that fits, or \
         change it (docs/engine-protocol.md)",
        exec::PROTOCOL
    )]
    OtherProtocol { found: u64 },
    #[error("{engine} has no {missing}; {hint}")]
    Unsupported {
        engine: String,
        missing: String,
        hint: &'static str,
    },
    #[error("the engine refused: {0}")]
    Refused(String),
    #[error("the engine ended with {status}; {}", printed(.log))]
    Crashed { status: String, log: String },
    #[error(
        "the engine hung: {reason}; it was ended (--stall-limit and --time-limit give it longer); {}",
        printed(.log)
    )]
    Hung { reason: String, log: String },
    #[error(
        "the engine took {reason}; it was ended (--memory-limit and --output-limit give it more)"
    )]
    TooMuch { reason: String },
    #[error(
        "{path} was replaced while it ran, so nobody can say which program made the run; start the command again"
    )]
    Changed { path: PathBuf },
    #[error("the engine was ended, as asked; start the command again")]
    Interrupted,
    #[error("the engine wrote nonsense: {0}")]
    Nonsense(String),
    #[error("the engine's run went wrong, seen in step {step} of stage {}: {trouble}", .stage.name())]
    WentWrong {
        stage: Stage,
        step: u64,
        trouble: Trouble,
    },
    #[error(transparent)]
    File(#[from] FileError),
}

fn printed(log: &str) -> String {
    match log {
        "" => "it printed nothing".to_owned(),
        log => format!("the end of what it printed:\n{log}"),
    }
}

impl ProgramError {
    pub fn exit_code(&self) -> u8 {
        match self {
            ProgramError::Unsupported { .. } | ProgramError::NotStarted { .. } => exit::USAGE,
            ProgramError::File(_) | ProgramError::Interrupted => exit::TRY_AGAIN,
            _ => exit::ENGINE_FAILED,
        }
    }

    /// Whether it says nothing of the engine: it was never started, a signal ended it, or a file failed.
    pub fn is_no_fault_of_it(&self) -> bool {
        matches!(
            self,
            Self::NotStarted { .. } | Self::Interrupted | Self::File(_)
        )
    }

    /// Whether the engine was understood, though its run is of no use.
    pub fn was_understood(&self) -> bool {
        matches!(self, Self::Nonsense(_) | Self::WentWrong { .. })
    }

    /// Whether the engine is not installed here, or too old.
    pub fn is_missing(&self) -> bool {
        matches!(self, Self::Missing { .. } | Self::TooOld { .. })
    }

    /// Whether the engine ran and failed, which it may not do another time.
    pub fn is_failure(&self) -> bool {
        use ProgramError::{Crashed, Hung, Nonsense, TooMuch};
        matches!(
            self,
            Crashed { .. } | Hung { .. } | TooMuch { .. } | Nonsense(_)
        )
    }
}

fn nonsense(reason: impl Into<String>) -> ProgramError {
    ProgramError::Nonsense(reason.into())
}

/// Nonsense unless this holds.
fn ensure(holds: bool, otherwise: impl FnOnce() -> String) -> Result<()> {
    holds.then_some(()).ok_or_else(|| nonsense(otherwise()))
}

/// What an engine says in JSON, in a file or a line of one.
fn parsed<T: DeserializeOwned>(text: &str, name: &str) -> Result<T> {
    serde_json::from_str(text).map_err(|error: serde_json::Error| {
        let words = text.split(|letter: char| !letter.is_ascii_alphabetic());
        let mut words = words.map(str::to_ascii_lowercase);
        // Which JSON has no word for; some libraries write them all the same.
        let no_number = words.find(|word| ["nan", "inf", "infinity"].contains(&word.as_str()));
        nonsense(match no_number.filter(|_| error.is_syntax()) {
            Some(word) => format!("{name}: a {word} among its numbers: {error}"),
            None => format!("{name}: {error}"),
        })
    })
}

/// A file of one such text, of at most so many bytes.
fn read_json<T: DeserializeOwned>(place: Place, longest: u64, name: &str) -> Result<T> {
    let text = read_text(place, longest).map_err(|error| nonsense(format!("{name}: {error}")))?;
    parsed(&text, name)
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Description {
    pub protocol: u32,
    pub name: String,
    pub version: String,
    pub parts: Vec<Part>,
    /// Where it does something else than the model says, in words; shown wherever its results are.
    #[serde(default)]
    pub approximations: Vec<String>,
    /// Terms of the model that it has in another form; what is found wrong is explained by them first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub forms: Vec<Form>,
    /// Rules that it has, whatever the model says; by them it is judged. From version 2 on.
    #[serde(default, skip_serializing_if = "Rules::are_usual")]
    pub rules: Rules,
    /// Its contact law is another one than the model's, and has this: it is held against itself alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own_law: Option<Vec<Own>>,
}

impl Description {
    /// Of an engine that is no program of somebody else's.
    fn of_this_program(name: &str, version: String, parts: Vec<Part>) -> Self {
        Description {
            protocol: PROTOCOL,
            name: name.to_owned(),
            version,
            parts,
            approximations: Vec::new(),
            forms: Vec::new(),
            rules: Rules::default(),
            own_law: None,
        }
    }

    /// Reads what `path` printed when it was asked what it is.
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let broken = |error: serde_json::Error| {
            let printed: String = text.chars().take(200).collect();
            undescribed(path)(format!("{error}; it printed {printed:?}"))
        };
        let Versioned { protocol } = serde_json::from_str(text).map_err(broken)?;
        if !(1..=u64::from(PROTOCOL)).contains(&protocol) {
            return Err(ProgramError::OtherProtocol { found: protocol });
        }
        let description: Description = serde_json::from_str(text).map_err(broken)?;
        let words = [&description.name, &description.version];
        let is_odd = |word: &&String| {
            word.chars().count() > LONGEST_WORDS || word.chars().any(char::is_control)
        };
        let odd = words
            .into_iter()
            .chain(&description.approximations)
            .find(is_odd);
        let wrong = if let Some(word) = odd {
            format!(
                "names and notes are at most {LONGEST_WORDS} characters without line breaks, and it says {word:?}"
            )
        } else if description.name.trim().is_empty() {
            "its name is empty".to_owned()
        } else if !description.has(Part::NormalSpring) {
            "it has no normal_spring, without which there is nothing to ask".to_owned()
        } else {
            return Ok(description);
        };
        Err(undescribed(path)(wrong))
    }

    pub fn has(&self, part: Part) -> bool {
        // This program's own engines name every part.
        let names = |part| self.parts.contains(&part);
        let alone = names(Part::SpaceAlone) && !names(Part::Plane);
        match part {
            Part::Plane => !alone,
            Part::Space if alone => true,
            Part::LimitedMoments => names(part) || names(Part::Moments),
            part => self.parts.contains(&part),
        }
    }

    pub fn label(&self) -> String {
        format!("{} {}", self.name, self.version)
    }
}

/// Looked at before the rest, which another version may not have.
#[derive(Deserialize)]
struct Versioned {
    protocol: u64,
}

/// The most that a description may say, bytes.
const LONGEST: u64 = 1 << 16;
/// Longest name, version or approximation, characters.
const LONGEST_WORDS: usize = 400;
/// A description takes no longer.
const TIME: Duration = Duration::from_secs(30);

fn undescribed(path: &Path) -> impl Fn(String) -> ProgramError {
    move |reason| ProgramError::Undescribed {
        path: path.to_owned(),
        reason,
    }
}

pub fn describe(options: &Options) -> Result<Description> {
    let work = work_folder()?;
    let limits = Limits {
        time: options.limits.time.min(TIME),
        stall: TIME,
        output: 1 << 20,
        ..options.limits
    };
    let asked = Options {
        limits,
        ..options.clone()
    };
    let undescribed = undescribed(&options.program);
    exec::ask(&asked, work.path()).map_err(|error| match error {
        ProgramError::Crashed { status, log } => {
            undescribed(format!("it ended with {status}\n{log}"))
        }
        ProgramError::Hung { reason, .. } => undescribed(reason),
        ProgramError::TooMuch { reason } => undescribed(format!("it took {reason}")),
        other => other,
    })?;
    let text = read_text((work.path(), exec::SAID), LONGEST)
        .map_err(|error| undescribed(error.to_string()))?;
    Description::parse(&options.program, &text)
}

/// What an engine may have; the vocabulary of version 1 of the protocol.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
#[value(rename_all = "snake_case")]
pub enum Part {
    /// normal springs
    NormalSpring,
    /// friction
    TangentialSpring,
    /// friction of its own at walls and punch
    WallFriction,
    /// rotating grains
    Rotation,
    /// dashpots
    Dashpots,
    /// Cundall's damping
    LocalDamping,
    /// gravity
    Gravity,
    /// walls
    Walls,
    /// punch
    Punch,
    /// rules that end a stage
    StopRules,
    /// lists of small experiments
    Cases,
    /// clock of its own steps
    Timing,
    /// constants of its own for loading
    Stages,
    /// grains in the plane, which every engine has that does not say space_alone
    Plane,
    /// spheres in space
    Space,
    /// spheres in space, and nothing in the plane
    SpaceAlone,
    /// springs of Hertz and Mindlin
    HertzMindlin,
    /// moments against rolling and twisting
    Moments,
    /// moments against rolling and twisting, those against rolling limited, which every engine has that says moments
    LimitedMoments,
    /// constant torque against rolling
    ConstantMoments,
    /// adhesion
    Adhesion,
    /// adhesion by Derjaguin, Muller and Toporov
    Dmt,
    /// adhesion by Johnson, Kendall and Roberts
    Jkr,
    /// grains of several materials
    Materials,
    /// planes of any direction
    Planes,
    /// triangles
    Facets,
    /// boxes that spheres run against
    Boxes,
}

impl Part {
    /// In files.
    pub fn name(self) -> String {
        value_name(&self)
    }

    /// With the name in files.
    pub fn in_words(self) -> String {
        let value = self.to_possible_value().expect("no part is hidden");
        let words = value.get_help().expect("each part has its words");
        format!("{words} ({})", self.name())
    }

    /// Some of them, in words.
    pub fn list(parts: &[Part]) -> String {
        let words: Vec<String> = parts.iter().map(|part| part.in_words()).collect();
        words.join(", ")
    }
}

/// As it is written on the command line or in files.
pub fn value_name(variant: &impl ValueEnum) -> String {
    let value = variant.to_possible_value();
    value.map_or(String::new(), |value| value.get_name().to_owned())
}

/// What this model asks for.
fn of_model(model: &Model) -> Vec<Part> {
    let contact = &model.law.contact;
    let adheres = |law| contact.adhesion.is_some() && contact.adhesion_law == law;
    let has =
        |kind: fn(&Surface) -> bool| model.obstacles.iter().any(|obstacle| kind(&obstacle.shape));
    let rolls = |is_so: fn(&Rolling) -> bool| contact.rolling.as_ref().is_some_and(is_so);
    let asked = [
        (Part::NormalSpring, true),
        (Part::TangentialSpring, model.law.has_friction()),
        (Part::WallFriction, model.law.has_friction_of_walls()),
        (Part::Rotation, model.law.rotates()),
        (Part::Dashpots, model.law.has_dashpots()),
        (Part::LocalDamping, model.alpha != 0.0),
        (Part::Gravity, model.gravity != [0.0; 2]),
        (Part::Walls, !model.walls.is_empty()),
        (Part::HertzMindlin, contact.springs == Springs::HertzMindlin),
        (
            Part::Moments,
            rolls(|rolling| match rolling.is_constant() {
                true => rolling.twisting_stiffness != 0.0,
                false => rolling.limit.is_none(),
            }),
        ),
        (
            Part::LimitedMoments,
            rolls(|rolling| !rolling.is_constant() && rolling.limit.is_some()),
        ),
        (Part::ConstantMoments, rolls(Rolling::is_constant)),
        (Part::Adhesion, adheres(AdhesionLaw::Pull)),
        (Part::Dmt, adheres(AdhesionLaw::Dmt)),
        (Part::Jkr, adheres(AdhesionLaw::Jkr)),
        (Part::Materials, !model.law.materials.is_empty()),
        (
            Part::Planes,
            has(|form| matches!(form, Surface::Plane { .. })),
        ),
        (
            Part::Facets,
            has(|form| matches!(form, Surface::Triangle { .. })),
        ),
        (Part::Boxes, has(|form| matches!(form, Surface::Box { .. }))),
    ];
    let asked = asked.into_iter().filter(|(_, asked)| *asked);
    asked.map(|(part, _)| part).collect()
}

/// Where grains are.
fn place(in_space: bool) -> Part {
    if in_space { Part::Space } else { Part::Plane }
}

/// What a task of this scene asks for and the engine does not have.
pub fn missing_for_scene(engine: &Description, scene: &Scene, task: &Task) -> Vec<Part> {
    let mut asked = of_model(&Model::of(scene));
    asked.push(place(scene.in_space()));
    if scene.has_stages() {
        asked.extend(of_model(&Model::in_stage(scene, Stage::Load)));
        asked.push(Part::Stages);
        asked.sort();
        asked.dedup();
    }
    if task.start.stage == Stage::Load || task.until == Until::EndOfLoading {
        asked.push(Part::Punch);
    }
    if !matches!(task.until, Until::Step(_)) {
        asked.push(Part::StopRules);
    }
    asked.retain(|part| !engine.has(*part));
    asked
}

/// Rules that a model has and an engine that has these has not, in words.
pub fn lacking_rules(model: Rules, has: Rules) -> Option<String> {
    let lacking = model.unusual().find(|choice| !choice.is_in(&has))?;
    Some(format!("rule {}", lacking.name()))
}

/// What this case asks for and the engine does not have.
pub fn missing_for_case(engine: &Description, case: &Case) -> Vec<Part> {
    let mut asked = of_model(&case.model);
    asked.extend([Part::Cases, place(case.bodies.in_space())]);
    if case.punch.is_some() {
        asked.push(Part::Punch);
    }
    asked.retain(|part| !engine.has(*part));
    asked
}
