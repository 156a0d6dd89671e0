//! The command line: one verb a file. Arguments in, one library call, an exit code out.

mod bench;
mod compare;
mod engine;
mod job_folder;
mod paper;
mod report;
mod reproduce;
mod run;
mod scene;
mod shell;
mod stability;
mod study;
mod verify;

use clap::{ArgAction, ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::error::Error;
use crate::progress::{Display, Task};
use crate::workers::asked_to_end;
use report::Files;

/// Pours, settles and presses discs in two engines, and says whether they agree.
#[derive(Debug, Parser)]
#[command(
    name = "crossgrain",
    version,
    about,
    max_term_width = 100,
    disable_help_flag = true
)]
#[command(
    after_help = "Exit codes: 0 agreed or done; 1 a check failed; 2 usage, or a bad scene or run \
    folder; 3 incomplete; 4 an engine failed; 75 try again.\n\nThe paper is I. G. Tejada, 2019, doi:10.32075/17ECSMGE-2019-1081.\n\nTo begin with:\n  crossgrain reproduce\n  crossgrain reproduce --help"
)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
    /// Print help
    #[arg(short, long, global = true, action = ArgAction::HelpShort, display_order = 999)]
    help: Option<bool>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Print the paper's scene, check a scene file, print the JSON Schema of scenes
    #[command(subcommand)]
    Scene(scene::Verb),
    /// Run one scene in one engine and write a run folder
    Run(run::Arguments),
    /// Compare two run folders: bits, first difference, every measured quantity
    Compare(compare::Arguments),
    /// The main job: the paper's experiment in both engines, compared, with a report
    Reproduce(reproduce::Arguments),
    /// The verification suite: exact solutions, symmetries, and native against YADE bit for bit
    Verify(verify::Arguments),
    /// Judge YADE, or an engine of your own, exec:PATH: is it right, and what is wrong if not
    #[command(subcommand)]
    Engine(engine::Verb),
    /// Many runs: plan, run in shards, merge, judge; the paper's claims and figures from them
    #[command(subcommand)]
    Study(study::Verb),
    /// What the paper prints that needs no simulation: its numbers recomputed, the continuum
    #[command(subcommand)]
    Paper(paper::Verb),
    /// The largest stable time steps, predicted and found, and the places where methods fail
    Stability(stability::Arguments),
    /// All engines side by side on the paper's bed: time a step, ratios, cost against size, limits
    Bench(bench::Arguments),
    /// What a finished job or run gives: checks, baselines, explanations, VTK files, archives
    #[command(subcommand)]
    Report(report::Verb),
    /// Completions for a shell, manual pages
    #[command(subcommand)]
    Shell(shell::Verb),
}

/// Arguments that were understood, and where an error of theirs is written to.
pub struct Asked {
    arguments: Arguments,
    files: Option<(String, Files)>,
}

impl Asked {
    /// Of this process; ends it with a usage error, or with help.
    pub fn parse() -> Self {
        let matches = Arguments::command().get_matches();
        let arguments = Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
        let files = files(&matches);
        Asked { arguments, files }
    }

    /// Does what was asked; the value is the exit code.
    pub fn execute(self) -> Result<u8, Error> {
        if let Some((_, files)) = &self.files {
            files.check()?;
        }
        let done = self.arguments.execute();
        if let (Err(error), Some((name, files))) = (&done, &self.files) {
            files.write_error(name, error)?;
        }
        done
    }
}

/// The name of the verb that was given, and the files that it was asked for if it judges.
fn files(mut matches: &ArgMatches) -> Option<(String, Files)> {
    let mut name = "crossgrain".to_owned();
    while let Some((verb, below)) = matches.subcommand() {
        name = name + " " + verb;
        matches = below;
    }
    Some((name, Files::asked(matches)?))
}

impl Arguments {
    fn execute(self) -> Result<u8, Error> {
        match self.command {
            Command::Scene(verb) => verb.execute(),
            Command::Run(arguments) => arguments.execute(),
            Command::Compare(arguments) => arguments.execute(),
            Command::Reproduce(arguments) => arguments.execute(),
            Command::Verify(arguments) => arguments.execute(),
            Command::Engine(verb) => verb.execute(),
            Command::Study(verb) => verb.execute(),
            Command::Paper(verb) => verb.execute(),
            Command::Stability(arguments) => arguments.execute(),
            Command::Bench(arguments) => arguments.execute(),
            Command::Report(verb) => verb.execute(),
            Command::Shell(verb) => verb.execute(),
        }
    }
}

/// Prints to standard output; a reader that has gone away is an error, not a panic.
fn print(text: &str) -> Result<(), Error> {
    use std::io::Write;
    let mut out = std::io::stdout().lock();
    out.write_all(crate::document::harmless(text).as_bytes())?;
    Ok(out.flush()?)
}

/// A command with those of its options that were given.
fn with_options<const N: usize>(verb: &str, options: [Option<String>; N]) -> String {
    let given = options.into_iter().flatten();
    given.fold(verb.to_owned(), |all, option| all + " " + &option)
}

/// A flag for it.
fn flag(given: bool, words: &str) -> Option<String> {
    given.then(|| words.to_owned())
}

/// A value as pretty JSON with a newline.
fn json(value: &impl serde::Serialize) -> Result<String, Error> {
    serde_json::to_string_pretty(value)
        .map(|text| text + "\n")
        .map_err(|error| Error::Report(error.to_string()))
}

