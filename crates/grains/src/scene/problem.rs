//! What is wrong with a scene's JSON, and where it stands in the text; the structure of a value held against the schema.

use std::collections::BTreeSet;
use std::fmt::{self, Debug};

use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};
use serde_json::value::RawValue;
use serde_json::{Map, Value};

/// Two words that are as alike as this are one with a slip of the pen; of 0 to 1.
const NEAR: f64 = 0.85;

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
    /// Line and column in the file, from 1.
    pub at: Option<(usize, usize)>,
}

impl Problem {
    pub(super) fn of(
        place: impl Into<String>,
        found: impl Into<String>,
        wanted: impl Into<String>,
    ) -> Self {
        Problem {
            place: place.into(),
            found: found.into(),
            wanted: wanted.into(),
            at: None,
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
pub(super) struct Findings<'a> {
    /// What was written.
    pub(super) given: &'a Value,
    /// The scene with its defaults.
    pub(super) whole: &'a Value,
    pub(super) problems: Vec<Problem>,
}

impl Findings<'_> {
    /// A problem at `place` unless something holds there.
    pub(super) fn unless(&mut self, holds: bool, place: &str, value: &dyn Debug, wanted: &str) {
        if !holds && self.is_sound(place) {
            let found = cut(format!("{value:?}"));
            self.problems.push(Problem::of(place, found, wanted));
        }
    }

    /// A problem unless something holds that follows from these keys, all of which are sound by themselves; it stands at the
    /// first of them that was written.
    pub(super) fn follows(&mut self, holds: bool, from: &[&str], wanted: &str) {
        if holds || !from.iter().all(|key| self.is_sound(key)) {
            return;
        }
        let first = |value: &Value| from.iter().find(|key| value.pointer(key).is_some());
        let place = first(self.given).or_else(|| first(self.whole));
        let place = place.copied().unwrap_or_default();
        let value = self.whole.pointer(place).cloned().unwrap_or_default();
        let found = cut(value.to_string().replace(',', ", "));
        self.problems.push(Problem::of(place, found, wanted));
    }

    /// Whether nothing is wrong there, nor with what it belongs to, nor inside it.
    pub(super) fn is_sound(&self, place: &str) -> bool {
        let is_in = |inner: &str, outer: &str| {
            let rest = inner.strip_prefix(outer);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        };
        let mut all = self.problems.iter();
        all.all(|problem| !is_in(place, &problem.place) && !is_in(&problem.place, place))
    }

    /// A problem unless the name can stand in a line, in tables and in pages.
    pub(super) fn name(&mut self, place: &str, name: &str) {
        let holds = name.chars().count() <= LONGEST_NAME && !name.chars().any(char::is_control);
        let wanted = format!(
            "at most {LONGEST_NAME} characters without line breaks or other control characters"
        );
        self.unless(holds, place, &name, &wanted);
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((line, column)) = self.at {
            write!(out, "line {line}, column {column}: ")?;
        }
        let place = match self.place.as_str() {
            "" => "/",
            place => place,
        };
        write!(out, "{place}: found {}, wanted {}", self.found, self.wanted)
    }
}

/// Every place where `value` does not have the form that `schema` asks for.
pub fn misfits(schema: &Value, value: &Value) -> Vec<Problem> {
    let (root, problems) = (schema, Vec::new());
    let mut walk = Walk { root, problems };
    walk.value(schema, value, "");
    walk.problems
}

/// Removes the key at this place, if it is one of an object.
pub(super) fn remove(value: &mut Value, place: &str) {
    let parent = place.rsplit_once('/');
    let parent = parent.and_then(|(parent, key)| Some((value.pointer_mut(parent)?, key)));
    if let Some((Value::Object(parent), key)) = parent {
        parent.remove(&key.replace("~1", "/").replace("~0", "~"));
    }
}

/// A value held against a schema, part by part.
struct Walk<'a> {
    /// Of the whole, in which references are looked up.
    root: &'a Value,
    problems: Vec<Problem>,
}

