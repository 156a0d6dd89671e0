//! Run folders: written whole or not at all, read back to the bit, refused when they are not sound.

use crossgrain::files::{FileError, write_folder};
use crossgrain::run::folder::{sum_line, write_sums};

use crate::support::*;

fn small_run() -> RunFolder {
    native_run(&small_scene(), sound(), Protocol::Steps { steps: 3000 })
}

/// Written as `run` into a folder that goes away, and read back to the same bits.
pub fn written(run: &RunFolder) -> (Place, PathBuf) {
    let folder = new_folder();
    let path = folder.join("run");
    run.write(&path).expect("a writable folder");
    assert_eq!(read_run(&path), *run);
    (folder, path)
}

fn has_columns(folder: &Path, tables: &str, columns: &str) {
    for table in tables.words() {
        let text = text_of(folder.join(table).with_extension("csv"));
        assert_eq!(text.lines().next(), Some(columns), "{table}");
    }
}

#[test]
fn a_folder_reads_back_to_the_same_bits() {
    let run = native_run(&small_scene(), sound(), Protocol::Whole);
    let (_folder, path) = written(&run);
    assert!(run.settled.is_some());
    for name in "scene.json run.json history.csv trace.csv settled-contacts.csv".words() {
        assert!(path.join(name).is_file(), "{name}");
    }
    let columns = "id,x,z,vx,vz,radius,mass";
    has_columns(&path, "initial bodies settled-bodies", columns);
    has_columns(&path, "contacts", "id1,id2,overlap,fn,ft,nx,nz,x,z");
}

#[test]
fn a_folder_of_grains_that_rotate_reads_back_to_the_same_bits() {
    let run = native_run(&frictional_scene(), sound(), Protocol::Whole);
    let (_folder, path) = written(&run);
    let settled = run.settled.expect("a settled bed").bodies;
    assert!(settled.spin.iter().all(|spin| *spin != 0.0));
    let columns = "id,x,z,vx,vz,radius,mass,spin,inertia";
    has_columns(&path, "initial bodies settled-bodies", columns);
    // Another spin at the end is another state.
    change(&path.join("bodies.csv"), |text| {
        with_cell(text, 9, 7, "0.125")
    });
    let error = RunFolder::read(&path).expect_err("another spin");
    has(&error.to_string(), ["another state"]);
}

#[test]
fn nothing_existing_is_overwritten() {
    let folder = &folder_with(&small_scene());
    let out = folder.join("out");
    fs::create_dir(&out).expect("a writable folder");
    fs::write(out.join("precious"), "mine").expect("a writable folder");
    let command = "run scene.json --engine native --steps 10 --out out";
    tells(folder, 2, command, ["exists already"]);
    assert_eq!(text_of(out.join("precious")), "mine");
    assert_eq!(fs::read_dir(&out).expect("a folder").count(), 1);
}

/// A run that never settles, at work for a moment.
fn endless_run() -> (Place, Child) {
    let folder = folder_with(&endless_scene());
    let command = "run scene.json --engine native --out out";
    let mut child = started(&folder, command);
    std::thread::sleep(Duration::from_millis(400));
    assert_eq!(child.try_wait().expect("a child"), None, "it is running");
    (folder, child)
}

#[test]
fn a_run_that_is_asked_to_end_is_kept_and_exits_with_75() {
    let (folder, mut child) = endless_run();
    send(&child, "TERM");
    let status = child.wait().expect("an ended child");
    assert_eq!(status.code(), Some(75));
    let left = fs::read_dir(&folder).expect("a folder").count();
    assert_eq!(left, 2, "the scene, the run and nothing else");
    let out = folder.join("out");
    let run = RunFolder::read_so_far(&out).expect("a run folder");
    // Nobody takes it for a whole run.
    let error = RunFolder::read(&out).expect_err("so far only");
    assert!(error.to_string().contains("--from-state"), "{error}");
    assert_eq!(run.record.stop(), Some(StopReason::Interrupted));
}

fn change(path: &Path, how: impl FnOnce(&str) -> String) {
    let text = text_of(path);
    put(path, how(&text));
}

/// With the digests of what stands there now: what is under test are the reasons after them.
pub fn put(path: &Path, bytes: impl AsRef<[u8]>) {
    fs::write(path, bytes).expect("writable");
    write_sums(path.parent().expect("a run folder")).expect("writable");
}

fn with_cell(text: &str, row: usize, column: usize, cell: &str) -> String {
    let mut rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    rows[row][column] = cell;
    rows.iter().map(|row| row.join(",") + "\n").collect()
}

/// Without so many rows at the end.
fn without_last(text: &str, count: usize) -> String {
    let rows = text.split_inclusive('\n');
    let kept = rows.clone().count() - count;
    rows.take(kept).collect()
}

