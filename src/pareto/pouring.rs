//! Pouring in phases: softened grains, other damping, stiffened step by step.

use super::method::{End, Phase};
use crate::engine::native::{self, NativeError};
use crate::engine::{Start, Task, Until};
use crate::measure::energy;
use crate::scene::{Damping, Scene, TimeStep};
use crate::tables::{Bodies, Snapshot, Stage};

/// A poured bed and what it took.
#[derive(Debug, Clone)]
pub struct Poured {
    /// The bed at rest.
    pub bed: Snapshot,
    /// Steps of all phases.
    pub steps: u64,
    /// Whether every phase ended by its rule.
    pub settled: bool,
}

/// Pours the cloud through these phases. Where the modulus grows from one phase to the next the overlaps stay
/// what they are, so the bed is pressed too hard for a moment and springs back: small ratios keep that small.
pub fn pour(
    scene: &Scene,
    phases: &[Phase],
    options: &native::Options,
    initial: Bodies,
) -> Result<Option<Poured>, NativeError> {
    let mut bodies = initial;
    let (mut steps, mut peak, mut settled) = (0, 0.0f64, true);
    // As often in time as the scene's own rule, so that one phase of the scene's settings is the scene's pouring.
    let look_every = scene.settle.check_every as f64 * scene.time_step_seconds();
    let mut bed = None;
    for phase in phases {
        let scene = of_phase(scene, phase);
        let dt = scene.time_step_seconds();
        let (length, fraction) = match phase.end {
            End::Seconds(seconds) => (seconds, None),
            End::Settled(fraction) => (look_every, Some(fraction)),
        };
        let part = ((length / dt).round() as u64).max(1);
        let mut of_phase = 0;
        loop {
            let last = run(&scene, options, bodies, part)?;
            bodies = last.bodies.clone();
            bed = Some(last);
            of_phase += part;
            let energy = energy::kinetic(&bodies);
            peak = peak.max(energy);
            if fraction.is_none_or(|fraction| energy <= fraction * peak) {
                break;
            }
            if of_phase >= scene.settle.max_steps {
                settled = false;
                break;
            }
        }
        steps += of_phase;
    }
    Ok(bed.map(|bed| Poured {
        bed,
        steps,
        settled,
    }))
}

fn of_phase(scene: &Scene, phase: &Phase) -> Scene {
    let mut scene = scene.clone();
    scene.material.youngs_modulus *= phase.modulus;
    scene.damping = Damping::Cundall { alpha: phase.alpha };
    scene.time_step = TimeStep::Fraction {
        of_sqrt_m_over_k: phase.step,
    };
    scene
}

fn run(
    scene: &Scene,
    options: &native::Options,
    bodies: Bodies,
    steps: u64,
) -> Result<Snapshot, NativeError> {
    let task = Task {
        start: Start {
            stage: Stage::Settle,
            step: 0,
            bodies,
            punch: None,
        },
        until: Until::Step(steps),
    };
    Ok(native::run(scene, &task, options, &mut ())?.last)
}
