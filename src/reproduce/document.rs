//! What the main job says: the evidence of its verdict first, and after it what is no part of the verdict.

use std::time::SystemTime;

use super::Runs;
use super::record::{Beside, Reproduction, Stated};
use crate::checks::{Check, Outcome};
use crate::compare::baseline::diff::Diff;
use crate::compare::first_steps;
use crate::document::{
    Axis, Block, Cell, Colour, Document, Plot, Point, Section, Style, Table, Tile,
};
use crate::error::Error;
use crate::limits::bench::machine::Machine;
use crate::paper;
use crate::report::disc_field::of_figure_4;
use crate::report::html::FIRST;
use crate::report::outcome::punch_bottom;
use crate::report::packing::pictures;
use crate::run::folder::RunFolder;
use grains::measure::HistoryRow;
use grains::tables::Stage;

const PAPER: &str = "I. G. Tejada, Stochastic modeling of stress fields in geotechnical problems with discrete media, \
                     Proceedings of the XVII ECSMGE, 2019, doi:10.32075/17ECSMGE-2019-1081";

impl Reproduction {
    /// The pages with their names, the first one first: verdict, tiles and evidence there, studies and details on pages of their
    /// own. `beside` are the records of other jobs, `diff` is against a baseline.
    pub fn documents(
        &self,
        runs: &Runs,
        beside: &Beside,
        diff: Option<&Diff>,
    ) -> Result<Vec<(&'static str, Document)>, Error> {
        let mut others = vec![("measures", self.measures(runs)), ("paper", self.paper())];
        if let Some(suite) = &self.suite {
            let mut document = suite.document();
            document.sections.push(of_figure_4());
            document.sections.extend(self.parameters());
            others.push(("verification", document));
        }
        // The claims with their distributions first.
        others.extend(beside.records.iter().rev().map(with_origin));
        let tiles = self.tiles(&others);
        let (glance, more): (Vec<Tile>, Vec<Tile>) = tiles
            .into_iter()
            .partition(|tile| !MORE.contains(&tile.page));
        let run = &runs.native;
        let words = format!("{}: {}", run.record.engine.label(), run.stages_in_words());
        let loaded = (run.last.bed(), punch_bottom(run), words);
        let (figures, agreement): (Vec<Tile>, Vec<Tile>) = glance
            .into_iter()
            .partition(|tile| FIGURES.contains(&tile.page));
        let agreement = Section::new(AGREE, self.origin()).with(agreement);
        let figures = (!figures.is_empty()).then(|| {
            let words = "Engines that agree can be wrong about the paper together: this does not enter the verdict above.";
            let answer = beside.answer.iter().fold(words.to_owned(), |all, sentence| all + " " + sentence);
            Section::new("Do the published figures come out?", answer).with(figures)
        });
        let sections = [
            diff.map(|diff| diff.section(false)),
            Some(agreement.with_all(pictures(&run.scene, &[loaded]))),
            figures,
            Some(self.compared()),
            self.first_steps(),
            Some(self.faults()),
            self.skipped(),
            Some(Section::new("More", "").with(more)),
            Some(choices(run).as_details()),
            Some(self.runs().as_details()),
        ];
        let first = Document {
            sections: sections.into_iter().flatten().collect(),
            ..self.summary()
        };
        Ok(std::iter::once((FIRST, first)).chain(others).collect())
    }

    /// Of which paper this is, by which version, when and where.
    fn origin(&self) -> String {
        format!(
            "The paper: {PAPER}. crossgrain {}, {}, {}.",
            self.crossgrain,
            today(),
            Machine::this().kind()
        )
    }

