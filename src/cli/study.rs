//! `crossgrain study`: many runs, planned, made in shards, merged and judged; what the paper says and draws, from a campaign's members.

pub mod plan;

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use super::engine::beside;
use super::job_folder::{Results, page_line};
use super::report::{Files, Views};
use super::run::YadeLimits;
use super::{json, print, tell};
use crate::checks::Outcome;
use crate::document::{Document, Section};
use crate::error::{Error, exit};
use crate::files::{failed, make_folder, write_whole};
use crate::limits::stability::Stability;
use crate::progress::{Display, say};
use crate::report::disc_field::of_figure_4;
use crate::report::fields::bulbs;
use crate::report::html::FOLDER;
use crate::report::packing::force_chains;
use crate::report::page;
use crate::study::campaign::compare::compare;
use crate::study::campaign::{Campaign, Merged, merged};
use crate::study::claims::{self, Origin};
use crate::study::figures::{Distribution, distributions, loaded_bed, setup_of, sharings};
use crate::study::folder::{AnyStudy, Job, Status, StudyFolder, Summary};
use crate::study::realization::{Engines, ending_in_words};
use crate::study::shard::Shard;
use crate::study::slurm;
use crate::study::{
    RECORD, Study, StudyError, candidates, conventions, plan as stored, search, tradeoff,
};
use crate::workers::{cores, unless_asked_to_end};
use grains::scene::paper_scene;

#[derive(Debug, Subcommand)]
#[command(after_help = "Examples:\n  crossgrain scene paper > scene.json\n  \
    crossgrain study plan campaign scene.json --members 1000 --out thousand\n  \
    crossgrain study run thousand\n  \
    crossgrain study run thousand --shard 2/8\n  \
    crossgrain study status thousand\n  \
    crossgrain study merge thousand\n  \
    crossgrain study slurm thousand --tasks 20\n  \
    crossgrain study report thousand --junit checks.xml\n  \
    crossgrain study compare thousand in-yade\n  \
    crossgrain study claims thousand")]
pub enum Verb {
    /// Fix what is run, in a new folder
    #[command(subcommand)]
    Plan(plan::Kind),
    /// Make the rows of a shard that are missing; without --shard all, then merge and report
    #[command(after_help = "Example:\n  crossgrain study run thousand --shard 2/8")]
    Run(RunArguments),
    /// How far it is
    #[command(after_help = "Example:\n  crossgrain study status thousand")]
    Status {
        /// The study's folder
        folder: PathBuf,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
    /// Put the rows of a finished study into one file
    #[command(after_help = "Example:\n  crossgrain study merge thousand")]
    Merge {
        /// The study's folder
        folder: PathBuf,
    },
    /// Write the scripts of a Slurm job array and of the merge after it, and print how they are submitted
    #[command(after_help = "Example:\n  crossgrain study slurm thousand --tasks 20")]
    Slurm(SlurmArguments),
    /// Judge the rows that are there: report.json, a page, and the checks for other programs
    #[command(after_help = "Example:\n  crossgrain study report thousand --junit checks.xml")]
    Report {
        /// The study's folder
        folder: PathBuf,
        #[command(flatten)]
        views: Views,
    },
    /// Two merged campaigns of one scene, such as of two engines: bits of common realizations, else equivalence
    #[command(after_help = "Example:\n  crossgrain study compare thousand in-yade")]
    Compare {
        /// A merged campaign
        first: PathBuf,
        /// Another one
        second: PathBuf,
        #[command(flatten)]
        results: Results,
        #[command(flatten)]
        views: Views,
    },
    /// The paper's claims against a campaign's members: ours, interval, verdict, figures
    Claims(Claims),
    /// The paper's figures from our own numbers: a page, each as SVG and CSV
    Figures(Figures),
}

#[derive(Debug, Args)]
pub struct RunArguments {
    /// The study's folder
    folder: PathBuf,
    /// I/N: every N-th row from the I-th on; auto: by the variables of a Slurm job array
    #[arg(long, conflicts_with_all = ["junit", "csv", "summary"])]
    shard: Option<String>,
    /// Rows at a time [default: the machine's cores; with --shard 1]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Where the planned external engine is on this machine, as exec:PATH
    #[arg(long, value_parser = beside)]
    engine: Option<PathBuf>,
    #[command(flatten)]
    limits: YadeLimits,
    /// No progress
    #[arg(long)]
    quiet: bool,
    #[command(flatten)]
    files: Files,
}

#[derive(Debug, Args)]
pub struct SlurmArguments {
    /// The study's folder, on a file system that all nodes share
    folder: PathBuf,
    /// Tasks of the array; each makes its share of the rows one after another
    #[arg(long)]
    tasks: u64,
    /// Rows at a time in a task, and processors that it asks for
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// The partition, where the cluster has no default
    #[arg(long)]
    partition: Option<String>,
}

/// Opens a study of any kind.
pub fn open(path: &Path) -> Result<Box<dyn AnyStudy>, StudyError> {
    fn opened<S: Study + 'static>(path: &Path) -> Result<Box<dyn AnyStudy>, StudyError> {
        Ok(Box::new(StudyFolder::<S>::open(path)?))
    }
    let kind = stored::kind(path)?;
    match kind.as_str() {
        Campaign::KIND => opened::<Campaign>(path),
        tradeoff::plan::Plan::KIND => opened::<tradeoff::plan::Plan>(path),
        candidates::Plan::KIND => opened::<candidates::Plan>(path),
        conventions::Plan::KIND => opened::<conventions::Plan>(path),
        search::Plan::KIND => opened::<search::Plan>(path),
        Stability::KIND => opened::<Stability>(path),
        _ => {
            let reason = format!("this program has no studies of kind {kind:?}");
            Err(StudyError::not_a_study(path, reason))
        }
    }
}

