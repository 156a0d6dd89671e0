//! The stability map as a page.

use serde::Serialize;

use super::chart::{BLUE, Chart, Corner, GREEN, VERMILION};
use super::figure::{Figure, Page, circles, line};
use super::shell;
use crate::compare::Verdict;
use crate::error::Error;
use crate::limits::stability::Map;
use crate::limits::stability::growth::Found;
use crate::limits::stability::map::{Limits, Row};

const PAGE: &str = include_str!("stability.html");
const PART: &str = include_str!("stability_part.html");

/// What the template is given.
#[derive(Debug, Serialize)]
struct Given<'a> {
    map: &'a Map,
    word: &'static str,
    /// The engine beside the native one.
    other: &'a str,
    rows: Vec<TableRow<'a>>,
    allowed: String,
    figures: Vec<Figure>,
}

/// A scene; found limits over predicted ones, YADE's choices over the limit without damping.
#[derive(Debug, Serialize)]
struct TableRow<'a> {
    number: usize,
    of: &'a Row,
    closed: String,
    native: String,
    yade: String,
    native_damped: String,
    yade_damped: String,
    at_random: String,
    p_wave: String,
    global_stiffness: String,
    with_dashpots: String,
    verdict: Verdict,
}

/// A page of its own.
pub fn page(map: &Map) -> Result<Page, Error> {
    render(map, &[("stability_page.html", PAGE)])
}

/// The part for the main report.
pub fn part(map: &Map) -> Result<Page, Error> {
    render(map, &[("stability_part.html", PART)])
}

fn render(map: &Map, templates: &[(&str, &str)]) -> Result<Page, Error> {
    let rows = map.rows.iter().enumerate();
    let given = Given {
        map,
        word: match map.verdict {
            Verdict::Pass => "Stable as predicted",
            Verdict::Fail => "Not as predicted",
            Verdict::NotMade => "Incomplete",
        },
        other: other(map),
        rows: rows.map(|(at, row)| table_row(at + 1, row)).collect(),
        allowed: format!("{} %", 100.0 * map.allowed),
        figures: figures(map)?,
    };
    Ok(Page {
        html: shell::render(templates, &given)?,
        figures: given.figures,
    })
}

/// The engine of the column beside the native one's.
fn other(map: &Map) -> &str {
    map.exec.as_ref().map_or("YADE", |engine| &engine.name)
}

fn table_row(number: usize, row: &Row) -> TableRow<'_> {
    let limit = row.undamped.predicted;
    let proposal = row.proposal_of_yade.unwrap_or(row.proposal);
    let worst = |verdict: Verdict| row.checks.iter().any(|check| check.verdict == verdict);
    TableRow {
        number,
        of: row,
        closed: ratio(row.closed.as_ref().map(|closed| closed.dt / limit)),
        native: over(&row.undamped, row.undamped.native),
        yade: over(&row.undamped, row.undamped.yade.or(row.undamped.exec)),
        native_damped: over(&row.damped, row.damped.native),
        yade_damped: over(&row.damped, row.damped.yade.or(row.damped.exec)),
        at_random: over(&row.damped, row.damped_at_random),
        p_wave: ratio(Some(proposal.p_wave / limit)),
        global_stiffness: ratio(Some(proposal.global_stiffness / limit)),
        with_dashpots: ratio(Some(proposal.with_dashpots / limit)),
        verdict: if worst(Verdict::Fail) {
            Verdict::Fail
        } else if worst(Verdict::NotMade) || row.not_made.is_some() {
            Verdict::NotMade
        } else {
            Verdict::Pass
        },
    }
}

fn over(limits: &Limits, found: Option<Found>) -> String {
    ratio(found.map(|found| found.limit / limits.predicted))
}

fn ratio(value: Option<f64>) -> String {
    value.map_or("–".to_owned(), |value| format!("{value:.4}"))
}

fn figures(map: &Map) -> Result<Vec<Figure>, Error> {
    let points = |of: &dyn Fn(&Row) -> Option<f64>| -> Vec<(f64, f64)> {
        let rows = map.rows.iter().enumerate();
        rows.filter_map(|(at, row)| Some(((at + 1) as f64, of(row)?)))
            .collect()
    };
    let off = |limits: Limits, found: Option<Found>| {
        found.map(|found| 100.0 * (found.limit / limits.predicted - 1.0))
    };
    let (left, right) = (0.5, map.rows.len() as f64 + 0.5);
    let level = |at: f64| vec![(left, at), (right, at)];
    let allowed = 100.0 * map.allowed;
    let frame = [
        level(allowed),
        vec![(right, -allowed), (left, -allowed), (left, allowed)],
    ]
    .concat();
    let both = |of: fn(&Limits) -> Option<Found>| {
        let mut all = points(&|row| off(row.undamped, of(&row.undamped)));
        all.extend(points(&|row| off(row.damped, of(&row.damped))));
        all
    };
    let apart = Chart {
        x: "scene, by its number in the table".to_owned(),
        y: "found over predicted, % apart".to_owned(),
        logarithmic: [false, false],
        legend: Corner::LowerRight,
        series: vec![
            line("allowed", BLUE, frame),
            circles("native", VERMILION, both(|of| of.native)),
            circles(other(map), GREEN, both(|of| of.yade.or(of.exec))),
        ]
        .into_iter()
        .filter(|series| !series.points.is_empty())
        .collect(),
    };
    let chosen = |of: fn(&crate::engine::yade::Proposal) -> f64| {
        points(&move |row| {
            let proposal = row.proposal_of_yade.unwrap_or(row.proposal);
            Some(of(&proposal) / row.undamped.predicted)
        })
    };
    let choices = Chart {
        x: "scene, by its number in the table".to_owned(),
        y: "step over the limit".to_owned(),
        logarithmic: [false, false],
        legend: Corner::UpperLeft,
        series: vec![
            line("the limit", BLUE, level(1.0)),
            circles("PWaveTimeStep", VERMILION, chosen(|of| of.p_wave)),
            circles("GlobalStiffness", GREEN, chosen(|of| of.global_stiffness)),
        ],
    };
    let apart = Figure::of_chart(
        "stability-limits",
        "Found limits against predicted ones, with and without damping; what is allowed is inside the frame.",
        &apart,
    )?;
    let choices = Figure::of_chart(
        "stability-choices",
        "What YADE would choose, over the largest stable step without damping. Above the line it would be unstable.",
        &choices,
    )?;
    Ok(apart.into_iter().chain(choices).collect())
}
