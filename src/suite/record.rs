//! What a verification found: the source of its lines and of its page.

use serde::Serialize;

use super::ladder::{self, Climbed, ClimbedInYade, Climbers, Ladder, Unmeasured};
use super::limits::{FromYade, Limits, limits};
use super::precision::{self, Errors, Precisions};
use super::{Group, Line};
use crate::compare::Verdict;
use crate::engine::exec::{self, Description};
use crate::engine::yade::{self, YadeError};
use crate::error::Error;
use crate::paper::disc_field::{DiscField, DiscFieldError, figure_4};
use crate::progress::Display;
use crate::run::EngineError;

/// The version of `verify.json`.
pub const VERIFICATION_VERSION: u32 = 2;

/// What is to be verified, and how.
#[derive(Debug, Clone)]
pub struct Options {
    /// Which engines climb.
    pub engine: Climbers,
    /// Trajectories and rounding errors of so many grains at most.
    pub grains: u32,
    /// Whether detection limits are measured.
    pub detection_limits: bool,
    /// How YADE is started.
    pub yade: yade::Options,
    /// The command as it was given.
    pub command: String,
}

/// How many rungs, by verdict.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Tally {
    /// Rungs that hold.
    pub passed: usize,
    /// Rungs that do not.
    pub failed: usize,
    /// Rungs that could not be climbed.
    pub not_made: usize,
    /// Rungs that an engine has no option for.
    pub inapplicable: usize,
}

/// A verification.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verification {
    /// [`VERIFICATION_VERSION`].
    pub version: u32,
    /// Version of crossgrain.
    pub crossgrain: String,
    /// The command as it was given.
    pub command: String,
    /// YADE's version, if it ran.
    pub yade: Option<String>,
    /// What an engine that was brought says of itself, if one climbed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exec: Option<Description>,
    /// Every rung in every engine.
    pub rungs: Vec<Climbed>,
    /// Rounding errors, if they were measured.
    pub errors: Vec<Errors>,
    /// The stress inside Figure 4's disc.
    pub disc: DiscFigures,
    /// Detection limits, if they were asked for.
    pub limits: Option<Limits>,
    /// How many rungs, by verdict.
    pub tally: Tally,
    /// Failed if a rung failed; not made if one is missing; else passed.
    pub verdict: Verdict,
}

/// Stresses of Figure 4's disc, Pa, tension positive, xx, zz, xz.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DiscFigures {
    /// Σ/V of the contact forces.
    pub contact: [f64; 3],
    /// The field averaged over the disc by quadrature.
    pub disc: [f64; 3],
    /// The field averaged over the control square of side R at the centre.
    pub square: [f64; 3],
    /// Σ over the cell of side 2R: σ of Table 3.
    pub cell: [f64; 3],
}

impl DiscFigures {
    /// Of this field.
    pub fn of(field: &DiscField) -> Result<Self, DiscFieldError> {
        let parts = |of: [[f64; 2]; 2]| [of[0][0], of[1][1], of[0][1]];
        Ok(DiscFigures {
            contact: parts(field.contact_average()),
            disc: parts(field.average_over_disc()),
            square: parts(field.average_over_square(field.radius())?),
            cell: parts(field.average_over_cell(2.0 * field.radius())),
        })
    }
}

/// Climbs the ladder as asked.
pub fn verify(options: &Options, display: &Display) -> Result<Verification, Error> {
    // Trajectories are for comparing, and their beds have to be poured first.
    let most_grains = match options.engine {
        Climbers::Both => options.grains,
        Climbers::Native | Climbers::Yade => 0,
    };
    let ladder = Ladder::new(most_grains);
    let mut rungs = Vec::new();
    if options.engine != Climbers::Yade {
        let task = display.task("native rungs");
        rungs.extend(ladder.climb_native());
        task.done("done");
    }
    let in_yade = match options.engine {
        Climbers::Native => Err("YADE was not asked for".to_owned()),
        Climbers::Yade | Climbers::Both => climb_yade(&ladder, options, display)?,
    };
    let mut errors = Vec::new();
    let mut precisions = None;
    if let (Ok(climbed), Climbers::Both) = (&in_yade, options.engine) {
        rungs.extend(climbed.solo.iter().cloned());
        rungs.push(climbed.facts.clone());
        rungs.extend(ladder.compare(&climbed.parity));
        let measured = precisions_in_yade(options, display)?;
        if let Ok(measured) = &measured {
            errors = measured
                .errors(None)
                .map_err(|error| Error::Engine(error.into()))?;
        }
        let found = measured.as_ref().map(|_| errors.as_slice());
        rungs.push(ladder::of_precision(found));
        precisions = measured.ok();
    } else if let Ok(climbed) = &in_yade {
        rungs.extend(climbed.solo.iter().cloned());
    } else if let (Err(reason), Climbers::Yade | Climbers::Both) = (&in_yade, options.engine) {
        rungs.extend(ladder.without_yade(reason));
        rungs.push(ladder::of_precision(Err(&Unmeasured::Missing(
            reason.clone(),
        ))));
    }
    let from_yade = FromYade {
        parity: in_yade.as_ref().map_or(&[], |of| of.parity.as_slice()),
        answers: in_yade.as_ref().map_or(&[], |of| of.answers.as_slice()),
        precisions: precisions.as_ref(),
    };
    let disc = disc_figures()?;
    let limits = options
        .detection_limits
        .then(|| measure_limits(&ladder, from_yade, display));
    if let Some(limits) = &limits {
        rungs.push(of_limits(limits));
    }
    let tally = tally(&rungs);
    Ok(Verification {
        version: VERIFICATION_VERSION,
        crossgrain: env!("CARGO_PKG_VERSION").to_owned(),
        command: options.command.clone(),
        yade: in_yade.ok().map(|of| of.version),
        exec: None,
        rungs,
        errors,
        disc,
        limits,
        tally,
        verdict: of_tally(tally),
    })
}

