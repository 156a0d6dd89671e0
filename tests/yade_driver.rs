//! The YADE driver against programs that are not YADE: each way to fail is its own error, and none
//! leaves a run folder. Needs a Python, not YADE.

use crate::support::*;

/// Moments of the two grains of the scene below, `{numbers}` doubles, and the files around them.
const WRITES: &str = r#"
import json, os, struct, sys, time
job = os.environ["CROSSGRAIN_JOB"]
def put(name, text):
    # As the real scripts do it: a file is there whole or not at all.
    aside = os.path.join(job, name + ".aside")
    with open(aside, "w") as file:
        file.write(text)
    os.replace(aside, os.path.join(job, name))
def frames(values, lines, steps=10):
    put("hello.json", json.dumps({"version": "2023.02a"}))
    with open(os.path.join(job, "tables.bin"), "wb") as file:
        file.write(struct.pack("<%dd" % len(values), *values))
    put("moments.jsonl", "".join(json.dumps(line) + "\n" for line in lines))
    put("done.json", json.dumps({"steps": steps}))
    os._exit(0)
def frame(step, contacts=0, out=0.0):
    return {"stage": "settle", "step": step, "contacts": contacts, "out_of_plane": out, "punch": None}
def end(steps, stop="steps_done"):
    return {"end": "settle", "steps": steps, "stop": stop, "wall_seconds": 1.0, "cpu_seconds": 1.0}
given = os.path.join(job, "initial.csv")
rows = [line.split(",") for line in open(given).read().split()[1:]] if os.path.exists(given) else []
fine = [float(row[column]) for column in (1, 2, 3, 4) for row in rows]
"#;

/// A program that stands for YADE, of this name, and does this.
pub fn yade(folder: &Path, name: impl AsRef<Path>, does: &str) -> PathBuf {
    let text = format!("#!/usr/bin/python3\n{WRITES}\n{does}\n");
    program(folder, name, &text)
}

/// Runs the scene in the folder for ten steps with this program for YADE, which fails: what is said of it.
fn run(folder: &Path, yade: &Path) -> String {
    let limits = "--stall-limit 2 --time-limit 6";
    let run = format!("run scene.json --engine yade --steps 10 --out out {limits} --yade");
    let yade = yade.to_string_lossy();
    let (_, errors) = ends(folder, 4, &[&run.words()[..], &[&yade]].concat());
    let left = |name: &String| name.starts_with(".crossgrain") || name == "out";
    assert_eq!(there(folder).into_iter().find(left), None, "left behind");
    errors
}

fn fails(does: &str, message: &str) {
    let folder = &folder_with(&scene_of(2));
    let errors = run(folder, &yade(folder, "yade", does));
    for words in message.split(" | ") {
        has(&errors, [words]);
    }
}

#[test]
fn missing() {
    let folder = &folder_with(&small_scene());
    let errors = run(folder, Path::new("/nowhere/yade"));
    has(&errors, ["YADE is missing"]);
    has(&errors, ["apt-get install --no-install-recommends yade"]);
    let path = folder.join("not-python");
    fs::write(&path, "just text\n").expect("writable");
    has(&run(folder, &path), ["does not name a Python interpreter"]);
}

/// What a program does that is too old, crashes or hangs, which being alive for ever is too; and what is said of it.
const FAILS: &str = r#"
    put("hello.json", json.dumps({"version": "2018.02b"})); time.sleep(60) ⇒ YADE 2018.02b is too old | 2023.02
    os.abort() ⇒ the engine ended with | signal
    raise RuntimeError("no functor for that") ⇒ the engine ended with | exit status: 1 | no functor for that
    time.sleep(600) ⇒ the engine hung | no sign of life
    [(put('heartbeat', 'settle 1 0.0\n' * int(time.time() % 1000)), time.sleep(0.1)) for i in range(10**6)] ⇒ the engine hung | not done within 6s
    import subprocess; subprocess.Popen(['sleep', '987654']); time.sleep(600) ⇒ the engine hung
"#;

#[test]
fn too_old_crashed_and_hung() {
    for [does, message] in rows(FAILS) {
        fails(does, message);
    }
    // What a hung program has started has ended with it.
    let entries = fs::read_dir("/proc").expect("Linux").flatten();
    let mut commands = entries.filter_map(|entry| fs::read(entry.path().join("cmdline")).ok());
    assert!(!commands.any(|command| command.starts_with(b"sleep\0987654\0")));
}

