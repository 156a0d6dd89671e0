//! The same bits on another arithmetic: the program on processors that qemu computes in software, without vectors wider than
//! SSE2 and with AVX2, friction and the punch included. `ci/on_arm` does the same with the program built for ARM.

use crossgrain::limits::bench::{bed::Bed, timing};

use crate::support::*;

/// qemu's names of processors, and what the program finds in them.
const PROCESSORS: [(&str, &str); 2] = [("qemu64", "the plainest of its kind"), ("max", "AVX2")];

fn on(processor: &str, arguments: &[&str], folder: &Path) -> String {
    let output = Command::new("qemu-x86_64")
        .args(["-cpu", processor, env!("CARGO_BIN_EXE_crossgrain")])
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("Debian's package qemu-user is installed");
    let (code, out, error) = told(&output);
    assert_eq!(code, 0, "{processor}: {error}");
    out
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs qemu-user: --features live")]
fn processors_computed_in_software_give_the_same_bits() {
    let at = &new_folder();
    for (name, scene) in [("smooth", tiny_scene()), ("rough", frictional_scene())] {
        let file = format!("{name}.json");
        write_scene(&scene, &at.join(&file));
        let run = |out: &str| format!("run {file} --engine native --quiet --out {out}");
        ends(at, 0, &run(name));
        let here = read_run(at.join(name));
        assert_eq!(here.record.stages.len(), 2, "poured and loaded");
        for (processor, _) in PROCESSORS {
            let out = format!("{name}-{processor}");
            on(processor, &run(&out).words(), at);
            let there = read_run(at.join(&out));
            assert_eq!(there.last, here.last, "{name} on {processor}");
            assert_eq!(there.history, here.history, "{name} on {processor}");
        }
    }
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs qemu-user: --features live")]
fn each_of_them_takes_the_code_for_its_vectors() {
    let folder = &new_folder();
    let scene = tiny_scene();
    let bodies = grains::generate::initial_bodies(&scene);
    timing::write_bed(&Bed { scene, bodies }, folder).expect("a writable folder");
    for (processor, vectors) in PROCESSORS {
        let arguments = timing::arguments(folder, 8, 1);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let said = on(processor, &arguments, folder);
        assert!(said.contains(vectors), "{processor}: {said}");
    }
}
