//! `crossgrain report history` and `crossgrain report bisect`: when something changed, and by which commit.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;

use super::job_folder::Results;
use super::report::{Views, Where};
use super::{json, tell};
use crate::compare::baseline::bisect::{Bisection, bisect, git};
use crate::compare::baseline::history::History as Kept;
use crate::error::{Error, exit};
use crate::progress::say;

#[derive(Debug, Args)]
#[command(
    after_help = "A speed has changed when its rounds lie apart from those of the record where its level began, by 5 % of the median \
    at least (single values: by half; instructions: by 1 %), in two records one after the other. Times are ratios, and only those of the \
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
    pub fn execute(self) -> Result<u8, Error> {
        self.results.check(RECORD)?;
        let store = self.at.store();
        let mut names = store.names()?;
        let mut subjects = BTreeMap::new();
        if let Some(repository) = &self.repository {
            let commits = git(
                repository,
                &["log", "--reverse", "--topo-order", "--format=%H %s"],
            )?;
            let commits = commits.lines().filter_map(|line| line.split_once(' '));
            let all = names.len();
            let mut in_order = Vec::new();
            for (commit, subject) in commits {
                if let Some(name) = names
                    .iter()
                    .find(|of| of.len() >= 7 && commit.starts_with(*of))
                {
                    in_order.push(name.clone());
                    subjects.insert(name.clone(), subject.to_owned());
                }
            }
            names = in_order;
            if names.len() < all {
                say(&format!(
                    "{} of {all} records are of commits that are not in HEAD's history; they are left out",
                    all - names.len()
                ));
            }
        }
        let records = names.iter().map(|name| store.load(name));
        let records: Vec<_> = records.collect::<Result<_, _>>()?;
        let [_, .., last] = &records[..] else {
            return Err(Error::Usage(format!(
                "a history needs two records, and there are {}; crossgrain report baseline save keeps one",
                records.len()
            )));
        };
        if let Some(other) = records.iter().find(|of| of.record.job != last.record.job) {
            return Err(Error::Usage(format!(
                "{} is of {}, {} of {}; keep the records of each job in a store of their own",
                other.name, other.record.job, last.name, last.record.job
            )));
        }
        let kept = Kept::of(&records);
        let subject = |name: &str| subjects.get(name).cloned().unwrap_or_default();
        let document = kept.document(&last.record, subject);
        let text = json(&kept)?;
        self.views.tell("report history", &text, &document)?;
        self.results.write(&document, &[(RECORD, &text)])?;
        Ok(document.verdict.exit_code())
    }
}

#[derive(Debug, Args)]
#[command(
    after_help = "Each commit is checked out in a temporary place, emptied of ignored files before the command runs; a build that is \
    not to begin anew keeps its files elsewhere (CARGO_TARGET_DIR). A commit where the check cannot be made is skipped.\nExit code 0: the \
    commit was found; 3: several are left that cannot be told apart.\n\nExample:\n  \
    crossgrain report bisect a-collision/velocity --good v1 --bad HEAD --record out/verify.json -- \
    crossgrain verify --engine exec:./engine.py --out out"
)]
pub struct Bisect {
    /// Id of a check or a speed, as `report checks --all` prints it
    id: String,
    /// A commit where it is right
    #[arg(long, value_name = "COMMIT")]
    good: String,
    /// A later commit, where it is not
    #[arg(long, value_name = "COMMIT", default_value = "HEAD")]
    bad: String,
    #[arg(long, value_name = "DIR", default_value = ".")]
    repository: PathBuf,
    /// The record that the command writes, as seen from the top of the checkout
    #[arg(long, value_name = "FILE")]
    record: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// What makes the record of a commit
    #[arg(required = true, last = true)]
    command: Vec<String>,
}

impl Bisect {
    pub fn execute(self) -> Result<u8, Error> {
        let of = Bisection {
            repository: &self.repository,
            command: &self.command,
            record: &self.record,
            id: &self.id,
        };
        let word = |as_before: Option<bool>| match as_before {
            Some(true) => "as before",
            Some(false) => "changed",
            None => "cannot be told",
        };
        let found = bisect(&of, [&self.good, &self.bad], |tried| {
            say(&format!(
                "{:.12} {}: {} ({})",
                tried.commit,
                tried.subject,
                word(tried.as_before),
                tried.found
            ));
        })?;
        let [first, ..] = &found.commits[..] else {
            return Err(Error::Report("git named no commit".to_owned()));
        };
        let words = || {
            if found.commits.len() > 1 {
                let all = found.commits.join(", ");
                return format!(
                    "{} changed in one of {all}; it could not be made there\n",
                    self.id
                );
            }
            let line = git(&self.repository, &["log", "-1", "--format=%h %s", first]);
            format!(
                "{} changed in {}\n",
                self.id,
                line.as_ref().unwrap_or(first)
            )
        };
        tell(self.json, &json(&found)?, words)?;
        Ok(match found.commits.len() {
            1 => exit::AGREED,
            _ => exit::INCOMPLETE,
        })
    }
}
