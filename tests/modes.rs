//! Modes without YADE's bits: labelled, repeatable, and refused where they do not exist.

use crossgrain::checks::Outcome;
use crossgrain::compare::compare;
use crossgrain::run::folder::record::Protocol;
use grains::generate::initial_bodies;
use grains::native::{self, Mode, Trouble};
use grains::scene::Scene;
use grains::tables::StopReason;
use grains::task::{Task, Until};

use crate::support::{
    crossgrain, folder_with, frictional_scene, native_run, small_scene, sound, told,
};

fn in_mode(mode: Mode) -> native::Options {
    native::Options {
        mode,
        ..native::Options::default()
    }
}

#[test]
fn free_and_single_are_labelled_repeatable_and_near() {
    let scene = small_scene();
    let exact = native_run(&scene, sound(), Protocol::Whole);
    let value = |run: &crossgrain::run::folder::RunFolder, key: &str| {
        let found = run.record.measures.iter().find(|of| of.key == key);
        found.expect(key).value
    };
    for mode in [Mode::Free, Mode::Single] {
        let one = native_run(&scene, in_mode(mode), Protocol::Whole);
        let again = native_run(&scene, in_mode(mode), Protocol::Whole);
        assert_eq!(one.last, again.last);
        assert!(one.record.engine.label().contains(mode.name()));
        assert!(
            one.record
                .command
                .contains(&format!("--mode {}", mode.name()))
        );
        assert_ne!(one.last, exact.last);
        let key = "settled.height.mean_surface";
        let (found, expected) = (value(&one, key), value(&exact, key));
        assert!(
            (found - expected).abs() < 0.05 * expected,
            "{found}, {expected}"
        );

        // Not a failure of either: their bits were never promised.
        let comparison = compare(&exact, &one, None);
        assert!(!comparison.bits_expected);
        for check in &comparison.checks {
            assert_ne!(
                check.outcome,
                Outcome::Fail,
                "{}: {}",
                check.quantity,
                check.found
            );
        }
    }
}

#[test]
fn friction_is_computed_in_exact_mode_only_and_the_message_says_so() {
    let scene = frictional_scene();
    let task = Task::pour(initial_bodies(&scene), 10);
    let error =
        native::run(&scene, &task, &in_mode(Mode::Free), &mut ()).expect_err("no such kernel");
    assert_eq!(error.trouble, Trouble::OnlyExact { mode: "free" });
    let (folder, _) = folder_with(&scene);
    let output = crossgrain(
        &[
            "run",
            "scene.json",
            "--engine",
            "native",
            "--mode",
            "free",
            "--out",
            "free",
        ],
        folder.path(),
    );
    let (code, _, message) = told(&output);
    assert_eq!(code, 2);
    assert!(message.contains("exact mode only"), "{message}");
    assert!(!folder.path().join("free").exists());
}

#[test]
fn a_task_may_end_with_settling() {
    let scene = small_scene();
    let whole = Task::whole(initial_bodies(&scene));
    let settle = Task::settle(initial_bodies(&scene));
    assert_eq!(settle.until, Until::EndOfSettling);
    let whole = native::run(&scene, &whole, &sound(), &mut ()).expect("a sound run");
    let settled = native::run(&scene, &settle, &sound(), &mut ()).expect("a sound run");
    assert_eq!(settled.stages.len(), 1);
    assert_eq!(settled.stages[0].stop, StopReason::Settled);
    let bed = whole.settled.expect("a settled bed");
    assert_eq!(settled.last.bodies, bed.bodies);
    assert_eq!(settled.last.contacts, bed.contacts);
}

/// So many steps of a settled bed between two looks of anybody: what a steady step allocates would show.
fn allocations(mut scene: Scene, mode: Mode, steps: u64) -> u64 {
    scene.measurement.history_every = 1_000_000;
    let bed = native::run(
        &scene,
        &Task::settle(initial_bodies(&scene)),
        &sound(),
        &mut (),
    );
    let start = Task::settle(bed.expect("a sound run").last.bodies);
    let task = Task {
        until: Until::Step(steps),
        ..start
    };
    allocation_counter::measure(|| {
        native::run(&scene, &task, &in_mode(mode), &mut ()).expect("a sound run");
    })
    .count_total
}

#[test]
fn a_steady_step_allocates_nothing() {
    let mut rough = small_scene();
    rough.material.friction_angle = 0.5;
    let smooth = [Mode::Exact, Mode::Free, Mode::Single].map(|mode| (small_scene(), mode));
    for (scene, mode) in smooth.into_iter().chain([(rough, Mode::Exact)]) {
        let short = allocations(scene.clone(), mode, 200);
        let long = allocations(scene, mode, 900);
        assert!(short > 0, "starting a run allocates");
        // The table at the end grows with its contacts; 700 steps of their own would show.
        assert!(long < short + 20, "{} mode: {short}, {long}", mode.name());
    }
}

#[test]
fn the_free_modes_scene_differs_in_the_step_and_what_goes_with_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let printed = |arguments: &[&str]| -> serde_json::Value {
        let (code, text, _) = told(&crossgrain(arguments, folder.path()));
        assert_eq!(code, 0);
        serde_json::from_str(&text).expect("JSON")
    };
    let plain = printed(&["scene", "paper"]);
    let mut free = printed(&["scene", "paper", "--free"]);
    let step = "/time_step/of_sqrt_m_over_k";
    assert_eq!(plain.pointer(step), Some(&0.45.into()));
    assert_eq!(free.pointer(step), Some(&0.65.into()));
    // Looked at equally often in time.
    let every = |of: &serde_json::Value| of.pointer("/settle/check_every").and_then(|n| n.as_f64());
    let ratio = every(&plain).expect("a number") / every(&free).expect("a number");
    assert!((ratio - 0.65 / 0.45).abs() < 0.01, "{ratio}");
    for key in ["time_step", "settle", "measurement", "choices"] {
        free[key] = plain[key].clone();
    }
    assert_eq!(free, plain);
}
