//! LAMMPS and LIGGGHTS through their adapters. Without the feature `exec-engines` these are listed as ignored and not made;
//! with it a missing one is a failure.

use std::fs;
use std::path::Path;

use crossgrain::folder::RunFolder;

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

/// The run folders of both adapters, whose names begin so.
fn agree_to_the_bit(folder: &Path, begin: &str) {
    let [one, other] = ADAPTERS.map(|name| format!("{begin}{name}"));
    let compare = ["compare", &one, &other, "--expect-bits"];
    let (code, text, errors) = told(&crossgrain(&compare, folder));
    assert_eq!(code, 0, "{text}{errors}");
}

#[test]
#[cfg_attr(
    not(feature = "exec-engines"),
    ignore = "needs LAMMPS and LIGGGHTS: --features exec-engines"
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

#[test]
#[cfg_attr(
    not(feature = "exec-engines"),
    ignore = "needs LAMMPS and LIGGGHTS: --features exec-engines"
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
    not(feature = "exec-engines"),
    ignore = "needs LAMMPS and LIGGGHTS: --features exec-engines"
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
