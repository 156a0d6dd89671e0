use std::collections::BTreeSet;

use super::*;
use crate::engine::yade::unsupported;
use grains::native::{Perturbation, run_case};

/// What a group's checks are with a fault; none if a case did not run.
pub fn judged(group: &CaseGroup, fault: Option<Perturbation>) -> Vec<Check> {
    let run = |case| run_case(case, fault).ok();
    let tracks: Option<Vec<Track>> = group.cases.iter().map(run).collect();
    tracks.map_or(Vec::new(), |tracks| group.judge(&tracks))
}

/// Of each group faults that it is about, and how small ones it must detect. Those on the scheme's own solution detect one part in
/// 10¹¹; those in continuous time what the length of the step leaves.
const FAULTS: &[(&str, &str)] = &[
    (
        "bounce-local-damping",
        "damping=1e-4 stiffness=1e-4 wall=missing damping=wrong-sign",
    ),
    ("bounce-dashpot", "dashpot=1e-4 density=1e-4 clipping=other"),
    ("bounce-dashpot-unclipped", "dashpot=1e-4 density=1e-4"),
    ("bounce-restitution", "dashpot=1e-4 clipping=other"),
    (
        "drop-on-wall",
        "gravity=1e-10 stiffness=1e-4 start=half-step clipping=other",
    ),
    ("drop-on-wall-unclipped", "gravity=1e-10 stiffness=1e-3"),
    ("repeated-bounces", "gravity=1e-3 dashpot=1e-2"),
    ("repeated-bounces-local-damping", "damping=1e-4"),
    ("chung-ooi-1-2-elastic", "modulus=1e-5 time-step=1e-5"),
    ("chung-ooi-3-rebound", "dashpot=1e-4 wall=missing"),
    ("chung-ooi-3-rebound-unclipped", "dashpot=1e-4"),
    (
        "oblique-impact",
        "friction=1e-9 inertia=1e-7 torque-arms=other",
    ),
    ("chung-ooi-4-oblique", "friction=1e-6 inertia=1e-6"),
    (
        "gross-sliding",
        "friction=1e-9 inertia=1e-8 torque-arms=other",
    ),
    ("spin-impact", "friction=1e-9 inertia=1e-8"),
    ("gross-sliding-pair", "friction=1e-4 inertia=1e-10"),
    ("opposite-spins", "radius=1e-10 ratcheting=other"),
    ("leapfrog-spring", "start=half-step"),
    ("leapfrog-dashpot", "dashpot=1e-11"),
    ("leapfrog-dashpot-unclipped", "dashpot=1e-11"),
    ("leapfrog-local-damping", "damping=1e-11 damping=wrong-sign"),
    (
        "leapfrog-drop",
        "damping=1e-11 dashpot=1e-11 gravity=1e-11 wall=missing",
    ),
    (
        "leapfrog-sliding",
        "friction=1e-11 inertia=1e-11 dashpot=1e-11 torque-arms=other",
    ),
    (
        "leapfrog-sticking",
        "shear-stiffness=1e-11 inertia=1e-11 gravity=1e-11 start=half-step ratcheting=other",
    ),
    (
        "first-slip",
        "shear-stiffness=1e-10 modulus=1e-10 radius=1e-10 time-step=1e-10 ratcheting=other",
    ),
    (
        "first-slip-since-touch",
        "shear-stiffness=1e-10 modulus=1e-10 radius=1e-10 time-step=1e-10",
    ),
    ("free-fall", "gravity=1e-9 time-step=1e-9 start=half-step"),
    (
        "flight-with-local-damping",
        "damping=1e-9 gravity=1e-9 damping=wrong-sign",
    ),
    (
        "oscillator",
        "stiffness=1e-9 modulus=1e-9 density=1e-9 gravity=1e-9 radius=1e-9 time-step=1e-9 wall=1e-9 start=half-step",
    ),
    (
        "oscillator-order",
        "stiffness=1e-5 time-step=1e-5 start=half-step",
    ),
    (
        "oscillator-with-local-damping",
        "damping=1e-9 stiffness=1e-9 damping=wrong-sign",
    ),
    (
        "two-stacked-grains",
        "stiffness=1e-9 density=1e-9 radius=1e-9 wall=1e-9 gravity=1e-6",
    ),
    (
        "tangential-spring",
        "shear-stiffness=1e-9 density=1e-9 time-step=1e-9 ratcheting=other",
    ),
    (
        "turning-spring",
        "shear-stiffness=1e-9 inertia=1e-9 radius=1e-9 torque-arms=other ratcheting=other",
    ),
    (
        "sliding-ball",
        "friction=1e-9 inertia=1e-9 gravity=1e-9 time-step=1e-9 torque-arms=other",
    ),
    (
        "slip-then-roll",
        "inertia=1e-9 torque-arms=other ratcheting=other friction=1e-3",
    ),
    (
        "rolling-incline",
        "inertia=1e-9 gravity=1e-9 shear-stiffness=1e-9 torque-arms=other",
    ),
    ("sliding-incline", "friction=1e-9 inertia=1e-9 gravity=1e-9"),
    ("momentum", "inertia=1e-6"),
    ("elastic-energy", "stiffness=1e-2 density=1e-2"),
    ("lost-energy", "damping=wrong-sign"),
    (
        "column-of-discs",
        "gravity=1e-9 density=1e-9 stiffness=1e-9 wall=missing",
    ),
    (
        "pyramid-of-discs",
        "gravity=1e-9 density=1e-9 stiffness=1e-9",
    ),
    (
        "extensive-stress-of-a-disc",
        "stiffness=1e-9 radius=1e-9 wall=1e-9",
    ),
    ("field-inside-a-disc", "wall=1e-9"),
    ("mirror", "wall=1e-12 wall=missing"),
    ("quarter-turn", "wall=1e-12 wall=missing"),
    ("shift", "wall=1e-9"),
    ("other-numbers", "radius=1e-9 inertia=1e-6"),
    ("moving-frame", "time-step=1e-6"),
    ("recorded-pouring", "stiffness=1e-12"),
];

