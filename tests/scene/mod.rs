//! Scenes: what is accepted, what is refused, and that the message says where and what.

use grains::scene::{Cloud, SceneError, json_schema, open_choices};

use crate::support::*;

/// What `scene check` complains of in each scene of a folder, which ends with this exit code.
fn checked(folder: &str, code: i32) -> BTreeMap<PathBuf, String> {
    let folder = root(folder);
    let names = there(&folder).into_iter();
    let files = names.filter(|name| name.ends_with(".json"));
    let checked = files.map(|file| {
        let (_, errors) = ends(&folder, code, &["scene", "check", &file]);
        (folder.join(file), errors)
    });
    checked.collect()
}

#[test]
fn every_good_scene_is_accepted() {
    assert!(checked("tests/scene/good", 0).len() + checked("examples", 0).len() >= 5);
}

/// Beside each bad scene stands a text file with every line that the message must have.
#[test]
fn every_bad_scene_is_refused_with_its_messages() {
    let all = checked("tests/scene/bad", 2);
    assert!(all.len() >= 10);
    for (file, errors) in all {
        for line in text_of(file.with_extension("txt")).lines() {
            has(&errors, [line]);
        }
        // A wrong width makes much else impossible, and stands alone.
        if file.ends_with("width_negative.json") {
            assert_eq!(errors.lines().count(), 2, "{errors}");
        }
    }
}

#[test]
fn the_papers_scene_reads_back_and_names_every_open_choice() {
    let scene = paper_scene(7, 5000);
    let text = serde_json::to_string_pretty(&scene).expect("JSON");
    assert_eq!(parse_scene(&text).expect("a valid scene"), scene);
    assert_eq!(open_choices().count(), 16);
    for key in open_choices() {
        let reason = scene.choices.contains_key(key);
        assert!(reason, "{key} has no reason in the scene");
    }
}

#[test]
fn the_digest_follows_physics_and_not_words() {
    let scene = paper_scene(1, 5000);
    let mut renamed = scene.clone();
    renamed.name = "other".to_owned();
    let (place, why) = ("/damping".to_owned(), "because".to_owned());
    renamed.choices.insert(place, why);
    assert_eq!(scene.digest(), renamed.digest());
    let mut faster = scene.clone();
    faster.loading.speed *= 1.0 + f64::EPSILON;
    assert_ne!(scene.digest(), faster.digest());
}

#[test]
fn one_message_lists_problems_of_structure_together() {
    let mut value = serde_json::to_value(paper_scene(1, 10)).expect("JSON");
    value["particles"]["count"] = "many".into();
    value["damping"]["kind"] = "oil".into();
    value["colour"] = "red".into();
    let particles = value["particles"].as_object_mut().expect("an object");
    particles.remove("mean_diameter");
    let Err(SceneError::Problems(problems)) = parse_scene(&value.to_string()) else {
        panic!("four problems were expected");
    };
    let places: Vec<&str> = problems.iter().map(|p| p.place.as_str()).collect();
    for place in "/particles/count /damping/kind /colour /particles/mean_diameter".words() {
        assert!(places.contains(&place), "{place} is not among {places:?}");
    }
    assert_eq!(problems.len(), 4, "{problems:?}");
}

#[test]
fn the_schema_in_the_documentation_is_the_one_of_the_types() {
    let written = json_of(root("docs/scene.schema.json"));
    assert_eq!(
        written,
        json_schema(),
        "write it anew: crossgrain scene schema > docs/scene.schema.json"
    );
}

/// What is written beside the grains and the box, and all that is said of it.
const WRONG: &str = r#"
    "contact": {"viscosity": {"kind": "dashpot", "cn": 3, "tension": "clipped"}, "colour": 3}, "gravity": -1 ⇒ /contact/colour; /contact/viscosity/c_n; /contact/viscosity/cn; /gravity: found -1, wanted at least 0
    "time_step": {"kind": "absolute", "seconds": 1} ⇒ /time_step/seconds: found 1.0, wanted a punch that moves at most 0.1 mean radii a step, of 1.0000e0 s
    "time_step": {"kind": "absolute", "seconds": 1}, "loading": {"speed": 0.2} ⇒ /time_step/seconds: found 1.0
    "loading": {"speed": 900000} ⇒ /loading/speed: found 900000.0, wanted a punch that moves at most 0.1 mean radii a step
    "box": {"width": 0.005} ⇒ /box/width: found 0.005, wanted room for the largest grain, 0.0105 m across
    "cloud": {"columns": 3, "over": [0.1, 0.105]} ⇒ /cloud/over: found [0.1, 0.105], wanted room for the largest grain
    "material": {"friction_angle": 30} ⇒ /material/friction_angle: found 30.0, wanted a number in [0, π/2) rad; 30 degrees are 0.5236 rad
    "material": {"friction_angle": 1000} ⇒ /material/friction_angle: found 1000.0, wanted a number in [0, π/2) rad
    "gravity": 1, "gravity": 2, "colour": 3, "damping": {"alpha": 2} ⇒ /colour; /damping/alpha; /gravity: found a key that was there already
    "box": {"width": "0.5"}, "material": {"friction_angle": 30}, "loading": {"material": {"youngs_modulus": "x", "density": 3}}, "control_points": [{"name": "O", "offset": 3, "depth": "a"}] ⇒ /box/width; /control_points/0/depth; /loading/material/density; /loading/material/youngs_modulus; /material/friction_angle
    "material": {"density": -1}, "loading": {"speed": 1e-30, "give_up_depth": 1.0} ⇒ /loading/give_up_depth; /material/density
    "particles": {"count": 4, "mean_diameter": 1e-155}, "cloud": {"columns": 2}, "control_points": [] ⇒ /box/width; /control_points; /particles/mean_diameter
