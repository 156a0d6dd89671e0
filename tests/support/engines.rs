//! External engines: those of the project, changed ones and broken ones.

use std::os::unix::fs::PermissionsExt;

use grains::scene::Cloud;

use super::*;

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
        over: None,
    };
    scene.loading.half_width = 0.012;
    scene.loading.give_up_depth = 0.02;
    scene.control_points.truncate(1);
    scene.measurement.history_every = 50;
    scene
}

/// An adapter of the project.
pub fn adapter_path(name: &str) -> PathBuf {
    root("adapters").join(name)
}

/// An adapter of the project, as it is named on the command line.
pub fn adapter(name: &str) -> String {
    format!("exec:{}", adapter_path(name).display())
}

/// Where `ci/install_engines` puts an environment of Python.
pub fn environment(name: &str) -> PathBuf {
    let home = std::env::var_os("HOME").expect("a home");
    Path::new(&home).join(".local/share/crossgrain").join(name)
}

/// A program of this text in the folder, under any name.
pub fn program(folder: &Path, name: impl AsRef<Path>, text: &str) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, text).expect("writable");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("ours");
    path
}

/// The same, as it is named on the command line.
pub fn engine(folder: &Path, name: &str, text: &str) -> String {
    format!("exec:{}", program(folder, name, text).display())
}

/// The toy with one place changed.
pub fn changed_toy(from: &str, to: &str) -> String {
    let toy = text_of(adapter_path("toy.py"));
    let count = toy.matches(from).count();
    assert_eq!(count, 1, "«{from}» is not once in the toy");
    toy.replace(from, to)
}

/// `crossgrain run scene.json` in this engine and folder, which ends with this exit code; what it complained of.
pub fn run_in(folder: &Path, code: i32, engine: &str, more: &[&str], out: &str) -> String {
    let run = ["run", "scene.json", "--quiet", "--out", out];
    ends(
        folder,
        code,
        &[&run[..], &["--engine", engine], more].concat()[..],
    )
    .1
}

/// The same, and it ends well.
pub fn ran_in(folder: &Path, engine: &str, more: &[&str], out: &str) {
    run_in(folder, 0, engine, more, out);
}

/// What every broken program begins with: it describes itself well, and can write well.
pub const SOUND: &str = r#"#!/usr/bin/env python3
import json, os, subprocess, sys, time
def describe(**changes):
    print(json.dumps({"protocol": 1, "name": "broken", "version": "1",
        "parts": ["normal_spring", "local_damping", "gravity", "walls"]} | changes))
    sys.exit()
SAY = describe
"#;
/// What follows what it says of itself.
pub const AND_THEN: &str = r#"
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