impl Verb {
    pub fn execute(self) -> Result<u8, Error> {
        match self {
            Verb::Plan(kind) => kind.execute(),
            Verb::Run(arguments) => arguments.execute(),
            // Exit code 0 if no row is missing, else 3.
            Verb::Status {
                folder,
                json: wanted,
            } => {
                let status = open(&folder)?.status()?;
                tell(wanted, &json(&status)?, || of_status(&status))?;
                Ok(match status.finished == status.rows {
                    true => exit::AGREED,
                    false => exit::INCOMPLETE,
                })
            }
            Verb::Merge { folder } => {
                print(&in_words(&open(&folder)?.merge()?))?;
                Ok(exit::AGREED)
            }
            Verb::Slurm(arguments) => arguments.execute(),
            Verb::Report { folder, views } => report(&folder, &views, true),
            Verb::Compare {
                first,
                second,
                results,
                views,
            } => {
                results.check(COMPARED)?;
                let comparison = compare(&merged(&first)?, &merged(&second)?)?;
                let text = json(&comparison)?;
                let document = comparison.told_apart([&first, &second]).document();
                results.finish(&views, "study compare", (COMPARED, &text), &document)
            }
            Verb::Claims(arguments) => arguments.execute(),
            Verb::Figures(arguments) => arguments.execute(),
        }
    }
}

impl RunArguments {
    fn execute(self) -> Result<u8, Error> {
        let study = open(&self.folder)?;
        let shard = match self.shard.as_deref() {
            None => Shard::WHOLE,
            Some("auto") => {
                Shard::from_slurm(|name| std::env::var(name).ok()).map_err(Error::Usage)?
            }
            Some(text) => text.parse().map_err(Error::Usage)?,
        };
        let threads = match self.threads {
            Some(threads) => usize::from(threads),
            None if self.shard.is_some() => 1,
            None => cores(),
        };
        let engines = engines_of(study.as_ref(), self.engine.as_deref(), &self.limits)?;
        let job = Job {
            shard,
            threads,
            engines: &engines,
        };
        let done = study.run(&job, &Display::new(self.quiet))?;
        print(&format!(
            "shard {shard}: {} rows, {} of them finished before\n",
            done.wanted, done.before
        ))?;
        if shard == Shard::WHOLE {
            print(&in_words(&study.merge()?))?;
            let (json, files) = (false, self.files);
            return report(&self.folder, &Views { json, files }, true);
        }
        if done.complete {
            let folder = self.folder.display();
            print(&format!(
                "all rows are finished; merge them: crossgrain study merge {folder}\n"
            ))?;
        }
        Ok(exit::AGREED)
    }
}

