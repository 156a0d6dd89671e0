//! LAMMPS and LIGGGHTS through their adapters. Without the feature `live` these are listed as ignored and not made;
//! with it a missing one is a failure.

use std::fs;
use std::path::Path;

use crossgrain::engine::exec::{self, ExternalEngine, Options};
use crossgrain::run::folder::RunFolder;
use grains::generate::initial_bodies;
use grains::model::Model;
use grains::native::{first_contact_punch, run_case};
use grains::tables::{Bodies, Snapshot};
use grains::task::Case;
use tempfile::tempdir;

use crate::support::engines::{adapter, adapter_path, narrow_scene, ran_in};
use crate::support::{crossgrain, folder_with, told};

const ADAPTERS: [&str; 2] = ["lammps.py", "liggghts.py"];

/// Largest distance of a grain from where the other bed has it, over its radius.
fn farthest(one: &Bodies, other: &Bodies) -> f64 {
    let distance = |id: usize| (one.x[id] - other.x[id]).hypot(one.z[id] - other.z[id]);
    let in_radii = (0..one.len()).map(|id| distance(id) / one.radius[id]);
    in_radii.fold(0.0, f64::max)
}

/// The same at the end of two runs.
fn apart(folder: &Path, a: &str, b: &str) -> f64 {
    let read = |name: &str| RunFolder::read(&folder.join(name)).expect("a run folder");
    farthest(&read(a).last.bodies, &read(b).last.bodies)
}

/// The forces of walls on grains at the end, by the ids of both.
fn wall_forces(folder: &Path, out: &str) -> Vec<f64> {
    let run = RunFolder::read(&folder.join(out)).expect("a run folder");
    let grains = run.last.bodies.len() as u32;
    let contacts = run.last.contacts.iter();
    let of_walls = contacts.filter(|contact| contact.id1 >= grains);
    of_walls.map(|contact| contact.normal_force).collect()
}

/// The run folders of both adapters, whose names begin so.
fn agree_to_the_bit(folder: &Path, begin: &str) {
    let [one, other] = ADAPTERS.map(|name| format!("{begin}{name}"));
    let compare = ["compare", &one, &other, "--expect-bits"];
    let (code, text, errors) = told(&crossgrain(&compare, folder));
    assert_eq!(code, 0, "{text}{errors}");
}

#[test]
#[cfg_attr(
    not(feature = "live"),
    ignore = "needs LAMMPS and LIGGGHTS: --features live"
)]
fn with_one_radius_both_are_native_up_to_rounding_and_each_other_to_the_bit() {
    let (folder, _) = folder_with(&narrow_scene(0.0));
    ran_in(folder.path(), "native", &["--steps", "500"], "native");
    for name in ADAPTERS {
        ran_in(folder.path(), &adapter(name), &["--steps", "500"], name);
        let apart = apart(folder.path(), "native", name);
        assert!(apart > 0.0 && apart < 1.0e-8, "{name}: {apart:e} R");
    }
    for name in ADAPTERS {
        let out = format!("long-{name}");
        ran_in(folder.path(), &adapter(name), &["--steps", "6000"], &out);
    }
    agree_to_the_bit(folder.path(), "long-");
}

/// The programs tell no forces of walls, so the adapters write those of the law; that the programs mean the same is seen by
/// where the grains are that have met a wall.
#[test]
#[cfg_attr(
    not(feature = "live"),
    ignore = "needs LAMMPS and LIGGGHTS: --features live"
)]
fn walls_push_as_the_native_ones_do() {
    let mut scene = narrow_scene(0.0);
    scene.particles.count = 12;
    let (folder, _) = folder_with(&scene);
    ran_in(folder.path(), "native", &["--steps", "1500"], "native");
    for name in ADAPTERS {
        ran_in(folder.path(), &adapter(name), &["--steps", "1500"], name);
        let apart = apart(folder.path(), "native", name);
        assert!(apart < 1.0e-8, "{name}: {apart:e} R");
        let [native, theirs] = ["native", name].map(|out| wall_forces(folder.path(), out));
        assert!(!native.is_empty() && native.len() == theirs.len());
        for (force, wanted) in theirs.iter().zip(&native) {
            let off = (force / wanted - 1.0).abs();
            assert!(
                off < 1.0e-6,
                "{name}: {force} N on a wall, and native has {wanted} N"
            );
        }
    }
}

/// From one bed, before anything has grown: one that differs in last bits is 2e-13 R off after 10 steps, 1e-12 after 30 and
/// 1e-10 after 100; a stiffness wrong by 1e-9 is 1e-12 R off after 10.
#[test]
#[cfg_attr(
    not(feature = "live"),
    ignore = "needs LAMMPS and LIGGGHTS: --features live"
)]
fn under_the_punch_both_are_native_up_to_rounding() {
    let mut scene = narrow_scene(0.0);
    scene.loading.speed = 2.0;
    let mut bed = Case {
        name: "press".to_owned(),
        model: Model::of(&scene),
        bodies: initial_bodies(&scene),
        punch: None,
        moments: vec![12_000],
    };
    bed.bodies = run_case(&bed, None).expect("a bed").remove(0).bodies;
    bed.punch = Some(first_contact_punch(&scene, &bed.bodies));
    bed.moments = vec![0, 10, 30, 100];
    let native = run_case(&bed, None).expect("a press");
    let force = |moment: &Snapshot| moment.punch.map_or(0.0, |punch| punch.force);
    assert!(force(&native[3]) > 0.0, "the punch presses on nothing");
    for name in ADAPTERS {
        let engine = ExternalEngine::ask(Options::new(adapter_path(name))).expect("an engine");
        let work = tempdir().expect("a folder");
        let cases = exec::run_cases(
            &[&bed],
            &engine.description,
            &engine.options,
            work.path(),
            &mut (),
        );
        let theirs = cases.expect("an answer").remove(0).expect("a press");
        for ((their, own), allowed) in theirs.iter().zip(&native).zip([0.0, 2e-13, 1e-12, 1e-10]) {
            let apart = farthest(&own.bodies, &their.bodies);
            assert!(apart <= allowed, "{name}, {}: {apart:e} R", own.step);
            let off = (force(their) - force(own)).abs();
            assert!(off <= 1e-6 * force(own), "{name}, {}: {off} N", own.step);
        }
    }
}

#[test]
#[cfg_attr(
    not(feature = "live"),
    ignore = "needs LAMMPS and LIGGGHTS: --features live"
)]
fn with_many_radii_both_have_classes_of_them_and_say_so() {
    let (folder, _) = folder_with(&narrow_scene(0.05));
    for name in ADAPTERS {
        ran_in(folder.path(), &adapter(name), &[], name);
        let record =
            fs::read_to_string(folder.path().join(name).join("run.json")).expect("a record");
        assert!(record.contains("classes of radius"), "{record}");
    }
    agree_to_the_bit(folder.path(), "");
}

#[test]
#[cfg_attr(
    not(feature = "live"),
    ignore = "needs LAMMPS and LIGGGHTS: --features live"
)]
fn engine_check_finds_both_sound() {
    let (folder, _) = folder_with(&narrow_scene(0.0));
    for name in ADAPTERS {
        let (code, text, errors) = told(&crossgrain(
            &["engine", "check", &adapter(name), "--quiet"],
            folder.path(),
        ));
        assert_eq!(code, 0, "{text}{errors}");
    }
}
