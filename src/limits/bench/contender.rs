//! The engines that are timed side by side, behind one word: in rounds, so that whatever slows the machine down slows all of
//! them, and each with a look at its bed, because an engine that drops grains or contacts is fast and its time means nothing.

use std::path::Path;

use clap::ValueEnum;
use serde::Serialize;

use super::bed::Bed;
use super::timing::{self, Spread};
use super::{Missed, Plan, Result, Setup, nonsense};
use crate::compare::bits::{self, TableBits};
use crate::engine::exec::{Adapter, Description, ExternalEngine};
use crate::engine::limits::Done;
use crate::engine::read::{Timed, TimedSteps};
use crate::engine::{Engine, yade};
use crate::progress;
use crate::study::realization::unobserved;
use grains::model::Model;
use grains::native::timing::{Share, Window};
use grains::tables::{Bodies, Snapshot};

/// An engine in one of its ways of working, in the order in which they stand in tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Contender {
    Native,
    YadeOrdinary,
    /// YADE `-j1`, interactions in the order of their ids.
    YadeSorted,
    Lammps,
    Liggghts,
    NativeFriction,
    YadeOrdinaryFriction,
    YadeSortedFriction,
    LammpsFriction,
    NativeSpace,
    YadeOrdinarySpace,
    YadeSortedSpace,
    LammpsSpace,
    /// A program that speaks the engine protocol, where one is named; all others always take part.
    External,
}

/// The bed that is timed.
#[derive(Clone, Copy, PartialEq)]
enum On {
    Plain,
    Friction,
    /// Spheres in space, with friction.
    Space,
}

/// What computes it.
#[derive(Clone, Copy, PartialEq)]
enum Program {
    /// A part of this program, so timed longer and without a process of its own.
    Native,
    Yade {
        sorted: bool,
    },
    Adapter(Adapter),
    External,
}

impl<'a> Setup<'a> {
    /// In the order of [`On`].
    fn beds(&self) -> [&'a Bed; 3] {
        [self.bed, self.with_friction, self.in_space]
    }
    fn described(&self, contender: Contender) -> Option<&Description> {
        let external = self.engines.external.as_ref();
        let external = external.filter(|_| contender == Contender::External);
        external.map(|engine| &engine.description)
    }

    /// For tables. An external engine may have the name of one that takes part anyway.
    pub fn name_of(&self, contender: Contender) -> String {
        let (_, on, _, name) = contender.parts();
        let where_from = ["", ", friction", ", spheres"][on as usize];
        match self.described(contender) {
            Some(external) => format!("exec:{}", external.name),
            None => format!("{name}{where_from}"),
        }
    }

    /// Where it says that it does something else than the model says.
    fn approximations_of(&self, contender: Contender) -> Vec<String> {
        let described = self.described(contender);
        described.map_or(Vec::new(), |external| external.approximations.clone())
    }
}

impl Contender {
    /// What computes it, whether the bed has friction, its id and its name without that.
    fn parts(self) -> (Program, On, &'static str, &'static str) {
        use Contender::*;
        use On::{Friction, Plain, Space};
        use Program::Yade;
        let [ordinary, sorted] = [false, true].map(|sorted| Yade { sorted });
        let [lammps, liggghts] = [Adapter::LAMMPS, Adapter::LIGGGHTS].map(Program::Adapter);
        let [loop_as_is, in_order] = ["YADE -j1, ordinary loop", "YADE -j1, sorted loop"];
        match self {
            Native => (Program::Native, Plain, "native", "native"),
            NativeFriction => (Program::Native, Friction, "native-friction", "native"),
            YadeOrdinary => (ordinary, Plain, "ordinary-loop", loop_as_is),
            YadeOrdinaryFriction => (ordinary, Friction, "ordinary-loop-friction", loop_as_is),
            YadeSorted => (sorted, Plain, "sorted-loop", in_order),
            YadeSortedFriction => (sorted, Friction, "sorted-loop-friction", in_order),
            Lammps => (lammps, Plain, "gran-hooke", "LAMMPS gran/hooke"),
            LammpsFriction => {
                let name = "LAMMPS gran/hooke/history";
                (lammps, Friction, "gran-hooke-history", name)
            }
            NativeSpace => (Program::Native, Space, "native-space", "native"),
            YadeOrdinarySpace => (ordinary, Space, "ordinary-loop-space", loop_as_is),
            YadeSortedSpace => (sorted, Space, "sorted-loop-space", in_order),
            LammpsSpace => {
                let name = "LAMMPS gran/hertz/history";
                (lammps, Space, "gran-hertz-history", name)
            }
            Liggghts => {
                let name = "LIGGGHTS hooke/stiffness";
                (liggghts, Plain, "hooke-stiffness", name)
            }
            External => (Program::External, Plain, "external", "exec"),
        }
    }

