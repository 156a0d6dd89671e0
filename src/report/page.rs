//! `report.html`: one page, self-contained, verdict first.

use serde::Serialize;

use super::chart::{BLUE, Chart, Corner, GREEN, VERMILION};
use super::figure::{Figure, Page, circles, line};
use super::junit::in_a_line;
use super::{claims, difference, packing, pareto, shell, stability, verification};
use crate::baseline::diff::{Change, Changed, Diff, Pace};
use crate::checks::{Check, Tally};
use crate::compare::Verdict;
use crate::compare::parting::Separation;
use crate::error::Error;
use crate::folder::{Moment, RunFolder};
use crate::measure::history::HistoryRow;
use crate::reproduce::Runs;
use crate::reproduce::beside::{Beside, Stated};
use crate::reproduce::checks;
use crate::reproduce::faults::FaultCheck;
use crate::reproduce::record::Reproduction;
use crate::tables::Stage;

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
    let ladder = ladder.map(verification::part).transpose()?;
    let sections = sections(beside)?;
    let given = Given {
        r: reproduction,
        changed: diff.map(changed),
        diff,
        diff_line: diff.map(Diff::in_a_line),
        worse: diff.filter(|diff| diff.verdict == Verdict::Fail).map(worse),
        word: match reproduction.verdict {
            Verdict::Pass => "Agreed",
            Verdict::Fail => "Different",
            Verdict::NotMade => "Incomplete",
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
        ladder: ladder.as_ref().map(|part| part.html.as_str()),
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
    figures.extend(ladder.into_iter().flat_map(|part| part.figures));
    Ok(Page { html, figures })
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

/// A part of the page that shows the record of another job.
#[derive(Debug, Serialize)]
struct Section {
    id: &'static str,
    title: &'static str,
    html: String,
    /// Where the record comes from.
    stated: Stated,
}

/// All of them, with their figures.
struct Sections {
    charts: Vec<Section>,
    claimed: Vec<Section>,
    figures: Vec<Figure>,
}

fn sections(beside: &Beside) -> Result<Sections, Error> {
    let mut figures = Vec::new();
    let mut section = |id, title, part: Page, stated: &Stated| {
        figures.extend(part.figures);
        Section {
            id,
            title,
            html: part.html,
            stated: stated.clone(),
        }
    };
    let mut charts = Vec::new();
    if let Some(of) = &beside.pareto {
        let part = pareto::part(&of.record)?;
        charts.push(section("cost", "Cost against error", part, &of.stated));
    }
    if let Some(of) = &beside.stability {
        let part = stability::part(&of.record)?;
        let title = "The largest stable time steps";
        charts.push(section("stability", title, part, &of.stated));
    }
    let mut claimed = Vec::new();
    if let Some(of) = &beside.claims {
        let part = claims::distributions(&of.record)?;
        let title = "Distributions of a grain's stress, with fits";
        charts.push(section("distributions", title, part, &of.stated));
        let part = claims::part(&of.record)?;
        let title = "The paper's claims about its simulations";
        claimed.push(section("claims", title, part, &of.stated));
    }
    Ok(Sections {
        charts,
        claimed,
        figures,
    })
}

/// The verdict in figures.
#[derive(Debug, Serialize)]
struct Summary {
    passed: usize,
    failed: usize,
    not_made: usize,
    expected_failures: usize,
    faults_found: usize,
}

impl Summary {
    fn of(reproduction: &Reproduction, checks: &[Check]) -> Self {
        let tally = Tally::of(checks);
        Summary {
            passed: tally.passed,
            failed: tally.failed,
            not_made: tally.not_made,
            expected_failures: tally.expected_failures,
            faults_found: tally_faults(reproduction),
        }
    }
}

/// A check that is not as it was.
#[derive(Debug, Serialize)]
struct ChangedRow<'a> {
    id: &'a str,
    change: &'static str,
    bad: bool,
    before: String,
    after: String,
    share: Option<f64>,
}

/// Rows of moved checks at most; the worst come first.
const MOST_MOVED: usize = 12;

fn changed(diff: &Diff) -> Vec<ChangedRow<'_>> {
    let side = |check: &Option<Check>| check.as_ref().map_or("–".to_owned(), in_a_line);
    let row = |of: &'_ Changed| ChangedRow {
        id: "",
        change: of.change.words(),
        bad: of.change == Change::NewFailure,
        before: side(&of.before),
        after: side(&of.after),
        share: of.share_of_tolerance,
    };
    let (moved, other): (Vec<_>, Vec<_>) = diff
        .changes
        .iter()
        .partition(|of| of.change == Change::Moved);
    let shown = other.into_iter().chain(moved.into_iter().take(MOST_MOVED));
    shown
        .map(|of| ChangedRow {
            id: &of.id,
            ..row(of)
        })
        .collect()
}

