//! `crossgrain engine`: whether an external engine does what the protocol and the model say. And engines as they are named on the
//! command line.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use serde::Serialize;

use super::job_folder::Results;
use super::report::Output;
use super::run::{YadeArguments, YadeLimits};
use super::{flag, with_options, with_progress};
use crate::checks::record;
use crate::compare::first_steps::{Beds, identified, identify, sentence};
use crate::compare::from_runs::states_of;
use crate::document::{Document, Section};
use crate::engine::Description;
use crate::engine::named::Named;
use crate::error::Error;
use crate::files::{Place, work_folder};
use crate::limits::bench::machine::Machine;
use crate::report;
use crate::report::packing::grains_left;
use crate::run::folder::read_scene;
use crate::suite::card::card;
use crate::suite::conformance::{conformance, table};
use grains::rules::{CATALOGUE, Rules};
use verdict::judge::Judgement;
use verdict::starts::DISPERSION;

#[derive(Debug, Subcommand)]
#[command(after_help = "Example:\n  crossgrain engine check exec:adapters/toy.py")]
pub enum Verb {
    /// Say whether an engine is the model's engine to the bit or to rounding, and what is wrong if it is not
    Check(Arguments),
    /// The conformance table: engines before one judge, with what each cannot express
    Table(TableArguments),
    /// Find the rules that an engine computes with, whatever it declares
    Identify(IdentifyArguments),
    /// What an engine's parameters really mean: each asked for and read from how a grain moves
    Card(CardArguments),
    /// The rules in which codes differ that compute one law, with the alternatives of each, as Markdown
    #[command(after_help = "Example:\n  crossgrain engine rules")]
    Rules,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Without --dispersion LAMMPS and LIGGGHTS get a bed of one radius, for their adapters have a stiffness for each radius \
    and only so many of them.\n\nExit codes: 0 all are identical or equal to rounding under the rules that they declare; 1 one differs; 3 undecided, \
    or one is not installed.\n\nExamples:\n  crossgrain engine table\n  crossgrain engine table --installed --out conformance\n  crossgrain engine table \
    lammps exec:./mine"
)]
pub struct TableArguments {
    /// yade-sorted, yade-ordinary, lammps, liggghts, esysparticle, kratos, toy or exec:PATH; all but the last if none is named
    #[arg(value_name = "ENGINE", value_parser = judged)]
    engines: Vec<Named>,
    /// Grains of the beds whose first steps are judged
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(50..=100_000))]
    grains: u32,
    /// How much the radii of every bed differ, as a share of their mean
    #[arg(long, value_parser = dispersion)]
    dispersion: Option<f64>,
    /// Engines that are not installed count for nothing
    #[arg(long)]
    installed: bool,
    #[command(flatten)]
    results: Results,
    #[command(flatten)]
    output: Output,
    #[command(flatten)]
    limits: YadeLimits,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Exit codes: 0 identical or equal to rounding; 1 different; 2 usage; 3 undecided; 4 the engine failed (it crashed, hung or was not \
    understood).\n\nExamples:\n  crossgrain engine check exec:adapters/toy.py\n  crossgrain engine check exec:./mine --scene mine.json\n  crossgrain engine check yade --loop ordinary"
)]
pub struct Arguments {
    /// yade, or exec:PATH, a program that speaks the engine protocol (docs/engine-protocol.md)
    #[arg(value_parser = one)]
    engine: Named,
    /// Grains of the bed whose first steps are judged
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(50..=100_000))]
    grains: u32,
    /// How much the radii of the bed differ, as a share of their mean; 0 for an engine that has one radius
    #[arg(long, default_value_t = DISPERSION, value_parser = dispersion)]
    dispersion: f64,
    /// Judge from this scene's states, as the native engine runs it to its end, in place of the paper's bed
    #[arg(long, value_name = "FILE", conflicts_with_all = ["grains", "dispersion"])]
    scene: Option<PathBuf>,
    /// Hold it against itself in every state, and not in one; an engine with a law of its own always is
    #[arg(long)]
    against_itself: bool,
    #[command(flatten)]
    results: Results,
    #[command(flatten)]
    output: Output,
    #[command(flatten)]
    yade: YadeArguments,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Exit codes: 0 identical or equal to rounding under the rules that were found; 1 different under any; 3 undecided; 4 the engine \
    failed.\n\nExamples:\n  crossgrain engine identify exec:./mine\n  crossgrain engine identify lammps --dispersion 0"
)]
pub struct IdentifyArguments {
    /// yade-sorted, yade-ordinary, lammps, liggghts, esysparticle, kratos, toy or exec:PATH
    #[arg(value_parser = judged)]
    engine: Named,
    /// Grains of the bed whose first steps are looked at
    #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u32).range(50..=100_000))]
    grains: u32,
    /// How much the radii of the bed differ, as a share of their mean; 0 for an engine that has one radius
    #[arg(long, default_value_t = DISPERSION, value_parser = dispersion)]
    dispersion: f64,
    #[command(flatten)]
    results: Results,
    #[command(flatten)]
    output: Output,
    #[command(flatten)]
    limits: YadeLimits,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Exit codes: 0 all constants are what was asked for, or what the rules that it declares make of it; 1 one is not; 3 nothing was asked; \
    4 the engine failed.\n\nExamples:\n  crossgrain engine card exec:./mine\n  crossgrain engine card lammps --out card"
)]
pub struct CardArguments {
    /// yade-sorted, yade-ordinary, lammps, liggghts, esysparticle, kratos, toy or exec:PATH
    #[arg(value_parser = judged)]
    engine: Named,
    #[command(flatten)]
    results: Results,
    #[command(flatten)]
    output: Output,
    #[command(flatten)]
    limits: YadeLimits,
}

