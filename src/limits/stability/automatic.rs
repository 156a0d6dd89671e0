//! The automatic time step: a safe share of the largest stable step that the scene itself shows.
//!
//! The scene is poured, settled and pressed once in the native engine with a step that is small for any scene;
//! at every look the contact network gives the largest stable step, with the scene's α. The smallest of them is the limit.

use crate::run::folder::record::{StepChoice, StepLook, StepTrial};
use grains::generate::initial_bodies;
use grains::model::{Law, Model, damping_ratio};
use grains::native::{self, NativeError, Options, Trouble};
use grains::scene::{Scene, TimeStep, Viscosity};
use grains::tables::{Bodies, Snapshot, Stage};
use grains::task::{Observer, Task};

use super::beds::rested;
use super::growth::Disturbed;
use super::network::Network;
use super::spectrum::limit;
use grains::case::Case;

/// The share of the limit that is taken if none is named; `docs/stability.md` has the evidence.
pub const DEFAULT_SHARE: f64 = 0.8;
/// The probing step over √(m/k) of the lightest grain, and over m/c of its dashpot. A dense bed
/// without friction bears 0.8 and 0.3.
const PROBE: f64 = 0.25;
const PROBE_OF_DASHPOT: f64 = 0.05;
/// The contacts are looked at every so many steps of the probe.
const LOOK_EVERY: u64 = 500;
/// The probing step is halved so often before it is given up.
const MOST_HALVINGS: u32 = 4;

/// Chooses the step of a scene, with the evidence.
///
/// # Errors
///
/// Those of the native engine, which probes the scene: a scene that goes wrong at any step.
pub fn choose(scene: &Scene, share: f64) -> Result<StepChoice, NativeError> {
    let mut probe = probing_step(scene);
    let mut halvings = 0;
    let (looks, last) = loop {
        match looks_of(scene, probe) {
            Ok((looks, last)) => {
                let least = least(&looks).map_or(f64::INFINITY, |look| look.limit);
                if probe < 0.75 * least {
                    break (looks, last);
                }
                if halvings == MOST_HALVINGS {
                    return Err(NativeError {
                        stage: Stage::Settle,
                        step: 0,
                        trouble: Trouble::NoProbe { dt: probe },
                    });
                }
            }
            Err(error)
                if halvings < MOST_HALVINGS && !matches!(error.trouble, Trouble::Interrupted) => {}
            Err(error) => return Err(error),
        }
        probe *= 0.5;
        halvings += 1;
    };
    let alpha = scene.damping.alpha();
    let (limit, undamped, at) = match least(&looks) {
        Some(look) => (look.limit, look.undamped, Some(look)),
        // Nothing ever touched: the probing step is as good as any.
        None => (probe / share, probe / share, None),
    };
    Ok(StepChoice {
        share,
        time_step: share * limit,
        limit,
        limit_without_damping: undamped,
        alpha,
        probed_at: probe,
        looks: looks.len() as u64,
        least: at,
        settled: last_of(&looks, Stage::Settle),
        loaded: last_of(&looks, Stage::Load),
        trial: trial(scene, probe, &last)?,
    })
}

/// The scene with the chosen step, and the reason for it among its choices.
pub fn with_step(scene: &Scene, choice: &StepChoice) -> Scene {
    let mut scene = scene.clone();
    scene.time_step = TimeStep::Absolute {
        seconds: choice.time_step,
    };
    scene.choices.insert(
        "/time_step".to_owned(),
        format!(
            "chosen by the program: {} of the largest stable step {:.4e} s of {} looks",
            choice.share, choice.limit, choice.looks
        ),
    );
    scene
}

/// The scene's step over the largest stable step of a settled bed with its contacts, the scene's α counted in; none where
/// nothing touches. A bed can settle at a step a little beyond the limit: what grows opens its contacts and stops
/// there. So a run that ends well does not show that its step was stable, and this does.
///
/// # Errors
///
/// Those of the native engine, for bodies that it cannot start from.
pub fn share_of_limit(scene: &Scene, bodies: &Bodies) -> Result<Option<f64>, NativeError> {
    let case = Case {
        name: "a settled bed".to_owned(),
        model: Model::of(scene),
        bodies: still(bodies),
        punch: None,
        moments: vec![0],
    };
    let limit = limit(&Network::of(&case)?, scene.damping.alpha()).dt;
    Ok(limit.is_finite().then(|| scene.time_step_seconds() / limit))
}

