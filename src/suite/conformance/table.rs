//! The conformance table: engines before one judge, each with what it cannot express.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::str::FromStr;

use clap::ValueEnum;
use serde::Serialize;

use super::{Conformance, conformance, of_yade};
use crate::checks::{Check, Outcome, slug, verdict};
use crate::compare::first_steps::{self, Beds};
use crate::document::{Document, Section, Table};
use crate::engine::exec::{self, Adapter, Part};
use crate::engine::{ProgramError, yade};
use crate::files::work_folder;
use crate::run::EngineError;
use verdict::causes::Cause;
use verdict::envelope::FACTOR;
use verdict::judge::{Judgement, Verdict};
use verdict::starts::DISPERSION;

#[derive(Debug, Clone, PartialEq)]
pub enum Candidate {
    /// In its sorted or in its ordinary loop.
    Yade { sorted: bool },
    /// One with an adapter that comes with this program.
    Adapter(Adapter),
    /// A program that speaks the engine protocol.
    Exec(PathBuf),
}

impl Candidate {
    pub fn all() -> Vec<Candidate> {
        let yade = [true, false].map(|sorted| Candidate::Yade { sorted });
        let adapters = Adapter::ALL.map(Candidate::Adapter);
        yade.into_iter().chain(adapters).collect()
    }

    pub fn key(&self) -> &str {
        match self {
            Candidate::Yade { sorted: true } => "yade-sorted",
            Candidate::Yade { sorted: false } => "yade-ordinary",
            Candidate::Adapter(adapter) => adapter.key,
            Candidate::Exec(_) => "exec:PATH",
        }
    }

    fn name(&self) -> &str {
        match self {
            Candidate::Yade { .. } => "YADE",
            Candidate::Adapter(adapter) => adapter.name,
            Candidate::Exec(_) => self.key(),
        }
    }

    /// How much radii may differ without an approximation of the adapter's.
    fn dispersion(&self) -> f64 {
        let of_one_radius = [Adapter::LAMMPS, Adapter::LIGGGHTS, Adapter::ESYS_PARTICLE];
        match self {
            Candidate::Adapter(adapter) if of_one_radius.contains(adapter) => 0.0,
            _ => DISPERSION,
        }
    }

    /// How it is known to differ, as the beginning of the sentence that says so.
    fn known_difference(&self) -> Option<&'static str> {
        let so = [Adapter::ESYS_PARTICLE, Adapter::KRATOS].map(Candidate::Adapter);
        (so.contains(self)).then_some("the sign in the damping is that of a·(v + 0·Δt·a)")
    }
}

impl FromStr for Candidate {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(path) = text.strip_prefix("exec:").filter(|path| !path.is_empty()) {
            return Ok(Candidate::Exec(PathBuf::from(path)));
        }
        let all = Candidate::all();
        let keys: Vec<&str> = all.iter().map(Candidate::key).collect();
        let known = format!("an engine is {} or exec:PATH", keys.join(", "));
        all.iter().find(|of| of.key() == text).cloned().ok_or(known)
    }
}

#[derive(Debug, Clone)]
pub struct Options {
    pub grains: u32,
    /// Of the radii of every bed, instead of one that each engine can express.
    pub dispersion: Option<f64>,
    /// Engines that are not installed count for nothing.
    pub installed: bool,
    /// YADE, and the limits of all.
    pub yade: yade::Options,
    pub command: String,
}

#[derive(Debug, Clone, Serialize)]
pub struct ConformanceTable {
    pub crossgrain: &'static str,
    pub command: String,
    /// In the order in which they were named.
    pub engines: Vec<Row>,
    #[serde(skip)]
    pub checks: Vec<Check>,
}

#[derive(Debug, Clone, Serialize)]
pub struct Row {
    pub key: String,
    /// Its name, with its version if it is here.
    pub name: String,
    /// How much the radii of its bed differ, as a share of their mean.
    pub dispersion: f64,
    /// Where it stands on the ladder; undecided if it is not installed.
    pub verdict: Verdict,
    /// It differs as it is known to, and in nothing else.
    pub as_known: bool,
    pub not_installed: Option<String>,
    pub found: Option<Conformance>,
}

