//! The scene: types, the paper's own, validation and the JSON Schema. Depends on nothing else.

pub mod check;
pub mod model;
pub mod paper_scene;
mod structure;

pub use check::{Problem, SceneError, parse_scene, read_scene};
pub use model::*;
pub use paper_scene::{OPEN_CHOICES, paper_scene};

/// The JSON Schema of a scene file, generated from the types.
pub fn json_schema() -> serde_json::Value {
    schemars::schema_for!(Scene).to_value()
}
