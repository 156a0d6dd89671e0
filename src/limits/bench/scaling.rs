//! Cost and memory against the number of grains, each size in a process of its own.

use std::path::Path;

use serde::Serialize;

use super::bed::{self, Bed, PAPER};
use super::contender::{self, Contender};
use super::timing::{self, One, Spread};
use super::{Missed, Result, Setup};
use crate::engine::read::{Timed, TimedSteps};
use crate::error::Error;
use crate::progress::Task;

/// Grains times steps of a native window: some tenths of a second.
const NATIVE_GRAIN_STEPS: u64 = 40_000_000;
/// The same of YADE's.
const YADE_GRAIN_STEPS: u64 = 1_000_000;
/// Steps of the smallest window: enough that none is all warm-up.
const FEWEST_STEPS: u64 = 20;
/// The same of native: a neighbour list lasts some hundred steps, and its share of the cost belongs to it.
const FEWEST_NATIVE_STEPS: u64 = 200;

/// One way of computing one size.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Point {
    /// The engine and its way: `native`, `native, ids shuffled`, `YADE -j1, ordinary loop`.
    pub name: String,
    pub grains: u32,
    pub seconds_per_step: Spread,
    pub seconds_per_grain: f64,
    /// Largest resident memory of the process, bytes.
    pub peak_memory: Option<u64>,
}

/// The native engine on a bed as it is, and with its ids shuffled.
const NATIVE: [&str; 2] = ["native", "native, ids shuffled"];

const YADE: &str = "YADE -j1, ordinary loop";

/// Larger beds are native's alone: what others take of them, they take of these.
const LARGEST_OF_OTHERS: u32 = 100_000;

/// What one bed gains by a second thread or process: times on the clock.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpeedUp {
    /// The engine and its way: `native`, `LAMMPS gran/hooke, mpirun -np 2`.
    pub name: String,
    pub grains: u32,
    /// Seconds a step.
    pub one: Spread,
    pub two: Spread,
    /// Time on one over that on two, round by round.
    pub times: Spread,
    /// Time on two over native's on two, round by round.
    pub over_native: Option<Spread>,
}

pub fn measure(
    setup: &Setup<'_>,
    progress: &Task,
    missed: &mut Vec<Missed>,
) -> Result<(Vec<Point>, Vec<SpeedUp>)> {
    let mut beds = Vec::new();
    for &size in setup.plan.sizes {
        progress.share(0.0, &format!("a bed of {size} grains"));
        beds.push(match size {
            PAPER => setup.bed.clone(),
            small if small < PAPER => bed::settled(small, &mut ())?,
            large => bed::laid_out(setup.bed, large / PAPER)?,
        });
    }
    let mut points = native_points(setup, &beds, progress)?;
    for bed in beds.iter().filter(|bed| bed.grains() <= LARGEST_OF_OTHERS) {
        let grains = bed.grains();
        progress.share(0.7, &format!("YADE, {grains} grains"));
        match in_program(setup, Contender::YadeOrdinary, bed, 1) {
            Ok(timed) => {
                let times = vec![timed.window.seconds_per_step()];
                points.extend(point(YADE, grains, times, timed.peak_memory));
            }
            Err(error) => {
                let what = "cost against the number of grains in YADE";
                missed.push(Missed::of("sizes", what, true, error)?);
                break;
            }
        }
    }
    let mut speed_ups = Vec::new();
    let both = |bed: &&Bed| [PAPER, LARGEST_OF_OTHERS].contains(&bed.grains());
    for bed in beds.iter().filter(both) {
        progress.share(0.8, &format!("two threads, {} grains", bed.grains()));
        speed_ups.extend(on_two(setup, bed, missed)?);
    }
    Ok((points, speed_ups))
}

/// Engines that compute one bed on two threads or processes, and the name of that way.
const ON_TWO: [(Contender, &str); 3] = [
    (Contender::Native, "native, two threads allowed"),
    (Contender::YadeOrdinary, "YADE -j2, ordinary loop"),
    (Contender::Lammps, "LAMMPS gran/hooke, mpirun -np 2"),
];

