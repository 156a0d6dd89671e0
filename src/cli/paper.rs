//! `crossgrain paper`: the published numbers that need no simulation.

use clap::Args;
use serde::Serialize;

use super::{json, print};
use crate::error::{Error, exit};
use crate::paper::{Finding, Number, TextFault, numbers, short, text_faults};

#[derive(Debug, Args)]
#[command(
    after_help = "What the paper misprints is a finding, not a failure: the exit code is 0.\n\nExamples:\n  crossgrain paper\n  crossgrain paper --json"
)]
pub struct Arguments {
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Output {
    numbers: Vec<Number>,
    text_faults: Vec<TextFault>,
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        let output = Output {
            numbers: numbers(),
            text_faults: text_faults(),
        };
        print(&if self.json {
            json(&output)?
        } else {
            in_words(&output)
        })?;
        // What does not come out is a finding about the paper, not a failure of the program.
        Ok(exit::AGREED)
    }
}

fn in_words(output: &Output) -> String {
    let mut text = format!(
        "{:<9} {:<19} {:<52} {:>11} {:>13} {:<10}  {}\n",
        "verdict", "place", "what", "published", "recomputed", "unit", "how"
    );
    for number in &output.numbers {
        text += &format!(
            "{:<9} {:<19} {:<52} {:>11} {:>13} {:<10}  {}\n",
            finding(number.finding),
            number.place,
            number.what,
            short(number.published),
            short(number.recomputed),
            number.unit,
            number.how
        );
        if !number.remark.is_empty() {
            text += &format!("{:>10}{}\n", "", number.remark);
        }
    }
    text += "\nfaults of the printed text\n";
    for fault in &output.text_faults {
        text += &format!(
            "{}: prints «{}», should be «{}»\n{:>10}{}\n",
            fault.place, fault.printed, fault.should_be, "", fault.evidence
        );
    }
    let count = |of: Finding| output.numbers.iter().filter(|n| n.finding == of).count();
    text + &format!(
        "\n{} numbers: {} agree, {} differ, {} misprinted, {} derived\n",
        output.numbers.len(),
        count(Finding::Agrees),
        count(Finding::Differs),
        count(Finding::Misprint),
        count(Finding::Derived)
    )
}

/// A verdict in one word.
fn finding(finding: Finding) -> &'static str {
    match finding {
        Finding::Agrees => "agrees",
        Finding::Differs => "DIFFERS",
        Finding::Misprint => "MISPRINT",
        Finding::Derived => "derived",
    }
}
