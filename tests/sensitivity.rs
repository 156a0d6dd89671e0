//! The map of what the published figures depend on, on beds small enough for a test.

use crossgrain::progress::Display;
use crossgrain::study::realization::Ending;
use crossgrain::study::sensitivity::choices::{Axis, with_friction, with_hold, with_speed};
use crossgrain::study::sensitivity::job;
use crossgrain::study::sensitivity::judge::Verdict;
use crossgrain::study::sensitivity::plan::Plan;
use crossgrain::study::sensitivity::push::{self, Kind, Push};
use crossgrain::study::sensitivity::record::of_members;
use crossgrain::study::sensitivity::row::{self, Poured};
use crossgrain::study::tradeoff::method::with_tolerance;
use grains::tables::StopReason;

use crate::support::pages::each_figure_stands_once_and_has_numbers;
use crate::support::{crossgrain, frictional_scene, small_scene, told};

/// The small scene as it is, settled much too early, and loaded so slowly that the punch sinks.
fn plan(clouds: u64) -> Plan {
    let mut base = small_scene();
    base.loading.give_up_depth = 0.04;
    let mut plan = Plan {
        settings: Vec::new(),
        pushes: Vec::new(),
        clouds,
        base,
    };
    plan.add(Axis::Settle, "as it is", 1.0e-4, 1, |scene| scene);
    plan.add(Axis::Settle, "hardly settled", 0.05, 1, |scene| {
        with_tolerance(scene, 0.05)
    });
    plan.add(Axis::SpeedAndDamping, "slow", 0.02, 1, |scene| {
        with_speed(scene, 0.02)
    });
    plan
}

#[test]
fn a_bed_poured_once_and_loaded_is_the_whole_run_bit_for_bit() {
    for scene in [
        small_scene(),
        with_speed(small_scene(), 0.3),
        with_hold(small_scene(), 0.01),
    ] {
        let poured = row::pour(&small_scene()).expect("it settles");
        let loaded = row::load("abc", &scene, &poured).expect("it runs");
        let whole = row::whole("abc", &scene).expect("it runs");
        assert!(loaded.last_state.is_some());
        assert_eq!(loaded, whole);
    }
}

/// Contacts with friction remember how they came about; a table of grains does not have it.
#[test]
fn with_friction_a_bed_cannot_be_taken_up_again_and_no_plan_does_so() {
    let mut scene = frictional_scene();
    scene.loading.give_up_depth = 0.02;
    let poured = row::pour(&scene).expect("it runs");
    assert!(matches!(poured, Poured::Bed { settled: true, .. }));
    let loaded = row::load("abc", &scene, &poured).expect("it runs");
    let whole = row::whole("abc", &scene).expect("it runs");
    assert_ne!(loaded.last_state, whole.last_state);
    for plan in [Plan::full(12), Plan::quick(6)] {
        for setting in plan.settings {
            let friction = setting.scene.material.friction_angle > 0.0;
            assert_eq!(setting.can_share_beds(), !friction, "{}", setting.name);
        }
    }
}

