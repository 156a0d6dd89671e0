//! Programs that are no engines: each is ended and named, and leaves no run folder.

use crate::support::*;

/// Runs two grains for ten steps in a program that says of itself `say` and then does `does`: what is said of it.
fn with(code: i32, say: &str, does: &str, [stall, time]: [&str; 2]) -> String {
    let folder = &folder_with(&scene_of(2));
    let text = format!("{SOUND}{say}{AND_THEN}{does}\n");
    let engine = engine(folder, "engine.py", &text);
    let limits = format!(
        "--steps 10 --stall-limit {stall} --time-limit {time} --memory-limit 300 --output-limit 8"
    );
    let errors = run_in(folder, code, &engine, &limits.words(), "out");
    let mut left = there(folder).into_iter();
    let left = left.find(|name| name.contains(".crossgrain"));
    assert_eq!(left, None, "left behind");
    assert_eq!(
        folder.join("out").exists(),
        code == 0,
        "a run folder of {does}"
    );
    errors
}

#[test]
fn a_program_that_writes_what_it_should_is_believed() {
    let does = "finish([moment(0), moment(10), end(10)])";
    with(0, "", does, ["60", "120"]);
}

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

#[test]
fn what_the_engine_has_started_ends_with_it() {
    let folder = &folder_with(&small_scene());
    let told_by = folder.join("pid");
    let does = format!(
        "child = subprocess.Popen(['sleep', '300'])\nopen({told_by:?}, 'w').write(str(child.pid))\ntime.sleep(600)"
    );
    has(&with(4, "", &does, ["15", "120"]), ["hung"]);
    let pid = text_of(told_by);
    let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    // Ended; whoever takes over orphans may not have looked at it yet.
    let ended = status.is_empty() || status.contains("State:\tZ");
    assert!(ended, "{status}");
}
