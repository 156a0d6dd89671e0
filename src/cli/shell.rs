//! `crossgrain shell`: the command line described to shells and to man.

use std::path::PathBuf;

use clap::{CommandFactory, Subcommand};
use clap_complete::Shell;

use super::print;
use crate::error::{Error, exit};
use crate::files::{failed, make_folder};

#[derive(Debug, Subcommand)]
#[command(
    after_help = "Examples:\n  crossgrain shell completions bash > ~/.local/share/bash-completion/completions/crossgrain\n  \
    crossgrain shell man | man -l -"
)]
pub enum Verb {
    /// Print a script that completes this command line in a shell
    #[command(
        after_help = "Examples:\n  crossgrain shell completions zsh > ~/.zfunc/_crossgrain\n  \
        crossgrain shell completions fish > ~/.config/fish/completions/crossgrain.fish"
    )]
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Print the manual page, or write those of all verbs
    #[command(
        after_help = "Examples:\n  crossgrain shell man | man -l -\n  crossgrain shell man --out ~/.local/share/man/man1"
    )]
    Man {
        /// A folder for crossgrain.1, crossgrain-run.1 and so on
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
}

impl Verb {
    pub fn execute(self) -> Result<u8, Error> {
        let mut command = super::Arguments::command();
        let mut text = Vec::new();
        match self {
            Verb::Completions { shell } => {
                clap_complete::generate(shell, &mut command, "crossgrain", &mut text);
            }
            Verb::Man { out: Some(folder) } => {
                make_folder(&folder)?;
                clap_mangen::generate_to(command, &folder).map_err(failed("write", &folder))?;
            }
            Verb::Man { out: None } => clap_mangen::Man::new(command).render(&mut text)?,
        }
        print(&String::from_utf8_lossy(&text))?;
        Ok(exit::AGREED)
    }
}
