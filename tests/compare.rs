//! The comparison: agrees where it should, and can fail.

use crossgrain::checks::Outcome;
use crossgrain::compare::{Comparison, compare, compare_as, first_difference::Locator, from_runs};
use crossgrain::run::folder::Moment;
use grains::scene::TimeStep;
use grains::tables::StopReason;
use verdict::envelope::Resolution;
use verdict::judge::Verdict;

use crate::support::*;

const POUR: Protocol = Protocol::Steps { steps: 4000 };

fn located(a: &RunFolder, b: &RunFolder) -> Comparison {
    compare(a, b, Some(&Locator::default()))
}

#[test]
fn a_run_agrees_with_itself_in_every_check() {
    let scene = small_scene();
    let [a, b] = [0, 1].map(|_| native_run(&scene, sound(), Protocol::Whole));
    let comparison = located(&a, &b);
    assert_eq!(comparison.verdict(), Verdict::Identical);
    assert!(comparison.first_difference.is_none());
    for check in &comparison.checks {
        assert_eq!(check.outcome, Outcome::Pass, "{}", check.quantity);
    }
    assert!(comparison.quantities.len() > 40);
    for pair in &comparison.quantities {
        assert_eq!(pair.verdict, Outcome::Pass, "{}", pair.key);
        assert_eq!(pair.difference, Some(0.0), "{}", pair.key);
    }
}

#[test]
fn every_fault_is_found_with_its_step_and_grain() {
    let scene = small_scene();
    let good = native_run(&scene, sound(), POUR);
    for fault in FAULTS {
        let bad = native_run(&scene, faulty(fault), POUR);
        let comparison = located(&good, &bad);
        assert!(!comparison.agrees(), "{fault} was not found");
        let first = comparison.first_difference.expect("a first difference");
        assert_eq!(first.stage, Stage::Settle);
        // The step before agrees in every bit and the step itself does not.
        for (steps, agree) in [(first.step - 1, true), (first.step, false)] {
            let run = |options| native_run(&scene, options, Protocol::Steps { steps });
            let [a, b] = [sound(), faulty(fault)].map(|options| run(options).last.bodies.digest());
            assert_eq!(a == b, agree, "{fault} at step {steps}");
        }
        assert!(first.number.id.starts_with("grain "), "{}", first.number.id);
        assert_ne!(first.number.a, first.number.b);
    }
}

#[test]
fn a_fault_that_shows_under_the_punch_is_found_there() {
    // The scenes are the same up to loading, then the punch's speed differs by one part in 10⁹. (One in 10¹² would round away in each step.)
    let scene = small_scene();
    let mut other = scene.clone();
    other.loading.speed *= 1.0 + 1e-9;
    let a = native_run(&scene, sound(), Protocol::Whole);
    let b = native_run(&other, sound(), Protocol::Whole);
    let comparison = located(&a, &b);
    let same_scene = &comparison.checks[0];
    assert_eq!(same_scene.outcome, Outcome::Fail);
    has(&same_scene.found, ["/loading/speed"]);
    let first = comparison.first_difference.expect("a first difference");
    assert_eq!(first.stage, Stage::Load);
    assert!(first.step > 0);
}

#[test]
fn one_last_bit_in_one_number_is_found() {
    let a = native_run(&small_scene(), sound(), POUR);
    let (mut moved, mut heavier) = (a.clone(), a.clone());
    for number in [&mut moved.last.bodies.vz[123], &mut heavier.initial.mass[7]] {
        *number = f64::from_bits(number.to_bits() ^ 1);
    }
    for (b, key, numbers, place) in [
        (moved, "last grains", 1200, ("grain 123", "vz", 1)),
        (heavier, "radii and masses", 600, ("grain 7", "mass", 1)),
    ] {
        let comparison = compare(&a, &b, None);
        assert_eq!(comparison.verdict(), Verdict::Different);
        let mut tables = comparison.tables.iter();
        let table = tables.find(|table| table.table == key).expect("the table");
        assert_eq!((table.differing, table.numbers), (1, numbers));
        let first = table.first.as_ref().expect("the number");
        assert_eq!((first.id.as_str(), first.key, first.ulps), place);
    }
}

/// The same grains to the bit, and another tale of them.
#[test]
fn what_is_told_of_the_same_grains_is_the_same() {
    let a = native_run(&small_scene(), sound(), Protocol::Whole);
    type Change = fn(&mut RunFolder);
    let changes: [(&str, Change); 5] = [
        ("load ended as", |run| {
            run.record.stages[1].stop = StopReason::TargetLoadNotReached;
        }),
        ("the kinetic energy at load", |run| {
            run.history.last_mut().expect("rows").kinetic_energy *= 1.5;
        }),
        ("the time at settle", |run| run.history[1].time *= 2.0),
        ("trace.csv has other paths", |run| {
            run.trace.pop();
        }),
        ("the force on the punch", |run| {
            let row = run.history.last_mut().expect("rows");
            row.punch_force = row.punch_force.map(|force| 1.1 * force);
        }),
    ];
    for (words, change) in changes {
        let mut b = a.clone();
        change(&mut b);
        // Whether bits are expected or not.
        for expected in [true, false] {
            let comparison = compare_as(&a, &b, expected, None);
            assert_eq!(comparison.verdict(), Verdict::Different, "{words}");
            let mut found = comparison.checks.iter().map(|check| check.found.as_str());
            assert!(found.any(|found| found.contains(words)), "{words}");
        }
    }
}

