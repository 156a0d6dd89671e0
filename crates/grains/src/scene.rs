//! The scene: types, the paper's own, validation and the JSON Schema. Depends on nothing that comes after it.

pub mod check;
pub mod model;
pub mod paper_scene;
pub mod problem;

pub use check::{SceneError, parse_scene};
pub use model::*;
pub use paper_scene::{OPEN_CHOICES, paper_scene};
pub use problem::Problem;

/// The JSON Schema of a scene file, generated from the types.
pub fn json_schema() -> serde_json::Value {
    schemars::schema_for!(Scene).to_value()
}
