//! `crossgrain scene`: print, check, model, the parameters that engines use, schema.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Subcommand};

use super::engine::{Several, several};
use super::run::YadeLimits;
use super::{json, print, tell};
use crate::checks::Outcome;
use crate::document::Table;
use crate::engine::named::Named;
use crate::error::{Error, exit};
use crate::files::work_folder;
use crate::run::folder::read_scene;
use crate::study::realization::fast_scene;
use crate::suite::parameters::{self, Parameter, ParameterPair};
use grains::model::Model;
use grains::scene::{Scene, json_schema, paper_scene};
use grains::tables::Stage;

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
        /// The fast protocol's: a longer step, which with `run --reduced-stiffness` was tested to be equivalent
        #[arg(long)]
        fast: bool,
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
        /// Under the punch, where the scene may have constants of its own, instead of while pouring
        #[arg(long)]
        loading: bool,
    },
    /// The parameters that each engine uses for a scene: stiffness, mass, damping, time step
    Parameters(Parameters),
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
                fast,
            } => {
                let scene = if fast { fast_scene } else { paper_scene };
                print(&json(&scene(seed, particles))?)?;
            }
            Verb::Check { file } => {
                let scene = read_scene(&file)?;
                let (file, digest) = (file.display(), scene.digest());
                print(&format!("{file}: a valid scene, digest {digest}\n"))?;
            }
            Verb::Model { file, loading } => {
                let stage = if loading { Stage::Load } else { Stage::Settle };
                print(&json(&Model::in_stage(&read_scene(&file)?, stage))?)?;
            }
            Verb::Parameters(arguments) => return arguments.execute(),
            Verb::Schema => print(&json(&json_schema())?)?,
        }
        Ok(exit::AGREED)
    }
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  crossgrain scene parameters scene.json --engine yade\n  crossgrain scene parameters scene.json --engine both"
)]
pub struct Parameters {
    /// A scene file
    scene: PathBuf,
    /// Which engine is asked; both must be equal to 1e-14
    #[arg(long, value_parser = names())]
    engine: Several,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    limits: YadeLimits,
}

const ASKED: &str = "Parameters, asked of ten grains that touch each other, a wall and the punch";

/// Of the engines of this program.
fn names() -> impl TypedValueParser<Value = Several> {
    PossibleValuesParser::new(["native", "yade", "both"]).try_map(|text| several(&text))
}

impl Parameters {
    fn execute(self) -> Result<u8, Error> {
        let scene = read_scene(&self.scene)?;
        match &self.engine[..] {
            [Named::Native] => self.show(&parameters::of_native(&scene)?),
            [_] => self.show(&self.of_yade(&scene)?),
            _ => {
                let native = parameters::of_native(&scene)?;
                self.compare(&parameters::side_by_side(native, &self.of_yade(&scene)?))
            }
        }
    }

    fn of_yade(&self, scene: &Scene) -> Result<Vec<Parameter>, Error> {
        let (work, options) = (work_folder()?, self.limits.options());
        Ok(parameters::of_yade(scene, &options, work.path())?)
    }

    fn show(&self, parameters: &[Parameter]) -> Result<u8, Error> {
        let table = Table::of("parameters", ASKED, parameters)
            .column("of", |parameter| &parameter.bodies)
            .column("symbol", |parameter| parameter.symbol)
            .column("value", |parameter| digits(parameter.value))
            .column("unit", |parameter| parameter.unit);
        tell(self.json, &json(&parameters)?, || Table::from(table).text())?;
        Ok(exit::AGREED)
    }

    fn compare(&self, pairs: &[ParameterPair]) -> Result<u8, Error> {
        let table = Table::of("parameters", ASKED, pairs)
            .column("of", |pair| &pair.native.bodies)
            .column("symbol", |pair| pair.native.symbol)
            .column("native", |pair| digits(pair.native.value))
            .column("YADE", |pair| pair.yade.map(digits))
            .column("difference", |pair| pair.difference)
            .column("unit", |pair| pair.native.unit)
            .column("", |pair| if pair.agrees() { "" } else { "DIFFERENT" });
        tell(self.json, &json(&pairs)?, || Table::from(table).text())?;
        Ok(Outcome::pass_if(pairs.iter().all(ParameterPair::agrees)).exit_code())
    }
}

/// All of them: two numbers that differ in the last are different.
fn digits(value: f64) -> String {
    format!("{value:?}")
}
