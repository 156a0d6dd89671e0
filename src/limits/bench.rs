//! Benchmarks: all engines side by side on the paper's settled bed, stages, and cost against size. What fails is an engine
//! that does not run or whose bed is no longer the bed; no time does.

pub mod bed;
pub mod contender;
mod document;
pub mod machine;
pub mod scaling;
pub mod timing;

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::compare::bits::TableBits;
use crate::engine::{EngineError, ProgramError};
use crate::error::Error;
use crate::files::work_folder;
use crate::progress::{Display, StageObserver};
use crate::study::realization::Engines;
use grains::native::timing::Share;

use bed::{Bed, PAPER};
use contender::{Contender, Contest};
use machine::Machine;
use scaling::{Point, SpeedUp};
use timing::Spread;

type Result<T, E = Error> = std::result::Result<T, E>;

fn nonsense(what: impl ToString) -> Error {
    ProgramError::Nonsense(what.to_string()).into()
}

/// A part that was skipped, or went wrong.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Missed {
    /// In the id of its check, unique.
    pub id: String,
    pub what: String,
    pub why: String,
    /// It is there and failed, instead of not being there.
    pub failed: bool,
    pub needed: bool,
}

impl Missed {
    /// Of this error; a signal and a full disk end the benchmark instead.
    pub fn of(id: &str, what: &str, needed: bool, error: Error) -> Result<Self> {
        use ProgramError::{File, Missing, Refused, TooOld, Unsupported};
        let missing = match &error {
            Error::File(_) | Error::Engine(EngineError::Program(File(_))) => return Err(error),
            Error::Engine(failure) if failure.is_interruption() => return Err(error),
            Error::Engine(EngineError::Program(failure)) => matches!(
                failure,
                Missing { .. } | TooOld { .. } | Unsupported { .. } | Refused(_)
            ),
            _ => false,
        };
        Ok(Missed {
            id: id.to_owned(),
            what: what.to_owned(),
            why: error.to_string(),
            failed: !missing,
            needed,
        })
    }
}

#[derive(Debug, Clone)]
pub struct Options {
    /// Where beds are kept for a later run.
    pub out: PathBuf,
    /// Few rounds and small sizes only.
    pub quick: bool,
    pub rounds: Option<u32>,
    /// One more engine may be among them, an external one.
    pub engines: Engines,
    /// This program, for the parts that need a process of their own.
    pub crossgrain: PathBuf,
    pub command: String,
}

#[derive(Debug, Clone, Copy)]
pub struct Plan {
    pub rounds: u32,
    pub warm_up: u64,
    /// Steps of a window of the native engine, and of another one.
    pub native: u64,
    pub other: u64,
    /// Steps with YADE's own timers on.
    pub shares: u64,
    /// Numbers of grains, rising: those up to the paper's are settled, the larger ones laid out of copies of it.
    pub sizes: &'static [u32],
    /// Times that each native point is measured.
    pub repeats: u32,
}

impl Plan {
    pub const QUICK: Plan = Plan {
        rounds: 3,
        warm_up: 50,
        native: 8_000,
        other: 150,
        shares: 50,
        sizes: &[1_000, PAPER],
        repeats: 1,
    };
    pub const FULL: Plan = Plan {
        rounds: 11,
        // Not longer: rounding grows on the way, and beds are compared at its end.
        warm_up: 50,
        native: 16_000,
        other: 250,
        shares: 100,
        sizes: &[
            1_000, 2_000, PAPER, 10_000, 20_000, 50_000, 100_000, 1_000_000,
        ],
        repeats: 9,
    };

    pub fn compared_after(&self) -> u64 {
        self.warm_up + self.other
    }
}

#[derive(Debug, Clone, Copy)]
pub struct Setup<'a> {
    pub plan: Plan,
    /// The paper's.
    pub bed: &'a Bed,
    pub with_friction: &'a Bed,
    /// As many spheres.
    pub in_space: &'a Bed,
    pub engines: &'a Engines,
    pub crossgrain: &'a Path,
    /// A folder for the processes.
    pub work: &'a Path,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BedRecord {
    pub grains: u32,
    pub scene_digest: String,
    /// Digest of positions and velocities.
    pub state: String,
    pub listed_pairs: usize,
    pub touching_pairs: usize,
    /// Steps from one build of the neighbour list to the next.
    pub steps_per_build: f64,
}

