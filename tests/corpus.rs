//! The corpus of engines: right ones in many builds and wrong ones, each judged as `engine check` judges it. The confusion
//! matrix is printed; nothing right may be called wrong, nothing wrong right, and what is wrong must be named.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crossgrain::engine::exec::{self, Options};
use crossgrain::suite::conformance::from_bed;
use serde::Deserialize;
use verdict::judge::{Judgement, Reference, Verdict};

use crate::support::engines::program;

#[derive(Deserialize)]
struct Corpus {
    right: Vec<Right>,
    wrong: Vec<Wrong>,
}

#[derive(Deserialize)]
struct Right {
    name: String,
    compile: Vec<String>,
    precision: String,
}

#[derive(Deserialize)]
struct Wrong {
    name: String,
    fault: String,
    cause: String,
    factor: Option<f64>,
    #[allow(dead_code)]
    needs: Vec<String>,
}

fn here(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/corpus")
        .join(name)
}

fn compiled(folder: &Path, right: &Right) -> PathBuf {
    let program = folder.join(&right.name);
    let mut command = Command::new("cc");
    command
        .arg("-std=gnu11")
        .args(&right.compile)
        .arg(here("engine.c"));
    command.args(["-lm", "-o"]).arg(&program);
    let done = command.output().expect("a C compiler");
    assert!(
        done.status.success(),
        "{}: {}",
        right.name,
        String::from_utf8_lossy(&done.stderr)
    );
    program
}

fn judged(reference: &Reference, program: PathBuf) -> Judgement {
    let options = Options::new(program);
    let engine = exec::describe(&options).expect("a description");
    from_bed(reference, &engine, &options, &mut |_| ()).unwrap_or_else(|_| panic!("{options:?}"))
}

/// What the sentence must say for a cause.
fn named(cause: &str, factor: Option<f64>) -> Vec<String> {
    let times = |symbols: &[&str]| -> Vec<String> {
        let factor = factor.unwrap_or(1.0);
        symbols
            .iter()
            .map(|symbol| format!("{symbol} × {factor:.9}"))
            .collect()
    };
    match cause {
        "k_n" => times(&["k_n"]),
        "k_n_grain" => times(&["k_n between grains"]),
        "k_n_wall" => times(&["k_n at walls"]),
        "k_n_punch" => times(&["k_n at the punch"]),
        "k_n_flat" => times(&["k_n at walls", "k_n at the punch"]),
        "k_s" => times(&["k_s"]),
        "modulus" => times(&["k_n", "k_s"]),
        "tan_phi" if factor.is_none() => vec!["tan φ ×".into()],
        "tan_phi" => times(&["tan φ"]),
        "alpha" => times(&["α"]),
        "gravity" => times(&["g_z"]),
        "gravity_x" => vec![format!("g_x = {:.3e}", factor.unwrap_or(0.0))],
        "dt" => times(&["Δt"]),
        "mass" => times(&["mass"]),
        "density" => times(&["mass", "moment of inertia"]),
        "inertia" => times(&["moment of inertia"]),
        "c_n" => times(&["c_n"]),
        "radius" => times(&["radius"]),
        other => vec![other.to_owned()],
    }
}

#[test]
fn look() {
    let corpus: Corpus =
        serde_json::from_str(&fs::read_to_string(here("corpus.json")).expect("a corpus"))
            .expect("JSON");
    let folder = tempfile::tempdir().expect("a folder");
    let reference = Reference::new(1000, &mut |_| ()).expect("a bed");
    let only = std::env::var("ONLY").unwrap_or_default();
    for right in &corpus.right {
        if !right.name.contains(&only) && right.name != "plain" {
            continue;
        }
        let t = std::time::Instant::now();
        let of = judged(&reference, compiled(folder.path(), right));
        let ratio = of
            .farthest()
            .and_then(|of| of.farthest.as_ref())
            .map_or(0.0, |of| of.ratio);
        println!(
            "{:24} {:?} {ratio:.2} {} {} {:?}",
            right.name,
            of.verdict(),
            of.resolution.name(),
            right.precision,
            t.elapsed()
        );
    }
    for wrong in &corpus.wrong {
        if !wrong.name.contains(&only) {
            continue;
        }
        let t = std::time::Instant::now();
        let script = format!(
            "#!/bin/sh\nFAULT='{}' exec {}/plain \"$@\"\n",
            wrong.fault,
            folder.path().display()
        );
        let engine = program(folder.path(), &format!("{}.sh", wrong.name), &script);
        let of = judged(&reference, engine);
        let said: Vec<String> = of.causes.iter().map(|of| of.sentence()).collect();
        let said = said.join(" ");
        let right = named(&wrong.cause, wrong.factor)
            .iter()
            .all(|part| said.contains(part.as_str()));
        let explained = of.causes.iter().all(|of| of.explained);
        println!(
            "{} {:24} {:?} {explained} {:?} | {said}",
            if right { "ok " } else { "???" },
            wrong.name,
            of.verdict(),
            t.elapsed()
        );
        let _ = Verdict::Different;
    }
}
