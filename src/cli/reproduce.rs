//! `crossgrain reproduce`: the main job.

use std::path::{Path, PathBuf};

use clap::Args;

use super::job_folder::{finish, open, page_line};
use super::report::{Files, Where};
use super::run::YadeLimits;
use super::{flag, json, print, unless_ended, with_options};
use crate::checks::record::{self, Found, Record};
use crate::checks::{self, Outcome};
use crate::compare::baseline::{self, diff::diff};
use crate::document::Document;
use crate::engine::yade;
use crate::error::Error;
use crate::files::{Place, write_whole};
use crate::limits::bench::machine::Machine;
use crate::progress::Display;
use crate::report::html::FIRST;
use crate::report::{Page, page_against, terminal};
use crate::reproduce::record::{Beside, Reproduction, measured};
use crate::reproduce::{Options, reproduce};
use crate::run::folder::read_scene;
use grains::native::Fault;
use grains::scene::paper_scene;

const RECORD: &str = "run.json";

#[derive(Debug, Args)]
#[command(
    after_help = "Without YADE the native run is compared with a recorded YADE run. With YADE it also \
    runs live: the whole experiment in the sorted loop in parts, and all else beside them.\nAn interrupted job \
    is taken up again when it is started with the same --out.\n\nExamples:\n  crossgrain reproduce\n  crossgrain reproduce --recorded\n  \
    crossgrain reproduce --baseline main --summary summary.md --junit checks.xml\n  \
    crossgrain reproduce --perturb stiffness=1e-3 --out faulty"
)]
pub struct Arguments {
    /// The folder to write; a finished job in it is kept, with a number after its name
    #[arg(long, value_name = "DIR", default_value = "out/reproduce")]
    out: PathBuf,
    /// Two more realizations, whole, against YADE's sorted loop
    #[arg(long)]
    full: bool,
    /// Leave YADE out, and hold the native run against the recorded one alone
    #[arg(long, conflicts_with = "full")]
    recorded: bool,
    /// Another scene than the paper's
    #[arg(long)]
    scene: Option<PathBuf>,
    #[command(flatten)]
    limits: YadeLimits,
    /// Show the record in this folder of a finished tradeoff, stability, search, candidates or claims study instead of the recorded
    /// one
    #[arg(long, value_name = "DIR")]
    with: Vec<PathBuf>,
    /// Put a deliberate fault into the native engine, such as stiffness=1e-3, to see that the job would notice
    #[arg(long, value_name = "FAULT")]
    perturb: Option<Fault>,
    /// Hold the run against this baseline: what changed stands second on the page, and what is worse fails
    #[arg(long, value_name = "NAME")]
    baseline: Option<String>,
    #[command(flatten)]
    at: Where,
    #[command(flatten)]
    files: Files,
    /// No progress
    #[arg(long)]
    quiet: bool,
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        let scene = match &self.scene {
            Some(path) => read_scene(path)?,
            None => paper_scene(1, 5000),
        };
        if scene.in_space() {
            let why = "it is in space (box.depth), and this checks the paper's figures, which are of the plane; `run`, `compare` and `study plan campaign` take it";
            return Err(Error::Usage(why.to_owned()));
        }
        // A name that is wrong is said before hours of work, not after.
        let baseline = self.baseline.as_ref();
        let baseline = baseline
            .map(|name| self.at.store().load(name))
            .transpose()?;
        // Without YADE the job does less; one that was named is meant to be there.
        if let (Some(program), false) = (self.limits.yade.as_deref(), self.recorded) {
            yade::find(Some(program))?;
        }
        // The recorded ones are of the paper's scene.
        let beside = Beside::read(&self.with, self.scene.is_none())?;
        let out = &self.out;
        let has = |name: &str| Place::from((out, name)).is_taken();
        if has("report.html") && !has("native") && !has(RECORD) {
            return Err(Error::Usage(format!(
                "{} holds a report.html that is not of this job; name another folder",
                out.display()
            )));
        }
        let _lock = open(out, RECORD)?;
        let display = Display::new(self.quiet);
        let options = Options {
            out: out.clone(),
            scene,
            full: self.full,
            suite: self.scene.is_none(),
            recorded: self.recorded,
            yade: self.limits.options(),
            fault: self.perturb,
            beside,
            command: self.command(),
        };
        let (reproduction, runs) = reproduce(&options, &display)?;
        unless_ended()?;
        let scene = json(&runs.native.scene)?;
        write_whole((out, "scene.json"), scene.as_bytes())?;
        let found = Found {
            checks: reproduction.checks(),
            measured: measured(&runs.native),
            speeds: reproduction.speeds(),
        };
        let kind = Machine::this().kind();
        let (text, record) = record::write("reproduce", &reproduction, kind, found)?;
        let diff = baseline.map(|baseline| diff(&baseline, &record));
        let mut documents = reproduction.documents(&runs, &options.beside, diff.as_ref())?;
        // What a baseline has and this run has not is missing evidence too; all views count alike.
        let of_baseline = || diff.iter().flat_map(baseline::checks);
        if let Some((_, first)) = documents.first_mut() {
            first.checks.extend(of_baseline());
        }
        let against = |name: &str| diff.as_ref().filter(|_| name == FIRST);
        let page =
            |(name, document): &(&str, Document)| page_against(name, document, against(name));
        let pages: Vec<Page> = documents.iter().map(page).collect();
        let judged = |document: Document| Document {
            verdict: checks::verdict(&document.checks),
            answer: match &diff {
                Some(diff) => format!("{}. {}", diff.answer(), document.answer),
                None => document.answer,
            },
            ..document
        };
        if let Some((_, first)) = documents.into_iter().next() {
            self.files.write(&record.job, &judged(first))?;
        }
        finish(out, &pages, RECORD, &text)?;
        let mut summary = reproduction.summary();
        summary.checks.extend(of_baseline());
        let mut summary = judged(summary);
        let verdict = summary.verdict;
        summary
            .sections
            .extend(diff.iter().map(|diff| diff.section(false)));
        let words = terminal(&summary) + &page_line(out);
        print(&(words + &what_next(&reproduction, &record, out)))?;
        Ok(verdict.exit_code())
    }

    fn command(&self) -> String {
        let options = [
            flag(self.full, "--full"),
            flag(self.recorded, "--recorded"),
            flag(self.scene.is_some(), "--scene scene.json"),
            self.perturb.map(|fault| format!("--perturb {fault}")),
            (self.baseline.as_ref()).map(|name| format!("--baseline {name}")),
        ];
        with_options("crossgrain reproduce", options)
    }
}

/// What to do about a failure, or about a job that could compare nothing.
fn what_next(reproduction: &Reproduction, record: &Record, out: &Path) -> String {
    let mut text = String::new();
    if record.verdict == Outcome::Fail {
        let path = out.join(RECORD);
        text += &format!(
            "crossgrain report checks {} names all; crossgrain report explain CHECK says what one means and what usually breaks it\n",
            path.display()
        );
    }
    if reproduction.comparisons.is_empty() {
        text += "nothing was compared with another engine: install YADE (ci/install_yade), or hold the run against one of your own \
                 (crossgrain report baseline save, then reproduce --baseline)\n";
    }
    text
}
