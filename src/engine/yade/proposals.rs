//! The time steps that YADE itself would choose for cases.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{Options, YadeError, child, find, job, nonsense, unsupported};
use crate::files::read_text;
use grains::case::Case;

/// What YADE would choose, s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Proposal {
    /// `utils.PWaveTimeStep()`.
    pub p_wave: f64,
    /// `GlobalStiffnessTimeStepper` as it is by default, with its safety factor of 0.8.
    pub global_stiffness: f64,
    /// The same with `viscEl=True`, which looks at dashpots; asked only where there are some.
    pub with_dashpots: f64,
}

/// Asks YADE; `work` is an empty folder. The answers in the order of the cases, and YADE's version.
pub fn propose(
    cases: &[&Case],
    options: &Options,
    work: &Path,
) -> Result<(Vec<Proposal>, String), YadeError> {
    if let Some(reason) = cases.iter().find_map(|case| unsupported(&case.model)) {
        return Err(YadeError::Unsupported(reason));
    }
    let installation = find(options.program.as_deref())?;
    job::write_cases_for(work, job::PROPOSE_STEPS, cases)?;
    let finished = child::run(&installation, job::PROPOSE_STEPS.0, work, options, &mut ())?;
    let path = work.join("proposals.json");
    let text = read_text(&path, 1 << 24).map_err(|error| nonsense(error.to_string()))?;
    let proposals: Vec<Proposal> = serde_json::from_str(&text)
        .map_err(|error| nonsense(format!("proposals.json: {error}")))?;
    if proposals.len() != cases.len() {
        return Err(nonsense(format!(
            "proposals.json has {} steps for {} cases",
            proposals.len(),
            cases.len()
        )));
    }
    Ok((proposals, finished.version))
}
