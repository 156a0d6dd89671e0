//! The map of what the published figures depend on, on beds small enough for a test.

use std::path::Path;

use crossgrain::report;
use crossgrain::study::machine::Folder;
use crossgrain::study::member::{Member, Members, of_one_bed};
use crossgrain::study::realization::Change::{Friction, Hold, Settled, Speed};
use crossgrain::study::realization::{Ending, Engines, Setting, Specification, changed};
use crossgrain::study::sensitivity::judge::Verdict;
use crossgrain::study::sensitivity::penetration::{self, Kind, Penetration};
use crossgrain::study::sensitivity::plan::{Plan, SPEED_AND_DAMPING};
use crossgrain::study::sensitivity::{Row, Sensitivity, keep};
use crossgrain::study::{Study, create};
use grains::scene::{Material, Scene};
use grains::tables::StopReason;

use crate::support::{frictional_scene, small_scene};
use crate::tradeoff::run;

/// The small scene as it is, settled much too early, and loaded so slowly that the punch sinks.
fn plan(clouds: u64) -> Plan {
    let mut base = small_scene();
    base.loading.give_up_depth = 0.04;
    let mut plan = Plan::new(base, clouds);
    plan.add("settle rule", "as-it-is", "as it is", 1.0e-4, 1, &[]);
    let early = [Settled(0.05)];
    plan.add("settle rule", "early", "hardly settled", 0.05, 1, &early);
    let slow = [Speed(0.02)];
    let slow = plan.add(SPEED_AND_DAMPING, "slow", "slow", 0.02, 1, &slow);
    slow.at.push(0.2);
    plan
}

/// Members of a folder, and how many rows it has.
fn members(folder: &Path) -> (Members, usize) {
    let mut all: Vec<Member> = Vec::new();
    let mut rows = 0;
    let folder = Folder::<Plan>::open(folder).expect("a study");
    let each = folder.each(|_, row| {
        rows += 1;
        if let Row::Loads(of) = row {
            all.extend(of);
        }
    });
    each.expect("rows");
    (all.into_iter().collect(), rows)
}

fn exact(scene: Scene) -> Specification {
    Specification::native(scene)
}

/// The whole run in one go.
fn whole(of: &Specification) -> Member {
    let engines = Engines::default();
    let run = Member::run(of, 1, &engines, Path::new(""), keep).expect("it runs");
    Member { cost: None, ..run }
}

#[test]
fn a_bed_poured_once_and_loaded_is_the_whole_run_bit_for_bit() {
    for mut scene in [small_scene(), frictional_scene()] {
        scene.loading.give_up_depth = 0.02;
        let scenes = [&[][..], &[Speed(0.3)], &[Hold(0.01)]];
        let [first, fast, held] = scenes.map(|changes| changed(scene.clone(), changes));
        // The bed is poured in the first scene, which may be one in which nothing turns.
        let mut rough = first.clone();
        rough.loading.material = Some(Material {
            friction_angle: 0.5,
            ..rough.material.clone()
        });
        let scenes = [first, fast, held, rough];
        let settings = scenes.map(|scene| Setting::new("a", "a", "test", exact(scene), 1));
        let loaded =
            of_one_bed(&settings.iter().collect::<Vec<&Setting>>(), 1, keep).expect("they run");
        for (setting, loaded) in settings.iter().zip(loaded) {
            assert!(loaded.loaded_state.is_some());
            assert_eq!(loaded, whole(&setting.specification));
        }
    }
}

