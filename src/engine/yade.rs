//! The YADE driver: finds Debian's YADE, runs the fixed script on a job folder without any
//! listening socket, and believes only what the tables prove.

mod binary;
mod cases;
mod child;
mod find;
pub mod frames;
mod job;
mod proposals;
pub mod timing;

use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::files::FileError;
use grains::model::Model;
use grains::native::Trouble;
use grains::scene::{NewContactSlip, Scene, SlipVelocity, Tension, TorqueArms, Viscosity};
use grains::tables::Stage;
use grains::task::{Observer, Outcome, Task};

pub use cases::{CaseInYade, CasesInYade, read as read_cases, run_cases};
pub use child::log;
pub use find::{Installation, find, sibling};
pub use job::script_digest;
pub use proposals::{Proposal, propose};

/// The oldest YADE whose options this driver relies on.
pub const OLDEST_VERSION: (u32, u32) = (2023, 2);

/// How YADE is run; none of it is physics, all of it may change bits.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Visit interactions in the order of their ids (slower): the mode that has the native
    /// engine's bits.
    pub sorted: bool,
    /// YADE's `verletDist`, m. In sorted mode the bits do not depend on it.
    pub verlet_distance: f64,
    /// The whole run may take so long.
    pub time_limit: Duration,
    /// YADE counts as hung when it has not moved on for so long.
    pub stall_limit: Duration,
    /// The most resident memory of YADE and all that it starts, bytes.
    pub memory_limit: u64,
    /// The most that its tables and its log may take, bytes.
    pub output_limit: u64,
    /// The `yade` to use instead of the one on the path.
    pub program: Option<PathBuf>,
    /// A program, with its arguments, that YADE's Python is to run under, such as valgrind; usually none.
    pub under: Vec<String>,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            sorted: true,
            verlet_distance: 1.0e-4,
            time_limit: Duration::from_secs(4 * 3600),
            stall_limit: Duration::from_secs(120),
            memory_limit: 4 << 30,
            output_limit: 16 << 30,
            program: None,
            under: Vec::new(),
        }
    }
}

/// YADE did not give a run that can be used.
#[derive(Debug, thiserror::Error)]
pub enum YadeError {
    #[error(
        "YADE is missing: {0}; on Debian 12 install it with \
         `apt-get install --no-install-recommends yade`"
    )]
    Missing(String),
    #[error(
        "YADE {found} is too old: this driver needs {}.{:02} or later, as in Debian 12",
        OLDEST_VERSION.0, OLDEST_VERSION.1
    )]
    TooOld { found: String },
    #[error("YADE has no such thing: {0}; run this scene with the native engine")]
    Unsupported(String),
    #[error("YADE crashed ({status}); the end of its log:\n{log}")]
    Crashed { status: String, log: String },
    #[error(
        "YADE hung: {reason}; it was ended (--stall-limit and --time-limit give it longer). The end of its log:\n{log}"
    )]
    Hung { reason: String, log: String },
    #[error("YADE took {reason}; it was ended (--memory-limit and --output-limit give it more)")]
    TooMuch { reason: String },
    #[error("YADE was ended, as asked; start the command again")]
    Interrupted,
    #[error(
        "YADE wrote nonsense: {0}; see that --yade, CROSSGRAIN_YADE or the path name Debian's YADE, and start the command \
         again"
    )]
    Nonsense(String),
    #[error("YADE's run went wrong, seen in step {step} of stage {}: {trouble}", .stage.name())]
    WentWrong {
        stage: Stage,
        step: u64,
        trouble: Trouble,
    },
    #[error(transparent)]
    File(#[from] FileError),
}

/// What was written is not what a run writes.
fn nonsense(reason: String) -> YadeError {
    YadeError::Nonsense(reason)
}

/// A finished run of YADE.
#[derive(Debug)]
pub struct YadeRun {
    /// Stages and last moment.
    pub outcome: Outcome,
    /// As YADE prints it.
    pub version: String,
    /// What YADE wrote on its standard output and error.
    pub log: String,
}

/// Runs the task in YADE. `work` is an empty folder on a disk with room for about 1 MB a moment
/// of history.
pub fn run(
    scene: &Scene,
    task: &Task,
    options: &Options,
    work: &Path,
    observer: &mut dyn Observer,
) -> Result<YadeRun, YadeError> {
    if let Some(reason) = unsupported(&Model::of(scene)) {
        return Err(YadeError::Unsupported(reason));
    }
    let installation = find(options.program.as_deref())?;
    job::write(work, scene, task, options)?;
    let finished = child::run(&installation, job::RUN_SCENE.0, work, options, observer)?;
    let outcome = frames::read(work, scene, task, observer)?;
    Ok(YadeRun {
        outcome,
        version: finished.version,
        log: finished.log,
    })
}

/// What the model asks for that YADE does not have, if there is anything.
pub fn unsupported(model: &Model) -> Option<String> {
    let contact = &model.law.contact;
    let reason = match contact.viscosity {
        Viscosity::None => None,
        Viscosity::Restitution { .. } => Some(
            "dashpots by restitution (it solves for them to 1 % only); give c_n with \
             contact.viscosity.kind = dashpot",
        ),
        Viscosity::Dashpot {
            tension: Tension::Unclipped,
            ..
        } => Some("dashpots that pull (contact.viscosity.tension = unclipped)"),
        Viscosity::Dashpot { .. } if !model.law.has_friction() => None,
        Viscosity::Dashpot { .. }
            if contact.slip_velocity != SlipVelocity::ContactPoint
                || contact.torque_arms != TorqueArms::ContactPoint =>
        {
            Some(
                "dashpots with friction other than by contact.slip_velocity = contact_point and \
                 contact.torque_arms = contact_point",
            )
        }
        Viscosity::Dashpot { .. } => None,
    };
    let timed = model.law.has_friction() && contact.new_contact_slip == NewContactSlip::SinceTouch;
    reason
        .or(timed.then_some("slip since touch (contact.new_contact_slip = since_touch)"))
        .map(str::to_owned)
}
