//! Cost and memory against the number of grains, each size in a process of its own.

use std::path::PathBuf;

use serde::Serialize;

use super::bed::{self, Bed, PAPER};
use super::contender::{self, Contender};
use super::timing::{self, Spread};
use super::{Missed, Setup, nonsense};
use crate::engine::read::TimedSteps;
use crate::error::Error;
use crate::progress::Task;

/// Grains times steps of a native window: some tenths of a second.
const NATIVE_GRAIN_STEPS: u64 = 40_000_000;
/// The same of YADE's.
const YADE_GRAIN_STEPS: u64 = 1_000_000;
/// Steps of the smallest window: enough that none is all warm-up.
const FEWEST_STEPS: u64 = 20;

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

pub fn measure(setup: &Setup<'_>, progress: &Task) -> Result<(Vec<Point>, Vec<Missed>), Error> {
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
    let mut missed = Vec::new();
    for bed in &beds {
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
    Ok((points, missed))
}

/// Repeats go round all sizes, so that a busy minute does not fall on one of them alone.
fn native_points(setup: &Setup<'_>, beds: &[Bed], progress: &Task) -> Result<Vec<Point>, Error> {
    let written = |bed: &Bed, end: &str| {
        let name = format!("bed-{}{end}", bed.bodies.len());
        let folder = timing::folder(setup.work, &name)?;
        timing::write_bed(bed, &folder)?;
        Ok::<PathBuf, Error>(folder)
    };
    let mut folders = Vec::new();
    for bed in beds {
        let disorder = Bed {
            scene: bed.scene.clone(),
            bodies: bed::shuffled(&bed.bodies),
        };
        folders.push([written(bed, "")?, written(&disorder, "-shuffled")?]);
    }
    let mut times = vec![(Vec::new(), None); beds.len() * NATIVE.len()];
    for repeat in 0..setup.plan.repeats {
        for (at, bed) in beds.iter().enumerate() {
            let grains = bed.bodies.len() as u64;
            progress.share(
                0.1 + 0.6 * f64::from(repeat) / f64::from(setup.plan.repeats),
                &format!("native, {grains} grains"),
            );
            let steps = (NATIVE_GRAIN_STEPS / grains).max(FEWEST_STEPS);
            for (way, folder) in folders[at].iter().enumerate() {
                let one =
                    timing::in_a_process(setup.crossgrain, folder, steps, setup.yade.limits.time)?;
                let (all, memory) = &mut times[at * NATIVE.len() + way];
                all.push(one.window.seconds_per_step());
                *memory = one.peak_memory;
            }
        }
    }
    let points = times.into_iter().enumerate();
    let points = points.filter_map(|(index, (all, memory))| {
        let grains = beds[index / NATIVE.len()].bodies.len() as u32;
        let name = NATIVE[index % NATIVE.len()];
        Some(point(name, grains, Spread::of(all)?, memory))
    });
    Ok(points.collect())
}

fn in_yade(setup: &Setup<'_>, bed: &Bed) -> Result<Point, Error> {
    let grains = bed.bodies.len() as u32;
    let timed = (YADE_GRAIN_STEPS / u64::from(grains)).max(FEWEST_STEPS);
    let steps = TimedSteps {
        warm_up: timed.div_ceil(4),
        timed,
        shares: 0,
    };
    let folder = timing::folder(setup.work, "yade")?;
    let (run, _) = contender::timed(Contender::YadeOrdinary, bed, steps, setup.yade, &folder)?;
    let all = vec![run.window.seconds_per_step()];
    let spread = Spread::of(all).ok_or_else(|| nonsense("no time"))?;
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
