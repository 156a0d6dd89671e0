//! The command line: one verb a file. Arguments in, one library call, an exit code out.

mod baseline;
mod bench;
mod checks;
mod chosen;
mod claims;
mod compare;
mod engine;
mod explain;
mod export;
mod figures;
mod job_folder;
mod paper;
mod parameters;
mod reproduce;
mod run;
mod scene;
mod shell;
mod stability;
mod study;
mod verify;

use clap::{Parser, Subcommand};

use crate::error::{Error, exit};

/// Pours, settles and presses discs in two engines, and says whether they agree.
#[derive(Debug, Parser)]
#[command(name = "crossgrain", version, about, max_term_width = 100)]
#[command(
    after_help = "Exit codes: 0 agreed or done; 1 a check failed; 2 usage, or a bad scene or run \
    folder; 3 incomplete; 4 an engine failed; 75 try again.\n\nTo begin with:\n  crossgrain reproduce\n  crossgrain reproduce --help"
)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// What the paper prints that needs no simulation: its numbers recomputed, the continuum under the punch
    #[command(subcommand)]
    Paper(paper::Verb),
    /// The paper's figures from our own numbers: a page, each as SVG and CSV
    Figures(figures::Arguments),
    /// Print the paper's scene, check a scene file, print the JSON Schema of scenes
    #[command(subcommand)]
    Scene(scene::Verb),
    /// Run one scene in one engine and write a run folder
    Run(run::Arguments),
    /// Compare two run folders: bits, first difference, every measured quantity
    Compare(compare::Arguments),
    /// The main job: the paper's experiment in both engines, compared, with a report
    Reproduce(reproduce::Arguments),
    /// Keep a run's checks under a name, and hold later runs against them
    #[command(subcommand)]
    Baseline(baseline::Verb),
    /// The checks of a finished job as lines, JUnit XML, CSV or a job summary in Markdown
    Checks(checks::Arguments),
    /// What a check means, its formula, its source and what usually breaks it
    Explain(explain::Arguments),
    /// Many runs: plan, run in shards, merge, judge
    #[command(subcommand)]
    Study(study::Verb),
    /// The paper's claims against a campaign's members: ours, interval, verdict, figures
    Claims(claims::Arguments),
    /// The verification suite: exact solutions, symmetries, and native against YADE bit for bit
    Verify(verify::Arguments),
    /// An external engine, exec:PATH: what is wrong with it
    #[command(subcommand)]
    Engine(engine::Verb),
    /// The largest stable time steps, predicted and found, and the places where methods fail
    Stability(stability::Arguments),
    /// All engines side by side on the paper's bed: time a step, ratios, cost against size, limits
    Bench(bench::Arguments),
    /// Run folders for ParaView and for archives
    #[command(subcommand)]
    Export(export::Verb),
    /// Print a script that completes this command line in a shell
    Completions(shell::Completions),
    /// Print the manual page, or write those of all verbs
    Man(shell::Man),
}

impl Arguments {
    /// Does what was asked; the value is the exit code.
    pub fn execute(self) -> Result<u8, Error> {
        match self.command {
            Command::Paper(verb) => verb.execute(),
            Command::Figures(arguments) => arguments.execute(),
            Command::Scene(verb) => verb.execute(),
            Command::Run(arguments) => arguments.execute(),
            Command::Compare(arguments) => arguments.execute(),
            Command::Reproduce(arguments) => arguments.execute(),
            Command::Baseline(verb) => verb.execute(),
            Command::Checks(arguments) => arguments.execute(),
            Command::Explain(arguments) => arguments.execute(),
            Command::Study(verb) => verb.execute(),
            Command::Claims(arguments) => arguments.execute(),
            Command::Verify(arguments) => arguments.execute(),
            Command::Engine(verb) => verb.execute(),
            Command::Stability(arguments) => arguments.execute(),
            Command::Bench(arguments) => arguments.execute(),
            Command::Export(verb) => verb.execute(),
            Command::Completions(arguments) => arguments.execute(),
            Command::Man(arguments) => arguments.execute(),
        }
    }
}

/// Prints to standard output; a reader that has gone away is an error, not a panic.
fn print(text: &str) -> Result<(), Error> {
    use std::io::Write;
    let mut out = std::io::stdout().lock();
    out.write_all(crate::document::harmless(text).as_bytes())?;
    out.flush()?;
    Ok(())
}

/// A value as pretty JSON with a newline.
fn json(value: &impl serde::Serialize) -> Result<String, Error> {
    serde_json::to_string_pretty(value)
        .map(|text| text + "\n")
        .map_err(|error| Error::Report(error.to_string()))
}

/// Prints a record's text, or what it says in words.
fn tell(as_json: bool, text: &str, words: impl FnOnce() -> String) -> Result<(), Error> {
    if as_json {
        print(text)
    } else {
        print(&words())
    }
}

/// The exit code of a record that may lack something.
fn exit_code_if(complete: bool) -> u8 {
    if complete {
        exit::AGREED
    } else {
        exit::INCOMPLETE
    }
}

#[cfg(test)]
mod tests {
    use clap::{Command, CommandFactory};

    use super::*;

    /// The lines of a help text that are commands, up to what a shell or a remark makes of them.
    fn examples(command: &Command) -> Vec<Vec<String>> {
        let help = command.get_after_help().map(ToString::to_string);
        let help = help.unwrap_or_default();
        let lines = help.lines().map(str::trim_start);
        let commands = lines.filter(|line| line.starts_with("crossgrain "));
        let ends = |word: &&str| ["#", ">", "|", "&&"].contains(word);
        commands
            .map(|line| {
                let words = line.split_whitespace().take_while(|word| !ends(word));
                words
                    .map(|word| word.trim_matches('"').to_owned())
                    .collect()
            })
            .collect()
    }

    /// Every verb without verbs of its own, with the examples in its help and in that of what it belongs to.
    fn verbs(command: &Command, names: &[String], above: &[Vec<String>], found: &mut Vec<Verb>) {
        let mut all = examples(command);
        all.extend_from_slice(above);
        let verbs_of = |command: &Command| command.get_subcommands().cloned().collect::<Vec<_>>();
        if verbs_of(command).is_empty() {
            found.push((names.to_owned(), all));
            return;
        }
        for verb in verbs_of(command) {
            let names = [names, &[verb.get_name().to_owned()]].concat();
            verbs(&verb, &names, &all, found);
        }
    }

    /// What is typed, and the examples that its reader sees.
    type Verb = (Vec<String>, Vec<Vec<String>>);

    #[test]
    fn every_verb_has_an_example_and_every_example_is_understood() {
        let mut all = Vec::new();
        verbs(
            &Arguments::command(),
            &["crossgrain".to_owned()],
            &[],
            &mut all,
        );
        assert!(all.len() > 25, "{}", all.len());
        for (names, examples) in all {
            let of_it = examples.iter().filter(|words| words.starts_with(&names));
            assert!(of_it.count() > 0, "{names:?} has no example");
            for words in examples {
                let understood = Arguments::try_parse_from(&words);
                // What only prints help ends the parser too.
                let help = understood
                    .as_ref()
                    .is_err_and(|error| error.kind() == clap::error::ErrorKind::DisplayHelp);
                assert!(understood.is_ok() || help, "{words:?}: {understood:?}");
            }
        }
    }
}