    fn program(self) -> Program {
        self.parts().0
    }

    pub fn friction(self) -> bool {
        self.parts().1 == On::Friction
    }

    /// Whether it computes spheres in space.
    pub fn in_space(self) -> bool {
        self.parts().1 == On::Space
    }

    /// In ids of checks, unique.
    pub fn id(self) -> &'static str {
        self.parts().2
    }

    pub fn is_native(self) -> bool {
        self.program() == Program::Native
    }

    /// Whether a benchmark without it is incomplete.
    pub fn needed(self) -> bool {
        !matches!(self.program(), Program::Adapter(_))
    }

    /// Times its window on the bed, with the bed after [`Plan::compared_after`] steps; and its version.
    pub fn run(self, setup: &Setup<'_>) -> Result<(Timed, String)> {
        let bed = setup.beds()[self.parts().1 as usize];
        let plan = &setup.plan;
        let folder = timing::folder(setup.work, "turn")?;
        match self.program() {
            Program::Native => {
                // In space a step takes as long as thirty in the plane.
                let steps = if self.in_space() {
                    4 * plan.other
                } else {
                    plan.native
                };
                let window = timing::time(bed, steps, 1)?;
                let last = timing::after(bed, plan.compared_after())?;
                let version = env!("CARGO_PKG_VERSION").to_owned();
                Ok((Timed::plain(window, last), version))
            }
            Program::External => by_two_runs(bed, plan, setup.engines.external()?, &folder),
            program => {
                // Only YADE has an account of its own.
                let is_yade = matches!(program, Program::Yade { .. });
                let steps = TimedSteps {
                    warm_up: plan.warm_up,
                    timed: plan.other,
                    shares: if is_yade { plan.shares } else { 0 },
                    processes: 1,
                };
                timed(self, bed, steps, &setup.engines.yade, &folder)
            }
        }
    }

    /// Holds its bed against the native one after the same steps.
    pub fn check(self, last: &Snapshot, setup: &Setup<'_>, native: &Snapshot) -> StateCheck {
        let tolerance = match self.program() {
            _ if !setup.approximations_of(self).is_empty() => Tolerance::OTHER_LAW,
            Program::Native | Program::Yade { .. } => Tolerance::ROUNDING,
            Program::Adapter(_) => Tolerance::OTHER_LAW,
            Program::External => Tolerance::OTHER_OPERATIONS,
        };
        let mean_radius = 0.5 * setup.bed.scene.particles.mean_diameter;
        let contacts = between_grains(last);
        StateCheck::of(&last.bodies, contacts, native, mean_radius, tolerance)
    }
}

