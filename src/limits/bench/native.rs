//! Steps of the native engine, timed from outside: by what it tells its observer.

use std::time::Instant;

use grains::native::timing::ThreadTime;

use super::BenchError;
use super::bed::{Bed, start};
use grains::native::timing::Window;
use grains::native::{self, Mode, NativeError};
use grains::tables::{Bodies, Snapshot, Stage};
use grains::task::{Observer, Task, Until};

/// Parts of a timed run: the first warms up, the others are the window.
const PARTS: u64 = 5;

/// Times about `steps` steps of this bed, after a quarter as many to warm up.
pub fn time(bed: &Bed, mode: Mode, steps: u64) -> Result<Window, BenchError> {
    let part = part(steps);
    let mut scene = bed.scene.clone();
    scene.measurement.history_every = u64::from(u32::MAX);
    // The engine tells how far it is whenever it looks whether the bed has settled: once a part. The looks cost
    // one sum over the grains each. No bed is ever settled by this rule.
    scene.settle.check_every = part;
    scene.settle.kinetic_energy_fraction = f64::MIN_POSITIVE;
    let task = Task {
        start: start(bed.bodies.clone()),
        until: Until::Step(PARTS * part),
    };
    let mut watch = Watch::default();
    native::run(&scene, &task, &options(mode), &mut watch)?;
    match watch {
        Watch {
            began: Some((step0, wall0, cpu0)),
            last: Some((step1, wall1, cpu1)),
        } if step1 == PARTS * part => Ok(Window {
            steps: step1 - step0,
            wall_seconds: (wall1 - wall0).as_secs_f64(),
            cpu_seconds: Some(cpu1.duration_since(cpu0).as_secs_f64()),
        }),
        _ => Err(BenchError::Nonsense(
            "the native engine did not tell how far it was".to_owned(),
        )),
    }
}

/// All steps that [`time`] does for a window of so many.
pub fn all_steps(steps: u64) -> u64 {
    PARTS * part(steps)
}

fn part(steps: u64) -> u64 {
    steps.div_ceil(PARTS - 1).max(1)
}

/// The bed after exactly so many steps.
pub fn after(bed: &Bed, mode: Mode, steps: u64) -> Result<Snapshot, NativeError> {
    let mut scene = bed.scene.clone();
    scene.measurement.history_every = u64::from(u32::MAX);
    let task = Task {
        start: start(bed.bodies.clone()),
        until: Until::Step(steps),
    };
    Ok(native::run(&scene, &task, &options(mode), &mut ())?.last)
}

/// Where the exact mode's time goes in so many steps, and what it was spent on.
pub fn clocked(bed: &Bed, steps: u64) -> Result<native::timing::Clocked, BenchError> {
    let model = grains::model::Model::of(&bed.scene);
    let mean_radius = 0.5 * bed.scene.particles.mean_diameter;
    let mode = Mode::Exact;
    let clocked = native::timing::parts_of_a_step(&model, &bed.bodies, mean_radius, mode, steps)
        .map_err(|trouble| BenchError::Nonsense(trouble.to_string()))?;
    let plain: Bodies = after(bed, Mode::Exact, steps)?.bodies;
    if plain.digest() == clocked.bodies.digest() {
        Ok(clocked)
    } else {
        Err(BenchError::Nonsense(
            "the step with clocks in it has other bits than the engine's".to_owned(),
        ))
    }
}

fn options(mode: Mode) -> native::Options {
    native::Options {
        mode,
        ..native::Options::default()
    }
}

type Moment = (u64, Instant, ThreadTime);

/// The first and the last time that the engine told how far it is.
#[derive(Default)]
struct Watch {
    began: Option<Moment>,
    last: Option<Moment>,
}

impl Observer for Watch {
    fn snapshot(&mut self, _: &Snapshot) {}

    fn progress(&mut self, _: Stage, step: u64, _: f64) {
        let now = (step, Instant::now(), ThreadTime::now());
        self.began.get_or_insert(now);
        self.last = Some(now);
    }
}
