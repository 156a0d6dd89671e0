//! Plans of campaigns. Where the input has a part `repair`, the digests of plan and scene are put right; it may have the
//! campaign's own plan alone.

use crossgrain::study::campaign::Campaign;
use crossgrain::study::plan::Plan;
use grains::scene::{Scene, parse_scene};

use super::parts::{self, Parts};

/// A plan that is accepted reads back as itself, and the program that it names can be checked.
pub fn read(input: &[u8]) -> bool {
    let parts = Parts::of(input);
    let Some(bytes) = parts.get("plan.json") else {
        return false;
    };
    let folder = parts::folder();
    let repaired = parts.get("repair").and_then(|_| repair(bytes));
    let text = repaired.as_deref().unwrap_or(bytes);
    std::fs::write(folder.path().join("plan.json"), text).expect("a writable folder");
    let Ok(plan) = Plan::<Campaign>::read(folder.path()) else {
        return false;
    };
    // Either way: what counts is that it can be told.
    let _ = plan.check_program(folder.path());
    let Campaign { members, seed, .. } = plan.study;
    assert_eq!(plan.study.realization(members), seed + members - 1);
    let again = folder.path().join("again");
    plan.write(&again).expect("a plan that can be written");
    let read = Plan::<Campaign>::read(&again);
    assert_eq!(read.expect("what was accepted once"), plan);
    true
}

fn repair(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut stored: serde_json::Value = serde_json::from_slice(bytes).ok()?;
    let study = match stored.get_mut("study") {
        Some(study) => study,
        None => &mut stored,
    };
    let object = study.as_object_mut()?;
    for key in ["version", "crossgrain", "yade_scripts", "digest"] {
        object.shift_remove(key);
    }
    let scene: Scene = parse_scene(&object.get("scene")?.to_string()).ok()?;
    object.insert("scene_digest".to_owned(), scene.digest().into());
    let campaign: Campaign = serde_json::from_value(study.take()).ok()?;
    Some(Plan::new(campaign, None).ok()?.text().into_bytes())
}
