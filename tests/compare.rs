//! The comparison: agrees where it should, and can fail.

use crossgrain::checks::Outcome;
use crossgrain::compare::divergence::{Divergence, Scatter, of_replicas, quantities};
use crossgrain::compare::first_difference::{CommonStart, Locator};
use crossgrain::compare::{Comparison, ReferenceScatter, compare};
use crossgrain::run::folder::RunFolder;
use crossgrain::run::folder::record::Protocol;
use grains::measure::Quantity;
use grains::tables::Stage;

use crate::support::{crossgrain, faulty, folder_with, native_run, small_scene, sound, told};

const POUR: Protocol = Protocol::Steps { steps: 4000 };

fn located(a: &RunFolder, b: &RunFolder) -> Comparison {
    compare(a, b, None, Some(&Locator::default()))
}

#[test]
fn a_run_agrees_with_itself_in_every_check() {
    let scene = small_scene();
    let a = native_run(&scene, sound(), Protocol::Whole);
    let b = native_run(&scene, sound(), Protocol::Whole);
    let comparison = located(&a, &b);
    assert!(comparison.agrees());
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

/// Each fault of the list, a part in 10¹² where it has a size: found, with step and grain.
#[test]
fn every_fault_is_found_with_its_step_and_grain() {
    let scene = small_scene();
    let good = native_run(&scene, sound(), POUR);
    for fault in [
        "stiffness=1e-12",
        "gravity=1e-12",
        "damping=1e-12",
        "wall=1e-12",
        "sums=reversed",
    ] {
        let bad = native_run(&scene, faulty(fault), POUR);
        let comparison = located(&good, &bad);
        assert!(!comparison.agrees(), "{fault} was not found");
        let first = comparison.first_difference.expect("a first difference");
        assert_eq!(first.stage, Stage::Settle);
        // The step before agrees in every bit and the step itself does not.
        for (steps, agree) in [(first.step - 1, true), (first.step, false)] {
            let protocol = Protocol::Steps { steps };
            let a = native_run(&scene, sound(), protocol);
            let b = native_run(&scene, faulty(fault), protocol);
            let same = a.last.bodies.digest() == b.last.bodies.digest();
            assert_eq!(same, agree, "{fault} at step {steps}");
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
    assert!(
        same_scene.found.contains("/loading/speed"),
        "{}",
        same_scene.found
    );
    let first = comparison.first_difference.expect("a first difference");
    assert_eq!(first.stage, Stage::Load);
    assert!(first.step > 0);
}

#[test]
fn one_last_bit_in_one_number_is_found() {
    let scene = small_scene();
    let a = native_run(&scene, sound(), POUR);
    let mut b = a.clone();
    b.last.bodies.vz[123] = f64::from_bits(b.last.bodies.vz[123].to_bits() ^ 1);
    let comparison = compare(&a, &b, None, None);
    assert!(!comparison.agrees());
    let table = comparison
        .tables
        .iter()
        .find(|table| table.table == "last grains")
        .expect("the table");
    assert_eq!((table.differing, table.numbers), (1, 1200));
    let first = table.first.as_ref().expect("the number");
    assert_eq!(
        (first.id.as_str(), first.key, first.ulps),
        ("grain 123", "vz", 1)
    );
}

#[test]
fn the_command_says_agreed_or_different_and_exits_so() {
    let (folder, _) = folder_with(&small_scene());
    let run = |out: &str, more: &[&str]| {
        let mut arguments = vec![
            "run",
            "scene.json",
            "--engine",
            "native",
            "--steps",
            "1000",
            "--quiet",
            "--out",
            out,
        ];
        arguments.extend(more);
        let (code, _, errors) = told(&crossgrain(&arguments, folder.path()));
        assert_eq!(code, 0, "{errors}");
    };
    run("a", &[]);
    run("b", &[]);
    run("c", &["--perturb", "stiffness=1e-12"]);
    run("d", &["--seed", "2"]);
    let (code, out, _) = told(&crossgrain(&["compare", "a", "b"], folder.path()));
    assert_eq!(code, 0, "{out}");
    assert!(out.contains("\nAGREED: native against native\n"), "{out}");
    let (code, out, _) = told(&crossgrain(&["compare", "a", "c"], folder.path()));
    assert_eq!(code, 1, "{out}");
    assert!(out.contains("first difference: step "), "{out}");
    let arguments = ["compare", "a", "c", "--json", "--junit", "checks.xml"];
    let (code, out, _) = told(&crossgrain(&arguments, folder.path()));
    assert_eq!(code, 1);
    let junit = std::fs::read_to_string(folder.path().join("checks.xml")).expect("JUnit");
    assert!(junit.contains("<failure"), "{junit}");
    let value: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    assert!(value["first_difference"]["step"].as_u64() > Some(0));
    let (code, out, _) = told(&crossgrain(&["compare", "a", "d"], folder.path()));
    assert_eq!(code, 1);
    assert!(out.contains("/realization"), "{out}");
}

/// The sum of two forces does not depend on their order, so reversing the sums changes nothing
/// until a grain bears three; a fault in the law shows before.
#[test]
fn bits_agree_until_the_order_of_sums_can_matter() {
    let scene = small_scene();
    let good = native_run(&scene, sound(), POUR);
    let reversed = native_run(&scene, faulty("sums=reversed"), POUR);
    let common = CommonStart::of(&good, &reversed, Some(&Locator::default())).expect("runs");
    assert_eq!(common.verdict(), Outcome::Pass, "{common}");
    assert!(common.three_forces.is_some() && common.first_unequal.is_some());
    let stiff = native_run(&scene, faulty("stiffness=1e-12"), POUR);
    // The histories alone say the same, if less sharply.
    let from_histories = CommonStart::of(&good, &reversed, None).expect("runs");
    assert_eq!(from_histories.verdict(), Outcome::Pass, "{from_histories}");
    let common = CommonStart::of(&good, &stiff, Some(&Locator::default())).expect("runs");
    assert_eq!(common.verdict(), Outcome::Fail, "{common}");
}

#[test]
fn replicas_diverge_and_their_scatter_allows_what_it_should() {
    let mut scene = small_scene();
    scene.settle.kinetic_energy_fraction = 1.0e-2;
    let run = native_run(&scene, sound(), Protocol::Whole);
    let scatter = of_replicas(&run, &|| {}).expect("replicas");
    let mean_surface = "settled.height.mean_surface";
    let allowed = scatter.allowed(mean_surface).expect("a known quantity");
    assert!(allowed > 0.0 && allowed < 0.1, "{allowed}");
    assert_eq!(scatter.allowed("no.such.quantity"), None);
    let reversed = native_run(&scene, faulty("sums=reversed"), Protocol::Whole);
    let value = |run: &RunFolder| {
        quantities(run)
            .into_iter()
            .find(|of| of.key == mean_surface)
            .expect("measured")
            .value
    };
    assert!((value(&run) - value(&reversed)).abs() <= allowed);
    let divergence = Divergence::of(&run, &reversed);
    assert!(divergence.e_folding_steps.expect("growth") > 1.0);
}

/// Student's t with 11 degrees of freedom at 0.5 % in each tail is 3.1058 (tables).
#[test]
fn the_allowed_difference_is_students_interval() {
    let replica = |value: f64| {
        vec![Quantity {
            key: "q".to_owned(),
            value,
            unit: "1".to_owned(),
        }]
    };
    let replicas: Vec<_> = (0..12).map(|k| replica(f64::from(k % 2) * 2.0)).collect();
    let scatter = Scatter::of(&replicas);
    let deviation = (12.0f64 / 11.0).sqrt();
    let expected = 3.1058 * deviation * 2f64.sqrt();
    let allowed = scatter.allowed("q").expect("known");
    assert!(
        (allowed / expected - 1.0).abs() < 1e-4,
        "{allowed} {expected}"
    );
    // A quantity that one replica lacks has no scatter.
    let mut some = replicas;
    some[3].clear();
    assert_eq!(Scatter::of(&some).allowed("q"), None);
}

/// Without a reference nothing can be said of a run in another order of sums, and nothing is.
#[test]
fn an_ordinary_run_without_control_is_not_called_agreed() {
    use crossgrain::run::folder::record::EngineRecord;
    let scene = small_scene();
    let a = native_run(&scene, sound(), POUR);
    let mut b = native_run(&scene, faulty("sums=reversed"), POUR);
    let ordinary = |verlet_distance| EngineRecord::Yade {
        version: "2023.02a".to_owned(),
        sorted: false,
        verlet_distance,
        script: String::new(),
    };
    b.record.engine = ordinary(1.0e-4);
    let comparison = compare(&a, &b, None, None);
    assert_eq!(comparison.verdict(), Outcome::Skipped);
    // B itself is no control of B; a run with another verletDist is.
    let scatter = of_replicas(&a, &|| {}).expect("replicas");
    for (distance, verdict) in [(1.0e-4, Outcome::Fail), (2.0e-4, Outcome::Pass)] {
        let mut control = b.clone();
        control.record.engine = ordinary(distance);
        let reference = ReferenceScatter {
            control: Some(&control),
            scatter: &scatter,
        };
        let comparison = compare(&a, &b, Some(reference), None);
        let check = comparison
            .checks
            .iter()
            .find(|check| check.quantity.starts_with("control differs"))
            .expect("the check");
        assert_eq!(check.outcome, verdict, "{}", check.found);
    }
}

#[test]
fn other_sizes_or_masses_are_found() {
    let a = native_run(&small_scene(), sound(), POUR);
    let mut b = a.clone();
    b.initial.mass[7] *= 1.0 + f64::EPSILON;
    let comparison = compare(&a, &b, None, None);
    assert_eq!(comparison.verdict(), Outcome::Fail);
    let table = &comparison.tables[0];
    assert_eq!((table.differing, table.numbers), (1, 600));
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
    for fault in [
        "stiffness=1e-15",
        "shear-stiffness=1e-9",
        "friction=1e-9",
        "density=1e-9",
        "inertia=1e-9",
        "radius=1e-9",
        "start=half-step",
    ] {
        let bad = run(&every_step, faulty(fault));
        let mut rows = good.history.iter().zip(&bad.history);
        let first = rows.find(|(good, bad)| good.state != bad.state);
        let first = first.expect("a difference").0.step;
        late += u32::from(first > 20);
        let folder = tempfile::tempdir().expect("a temporary folder");
        let bad = run(&seldom, faulty(fault));
        bad.write(&folder.path().join("bad")).expect("writable");
        let bad = RunFolder::read(&folder.path().join("bad")).expect("a folder in one piece");
        let found = located(&sparse, &bad).first_difference;
        assert_eq!(found.map(|found| found.step), Some(first), "{fault}");
    }
    assert!(late > 0, "no difference after the first row");
}

/// The step at which a grain first bears three forces is that of the run, whatever contacts remember.
#[test]
fn three_forces_on_a_rough_grain_are_counted_in_the_run_itself() {
    let scene = crossgrain::suite::cross_code::rough(100);
    let protocol = Protocol::Steps { steps: 4000 };
    let run = native_run(&scene, sound(), protocol);
    let common = CommonStart::of(&run, &run, None).expect("a run that goes on");
    let first = common.three_forces.expect("three forces within the run");
    assert!(first > 500, "{first}: beyond the first piece");
    let case = grains::task::Case {
        name: "the run itself".to_owned(),
        model: grains::model::Model::of(&scene),
        bodies: run.initial.clone(),
        punch: None,
        moments: vec![first - 1, first],
    };
    let track = grains::native::run_case(&case, None).expect("a run");
    let most = |moment: &grains::tables::Snapshot| {
        let on = |id: u32| {
            let touches = |c: &&grains::tables::Contact| c.id1 == id || c.id2 == id;
            moment.contacts.iter().filter(touches).count()
        };
        (0..100).map(on).max().unwrap_or(0)
    };
    assert!(most(&track[0]) < 3 && most(&track[1]) >= 3);
}
