//! Engines by their names, as commands are given them.

use std::path::{Path, PathBuf};

use super::exec::{self, Adapter, ExternalEngine};
use super::{Engine, Result, yade};
use grains::native;

/// An engine by its name, from which the engine is made.
#[derive(Debug, Clone, PartialEq)]
pub enum Named {
    Native,
    /// In its sorted or in its ordinary loop, where the name says which.
    Yade(Option<bool>),
    /// One with an adapter that comes with this program.
    Adapter(Adapter),
    /// A program that speaks the engine protocol.
    Exec(PathBuf),
}

impl Named {
    /// None if no engine has this name.
    pub fn parse(text: &str) -> Option<Named> {
        Some(match (text, text.strip_prefix("exec:")) {
            ("native", _) => Named::Native,
            ("yade", _) => Named::Yade(None),
            ("yade-sorted", _) => Named::Yade(Some(true)),
            ("yade-ordinary", _) => Named::Yade(Some(false)),
            (_, Some(path)) if !path.is_empty() => Named::Exec(PathBuf::from(path)),
            _ => Named::Adapter(
                Adapter::ALL
                    .into_iter()
                    .find(|adapter| adapter.key == text)?,
            ),
        })
    }

    /// Its name, the path left out: it belongs to a machine.
    pub fn key(&self) -> &'static str {
        match self {
            Named::Native => "native",
            Named::Yade(None) => "yade",
            Named::Yade(Some(true)) => "yade-sorted",
            Named::Yade(Some(false)) => "yade-ordinary",
            Named::Adapter(adapter) => adapter.key,
            Named::Exec(_) => "exec:PATH",
        }
    }

    /// The engine, a program asked what it is. Options are YADE's, and the limits are those of all programs; an adapter is
    /// written into `folder`, which must last.
    pub fn engine(&self, options: &yade::Options, folder: &Path) -> Result<Box<dyn Engine>> {
        Ok(match self {
            Named::Native => Box::new(native::Options::default()),
            Named::Yade(sorted) => Box::new(yade::Options {
                sorted: sorted.unwrap_or(options.sorted),
                ..options.clone()
            }),
            Named::Adapter(adapter) => Box::new(adapter.place(folder, &options.limits)?),
            Named::Exec(program) => Box::new(ExternalEngine::ask(exec::Options {
                program: program.clone(),
                limits: options.limits.clone(),
            })?),
        })
    }
}
