//! Steps of the native engine, timed from outside: by what it tells its observer, here or in a process of its own, so that
//! its memory is its own. And what repeated measurements come to.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use evidence::Interval;
use serde::{Deserialize, Serialize};
use statrs::distribution::{Binomial, DiscreteCDF};

use super::bed::Bed;
use super::{Result, nonsense};
use crate::engine::exec;
use crate::engine::limits::Limits;
use crate::files::{FileError, Place, new_folder, read_text, remove_folder, write_whole};
use crate::study::realization::unobserved;
use crate::tables::{read_bodies, write_bodies};
use grains::native::timing::{ThreadTime, Window};
use grains::native::{self, NativeError, Threads};
use grains::scene::Scene;
use grains::tables::{Bodies, Snapshot, Stage};
use grains::task::Observer;

/// Parts of a timed run: the first warms up, the others are the window.
const PARTS: u64 = 5;

/// Times about `steps` steps of this bed on at most so many threads, after a quarter as many to warm up.
pub fn time(bed: &Bed, steps: u64, threads: usize) -> Result<Window> {
    let part = part(steps);
    let mut scene = unobserved(&bed.scene);
    // The engine tells how far it is whenever it looks whether the bed has settled: once a part. The looks cost
    // one sum over the grains each. No bed is ever settled by this rule.
    scene.settle.check_every = part;
    scene.settle.kinetic_energy_fraction = f64::MIN_POSITIVE;
    let mut watch = Watch::default();
    let options = native::Options {
        threads: Threads::at_most(threads),
        ..native::Options::default()
    };
    native::run(&scene, &bed.task(PARTS * part), &options, &mut watch)?;
    match watch.0[..] {
        [(step0, wall0, cpu0), .., (step1, wall1, cpu1)] if step1 == PARTS * part => Ok(Window {
            steps: step1 - step0,
            wall_seconds: (wall1 - wall0).as_secs_f64(),
            // Of this thread, which is not all of several.
            cpu_seconds: (threads == 1).then(|| cpu1.duration_since(cpu0).as_secs_f64()),
        }),
        _ => Err(nonsense("the native engine did not tell how far it was")),
    }
}

fn part(steps: u64) -> u64 {
    steps.div_ceil(PARTS - 1).max(1)
}

/// The bed after exactly so many steps.
pub fn after(bed: &Bed, steps: u64) -> Result<Snapshot, NativeError> {
    let scene = unobserved(&bed.scene);
    let options = native::Options::default();
    Ok(native::run(&scene, &bed.task(steps), &options, &mut ())?.last)
}

/// Where the native engine's time goes in so many steps, and what it was spent on.
pub fn clocked(bed: &Bed, steps: u64) -> Result<native::timing::Clocked> {
    let model = grains::model::Model::of(&bed.scene);
    let mean_radius = 0.5 * bed.scene.particles.mean_diameter;
    let clocked = native::timing::parts_of_a_step(&model, &bed.bodies, mean_radius, steps)
        .map_err(nonsense)?;
    let plain: Bodies = after(bed, steps)?.bodies;
    if plain.digest() != clocked.bodies.digest() {
        let why = "the step with clocks in it has other bits than the engine's";
        return Err(nonsense(why));
    }
    Ok(clocked)
}

/// The step and the times whenever the engine told how far it is.
#[derive(Default)]
struct Watch(Vec<(u64, Instant, ThreadTime)>);

impl Observer for Watch {
    fn snapshot(&mut self, _: &Snapshot) {}

    fn progress(&mut self, _: Stage, step: u64, _: f64) {
        self.0.push((step, Instant::now(), ThreadTime::now()));
    }
}

/// What the process says when it is done.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct One {
    pub window: Window,
    /// Largest resident memory, bytes, where the system tells.
    pub peak_memory: Option<u64>,
    /// The widest vector unit that the processor shows it.
    pub vector_unit: String,
}

/// Puts a bed where [`one`] finds it.
pub fn write_bed(bed: &Bed, folder: &Path) -> Result<()> {
    let text = serde_json::to_string(&bed.scene).map_err(nonsense)?;
    write_whole((folder, "scene.json"), text.as_bytes())?;
    Ok(write_bodies((folder, "bed.csv"), &bed.bodies)?)
}

/// Inside the process: times the bed in this folder.
pub fn one(folder: &Path, steps: u64, threads: usize) -> Result<One> {
    let text = read_text((folder, "scene.json"), 1 << 20)?;
    // Not through the check of scenes: a narrow box has no room for the paper's control points.
    let scene: Scene = serde_json::from_str(&text).map_err(nonsense)?;
    let bodies = read_bodies((folder, "bed.csv"), scene.particles.count);
    let bodies = bodies.map_err(|error| match error {
        FileError::Unfit(words) => nonsense(words),
        error => error.into(),
    })?;
    let window = time(&Bed { scene, bodies }, steps, threads)?;
    Ok(One {
        window,
        peak_memory: crate::run::peak_memory(),
        vector_unit: super::machine::vector_unit().to_owned(),
    })
}

