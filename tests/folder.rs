//! Run folders: written whole or not at all, read back to the bit, refused when they are not sound.

use std::fs;
use std::path::Path;

use crossgrain::run::folder::RunFolder;
use crossgrain::run::folder::record::Protocol;

use crate::support::{
    crossgrain, folder_with, frictional_scene, native_run, small_scene, sound, told,
};

fn small_run() -> RunFolder {
    native_run(&small_scene(), sound(), Protocol::Steps { steps: 3000 })
}

#[test]
fn a_folder_reads_back_to_the_same_bits() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let run = native_run(&small_scene(), sound(), Protocol::Whole);
    let path = folder.path().join("run");
    run.write(&path).expect("a writable folder");
    let back = RunFolder::read(&path).expect("a sound folder");
    assert_eq!(back, run);
    assert!(run.settled.is_some());
    for name in [
        "scene.json",
        "initial.csv",
        "bodies.csv",
        "contacts.csv",
        "history.csv",
        "trace.csv",
        "run.json",
        "settled-bodies.csv",
        "settled-contacts.csv",
    ] {
        assert!(path.join(name).is_file(), "{name}");
    }
    let header = |name: &str| {
        let text = fs::read_to_string(path.join(name)).expect("text");
        text.lines().next().expect("a header").to_owned()
    };
    assert_eq!(header("initial.csv"), "id,x,z,vx,vz,radius,mass");
    assert_eq!(header("bodies.csv"), "id,x,z,vx,vz,radius,mass");
    assert_eq!(header("contacts.csv"), "id1,id2,overlap,fn,ft,nx,nz,x,z");
}

#[test]
fn a_folder_of_grains_that_rotate_reads_back_to_the_same_bits() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let run = native_run(&frictional_scene(), sound(), Protocol::Whole);
    let path = folder.path().join("run");
    run.write(&path).expect("a writable folder");
    assert_eq!(RunFolder::read(&path).expect("a sound folder"), run);
    let settled = run.settled.expect("a settled bed").bodies;
    assert!(settled.spin.iter().all(|spin| *spin != 0.0));
    for name in ["initial.csv", "bodies.csv", "settled-bodies.csv"] {
        let text = fs::read_to_string(path.join(name)).expect("text");
        let header = text.lines().next().expect("a header");
        assert_eq!(header, "id,x,z,vx,vz,radius,mass,spin,inertia", "{name}");
    }
    // Another spin at the end is another state.
    change(&path.join("bodies.csv"), |text| {
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let mut columns: Vec<&str> = lines[9].split(',').collect();
        columns[7] = "0.125";
        lines[9] = columns.join(",");
        lines.join("\n") + "\n"
    });
    let error = RunFolder::read(&path).expect_err("another spin");
    assert!(error.to_string().contains("another state"), "{error}");
}

#[test]
fn nothing_existing_is_overwritten() {
    let (folder, _) = folder_with(&small_scene());
    let out = folder.path().join("out");
    fs::create_dir(&out).expect("a writable folder");
    fs::write(out.join("precious"), "mine").expect("a writable folder");
    let arguments = [
        "run",
        "scene.json",
        "--engine",
        "native",
        "--steps",
        "10",
        "--out",
        "out",
    ];
    let (code, _, errors) = told(&crossgrain(&arguments, folder.path()));
    assert_eq!(code, 2, "{errors}");
    assert!(errors.contains("exists already"), "{errors}");
    assert_eq!(
        fs::read_to_string(out.join("precious")).expect("still there"),
        "mine"
    );
    assert_eq!(fs::read_dir(&out).expect("a folder").count(), 1);
}

/// A run that never settles, at work for a moment.
fn endless_run() -> (tempfile::TempDir, std::process::Child) {
    let mut scene = small_scene();
    scene.settle.kinetic_energy_fraction = 1.0e-300;
    scene.settle.max_steps = 1_000_000_000;
    let (folder, _) = folder_with(&scene);
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_crossgrain"))
        .args(["run", "scene.json", "--engine", "native", "--out", "out"])
        .current_dir(folder.path())
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("the program starts");
    std::thread::sleep(std::time::Duration::from_millis(400));
    assert_eq!(child.try_wait().expect("a child"), None, "it is running");
    (folder, child)
}

#[test]
fn a_killed_run_leaves_no_folder_under_its_name() {
    let (folder, mut child) = endless_run();
    child.kill().expect("a child to kill");
    child.wait().expect("an ended child");
    assert!(!folder.path().join("out").exists());
}

