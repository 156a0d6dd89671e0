//! What several tests need.

pub mod browser;
pub mod engines;
pub mod pages;

// What most tests name.
pub use std::collections::{BTreeMap, BTreeSet};
pub use std::fs;
pub use std::path::{Path, PathBuf};
pub use std::process::{Child, Command, Output, Stdio};
pub use std::time::{Duration, Instant};

pub use crossgrain::progress::Display;
pub use crossgrain::run::folder::RunFolder;
pub use crossgrain::run::folder::record::Protocol;
pub use grains::generate::initial_bodies;
pub use grains::native;
pub use grains::scene::{Scene, paper_scene, parse_scene};
pub use grains::tables::{Bodies, Contact, Punch, Snapshot, Stage, StopReason};
pub use grains::task::{Start, Task, Until};
pub use serde_json::{Value, json};

pub use engines::*;
pub use pages::*;

use std::ops::Deref;

use crossgrain::engine::Engine;
use crossgrain::files::read_text;
use crossgrain::run::recorded;
use crossgrain::study::Study;
use crossgrain::study::folder::{AnyStudy as _, StudyFolder};
use grains::native::Fault;
use grains::scene::Cloud;
use grains::task::Outcome;
use serde::de::DeserializeOwned;

/// The paper's scene in a box of this width, m, with so many grains; `offsets` is a factor, `depth` in m.
fn paper_in(width: f64, grains: u32, offsets: f64, depth: f64) -> Scene {
    let mut scene = paper_scene(1, grains);
    let Cloud::JitteredLattice { columns, .. } = &mut scene.cloud;
    *columns = (f64::from(*columns) * width / scene.container.width).round() as u32;
    scene.container.width = width;
    for point in &mut scene.control_points {
        point.offset *= offsets;
        point.depth = depth;
    }
    scene
}

/// The paper's scene, 0.3 m wide with 300 grains: the same physics in a second.
pub fn small_scene() -> Scene {
    paper_in(0.3, 300, 0.5, 0.05)
}

/// The same box with this number of grains.
pub fn scene_of(count: u32) -> Scene {
    let mut scene = small_scene();
    scene.particles.count = count;
    scene
}

/// A scene that never settles.
pub fn endless_scene() -> Scene {
    let mut scene = small_scene();
    scene.settle.kinetic_energy_fraction = 1.0e-300;
    scene.settle.max_steps = 200_000_000;
    scene
}

/// The paper's scene, 0.15 m wide with 100 grains: about a twentieth of a second.
pub fn tiny_scene() -> Scene {
    paper_in(0.15, 100, 0.25, 0.0267)
}

/// 60 grains with friction, eight a layer, thrown in with spins.
pub fn frictional_scene() -> Scene {
    let mut scene = small_scene();
    scene.particles.count = 60;
    scene.particles.dispersion = 0.2;
    scene.material.friction_angle = 0.5;
    scene.material.stiffness_ratio = 0.3;
    scene.container.width = 0.1;
    scene.control_points.truncate(1);
    scene.cloud = Cloud::JitteredLattice {
        columns: 8,
        jitter: 0.9,
        speed: 0.3,
        spin: 40.0,
        over: None,
    };
    scene
}

/// Pourings and loadings with different constants: a name, what is put over [`frictional_scene`], whether contacts bear
/// tangential forces in the settled and in the loaded bed, and whether YADE has it.
const STAGES: &str = r#"
    friction is switched on ⇒ {"material": {"friction_angle": 0.0}, "loading": {"material": {"friction_angle": 0.4}}} ⇒ no ⇒ yes ⇒ yes
    friction is switched off ⇒ {"loading": {"material": {"friction_angle": 0.0}}} ⇒ yes ⇒ no ⇒ yes
    other springs, friction and damping ⇒ {"loading": {"material": {"youngs_modulus": 7e9, "stiffness_ratio": 0.6, "friction_angle": 0.2}, "damping": {"alpha": 0.5}}} ⇒ yes ⇒ yes ⇒ yes
    rough walls, then smooth grains under a rough punch ⇒ {"material": {"friction_angle": 0.1, "wall_friction_angle": 0.5}, "loading": {"material": {"friction_angle": 0.0, "wall_friction_angle": 0.1, "punch_friction_angle": 0.6}}} ⇒ yes ⇒ yes ⇒ yes
    smooth walls and punch ⇒ {"material": {"wall_friction_angle": 0.0, "punch_friction_angle": 0.0}} ⇒ yes ⇒ yes ⇒ yes
    smooth walls beside dashpots ⇒ {"material": {"wall_friction_angle": 0.0}, "contact": {"viscosity": {"kind": "dashpot", "c_n": 300.0, "tension": "clipped"}, "slip_velocity": "contact_point", "torque_arms": "contact_point"}} ⇒ yes ⇒ yes ⇒ no
    other rules of friction ⇒ {"loading": {"contact": {"slip_velocity": "contact_point", "torque_arms": "contact_point"}}} ⇒ yes ⇒ yes ⇒ yes
    rotation is set free ⇒ {"contact": {"rotation": "blocked"}, "loading": {"contact": {"rotation": "free"}}} ⇒ yes ⇒ yes ⇒ yes
    stronger dashpots ⇒ {"contact": {"viscosity": {"kind": "dashpot", "c_n": 300.0, "tension": "clipped"}, "slip_velocity": "contact_point", "torque_arms": "contact_point"}, "loading": {"contact": {"viscosity": {"c_n": 900.0}}}} ⇒ yes ⇒ yes ⇒ yes
    dashpots are put in ⇒ {"loading": {"contact": {"viscosity": {"kind": "restitution", "e_n": 0.5, "tension": "clipped"}}}} ⇒ yes ⇒ yes ⇒ no
