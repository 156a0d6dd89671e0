//! What can be wrong with a scene: a place, what stands there, what would be right.

use std::fmt;

use serde_json::Value;

/// One thing wrong with a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// JSON pointer of the key.
    pub place: String,
    /// What stands there.
    pub found: String,
    /// What would be right.
    pub wanted: String,
}

impl Problem {
    /// A problem with the value at `place`; long values are cut.
    pub fn new(place: &str, found: &Value, wanted: String) -> Self {
        let mut found = found.to_string();
        if found.chars().count() > 60 {
            found = found.chars().take(57).collect::<String>() + "...";
        }
        Problem {
            place: place.to_owned(),
            found,
            wanted,
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = if self.place.is_empty() {
            "/"
        } else {
            &self.place
        };
        write!(out, "{place}: found {}, wanted {}", self.found, self.wanted)
    }
}
