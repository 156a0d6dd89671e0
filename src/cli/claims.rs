//! `crossgrain claims`: the paper's claims against a campaign's members.

use std::path::PathBuf;

use clap::Args;

use super::{json, tell};
use crate::error::Error;
use crate::files::{refuse_existing, write_folder, write_whole};
use crate::report::{page, terminal};
use crate::study::campaign::merged;
use crate::study::claims::{self, Origin};

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
        let merged = merged(&self.folder)?;
        let origin = Origin {
            command: "crossgrain claims".to_owned(),
            engine: merged.summary.engine.clone(),
            plan: merged.summary.plan.clone(),
            members_digest: merged.summary.sha256.clone(),
        };
        let found = claims::of(&merged.plan.study.scene, &merged.rows, origin);
        let (text, document) = (json(&found)?, found.document());
        if let Some(out) = &self.out {
            write_folder::<Error>(out, |aside| {
                page(&document).write(aside)?;
                Ok(write_whole(&aside.join("claims.json"), text.as_bytes())?)
            })?;
        }
        tell(self.json, &text, || terminal(&document))?;
        Ok(document.verdict.exit_code())
    }
}
