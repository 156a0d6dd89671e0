//! The verification as a page, and as a part of the main report.

use serde::Serialize;

use super::chart::{BLUE, Chart, Corner, GREEN, VERMILION};
use super::figure::{Figure, Page, circles, line};
use super::figures::inside_a_grain;
use super::shell;
use crate::compare::Verdict;
use crate::error::Error;
use crate::paper::disc_field::figure_4;
use crate::suite::Line;
use crate::suite::ladder::Climbed;
use crate::suite::limits::{Limit, Sound};
use crate::suite::precision::Errors;
use crate::suite::record::Verification;

const PAGE: &str = include_str!("verification_page.html");
const PART: &str = include_str!("verification.html");

/// What the template is given.
#[derive(Debug, Serialize)]
struct Given<'a> {
    v: &'a Verification,
    word: &'static str,
    rungs: Vec<RungRow<'a>>,
    table: Option<Table<'a>>,
    disc: Figure,
    errors: Option<Figure>,
    /// Why rungs that need YADE were not made.
    missing: &'a str,
    /// Whether this is a page of its own.
    own_page: bool,
}

/// A rung in every engine that climbed it.
#[derive(Debug, Serialize)]
struct RungRow<'a> {
    name: &'a str,
    title: String,
    /// Verdicts: native, YADE, native against YADE or of no engine.
    native: Option<&'a Climbed>,
    yade: Option<&'a Climbed>,
    both: Option<&'a Climbed>,
    reason: &'a str,
    failed: bool,
    lines: Vec<LineRow<'a>>,
}

/// A figure of a rung, the engines side by side; where it is of both, the value stands alone.
#[derive(Debug, Serialize)]
struct LineRow<'a> {
    of: &'a Line,
    yade: Option<f64>,
}

/// The table of detection limits as text.
#[derive(Debug, Serialize)]
struct Table<'a> {
    faults: &'a [String],
    rows: Vec<TableRow<'a>>,
}

#[derive(Debug, Serialize)]
struct TableRow<'a> {
    name: &'a str,
    cells: Vec<Cell>,
    alarms: String,
}

#[derive(Debug, Serialize)]
struct Cell {
    text: String,
    /// 0 not noticed or not in the rung; 1 to 4, the more the smaller.
    grade: u8,
}

/// A page of its own.
pub fn page(verification: &Verification) -> Result<Page, Error> {
    let templates = [
        ("verification.html", PART),
        ("verification_page.html", PAGE),
    ];
    render(verification, &templates, true)
}

/// The part for the main report.
pub fn part(verification: &Verification) -> Result<Page, Error> {
    render(verification, &[("verification.html", PART)], false)
}

fn render(
    verification: &Verification,
    templates: &[(&str, &str)],
    own_page: bool,
) -> Result<Page, Error> {
    let field = figure_4().map_err(|error| Error::Report(error.to_string()))?;
    let given = Given {
        v: verification,
        word: match verification.verdict {
            Verdict::Pass => "Verified",
            Verdict::Fail => "Not verified",
            Verdict::NotMade => "Incomplete",
        },
        rungs: rows(&verification.rungs),
        table: table(verification),
        disc: inside_a_grain(&field)?,
        errors: errors(&verification.errors)?,
        missing: missing(verification),
        own_page,
    };
    Ok(Page {
        html: shell::render(templates, &given)?,
        figures: given.errors.into_iter().chain([given.disc]).collect(),
    })
}

/// A row a rung, in the order in which they were first climbed.
fn rows(rungs: &[Climbed]) -> Vec<RungRow<'_>> {
    let mut names: Vec<&str> = Vec::new();
    for rung in rungs {
        if !names.contains(&rung.name.as_str()) {
            names.push(&rung.name);
        }
    }
    names
        .into_iter()
        .filter_map(|name| row(name, rungs))
        .collect()
}

fn row<'a>(name: &'a str, rungs: &'a [Climbed]) -> Option<RungRow<'a>> {
    let of: Vec<&Climbed> = rungs.iter().filter(|rung| rung.name == name).collect();
    let by = |engine: &str| of.iter().copied().find(|rung| rung.engine == engine);
    let (native, yade) = (by("native"), by("YADE"));
    let both = of
        .iter()
        .copied()
        .find(|rung| !["native", "YADE"].contains(&rung.engine.as_str()));
    let first = native.or(yade).or(both)?;
    let beside = yade.filter(|_| native.is_some());
    let lines = first.lines.iter().enumerate().map(|(index, line)| LineRow {
        of: line,
        yade: beside
            .and_then(|yade| yade.lines.get(index))
            .map(|line| line.value),
    });
    // What is missing for many is said once, above.
    let own = of
        .iter()
        .filter(|rung| rung.inapplicable || rung.verdict == Verdict::Fail);
    let mut reason = own.map(|rung| rung.reason.as_str());
    Some(RungRow {
        name,
        title: capitalised(&first.title),
        native,
        yade,
        both,
        reason: reason.find(|reason| !reason.is_empty()).unwrap_or(""),
        failed: of.iter().any(|rung| rung.verdict == Verdict::Fail),
        lines: lines.collect(),
    })
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

fn missing(verification: &Verification) -> &str {
    let missing = |rung: &&Climbed| rung.verdict == Verdict::NotMade && !rung.inapplicable;
    verification
        .rungs
        .iter()
        .find(missing)
        .map_or("", |rung| &rung.reason)
}

fn table(verification: &Verification) -> Option<Table<'_>> {
    let limits = verification.limits.as_ref()?;
    let rows = limits.rungs.iter().map(|row| TableRow {
        name: &row.rung,
        cells: row.limits.iter().map(cell).collect(),
        alarms: format!(
            "{}/{} {}",
            row.false_alarms,
            row.sound_runs,
            match row.sound {
                Sound::OtherStarts => "starts",
                Sound::OtherStiffness => "stiffness",
                Sound::OtherLists => "lists",
            }
        ),
    });
    Some(Table {
        faults: &limits.faults,
        rows: rows.collect(),
    })
}

fn cell(limit: &Limit) -> Cell {
    let (text, grade) = match limit {
        Limit::Without => (String::new(), 0),
        Limit::Blind => ("–".to_owned(), 0),
        Limit::Notices => ("yes".to_owned(), 4),
        Limit::From { size } => {
            let grade = match size.log10() {
                power if power < -14.0 => 4,
                power if power < -9.0 => 3,
                power if power < -5.0 => 2,
                _ => 1,
            };
            (format!("{size:.0e}"), grade)
        }
    };
    Cell { text, grade }
}

/// How rounding errors grow in each precision.
fn errors(errors: &[Errors]) -> Result<Option<Figure>, Error> {
    let points = |of: fn(&Errors) -> f64| {
        let points = errors.iter().map(|errors| (errors.step as f64, of(errors)));
        points.filter(|(_, error)| *error > 0.0).collect()
    };
    let chart = Chart {
        x: "step of pouring".to_owned(),
        y: "largest error over R".to_owned(),
        logarithmic: [false, true],
        legend: Corner::LowerRight,
        series: vec![
            line("native", BLUE, points(|of| of.native)),
            circles("YADE, double", VERMILION, points(|of| of.yade)),
            line("YADE, long double", GREEN, points(|of| of.long_double)),
        ],
    };
    Figure::of_chart(
        "rounding",
        "Distance from the same run in 128-bit arithmetic. Native and YADE round alike; 11 more bits make the error smaller by about 2¹¹, so it is \
         rounding and nothing else. It grows while grains collide, until neighbours are no longer the same.",
        &chart,
    )
}