impl Walk<'_> {
    fn misfit(&mut self, place: &str, found: &Value, wanted: String) {
        let found = cut(found.to_string());
        self.problems.push(Problem::of(place, found, wanted));
    }

    fn value(&mut self, schema: &Value, value: &Value, place: &str) {
        let reference = schema.get("$ref").and_then(Value::as_str);
        let root = self.root;
        let known = reference.and_then(|pointer| root.pointer(pointer.trim_start_matches('#')));
        let schema = known.unwrap_or(schema);
        if let Some(variants) = schema.get("oneOf").and_then(Value::as_array) {
            return self.one_of(variants, value, place);
        }
        if let Some(names) = schema.get("enum").and_then(Value::as_array) {
            if !names.contains(value) {
                self.misfit(place, value, one_of_these(names));
            }
            return;
        }
        if let Some(kind) = schema.get("type").and_then(Value::as_str)
            && !has_type(kind, value)
        {
            let keys: Vec<&str> = properties(schema)
                .map(|property| property.0.as_str())
                .collect();
            let wanted = match keys[..] {
                [] => article(kind),
                _ => format!("{} of {}", article(kind), keys.join(", ")),
            };
            return self.misfit(place, value, wanted);
        }
        let bound = |key: &str| value.as_f64().zip(schema.get(key).and_then(Value::as_f64));
        if let Some((_, least)) = bound("minimum").filter(|(number, least)| number < least) {
            self.misfit(place, value, format!("at least {least}"));
        }
        if let Some((_, most)) = bound("maximum").filter(|(number, most)| number > most) {
            self.misfit(place, value, format!("at most {most}"));
        }
        if let (Some(items), Some(elements)) = (schema.get("items"), value.as_array()) {
            for (index, element) in elements.iter().enumerate() {
                self.value(items, element, &format!("{place}/{index}"));
            }
        }
        if let Some(object) = value.as_object() {
            self.object(schema, object, place);
        }
    }

    fn object(&mut self, schema: &Value, object: &Map<String, Value>, place: &str) {
        for key in required(schema).filter(|key| !object.contains_key(*key)) {
            let (here, wanted) = (format!("{place}/{key}"), "this key; it has no default");
            self.problems.push(Problem::of(here, "nothing", wanted));
        }
        let others = schema.get("additionalProperties");
        for (key, value) in object {
            let here = format!("{place}/{}", escaped(key));
            let own = properties(schema)
                .find(|property| property.0 == key)
                .map(|property| property.1);
            match (own, others) {
                (Some(of_key), _) | (None, Some(of_key @ Value::Object(_))) => {
                    self.value(of_key, value, &here);
                }
                (None, Some(Value::Bool(false))) => {
                    let names: Vec<&str> = properties(schema)
                        .map(|property| property.0.as_str())
                        .collect();
                    let near = |name: &&&str| strsim::jaro_winkler(name, key);
                    let nearest = names.iter().max_by(|a, b| near(a).total_cmp(&near(b)));
                    let wanted = match nearest {
                        Some(name) if near(&name) > NEAR => (*name).to_string(),
                        _ => format!("one of {}", names.join(", ")),
                    };
                    self.problems
                        .push(Problem::of(here, "an unknown key", wanted));
                }
                (None, _) => {}
            }
        }
    }

    /// Alternatives are told apart by their `kind`, or are plain names, some of them with numbers of their own as in
    /// `{"name": {…}}`.
    fn one_of(&mut self, variants: &[Value], value: &Value, place: &str) {
        let kind_of = |variant: &Value| variant.pointer("/properties/kind/const").cloned();
        let kinds: Vec<Value> = variants.iter().filter_map(kind_of).collect();
        if kinds.is_empty() {
            return self.named(variants, value, place);
        }
        let Some(object) = value.as_object() else {
            let wanted = format!("an object whose kind is {}", one_of_these(&kinds));
            return self.misfit(place, value, wanted);
        };
        let given = object.get("kind");
        let chosen = variants
            .iter()
            .find(|variant| kind_of(variant).as_ref() == given);
        let Some(variant) = chosen else {
            let (place, found) = (format!("{place}/kind"), given.unwrap_or(&Value::Null));
            return self.misfit(&place, found, one_of_these(&kinds));
        };
        let mut without_kind = variant.clone();
        without_kind["properties"]["kind"] = Value::Bool(true);
        self.object(&without_kind, object, place);
    }

    /// A plain name, or an object with a name as its only key.
    fn named(&mut self, variants: &[Value], value: &Value, place: &str) {
        if variants
            .iter()
            .any(|variant| variant.get("const") == Some(value))
        {
            return;
        }
        let object = value.as_object();
        let has = |name: &str| object.is_some_and(|object| object.contains_key(name));
        let chosen = variants.iter().find(|variant| required(variant).any(has));
        if let (Some(variant), Some(object)) = (chosen, object) {
            return self.object(variant, object, place);
        }
        let name_of = |variant: &Value| match variant.get("const") {
            Some(name) => Some(name.to_string()),
            None => Some(format!("{{\"{}\": …}}", required(variant).next()?)),
        };
        let names: Vec<String> = variants.iter().filter_map(name_of).collect();
        self.misfit(place, value, format!("one of {}", names.join(", ")));
    }
}

