//! Pouring in phases: softened grains, other damping, stiffened step by step.

use serde::{Deserialize, Serialize};

use super::stages::{NativeError, Options, run};
use crate::scene::{Damping, Scene, TimeStep};
use crate::tables::{Bodies, Snapshot};
use crate::task::{Start, Task};

/// A part of pouring.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Phase {
    /// Young's modulus as a share of the scene's.
    pub modulus: f64,
    /// Cundall's α.
    pub alpha: f64,
    /// dt over √(m/k) of the mean grain at this modulus.
    pub step: f64,
    /// What ends it.
    pub end: End,
}

/// What ends a part of pouring.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum End {
    /// So much time, s.
    Seconds(f64),
    /// The kinetic energy is at most this share of the largest that was seen since the start of pouring.
    Settled(f64),
}

/// Poured soft, then stiffened.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Softly {
    /// Modulus at the start, as a share.
    pub start: f64,
    /// The modulus grows by this factor from phase to phase.
    pub ratio: f64,
    /// The soft phase ends at this share of the largest kinetic energy.
    pub until: f64,
    /// Cundall's α.
    pub alpha: f64,
    /// dt over √(m/k) in all phases and in loading.
    pub step: f64,
}

/// A phase between two moduli takes this long at full stiffness, s, and longer where the bed is softer: about ten
/// times what a sound wave takes from the floor to the surface.
const STIFFENING: f64 = 0.002;

impl Softly {
    /// E/10 until the energy is 10⁻³ of its peak, then stiffened by √10 twice: tested to be equivalent for the paper's
    /// scene (`crossgrain pareto`), with the scene's α and step. None where the scene gives its step in seconds.
    pub fn tested(scene: &Scene) -> Option<Self> {
        let TimeStep::Fraction { of_sqrt_m_over_k } = scene.time_step else {
            return None;
        };
        Some(Softly {
            start: 0.1,
            ratio: 10.0f64.sqrt(),
            until: 1.0e-3,
            alpha: scene.damping.alpha(),
            step: of_sqrt_m_over_k,
        })
    }

    /// The phases of pouring, the last one at the scene's modulus until the scene's settle rule.
    pub fn phases(&self, scene: &Scene) -> Vec<Phase> {
        let phase = |modulus: f64, end| Phase {
            modulus,
            alpha: self.alpha,
            step: self.step,
            end,
        };
        let mut phases = vec![phase(self.start, End::Settled(self.until))];
        let mut modulus = self.start * self.ratio;
        while modulus < 0.999 {
            phases.push(phase(modulus, End::Seconds(STIFFENING / modulus.sqrt())));
            modulus *= self.ratio;
        }
        phases.push(phase(
            1.0,
            End::Settled(scene.settle.kinetic_energy_fraction),
        ));
        phases
    }
}

/// A poured bed and what it took.
#[derive(Debug, Clone)]
pub struct Poured {
    /// The bed at rest.
    pub bed: Snapshot,
    /// Steps of all phases.
    pub steps: u64,
    /// Whether every phase ended by its rule.
    pub settled: bool,
    /// The largest kinetic energy that the phases' rules have seen, J.
    pub energy_seen: f64,
}

/// Pours the cloud through these phases. Where the modulus grows from one phase to the next the overlaps stay
/// what they are, so the bed is pressed too hard for a moment and springs back: small ratios keep that small.
pub fn pour(
    scene: &Scene,
    phases: &[Phase],
    options: &Options,
    initial: Bodies,
) -> Result<Option<Poured>, NativeError> {
    let mut start = Start::from(initial);
    let (mut steps, mut peak, mut settled) = (0, 0.0f64, true);
    // As often in time as the scene's own rule, so that one phase of the scene's settings is the scene's pouring.
    let look_every = scene.settle.check_every as f64 * scene.time_step_seconds();
    let mut bed = None;
    for phase in phases {
        let mut scene = scene.clone();
        scene.material.youngs_modulus *= phase.modulus;
        scene.damping = Damping::Cundall { alpha: phase.alpha };
        scene.time_step = TimeStep::Fraction {
            of_sqrt_m_over_k: phase.step,
        };
        let dt = scene.time_step_seconds();
        let (length, fraction) = match phase.end {
            End::Seconds(seconds) => (seconds, None),
            End::Settled(fraction) => (look_every, Some(fraction)),
        };
        let part = ((length / dt).round() as u64).max(1);
        let mut of_phase = 0;
        loop {
            let last = run(&scene, &Task::pour(start, part), options, &mut ())?.last;
            of_phase += part;
            let energy = last.bodies.kinetic_energy();
            start = Start {
                memory: last.memory.clone(),
                ..last.bodies.clone().into()
            };
            bed = Some(last);
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
        energy_seen: peak,
    }))
}
