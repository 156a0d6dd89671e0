//! `crossgrain figures`: the paper's figures from our own numbers.

use std::path::{Path, PathBuf};

use clap::Args;

use super::print;
use crate::error::{Error, exit};
use crate::files::{failed, free_folder};
use crate::paper::disc_field::figure_4;
use crate::report::figure_files::{SCALE, figure_files};
use crate::report::figures::{bulbs, chains, distributions, inside_a_grain, sharings};
use crate::study::campaign::merged;
use crate::study::figures::{loaded_bed, samples, setup_of};
use crate::study::realization::Runner;
use grains::native::Mode;
use grains::scene::paper_scene;

/// The folder that is used when none is named; a number is added when it exists.
const DEFAULT_OUT: &str = "out/figures";

#[derive(Debug, Args)]
#[command(
    after_help = "Each figure is written as SVG, PNG and CSV; files of the same names in --out are replaced.\n\n\
    Examples:\n  crossgrain figures\n  crossgrain figures --campaign thousand --out figures"
)]
pub struct Arguments {
    /// A merged campaign: its members give Figure 5, the scene of its first one the others
    #[arg(long)]
    campaign: Option<PathBuf>,
    /// The folder to write
    #[arg(long)]
    out: Option<PathBuf>,
    /// Pixels of PNG for a unit of SVG
    #[arg(long, default_value_t = SCALE)]
    scale: f32,
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        if !(0.1..=10.0).contains(&self.scale) {
            return Err(Error::Usage(format!(
                "--scale is {}, and must be from 0.1 to 10",
                self.scale
            )));
        }
        // Before anything is run or written.
        let campaign = self.campaign.as_deref().map(merged::read).transpose()?;
        let scene = match &campaign {
            Some(campaign) => {
                let mut scene = campaign.plan.scene.clone();
                scene.realization = campaign.plan.realization(1);
                scene
            }
            None => paper_scene(1, 5000),
        };
        // First, as it runs nothing and may have nothing to draw.
        let fifth = match &campaign {
            Some(campaign) => Some(distributions(&samples(campaign)?)?),
            None => None,
        };
        let mut figures = vec![
            bulbs::figure(&setup_of(&scene))?,
            chains::figure(&loaded_bed(&scene, Runner::Native(Mode::Exact))?)?,
            sharings::figure()?,
            inside_a_grain(&figure_4().map_err(|error| Error::Report(error.to_string()))?)?,
        ];
        let has_all = fifth.is_some();
        figures.extend(fifth);
        let out = self
            .out
            .unwrap_or_else(|| free_folder(Path::new(DEFAULT_OUT), "figure-1.svg"));
        std::fs::create_dir_all(&out).map_err(failed("create", &out))?;
        let mut text = String::new();
        for figure in &figures {
            figure_files(&out, &figure.name, &figure.svg, &figure.csv, self.scale)?;
            text += &format!("{}: {}\n", figure.name, figure.caption);
        }
        if !has_all {
            text += "figure-5 is of a campaign's members: name one with --campaign\n";
        }
        print(&format!(
            "{text}SVG, PNG and CSV of each in {}\n",
            out.display()
        ))?;
        Ok(exit::AGREED)
    }
}
