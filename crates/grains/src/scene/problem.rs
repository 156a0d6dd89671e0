//! What can be wrong with a scene: a place, what stands there, what would be right.

use std::fmt::{self, Debug};

use serde_json::Value;

/// Longest name of a scene or a control point, characters.
const LONGEST_NAME: usize = 200;

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
        Problem {
            place: place.to_owned(),
            found: cut(found.to_string()),
            wanted,
        }
    }
}

fn cut(found: String) -> String {
    if found.chars().count() > 60 {
        found.chars().take(57).collect::<String>() + "..."
    } else {
        found
    }
}

/// All problems of a scene.
pub(super) struct Findings(pub(super) Vec<Problem>);

impl Findings {
    /// A problem at `place` unless something holds there.
    pub(super) fn unless(&mut self, holds: bool, place: &str, value: &dyn Debug, wanted: &str) {
        if !holds {
            self.0.push(Problem {
                place: place.to_owned(),
                found: cut(format!("{value:?}")),
                wanted: wanted.to_owned(),
            });
        }
    }

    /// A problem unless the value is above 0.
    pub(super) fn positive(&mut self, place: &str, value: f64) {
        self.unless(
            value.is_finite() && value > 0.0,
            place,
            &value,
            "a finite number above 0",
        );
    }

    /// A problem unless the name can stand in a line, in tables and in pages.
    pub(super) fn name(&mut self, place: &str, name: &str) {
        self.unless(
            name.chars().count() <= LONGEST_NAME && !name.chars().any(char::is_control),
            place,
            &name,
            &format!(
                "at most {LONGEST_NAME} characters without line breaks or other control characters"
            ),
        );
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
