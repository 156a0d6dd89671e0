//! What no reading asks for. A key of the law, of the job or a rule is read where a reading that was made shows another value when it is
//! another one; all keys, their values and rules are those of the types, so that none can be forgotten here.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Value, json};

use super::TOLERANCE;
use super::asked::{Kind, Quantity};
use crate::engine::Description;
use grains::model::{Axis, Law, Solid};
use grains::rules::Choice;
use grains::scene::{ContactLaw, SceneError, Shape, SurfaceHeight, paper_scene};
use grains::task::Case;
use grains::variant::{Form, Key, Variant, run};
use verdict::forms::plays_a_part;

/// A key of the contact law and what it may be.
type Choosable = (String, Value);

/// All keys of a law of this kind with each value that they may have; numbers stand for all numbers.
fn options(kind: Kind) -> Vec<Choosable> {
    let schema = schemars::schema_for!(ContactLaw).to_value();
    let properties = schema["properties"].as_object().into_iter().flatten();
    let contact = properties.flat_map(|(key, part)| {
        let values = values(part, &schema).into_iter();
        values.map(move |value| (key.clone(), value))
    });
    // Kinds are of different springs.
    let contact = contact.filter(|(key, _)| key != "springs");
    let all: Vec<Choosable> = contact.filter(|one| is_valid(kind, one)).collect();
    // What can have one value alone is no choice.
    let is_choice = |(key, value): &Choosable| {
        let others = all.iter().filter(|(other, _)| other == key);
        !value.is_string() || others.count() > 1
    };
    all.iter().filter(|one| is_choice(one)).cloned().collect()
}

/// What a part of a schema allows, with a number for all numbers and with and without what may be left out.
fn values(part: &Value, schema: &Value) -> Vec<Value> {
    if let Some(name) = part["$ref"].as_str() {
        let place = name.trim_start_matches('#');
        return values(schema.pointer(place).unwrap_or(&Value::Null), schema);
    }
    let alternatives = ["oneOf", "anyOf", "allOf"].map(|key| part[key].as_array());
    if let Some(all) = alternatives.into_iter().flatten().next() {
        return all.iter().flat_map(|one| values(one, schema)).collect();
    }
    if let Some(one) = part.get("const") {
        return vec![one.clone()];
    }
    if let Some(all) = part["enum"].as_array() {
        return all.clone();
    }
    let Some(properties) = part["properties"].as_object() else {
        return vec![json!(0.5)];
    };
    let required = part["required"].as_array().cloned().unwrap_or_default();
    let mut all = vec![json!({})];
    for (key, inner) in properties {
        let mut next = Vec::new();
        for one in &all {
            next.extend((!required.contains(&json!(key))).then(|| one.clone()));
            for value in values(inner, schema) {
                let mut with = one.clone();
                with[key] = value;
                next.push(with);
            }
        }
        all = next;
    }
    all
}

/// Whether a scene may have it, by itself or beside adhesion.
fn is_valid(kind: Kind, (key, value): &Choosable) -> bool {
    let contact = kind.law(1.0, 0.5).contact;
    let mut beside = contact.clone();
    beside.adhesion = Some(0.5);
    [contact, beside].into_iter().any(|contact| {
        patched(&contact, key, value).is_some_and(|contact| is_possible(kind, &contact))
    })
}

fn is_possible(kind: Kind, contact: &ContactLaw) -> bool {
    let mut scene = paper_scene(1, 1);
    if kind.in_space() {
        scene.container.depth = Some(scene.container.width);
        scene.particles.shape = Shape::Sphere;
        scene.measurement.surface_height = SurfaceHeight::HighestGrain;
        scene.material.poissons_ratio = Some(0.3);
    }
    scene.contact = contact.clone();
    match scene.check() {
        Err(SceneError::Problems(all)) => {
            let mut all = all.iter();
            !all.any(|problem| problem.place.starts_with("/contact"))
        }
        other => other.is_ok(),
    }
}

fn patched(contact: &ContactLaw, key: &str, value: &Value) -> Option<ContactLaw> {
    let mut all = serde_json::to_value(contact).ok()?;
    all[key] = value.clone();
    serde_json::from_value(all).ok()
}

