//! Proof that the comparison can fail: small faults in the native engine, each of which it must find.

use serde::Serialize;

use crate::compare::compare;
use crate::compare::first_difference::Locator;
use crate::engine::native::{self, Perturbation};
use crate::error::Error;
use crate::folder::record::Protocol;
use crate::generate::initial_bodies;
use crate::progress::Display;
use crate::run::{Engine, EngineError, recorded};
use crate::scene::Scene;

/// Steps of pouring that a fault has to show itself in.
pub const STEPS: u64 = 6000;

/// The faults, smallest sizes that the issue of finding them is about.
pub const FAULTS: [Perturbation; 6] = [
    Perturbation::Stiffness(1e-12),
    Perturbation::Gravity(1e-12),
    Perturbation::Damping(1e-12),
    Perturbation::Wall(1e-12),
    Perturbation::MissingWall,
    Perturbation::ReversedSums,
];

/// One fault, and whether it was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaultCheck {
    pub fault: String,
    pub detected: bool,
    /// The first step and grain, or why the faulty engine stopped.
    pub found: String,
}

/// Puts each fault in, compares with the sound engine and finds the first difference.
pub fn check_all(scene: &Scene, display: &Display) -> Result<Vec<FaultCheck>, Error> {
    let task = display.task("faults put in");
    let pour = |perturbation: Option<Perturbation>| {
        let engine = Engine::Native(native::Options {
            skin: None,
            perturbation,
        });
        let protocol = Protocol::Steps { steps: STEPS };
        // The native engine leaves nothing in its work folder.
        let nowhere = std::path::Path::new("");
        let initial = initial_bodies(scene);
        recorded(
            scene,
            &engine,
            protocol,
            initial,
            nowhere,
            &mut |_, _, _| {},
        )
    };
    let sound = pour(None)?;
    let mut checks = Vec::new();
    for (done, fault) in FAULTS.into_iter().enumerate() {
        let check = match pour(Some(fault)) {
            Ok(faulty) => {
                let comparison = compare(&sound, &faulty, None, Some(&Locator::default()));
                FaultCheck {
                    fault: fault.to_string(),
                    detected: !comparison.agrees(),
                    found: match &comparison.first_difference {
                        Some(first) => first.to_string(),
                        None => format!("no difference in {STEPS} steps"),
                    },
                }
            }
            Err(EngineError::Native(error)) => FaultCheck {
                fault: fault.to_string(),
                detected: true,
                found: error.to_string(),
            },
            Err(error) => return Err(error.into()),
        };
        checks.push(check);
        task.share((done + 1) as f64 / FAULTS.len() as f64, &fault.to_string());
    }
    let found = checks.iter().filter(|check| check.detected).count();
    task.done(&format!("{found} of {} found", checks.len()));
    Ok(checks)
}
