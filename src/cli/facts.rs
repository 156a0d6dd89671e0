//! `crossgrain facts`: the parameters that each engine uses for a scene.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::run::YadeLimits;
use super::{json, print};
use crate::engine::yade::YadeError;
use crate::error::{Error, exit};
use crate::run::EngineError;
use crate::run::scene_file::read_scene;
use crate::suite::facts::{self, Fact, FactPair};
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
    after_help = "Examples:\n  crossgrain facts scene.json --engine yade\n  crossgrain facts scene.json --engine both"
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
        let native =
            || facts::of_native(&scene).map_err(|error| Error::Engine(EngineError::Native(error)));
        match self.engine {
            Asked::Native => self.show(&native()?),
            Asked::Yade => self.show(&self.of_yade(&scene)?),
            Asked::Both => self.compare(&facts::side_by_side(native()?, &self.of_yade(&scene)?)),
        }
    }

    fn of_yade(&self, scene: &Scene) -> Result<Vec<Fact>, Error> {
        let in_yade = |error: YadeError| Error::Engine(EngineError::Yade(error));
        let work = crate::files::work_folder()?;
        facts::of_yade(scene, &self.limits.options(), work.path()).map_err(in_yade)
    }

    fn show(&self, facts: &[Fact]) -> Result<u8, Error> {
        if self.json {
            print(&json(&facts)?)?;
            return Ok(exit::AGREED);
        }
        let mut text = String::new();
        for fact in facts {
            text += &format!(
                "{:<52} {:<8} {:>24} {}\n",
                fact.of,
                fact.symbol,
                format!("{:?}", fact.value),
                fact.unit
            );
        }
        print(&text)?;
        Ok(exit::AGREED)
    }

    fn compare(&self, pairs: &[FactPair]) -> Result<u8, Error> {
        let agree = pairs.iter().all(FactPair::agrees);
        if self.json {
            print(&json(&pairs)?)?;
        } else {
            print(&in_words(pairs))?;
        }
        Ok(if agree {
            exit::AGREED
        } else {
            exit::CHECK_FAILED
        })
    }
}

fn in_words(pairs: &[FactPair]) -> String {
    let mut text = format!(
        "{:<52} {:<8} {:>24} {:>24} {:>10}\n",
        "of", "symbol", "native", "YADE", "difference"
    );
    for pair in pairs {
        let number =
            |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:?}"));
        text += &format!(
            "{:<52} {:<8} {:>24} {:>24} {:>10} {}\n",
            pair.native.of,
            pair.native.symbol,
            format!("{:?}", pair.native.value),
            number(pair.yade),
            number(pair.difference),
            if pair.agrees() { "" } else { "DIFFERENT" }
        );
    }
    text
}
