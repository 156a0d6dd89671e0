//! `crossgrain report`: what a finished job or run gives to people and to other programs.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::{ArgMatches, Args, FromArgMatches, Subcommand};

use super::job_folder::Results;
use super::{json, print, tell};
use crate::checks::record::{Record, read};
use crate::checks::{Check, Outcome, Tally};
use crate::compare::baseline::diff::diff;
use crate::compare::baseline::history::{self, Repository};
use crate::compare::baseline::{NONE, Store};
use crate::document::{Document, Table};
use crate::error::{Error, exit};
use crate::explain::{self, EXPLANATIONS};
use crate::files::{Aside, FileError, Place, refuse_existing, write_folder, write_named};
use crate::limits::stability::time_step;
use crate::progress::say;
use crate::report;
use crate::run::export::{pack_archive, write_vtk};
use crate::run::folder::RunFolder;
use crate::workers::unless_asked_to_end;

#[derive(Debug, Subcommand)]
#[command(
    after_help = "Examples:\n  crossgrain report checks out/reproduce/run.json\n  crossgrain report explain faults\n  \
    crossgrain report baseline save out/reproduce/run.json main\n  crossgrain report vtk native --out vtk"
)]
pub enum Verb {
    /// The checks of a finished job as lines, JUnit XML, CSV or a job summary in Markdown
    Checks(Checks),
    /// What a check means, its formula, its source and what usually breaks it
    Explain(Explain),
    /// Keep a job's checks under a name, and hold later jobs against them
    #[command(subcommand)]
    Baseline(Baseline),
    /// Jobs that were kept over time: which check or speed changed in which
    History(History),
    /// What came of a run: why it ended, the force against the depth, heights, and with --out a page with pictures
    #[command(after_help = "Example:\n  crossgrain report run native --out page")]
    Run(OfRun),
    /// Grains, contacts and cells of a run folder as VTK files that ParaView opens
    #[command(
        after_help = "Example:\n  crossgrain report vtk native --out vtk  # open vtk/grains.vtp in ParaView, look along y"
    )]
    Vtk(Folders),
    /// A run folder packed, with checksums and an RO-Crate description
    #[command(after_help = "Example:\n  crossgrain report archive native --out native.tar.gz")]
    Archive(Folders),
}

impl Verb {
    pub fn execute(self) -> Result<u8, Error> {
        match self {
            Verb::Checks(arguments) => arguments.execute(),
            Verb::Explain(arguments) => arguments.execute(),
            Verb::Baseline(verb) => verb.execute(),
            Verb::History(arguments) => arguments.execute(),
            Verb::Run(arguments) => arguments.execute(),
            Verb::Vtk(folders) => folders.vtk(),
            Verb::Archive(folders) => folders.archive(),
        }
    }
}

#[derive(Debug, Args)]
#[command(
    after_help = "The exit code is that of the job: 0 agreed, 1 a check failed, 3 incomplete, 4 an engine failed.\n\nExamples:\n  \
    crossgrain report checks out/reproduce/run.json\n  crossgrain report checks out/reproduce/run.json --junit checks.xml --summary \
    summary.md\n  crossgrain report checks verified/verify.json --all --csv checks.csv"
)]
pub struct Checks {
    /// run.json, verify.json, bench.json, check.json or report.json of a finished job
    #[arg(required_unless_present = "schema")]
    record: Option<PathBuf>,
    /// Print the JSON Schema of what all records have in common
    #[arg(long, conflicts_with = "record")]
    schema: bool,
    /// Print the checks that passed too
    #[arg(long)]
    all: bool,
    #[command(flatten)]
    views: Views,
}

/// What a verb that judges prints and writes.
#[derive(Debug, Clone, Default, Args)]
pub struct Views {
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub files: Files,
}

impl Views {
    /// What was found, as JSON or as words, and the files that were asked for.
    pub fn tell(&self, job: &str, text: &str, document: &Document) -> Result<(), Error> {
        self.files.write(job, document)?;
        tell(self.json, text, || report::terminal(document))
    }
}

