//! Instructions a step, counted by valgrind's callgrind: a figure that does not depend on the machine's mood.
//!
//! Two runs of different length are counted, and their difference is what the steps take, without start and
//! reading. Valgrind shows programs a processor without AVX-512, so the counted code is the one for AVX2.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use serde::Serialize;

use super::{BenchError, one, program};
use crate::engine::native::Mode;
use crate::files::read_text;

/// Counted instructions.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Instructions {
    /// Which kernel.
    pub mode: Mode,
    /// Grains of the bed.
    pub grains: u32,
    /// Instructions a step.
    pub per_step: f64,
    /// Instructions a step and listed pair, where pairs were counted.
    pub per_listed_pair: f64,
    /// The vector unit that valgrind showed the program.
    pub vector_unit: String,
    /// Share of each function that has at least a hundredth, itself without what it calls; largest first.
    pub functions: Vec<(String, f64)>,
}

/// Steps of the two counted runs.
const STEPS: [u64; 2] = [80, 480];

/// Counts the instructions of steps of the bed in `folder`.
pub fn count(
    crossgrain: &Path,
    folder: &Path,
    grains: u32,
    listed_pairs: usize,
    mode: Mode,
    limit: Duration,
) -> Result<Instructions, BenchError> {
    let valgrind =
        program::on_path("valgrind").ok_or_else(|| program::missing("valgrind", "valgrind"))?;
    let counted = |steps: u64| -> Result<(Profile, one::One), BenchError> {
        let mut arguments = vec![
            "--tool=callgrind".to_owned(),
            "--callgrind-out-file=callgrind.out".to_owned(),
            crossgrain.display().to_string(),
        ];
        arguments.extend(one::arguments(folder, mode, steps));
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let log = program::run(&valgrind, &arguments, folder, limit)?;
        let profile = read_text(&folder.join("callgrind.out"), 1 << 26)?;
        Ok((Profile::parse(&profile), one::said(&log)?))
    };
    let (few, of_few) = counted(STEPS[0])?;
    let (many, of_many) = counted(STEPS[1])?;
    // Each run warms up by a quarter of its window.
    let steps = 1.25 * (of_many.window.steps as f64 - of_few.window.steps as f64);
    let more = |name: &str| {
        let of = |profile: &Profile| profile.functions.get(name).copied().unwrap_or(0) as f64;
        (of(&many) - of(&few)).max(0.0)
    };
    let total: f64 = many.functions.keys().map(|name| more(name)).sum();
    if !(total > 0.0 && steps > 0.0) {
        return Err(BenchError::Nonsense("callgrind counted nothing".to_owned()));
    }
    let mut functions: Vec<(String, f64)> = many
        .functions
        .keys()
        .map(|name| (name.clone(), more(name) / total))
        .filter(|(_, share)| *share >= 0.01)
        .collect();
    functions.sort_by(|a, b| b.1.total_cmp(&a.1));
    Ok(Instructions {
        mode,
        grains,
        per_step: total / steps,
        per_listed_pair: total / steps / listed_pairs as f64,
        vector_unit: of_many.vector_unit,
        functions,
    })
}

/// Instructions by function, from callgrind's file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Profile {
    /// Of each function itself, without what it calls.
    pub functions: BTreeMap<String, u64>,
}

impl Profile {
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
            } else if line.starts_with(|first: char| first.is_ascii_digit() || "+-*".contains(first))
            {
                let cost = line.split(' ').nth(1).and_then(|cost| cost.parse::<u64>().ok());
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
