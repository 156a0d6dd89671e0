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

/// The example with these keys more.
fn with(folder: &Path, more: &str) {
    let scene =
        text_of(root("examples/poured-spheres.json")).replace("\"count\": 800", "\"count\": 60");
    let text = scene.replacen('{', &format!("{{ {more},"), 1);
    fs::write(folder.join("scene.json"), text).expect("writable");
}

const MESH: &str = r#""meshes": [{ "path": "floor.stl", "scale": 0.001, "shift": [0, 0, 0.01] }]"#;

fn binary_stl(triangles: &[[f32; 9]]) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes[..6].copy_from_slice(b"solid ");
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        triangle
            .iter()
            .for_each(|part| bytes.extend(part.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

const FLOOR: [[f32; 9]; 2] = [
    [0.0, 0.0, 0.0, 100.0, 0.0, 5.0, 0.0, 100.0, 0.0],
    [100.0, 100.0, 5.0, 0.0, 100.0, 0.0, 100.0, 0.0, 5.0],
];

#[test]
fn a_scene_has_the_triangles_of_its_stl_file_and_spheres_lie_on_them() {
    let folder = &new_folder();
    with(folder, MESH);
    let mut text = "solid floor\n".to_owned();
    for t in FLOOR {
        text += "facet normal 0 0 0\nouter loop\n";
        t.chunks(3)
            .for_each(|v| text += &format!("vertex {} {} {}\n", v[0], v[1], v[2]));
        text += "endloop\nendfacet\n";
    }
    text += "endsolid floor\n";
    let floor = folder.join("floor.stl");
    fs::write(&floor, text).expect("writable");
    let (as_text, _) = ends(folder, 0, "scene model scene.json");
    fs::write(&floor, binary_stl(&FLOOR)).expect("writable");
    let (as_bytes, _) = ends(folder, 0, "scene model scene.json");
    assert_eq!(as_text, as_bytes);
    has(&as_text, ["obstacles", "triangle", "0.015"]);
    let run = "run scene.json --engine native --steps 6000 --quiet --out o";
    ends(folder, 0, run);
    // The run has the triangles in itself.
    fs::remove_file(&floor).expect("it is there");
    let run = read_run(folder.join("o"));
    assert_eq!(run.scene.obstacles.len(), 2);
    let (first, lowest) = (run.scene.particles.count + 5, 0.0101);
    assert!(run.last.contacts.iter().any(|contact| contact.id1 >= first));
    assert!(run.last.bodies.z.iter().all(|z| *z > lowest));
    ends(folder, 0, "compare o o --quiet");
}

#[test]
fn stl_files_that_cannot_be_meant_are_refused_with_the_reason() {
    let folder = &new_folder();
    with(folder, MESH);
    let whole = binary_stl(&FLOOR);
    let nan = binary_stl(&[[f32::NAN; 9]]);
    let flat = binary_stl(&[[1.0; 9]]);
    let line = binary_stl(&[[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 3.0, 3.0, 3.0]]);
    let many = binary_stl(&vec![FLOOR[0]; 5_001]);
    let text = b"solid a\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n";
    let files: [(&[u8], &str); 9] = [
        (&[], "an STL file"),
        (&whole[..100], "a whole STL file"),
        (&whole[6..], "an STL file"),
        (&nan, "finite numbers"),
        (&flat, "a triangle with an area"),
        (&line, "a triangle with an area"),
        (&many, "at most 5000 triangles"),
        (&binary_stl(&[]), "a file with triangles"),
        (text, "a whole STL file"),
    ];
    for (bytes, reason) in files {
        fs::write(folder.join("floor.stl"), bytes).expect("writable");
        let (_, errors) = ends(folder, 2, "scene model scene.json");
        has(&errors, [reason]);
    }
    fs::remove_file(folder.join("floor.stl")).expect("it is there");
    let (_, errors) = ends(folder, 2, "scene model scene.json");
    has(&errors, ["a file that can be read"]);
}

#[test]
fn obstacles_that_cannot_be_meant_are_refused_with_the_reason() {
    let folder = &new_folder();
    let plane = |normal: &str| {
        format!(r#""shape": {{ "kind": "plane", "point": [0, 0, 0.01], "normal": {normal} }}"#)
    };
    let body = |half: &str| {
        format!(
            r#""shape": {{ "kind": "box", "centre": [0.05, 0.05, 0], "half_extents": {half} }}"#
        )
    };
    let (good, moving) = (plane("[0.6, 0, 0.8]"), r#""velocity": [0, 0, 1]"#);
    for (obstacle, reason) in [
        (plane("[1, 0, 1]"), "a normal of length 1"),
        (plane("[1, 0, 0]"), "less steep"),
        (body("[0.1, 0, 0.1]"), "half extents above 0"),
        (format!("{good}, {moving}"), "only the punch moves"),
    ] {
        with(folder, &format!(r#""obstacles": [{{ {obstacle} }}]"#));
        let (_, errors) = ends(folder, 2, "scene model scene.json");
        has(&errors, ["/obstacles/0", reason]);
    }
    with(folder, &format!(r#""obstacles": [{{ {good} }}]"#));
    ends(folder, 0, "scene model scene.json");
    let scene = crossgrain::run::folder::read_scene(&folder.join("scene.json")).expect("a scene");
    let lacks = crossgrain::engine::yade::lacking(&scene).expect("YADE has none");
    has(&lacks, ["planes of any direction"]);
    let plane = text_of(folder.join("scene.json")).replace("\"depth\": 0.1", "\"width\": 0.1");
    let flat = plane.replace("\"width\": 0.1, \"width\": 0.1", "\"width\": 0.1");
    fs::write(folder.join("scene.json"), flat).expect("writable");
    let (_, errors) = ends(folder, 2, "scene model scene.json");
    has(&errors, ["left out in the plane"]);
}
