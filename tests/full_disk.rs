//! Disks that are full or cannot be written: exit code 75, a message that names the place and what to do, and nothing that is
//! half-written. A limit on the size of files (`ulimit -f`) stands for a full disk; a small disk of its own is made by the
//! last test.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::support::{Words, ends, folder_with, has, rows, there, tiny_scene, told};

/// The program with files of at most so many kB: exit code and standard error.
fn limited(kilobytes: u32, command: &str, folder: &Path) -> (i32, String) {
    let script = format!("ulimit -f {kilobytes}; exec \"$0\" \"$@\" 2>&1 | cat");
    let script = format!("set -o pipefail; {script}");
    let output = Command::new("bash")
        .args(["-c", &script, env!("CARGO_BIN_EXE_crossgrain")])
        .args(command.words())
        .current_dir(folder)
        .output()
        .expect("bash is there");
    let (code, out, _) = told(&output);
    (code, out)
}

/// A folder with a run of the tiny scene.
fn folder_with_run() -> tempfile::TempDir {
    let (folder, _) = folder_with(&tiny_scene());
    let run = "run scene.json --engine native --steps 2000 --out run";
    ends(folder.path(), 0, run);
    folder
}

/// Runs a command with ever larger files until it can be done: before that it must end as on a full disk, and leave the folder
/// as it was.
fn fails_whole_until_it_fits(command: &str, made: &str) {
    let folder = folder_with_run();
    // Where the words are told apart by spaces the record has to be here.
    let record = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus/record/reproduce");
    fs::copy(record, folder.path().join("record")).expect("writable");
    let before = there(folder.path());
    let limits = [1, 2, 4, 8, 16, 64, 1024, 65536];
    for (full, kilobytes) in limits.into_iter().enumerate() {
        let (code, said) = limited(kilobytes, command, folder.path());
        if code != 75 {
            assert_eq!(code, 0, "{command}: {said}");
            assert!(folder.path().join(made).exists());
            assert!(full > 0, "{command} never met the limit");
            return;
        }
        has(&said, ["make room"]);
        assert_eq!(there(folder.path()), before, "{command} left something");
    }
    panic!("{command} does not fit into 64 MB");
}

#[test]
fn runs_exports_and_baselines_are_whole_or_not_there() {
    for [command, made] in rows(
        "run scene.json --engine native --steps 2000 --out o ⇒ o/run.json
        report vtk run --out o ⇒ o/cells.vtp
        report archive run --out o.tar.gz ⇒ o.tar.gz
        report baseline save record main --store . ⇒ main.json",
    ) {
        fails_whole_until_it_fits(command, made);
    }
}

/// The main job writes into a folder that it takes up again: what is in it is whole, and it is not finished.
#[test]
fn a_main_job_on_a_full_disk_is_taken_up_again() {
    let (folder, _) = folder_with(&tiny_scene());
    let job = "reproduce --scene scene.json --quiet --out o --yade /nowhere/yade";
    for kilobytes in [1, 8, 32] {
        let (code, said) = limited(kilobytes, job, folder.path());
        assert_eq!(code, 75, "{kilobytes}: {said}");
        has(&said, ["make room"]);
        for name in there(&folder.path().join("o")) {
            let known = ["native", "scene.json", ".crossgrain.lock"];
            assert!(known.contains(&name.as_str()), "{name}");
        }
    }
    let (code, said) = limited(65536, job, folder.path());
    assert_eq!(code, 3, "without YADE it is incomplete: {said}");
    assert!(folder.path().join("o/run.json").is_file());
}

#[test]
fn a_ladder_on_a_full_disk_leaves_no_folder() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let verify = "verify --engine native --grains 5 --quiet --out o";
    let (code, said) = limited(64, verify, folder.path());
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
    let record = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus/record/reproduce");
    fs::copy(record, folder.path().join("record")).expect("writable");
    let before = there(folder.path());
    for (place, code) in [("/proc/crossgrain", 75), ("scene.json/o", 2)] {
        for command in [
            "run scene.json --engine=native --steps=20 --out",
            "report vtk run --out",
            "report archive run --out",
            "report baseline save record main --store",
            "reproduce --scene scene.json --yade=/nowhere --out",
            "verify --engine=native --grains=5 --out",
            "study plan campaign scene.json --members=2 --out",
        ] {
            let command = format!("{command} {place}");
            let (_, errors) = ends(folder.path(), code, &command);
            let named = errors.contains("/proc") || errors.contains("scene.json");
            assert!(named, "{command}: {errors}");
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