#[test]
fn a_map_is_taken_up_where_it_was_and_notices_what_was_moved() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let quiet = Display::new(true);
    let plan = plan(8);
    job::run(&plan, folder.path(), &quiet).expect("it runs");
    let ledger = folder.path().join("members.jsonl");
    let text = std::fs::read_to_string(&ledger).expect("readable");
    assert_eq!(text.lines().count(), 24);

    // Killed in the middle of the last line: that member alone is made again, with the same numbers.
    std::fs::write(&ledger, &text[..text.len() - 20]).expect("cut");
    let unfinished = of_members(
        &plan,
        &job::read(&plan, folder.path()).expect("readable"),
        String::new(),
    );
    assert!(!unfinished.complete);
    let members = job::run(&plan, folder.path(), &quiet).expect("it runs");
    let again = std::fs::read_to_string(&ledger).expect("readable");
    assert_eq!(text, again);

    let record = of_members(&plan, &members, "test".to_owned());
    assert!(record.complete);
    let [sound, early, slow] = &record.points[..] else {
        panic!("three settings");
    };
    let height = |of: usize| record.points[of].figures[0].clone();
    assert_eq!(record.figures[0].id, "height");
    assert!(height(0).change.is_none());
    let moved = height(1).change.expect("eight clouds").low;
    assert!(moved > 0.002, "{moved}");
    assert_eq!(early.digest.len(), 16);
    // Beds are the same where only the load differs.
    assert_eq!(height(0).value, height(2).value);
    assert_eq!(sound.endings.all(), 8);
    // A small bed is not half a metre high.
    assert_eq!(height(0).verdict, Verdict::DoesNot);
    assert_eq!(record.figures[0].does_not, [1, 2, 3]);

    // Members whose punch sank are counted, and give no stress.
    let sank = members
        .of(&slow.setting)
        .iter()
        .filter(|row| row.ending == Ending::Sank)
        .map(|row| assert!(!row.measured.contains_key("last.stress.O.local_zz")))
        .count();
    assert_eq!(slow.endings.sank, sank);
    let stress = record.figures.iter().position(|of| of.id == "stress.O");
    let judged = &slow.figures[stress.expect("a published figure")];
    assert_eq!(judged.packings, 8 - sank);
    assert_eq!(judged.conditional, sank > 0);

    let page = crossgrain::report::sensitivity::page(&record).expect("a page");
    let html = &page.html;
    assert!(html.contains("hardly settled") && html.contains("does not come out"));
    each_figure_stands_once_and_has_numbers(&page);
}

#[test]
fn more_clouds_are_added_to_what_is_there() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let quiet = Display::new(true);
    let lines = |clouds: u64| {
        job::run(&plan(clouds), folder.path(), &quiet).expect("it runs");
        let text = std::fs::read_to_string(folder.path().join("members.jsonl"));
        text.expect("readable").lines().count()
    };
    assert_eq!(lines(3), 9);
    assert_eq!(lines(4), 12);
}

#[test]
fn a_watched_punch_goes_through_or_stands_still() {
    let base = small_scene();
    let through = Push::through(&base, 0.1, 0.2, 0.0, 0.03, 1);
    let watched = push::watch(&through, 1).expect("it runs");
    assert_eq!(watched.stop, Some(StopReason::SankToGiveUpDepth));
    assert_eq!(watched.windows.len(), 3);
    assert!(watched.windows.iter().all(|window| window.moments > 20
        && window.pressure > 0.0
        && window.largest >= window.pressure));

    let stand = Push::stand(&base, 0.2, 0.2, 0.0, 1);
    assert_eq!(stand.kind, Kind::Stand);
    let watched = push::watch(&stand, 1).expect("it runs");
    assert_eq!(watched.stop, Some(StopReason::Reached));
    let pressures: Vec<f64> = watched.windows.iter().map(|of| of.pressure).collect();
    assert_eq!(pressures.len(), push::TIMES.len() - 1);
    // What is left after half a second is a small part of what was reached.
    let last = pressures.last().expect("windows");
    assert!(*last < 0.5 * base.loading.pressure, "{pressures:?}");
}

#[test]
fn a_finished_map_is_never_overwritten() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("sensitivity.json"), "{}").expect("written");
    let out = folder.path().to_string_lossy().into_owned();
    let words = ["sensitivity", "--quick", "--out", &out];
    let (code, _, message) = told(&crossgrain(&words, folder.path()));
    assert_eq!(code, 2);
    assert!(message.contains("finished map"), "{message}");
}

#[test]
fn friction_bears_the_punch_earlier() {
    let mut base = small_scene();
    base.loading.give_up_depth = 0.04;
    base.loading.pressure *= 0.25;
    let slow = with_speed(base, 0.02);
    let without = row::whole("abc", &slow).expect("it runs");
    let with = row::whole("abc", &with_friction(slow, 0.5)).expect("it runs");
    assert_eq!(
        [&with.ending, &without.ending],
        [&Ending::Reached, &Ending::Reached]
    );
    assert!(with.load_steps < without.load_steps);
}
