//! Engines that people bring: the toy has the native engine's bits, each way in which a program can be broken is its own
//! message and leaves no run folder, and `engine check` says what is wrong. Needs a Python and nothing else.

mod broken;
mod check;
mod hostile;
mod house;

use grains::scene::Damping;

use crate::support::*;

#[test]
fn the_toy_has_every_bit_of_the_native_engine() {
    let folder = &folder_with(&narrow_scene(0.05));
    let toy = adapter("toy.py");
    for (engine, out) in [("native", "native"), (toy.as_str(), "toy")] {
        ran_in(folder, engine, &["--steps", "1200"], out);
    }
    ends(folder, 0, "compare native toy --expect-bits");
    tells(folder, 0, "compare native toy", ["AGREED: Identical"]);
    let record = text_of(folder.join("toy/run.json"));
    assert!(record.contains(r#""name": "toy""#) && record.contains(r#""kernel": null"#));
}

/// A toy that does something else from step 137 on, if only by a billionth.
#[test]
fn the_first_difference_is_found_by_running_an_external_engine_again() {
    let folder = &folder_with(&narrow_scene(0.05));
    let later = "+= dt * a * (1.0 + 1e-9 * (step == 137))\n";
    let toy = changed_toy("+= dt * a\n", later);
    let other = engine(folder, "other.py", &toy);
    for (engine, out) in [("native", "native"), (other.as_str(), "other")] {
        ran_in(folder, engine, &["--steps", "400"], out);
    }
    let unchanged = adapter("toy.py");
    for (engine, message) in [
        (None, "name toy with --engine exec:PATH"),
        (Some(&unchanged), "they have other bytes"),
        (Some(&other), "step 137 of stage settle"),
    ] {
        let mut compare = vec!["compare", "native", "other", "--expect-bits"];
        compare.extend(engine.iter().flat_map(|engine| ["--engine", engine]));
        let (text, _) = ends(folder, 1, &compare);
        assert!(text.contains(message), "«{message}» is missing: {text}");
    }
}

/// What a program imports from its own folder is part of it, and what that imports too.
#[test]
fn a_module_beside_the_program_counts_as_the_program() {
    let folder = &folder_with(&narrow_scene(0.05));
    let toy = changed_toy("import csv, json,", "import csv, middle, json,");
    let toy = toy.replace("+= dt * a\n", "+= dt * a * middle.k\n");
    let other = engine(folder, "other.py", &toy);
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).expect("ours");
    write("middle.py", "from deep import k\n");
    write("deep.py", "k = 1.0 + 1e-9\n");
    for (engine, out) in [("native", "native"), (other.as_str(), "other")] {
        ran_in(folder, engine, &["--steps", "2"], out);
    }
    let compare = format!("compare native other --expect-bits --engine {other}");
    has(&say(folder, &compare).1, ["step 1 of stage settle"]);
    write("deep.py", "k = 1.0 + 2e-9\n");
    has(&say(folder, &compare).1, ["they have other bytes"]);
}

/// A package, a library and any other file beside a program are part of it where its text names them; no link is followed.
#[test]
fn what_a_program_names_beside_it_counts_as_the_program() {
    use crossgrain::engine::exec::{covered, program_digest};
    let place = &new_folder();
    let folder = &place.join("own");
    fs::create_dir_all(folder.join("package/deep/__pycache__")).expect("a new folder");
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).expect("ours");
    write("../elsewhere.json", "0");
    std::os::unix::fs::symlink("../elsewhere.json", folder.join("linked.json")).expect("ours");
    let text = "#!/usr/bin/env python3\nimport package.deep, fast\n# linked.json job.json\n\
                k = open(here + '/params.json'); run('./solver')\n";
    let engine = &program(folder, "engine.py", text);
    let files = [
        ("package/deep/law.py", true),
        ("fast.cpython-311.so", true),
        ("params.json", true),
        ("solver", true),
        ("package/deep/__pycache__/law.py", false),
        ("package/notes.txt", false),
        ("env", false),
        ("job.json", false),
        ("python3.py", false),
        ("../elsewhere.json", false),
    ];
    files.iter().for_each(|(name, _)| write(name, "1"));
    let digest = || program_digest(engine).expect("a digest");
    for (name, counts) in files {
        let before = digest();
        write(name, "2");
        assert_eq!(digest() != before, counts, "{name}");
    }
    has(
        &covered(engine).expect("a sentence"),
        ["the digest covers engine.py and 4 files beside it; what it loads from elsewhere"],
    );
    let large = fs::File::create(folder.join("params.json")).expect("ours");
    large.set_len(65 << 20).expect("a hole");
    has(
        &covered(engine).expect("a sentence"),
        ["are too many or too large"],
    );
    let alone = &program(folder, "alone", "nothing\n");
    assert_eq!(
        program_digest(alone).expect("a digest"),
        crossgrain::files::file_digest(alone).expect("a digest")
    );
}

#[test]
fn what_an_engine_does_not_have_is_not_asked_of_it() {
    let mut scene = narrow_scene(0.05);
    scene.loading.damping = Some(Damping::Cundall { alpha: 0.5 });
    let folder = &folder_with(&scene);
    let mut rough = scene.clone();
    rough.material.wall_friction_angle = Some(0.3);
    let own = "friction of its own at walls and punch (wall_friction)";
    let errors = run_in(
        &folder_with(&rough),
        2,
        &adapter("esysparticle.py"),
        &[],
        "out",
    );
    has(&errors, [own]);
    // A result of before stays where it is, and a campaign is not planned.
    fs::create_dir(folder.join("before")).expect("a new folder");
    fs::write(folder.join("before/run.json"), "{}").expect("can be written");
    run_in(folder, 2, "exec:no-such-engine", &[], "before");
    assert!(folder.join("before/run.json").exists() && !folder.join("before-2").exists());
    let plan = "study plan campaign scene.json --members 2 --out c --engine";
    let (_, errors) = ends(folder, 2, &format!("{plan} {}", adapter("toy.py")));
    has(&errors, ["stop_rules"]);
    assert!(!folder.join("c").exists());
    let toy = adapter("toy.py");
    let stages = "constants of its own for loading (stages)";
    for (more, missing) in [
        (None, "punch (punch)"),
        (Some("settled"), "stop_rules"),
        (None, stages),
    ] {
        let more: Vec<&str> = more.iter().flat_map(|until| ["--until", until]).collect();
        let errors = run_in(folder, 2, &toy, &more, "out");
        has(&errors, ["toy has no", missing]);
        assert!(!folder.join("out").exists());
    }
}
