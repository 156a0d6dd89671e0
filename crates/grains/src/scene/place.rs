//! Where something stands in the text of a scene, and what was given twice there.

use std::collections::BTreeSet;
use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};
use serde_json::value::RawValue;

/// The keys of an object in the order of the text, each with the text of its value.
struct Entries<'a>(Vec<(String, &'a RawValue)>);

impl<'a> Deserialize<'a> for Entries<'a> {
    fn deserialize<D: Deserializer<'a>>(from: D) -> Result<Self, D::Error> {
        struct All;
        impl<'a> Visitor<'a> for All {
            type Value = Entries<'a>;

            fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
                out.write_str("an object")
            }

            fn visit_map<M: MapAccess<'a>>(self, mut map: M) -> Result<Entries<'a>, M::Error> {
                let mut all = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    all.push(entry);
                }
                Ok(Entries(all))
            }
        }
        from.deserialize_map(All)
    }
}

/// The parts of a value with their keys, or with their numbers in a list.
fn parts(text: &str) -> Vec<(String, &str)> {
    if let Ok(Entries(all)) = serde_json::from_str(text) {
        return all.into_iter().map(|(key, of)| (key, of.get())).collect();
    }
    let list: Vec<&RawValue> = serde_json::from_str(text).unwrap_or_default();
    let list = list.into_iter().enumerate();
    list.map(|(index, of)| (index.to_string(), of.get()))
        .collect()
}

/// The JSON pointer of the first key that is given twice in its object.
pub(super) fn twice(text: &str, place: &str) -> Option<String> {
    let mut seen = BTreeSet::new();
    for (key, of) in parts(text) {
        let here = format!("{place}/{}", escaped(&key));
        if !seen.insert(key) {
            return Some(here);
        }
        if let Some(inside) = twice(of, &here) {
            return Some(inside);
        }
    }
    None
}

/// A key as it stands in a JSON pointer.
pub(super) fn escaped(key: &str) -> String {
    key.replace('~', "~0").replace('/', "~1")
}

/// Line and column, from 1, of the last key of a JSON pointer that is in the text.
pub(super) fn line_and_column(text: &str, pointer: &str) -> (usize, usize) {
    let (mut inner, mut start) = (text, 0);
    for wanted in pointer.split('/').skip(1) {
        let found = parts(inner)
            .into_iter()
            .rfind(|(key, _)| escaped(key) == wanted);
        let Some((key, value)) = found else { break };
        let offset = value.as_ptr() as usize - text.as_ptr() as usize;
        let before = &text[..offset];
        start = before.rfind(&format!("\"{key}\"")).unwrap_or(offset);
        inner = value;
    }
    let before = &text[..start];
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    let line = before.matches('\n').count() + 1;
    (line, text[line_start..start].chars().count() + 1)
}
