//! What is not judged of spheres in space is refused or said.

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
