//! `engine check` says what is wrong with an engine.

use crate::support::engines::{AND_THEN, SOUND, adapter, changed_toy, narrow_scene, program};
use crate::support::{crossgrain, folder_with, told};

#[test]
fn engine_check_finds_the_toy_sound() {
    let (folder, _) = folder_with(&narrow_scene(0.05));
    let toy = adapter("toy.py");
    let check = ["engine", "check", &toy, "--quiet", "--junit", "checks.xml"];
    let (code, text, errors) = told(&crossgrain(&check, folder.path()));
    assert_eq!(code, 0, "{text}{errors}");
    let junit = std::fs::read_to_string(folder.path().join("checks.xml")).expect("JUnit");
    assert!(
        junit.contains("name=\"punch\"") && junit.contains("<skipped"),
        "{junit}"
    );
    assert!(
        text.contains("identical: every bit of its first hundred steps"),
        "{text}"
    );
    assert!(text.contains("skipped engine/punch"), "{text}");
}

/// What no constant and no form explains is shown where it is.
#[test]
fn the_page_of_engine_check_marks_the_grains_that_are_left() {
    let (folder, _) = folder_with(&narrow_scene(0.05));
    let one = "v[i][axis] += dt * a * (1.0 + 0.01 * (i == 17))\n";
    let toy = changed_toy("v[i][axis] += dt * a\n", one);
    let toy = format!("exec:{}", program(folder.path(), "one", &toy).display());
    let check = [
        "engine", "check", &toy, "--grains", "50", "--quiet", "--out", "out",
    ];
    let (code, text, errors) = told(&crossgrain(&check, folder.path()));
    assert_eq!(code, 1, "{text}{errors}");
    assert!(text.contains("it sits on grain 17 alone"), "{text}");
    let read = |name: &str| {
        let path = folder.path().join("out").join(name);
        std::fs::read_to_string(path).expect("a view")
    };
    let grains = read("figures/left-springs.csv");
    let places = |kind: &str| -> Vec<String> {
        let rows = grains.lines().filter_map(|row| row.strip_prefix(kind));
        rows.map(|row| row.split(',').take(2).collect::<Vec<_>>().join(","))
            .collect()
    };
    assert_eq!(places("left,"), places("grain,")[17..18]);
    assert!(read("figures/left-springs.svg").contains("stroke=\"#d55e00\""));
    assert!(read("report.html").contains("marked: 1 of 50"));
    assert!(read("check.json").contains("\"causes\""));
}

#[test]
fn engine_check_says_what_is_wrong() {
    let (folder, _) = folder_with(&narrow_scene(0.05));
    for (from, to, message) in [
        ("+ gravity[axis]", "", "gravity is missing"),
        ("+ gravity[axis]", "- gravity[axis]", "gravity points up"),
        ("1.0 - alpha * (", "1.0 + alpha * (", "the wrong way round"),
        (
            "a *= 1.0 - alpha",
            "a *= 1.0 - 0.0 * alpha",
            "not damped at all",
        ),
        (
            "+ 0.5 * dt * a)",
            "+ 0.0 * dt * a)",
            "the velocity in the middle of the kick",
        ),
        (
            "v[i][axis] += dt * a\n",
            "old = v[i][axis]; v[i][axis] += dt * a\n",
            "",
        ),
        (
            "v[i][axis] += dt * a\n",
            "v[i][axis] += 0.5 * dt * a\n",
            "half a kick too few",
        ),
        ("2.0 * a * b / (a + b)", "a * b / (a + b)", "0.500000 of it"),
        (
            "(dx / distance, dz / distance)",
            "(-dx / distance, -dz / distance)",
            "points from body 2 to body 1",
        ),
        (
            "for index, wall in enumerate(walls)",
            "for index, wall in enumerate([])",
            "touch, and no contact",
        ),
        (
            "if overlap >= 0.0:",
            "if overlap >= -1e-3:",
            "only what touches",
        ),
        ("import csv,", "import random, csv,", ""),
    ] {
        let text = changed_toy(from, to);
        let broken = program(folder.path(), "broken.py", &text);
        let engine = format!("exec:{}", broken.display());
        let (code, text, errors) = told(&crossgrain(
            &["engine", "check", &engine, "--quiet"],
            folder.path(),
        ));
        // Where no message is given, nothing was broken.
        assert_eq!(
            code,
            i32::from(!message.is_empty()),
            "{from} to {to}: {text}{errors}"
        );
        assert!(text.contains(message), "«{message}» is missing: {text}");
    }
}

#[test]
fn an_engine_that_refuses_one_job_is_undecided() {
    let (folder, _) = folder_with(&narrow_scene(0.05));
    let toy = changed_toy(
        "if len(grains) > 200:",
        "if len(grains) > 200 or len(grains) == 2:",
    );
    let engine = program(folder.path(), "choosy.py", &toy);
    let engine = format!("exec:{}", engine.display());
    let check = ["engine", "check", &engine, "--quiet"];
    let (code, text, errors) = told(&crossgrain(&check, folder.path()));
    assert_eq!(code, 3, "{text}{errors}");
    assert!(text.contains("undecided"), "{text}");
}

/// A refusal leaves the suite incomplete, whatever else passes.
#[test]
fn an_engine_that_refuses_some_cases_is_not_verified() {
    let (folder, _) = folder_with(&narrow_scene(0.05));
    let toy = changed_toy("if len(grains) > 200:", "if len(grains) > 1:");
    let engine = program(folder.path(), "refuses.py", &toy);
    let engine = format!("exec:{}", engine.display());
    let verify = ["verify", "--engine", &engine, "--quiet"];
    let (code, text, errors) = told(&crossgrain(&verify, folder.path()));
    assert_eq!(code, 3, "{text}{errors}");
    assert!(text.contains(" 0 failed"), "{text}");
    assert!(!text.contains("INCOMPLETE: 0 cases passed"), "{text}");
    assert!(text.contains("refused: more than 200 grains"), "{text}");
}

#[test]
fn engine_check_finds_what_changes_from_run_to_run() {
    let (folder, _) = folder_with(&narrow_scene(0.05));
    let toy = changed_toy(
        "* (v[i][axis] + 0.5",
        "* (1.0 + 1e-14 * (time.time() % 1.0)) * (v[i][axis] + 0.5",
    );
    let toy = toy.replace(
        "v[i][axis] += dt * a",
        "v[i][axis] += dt * a * (1.0 + 1e-14 * (time.time() % 1.0))",
    );
    let engine = program(folder.path(), "moody.py", &toy);
    let engine = format!("exec:{}", engine.display());
    let (code, text, errors) = told(&crossgrain(
        &["engine", "check", &engine, "--quiet"],
        folder.path(),
    ));
    assert_eq!(code, 1, "{text}{errors}");
    assert!(
        text.contains("two runs of one job have other bits"),
        "{text}"
    );
}

#[test]
fn engine_check_tells_a_crash_from_a_wrong_number() {
    let (folder, _) = folder_with(&narrow_scene(0.05));
    let engine = program(
        folder.path(),
        "engine.py",
        &format!("{SOUND}{AND_THEN}sys.exit(5)\n"),
    );
    let engine = format!("exec:{}", engine.display());
    let (code, text, _) = told(&crossgrain(
        &["engine", "check", &engine, "--quiet"],
        folder.path(),
    ));
    assert_eq!(code, 4, "{text}");
    let (code, _, errors) = told(&crossgrain(&["engine", "check", "native"], folder.path()));
    assert_eq!(code, 2, "{errors}");
}
