//! The largest stable steps in an external engine, found by the trials that YADE's are found by.

use crossgrain::checks::{Check, Outcome};
use crossgrain::engine::exec::{ExternalEngine, Options};
use crossgrain::limits::stability::spheres::{MODULI, bed_scene};
use crossgrain::limits::stability::{Map, Row, Stability};
use crossgrain::report;
use crossgrain::study::folder::{AnyStudy as _, StudyFolder};
use crossgrain::study::realization::Runner;

use crate::support::*;
use crate::tradeoff::tried;

/// The map of the small scenes of these names in the engine.
fn map(options: &Options, names: &[&str]) -> Map {
    let engine = ExternalEngine::ask(options.clone()).expect("an engine");
    let plan = Stability::new(false, Some(Runner::External), true, false);
    map_of(plan, Some(engine), names)
}

/// Planned, run and reported as a study.
fn map_of(mut plan: Stability, engine: Option<ExternalEngine>, names: &[&str]) -> Map {
    plan.scenes.retain(|name| names.contains(&name.as_str()));
    let (_place, folder, ended) = tried(plan, engine);
    ended.expect("trials");
    let study = StudyFolder::<Stability>::open(&folder).expect("a study");
    let report = study.judge().expect("a report");
    serde_json::from_str(&report.text).expect("a map")
}

/// The outcomes of the engine's checks of a scene.
fn outcomes(checks: &[Check], row: &Row) -> Vec<Outcome> {
    let id = format!("stability/{}/", row.name);
    let of_row = checks
        .iter()
        .filter(|check| check.id.starts_with(&id) && check.id.ends_with("/external"));
    of_row.map(|check| check.outcome).collect()
}

/// Found, without damping and with, as near to the prediction as the trials come.
fn is_as_predicted(map: &Map, row: &Row) {
    for limits in [row.undamped, row.damped] {
        let found = limits.external.expect("a limit was found").limit();
        let off = found / limits.predicted - 1.0;
        assert!(off.abs() < 0.01, "{}: {off}", row.name);
        assert!(limits.native.is_none());
    }
    assert_eq!(outcomes(&map.checks(), row), [Outcome::Pass; 2]);
    assert_eq!(row.skipped, None);
}

#[test]
fn limits_in_the_toy_are_the_predicted_ones() {
    let options = Options::new(adapter_path("toy.py"));
    let map = map(&options, &["one-contact", "grain-on-wall", "unequal-sizes"]);
    assert_eq!(map.rows.len(), 3);
    map.rows.iter().for_each(|row| is_as_predicted(&map, row));
    assert_eq!(map.verdict(), Outcome::Pass);
}

/// Its own proposals too, which an engine that is given no spheres would not make.
#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn limits_of_spheres_in_yade_are_the_predicted_ones() {
    let mut plan = Stability::new(false, Some(Runner::YadeSorted), true, true);
    plan.grains = 40;
    plan.scene_digest = bed_scene(plan.grains, MODULI[0]).digest();
    let names = [
        "sticking-sphere",
        "rolling-sphere",
        "damped-sphere",
        "rough-bed-1e6",
        "rolling-bed-1e6",
    ];
    let map = map_of(plan, None, &names);
    assert_eq!(map.rows.len(), names.len());
    for row in &map.rows {
        // Damped beds are found up to some per cent above, which the map's own checks allow.
        if row.spheres.is_some_and(|spheres| spheres.bearing.is_none()) {
            is_as_predicted(&map, row);
        }
        let of_yade = row.proposal_of_yade.expect("YADE proposes");
        assert!((of_yade.p_wave / row.proposal.p_wave - 1.0).abs() < 1.0e-6);
    }
    assert_eq!(map.verdict(), Outcome::Pass);
}

#[test]
fn scenes_of_parts_that_the_engine_lacks_are_skipped_and_no_failures() {
    let options = Options::new(adapter_path("toy.py"));
    let names = ["sticking-grain", "punch-corner", "dashpot-0.5"];
    let lacking = ["tangential_spring", "punch (punch)", "dashpots"];
    let map = map(&options, &names);
    for (row, lacking) in map.rows.iter().zip(lacking) {
        let reason = row.skipped.as_ref().expect("skipped");
        has(reason, ["toy has no", lacking]);
        assert_eq!(outcomes(&map.checks(), row), [Outcome::Skipped]);
    }
    // An engine that has the parts for no scene has shown nothing.
    assert_eq!(map.verdict(), Outcome::Skipped);
}

/// The page has the engine's name over its columns, and says what was skipped. The failure modes of the native engine are
/// none of this engine's checks.
#[test]
fn the_page_names_the_engine_and_what_it_lacks() {
    let options = Options::new(adapter_path("toy.py"));
    let map = map(&options, &["grain-on-wall", "punch-corner"]);
    assert_eq!(map.verdict(), Outcome::Pass);
    let document = map.document();
    let html = report::page(&document).html;
    for words in [
        "toy 1 made the trials. It does not have the parts for 1 scenes.",
        "toy with damping</th>",
        "toy has no punch (punch)",
    ] {
        assert!(html.contains(words), "{words}");
    }
    let failures = document
        .checks
        .iter()
        .filter(|check| check.id.contains("/failures/"));
    assert_eq!(failures.count(), 0);
    let json = serde_json::to_value(&map).expect("JSON");
    assert_eq!(json["external"]["name"], "toy");
    assert!(json["rows"][0]["damped"]["external"]["stable"].is_number());
    assert!(json["rows"][1]["skipped"].is_string());
}

#[test]
fn what_the_engine_refuses_is_skipped_in_its_own_words() {
    let folder = &new_folder();
    let toy = changed_toy("len(grains) > 200", "len(grains) == 2");
    let options = Options::new(program(folder, "shy.py", &toy));
    let map = map(&options, &["one-contact", "grain-on-wall"]);
    let refused = &map.rows[0];
    let why = refused.skipped.as_deref();
    assert_eq!(why, Some("toy refused: more than 200 grains"));
    assert_eq!(outcomes(&map.checks(), refused), [Outcome::Skipped]);
    is_as_predicted(&map, &map.rows[1]);
}

#[test]
fn springs_that_are_too_soft_are_seen_by_the_limit() {
    let folder = &new_folder();
    let toy = changed_toy("2.0 * a * a / (a + a)", "0.9 * a");
    let options = Options::new(program(folder, "soft.py", &toy));
    let map = map(&options, &["grain-on-wall"]);
    let row = &map.rows[0];
    assert_eq!(outcomes(&map.checks(), row), [Outcome::Fail; 2]);
    let off = row.undamped.external.expect("a limit").limit() / row.undamped.predicted;
    assert!((off - 0.9f64.powf(-0.5)).abs() < 0.01, "{off}");
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs LAMMPS and LIGGGHTS")]
fn limits_in_lammps_and_liggghts_are_the_predicted_ones() {
    for adapter in ["lammps.py", "liggghts.py"] {
        let options = Options::new(adapter_path(adapter));
        let map = map(&options, &["grain-on-wall", "chain"]);
        map.rows.iter().for_each(|row| is_as_predicted(&map, row));
    }
}
