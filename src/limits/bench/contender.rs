//! The engines that are timed side by side, behind one word: in rounds, so that whatever slows the machine down slows all of
//! them, and each with a look at its bed, because an engine that drops grains or contacts is fast and its time means nothing.

use std::path::Path;

use serde::Serialize;

use super::bed::Bed;
use super::timing::{self, Spread};
use super::{Missed, Plan, Setup, nonsense};
use crate::compare::bits::{self, TableBits};
use crate::engine::exec::{self, Adapter, ExecRun, ExternalEngine, run_external};
use crate::engine::read::{Timed, TimedSteps};
use crate::engine::{ProgramError, yade};
use crate::error::Error;
use crate::progress;
use crate::study::realization::unobserved;
use grains::model::Model;
use grains::native::timing::{Share, Window};
use grains::tables::{Bodies, Snapshot};

/// An engine in one of its ways of working.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Contender {
    /// The native engine, YADE's bits.
    Native,
    /// YADE `-j1`, its own order.
    YadeOrdinary,
    /// YADE `-j1`, interactions in the order of their ids.
    YadeSorted,
    Lammps,
    Liggghts,
    /// The first on the bed with friction.
    NativeFriction,
    YadeOrdinaryFriction,
    YadeSortedFriction,
    LammpsFriction,
    /// A program that speaks the engine protocol.
    External,
}

/// Those that always take part, in the order in which they stand in tables.
pub const ALL: [Contender; 9] = [
    Contender::Native,
    Contender::YadeOrdinary,
    Contender::YadeSorted,
    Contender::Lammps,
    Contender::Liggghts,
    Contender::NativeFriction,
    Contender::YadeOrdinaryFriction,
    Contender::YadeSortedFriction,
    Contender::LammpsFriction,
];

impl Setup<'_> {
    /// What it computes.
    pub fn bed_of(&self, contender: Contender) -> &Bed {
        match contender.friction() {
            true => self.with_friction,
            false => self.bed,
        }
    }

    /// For tables. An external engine may have the name of one that takes part anyway.
    pub fn name_of(&self, contender: Contender) -> String {
        match (contender, self.external) {
            (Contender::External, Some(of)) => format!("exec:{}", of.description.name),
            _ => contender.known().name.to_owned(),
        }
    }

    /// Where it says that it does something else than the model says.
    fn approximations_of(&self, contender: Contender) -> Vec<String> {
        match (contender, self.external) {
            (Contender::External, Some(of)) => of.description.approximations.clone(),
            _ => Vec::new(),
        }
    }
}

#[derive(Debug)]
pub struct Turn {
    pub window: Window,
    /// The bed after [`Plan::compared_after`] steps, and its contacts between grains; a native engine is not asked
    /// here, because its window is longer.
    pub bed: Option<(Bodies, usize)>,
    pub version: String,
    /// Largest resident memory of its process, where that is known.
    pub peak_memory: Option<u64>,
    /// Its own account of where the time goes.
    pub shares: Vec<Share>,
}

/// Goals: how many times native's time a step of YADE's ordinary loop is to take, and one of LAMMPS; the same with friction.
pub const YADE_OVER_NATIVE: f64 = 30.0;
pub const LAMMPS_OVER_NATIVE: f64 = 7.0;
pub const YADE_OVER_NATIVE_FRICTION: f64 = 25.0;
pub const LAMMPS_OVER_NATIVE_FRICTION: f64 = 4.0;

pub struct Known {
    /// In ids of checks, unique.
    pub id: &'static str,
    pub name: &'static str,
    /// Part of this program, so timed longer and without a process of its own.
    pub native: bool,
    tolerance: Tolerance,
    pub needed: bool,
    /// How many times native's time a step of it is to take, where that is a goal.
    pub goal: Option<f64>,
}

impl Turn {
    fn new(window: Window, version: String, bed: Option<&Snapshot>) -> Self {
        Turn {
            window,
            bed: bed.map(|last| (last.bodies.clone(), between_grains(last))),
            version,
            peak_memory: None,
            shares: Vec::new(),
        }
    }
}

