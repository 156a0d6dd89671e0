//! Verification cases in YADE: all of them in one process, in sorted mode.

use std::path::Path;

use serde::Deserialize;

use super::binary::{MomentLine, Tables, index};
use super::{Options, YadeError, child, find, job, nonsense, unsupported};
use crate::files::read_text;
use grains::case::{Case, Effective, Load};
use grains::tables::{BodyIds, Snapshot, Stage};
use grains::task::Observer;

/// What YADE made of all cases.
#[derive(Debug, Clone, PartialEq)]
pub struct CasesInYade {
    /// As YADE prints it.
    pub version: String,
    /// In the order of the cases.
    pub cases: Vec<CaseInYade>,
}

/// What YADE made of one case.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseInYade {
    /// The parameters that YADE says it uses.
    pub effective: Effective,
    /// The state at each moment of the case.
    pub track: Vec<Snapshot>,
    /// Force and torque summed on each grain at each moment; empty for large cases.
    pub loads: Vec<Vec<Load>>,
}

#[derive(Deserialize)]
struct CaseLine {
    case: usize,
    step: u64,
    #[serde(default)]
    loads: Option<Vec<Load>>,
    #[serde(flatten)]
    moment: MomentLine,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EffectiveLine {
    effective: usize,
    parameters: Effective,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DoneFile {
    steps_by_yade: u64,
}

/// Runs the cases, in order; `work` is an empty folder.
pub fn run_cases(
    cases: &[&Case],
    options: &Options,
    work: &Path,
    observer: &mut dyn Observer,
) -> Result<CasesInYade, YadeError> {
    if let Some(reason) = cases.iter().find_map(|case| unsupported(&case.model)) {
        return Err(YadeError::Unsupported(reason));
    }
    let installation = find(options.program.as_deref())?;
    job::write_cases(work, cases)?;
    let finished = child::run(&installation, job::RUN_CASES.0, work, options, observer)?;
    Ok(CasesInYade {
        version: finished.version,
        cases: read(work, cases)?,
    })
}

/// Reads what YADE made of each case.
pub fn read(work: &Path, cases: &[&Case]) -> Result<Vec<CaseInYade>, YadeError> {
    let index = index(work)?;
    let mut lines = index.lines();
    let mut tables = Tables::open(work)?;
    let mut next = |what: &str| {
        let ended = || nonsense(format!("frames.jsonl ends before {what}"));
        lines.next().ok_or_else(ended)
    };
    let mut all = Vec::with_capacity(cases.len());
    for (index, case) in cases.iter().enumerate() {
        let line: EffectiveLine = parse(next(&case.name)?)?;
        if line.effective != index {
            return Err(nonsense(format!("case {index} is not where it should be")));
        }
        let mut track = Vec::with_capacity(case.moments.len());
        let mut loads = Vec::new();
        for &step in &case.moments {
            let line: CaseLine = parse(next(&case.name)?)?;
            if (line.case, line.step) != (index, step) {
                return Err(nonsense(format!(
                    "{}: step {} where step {step} should be",
                    case.name, line.step
                )));
            }
            track.push(snapshot(&mut tables, &line, case)?);
            loads.extend(loads_of(line.loads, case)?);
        }
        all.push(CaseInYade {
            effective: line.parameters,
            track,
            loads,
        });
    }
    tables.at_end()?;
    check_count(work, cases)?;
    Ok(all)
}

/// The loads of a moment, which a small case must have for every grain.
fn loads_of(loads: Option<Vec<Load>>, case: &Case) -> Result<Option<Vec<Load>>, YadeError> {
    let wanted = case.bodies.len() <= job::MOST_LOADED;
    match &loads {
        None if !wanted => Ok(None),
        Some(rows) if wanted && rows.len() == case.bodies.len() => Ok(loads),
        _ => Err(nonsense(format!("{}: loads of other grains", case.name))),
    }
}

fn parse<'a, T: Deserialize<'a>>(line: &'a str) -> Result<T, YadeError> {
    serde_json::from_str(line).map_err(|error| nonsense(format!("frames.jsonl: {error}")))
}

fn snapshot(tables: &mut Tables, line: &CaseLine, case: &Case) -> Result<Snapshot, YadeError> {
    let at = format!("{} step {}", case.name, line.step);
    let ids = BodyIds {
        grains: case.bodies.len() as u32,
        walls: case.model.walls.len() as u32,
    };
    let half_extents = case.punch.map_or([0.0; 2], |punch| punch.half_extents);
    let (bodies, contacts, punch) =
        tables.moment(&line.moment, &case.bodies, ids, half_extents, &at)?;
    Ok(Snapshot {
        stage: Stage::Settle,
        step: line.step,
        time: line.step as f64 * case.model.dt,
        bodies,
        contacts,
        punch,
    })
}

fn check_count(work: &Path, cases: &[&Case]) -> Result<(), YadeError> {
    let text =
        read_text(&work.join("done.json"), 1 << 16).map_err(|error| nonsense(error.to_string()))?;
    let done: DoneFile = parse(&text)?;
    let steps: u64 = cases.iter().filter_map(|case| case.moments.last()).sum();
    if done.steps_by_yade == steps {
        return Ok(());
    }
    Err(nonsense(format!(
        "YADE counts {} steps, its cases {steps}",
        done.steps_by_yade
    )))
}
