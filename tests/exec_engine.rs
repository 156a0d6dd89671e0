//! Engines that people bring: the toy has the native engine's bits, each way in which a program can be broken is its own
//! message and leaves no run folder, and `engine check` says what is wrong. Needs a Python and nothing else.

mod broken;
mod check;
mod tables;

use std::fs;

use crate::support::engines::{adapter, changed_toy, narrow_scene, program, ran_in, run_in};
use crate::support::{crossgrain, folder_with, told};

#[test]
fn the_toy_has_every_bit_of_the_native_engine() {
    let (folder, _) = folder_with(&narrow_scene(0.05));
    let toy = adapter("toy.py");
    for (engine, out) in [("native", "native"), (toy.as_str(), "toy")] {
        ran_in(folder.path(), engine, &["--steps", "1200"], out);
    }
    let compared = crossgrain(
        &["compare", "native", "toy", "--expect-bits"],
        folder.path(),
    );
    let (code, text, errors) = told(&compared);
    assert_eq!(code, 0, "{text}{errors}");
    // Nobody has promised bits of an engine that was brought, so without being asked none are expected.
    let compared = crossgrain(&["compare", "native", "toy"], folder.path());
    let (code, text, _) = told(&compared);
    assert_eq!(code, 3, "{text}");
    let record = fs::read_to_string(folder.path().join("toy/run.json")).expect("a record");
    assert!(record.contains(r#""name": "toy""#) && record.contains(r#""kernel": null"#));
}

#[test]
fn a_law_that_differs_is_seen_by_its_bits() {
    let (folder, _) = folder_with(&narrow_scene(0.05));
    let toy = changed_toy(
        "2.0 * a * b / (a + b)",
        "2.0 * a * b / (a + b) * (1.0 + 1e-15)",
    );
    let other = program(folder.path(), "other.py", &toy);
    let other = format!("exec:{}", other.display());
    for (engine, out) in [("native", "native"), (other.as_str(), "other")] {
        ran_in(folder.path(), engine, &["--steps", "1200"], out);
    }
    let compared = crossgrain(
        &["compare", "native", "other", "--expect-bits"],
        folder.path(),
    );
    let (code, text, errors) = told(&compared);
    assert_eq!(code, 1, "{text}{errors}");
}

#[test]
fn what_an_engine_does_not_have_is_not_asked_of_it() {
    let (folder, _) = folder_with(&narrow_scene(0.05));
    let toy = adapter("toy.py");
    for (more, missing) in [(None, "punch (punch)"), (Some("settled"), "stop_rules")] {
        let more: Vec<&str> = more.iter().flat_map(|until| ["--until", until]).collect();
        let (code, _, errors) = run_in(folder.path(), &toy, &more, "out");
        assert_eq!(code, 2, "{errors}");
        assert!(
            errors.contains("toy has no") && errors.contains(missing),
            "{errors}"
        );
        assert!(!folder.path().join("out").exists());
    }
}

#[test]
fn hostile_paths_reach_no_shell() {
    let (folder, _) = folder_with(&narrow_scene(0.05));
    let hostile = folder
        .path()
        .join("a b;touch hacked $(touch hacked) `touch hacked` 'x\" \n");
    fs::create_dir(&hostile).expect("a folder");
    let toy = program(
        &hostile,
        "-toy';.py",
        &changed_toy("\"version\": \"1\"", "\"version\": \"1\""),
    );
    let toy = format!("exec:{}", toy.display());
    let out = hostile.join("--out 'x");
    let out = out.to_str().expect("text");
    ran_in(folder.path(), &toy, &["--steps", "3"], out);
    for place in [folder.path(), &hostile] {
        assert!(!place.join("hacked").exists());
    }
}