#[test]
fn its_log_is_kept() {
    let folder = &folder_with(&scene_of(2));
    let path = folder.join("yade");
    program(
        folder,
        "yade",
        "#!/usr/bin/python3\nprint('last words')\nraise SystemExit(3)\n",
    );
    fs::write(folder.join("out.yade.log"), "mine").expect("writable");
    run(folder, &path);
    let read = |name: &str| text_of(folder.join(name));
    assert_eq!(read("out.yade.log"), "mine");
    assert!(read("out.yade.log-2").contains("last words"));
}

/// What the program does, and what is said of it.
const NONSENSE: &str = r#"
    os._exit(0) ⇒ without saying its version
    put("hello.json", json.dumps({"version": "2023.02a"})); os._exit(0) ⇒ its list of moments is not there
    put("hello.json", "{"); put("done.json", "{}"); os._exit(0) ⇒ hello.json
    frames([float('nan')] + fine[1:] + fine, [frame(0), frame(10), end(10)]) ⇒ a NaN among its numbers
    frames(fine + fine[:3], [frame(0), frame(10), end(10)]) ⇒ cut off
    frames(fine + fine + fine, [frame(0), frame(10), end(10)]) ⇒ goes on after the last moment
    frames(fine + fine, [frame(0), frame(7), end(7)]) ⇒ 10 steps were asked for and 7 were done
    frames(fine + fine, [frame(0), frame(9), end(10)]) ⇒ moment 1 of the run should be settle 10 and is settle 9
    frames(fine + fine + fine, [frame(0), frame(10), end(10), frame(11)]) ⇒ moment 2 of the run should be none and is settle 11
    frames(fine + fine, [frame(0), frame(10)]) ⇒ none was finished
    frames(fine + fine, [frame(0), frame(10), end(10, 'settled')]) ⇒ its stages are not those of the task
    frames(fine + fine, [frame(0), frame(10), end(10)], steps=9) ⇒ it counts 9 steps, its stages have 10
    frames([0.2] + fine[1:] + fine, [frame(0), frame(10), end(10)]) ⇒ not the start that it was given
    put("hello.json", json.dumps({"version": "2023.02a"})); put("done.json", "{}"); os._exit(0) ⇒ moments.jsonl
    frames(fine, [frame(0), end(10, 'not_finite')]) ⇒ not finite in step 10
    frames(fine, [frame(0), end(10, 'bored')]) ⇒ the stop reason
    frames(fine + fine[:4], [frame(0), end(0)]) ⇒ goes on after the last moment
    os.remove(os.path.join(job, 'initial.csv')); frames(fine, [dict(frame(0), contacts=None), end(0)]) ⇒ settle-0-bodies.csv
    frames(fine, [frame(0, out=1e-9), end(0)]) ⇒ left the plane
    frames(fine + [1, 77, 0, 1, 0, 1, 0, 0, 0], [frame(0, contacts=1), end(0)]) ⇒ bodies that do not exist
    frames(fine + [1, 0.5, 0, 1, 0, 1, 0, 0, 0], [frame(0, contacts=1), end(0)]) ⇒ bodies that do not exist
    frames(fine + [1, 0, 0, 1, 0, 1, 0, 0, 0], [frame(0, contacts=1), end(0)]) ⇒ the lower id stands first
    frames(fine + [0, 1, -1e-9, 1, 0, 1, 0, 0, 0], [frame(0, contacts=1), end(0)]) ⇒ only what touches is a contact
    frames(fine + [0, 1, 0, 1, 0, 1, 1, 0, 0], [frame(0, contacts=1), end(0)]) ⇒ must be of length 1
    frames(fine + 2 * [0, 1, 0, 1, 0, 1, 0, 0, 0], [frame(0, contacts=2), end(0)]) ⇒ after the pair of the row before
    frames(fine, [frame(0, contacts=10**12), end(0)]) ⇒ contacts
    frames(fine, [{'colour': 'red'}]) ⇒ moments.jsonl
"#;

#[test]
fn nonsense() {
    for [program, message] in rows(NONSENSE) {
        fails(program, &format!("the engine wrote nonsense | {message}"));
    }
}
