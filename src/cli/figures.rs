//! `crossgrain figures`: the paper's figures from our own numbers.

use std::path::{Path, PathBuf};

use clap::Args;

use super::print;
use crate::checks::Outcome;
use crate::document::{Document, Section};
use crate::error::{Error, exit};
use crate::files::free_folder;
use crate::paper::disc_field::figure_4;
use crate::report::disc_field::inside_a_disc;
use crate::report::fields::bulbs;
use crate::report::packing::force_chains;
use crate::report::page;
use crate::study::campaign::merged;
use crate::study::distribution::Distribution;
use crate::study::figures::{distributions, loaded_bed, setup_of, sharings};
use crate::study::realization::Runner;
use grains::native::Mode;
use grains::scene::paper_scene;

/// The folder that is used when none is named; a number is added when it exists.
const DEFAULT_OUT: &str = "out/figures";

#[derive(Debug, Args)]
#[command(
    after_help = "Writes a page and each figure as SVG and CSV; files of the same names in --out are replaced.\n\n\
    Examples:\n  crossgrain figures\n  crossgrain figures --campaign thousand --out figures"
)]
pub struct Arguments {
    /// A merged campaign: its members give Figure 5, the scene of its first one the others
    #[arg(long)]
    campaign: Option<PathBuf>,
    /// The folder to write
    #[arg(long)]
    out: Option<PathBuf>,
}

impl Arguments {
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
        let chains = force_chains(&loaded_bed(&scene, Runner::Native(Mode::Exact))?)?;
        let disc = figure_4().map_err(|error| Error::Report(error.to_string()))?;
        let (table, shares) = sharings();
        let (map, profiles) = inside_a_disc("figure-4", &disc);
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
                Section::new("Figure 4", "Inside a grain.")
                    .with(map)
                    .with(profiles),
                fifth,
            ],
            checks: Vec::new(),
        };
        let out = self
            .out
            .unwrap_or_else(|| free_folder(Path::new(DEFAULT_OUT), "report.html"));
        let page = page(&document);
        page.write(&out)?;
        let files: Vec<&str> = page.files.iter().map(|(name, _)| name.as_str()).collect();
        print(&format!(
            "{}\nreport.html, and SVG and CSV in figures: {}\n",
            out.display(),
            files.join(" ")
        ))?;
        Ok(exit::AGREED)
    }
}