/// A finished benchmark: `bench.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bench {
    pub crossgrain: String,
    pub command: String,
    pub quick: bool,
    pub rounds: u32,
    pub machine: Machine,
    pub bed: BedRecord,
    pub contests: Vec<Contest>,
    /// Native against YADE's sorted loop after the same steps.
    pub sorted_bits: Option<TableBits>,
    /// The same on the bed with friction: spins too.
    pub friction_bits: Option<TableBits>,
    /// The same of spheres in space.
    pub space_bits: Option<TableBits>,
    /// Time a step of native with friction over that without, round by round.
    pub friction_cost: Option<Spread>,
    pub stages: Vec<Share>,
    pub scaling: Vec<Point>,
    pub speed_ups: Vec<SpeedUp>,
    /// Whether the machine had other things to do meanwhile, as far as clocks tell: then no time is to be trusted, and
    /// ratios against YADE flatter, because its steps suffer more from shared caches.
    pub disturbed: bool,
    pub missed: Vec<Missed>,
    pub seconds: f64,
}

/// Steps with clocks between their stages.
const CLOCKED_STEPS: u64 = 4000;

pub fn bench(options: &Options, display: &Display) -> Result<Bench> {
    let began = std::time::Instant::now();
    let machine = Machine::this();
    let work = work_folder()?;
    let task = display.task("the paper's bed");
    let bed = bed::settled_or_kept(&options.out, PAPER, &mut StageObserver(&task))?;
    let in_space = bed::poured_or_kept(&options.out, PAPER)?;
    task.done("settled");

    let mut plan = [Plan::FULL, Plan::QUICK][usize::from(options.quick)];
    plan.rounds = options.rounds.unwrap_or(plan.rounds);
    let with_friction = bed.with_friction();
    let setup = Setup {
        plan,
        bed: &bed,
        with_friction: &with_friction,
        in_space: &in_space,
        engines: &options.engines,
        crossgrain: &options.crossgrain,
        work: work.path(),
    };
    let task = display.task("engines side by side");
    let mut missed = Vec::new();
    let (contests, bits) = contender::rounds(&setup, &task, &mut missed)?;
    let [sorted_bits, friction_bits, space_bits] = bits;
    task.done(&format!("{} rounds", plan.rounds));

    let task = display.task("stages");
    let clocked = timing::clocked(&bed, CLOCKED_STEPS)?;
    task.done("measured");

    let task = display.task("cost against size");
    let (scaling, speed_ups) = scaling::measure(&setup, &task, &mut missed)?;
    task.done(&format!("{} sizes", plan.sizes.len()));

    let friction_cost = friction_cost(&contests);
    Ok(Bench {
        crossgrain: env!("CARGO_PKG_VERSION").to_owned(),
        command: options.command.clone(),
        quick: options.quick,
        rounds: plan.rounds,
        machine,
        bed: BedRecord {
            grains: PAPER,
            scene_digest: bed.scene.digest(),
            state: bed.bodies.digest(),
            listed_pairs: clocked.listed_pairs,
            touching_pairs: clocked.touching_pairs,
            steps_per_build: CLOCKED_STEPS as f64 / clocked.builds.max(1) as f64,
        },
        stages: clocked.shares,
        friction_cost,
        disturbed: (contests
            .iter()
            .filter_map(|contest| contest.processor_share))
        .any(|share| share < UNDISTURBED),
        contests,
        sorted_bits,
        friction_bits,
        space_bits,
        scaling,
        speed_ups,
        missed,
        seconds: began.elapsed().as_secs_f64(),
    })
}

fn friction_cost(contests: &[Contest]) -> Option<Spread> {
    let find = |wanted| contests.iter().find(|contest| contest.contender == wanted);
    let [friction, native] = [Contender::NativeFriction, Contender::Native].map(find);
    Spread::ratio(&friction?.seconds_per_step, &native?.seconds_per_step)
}

/// A processor share below this in some round says that somebody else was at work.
const UNDISTURBED: f64 = 0.95;