impl Contender {
    /// Whether it computes the bed with friction.
    pub fn friction(self) -> bool {
        use Contender::{LammpsFriction, NativeFriction, YadeOrdinaryFriction, YadeSortedFriction};
        matches!(
            self,
            NativeFriction | YadeOrdinaryFriction | YadeSortedFriction | LammpsFriction
        )
    }

    fn sorted(self) -> bool {
        matches!(self, Contender::YadeSorted | Contender::YadeSortedFriction)
    }

    pub fn known(self) -> Known {
        use Tolerance as Within;
        let other = |id, name, tolerance| Known {
            id,
            name,
            native: false,
            tolerance,
            needed: true,
            goal: None,
        };
        let native = |id, name| Known {
            native: true,
            ..other(id, name, Within::ROUNDING)
        };
        match self {
            Contender::Native => native("native", "native"),
            Contender::YadeOrdinary => Known {
                goal: Some(YADE_OVER_NATIVE),
                ..other("ordinary-loop", "YADE -j1, ordinary loop", Within::ROUNDING)
            },
            Contender::YadeSorted => {
                other("sorted-loop", "YADE -j1, sorted loop", Within::ROUNDING)
            }
            Contender::Lammps => Known {
                needed: false,
                goal: Some(LAMMPS_OVER_NATIVE),
                ..other("gran-hooke", "LAMMPS gran/hooke", Within::OTHER_LAW)
            },
            Contender::Liggghts => Known {
                needed: false,
                ..other(
                    "hooke-stiffness",
                    "LIGGGHTS hooke/stiffness",
                    Within::OTHER_LAW,
                )
            },
            Contender::NativeFriction => native("native-friction", "native, friction"),
            Contender::YadeOrdinaryFriction => Known {
                goal: Some(YADE_OVER_NATIVE_FRICTION),
                ..other(
                    "ordinary-loop-friction",
                    "YADE -j1, ordinary loop, friction",
                    Within::ROUNDING,
                )
            },
            Contender::YadeSortedFriction => other(
                "sorted-loop-friction",
                "YADE -j1, sorted loop, friction",
                Within::ROUNDING,
            ),
            Contender::LammpsFriction => Known {
                needed: false,
                goal: Some(LAMMPS_OVER_NATIVE_FRICTION),
                ..other(
                    "gran-hooke-history",
                    "LAMMPS gran/hooke/history, friction",
                    Within::OTHER_LAW,
                )
            },
            Contender::External => other("external", "exec", Within::OTHER_OPERATIONS),
        }
    }

    /// Times its window on the bed.
    pub fn run(self, setup: &Setup<'_>) -> Result<Turn, Error> {
        let (bed, plan) = (setup.bed_of(self), &setup.plan);
        let folder = timing::folder(setup.work, "turn")?;
        if self.known().native {
            let window = timing::time(bed, plan.native, 1)?;
            return Ok(Turn::new(
                window,
                env!("CARGO_PKG_VERSION").to_owned(),
                None,
            ));
        }
        if self == Contender::External {
            let engine = setup.external.ok_or_else(|| {
                ProgramError::Refused("none was named: --engine exec:PATH".to_owned())
            })?;
            return by_two_runs(bed, plan, engine, &folder);
        }
        // Only YADE has an account of its own.
        let is_yade = !matches!(
            self,
            Contender::Lammps | Contender::Liggghts | Contender::LammpsFriction
        );
        let steps = TimedSteps {
            warm_up: plan.warm_up,
            timed: plan.other,
            shares: if is_yade { plan.shares } else { 0 },
            processes: 1,
        };
        let (timed, version) = timed(self, bed, steps, setup.yade, &folder)?;
        Ok(Turn {
            peak_memory: timed.peak_memory,
            shares: timed.shares,
            ..Turn::new(timed.window, version, Some(&timed.last))
        })
    }

