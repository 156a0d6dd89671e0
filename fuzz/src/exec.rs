//! What a program of the engine protocol says and writes: the part `describe`, or the files of a scene, or of a case;
//! the tables as text or as numbers. `tables.bin` is the last part of an input; its line's end, if it has one, is none of it.

use std::path::Path;

use crossgrain::engine::exec::Description;
use crossgrain::engine::read;
use grains::generate::initial_bodies;
use grains::tables::Snapshot;
use grains::task::{Observer, Task};

use super::parts::{self, Parts};
use super::small;

/// The files of a scene's run of ten steps; those of a case are in `case-0000`.
const FILES: [&str; 8] = [
    "moments.jsonl",
    "settle-0-bodies.csv",
    "settle-0-contacts.csv",
    "settle-10-bodies.csv",
    "settle-10-contacts.csv",
    "tables.bin",
    "effective.json",
    "done.json",
];

/// What is shown while reading is finite.
struct Sound;

impl Observer for Sound {
    fn snapshot(&mut self, snapshot: &Snapshot) {
        assert!(snapshot.bodies.x.iter().all(|x| x.is_finite()));
    }
}

/// Gives the reader what the input has.
pub fn read(input: &[u8]) -> bool {
    let parts = Parts::of(input);
    if let Some(text) = parts.text("describe") {
        return describes(text);
    }
    let folder = parts::folder();
    if parts.get("case").is_some() {
        let inside = folder.path().join("case-0000");
        std::fs::create_dir(&inside).expect("a folder in a folder of ours");
        parts.write(&FILES[..7], &inside);
        parts.write(&FILES[7..], folder.path());
        let case = small::case();
        let found = read::cases(folder.path(), &[&case]);
        return found.is_ok_and(|found| match &found[0] {
            Ok(run) => {
                assert_eq!(run.track.len(), case.moments.len());
                true
            }
            Err(_) => false,
        });
    }
    parts.write(&FILES, folder.path());
    let scene = small::scene();
    let task = Task::pour(initial_bodies(&scene), 10);
    match read::scene(folder.path(), &scene, &task, &mut Sound) {
        Ok(outcome) => {
            assert_eq!(outcome.last.step, 10);
            true
        }
        Err(_) => false,
    }
}

fn describes(text: &str) -> bool {
    let Ok(description) = Description::parse(Path::new("engine"), text) else {
        return false;
    };
    let written = serde_json::to_string(&description).expect("a description is JSON");
    let again = Description::parse(Path::new("engine"), &written).expect("accepted once");
    assert_eq!(again, description);
    assert!(!description.label().chars().any(char::is_control));
    true
}
