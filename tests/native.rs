//! The native engine: where it ends and what it allocates here; the kernels against the step written out plainly, rules,
//! troubles and the punch in files of their own. Exact solutions are the suite's (`verify`).

mod ends;
mod punch;
mod reference;

use crate::support::*;

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
fn allocations(mut scene: Scene, steps: u64) -> u64 {
    scene.measurement.history_every = 1_000_000;
    let (bed, _) = native_outcome(&scene, &Task::settle(initial_bodies(&scene)), None);
    let task = Task::pour(bed.last.bodies, steps);
    allocation_counter::measure(|| {
        native::run(&scene, &task, &sound(), &mut ()).expect("a sound run");
    })
    .count_total
}

#[test]
fn a_steady_step_allocates_nothing() {
    let mut rough = small_scene();
    rough.material.friction_angle = 0.5;
    for scene in [small_scene(), rough] {
        let short = allocations(scene.clone(), 200);
        let long = allocations(scene, 900);
        assert!(short > 0, "starting a run allocates");
        // The table at the end grows with its contacts; 700 steps of their own would show.
        assert!(long < short + 20, "{short}, {long}");
    }
}