/// The same of one that takes its time.
#[derive(Debug, Clone, Default, Args)]
pub struct Output {
    #[command(flatten)]
    pub views: Views,
    /// No progress
    #[arg(long)]
    pub quiet: bool,
}

/// The files that a job's checks can be written to.
#[derive(Debug, Clone, Default, Args)]
pub struct Files {
    /// Write JUnit XML
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Write a table
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Append a job summary in Markdown
    #[arg(long, value_name = "FILE")]
    summary: Option<PathBuf>,
}

impl Files {
    /// Those that the arguments of a verb ask for; none for a verb that judges nothing.
    pub fn asked(arguments: &ArgMatches) -> Option<Self> {
        let judges = arguments.try_contains_id("junit").is_ok();
        judges.then(|| Files::from_arg_matches(arguments).ok())?
    }

    /// An error if a folder of theirs is missing; to be asked before the work.
    pub fn check(&self) -> Result<(), Error> {
        let paths = [&self.junit, &self.csv, &self.summary];
        for path in paths.into_iter().flatten() {
            let folder = path
                .parent()
                .filter(|parent| !parent.as_os_str().is_empty());
            if let Some(folder) = folder.filter(|parent| !Place::from(parent).is_folder()) {
                return Err(Error::Usage(format!(
                    "{} cannot be written: there is no folder {}; make it, or name another file",
                    path.display(),
                    folder.display()
                )));
            }
        }
        Ok(())
    }

    /// Writes those that were asked for, from what the page is made of.
    pub fn write(&self, job: &str, document: &Document) -> Result<(), Error> {
        let checks = &document.checks;
        if let Some(path) = &self.junit {
            let junit = report::junit(&format!("crossgrain {job}"), checks);
            write_named(path, junit.as_bytes(), false)?;
        }
        if let Some(path) = &self.csv {
            let table = Table::of_checks("checks", checks).csv();
            write_named(path, table.as_bytes(), false)?;
        }
        if let Some(path) = &self.summary {
            write_named(path, report::markdown(document).as_bytes(), true)?;
        }
        Ok(())
    }

    /// A job that ended with an error has no checks; whoever reads the files is told so there too.
    pub fn write_error(&self, name: &str, error: &Error) -> Result<(), Error> {
        if let Some(path) = &self.junit {
            write_named(path, report::junit_of_error(name, error).as_bytes(), false)?;
        }
        if let Some(path) = &self.summary {
            let document = Document {
                title: name.to_owned(),
                verdict: Outcome::Skipped,
                answer: format!("It ended with exit code {}: {error}", error.exit_code()),
                sections: Vec::new(),
                checks: Vec::new(),
            };
            write_named(path, report::markdown(&document).as_bytes(), true)?;
        }
        Ok(())
    }
}

impl Checks {
    fn execute(self) -> Result<u8, Error> {
        let Some(path) = &self.record else {
            print(&json(&schemars::schema_for!(Record))?)?;
            return Ok(exit::AGREED);
        };
        let record = read(path)?;
        let document = record.document();
        self.views.files.write(&record.job, &document)?;
        tell(self.views.json, &json(&record)?, || {
            let lines = report::check_lines(&record.checks, self.all);
            let said = document.verdict_in_words();
            let verdict = said.unwrap_or_default().to_uppercase();
            lines + &format!("{verdict}: {}; {}\n", record.job, Tally::of(&record.checks))
        })?;
        Ok(document.exit_code())
    }
}

#[derive(Debug, Args)]
#[command(
    after_help = "Without CHECK all kinds of checks are named.\n\nExamples:\n  crossgrain report explain faults\n  crossgrain report explain \
    compare/sorted-recorded --record out/reproduce/run.json"
)]
pub struct Explain {
    /// A check's id, or the beginning of one, as `report checks --all` prints it
    check: Option<String>,
    /// The record that it stands in: its values and limits are shown too
    #[arg(long, value_name = "FILE", requires = "check")]
    record: Option<PathBuf>,
}

