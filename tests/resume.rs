//! Runs that go on from a folder: what comes out has the bits of the whole run, friction's memory included.

use std::thread::sleep;

use crossgrain::run::folder::write_sums;

use crate::support::*;

/// What a run has made; times and the number of parts belong to how it was made.
const TABLES: &str =
    "bodies contacts memory settled-bodies settled-contacts settled-memory history trace";

fn assert_same_tables(folder: &Path, a: &str, b: &str) {
    for table in TABLES.words() {
        let table = format!("{table}.csv");
        let [a, b] = [a, b].map(|run| fs::read(folder.join(run).join(&table)).ok());
        assert!(a == b, "{table}");
    }
}

fn run(folder: &Path, scene: &str, out: &str, more: &[&str]) -> (i32, String, String) {
    let mut words = vec!["run", scene, "--engine", "native", "--quiet", "--out", out];
    words.extend(more);
    say(folder, &words)
}

/// The same, and it ends well.
fn ran(folder: &Path, scene: &str, out: &str, more: &[&str]) {
    let (code, _, errors) = run(folder, scene, out, more);
    assert_eq!(code, 0, "{scene}, {out}: {errors}");
}

#[test]
fn a_run_with_friction_goes_on_from_any_step_of_pouring() {
    let mut scene = frictional_scene();
    scene.measurement.history_every = 700;
    let folder = &folder_with(&scene);
    ran(folder, "scene.json", "whole", &[]);
    assert!(folder.join("whole/settled-memory.csv").is_file());
    let mut before = None;
    for steps in ["1", "6300", "8001", "end"] {
        let mut more = before.map_or(vec![], |state| vec!["--from-state", state]);
        if steps != "end" {
            more.extend(["--steps", steps]);
        }
        ran(folder, "scene.json", steps, &more);
        before = Some(steps);
    }
    assert_same_tables(folder, "whole", "end");
    let fault = ["--perturb", "start=half-step"];
    for (out, more) in [
        ("faulty", vec![]),
        ("stopped", vec!["--steps", "6300"]),
        ("goes-on", vec!["--from-state", "stopped"]),
    ] {
        ran(folder, "scene.json", out, &[&fault[..], &more].concat());
    }
    assert_same_tables(folder, "faulty", "goes-on");
    let record = text_of(folder.join("end/run.json"));
    has(&record, ["\"parts\": 4"]);
}

/// Asked to end again and again, in both stages, it comes to the same end.
#[test]
fn an_interrupted_run_is_kept_and_goes_on() {
    let mut scene = small_scene();
    scene.material.friction_angle = 0.5;
    scene.loading.speed *= 0.1;
    let folder = &folder_with(&scene);
    ran(folder, "scene.json", "whole", &[]);
    let (mut before, mut stages) = (String::new(), Vec::new());
    for part in 0..100 {
        let out = format!("part-{part}");
        let mut command = cli(folder);
        command.args(["run", "scene.json", "--engine", "native", "--out", &out]);
        command.stderr(Stdio::piped());
        if !before.is_empty() {
            command.args(["--from-state", &before]);
        }
        let child = command.spawn().expect("the program starts");
        sleep(Duration::from_millis(100 + 60 * part));
        send(&child, "TERM");
        let (code, _, errors) = told(&child.wait_with_output().expect("it ends"));
        if code == 0 {
            assert_same_tables(folder, "whole", &out);
            break;
        }
        // Without a folder the signal came before the program listened to it.
        if folder.join(&out).exists() {
            assert_eq!(code, 75, "{errors}");
            has(&errors, [&format!("--from-state {out}")]);
            stages.push(errors.contains("stage load"));
            before = out;
        }
    }
    assert!(stages.contains(&true), "{stages:?}");
}

#[test]
fn another_load_on_a_settled_bed_is_the_whole_run_of_its_scene() {
    for (_, changes, _, _) in stages() {
        let scene = staged_scene(changes);
        let folder = &folder_with(&scene);
        let mut other = scene.clone();
        other.loading.speed *= 0.5;
        other.loading.pressure *= 0.8;
        write_scene(&other, &folder.join("other.json"));
        for (scene, out, more) in [
            ("scene.json", "settled", ["--until", "settled"]),
            ("other.json", "whole", ["--until", "loaded"]),
            ("other.json", "loaded", ["--from-state", "settled"]),
        ] {
            ran(folder, scene, out, &more);
        }
        assert_same_tables(folder, "whole", "loaded");
    }
}

#[test]
fn what_cannot_go_on_says_why() {
    let scene = frictional_scene();
    let folder = &folder_with(&scene);
    let mut other = scene.clone();
    other.material.friction_angle = 0.3;
    write_scene(&other, &folder.join("other.json"));
    ran(folder, "scene.json", "whole", &[]);
    let refused = |scene: &str, more: &[&str], why: &str| {
        let more = [&["--from-state", "whole"], more].concat();
        let (code, _, errors) = run(folder, scene, "out", &more);
        assert_eq!(code, 2, "{errors}");
        has(&errors, [why]);
        assert!(!folder.join("out").exists());
    };
    refused("scene.json", &[], "it is at its end");
    refused("other.json", &[], "poured in another way");
    ran(folder, "scene.json", "beyond", &["--steps", "40000"]);
    let beyond = run(folder, "scene.json", "out", &["--from-state", "beyond"]);
    assert_eq!(beyond.0, 2);
    has(&beyond.2, ["beyond the rule of its stage"]);
    let fault = ["--perturb", "friction=1e-3"];
    refused("scene.json", &fault, "another --perturb");
    let path = folder.join("whole/run.json");
    let sound = text_of(&path);
    let mut record: Value = serde_json::from_str(&sound).expect("JSON");
    record["restart"]["punch"]["force"] = 1.0.into();
    let put = |path: &Path, text: &str| {
        fs::write(path, text).expect("writable");
        write_sums(&folder.join("whole")).expect("writable");
    };
    put(&path, &record.to_string());
    refused("scene.json", &[], "another punch than run.json");
    put(&path, &sound);
    let memory = folder.join("whole/memory.csv");
    let text = text_of(&memory);
    let cut: String = text.split_inclusive('\n').skip(1).collect();
    let header = text.lines().next().expect("a header");
    let shorter: String = cut.split_inclusive('\n').skip(1).collect();
    put(&memory, &format!("{header}\n{shorter}"));
    let (code, _, errors) = run(folder, "scene.json", "out", &["--from-state", "whole"]);
    assert_ne!(code, 0);
    has(&errors, ["does not belong to the table of contacts"]);
    // Before, friction began anew without a word.
    fs::remove_file(&memory).expect("removable");
    let why = "memory.csv is in SHA256SUMS and not in the folder";
    refused("scene.json", &[], why);
    write_sums(&folder.join("whole")).expect("writable");
    refused("scene.json", &[], "memory.csv of it is missing");
}
