//! Two run folders side by side: bits, the first difference, and every measured quantity; where bits may differ, the first
//! steps of both engines.

pub mod baseline;
pub mod bits;
pub mod first_difference;
pub mod first_steps;
pub mod from_runs;

use std::collections::BTreeSet;
use std::path::Path;

use serde::Serialize;

use crate::checks::{self, Check, Outcome};
use crate::document::{Cell, Document, Section, Table};
use crate::engine::EngineRecord;
use crate::run::folder::RunFolder;
use bits::TableBits;
use first_difference::{FirstDifference, Locator};
use first_steps::Beds;
use from_runs::Replicas;
use grains::measure::Quantity;
use grains::model::Model;
use grains::native;
use grains::rules::Rules;
use grains::tables::Stage;
use grains::task::Case;
use verdict::envelope::Resolution;
use verdict::forms::plays_a_part;
use verdict::judge::{Judgement, Verdict};

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct QuantityPair {
    pub key: String,
    pub unit: String,
    pub a: Option<f64>,
    pub b: Option<f64>,
    /// |a − b|.
    pub difference: Option<f64>,
    /// Whether they are the same number; skipped where that is not expected.
    pub verdict: Outcome,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Comparison {
    pub a: String,
    pub b: String,
    /// Both runs add forces in the same order, so every bit is expected to agree.
    pub bits_expected: bool,
    pub checks: Vec<Check>,
    pub tables: Vec<TableBits>,
    /// Every bit of every table and moment is the same.
    pub same_bits: bool,
    /// Where the runs diverge, if they should not and it was looked for.
    pub first_difference: Option<FirstDifference>,
    /// Where bits may differ: the first steps of the engine of run A or B, where it is not the native engine itself.
    pub first_steps: Vec<(&'static str, Judgement)>,
    pub quantities: Vec<QuantityPair>,
}

impl Comparison {
    /// All checks, their ids beginning with this one.
    pub fn all_checks(&self, id: &str) -> Vec<Check> {
        let prefixed = |check: &Check| Check {
            id: format!("{id}/{}", check.id),
            ..check.clone()
        };
        let quantities = self.paired();
        let quantities = quantities.map(|pair| pair.check(id, self.bits_expected));
        self.checks.iter().map(prefixed).chain(quantities).collect()
    }

    /// The quantities to be looked at one by one: where the runs did not go equally far, those that both have.
    fn paired(&self) -> impl Iterator<Item = &QuantityPair> {
        let failed = |check: &Check| check.id == PROTOCOL && check.outcome == Outcome::Fail;
        let same = !self.checks.iter().any(failed);
        let all = self.quantities.iter();
        all.filter(move |pair| same || pair.difference.is_some())
    }

    /// By all checks; undecided where bits may differ and no first steps were looked at.
    pub fn verdict(&self) -> Verdict {
        match checks::verdict(&self.all_checks("")) {
            Outcome::Fail => Verdict::Different,
            Outcome::Pass if self.same_bits => Verdict::Identical,
            Outcome::Pass => Verdict::EqualToRounding,
            Outcome::Skipped | Outcome::ExpectedFailure => Verdict::Undecided,
        }
    }

    /// Whether the comparison was made and no check failed.
    pub fn agrees(&self) -> bool {
        Outcome::from(self.verdict()) == Outcome::Pass
    }

    /// Two runs of one engine by their folders.
    pub fn tell_apart(&mut self, folders: [&Path; 2]) {
        if self.a == self.b {
            self.a += &format!(" in {}", folders[0].display());
            self.b += &format!(" in {}", folders[1].display());
        }
    }

    fn check(&mut self, id: &str, quantity: &str, outcome: Outcome, found: &str) {
        self.checks
            .push(Check::of_words(id, quantity, outcome, found));
    }

    /// A check that is required and was not made.
    fn missing(&mut self, id: &str, quantity: &str, why: &str) {
        let check = Check::of_words(id, quantity, Outcome::Skipped, why);
        self.checks.push(check.required());
    }

    /// A check that its id names.
    fn holds(&mut self, id: &str, holds: bool, found: &str) {
        let quantity = id.replace('-', " ");
        self.check(id, &quantity, Outcome::pass_if(holds), found);
    }

    /// What was checked, as a table.
    pub fn check_table(&self) -> Table {
        let table = Table::of("checks", "", &self.checks)
            .column("outcome", |check| check.outcome)
            .column("check", |check| &check.quantity)
            .column("found", |check| &check.found);
        let mut table = Table::from(table);
        if let Some(first) = &self.first_difference {
            let first = first.to_string();
            table.row([Cell::Missing, "first difference".into(), first.into()]);
        }
        table
    }

    /// Every measured quantity, as a table with this title.
    pub fn quantity_table(&self, title: &str) -> Table {
        let table = Table::of("quantities", title, self.paired())
            .column("outcome", |pair| pair.verdict)
            .column("quantity", |pair| Cell::Code(pair.key.clone()))
            .column("unit", |pair| &pair.unit)
            .column("A", |pair| pair.a)
            .column("B", |pair| pair.b)
            .column("|A − B|", |pair| pair.difference);
        Table::from(table)
    }

    pub fn document(&self) -> Document {
        let mut sections = vec![
            Section::new("Checks", format!("A: {}\nB: {}", self.a, self.b))
                .with(self.check_table()),
        ];
        for (run, judgement) in &self.first_steps {
            let own = first_steps::sections(judgement).into_iter();
            sections.extend(own.map(|section| Section {
                title: format!("{run}: {}", section.title),
                ..section
            }));
        }
        let mut about =
            "`settled` is the settled bed, `loaded` the one under the punch at the end, `poured` that of a run without loading."
                .to_owned();
        let is_identical = self.verdict() == Verdict::Identical;
        if !self.bits_expected && !is_identical {
            about += " One realization each, and rounding has made them two: these numbers judge nothing. Whether their distributions are \
             the same, two campaigns say (`crossgrain study compare`).";
        }
        let paired = self.paired().count();
        if paired < self.quantities.len() {
            let (alone, all) = (self.quantities.len() - paired, self.quantities.len());
            about += &format!(
                " One run alone has {alone} of {all}, for the other one did not go as far."
            );
        }
        sections.push(Section::new("Measured quantities", about).with(self.quantity_table("")));
        let checks = self.all_checks("compare");
        Document::new("Two runs compared", self.answer(), checks).with(sections)
    }

    pub fn answer(&self) -> String {
        let mut said = format!("{} against {}", self.a, self.b);
        let asked = ["same-scene", "same-start", PROTOCOL];
        let of_question = |check: &&Check| asked.iter().any(|id| check.id.ends_with(id));
        let mut other = self.checks.iter().filter(of_question);
        if let Some(check) = other.find(|check| check.outcome == Outcome::Fail) {
            said += &format!(", not the {}: {}", check.quantity, check.found);
        }
        if let Some(first) = &self.first_difference {
            said += &format!("; first difference: {first}");
        }
        let skipped = self.checks.iter();
        for check in skipped.filter(|check| check.required && check.outcome == Outcome::Skipped) {
            said += &format!("; not decided: {}: {}", check.quantity, check.found);
        }
        for (run, judgement) in &self.first_steps {
            let id = format!("stretches-{}", run.to_lowercase());
            let late = self.checks.iter().find(|check| check.id == id);
            let of_states = match late {
                Some(_) => first_steps::from_states(judgement),
                None => first_steps::answer(judgement),
            };
            said += &format!(". {run}: {of_states}");
            said += &late.map_or(String::new(), |check| {
                format!(" {}: {}.", check.quantity, check.found)
            });
        }
        for check in self
            .checks
            .iter()
            .filter(|check| check.id.contains(PROGRAM))
        {
            said += &format!(" Of {} {}.", check.quantity, check.found);
        }
        first_steps::with_verdict(self.verdict(), &said)
    }
}

/// The checks that a run's program is the one that is asked, by its digest.
const PROGRAM: &str = "program-";
/// The check that both runs go equally far.
const PROTOCOL: &str = "same-protocol";
const SAME_OPERATIONS: &str =
    "both engines do the same operations in the same order (docs/determinism.md)";

impl QuantityPair {
    /// A is the value, B what is expected.
    fn check(&self, id: &str, bits_expected: bool) -> Check {
        let found = match (self.a, self.b) {
            (None, _) => "run A does not have it",
            (_, None) => "run B does not have it",
            _ if self.verdict == Outcome::Skipped => {
                "not judged: one realization each shows no scatter"
            }
            _ => "",
        };
        let (a, b) = (self.a.unwrap_or(f64::NAN), self.b.unwrap_or(f64::NAN));
        let id = format!("{id}/quantity/{}", self.key);
        let check = Check {
            unit: self.unit.clone(),
            ..Check::of_words(id, &self.key, self.verdict, found)
        };
        let check = check.with_limits(a, b, bits_expected.then_some(0.0));
        match bits_expected {
            true => check.judged_by("the same number in both runs", SAME_OPERATIONS),
            false => check,
        }
    }
}

/// Compares two runs. With a locator the engines are run again: where bits are expected and differ, to find the first step and
/// grain; where they may differ, to judge the engines' first steps.
pub fn compare(a: &RunFolder, b: &RunFolder, locator: Option<&Locator>) -> Comparison {
    let keep_order = [a, b].map(|run| run.record.engine.keeps_order());
    compare_as(a, b, keep_order == [true; 2], locator)
}

/// The same where somebody says whether bits are expected: of external engines nobody else knows.
pub fn compare_as(
    a: &RunFolder,
    b: &RunFolder,
    bits_expected: bool,
    locator: Option<&Locator>,
) -> Comparison {
    let mut comparison = Comparison {
        a: a.record.engine.label(),
        b: b.record.engine.label(),
        bits_expected,
        ..Comparison::default()
    };
    same_question(a, b, &mut comparison);
    for (name, run) in [("A", a), ("B", b)] {
        let stated = run.record.engine.approximations();
        if !stated.is_empty() {
            let id = format!("approximations-{}", name.to_lowercase());
            let name = format!("approximations that {name} states");
            comparison.check(&id, &name, Outcome::Skipped, &stated.join("; "));
        }
    }
    if a.scene.particles.count != b.scene.particles.count {
        return comparison;
    }
    comparison.tables = bits::tables(a, b);
    let contradiction = bits::contradiction(a, b);
    comparison.same_bits = comparison.tables.iter().all(TableBits::agrees)
        && bits::history(a, b).agrees()
        && contradiction.is_none();
    if let Some(why) = contradiction {
        comparison.holds("same-states", false, &why);
    }
    if bits_expected {
        expect_bits(a, b, locator, &mut comparison);
    } else {
        expect_rounding(a, b, locator, &mut comparison);
    }
    declared_rules(a, b, &mut comparison);
    quantities(a, b, &mut comparison);
    comparison
}

/// Scene, start and protocol are the same in both.
fn same_question(a: &RunFolder, b: &RunFolder, comparison: &mut Comparison) {
    let differing = bits::differing_keys(&a.scene, &b.scene);
    let found = match differing.is_empty() {
        true => format!("digest {}", &a.record.scene_digest[..16]),
        false => format!("the scenes differ in {}", differing.join(", ")),
    };
    comparison.holds("same-scene", differing.is_empty(), &found);
    let (of_a, of_b) = (&a.record.initial_digest, &b.record.initial_digest);
    let found = format!("initial states {of_a} and {of_b}");
    comparison.holds("same-start", of_a == of_b, &found);
    let (of_a, of_b) = (a.record.protocol, b.record.protocol);
    comparison.holds(PROTOCOL, of_a == of_b, &format!("{of_a} and {of_b}"));
}

/// Engines that declare other rules than each other are different, however right each is under its own.
fn declared_rules(a: &RunFolder, b: &RunFolder, comparison: &mut Comparison) {
    let rules = [a, b].map(|run| run.record.engine.rules().over(run.scene.rules));
    if rules.iter().all(Rules::are_usual) {
        return;
    }
    // What the scene has no part for may be as it likes.
    let of_stage = |stage| {
        let case = Case {
            name: String::new(),
            model: Model::in_stage(&a.scene, stage),
            bodies: a.initial.clone(),
            punch: None,
            moments: Vec::new(),
        };
        let [of_a, of_b] = rules.map(|rules| case.model.law.resolved(rules));
        let both = of_a.choices().zip(of_b.choices());
        let apart = both.filter(|(one, two)| one != two && plays_a_part(&case, one.rule().needs));
        apart
            .map(|(one, two)| format!("{} in A, {} in B", one.name(), two.name()))
            .collect()
    };
    let apart: BTreeSet<String> = [Stage::Settle, Stage::Load]
        .into_iter()
        .flat_map::<Vec<String>, _>(of_stage)
        .collect();
    let found = match apart.is_empty() {
        true => "those that play a part in this scene are the same".to_owned(),
        false => apart.iter().cloned().collect::<Vec<_>>().join("; "),
    };
    comparison.holds("same-rules", apart.is_empty(), &found);
}

fn expect_bits(
    a: &RunFolder,
    b: &RunFolder,
    locator: Option<&Locator>,
    comparison: &mut Comparison,
) {
    let (of_a, of_b) = (a.stages_in_words(), b.stages_in_words());
    let same = of_a == of_b;
    let against = format!("{of_a} against {of_b}");
    comparison.holds("same-stages", same, if same { &of_a } else { &against });
    for table in comparison.tables.clone() {
        let id = format!("bits-of-{}", table.table.replace(' ', "-"));
        let quantity = format!("bits of {}", table.table);
        let check = Check::of_words(id, &quantity, table.verdict(), &table.to_string());
        let check = Check {
            n: table.numbers as u64,
            ..check.with_limits(table.differing as f64, 0.0, Some(0.0))
        };
        comparison.checks.push(check.judged_by(
            "how many numbers of the two tables differ in any bit",
            SAME_OPERATIONS,
        ));
    }
    let history = bits::history(a, b);
    comparison.holds("bits-along-the-way", history.agrees(), &history.to_string());
    let mut checks = comparison.checks.iter();
    if checks.all(|check| check.outcome != Outcome::Fail) {
        return;
    }
    let found = locator.ok_or_else(|| "not asked for".to_owned());
    match found.and_then(|locator| locator.locate(a, b)) {
        Ok(found) => comparison.first_difference = found,
        Err(reason) => {
            let id = "first-difference";
            comparison.check(id, "first difference", Outcome::Skipped, &reason);
        }
    }
}

fn expect_rounding(
    a: &RunFolder,
    b: &RunFolder,
    locator: Option<&Locator>,
    comparison: &mut Comparison,
) {
    if comparison.same_bits {
        if let Some(why) = from_runs::never_acts(a) {
            comparison.missing(
                "acts",
                "what the scene has and its moments do not show",
                &why,
            );
        }
        return comparison.check("bits", "bits", Outcome::Pass, "all bits are the same");
    }
    let found = "not expected to be the same";
    comparison.check("bits", "bits", Outcome::Skipped, found);
    let beds = from_runs::states(a, b);
    let beds = beds.map(Beds::from).map_err(|error| error.to_string());
    for (name, run) in [("A", a), ("B", b)] {
        let lower = name.to_lowercase();
        let id = format!("first-steps-{lower}");
        let judged = locator.ok_or_else(|| "the engines were not to be run again".to_owned());
        let judged = judged.and_then(|locator| of_first_steps(run, locator, &beds));
        let mut measured = None;
        match judged {
            Ok(None) => continue,
            Ok(Some(judgement)) => {
                if let Some(Ok(covered)) = locator.and_then(|locator| locator.covered(run)) {
                    let id = format!("{PROGRAM}{lower}");
                    comparison.check(&id, &format!("{name}'s program"), Outcome::Pass, &covered);
                }
                measured = Some(judgement.resolution);
                let checks = first_steps::checks(&judgement, &id);
                comparison.checks.extend(checks);
                comparison.first_steps.push((name, judgement));
            }
            Err(why) => {
                let what = format!("the first steps of {name}'s engine");
                comparison.missing(&id, &what, &why);
            }
        }
        match from_runs::contact_tables(run, &lower, measured) {
            Ok(check) => comparison.checks.push(check),
            Err(why) => {
                let what = format!("{name}'s contact tables");
                comparison.missing(&format!("contacts-{lower}"), &what, &why);
            }
        }
        comparison
            .checks
            .extend(from_runs::stretches(run, &lower, measured));
        if locator.is_none() {
            continue;
        }
        let noise = measured.unwrap_or(Resolution::DOUBLE).noise();
        match Replicas::of(run, noise) {
            Ok(replicas) => comparison.checks.extend(replicas.checks(run, &lower)),
            Err(why) => {
                let (id, what) = (
                    format!("history-{lower}"),
                    format!("{name}'s history and end"),
                );
                comparison.missing(&id, &what, &why);
            }
        }
    }
}

/// What the first steps of a run's engine say from the states of the runs; nothing of the native engine as it is, which they are held
/// against.
fn of_first_steps(
    run: &RunFolder,
    locator: &Locator,
    beds: &Result<Beds, String>,
) -> Result<Option<Judgement>, String> {
    let engine = locator.engine_of(run)?;
    if engine.native() == Some(&native::Options::default()) {
        return Ok(None);
    }
    // What the run says of its engine counts, and it is the engine that is asked now.
    if let EngineRecord::Exec { described, .. } = &run.record.engine
        && *described != engine.describe().map_err(|error| error.to_string())?
    {
        let name = engine.name();
        return Err(format!(
            "{name} describes itself otherwise than run.json says; make the run again"
        ));
    }
    let judged = first_steps::first_steps(engine.as_ref(), beds.as_ref()?, &mut |_| ());
    judged.map(Some).map_err(|error| error.to_string())
}

/// Pairs the quantities of both runs: the same number where bits are expected.
fn quantities(a: &RunFolder, b: &RunFolder, comparison: &mut Comparison) {
    let (of_a, of_b) = (a.quantities(), b.quantities());
    let find = |list: &[Quantity], key: &str| {
        let found = list.iter().find(|quantity| quantity.key == key);
        found.map(|quantity| quantity.value)
    };
    let mut all: Vec<&Quantity> = of_a.iter().collect();
    all.extend(
        of_b.iter()
            .filter(|quantity| find(&of_a, &quantity.key).is_none()),
    );
    for quantity in all {
        let key = &quantity.key;
        let (in_a, in_b) = (find(&of_a, key), find(&of_b, key));
        let difference = in_a.zip(in_b).map(|(a, b)| (a - b).abs());
        comparison.quantities.push(QuantityPair {
            key: key.clone(),
            unit: quantity.unit.clone(),
            a: in_a,
            b: in_b,
            difference,
            verdict: if comparison.bits_expected {
                Outcome::pass_if(difference == Some(0.0))
            } else {
                Outcome::Skipped
            },
        });
    }
}
