//! `crossgrain claims`: the paper's claims against a campaign's members.

use std::path::PathBuf;

use clap::Args;

use super::job_folder::write_new;
use super::{exit_code_if, json, tell};
use crate::error::Error;
use crate::files::refuse_existing;
use crate::report;
use crate::study::campaign::merged;
use crate::study::claims::claim::Verdict;
use crate::study::claims::{self, Claims, Origin};

#[derive(Debug, Args)]
#[command(
    after_help = "Exit code 0: every claim has a verdict, whichever; 3: the campaign is too small for a claim.\n\nExamples:\n  \
    crossgrain claims thousand\n  crossgrain claims thousand --out claims"
)]
pub struct Arguments {
    /// The folder of a merged campaign
    folder: PathBuf,
    /// A new folder for claims.json and report.html
    #[arg(long)]
    out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        if let Some(out) = &self.out {
            refuse_existing(out)?;
        }
        let merged = merged::read(&self.folder)?;
        let origin = Origin {
            command: "crossgrain claims".to_owned(),
            engine: merged.summary.engine.clone(),
            plan: merged.summary.plan.clone(),
            members_digest: merged.summary.sha256.clone(),
        };
        let found = claims::of(&merged.plan.scene, &merged.members, origin);
        let text = json(&found)?;
        if let Some(out) = &self.out {
            let page = report::claims::page(&found)?;
            write_new(out, "claims.json", &text, &page)?;
        }
        tell(self.json, &text, || in_words(&found))?;
        Ok(exit_code_if(found.complete))
    }
}

/// The claims as lines for a terminal.
fn in_words(found: &Claims) -> String {
    let endings: Vec<String> = found
        .endings
        .iter()
        .map(|(how, count)| format!("{count} {how}"))
        .collect();
    let mut text = format!(
        "{} members of {}: {}\n",
        found.members,
        found.origin.engine,
        endings.join(", ")
    );
    for [key, default, here] in &found.other_choices {
        text += &format!("  {key} is {here} instead of {default}\n");
    }
    for claim in &found.claims {
        let verdict = claim
            .verdict
            .map_or("open: too few members", Verdict::words);
        text += &format!("\n{:<20} {verdict}  [{}]\n", claim.id, claim.place);
        if let Some(row) = claim.rows.iter().find(|row| row.judged.is_some()) {
            let published = row.published.map_or("–".to_owned(), report::claims::short);
            text += &format!(
                "{:>4}{}: published {published}, ours {}, {} packings\n",
                "",
                row.what,
                report::claims::interval(row.ours, &row.unit),
                row.packings
            );
        }
        text += &format!("{:>4}{}\n", "", claim.reading);
    }
    let verdicts: Vec<String> = found
        .verdicts
        .iter()
        .map(|(verdict, count)| format!("{verdict}: {count}"))
        .collect();
    text + &format!("\n{}\n", verdicts.join(", "))
}
