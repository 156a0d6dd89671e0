//! The corpus engine under rules of the catalogue that are drawn: what it declares it is judged by, and is equal to rounding; with
//! one rule declared wrongly it is different, and that rule is named. Where nothing tells two alternatives apart the program says
//! so. Every 25th combination is judged each time, all of them with CROSSGRAIN_ALL=1; CROSSGRAIN_KEEP=1 writes them all to
//! `reference_data/rules-1.csv`.

use evidence::in_parallel;
use evidence::random::Source;
use grains::rules::{CATALOGUE, Choice, Rules};
use verdict::forms::other_rules;
use verdict::starts::{Bed, DISPERSION, State};

use crate::support::*;

/// How many combinations there are.
const COMBINATIONS: u64 = 100;
/// Grains of the bed.
const GRAINS: u32 = 60;

/// Of each rule the first alternative as often as all others together.
fn drawn(source: &mut Source) -> Rules {
    let mut rules = Rules::default();
    for rule in CATALOGUE.iter().filter(|rule| !rule.needs.is_of_space()) {
        let others: Vec<Choice> = of_rule(Choice::all(), rule.key).skip(1).collect();
        if source.below(2) == 1 {
            others[source.below(others.len())].set(&mut rules);
        }
    }
    rules
}

fn of_rule<'a>(
    all: impl Iterator<Item = Choice> + 'a,
    key: &'a str,
) -> impl Iterator<Item = Choice> + 'a {
    all.filter(move |choice| choice.rule().key == key)
}

/// One rule that the engine computes otherwise than it says, of those that make a difference in any of the states.
fn drawn_wrong(source: &mut Source, rules: Rules, states: &[State]) -> Choice {
    let cases = states.iter().map(|state| state.under(rules).case);
    let all: BTreeSet<Choice> = cases
        .flat_map(|case| other_rules(&case).collect::<Vec<_>>())
        .collect();
    let keys: BTreeSet<&str> = all.iter().map(|choice| choice.rule().key).collect();
    let keys: Vec<&str> = keys.into_iter().collect();
    let key = keys[source.below(keys.len())];
    let alternatives: Vec<Choice> = of_rule(all.into_iter(), key).collect();
    alternatives[source.below(alternatives.len())]
}

/// As the engine is told of them.
fn told(rules: Rules) -> String {
    let names = rules.unusual().map(|choice| choice.name().replace(' ', ""));
    names.collect::<Vec<_>>().join(",")
}

/// What `engine check` finds of the engine that computes with these rules and declares those.
fn checked(folder: &Path, computed: Rules, declared: Rules, name: &str) -> (i32, Value) {
    let (computed, declared) = (told(computed), told(declared));
    let script =
        format!("#!/bin/sh\nRULES='{computed}' DECLARED='{declared}' exec ./sound \"$@\"\n");
    let script = script.replace("./sound", &folder.join("sound").display().to_string());
    let engine = engine(folder, name, &script);
    let command = format!("engine check {engine} --grains {GRAINS} --quiet --json");
    let (code, out, errors) = say(folder, &command);
    let found = serde_json::from_str(&out).unwrap_or_else(|error| panic!("{error}: {errors}"));
    (code, found)
}

/// Whether any of these sentences has the choice in it.
fn has_choice(list: &Value, choice: Choice) -> bool {
    let name = choice.name();
    let mut sentences = list.as_array().into_iter().flatten();
    sentences.any(|sentence| {
        sentence
            .as_str()
            .is_some_and(|sentence| sentence.contains(&name))
    })
}

fn row(folder: &Path, number: u64, states: &[State]) -> [String; 6] {
    let mut source = Source::new(b"crossgrain: rules that are drawn", number);
    let declared = drawn(&mut source);
    let wrong = drawn_wrong(&mut source, declared, states);
    let word = |code| match code {
        0 => "equal to rounding",
        1 => "different",
        _ => "undecided",
    };
    let (right, _) = checked(folder, declared, declared, &format!("right-{number}"));
    let mut computed = declared;
    wrong.set(&mut computed);
    let (other, found) = checked(folder, computed, declared, &format!("wrong-{number}"));
    let steps = &found["first_steps"];
    let causes = steps["causes"].as_array().into_iter().flatten();
    let of_causes: Vec<&Value> = causes.collect();
    let named = |key: &str| of_causes.iter().any(|cause| has_choice(&cause[key], wrong));
    let said = match other {
        0 if has_choice(&steps["unseen"], wrong) => "not told apart",
        0 => "agreed silently",
        _ if named("forms") => "named",
        _ if named("also") => "named with others",
        _ => "not named",
    };
    let row = [
        number.to_string(),
        told(declared).replace(',', " "),
        word(right).to_owned(),
        wrong.name().replace(' ', ""),
        word(other).to_owned(),
        said.to_owned(),
    ];
    println!("{}", row.join(","));
    if said == "not named" || said == "agreed silently" {
        println!("{} {}", steps["causes"], steps["unseen"]);
    }
    row
}

#[test]
fn declared_rules_are_judged_by_and_one_declared_wrongly_is_named() {
    let folder = &new_folder();
    let mut compile = Command::new("cc");
    compile
        .args(["-std=gnu11", "-O2"])
        .arg(root("tests/corpus/engine.c"));
    let compiled = compile.args(["-lm", "-o"]).arg(folder.join("sound"));
    assert!(compiled.status().expect("a C compiler").success());
    let states = Bed::new(GRAINS, DISPERSION).expect("a bed").states();
    let keep = std::env::var_os("CROSSGRAIN_KEEP").is_some();
    let all = keep || std::env::var_os("CROSSGRAIN_ALL").is_some();
    let every = if all { 1 } else { 25 };
    let numbers: Vec<u64> = (0..COMBINATIONS).step_by(every).collect();
    let found = in_parallel(numbers.len(), |at| row(folder, numbers[at], &states));
    let mistaken = |[_, _, right, _, wrong, said]: &&[String; 6]| {
        let seen = wrong == "different" && said.starts_with("named");
        right != "equal to rounding" || !(seen || said == "not told apart")
    };
    let mistakes: Vec<&[String; 6]> = found.iter().filter(mistaken).collect();
    let head = "combination,declared,judged,computed instead,judged then,cause".to_owned();
    let rows = [head]
        .into_iter()
        .chain(found.iter().map(|row| row.join(",")));
    let table = rows.collect::<Vec<_>>().join("\n") + "\n";
    if keep {
        fs::write(root("reference_data/rules-1.csv"), table).expect("writable");
    }
    assert!(mistakes.is_empty(), "{mistakes:#?}");
}

/// What README.md says of them.
#[test]
fn the_recorded_combinations_are_what_is_claimed() {
    let table = text_of(root("reference_data/rules-1.csv"));
    let cells = |row| str::split(row, ',').collect();
    let rows: Vec<Vec<&str>> = table.lines().skip(1).map(cells).collect();
    let count = |column: usize, words: &[&str]| {
        let holds = rows.iter().filter(|row| words.contains(&row[column]));
        holds.count()
    };
    let (right, different) = (count(2, &["equal to rounding"]), count(4, &["different"]));
    let named = count(5, &["named", "named with others"]);
    let alike = count(5, &["not told apart"]);
    assert_eq!(
        (rows.len(), right, different + alike, named),
        (100, 100, 100, different)
    );
    let others = if alike > 0 {
        format!(", {alike} alike")
    } else {
        String::new()
    };
    let said = format!(
        "of {right} drawn sets of declared rules {right} are equal to rounding; with one wrong, {named} named{others}"
    );
    has(&text_of(root("README.md")), [said.as_str()]);
}
