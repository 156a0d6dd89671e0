//! A punch that stands still once the force is reached.

use grains::scene::AfterForce;

use crate::support::*;

fn standing(seconds: f64) -> Scene {
    let mut scene = small_scene();
    scene.measurement.history_every = 100;
    scene.loading.after_force = AfterForce::StandStill { seconds };
    scene
}

#[test]
fn the_punch_stops_where_it_reached_the_force_and_stands_as_long_as_it_is_told() {
    let scene = standing(0.02);
    let mut at_once = scene.clone();
    at_once.loading.after_force = AfterForce::MeasureAtOnce;
    let task = Task::whole(initial_bodies(&scene));
    let (reached, _) = native_outcome(&at_once, &task, None);
    let (stood, moments) = native_outcome(&scene, &task, None);
    let [reached_load, stood_load] = [&reached, &stood].map(|outcome| outcome.stages[1].clone());
    assert_eq!(reached_load.stop, StopReason::Reached);
    assert_eq!(stood_load.stop, StopReason::Reached);
    let steps = scene.steps_standing_still().expect("it stands");
    assert_eq!(steps, (0.02 / scene.time_step_seconds()).round() as u64);
    assert_eq!(stood_load.steps, reached_load.steps + steps);
    let [at_reach, at_end] = [&reached, &stood].map(|outcome| outcome.last.punch.expect("a punch"));
    assert!(at_reach.force >= scene.target_force());
    assert_eq!(at_end.centre, at_reach.centre);
    assert_eq!(at_end.velocity, 0.0);
    assert_ne!(at_end.force, at_reach.force);
    // Until then nothing differs.
    assert_eq!(reached.settled, stood.settled);
    let before = moments.iter().filter(|moment| moment.stage == Stage::Load);
    let moved = before.filter(|moment| moment.step < reached_load.steps);
    assert!(moved.clone().count() > 0);
    let down = |moment: &Snapshot| moment.punch.is_some_and(|punch| punch.velocity < 0.0);
    assert!(moved.into_iter().all(down));
}

/// As a first difference is looked for: a run that is taken up while the punch stands goes on as it would have.
#[test]
fn a_standing_punch_goes_on_standing_when_the_run_is_taken_up() {
    let scene = standing(0.02);
    let task = Task::whole(initial_bodies(&scene));
    let (whole, moments) = native_outcome(&scene, &task, None);
    let standing = |punch: &Punch| punch.velocity == 0.0;
    let middle = moments
        .iter()
        .find(|moment| moment.stage == Stage::Load && moment.punch.as_ref().is_some_and(standing));
    let middle = middle.expect("a moment of standing");
    let end = whole.stages[1].steps;
    assert!(middle.step < end);
    let start = middle.clone().into();
    let until = Until::Step(end);
    let (again, _) = native_outcome(&scene, &Task { start, until }, None);
    assert_eq!(again.last.digest(), whole.last.digest());
    // The same with a punch that moves is another run: the bits do depend on it.
    let mut moving = whole.last.clone();
    if let Some(punch) = &mut moving.punch {
        punch.centre[1] -= 1.0e-9;
    }
    assert_ne!(moving.digest(), whole.last.digest());
}
