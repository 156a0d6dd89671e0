//! Cost and memory against the number of grains, each size in a process of its own.

use serde::Serialize;

use super::bed::{self, Bed, PAPER};
use super::contender::{self, Contender};
use super::timing::{self, Spread};
use super::{Missed, Result, Setup, nonsense};
use crate::engine::read::TimedSteps;
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

pub const YADE: &str = "YADE -j1, ordinary loop";

/// Larger beds are native's alone: what others take of them, they take of these.
pub const LARGEST_OF_OTHERS: u32 = 100_000;

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
    let of_others = |bed: &&Bed| bed.bodies.len() as u32 <= LARGEST_OF_OTHERS;
    for bed in beds.iter().filter(of_others) {
        let grains = bed.bodies.len() as u32;
        progress.share(0.7, &format!("YADE, {grains} grains"));
        match in_yade(setup, bed) {
            Ok(point) => points.push(point),
            Err(error) => {
                let what = "cost against the number of grains in YADE";
                missed.push(Missed::of("sizes", what, true, error)?);
                break;
            }
        }
    }
    let mut speed_ups = Vec::new();
    for bed in &beds {
        let grains = bed.bodies.len() as u32;
        if [PAPER, LARGEST_OF_OTHERS].contains(&grains) {
            progress.share(0.8, &format!("two threads, {grains} grains"));
            speed_ups.extend(on_two(setup, bed, missed)?);
        }
    }
    Ok((points, speed_ups))
}

/// Engines that compute one bed on two threads or processes, and the name of that way.
pub const ON_TWO: [(Contender, &str); 3] = [
    (Contender::Native, "native, two threads allowed"),
    (Contender::YadeOrdinary, "YADE -j2, ordinary loop"),
    (Contender::Lammps, "LAMMPS gran/hooke, mpirun -np 2"),
];

/// Every engine on one and on two, in turns; others on the largest of their beds alone.
fn on_two(setup: &Setup<'_>, bed: &Bed, missed: &mut Vec<Missed>) -> Result<Vec<SpeedUp>> {
    let grains = bed.bodies.len() as u32;
    let native = timing::folder(setup.work, "two")?;
    timing::write_bed(bed, &native)?;
    let one = |contender: Contender, processes: u32| {
        let window = if contender == Contender::Native {
            // Threads wait for each other now and then, and looks whether the bed is at rest are one thread's.
            let steps = 4 * NATIVE_GRAIN_STEPS / u64::from(grains);
            let (threads, limit) = (processes as usize, setup.engines.yade.limits.time);
            timing::in_a_process(setup.crossgrain, &native, steps, threads, limit)?.window
        } else {
            let folder = timing::folder(setup.work, "turn")?;
            let (steps, yade) = (few_steps(grains, processes), &setup.engines.yade);
            let (timed, _) = contender::timed(contender, bed, steps, yade, &folder)?;
            timed.window
        };
        Ok::<f64, Error>(window.wall_seconds / window.steps as f64)
    };
    let mut all = ON_TWO.map(|_| [Vec::new(), Vec::new()]);
    for _ in 0..setup.plan.repeats {
        for ((contender, name), times) in ON_TWO.iter().zip(&mut all) {
            let id = format!("two/{}", contender.id());
            let wanted = *contender == Contender::Native || grains == LARGEST_OF_OTHERS;
            if !wanted || missed.iter().any(|of| of.id == id) {
                continue;
            }
            match one(*contender, 1).and_then(|of| Ok([of, one(*contender, 2)?])) {
                Ok([one, two]) => {
                    times[0].push(one);
                    times[1].push(two);
                }
                Err(error) => missed.push(Missed::of(&id, name, false, error)?),
            }
        }
    }
    let native = Spread::of(all[0][1].clone());
    let of_all = ON_TWO.iter().zip(all);
    let speed_ups = of_all.filter_map(|((contender, name), [one, two])| {
        let (one, two) = (Spread::of(one)?, Spread::of(two)?);
        let native = native.as_ref().filter(|_| *contender != Contender::Native);
        Some(SpeedUp {
            name: (*name).to_owned(),
            grains,
            times: Spread::ratio(&one, &two)?,
            over_native: native.and_then(|native| Spread::ratio(&two, native)),
            one,
            two,
        })
    });
    Ok(speed_ups.collect())
}

fn few_steps(grains: u32, processes: u32) -> TimedSteps {
    let timed = (YADE_GRAIN_STEPS / u64::from(grains)).max(FEWEST_STEPS);
    TimedSteps {
        warm_up: timed.div_ceil(4),
        timed,
        shares: 0,
        processes,
    }
}

/// Repeats go round all sizes, so that a busy minute does not fall on one of them alone.
fn native_points(setup: &Setup<'_>, beds: &[Bed], progress: &Task) -> Result<Vec<Point>> {
    let mut ways = Vec::new();
    for bed in beds {
        let mut disorder = bed.clone();
        disorder.bodies = bed::shuffled(&bed.bodies);
        let grains = bed.bodies.len() as u32;
        for (name, bed) in NATIVE.into_iter().zip([bed, &disorder]) {
            let folder = timing::folder(setup.work, &format!("{grains} {name}"))?;
            timing::write_bed(bed, &folder)?;
            ways.push((name, grains, folder, Vec::new(), None));
        }
    }
    let repeats = f64::from(setup.plan.repeats);
    for repeat in 0..setup.plan.repeats {
        for (_, grains, folder, times, memory) in &mut ways {
            let share = 0.1 + 0.6 * f64::from(repeat) / repeats;
            progress.share(share, &format!("native, {grains} grains"));
            let steps = (NATIVE_GRAIN_STEPS / u64::from(*grains)).max(FEWEST_NATIVE_STEPS);
            let limit = setup.engines.yade.limits.time;
            let one = timing::in_a_process(setup.crossgrain, folder, steps, 1, limit)?;
            times.push(one.window.seconds_per_step());
            *memory = one.peak_memory;
        }
    }
    let points = ways
        .into_iter()
        .filter_map(|(name, grains, _, times, memory)| {
            Some(point(name, grains, Spread::of(times)?, memory))
        });
    Ok(points.collect())
}

fn in_yade(setup: &Setup<'_>, bed: &Bed) -> Result<Point> {
    let grains = bed.bodies.len() as u32;
    let steps = few_steps(grains, 1);
    let folder = timing::folder(setup.work, "yade")?;
    let (yade, contender) = (&setup.engines.yade, Contender::YadeOrdinary);
    let (run, _) = contender::timed(contender, bed, steps, yade, &folder)?;
    let spread = Spread::of(vec![run.window.seconds_per_step()]);
    let spread = spread.ok_or_else(|| nonsense("no time"))?;
    Ok(point(YADE, grains, spread, run.peak_memory))
}

fn point(name: &str, grains: u32, seconds_per_step: Spread, peak_memory: Option<u64>) -> Point {
    Point {
        name: name.to_owned(),
        grains,
        seconds_per_grain: seconds_per_step.median / f64::from(grains),
        seconds_per_step,
        peak_memory,
    }
}