const CARD: &str = "card.json";
const IDENTIFIED: &str = "identified.json";
const CHECK: &str = "check.json";
const TABLE: &str = "conformance.json";

const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The record of a check, or a card, beside what all records have.
#[derive(Serialize)]
struct Checked<'a, T> {
    crossgrain: &'static str,
    command: String,
    #[serde(flatten)]
    found: &'a T,
}

/// Writes the record of a verb, by the names of its job and its file, tells what it says and gives the exit code.
fn finish(
    [job, file]: [&str; 2],
    own: &impl Serialize,
    document: &Document,
    results: &Results,
    output: &Output,
) -> Result<u8, Error> {
    let (found, machine) = (document.checks[..].into(), Machine::this().kind());
    let (text, _) = record::write(job, own, machine, found)?;
    results.finish(&output.views, job, (file, &text), document)
}

/// Grains of a bed that stays a bed.
fn dispersion(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..=0.3).contains(&value) => Ok(value),
        Ok(_) => Err("it is 0 to 0.3".to_owned()),
        Err(_) => Err("it is a number".to_owned()),
    }
}

impl Verb {
    pub fn execute(self) -> Result<u8, Error> {
        match self {
            Verb::Check(arguments) => arguments.execute(),
            Verb::Table(arguments) => arguments.execute(),
            Verb::Identify(arguments) => arguments.execute(),
            Verb::Card(arguments) => arguments.execute(),
            Verb::Rules => {
                print!("{}", rules());
                Ok(0)
            }
        }
    }
}

/// The catalogue of rules as a page of Markdown, `docs/rules.md`.
pub fn rules() -> String {
    let mut page = "# Rules\n\nConventions in which codes differ that compute one law. The first alternative of each is this program's. A scene sets others in \
                    `rules`, an engine declares those that it has in its description. Made by `crossgrain engine rules`.\n"
        .to_owned();
    for rule in CATALOGUE {
        page += &format!(
            "\n## {}\n\n{}.\n\n| alternative | what is computed | which code |\n|---|---|---|\n",
            rule.key,
            sentence(rule.about)
        );
        for alternative in rule.alternatives {
            let codes = if alternative.codes.is_empty() {
                "–"
            } else {
                alternative.codes
            };
            let formula = alternative.formula.replace('|', "\\|");
            page += &format!("| `{}` | {formula} | {codes} |\n", alternative.key);
        }
    }
    page + include_str!("rules_that_matter.md") + include_str!("laws_in_space.md")
}

