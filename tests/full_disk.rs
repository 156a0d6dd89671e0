//! Disks that are full or cannot be written: exit code 75, a message that names the place and what to do, and nothing that is
//! half-written. A limit on the size of files (`ulimit -f`) stands for a full disk; a small disk of its own is made by the
//! last test.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use crate::support::{crossgrain, folder_with, tiny_scene, told};

/// Names in a folder.
fn there(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let name = |entry: std::io::Result<fs::DirEntry>| entry.expect("an entry").file_name();
    entries
        .map(|of| name(of).to_string_lossy().into_owned())
        .collect()
}

/// The program with files of at most so many kB: exit code and standard error.
fn limited(kilobytes: u32, arguments: &[&str], folder: &Path) -> (i32, String) {
    let script = format!("ulimit -f {kilobytes}; exec \"$0\" \"$@\" 2>&1 | cat");
    let script = format!("set -o pipefail; {script}");
    let output = Command::new("bash")
        .args(["-c", &script, env!("CARGO_BIN_EXE_crossgrain")])
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("bash is there");
    let (code, out, _) = told(&output);
    (code, out)
}

/// A folder with a run of the tiny scene.
fn folder_with_run() -> tempfile::TempDir {
    let (folder, _) = folder_with(&tiny_scene());
    let run = ["run", "scene.json", "--engine", "native", "--steps", "2000"];
    let output = crossgrain(&[&run, ["--out", "run"].as_slice()].concat(), folder.path());
    assert_eq!(told(&output).0, 0, "{}", told(&output).2);
    folder
}

/// Runs a command with ever larger files until it can be done: before that it must end as on a full disk, and leave the folder
/// as it was.
fn fails_whole_until_it_fits(arguments: &[&str], made: &str, codes: &[i32]) {
    let folder = folder_with_run();
    let before = there(folder.path());
    let limits = [1, 2, 4, 8, 16, 64, 1024, 65536];
    for (full, kilobytes) in limits.into_iter().enumerate() {
        let (code, said) = limited(kilobytes, arguments, folder.path());
        if code != 75 {
            assert!(codes.contains(&code), "{arguments:?}: {said}");
            assert!(folder.path().join(made).exists());
            assert!(full > 0, "{arguments:?} never met the limit");
            return;
        }
        assert!(said.contains("make room"), "{said}");
        assert_eq!(there(folder.path()), before, "{arguments:?} left something");
    }
    panic!("{arguments:?} does not fit into 64 MB");
}

#[test]
fn runs_exports_and_baselines_are_whole_or_not_there() {
    let run = ["run", "scene.json", "--engine", "native", "--steps", "2000"];
    fails_whole_until_it_fits(
        &[&run, ["--out", "o"].as_slice()].concat(),
        "o/run.json",
        &[0],
    );
    fails_whole_until_it_fits(&["report", "vtk", "run", "--out", "o"], "o/cells.vtp", &[0]);
    fails_whole_until_it_fits(
        &["report", "archive", "run", "--out", "o.tar.gz"],
        "o.tar.gz",
        &[0],
    );
    let record = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus/record/reproduce");
    let record = record.to_string_lossy();
    let save = [
        "report", "baseline", "save", &record, "main", "--store", ".",
    ];
    fails_whole_until_it_fits(&save, "main.json", &[0]);
}

/// The main job writes into a folder that it takes up again: what is in it is whole, and it is not finished.
#[test]
fn a_main_job_on_a_full_disk_is_taken_up_again() {
    let (folder, _) = folder_with(&tiny_scene());
    let arguments = [
        "reproduce",
        "--scene",
        "scene.json",
        "--quiet",
        "--out",
        "o",
        "--yade",
        "/nowhere/yade",
    ];
    for kilobytes in [1, 8, 32] {
        let (code, said) = limited(kilobytes, &arguments, folder.path());
        assert_eq!(code, 75, "{kilobytes}: {said}");
        assert!(said.contains("make room"), "{said}");
        for name in there(&folder.path().join("o")) {
            let known = ["native", "scene.json", ".crossgrain.lock"];
            assert!(known.contains(&name.as_str()), "{name}");
        }
    }
    let (code, said) = limited(65536, &arguments, folder.path());
    assert_eq!(code, 3, "without YADE it is incomplete: {said}");
    assert!(folder.path().join("o/run.json").is_file());
}

#[test]
fn a_ladder_on_a_full_disk_leaves_no_folder() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let arguments = [
        "verify", "--engine", "native", "--grains", "5", "--quiet", "--out", "o",
    ];
    let (code, said) = limited(64, &arguments, folder.path());
    assert_eq!(code, 75, "{said}");
    assert!(
        there(folder.path()).is_empty(),
        "{:?}",
        there(folder.path())
    );
}

/// `/proc` takes no files from anybody; a file is no folder.
#[test]
fn places_that_cannot_be_written_are_named() {
    let folder = folder_with_run();
    let before = there(folder.path());
    let record = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus/record/reproduce");
    let record = record.to_string_lossy();
    for (place, code) in [("/proc/crossgrain", 75), ("scene.json/o", 2)] {
        for arguments in [
            [
                "run",
                "scene.json",
                "--engine=native",
                "--steps=20",
                "--out",
                place,
            ]
            .as_slice(),
            &["report", "vtk", "run", "--out", place],
            &["report", "archive", "run", "--out", place],
            &[
                "report", "baseline", "save", &record, "main", "--store", place,
            ],
            &[
                "reproduce",
                "--scene",
                "scene.json",
                "--yade=/nowhere",
                "--out",
                place,
            ],
            &["verify", "--engine=native", "--grains=5", "--out", place],
            &[
                "study",
                "plan",
                "campaign",
                "scene.json",
                "--members=2",
                "--out",
                place,
            ],
        ] {
            let (found, _, errors) = told(&crossgrain(arguments, folder.path()));
            assert_eq!(found, code, "{arguments:?}: {errors}");
            let named = errors.contains("/proc") || errors.contains("scene.json");
            assert!(named, "{arguments:?}: {errors}");
            assert_eq!(there(folder.path()), before);
        }
    }
}

/// A disk of 16 kB, then the same one read-only; in a name space of its own, so that nobody else sees it.
#[test]
#[ignore = "mounts a small disk of its own: unshare -rm must be allowed"]
fn a_small_disk_and_one_that_is_read_only() {
    let folder = folder_with_run();
    let script = r#"
        set -u
        mkdir disk && mount -t tmpfs -o size=16k none disk
        run() { "$program" "$@" 2>&1; echo "code $?"; ls -A disk; }
        commands() {
            run run scene.json --engine native --steps 2000 --quiet --out disk/o
            run report vtk run --out disk/o
            run reproduce --scene scene.json --quiet --yade /nowhere --out disk/r
            rm -rf disk/r
        }
        commands
        mount -o remount,ro disk
        commands
    "#;
    let output = Command::new("unshare")
        .args(["-rm", "bash", "-c", script])
        .env("program", env!("CARGO_BIN_EXE_crossgrain"))
        .current_dir(folder.path())
        .output()
        .expect("unshare is there");
    let (_, said, errors) = told(&output);
    assert_eq!(said.matches("code 75").count(), 6, "{said}{errors}");
    assert_eq!(said.matches("make room").count(), 3, "{said}");
    assert_eq!(said.matches("can be written").count(), 3, "{said}");
    // All that is left is what the main job takes up again.
    for line in said
        .lines()
        .filter(|line| !line.starts_with("cro") && !line.starts_with("code"))
    {
        assert!(
            line == "r" || line.starts_with("rm: "),
            "left behind: {line}\n{said}"
        );
    }
}
