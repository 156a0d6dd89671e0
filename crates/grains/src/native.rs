//! The native engine: discs or planar spheres between walls under a rigid punch, in the same operations
//! and the same order as YADE's sorted loop, so with the same bits.
//!
//! A step is: integrate (forces → velocities → positions), move the punch, rebuild the neighbour
//! list if anything moved too far, evaluate the forces at the new positions. The model selects the
//! kernel that evaluates them: the frictionless one computes normal springs and nothing else.

pub mod contact;
mod dynamics;
pub mod fault;
mod general;
mod health;
pub(crate) mod lanes;
mod neighbours;
mod pairs;
pub mod pouring;
pub(crate) mod powers;
mod rounding;
mod springs;
mod stages;
pub(crate) mod state;
mod sweep;
mod threads;
pub mod timing;

pub use fault::{Fault, FaultError};
pub use health::{Trouble, check_moment};
pub use rounding::Noise;
pub use stages::{NativeError, Options, first_contact_punch, run};
pub use threads::Threads;

use std::iter::repeat;

use crate::constant::Given;
use crate::reference::{Linear, Reference};
use crate::tables::{Body, Memories, Snapshot, Stage};
use crate::task::{Case, Effective, EffectiveContact, Load};
use crate::variant::Variant;
use dynamics::Dynamics;
use neighbours::Skin;
use state::{Constants, State};

/// Skin over the largest radius; the bits do not depend on it.
const SKIN_OVER_RADIUS: f64 = 0.1;

/// How a case is run; none of it is physics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CaseOptions {
    pub fault: Option<Fault>,
    pub skin_over_radius: f64,
    /// Rounding errors of another engine, put in after each step.
    pub noise: Option<Noise>,
}

impl Default for CaseOptions {
    fn default() -> Self {
        CaseOptions {
            fault: None,
            skin_over_radius: SKIN_OVER_RADIUS,
            noise: None,
        }
    }
}

impl From<Option<Fault>> for CaseOptions {
    fn from(fault: Option<Fault>) -> Self {
        CaseOptions {
            fault,
            ..CaseOptions::default()
        }
    }
}

/// Runs a case and returns the state at each of its moments.
pub fn run_case(
    case: &Case,
    options: impl Into<CaseOptions>,
) -> Result<Vec<Snapshot>, NativeError> {
    let mut snapshots = Vec::with_capacity(case.moments.len());
    watch_case(case, &options.into(), &mut |snapshot| {
        snapshots.push(snapshot);
        true
    })?;
    Ok(snapshots)
}

/// Runs a case and shows the state at each of its moments, as long as the watcher wants to go on.
pub fn watch_case(
    case: &Case,
    options: &CaseOptions,
    watcher: &mut dyn FnMut(Snapshot) -> bool,
) -> Result<(), NativeError> {
    each_moment(case, options, &mut |dynamics, step| {
        watcher(dynamics.snapshot(Stage::Settle, step))
    })
}

/// Force and torque summed on each grain at each moment of a case; no torques where nothing turns a grain.
pub fn loads(case: &Case) -> Result<Vec<Vec<Load>>, NativeError> {
    let mut all = Vec::with_capacity(case.moments.len());
    let mut look = |Dynamics { state, .. }: &Dynamics, _| {
        let torques = state.by_number(&state.torque).chain(repeat(0.0));
        let loads = state.by_number(&state.force).zip(torques);
        all.push(loads.map(|([x, z], torque)| [x, z, torque]).collect());
        true
    };
    each_moment(case, &CaseOptions::default(), &mut look)?;
    Ok(all)
}

fn each_moment(
    case: &Case,
    options: &CaseOptions,
    look: &mut dyn FnMut(&Dynamics, u64) -> bool,
) -> Result<(), NativeError> {
    let mut dynamics = start(case, options).map_err(failed(0))?;
    let mut noise = options.noise.map(|noise| noise.begin());
    let mut shake = |dynamics: &mut Dynamics| {
        if let Some(noise) = &mut noise {
            dynamics.shake(noise);
        }
    };
    let mut step = 0;
    for &moment in &case.moments {
        while step < moment {
            if step == 0 {
                shake(&mut dynamics);
            }
            step += 1;
            dynamics.step().map_err(failed(step))?;
            shake(&mut dynamics);
        }
        health::check(&dynamics.state, &dynamics.constants).map_err(failed(step))?;
        if !look(&dynamics, step) {
            break;
        }
    }
    Ok(())
}

/// The parameters that the native engine uses for a case.
pub fn effective(case: &Case, options: impl Into<CaseOptions>) -> Result<Effective, NativeError> {
    let dynamics = start(case, &options.into()).map_err(failed(0))?;
    let (state, constants) = (&dynamics.state, &dynamics.constants);
    let at_start = dynamics.snapshot(Stage::Settle, 0);
    let parameters = |id1: u32, id2: u32| {
        let place = |id: u32| state.place[id as usize] as usize;
        match constants.ids.body(id1) {
            Body::Grain => constants.of_pair(state, place(id1), place(id2)),
            flat => constants.of_flat(state, flat, place(id2)),
        }
    };
    let has_friction = constants.law.has_friction();
    let tan_phi = constants.law.friction_angles().map(f64::tan);
    Ok(Effective {
        contacts: at_start
            .contacts
            .iter()
            .map(|contact| {
                let parameters = parameters(contact.id1, contact.id2);
                EffectiveContact {
                    id1: contact.id1,
                    id2: contact.id2,
                    k_n: parameters.k_n,
                    k_s: has_friction.then_some(parameters.k_s),
                    tan_phi: tan_phi[constants.ids.body(contact.id1) as usize],
                    c_n: parameters.c_n,
                }
            })
            .collect(),
        mass: at_start.bodies.mass,
        inertia: state.by_number(&state.inertia).collect(),
        gravity: constants.gravity,
        alpha: constants.alpha,
        dt: constants.dt,
    })
}

/// The contacts of a case at its start, for small displacements.
pub fn linear(case: &Case) -> Result<Vec<Linear>, NativeError> {
    let constants = Constants::new(&case.model, case.bodies.len() as u32);
    let state = State::new(&case.bodies, case.punch, constants.kernel());
    health::check(&state, &constants).map_err(failed(0))?;
    let usual = Variant::default();
    let written_out = Reference::new(&case.model, &case.bodies, case.punch, &usual);
    Ok(written_out.linear())
}

fn start(case: &Case, options: &CaseOptions) -> Result<Dynamics, Trouble> {
    let mut given = Given::new(&case.model, &case.bodies, case.punch);
    if let Some(fault) = options.fault {
        fault.apply(&mut given);
    }
    let Given {
        constants,
        bodies,
        punch,
    } = given;
    let largest = bodies.radius.iter().copied().fold(0.0, f64::max);
    let skin = options.skin_over_radius * largest;
    let (skin, threads) = (Skin::Fixed(skin), Threads::default());
    Dynamics::new(
        &bodies,
        punch,
        &Memories::default(),
        constants,
        skin,
        threads,
    )
}

fn failed(step: u64) -> impl FnOnce(Trouble) -> NativeError {
    NativeError::at(Stage::Settle, step)
}