#[test]
fn a_map_is_taken_up_where_it_was_and_notices_what_was_moved() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let folder = place.path().join("map");
    let plan = plan(8);
    // The slow load has the bed of the base.
    assert_eq!(plan.count(), 16);
    create(&folder, plan.clone(), None, None).expect("a new study");
    run::<Plan>(&folder, &Engines::default()).expect("it runs");
    let rows = folder.join("records/shard-1-of-1.jsonl");
    let text = std::fs::read_to_string(&rows).expect("readable");
    assert_eq!(text.lines().count(), 16);

    // Killed in the middle of the last line: that row alone is made again, with the same numbers.
    std::fs::write(&rows, &text[..text.len() - 20]).expect("cut");
    assert_eq!(members(&folder).1, 15);
    run::<Plan>(&folder, &Engines::default()).expect("it runs");
    let again = std::fs::read_to_string(&rows).expect("readable");
    assert!(again.starts_with(&text[..text.len() - 20]));
    assert_eq!(text.lines().last(), again.lines().last());

    let all = || members(&folder).0;
    let record = Sensitivity::of(&plan, all(), &[]);
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
    assert_eq!(record.figures[0].does_not, ["as-it-is", "early", "slow"]);

    // Members whose punch missed the force are counted, and give no stress.
    let missed = all()
        .of(&slow.setting)
        .iter()
        .filter(|row| row.ending == Ending::TargetLoadNotReached)
        .map(|row| assert!(!row.measured.contains_key("loaded.stress.O.local_zz")))
        .count();
    assert_eq!(slow.endings.target_load_not_reached, missed);
    let stress = record.figures.iter().position(|of| of.id == "stress.O");
    let judged = &slow.figures[stress.expect("a published figure")];
    assert_eq!(judged.packings, 8 - missed);
    assert_eq!(judged.conditional, missed > 0);

    let document = record.document();
    let page = report::page(&document);
    assert!(page.html.contains("hardly settled") && page.html.contains("does not come out"));
    for name in [
        "speed-and-damping-height.svg",
        "choices-stress-o.svg",
        "figures.csv",
        "together.csv",
        "verdicts-1.csv",
        "changes-1.csv",
    ] {
        assert!(page.files.iter().any(|(file, _)| file == name), "{name}");
    }
    assert!(report::terminal(&document).contains(&document.answer));
}

#[test]
fn more_clouds_are_added_to_what_is_there() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let [three, four] = ["three", "four"].map(|name| place.path().join(name));
    create(&three, plan(3), None, None).expect("a new study");
    run::<Plan>(&three, &Engines::default()).expect("it runs");
    assert_eq!(
        create(&four, plan(4), None, Some(&three)).expect("a new study"),
        6
    );
    assert_eq!(members(&four).1, 6);
    run::<Plan>(&four, &Engines::default()).expect("it runs");
    assert_eq!(members(&four).1, 8);
}

#[test]
fn a_watched_punch_goes_through_or_stands_still() {
    let base = small_scene();
    let through = Penetration::through(&base, (0.1, 0.2, 0.0), 0.03, 1);
    let watched = penetration::watch(&through, 1).expect("it runs");
    assert_eq!(watched.stop, Some(StopReason::TargetLoadNotReached));
    assert_eq!(watched.windows.len(), 3);
    assert!(watched.windows.iter().all(|window| window.moments > 20
        && window.pressure > 0.0
        && window.largest >= window.pressure));

    let stand = Penetration::stand(&base, (0.2, 0.2, 0.0), 1);
    assert_eq!(stand.kind, Kind::Stand);
    let watched = penetration::watch(&stand, 1).expect("it runs");
    assert_eq!(watched.stop, Some(StopReason::Reached));
    let pressures: Vec<f64> = watched.windows.iter().map(|of| of.pressure).collect();
    assert_eq!(pressures.len(), penetration::TIMES.len() - 1);
    // What is left after half a second is a small part of what was reached.
    let last = pressures.last().expect("windows");
    assert!(*last < 0.5 * base.loading.pressure, "{pressures:?}");
}

#[test]
fn friction_bears_the_punch_earlier() {
    let mut base = small_scene();
    base.loading.give_up_depth = 0.04;
    base.loading.pressure *= 0.25;
    let slow = changed(base, &[Speed(0.02)]);
    let without = whole(&exact(slow.clone()));
    let with = whole(&exact(changed(slow, &[Friction(0.5)])));
    assert_eq!(
        [&with.ending, &without.ending],
        [&Ending::Reached, &Ending::Reached]
    );
    assert!(with.load_steps < without.load_steps);
}