impl Arguments {
    fn execute(self) -> Result<u8, Error> {
        if self.engine == Named::Native {
            return Err(Error::Usage(
                "the native engine is what others are held against: yade, or exec:PATH; `crossgrain verify` verifies it"
                    .to_owned(),
            ));
        }
        self.results.check(CHECK)?;
        let asked = match &self.engine {
            Named::Exec(program) => format!("exec:{}", program.display()),
            _ => format!("yade{}", self.yade.words()),
        };
        let found = with_progress(self.output.quiet, "engine check", |task| {
            let mut beds = match &self.scene {
                Some(path) => {
                    let scene = read_scene(path)?;
                    task.share(0.0, "native runs the scene");
                    Beds::from(states_of(&scene)?)
                }
                None => Beds::new(self.grains, self.dispersion),
            };
            beds.thorough = self.against_itself;
            let engine = self.yade.engine(&self.engine)?;
            let mut progress = |name: &str| task.share(0.0, name);
            Ok(conformance(engine.as_ref(), &beds, &mut progress)?)
        })?;
        let from = match &self.scene {
            Some(_) => "--scene FILE".to_owned(),
            None => format!("--grains {} --dispersion {}", self.grains, self.dispersion),
        };
        let thorough = flag(self.against_itself, "--against-itself");
        let command = with_options(
            &format!("crossgrain engine check {asked} {from}"),
            [thorough],
        );
        let mut made = format!("crossgrain {VERSION}: `{command}`.");
        let (bed, asked_for) = (found.first_steps.as_ref(), self.grains);
        if let Some(bed) = bed
            .map(|steps| steps.grains)
            .filter(|bed| (1..asked_for as usize).contains(bed) && self.scene.is_none())
        {
            made +=
                &format!(" The engine refused a bed of {asked_for} grains and was given {bed}.");
        }
        let own = Checked {
            crossgrain: VERSION,
            command,
            found: &found,
        };
        let mut document = found.document();
        document.title += &format!(" ({asked})");
        let causes = found.first_steps.iter().flat_map(|steps| &steps.causes);
        let places = Section::new("Where", "").with_all(causes.filter_map(grains_left));
        let made = Section::new("How this was made", made);
        let more = [places]
            .into_iter()
            .filter(|section| !section.blocks.is_empty());
        document.sections.extend(more.chain([made]));
        let names = ["engine check", CHECK];
        finish(names, &own, &document, &self.results, &self.output)
    }
}

/// The record of what was identified beside what all records have.
#[derive(Serialize)]
struct OfRules<'a> {
    crossgrain: &'static str,
    command: String,
    engine: &'a Description,
    rules: Rules,
    also: Vec<String>,
    unasked: &'a [&'static str],
    first_steps: &'a Judgement,
}

impl IdentifyArguments {
    fn execute(self) -> Result<u8, Error> {
        self.results.check(IDENTIFIED)?;
        let (key, grains, dispersion) = (self.engine.key(), self.grains, self.dispersion);
        let found = with_progress(self.output.quiet, "engine identify", |task| {
            let folder = work_folder()?;
            let engine = self.engine.engine(&self.limits.options(), folder.path())?;
            let mut progress = |name: &str| task.share(0.0, name);
            let described = engine.describe()?;
            let found = identify(engine.as_ref(), grains, dispersion, &mut progress)?;
            Ok((described, found))
        });
        let (described, found) = found?;
        let own = OfRules {
            crossgrain: VERSION,
            command: format!(
                "crossgrain engine identify {key} --grains {grains} --dispersion {dispersion}"
            ),
            engine: &described,
            rules: found.rules,
            also: found.also.iter().map(|choice| choice.name()).collect(),
            unasked: &found.unasked,
            first_steps: &found.judgement,
        };
        let document = identified(&described, &found);
        let names = ["engine identify", IDENTIFIED];
        finish(names, &own, &document, &self.results, &self.output)
    }
}

