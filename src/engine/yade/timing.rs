//! How long YADE takes for a step of a bed: steps alone, after its start and outside of all tables.

use std::path::Path;

use serde::Deserialize;

use super::binary::{MomentLine, Tables, index};
use super::{Options, YadeError, child, find, job, nonsense};
use crate::files::read_text;
use grains::model::Model;
use grains::tables::{Bodies, BodyIds, Contact};
use grains::timing::{Share, Window};

/// A bed in YADE, timed.
#[derive(Debug)]
pub struct TimedInYade {
    /// The timed steps.
    pub window: Window,
    /// The grains after warm-up and window.
    pub bodies: Bodies,
    /// Their contacts, sorted by ids.
    pub contacts: Vec<Contact>,
    /// Largest resident memory of YADE's process up to the end of the window, bytes.
    pub peak_memory: u64,
    /// YADE's own account of its engines; empty where no steps were given to it.
    pub shares: Vec<Share>,
    /// As YADE prints it.
    pub version: String,
}

/// Steps before, in and after the timed window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Steps {
    /// Before it.
    pub warm_up: u64,
    /// In it.
    pub timed: u64,
    /// Afterwards, with YADE's own timers on.
    pub shares: u64,
}

#[derive(Deserialize)]
struct Frame {
    #[serde(flatten)]
    moment: MomentLine,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Done {
    steps_by_yade: u64,
    wall_seconds: f64,
    cpu_seconds: f64,
    peak_memory: u64,
    shares: Vec<DoneShare>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DoneShare {
    name: String,
    nanoseconds: u64,
}

/// Times steps of this bed. `work` is an empty folder.
pub fn time(
    model: &Model,
    bodies: &Bodies,
    steps: Steps,
    options: &Options,
    work: &Path,
) -> Result<TimedInYade, YadeError> {
    if let Some(reason) = super::unsupported(model) {
        return Err(YadeError::Unsupported(reason));
    }
    let installation = find(options.program.as_deref())?;
    job::write_timing(work, model, bodies, steps, options)?;
    let finished = child::run(&installation, job::TIME_STEPS.0, work, options, &mut ())?;
    let done = read_text(&work.join("done.json"), 1 << 16)?;
    let done: Done =
        serde_json::from_str(&done).map_err(|error| nonsense(format!("done.json: {error}")))?;
    if done.steps_by_yade != steps.warm_up + steps.timed + steps.shares {
        return Err(nonsense(format!(
            "YADE counts {} steps, {} were asked for",
            done.steps_by_yade,
            steps.warm_up + steps.timed + steps.shares
        )));
    }
    if !(done.wall_seconds > 0.0 && done.cpu_seconds > 0.0) {
        return Err(nonsense("times that are not above zero".to_owned()));
    }
    let (bodies, contacts) = last_moment(work, bodies)?;
    let total: f64 = done.shares.iter().map(|of| of.nanoseconds as f64).sum();
    let shares = done.shares.into_iter().map(|share| Share {
        share: share.nanoseconds as f64 / total,
        stage: share.name,
    });
    Ok(TimedInYade {
        window: Window {
            steps: steps.timed,
            wall_seconds: done.wall_seconds,
            cpu_seconds: Some(done.cpu_seconds),
        },
        bodies,
        contacts,
        peak_memory: done.peak_memory,
        shares: shares.filter(|_| total > 0.0).collect(),
        version: finished.version,
    })
}

fn last_moment(work: &Path, start: &Bodies) -> Result<(Bodies, Vec<Contact>), YadeError> {
    let index = index(work)?;
    let line = index.lines().next().unwrap_or_default();
    let frame: Frame =
        serde_json::from_str(line).map_err(|error| nonsense(format!("frames.jsonl: {error}")))?;
    let mut tables = Tables::open(work)?;
    let ids = BodyIds::of_box(start.len() as u32);
    let (bodies, contacts, _) =
        tables.moment(&frame.moment, start, ids, [0.0; 2], "the timed bed")?;
    tables.at_end()?;
    Ok((bodies, contacts))
}