/// Has a program that is no part of this one time steps of the bed by its own clock; and its version. `work` is an empty folder.
pub fn timed(
    contender: Contender,
    bed: &Bed,
    steps: TimedSteps,
    options: &yade::Options,
    work: &Path,
) -> Result<(Timed, String)> {
    let model = Model::of(&bed.scene);
    let Program::Adapter(adapter) = contender.program() else {
        let mut options = options.clone();
        options.sorted = contender.program() == Program::Yade { sorted: true };
        return Ok(options.time(&model, &bed.bodies, steps, work)?);
    };
    let engine = adapter.place(work, &options.limits)?;
    let job = timing::folder(work, "job")?;
    Ok(engine.time(&model, &bed.bodies, steps, &job)?)
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
) -> Result<(Timed, String)> {
    let mut steps = plan.compared_after();
    let (mut before, last) = run(bed, steps, engine, work)?;
    for _ in 0..MOST_ROUNDS {
        let after = run(bed, 2 * steps, engine, work)?.0;
        let both = after.processor_seconds.zip(before.processor_seconds);
        let cpu_seconds = both.map(|(after, before)| after - before);
        let window = Window {
            steps,
            wall_seconds: after.wall_seconds - before.wall_seconds,
            cpu_seconds,
        };
        let seconds = cpu_seconds.unwrap_or(window.wall_seconds);
        if seconds >= LONG_ENOUGH {
            let timed = Timed::plain(window, last);
            return Ok((timed, engine.description.version.clone()));
        }
        // A little more than it should take.
        let longer = 1.2 * LONG_ENOUGH / seconds.max(f64::MIN_POSITIVE);
        steps *= longer.ceil().clamp(2.0, MOST_LONGER) as u64;
        before = run(bed, steps, engine, work)?.0;
    }
    Err(nonsense(format!(
        "{steps} steps take no longer than half of them"
    )))
}

