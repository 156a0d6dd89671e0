//! `report.html`: one page, self-contained, verdict first.

mod changes;
mod histories;
mod sections;

use serde::Serialize;

use self::changes::{ChangedRow, changed, worse};
use self::histories::{histories, separation};
use self::sections::{Section, sections};
use super::figure::{Figure, Page};
use super::views::words;
use super::{difference, packing, shell, svg};
use crate::checks::Outcome;
use crate::checks::{Check, Tally};
use crate::compare::baseline::diff::Diff;
use crate::document::Block;
use crate::error::Error;
use crate::reproduce::Runs;
use crate::reproduce::beside::{Beside, Stated};
use crate::reproduce::checks;
use crate::reproduce::faults::FaultCheck;
use crate::reproduce::record::Reproduction;
use crate::run::folder::{Moment, RunFolder};
use crate::suite::run::Verification;

const TEMPLATE: &str = include_str!("page.html");

/// The page; `beside` are the records of other jobs that stand on it.
pub fn render(
    reproduction: &Reproduction,
    runs: &Runs,
    beside: &Beside,
    diff: Option<&Diff>,
) -> Result<Page, Error> {
    let checks = checks::all(reproduction);
    let ladder = reproduction.ladder.as_ref();
    let ladder = ladder.map(verification);
    let sections = sections(beside)?;
    let given = Given {
        r: reproduction,
        changed: diff.map(changed),
        diff,
        diff_line: diff.map(Diff::in_a_line),
        worse: diff.filter(|diff| diff.verdict == Outcome::Fail).map(worse),
        word: match reproduction.verdict {
            Outcome::Pass => "Agreed",
            Outcome::Fail => "Different",
            Outcome::Skipped | Outcome::ExpectedFailure => "Incomplete",
        },
        summary: Summary::of(reproduction, &checks),
        checks: &checks,
        choices: choices(&runs.native),
        packings: packings(runs)?,
        histories: histories(runs)?,
        separation: separation(reproduction)?,
        differences: difference::figures(reproduction, runs)?,
        charts: &sections.charts,
        claimed: &sections.claimed,
        beside: beside.stated(),
        ladder: ladder.as_deref(),
    };
    let html = shell::render(&[("page.html", TEMPLATE)], &given)?;
    let own = given
        .differences
        .into_iter()
        .chain(given.packings)
        .chain(given.histories)
        .chain(given.separation);
    let mut figures = sections.figures;
    figures.extend(own);
    Ok(Page { html, figures })
}

/// The sections of the verification suite.
fn verification(of: &Verification) -> String {
    let mut html = String::new();
    for section in of.sections() {
        html += &format!(
            "<h2>{}</h2>\n<p>{}</p>\n",
            words(&section.title),
            words(&section.answer)
        );
        for block in &section.blocks {
            html += &match block {
                Block::Text(text) => format!("<p>{}</p>\n", words(text)),
                Block::Table(table) => table.html(),
                Block::Plot(plot) => svg(plot),
                Block::Drawing(drawing) => drawing.svg.clone(),
            };
        }
    }
    html
}

/// What the template is given.
#[derive(Debug, Serialize)]
struct Given<'a> {
    r: &'a Reproduction,
    /// Against a baseline, if there is one.
    changed: Option<Vec<ChangedRow<'a>>>,
    diff: Option<&'a Diff>,
    diff_line: Option<String>,
    /// What is worse than in the baseline, a line each; none if nothing is.
    worse: Option<Vec<String>>,
    word: &'static str,
    summary: Summary,
    /// Every check of the job.
    checks: &'a [Check],
    choices: Vec<Choice>,
    packings: Vec<Figure>,
    histories: Vec<Figure>,
    separation: Option<Figure>,
    differences: Vec<Figure>,
    /// Cost against error, stable steps, distributions: from the records of other jobs.
    charts: &'a [Section],
    /// The claims, from theirs.
    claimed: &'a [Section],
    /// What the records of other jobs say of themselves.
    beside: Vec<&'a Stated>,
    /// The ladder as HTML, if it was climbed.
    ladder: Option<&'a str>,
}

/// The verdict in figures.
#[derive(Debug, Serialize)]
struct Summary {
    passed: usize,
    failed: usize,
    skipped: usize,
    expected_failures: usize,
    faults_found: usize,
}

impl Summary {
    fn of(reproduction: &Reproduction, checks: &[Check]) -> Self {
        let tally = Tally::of(checks);
        Summary {
            passed: tally.passed,
            failed: tally.failed,
            skipped: tally.skipped,
            expected_failures: tally.expected_failures,
            faults_found: tally_faults(reproduction),
        }
    }
}

fn tally_faults(reproduction: &Reproduction) -> usize {
    let found = |fault: &&FaultCheck| fault.verdict == Outcome::Pass;
    reproduction.faults.iter().filter(found).count()
}

/// An open choice: where, what was chosen, why.
#[derive(Debug, Serialize)]
struct Choice {
    key: String,
    value: String,
    reason: String,
}

fn choices(run: &RunFolder) -> Vec<Choice> {
    let scene = serde_json::to_value(&run.scene).unwrap_or_default();
    let choice = |(key, reason): (&String, &String)| Choice {
        key: key.clone(),
        value: scene.pointer(key).map_or(String::new(), |v| v.to_string()),
        reason: reason.clone(),
    };
    run.scene.choices.iter().map(choice).collect()
}

/// Before and after loading, native and YADE, all with the same scale of forces.
fn packings(runs: &Runs) -> Result<Vec<Figure>, Error> {
    let moments = |run: &RunFolder, engine: &str| {
        let bottom = punch_bottom(run);
        let mut moments = Vec::new();
        if let Some(settled) = &run.settled {
            moments.push((settled.clone(), None, format!("{engine}, settled")));
        }
        moments.push((
            run.last.clone(),
            bottom,
            format!("{engine}, at the end: {}", run.stages_in_words()),
        ));
        moments
    };
    let mut all: Vec<(Moment, Option<f64>, String)> = moments(&runs.native, "native");
    if let Some(yade) = &runs.yade {
        all.extend(moments(yade, &yade.record.engine.label()));
    }
    let strong = packing::strong_force(all.iter().map(|(moment, _, _)| moment.bed()));
    let top = all
        .iter()
        .map(|(moment, _, _)| grains::measure::highest_grain(&moment.bodies))
        .fold(0.0, f64::max)
        + 0.02;
    let figures = all.iter().enumerate();
    figures
        .map(|(index, (moment, bottom, caption))| {
            let bed = moment.bed();
            let scene = &runs.native.scene;
            Ok(Figure {
                name: format!("packing-{}", index + 1),
                svg: packing::picture(scene, bed, *bottom, strong, top, caption),
                caption: format!("{caption}; the thickest lines bear {strong:.0} N or more."),
                csv: packing::numbers(bed)?,
            })
        })
        .collect()
}

/// Where the punch's bottom is at the end, m.
fn punch_bottom(run: &RunFolder) -> Option<f64> {
    let depth = run.history.last()?.punch_depth?;
    let settled = run.settled.as_ref()?;
    let start = grains::native::first_contact_punch(&run.scene, &settled.bodies).start;
    Some(start - depth)
}