/// Checks of a record that are shown for the beginning of an id.
const MOST_SHOWN: usize = 10;

impl Explain {
    fn execute(self) -> Result<u8, Error> {
        let Some(id) = &self.check else {
            let kinds = EXPLANATIONS.iter().map(|explanation| {
                format!("{}\n    {}\n", explanation.pattern, explanation.meaning)
            });
            print(&kinds.collect::<String>())?;
            return Ok(exit::AGREED);
        };
        let Some(found) = explain::of(id) else {
            let patterns = EXPLANATIONS.iter().map(|explanation| explanation.pattern);
            let kinds = patterns.filter_map(|pattern| pattern.split('/').next());
            let mut kinds: Vec<&str> = kinds.filter(|kind| *kind != "*").collect();
            kinds.dedup();
            return Err(Error::Usage(format!(
                "there is no check {id}; a check's id begins with {}; crossgrain report checks RECORD --all names those of a job",
                kinds.join(", ")
            )));
        };
        let mut text = format!(
            "{}\n\nmeaning: {}\nformula: {}\nsource:  {}\nbreaks:  {}\n",
            found.pattern, found.meaning, found.formula, found.source, found.breaks
        );
        if let Some(path) = &self.record {
            let record = read(path)?;
            let below = format!("{}/", id.trim_end_matches('/'));
            let within = |check: &&Check| check.id == *id || check.id.starts_with(&below);
            let shown: Vec<&Check> = record.checks.iter().filter(within).collect();
            if shown.is_empty() {
                let path = path.display();
                return Err(Error::Usage(format!(
                    "{path} has no check {id}; crossgrain report checks {path} --all names them"
                )));
            }
            for check in shown.iter().take(MOST_SHOWN) {
                text += &lines(check);
            }
            if shown.len() > MOST_SHOWN {
                text += &format!("\n… and {} more\n", shown.len() - MOST_SHOWN);
            }
        }
        print(&text)?;
        Ok(exit::AGREED)
    }
}

fn lines(check: &Check) -> String {
    let (outcome, line) = (check.outcome.word(), check.in_a_line());
    let mut text = format!("\n{}: {outcome}\n    {line}\n", check.id);
    for (title, words) in [("method", &check.method), ("limits", &check.basis)] {
        if !words.is_empty() {
            text += &format!("    {title}: {words}\n");
        }
    }
    text
}

#[derive(Debug, Subcommand)]
#[command(
    after_help = "A baseline changes only by `save --replace`.\n\nExamples:\n  crossgrain report baseline save out/reproduce/run.json main\n  \
    crossgrain report baseline list\n  crossgrain report baseline diff out/reproduce/run.json main"
)]
pub enum Baseline {
    /// Keep the checks of a finished job under a name
    #[command(
        after_help = "Example:\n  crossgrain report baseline save out/reproduce/run.json main"
    )]
    Save {
        /// run.json, verify.json, bench.json, check.json or report.json of a finished job
        record: PathBuf,
        /// Its name as a baseline
        name: String,
        /// Put it in the place of one of that name
        #[arg(long)]
        replace: bool,
        #[command(flatten)]
        at: Where,
    },
    /// All baselines: name, job, version, how many checks
    #[command(after_help = "Example:\n  crossgrain report baseline list")]
    List(Where),
    /// What is worse, better, moved or gone since a baseline
    Diff(DiffArguments),
}

#[derive(Debug, Args)]
pub struct Where {
    /// The folder of baselines
    #[arg(long, default_value = "baselines", value_name = "DIR")]
    store: PathBuf,
}

impl Where {
    pub fn store(&self) -> Store {
        Store::new(&self.store)
    }
}

