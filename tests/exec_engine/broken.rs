//! Programs that are no engines: each is ended and named, and leaves no run folder.

use crate::support::*;

/// Longest time without a sign of life and longest time, s: long, for a machine that is busy.
const PATIENT: [&str; 2] = ["60", "120"];

/// Runs two grains for ten steps in a program that says of itself `say` and then does `does`.
fn with(say: &str, does: &str, [stall, time]: [&str; 2]) -> (i32, String, bool) {
    let mut scene = small_scene();
    scene.particles.count = 2;
    let folder = &folder_with(&scene);
    let text = format!("{SOUND}{say}{AND_THEN}{does}\n");
    let engine = engine(folder, "engine.py", &text);
    let limits = format!(
        "--steps 10 --stall-limit {stall} --time-limit {time} --memory-limit 300 --output-limit 8"
    );
    let (code, _, errors) = run_in(folder, &engine, &limits.words(), "out");
    let left: Vec<PathBuf> = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("readable").path())
        .filter(|path| path.display().to_string().contains(".crossgrain"))
        .collect();
    assert!(left.is_empty(), "left behind: {left:?}");
    (code, errors, folder.join("out").exists())
}

fn fails_in(say: &str, does: &str, message: &str, limits: [&str; 2]) {
    let (code, errors, left) = with(say, does, limits);
    assert_eq!(code, 4, "{say}{does}: {errors}");
    assert!(!left, "{does} left a run folder");
    assert!(errors.contains(message), "«{message}» is missing: {errors}");
}

#[test]
fn a_program_that_writes_what_it_should_is_believed() {
    let (code, errors, left) = with("", "finish([moment(0), moment(10), end(10)])", PATIENT);
    assert_eq!(code, 0, "{errors}");
    assert!(left);
}

/// Before, the folder with the file that the message names was deleted.
#[test]
fn the_file_that_a_message_names_is_kept() {
    let mut scene = small_scene();
    scene.particles.count = 2;
    let folder = &folder_with(&scene);
    let text = format!("{SOUND}{AND_THEN}finish([moment(0), {{'a wrong': 'line'}}, end(10)])\n");
    let engine = engine(folder, "engine.py", &text);
    for kept in ["out.job", "out.job-2"] {
        let (code, _, errors) = run_in(folder, &engine, &["--steps", "10"], "out");
        assert_eq!(code, 4, "{errors}");
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
        let (code, _, errors) = run_in(folder, engine, &[], "out");
        assert_eq!(code, 2, "{errors}");
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
    fails_in("", &does, "hung", ["15", "120"]);
    let pid = text_of(told_by);
    let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    // Ended; whoever takes over orphans may not have looked at it yet.
    let ended = status.is_empty() || status.contains("State:\tZ");
    assert!(ended, "{status}");
}
