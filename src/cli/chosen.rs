//! Engines as they are named on the command line.

use std::path::PathBuf;
use std::str::FromStr;

use clap::ValueEnum;

use crate::engine::value_name;
use crate::suite::run::Engines;

/// One engine.
#[derive(Debug, Clone)]
pub enum Chosen {
    Native,
    Yade,
    /// A program that speaks the engine protocol.
    Exec(PathBuf),
}

impl FromStr for Chosen {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match (text, program(text)) {
            ("native", _) => Ok(Chosen::Native),
            ("yade", _) => Ok(Chosen::Yade),
            (_, Some(path)) => Ok(Chosen::Exec(path)),
            _ => Err(
                "an engine is native, yade or exec:PATH, such as exec:adapters/lammps.py"
                    .to_owned(),
            ),
        }
    }
}

/// The engines of this program, or an external one.
#[derive(Debug, Clone)]
pub enum Several {
    BuiltIn(Engines),
    Exec(PathBuf),
}

impl FromStr for Several {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match program(text) {
            Some(path) => Ok(Several::Exec(path)),
            None => Engines::from_str(text, false)
                .map(Several::BuiltIn)
                .map_err(|_| "an engine is native, yade, both or exec:PATH".to_owned()),
        }
    }
}

impl Several {
    /// As a command has it, the path left out: it belongs to a machine.
    pub fn name(&self) -> String {
        match self {
            Several::BuiltIn(engine) => value_name(engine),
            Several::Exec(_) => "exec:PATH".to_owned(),
        }
    }
}

/// Parses an external engine, beside those of this program.
pub fn beside(text: &str) -> Result<PathBuf, String> {
    program(text).ok_or_else(|| {
        "native and YADE take part anyway; one more engine is named as exec:PATH".to_owned()
    })
}

fn program(text: &str) -> Option<PathBuf> {
    let path = text.strip_prefix("exec:")?;
    (!path.is_empty()).then(|| PathBuf::from(path))
}
