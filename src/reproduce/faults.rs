//! Proof that the comparison can fail: small faults in the native engine, each of which it must find.

use serde::Serialize;

use crate::checks::Outcome;
use crate::compare::compare;
use crate::compare::first_difference::Locator;
use crate::error::Error;
use crate::progress::Display;
use crate::run::folder::RunFolder;
use crate::run::folder::record::Protocol;
use crate::run::{Engine, EngineError, recorded};
use grains::generate::initial_bodies;
use grains::native::perturb::{Quantity, Switch};
use grains::native::{self, Perturbation, Trouble};
use grains::scene::Scene;

/// Steps of pouring that a fault has to show itself in.
pub const STEPS: u64 = 6000;

/// The faults, smallest sizes that the issue of finding them is about.
pub const FAULTS: [Perturbation; 6] = [
    Perturbation::Sized(Quantity::Stiffness, 1e-12),
    Perturbation::Sized(Quantity::Gravity, 1e-12),
    Perturbation::Sized(Quantity::Damping, 1e-12),
    Perturbation::Sized(Quantity::Wall, 1e-12),
    Perturbation::Switched(Switch::Wall),
    Perturbation::Switched(Switch::Sums),
];

/// One fault, and whether it was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaultCheck {
    /// As on the command line.
    pub fault: String,
    /// Passed if the comparison found it; not made where the fault changes nothing in this scene.
    pub verdict: Outcome,
    /// The first step and grain, or why it was not found.
    pub found: String,
}

/// Puts each fault in, compares with the sound engine and finds the first difference.
pub fn check_all(scene: &Scene, display: &Display) -> Result<Vec<FaultCheck>, Error> {
    let task = display.task("faults put in");
    let sound = pour(scene, None, STEPS)?;
    let mut checks = Vec::new();
    for (done, fault) in FAULTS.into_iter().enumerate() {
        checks.push(check(scene, &sound, fault)?);
        task.share((done + 1) as f64 / FAULTS.len() as f64, &fault.to_string());
    }
    let found = checks.iter().filter(|check| check.verdict == Outcome::Pass);
    task.done(&format!("{} of {} found", found.count(), checks.len()));
    Ok(checks)
}

fn check(scene: &Scene, sound: &RunFolder, fault: Perturbation) -> Result<FaultCheck, Error> {
    let of = |verdict, found| {
        Ok(FaultCheck {
            fault: fault.to_string(),
            verdict,
            found,
        })
    };
    if !fault.changes(scene) {
        return of(
            Outcome::Skipped,
            "it changes nothing in this scene".to_owned(),
        );
    }
    // A fault may end the faulty engine; a tenth earlier, all may still be well enough to compare.
    let (mut steps, mut ended) = (STEPS, None);
    let faulty = loop {
        match pour(scene, Some(fault), steps) {
            Ok(faulty) => break faulty,
            Err(EngineError::Native(error)) if error.trouble != Trouble::Interrupted => {
                steps = error.step * 9 / 10;
                ended.get_or_insert(error);
            }
            Err(error) => return Err(error.into()),
        }
    };
    let shortened = match &ended {
        Some(_) => Some(pour(scene, None, faulty.record.stages[0].steps)?),
        None => None,
    };
    let sound = shortened.as_ref().unwrap_or(sound);
    let comparison = compare(sound, &faulty, None, Some(&Locator::default()));
    let mut found = match (&comparison.first_difference, comparison.verdict()) {
        (Some(first), _) => first.to_string(),
        (None, Outcome::Fail) => "a check failed, the place was not found".to_owned(),
        (None, _) => format!("no difference in {STEPS} steps"),
    };
    if let Some(error) = ended {
        found += &format!("; then the {error}");
    }
    let verdict = if comparison.verdict() == Outcome::Fail {
        Outcome::Pass
    } else {
        Outcome::Fail
    };
    of(verdict, found)
}

/// Pours for so many steps, nothing kept on disk.
fn pour(
    scene: &Scene,
    perturbation: Option<Perturbation>,
    steps: u64,
) -> Result<RunFolder, EngineError> {
    let engine = Engine::Native(native::Options {
        perturbation,
        ..native::Options::default()
    });
    let protocol = Protocol::Steps { steps };
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
}
