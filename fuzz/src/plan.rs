//! Plans of campaigns. Where the input has a part `repair`, the plan has no digest and its scene's is put right.

use crossgrain::study::campaign::plan::{Plan, path};
use grains::scene::{Scene, parse_scene};

use super::parts::{self, Parts};

/// A plan that is accepted reads back as itself, and its version can be checked.
pub fn read(input: &[u8]) -> bool {
    let parts = Parts::of(input);
    let Some(bytes) = parts.get("plan.json") else {
        return false;
    };
    let folder = parts::folder();
    let repaired = parts.get("repair").and_then(|_| repair(bytes));
    let text = repaired.as_deref().unwrap_or(bytes);
    std::fs::write(path(folder.path()), text).expect("a writable folder");
    let Ok(plan) = Plan::read(folder.path()) else {
        return false;
    };
    // Either way: what counts is that it can be told.
    let _ = plan.check_version(folder.path());
    assert_eq!(plan.realization(plan.members), plan.seed + plan.members - 1);
    let again = folder.path().join("again");
    plan.write(&again).expect("a plan that can be written");
    assert_eq!(Plan::read(&again).expect("what was accepted once"), plan);
    true
}

fn repair(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut stored: serde_json::Value = serde_json::from_slice(bytes).ok()?;
    let object = stored.as_object_mut()?;
    object.shift_remove("digest");
    let scene: Scene = parse_scene(&object.get("scene")?.to_string()).ok()?;
    object.insert("scene_digest".to_owned(), scene.digest().into());
    Some(stored.to_string().into_bytes())
}
