//! The conformance table: engines before one judge, each with what it cannot express.

use std::collections::{BTreeMap, BTreeSet};

use clap::ValueEnum;
use serde::Serialize;

use super::{Conformance, conformance};
use crate::checks::{Check, Outcome, slug, verdict};
use crate::compare::first_steps::{self, Beds};
use crate::document::{Document, Section, Table};
use crate::engine::exec::{Adapter, Part};
use crate::engine::named::Named;
use crate::engine::{ProgramError, yade};
use crate::files::work_folder;
use crate::run::EngineError;
use verdict::envelope::FACTOR;
use verdict::judge::{Judgement, Verdict};
use verdict::starts::DISPERSION;

/// The engines of the table if none is named.
pub fn all() -> Vec<Named> {
    let yade = [true, false].map(|sorted| Named::Yade(Some(sorted)));
    yade.into_iter()
        .chain(Adapter::ALL.map(Named::Adapter))
        .collect()
}

/// The name of one that is not here.
fn name(engine: &Named) -> &'static str {
    match engine {
        Named::Yade(_) => "YADE",
        Named::Adapter(adapter) => adapter.name,
        other => other.key(),
    }
}

/// How much radii may differ without an approximation of the adapter's.
fn dispersion(engine: &Named) -> f64 {
    let of_one_radius = [Adapter::LAMMPS, Adapter::LIGGGHTS];
    match of_one_radius.map(Named::Adapter).contains(engine) {
        true => 0.0,
        false => DISPERSION,
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
    pub not_installed: Option<String>,
    pub found: Option<Conformance>,
}

pub fn table(
    candidates: &[Named],
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
    for (at, candidate) in candidates.iter().enumerate() {
        let dispersion = options.dispersion.unwrap_or(dispersion(candidate));
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
        let label = |conformance: &Conformance| conformance.engine.label();
        // Several programs of one's own have a number each.
        let before = candidates[..at].iter().filter(|other| other.key() == key);
        let key = match before.count() {
            0 => key.to_owned(),
            count => format!("{key}-{}", count + 1),
        };
        let row = Row {
            key,
            name: found.as_ref().map_or(name(candidate).to_owned(), label),
            dispersion,
            verdict: (found.as_ref()).map_or(Verdict::Undecided, Conformance::verdict),
            not_installed,
            found,
        };
        let check = row.check();
        made.checks.push(match row.not_installed {
            Some(_) if options.installed => check,
            _ => check.required(),
        });
        made.engines.push(row);
    }
    Ok(made)
}

fn judged(
    candidate: &Named,
    beds: &Beds,
    options: &Options,
    progress: &mut dyn FnMut(&str),
) -> Result<Conformance, EngineError> {
    let folder = work_folder().map_err(ProgramError::File)?;
    let engine = candidate.engine(&options.yade, folder.path())?;
    conformance(engine.as_ref(), beds, progress)
}

/// An adapter of this program says what it is unless what it translates for cannot be started.
fn is_not_installed(candidate: &Named, error: &ProgramError) -> bool {
    let undescribed = matches!(error, ProgramError::Undescribed { .. });
    error.is_missing() || undescribed && matches!(candidate, Named::Adapter(_))
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
            let not_asked = self
                .judgement()
                .map_or(&[][..], |judgement| &judgement.not_asked);
            lacks.extend(not_asked.iter().map(|excerpt| excerpt.lacking.clone()));
            let mut seen = BTreeSet::new();
            lacks.retain(|part| seen.insert(part.clone()));
        }
        lacks
    }

    fn words(&self) -> String {
        let declares = self
            .judgement()
            .is_some_and(|judgement| !judgement.declared.is_empty());
        match (&self.not_installed, declares) {
            (Some(_), _) => "not installed".to_owned(),
            (_, true) => format!("{} under its own rules", self.verdict.in_words()),
            _ => self.verdict.in_words().to_owned(),
        }
    }

    /// Rules that it has otherwise than the model, and how far they move a grain.
    fn rules(&self) -> String {
        let declared = self
            .judgement()
            .map_or(&[][..], |judgement| &judgement.declared);
        let rules = declared
            .iter()
            .map(|declared| format!("{}: {:.1e} R", declared.rule, declared.moves));
        rules.collect::<Vec<_>>().join("; ")
    }

    /// Passed where it is the model's engine, under the rules that it declares.
    fn check(&self) -> Check {
        let outcome = match &self.not_installed {
            Some(_) => Outcome::Skipped,
            // It was held against no reference.
            None if self.verdict == Verdict::ConsistentWithItself => Outcome::Skipped,
            None => self.verdict.into(),
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
            .column("engine", |row: &Row| &row.name)
            .column("verdict", |row| row.words())
            .column("times as far as replicas", Row::ratio)
            .column("grains", |row| {
                row.judgement().map(|judgement| judgement.grains)
            })
            .column("radii", |row| match row.dispersion {
                0.0 => "one".to_owned(),
                dispersion => format!("±{} %", 100.0 * dispersion),
            })
            .column("computes in", |row| {
                Some(row.judgement()?.resolution.name())
            });
        let found = self.engines.iter();
        let found = found.map(|row| format!("{}: {}", row.name, row.said()));
        let cannot = Table::of("cannot-express", "", &self.engines)
            .column("engine", |row: &Row| &row.name)
            .column("has no", |row| row.lacks().join(", "))
            .column(
                "its own rules, and what they move in a hundred steps",
                Row::rules,
            )
            .column("otherwise than the model", |row| {
                let engine = row.found.as_ref().map(|conformance| &conformance.engine);
                engine.map(|engine| engine.approximations.join("; "))
            });
        let judged = |row| Some((row, Row::judgement(row)?));
        let states = self.engines.iter().filter_map(judged);
        let states = states
            .flat_map(|(row, judgement)| judgement.starts.iter().map(move |start| (row, start)));
        let states = Table::of("states", "", states)
            .column("engine", |(row, _)| &row.name)
            .column("law", |(_, state)| &state.law)
            .column("state", |(_, state)| &state.start)
            .column("verdict", |(_, state)| state.verdict.in_words())
            .column("times as far as replicas", |(_, state)| {
                state.farthest.as_ref().map(|farthest| farthest.ratio)
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
        let mut counted: Vec<(String, usize)> = Vec::new();
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
