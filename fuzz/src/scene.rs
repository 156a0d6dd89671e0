//! Scene files.

use grains::generate::initial_bodies;
use grains::model::Model;
use grains::scene::parse_scene;

/// More grains are not placed here.
const MOST_PLACED: u32 = 1000;

/// A scene that is accepted reads back as itself, and its grains can be placed.
pub fn read(input: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(input) else {
        return false;
    };
    let scene = match parse_scene(text) {
        Ok(scene) => scene,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return false;
        }
    };
    let written = serde_json::to_string(&scene).expect("a scene is JSON");
    let again = parse_scene(&written).expect("what was accepted once");
    assert_eq!(again, scene);
    assert_eq!(again.digest(), scene.digest());
    let model = Model::of(&scene);
    assert!(model.dt > 0.0);
    if scene.particles.count <= MOST_PLACED {
        let grains = initial_bodies(&scene);
        assert_eq!(grains.len(), scene.particles.count as usize);
    }
    true
}
