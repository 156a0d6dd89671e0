//! Disks that are full or cannot be written: exit code 75, a message that names the place and what to do, and nothing that is
//! half-written. For a full disk stands a library that lets one call fail, or a limit on the size of files (`ulimit -f`); a
//! small disk of its own is made by the last test.

use crate::support::*;

/// The program with files of at most so many kB: exit code and standard error.
fn limited(kilobytes: u32, command: &str, folder: &Path) -> (i32, String) {
    let limit = format!("set -o pipefail; ulimit -f {kilobytes}");
    let script = format!("{limit}; exec \"$0\" \"$@\" 2>&1 | cat");
    let (code, out, _) = bash(folder, &script, &command.words());
    (code, out)
}

/// A folder with a run of the tiny scene and the record of a job.
fn folder_with_run() -> Place {
    let folder = folder_with(&tiny_scene());
    let record = root("fuzz/corpus/record/reproduce");
    fs::copy(record, folder.join("record")).expect("writable");
    let run = "run scene.json --engine native --steps 2000 --out run";
    ends(&folder, 0, run);
    folder
}

/// In the place of the system's calls that take room: the one of the number in FULL_AT finds the disk full, and says so. Files below a folder
/// are opened past it.
const FULL: &str = r#"
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/types.h>
#include <unistd.h>
static int full(void) {
    static int calls;
    const char *at = getenv("FULL_AT");
    if (!at || __sync_add_and_fetch(&calls, 1) != atoi(at)) return 0;
    dprintf(2, "[full]");
    errno = ENOSPC;
    return 1;
}
#define NEXT(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))
ssize_t write(int fd, const void *from, size_t size) { return fd > 2 && full() ? -1 : NEXT(write)(fd, from, size); }
int fsync(int fd) { return full() ? -1 : NEXT(fsync)(fd); }
int fdatasync(int fd) { return full() ? -1 : NEXT(fdatasync)(fd); }
int mkdir(const char *path, mode_t mode) { return full() ? -1 : NEXT(mkdir)(path, mode); }
int rename(const char *from, const char *to) { return full() ? -1 : NEXT(rename)(from, to); }
#define OPEN(name) int name(const char *path, int flags, ...) { \
    va_list more; \
    va_start(more, flags); \
    mode_t mode = flags & O_CREAT ? va_arg(more, mode_t) : 0; \
    va_end(more); \
    return flags & O_CREAT && full() ? -1 : NEXT(name)(path, flags, mode); \
}
OPEN(open)
OPEN(open64)
"#;

/// The program with a disk that is full at one call alone: whether it came so far, exit code, standard error.
struct Full(Place);

impl Full {
    fn new() -> Self {
        let place = new_folder();
        fs::write(place.join("full.c"), FULL).expect("writable");
        let made = Command::new("cc")
            .args(["-shared", "-fPIC", "-o", "full.so", "full.c", "-ldl"])
            .current_dir(&place)
            .status();
        assert!(made.expect("cc is there, as for the program").success());
        Full(place)
    }

    fn at(&self, call: usize, command: &str, folder: &Path) -> (bool, i32, String) {
        let mut program = cli(folder);
        program
            .args(command.words())
            .env("FULL_AT", call.to_string());
        let output = program.env("LD_PRELOAD", self.0.join("full.so")).output();
        let (code, _, errors) = told(&output.expect("the program starts"));
        (errors.contains("[full]"), code, errors)
    }
}

#[test]
fn runs_exports_and_plans_are_whole_or_not_there_whichever_write_fails() {
    let full = Full::new();
    let folder = &folder_with_run();
    for [command, made, fewest] in rows(
        "run scene.json --engine native --steps 200 --quiet --out o ⇒ o/run.json ⇒ 24
        report vtk run --out v ⇒ v/cells.vtp ⇒ 10
        report archive run --out o.tar.gz ⇒ o.tar.gz ⇒ 4
        report baseline save record main --store . ⇒ main.json ⇒ 3
        study plan campaign scene.json --members 2 --out c ⇒ c/plan.json ⇒ 5",
    ) {
        let before = there(folder);
        let fewest: usize = fewest.parse().expect("a number");
        for call in 1.. {
            let (met, code, said) = full.at(call, command, folder);
            if !met {
                assert_eq!(code, 0, "{command}: {said}");
                assert!(folder.join(made).exists());
                assert!(call > fewest, "{command} makes {call} calls");
                break;
            }
            assert_eq!(code, 75, "{command}, call {call}: {said}");
            has(&said, ["make room"]);
            assert_eq!(there(folder), before, "{command}, call {call}: {said}");
        }
    }
}