    /// Holds its bed against the native one after the same steps.
    pub fn check(self, turn: &Turn, setup: &Setup<'_>, native: &Snapshot) -> Result<Sanity, Error> {
        let (known, bed) = (self.known(), setup.bed_of(self));
        let own;
        let (bodies, contacts) = match &turn.bed {
            Some((bodies, contacts)) => (bodies, *contacts),
            None => {
                own = timing::after(bed, native.step)?;
                (&own.bodies, between_grains(&own))
            }
        };
        let mean_radius = 0.5 * bed.scene.particles.mean_diameter;
        let tolerance = match setup.approximations_of(self).is_empty() {
            true => known.tolerance,
            false => Tolerance::OTHER_LAW,
        };
        Ok(Sanity::of(bodies, contacts, native, mean_radius, tolerance))
    }
}

/// Has a program that is no part of this one time steps of the bed by its own clock, under another program if any is named;
/// and its version. `work` is an empty folder.
pub fn timed(
    contender: Contender,
    bed: &Bed,
    steps: TimedSteps,
    options: &yade::Options,
    work: &Path,
) -> Result<(Timed, String), Error> {
    let model = Model::of(&bed.scene);
    let options = yade::Options {
        sorted: contender.sorted(),
        ..options.clone()
    };
    let adapter = match contender {
        Contender::Lammps | Contender::LammpsFriction => Adapter::LAMMPS,
        Contender::Liggghts => Adapter::LIGGGHTS,
        _ => return Ok(yade::time(&model, &bed.bodies, steps, &options, work)?),
    };
    let engine = adapter.place(work, &options.limits)?;
    let job = timing::folder(work, "job")?;
    let timed = exec::time(&model, &bed.bodies, steps, &engine, &options.under, &job)?;
    Ok((timed, engine.description.version))
}

/// The two runs differ by at least so much, s: processor time is told in hundredths of a second.
const LONG_ENOUGH: f64 = 1.0;
/// N grows by this factor at most, and so many times at most: an engine that needs more computes nothing.
const MOST_LONGER: f64 = 16.0;
const MOST_ROUNDS: u32 = 8;

/// Times steps of this bed: runs of N and of 2N steps from it, N made longer until they differ by a second.
/// Start, reading and tables are the same in both, and so not in their difference. The bed is that of the first run.
fn by_two_runs(
    bed: &Bed,
    plan: &Plan,
    engine: &ExternalEngine,
    work: &Path,
) -> Result<Turn, Error> {
    let mut steps = plan.compared_after();
    let first = run(bed, steps, engine, work)?;
    let mut before = first.took;
    for _ in 0..MOST_ROUNDS {
        let after = run(bed, 2 * steps, engine, work)?.took;
        let cpu_seconds = after
            .processor_seconds
            .zip(before.processor_seconds)
            .map(|(after, before)| after - before);
        let window = Window {
            steps,
            wall_seconds: after.wall_seconds - before.wall_seconds,
            cpu_seconds,
        };
        let seconds = cpu_seconds.unwrap_or(window.wall_seconds);
        if seconds >= LONG_ENOUGH {
            let version = first.description.version;
            return Ok(Turn::new(window, version, Some(&first.outcome.last)));
        }
        // A little more than it should take.
        let longer = 1.2 * LONG_ENOUGH / seconds.max(f64::MIN_POSITIVE);
        steps *= longer.ceil().clamp(2.0, MOST_LONGER) as u64;
        before = run(bed, steps, engine, work)?.took;
    }
    Err(nonsense(format!(
        "{steps} steps take no longer than half of them"
    )))
}

