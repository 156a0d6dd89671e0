//! `crossgrain completions` and `crossgrain man`: the command line described to shells and to man.

use std::path::PathBuf;

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::print;
use crate::error::{Error, exit};
use crate::files::failed;

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  crossgrain completions bash > ~/.local/share/bash-completion/completions/crossgrain\n  \
    crossgrain completions zsh > ~/.zfunc/_crossgrain\n  crossgrain completions fish > ~/.config/fish/completions/crossgrain.fish"
)]
pub struct Completions {
    /// The shell
    shell: Shell,
}

impl Completions {
    pub fn execute(self) -> Result<u8, Error> {
        let mut script = Vec::new();
        let mut command = super::Arguments::command();
        clap_complete::generate(self.shell, &mut command, "crossgrain", &mut script);
        print(&String::from_utf8_lossy(&script))?;
        Ok(exit::AGREED)
    }
}

#[derive(Debug, Args)]
#[command(
    after_help = "Without --out the page of crossgrain itself is printed; with it a page for each verb is written too.\n\nExamples:\n  \
    crossgrain man | man -l -\n  crossgrain man --out ~/.local/share/man/man1"
)]
pub struct Man {
    /// A folder for crossgrain.1, crossgrain-run.1 and so on
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Man {
    pub fn execute(self) -> Result<u8, Error> {
        let command = super::Arguments::command();
        match &self.out {
            Some(folder) => {
                std::fs::create_dir_all(folder).map_err(failed("create", folder))?;
                clap_mangen::generate_to(command, folder).map_err(failed("write", folder))?;
            }
            None => {
                let mut page = Vec::new();
                clap_mangen::Man::new(command).render(&mut page)?;
                print(&String::from_utf8_lossy(&page))?;
            }
        }
        Ok(exit::AGREED)
    }
}
