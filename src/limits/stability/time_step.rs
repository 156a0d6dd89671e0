//! Time steps that are chosen: by YADE's formulas, and the automatic one, a safe share of the largest stable step that
//! the scene itself shows.
//!
//! For the automatic one the scene is poured, settled and pressed once in the native engine with a step that is small for any scene;
//! at every look the contact network gives the largest stable step, with the scene's α. The smallest of them is the limit.

use super::Result;
use super::scenes::{rested, still};
use super::spectrum::Network;
use super::trials::Disturbed;
use crate::engine::yade::Proposal;
use crate::run::folder::RunFolder;
use crate::run::folder::record::{StepChoice, StepLook, StepTrial};
use grains::generate::initial_bodies;
use grains::model::{Model, damping_ratio};
use grains::native::{self, NativeError, Options, Trouble};
use grains::scene::{Scene, TimeStep, Viscosity};
use grains::tables::{Bodies, Snapshot, Stage};
use grains::task::{Case, Observer, Task};

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
pub fn choose(scene: &Scene, share: f64) -> Result<StepChoice> {
    let of_stages = scene
        .stages()
        .map(|stage| probing_step(&scene.in_stage(stage)));
    let mut probe = of_stages.fold(f64::INFINITY, f64::min);
    let mut halvings = 0;
    let (looks, last) = loop {
        let small = |looks: &[StepLook]| least(looks).is_none_or(|look| probe < 0.75 * look.limit);
        match looks_of(scene, probe) {
            Ok((looks, last)) if small(&looks) => break (looks, last),
            Err(error) if error.trouble == Trouble::Interrupted => return Err(error),
            _ if halvings < MOST_HALVINGS => {}
            Err(error) => return Err(error),
            Ok(_) => {
                return Err(NativeError {
                    stage: Stage::Settle,
                    step: 0,
                    trouble: Trouble::NoProbe { dt: probe },
                });
            }
        }
        probe *= 0.5;
        halvings += 1;
    };
    let alpha = scene.damping.alpha();
    let least = least(&looks);
    // Where nothing ever touched the probing step is as good as any.
    let [limit, undamped] = least.map_or([probe / share; 2], |look| [look.limit, look.undamped]);
    Ok(StepChoice {
        share,
        time_step: share * limit,
        limit,
        limit_without_damping: undamped,
        alpha,
        probed_at: probe,
        looks: looks.len() as u64,
        least,
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
    let why = format!(
        "chosen by the program: {} of the largest stable step {:.4e} s of {} looks",
        choice.share, choice.limit, choice.looks
    );
    // A scene that gives reasons gives all of them.
    if !scene.choices.is_empty() {
        scene.choices.insert("/time_step".to_owned(), why);
    }
    scene
}

/// The scene's step over the largest stable step of a settled bed with its contacts, the scene's α counted in; none where
/// nothing touches. A bed can settle at a step a little beyond the limit: what grows opens its contacts and stops
/// there. So a run that ends well does not show that its step was stable, and this does.
pub fn share_of_limit(scene: &Scene, bodies: &Bodies) -> Result<Option<f64>> {
    let mut limit = f64::INFINITY;
    for stage in scene.stages() {
        let model = Model::in_stage(scene, stage);
        let alpha = model.alpha;
        let network = Network::of(&still("a look", model, bodies.clone(), None))?;
        limit = limit.min(network.limit(alpha).dt);
    }
    Ok(limit.is_finite().then(|| scene.time_step_seconds() / limit))
}

/// The largest [`share_of_limit`] of a run's beds.
pub fn largest_share(run: &RunFolder) -> Result<Option<f64>> {
    let last = run.record.stages.last();
    let last = last.map_or(Stage::Settle, |record| record.stage);
    let settled = run.settled.iter().map(|bed| (bed, Stage::Settle));
    let mut largest: Option<f64> = None;
    for (bed, stage) in settled.chain([(&run.last, last)]) {
        let share = share_of_limit(&run.scene.in_stage(stage), &bed.bodies)?;
        largest = largest.into_iter().chain(share).reduce(f64::max);
    }
    Ok(largest)
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
        Viscosity::Ratio { ratio, .. } => 2.0 * ratio * (mass * stiffness).sqrt(),
    };
    springs.min(PROBE_OF_DASHPOT * mass / constant)
}

fn looks_of(scene: &Scene, probe: f64) -> Result<(Vec<StepLook>, Snapshot)> {
    let mut scene = scene.clone();
    // As long in time as the scene allows, and no less.
    let slower = scene.time_step_seconds() / probe;
    let more = |steps: u64| ((steps as f64 * slower).ceil() as u64).max(steps);
    scene.settle.check_every = more(scene.settle.check_every);
    scene.settle.max_steps = more(scene.settle.max_steps);
    scene.time_step = TimeStep::Absolute { seconds: probe };
    scene.measurement.history_every = LOOK_EVERY;
    let mut looker = Looker {
        scene: scene.clone(),
        looks: Vec::new(),
        failed: Ok(()),
    };
    let task = Task::whole(initial_bodies(&scene));
    let outcome = native::run(&scene, &task, &Options::default(), &mut looker)?;
    looker.failed?;
    Ok((looker.looks, outcome.settled.unwrap_or(outcome.last)))
}

struct Looker {
    scene: Scene,
    looks: Vec<StepLook>,
    failed: Result<()>,
}

impl Observer for Looker {
    fn snapshot(&mut self, snapshot: &Snapshot) {
        if snapshot.contacts.is_empty() || self.failed.is_err() {
            return;
        }
        let model = Model::in_stage(&self.scene, snapshot.constants());
        let alpha = model.alpha;
        let (bodies, punch) = (snapshot.bodies.clone(), snapshot.punch);
        match Network::of(&still("a look", model, bodies, punch)) {
            Ok(network) => {
                let undamped = network.limit(0.0).dt;
                let look = StepLook {
                    stage: snapshot.stage,
                    step: snapshot.step,
                    contacts: network.contacts() as u64,
                    limit: network.limit(alpha).dt,
                    undamped,
                };
                self.looks.extend(look.limit.is_finite().then_some(look));
            }
            Err(error) => self.failed = Err(error),
        }
    }
}

fn least(looks: &[StepLook]) -> Option<StepLook> {
    let looks = looks.iter().copied();
    looks.min_by(|a, b| a.limit.total_cmp(&b.limit))
}

fn last_of(looks: &[StepLook], stage: Stage) -> Option<StepLook> {
    looks.iter().rev().find(|look| look.stage == stage).copied()
}

/// The settled bed brought to rest, its limit predicted and found; none where it does not come to rest.
fn trial(scene: &Scene, probe: f64, settled: &Snapshot) -> Result<Option<StepTrial>> {
    let mut model = Model::of(scene);
    model.dt = probe;
    model.law.contact.viscosity = Viscosity::None;
    let case = match rested("the settled bed", &model, &settled.bodies, None) {
        Err(error) if matches!(error.trouble, Trouble::DoesNotRest { .. }) => return Ok(None),
        case => case?,
    };
    let predicted = Network::of(&case)?.limit(0.0).dt;
    let found = Disturbed::at_random(&case, [true; 3])?.undamped()?;
    Ok(found.map(|found| StepTrial {
        predicted,
        stable: found.stable,
        unstable: found.unstable,
    }))
}

/// √2 as YADE's stepper has it.
const ROOT_TWO: f64 = 1.41044;
const SAFETY: f64 = 0.8;

/// YADE's formulas on a case at its start: shown where YADE is not there to be asked.
///
/// PWave: min R√(ρ/E) with ρ the mass over the volume 4/3πR³ of a ball. GlobalStiffness: per grain and axis
/// K = Σ[(k_n − k_s)n_a² + k_s], about each axis K = Σ[(k_s R² + k_r)(1 − n_a²) + k_t n_a²], both over contacts under load;
/// dt = 1.41044·0.8·√(min(m/K, I/K)), with dashpots no more than 2·0.8·m/C. A material without friction
/// still has a k_s here.
pub fn by_formula(case: &Case) -> Result<Proposal> {
    let (bodies, ids) = (&case.bodies, case.ids());
    // Of each grain: K along the axes, K about the axes, C.
    let mut sums = vec![[0.0; 7]; bodies.len()];
    for contact in native::linear(case)? {
        if contact.force == 0.0 {
            continue;
        }
        let squares = contact.normal.map(|n| n * n);
        let both = [contact.ids.0, contact.ids.1].into_iter();
        for id in both.filter(|id| ids.is_grain(*id)) {
            let radius = bodies.radius[id as usize];
            let sums = &mut sums[id as usize];
            for axis in 0..3 {
                let k_s = contact.k_s;
                sums[axis] += (contact.k_n - k_s) * squares[axis] + k_s;
                let bending = k_s * radius * radius + contact.bending;
                sums[3 + axis] += bending * (1.0 - squares[axis]);
                sums[3 + axis] += contact.twisting * squares[axis];
            }
            sums[6] += contact.c_n;
        }
    }
    let [mut p_wave, mut square, mut viscous] = [f64::INFINITY; 3];
    for (id, sums) in sums.iter().enumerate() {
        let (mass, radius) = (bodies.mass[id], bodies.radius[id]);
        let volume = 4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius;
        p_wave = p_wave.min(radius * (mass / volume / case.model.law.modulus).sqrt());
        // Where grains do not turn the stepper looks at rotations all the same: a ball of this mass.
        let ball = 0.4 * mass * radius * radius;
        let inertia = bodies.inertia.get(id).copied().unwrap_or(ball);
        for (inert, stiffness) in [(mass, &sums[..3]), (inertia, &sums[3..6])] {
            let stiffness = stiffness.iter().copied().fold(0.0, f64::max);
            if stiffness > 0.0 {
                square = square.min(inert / stiffness);
            }
        }
        if sums[6] > 0.0 {
            viscous = viscous.min(2.0 * SAFETY * mass / sums[6]);
        }
    }
    let global_stiffness = ROOT_TWO * SAFETY * square.sqrt();
    Ok(Proposal {
        p_wave,
        global_stiffness,
        with_dashpots: global_stiffness.min(viscous),
    })
}
