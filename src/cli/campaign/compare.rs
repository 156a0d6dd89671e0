//! `crossgrain campaign compare`: two merged campaigns of one scene.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;

use crate::cli::{json, tell};
use crate::error::{Error, exit};
use crate::study::campaign::compare::{Comparison, Verdict, compare};
use crate::study::campaign::merged;
use evidence::Interval;
use evidence::equivalence::Finding;

#[derive(Debug, Args)]
pub struct Arguments {
    /// A merged campaign
    first: PathBuf,
    /// Another one
    second: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        let first = merged::read(&self.first)?;
        let second = merged::read(&self.second)?;
        let comparison = compare(&first, &second)?;
        tell(self.json, &json(&comparison)?, || in_words(&comparison))?;
        Ok(match comparison.verdict {
            Verdict::SameBits | Verdict::Equivalent => exit::AGREED,
            Verdict::Different => exit::CHECK_FAILED,
            Verdict::Undecided => exit::INCOMPLETE,
        })
    }
}

fn in_words(comparison: &Comparison) -> String {
    let Comparison { bits, .. } = comparison;
    let mut text = format!(
        "A: {} packings of {}\nB: {} packings of {}\n\nrealizations in both: {}; settled beds with the same bits: {}; \
         last moments with the same bits: {}\n",
        comparison.packings[0],
        comparison.engines[0],
        comparison.packings[1],
        comparison.engines[1],
        bits.common,
        bits.settled,
        bits.last
    );
    if let Some(missed) = comparison.missed {
        let _ = writeln!(
            text,
            "punches that missed the force, B − A: {:.3} ({:.3} to {:.3})",
            missed.estimate, missed.low, missed.high
        );
    }
    if !comparison.quantities.is_empty() {
        let _ = writeln!(
            text,
            "\n{:<46} {:>12} {:>12} {:>34} {:>10}  {:<12} p equal",
            "quantity", "A", "B", "B − A (95 %)", "margin", "finding"
        );
    }
    for of in &comparison.quantities {
        let Interval {
            estimate,
            low,
            high,
        } = of.unpaired.difference;
        let finding = match of.finding {
            Some(Finding::Equivalent) => "equivalent",
            Some(Finding::Different) => "different",
            Some(Finding::Undecided) => "undecided",
            None => "",
        };
        let _ = writeln!(
            text,
            "{:<46} {:>12} {:>12} {:>34} {:>10}  {:<12} {:.3}",
            format!("{} [{}]", of.title, of.unit),
            short(of.first[0]),
            short(of.second[0]),
            format!("{} ({} to {})", short(estimate), short(low), short(high)),
            of.margin.map(short).unwrap_or_default(),
            finding,
            of.distribution_p
        );
    }
    let verdict = match comparison.verdict {
        Verdict::SameBits => "SAME BITS",
        Verdict::Equivalent => "EQUIVALENT",
        Verdict::Different => "DIFFERENT",
        Verdict::Undecided => "UNDECIDED: more packings are needed for these margins",
    };
    let _ = writeln!(text, "{verdict}");
    text
}

/// Four digits.
fn short(value: f64) -> String {
    format!("{value:.4e}")
}