/// Asked to end, a run leaves the folder from which it can go on and nothing else.
#[test]
fn a_run_that_is_asked_to_end_is_kept_and_exits_with_75() {
    let (folder, mut child) = endless_run();
    let asked = std::process::Command::new("kill")
        .args(["-TERM", &child.id().to_string()])
        .status()
        .expect("kill is there");
    assert!(asked.success());
    let status = child.wait().expect("an ended child");
    assert_eq!(status.code(), Some(75));
    let left = fs::read_dir(folder.path()).expect("a folder").count();
    assert_eq!(left, 2, "the scene, the run and nothing else");
    let out = folder.path().join("out");
    let run = RunFolder::read_so_far(&out).expect("a run folder");
    // Nobody takes it for a whole run.
    let error = RunFolder::read(&out).expect_err("so far only");
    assert!(error.to_string().contains("--from-state"), "{error}");
    assert_eq!(
        run.record.stop(),
        Some(grains::tables::StopReason::Interrupted)
    );
}

/// Does something bad to a sound folder and returns exit code and message of a comparison with it.
fn spoiled(spoil: impl FnOnce(&Path)) -> (i32, String) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let run = small_run();
    run.write(&folder.path().join("good")).expect("writable");
    run.write(&folder.path().join("bad")).expect("writable");
    spoil(&folder.path().join("bad"));
    let output = crossgrain(&["compare", "good", "bad", "--no-locate"], folder.path());
    let (code, out, errors) = told(&output);
    (code, out + &errors)
}

fn change(path: &Path, how: impl FnOnce(String) -> String) {
    let text = fs::read_to_string(path).expect("text");
    fs::write(path, how(text)).expect("writable");
}

#[test]
fn unsound_folders_are_refused_with_exit_2() {
    type Spoil = fn(&Path);
    let cases: [(&str, Spoil, &str); 15] = [
        (
            "missing",
            |bad| fs::remove_dir_all(bad).expect("a folder"),
            "it has no run.json",
        ),
        (
            "no bodies",
            |bad| fs::remove_file(bad.join("bodies.csv")).expect("a file"),
            "bodies.csv",
        ),
        (
            "cut",
            |bad| {
                change(&bad.join("bodies.csv"), |text| {
                    text[..text.len() - 9].to_owned()
                })
            },
            "bodies.csv",
        ),
        (
            "cut at a line",
            |bad| {
                change(&bad.join("bodies.csv"), |text| {
                    let lines: Vec<&str> = text.lines().collect();
                    lines[..lines.len() - 3].join("\n") + "\n"
                });
            },
            "has 297 grains, the scene 300",
        ),
        (
            "empty",
            |bad| fs::write(bad.join("bodies.csv"), "").expect("writable"),
            "bodies.csv",
        ),
        (
            "NaN",
            |bad| {
                change(&bad.join("bodies.csv"), |text| {
                    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
                    lines[5] = "4,NaN,0.1,0,0,0.005,0.2".to_owned();
                    lines.join("\n") + "\n"
                });
            },
            "x = NaN, which must be finite",
        ),
        (
            "contact with nobody",
            |bad| {
                change(&bad.join("contacts.csv"), |text| {
                    text + "303,100000,1e-6,1,0,1,0,0.1,0.1\n"
                });
            },
            "id2 = 100000",
        ),
        (
            "other version",
            |bad| {
                change(&bad.join("run.json"), |text| {
                    text.replacen("\"version\": 4", "\"version\": 99", 1)
                });
            },
            "version 99",
        ),
        (
            "other scene",
            |bad| {
                change(&bad.join("scene.json"), |text| {
                    text.replacen("\"gravity\": 9.81", "\"gravity\": 9.8", 1)
                });
            },
            "not the scene of run.json",
        ),
        (
            "not JSON",
            |bad| fs::write(bad.join("run.json"), "{").expect("writable"),
            "run.json",
        ),
        (
            "not text",
            |bad| fs::write(bad.join("history.csv"), [0xff, 0xfe, 0]).expect("writable"),
            "not UTF-8",
        ),
        (
            "other end",
            |bad| {
                change(&bad.join("history.csv"), |text| {
                    let lines: Vec<&str> = text.lines().collect();
                    lines[..lines.len() - 1].join("\n") + "\n"
                });
            },
            "has not the moments of the stages",
        ),
        (
            "other masses",
            |bad| {
                change(&bad.join("bodies.csv"), |text| {
                    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
                    let mass = lines[9].rfind(',').expect("columns");
                    lines[9].truncate(mass);
                    lines[9] += ",7.0";
                    lines.join("\n") + "\n"
                });
            },
            "other radii, masses or moments of inertia than initial.csv",
        ),
        (
            "history of not a number",
            |bad| {
                change(&bad.join("history.csv"), |text| {
                    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
                    let columns: Vec<&str> = lines[2].split(',').collect();
                    let mut columns: Vec<String> = columns.into_iter().map(str::to_owned).collect();
                    columns[3] = "NaN".to_owned();
                    lines[2] = columns.join(",");
                    lines.join("\n") + "\n"
                });
            },
            "not finite at settle 250",
        ),
        (
            "endless stages",
            |bad| {
                change(&bad.join("run.json"), |text| {
                    text.replacen("\"steps\": 3000", "\"steps\": 9000000000000", 2)
                });
            },
            "moments of history",
        ),
    ];
    for (name, spoil, message) in cases {
        let (code, told) = spoiled(spoil);
        assert_eq!(code, 2, "{name}: {told}");
        assert!(told.contains(message), "{name}: {told}");
    }
}