/// The engines of a study that are other programs, with the planned external one, which may be `named` at another place.
pub fn engines_of(
    study: &dyn AnyStudy,
    named: Option<&Path>,
    limits: &YadeLimits,
) -> Result<Engines, Error> {
    let planned = study.program();
    if planned.is_none() && named.is_some() {
        let why = "no external engine is planned here";
        return Err(Error::Usage(why.to_owned()));
    }
    let place = planned.map(|program| named.unwrap_or(&program.path));
    Ok(Engines {
        yade: limits.options(),
        external: place.map(|place| limits.external(place)).transpose()?,
    })
}

fn of_status(status: &Status) -> String {
    let (finished, rows) = (status.finished, status.rows);
    let merged = if status.merged { ", merged" } else { "" };
    let mut text = format!(
        "{}: {finished} of {rows} rows finished{merged}\n",
        status.kind
    );
    for (file, rows) in &status.files {
        text += &format!("  {file}: {rows}\n");
    }
    if status.repeated > 0 {
        let count = status.repeated;
        text += &format!("  {count} lines repeat a row; it counts once\n");
    }
    for (file, line) in &status.damaged {
        text += &format!("  {file} line {line} is no whole row and is not believed\n");
    }
    if !status.missing.is_empty() {
        text += &format!("missing: rows {}\n", status.missing);
    }
    text
}

impl SlurmArguments {
    fn execute(self) -> Result<u8, Error> {
        let program = std::env::current_exe().map_err(failed("find", Path::new("this program")))?;
        let (folder, tasks, threads) = (&self.folder, self.tasks, self.threads);
        let (study, partition) = (open(folder)?, self.partition.as_deref());
        let submit = slurm::write(folder, study.as_ref(), tasks, threads, partition, &program)?;
        print(&format!("{}\n", submit.join("\n")))?;
        Ok(exit::AGREED)
    }
}

/// Writes record and page, and says what the checks come to, and where the page is if it stays.
pub fn report(folder: &Path, views: &Views, stays: bool) -> Result<u8, Error> {
    let report = open(folder)?.judge()?;
    page(&report.document).write(folder)?;
    write_whole((folder, RECORD), report.text.as_bytes())?;
    views.tell(&report.record.job, &report.text, &report.document)?;
    if stays && !views.json {
        print(&page_line(folder))?;
    }
    Ok(report.document.verdict.exit_code())
}

fn in_words(summary: &Summary) -> String {
    let endings = summary.endings.iter();
    let endings = endings.map(|(how, count)| format!("{count} {}", ending_in_words(how)));
    let endings: Vec<String> = endings.collect();
    // None where it gave up on every row, or where several take part.
    let engine = match summary.engine.as_str() {
        "" => String::new(),
        engine => format!(" of {engine}"),
    };
    let (rows, endings, digest) = (summary.rows, endings.join(", "), &summary.sha256[..16]);
    format!("merged {rows} rows{engine}: {endings}; sha256 {digest}\n")
}

#[derive(Debug, Args)]
#[command(
    after_help = "Exit code 0: every claim could be decided, either way; 3: some claim is undecided.\n\nExamples:\n  \
    crossgrain study claims thousand\n  crossgrain study claims thousand --beside best --out claims"
)]
pub struct Claims {
    /// The folder of a merged campaign
    folder: PathBuf,
    /// That of another scene, to stand beside it claim by claim
    #[arg(long, value_name = "FOLDER")]
    beside: Option<PathBuf>,
    #[command(flatten)]
    results: Results,
    #[command(flatten)]
    views: Views,
}

/// The files of the records.
const CLAIMS: &str = "claims.json";
const COMPARED: &str = "compare.json";

