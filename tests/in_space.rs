//! What is not judged of spheres in space is refused or said.

use crossgrain::run::continued::Continued;
use verdict::envelope::Resolution;

use crate::support::*;

/// A few of the example's spheres.
fn folder_in_space() -> Place {
    let folder = new_folder();
    let text =
        text_of(root("examples/poured-spheres.json")).replace("\"count\": 800", "\"count\": 60");
    fs::write(folder.join("scene.json"), text).expect("writable");
    folder
}

#[test]
fn what_judges_the_plane_alone_refuses_scenes_in_space() {
    let folder = &folder_in_space();
    let commands = [
        "reproduce --scene scene.json --out job".to_owned(),
        "study plan campaign scene.json --members 2 --out campaign".to_owned(),
    ];
    for command in commands {
        let (_, errors) = ends(folder, 2, &command.words());
        has(&errors, ["it is in space (box.depth)"]);
    }
}

#[test]
fn runs_in_space_agree_by_their_bits_contacts_across_included() {
    let folder = &folder_in_space();
    for (out, more) in [("a", ""), ("b", ""), ("c", " --perturb stiffness=1e-12")] {
        let run = format!("run scene.json --engine native --steps 1500 --quiet --out {out}{more}");
        ends(folder, 0, &run.words());
    }
    let (text, _) = ends(folder, 0, &"compare a b --quiet".words());
    has(&text, ["Identical", "contacts across"]);
    ends(folder, 1, &"compare a c --quiet".words());
}

/// Judged by an engine that was written from the documents: what contacts remember is taken from their tables, and where it is lost late in
/// the run no first steps show it.
#[test]
fn runs_of_spheres_with_friction_and_dashpots_are_followed() {
    let folder = &folder_in_space();
    let path = folder.join("scene.json");
    let mut scene = json_of(&path);
    scene["measurement"]["history_every"] = 100.into();
    fs::write(&path, scene.to_string()).expect("writable");
    let mut compile = Command::new("cc");
    compile
        .args(["-std=gnu11", "-O2"])
        .arg(root("tests/corpus/spheres.c"))
        .args(["-lm", "-o"])
        .arg(folder.join("spheres"));
    assert!(compile.status().expect("a C compiler").success());
    let run = "run scene.json --engine native --steps 6000 --quiet --out native";
    ends(folder, 0, &run.words());
    for (name, fault, code, found) in [
        ("right", "", 0, "stretches-b"),
        ("forgets", "history_reset", 1, "from step 0 to 100"),
        (
            "forgets-late",
            "history_late=3000",
            1,
            "from step 3000 to 3100",
        ),
    ] {
        let script = format!(
            "#!/bin/sh\nFAULT='{fault}' exec {} \"$@\"\n",
            folder.join("spheres").display()
        );
        let engine = engine(folder, &format!("{name}.sh"), &script);
        let run = format!("run scene.json --engine {engine} --steps 6000 --quiet --out {name}");
        ends(folder, 0, &run.words());
        let followed = RunFolder::read(&folder.join(name))
            .expect("a run")
            .record
            .continued;
        let double = |of: &Continued| of.is_rounding(Resolution::DOUBLE);
        assert!(
            followed.len() == 1 && double(&followed[0]) || code == 1,
            "{followed:?}"
        );
        let last = followed.last().expect("a stretch");
        assert_eq!((followed[0].from, last.to), (0, 6000), "{followed:?}");
        let (text, _) = ends(
            folder,
            code,
            &format!("compare native {name} --quiet").words(),
        );
        has(&text, [["AGREED", "DIFFERENT"][usize::from(code == 1)]]);
        if code == 1 {
            has(&text, ["compare/stretches-b", found]);
        }
    }
    // Moments are in no table.
    scene["contact"]["rolling"] = json!({"bending_stiffness": 0.5, "twisting_stiffness": 0.3});
    fs::write(&path, scene.to_string()).expect("writable");
    let run = format!(
        "run scene.json --engine exec:{} --steps 300 --quiet --out moments",
        folder.join("right.sh").display()
    );
    ends(folder, 0, &run.words());
    assert!(
        RunFolder::read(&folder.join("moments"))
            .expect("a run")
            .record
            .continued
            .is_empty()
    );
}