"#;

/// The rows of [`STAGES`].
pub fn stages() -> impl Iterator<Item = (&'static str, &'static str, [bool; 2], bool)> {
    rows(STAGES).map(|[name, changes, settled, loaded, yade]| {
        let [settled, loaded, yade] = [settled, loaded, yade].map(|word| word == "yes");
        (name, changes, [settled, loaded], yade)
    })
}

/// Faults of the native engine that every comparison must find.
pub const FAULTS: [&str; 5] = [
    "stiffness=1e-12",
    "gravity=1e-12",
    "damping=1e-12",
    "wall=1e-12",
    "sums=reversed",
];

/// The frictional scene with these changes, a JSON merge patch.
pub fn staged_scene(changes: &str) -> Scene {
    fn merge(into: &mut Value, changes: Value) {
        match changes {
            Value::Object(changes) if into.is_object() => {
                for (key, value) in changes {
                    merge(&mut into[key], value);
                }
            }
            other => *into = other,
        }
    }
    let mut scene = serde_json::to_value(frictional_scene()).expect("a scene");
    merge(&mut scene, serde_json::from_str(changes).expect("JSON"));
    parse_scene(&scene.to_string()).expect("a valid scene")
}

/// The native engine as it is.
pub fn sound() -> native::Options {
    native::Options::default()
}

/// The native engine with a fault.
pub fn faulty(fault: &str) -> native::Options {
    let fault: Fault = fault.parse().expect("a fault that the engine knows");
    native::Options {
        perturbation: Some(fault),
        ..native::Options::default()
    }
}

/// A run with everything that a folder holds.
pub fn run_of(scene: &Scene, engine: &dyn Engine, protocol: Protocol) -> RunFolder {
    let (initial, work) = (initial_bodies(scene), new_folder());
    let run = recorded(scene, engine, protocol, initial, &work, &mut |_, _, _| {});
    run.expect("a run that finishes")
}

/// The same in the native engine.
pub fn native_run(scene: &Scene, options: native::Options, protocol: Protocol) -> RunFolder {
    run_of(scene, &options, protocol)
}

/// A bare native run.
pub fn native_outcome(scene: &Scene, task: &Task, skin: Option<f64>) -> (Outcome, Vec<Snapshot>) {
    let mut keep = Vec::new();
    let options = native::Options {
        skin,
        ..native::Options::default()
    };
    let outcome =
        native::run(scene, task, &options, &mut keep).expect("a native run that finishes");
    (outcome, keep)
}

/// The words of a command: those of a line, or one by one where one is a path, which may have spaces.
pub trait Words {
    fn words(&self) -> Vec<&str>;
}

impl Words for str {
    fn words(&self) -> Vec<&str> {
        self.split(' ').collect()
    }
}

impl Words for String {
    fn words(&self) -> Vec<&str> {
        self.as_str().words()
    }
}

impl Words for Vec<&str> {
    fn words(&self) -> Vec<&str> {
        self.clone()
    }
}

impl Words for [&str] {
    fn words(&self) -> Vec<&str> {
        self.to_vec()
    }
}

impl<const N: usize> Words for [&str; N] {
    fn words(&self) -> Vec<&str> {
        self.to_vec()
    }
}

/// The program under test, to be started in a folder.
pub fn cli(folder: &Path) -> Command {
    let mut program = Command::new(env!("CARGO_BIN_EXE_crossgrain"));
    program.current_dir(folder);
    program.env("XDG_CACHE_HOME", folder.join(".cache"));
    program
}

