//! `crossgrain scene`: print, check, model, schema.

use std::path::PathBuf;

use clap::Subcommand;

use super::{json, print};
use crate::error::{Error, exit};
use crate::run::folder::read_scene;
use crate::study::realization::free_mode_scene;
use grains::model::Model;
use grains::scene::{json_schema, paper_scene};

#[derive(Debug, Subcommand)]
#[command(
    after_help = "Examples:\n  crossgrain scene paper > scene.json\n  crossgrain scene paper --seed 2 --particles 1000 > small.json\n  \
    crossgrain scene check scene.json\n  crossgrain scene model scene.json\n  crossgrain scene schema > scene.schema.json"
)]
pub enum Verb {
    /// Print the paper's scene as JSON: complete, no default left implicit
    #[command(after_help = "Example:\n  crossgrain scene paper > scene.json")]
    Paper {
        /// Realization number
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Number of grains
        #[arg(long, default_value_t = 5000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
        particles: u32,
        /// With the choices that are the default of `run --mode free`: a longer step, tested to be equivalent
        #[arg(long)]
        free: bool,
    },
    /// Validate a scene file: every problem at once, each with its place and what would be right
    #[command(after_help = "Example:\n  crossgrain scene check scene.json")]
    Check {
        /// The scene
        file: PathBuf,
    },
    /// Print what engines are given: gravity, walls, contact law and time step as numbers
    #[command(after_help = "Example:\n  crossgrain scene model scene.json")]
    Model {
        /// The scene
        file: PathBuf,
    },
    /// The parameters that each engine uses for a scene: stiffness, mass, damping, time step
    Parameters(super::parameters::Arguments),
    /// Print the JSON Schema of scene files
    #[command(after_help = "Example:\n  crossgrain scene schema > scene.schema.json")]
    Schema,
}

impl Verb {
    pub fn execute(self) -> Result<u8, Error> {
        match self {
            Verb::Paper {
                seed,
                particles,
                free,
            } => {
                let scene = if free { free_mode_scene } else { paper_scene };
                print(&json(&scene(seed, particles))?)?;
            }
            Verb::Check { file } => {
                let scene = read_scene(&file)?;
                print(&format!(
                    "{}: a valid scene, digest {}\n",
                    file.display(),
                    scene.digest()
                ))?;
            }
            Verb::Model { file } => print(&json(&Model::of(&read_scene(&file)?))?)?,
            Verb::Parameters(arguments) => return arguments.execute(),
            Verb::Schema => print(&json(&json_schema())?)?,
        }
        Ok(exit::AGREED)
    }
}
