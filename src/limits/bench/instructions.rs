//! Instructions a step, counted by valgrind's callgrind: a figure that does not depend on the machine's mood.
//!
//! Two runs of different length are counted, and their difference is what the steps take, without start and
//! reading. Valgrind 3.19 shows programs a processor without AVX-512, so the native code that is counted is the one for AVX2.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use serde::Serialize;

use super::bed::Bed;
use super::contender::{self, Contender};
use super::{Missed, nonsense, timing};
use crate::child::on_path;
use crate::engine::read::TimedSteps;
use crate::engine::{ProgramError, yade};
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
    pub over_exact: f64,
    /// Share of each function that has at least a hundredth, itself without what it calls; largest first.
    pub functions: Vec<(String, f64)>,
}

/// Steps of the two counted runs: the native engine's, and other engines', which take more.
const NATIVE_STEPS: [u64; 2] = [40, 240];
const OTHER_STEPS: [u64; 2] = [10, 30];

/// What is counted on: a bed, this program, and how other engines are started.
#[derive(Debug, Clone, Copy)]
pub struct Counting<'a> {
    pub crossgrain: &'a Path,
    pub bed: &'a Bed,
    pub listed_pairs: usize,
    pub yade: &'a yade::Options,
    /// A folder for the processes.
    pub work: &'a Path,
}

impl Counting<'_> {
    /// Counts each of these engines; what cannot be counted is missed.
    pub fn all(
        &self,
        of: &[Contender],
        progress: &Task,
        missed: &mut Vec<Missed>,
    ) -> Result<Vec<Instructions>, Error> {
        let mut all: Vec<Instructions> = Vec::new();
        for (index, contender) in of.iter().enumerate() {
            progress.share(index as f64 / of.len() as f64, contender.name());
            let exact = all.first().map(|exact| exact.per_step);
            if exact.is_none() && *contender != Contender::Exact {
                // There is nothing to hold it against.
                continue;
            }
            match self.count(*contender) {
                Ok(mut counted) => {
                    let exact = exact.unwrap_or(counted.per_step);
                    counted.over_exact = counted.per_step / exact;
                    all.push(counted);
                }
                Err(error) => {
                    let id = format!("instructions/{}", contender.id());
                    let what = format!("instructions of {}", contender.name());
                    // The counter's failure is none of the engine's.
                    missed.push(Missed {
                        failed: false,
                        ..Missed::of(&id, &what, false, error)?
                    });
                }
            }
        }
        Ok(all)
    }

    fn count(&self, contender: Contender) -> Result<Instructions, Error> {
        let valgrind = on_path("valgrind").ok_or_else(|| ProgramError::Missing {
            engine: "valgrind",
            reason: "there is no such program on the path".to_owned(),
            package: "valgrind",
        })?;
        let [few, many] = match contender.mode() {
            Some(_) => NATIVE_STEPS,
            None => OTHER_STEPS,
        };
        let (of_few, first) = self.profile(&valgrind, contender, few)?;
        let (of_many, last) = self.profile(&valgrind, contender, many)?;
        let steps = (last - first) as f64;
        let more = |name: &str| {
            let of = |profile: &Profile| profile.functions.get(name).copied().unwrap_or(0) as f64;
            of(&of_many) - of(&of_few)
        };
        let total = of_many.total() as f64 - of_few.total() as f64;
        if !(total > 0.0 && steps > 0.0) {
            return Err(nonsense("callgrind counted nothing"));
        }
        let names = of_many.functions.keys();
        let mut functions: Vec<(String, f64)> = names
            .map(|name| (name.clone(), more(name) / total))
            .filter(|(_, share)| *share >= 0.01)
            .collect();
        functions.sort_by(|a, b| b.1.total_cmp(&a.1));
        Ok(Instructions {
            contender,
            name: contender.name().to_owned(),
            per_step: total / steps,
            per_listed_pair: total / steps / self.listed_pairs as f64,
            over_exact: 1.0,
            functions,
        })
    }

    /// The profile of a run of about `steps` steps, and how many there were.
    fn profile(
        &self,
        valgrind: &Path,
        contender: Contender,
        steps: u64,
    ) -> Result<(Profile, u64), Error> {
        let folder = timing::folder(self.work, "counted")?;
        let out = folder.join("callgrind.out");
        let under = [
            "--tool=callgrind".to_owned(),
            format!("--callgrind-out-file={}", out.display()),
        ];
        let limit = self.yade.limits.time;
        let done = match contender {
            Contender::Exact | Contender::Free | Contender::Single => {
                timing::write_bed(self.bed, &folder)?;
                let mode = contender.mode().unwrap_or_default();
                let mut command = Command::new(valgrind);
                let command = command.args(&under).arg(self.crossgrain);
                let command = command.args(timing::arguments(&folder, mode, steps));
                timing::said(&timing::run(command, &folder, limit)?)?.steps
            }
            // Its start would be counted, and whatever starts it.
            Contender::External => {
                let why = "instructions of an external engine are not counted";
                return Err(ProgramError::Refused(why.to_owned()).into());
            }
            Contender::YadeOrdinary
            | Contender::YadeSorted
            | Contender::Lammps
            | Contender::Liggghts => {
                let mut options = self.yade.clone();
                options.under = [&[valgrind.display().to_string()], &under[..]].concat();
                options.limits.stall = limit;
                let steps = TimedSteps {
                    warm_up: 0,
                    timed: steps,
                    shares: 0,
                };
                let job = timing::folder(&folder, "timed")?;
                contender::timed(contender, self.bed, steps, &options, &job)?;
                steps.timed
            }
        };
        Ok((Profile::parse(&read_text(&out, 1 << 28)?), done))
    }
}

/// Instructions by function, from callgrind's file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Profile {
    /// Of each function itself, without what it calls.
    pub functions: BTreeMap<String, u64>,
}

impl Profile {
    pub fn total(&self) -> u64 {
        self.functions.values().sum()
    }

    /// Reads callgrind's format (its manual, chapter "Callgrind Format Specification"): a cost line belongs to the last
    /// `fn=`, the line after `calls=` is the callee's and not its own; names are written out once.
    pub fn parse(text: &str) -> Self {
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
            } else if line
                .starts_with(|first: char| first.is_ascii_digit() || "+-*".contains(first))
            {
                let cost = line
                    .split(' ')
                    .nth(1)
                    .and_then(|cost| cost.parse::<u64>().ok());
                if let Some(cost) = cost.filter(|_| !skip) {
                    *profile.functions.entry(current.to_owned()).or_default() += cost;
                }
                skip = false;
            }
        }
        profile
    }
}

#[cfg(test)]
mod tests {
    use super::Profile;

    #[test]
    fn costs_of_callees_are_not_the_callers() {
        let text = "events: Ir\nfl=(1) a.rs\nfn=(1) outer\n10 5\n+2 7\ncfn=(2) inner\ncalls=1 20\n\
                    * 100\n-1 1\nfn=(2)\n20 100\n\ntotals: 113\n";
        let functions = Profile::parse(text).functions;
        assert_eq!(functions["outer"], 13);
        assert_eq!(functions["inner"], 100);
        assert_eq!(functions.len(), 2);
    }
}
