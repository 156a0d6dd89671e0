//! The engines that are timed side by side, behind one word.

use std::path::Path;

use serde::Serialize;

use super::bed::Bed;
use super::sanity::{Sanity, Tolerance, between_grains};
use super::{BenchError, brought, native, program};
use crate::engine::exec::{self, Adapter, Brought};
use crate::engine::read::{Timed, TimedSteps};
use crate::engine::yade;
use grains::model::Model;
use grains::native::Mode;
use grains::native::timing::{Share, Window};
use grains::tables::{Bodies, Snapshot};

/// An engine in one of its ways of working.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Contender {
    /// The native engine, YADE's bits.
    Exact,
    /// The native engine, any order.
    Free,
    /// The native engine, contact forces in single precision.
    Single,
    /// YADE `-j1`, its own order.
    YadeOrdinary,
    /// YADE `-j1`, interactions in the order of their ids.
    YadeSorted,
    /// LAMMPS, gran/hooke.
    Lammps,
    /// LIGGGHTS, hooke/stiffness.
    Liggghts,
    /// A program that speaks the engine protocol.
    Brought,
}

/// Those that always take part, in the order in which they stand in tables.
pub const ALL: [Contender; 7] = [
    Contender::Exact,
    Contender::Free,
    Contender::Single,
    Contender::YadeOrdinary,
    Contender::YadeSorted,
    Contender::Lammps,
    Contender::Liggghts,
];

/// The native engine's.
pub const NATIVE: [Contender; 3] = [Contender::Exact, Contender::Free, Contender::Single];

/// Those whose instructions are counted; YADE's sorted loop would take minutes.
pub const COUNTED: [Contender; 6] = [
    Contender::Exact,
    Contender::Free,
    Contender::Single,
    Contender::YadeOrdinary,
    Contender::Lammps,
    Contender::Liggghts,
];

/// Steps of the other engines' windows, and of the check of every bed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plan {
    /// Steps before a window.
    pub warm_up: u64,
    /// Steps of a window of the native engine.
    pub native: u64,
    /// Steps of a window of another engine.
    pub other: u64,
    /// Steps with YADE's own timers on.
    pub shares: u64,
}

impl Plan {
    /// Steps after which beds are compared.
    pub fn compared_after(&self) -> u64 {
        self.warm_up + self.other
    }
}

/// The engines that are programs of their own, as far as they are not looked for on the path.
#[derive(Debug, Clone, Copy)]
pub struct Programs<'a> {
    /// How YADE is started.
    pub yade: &'a yade::Options,
    /// The engine that was brought, if there is one.
    pub brought: Option<&'a Brought>,
}

impl Programs<'_> {
    /// For tables. A program that was brought may have the name of one that takes part anyway.
    pub fn name_of(&self, contender: Contender) -> String {
        match (contender, self.brought) {
            (Contender::Brought, Some(of)) => format!("exec:{}", of.description.name),
            _ => contender.name().to_owned(),
        }
    }

    /// Where it says that it does something else than the model says.
    pub fn approximations_of(&self, contender: Contender) -> Vec<String> {
        match (contender, self.brought) {
            (Contender::Brought, Some(of)) => of.description.approximations.clone(),
            _ => Vec::new(),
        }
    }

    fn tolerance_of(&self, contender: Contender) -> Tolerance {
        if self.approximations_of(contender).is_empty() {
            contender.tolerance()
        } else {
            Tolerance::OTHER_LAW
        }
    }
}

/// What an engine did in a round.
#[derive(Debug)]
pub struct Turn {
    /// The timed steps.
    pub window: Window,
    /// The bed after [`Plan::compared_after`] steps, and its contacts between grains; a native engine is not asked
    /// here, because its window is longer.
    pub bed: Option<(Bodies, usize)>,
    /// Its version.
    pub version: String,
    /// Largest resident memory of its process, where that is known.
    pub peak_memory: Option<u64>,
    /// Its own account of where the time goes.
    pub shares: Vec<Share>,
}

