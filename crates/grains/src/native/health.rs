//! Signs that a run has gone wrong. Looked for whenever the neighbour list is rebuilt, which no
//! grain can avoid by moving, every thousand steps and at the end of a stage.

use super::state::{Constants, State};
use crate::scene::Container;
use crate::tables::Snapshot;

/// What went wrong, with the grain.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Trouble {
    #[error("grain {grain} has a position, velocity or force that is not a finite number")]
    NotFinite { grain: u32 },
    #[error(
        "grain {grain} has left the box: its centre is at x={x} m, z={z} m; a grain that moves more than its \
         radius in a step can pass a wall: take a smaller /time_step or a lower /cloud/speed"
    )]
    Lost { grain: u32, x: f64, z: f64 },
    #[error(
        "grain {grain} has left the box: its centre is at y={y} m; a grain that moves more than its radius in a step can pass \
         a wall: take a smaller /time_step or a lower /cloud/speed"
    )]
    LostAcross { grain: u32, y: f64 },
    #[error(
        "the bed did not come to rest within {steps} steps, so nothing can be said of it at rest; with this load it may \
         not be able to"
    )]
    DoesNotRest { steps: u64 },
    #[error("the punch did not get its force, so there is no bed under load")]
    DoesNotBear,
    #[error(
        "no step was found at which the scene can be probed: even {dt} s is not below its limit; give /time_step instead"
    )]
    NoProbe { dt: f64 },
    #[error("it was asked to end; start it again")]
    Interrupted,
    #[error(
        "the kinetic energy has grown to {energy} J, more than the {limit} J that this \
         scene can give; grain {grain} is the fastest. The step is probably too large: try --auto-step"
    )]
    EnergyBlownUp { grain: u32, energy: f64, limit: f64 },
    #[error(
        "bodies {id1} and {id2} overlap by {overlap} m, beyond the radius {radius} m: grains pass through each other, and \
         no linear spring means that; raise /material/youngs_modulus, lower what presses on them, or take a smaller step \
         (--auto-step)"
    )]
    BeyondRadius {
        id1: u32,
        id2: u32,
        overlap: f64,
        radius: f64,
    },
}

/// Every grain finite and inside the box; else the one with the lowest number.
pub fn check(state: &State, constants: &Constants) -> Result<(), Trouble> {
    let trouble = |at: usize| {
        let (position, velocity, force) = (state.position[at], state.velocity[at], state.force[at]);
        let grain = state.number[at];
        let [x, z] = position;
        let spin = state.spin.get(at).is_none_or(|spin| spin.is_finite());
        let pairs = [position, velocity, force];
        if !spin || !pairs.as_flattened().iter().all(|value| value.is_finite()) {
            return Some((grain, Trouble::NotFinite { grain }));
        }
        let outside = |width| x <= 0.0 || x >= width || z <= 0.0;
        let lost = constants.box_width.is_some_and(outside);
        lost.then_some((grain, Trouble::Lost { grain, x, z }))
    };
    let troubles = (0..state.position.len()).filter_map(trouble);
    let first = troubles.min_by_key(|(grain, _)| *grain);
    first.map_or(Ok(()), |(_, trouble)| Err(trouble))
}

/// A moment of any engine: every grain in this box, and no overlap beyond the smaller radius of a pair.
pub fn check_moment(moment: &Snapshot, container: &Container) -> Result<(), Trouble> {
    let bodies = &moment.bodies;
    for (id, y) in bodies.y.iter().enumerate() {
        let grain = id as u32;
        let depth = container.depth.unwrap_or(f64::INFINITY);
        if !(*y > 0.0 && *y < depth) {
            return Err(Trouble::LostAcross { grain, y: *y });
        }
    }
    for (id, (&x, &z)) in bodies.x.iter().zip(&bodies.z).enumerate() {
        let grain = id as u32;
        if !(x.is_finite() && z.is_finite()) {
            return Err(Trouble::NotFinite { grain });
        }
        if x <= 0.0 || x >= container.width || z <= 0.0 {
            return Err(Trouble::Lost { grain, x, z });
        }
    }
    for contact in &moment.contacts {
        let radius = |id: u32| bodies.radius.get(id as usize).copied();
        let one = radius(contact.id1).unwrap_or(f64::INFINITY);
        let radius = radius(contact.id2).unwrap_or(f64::INFINITY).min(one);
        if contact.overlap > radius {
            return Err(Trouble::BeyondRadius {
                id1: contact.id1,
                id2: contact.id2,
                overlap: contact.overlap,
                radius,
            });
        }
    }
    Ok(())
}

/// Ten times all the energy that a run can turn into motion, J: what falling to the floor gives and `work`: what it has, what is
/// stored in overlaps and what the punch may do.
pub fn energy_limit(state: &State, constants: &Constants, work: f64) -> f64 {
    let fall: f64 = state
        .by_number(&state.mass)
        .zip(state.by_number(&state.position))
        .map(|(mass, position)| mass * -constants.gravity[1] * position[1])
        .sum();
    10.0 * (fall + work)
}

/// The kinetic energy is below its limit.
pub fn check_energy(state: &State, energy: f64, limit: f64) -> Result<(), Trouble> {
    if energy <= limit {
        return Ok(());
    }
    let speed = |v: &[f64; 2]| v[0] * v[0] + v[1] * v[1];
    let fastest = state
        .by_number(&state.velocity)
        .enumerate()
        .max_by(|(_, a), (_, b)| speed(a).total_cmp(&speed(b)));
    Err(Trouble::EnergyBlownUp {
        grain: fastest.map_or(0, |(id, _)| id as u32),
        energy,
        limit,
    })
}
