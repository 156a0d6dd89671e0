//! What the scripts inside YADE write: the files of a scene's run of ten steps or, with a part `case`, of a case. `frames.bin` is
//! the last part; its line's end, if it has one, is no part of it.

use crossgrain::engine::yade::{frames, read_cases};
use grains::generate::initial_bodies;
use grains::task::Task;

use super::parts::{self, Parts};
use super::small;

/// Gives the reader what the input has.
pub fn read(input: &[u8]) -> bool {
    let parts = Parts::of(input);
    let folder = parts::folder();
    parts.write(&["frames.jsonl", "done.json"], folder.path());
    if let Some(bytes) = parts.get("frames.bin") {
        let bytes = bytes.strip_suffix(b"\n").unwrap_or(bytes);
        parts::put(folder.path(), "frames.bin", bytes);
    }
    if parts.get("case").is_some() {
        let case = small::case();
        return match read_cases(folder.path(), &[&case]) {
            Ok(found) => {
                assert_eq!(found[0].track.len(), case.moments.len());
                true
            }
            Err(_) => false,
        };
    }
    let scene = small::scene();
    let task = Task::pour(initial_bodies(&scene), 10);
    match frames::read(folder.path(), &scene, &task, &mut ()) {
        Ok(outcome) => {
            assert_eq!(outcome.last.step, 10);
            true
        }
        Err(_) => false,
    }
}
