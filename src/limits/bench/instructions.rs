//! Instructions a step, counted by valgrind's callgrind: a figure that does not depend on the machine's mood.
//!
//! Two runs of different length are counted, and their difference is what the steps take, without start and
//! reading. Valgrind 3.19 shows programs a processor without AVX-512, so the native code that is counted is the one for AVX2.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use serde::Serialize;

use super::contender::{self, ALL, Contender, Known};
use super::{Missed, Setup, nonsense, timing};
use crate::child::on_path;
use crate::engine::ProgramError;
use crate::engine::read::TimedSteps;
use crate::error::Error;
use crate::files::read_text;
use crate::progress::Task;

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Instructions {
    pub contender: Contender,
    pub name: String,
    pub per_step: f64,
    /// Instructions a step and pair that the native engine lists.
    pub per_listed_pair: f64,
    pub over_native: f64,
    /// Share of each function that has at least a hundredth, itself without what it calls; largest first.
    pub functions: Vec<(String, f64)>,
}

/// Steps of the two counted runs: the native engine's, and other engines', which take more.
const NATIVE_STEPS: [u64; 2] = [40, 240];
const OTHER_STEPS: [u64; 2] = [10, 30];

/// Counts each engine but YADE's sorted loop, which would take minutes; what cannot be counted is missed.
pub fn all(
    setup: &Setup<'_>,
    listed_pairs: usize,
    progress: &Task,
    missed: &mut Vec<Missed>,
) -> Result<Vec<Instructions>, Error> {
    let mut all: Vec<Instructions> = Vec::new();
    for (index, contender) in ALL.into_iter().enumerate() {
        let Known {
            id, name, native, ..
        } = contender.known();
        let counts = native || setup.plan.counts_others;
        let base = all.first().map(|base| base.per_step);
        // Without native there is nothing to hold it against.
        let lacks = base.is_none() && contender != Contender::Native;
        if !counts
            || lacks
            || matches!(
                contender,
                Contender::YadeSorted | Contender::YadeSortedFriction
            )
        {
            continue;
        }
        progress.share(index as f64 / ALL.len() as f64, name);
        match count(setup, contender) {
            Ok((per_step, functions)) => all.push(Instructions {
                contender,
                name: name.to_owned(),
                per_step,
                per_listed_pair: per_step / listed_pairs as f64,
                over_native: per_step / base.unwrap_or(per_step),
                functions,
            }),
            // The counter's failure is none of the engine's.
            Err(error) => missed.push(Missed {
                failed: false,
                ..Missed::of(
                    &format!("instructions/{id}"),
                    &format!("instructions of {name}"),
                    false,
                    error,
                )?
            }),
        }
    }
    Ok(all)
}

/// Instructions a step, and the functions that have most of them.
fn count(setup: &Setup<'_>, contender: Contender) -> Result<(f64, Vec<(String, f64)>), Error> {
    let valgrind = on_path("valgrind").ok_or_else(|| ProgramError::Missing {
        engine: "valgrind",
        reason: "there is no such program on the path".to_owned(),
        package: "valgrind",
    })?;
    let [few, many] = match contender.known().native {
        true => NATIVE_STEPS,
        false => OTHER_STEPS,
    };
    let (of_few, first) = profile(setup, &valgrind, contender, few)?;
    let (of_many, last) = profile(setup, &valgrind, contender, many)?;
    let steps = (last - first) as f64;
    let more = |(name, count): (&String, &u64)| {
        let before = of_few.get(name).copied().unwrap_or(0);
        (name.clone(), *count as f64 - before as f64)
    };
    let all = |of: &Profile| of.values().sum::<u64>() as f64;
    let total = all(&of_many) - all(&of_few);
    if !(total > 0.0 && steps > 0.0) {
        return Err(nonsense("callgrind counted nothing"));
    }
    let shares = of_many.iter().map(more);
    let shares = shares.map(|(name, count)| (name, count / total));
    let mut functions: Vec<(String, f64)> = shares.filter(|(_, share)| *share >= 0.01).collect();
    functions.sort_by(|a, b| b.1.total_cmp(&a.1));
    Ok((total / steps, functions))
}

/// The profile of a run of about `steps` steps, and how many there were.
fn profile(
    setup: &Setup<'_>,
    valgrind: &Path,
    contender: Contender,
    steps: u64,
) -> Result<(Profile, u64), Error> {
    let folder = timing::folder(setup.work, "counted")?;
    let out = folder.join("callgrind.out");
    let under = [
        "--tool=callgrind".to_owned(),
        format!("--callgrind-out-file={}", out.display()),
    ];
    let limit = setup.yade.limits.time;
    let done = if contender.known().native {
        timing::write_bed(setup.bed_of(contender), &folder)?;
        let mut command = Command::new(valgrind);
        let command = command.args(&under).arg(setup.crossgrain);
        let command = command.args(timing::arguments(&folder, steps, 1));
        timing::said(&timing::run(command, &folder, limit)?)?.steps
    } else {
        let mut options = setup.yade.clone();
        options.under = [&[valgrind.display().to_string()], &under[..]].concat();
        options.limits.stall = limit;
        let steps = TimedSteps {
            warm_up: 0,
            timed: steps,
            shares: 0,
            processes: 1,
        };
        let job = timing::folder(&folder, "timed")?;
        contender::timed(contender, setup.bed_of(contender), steps, &options, &job)?;
        steps.timed
    };
    Ok((parse(&read_text(&out, 1 << 28)?), done))
}

/// Instructions of each function itself, without what it calls.
type Profile = BTreeMap<String, u64>;

/// Reads callgrind's format (its manual, chapter "Callgrind Format Specification"): a cost line belongs to the last
/// `fn=`, the line after `calls=` is the callee's and not its own; names are written out once.
fn parse(text: &str) -> Profile {
    let mut profile = Profile::default();
    let mut names: BTreeMap<&str, &str> = BTreeMap::new();
    let mut current = "";
    let mut skip = false;
    for line in text.lines() {
        if let Some(function) = line.strip_prefix("fn=") {
            let (number, name) = function.split_once(' ').unwrap_or((function, ""));
            if !name.is_empty() {
                names.insert(number, name);
            }
            current = names.get(number).copied().unwrap_or(number);
        } else if let Some(function) = line.strip_prefix("cfn=") {
            if let Some((number, name)) = function.split_once(' ') {
                names.insert(number, name);
            }
        } else if line.starts_with("calls=") {
            skip = true;
        } else if line.starts_with(|first: char| first.is_ascii_digit() || "+-*".contains(first)) {
            let cost = line
                .split(' ')
                .nth(1)
                .and_then(|cost| cost.parse::<u64>().ok());
            if let Some(cost) = cost.filter(|_| !skip) {
                *profile.entry(current.to_owned()).or_default() += cost;
            }
            skip = false;
        }
    }
    profile
}

#[cfg(test)]
mod tests {
    use super::parse;

    #[test]
    fn costs_of_callees_are_not_the_callers() {
        let text = "events: Ir\nfl=(1) a.rs\nfn=(1) outer\n10 5\n+2 7\ncfn=(2) inner\ncalls=1 20\n\
                    * 100\n-1 1\nfn=(2)\n20 100\n\ntotals: 113\n";
        let functions = parse(text);
        assert_eq!(functions["outer"], 13);
        assert_eq!(functions["inner"], 100);
        assert_eq!(functions.len(), 2);
    }
}