/// A step that is small for any scene of these grains, s.
fn probing_step(scene: &Scene) -> f64 {
    let radius = 0.5 * scene.particles.mean_diameter * (1.0 - scene.particles.dispersion);
    let mass = scene.grain_mass(radius);
    let stiffness = scene.material.youngs_modulus * radius;
    let law = Model::of(scene).law;
    // A sticking contact adds k_s(1/m + R²/I) to k_n/m, at most 3.5 k_s/m; half of that is felt at a time.
    let sticking = if law.has_friction() {
        1.0 + 1.75 * law.stiffness_ratio
    } else {
        1.0
    };
    let springs = PROBE * (mass / (stiffness * sticking)).sqrt();
    let constant = match law.contact.viscosity {
        Viscosity::None => return springs,
        Viscosity::Dashpot { c_n, .. } => c_n,
        Viscosity::Restitution { e_n, tension } => {
            2.0 * damping_ratio(e_n, tension) * (mass * stiffness).sqrt()
        }
    };
    springs.min(PROBE_OF_DASHPOT * mass / constant)
}

fn looks_of(scene: &Scene, probe: f64) -> Result<(Vec<StepLook>, Snapshot), NativeError> {
    let mut scene = scene.clone();
    // As long in time as the scene allows, and no less.
    let slower = scene.time_step_seconds() / probe;
    let more = |steps: u64| ((steps as f64 * slower).ceil() as u64).max(steps);
    scene.settle.check_every = more(scene.settle.check_every);
    scene.settle.max_steps = more(scene.settle.max_steps);
    scene.time_step = TimeStep::Absolute { seconds: probe };
    scene.measurement.history_every = LOOK_EVERY;
    let mut looker = Looker {
        model: Model::of(&scene),
        looks: Vec::new(),
        failed: None,
    };
    let task = Task::whole(initial_bodies(&scene));
    let outcome = native::run(&scene, &task, &Options::default(), &mut looker)?;
    match looker.failed {
        Some(error) => Err(error),
        None => Ok((looker.looks, outcome.settled.unwrap_or(outcome.last))),
    }
}

struct Looker {
    model: Model,
    looks: Vec<StepLook>,
    failed: Option<NativeError>,
}

impl Observer for Looker {
    fn snapshot(&mut self, snapshot: &Snapshot) {
        if snapshot.contacts.is_empty() || self.failed.is_some() {
            return;
        }
        let case = Case {
            name: "a look".to_owned(),
            model: self.model.clone(),
            bodies: still(&snapshot.bodies),
            punch: snapshot.punch,
            moments: vec![0],
        };
        match Network::of(&case) {
            Ok(network) => {
                let undamped = limit(&network, 0.0).dt;
                let look = StepLook {
                    stage: snapshot.stage,
                    step: snapshot.step,
                    contacts: network.contacts() as u64,
                    limit: if self.model.alpha == 0.0 {
                        undamped
                    } else {
                        limit(&network, self.model.alpha).dt
                    },
                    undamped,
                };
                if look.limit.is_finite() {
                    self.looks.push(look);
                }
            }
            Err(error) => self.failed = Some(error),
        }
    }
}

fn still(bodies: &Bodies) -> Bodies {
    let mut still = bodies.clone();
    still.vx.fill(0.0);
    still.vz.fill(0.0);
    still.spin.fill(0.0);
    still
}

fn least(looks: &[StepLook]) -> Option<StepLook> {
    looks
        .iter()
        .copied()
        .min_by(|a, b| a.limit.total_cmp(&b.limit))
}

fn last_of(looks: &[StepLook], stage: Stage) -> Option<StepLook> {
    looks.iter().rev().find(|look| look.stage == stage).copied()
}

/// The settled bed brought to rest, its limit predicted and found; none where it does not come to rest.
fn trial(scene: &Scene, probe: f64, settled: &Snapshot) -> Result<Option<StepTrial>, NativeError> {
    let mut model = Model::of(scene);
    model.dt = probe;
    model.law = Law {
        contact: grains::scene::ContactLaw {
            viscosity: Viscosity::None,
            ..model.law.contact
        },
        ..model.law
    };
    let Some(case) = rested("the settled bed", &model, &settled.bodies, None)? else {
        return Ok(None);
    };
    let predicted = limit(&Network::of(&case)?, 0.0).dt;
    let found = Disturbed::at_random(&case, [true; 2])?.undamped()?;
    Ok(found.map(|found| StepTrial {
        predicted,
        stable: found.stable,
        unstable: found.unstable,
    }))
}