impl CardArguments {
    fn execute(self) -> Result<u8, Error> {
        self.results.check(CARD)?;
        let folder = work_folder()?;
        let engine = self.engine.engine(&self.limits.options(), folder.path())?;
        let card = card(engine.as_ref())?;
        let document = card.document();
        let own = Checked {
            crossgrain: VERSION,
            command: format!("crossgrain engine card {}", self.engine.key()),
            found: &card,
        };
        let names = ["engine card", CARD];
        finish(names, &own, &document, &self.results, &self.output)
    }
}

impl TableArguments {
    fn execute(self) -> Result<u8, Error> {
        self.results.check(TABLE)?;
        let candidates = match &self.engines[..] {
            [] => table::all(),
            named => named.to_vec(),
        };
        let options = table::Options {
            grains: self.grains,
            dispersion: self.dispersion,
            installed: self.installed,
            yade: self.limits.options(),
            command: self.command(),
        };
        let made = with_progress(self.output.quiet, "engine table", |task| {
            let mut progress = |name: &str| task.share(0.0, name);
            Ok(table::table(&candidates, &options, &mut progress)?)
        })?;
        let (found, machine) = (made.checks[..].into(), Machine::this().kind());
        let (text, record) = record::write("conformance", &made, machine, found)?;
        let document = made.document();
        self.output.views.tell(&record.job, &text, &document)?;
        let markdown = report::markdown(&document);
        let files = [(TABLE, text.as_str()), ("conformance.md", &markdown)];
        self.results.write(&document, &files)?;
        Ok(record.verdict.exit_code())
    }

    fn command(&self) -> String {
        let options = [
            Some(format!("--grains {}", self.grains)),
            self.dispersion
                .map(|dispersion| format!("--dispersion {dispersion}")),
            flag(self.installed, "--installed"),
        ];
        let engines = self
            .engines
            .iter()
            .map(|engine| format!(" {}", engine.key()));
        with_options("crossgrain engine table", options) + &engines.collect::<String>()
    }
}

/// One engine.
pub fn one(text: &str) -> Result<Named, String> {
    match Named::parse(text) {
        Some(named @ (Named::Native | Named::Yade(None) | Named::Exec(_))) => Ok(named),
        _ if Place::from(text).is_file() => Err(format!(
            "a program that is an engine is written exec:{text}"
        )),
        _ => Err(
            "an engine is native, yade or exec:PATH, such as exec:adapters/lammps.py or exec:adapters/toy.py"
                .to_owned(),
        ),
    }
}

/// The engines of this program, one or both, or an external one.
pub type Several = Vec<Named>;

pub fn several(text: &str) -> Result<Several, String> {
    match (text, Named::parse(text)) {
        ("both", _) => Ok(vec![Named::Native, Named::Yade(None)]),
        (_, Some(named @ (Named::Native | Named::Yade(None) | Named::Exec(_)))) => Ok(vec![named]),
        _ => Err("an engine is native, yade, both or exec:PATH".to_owned()),
    }
}

/// As a command has them, a path left out: it belongs to a machine.
pub fn name(engines: &Several) -> &'static str {
    match &engines[..] {
        [one] => one.key(),
        _ => "both",
    }
}

/// An external engine, beside those of this program.
pub fn beside(text: &str) -> Result<PathBuf, String> {
    match Named::parse(text) {
        Some(Named::Exec(path)) => Ok(path),
        _ => Err(
            "native and YADE take part anyway; one more engine is named as exec:PATH".to_owned(),
        ),
    }
}

/// An engine of the conformance table.
fn judged(text: &str) -> Result<Named, String> {
    let all = table::all();
    let keys: Vec<&str> = all.iter().map(Named::key).collect();
    let known = format!("an engine is {} or exec:PATH", keys.join(", "));
    let named = Named::parse(text);
    named
        .filter(|named| matches!(named, Named::Exec(_)) || all.contains(named))
        .ok_or(known)
}
