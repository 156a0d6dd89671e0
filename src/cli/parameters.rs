//! `crossgrain scene parameters`: the parameters that each engine uses for a scene.

use std::path::PathBuf;

use clap::Args;

use super::run::YadeLimits;
use super::{json, print};
use crate::document::Table;
use crate::error::{Error, exit};
use crate::files::work_folder;
use crate::run::folder::read_scene;
use crate::suite::parameters::{self, Parameter, ParameterPair};
use crate::suite::run::Engines;
use grains::scene::Scene;

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  crossgrain scene parameters scene.json --engine yade\n  crossgrain scene parameters scene.json --engine both"
)]
pub struct Arguments {
    /// A scene file
    scene: PathBuf,
    /// Which engine is asked; both must be equal to 1e-14
    #[arg(long, value_enum)]
    engine: Engines,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    limits: YadeLimits,
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        let scene = read_scene(&self.scene)?;
        match self.engine {
            Engines::Native => self.show(&parameters::of_native(&scene)?),
            Engines::Yade => self.show(&self.of_yade(&scene)?),
            Engines::Both => {
                let native = parameters::of_native(&scene)?;
                self.compare(&parameters::side_by_side(native, &self.of_yade(&scene)?))
            }
        }
    }

    fn of_yade(&self, scene: &Scene) -> Result<Vec<Parameter>, Error> {
        let work = work_folder()?;
        Ok(parameters::of_yade(
            scene,
            &self.limits.options(),
            work.path(),
        )?)
    }

    fn show(&self, parameters: &[Parameter]) -> Result<u8, Error> {
        let table = Table::of("parameters", "Parameters", parameters)
            .column("of", |of| &of.of)
            .column("symbol", |of| of.symbol)
            .column("value", |of| digits(of.value))
            .column("unit", |of| of.unit);
        print(&if self.json {
            json(&parameters)?
        } else {
            Table::from(table).text()
        })?;
        Ok(exit::AGREED)
    }

    fn compare(&self, pairs: &[ParameterPair]) -> Result<u8, Error> {
        let table = Table::of("parameters", "Parameters in both engines", pairs)
            .column("of", |pair| &pair.native.of)
            .column("symbol", |pair| pair.native.symbol)
            .column("native", |pair| digits(pair.native.value))
            .column("YADE", |pair| pair.yade.map(digits))
            .column("difference", |pair| pair.difference)
            .column("unit", |pair| pair.native.unit)
            .column("", |pair| if pair.agrees() { "" } else { "DIFFERENT" });
        print(&if self.json {
            json(&pairs)?
        } else {
            Table::from(table).text()
        })?;
        Ok(if pairs.iter().all(ParameterPair::agrees) {
            exit::AGREED
        } else {
            exit::CHECK_FAILED
        })
    }
}

/// All of them: two numbers that differ in the last are different.
fn digits(value: f64) -> String {
    format!("{value:?}")
}