pub fn table(
    candidates: &[Candidate],
    options: &Options,
    progress: &mut dyn FnMut(&str),
) -> Result<ConformanceTable, EngineError> {
    let mut made = ConformanceTable {
        crossgrain: env!("CARGO_PKG_VERSION"),
        command: options.command.clone(),
        engines: Vec::new(),
        checks: Vec::new(),
    };
    let mut beds = BTreeMap::new();
    for candidate in candidates {
        let dispersion = options.dispersion.unwrap_or(candidate.dispersion());
        let known = beds.entry(dispersion.to_bits());
        let beds = known.or_insert_with(|| Beds::new(options.grains, dispersion));
        let key = candidate.key();
        let mut progress = |what: &str| progress(&format!("{key}: {what}"));
        let (found, not_installed) = match judged(candidate, beds, options, &mut progress) {
            Ok(found) => (Some(found), None),
            Err(EngineError::Program(error)) if is_not_installed(candidate, &error) => {
                (None, Some(error.to_string()))
            }
            Err(error) => return Err(error),
        };
        let label = |of: &Conformance| of.engine.label();
        let mut row = Row {
            key: key.to_owned(),
            name: found.as_ref().map_or(candidate.name().to_owned(), label),
            dispersion,
            verdict: (found.as_ref()).map_or(Verdict::Undecided, Conformance::verdict),
            as_known: false,
            not_installed,
            found,
        };
        let known = candidate.known_difference();
        row.as_known = known.is_some_and(|known| row.differs_only_so(known));
        let check = row.check(known.is_some());
        made.checks.push(match row.not_installed {
            Some(_) if options.installed => check,
            _ => check.required(),
        });
        made.engines.push(row);
    }
    Ok(made)
}

fn judged(
    candidate: &Candidate,
    beds: &Beds,
    options: &Options,
    progress: &mut dyn FnMut(&str),
) -> Result<Conformance, EngineError> {
    let limits = &options.yade.limits;
    match candidate {
        Candidate::Yade { sorted } => {
            let mut yade = options.yade.clone();
            yade.sorted = *sorted;
            of_yade(&yade, beds, progress)
        }
        Candidate::Adapter(adapter) => {
            let folder = work_folder().map_err(ProgramError::File)?;
            let engine = adapter.place(folder.path(), limits)?;
            conformance(&engine.options, beds, progress)
        }
        Candidate::Exec(program) => {
            let engine = exec::Options {
                program: program.clone(),
                limits: limits.clone(),
            };
            conformance(&engine, beds, progress)
        }
    }
}

/// An adapter of this program says what it is unless what it translates for cannot be started.
fn is_not_installed(candidate: &Candidate, error: &ProgramError) -> bool {
    let undescribed = matches!(error, ProgramError::Undescribed { .. });
    error.is_missing() || undescribed && matches!(candidate, Candidate::Adapter(_))
}

impl Row {
    fn judgement(&self) -> Option<&Judgement> {
        self.found.as_ref()?.first_steps.as_ref()
    }

    /// How far it is from the native run, over the replicas, at most.
    fn ratio(&self) -> Option<f64> {
        Some(self.judgement()?.farthest()?.farthest.as_ref()?.ratio)
    }

    fn said(&self) -> String {
        match (&self.not_installed, self.judgement(), &self.found) {
            (Some(why), ..) => why.clone(),
            (_, Some(judgement), _) => first_steps::answer(judgement),
            (_, _, Some(found)) => found.answer(),
            _ => String::new(),
        }
    }

    /// What it has not of the model, in words.
    fn lacks(&self) -> Vec<String> {
        let Some(found) = &self.found else {
            return Vec::new();
        };
        let parts = Part::value_variants().iter().copied();
        let parts = parts.filter(|part| !found.engine.has(*part));
        let mut lacks: Vec<String> = parts.map(Part::in_words).collect();
        if lacks.is_empty() {
            let not_asked = self.judgement().map_or(&[][..], |of| &of.not_asked);
            lacks.extend(not_asked.iter().map(|of| of.lacking.clone()));
            let mut seen = BTreeSet::new();
            lacks.retain(|of| seen.insert(of.clone()));
        }
        lacks
    }