#[derive(Debug, Args)]
#[command(
    after_help = "Exit code 0: nothing is worse; 1: a new failure, or slower on the same kind of machine; 3: a check is gone, is no \
    longer made or is defined otherwise, so that nothing can be said of it.\nTimes are compared as ratios to YADE and to native, \
    never as seconds.\n\nExample:\n  crossgrain report baseline diff out/reproduce/run.json main"
)]
pub struct DiffArguments {
    /// run.json, verify.json, bench.json, check.json or report.json of a finished job
    record: PathBuf,
    /// The baseline's name
    name: String,
    /// Print every check and number that moved, not only the dozen that moved most
    #[arg(long)]
    all: bool,
    /// Every measured number must be the same to the last bit, as after a change that is to change nothing
    #[arg(long)]
    bits: bool,
    #[command(flatten)]
    views: Views,
    #[command(flatten)]
    at: Where,
}

impl Baseline {
    fn execute(self) -> Result<u8, Error> {
        match self {
            Baseline::Save {
                record,
                name,
                replace,
                at,
            } => {
                let path = at.store().save(&record, &name, replace)?;
                print(&format!("kept as {}\n", path.display()))?;
                Ok(exit::AGREED)
            }
            Baseline::List(at) => {
                let store = at.store();
                let mut text = String::new();
                for name in store.names()? {
                    let record = store.load(&name)?.record;
                    let [job, version] = [&record.job, &record.crossgrain];
                    let tally = Tally::of(&record.checks);
                    text += &format!("{name}: {job}, crossgrain {version}, {tally}\n");
                }
                if text.is_empty() {
                    text = format!("{NONE}\n");
                }
                print(&text)?;
                Ok(exit::AGREED)
            }
            Baseline::Diff(arguments) => arguments.execute(),
        }
    }
}

impl DiffArguments {
    fn execute(self) -> Result<u8, Error> {
        let baseline = self.at.store().load(&self.name)?;
        let record = read(&self.record)?;
        if baseline.record.job != record.job {
            return Err(Error::Usage(format!(
                "the baseline {} is of {}, this run is of {}; give a run of the same job",
                self.name, baseline.record.job, record.job
            )));
        }
        let found = diff(&baseline, &record);
        let found = if self.bits {
            found.demanding_bits()
        } else {
            found
        };
        let (text, document) = (json(&found)?, found.document(self.all));
        self.views.tell("report baseline diff", &text, &document)?;
        Ok(found.verdict.exit_code())
    }
}

#[derive(Debug, Args)]
pub struct OfRun {
    /// A run folder
    run: PathBuf,
    #[command(flatten)]
    results: Results,
    #[command(flatten)]
    views: Views,
}

impl OfRun {
    fn execute(self) -> Result<u8, Error> {
        const RECORD: &str = "outcome.json";
        self.results.check(RECORD)?;
        let mut run = RunFolder::read(&self.run)?;
        // The page shows nothing of it, and it takes room.
        run.initial = grains::tables::Bodies::default();
        let text = json(&run.record)?;
        let document = unless_asked_to_end(move || {
            let share = time_step::largest_share(&run)?;
            Ok::<_, Error>(report::outcome::document(&run, share))
        });
        let document = document.ok_or(Error::Interrupted)??;
        let record = (RECORD, text.as_str());
        self.results
            .finish(&self.views, "report run", record, &document)
    }
}

#[derive(Debug, Args)]
pub struct Folders {
    /// A run folder
    run: PathBuf,
    /// What to write; must not exist
    #[arg(long)]
    out: PathBuf,
}

impl Folders {
    fn vtk(self) -> Result<u8, Error> {
        refuse_existing(&self.out)?;
        let run = RunFolder::read(&self.run)?;
        let mut names = Vec::new();
        write_folder::<FileError>(&self.out, |aside| {
            names.extend(write_vtk(aside, &run.scene, &run.last, "")?);
            if let Some(settled) = &run.settled {
                names.extend(write_vtk(aside, &run.scene, settled, "settled-")?);
            }
            Ok(())
        })?;
        print(&format!("{}: {}\n", self.out.display(), names.join(", ")))?;
        Ok(exit::AGREED)
    }