/// What it does with a command.
pub fn crossgrain(command: &(impl Words + ?Sized), folder: &Path) -> Output {
    let mut program = cli(folder);
    program.args(command.words()).env_remove("CROSSGRAIN_YADE");
    program.output().expect("the program starts")
}

/// The program at work, and nobody listens to it.
pub fn started(folder: &Path, command: &(impl Words + ?Sized)) -> Child {
    let mut program = cli(folder);
    program.stdout(Stdio::null()).stderr(Stdio::null());
    let child = program.args(command.words()).spawn();
    child.expect("the program starts")
}

/// Lines of bash in a folder, with the program as `$0` and these arguments: exit code, output, errors.
pub fn bash(folder: &Path, lines: &str, arguments: &[&str]) -> (i32, String, String) {
    let mut bash = Command::new("bash");
    bash.args(["-c", lines, env!("CARGO_BIN_EXE_crossgrain")]);
    let output = bash.args(arguments).current_dir(folder).output();
    told(&output.expect("bash is there"))
}

/// What this Python makes of lines with a folder of modules: exit code, output, errors.
pub fn python(
    program: &str,
    modules: &Path,
    lines: &str,
    arguments: &[&Path],
) -> (i32, String, String) {
    let mut python = Command::new(program);
    python.args(["-B", "-c", lines]).args(arguments);
    let output = python.env("PYTHONPATH", modules).output();
    told(&output.expect("a Python"))
}

/// A child that is ended with the value.
pub struct Running(pub Child);

