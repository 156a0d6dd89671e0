//! An external engine on the settled bed.

use crossgrain::engine::exec::{ExternalEngine, Options};
use crossgrain::error::Error;
use crossgrain::limits::bench::bed::{self, Bed};
use crossgrain::limits::bench::contender::{Contender, StateCheck, Tolerance};
use crossgrain::limits::bench::{Missed, Plan, Setup, timing};
use crossgrain::study::realization::Engines;
use grains::native::timing::Window;

use crate::support::*;

const PLAN: Plan = Plan {
    warm_up: 10,
    native: 100,
    other: 20,
    ..Plan::QUICK
};

/// A turn of the engine on this bed.
fn turn(bed: &Bed, external: &ExternalEngine) -> Result<(Window, StateCheck, String), Error> {
    let engines = Engines {
        external: Some(external.clone()),
        ..Engines::default()
    };
    let work = new_folder();
    let setup = Setup {
        plan: PLAN,
        bed,
        with_friction: bed,
        in_space: bed,
        engines: &engines,
        crossgrain: &work,
        work: &work,
    };
    let (timed, version) = Contender::External.run(&setup)?;
    assert_eq!(version, external.description.version);
    let native = timing::after(bed, PLAN.compared_after())?;
    let state_check = Contender::External.check(&timed.last, &setup, &native);
    Ok((
        timed.window,
        state_check,
        setup.name_of(Contender::External),
    ))
}

fn small_bed(grains: u32) -> Bed {
    bed::settled(grains, &mut ()).expect("a bed that settles")
}

fn toy(from: &str, to: &str) -> (Place, ExternalEngine) {
    let folder = new_folder();
    let path = program(&folder, "toy.py", &changed_toy(from, to));
    let engine = ExternalEngine::ask(Options::new(path)).expect("an engine");
    (folder, engine)
}

#[test]
fn its_steps_are_timed_by_two_runs_and_its_bed_is_held_against_native() {
    let external = ExternalEngine::ask(Options::new(adapter_path("toy.py"))).expect("the toy");
    let (window, state_check, name) = turn(&small_bed(60), &external).expect("a turn");
    // As long as it takes until the two differ by a second.
    assert!(window.steps.is_multiple_of(PLAN.compared_after()));
    let seconds = window.cpu_seconds;
    assert!(seconds.is_some_and(|seconds| seconds >= 1.0), "{window:?}");
    assert!(
        state_check.holds && state_check.steps == 30,
        "{state_check:?}"
    );
    // The toy has the native engine's bits.
    assert_eq!(state_check.displacement, 0.0);
    assert_eq!(name, "exec:toy");
    assert_eq!(external.description.version, "1");
}

#[test]
fn a_bed_that_is_no_longer_the_bed_is_seen() {
    let (_folder, external) = toy("2.0 * a * a / (a + a)", "0.5 * a");
    let (_, state_check, _) = turn(&small_bed(60), &external).expect("a turn");
    assert!(!state_check.holds, "{state_check:?}");
}

#[test]
fn what_it_says_of_itself_widens_what_is_allowed() {
    let says = "\"version\": \"1\", \"approximations\": [\"springs\"]";
    let (_folder, external) = toy("\"version\": \"1\"", says);
    let (_, state_check, _) = turn(&small_bed(60), &external).expect("a turn");
    assert_eq!(state_check.tolerance, Tolerance::OTHER_LAW);
}

#[test]
fn a_bed_that_it_cannot_take_is_not_made_with_its_reason() {
    let missed = |external: &ExternalEngine, grains| {
        let error = turn(&small_bed(grains), external).expect_err("not made");
        let needed = Contender::External.needed();
        let missed = Missed::of("external", "exec:toy", needed, error);
        missed.expect("no interruption")
    };
    let sound = ExternalEngine::ask(Options::new(adapter_path("toy.py"))).expect("the toy");
    let refused = missed(&sound, 250);
    assert!(refused.why.contains("more than 200 grains"), "{refused:?}");
    let (_folder, lacking) = toy("\"gravity\", \"walls\", \"cases\"]", "\"gravity\"]");
    let lacking = missed(&lacking, 60);
    assert!(lacking.why.contains("toy has no walls"), "{lacking:?}");
    for missed in [refused, lacking] {
        assert!(!missed.failed && missed.needed, "{missed:?}");
    }
    let (_folder, broken) = toy("job[\"kind\"] == \"cases\"", "job[\"no such key\"]");
    assert!(missed(&broken, 60).failed);
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs LAMMPS and LIGGGHTS")]
fn lammps_takes_the_bed() {
    let external = ExternalEngine::ask(Options::new(adapter_path("lammps.py"))).expect("LAMMPS");
    let (window, state_check, name) = turn(&small_bed(500), &external).expect("a turn");
    assert!(state_check.holds, "{state_check:?}");
    assert!(window.steps >= 30 && name == "exec:LAMMPS");
}
