use std::collections::BTreeSet;

use super::*;
use crate::engine::yade::unsupported;
use crate::suite::{Line, Track};
use grains::native::perturb::{Quantity, Switch};
use grains::native::{Perturbation, run_case};

/// The longest case in steps: YADE has to make it too.
const MOST_STEPS: u64 = 20_000;

/// What the rung's lines are with a fault; nothing if a case did not run.
fn climb(rung: &Rung, fault: Option<Perturbation>) -> Option<Vec<Line>> {
    let run = |case| run_case(case, fault).ok();
    let tracks: Option<Vec<Track>> = rung.cases.iter().map(run).collect();
    tracks.map(|tracks| (rung.judge)(&tracks))
}

fn notices(rung: &Rung, fault: Perturbation) -> bool {
    let broken = |lines: Vec<Line>| lines.iter().any(|line| !line.holds());
    climb(rung, Some(fault)).is_none_or(broken)
}

fn sized(quantity: Quantity, size: f64) -> Perturbation {
    Perturbation::Sized(quantity, size)
}

fn rung(name: &str) -> Rung {
    let found = rungs().into_iter().find(|rung| rung.name == name);
    found.unwrap_or_else(|| panic!("no rung {name}"))
}

#[test]
fn every_rung_holds_natively() {
    for rung in rungs() {
        let lines = climb(&rung, None).expect("cases that run");
        assert!(!lines.is_empty(), "{}", rung.name);
        for line in lines {
            // Shown with --nocapture: how much of its tolerance a line takes.
            let share = (line.value - line.expected) / line.tolerance;
            println!("{} | {} | {share:.4}", rung.name, line.quantity);
            assert!(line.holds(), "{}: {line:?}", rung.name);
            assert!(!line.basis.is_empty() && !line.unit.is_empty());
        }
    }
}

#[test]
fn names_are_in_kebab_case_and_their_own() {
    let mut names = BTreeSet::new();
    for rung in rungs() {
        let plain =
            |letter: char| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '-';
        assert!(rung.name.chars().all(plain), "{}", rung.name);
        assert!(names.insert(rung.name), "{} twice", rung.name);
    }
}

#[test]
fn cases_are_short_and_their_moments_rise() {
    for rung in rungs() {
        for case in &rung.cases {
            assert!(
                case.moments.is_sorted_by(|a, b| a < b),
                "{} {}",
                rung.name,
                case.name
            );
            let last = case.moments.last().copied().expect("a moment");
            assert!(
                last <= MOST_STEPS,
                "{} {}: {last} steps",
                rung.name,
                case.name
            );
        }
    }
}

#[test]
fn what_yade_lacks_is_in_rungs_of_its_own() {
    for rung in rungs() {
        let lacking = rung
            .cases
            .iter()
            .filter(|case| unsupported(&case.model).is_some())
            .count();
        let marked = ["-unclipped", "-restitution", "-since-touch"]
            .iter()
            .any(|end| rung.name.ends_with(end));
        assert_eq!(lacking > 0, marked, "{}", rung.name);
    }
}

/// An engine that returned nothing has shown nothing.
#[test]
fn missing_tracks_and_moments_hold_nowhere() {
    for rung in rungs() {
        let empty = vec![Track::new(); rung.cases.len()];
        let lines = (rung.judge)(&empty);
        assert!(!lines.is_empty(), "{}", rung.name);
        for line in lines.iter().chain(&(rung.judge)(&[])) {
            assert!(!line.holds(), "{}: {line:?}", rung.name);
        }
    }
}

