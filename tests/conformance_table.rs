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
    for view in ["conformance.md", "report.html", "figures/engines.csv"] {
        let text = read_text(&folder.join("table").join(view), 1 << 24).expect("a view");
        has(&text, ["ESyS-Particle", "equal to rounding"]);
    }
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
