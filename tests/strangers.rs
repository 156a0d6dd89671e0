//! Engines by someone who has not read the judge, in scenes of their own: wrong ones, each of which ignores, swaps or hard-codes one
//! thing or writes one table wrongly, and right ones. None that is wrong may be called agreed by `compare`, `engine check` or `verify`,
//! and no right one different. CROSSGRAIN_KEEP=1 writes the whole table to `reference_data/strangers-1.csv`.
//! Every twenty-fifth engine is judged each time, all of them when the table is made anew.

use crossgrain::checks::Outcome;
use crossgrain::compare::compare;
use crossgrain::compare::first_difference::Locator;
use crossgrain::compare::first_steps::Beds;
use crossgrain::compare::from_runs::states_of;
use crossgrain::engine::exec::{ExternalEngine, Options};
use crossgrain::engine::{Engine, EngineError};
use crossgrain::run::folder::read_scene;
use crossgrain::run::recorded;
use crossgrain::suite::conformance::conformance;
use crossgrain::suite::run::verify_in;
use evidence::in_parallel;
use serde::Deserialize;
use verdict::judge::Reference;
use verdict::starts::DISPERSION;

use crate::support::*;

/// Grains of the bed, more than the ids from which one of the faults begins.
const GRAINS: u32 = 600;

const NOT_RUN: &str = "not run";
/// What a wrong engine writes of its scene is what the right one writes.
const RIGHT_THERE: &str = "right there";

#[derive(Deserialize)]
struct Stranger {
    name: String,
    switch: String,
    flags: String,
    right: bool,
    scene: Option<String>,
    steps: Option<u64>,
    until: Option<String>,
    #[serde(default)]
    seen_in: Vec<String>,
}

impl Stranger {
    fn protocol(&self) -> Protocol {
        match (self.steps, self.until.as_deref()) {
            (Some(steps), _) => Protocol::Steps { steps },
            (None, Some("settled")) => Protocol::Settled,
            (None, _) => Protocol::Whole,
        }
    }

    /// Whether it does anything wrong in this kind of job.
    fn shows_in(&self, kind: &str) -> bool {
        self.seen_in.iter().any(|job| job == kind)
    }
}

fn here(name: &str) -> PathBuf {
    root("tests/strangers").join(name)
}

/// The program of a stranger: one binary for each set of flags, and a link of the stranger's name to it.
fn program(folder: &Path, stranger: &Stranger) -> PathBuf {
    let built =
        folder.join(format!("{:x}", stranger.flags.len()) + &stranger.flags.replace(' ', "_"));
    if !built.exists() {
        fs::create_dir(&built).expect("a folder");
        let mut command = Command::new("sh");
        let line = format!("cc {} -o \"$1\" \"$2\" -lm", stranger.flags);
        command
            .args(["-c", &line, "sh"])
            .arg(built.join("engine"))
            .arg(here("engine.c"));
        assert!(command.status().expect("a shell").success(), "{line}");
    }
    if stranger.switch.is_empty() {
        return built.join("engine");
    }
    // The right engine is beside it.
    let link = built.join(format!("engine--{}", stranger.switch));
    if !link.exists() {
        fs::copy(built.join("engine"), &link).expect("a copy");
    }
    link
}