    fn differs_only_so(&self, known: &str) -> bool {
        let causes = self.judgement().map_or(&[][..], |of| &of.causes);
        let so = |of: &Cause| of.explained && of.sentence().starts_with(known);
        self.verdict == Verdict::Different && !causes.is_empty() && causes.iter().all(so)
    }

    fn words(&self) -> &'static str {
        match (&self.not_installed, self.as_known) {
            (Some(_), _) => "not installed",
            (_, true) => "different as known",
            _ => self.verdict.in_words(),
        }
    }

    /// Passed where it is the model's engine; expected to fail where it is known how it differs.
    fn check(&self, is_known_to_differ: bool) -> Check {
        let outcome = match (&self.not_installed, is_known_to_differ) {
            (Some(_), _) => Outcome::Skipped,
            (_, false) => self.verdict.into(),
            _ if self.as_known => Outcome::ExpectedFailure,
            _ => Outcome::Fail,
        };
        let id = format!("conformance/{}", slug(&self.key));
        let quantity = format!("{}, first hundred steps from a bed", self.name);
        let found = format!("{}: {}", self.words(), self.said());
        let ratio = self.ratio().unwrap_or(f64::NAN);
        Check::of_words(id, &quantity, outcome, &found).with_limits(ratio, 0.0, Some(FACTOR))
    }
}

impl ConformanceTable {
    pub fn document(&self) -> Document {
        let engines = Table::of("engines", "", &self.engines)
            .column("engine", |of: &Row| &of.name)
            .column("verdict", |of| of.words())
            .column("times as far as replicas", Row::ratio)
            .column("grains", |of| of.judgement().map(|of| of.grains))
            .column("radii", |of| match of.dispersion {
                0.0 => "one".to_owned(),
                dispersion => format!("±{} %", 100.0 * dispersion),
            })
            .column("computes in", |of| Some(of.judgement()?.resolution.name()));
        let found = self.engines.iter();
        let found = found.map(|of| format!("{}: {}", of.name, of.said()));
        let cannot = Table::of("cannot-express", "", &self.engines)
            .column("engine", |of: &Row| &of.name)
            .column("has no", |of| of.lacks().join(", "))
            .column("otherwise than the model", |of| {
                let engine = of.found.as_ref().map(|of| &of.engine);
                engine.map(|of| of.approximations.join("; "))
            });
        let judged = |row| Some((row, Row::judgement(row)?));
        let states = self.engines.iter().filter_map(judged);
        let states = states.flat_map(|(row, of)| of.starts.iter().map(move |start| (row, start)));
        let states = Table::of("states", "", states)
            .column("engine", |(row, _)| &row.name)
            .column("law", |(_, of)| &of.law)
            .column("state", |(_, of)| &of.start)
            .column("verdict", |(_, of)| of.verdict.in_words())
            .column("times as far as replicas", |(_, of)| {
                of.farthest.as_ref().map(|of| of.ratio)
            });
        let about = "The first hundred steps from a bed in four states, under the laws that an engine says it has, are held against the \
                     native engine's. Replicas are native runs with rounding errors as coarse as the engine's in every step.";
        let about = format!("{about} Up to {FACTOR} times as far as they are is rounding.");
        let neither_way = "States that ask for it count neither way.";
        Document {
            title: "Conformance table".to_owned(),
            verdict: verdict(&self.checks),
            answer: self.answer(),
            sections: vec![
                Section::new("Engines", about).with(engines),
                Section::new("What was found", "").with_all(found),
                Section::new("What each cannot express", neither_way).with(cannot),
                Section::new("State by state", "").with(states).as_details(),
            ],
            checks: self.checks.clone(),
        }
    }

    fn answer(&self) -> String {
        let mut counted: Vec<(&str, usize)> = Vec::new();
        for words in self.engines.iter().map(Row::words) {
            match counted.iter_mut().find(|(known, _)| *known == words) {
                Some((_, count)) => *count += 1,
                None => counted.push((words, 1)),
            }
        }
        let counted = counted.iter();
        let counted = counted.map(|(words, count)| format!("{count} {words}"));
        let counted = counted.collect::<Vec<_>>().join(", ");
        format!("Of {} engines {counted}", self.engines.len())
    }
}