#[test]
fn the_command_says_agreed_or_different_and_exits_so() {
    let folder = &folder_with(&small_scene());
    for out in ["a", "b", "c --perturb stiffness=1e-12", "d --seed 2"] {
        let run = "run scene.json --engine native --steps 1000 --quiet --out";
        ends(folder, 0, &format!("{run} {out}"));
    }
    let (out, _) = ends(folder, 0, "compare a b");
    has(
        &out,
        ["\nAGREED: Identical: native in a against native in b\n"],
    );
    let (out, _) = ends(folder, 1, "compare a c");
    has(&out, ["\nDIFFERENT: Native against native with"]);
    has(&out, ["first difference: step "]);
    let (out, _) = ends(folder, 1, "compare a c --json --junit checks.xml");
    let junit = text_of(folder.join("checks.xml"));
    has(&junit, ["<failure"]);
    let value: Value = serde_json::from_str(&out).expect("JSON");
    assert!(value["first_difference"]["step"].as_u64() > Some(0));
    tells(folder, 2, "compare a d", ["two scenes", "/realization"]);
    let (out, _) = ends(folder, 0, "compare a b --json --out judged");
    let kept = text_of(folder.join("judged/compare.json"));
    assert_eq!(out.trim_end(), kept.trim_end());
    assert!(folder.join("judged/report.html").is_file());
    // What a run has not that did not go as far is counted once.
    ran_in(folder, "native", &[], "whole");
    let (out, _) = ends(folder, 1, "compare a whole");
    has(&out, ["One run alone has "]);
    assert!(!out.contains("does not have it"), "{out}");
}

/// From rows far apart the search finds the very step that rows of every step show.
#[test]
fn faults_in_friction_are_found_with_their_step() {
    let mut every_step = crossgrain::suite::cross_code::rough(100);
    every_step.measurement.history_every = 1;
    let mut seldom = every_step.clone();
    seldom.measurement.history_every = 20;
    let protocol = Protocol::Steps { steps: 1500 };
    let run = |scene, options| native_run(scene, options, protocol);
    let (good, sparse) = (run(&every_step, sound()), run(&seldom, sound()));
    let mut late = 0;
    let faults = "stiffness=1e-15 shear-stiffness=1e-9 friction=1e-9 density=1e-9 inertia=1e-9 radius=1e-9 start=half-step";
    for fault in faults.words() {
        let bad = run(&every_step, faulty(fault));
        let mut rows = good.history.iter().zip(&bad.history);
        let first = rows.find(|(good, bad)| good.state != bad.state);
        let first = first.expect("a difference").0.step;
        late += u32::from(first > 20);
        let folder = &new_folder();
        let bad = run(&seldom, faulty(fault));
        bad.write(&folder.join("bad")).expect("writable");
        let bad = read_run(folder.join("bad"));
        let found = located(&sparse, &bad).first_difference;
        assert_eq!(found.map(|found| found.step), Some(first), "{fault}");
    }
    assert!(late > 0, "no difference after the first row");
}

/// Exit code and words of the comparison of a native run with one of the toy after these changes of its text; the toy's
/// operations are other ones in any case. It is asked for its first steps if that is wanted.
fn against_toy(changes: &[(&str, &str)], asked: bool) -> (i32, String) {
    let folder = &folder_with(&narrow_scene(0.05));
    let other = ("* (v[i][axis] + 0.5", "* (1.0 + 1e-14) * (v[i][axis] + 0.5");
    let kick = "v[i][axis] += dt * a";
    let toy = changed_toy(kick, &format!("{kick} * (1.0 + 1e-15)"));
    let toy = changes.iter().chain([&other]).fold(toy, |toy, (from, to)| {
        assert_eq!(toy.matches(from).count(), 1, "{from}");
        toy.replace(from, to)
    });
    let engine = engine(folder, "toy.py", &toy);
    ran_in(folder, "native", &["--steps", "6000"], "native");
    ran_in(folder, &engine, &["--steps", "6000"], "theirs");
    let asked = if asked { 5 } else { 3 };
    let compare = ["compare", "native", "theirs", "--engine", &engine];
    let (code, text, errors) = say(folder, &compare[..asked]);
    (code, text + &errors)
}

