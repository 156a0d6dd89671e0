//! `crossgrain study claims` and `study figures`: what the paper says and draws, from a campaign's members.

use std::path::PathBuf;

use clap::Args;

use crate::checks::Outcome;
use crate::cli::job_folder::{Results, page_line};
use crate::cli::report::Views;
use crate::cli::{json, print};
use crate::document::{Document, Section};
use crate::error::{Error, exit};
use crate::progress::say;
use crate::report::disc_field::of_figure_4;
use crate::report::fields::bulbs;
use crate::report::html::FOLDER;
use crate::report::packing::force_chains;
use crate::report::page;
use crate::study::StudyError;
use crate::study::campaign::{Merged, merged};
use crate::study::claims::{self, Origin};
use crate::study::figures::{Distribution, distributions, loaded_bed, setup_of, sharings};
use crate::workers::unless_asked_to_end;
use grains::scene::paper_scene;

#[derive(Debug, Args)]
#[command(
    after_help = "Exit code 0: every claim has a verdict, whichever; 3: the campaign is too small for a claim.\n\nExamples:\n  \
    crossgrain study claims thousand\n  crossgrain study claims thousand --beside best --out claims"
)]
pub struct Claims {
    /// The folder of a merged campaign
    folder: PathBuf,
    /// That of another scene, to stand beside it claim by claim
    #[arg(long, value_name = "FOLDER")]
    beside: Option<PathBuf>,
    #[command(flatten)]
    results: Results,
    #[command(flatten)]
    views: Views,
}

/// The file of the record.
const CLAIMS: &str = "claims.json";

impl Claims {
    pub fn execute(self) -> Result<u8, Error> {
        self.results.check(CLAIMS)?;
        let read = |folder: &PathBuf| {
            let of = merged(folder)?;
            let origin = Origin {
                command: format!("crossgrain study claims {}", folder.display()),
                engine: of.summary.engine.clone(),
                plan: of.summary.plan.clone(),
                members_digest: of.summary.sha256.clone(),
            };
            Ok::<_, StudyError>((of, origin))
        };
        let here = read(&self.folder)?;
        let other = self.beside.as_ref().map(read).transpose()?;
        say("Holding the members against the claims and the laws; a thousand take about a minute.");
        let judged =
            |(of, origin): (Merged, Origin)| claims::of(&of.plan.study.scene, &of.rows, origin);
        let found = unless_asked_to_end(move || (judged(here), other.map(judged)));
        let (mut found, other) = found.ok_or(Error::Interrupted)?;
        found.beside = other.map(Into::into);
        let (text, document) = (json(&found)?, found.document());
        self.views.tell("study claims", &text, &document)?;
        self.results.write(&document, &[(CLAIMS, &text)])?;
        Ok(document.verdict.exit_code())
    }
}

#[derive(Debug, Args)]
#[command(
    after_help = "Writes a page and each figure as SVG and CSV; files of the same names in --out are replaced.\n\n\
    Examples:\n  crossgrain study figures\n  crossgrain study figures --campaign thousand --out figures"
)]
pub struct Figures {
    /// A merged campaign: its members give Figure 5, the scene of its first one the others
    #[arg(long)]
    campaign: Option<PathBuf>,
    /// The folder to write
    #[arg(long, default_value = "out/figures")]
    out: PathBuf,
}

impl Figures {
    pub fn execute(self) -> Result<u8, Error> {
        // Before anything is run or written.
        let campaign = self.campaign.as_deref().map(merged).transpose()?;
        let scene = match &campaign {
            Some(campaign) => {
                let mut scene = campaign.plan.study.scene.clone();
                scene.realization = campaign.plan.study.realization(1);
                scene
            }
            None => paper_scene(1, 5000),
        };
        // First, as it runs nothing and may have nothing to draw.
        let fifth = match &campaign {
            Some(campaign) => {
                let all = distributions(campaign)?;
                let plots = all.iter().flat_map(Distribution::plots);
                plots.fold(
                    Section::new("Figure 5", "Distributions at O, A and B."),
                    Section::with,
                )
            }
            None => Section::new(
                "Figure 5",
                "It is of a campaign's members: name one with --campaign.",
            ),
        };
        let chains = force_chains(&loaded_bed(&scene)?)?;
        let (table, shares) = sharings();
        let disc = Section {
            title: "Figure 4".to_owned(),
            answer: "Inside a grain.".to_owned(),
            ..of_figure_4()?
        };
        let document = Document {
            title: "The paper's figures from our own numbers".to_owned(),
            verdict: Outcome::Pass,
            answer: format!("Drawn for the scene {}.", scene.name),
            sections: vec![
                Section::new("Figure 1", "The continuum.").with(bulbs(&setup_of(&scene))),
                Section::new("Figure 2", "The forces between the grains.").with(chains),
                Section::new("Figure 3 and Table 1", "Five piles.")
                    .with(table)
                    .with(shares),
                disc,
                fifth,
            ],
            checks: Vec::new(),
        };
        let out = self.out;
        let page = page(&document);
        page.write(&out)?;
        let files: Vec<&str> = page.files.iter().map(|(name, _)| name.as_str()).collect();
        print(&format!(
            "SVG and CSV in {}: {}\n{}",
            out.join(FOLDER).display(),
            files.join(" "),
            page_line(&out)
        ))?;
        Ok(exit::AGREED)
    }
}