/// Every engine on one and on two, in turns; others on the largest of their beds alone.
fn on_two(setup: &Setup<'_>, bed: &Bed, missed: &mut Vec<Missed>) -> Result<Vec<SpeedUp>> {
    let grains = bed.grains();
    let placed = timing::folder(setup.work, "two")?;
    timing::write_bed(bed, &placed)?;
    let one = |contender: Contender, processes: u32| {
        let window = if contender == Contender::Native {
            // Threads wait for each other now and then, and looks whether the bed is at rest are one thread's.
            let steps = 4 * NATIVE_GRAIN_STEPS / u64::from(grains);
            in_native(setup, &placed, steps, processes as usize)?.window
        } else {
            in_program(setup, contender, bed, processes)?.window
        };
        Ok::<f64, Error>(window.wall_seconds / window.steps as f64)
    };
    let mut all = ON_TWO.map(|_| [Vec::new(), Vec::new()]);
    for _ in 0..setup.plan.repeats {
        for ((contender, name), times) in ON_TWO.into_iter().zip(&mut all) {
            let id = format!("two/{}", contender.id());
            let wanted = contender == Contender::Native || grains == LARGEST_OF_OTHERS;
            if !wanted || missed.iter().any(|missing| missing.id == id) {
                continue;
            }
            match one(contender, 1).and_then(|of_one| Ok((of_one, one(contender, 2)?))) {
                Ok((of_one, of_two)) => {
                    times[0].push(of_one);
                    times[1].push(of_two);
                }
                Err(error) => missed.push(Missed::of(&id, name, false, error)?),
            }
        }
    }
    let native = Spread::of(all[0][1].clone());
    let rows = ON_TWO.into_iter().zip(all);
    let speed_ups = rows.filter_map(|((contender, name), [one, two])| {
        let (one, two) = (Spread::of(one)?, Spread::of(two)?);
        let native = native.as_ref().filter(|_| contender != Contender::Native);
        Some(SpeedUp {
            name: name.to_owned(),
            grains,
            times: Spread::ratio(&one, &two)?,
            over_native: native.and_then(|native| Spread::ratio(&two, native)),
            one,
            two,
        })
    });
    Ok(speed_ups.collect())
}

/// Times the bed in this folder in a process of its own.
fn in_native(setup: &Setup<'_>, placed: &Path, steps: u64, threads: usize) -> Result<One> {
    let limit = setup.engines.yade.limits.time;
    timing::in_a_process(setup.crossgrain, placed, steps, threads, limit)
}

/// Times a few steps of this bed in another engine.
fn in_program(setup: &Setup<'_>, contender: Contender, bed: &Bed, processes: u32) -> Result<Timed> {
    let timed = (YADE_GRAIN_STEPS / u64::from(bed.grains())).max(FEWEST_STEPS);
    let steps = TimedSteps {
        warm_up: timed.div_ceil(4),
        timed,
        shares: 0,
        processes,
    };
    let folder = timing::folder(setup.work, "turn")?;
    Ok(contender::timed(contender, bed, steps, &setup.engines.yade, &folder)?.0)
}

/// Repeats go round all sizes, so that a busy minute does not fall on one of them alone.
fn native_points(setup: &Setup<'_>, beds: &[Bed], progress: &Task) -> Result<Vec<Point>> {
    let mut ways = Vec::new();
    for bed in beds {
        let shuffled = Bed {
            scene: bed.scene.clone(),
            bodies: bed::shuffled(&bed.bodies),
        };
        for (name, bed) in NATIVE.into_iter().zip([bed, &shuffled]) {
            let folder = timing::folder(setup.work, &format!("{} {name}", bed.grains()))?;
            timing::write_bed(bed, &folder)?;
            ways.push((name, bed.grains(), folder, Vec::new(), None));
        }
    }
    for repeat in 0..setup.plan.repeats {
        for (_, grains, folder, times, memory) in &mut ways {
            let share = 0.1 + 0.6 * f64::from(repeat) / f64::from(setup.plan.repeats);
            progress.share(share, &format!("native, {grains} grains"));
            let steps = (NATIVE_GRAIN_STEPS / u64::from(*grains)).max(FEWEST_NATIVE_STEPS);
            let one = in_native(setup, folder, steps, 1)?;
            times.push(one.window.seconds_per_step());
            *memory = one.peak_memory;
        }
    }
    let points = (ways.into_iter())
        .filter_map(|(name, grains, _, times, memory)| point(name, grains, times, memory));
    Ok(points.collect())
}

fn point(name: &str, grains: u32, times: Vec<f64>, peak_memory: Option<u64>) -> Option<Point> {
    let seconds_per_step = Spread::of(times)?;
    Some(Point {
        name: name.to_owned(),
        grains,
        seconds_per_grain: seconds_per_step.median / f64::from(grains),
        seconds_per_step,
        peak_memory,
    })
}