impl Claims {
    fn execute(self) -> Result<u8, Error> {
        self.results.check(CLAIMS)?;
        let mut command = format!("crossgrain study claims {}", self.folder.display());
        if let Some(folder) = &self.beside {
            command += &format!(" --beside {}", folder.display());
        }
        let read = |folder: &PathBuf| {
            let merged = merged(folder)?;
            let origin = Origin {
                command: command.clone(),
                engine: merged.summary.engine.clone(),
                plan: merged.summary.plan.clone(),
                members_digest: merged.summary.sha256.clone(),
            };
            Ok::<_, StudyError>((merged, origin))
        };
        let here = read(&self.folder)?;
        let other = self.beside.as_ref().map(read).transpose()?;
        say("Holding the members against the claims and the laws; a thousand take about a minute.");
        let judged = |(merged, origin): (Merged, Origin)| {
            claims::of(&merged.plan.study.scene, &merged.rows, origin)
        };
        let found = unless_asked_to_end(move || (judged(here), other.map(judged)));
        let (mut found, other) = found.ok_or(Error::Interrupted)?;
        found.beside = other.map(Into::into);
        let (text, document) = (json(&found)?, found.document());
        let record = (CLAIMS, text.as_str());
        self.results
            .finish(&self.views, "study claims", record, &document)
    }
}

#[derive(Debug, Args)]
#[command(
    after_help = "Writes a page and each figure as SVG and CSV; files of the same names in --out are replaced.\n\n\
    Examples:\n  crossgrain study figures\n  crossgrain study figures --campaign thousand --out figures"
)]
pub struct Figures {
    /// A merged campaign: its members give Figure 5, the scene of its first one the others
    #[arg(long)]
    campaign: Option<PathBuf>,
    /// The folder to write
    #[arg(long, default_value = "out/figures")]
    out: PathBuf,
}

impl Figures {
    fn execute(self) -> Result<u8, Error> {
        // Before anything is run or written.
        let campaign = self.campaign.as_deref().map(merged).transpose()?;
        let mut scene = paper_scene(1, 5000);
        let mut words = "It is of a campaign's members: name one with --campaign.";
        let mut members = Vec::new();
        if let Some(campaign) = &campaign {
            scene = campaign.plan.study.scene.clone();
            scene.realization = campaign.plan.study.realization(1);
            words = "Distributions at O, A and B.";
            // First, as it runs nothing and may have nothing to draw.
            members = distributions(campaign)?;
        }
        // A place that cannot be written is told before seconds of work.
        let out = self.out;
        make_folder(&out)?;
        let plots = members.iter().flat_map(Distribution::plots);
        let fifth = Section::new("Figure 5", words).with_all(plots);
        let chains = force_chains(&loaded_bed(&scene)?)?;
        let (table, shares) = sharings();
        let disc = Section {
            title: "Figure 4".to_owned(),
            answer: "Inside a grain.".to_owned(),
            ..of_figure_4()
        };
        let document = Document {
            title: "The paper's figures from our own numbers".to_owned(),
            verdict: Outcome::Pass,
            answer: format!(
                "Figures 1 to {} of the paper, drawn for the scene {}.",
                if campaign.is_some() { 5 } else { 4 },
                scene.name
            ),
            sections: vec![
                Section::new("Figure 1", "The continuum.").with(bulbs(&setup_of(&scene))),
                Section::new("Figure 2", "The forces between the grains.").with(chains),
                Section::new("Figure 3 and Table 1", "Five piles.")
                    .with(table)
                    .with(shares),
                disc,
                fifth,
            ],
            checks: Vec::new(),
        };
        let page = page(&document);
        page.write(&out)?;
        let files: Vec<&str> = page.files.iter().map(|(name, _)| name.as_str()).collect();
        print(&format!(
            "SVG and CSV in {}: {}\n{}",
            out.join(FOLDER).display(),
            files.join(" "),
            page_line(&out)
        ))?;
        Ok(exit::AGREED)
    }
}
