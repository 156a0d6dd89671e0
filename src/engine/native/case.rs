//! Cases in the native engine.

use super::constants::Constants;
use super::dynamics::Dynamics;
use super::health::Trouble;
use super::perturb::Perturbation;
use super::stages::NativeError;
use crate::engine::case::{Case, Effective, EffectiveContact};
use crate::tables::{Bodies, Snapshot, Stage};

/// Skin over the largest radius; the bits do not depend on it.
const SKIN_OVER_RADIUS: f64 = 0.1;

/// Runs a case and returns the state at each of its moments.
pub fn run_case(case: &Case, fault: Option<Perturbation>) -> Result<Vec<Snapshot>, NativeError> {
    let failed = |step| move |trouble| error(step, trouble);
    let mut dynamics = start(case, fault).map_err(failed(0))?;
    let mut snapshots = Vec::with_capacity(case.moments.len());
    let mut step = 0;
    for &moment in &case.moments {
        while step < moment {
            step += 1;
            dynamics.step().map_err(failed(step))?;
        }
        super::health::check(&dynamics.state, &dynamics.constants).map_err(failed(step))?;
        snapshots.push(dynamics.snapshot(Stage::Settle, step));
    }
    Ok(snapshots)
}

/// The parameters that the native engine uses for a case.
pub fn effective(case: &Case, fault: Option<Perturbation>) -> Result<Effective, NativeError> {
    let dynamics = start(case, fault).map_err(|trouble| error(0, trouble))?;
    let Dynamics {
        state, constants, ..
    } = &dynamics;
    let contacts = dynamics.snapshot(Stage::Settle, 0).contacts;
    let parameters = |id1: u32, id2: u32| {
        let (r2, m2) = (state.radius[id2 as usize], state.mass[id2 as usize]);
        if constants.ids.is_grain(id1) {
            let (r1, m1) = (state.radius[id1 as usize], state.mass[id1 as usize]);
            constants.parameters(r1, r2, m1 * m2 / (m1 + m2))
        } else {
            constants.parameters(r2, r2, m2)
        }
    };
    let has_friction = constants.law.has_friction();
    Ok(Effective {
        contacts: contacts
            .iter()
            .map(|contact| {
                let of = parameters(contact.id1, contact.id2);
                EffectiveContact {
                    id1: contact.id1,
                    id2: contact.id2,
                    k_n: of.k_n,
                    k_s: has_friction.then_some(of.k_s),
                    tan_phi: constants.law.friction_angle.tan(),
                    c_n: of.c_n,
                }
            })
            .collect(),
        mass: state.mass.clone(),
        inertia: state.inertia.clone(),
        gravity: constants.gravity,
        alpha: constants.alpha,
        dt: constants.dt,
    })
}

fn start(case: &Case, fault: Option<Perturbation>) -> Result<Dynamics, Trouble> {
    let mut bodies: Bodies = case.bodies.clone();
    let mut constants = Constants::new(&case.model, bodies.len() as u32);
    if let Some(fault) = fault {
        fault.apply(&mut constants, &mut bodies);
    }
    let largest = bodies.radius.iter().copied().fold(0.0, f64::max);
    Dynamics::new(&bodies, case.punch, constants, SKIN_OVER_RADIUS * largest)
}

fn error(step: u64, trouble: Trouble) -> NativeError {
    NativeError {
        stage: Stage::Settle,
        step,
        trouble,
    }
}