/// Where bits may differ, the engine of the run is judged by its first steps, and its numbers are not.
#[test]
fn a_run_with_other_operations_is_judged_by_its_engines_first_steps() {
    let (code, said) = against_toy(&[], true);
    assert_eq!(code, 0, "{said}");
    has(&said, ["AGREED: Equal to rounding"]);
    let k_n = "2.0 * a * b / (a + b)";
    let stiff = against_toy(&[(k_n, &format!("(1.0 + 1e-8) * {k_n}"))], true);
    assert_eq!(stiff.0, 1, "{}", stiff.1);
    has(&stiff.1, ["k_n between grains × 1.00000001"]);
}

/// Nothing is said of a run with other operations whose engine is not run again, or cannot be asked for first steps.
#[test]
fn where_first_steps_are_not_looked_at_the_verdict_is_open() {
    let (code, said) = against_toy(&[], false);
    assert_eq!(code, 3, "{said}");
    has(&said, ["Undecided"]);
    let (code, said) = against_toy(&[("\"walls\", \"cases\"]", "\"walls\"]")], true);
    assert_eq!(code, 3, "{said}");
    has(&said, ["Undecided", "cases"]);
}

/// The tables of both states follow from the grains; each number that does not is found, and what of it is wrong is said.
#[test]
fn a_contact_table_that_does_not_follow_from_its_grains_is_found() {
    let mut scene = small_scene();
    scene.material.friction_angle = 0.4;
    scene.material.wall_friction_angle = Some(0.2);
    scene.time_step = TimeStep::Fraction {
        of_sqrt_m_over_k: 0.2,
    };
    let run = native_run(&scene, sound(), Protocol::Whole);
    let judged = |run: &RunFolder| {
        let measured = Some(verdict::envelope::Resolution::DOUBLE);
        from_runs::contact_tables(run, "a", measured).expect("the punch is known")
    };
    assert_eq!(
        judged(&run).outcome,
        Outcome::Pass,
        "{}",
        judged(&run).found
    );
    type Change = fn(&mut Moment);
    let changes: [(&str, Change); 5] = [
        ("contacts are missing", |moment| {
            moment.contacts.remove(3);
        }),
        ("fn is off", |moment| {
            moment
                .contacts
                .iter_mut()
                .for_each(|contact| contact.normal_force *= 1.02);
        }),
        ("overlap is off", |moment| {
            moment.contacts[5].overlap *= 1.001
        }),
        ("x is off", |moment| moment.contacts[5].point[0] += 1.0e-6),
        ("its limit is", |moment| {
            let normal = moment.contacts[5].normal_force;
            moment.contacts[5].tangential_force = 0.5 * normal;
        }),
    ];
    // What cannot be looked at is no agreement.
    let mut without = run.clone();
    without.settled = None;
    let why = from_runs::contact_tables(&without, "a", None).expect_err("the punch is nowhere");
    has(&why, ["where the punch is"]);
    for (words, change) in changes {
        let mut settled = run.clone();
        change(settled.settled.as_mut().expect("a settled bed"));
        let mut last = run.clone();
        change(&mut last.last);
        for (state, wrong) in [("the settled bed", settled), ("the last state", last)] {
            let check = judged(&wrong);
            assert_eq!(check.outcome, Outcome::Fail, "{words} in {state}");
            has(&check.found, [words, state]);
        }
    }
}

/// A bed that is livelier than its rule allows did not settle, whatever looks its history has.
#[test]
fn a_bed_that_settled_too_early_is_found() {
    let mut scene = small_scene();
    // No look of the rule is a row of the history.
    scene.measurement.history_every = 70;
    let mut run = native_run(&scene, sound(), Protocol::Settled);
    assert_eq!(from_runs::against_rules(&run), None);
    let bodies = &mut run.last.bodies;
    let velocities = bodies.vx.iter_mut().chain(&mut bodies.vz);
    velocities.for_each(|velocity| *velocity *= 3.0);
    let why = from_runs::against_rules(&run).expect("found");
    has(&why, ["J left"]);
}

/// A spring that is turned to the first order leaves the tangent a little, so that normal forces are not those of overlaps alone.
#[test]
fn tables_of_a_rough_bed_follow_from_its_grains() {
    for realization in 1..=4 {
        let mut scene = frictional_scene();
        scene.realization = realization;
        scene.settle.kinetic_energy_fraction = 0.05;
        let mut run = native_run(&scene, sound(), Protocol::Whole);
        let judged = |run: &RunFolder| {
            let found = from_runs::contact_tables(run, "a", Some(Resolution::DOUBLE));
            found.expect("grains that touch").outcome
        };
        assert_eq!(judged(&run), Outcome::Pass, "{realization}");
        let slides = |contact: &&mut Contact| contact.tangential_force != 0.0;
        let one = run.last.contacts.iter_mut().find(slides);
        one.expect("friction").normal_force *= 1.05;
        assert_eq!(judged(&run), Outcome::Fail, "{realization}");
    }
}
