//! Engines that people bring: the toy has the native engine's bits, each way in which a program can be broken is its own
//! message and leaves no run folder, and `engine check` says what is wrong. Needs a Python and nothing else.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use crossgrain::scene::{Cloud, Scene};

use crate::support::{crossgrain, folder_with, small_scene, told};

/// Forty grains in a narrow box.
pub fn narrow_scene(dispersion: f64) -> Scene {
    let mut scene = small_scene();
    scene.particles.count = 40;
    scene.particles.dispersion = dispersion;
    scene.container.width = 0.08;
    scene.cloud = Cloud::JitteredLattice {
        columns: 6,
        jitter: 0.9,
        speed: 0.3,
        spin: 0.0,
    };
    scene.loading.half_width = 0.012;
    scene.loading.give_up_depth = 0.02;
    scene.control_points.truncate(1);
    scene.measurement.history_every = 50;
    scene
}

/// An adapter of the project, as it is named on the command line.
pub fn adapter(name: &str) -> String {
    format!("exec:{}/adapters/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// A program of this text in the folder.
fn program(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, text).expect("writable");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("ours");
    path
}

/// The toy with one place changed.
fn changed_toy(from: &str, to: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("adapters/toy.py");
    let toy = fs::read_to_string(path).expect("the toy");
    assert_eq!(
        toy.matches(from).count(),
        1,
        "«{from}» is not once in the toy"
    );
    toy.replace(from, to)
}

#[test]
fn the_toy_has_every_bit_of_the_native_engine() {
    let (folder, _) = folder_with(&narrow_scene(0.05));
    let toy = adapter("toy.py");
    for (engine, out) in [("native", "native"), (toy.as_str(), "toy")] {
        let run = [
            "run",
            "scene.json",
            "--engine",
            engine,
            "--steps",
            "1200",
            "--out",
            out,
            "--quiet",
        ];
        let (code, _, errors) = told(&crossgrain(&run, folder.path()));
        assert_eq!(code, 0, "{errors}");
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
        let run = [
            "run",
            "scene.json",
            "--engine",
            engine,
            "--steps",
            "1200",
            "--out",
            out,
            "--quiet",
        ];
        let (code, _, errors) = told(&crossgrain(&run, folder.path()));
        assert_eq!(code, 0, "{errors}");
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
        let mut run = vec![
            "run",
            "scene.json",
            "--engine",
            &toy,
            "--out",
            "out",
            "--quiet",
        ];
        run.extend(more.iter().flat_map(|until| ["--until", until]));
        let (code, _, errors) = told(&crossgrain(&run, folder.path()));
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
    let run = [
        "run",
        "scene.json",
        "--engine",
        &toy,
        "--steps",
        "3",
        "--out",
        out,
        "--quiet",
    ];
    let (code, _, errors) = told(&crossgrain(&run, folder.path()));
    assert_eq!(code, 0, "{errors}");
    for place in [folder.path(), &hostile] {
        assert!(!place.join("hacked").exists());
    }
}

/// What every broken program begins with: it describes itself well, and can write well.
const SOUND: &str = r#"#!/usr/bin/env python3
import json, os, subprocess, sys, time
def describe(**changes):
    print(json.dumps({"protocol": 1, "name": "broken", "version": "1",
        "parts": ["normal_spring", "local_damping", "gravity", "walls"]} | changes))
    sys.exit()
SAY = describe
"#;
const AND_THEN: &str = r#"
if sys.argv[1] == "describe": SAY()
job = sys.argv[2]
given = open(os.path.join(job, "initial.csv")).read()
EMPTY = "id1,id2,overlap,fn,ft,nx,nz,x,z\n"
def put(name, text):
    with open(os.path.join(job, name), "w") as file: file.write(text)
def moment(step, bodies=given, contacts=EMPTY):
    put("settle-%d-bodies.csv" % step, bodies)
    put("settle-%d-contacts.csv" % step, contacts)
    return {"stage": "settle", "step": step, "punch": None}
def end(steps, stop="steps_done"):
    return {"end": "settle", "steps": steps, "stop": stop, "wall_seconds": 1.0, "cpu_seconds": 1.0}
def finish(lines, steps=10):
    put("moments.jsonl", "".join(json.dumps(line) + "\n" for line in lines))
    put("done.json", json.dumps({"steps": steps}))
"#;

/// Longest time without a sign of life and longest time, s: long, for a machine that is busy.
const PATIENT: [&str; 2] = ["60", "120"];

/// Runs two grains for ten steps in a program that says of itself `say` and then does `does`.
fn with(say: &str, does: &str, [stall, time]: [&str; 2]) -> (i32, String, bool) {
    let mut scene = small_scene();
    scene.particles.count = 2;
    let (folder, _) = folder_with(&scene);
    let path = program(
        folder.path(),
        "engine.py",
        &format!("{SOUND}{say}{AND_THEN}{does}\n"),
    );
    let engine = format!("exec:{}", path.display());
    let run = [
        "run",
        "scene.json",
        "--engine",
        &engine,
        "--steps",
        "10",
        "--stall-limit",
        stall,
        "--time-limit",
        time,
        "--memory-limit",
        "300",
        "--output-limit",
        "8",
        "--out",
        "out",
        "--quiet",
    ];
    let (code, _, errors) = told(&crossgrain(&run, folder.path()));
    let left: Vec<PathBuf> = fs::read_dir(folder.path())
        .expect("a folder")
        .map(|entry| entry.expect("readable").path())
        .filter(|path| path.display().to_string().contains(".crossgrain"))
        .collect();
    assert!(left.is_empty(), "left behind: {left:?}");
    (code, errors, folder.path().join("out").exists())
}

fn fails(say: &str, does: &str, message: &str) {
    fails_in(say, does, message, PATIENT);
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

#[test]
fn a_program_that_cannot_be_started_is_named() {
    let (folder, _) = folder_with(&small_scene());
    fs::write(folder.path().join("text"), "no program\n").expect("writable");
    for engine in ["exec:/nowhere/engine", "exec:text", "exec:."] {
        let run = [
            "run",
            "scene.json",
            "--engine",
            engine,
            "--out",
            "out",
            "--quiet",
        ];
        let (code, _, errors) = told(&crossgrain(&run, folder.path()));
        assert_eq!(code, 2, "{errors}");
        assert!(
            errors.contains("cannot be started") && errors.contains("chmod +x"),
            "{errors}"
        );
    }
}

#[test]
fn hangs_crashes_and_greed_are_ended_and_named() {
    fails_in(
        "",
        "time.sleep(600)",
        "hung: no sign of life for 3s",
        ["3", "120"],
    );
    let talks = "while True: print('still here', flush=True); time.sleep(0.1)";
    fails_in("", talks, "hung: not done within 20s", ["60", "20"]);
    for (does, message) in [
        ("sys.exit(7)", "ended with exit status: 7"),
        ("os.kill(os.getpid(), 11)", "signal: 11"),
        ("raise ValueError('the reason')", "ValueError: the reason"),
        (
            "heap = []\nwhile True: heap.append(bytes(os.urandom(1 << 20) * 8)); print(len(heap), flush=True)",
            "MB of memory",
        ),
        ("while True: print('x' * 100000)", "MB of output"),
        (
            "os.mkdir(os.path.join(job, 'd'))\nput('d/x', 'x' * (20 << 20)); time.sleep(600)",
            "MB of output",
        ),
    ] {
        fails("", does, message);
    }
}

#[test]
fn what_the_engine_has_started_ends_with_it() {
    let (folder, _) = folder_with(&small_scene());
    let told_by = folder.path().join("pid");
    let does = format!(
        "child = subprocess.Popen(['sleep', '300'])\nopen({told_by:?}, 'w').write(str(child.pid))\ntime.sleep(600)"
    );
    fails_in("", &does, "hung", ["15", "120"]);
    let pid = fs::read_to_string(told_by).expect("a number");
    let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    // Ended; whoever takes over orphans may not have looked at it yet.
    assert!(
        status.is_empty() || status.contains("State:\tZ"),
        "{status}"
    );
}

#[test]
fn descriptions_are_not_believed_blindly() {
    fails_in(
        "SAY = lambda: time.sleep(600)",
        "",
        "not done within",
        ["60", "5"],
    );
    for (say, message) in [
        (
            "SAY = lambda: describe(protocol=2)",
            "speaks version 2 of the protocol",
        ),
        (
            "SAY = lambda: describe(protocol=99999999999)",
            "speaks version 99999999999",
        ),
        (
            "SAY = lambda: describe(parts=['normal_spring', 'magic'])",
            "magic",
        ),
        ("SAY = lambda: describe(parts=[])", "no normal_spring"),
        ("SAY = lambda: describe(name=' ')", "its name is empty"),
        (
            "SAY = lambda: describe(name='a\\nb')",
            "without line breaks",
        ),
        ("SAY = lambda: describe(colour='red')", "colour"),
        (
            "SAY = lambda: (print('hello'), sys.exit())",
            r#"it printed "hello"#,
        ),
        ("SAY = lambda: sys.exit()", "EOF"),
        ("SAY = lambda: sys.exit('no licence')", "no licence"),
        (
            "SAY = lambda: (print('x' * 100000), sys.exit())",
            "larger than",
        ),
    ] {
        fails(say, "", message);
    }
}

#[test]
fn tables_are_not_believed_blindly() {
    for (does, message) in [
        ("", "its list of moments is not there"),
        (
            "put('moments.jsonl', ''); put('done.json', '{\"steps\": 10}')",
            "not one moment",
        ),
        (
            "put('moments.jsonl', 'rubbish\\n')",
            "moments.jsonl: expected value",
        ),
        ("put('moments.jsonl', '[' * 100000)", "moments.jsonl"),
        ("finish([{'colour': 'red'}])", "moments.jsonl"),
        (
            "finish([{'stage': 'settle', 'step': 0}, end(10)])",
            "settle-0-bodies.csv",
        ),
        (
            "finish([moment(0, given.replace('0.', 'nan', 1)), moment(10), end(10)])",
            "settle-0-bodies.csv",
        ),
        (
            "finish([moment(0, '\\n'.join(given.split('\\n')[:2]) + '\\n')])",
            "1 grains instead of 2",
        ),
        ("finish([moment(0, given[:-5])])", "cut off"),
        ("finish([moment(0, given * 2000)])", "larger than"),
        (
            "rows = given.split('\\n'); rows[1] = ','.join(rows[1].split(',')[:-1] + ['1.0']); finish([moment(0, '\\n'.join(rows))])",
            "other radii, masses",
        ),
        (
            "rows = given.split('\\n'); row = rows[1].split(','); row[1] = '0.011'; rows[1] = ','.join(row); \
             finish([moment(0, '\\n'.join(rows)), moment(10), end(10)])",
            "not the start that it was given",
        ),
        (
            "finish([moment(0, contacts=EMPTY + '0,77,0,0,0,1,0,0,0\\n')])",
            "id2 = 77",
        ),
        (
            "finish([moment(0, contacts=EMPTY + '1,0,0,0,0,1,0,0,0\\n')])",
            "the lower id stands first",
        ),
        (
            "finish([moment(0, contacts=EMPTY + '0,1,-1,0,0,1,0,0,0\\n')])",
            "only what touches is a contact",
        ),
        (
            "finish([moment(0, contacts=EMPTY + '0,1,0,0,0,1,1,0,0\\n')])",
            "of length 1",
        ),
        (
            "finish([moment(0, contacts=EMPTY + '0,1,0,inf,0,1,0,0,0\\n')])",
            "fn = inf",
        ),
        (
            "finish([moment(0, contacts=EMPTY + '0,1,9,0,0,1,0,0,0\\n'), moment(10), end(10)])",
            "overlap by 9",
        ),
        ("finish([moment(0), moment(10)])", "none was finished"),
        (
            "finish([moment(0), moment(7), end(7)])",
            "10 steps were asked for and 7 were done",
        ),
        (
            "finish([moment(0), moment(9), end(10)])",
            "moment 1 of the run should be settle 10 and is settle 9",
        ),
        (
            "finish([moment(0), moment(10), end(10), moment(11)])",
            "moment 2 of the run should be none",
        ),
        (
            "finish([moment(0), moment(10), end(10, 'settled')])",
            "its stages are not those of the task",
        ),
        (
            "finish([moment(0), moment(10), end(10, 'bored')])",
            "the stop reason",
        ),
        (
            "finish([moment(0), end(10**15, 'max_steps')])",
            "its stages are not those of the task",
        ),
        (
            "finish([moment(0), moment(10), end(10)], steps=9)",
            "it counts 9 steps",
        ),
        (
            "finish([moment(0), moment(10), end(10)]); os.remove(os.path.join(job, 'done.json'))",
            "before the job was done",
        ),
        (
            "finish([{'refused': 'no discs today'}])",
            "the engine refused: no discs today",
        ),
        (
            "os.symlink('/dev/zero', os.path.join(job, 'moments.jsonl'))",
            "not a regular file",
        ),
        (
            "os.mkfifo(os.path.join(job, 'moments.jsonl'))",
            "not a regular file",
        ),
    ] {
        fails("", does, message);
    }
}

#[test]
fn engine_check_finds_the_toy_sound() {
    let (folder, _) = folder_with(&narrow_scene(0.05));
    let check = ["engine", "check", &adapter("toy.py"), "--quiet"];
    let (code, text, errors) = told(&crossgrain(&check, folder.path()));
    assert_eq!(code, 0, "{text}{errors}");
    assert!(text.contains("every bit is the native engine's"), "{text}");
    assert!(text.contains("not made punch"), "{text}");
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
