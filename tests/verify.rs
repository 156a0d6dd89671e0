//! The ladder: it passes, it can fail, and what was not climbed is never shown as passed.

use std::path::PathBuf;

use crossgrain::compare::Verdict;
use crossgrain::engine::yade;
use crossgrain::progress::Display;
use crossgrain::suite::Group;
use crossgrain::suite::facts;
use crossgrain::suite::ladder::{Climbers, Ladder};
use crossgrain::suite::limits::{FromYade, Limit, limits};
use crossgrain::suite::record::{Options, verify};
use grains::scene::{ContactLaw, NewContactSlip, Scene, Tension, Viscosity};
use serde_json::Value;

use crate::support::{crossgrain, small_scene};

fn options(engine: Climbers) -> Options {
    Options {
        engine,
        grains: 5,
        detection_limits: false,
        yade: yade::Options {
            program: Some(PathBuf::from("/no/such/yade")),
            ..yade::Options::default()
        },
        command: "a test".to_owned(),
    }
}

#[test]
fn every_native_rung_passes() {
    let found = verify(&options(Climbers::Native), &Display::new(true)).expect("a verification");
    for rung in &found.rungs {
        assert_eq!(rung.verdict, Verdict::Pass, "{rung:?}");
        assert!(!rung.lines.is_empty(), "{}", rung.name);
    }
    assert_eq!(found.verdict, Verdict::Pass);
    assert!(found.rungs.len() > 40, "{}", found.rungs.len());
}

#[test]
fn without_yade_its_rungs_are_not_made() {
    let found = verify(&options(Climbers::Both), &Display::new(true)).expect("a verification");
    assert_eq!(found.verdict, Verdict::NotMade);
    assert_eq!(found.tally.failed, 0);
    for rung in &found.rungs {
        let alone = rung.engine == "native";
        let expected = if alone {
            Verdict::Pass
        } else {
            Verdict::NotMade
        };
        assert_eq!(rung.verdict, expected, "{} {}", rung.name, rung.engine);
        assert_eq!(rung.reason.is_empty(), alone, "{}", rung.name);
    }
    let of = |group: Group| {
        found
            .rungs
            .iter()
            .filter(|rung| rung.group == group)
            .count()
    };
    assert!(of(Group::Parity) > 10 && of(Group::Precision) == 1);
}

#[test]
fn a_rung_that_was_shown_nothing_fails() {
    let mut ladder = Ladder::new(5);
    for rung in &mut ladder.solo {
        for case in &mut rung.cases {
            case.moments.clear();
        }
    }
    for rung in ladder.climb_native() {
        assert_eq!(rung.verdict, Verdict::Fail, "{}", rung.name);
    }
}

/// What must hold without YADE: every fault is noticed, every rung notices one, none cries wolf.
#[test]
fn every_fault_is_noticed_by_the_native_ladder() {
    let table = limits(&Ladder::new(0), FromYade::default(), &|_, _| {});
    for line in table.lines() {
        assert!(line.holds(), "{line:?}");
    }
    // Where a fault of this kind is seen only if it is gross, another rung sees it small.
    let row = |name: &str| table.rungs.iter().find(|row| row.rung == name);
    let gravity = table.faults.iter().position(|fault| fault == "gravity");
    let seen = row("repeated-bounces")
        .zip(gravity)
        .map(|(row, at)| row.limits[at]);
    assert!(
        matches!(seen, Some(Limit::From { size }) if size > 1e-6),
        "{seen:?}"
    );
}

#[test]
fn the_command_line_says_what_was_not_made() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("verified");
    let out = out.to_str().expect("a plain path");
    let arguments = [
        "verify", "--grains", "5", "--json", "--quiet", "--yade", "/no/such", "--out", out,
    ];
    let output = crossgrain(&arguments, folder.path());
    assert_eq!(output.status.code(), Some(3));
    let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(found["verdict"], "not_made");
    assert_eq!(found["tally"]["failed"], 0);
    let page = std::fs::read_to_string(folder.path().join("verified/report.html")).expect("a page");
    assert!(page.contains("Incomplete") && page.contains("class=\"disc-field\""));
    let again = crossgrain(&arguments, folder.path());
    assert_eq!(
        again.status.code(),
        Some(2),
        "the folder is not overwritten"
    );
}

