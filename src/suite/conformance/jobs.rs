//! The small jobs that an engine is examined with.

use super::{Story, contacts_agree, how_close, moments_agree};
use crate::suite::build::{Grain, case, model, springs, wall};
use grains::generate::initial_bodies;
use grains::model::Axis;
use grains::scene::{Cloud, Damping, Scene, paper_scene};
use grains::tables::{Bodies, Stage};
use grains::task::Case;
use grains::task::{Start, Task, Until};

/// Largest difference over the radius that rounding explains after some tens of steps of one contact.
pub fn rounding(single: bool) -> f64 {
    if single { 1.0e-3 } else { 1.0e-9 }
}
/// In a bed after some hundred steps rounding has grown by so much.
const GROWN: f64 = 1.0e3;

/// How a run is judged: what was found, or what is wrong.
type Judge = fn(&Job, &Story, &Story) -> Result<String, String>;

/// One small job.
pub struct Job {
    /// Lasting and unique.
    pub id: &'static str,
    /// What it is, in one line.
    pub what: &'static str,
    /// The scene.
    pub scene: Scene,
    /// What is run of it.
    pub task: Task,
    /// The engine computes in single precision.
    pub single: bool,
    /// Holds the engine's run against the native one.
    pub judge: Judge,
}

/// All of them, from what everything rests on to what rests on all of it.
pub fn all() -> Vec<Job> {
    vec![
        job(
            "start",
            "three grains, no step: the start and its contacts as they are",
            grains(
                &[
                    ([0.005, 0.004999], [0.0, 0.0], 0.005),
                    ([0.014998, 0.0051], [0.1, 0.2], 0.005),
                    ([0.5, 0.3], [0.0, 0.0], 0.004),
                ],
                0,
                1,
            ),
            |job, theirs, native| {
                contacts_agree(&theirs.moments[0], &native.moments[0], job.single)?;
                Ok("the start and its contacts are right".to_owned())
            },
        ),
        flight(),
        job(
            "damping",
            "grains in the air that rise, fall and turn round, two steps with Cundall's damping",
            grains(
                &[
                    ([0.3, 0.3], [0.2, -0.1], 0.005),
                    ([0.5, 0.3], [0.2, 0.1], 0.005),
                    ([0.7, 0.3], [0.0, 0.00001], 0.005),
                ],
                2,
                1,
            ),
            super::damping,
        ),
        job(
            "walls",
            "one grain into the corner of floor and wall",
            grains(&[([0.0051, 0.0052], [-0.3, -0.4], 0.005)], 60, 10),
            |job, theirs, native| {
                moments_agree(&theirs.moments, &native.moments, rounding(job.single))?;
                Ok("it bounces as it should".to_owned())
            },
        ),
        job(
            "pair",
            "two grains of other sizes meet",
            grains(
                &[
                    ([0.5, 0.3], [0.3, 0.0], 0.005),
                    ([0.5091, 0.3005], [-0.3, 0.1], 0.004),
                ],
                40,
                5,
            ),
            |job, theirs, native| {
                moments_agree(&theirs.moments, &native.moments, rounding(job.single))?;
                Ok("they part as they should".to_owned())
            },
        ),
        bed(),
        rules(),
        punch(),
    ]
}

fn job(id: &'static str, what: &'static str, (scene, task): (Scene, Task), judge: Judge) -> Job {
    Job {
        id,
        what,
        scene,
        task,
        single: false,
        judge,
    }
}

/// One grain: place, velocity, radius.
type Given = ([f64; 2], [f64; 2], f64);

/// Some grains in the paper's box for so many steps, looked at every `every`.
fn grains(given: &[Given], steps: u64, every: u64) -> (Scene, Task) {
    let mut scene = paper_scene(1, given.len() as u32);
    scene.measurement.history_every = every;
    let mut bodies = Bodies::with_capacity(given.len());
    for &(position, velocity, radius) in given {
        bodies.push(position, velocity, radius, scene.grain_mass(radius));
    }
    (scene, Task::pour(bodies, steps))
}

fn flight() -> Job {
    let (mut scene, task) = grains(&[([0.5, 0.3], [0.2, -0.1], 0.005)], 2, 1);
    scene.damping = Damping::Cundall { alpha: 0.0 };
    job(
        "flight",
        "one grain in the air for two steps, no damping: gravity and the order of a step",
        (scene, task),
        super::flight,
    )
}

/// A small bed of one size.
fn small_bed(grains: u32) -> Scene {
    let mut scene = paper_scene(1, grains);
    scene.particles.dispersion = 0.0;
    scene.container.width = 0.06;
    let Cloud::JitteredLattice { columns, .. } = &mut scene.cloud;
    *columns = 5;
    scene.loading.half_width = 0.012;
    scene.loading.give_up_depth = 0.005;
    scene.control_points.clear();
    scene.measurement.history_every = 100;
    scene
}

/// Twenty grains of one size, poured for four hundred steps.
pub fn bed() -> Job {
    let scene = small_bed(20);
    let task = Task::pour(initial_bodies(&scene), 400);
    job(
        "bed",
        "twenty grains of one size, poured for 400 steps",
        (scene, task),
        |job, theirs, native| {
            moments_agree(
                &theirs.moments,
                &native.moments,
                GROWN * rounding(job.single),
            )?;
            Ok(how_close(theirs, native))
        },
    )
}

fn rules() -> Job {
    let mut scene = small_bed(10);
    // A rule that holds early: the energy of the cloud has fallen to nine tenths before the grains come down.
    scene.settle.kinetic_energy_fraction = 0.9;
    scene.settle.check_every = 40;
    let task = Task {
        until: Until::EndOfSettling,
        ..Task::whole(initial_bodies(&scene))
    };
    job(
        "rules",
        "ten grains until the settle rule holds",
        (scene, task),
        super::rules,
    )
}

fn punch() -> Job {
    let mut scene = small_bed(5);
    scene.loading.speed = 0.5;
    scene.measurement.history_every = 20;
    let radius = 0.005;
    let mut bodies = Bodies::with_capacity(5);
    for column in 0..5 {
        let x = 0.008 + 0.011 * f64::from(column);
        bodies.push([x, radius], [0.0; 2], radius, scene.grain_mass(radius));
    }
    let task = Task {
        start: Start {
            stage: Stage::Load,
            step: 0,
            bodies,
            punch: None,
        },
        until: Until::Step(60),
    };
    job(
        "punch",
        "the punch comes down on five grains on the floor for 60 steps",
        (scene, task),
        super::punch,
    )
}

/// Two experiments that are no scenes.
pub fn cases() -> Vec<Case> {
    let small = |x: f64, speed: f64| Grain::disc([x, 0.0], 0.5, 1000.0).moving([speed, 0.0]);
    let law = springs(1.0e6);
    let mut on_wall = model(law.clone(), 1.0e-3);
    on_wall.walls = vec![wall(Axis::X, 2.0)];
    vec![
        case(
            "two grains meet",
            model(law, 1.0e-3),
            &[small(0.0, 1.0), small(1.001, -1.0)],
            vec![0, 7, 30],
        ),
        case(
            "a grain meets a wall from the left",
            on_wall,
            &[small(1.499, 1.0)],
            vec![0, 7, 30],
        ),
    ]
}