/// An error where the work was asked to end, and is not whole.
fn unless_ended() -> Result<(), Error> {
    match asked_to_end() {
        true => Err(Error::Interrupted),
        false => Ok(()),
    }
}

/// Does work that takes its time, with progress under this name, and whole.
fn with_progress<T>(
    quiet: bool,
    name: &str,
    work: impl FnOnce(&Task) -> Result<T, Error>,
) -> Result<T, Error> {
    let task = Display::new(quiet).task(name);
    let made = work(&task)?;
    task.done("done");
    unless_ended().map(|()| made)
}

/// Prints a record's text, or what it says in words.
fn tell(as_json: bool, text: &str, words: impl FnOnce() -> String) -> Result<(), Error> {
    match as_json {
        true => print(text),
        false => print(&words()),
    }
}

#[cfg(test)]
mod tests {
    use clap::Command;
    use clap::error::ErrorKind::DisplayHelp;

    use super::*;

    /// The lines of a help text that are commands, up to what a shell or a remark makes of them.
    fn examples(help: &str) -> Vec<Vec<String>> {
        let whole = help.replace("\\\n", " ");
        let lines = whole.lines().map(str::trim_start);
        let commands = lines.filter(|line| line.starts_with("crossgrain "));
        let words = |line: &str| {
            let words = line.split_whitespace();
            let words = words.take_while(|word| !["#", ">", "|", "&&"].contains(word));
            words
                .map(|word| word.trim_matches('"').to_owned())
                .collect()
        };
        commands.map(words).collect()
    }

    /// Looks at the help of a verb and of all verbs below it; the value is how many there are.
    fn look(command: &Command, names: &[String]) -> usize {
        let after = command.get_after_help().map(ToString::to_string);
        let after = after.unwrap_or_default();
        // A command that the help breaks cannot be pasted.
        let is_broken =
            |line: &&str| line.starts_with("  crossgrain") && line.chars().count() > 100;
        assert_eq!(after.lines().find(is_broken), None, "{names:?}");
        let of_it = examples(&after);
        let mut own = of_it.iter().filter(|words| words.starts_with(names));
        assert!(own.next().is_some(), "{names:?} has no example");
        for flag in ["-h", "--help"] {
            let asked = names.iter().map(String::as_str).chain([flag]);
            let help = Arguments::try_parse_from(asked).expect_err("help ends the parser");
            assert_eq!(help.kind(), DisplayHelp, "{names:?}");
            let help = help.to_string();
            let widest = help.lines().map(|line| line.chars().count()).max();
            let size = (help.lines().count(), widest.unwrap_or(0));
            assert!(size.0 <= 50 && size.1 <= 100, "{names:?}: {size:?}\n{help}");
        }
        for words in of_it {
            let understood = Arguments::try_parse_from(&words);
            // What only prints help ends the parser too.
            let ended = understood.as_ref().err().map(clap::Error::kind);
            assert!(
                matches!(ended, None | Some(DisplayHelp)),
                "{words:?}: {understood:?}"
            );
        }
        let below = command.get_subcommands().map(|verb| {
            let names = [names, &[verb.get_name().to_owned()]].concat();
            look(verb, &names)
        });
        1 + below.sum::<usize>()
    }

    /// Verbs that judge nothing: they make, show or keep something.
    const NO_JUDGES: [&str; 25] = [
        "scene paper",
        "scene check",
        "scene model",
        "scene parameters",
        "scene schema",
        "run",
        "study plan campaign",
        "study plan tradeoff",
        "study plan search",
        "study plan candidates",
        "study plan rules",
        "study plan stability",
        "study status",
        "study merge",
        "study slurm",
        "study figures",
        "paper continuum",
        "engine rules",
        "report explain",
        "report baseline save",
        "report baseline list",
        "report vtk",
        "report archive",
        "shell completions",
        "shell man",
    ];

    /// Verbs without verbs below them, as they are typed.
    fn leaves<'a>(command: &'a Command, name: &str) -> Vec<(String, &'a Command)> {
        let below = command.get_subcommands().flat_map(|verb| {
            let name = format!("{name} {}", verb.get_name());
            leaves(verb, name.trim_start())
        });
        let below: Vec<_> = below.collect();
        if below.is_empty() {
            return vec![(name.to_owned(), command)];
        }
        below
    }

    #[test]
    fn every_verb_that_judges_writes_junit_a_table_and_a_summary() {
        let command = Arguments::command();
        let mut judges = 0;
        for (name, verb) in leaves(&command, "") {
            let flags = verb
                .get_arguments()
                .filter_map(|argument| argument.get_long());
            let flags = flags.filter(|flag| ["junit", "csv", "summary"].contains(flag));
            let is_judge = !NO_JUDGES.contains(&name.as_str());
            assert_eq!(flags.count(), if is_judge { 3 } else { 0 }, "{name}");
            judges += usize::from(is_judge);
        }
        assert_eq!(judges, 18);
    }

    #[test]
    fn the_help_of_every_verb_fits_one_screen_with_an_example_that_is_understood() {
        let command = Arguments::command();
        assert_eq!(command.get_subcommands().count(), 12);
        let all = look(&command, &["crossgrain".to_owned()]);
        assert!(all > 35, "{all}");
    }
}