/// Of each rung one fault that it is about, and how small a one it must notice.
#[test]
fn every_rung_notices_the_faults_that_it_is_about() {
    use Quantity as Q;
    let faults: &[(&str, &[(Quantity, f64)])] = &[
        (
            "bounce-local-damping",
            &[(Q::Damping, 1.0e-4), (Q::Stiffness, 1.0e-4)],
        ),
        (
            "bounce-dashpot",
            &[(Q::Dashpot, 1.0e-4), (Q::Density, 1.0e-4)],
        ),
        (
            "bounce-dashpot-unclipped",
            &[(Q::Dashpot, 1.0e-4), (Q::Density, 1.0e-4)],
        ),
        ("bounce-restitution", &[(Q::Dashpot, 1.0e-4)]),
        (
            "drop-on-wall",
            &[(Q::Gravity, 1.0e-10), (Q::Stiffness, 1.0e-4)],
        ),
        (
            "drop-on-wall-unclipped",
            &[(Q::Gravity, 1.0e-10), (Q::Stiffness, 1.0e-3)],
        ),
        (
            "repeated-bounces",
            &[(Q::Gravity, 1.0e-3), (Q::Dashpot, 1.0e-2)],
        ),
        ("repeated-bounces-local-damping", &[(Q::Damping, 1.0e-4)]),
        (
            "chung-ooi-1-2-elastic",
            &[(Q::Modulus, 1.0e-5), (Q::TimeStep, 1.0e-5)],
        ),
        ("chung-ooi-3-rebound", &[(Q::Dashpot, 1.0e-4)]),
        ("chung-ooi-3-rebound-unclipped", &[(Q::Dashpot, 1.0e-4)]),
        (
            "oblique-impact",
            &[(Q::Friction, 1.0e-9), (Q::Inertia, 1.0e-7)],
        ),
        (
            "chung-ooi-4-oblique",
            &[(Q::Friction, 1.0e-6), (Q::Inertia, 1.0e-6)],
        ),
        (
            "gross-sliding",
            &[(Q::Friction, 1.0e-9), (Q::Inertia, 1.0e-8)],
        ),
        (
            "spin-impact",
            &[(Q::Friction, 1.0e-9), (Q::Inertia, 1.0e-8)],
        ),
        (
            "gross-sliding-pair",
            &[(Q::Friction, 1.0e-4), (Q::Inertia, 1.0e-10)],
        ),
        ("opposite-spins", &[(Q::Radius, 1.0e-10)]),
    ];
    for (name, faults) in faults {
        for (quantity, size) in *faults {
            assert!(
                notices(&rung(name), sized(*quantity, *size)),
                "{name}: {quantity} {size}"
            );
        }
    }
}

#[test]
fn rungs_on_the_scheme_itself_notice_faults_of_1e_11() {
    use Quantity as Q;
    let swing = [
        Q::Stiffness,
        Q::Modulus,
        Q::Density,
        Q::Radius,
        Q::TimeStep,
        Q::Wall,
    ];
    let also: &[(&str, &[Quantity])] = &[
        ("leapfrog-spring", &[]),
        ("leapfrog-dashpot", &[Q::Dashpot]),
        ("leapfrog-dashpot-unclipped", &[Q::Dashpot]),
        ("leapfrog-local-damping", &[Q::Damping]),
        ("leapfrog-drop", &[Q::Damping, Q::Dashpot, Q::Gravity]),
        ("leapfrog-sliding", &[Q::Friction, Q::Inertia, Q::Dashpot]),
        (
            "leapfrog-sticking",
            &[Q::ShearStiffness, Q::Inertia, Q::Gravity],
        ),
    ];
    for (name, also) in also {
        for quantity in swing.iter().chain(*also) {
            assert!(
                notices(&rung(name), sized(*quantity, 1.0e-11)),
                "{name}: {quantity}"
            );
        }
    }
    for name in ["first-slip", "first-slip-since-touch"] {
        for quantity in [Q::ShearStiffness, Q::Modulus, Q::Radius, Q::TimeStep] {
            assert!(
                notices(&rung(name), sized(quantity, 1.0e-10)),
                "{name}: {quantity}"
            );
        }
    }
}

#[test]
fn a_thing_done_in_another_way_is_noticed() {
    let faults: &[(Switch, &[&str])] = &[
        (
            Switch::Wall,
            &[
                "bounce-local-damping",
                "chung-ooi-3-rebound",
                "leapfrog-drop",
            ],
        ),
        (
            Switch::DampingSign,
            &["bounce-local-damping", "leapfrog-local-damping"],
        ),
        (
            Switch::Start,
            &["drop-on-wall", "leapfrog-spring", "leapfrog-sticking"],
        ),
        (
            Switch::TorqueArms,
            &["oblique-impact", "gross-sliding", "leapfrog-sliding"],
        ),
        (
            Switch::Ratcheting,
            &["opposite-spins", "leapfrog-sticking", "first-slip"],
        ),
        (
            Switch::Clipping,
            &["bounce-dashpot", "bounce-restitution", "drop-on-wall"],
        ),
    ];
    for (switch, names) in faults {
        for name in *names {
            let fault = Perturbation::Switched(*switch);
            assert!(notices(&rung(name), fault), "{name}: {switch}");
        }
    }
}