impl Contender {
    /// For tables.
    pub fn name(self) -> &'static str {
        match self {
            Contender::Exact => "native exact",
            Contender::Free => "native free",
            Contender::Single => "native single",
            Contender::YadeOrdinary => "YADE -j1, ordinary loop",
            Contender::YadeSorted => "YADE -j1, sorted loop",
            Contender::Lammps => "LAMMPS gran/hooke",
            Contender::Liggghts => "LIGGGHTS hooke/stiffness",
            Contender::Brought => "exec",
        }
    }

    /// The mode, of a native engine.
    pub fn mode(self) -> Option<Mode> {
        match self {
            Contender::Exact => Some(Mode::Exact),
            Contender::Free => Some(Mode::Free),
            Contender::Single => Some(Mode::Single),
            _ => None,
        }
    }

    /// How many times native exact's time a step of it is to take, where that is a goal.
    pub fn goal(self) -> Option<f64> {
        match self {
            Contender::YadeOrdinary => Some(30.0),
            Contender::Lammps => Some(7.0),
            _ => None,
        }
    }

    fn is_yade(self) -> bool {
        matches!(self, Contender::YadeOrdinary | Contender::YadeSorted)
    }

    /// Whether a benchmark without it lacks something.
    pub fn is_needed(self) -> bool {
        !matches!(self, Contender::Lammps | Contender::Liggghts)
    }

    fn tolerance(self) -> Tolerance {
        match self {
            Contender::Exact | Contender::YadeOrdinary | Contender::YadeSorted => {
                Tolerance::ROUNDING
            }
            Contender::Free | Contender::Brought => Tolerance::FREE,
            Contender::Single => Tolerance::SINGLE,
            Contender::Lammps | Contender::Liggghts => Tolerance::OTHER_LAW,
        }
    }

    /// Times its window on the bed.
    pub fn run(
        self,
        bed: &Bed,
        plan: &Plan,
        programs: Programs<'_>,
        work: &Path,
    ) -> Result<Turn, BenchError> {
        let folder = program::folder(work, "turn")?;
        match self {
            Contender::Exact | Contender::Free | Contender::Single => {
                let mode = self.mode().unwrap_or_default();
                Ok(Turn {
                    window: native::time(bed, mode, plan.native)?,
                    bed: None,
                    version: env!("CARGO_PKG_VERSION").to_owned(),
                    peak_memory: None,
                    shares: Vec::new(),
                })
            }
            Contender::YadeOrdinary
            | Contender::YadeSorted
            | Contender::Lammps
            | Contender::Liggghts => {
                // Only YADE has an account of its own.
                let steps = TimedSteps {
                    warm_up: plan.warm_up,
                    timed: plan.other,
                    shares: if self.is_yade() { plan.shares } else { 0 },
                };
                let (timed, version) = timed(self, bed, steps, programs.yade, &folder)?;
                Ok(Turn::of(timed, version))
            }
            Contender::Brought => {
                let engine = programs.brought.ok_or_else(|| {
                    BenchError::Missing("no engine was brought: --engine exec:PATH".to_owned())
                })?;
                brought::time(bed, plan, engine, &folder)
            }
        }
    }

    /// Holds its bed against the exact one after the same steps.
    pub fn check(
        self,
        turn: &Turn,
        programs: Programs<'_>,
        bed: &Bed,
        exact: &Snapshot,
    ) -> Result<Sanity, BenchError> {
        let mean_radius = 0.5 * bed.scene.particles.mean_diameter;
        let tolerance = programs.tolerance_of(self);
        let of =
            |bodies: &Bodies, contacts| Sanity::of(bodies, contacts, exact, mean_radius, tolerance);
        match (&turn.bed, self.mode()) {
            (Some((bodies, contacts)), _) => Ok(of(bodies, *contacts)),
            (None, mode) => {
                let own = native::after(bed, mode.unwrap_or_default(), exact.step)?;
                Ok(of(&own.bodies, between_grains(&own)))
            }
        }
    }
}

impl Turn {
    /// Of a program that timed its own steps.
    fn of(timed: Timed, version: String) -> Self {
        let contacts = between_grains(&timed.last);
        Turn {
            window: timed.window,
            bed: Some((timed.last.bodies, contacts)),
            version,
            peak_memory: timed.peak_memory,
            shares: timed.shares,
        }
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
) -> Result<(Timed, String), BenchError> {
    let model = Model::of(&bed.scene);
    let options = yade::Options {
        sorted: contender == Contender::YadeSorted,
        ..options.clone()
    };
    let adapter = match contender {
        Contender::Lammps => Adapter::Lammps,
        Contender::Liggghts => Adapter::Liggghts,
        _ => return Ok(yade::time(&model, &bed.bodies, steps, &options, work)?),
    };
    let engine = adapter.place(work, &options.limits)?;
    let job = program::folder(work, "job")?;
    let timed = exec::time(&model, &bed.bodies, steps, &engine, &options.under, &job)?;
    Ok((timed, engine.description.version))
}