fn run(bed: &Bed, steps: u64, engine: &ExternalEngine, work: &Path) -> Result<ExecRun, Error> {
    // Its first moment and its last.
    let (scene, task) = (unobserved(&bed.scene), bed.task(steps));
    let folder = timing::folder(work, "job")?;
    Ok(run_external(&scene, &task, engine, &folder, &mut ())?)
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Tolerance {
    /// Of the largest displacement over the mean radius.
    pub displacement: f64,
    /// Of the number of contacts between grains, relative.
    pub contacts: f64,
    /// Kinetic energy over the other, at most, either way.
    pub energy: f64,
}

impl Tolerance {
    /// The same operations up to their order: rounding, which was seen to be 1e-11 R after 200 steps and 2e-4 R after
    /// 500, so beds are compared after 300 at most.
    pub const ROUNDING: Tolerance = Tolerance {
        displacement: 1.0e-6,
        contacts: 1.0e-3,
        energy: 1.001,
    };
    /// Other operations: a force is then rounded by a distance's last digit over the overlap, some 10⁴ times more than a sum
    /// in another order is, and so much further apart are grains after the same steps.
    pub const OTHER_OPERATIONS: Tolerance = Tolerance {
        displacement: 1.0e-2,
        ..Tolerance::ROUNDING
    };
    /// One stiffness for all contacts and a drag in place of Cundall's damping: the same method with other choices.
    pub const OTHER_LAW: Tolerance = Tolerance {
        displacement: 0.2,
        contacts: 0.15,
        energy: 10.0,
    };
}

/// An engine's bed against the native one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sanity {
    /// Steps after which both were looked at.
    pub steps: u64,
    /// Largest distance between a grain here and there, over the mean radius.
    pub displacement: f64,
    pub contacts: usize,
    pub contacts_in_native: usize,
    pub energy: f64,
    pub energy_in_native: f64,
    pub tolerance: Tolerance,
    pub holds: bool,
}

impl Sanity {
    /// Holds a bed, with its number of contacts between grains, against the native one.
    pub fn of(
        bodies: &Bodies,
        contacts: usize,
        native: &Snapshot,
        mean_radius: f64,
        tolerance: Tolerance,
    ) -> Self {
        let there = &native.bodies;
        let contacts_in_native = between_grains(native);
        let displacement = if bodies.len() == there.len() {
            largest_distance(bodies, there) / mean_radius
        } else {
            f64::INFINITY
        };
        let (energy, energy_in_native) = (bodies.kinetic_energy(), there.kinetic_energy());
        let lost = (contacts as f64 / contacts_in_native as f64 - 1.0).abs();
        let ratio = (energy / energy_in_native).max(energy_in_native / energy);
        Sanity {
            steps: native.step,
            displacement,
            contacts,
            contacts_in_native,
            energy,
            energy_in_native,
            tolerance,
            // Comparisons that a NaN fails.
            holds: displacement <= tolerance.displacement
                && lost <= tolerance.contacts
                && ratio <= tolerance.energy,
        }
    }
}

pub fn between_grains(snapshot: &Snapshot) -> usize {
    let grains = snapshot.bodies.len() as u32;
    let contacts = snapshot.contacts.iter();
    contacts.filter(|contact| contact.id1 < grains).count()
}

fn largest_distance(a: &Bodies, b: &Bodies) -> f64 {
    let mut largest = 0.0f64;
    for id in 0..a.len() {
        let distance = (a.x[id] - b.x[id]).hypot(a.z[id] - b.z[id]);
        // A NaN would be passed over by a maximum.
        if distance.is_nan() {
            return f64::INFINITY;
        }
        largest = distance.max(largest);
    }
    largest
}

/// An engine over all rounds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Contest {
    pub contender: Contender,
    pub name: String,
    pub version: String,
    pub steps: u64,
    /// Seconds a step, round by round; of processor time, or on the clock where the engine tells no other.
    pub seconds_per_step: Spread,
    /// Processor time over time on the clock, the least of the rounds, where both are known; well below 1 on a busy machine.
    pub processor_share: Option<f64>,
    pub over_native: Option<Spread>,
    /// Largest resident memory of its process, bytes, where it has one of its own.
    pub peak_memory: Option<u64>,
    /// Its own account of where the time goes, where it gives one.
    pub shares: Vec<Share>,
    /// Where it says that it does something else than the model says.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub approximations: Vec<String>,
    /// Whether its bed is still the bed.
    pub sanity: Sanity,
}

