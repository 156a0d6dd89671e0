//! Runs that go on from a folder: what comes out has the bits of the whole run, friction's memory included.

use std::thread::sleep;

use crate::folder::put;
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

/// `run SCENE.json --out MORE` in the native engine, which ends with this exit code: what it complained of.
fn run(folder: &Path, code: i32, scene: &str, more: &str) -> String {
    let run = format!("run {scene}.json --engine native --quiet --out {more}");
    ends(folder, code, &run).1
}

#[test]
fn a_run_with_friction_goes_on_from_any_step_of_pouring() {
    let mut scene = frictional_scene();
    scene.measurement.history_every = 700;
    let folder = &folder_with(&scene);
    run(folder, 0, "scene", "whole");
    assert!(folder.join("whole/settled-memory.csv").is_file());
    for more in [
        "1 --steps 1",
        "6300 --steps 6300 --from-state 1",
        "8001 --steps 8001 --from-state 6300",
        "end --from-state 8001",
        "faulty --perturb start=half-step",
        "stopped --perturb start=half-step --steps 6300",
        "goes-on --perturb start=half-step --from-state stopped",
    ] {
        run(folder, 0, "scene", more);
    }
    assert_same_tables(folder, "whole", "end");
    assert_same_tables(folder, "faulty", "goes-on");
    let record = text_of(folder.join("end/run.json"));
    has(&record, ["\"parts\": 4"]);
}

#[test]
fn a_run_in_space_goes_on_from_any_step_of_pouring() {
    let folder = &new_folder();
    let mut scene: Value = json_of(root("examples/poured-spheres.json"));
    scene["particles"]["count"] = 60.into();
    scene["damping"]["alpha"] = 0.3.into();
    scene["settle"]["kinetic_energy_fraction"] = 0.001.into();
    scene["measurement"]["history_every"] = 700.into();
    scene["loading"]["speed"] = 0.1.into();
    let moments = json!({"bending_stiffness": 0.5, "twisting_stiffness": 0.3, "limit": 0.1});
    scene["contact"]["rolling"] = moments;
    fs::write(folder.join("scene.json"), scene.to_string()).expect("writable");
    run(folder, 0, "scene", "whole");
    let rows = text_of(folder.join("whole/memory.csv"));
    has(&rows, ["ny,sy,bx,by,bz,tx,ty,tz,slides"]);
    assert!(folder.join("whole/settled-memory.csv").is_file());
    for more in [
        "1 --steps 1",
        "1300 --steps 1300 --from-state 1",
        "2001 --steps 2001 --from-state 1300",
        "end --from-state 2001",
        "settled --until settled",
        "loaded --from-state settled",
    ] {
        run(folder, 0, "scene", more);
    }
    assert_same_tables(folder, "whole", "end");
    assert_same_tables(folder, "whole", "loaded");
    let memory = folder.join("2001/memory.csv");
    let rows = text_of(&memory).replace(",slides", ",other");
    put(&memory, rows);
    let complaint = run(folder, 2, "scene", "out --from-state 2001");
    has(&complaint, ["memory.csv"]);
}

/// Asked to end again and again, in both stages, it comes to the same end.
#[test]
fn an_interrupted_run_is_kept_and_goes_on() {
    let mut scene = small_scene();
    scene.material.friction_angle = 0.5;
    scene.loading.speed *= 0.1;
    let folder = &folder_with(&scene);
    run(folder, 0, "scene", "whole");
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
        run(folder, 0, "scene", "settled --until settled");
        run(folder, 0, "other", "whole --until loaded");
        run(folder, 0, "other", "loaded --from-state settled");
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
    run(folder, 0, "scene", "whole");
    let refused = |scene: &str, more: &str, why: &str| {
        let more = format!("out --from-state {more}");
        has(&run(folder, 2, scene, &more), [why]);
        assert!(!folder.join("out").exists());
    };
    refused("scene", "whole", "it is at its end");
    refused("other", "whole", "poured in another way");
    run(folder, 0, "scene", "beyond --steps 40000");
    refused("scene", "beyond", "beyond the rule of its stage");
    let fault = "whole --perturb friction=1e-3";
    refused("scene", fault, "another --perturb");
    let path = folder.join("whole/run.json");
    let sound = text_of(&path);
    let mut record: Value = serde_json::from_str(&sound).expect("JSON");
    record["restart"]["punch"]["force"] = 1.0.into();
    put(&path, record.to_string());
    refused("scene", "whole", "another punch than run.json");
    put(&path, sound);
    let memory = folder.join("whole/memory.csv");
    let rows = text_of(&memory);
    let mut rows: Vec<&str> = rows.lines().collect();
    rows.remove(1);
    put(&memory, rows.join("\n") + "\n");
    let why = "does not belong to the table of contacts";
    refused("scene", "whole", why);
    // Before, friction began anew without a word.
    fs::remove_file(&memory).expect("removable");
    let why = "memory.csv is in SHA256SUMS and not in the folder";
    refused("scene", "whole", why);
    put(&path, text_of(&path));
    refused("scene", "whole", "memory.csv of it is missing");
}