#[test]
fn packed_tables_are_read_and_packed_bombs_are_not() {
    use flate2::{Compression, write::GzEncoder};
    use std::io::Write;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let run = small_run();
    let path = folder.path().join("run");
    run.write(&path).expect("writable");
    let table = path.join("trace.csv");
    let text = fs::read(&table).expect("text");
    let packed = fs::File::create(path.join("trace.csv.gz")).expect("writable");
    let mut encoder = GzEncoder::new(packed, Compression::best());
    encoder.write_all(&text).expect("writable");
    encoder.finish().expect("writable");
    fs::remove_file(&table).expect("a file");
    assert_eq!(RunFolder::read(&path).expect("a sound folder"), run);

    let bomb = fs::File::create(path.join("bomb.gz")).expect("writable");
    let mut encoder = GzEncoder::new(bomb, Compression::best());
    for _ in 0..64 {
        encoder.write_all(&[b'0'; 1 << 16]).expect("writable");
    }
    encoder.finish().expect("writable");
    let error = crossgrain::files::read_text(&path.join("bomb.gz"), 1 << 20)
        .expect_err("more than the limit");
    assert!(error.to_string().contains("larger than"), "{error}");
}

/// A bed without contacts has tables without rows, which are tables all the same.
#[test]
fn a_folder_without_contacts_reads_back() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let run = native_run(&small_scene(), sound(), Protocol::Steps { steps: 10 });
    assert!(run.last.contacts.is_empty());
    let path = folder.path().join("run");
    run.write(&path).expect("writable");
    assert_eq!(RunFolder::read(&path).expect("a sound folder"), run);
}

/// Killed at any moment, a run leaves a whole folder or none.
#[test]
fn a_run_killed_at_any_moment_leaves_a_whole_folder_or_none() {
    let (folder, _) = folder_with(&small_scene());
    let (mut whole, mut none) = (0, 0);
    // The last one has all the time that even a busy machine needs.
    for delay in (0..40).map(|k| 5 * k).chain([5000]) {
        let out = format!("out{delay}");
        let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_crossgrain"))
            .args(["run", "scene.json", "--engine", "native", "--steps", "3000"])
            .args(["--out", &out])
            .current_dir(folder.path())
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .expect("the program starts");
        std::thread::sleep(std::time::Duration::from_millis(delay));
        // Fails only for a run that was faster.
        let _ = child.kill();
        child.wait().expect("an ended child");
        let out = folder.path().join(out);
        if out.exists() {
            RunFolder::read(&out).expect("a whole folder");
            whole += 1;
        } else {
            none += 1;
        }
    }
    assert!(whole > 0 && none > 0, "{whole} whole, {none} none");
}

#[test]
fn a_pipe_is_no_table() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let made = std::process::Command::new("mkfifo")
        .arg(folder.path().join("run.json"))
        .status()
        .expect("mkfifo is there");
    assert!(made.success());
    let error = RunFolder::read(folder.path()).expect_err("no folder");
    assert!(error.to_string().contains("not a regular file"), "{error}");
}

/// A place that takes no files, whoever asks, stands for a disk that refuses: nothing half-written,
/// exit code 75.
#[test]
fn a_disk_that_refuses_says_try_again() {
    let (folder, _) = folder_with(&small_scene());
    let arguments = [
        "run",
        "scene.json",
        "--engine",
        "native",
        "--steps",
        "10",
        "--out",
        "/proc/out",
    ];
    let (code, _, errors) = told(&crossgrain(&arguments, folder.path()));
    assert_eq!(code, 75, "{errors}");
    assert!(errors.contains("cannot write into /proc"), "{errors}");
}
