//! How coarsely an engine computes, by its answers to small changes of its start.

use grains::native::Noise;
use grains::tables::Bodies;
use grains::task::Case;
use grains::variant;
use serde::Serialize;

use crate::Answer;
use crate::constants::{FLYING, KINDS, situations, until};

/// The smallest change, over a metre or over a velocity: about the last bit of a number in double precision.
const SMALLEST: f64 = 1.0 / (1u64 << 52) as f64;
/// Each change is so many times the one before.
const RATIO: f64 = 8.0;
/// So many changes; the largest is 2·10⁻⁶.
const CHANGES: i32 = 12;
/// A change is noticed if so many of the grains answer that answer to the largest one.
const ANSWERING: f64 = 0.95;

/// The smallest changes that the engine notices.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Resolution {
    /// Of a position, by the position one step later, m.
    pub position: f64,
    /// Of a velocity, by the velocity one step later, relative.
    pub velocity: f64,
    /// Of a position, by the velocities of grains in contact one step later, so by the forces, m.
    pub overlap: f64,
}

impl Resolution {
    /// Of numbers in double precision.
    pub const DOUBLE: Resolution = Resolution {
        position: SMALLEST,
        velocity: SMALLEST,
        overlap: SMALLEST,
    };

    /// The same as noise for replicas: numbers are off by half of what makes a difference.
    pub fn noise(&self) -> Noise {
        Noise {
            position: 0.5 * self.position,
            velocity: 0.5 * self.velocity,
            overlap: 0.5 * self.overlap,
            replica: 0,
        }
    }

    /// Whether all numbers are those of double precision, as far as it can be told.
    pub fn is_double(&self) -> bool {
        let coarsest = self.position.max(self.velocity).max(self.overlap);
        coarsest <= SMALLEST * RATIO * RATIO
    }

    pub fn name(&self) -> &'static str {
        match self.is_double() {
            true => "double precision",
            false => "single precision",
        }
    }

    /// The coarser of two, number by number.
    pub fn coarser(self, other: Resolution) -> Resolution {
        Resolution {
            position: self.position.max(other.position),
            velocity: self.velocity.max(other.velocity),
            overlap: self.overlap.max(other.overlap),
        }
    }
}

/// The case as it is, then with ever larger changes, each looked at after one step. Of a grain in contact the place is
/// changed, of one in flight the velocity too: nothing but its own velocity can answer there.
pub fn cases(case: &Case) -> Vec<Case> {
    let situations = at_start(case);
    let changed = |change: f64| {
        let mut of = Case {
            moments: vec![1],
            ..case.clone()
        };
        let bodies = &mut of.bodies;
        for (id, situation) in situations.iter().enumerate() {
            // Each by another length, so that neighbours do not move together.
            let length = change * (1.0 + (id as f64 * 0.618).fract());
            bodies.x[id] += length;
            bodies.z[id] -= length;
            if *situation == FLYING {
                bodies.vx[id] *= 1.0 + change;
                bodies.vz[id] *= 1.0 + change;
            }
        }
        of
    };
    let mut all = vec![changed(0.0)];
    all.extend((0..CHANGES).map(|power| changed(SMALLEST * RATIO.powi(power))));
    all
}

/// The kind of place that each grain is in at the start.
fn at_start(case: &Case) -> Vec<usize> {
    situations(case, &variant::run(&until(case, 0), &Default::default()))
}

/// From the answers to [`cases`]; none if the engine refused one of them.
pub fn measured(case: &Case, answers: &[Answer]) -> Option<Resolution> {
    let last = answers.iter().map(|of| of.as_deref().ok()?.last());
    let last = last.map(|of| of.map(|of| &of.bodies));
    let last: Option<Vec<&Bodies>> = last.collect();
    let (base, changed) = last.as_deref()?.split_first()?;
    let situations = at_start(case);
    // The smallest change that enough of these grains notice.
    let noticed = |answers: &dyn Fn(&Bodies, usize) -> bool, among: &dyn Fn(usize) -> bool| {
        let at_all = |id: &usize| among(*id) && changed.last().is_some_and(|of| answers(of, *id));
        let ids: Vec<usize> = (0..situations.len()).filter(at_all).collect();
        let mut level = SMALLEST;
        for of in changed {
            let share = ids.iter().filter(|id| answers(of, **id)).count() as f64;
            if share >= ANSWERING * ids.len() as f64 {
                break;
            }
            level *= RATIO;
        }
        level
    };
    let moved = |of: &Bodies, id: usize| of.x[id] != base.x[id] && of.z[id] != base.z[id];
    let sped = |of: &Bodies, id: usize| of.vx[id] != base.vx[id] || of.vz[id] != base.vz[id];
    Some(Resolution {
        position: noticed(&moved, &|_| true),
        velocity: noticed(&sped, &|id| situations[id] == FLYING),
        // A force on a grain at a wall or the punch may be coarser than one between grains.
        overlap: (FLYING + 1..KINDS)
            .map(|kind| noticed(&sped, &|id| situations[id] == kind))
            .fold(0.0, f64::max),
    })
}
