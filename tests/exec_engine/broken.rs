//! Programs that are no engines: each is ended and named, and leaves no run folder.

use crate::support::*;

/// Before, the folder with the file that the message names was deleted.
#[test]
fn the_file_that_a_message_names_is_kept() {
    let folder = &folder_with(&scene_of(2));
    let text = format!("{SOUND}{AND_THEN}finish([moment(0), {{'a wrong': 'line'}}, end(10)])\n");
    let engine = engine(folder, "engine.py", &text);
    for kept in ["out.job", "out.job-2"] {
        let errors = run_in(folder, 4, &engine, &["--steps", "10"], "out");
        has(&errors, ["moments.jsonl: "]);
        has(&errors, [&format!("is kept in {kept}\n")]);
        let named = folder.join(kept).join("moments.jsonl");
        let named = text_of(named);
        assert!(named.contains("a wrong"));
    }
}

#[test]
fn a_program_that_cannot_be_started_is_named() {
    let folder = &folder_with(&small_scene());
    fs::write(folder.join("text"), "no program\n").expect("writable");
    for engine in ["exec:/nowhere/engine", "exec:text", "exec:."] {
        let errors = run_in(folder, 2, engine, &[], "out");
        has(&errors, ["cannot be started", "chmod +x"]);
    }
}
