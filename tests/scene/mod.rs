//! Scenes: what is accepted, what is refused, and that the message says where and what.

use std::fs;
use std::path::{Path, PathBuf};

use grains::scene::{OPEN_CHOICES, Scene, SceneError, json_schema, paper_scene, parse_scene};

use crate::support::{crossgrain, told};

fn inputs(kind: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/scene")
        .join(kind);
    let mut files: Vec<PathBuf> = fs::read_dir(folder)
        .expect("the inputs are there")
        .map(|entry| entry.expect("a readable folder").path())
        .filter(|path| path.extension().is_some_and(|end| end == "json"))
        .collect();
    files.sort();
    files
}

#[test]
fn every_good_scene_is_accepted() {
    let files = inputs("good");
    assert!(files.len() >= 2);
    for file in files {
        let (code, _, errors) = told(&crossgrain(
            &["scene", "check", &file.to_string_lossy()],
            Path::new("."),
        ));
        assert_eq!(code, 0, "{}: {errors}", file.display());
    }
}

/// Beside each bad scene stands a text file with every line that the message must have.
#[test]
fn every_bad_scene_is_refused_with_its_messages() {
    let files = inputs("bad");
    assert!(files.len() >= 10);
    for file in files {
        let (code, _, errors) = told(&crossgrain(
            &["scene", "check", &file.to_string_lossy()],
            Path::new("."),
        ));
        assert_eq!(code, 2, "{}: {errors}", file.display());
        let expected = fs::read_to_string(file.with_extension("txt")).expect("the messages");
        for line in expected.lines() {
            assert!(
                errors.contains(line),
                "{}: «{line}» is missing in\n{errors}",
                file.display()
            );
        }
    }
}

#[test]
fn the_papers_scene_reads_back_and_names_every_open_choice() {
    let scene = paper_scene(7, 5000);
    let text = serde_json::to_string_pretty(&scene).expect("JSON");
    assert_eq!(parse_scene(&text).expect("a valid scene"), scene);
    for (key, _) in OPEN_CHOICES {
        assert!(
            scene.choices.contains_key(*key),
            "{key} has no reason in the scene"
        );
    }
}

#[test]
fn the_digest_follows_physics_and_not_words() {
    let scene = paper_scene(1, 5000);
    let mut renamed = scene.clone();
    renamed.name = "other".to_owned();
    renamed
        .choices
        .insert("/damping".to_owned(), "because".to_owned());
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
    value["material"]
        .as_object_mut()
        .expect("an object")
        .remove("density");
    let Err(SceneError::Problems(problems)) = parse_scene(&value.to_string()) else {
        panic!("four problems were expected");
    };
    let places: Vec<&str> = problems.iter().map(|p| p.place.as_str()).collect();
    for place in [
        "/particles/count",
        "/damping/kind",
        "/colour",
        "/material/density",
    ] {
        assert!(places.contains(&place), "{place} is not among {places:?}");
    }
    assert_eq!(problems.len(), 4, "{problems:?}");
}

#[test]
fn the_schema_in_the_documentation_is_the_one_of_the_types() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/scene.schema.json");
    let text = fs::read_to_string(path).expect("docs/scene.schema.json");
    let written: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(
        written,
        json_schema(),
        "write it anew: crossgrain scene schema > docs/scene.schema.json"
    );
}

#[test]
fn a_file_that_is_far_too_large_is_not_read() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("huge.json");
    fs::write(&path, vec![b' '; 2 << 20]).expect("a writable folder");
    let (code, _, errors) = told(&crossgrain(&["scene", "check", "huge.json"], folder.path()));
    assert_eq!(code, 2);
    assert!(errors.contains("larger than"), "{errors}");
}

proptest::proptest! {
    /// Cut or changed anywhere, a scene is refused or read, never a panic.
    #[test]
    fn mangled_text_never_panics(cut in 0usize..3000, place in 0usize..3000, byte in 0u8..128) {
        let text = serde_json::to_string_pretty(&paper_scene(1, 10)).expect("JSON");
        let mut bytes = text.into_bytes();
        let at = place % bytes.len();
        bytes[at] = byte;
        bytes.truncate(bytes.len() - cut % bytes.len());
        if let Ok(text) = String::from_utf8(bytes) {
            let read: Result<Scene, SceneError> = parse_scene(&text);
            if let Err(error) = read {
                proptest::prop_assert!(!error.to_string().is_empty());
            }
        }
    }
}