#[test]
fn no_wrong_engine_of_a_stranger_is_agreed_with() {
    let strangers: Vec<Stranger> =
        serde_json::from_value(json_of(here("strangers.json"))).expect("a list");
    let all = std::env::var_os("CROSSGRAIN_KEEP").is_some();
    let only = std::env::var("CROSSGRAIN_STRANGER").ok();
    let folder = &new_folder();
    let reference = Reference::new(GRAINS, DISPERSION, &mut |_| ()).expect("a bed");
    let beds = Beds::from(reference.without_causes());
    let scene_of = |name: &str| read_scene(&here("scenes").join(name)).expect("a scene");
    let run = |stranger: &Stranger, name: &str, engine: &dyn Engine| {
        let (scene, work) = (scene_of(name), new_folder());
        let start = initial_bodies(&scene);
        recorded(
            &scene,
            engine,
            stranger.protocol(),
            start,
            &work,
            &mut |_, _, _| (),
        )
    };
    let key = |stranger: &Stranger, name: &str| format!("{name} {:?}", stranger.protocol());
    let mut of_scenes: BTreeMap<String, Beds> = BTreeMap::new();
    let mut natives: BTreeMap<String, RunFolder> = BTreeMap::new();
    let mut rights: BTreeMap<String, RunFolder> = BTreeMap::new();
    let chosen = |stranger: &Stranger| {
        let kind = if stranger.right { "right" } else { "wrong" };
        only.as_ref()
            .is_none_or(|only| stranger.name == *only || kind == only)
    };
    let every = if all || only.is_some() { 1 } else { 25 };
    let strangers = strangers.into_iter().filter(chosen).step_by(every);
    let strangers: Vec<Stranger> = strangers.collect();
    for stranger in &strangers {
        program(folder, stranger);
        let Some(name) = &stranger.scene else {
            continue;
        };
        let native = || run(stranger, name, &sound()).expect("a run");
        natives.entry(key(stranger, name)).or_insert_with(native);
        if !stranger.right {
            let right = program(folder, stranger).with_file_name("engine");
            let right = || {
                let right = ExternalEngine::ask(Options::new(right)).expect("an engine");
                run(stranger, name, &right).expect("a run")
            };
            rights.entry(key(stranger, name)).or_insert_with(right);
        }
        if !stranger.right && !stranger.shows_in("cases") {
            let states = || states_of(&scene_of(name)).expect("states");
            let beds = || Beds::from(states().without_causes());
            of_scenes.entry(name.clone()).or_insert_with(beds);
        }
    }
    let judged = in_parallel(strangers.len(), |at| {
        let stranger = &strangers[at];
        let options = Options::new(program(folder, stranger));
        let asked = || ExternalEngine::ask(options.clone()).map_err(EngineError::from);
        let compared = stranger.scene.as_ref().map_or(NOT_RUN, |name| {
            let Ok(theirs) = asked().and_then(|of_it| run(stranger, name, &of_it)) else {
                return "engine failed";
            };
            // A verdict of compare is about what was run.
            let all =
                |run: &RunFolder| (run.settled.clone(), run.last.clone(), run.history.clone());
            let right = rights.get(&key(stranger, name)).filter(|_| !stranger.right);
            if right.is_some_and(|right| all(right) == all(&theirs)) {
                return RIGHT_THERE;
            }
            let locator = Locator {
                programs: vec![options.clone()],
                ..Locator::default()
            };
            let native = &natives[&key(stranger, name)];
            compare(&theirs, native, Some(&locator))
                .verdict()
                .in_words()
        });
        // What shows in a user's scene alone is judged from that scene.
        let of_scene = stranger.scene.as_ref().and_then(|name| of_scenes.get(name));
        let of_scene = of_scene.filter(|_| !stranger.right && !stranger.shows_in("cases"));
        let checked = match asked()
            .and_then(|engine| conformance(&engine, of_scene.unwrap_or(&beds), &mut |_| ()))
        {
            Ok(found) => found.verdict().in_words(),
            Err(_) => "engine failed",
        };
        let verified =
            match asked().and_then(|engine| verify_in(&engine, &beds, "", &Display::new(true))) {
                Ok(found) => match found.verdict() {
                    Outcome::Pass => "agreed",
                    Outcome::Fail => "different",
                    Outcome::Skipped | Outcome::ExpectedFailure => "undecided",
                },
                Err(_) => "engine failed",
            };
        let is = if stranger.right { "right" } else { "wrong" };
        let row = format!("{},{is},{compared},{checked},{verified}", stranger.name);
        println!("{row}");
        let agreed = |word: &str| ["identical", "equal to rounding", "agreed"].contains(&word);
        let mistaken = match stranger.right {
            true => [compared, checked, verified]
                .iter()
                .any(|word| ["different", "engine failed"].contains(word)),
            false => [compared, checked, verified]
                .iter()
                .any(|word| agreed(word)),
        };
        (row, mistaken)
    });
    let mistakes: Vec<&String> = judged
        .iter()
        .filter(|judged| judged.1)
        .map(|judged| &judged.0)
        .collect();
    let head = ["engine,is,compare,engine check,verify".to_owned()];
    let rows: Vec<String> = head
        .into_iter()
        .chain(judged.iter().map(|judged| judged.0.clone()))
        .collect();
    let found = rows.join("\n") + "\n";
    if all {
        fs::write(root("reference_data/strangers-1.csv"), &found).expect("writable");
    }
    assert!(mistakes.is_empty(), "{mistakes:#?}");
}
