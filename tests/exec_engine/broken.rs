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

/// A right engine whose first table of loading is changed afterwards: before, `run` wrote a folder that no verb could read.
#[test]
fn loading_begins_with_the_grains_of_the_settled_bed() {
    let folder = &folder_with(&small_scene());
    let compile = format!(
        "cc -O2 -std=c11 -o right {} -lm",
        root("tests/strangers/engine.c").display()
    );
    assert_eq!(bash(folder, &compile, &[]).0, 0);
    let moved = r#"awk -F, -v OFS=, 'NR == 2 { $2 += 1e-9 } 1' "$2/load-0-bodies.csv" > "$2/other" && mv "$2/other" "$2/load-0-bodies.csv""#;
    for (change, code) in [("true", 0), (moved, 4)] {
        let text = format!(
            "#!/bin/sh\n\"${{0%/*}}/right\" \"$@\" || exit 1\n[ \"$1\" != run ] || {{ {change}; }}\n"
        );
        let engine = engine(folder, "engine.sh", &text);
        let out = format!("out-{code}");
        let errors = run_in(folder, code, &engine, &[], &out);
        assert_eq!(folder.join(&out).join("run.json").exists(), code == 0);
        if code != 0 {
            has(&errors, ["loading begins with other grains"]);
        }
    }
}
