//! `crossgrain scene parameters`: the parameters that each engine uses for a scene.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::run::YadeLimits;
use super::{json, print};
use crate::document::{Cell, Table};
use crate::error::{Error, exit};
use crate::files::work_folder;
use crate::run::EngineError;
use crate::run::folder::read_scene;
use crate::suite::parameters::{self, Parameter, ParameterPair};
use grains::scene::Scene;

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Asked {
    /// Our own
    Native,
    /// Debian's YADE, asked itself
    Yade,
    /// Both, which must be equal to 1e-14
    Both,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  crossgrain scene parameters scene.json --engine yade\n  crossgrain scene parameters scene.json --engine both"
)]
pub struct Arguments {
    /// A scene file
    scene: PathBuf,
    /// Which engine is asked
    #[arg(long, value_enum)]
    engine: Asked,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    limits: YadeLimits,
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        let scene = read_scene(&self.scene)?;
        let native = || {
            let found = parameters::of_native(&scene);
            found.map_err(|error| Error::Engine(EngineError::Native(error)))
        };
        match self.engine {
            Asked::Native => self.show(&native()?),
            Asked::Yade => self.show(&self.of_yade(&scene)?),
            Asked::Both => {
                let pairs = parameters::side_by_side(native()?, &self.of_yade(&scene)?);
                self.compare(&pairs)
            }
        }
    }

    fn of_yade(&self, scene: &Scene) -> Result<Vec<Parameter>, Error> {
        let work = work_folder()?;
        let found = parameters::of_yade(scene, &self.limits.options(), work.path());
        found.map_err(|error| Error::Engine(error.into()))
    }

    fn show(&self, parameters: &[Parameter]) -> Result<u8, Error> {
        let mut table = Table::new(
            "parameters",
            "Parameters",
            &["of", "symbol", "value", "unit"],
        );
        for of in parameters {
            let cells = [of.of.as_str(), of.symbol].map(Cell::from);
            let value = format!("{:?}", of.value);
            table.row(cells.into_iter().chain([value.into(), of.unit.into()]));
        }
        print(&if self.json {
            json(&parameters)?
        } else {
            table.text()
        })?;
        Ok(exit::AGREED)
    }

    fn compare(&self, pairs: &[ParameterPair]) -> Result<u8, Error> {
        let columns = ["of", "symbol", "native", "YADE", "difference", "unit", ""];
        let mut table = Table::new("parameters", "Parameters in both engines", &columns);
        for pair in pairs {
            let of = &pair.native;
            // All digits: two that differ in the last are different.
            let digits = |value: f64| Cell::from(format!("{value:?}"));
            table.row([
                of.of.as_str().into(),
                of.symbol.into(),
                digits(of.value),
                pair.yade.map_or(Cell::Missing, digits),
                pair.difference.into(),
                of.unit.into(),
                if pair.agrees() { "" } else { "DIFFERENT" }.into(),
            ]);
        }
        print(&if self.json {
            json(&pairs)?
        } else {
            table.text()
        })?;
        Ok(if pairs.iter().all(ParameterPair::agrees) {
            exit::AGREED
        } else {
            exit::CHECK_FAILED
        })
    }
}
