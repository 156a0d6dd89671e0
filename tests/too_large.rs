//! What asks for too much memory is refused before it gets it.

use std::fmt::Display;

use allocation_counter::measure;

use crossgrain::checks::record;
use crossgrain::files::read_text;
use crossgrain::run::folder::read_scene;

use crate::folder::{put, written};
use crate::readers::parts::packed;
use crate::support::*;

/// How this is refused, with less memory than so many megabytes.
fn refusal<T, E: Display>(megabytes: u64, read: impl FnOnce() -> Result<T, E>) -> String {
    let mut error = String::new();
    let taken = measure(|| error = read().err().expect("a refusal").to_string());
    assert!(taken.bytes_max < megabytes << 20, "{error}: {taken:?}");
    error
}

#[test]
fn a_scene_of_a_million_million_grains_is_refused_before_they_are_made() {
    let text = serde_json::to_string(&tiny_scene()).expect("JSON");
    for count in "1000000000000 4294967295 1000001 1e12 18446744073709551616".split(' ') {
        let huge = text.replace("\"count\":100,", &format!("\"count\":{count},"));
        assert_ne!(huge, text);
        refusal(1, || parse_scene(&huge));
    }
}

/// A large file that takes no room on the disk.
fn hole(path: &Path) {
    let file = fs::File::create(path).expect("writable");
    file.set_len(1 << 36).expect("a large file");
}

#[test]
fn a_scene_file_that_is_none_is_not_read_whole() {
    let folder = &new_folder();
    let path = folder.join("scene.json");
    hole(&path);
    let error = refusal(16, || read_scene(&path));
    has(&error, ["larger than 4194304 bytes"]);
}

#[test]
fn packed_tables_are_unpacked_no_further_than_they_may_reach() {
    // Empty lines are no rows, and a line without an end is none; where one block holds a whole table that is too large first.
    let [empty, endless] = [b'\n', b'0'].map(|byte| packed(&vec![byte; 64 << 20]));
    let [large, long] = ["is larger than", "line 1 is longer than 4096"];
    let run = native_run(&tiny_scene(), sound(), Protocol::Steps { steps: 10 });
    for (table, of_endless) in [
        ("initial", large),
        ("bodies", large),
        ("contacts", long),
        ("history", large),
        ("trace", long),
    ] {
        for (bomb, refused) in [(&empty, large), (&endless, of_endless)] {
            let (_folder, path) = written(&run);
            let table = path.join(table).with_extension("csv");
            fs::remove_file(&table).expect("it is there");
            put(&table.with_extension("csv.gz"), bomb);
            let error = refusal(16, || RunFolder::read(&path));
            assert!(error.contains(refused), "{table:?}: {error}");
        }
    }
}

/// `gzip` files may be put one after the other; all of it counts, and what is not packed is an error.
#[test]
fn all_of_a_packed_file_is_read() {
    let folder = &new_folder();
    let path = folder.join("a.csv.gz");
    fs::write(&path, [packed(b"one\n"), packed(b"two\n")].concat()).expect("writable");
    assert_eq!(read_text(&path, 100).expect("text"), "one\ntwo\n");
    assert!(read_text(&path, 5).is_err());
    fs::write(&path, [&packed(b"one\n"), b"and more".as_slice()].concat()).expect("writable");
    assert!(read_text(&path, 100).is_err());
}

/// Steps so many that the moments of them cannot be counted.
#[test]
fn a_record_of_more_steps_than_there_are_numbers_is_refused() {
    let mut scene = tiny_scene();
    scene.measurement.history_every = 1;
    let protocol = Protocol::Steps { steps: 3 };
    let mut run = native_run(&scene, sound(), protocol);
    run.record.stages[0].steps = u64::MAX;
    let folder = new_folder();
    let path = folder.join("run");
    run.write(&path).expect("a writable folder");
    let error = refusal(8, || RunFolder::read(&path));
    has(&error, ["moments of history"]);
}

/// Thousands of checks of one id are refused without being counted up; the message names the id once.
#[test]
fn a_record_cannot_multiply_its_names() {
    let check = r#"{"id": "x", "quantity": "", "unit": "", "method": "", "basis": "", "n": 1, "outcome": "pass", "found": ""}"#;
    let many = vec![check; 20_000].join(",");
    let text = format!(
        r#"{{"job": "verify", "version": 1, "crossgrain": "", "command": "", "verdict": "pass", "checks": [{many}]}}"#
    );
    let error = refusal(32, || record::parse("r", &text));
    assert!(error.len() < 200 && error.contains("the id x"), "{error}");
}

/// Neither a pipe that nobody writes to nor a file without lines is waited for.
#[test]
fn what_is_no_program_is_no_yade() {
    let folder = &folder_with(&tiny_scene());
    let pipe = a_pipe(folder, "pipe");
    hole(&folder.join("hole"));
    for yade in [Path::new("/dev/zero"), &pipe, &folder.join("hole"), folder] {
        let began = Instant::now();
        let yade = yade.to_string_lossy();
        let run = "run scene.json --engine=yade --out=o --yade".words();
        tells(
            folder,
            4,
            &[&run[..], &[&yade]].concat(),
            ["YADE is missing"],
        );
        assert!(began.elapsed() < Duration::from_secs(20), "{yade}");
        assert!(!folder.join("o").exists());
    }
}
