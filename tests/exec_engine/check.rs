//! `engine check` says what is wrong with an engine.

use crate::support::*;

#[test]
fn engine_check_finds_the_toy_sound() {
    let folder = &folder_with(&narrow_scene(0.05));
    let toy = adapter("toy.py");
    let check = ["engine", "check", &toy, "--quiet", "--junit", "checks.xml"];
    let (text, _) = ends(folder, 0, &check);
    let junit = text_of(folder.join("checks.xml"));
    has(&junit, ["name=\"engine/punch\"", "<skipped"]);
    has(&text, ["Identical: every bit of its first hundred steps"]);
    has(&text, ["skipped engine/punch"]);
}

/// The engines to begin with, built as their first lines say. The keys of the Rust one's lines stand in another order.
#[test]
fn engine_check_finds_the_engines_to_begin_with_sound() {
    let folder = &folder_with(&narrow_scene(0.05));
    let examples = root("examples");
    let in_c = folder.join("engine");
    let mut compile = Command::new("cc");
    compile
        .args(["-O2", "-ffp-contract=off", "-o"])
        .arg(&in_c)
        .arg(examples.join("engine-c/engine.c"))
        .arg("-lm");
    let mut build = Command::new(env!("CARGO"));
    build
        .args(["build", "--release", "--locked", "--target-dir"])
        .arg(folder.join("target"))
        .current_dir(examples.join("engine-rust"));
    for mut command in [compile, build] {
        let done = command.output().expect("a compiler");
        let told = String::from_utf8_lossy(&done.stderr);
        assert!(done.status.success(), "{told}");
    }
    for program in [in_c, folder.join("target/release/engine-rust")] {
        let program = format!("exec:{}", program.display());
        let check = ["engine", "check", &program, "--quiet"];
        let (text, _) = ends(folder, 0, &check);
        has(&text, ["Identical: every bit of its first hundred steps"]);
        has(&text, [" checks passed, 0 failed"]);
    }
}

/// What no constant and no form explains is shown where it is.
#[test]
fn the_page_of_engine_check_marks_the_grains_that_are_left() {
    let folder = &folder_with(&narrow_scene(0.05));
    let one = "v[i][axis] += dt * a * (1.0 + 0.01 * (i == 17))\n";
    let toy = changed_toy("v[i][axis] += dt * a\n", one);
    let toy = engine(folder, "one", &toy);
    let check = format!("engine check {toy} --grains 50 --quiet --out out");
    tells(folder, 1, &check, ["× 1.01 (grain 17 alone)"]);
    let read = |name: &str| text_of(folder.join("out").join(name));
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
    // It is a record as those of all jobs, and what it says is explained.
    let checks = "report checks out/check.json --junit checks.xml";
    tells(folder, 1, checks, ["engine/first-steps/springs"]);
    assert!(text_of(folder.join("checks.xml")).contains("<failure"));
    tells(folder, 0, "report explain engine/damping", ["tiny job"]);
    // A folder that is not there is named before the work.
    let nowhere = format!("engine check {toy} --junit nowhere/checks.xml");
    tells(folder, 2, &nowhere, ["there is no folder nowhere"]);
}