/// Climbs the ladder in an engine that was brought.
pub fn verify_exec(
    options: &exec::Options,
    command: String,
    display: &Display,
) -> Result<Verification, Error> {
    let failed = |error: exec::ExecError| Error::Engine(error.into());
    let engine = exec::describe(options).map_err(failed)?;
    let task = display.task(&format!("rungs in {}", engine.name));
    let ladder = Ladder::new(0);
    let rungs = ladder
        .climb_exec(&engine, options, &|done, all| {
            task.share(done as f64 / all as f64, &format!("{done} of {all} rungs"));
        })
        .map_err(failed)?;
    task.done("done");
    let tally = tally(&rungs);
    Ok(Verification {
        version: VERIFICATION_VERSION,
        crossgrain: env!("CARGO_PKG_VERSION").to_owned(),
        command,
        yade: None,
        exec: Some(engine),
        rungs,
        errors: Vec::new(),
        disc: disc_figures()?,
        limits: None,
        tally,
        // An engine that has nothing of what is asked has not passed.
        verdict: if tally.passed + tally.failed == 0 {
            Verdict::NotMade
        } else {
            of_tally(tally)
        },
    })
}

fn of_tally(tally: Tally) -> Verdict {
    match tally {
        Tally { failed: 1.., .. } => Verdict::Fail,
        Tally { not_made: 1.., .. } => Verdict::NotMade,
        _ => Verdict::Pass,
    }
}

/// What YADE made of the ladder; the inner error says why there is no YADE.
fn climb_yade(
    ladder: &Ladder,
    options: &Options,
    display: &Display,
) -> Result<Result<ClimbedInYade, String>, Error> {
    let task = display.task("all cases in YADE");
    let mut observer = crate::progress::StageObserver::new(&task);
    match ladder.climb_yade(&options.yade, &mut observer) {
        Ok(climbed) => {
            task.done("done");
            Ok(Ok(climbed))
        }
        Err(EngineError::Yade(error @ YadeError::Missing(_))) => {
            task.done("YADE is missing");
            Ok(Err(error.to_string()))
        }
        Err(error) => Err(Error::Engine(error)),
    }
}

fn precisions_in_yade(
    options: &Options,
    display: &Display,
) -> Result<Result<Precisions, Unmeasured>, Error> {
    let task = display.task("rounding errors");
    match precision::run(precision::case(options.grains), &options.yade) {
        Ok(precisions) => {
            task.done("done");
            Ok(Ok(precisions))
        }
        Err(error @ YadeError::Missing(_)) => {
            task.done("this YADE has no build of that precision");
            Ok(Err(Unmeasured::Missing(error.to_string())))
        }
        Err(error @ (YadeError::Interrupted | YadeError::File(_))) => {
            Err(Error::Engine(error.into()))
        }
        // What the other rungs have shown is not lost with it.
        Err(error) => {
            task.done("a build of YADE failed");
            Ok(Err(Unmeasured::Failed(error.to_string())))
        }
    }
}

fn measure_limits(ladder: &Ladder, in_yade: FromYade<'_>, display: &Display) -> Limits {
    let task = display.task("detection limits");
    let limits = limits(ladder, in_yade, &|done, all| {
        task.share(done as f64 / all as f64, &format!("{done} of {all} rungs"));
    });
    task.done("done");
    limits
}

fn disc_figures() -> Result<DiscFigures, Error> {
    figure_4()
        .and_then(|field| DiscFigures::of(&field))
        .map_err(|error| Error::Report(error.to_string()))
}

fn of_limits(limits: &Limits) -> Climbed {
    let lines = limits.lines();
    without_engine(
        "detection-limits",
        "every fault is noticed, every rung can fail, none cries wolf",
        Group::Proof,
        lines,
    )
}

fn without_engine(name: &str, title: &str, group: Group, lines: Vec<Line>) -> Climbed {
    Climbed {
        name: name.to_owned(),
        title: title.to_owned(),
        group,
        engine: "none".to_owned(),
        verdict: ladder::verdict(&lines),
        reason: String::new(),
        inapplicable: false,
        lines,
    }
}

fn tally(rungs: &[Climbed]) -> Tally {
    let count = |of: &dyn Fn(&Climbed) -> bool| rungs.iter().filter(|rung| of(rung)).count();
    Tally {
        passed: count(&|rung| rung.verdict == Verdict::Pass),
        failed: count(&|rung| rung.verdict == Verdict::Fail),
        not_made: count(&|rung| rung.verdict == Verdict::NotMade && !rung.inapplicable),
        inapplicable: count(&|rung| rung.inapplicable),
    }
}