impl Drop for Running {
    fn drop(&mut self) {
        // Both fail only when it has ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Waits until this holds, which it must within so many seconds.
#[track_caller]
pub fn within(seconds: u64, what: &str, holds: impl Fn() -> bool) {
    let began = Instant::now();
    while !holds() {
        let waits = began.elapsed() < Duration::from_secs(seconds);
        assert!(waits, "not within {seconds} s: {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Sends this signal.
pub fn send(child: &Child, signal: &str) {
    let sent = Command::new("kill")
        .args(["-s", signal, &child.id().to_string()])
        .status();
    assert!(sent.expect("kill is there").success());
}

/// The most memory that a process has had, kB; 0 once it has gone, and as long as it still has the memory of the tests, which
/// started it and may go on before it has its own.
pub fn peak_memory(process: u32) -> u64 {
    let program = |process: &str| fs::read_link(format!("/proc/{process}/exe")).ok();
    if program(&process.to_string()) == program("self") {
        return 0;
    }
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let number = peak.and_then(|rest| rest.split_whitespace().next()?.parse().ok());
    number.unwrap_or(0)
}

/// A zombie waits for nobody but its parent.
pub fn is_running(process: u32) -> bool {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    let state = stat.rsplit_once(") ");
    state.is_some_and(|(_, state)| !state.starts_with(['Z', 'X']))
}

/// How many processes but this one have the folder in their command or work in it.
pub fn at_work_in(folder: &Path) -> usize {
    let (text, own) = (folder.to_string_lossy(), std::process::id().to_string());
    let others = fs::read_dir("/proc").expect("Linux").flatten();
    let others = others.filter(|process| process.file_name().to_string_lossy() != own);
    let inside = others.filter(|process| {
        let command = fs::read(process.path().join("cmdline")).unwrap_or_default();
        let place = fs::read_link(process.path().join("cwd"));
        place.is_ok_and(|place| place.starts_with(folder))
            || String::from_utf8_lossy(&command).contains(&*text)
    });
    inside.count()
}

/// What git says to this in the folder.
pub fn git(folder: &Path, words: &[&str]) -> String {
    let who = "-c user.name=a -c user.email=a@b -c commit.gpgsign=false";
    let mut git = Command::new("git");
    git.args(who.words()).current_dir(folder).args(words);
    let done = git.output().expect("git is there");
    assert!(done.status.success(), "{words:?}: {done:?}");
    String::from_utf8_lossy(&done.stdout).trim().to_owned()
}

/// Exit code, standard output, standard error.
pub fn told(output: &Output) -> (i32, String, String) {
    let [out, errors] =
        [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    let code = output.status.code().unwrap_or(-1);
    (code, out.into_owned(), errors.into_owned())
}

/// What the program told of this command.
pub fn say(folder: &Path, command: &(impl Words + ?Sized)) -> (i32, String, String) {
    told(&crossgrain(command, folder))
}

/// The same of one that ends with this exit code: standard output, standard error.
pub fn ends(folder: &Path, code: i32, command: &(impl Words + ?Sized)) -> (String, String) {
    let (ended, out, errors) = say(folder, command);
    assert_eq!(ended, code, "{:?}: {out}{errors}", command.words());
    (out, errors)
}

/// What a text must say.
#[track_caller]
pub fn has<const N: usize>(text: &str, words: [&str; N]) {
    for words in words {
        assert!(text.contains(words), "{words}: {text}");
    }
}

/// Two numbers differ by less than this.
#[track_caller]
pub fn near(found: f64, wanted: f64, least: f64) {
    assert!((found - wanted).abs() < least, "{found} for {wanted}");
}

/// A command that ends with this exit code and says these words: where it prints what it found, else in its errors.
#[track_caller]
pub fn tells<const N: usize>(
    folder: &Path,
    code: i32,
    command: &(impl Words + ?Sized),
    words: [&str; N],
) {
    let (out, errors) = ends(folder, code, command);
    let told = if matches!(code, 0 | 1 | 3) {
        out
    } else {
        errors
    };
    has(&told, words);
}

/// Names in a folder.
pub fn there(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let names = entries.map(|entry| entry.expect("an entry").file_name());
    names
        .map(|name| name.to_string_lossy().into_owned())
        .collect()
}

/// Everything below a folder; links are not followed.
pub fn below(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() && !path.is_symlink() {
            found.extend(below(&path));
        }
        found.push(path);
    }
    found
}

/// What a command prints as JSON, which ends with this exit code.
#[track_caller]
pub fn prints(folder: &Path, code: i32, command: &(impl Words + ?Sized)) -> Value {
    serde_json::from_str(&ends(folder, code, command).0).expect("JSON")
}

/// The rows of a table, a line each, whose cells have ` ⇒ ` between them.
pub fn rows<const N: usize>(table: &str) -> impl Iterator<Item = [&str; N]> {
    let lines = table.lines().map(str::trim).filter(|line| !line.is_empty());
    lines.map(|line| {
        let cells: Vec<&str> = line.split(" ⇒ ").collect();
        cells.try_into().expect("as many cells as columns")
    })
}

/// A path of the project.
pub fn root(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// What a file says.
#[track_caller]
pub fn text_of(path: impl AsRef<Path>) -> String {
    let path = path.as_ref();
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// What a file of JSON says.
#[track_caller]
pub fn json_of(path: impl AsRef<Path>) -> Value {
    serde_json::from_str(&text_of(path)).expect("JSON")
}

/// A run folder that is whole.
#[track_caller]
pub fn read_run(path: impl AsRef<Path>) -> RunFolder {
    RunFolder::read(path.as_ref()).expect("a whole run folder")
}

/// What is recorded of a study.
pub fn recorded_of<R: DeserializeOwned>(folder: impl AsRef<Path>) -> R {
    let path = folder.as_ref().join("report.json.gz");
    let text = read_text(&path, 1 << 26).expect("is there");
    serde_json::from_str(&text).expect("a record")
}

/// What is recorded of a study, which its rows give again.
pub fn judged_again<S: Study, R>(folder: &str) -> (StudyFolder<S>, R)
where
    R: DeserializeOwned + PartialEq,
{
    let path = root(folder);
    let folder = StudyFolder::<S>::open(&path).expect("recorded evidence");
    let report = folder.judge().expect("a judgement");
    let recorded: R = recorded_of(&path);
    let again: R = serde_json::from_str(&report.text).expect("a record");
    assert!(again == recorded, "{}", path.display());
    (folder, recorded)
}

/// A named pipe.
pub fn a_pipe(folder: &Path, name: &str) -> PathBuf {
    let pipe = folder.join(name);
    let made = Command::new("mkfifo").arg(&pipe).status();
    assert!(made.expect("mkfifo is there").success());
    pipe
}

/// Writes a scene as JSON.
pub fn write_scene(scene: &Scene, path: &Path) {
    let text = serde_json::to_string_pretty(scene).expect("a scene is JSON");
    fs::write(path, text).expect("a writable folder");
}

/// A folder that goes away.
pub struct Place(tempfile::TempDir);

impl Deref for Place {
    type Target = Path;

    fn deref(&self) -> &Path {
        self.0.path()
    }
}

impl AsRef<Path> for Place {
    fn as_ref(&self) -> &Path {
        self
    }
}

/// An empty folder that goes away.
pub fn new_folder() -> Place {
    Place(tempfile::tempdir().expect("a temporary folder"))
}

/// A folder that goes away, with a `scene.json` in it.
pub fn folder_with(scene: &Scene) -> Place {
    let folder = new_folder();
    write_scene(scene, &folder.join("scene.json"));
    folder
}
