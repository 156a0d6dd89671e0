use super::*;
use crate::checks::Speed;

fn check(id: &str, value: f64, outcome: Outcome) -> Check {
    Check::of_words(id.to_owned(), id, outcome, "")
        .with_limits(value, 1.0, Some(0.5))
        .judged_by("by looking", "told so")
}

fn speed(value: f64, range: Option<[f64; 2]>, unit: &str) -> Speed {
    Speed {
        id: "time/yade".to_owned(),
        what: "YADE over native".to_owned(),
        unit: unit.to_owned(),
        value,
        range,
        less_is_better: unit.starts_with("instructions"),
    }
}

fn record(checks: Vec<Check>, speeds: Vec<Speed>) -> Record {
    Record {
        job: "verify".to_owned(),
        version: 2,
        crossgrain: "0.1.0".to_owned(),
        command: "crossgrain verify".to_owned(),
        machine_kind: Some("a machine".to_owned()),
        scene_digest: None,
        yade: None,
        verdict: Outcome::Pass,
        checks,
        measured: Vec::new(),
        speeds,
    }
}

fn between(before: Record, after: &Record) -> Diff {
    let baseline = Baseline {
        baseline: 1,
        name: "main".to_owned(),
        source: String::new(),
        record: before,
    };
    diff(&baseline, after)
}

fn of_one(before: Option<Check>, after: Option<Check>) -> (Option<Change>, Verdict) {
    let run = |check: Option<Check>| record(check.into_iter().collect(), Vec::new());
    let diff = between(run(before), &run(after));
    (diff.changes.first().map(|of| of.change), diff.verdict)
}

#[test]
fn each_kind_of_change_is_told_and_weighed() {
    use Change::*;
    use Outcome::{ExpectedFailure, Fail, Pass, Skipped};
    use Verdict::{Fail as Worse, Pass as Fine, Skipped as Open};
    let a = |value, outcome| Some(check("a", value, outcome));
    let other = |change: fn(&mut Check)| {
        let mut check = check("a", 1.0, Pass);
        change(&mut check);
        Some(check)
    };
    let looser = other(|check| check.upper = Some(1.6));
    let unit = other(|check| check.unit = "m".to_owned());
    let method = other(|check| check.method = "by hearsay".to_owned());
    for (before, after, change, verdict) in [
        (a(1.0, Pass), a(1.0, Pass), None, Fine),
        (a(1.0, Pass), a(1.1, Pass), Some(Moved), Fine),
        (a(1.0, Pass), a(1.6, Fail), Some(NewFailure), Worse),
        (None, a(1.6, Fail), Some(NewFailure), Worse),
        (a(0.0, Skipped), a(1.6, Fail), Some(NewFailure), Worse),
        (a(1.6, Fail), a(1.6, Fail), None, Fine),
        (a(1.6, Fail), a(1.7, Fail), Some(Moved), Fine),
        (a(1.6, Fail), a(1.0, Pass), Some(Fixed), Fine),
        (a(1.0, Pass), a(0.0, Skipped), Some(NoLongerMade), Open),
        (a(1.6, Fail), a(0.0, Skipped), Some(NoLongerMade), Open),
        (a(0.0, Skipped), a(1.0, Pass), Some(NowMade), Fine),
        (a(0.0, Skipped), a(0.0, Skipped), None, Fine),
        (None, a(1.0, Pass), Some(Added), Fine),
        (a(1.0, Pass), None, Some(Removed), Open),
        (a(1.0, Pass), looser, Some(DefinitionChanged), Open),
        (a(1.0, Pass), unit, Some(DefinitionChanged), Open),
        (a(1.0, Pass), method, Some(DefinitionChanged), Open),
        (
            a(1.0, ExpectedFailure),
            a(1.0, Pass),
            Some(DefinitionChanged),
            Open,
        ),
    ] {
        let found = of_one(before.clone(), after.clone());
        assert_eq!(found, (change, verdict), "{before:?} {after:?}");
    }
}