/// How a value is told: its words, and which numbers are given.
fn told(key: &str, value: &Value) -> String {
    match value {
        Value::String(word) => format!("{key} = {word}"),
        Value::Object(inner) => {
            let parts = inner.iter().map(|(name, value)| match value {
                Value::String(word) => word.clone(),
                _ => name.clone(),
            });
            format!("{key} = {}", parts.collect::<Vec<_>>().join(", "))
        }
        _ => key.to_owned(),
    }
}

/// With spins where grains turn, and without where they do not.
fn fitted(mut case: Case) -> Case {
    let (turns, bodies) = (case.model.law.rotates(), &mut case.bodies);
    let in_space = !bodies.y.is_empty();
    let count = bodies.radius.len();
    let mut columns = vec![&mut bodies.spin, &mut bodies.inertia];
    columns.extend(
        in_space
            .then_some([&mut bodies.spin_x, &mut bodies.spin_z])
            .into_iter()
            .flatten(),
    );
    for column in columns {
        column.resize(if turns { count } else { 0 }, 0.0);
    }
    let grains = bodies
        .inertia
        .iter_mut()
        .zip(&bodies.mass)
        .zip(&bodies.radius);
    grains.for_each(|((inertia, mass), radius)| {
        if *inertia == 0.0 {
            *inertia = 0.4 * mass * radius * radius;
        }
    });
    case
}

/// Every number of it a little larger.
fn larger(value: &mut Value) {
    match value {
        Value::Number(number) => *value = json!(number.as_f64().unwrap_or(0.0) * 1.1),
        Value::Array(all) => all.iter_mut().for_each(larger),
        Value::Object(all) => all.values_mut().for_each(larger),
        _ => {}
    }
}

/// A law that has all its keys.
fn whole_law() -> Law {
    let solid = Solid {
        modulus: 1.0,
        stiffness_ratio: 1.0,
        poissons_ratio: 0.3,
        friction_angle: 0.5,
    };
    Law {
        modulus: 1.0,
        stiffness_ratio: 1.0,
        friction_angle: 0.5,
        wall_friction_angle: Some(0.5),
        punch_friction_angle: Some(0.5),
        poissons_ratio: Some(0.3),
        materials: vec![solid],
        contact: ContactLaw::default(),
    }
}

/// What readings ask for, and what there is.
struct Asked<'a> {
    all: &'a [&'a Quantity],
    under: Variant,
}

impl Asked<'_> {
    fn shows(&self, quantity: &Quantity, case: &Case, variant: &Variant) -> bool {
        let [before, after] = [(&quantity.case, &self.under), (case, variant)]
            .map(|(case, variant)| (quantity.read)(&run(case, variant)));
        (before - after).abs() > TOLERANCE * before.abs()
    }

    /// Whether a reading shows that this is otherwise in its case.
    fn is_read(&self, kinds: &[Kind], others: impl Fn(&Case) -> Vec<Case>) -> bool {
        let of_kind = |quantity: &&&Quantity| kinds.contains(&quantity.about.kind);
        self.all.iter().filter(of_kind).any(|quantity| {
            let others = others(&quantity.case);
            let mut others = others.into_iter().map(fitted);
            others.any(|case| self.shows(quantity, &case, &self.under))
        })
    }

    /// An option of the contact law: a reading has it, and shows where it is another one.
    fn has(&self, kind: Kind, (key, value): &Choosable, all: &[Choosable]) -> bool {
        self.is_read(&[kind], |case| {
            let contact = &case.model.law.contact;
            let has = patched(contact, key, value);
            let written = serde_json::to_value(contact).unwrap_or_default();
            let same = has.as_ref() == Some(contact)
                || written
                    .get(key)
                    .is_some_and(|own| told(key, own) == told(key, value));
            if !same {
                return Vec::new();
            }
            let mut others: Vec<Value> = all
                .iter()
                .filter(|(other, _)| other == key)
                .map(|(_, other)| other.clone())
                .filter(|other| told(key, other) != told(key, value))
                .collect();
            others.extend(written.get(key).cloned().map(|mut own| {
                larger(&mut own);
                own
            }));
            let others = others
                .iter()
                .filter_map(|other| patched(contact, key, other));
            let others = others.filter(|other| other != contact && is_possible(kind, other));
            others
                .map(|contact| {
                    let mut case = case.clone();
                    case.model.law.contact = contact;
                    case
                })
                .collect()
        })
    }

    /// A key of the law beside its contact.
    fn has_key(&self, kind: Kind, key: &str) -> bool {
        self.is_read(&[kind], |case| {
            let mut law = serde_json::to_value(&case.model.law).unwrap_or_default();
            law.get_mut(key).map(larger);
            let law = serde_json::from_value(law).ok();
            let law = law.filter(|law: &Law| *law != case.model.law);
            law.into_iter()
                .map(|law| {
                    let mut case = case.clone();
                    case.model.law = law;
                    case
                })
                .collect()
        })
    }
}