/// Springs that swing as the scheme's own solution.
const SWING: &str =
    "stiffness=1e-11 modulus=1e-11 density=1e-11 radius=1e-11 time-step=1e-11 wall=1e-11";

#[test]
fn every_group_holds_and_says_why() {
    for group in groups() {
        let checks = judged(&group, None);
        assert!(!checks.is_empty(), "{}", group.id);
        for check in checks {
            assert_eq!(check.outcome, Outcome::Pass, "{}: {check:?}", group.id);
            assert!(
                !check.basis.is_empty() && !check.unit.is_empty(),
                "{check:?}"
            );
        }
    }
}

#[test]
fn every_group_detects_the_faults_that_it_is_about() {
    for group in groups() {
        let of = FAULTS.iter().find(|(id, _)| *id == group.id);
        let (_, faults) = of.unwrap_or_else(|| panic!("no faults of {}", group.id));
        let swing = if group.id.starts_with("leapfrog-") {
            SWING
        } else {
            ""
        };
        for fault in faults.split_whitespace().chain(swing.split_whitespace()) {
            let checks = judged(&group, Some(fault.parse().expect("a fault")));
            assert_eq!(outcome(&checks), Outcome::Fail, "{} with {fault}", group.id);
        }
    }
    let ids: BTreeSet<&str> = groups().iter().map(|group| group.id).collect();
    assert!(FAULTS.iter().all(|(id, _)| ids.contains(id)));
}

/// An engine that returned nothing has shown nothing.
#[test]
fn missing_tracks_and_moments_hold_nowhere() {
    for group in groups() {
        let tracks = vec![Track::new(); group.cases.len()];
        let checks = group.judge(&tracks);
        assert_eq!(outcome(&checks), Outcome::Fail, "{}", group.id);
        let symmetric = group.evidence == Evidence::Symmetry;
        let passes = |check: &Check| check.outcome == Outcome::Pass;
        assert!(
            symmetric || !checks.iter().any(passes),
            "{}: {checks:?}",
            group.id
        );
        assert_eq!(outcome(&group.judge(&tracks[1..])), Outcome::Fail);
        assert_eq!(outcome(&group.judge(&[])), Outcome::Fail);
    }
}

#[test]
fn ids_are_plain_and_unique() {
    let mut ids = BTreeSet::new();
    let plain = |letter: char| {
        letter.is_ascii_lowercase() || letter.is_ascii_digit() || "-./_".contains(letter)
    };
    for group in groups() {
        assert!(group.id.chars().all(plain) && ids.insert(group.id.to_owned()));
        for check in judged(&group, None) {
            let id = format!("{}/{}", group.id, check.id);
            assert!(id.chars().all(plain), "{id}");
            assert!(ids.insert(id.clone()), "{id} twice");
        }
    }
}

#[test]
fn cases_are_short_and_their_moments_rise() {
    for group in groups() {
        for case in &group.cases {
            let (id, name) = (group.id, &case.name);
            assert!(case.moments.is_sorted_by(|a, b| a < b), "{id} {name}");
            // YADE has to make the longest, too.
            let last = case.moments.last().copied().expect("a moment");
            assert!(last <= 20_000, "{id} {name}: {last} steps");
        }
    }
}

#[test]
fn what_yade_lacks_is_in_groups_of_its_own() {
    for group in groups() {
        let lacks = |case: &Case| unsupported(&case.model).is_some();
        let marked = ["-unclipped", "-restitution", "-since-touch"];
        let marked = marked.iter().any(|end| group.id.ends_with(end));
        assert_eq!(group.cases.iter().any(lacks), marked, "{}", group.id);
    }
}

#[test]
fn the_furthest_value_may_be_none() {
    assert_eq!(furthest(1.0, [1.5, 0.0, 2.0]), 0.0);
    assert!(furthest(1.0, [1.5, f64::NAN, 2.0]).is_nan());
}

#[test]
fn a_check_is_named_by_its_id_and_judged_by_one_rule() {
    let mut figures = Figures::default();
    figures.case("pair/e-0.5");
    figures
        .because("a bound")
        .is("contact-time, s", 1.5, 1.0, 0.5);
    figures.is("rest: at rest, in the end, m", f64::NAN, 0.0, f64::INFINITY);
    let checks = figures.done();
    assert_eq!(checks[0].id, "pair/e-0.5/contact-time");
    assert_eq!(checks[0].quantity, "contact time, pair/e 0.5");
    assert_eq!(
        (checks[0].unit.as_str(), checks[0].outcome),
        ("s", Outcome::Pass)
    );
    assert_eq!(checks[1].quantity, "at rest, in the end, pair/e 0.5");
    assert_eq!(checks[1].outcome, Outcome::Fail);
}
