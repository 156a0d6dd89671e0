//! A run in parts is the run.

use crossgrain::engine::exec::{ExternalEngine, Options};
use crossgrain::engine::{Engine, yade};
use crossgrain::run::{folder::recorded_history, parts};
use grains::scene::AfterForce;
use grains::task::Seen;

use crate::support::*;

/// The first before a grain touches three others, the last after the energy has fallen.
const CUTS: [u64; 3] = [500, 7250, 13_000];

fn whole(scene: &Scene, engine: &dyn Engine) -> RunFolder {
    run_of(scene, engine, Protocol::Whole)
}

/// Read again from its folder.
fn in_parts(scene: &Scene, engine: &dyn Engine, cuts: &[u64]) -> RunFolder {
    let folder = &new_folder();
    let out = folder.join("run");
    parts::to_folder(scene, engine, cuts, &out, &Display::new(true)).expect("a run");
    read_run(&out)
}

/// All but times, and how many parts it is of.
fn is_of_parts(run: &RunFolder, whole: &RunFolder, parts: usize) {
    let steps = |run: &RunFolder| -> Vec<(Stage, u64, StopReason)> {
        let stages = run.record.stages.iter();
        stages
            .map(|stage| (stage.stage, stage.steps, stage.stop))
            .collect()
    };
    assert_eq!(steps(run), steps(whole));
    assert_eq!(run.history, whole.history);
    assert_eq!(run.trace, whole.trace);
    let bits = |run: &RunFolder| (run.last.bodies.digest(), run.initial.digest());
    assert_eq!(bits(run), bits(whole));
    assert_eq!(run.last, whole.last);
    assert_eq!(run.settled, whole.settled);
    assert_eq!(run.record.command, whole.record.command);
    assert_eq!(run.record.measures, whole.record.measures);
    assert_eq!((run.record.parts, whole.record.parts), (Some(parts), None));
}

#[test]
fn parts_are_the_whole_run() {
    let engine = sound();
    let mut standing = small_scene();
    standing.loading.after_force = AfterForce::StandStill { seconds: 0.02 };
    let mut restless = small_scene();
    restless.settle.max_steps = 9000;
    for (scene, cuts, parts) in [
        (small_scene(), &CUTS[..], 5),
        (standing, &CUTS[1..2], 3),
        (restless, &CUTS, 3),
    ] {
        let run = in_parts(&scene, &engine, cuts);
        is_of_parts(&run, &whole(&scene, &engine), parts);
    }
}

/// Of an engine that has other bits than the native one, what follows a seam is nobody's run.
#[test]
fn parts_that_do_not_fit_are_left_away() {
    let scene = small_scene();
    for (fault, parts) in [
        ("gravity=1e-12", 2),
        // Up to the first cut no grain touches three others.
        ("sums=reversed", 3),
    ] {
        let engine = faulty(fault);
        let run = in_parts(&scene, &engine, &CUTS);
        is_of_parts(&run, &whole(&scene, &engine), parts);
        assert_ne!(run.last, whole(&scene, &sound()).last);
    }
}

#[test]
fn a_part_that_fails_leaves_no_folder() {
    let folder = &new_folder();
    let out = folder.join("run");
    let parts =
        "['normal_spring', 'local_damping', 'gravity', 'walls', 'stages', 'punch', 'stop_rules']";
    let text =
        format!("{SOUND}SAY = lambda: describe(parts={parts})\n{AND_THEN}sys.exit('no licence')\n");
    let program = program(folder, "engine.py", &text);
    let engine = ExternalEngine::ask(Options::new(program)).expect("an engine");
    let display = Display::new(true);
    let error = parts::to_folder(&small_scene(), &engine, &CUTS, &out, &display);
    assert!(error.is_err_and(|error| error.to_string().contains("no licence")));
    assert!(!out.exists());
}

#[test]
fn a_long_run_without_memory_is_cut_into_ever_longer_parts() {
    let history = recorded_history().expect("a history");
    let scene = paper_scene(1, 5000);
    let cuts = parts::cuts(&scene, &history);
    assert!((6..12).contains(&cuts.len()), "{cuts:?}");
    let contacts = |from: u64, to: u64| -> u64 {
        let settling = history.iter().filter(|row| row.stage == Stage::Settle);
        let part = settling.filter(|row| (from..to).contains(&row.step));
        part.map(|row| row.contacts).sum()
    };
    let ends = cuts.iter().chain([&42_000]);
    let begins = [0].iter().chain(&cuts);
    let works: Vec<u64> = begins.zip(ends).map(|(a, b)| contacts(*a, *b)).collect();
    assert!(works.is_sorted(), "{works:?}");
    let all: u64 = works.iter().sum();
    let longest = works.last().expect("a part");
    assert!(all > 3 * longest, "a core would wait for it: {works:?}");
    assert!(cuts.iter().all(|step| step % 250 == 0), "{cuts:?}");

    let none: [u64; 0] = [];
    assert_eq!(parts::cuts(&scene, &history[..20]), none, "it is short");
    let mut unseen = scene.clone();
    unseen.settle.check_every = 1001;
    // It looks between moments.
    assert_eq!(parts::cuts(&unseen, &history), none);
    let mut rough = frictional_scene();
    rough.particles.count = 5000;
    assert_eq!(parts::cuts(&rough, &history), none, "contacts remember");
}

/// The state after so many steps of pouring.
fn poured(scene: &Scene, steps: u64) -> Start {
    let (outcome, _) = native_outcome(scene, &Task::pour(initial_bodies(scene), steps), None);
    outcome.last.into()
}

#[test]
fn the_settle_rule_counts_the_energy_that_was_seen_before() {
    let scene = small_scene();
    let settles_at = |energy| {
        let start = Start {
            seen: Seen {
                energy,
                ..Seen::default()
            },
            ..poured(&scene, 5000)
        };
        let until = Until::EndOfSettling;
        let task = Task { start, until };
        let outcome = native::run(&scene, &task, &sound(), &mut ()).expect("a run");
        outcome.stages[0].steps
    };
    assert_eq!(settles_at(1.0e9), 6000, "the first look");
    assert!(settles_at(0.0) > 6000);
}

#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn yade_in_parts_is_yade_as_a_whole() {
    let engine = yade::Options::default();
    let mut standing = small_scene();
    standing.realization = 3;
    standing.loading.after_force = AfterForce::StandStill { seconds: 0.02 };
    for scene in [small_scene(), standing] {
        let run = in_parts(&scene, &engine, &CUTS);
        is_of_parts(&run, &whole(&scene, &engine), 5);
    }
}
