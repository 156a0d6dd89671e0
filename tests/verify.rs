//! The verification suite: it passes, it can fail, and what was skipped is never shown as passed.

use crossgrain::checks::Outcome;
use crossgrain::engine::yade;
use crossgrain::suite::detection::{Limit, limits};
use crossgrain::suite::run::{Options, Role, Suite, verify};
use crossgrain::suite::{Evidence, parameters};
use grains::rules::Rules;
use grains::scene::{ContactLaw, NewContactSlip, Tension, Viscosity};

use crate::support::*;

fn options(with_yade: bool) -> Options {
    let missing = yade::Options {
        program: Some(PathBuf::from("/no/such/yade")),
        ..yade::Options::default()
    };
    Options {
        native: true,
        grains: 5,
        detection_limits: false,
        yade: with_yade.then_some(missing),
        command: "a test".to_owned(),
    }
}

/// The native cases pass with or without a YADE, which is missing here: what needs it is skipped, in each role.
#[test]
fn native_cases_pass_and_without_yade_its_cases_are_skipped() {
    let found = verify(&options(false), &Display::new(true)).expect("a verification");
    assert_eq!(found.verdict(), Outcome::Pass);
    assert!(found.cases.len() > 40, "{}", found.cases.len());
    for case in &found.cases {
        assert_eq!(case.outcome, Outcome::Pass, "{case:?}");
        assert!(!case.checks.is_empty(), "{}", case.id);
    }
    let found = verify(&options(true), &Display::new(true)).expect("a verification");
    assert_eq!(found.verdict(), Outcome::Skipped);
    assert_eq!(found.tally.failed, 0);
    for case in &found.cases {
        let (outcome, alone) = match case.role {
            Role::Tested => (Outcome::Pass, true),
            _ => (Outcome::Skipped, false),
        };
        assert_eq!(case.outcome, outcome, "{} {:?}", case.id, case.role);
        assert_eq!(case.reason.is_empty(), alone, "{}", case.id);
    }
    let count = |evidence: Evidence| {
        let cases = found.cases.iter().filter(|case| case.evidence == evidence);
        cases.count()
    };
    assert!(count(Evidence::CrossCode) > 10 && count(Evidence::Precision) == 1);
    // Ids name the part that an engine has, and never the engine.
    let checks = found.checks();
    for check in &checks {
        assert!(check.id.starts_with("verify/"), "{}", check.id);
        let named = ["yade", "native"].map(|engine| check.id.contains(engine));
        assert_eq!(named, [false; 2], "{}", check.id);
    }
    let ids: BTreeSet<&str> = checks.iter().map(|check| check.id.as_str()).collect();
    assert_eq!(ids.len(), checks.len());
}

#[test]
fn a_case_that_was_shown_nothing_fails() {
    let mut suite = Suite::new(5, Rules::default());
    for group in &mut suite.groups {
        for case in &mut group.cases {
            case.moments.clear();
        }
    }
    for case in suite.run_native() {
        assert_eq!(case.outcome, Outcome::Fail, "{}", case.id);
    }
}

/// What must hold without YADE: every fault is detected, every case detects one, none has false positives.
#[test]
fn every_fault_is_detected_by_the_native_suite() {
    let table = limits(&Suite::new(0, Rules::default()), &[], &[], None, &|_, _| {});
    for check in table.checks() {
        assert_eq!(check.outcome, Outcome::Pass, "{check:?}");
    }
    // Where a fault of this kind is seen only if it is gross, another case sees it small.
    let row = |id: &str| table.cases.iter().find(|row| row.case == id);
    let gravity = table.faults.iter().position(|fault| fault == "gravity");
    let seen = row("repeated-bounces").zip(gravity);
    let seen = seen.map(|(row, at)| row.limits[at]);
    let large = matches!(seen, Some(Limit::From { size }) if size > 1e-6);
    assert!(large, "{seen:?}");
}

