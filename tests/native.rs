//! The native engine: what it allocates here; the kernels against the method written out plainly, rules, troubles and the punch
//! in files of their own. Exact solutions are the suite's (`verify`).

mod all_pairs;
mod ends;
mod punch;

use crate::support::*;

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
