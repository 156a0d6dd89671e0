//! The engines that are timed side by side, behind one word.

use std::path::Path;
use std::time::Duration;

use serde::Serialize;

use super::bed::Bed;
use super::sanity::{Sanity, Tolerance, between_grains};
use super::{BenchError, lammps, liggghts, native, program};
use crate::engine::native::Mode;
use crate::engine::timing::{Share, Window};
use crate::engine::yade::{self, timing::Steps};
use crate::model::Model;
use crate::tables::{Bodies, Snapshot};

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
}

/// In the order in which they stand in tables.
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

    /// Whether a benchmark without it lacks something.
    pub fn is_needed(self) -> bool {
        !matches!(self, Contender::Lammps | Contender::Liggghts)
    }

    fn tolerance(self) -> Tolerance {
        match self {
            Contender::Exact | Contender::YadeOrdinary | Contender::YadeSorted => {
                Tolerance::ROUNDING
            }
            Contender::Free => Tolerance::FREE,
            Contender::Single => Tolerance::SINGLE,
            Contender::Lammps | Contender::Liggghts => Tolerance::OTHER_LAW,
        }
    }

    /// Times its window on the bed.
    pub fn run(
        self,
        bed: &Bed,
        plan: &Plan,
        yade: &yade::Options,
        work: &Path,
    ) -> Result<Turn, BenchError> {
        let folder = program::folder(work, "turn")?;
        let limit = yade.time_limit;
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
            Contender::YadeOrdinary => in_yade(bed, plan, false, yade, &folder),
            Contender::YadeSorted => in_yade(bed, plan, true, yade, &folder),
            Contender::Lammps => foreign(lammps::time, bed, plan, &folder, limit),
            Contender::Liggghts => foreign(liggghts::time, bed, plan, &folder, limit),
        }
    }

    /// Holds its bed against the exact one after the same steps.
    pub fn check(self, turn: &Turn, bed: &Bed, exact: &Snapshot) -> Result<Sanity, BenchError> {
        let mean_radius = 0.5 * bed.scene.particles.mean_diameter;
        let of = |bodies: &Bodies, contacts| {
            Sanity::of(bodies, contacts, exact, mean_radius, self.tolerance())
        };
        match (&turn.bed, self.mode()) {
            (Some((bodies, contacts)), _) => Ok(of(bodies, *contacts)),
            (None, mode) => {
                let own = native::after(bed, mode.unwrap_or_default(), exact.step)?;
                Ok(of(&own.bodies, between_grains(&own)))
            }
        }
    }
}

fn in_yade(
    bed: &Bed,
    plan: &Plan,
    sorted: bool,
    options: &yade::Options,
    work: &Path,
) -> Result<Turn, BenchError> {
    let options = yade::Options {
        sorted,
        ..options.clone()
    };
    let steps = Steps {
        warm_up: plan.warm_up,
        timed: plan.other,
        shares: plan.shares,
    };
    let model = Model::of(&bed.scene);
    let timed = yade::timing::time(&model, &bed.bodies, steps, &options, work)?;
    let grains = timed.bodies.len() as u32;
    let contacts = timed.contacts.iter();
    let contacts = contacts.filter(|of| of.id1 < grains).count();
    Ok(Turn {
        window: timed.window,
        bed: Some((timed.bodies, contacts)),
        version: timed.version,
        peak_memory: Some(timed.peak_memory),
        shares: timed.shares,
    })
}

fn foreign(
    time: fn(&Bed, u64, u64, &Path, Duration) -> Result<lammps::Foreign, BenchError>,
    bed: &Bed,
    plan: &Plan,
    work: &Path,
    limit: Duration,
) -> Result<Turn, BenchError> {
    let timed = time(bed, plan.warm_up, plan.other, work, limit)?;
    Ok(Turn {
        window: timed.window,
        bed: Some((timed.bodies, timed.contacts)),
        version: timed.version,
        peak_memory: None,
        shares: Vec::new(),
    })
}
