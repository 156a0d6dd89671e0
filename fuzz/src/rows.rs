//! Rows of studies as JSON. The first byte says of which one.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crossgrain::study::member::Member;

/// A row that is accepted reads back as itself.
pub fn read(input: &[u8]) -> bool {
    match input.split_first() {
        Some((b't', json)) => read_as::<Member>(json),
        Some((b's', json)) => read_as::<Vec<Member>>(json),
        _ => false,
    }
}

fn read_as<T: Serialize + DeserializeOwned + PartialEq + std::fmt::Debug>(json: &[u8]) -> bool {
    let Ok(row) = serde_json::from_slice::<T>(json) else {
        return false;
    };
    let text = serde_json::to_string(&row).expect("a row can be written");
    let again: T = serde_json::from_str(&text).expect("what was written can be read");
    assert_eq!(again, row);
    true
}