/// The keys that a schema knows, each with its own schema.
fn properties(schema: &Value) -> impl Iterator<Item = (&String, &Value)> {
    let known = schema.get("properties").and_then(Value::as_object);
    known.into_iter().flatten()
}

fn required(schema: &Value) -> impl Iterator<Item = &str> {
    let keys = schema.get("required").and_then(Value::as_array);
    keys.into_iter().flatten().filter_map(Value::as_str)
}

fn has_type(kind: &str, value: &Value) -> bool {
    match kind {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "integer" => value.is_u64(),
        "number" => value.is_number(),
        _ => true,
    }
}

fn article(kind: &str) -> String {
    match kind {
        "integer" => "a whole number, 0 or more".to_owned(),
        "object" | "array" => format!("an {kind}"),
        _ => format!("a {kind}"),
    }
}

fn one_of_these(values: &[Value]) -> String {
    let values: Vec<String> = values.iter().map(Value::to_string).collect();
    format!("one of {}", values.join(", "))
}

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
        return all
            .into_iter()
            .map(|(key, part)| (key, part.get()))
            .collect();
    }
    let list: Vec<&RawValue> = serde_json::from_str(text).unwrap_or_default();
    let list = list.into_iter().enumerate();
    list.map(|(index, part)| (index.to_string(), part.get()))
        .collect()
}

/// The JSON pointers of keys that are given again in their objects.
pub(super) fn twice(text: &str, place: &str) -> Vec<String> {
    let (mut seen, mut found) = (BTreeSet::new(), Vec::new());
    for (key, part) in parts(text) {
        let here = format!("{place}/{}", escaped(&key));
        found.extend(twice(part, &here));
        if !seen.insert(key) {
            found.push(here);
        }
    }
    found
}

/// A key as it stands in a JSON pointer.
fn escaped(key: &str) -> String {
    key.replace('~', "~0").replace('/', "~1")
}

/// Line and column, from 1, of the last key of a JSON pointer that is in the text, if any is.
pub(super) fn line_and_column(text: &str, pointer: &str) -> Option<(usize, usize)> {
    let (mut inner, mut start) = (text, None);
    for wanted in pointer.split('/').skip(1) {
        let found = parts(inner)
            .into_iter()
            .rfind(|(key, _)| escaped(key) == wanted);
        let Some((key, value)) = found else { break };
        let offset = value.as_ptr() as usize - text.as_ptr() as usize;
        let before = &text[..offset];
        start = Some(before.rfind(&format!("\"{key}\"")).unwrap_or(offset));
        inner = value;
    }
    let before = &text[..start?];
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    let line = before.matches('\n').count() + 1;
    Some((line, text[line_start..before.len()].chars().count() + 1))
}