/// Nobody looks at the first steps of an engine that takes no lists of cases: neither it nor its record has passed.
#[test]
fn an_engine_whose_first_steps_were_not_looked_at_is_undecided() {
    let folder = &folder_with(&narrow_scene(0.05));
    let toy = changed_toy(r#""walls", "cases"]"#, r#""walls"]"#);
    let toy = engine(folder, "no-cases", &toy);
    let check = format!("engine check {toy} --grains 50 --quiet --out out");
    tells(folder, 3, &check, ["its first steps were not looked at"]);
    let record = "report checks out/check.json";
    tells(folder, 3, record, ["engine/first-steps"]);
}

/// Of the toy's text what is changed, to what, the exit code, and what is said of it.
const WRONG: &str = "
    + gravity[axis] ⇒ + 0.0 ⇒ 1 ⇒ gravity is missing
    + gravity[axis] ⇒ - gravity[axis] ⇒ 1 ⇒ gravity points up
    1.0 - alpha * ( ⇒ 1.0 + alpha * ( ⇒ 1 ⇒ the wrong way round
    a *= 1.0 - alpha ⇒ a *= 1.0 - 0.0 * alpha ⇒ 1 ⇒ not damped at all
    + 0.5 * dt * a) ⇒ + 0.0 * dt * a) ⇒ 1 ⇒ the velocity in the middle of the kick
    v[i][axis] += dt * a ⇒ v[i][axis] += 0.5 * dt * a ⇒ 1 ⇒ half a kick too few
    x[i][axis] += dt * v[i][axis] ⇒ x[i][axis] += dt * v[i][axis] + 0.5 * dt * dt * a ⇒ 1 ⇒ the velocity is right and z has changed
    2.0 * a * b / (a + b) ⇒ a * b / (a + b) ⇒ 1 ⇒ 0.500000 of it
    (dx / distance, dz / distance) ⇒ (-dx / distance, -dz / distance) ⇒ 1 ⇒ points from body 2 to body 1
    for index, wall in enumerate(walls) ⇒ for index, wall in enumerate([]) ⇒ 1 ⇒ touch, and no contact
    if overlap >= 0.0: ⇒ if overlap >= -1e-3: ⇒ 1 ⇒ only what touches
    import csv, ⇒ import random, csv, ⇒ 0 ⇒ Identical
    v[i][axis] += dt * a ⇒ old = v[i][axis]; v[i][axis] += dt * a ⇒ 0 ⇒ Identical
    if len(grains) > 200 ⇒ if len(grains) > 200 or len(grains) == 2 ⇒ 3 ⇒ Undecided
";

#[test]
fn engine_check_says_what_is_wrong() {
    let folder = &folder_with(&narrow_scene(0.05));
    for [from, to, code, message] in rows(WRONG) {
        let engine = engine(folder, "broken.py", &changed_toy(from, to));
        let (ended, text, errors) = say(
            folder,
            &["engine", "check", &engine, "--grains", "50", "--quiet"],
        );
        assert_eq!(ended.to_string(), code, "{from} to {to}: {text}{errors}");
        assert!(text.contains(message), "«{message}» is missing: {text}");
    }
}

#[test]
fn the_verdict_on_tables_that_cannot_be_read_has_the_reason() {
    let folder = &folder_with(&narrow_scene(0.05));
    let toy = changed_toy("sorted(rows)", "sorted(rows, reverse=len(rows) > 150)");
    let engine = engine(folder, "unsorted.py", &toy);
    let (out, _) = ends(folder, 1, &["engine", "check", &engine, "--quiet"]);
    let mut lines = out.lines();
    let verdict = lines.find(|line| line.starts_with("DIFFERENT: "));
    let verdict = verdict.unwrap_or_default();
    has(verdict, ["states it wrote nonsense: case", "contacts.csv"]);
    has(verdict, ["must be after"]);
}

/// A refusal leaves the suite incomplete, whatever else passes.
#[test]
fn an_engine_that_refuses_some_cases_is_not_verified() {
    let folder = &folder_with(&narrow_scene(0.05));
    let toy = changed_toy("if len(grains) > 200:", "if len(grains) > 1:");
    let engine = engine(folder, "refuses.py", &toy);
    let verify = ["verify", "--engine", &engine, "--quiet"];
    let (text, _) = ends(folder, 3, &verify);
    has(&text, [" 0 failed"]);
    assert!(!text.contains("INCOMPLETE: 0 cases passed"), "{text}");
    has(&text, ["refused: more than 200 grains"]);
}

#[test]
fn engine_check_finds_what_changes_from_run_to_run() {
    let folder = &folder_with(&narrow_scene(0.05));
    let moody = "(1.0 + 1e-14 * (time.time() % 1.0))";
    let (speed, kick) = ("* (v[i][axis] + 0.5", "v[i][axis] += dt * a");
    let toy = changed_toy(speed, &format!("* {moody} {speed}"));
    let toy = toy.replace(kick, &format!("{kick} * {moody}"));
    let engine = engine(folder, "moody.py", &toy);
    let (out, _) = ends(folder, 1, &["engine", "check", &engine, "--quiet"]);
    has(&out, ["two runs of one job have other bits"]);
}

#[test]
fn engine_check_tells_a_crash_from_a_wrong_number() {
    let folder = &folder_with(&narrow_scene(0.05));
    let text = format!("{SOUND}{AND_THEN}sys.exit(5)\n");
    let engine = engine(folder, "engine.py", &text);
    ends(folder, 4, &["engine", "check", &engine, "--quiet"]);
    ends(folder, 2, "engine check native");
}
