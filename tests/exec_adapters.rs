//! LAMMPS and LIGGGHTS through their adapters. Without the feature `live` these are listed as ignored and not made;
//! with it a missing one is a failure.

use std::fs;
use std::path::Path;

use crossgrain::run::folder::RunFolder;

use crate::support::engines::{adapter, narrow_scene, ran_in};
use crate::support::{crossgrain, folder_with, told};

const ADAPTERS: [&str; 2] = ["lammps.py", "liggghts.py"];

/// Largest displacement over the mean radius at the end.
fn apart(folder: &Path, a: &str, b: &str) -> f64 {
    let read = |name: &str| RunFolder::read(&folder.join(name)).expect("a run folder");
    let (a, b) = (read(a), read(b));
    let radius = 0.5 * a.scene.particles.mean_diameter;
    let (one, other) = (&a.last.bodies, &b.last.bodies);
    let distance = |id: usize| (one.x[id] - other.x[id]).hypot(one.z[id] - other.z[id]);
    (0..one.len()).map(distance).fold(0.0, f64::max) / radius
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

#[test]
#[cfg_attr(
    not(feature = "live"),
    ignore = "needs LAMMPS and LIGGGHTS: --features live"
)]
fn with_many_radii_both_have_classes_of_them_and_say_so() {
    let (folder, _) = folder_with(&narrow_scene(0.05));
    for name in ADAPTERS {
        ran_in(folder.path(), &adapter(name), &["--until", "settled"], name);
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