#[derive(Debug)]
pub struct Rounds {
    /// The engines that ran in every round.
    pub contests: Vec<Contest>,
    /// Native against YADE's sorted loop after the same steps: every position and velocity.
    pub sorted_bits: Option<TableBits>,
    /// The same with friction: spins too.
    pub friction_bits: Option<TableBits>,
    pub missed: Vec<Missed>,
}

/// Lets every engine take its turn in every round; every second round goes backwards.
pub fn rounds(setup: &Setup<'_>, progress: &progress::Task) -> Result<Rounds, Error> {
    let rounds = setup.plan.rounds;
    let mut turns: Vec<(Contender, Vec<Turn>)> = ALL.map(|of| (of, Vec::new())).into();
    turns.extend(setup.external.map(|_| (Contender::External, Vec::new())));
    let mut missed: Vec<Missed> = Vec::new();
    for round in 0..rounds {
        let mut order: Vec<usize> = (0..turns.len()).collect();
        if round % 2 == 1 {
            order.reverse();
        }
        let turns_a_round = order.len();
        for (turn, index) in order.into_iter().enumerate() {
            let (contender, of) = &mut turns[index];
            let (known, name) = (contender.known(), setup.name_of(*contender));
            let of_round = turn as f64 / turns_a_round as f64;
            progress.share(
                (f64::from(round) + of_round) / f64::from(rounds),
                &format!("round {}, {name}", round + 1),
            );
            match contender.run(setup) {
                Ok(turn) => of.push(turn),
                Err(error) => missed.push(Missed::of(known.id, &name, known.needed, error)?),
            }
        }
        // What has failed once does not run again.
        turns.retain(|(contender, _)| missed.iter().all(|of| of.id != contender.known().id));
    }
    let after = setup.plan.compared_after();
    let native_bed = timing::after(setup.bed, after)?;
    let friction_bed = timing::after(setup.with_friction, after)?;
    let of = |wanted: Contender| {
        let found = turns.iter().find(|(contender, _)| *contender == wanted);
        found.map(|(_, turns)| turns.as_slice())
    };
    let bases = [Contender::Native, Contender::NativeFriction];
    let [native, friction] = bases.map(|base| of(base).and_then(spread));
    let mut contests = Vec::new();
    for (contender, of) in &turns {
        let (Some(seconds_per_step), Some(last)) = (spread(of), of.last()) else {
            continue;
        };
        let (native, native_bed) = match contender.friction() {
            true => (&friction, &friction_bed),
            false => (&native, &native_bed),
        };
        let over_native = native.as_ref();
        let over_native = over_native.and_then(|native| Spread::ratio(&seconds_per_step, native));
        let shares = of.iter().filter_map(|turn| turn.window.processor_share());
        contests.push(Contest {
            contender: *contender,
            name: setup.name_of(*contender),
            version: last.version.clone(),
            steps: last.window.steps,
            processor_share: shares.min_by(f64::total_cmp),
            over_native,
            peak_memory: last.peak_memory,
            shares: last.shares.clone(),
            approximations: setup.approximations_of(*contender),
            sanity: contender.check(last, setup, native_bed)?,
            seconds_per_step,
        });
    }
    let bits_of = |sorted, name, native: &Snapshot| {
        let (bodies, _) = of(sorted)?.last()?.bed.as_ref()?;
        Some(bits::bodies(name, &native.bodies, bodies))
    };
    Ok(Rounds {
        sorted_bits: bits_of(
            Contender::YadeSorted,
            "positions and velocities",
            &native_bed,
        ),
        friction_bits: bits_of(
            Contender::YadeSortedFriction,
            "positions, velocities and spins",
            &friction_bed,
        ),
        contests,
        missed,
    })
}

fn spread(turns: &[Turn]) -> Option<Spread> {
    let windows = turns.iter().map(|turn| turn.window);
    Spread::of(windows.map(|of| of.seconds_per_step()).collect())
}