fn written(scene: &Scene) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let text = serde_json::to_string(scene).expect("JSON");
    std::fs::write(folder.path().join("scene.json"), text).expect("writable");
    (folder, "scene.json".to_owned())
}

#[test]
fn facts_are_those_of_the_scene() {
    let mut scene = small_scene();
    scene.material.friction_angle = 0.4;
    scene.material.stiffness_ratio = 0.3;
    let (folder, path) = written(&scene);
    let output = crossgrain(
        &["facts", &path, "--engine", "native", "--json"],
        folder.path(),
    );
    assert_eq!(output.status.code(), Some(0));
    let facts: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let of = |symbol: &str| -> Vec<f64> {
        let facts = facts.as_array().expect("an array").iter();
        let with = facts.filter(|fact| fact["symbol"] == symbol);
        with.filter_map(|fact| fact["value"].as_f64()).collect()
    };
    // The wall's contact with the mean grain: E·R.
    let mean = 0.5 * scene.particles.mean_diameter;
    let stiffness = scene.material.youngs_modulus * mean;
    let near = |values: &[f64], wanted: f64| {
        values
            .iter()
            .any(|value| (value / wanted - 1.0).abs() < 1e-14)
    };
    assert!(near(&of("k_n"), stiffness), "{:?}", of("k_n"));
    assert!(near(&of("k_s"), 0.3 * stiffness), "{:?}", of("k_s"));
    assert!(near(&of("tan_phi"), 0.4f64.tan()));
    assert!(near(&of("I"), 0.5 * scene.grain_mass(mean) * mean * mean));
    assert_eq!(of("dt"), [scene.time_step_seconds()]);
    assert_eq!(of("alpha"), [0.2]);
}

#[test]
fn facts_that_differ_are_seen() {
    let scene = small_scene();
    let sound = facts::of_native(&scene).expect("facts");
    let mut other = scene.clone();
    other.material.youngs_modulus *= 1.0 + 1e-13;
    let faulty = facts::of_native(&other).expect("facts");
    let same = facts::side_by_side(sound.clone(), &sound);
    assert_eq!(facts::verdict(&same), Some(Verdict::Pass));
    let apart = facts::side_by_side(sound.clone(), &faulty);
    assert_eq!(facts::verdict(&apart), Some(Verdict::Fail));
    // An engine that does not tell is no engine that agrees.
    let silent = facts::side_by_side(sound, &[]);
    assert_eq!(facts::verdict(&silent), Some(Verdict::Fail));
}

#[test]
fn facts_of_a_missing_yade_are_an_engine_failure() {
    let (folder, path) = written(&small_scene());
    let arguments = ["facts", &path, "--engine", "both", "--yade", "/no/such"];
    let output = crossgrain(&arguments, folder.path());
    assert_eq!(output.status.code(), Some(4));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("apt-get install"), "{message}");
}

/// Each option that YADE does not have is refused before YADE is looked for, with the key to change.
#[test]
fn what_yade_does_not_have_is_refused_by_key() {
    let rough = |contact: ContactLaw| {
        let mut scene = small_scene();
        scene.material.friction_angle = 0.4;
        scene.contact = contact;
        scene
    };
    let dashpot = |tension| Viscosity::Dashpot { c_n: 10.0, tension };
    let cases = [
        (
            "contact.viscosity.tension",
            ContactLaw {
                viscosity: dashpot(Tension::Unclipped),
                ..ContactLaw::default()
            },
        ),
        (
            "contact.viscosity.kind",
            ContactLaw {
                viscosity: Viscosity::Restitution {
                    e_n: 0.5,
                    tension: Tension::Clipped,
                },
                ..ContactLaw::default()
            },
        ),
        (
            "contact.new_contact_slip",
            ContactLaw {
                new_contact_slip: NewContactSlip::SinceTouch,
                ..ContactLaw::default()
            },
        ),
        (
            "contact.slip_velocity",
            ContactLaw {
                viscosity: dashpot(Tension::Clipped),
                ..ContactLaw::default()
            },
        ),
    ];
    for (key, contact) in cases {
        let (folder, path) = written(&rough(contact));
        let arguments = ["run", &path, "--engine", "yade", "--out", "o"];
        let output = crossgrain(&arguments, folder.path());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{key}: {message}");
        assert!(message.contains(key), "{key}: {message}");
    }
}
