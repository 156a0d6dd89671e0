//! The paper's experiment as a scene (Table 2, section 3), every choice that the paper leaves open named with its reason:
//! `paper.json`, read.

use std::sync::LazyLock;

use super::*;

static PAPER: LazyLock<Scene> =
    LazyLock::new(|| serde_json::from_str(include_str!("paper.json")).expect("it is a scene"));

/// The paper's scene for one realization and so many grains, 5,000 in the paper.
pub fn paper_scene(realization: u64, particles: u32) -> Scene {
    let mut scene = PAPER.clone();
    scene.realization = realization;
    scene.particles.count = particles;
    scene
}

/// The keys that the paper does not print; its scene has a reason for each.
pub fn open_choices() -> impl Iterator<Item = &'static str> {
    PAPER.choices.keys().map(String::as_str)
}
