//! The largest stable steps in an engine that was brought, found by the trials that YADE's are found by.

use crossgrain::compare::Verdict;
use crossgrain::engine::exec::{Brought, Options};
use crossgrain::limits::stability::draft::Draft;
use crossgrain::limits::stability::map::{ALLOWED, Map, Row, STABILITY_VERSION, Tally, Wanted};
use crossgrain::limits::stability::others::look_in_exec;
use crossgrain::limits::stability::scenes::small;
use crossgrain::progress::Display;
use crossgrain::report;

use crate::support::engines::{adapter_path, changed_toy, program};

/// The rows of the small scenes of these names in the engine.
fn rows(options: &Options, names: &[&str]) -> Vec<Row> {
    let scenes = small()
        .into_iter()
        .filter(|scene| names.contains(&scene.name.as_str()));
    let mut drafts: Vec<Draft> = scenes
        .map(|scene| Draft::new(scene, false).expect("a prediction"))
        .collect();
    let engine = Brought::ask(options.clone()).expect("an engine");
    look_in_exec(&mut drafts, &engine, &Display::new(true)).expect("trials");
    let wanted = Wanted::Exec(engine);
    drafts
        .into_iter()
        .map(|draft| draft.judged(&wanted))
        .collect()
}

fn verdicts(row: &Row, of: &str) -> Vec<Verdict> {
    let checks = row.checks.iter().filter(|check| check.name.contains(of));
    checks.map(|check| check.verdict).collect()
}

/// Found, without damping and with, as near to the prediction as the trials come.
fn is_as_predicted(row: &Row, engine: &str) {
    for limits in [row.undamped, row.damped] {
        let found = limits.exec.expect("a limit was found").limit;
        let off = found / limits.predicted - 1.0;
        assert!(off.abs() < 0.01, "{} in {engine}: {off}", row.name);
        assert!(limits.native.is_none() && limits.yade.is_none());
    }
    assert_eq!(
        verdicts(row, engine),
        [Verdict::Pass; 2],
        "{:?}",
        row.checks
    );
    assert_eq!(row.not_made, None);
}

#[test]
fn limits_in_the_toy_are_the_predicted_ones() {
    let options = Options::new(adapter_path("toy.py"));
    for row in rows(&options, &["one-contact", "grain-on-wall", "unequal-sizes"]) {
        is_as_predicted(&row, "toy");
    }
}

#[test]
fn scenes_of_parts_that_the_engine_lacks_are_not_made_and_no_failures() {
    let options = Options::new(adapter_path("toy.py"));
    let names = ["sticking-grain", "punch-corner", "dashpot-0.5"];
    let lacking = ["tangential_spring", "punch (punch)", "dashpots"];
    for (row, lacking) in rows(&options, &names).iter().zip(lacking) {
        let reason = row.not_made.as_ref().expect("not made");
        assert!(
            reason.contains("toy has no") && reason.contains(lacking),
            "{reason}"
        );
        assert_eq!(verdicts(row, "toy"), []);
    }
}

/// The page has the engine's name over its columns, and says what was not made.
#[test]
fn the_page_names_the_engine_and_what_it_lacks() {
    let options = Options::new(adapter_path("toy.py"));
    let rows = rows(&options, &["grain-on-wall", "punch-corner"]);
    let map = Map {
        version: STABILITY_VERSION,
        crossgrain: "0".to_owned(),
        command: "crossgrain stability --engine exec:PATH".to_owned(),
        scene_digest: String::new(),
        yade: None,
        missing: "YADE was not asked for".to_owned(),
        exec: Some(Brought::ask(options).expect("the toy").description),
        allowed: ALLOWED,
        rows,
        failures: Vec::new(),
        tally: Tally {
            inapplicable: 1,
            ..Tally::default()
        },
        verdict: Verdict::Pass,
        seconds: 1.0,
    };
    let page = report::stability::page(&map).expect("a page");
    for words in [
        "toy 1 ran; 1 scenes are of parts that it does not have",
        "toy, damped</th>",
        "not made: toy has no punch (punch)",
    ] {
        assert!(page.html.contains(words), "{words}");
    }
    // A scene that the engine has no parts for is not green, though its closed form holds.
    assert_eq!(page.html.matches("✓ pass").count(), 1);
    let json = serde_json::to_value(&map).expect("JSON");
    assert_eq!(json["exec"]["name"], "toy");
    assert!(json["rows"][0]["damped"]["exec"]["limit"].is_number());
    assert!(json["rows"][1]["not_made"].is_string());
}

#[test]
fn what_the_engine_refuses_is_not_made_in_its_own_words() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let toy = changed_toy("len(grains) > 200", "len(grains) == 2");
    let options = Options::new(program(folder.path(), "shy.py", &toy));
    let rows = rows(&options, &["one-contact", "grain-on-wall"]);
    assert_eq!(
        rows[0].not_made.as_deref(),
        Some("toy refused: more than 200 grains")
    );
    assert_eq!(verdicts(&rows[0], "toy"), []);
    is_as_predicted(&rows[1], "toy");
}

#[test]
fn springs_that_are_too_soft_are_seen_by_the_limit() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let toy = changed_toy("2.0 * a * a / (a + a)", "0.9 * a");
    let options = Options::new(program(folder.path(), "soft.py", &toy));
    let row = rows(&options, &["grain-on-wall"]).remove(0);
    assert_eq!(
        verdicts(&row, "toy"),
        [Verdict::Fail; 2],
        "{:?}",
        row.checks
    );
    let off = row.undamped.exec.expect("a limit").limit / row.undamped.predicted;
    assert!((off - 0.9f64.powf(-0.5)).abs() < 0.01, "{off}");
}

#[test]
#[cfg_attr(
    not(feature = "exec-engines"),
    ignore = "needs LAMMPS and LIGGGHTS: --features exec-engines"
)]
fn limits_in_lammps_and_liggghts_are_the_predicted_ones() {
    for (adapter, name) in [("lammps.py", "LAMMPS"), ("liggghts.py", "LIGGGHTS")] {
        let options = Options::new(adapter_path(adapter));
        for row in rows(&options, &["grain-on-wall", "chain"]) {
            is_as_predicted(&row, name);
        }
    }
}