#[test]
fn unsound_folders_are_refused_with_exit_2() {
    let run = small_run();
    let is_refused = |message: &str, spoil: &dyn Fn(&Path)| {
        let folder = &new_folder();
        for name in ["good", "bad"] {
            run.write(&folder.join(name)).expect("writable");
        }
        spoil(&folder.join("bad"));
        tells(folder, 2, "compare good bad --no-locate", [message]);
    };
    let changed = |file: &str, message: &str, how: fn(&str) -> String| {
        is_refused(message, &|bad| change(&bad.join(file), how));
    };
    let bodies = |message: &str, how| changed("bodies.csv", message, how);
    bodies("bodies.csv", |text| text[..text.len() - 9].to_owned());
    bodies("has 297 grains, the scene 300", |text| {
        without_last(text, 3)
    });
    bodies("bodies.csv", |_| String::new());
    bodies("x = NaN, which must be finite", |text| {
        with_cell(text, 5, 1, "NaN")
    });
    let masses = "other radii, masses or moments of inertia than initial.csv";
    bodies(masses, |text| with_cell(text, 9, 6, "7.0"));
    changed("contacts.csv", "id2 = 100000", |text| {
        format!("{text}303,100000,1e-6,1,0,1,0,0.1,0.1\n")
    });
    changed("contacts.csv", "second body is no grain", |text| {
        format!("{text}303,302,1e-6,1,0,1,0,0.1,0.1\n")
    });
    let history = |message: &str, how| changed("history.csv", message, how);
    history("has not the moments of the stages", |text| {
        without_last(text, 1)
    });
    history("not finite at settle 250", |text| {
        with_cell(text, 2, 3, "NaN")
    });
    let record = |message: &str, how| changed("run.json", message, how);
    record("run.json", |_| "{".to_owned());
    record("version 99", |text| {
        text.replacen("\"version\": 4", "\"version\": 99", 1)
    });
    record("moments of history", |text| {
        text.replacen("\"steps\": 3000", "\"steps\": 9000000000000", 2)
    });
    changed("scene.json", "not the scene of run.json", |text| {
        text.replacen("\"gravity\": 9.81", "\"gravity\": 9.8", 1)
    });
    let gone = |bad: &Path| fs::remove_dir_all(bad).expect("a folder");
    is_refused("there is no such folder", &gone);
    is_refused("it has no run.json", &|bad| {
        gone(bad);
        fs::create_dir(bad).expect("writable");
    });
    is_refused("holds run folders; name one of them: ", &|bad| {
        let aside = bad.with_extension("aside");
        fs::rename(bad, &aside).expect("a folder");
        fs::create_dir(bad).expect("writable");
        fs::rename(aside, bad.join("native")).expect("writable");
    });
    is_refused("bodies.csv", &|bad| {
        fs::remove_file(bad.join("bodies.csv")).expect("a file");
    });
    is_refused("not UTF-8", &|bad| {
        put(&bad.join("history.csv"), b"\xff\xfe\0")
    });
}

#[test]
fn a_run_killed_at_any_moment_leaves_a_whole_folder_or_none() {
    let folder = &folder_with(&small_scene());
    let (mut whole, mut none) = (0, 0);
    // The last one has all the time that even a busy machine needs.
    for delay in (0..40).map(|k| 5 * k).chain([5000]) {
        let out = format!("out{delay}");
        let run = format!("run scene.json --engine native --steps 3000 --out {out}");
        let mut child = started(folder, &run);
        std::thread::sleep(Duration::from_millis(delay));
        // Fails only for a run that was faster.
        let _ = child.kill();
        child.wait().expect("an ended child");
        let out = folder.join(out);
        if out.exists() {
            read_run(&out);
            whole += 1;
        } else {
            none += 1;
        }
    }
    assert!(whole > 0 && none > 0, "{whole} whole, {none} none");
}

#[test]
fn of_two_runs_into_one_folder_one_is_refused() {
    let folder = &folder_with(&small_scene());
    let command = "run scene.json --engine native --steps 5000 --quiet --out out";
    let ends = std::thread::scope(|both| {
        let run = || both.spawn(|| say(folder, command));
        [run(), run()].map(|run| run.join().expect("no panic"))
    });
    let codes = ends.each_ref().map(|(code, ..)| *code);
    assert!(matches!(codes, [0, 2] | [2, 0]), "{ends:?}");
    let refused = |(_, _, errors): &(i32, String, String)| errors.contains("out exists already");
    assert!(ends.iter().any(refused), "{ends:?}");
    read_run(folder.join("out"));
    assert_eq!(fs::read_dir(folder).expect("a folder").count(), 2);
}

#[test]
fn a_name_that_is_taken_while_a_folder_is_filled_is_refused() {
    let folder = &new_folder();
    let path = folder.join("out");
    let error = write_folder(&path, |_| {
        fs::create_dir(&path).expect("a new folder");
        fs::write(path.join("theirs"), "whole").expect("a writable folder");
        Ok::<_, FileError>(())
    })
    .expect_err("taken");
    assert_eq!(error.exit_code(), 2);
    assert!(error.to_string().contains("out exists already"), "{error}");
    assert_eq!(fs::read_dir(folder).expect("a folder").count(), 1);
    assert!(path.join("theirs").exists());
}

#[test]
fn a_pipe_is_no_table() {
    let folder = &new_folder();
    a_pipe(folder, "run.json");
    let line = sum_line(&"0".repeat(64), "run.json");
    fs::write(folder.join("SHA256SUMS"), line).expect("ours");
    let error = RunFolder::read(folder).expect_err("no folder");
    assert!(error.to_string().contains("not a regular file"), "{error}");
}

/// A place that takes no files, whoever asks, stands for a disk that refuses: nothing half-written,
/// exit code 75.
#[test]
fn a_disk_that_refuses_says_try_again() {
    let folder = &folder_with(&small_scene());
    let command = "run scene.json --engine native --steps 10 --out /proc/out";
    tells(folder, 75, command, ["cannot write into /proc"]);
}