    /// What each of the other pages says.
    fn tiles(&self, others: &[(&'static str, Document)]) -> Vec<Tile> {
        let tile = |(page, document): &(&'static str, Document)| {
            let mut stated = self.beside.iter();
            let is_recorded = stated.any(|record| record.job == *page && record.recorded);
            let recorded = if is_recorded { ", recorded" } else { "" };
            let answer = &document.answer;
            let (title, (figure, words)) = match *page {
                "measures" => ("The same bits".to_owned(), self.bits()),
                "verification" => {
                    let figure = format!("{} of {} faults", self.found(), self.faults.len());
                    let words = format!("put in were found, down to a part in 10¹². {answer}");
                    ("Faults found".to_owned(), (figure, words))
                }
                "tradeoff" => {
                    let sorted = self.runs.iter().find(|run| run.folder == "yade-sorted");
                    let told = match sorted.and_then(|run| run.times_native) {
                        None => halves(answer),
                        Some(times) => (
                            format!("{times:.0} times"),
                            format!(
                                "the time of a native step is what a step of YADE's sorted loop took here. The trade-off{recorded}: {answer}"
                            ),
                        ),
                    };
                    ("Speed and accuracy".to_owned(), told)
                }
                "candidates" => {
                    let first = answer.split_inclusive(". ").next().unwrap_or(answer);
                    let title = format!("Settings that give them{recorded}");
                    (title, split(first.trim_end(), " settings"))
                }
                "claims" => (
                    format!("Published figures{recorded}"),
                    split(answer, " claims"),
                ),
                _ => (document.title.clone(), halves(answer)),
            };
            Tile {
                title,
                figure,
                words,
                page,
            }
        };
        others.iter().map(tile).collect()
    }

    fn found(&self) -> usize {
        let found = self.faults.iter();
        found.filter(|fault| fault.verdict == Outcome::Pass).count()
    }

    /// In how many numbers the first comparison's last states differ.
    fn bits(&self) -> (String, String) {
        let Some(named) = self.comparisons.last() else {
            let words = "No other engine's run is there.";
            return ("not compared".to_owned(), words.to_owned());
        };
        let tables = named.comparison.tables.iter();
        let (numbers, differing) = tables.fold((0, 0), |(all, bad), table| {
            (all + table.numbers, bad + table.differing)
        });
        let figure = format!("{differing} of {numbers}");
        (figure, format!("numbers differ: {}.", named.title))
    }

    fn measures(&self, runs: &Runs) -> Document {
        let quantities = self.comparisons.iter();
        let quantities = quantities.map(|named| named.comparison.quantity_table(&named.title));
        let all = "Each is measured in both runs of a comparison, A and B.";
        let (figure, words) = self.bits();
        Document {
            title: "States and measures of both engines".to_owned(),
            verdict: self.verdict,
            answer: format!("{figure} {words}"),
            sections: vec![
                beds(runs).with_all(quantiles(runs)),
                histories(runs),
                Section::new("Every measured quantity", all).with_all(quantities),
            ],
            checks: Vec::new(),
        }
    }

    fn paper(&self) -> Document {
        let mut document = paper::document(&self.numbers, &self.text_faults);
        document.sections.push(self.claims());
        document
    }

    /// The same for a terminal: comparisons, faults, what was skipped, runs.
    pub fn summary(&self) -> Document {
        let mut verdicts = String::new();
        for named in &self.comparisons {
            let verdict = named.comparison.verdict().in_words();
            verdicts += &format!("{}: {verdict}. ", first_steps::sentence(&named.title));
        }
        for steps in &self.first_steps {
            let verdict = steps.judgement.verdict().in_words();
            verdicts += &format!("First steps of {}: {verdict}. ", steps.title);
        }
        let ran = self.yade.as_ref();
        let ran = ran.map(|version| format!("YADE {version} ran live."));
        let live = ran.as_deref().unwrap_or(match self.comparisons.is_empty() {
            false => "YADE did not run live; the native engine is compared with a recorded run.",
            true => "Nothing could be compared: YADE did not run live, and the recorded run is of another scene.",
        });
        let sections = [Some(self.compared()), Some(self.faults()), self.skipped()];
        let sections = sections.into_iter().chain([Some(self.runs())]);
        Document {
            title: "The paper's experiment in two engines".to_owned(),
            verdict: self.verdict,
            answer: format!(
                "{verdicts}{live} {} of {} deliberate faults found.",
                self.found(),
                self.faults.len()
            ),
            sections: sections.flatten().collect(),
            checks: self.checks(),
        }
    }

    fn compared(&self) -> Section {
        let answer = "The verdict says whether the engines agree on one realization. Whether the paper's figures come out is another \
                      question.";
        let mut section = Section::new("Comparisons", answer);
        for named in &self.comparisons {
            let comparison = &named.comparison;
            let folders = named.folders.join(", ");
            let words = format!(
                "A: {}. B: {}. Folders: {folders}.",
                comparison.a, comparison.b
            );
            let heading = format!("{}: {}", named.title, comparison.verdict().in_words());
            section = section.with(Block::Heading(heading));
            section = section.with(words).with(comparison.check_table());
        }
        section
    }

    fn faults(&self) -> Section {
        let answer = "Each fault is put into the native engine alone and compared with the sound one; the comparison has to find it \
                      within the first steps of pouring, and names the first step and grain.";
        let table = Table::of("faults", "", &self.faults)
            .column("outcome", |fault| fault.verdict)
            .column("fault", |fault| Cell::Code(fault.fault.clone()))
            .column("first difference", |fault| &fault.found);
        Section::new("Would it notice?", answer).with(table)
    }

    fn skipped(&self) -> Option<Section> {
        let checks = self.checks().into_iter();
        let skipped = checks.filter(|check| check.outcome == Outcome::Skipped);
        let skipped: Vec<Check> = skipped.collect();
        let table = Table::of("skipped", "", &skipped)
            .column("skipped", |check| &check.quantity)
            .column("why", |check| &check.found);
        let section = Section::new("Skipped", "These count for nothing.");
        (!skipped.is_empty()).then(|| section.with(table))
    }

    fn parameters(&self) -> Option<Section> {
        let title = "Parameters of a few grains in contact, asked before anything was run";
        let table = Table::of("parameters", title, &self.facts)
            .column("of", |pair| &pair.native.bodies)
            .column("symbol", |pair| pair.native.symbol)
            .column("native", |pair| pair.native.value)
            .column("YADE", |pair| pair.yade)
            .column("relative difference", |pair| pair.difference)
            .column("unit", |pair| pair.native.unit);
        let section = Section::new("Parameters: what each engine says that it uses", "");
        (!self.facts.is_empty()).then(|| section.with(table).as_details())
    }

    /// The first steps of YADE's loops, if YADE ran live.
    fn first_steps(&self) -> Option<Section> {
        let answer = "The ordinary loop, which is YADE's default, adds forces in another order: only rounding may differ. In a hundred \
                      steps rounding has a narrow envelope, and a wrong constant leaves it; at the end of a run all differences are \
                      of one size. Four states, each law that YADE has.";
        let mut section = Section::new("First steps of YADE's loops", answer);
        for steps in &self.first_steps {
            let verdict = steps.judgement.verdict().in_words();
            let heading = format!("{}: {verdict}", steps.title);
            section = section.with(Block::Heading(heading));
            section = section.with(first_steps::answer(&steps.judgement));
            section = section.with(first_steps::state_table(&steps.judgement));
        }
        (!self.first_steps.is_empty()).then_some(section)
    }

    fn claims(&self) -> Section {
        let title = "This realization beside the paper's figures";
        if self.claims.is_empty() {
            let answer = "This is not the paper's scene, so the paper says nothing of it.";
            return Section::new(title, answer);
        }
        let table = Table::of("realization", "", &self.claims)
            .column("figure", |claim| &claim.what)
            .column("published", |claim| claim.published)
            .column("±", |claim| claim.scatter)
            .column("here", |claim| claim.ours)
            .column("unit", |claim| &claim.unit)
            .column("reading", |claim| &claim.reading);
        let answer = "One realization is one draw: it can show a height or a porosity that is out of reach, it cannot decide a mean \
                      stress or a distribution. These are findings, not checks.";
        Section::new(title, answer).with(table)
    }

    fn runs(&self) -> Section {
        let table = Table::of("runs", "", &self.runs)
            .column("folder", |run| Cell::Code(run.folder.clone()))
            .column("engine", |run| &run.engine)
            .column("stages", |run| &run.stages)
            .column("time a step, µs", |run| run.microseconds_per_step)
            .column("times native", |run| run.times_native)
            .column("processor time, s", |run| run.cpu_seconds)
            .column("command", |run| Cell::Code(run.command.clone()));
        let answer = format!(
            "`{}`, crossgrain {}, {} s. Scene with digest `{}`. Without “times native”, a run was made on another machine. The \
             parts of a run go on in the very bits that the part before has left.",
            self.command,
            self.crossgrain,
            self.seconds.round(),
            self.scene_digest
        );
        Section::new("Runs, versions and commands", answer).with(table)
    }
}

/// The day, UTC, as 2026-11-22.
fn today() -> String {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    let days = since.map_or(0, |since| since.as_secs() / 86_400);
    // Years begin in March, so that a leap day is the last (H. Hinnant, chrono-compatible low-level date algorithms).
    let shifted = days + 719_468;
    let (era, of_era) = (shifted / 146_097, shifted % 146_097);
    let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let next = month / 10;
    let (year, month) = (year + 400 * era + next, month + 3 - 12 * next);
    format!("{year}-{month:02}-{day:02}")
}

/// The record of another job, with where it comes from.
fn with_origin((stated, document): &(Stated, Document)) -> (&'static str, Document) {
    let whole = &*stated.scene_digest;
    let digest = whole.get(..12).unwrap_or(whole);
    let origin = match stated.recorded {
        true => "Recorded, and not run again here; `reference_data/README.md` says how".to_owned(),
        false => format!("From a job of yours, `{}`", stated.command),
    };
    let made = format!(
        "{origin}: crossgrain {}, scene `{digest}`. It is no part of the main job's verdict.",
        stated.crossgrain
    );
    let mut document = document.clone();
    document
        .sections
        .insert(0, Section::new("Where this comes from", made));
    (stated.job, document)
}

/// The first question of the page, which its verdict answers.
const AGREE: &str = "Do the engines agree?";
/// Pages that answer the other one.
const FIGURES: [&str; 2] = ["claims", "candidates"];
/// Pages whose tiles do not stand on the first screen.
const MORE: [&str; 3] = ["paper", "search", "stability"];

/// An answer as a figure and the rest; without a figure it is all rest.
fn halves(answer: &str) -> (String, String) {
    let (figure, rest) = answer.split_once(": ").unwrap_or(("", answer));
    (figure.to_owned(), rest.to_owned())
}

/// An answer that begins with a count of what `at` names.
fn split(answer: &str, at: &str) -> (String, String) {
    match answer.split_once(at) {
        Some((count, rest)) => (count.to_owned(), format!("{}{rest}", at.trim_start())),
        None => halves(answer),
    }
}

fn choices(run: &RunFolder) -> Section {
    let scene = run.scene.json();
    let chosen = |key: &str| scene.pointer(key).map(ToString::to_string);
    let table = Table::of("choices", "", &run.scene.choices)
        .column("key of the scene", |(key, _)| Cell::Code(key.clone()))
        .column("chosen", |(key, _)| chosen(key).map(Cell::Code))
        .column("why", |(_, reason)| reason);
    Section::new("What the paper leaves open, and what was chosen", "").with(table)
}

/// Before and after loading, native and YADE, all with the same scale of forces.
fn beds(runs: &Runs) -> Section {
    let mut all = Vec::new();
    let native = [(&runs.native, "native".to_owned())].into_iter();
    let yade = runs.yade.iter();
    for (run, engine) in native.chain(yade.map(|run| (run, run.record.engine.label()))) {
        if let Some(settled) = &run.settled {
            all.push((settled.bed(), None, format!("{engine}, settled")));
        }
        let end = format!("{engine}, at the end: {}", run.stages_in_words());
        all.push((run.last.bed(), punch_bottom(run), end));
    }
    let answer = "Lines join grains in contact and are as thick as the force is strong, in eight classes, on the same scale in all \
                  pictures.";
    Section::new("The packings", answer).with_all(pictures(&runs.native.scene, &all))
}

/// Histories of native and YADE on top of each other.
fn histories(runs: &Runs) -> Section {
    let draw = |plot: Plot, stage: Stage, value: fn(&HistoryRow) -> Option<[f64; 2]>| {
        let points = |run: &RunFolder, every: usize| -> Vec<[f64; 2]> {
            let rows = run.history.iter().filter(|row| row.stage == stage);
            rows.step_by(every).filter_map(value).collect()
        };
        let mut plot = plot.line("native", Colour::Blue, points(&runs.native, 1));
        if let Some(yade) = &runs.yade {
            let every = if stage == Stage::Settle { 4 } else { 1 };
            let points = points(yade, every).into_iter();
            let points = points.map(|[x, y]| Point::at(x, y));
            plot = plot.group(
                "YADE, sorted loop",
                Colour::Vermilion,
                Style::Hollow,
                points,
            );
        }
        plot
    };
    let over_time = |name: &str, caption: &str, y: &str| {
        let x = Axis::linear("time since pouring began, s");
        Plot::new(name, caption, x, Axis::logarithmic(y))
    };
    let caption = "Settling: the kinetic energy falls until the settle rule holds";
    let energy = over_time("kinetic-energy", caption, "kinetic energy, J");
    let caption = "Settling: mean net force on a grain over mean contact force";
    let unbalanced = over_time("unbalanced-force", caption, "unbalanced force");
    let caption = "Loading: the force of the grains on the punch";
    let [x, y] = ["punch depth, mm", "force on the punch, N"].map(Axis::linear);
    let punch = Plot::new("punch-force", caption, x, y);
    let section = Section::new("Histories", "")
        .with(draw(energy, Stage::Settle, |row| {
            Some([row.time, row.kinetic_energy])
        }))
        .with(draw(unbalanced, Stage::Settle, |row| {
            row.unbalanced_force.map(|force| [row.time, force])
        }));
    if runs.native.record.stages.len() < 2 {
        return section;
    }
    section.with(draw(punch, Stage::Load, |row| {
        let at = row.punch_depth.zip(row.punch_force);
        at.map(|(depth, force)| [1e3 * depth, force])
    }))
}

const QUANTILES: usize = 100;

/// Normal forces of the last moment in YADE over those in the native engine, quantile by quantile.
fn quantiles(runs: &Runs) -> Option<Plot> {
    let normal_forces = |run: &RunFolder| -> Vec<f64> {
        let forces = run.last.contacts.iter().map(|contact| contact.normal_force);
        let mut forces: Vec<f64> = forces.filter(|force| *force > 0.0).collect();
        forces.sort_by(f64::total_cmp);
        let at = |share: f64| forces.get((share * forces.len() as f64) as usize).copied();
        let shares = (0..QUANTILES).map(|index| (index as f64 + 0.5) / QUANTILES as f64);
        shares.filter_map(at).collect()
    };
    let native = normal_forces(&runs.native);
    let (low, high) = (*native.first()?, *native.last()?);
    let yade = normal_forces(runs.yade.as_ref()?);
    // Below a ten-thousandth of the strongest there are but a few.
    let low = low.max(1.0e-4 * high);
    let caption = "Normal forces of the last moment, quantile by quantile: the same distribution lies on the line, the same bits do so exactly.";
    let [x, y] = ["normal force in native, N", "in YADE, N"].map(Axis::logarithmic);
    let pairs = native.iter().zip(yade);
    let shown = pairs.filter(|(x, y)| **x >= low && *y >= low);
    let shown = shown.map(|(x, y)| Point::at(*x, y));
    let plot = Plot::new("force-quantiles", caption, x, y)
        .line("the same", Colour::Grey, [[low, low], [high, high]])
        .points("YADE, sorted loop", Colour::Vermilion, shown);
    Some(plot)
}