/// What an engine with these parts may be asked for and was not, told once with all kinds of which it is so.
pub fn unread(asked: &[&Quantity], engine: &Description, under: Variant) -> Vec<String> {
    let asked = Asked { all: asked, under };
    let kinds: Vec<Kind> = Kind::ALL
        .into_iter()
        .filter(|kind| kind.is_in(engine))
        .collect();
    let mut found: BTreeMap<String, BTreeSet<usize>> = BTreeMap::new();
    let mut note = |what: String, kind: Kind| {
        found.entry(what).or_default().insert(kind as usize);
    };
    for kind in &kinds {
        let all = options(*kind);
        for one in all.iter().filter(|one| !asked.has(*kind, one, &all)) {
            note(format!("contact.{}", told(&one.0, &one.1)), *kind);
        }
        let law = serde_json::to_value(whole_law()).unwrap_or_default();
        let keys = law.as_object().into_iter().flatten().map(|(key, _)| key);
        let of_hertz = ["poissons_ratio"];
        let keys = keys
            .filter(|key| *key != "contact")
            .filter(|key| match key.as_str() {
                "stiffness_ratio" => *kind != Kind::Hertz,
                "materials" => kind.in_space(),
                key => *kind == Kind::Hertz || !of_hertz.contains(&key),
            });
        for key in keys.filter(|key| !asked.has_key(*kind, key)) {
            note(format!("law.{key}"), *kind);
        }
        let quantities = asked
            .all
            .iter()
            .filter(|quantity| quantity.about.kind == *kind);
        let walls = quantities.flat_map(|quantity| {
            let height = move |axis: Axis| match axis {
                Axis::X => quantity.case.bodies.x.last(),
                Axis::Y => quantity.case.bodies.y.last(),
                Axis::Z => quantity.case.bodies.z.last(),
            };
            let walls = quantity.case.model.walls.iter();
            walls.flat_map(move |wall| {
                let below = height(wall.axis).is_some_and(|height| *height < wall.place);
                let mut all = vec![format!("walls.axis = {:?}", wall.axis).to_lowercase()];
                all.extend((wall.place < 0.0).then(|| "walls.place below 0".to_owned()));
                all.extend((wall.place > 0.0).then(|| "walls.place above 0".to_owned()));
                all.push(format!(
                    "walls with a grain {} them",
                    if below { "below" } else { "above" }
                ));
                all
            })
        });
        let walls: BTreeSet<String> = walls.collect();
        let mut there_are = vec![
            "walls.axis = x",
            "walls.axis = z",
            "walls.place below 0",
            "walls.place above 0",
        ];
        there_are.extend([
            "walls with a grain below them",
            "walls with a grain above them",
        ]);
        there_are.extend(kind.in_space().then_some("walls.axis = y"));
        for one in there_are.into_iter().filter(|one| !walls.contains(*one)) {
            note(one.to_owned(), *kind);
        }
    }
    let keys = Key::ALL.into_iter();
    for key in keys.filter(|key| !key.name().starts_with("law.")) {
        // In space one grain is asked for by one law alone.
        for kind in kinds.iter().filter(|kind| **kind != Kind::Hertz) {
            let all = if kind.in_space() {
                &Kind::ALL[1..]
            } else {
                &Kind::ALL[..1]
            };
            if !asked.is_read(all, |case| key.unread(case).into_iter().collect()) {
                note(key.name().to_owned(), *kind);
            }
        }
    }
    let rules = Choice::all().filter(|choice| !choice.is_models());
    for choice in rules.filter(|choice| !choice.is_in(&grains::rules::Rules::default())) {
        let needs = choice.rule().needs;
        let mut with = asked.under.clone();
        with.forms.push(Form::Rule(choice));
        if asked.under.has(Form::Rule(choice)) {
            continue;
        }
        for kind in kinds
            .iter()
            .filter(|kind| kind.in_space() || !needs.is_of_space())
        {
            if needs.is_of_space() != (*kind == Kind::Hertz)
                && kind.in_space()
                && kinds.contains(&Kind::Hertz)
            {
                continue;
            }
            let same = |quantity: &&&Quantity| match needs.is_of_space() {
                true => quantity.about.kind == *kind,
                false => quantity.about.kind.in_space() == kind.in_space(),
            };
            let has = asked.all.iter().filter(same).any(|quantity| {
                plays_a_part(&quantity.case, needs) && asked.shows(quantity, &quantity.case, &with)
            });
            if !has {
                note(format!("rules.{}", choice.name()), *kind);
            }
        }
    }
    let everywhere = kinds.len();
    let tell = |(what, kinds): (String, BTreeSet<usize>)| {
        let names = kinds.iter().map(|kind| {
            [
                "in the plane",
                "by linear springs in space",
                "by Hertz's springs",
            ][*kind]
        });
        match kinds.len() == everywhere {
            true => what,
            false => format!("{what} ({})", names.collect::<Vec<_>>().join(", ")),
        }
    };
    found.into_iter().map(tell).collect()
}