/// Rows that were written down stay, and the next start comes to the same end as if nothing had been.
#[test]
fn a_study_goes_on_whichever_write_fails() {
    let full = Full::new();
    let at = &folder_with(&tiny_scene());
    let plan = "study plan campaign scene.json --members 2 --out";
    let results = ["rows.jsonl", "rows.csv", "merged.json", "report.json"];
    let made =
        |folder: &str| results.map(|name| fs::read(at.join(folder).join(name)).expect("a result"));
    ends(at, 0, &format!("{plan} sound"));
    ends(at, 0, "study run sound --threads 1 --quiet");
    for call in 1.. {
        ends(at, 0, &format!("{plan} c"));
        let run = "study run c --threads 1 --quiet";
        let (met, code, said) = full.at(call, run, at);
        if !met {
            assert!(call > 20, "it makes {call} calls");
            break;
        }
        assert_eq!(code, 75, "call {call}: {said}");
        has(&said, ["make room"]);
        ends(at, 0, run);
        assert!(made("c") == made("sound"), "call {call}");
        let hidden = there(&at.join("c")).into_iter();
        let hidden = hidden.filter(|name| name.starts_with('.'));
        let hidden: Vec<String> = hidden.filter(|name| !name.ends_with(".lock")).collect();
        assert!(hidden.is_empty(), "call {call} left {hidden:?}");
        fs::remove_dir_all(at.join("c")).expect("removable");
    }
}

/// The main job writes into a folder that it takes up again: what is in it is whole, and it is not finished.
#[test]
fn a_main_job_on_a_full_disk_is_taken_up_again() {
    let folder = &folder_with(&tiny_scene());
    let job = "reproduce --scene scene.json --quiet --out o --recorded";
    for kilobytes in [1, 8, 32] {
        let (code, said) = limited(kilobytes, job, folder);
        assert_eq!(code, 75, "{kilobytes}: {said}");
        has(&said, ["make room"]);
        for name in there(&folder.join("o")) {
            let known = ["native", "scene.json", ".crossgrain.lock"];
            assert!(known.contains(&name.as_str()), "{name}");
        }
    }
    let (code, said) = limited(65536, job, folder);
    assert_eq!(code, 3, "without YADE it is incomplete: {said}");
    assert!(folder.join("o/run.json").is_file());
}

#[test]
fn a_ladder_on_a_full_disk_leaves_no_folder() {
    let folder = &new_folder();
    let verify = "verify --engine native --grains 5 --quiet --out o";
    let (code, said) = limited(64, verify, folder);
    assert_eq!(code, 75, "{said}");
    assert!(there(folder).is_empty(), "{:?}", there(folder));
}

/// `/proc` takes no files from anybody; a file is no folder.
#[test]
fn places_that_cannot_be_written_are_named() {
    let folder = &folder_with_run();
    let before = there(folder);
    for (place, code, named) in [
        ("/proc/crossgrain", 75, "/proc"),
        ("scene.json/o", 2, "scene.json"),
    ] {
        for command in [
            "run scene.json --engine=native --steps=20 --out",
            "report vtk run --out",
            "report archive run --out",
            "report baseline save record main --store",
            "reproduce --scene scene.json --recorded --out",
            "verify --engine=native --grains=5 --out",
            "study plan campaign scene.json --members=2 --out",
        ] {
            let command = format!("{command} {place}");
            let (_, errors) = ends(folder, code, &command);
            has(&errors, [named]);
            assert_eq!(there(folder), before);
        }
    }
}

/// A disk of 16 kB, then the same one read-only; in a name space of its own, so that nobody else sees it.
#[test]
#[ignore = "mounts a small disk of its own: unshare -rm must be allowed"]
fn a_small_disk_and_one_that_is_read_only() {
    let folder = &folder_with_run();
    let script = r#"
        set -u
        mkdir disk && mount -t tmpfs -o size=16k none disk
        run() { "$0" "$@" 2>&1; echo "code $?"; ls -A disk; }
        commands() {
            run run scene.json --engine native --steps 2000 --quiet --out disk/o
            run report vtk run --out disk/o
            run reproduce --scene scene.json --quiet --recorded --out disk/r
            rm -rf disk/r
        }
        commands
        mount -o remount,ro disk
        commands
    "#;
    let own = r#"unshare -rm bash -c "$1" "$0""#;
    let (_, said, errors) = bash(folder, own, &[script]);
    assert_eq!(said.matches("code 75").count(), 6, "{said}{errors}");
    assert_eq!(said.matches("make room").count(), 3, "{said}");
    assert_eq!(said.matches("can be written").count(), 3, "{said}");
    // All that is left is what the main job takes up again.
    for line in said.lines().filter(|line| *line != "r") {
        let told = ["cro", "code", "rm: "]
            .iter()
            .any(|beginning| line.starts_with(beginning));
        assert!(told, "left behind: {line}\n{said}");
    }
}