/// New failures as a number, as `What failed` names them, and every speed that is slower.
fn worse(diff: &Diff) -> Vec<String> {
    let new = |of: &&Changed| of.change == Change::NewFailure;
    let failures = diff.changes.iter().filter(new).count();
    let mut lines = Vec::new();
    if failures > 0 {
        lines.push(format!("new failures: {failures}"));
    }
    let slower = diff.speeds.iter().filter(|of| of.pace == Pace::Slower);
    lines.extend(slower.map(|of| format!("slower: {}", of.in_a_line())));
    lines
}

fn tally_faults(reproduction: &Reproduction) -> usize {
    let found = |fault: &&FaultCheck| fault.verdict == Verdict::Pass;
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
        .map(|(moment, _, _)| crate::measure::height::highest_grain(&moment.bodies))
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
    let start = crate::engine::native::first_contact_punch(&run.scene, &settled.bodies).start;
    Some(start - depth)
}

/// Histories of native and YADE on top of each other.
fn histories(runs: &Runs) -> Result<Vec<Figure>, Error> {
    let column = |stage: Stage, of: fn(&HistoryRow) -> Option<(f64, f64)>| {
        let points = |run: &RunFolder, every: usize| {
            let rows = run.history.iter().filter(|row| row.stage == stage);
            rows.step_by(every).filter_map(of).collect::<Vec<_>>()
        };
        let mut series = vec![line("native", BLUE, points(&runs.native, 1))];
        if let Some(yade) = &runs.yade {
            let every = if stage == Stage::Settle { 4 } else { 1 };
            series.push(circles("YADE, sorted loop", VERMILION, points(yade, every)));
        }
        if let Some(ordinary) = &runs.ordinary {
            series.push(line("YADE, ordinary loop", GREEN, points(ordinary, 1)));
        }
        series
    };
    let mut figures = vec![
        (
            "kinetic-energy",
            Chart {
                x: "time since pouring began, s".to_owned(),
                y: "kinetic energy, J".to_owned(),
                logarithmic: [false, true],
                legend: Corner::UpperRight,
                series: column(Stage::Settle, |row| Some((row.time, row.kinetic_energy))),
            },
            "Settling: the kinetic energy falls until the settle rule holds",
        ),
        (
            "unbalanced-force",
            Chart {
                x: "time since pouring began, s".to_owned(),
                y: "unbalanced force".to_owned(),
                logarithmic: [false, true],
                legend: Corner::UpperRight,
                series: column(Stage::Settle, |row| {
                    row.unbalanced_force.map(|force| (row.time, force))
                }),
            },
            "Settling: mean net force on a grain over mean contact force",
        ),
    ];
    if runs.native.record.stages.len() > 1 {
        figures.push((
            "punch-force",
            Chart {
                x: "punch depth, mm".to_owned(),
                y: "force on the punch, N".to_owned(),
                logarithmic: [false, false],
                legend: Corner::UpperLeft,
                series: column(Stage::Load, |row| {
                    row.punch_depth
                        .zip(row.punch_force)
                        .map(|(depth, force)| (1e3 * depth, force))
                }),
            },
            "Loading: the force of the grains on the punch",
        ));
    }
    let mut drawn = Vec::new();
    for (name, chart, caption) in figures {
        drawn.extend(Figure::of_chart(name, caption, &chart)?);
    }
    Ok(drawn)
}

/// How rounding differences grow, where an ordinary pair was run.
fn separation(reproduction: &Reproduction) -> Result<Option<Figure>, Error> {
    let partings = reproduction
        .comparisons
        .iter()
        .find_map(|named| named.comparison.partings.as_ref());
    let Some(partings) = partings else {
        return Ok(None);
    };
    let largest = |curve: &[Separation]| {
        curve
            .iter()
            .map(|moment| (moment.step as f64, moment.largest))
            .filter(|(_, apart)| *apart > 0.0)
            .collect::<Vec<_>>()
    };
    let chart = Chart {
        x: "step of pouring".to_owned(),
        y: "largest separation over R".to_owned(),
        logarithmic: [false, true],
        legend: Corner::LowerRight,
        series: vec![
            line("native, YADE", BLUE, largest(&partings.engines.curve)),
            line("YADE, YADE", VERMILION, largest(&partings.control.curve)),
        ],
    };
    // A scene too short for rounding to matter has no curve to draw.
    Figure::of_chart(
        "separation",
        "Rounding differences grow: native against YADE's ordinary loop, and two ordinary YADE runs that differ in verletDist only (before the \
         curves begin the bits agree)",
        &chart,
    )
}