#[test]
fn the_command_line_says_what_was_skipped() {
    let folder = &new_folder();
    let verify = "verify --grains 5 --json --quiet --yade /no/such --out verified";
    let found = prints(folder, 3, verify);
    assert_eq!(found["verdict"], "skipped");
    assert_eq!(found["tally"]["failed"], 0);
    let page = text_of(folder.join("verified/report.html"));
    has(&page, ["Incomplete", "Inside a grain", "leapfrog-sticking"]);
    // An earlier result keeps all that it has, under another name; a folder of somebody else's is left alone.
    let (_, _, errors) = say(folder, verify);
    has(&errors, ["verified-2 now"]);
    let kept = text_of(folder.join("verified-2/report.html"));
    assert_eq!(kept, page);
    fs::remove_file(folder.join("verified/verify.json")).expect("a file");
    tells(folder, 2, verify, ["exists already"]);
}

#[test]
fn parameters_are_those_of_the_scene() {
    let mut scene = small_scene();
    scene.material.friction_angle = 0.4;
    scene.material.wall_friction_angle = Some(0.2);
    scene.material.punch_friction_angle = Some(0.1);
    scene.material.stiffness_ratio = 0.3;
    let folder = &folder_with(&scene);
    let found = prints(
        folder,
        0,
        "scene parameters scene.json --engine native --json",
    );
    let values = |symbol: &str| -> Vec<f64> {
        let all = found.as_array().expect("an array").iter();
        let with = all.filter(|parameter| parameter["symbol"] == symbol);
        with.filter_map(|parameter| parameter["value"].as_f64())
            .collect()
    };
    // The wall's contact with the mean grain: E·R.
    let mean = 0.5 * scene.particles.mean_diameter;
    let stiffness = scene.material.youngs_modulus * mean;
    let near = |values: &[f64], wanted: f64| {
        let mut off = values.iter().map(|value| (value / wanted - 1.0).abs());
        off.any(|off| off < 1e-14)
    };
    assert!(near(&values("k_n"), stiffness), "{:?}", values("k_n"));
    assert!(near(&values("k_s"), 0.3 * stiffness), "{:?}", values("k_s"));
    for angle in [0.4f64, 0.2, 0.1] {
        assert!(
            near(&values("tan_phi"), angle.tan()),
            "{:?}",
            values("tan_phi")
        );
    }
    assert!(near(
        &values("I"),
        0.5 * scene.grain_mass(mean) * mean * mean
    ));
    assert_eq!(values("dt"), [scene.time_step_seconds()]);
    assert_eq!(values("alpha"), [0.2]);
}

#[test]
fn parameters_that_differ_are_seen() {
    let scene = small_scene();
    let sound = parameters::of_native(&scene).expect("parameters");
    let mut other = scene.clone();
    other.material.youngs_modulus *= 1.0 + 1e-13;
    let faulty = parameters::of_native(&other).expect("parameters");
    let judged = |other: &[_]| {
        let table = parameters::side_by_side(sound.clone(), other);
        parameters::outcome(&table)
    };
    assert_eq!(judged(&sound), Some(Outcome::Pass));
    assert_eq!(judged(&faulty), Some(Outcome::Fail));
    // An engine that does not tell is no engine that agrees.
    assert_eq!(judged(&[]), Some(Outcome::Fail));
}

#[test]
fn parameters_of_a_missing_yade_are_an_engine_failure() {
    let folder = &folder_with(&small_scene());
    let command = "scene parameters scene.json --engine both --yade /no/such";
    tells(folder, 4, command, ["apt-get install"]);
}

/// Each option that YADE does not have is refused before YADE is looked for, with the key to change.
#[test]
fn what_yade_does_not_have_is_refused_by_key() {
    let dashpot = |tension| Viscosity::Dashpot { c_n: 10.0, tension };
    let tension = Tension::Clipped;
    let restitution = Viscosity::Restitution { e_n: 0.5, tension };
    let (none, whole) = (Viscosity::None, NewContactSlip::WholeStep);
    for (key, viscosity, new_contact_slip) in [
        ("viscosity.tension", dashpot(Tension::Unclipped), whole),
        ("viscosity.kind", restitution, whole),
        ("new_contact_slip", none, NewContactSlip::SinceTouch),
        ("slip_velocity", dashpot(tension), whole),
    ] {
        let mut scene = small_scene();
        scene.material.friction_angle = 0.4;
        scene.contact = ContactLaw {
            viscosity,
            new_contact_slip,
            ..ContactLaw::default()
        };
        let folder = &folder_with(&scene);
        let (_, message) = ends(folder, 2, "run scene.json --engine yade --out o");
        let named = message.contains(&format!("contact.{key}"));
        assert!(named, "{key}: {message}");
    }
}