"#;

#[test]
fn all_that_is_wrong_is_said_at_once_at_the_keys_that_were_written() {
    for [written, wanted] in rows(WRONG) {
        let mut given = r#""particles": {"count": 40, "mean_diameter": 0.01}"#.to_owned();
        if written.contains("particles") {
            given = r#""box": {"width": 0.5}"#.to_owned();
        } else if !written.contains("box") {
            given += r#", "box": {"width": 0.5}"#;
        }
        let Err(SceneError::Problems(found)) = parse_scene(&format!("{{{given}, {written}}}"))
        else {
            panic!("{written}");
        };
        let mut found: Vec<String> = found.iter().map(ToString::to_string).collect();
        let place = |problem: &String| problem.split_once(": /").expect("a line").1.to_owned();
        found = found
            .iter()
            .map(|problem| format!("/{}", place(problem)))
            .collect();
        found.sort();
        let is = |(found, wanted): (&String, &str)| found.starts_with(wanted);
        let wanted: Vec<&str> = wanted.split("; /").collect();
        let wanted = wanted.iter().map(|problem| problem.trim_start_matches('/'));
        let wanted: Vec<String> = wanted.map(|problem| format!("/{problem}")).collect();
        let all = found.iter().zip(wanted.iter().map(String::as_str)).all(is);
        assert!(all && found.len() == wanted.len(), "{written}: {found:#?}");
    }
}

proptest::proptest! {
    #[test]
    fn mangled_text_never_panics(cut in 0usize..3000, place in 0usize..3000, byte in 0u8..128) {
        let text = serde_json::to_string_pretty(&paper_scene(1, 10)).expect("JSON");
        let mut bytes = text.into_bytes();
        let at = place % bytes.len();
        bytes[at] = byte;
        bytes.truncate(bytes.len() - cut % bytes.len());
        let text = String::from_utf8(bytes).ok();
        let refused = text.and_then(|text| parse_scene(&text).err());
        proptest::prop_assert!(refused.is_none_or(|error| !error.to_string().is_empty()));
    }
}

/// What is left out is the paper's, with lengths in mean diameters; what is given stands, and a scene that says it all means the same.
#[test]
fn what_a_scene_leaves_out_has_a_default_that_its_record_states() {
    let given = r#"{"particles": {"count": 40, "mean_diameter": 0.004}, "box": {"width": 0.1}, "damping": {"alpha": 0.3},
        "time_step": {"kind": "absolute", "seconds": 1e-6}, "loading": {"speed": 0.02}}"#;
    let scene = parse_scene(given).expect("a scene");
    assert_eq!(scene.particles.count, 40);
    assert_eq!(scene.damping.alpha(), 0.3);
    assert_eq!(scene.time_step_seconds(), 1e-6);
    let paper = paper_scene(1, 40);
    assert_eq!(scene.material, paper.material);
    assert_eq!(scene.settle, paper.settle);
    assert_eq!(scene.loading.speed, 0.02);
    let lengths = |scene: &Scene| {
        let loading = &scene.loading;
        let measured = &scene.measurement;
        let [half_width, depth] = [loading.half_width, scene.control_points[0].depth];
        let volume = [measured.local_radius, measured.control_volume_side];
        let punch = [loading.punch_height, loading.give_up_depth];
        let lengths = [half_width, punch[0], punch[1], volume[0], volume[1], depth];
        lengths.map(|length| (1e6 * length / scene.particles.mean_diameter).round())
    };
    assert_eq!(lengths(&scene), lengths(&paper));
    let Cloud::JitteredLattice { columns, .. } = scene.cloud;
    assert_eq!(columns, 20);
    let whole = serde_json::to_string(&scene).expect("JSON");
    let read = parse_scene(&whole).expect("a scene");
    assert_eq!(read.digest(), scene.digest());
}

/// Of the constants of loading, what is left out is as in pouring; a scene without them keeps its digest.
#[test]
fn loading_has_the_constants_of_pouring_where_it_gives_no_others() {
    let text = text_of("examples/friction-after-pouring.json");
    let scene = parse_scene(&text).expect("a scene");
    let mut expected = scene.material.clone();
    assert_eq!(expected.friction_angle, 0.0);
    expected.friction_angle = 0.5;
    let loading = scene.in_stage(Stage::Load);
    assert_eq!(loading.material, expected);
    assert_eq!(loading.contact, scene.contact);
    assert_eq!(loading.damping, scene.damping);
    assert_eq!(loading.time_step_seconds(), scene.time_step_seconds());
    assert!(!loading.has_stages() && *scene.in_stage(Stage::Settle) == scene);
    let mut without = scene.clone();
    without.loading.material = None;
    assert_ne!(without.digest(), scene.digest());
    let loading = serde_json::to_string(&without.loading).expect("JSON");
    assert!(!loading.contains("material"));
}

#[test]
fn a_cloud_may_stand_over_a_part_of_the_box() {
    let text = text_of("examples/column-collapse.json");
    let bodies = initial_bodies(&parse_scene(&text).expect("a scene"));
    assert!(bodies.x.iter().all(|x| (0.0..=0.1).contains(x)));
    assert!(bodies.x.iter().any(|x| *x > 0.08));
}

/// Neither looking for a key given twice nor for lines takes longer than the file is long, many times over.
#[test]
fn very_many_unknown_keys_are_refused_in_time() {
    let keys: Vec<String> = (0..50_000).map(|key| format!("\"k{key}\": 0")).collect();
    let began = Instant::now();
    let refused = parse_scene(&format!("{{{}}}", keys.join(", ")));
    assert!(matches!(refused, Err(SceneError::Problems(problems)) if problems.len() > 50_000));
    assert!(began.elapsed().as_secs() < 60, "{:?}", began.elapsed());
}