/// The arguments that make the program `crossgrain` do [`one`].
pub fn arguments(folder: &Path, steps: u64, threads: usize) -> [String; 7] {
    let (folder, steps) = (folder.display().to_string(), steps.to_string());
    let threads = threads.to_string();
    let words = [
        "bench",
        "--one",
        &folder,
        "--one-steps",
        &steps,
        "--one-threads",
        &threads,
    ];
    words.map(str::to_owned)
}

/// Outside: starts the process on the bed in `folder` and waits for it.
pub fn in_a_process(
    crossgrain: &Path,
    folder: &Path,
    steps: u64,
    threads: usize,
    limit: Duration,
) -> Result<One> {
    let mut command = Command::new(crossgrain);
    let command = command.args(arguments(folder, steps, threads));
    let log = run(command, folder, limit)?;
    // What it printed is one line, among others.
    log.lines()
        .find(|line| line.starts_with('{'))
        .and_then(|line| serde_json::from_str(line).ok())
        .ok_or_else(|| nonsense("the timing process said nothing"))
}

/// Runs a program in `work`, which it may do without a sign of life, and returns what it wrote on both outputs.
pub fn run(command: &mut Command, work: &Path, limit: Duration) -> Result<String> {
    let limits = Limits {
        time: limit,
        stall: limit,
        ..exec::usual_limits()
    };
    exec::finish(command, exec::SAID, &limits, work, &mut (), &mut || true)?;
    Ok(exec::log(work))
}

pub fn folder(work: &Path, name: &str) -> Result<PathBuf> {
    let folder = work.join(name);
    if Place::from(&folder).is_taken() {
        remove_folder(&folder)?;
    }
    new_folder(&folder)?;
    Ok(folder)
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Spread {
    /// Every measurement, in the order of the rounds.
    pub all: Vec<f64>,
    pub median: f64,
    pub low_quartile: f64,
    pub high_quartile: f64,
    pub least: f64,
    pub most: f64,
}

impl Spread {
    pub fn of(all: Vec<f64>) -> Option<Self> {
        let mut sorted = all.clone();
        sorted.sort_by(f64::total_cmp);
        Some(Spread {
            median: quantile(&sorted, 0.5)?,
            low_quartile: quantile(&sorted, 0.25)?,
            high_quartile: quantile(&sorted, 0.75)?,
            least: *sorted.first()?,
            most: *sorted.last()?,
            all,
        })
    }

    /// The median with its 95 % interval, by ranks, whatever the law of the measurements; none for fewer than six of them.
    pub fn median_interval(&self) -> Option<Interval> {
        let mut sorted = self.all.clone();
        sorted.sort_by(f64::total_cmp);
        let law = Binomial::new(0.5, sorted.len() as u64).ok()?;
        let outside = (0..sorted.len() / 2).rfind(|rank| 2.0 * law.cdf(*rank as u64) <= 0.05)?;
        Some(Interval {
            estimate: self.median,
            low: sorted[outside],
            high: sorted[sorted.len() - 1 - outside],
        })
    }

    /// `a` over `b`, round by round.
    pub fn ratio(a: &Spread, b: &Spread) -> Option<Self> {
        Spread::of(a.all.iter().zip(&b.all).map(|(a, b)| a / b).collect())
    }
}

/// Linear between the measurements, as R's type 7.
fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let place = share * sorted.len().checked_sub(1)? as f64;
    let below = sorted[place as usize];
    let above = sorted[(place.ceil()) as usize];
    Some(below + (place - place.floor()) * (above - below))
}

#[cfg(test)]
mod tests {
    use super::Spread;

    #[test]
    fn quartiles_lie_between_the_measurements() {
        let spread = Spread::of(vec![4.0, 1.0, 3.0, 2.0]).expect("there are some");
        let quartiles = [spread.low_quartile, spread.median, spread.high_quartile];
        assert_eq!(quartiles, [1.75, 2.5, 3.25]);
        assert_eq!((spread.least, spread.most), (1.0, 4.0));
        let one = Spread::of(vec![7.0]).expect("there is one");
        assert_eq!((one.low_quartile, one.high_quartile), (7.0, 7.0));
        assert_eq!(Spread::of(Vec::new()), None);
    }

    /// Of eleven the second and the tenth, as in tables of the sign test; of five none are far enough out.
    #[test]
    fn medians_have_intervals_by_ranks() {
        let spread = |count: u32| Spread::of((1..=count).map(f64::from).collect());
        let ends = |count| {
            spread(count)?
                .median_interval()
                .map(|interval| [interval.low, interval.high])
        };
        let expected = [(5, None), (6, Some([1.0, 6.0])), (11, Some([2.0, 10.0]))];
        for (count, wanted) in expected {
            assert_eq!(ends(count), wanted);
        }
    }

    #[test]
    fn ratios_are_taken_round_by_round() {
        let spread = |all: &[f64]| Spread::of(all.to_vec()).expect("there are some");
        let ratio = Spread::ratio(&spread(&[2.0, 40.0]), &spread(&[1.0, 10.0])).expect("two");
        assert_eq!(ratio.all, [2.0, 4.0]);
    }
}