#[cfg(test)]
mod tests {
    use super::super::asked::quantities;
    use super::*;
    use crate::engine::Engine;
    use grains::native;

    fn engine() -> Description {
        let engine = native::Options::default();
        engine.describe().expect("described")
    }

    fn not_read(is_asked: impl Fn(&Quantity) -> bool) -> Vec<String> {
        let all = quantities(&engine());
        let asked: Vec<&Quantity> = all.iter().filter(|quantity| is_asked(quantity)).collect();
        unread(&asked, &engine(), Variant::default())
    }

    fn lists(all: &[String], key: &str) -> bool {
        all.iter().any(|listed| {
            let rest = listed.strip_prefix(key);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(' '))
        })
    }

    #[test]
    fn nothing_is_read_where_nothing_is_asked_for() {
        let all = not_read(|_| false);
        let law = serde_json::to_value(whole_law()).expect("JSON");
        let keys = law.as_object().expect("an object").keys();
        for key in keys.filter(|key| *key != "contact") {
            assert!(lists(&all, &format!("law.{key}")), "{key}: {all:?}");
        }
        let schema = schemars::schema_for!(ContactLaw).to_value();
        let keys = schema["properties"].as_object().expect("an object").keys();
        for key in keys.filter(|key| *key != "springs") {
            assert!(lists(&all, &format!("contact.{key}")), "{key}: {all:?}");
        }
        for choice in Choice::all().filter(|choice| !choice.is_models()) {
            let usual = choice.is_in(&grains::rules::Rules::default());
            assert!(usual || lists(&all, &format!("rules.{}", choice.name())));
        }
    }

    #[test]
    fn a_key_is_listed_where_its_reading_is_left_out() {
        for (reading, key) in [
            ("friction-own", "law.wall_friction_angle"),
            ("friction-own", "law.punch_friction_angle"),
            ("c-s-own", "contact.tangential_viscosity"),
            ("alpha-spin", "rules.damped_spins = undamped"),
            ("new-touch", "contact.new_contact_slip = since_touch"),
            ("k-s-point", "contact.slip_velocity = contact_point"),
            ("parting", "contact.viscosity = ratio, ratio, unclipped"),
        ] {
            assert!(
                lists(
                    &not_read(|quantity| !quantity.about.key.contains(reading)),
                    key
                ),
                "{key}"
            );
        }
        let all = not_read(|_| true);
        for key in [
            "law.wall_friction_angle",
            "contact.tangential_viscosity",
            "rules.damped_spins = undamped",
        ] {
            assert!(!lists(&all, key), "{key}: {all:?}");
        }
    }
}