#[test]
fn a_move_is_measured_in_its_tolerance_and_the_worst_comes_first() {
    let of = |values: [f64; 3], outcome| {
        let checks = ["a", "b", "c"].into_iter().zip(values);
        checks
            .map(|(id, value)| check(id, value, outcome))
            .collect()
    };
    let before = record(of([1.0; 3], Outcome::Pass), Vec::new());
    let mut after = record(of([1.1, 1.0, 0.6], Outcome::Pass), Vec::new());
    after.checks[1].outcome = Outcome::Fail;
    let diff = between(before, &after);
    let ids: Vec<&str> = diff.changes.iter().map(|of| of.id.as_str()).collect();
    assert_eq!(ids, ["b", "c", "a"]);
    let share = diff.changes[1].share_of_tolerance.expect("limits");
    assert!((share - 0.8).abs() < 1e-12, "{share}");
}

#[test]
fn measured_numbers_that_moved_are_told_by_their_own_size() {
    let run = |numbers: &[(&str, f64)]| Record {
        measured: numbers
            .iter()
            .map(|(id, value)| Measured {
                id: (*id).to_owned(),
                unit: "m".to_owned(),
                value: *value,
            })
            .collect(),
        ..record(Vec::new(), Vec::new())
    };
    let before = run(&[("a", 1.0), ("b", 1.0), ("c", 100.0), ("gone", 1.0)]);
    let after = run(&[
        ("a", 1.0),
        ("b", 1.0 + f64::EPSILON),
        ("c", 101.0),
        ("new", 1.0),
    ]);
    let diff = between(before.clone(), &after);
    let moved: Vec<&str> = diff.moved.iter().map(|of| of.id.as_str()).collect();
    assert_eq!(moved, ["gone", "new", "c", "b"]);
    assert_eq!(diff.unmoved, 1);
    assert!(diff.in_a_line().contains("4 of 5 measured numbers moved"));
    // Numbers alone are findings; whether they may move is for the caller to say.
    assert_eq!(diff.verdict, Verdict::Pass);
    assert_eq!(diff.demanding_bits().verdict, Verdict::Fail);
    let same = between(before.clone(), &before).demanding_bits();
    assert_eq!(same.verdict, Verdict::Pass);
}

#[test]
fn speeds_are_ratios_judged_beyond_their_scatter_on_one_machine() {
    let pace = |before: Speed, after: Speed| {
        let run = |speed| record(Vec::new(), vec![speed]);
        let diff = between(run(before), &run(after));
        (diff.speeds[0].pace, diff.verdict)
    };
    let single = |value| speed(value, None, "times native");
    let rounds = |value| speed(value, Some([value - 2.0, value + 2.0]), "times native");
    let counted = |value| speed(value, None, "instructions a step");
    use Verdict::{Fail, Pass};
    assert_eq!(pace(single(80.0), single(60.0)), (Pace::Same, Pass));
    assert_eq!(pace(single(80.0), single(40.0)), (Pace::Slower, Fail));
    assert_eq!(pace(single(40.0), single(80.0)), (Pace::Faster, Pass));
    assert_eq!(pace(rounds(80.0), rounds(77.0)), (Pace::Same, Pass));
    assert_eq!(pace(rounds(80.0), rounds(70.0)), (Pace::Slower, Fail));
    assert_eq!(pace(counted(1.0e6), counted(1.02e6)), (Pace::Slower, Fail));
    assert_eq!(pace(counted(1.0e6), counted(1.005e6)), (Pace::Same, Pass));
    let before = record(Vec::new(), vec![single(80.0)]);
    let mut after = record(Vec::new(), vec![single(40.0)]);
    after.machine_kind = Some("another".to_owned());
    assert_eq!(between(before, &after).speeds[0].pace, Pace::NotJudged);
}