fn run(bed: &Bed, steps: u64, engine: &dyn Engine, work: &Path) -> Result<(Done, Snapshot)> {
    // Its first moment and its last.
    let (scene, task) = (unobserved(&bed.scene), bed.task(steps));
    let folder = timing::folder(work, "job")?;
    let run = engine.run(&scene, &task, &folder, &mut ())?;
    let took = run
        .took
        .ok_or_else(|| nonsense("it has no process of its own"))?;
    Ok((took, run.outcome.last))
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
pub struct StateCheck {
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

impl StateCheck {
    /// Holds a bed, with its number of contacts between grains, against the native one.
    pub fn of(
        bodies: &Bodies,
        contacts: usize,
        native: &Snapshot,
        mean_radius: f64,
        tolerance: Tolerance,
    ) -> Self {
        let there = &native.bodies;
        let displacement = if bodies.len() == there.len() {
            largest_distance(bodies, there) / mean_radius
        } else {
            f64::INFINITY
        };
        let mut check = StateCheck {
            steps: native.step,
            displacement,
            contacts,
            contacts_in_native: between_grains(native),
            energy: bodies.kinetic_energy(),
            energy_in_native: there.kinetic_energy(),
            tolerance,
            holds: false,
        };
        // Comparisons that a NaN fails.
        let holds = |(value, [_, low, high]): &(f64, [f64; 3])| low <= value && value <= high;
        check.holds = check.limits().iter().all(holds);
        check
    }

    /// Displacement, contacts and kinetic energy: each value with what is expected, the least and the most.
    pub fn limits(&self) -> [(f64, [f64; 3]); 3] {
        let (contacts, energy) = (self.contacts_in_native as f64, self.energy_in_native);
        let (share, factor) = (self.tolerance.contacts, self.tolerance.energy);
        let around = [contacts, contacts * (1.0 - share), contacts * (1.0 + share)];
        [
            (self.displacement, [0.0, 0.0, self.tolerance.displacement]),
            (self.contacts as f64, around),
            (self.energy, [energy, energy / factor, energy * factor]),
        ]
    }
}

pub fn between_grains(snapshot: &Snapshot) -> usize {
    let grains = snapshot.bodies.len() as u32;
    let contacts = snapshot.contacts.iter();
    contacts.filter(|contact| contact.id1 < grains).count()
}

fn largest_distance(a: &Bodies, b: &Bodies) -> f64 {
    let across = |id: usize| a.y.get(id).zip(b.y.get(id)).map_or(0.0, |(a, b)| a - b);
    let distance = |id: usize| {
        let in_plane = (a.x[id] - b.x[id]).hypot(a.z[id] - b.z[id]);
        in_plane.hypot(across(id))
    };
    let distances = (0..a.len()).map(distance);
    // A NaN would be passed over by a maximum.
    let known = distances.map(|length| {
        if length.is_nan() {
            f64::INFINITY
        } else {
            length
        }
    });
    known.fold(0.0, f64::max)
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
    pub state_check: StateCheck,
}

/// What an engine has shown so far.
struct Entrant {
    contender: Contender,
    windows: Vec<Window>,
    /// Its last turn, and its version.
    last: Option<(Timed, String)>,
}

impl Entrant {
    fn spread(&self) -> Option<Spread> {
        Spread::of(self.windows.iter().map(Window::seconds_per_step).collect())
    }
}

/// Native against YADE's sorted loop after the same steps: every position and velocity; with friction and in space every spin too.
pub type SortedBits = [Option<TableBits>; 3];

/// Lets every engine take its turn in every round; every second round goes backwards. The engines that ran in every
/// round.
pub fn rounds(
    setup: &Setup<'_>,
    progress: &progress::Task,
    missed: &mut Vec<Missed>,
) -> Result<(Vec<Contest>, SortedBits)> {
    let all = Contender::value_variants().iter().copied();
    let named = setup.engines.external.is_some();
    let all = all.filter(|contender| named || *contender != Contender::External);
    let entrants = all.map(|contender| Entrant {
        contender,
        windows: Vec::new(),
        last: None,
    });
    let mut entrants: Vec<Entrant> = entrants.collect();
    for round in 0..setup.plan.rounds {
        let turns = entrants.len() as f64;
        for (turn, entrant) in entrants.iter_mut().enumerate() {
            let (contender, name) = (entrant.contender, setup.name_of(entrant.contender));
            let share = (f64::from(round) + turn as f64 / turns) / f64::from(setup.plan.rounds);
            progress.share(share, &format!("round {}, {name}", round + 1));
            match contender.run(setup) {
                Ok(turn) => {
                    entrant.windows.push(turn.0.window);
                    entrant.last = Some(turn);
                }
                Err(error) => {
                    let needed = contender.needed();
                    missed.push(Missed::of(contender.id(), &name, needed, error)?);
                }
            }
        }
        // What has failed once does not run again.
        entrants.retain(|entrant| {
            missed
                .iter()
                .all(|missing| missing.id != entrant.contender.id())
        });
        entrants.reverse();
    }
    if setup.plan.rounds % 2 == 1 {
        entrants.reverse();
    }
    let after = |bed: &Bed| timing::after(bed, setup.plan.compared_after());
    let [bed, with_friction, in_space] = setup.beds().map(after);
    let beds = [bed?, with_friction?, in_space?];
    let find = |wanted: Contender| entrants.iter().find(|entrant| entrant.contender == wanted);
    let ways = [
        Contender::Native,
        Contender::NativeFriction,
        Contender::NativeSpace,
    ];
    let native = ways.map(|way| find(way)?.spread());
    let bits_of = |sorted, name, native: &Snapshot| {
        let (timed, _) = find(sorted)?.last.as_ref()?;
        Some(bits::bodies(name, &native.bodies, &timed.last.bodies))
    };
    let [plain, friction] = [
        "positions and velocities",
        "positions, velocities and spins",
    ];
    let bits = [
        bits_of(Contender::YadeSorted, plain, &beds[0]),
        bits_of(Contender::YadeSortedFriction, friction, &beds[1]),
        bits_of(Contender::YadeSortedSpace, friction, &beds[2]),
    ];
    let contest = |entrant: Entrant| {
        let (contender, seconds_per_step) = (entrant.contender, entrant.spread()?);
        let (last, version) = entrant.last?;
        let way = contender.parts().1 as usize;
        let native = native[way].as_ref();
        let shares = entrant.windows.iter().filter_map(Window::processor_share);
        Some(Contest {
            contender,
            name: setup.name_of(contender),
            version,
            steps: last.window.steps,
            processor_share: shares.min_by(f64::total_cmp),
            over_native: native.and_then(|native| Spread::ratio(&seconds_per_step, native)),
            peak_memory: last.peak_memory,
            approximations: setup.approximations_of(contender),
            state_check: contender.check(&last.last, setup, &beds[way]),
            shares: last.shares,
            seconds_per_step,
        })
    };
    Ok((entrants.into_iter().filter_map(contest).collect(), bits))
}
