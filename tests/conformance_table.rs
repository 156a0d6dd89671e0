//! The conformance table: the recorded one, made again where all engines are installed, and what it says of one that is not.

use std::os::unix::fs::symlink;

use crossgrain::checks::record;
use crossgrain::files::read_text;

use crate::support::*;

/// Each engine with its place on the ladder.
fn verdicts(record: &str) -> Vec<(String, String)> {
    record::parse("conformance.json", record).expect("a record");
    let record: Value = serde_json::from_str(record).expect("JSON");
    let engines = record["engines"].as_array().expect("engines");
    let word = |value: &Value| value.as_str().expect("a word").to_owned();
    let pair = |row: &Value| (word(&row["key"]), word(&row["verdict"]));
    engines.iter().map(pair).collect()
}

fn recorded() -> Vec<(String, String)> {
    let path = root("reference_data/conformance-1/conformance.json.gz");
    verdicts(&read_text(&path, 1 << 24).expect("a record"))
}

#[test]
fn the_recorded_table_has_every_engine_on_its_step_of_the_ladder() {
    let known = [
        ("yade-sorted", "identical"),
        ("yade-ordinary", "equal_to_rounding"),
        ("lammps", "equal_to_rounding"),
        ("liggghts", "equal_to_rounding"),
        ("esysparticle", "equal_to_rounding"),
        ("kratos", "undecided"),
        ("toy", "identical"),
    ];
    let known = known.map(|(key, verdict)| (key.to_owned(), verdict.to_owned()));
    assert_eq!(recorded(), known);
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs Debian's engines")]
fn every_engine_is_still_where_it_was_recorded() {
    let folder = &new_folder();
    let table = "engine table --grains 100 --quiet --out table yade-sorted yade-ordinary lammps liggghts esysparticle toy";
    tells(folder, 0, table, ["equal to rounding under its own rules"]);
    let made = folder.join("table/conformance.json");
    // Kratos DEM is no Debian package.
    let mut of_debian = recorded();
    of_debian.retain(|(key, _)| key != "kratos");
    let recorded = read_text(&made, 1 << 24).expect("a record");
    assert_eq!(verdicts(&recorded), of_debian);
    for (key, rules) in [
        // LAMMPS limits dashpots along the tangent together with the spring, and its moments are of a force.
        (
            "lammps",
            json!({"tangential_dashpot": "within_limit", "moment_turn": "as_force"}),
        ),
        // LIGGGHTS keeps the way that contacts slipped.
        ("liggghts", json!({"spring_memory": "displacement"})),
    ] {
        let states = judged_in_all_states(&recorded, key, &rules);
        // Four under each of four laws, eight with other constants and choices, 24 drawn laws, a large one, eleven as a scene at least,
        // and in space eight and twelve drawn laws.
        assert!(states.len() >= 80, "{key}: {}", states.len());
        let law = "Hertz–Mindlin of four materials".to_owned();
        assert!(states.contains(&law), "{key}");
    }
    // It has springs along the normal alone.
    let rules = json!({"damping_velocity": "before", "stiffness_mean": "arithmetic"});
    let states = judged_in_all_states(&recorded, "esysparticle", &rules);
    assert!(states.len() >= 10, "{states:?}");
    for view in ["conformance.md", "report.html", "figures/engines.csv"] {
        let text = read_text(&folder.join("table").join(view), 1 << 24).expect("a view");
        has(&text, ["ESyS-Particle", "equal to rounding"]);
    }
}

/// This engine of a table is equal to rounding in every state, in space too, under rules among which these are; the laws of the states.
fn judged_in_all_states(record: &str, key: &str, rules: &Value) -> Vec<String> {
    let record: Value = serde_json::from_str(record).expect("JSON");
    let mut engines = record["engines"].as_array().expect("engines").iter();
    let found = &engines.find(|row| row["key"] == key).expect("there")["found"];
    for (rule, choice) in rules.as_object().expect("rules") {
        assert_eq!(found["engine"]["rules"][rule], *choice, "{key}: {rule}");
    }
    assert_eq!(found["first_steps"]["spheres"], 150, "{key}");
    let starts = found["first_steps"]["starts"].as_array();
    let looked_at = starts.expect("states").iter();
    let looked_at = looked_at.filter(|start| start["verdict"] != "undecided");
    let laws = looked_at.map(|start| {
        assert_eq!(start["verdict"], "equal_to_rounding", "{key}: {start}");
        start["law"].as_str().expect("a law").to_owned()
    });
    laws.collect()
}

/// With a path that has a Python and nothing else.
#[test]
fn an_engine_that_is_not_installed_leaves_the_table_undecided_unless_that_was_asked_for() {
    let folder = &new_folder();
    let lines = "import sys; print(sys.executable)";
    let (_, python, _) = python("python3", folder, lines, &[]);
    symlink(python.trim(), folder.join("python3")).expect("ours");
    let table = |more: &[&str]| {
        let mut program = cli(folder);
        for name in ["PATH", "CROSSGRAIN_KRATOS"] {
            program.env(name, folder.as_os_str());
        }
        program.args("engine table --grains 50 --quiet".words());
        told(&program.args(more).output().expect("the program starts"))
    };
    let (code, text, errors) = table(&["toy", "lammps", "kratos"]);
    assert_eq!(code, 3, "{text}{errors}");
    has(&text, ["1 identical, 2 not installed", "apt-get install"]);
    has(&text, ["bin/pip install"]);
    let (code, text, errors) = table(&["--installed", "toy", "lammps"]);
    assert_eq!(code, 0, "{text}{errors}");
    let (code, _, errors) = table(&["lamps"]);
    assert_eq!(code, 2);
    has(&errors, ["yade-sorted, yade-ordinary, lammps"]);
}