    fn archive(self) -> Result<u8, Error> {
        refuse_existing(&self.out)?;
        // Only what belongs together is worth an archive's room.
        let run = RunFolder::read(&self.run)?;
        let name = self.out.file_name().and_then(|name| name.to_str());
        let name = name.and_then(|name| name.split('.').next());
        let Some(name) = name.filter(|name| !name.is_empty()) else {
            return Err(Error::Usage(format!(
                "{} is no name for an archive; give one such as run.tar.gz",
                self.out.display()
            )));
        };
        let mut aside = Aside::of(&self.out)?;
        pack_archive(&self.run, &run, name, &mut aside)?;
        aside.into_place()?;
        print(&format!("{}\n", self.out.display()))?;
        Ok(exit::AGREED)
    }
}

#[derive(Debug, Args)]
#[command(
    after_help = "A speed has changed when its rounds lie apart from those of the record where its level began, by 5 % of the median \
    at least (single values: by half), in two records one after the other. Times are ratios, and only those of the \
    newest record's kind of machine are held against each other. The exit code is the newest record's, and 1 if something became slower in \
    the last two.\n\nExamples:\n  \
    crossgrain report baseline save verified/verify.json $COMMIT --store history  # after each change\n  \
    crossgrain report history --store history --repository . --out over-time"
)]
pub struct History {
    #[command(flatten)]
    at: Where,
    /// A git repository: the names of the records are commits, in the order in which they came to HEAD; without it names
    /// are in the order of their letters
    #[arg(long, value_name = "DIR")]
    repository: Option<PathBuf>,
    #[command(flatten)]
    results: Results,
    #[command(flatten)]
    views: Views,
}

/// The record's file in the folder of results.
const RECORD: &str = "history.json";

impl History {
    fn execute(self) -> Result<u8, Error> {
        self.results.check(RECORD)?;
        let store = self.at.store();
        let mut names = store.names()?;
        let mut subjects = BTreeMap::new();
        if let Some(repository) = &self.repository {
            let log = ["log", "--reverse", "--topo-order", "--format=%H %s"];
            let log = Repository::open(repository)?.git(&log)?;
            let mut in_order = Vec::new();
            for (commit, subject) in log.lines().filter_map(|line| line.split_once(' ')) {
                let is_of = |name: &&String| name.len() >= 7 && commit.starts_with(*name);
                if let Some(name) = names.iter().find(is_of) {
                    in_order.push(name.clone());
                    subjects.insert(name.clone(), subject.to_owned());
                }
            }
            let all = names.len();
            names = in_order;
            if names.len() < all {
                say(&format!(
                    "{} of {all} records are of commits that are not in HEAD's history; they are left out",
                    all - names.len()
                ));
            }
        }
        let records: Result<Vec<_>, _> = names.iter().map(|name| store.load(name)).collect();
        let records = records?;
        let [_, .., last] = &records[..] else {
            return Err(Error::Usage(format!(
                "a history needs two records, and there are {}; crossgrain report baseline save keeps one",
                records.len()
            )));
        };
        if let Some(other) = records
            .iter()
            .find(|entry| entry.record.job != last.record.job)
        {
            return Err(Error::Usage(format!(
                "{} is of {}, {} of {}; keep the records of each job in a store of their own",
                other.name, other.record.job, last.name, last.record.job
            )));
        }
        let kept = history::History::of(&records);
        let subject = |name: &str| subjects.get(name).cloned().unwrap_or_default();
        let (text, document) = (json(&kept)?, kept.document(&last.record, subject));
        self.views.tell("report history", &text, &document)?;
        self.results.write(&document, &[(RECORD, &text)])?;
        Ok(document.verdict.exit_code())
    }
}
